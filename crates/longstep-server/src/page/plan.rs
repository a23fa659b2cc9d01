//! A plan as a tree: branches, loops, and lanes beside each other.

use std::collections::HashMap;

use longstep::report::{Answer, EditAnswer};
use longstep_core::domain::phrase;
use longstep_core::environment::World;
use longstep_core::model::{Fact, Voice, ground};
use longstep_core::plan::{Lane, Node, Plan, StepId, Test};
use longstep_core::schedule::{Row, timetable};
use maud::{Markup, html};

use super::picture::Moment;

/// A plan as it is shown.
pub(super) struct PlanTree<'a> {
    world: &'a World,
    plan: &'a Plan,
    /// The answer with edits and violations; none for a plan that was accepted.
    answer: Option<&'a Answer>,
    /// The changes of each step, in words.
    changes: HashMap<usize, &'a [String]>,
    /// The step that the picture shows.
    shown: Option<usize>,
    /// The path of the page that shows the scene of a step; none for a page without.
    path: Option<String>,
}

impl<'a> PlanTree<'a> {
    /// Creates the tree of a plan with its moments.
    pub(super) fn new(
        (world, plan): (&'a World, &'a Plan),
        answer: &'a Answer,
        moments: &'a [Moment],
        shown: Option<usize>,
        path: String,
    ) -> Self {
        let changes = moments
            .iter()
            .filter_map(|own| Some((own.frame.step?, &own.changes[..])));
        Self {
            world,
            plan,
            answer: Some(answer),
            changes: changes.collect(),
            shown,
            path: Some(path),
        }
    }

    /// Creates the tree of a plan that was accepted.
    pub(super) fn accepted(world: &'a World, plan: &'a Plan) -> Self {
        Self {
            world,
            plan,
            answer: None,
            changes: HashMap::new(),
            shown: None,
            path: None,
        }
    }

    /// Writes the tree.
    pub(super) fn html(&self) -> Markup {
        html! {
            @if self.plan.steps().is_empty() {
                p { "Nothing to do: everything is so already." }
            } @else {
                div.plan { (self.nodes(self.plan.body())) }
            }
            (self.dropped())
        }
    }

    fn nodes(&self, nodes: &[Node]) -> Markup {
        html! { ol.steps { @for node in nodes { li { (self.node(node)) } } } }
    }

    fn node(&self, node: &Node) -> Markup {
        match node {
            Node::Step(id) => self.step(*id),
            Node::If {
                condition,
                then,
                otherwise,
            } => html! {
                (self.tested(condition))
                div.branch {
                    p.case { "If " (self.sentence(condition, true)) }
                    (self.nodes(then))
                }
                @if !otherwise.is_empty() {
                    div.branch { p.case { "Otherwise" } (self.nodes(otherwise)) }
                }
            },
            Node::While { condition, body } => html! {
                div.branch {
                    p.case { "As long as " (self.sentence(condition, true)) }
                    (self.tested(condition))
                    (self.nodes(body))
                }
            },
            Node::Repeat { times, body } => html! {
                div.branch { p.case { (times) " times" } (self.nodes(body)) }
            },
            Node::Parallel { lanes } => self.lanes(lanes),
            Node::Remark(text) => html! { p.quiet { (text) } },
        }
    }

    /// Writes the sensing steps of a condition.
    fn tested(&self, condition: &Test) -> Markup {
        html! { @for id in condition.steps() { (self.step(id)) } }
    }

    /// Writes a condition as a sentence. A sensing step holds if its first outcome occurs.
    fn sentence(&self, test: &Test, holds: bool) -> String {
        let joined = |parts: &[Test], word: &str| {
            let parts: Vec<String> = parts.iter().map(|part| self.sentence(part, holds)).collect();
            parts.join(word)
        };
        match test {
            Test::Sense(id) => match self.outcome(*id) {
                Some(fact) => Voice::Person.fact(self.world, fact, holds),
                None => format!("step {} finds it", id.index() + 1),
            },
            Test::Holds(fact) => Voice::Person.fact(self.world, *fact, holds),
            Test::Not(inner) => self.sentence(inner, !holds),
            // Not all is one of the negations, and the other way round.
            Test::All(parts) => joined(parts, if holds { ", and " } else { ", or " }),
            Test::Any(parts) => joined(parts, if holds { ", or " } else { ", and " }),
        }
    }

    /// Returns the first outcome of a sensing step.
    fn outcome(&self, id: StepId) -> Option<Fact> {
        let step = self.plan.step(id);
        let sensed = self.world.domain().action(step.action).senses.first()?;
        Some(ground(sensed, &step.arguments))
    }

    fn lanes(&self, lanes: &[Lane]) -> Markup {
        html! {
            div.wide tabindex="0" role="region" aria-label="Steps at the same time" {
                table.lanes {
                    caption { "At the same time" }
                    thead { tr { @for lane in lanes { th scope="col" { (self.world.entity(lane.actor).name) } } } }
                    tbody { @for row in timetable(lanes) { (self.row(&row, lanes.len())) } }
                }
            }
        }
    }

    fn row(&self, row: &Row, lanes: usize) -> Markup {
        match row {
            Row::Unit(steps) => html! {
                tr { @for step in steps { td { @if let Some(id) = step { (self.step(*id)) } } } }
            },
            Row::Sync { name, lanes: met } => html! {
                tr.sync {
                    @for lane in 0..lanes {
                        td { @if met.contains(&lane) { "wait for each other" span.unseen { " at " (name) } } }
                    }
                }
            },
        }
    }

    fn step(&self, id: StepId) -> Markup {
        let index = id.index();
        let step = self.plan.step(id);
        let call = step.call(self.world).to_string();
        let changes = self.changes.get(&index).copied().unwrap_or_default();
        let edits: Vec<&EditAnswer> = self.edits_at(index).collect();
        let violations = self.answer.iter().flat_map(|answer| &answer.violations);
        let violations = violations.filter(|own| own.step == Some(index));
        html! {
            div.step.edited[!edits.is_empty()] id={ "step-" (index + 1) } {
                @match &self.path {
                    Some(path) => a.number href={ (path) "?step=" (index + 1) "#scene" }
                        aria-current=[(self.shown == Some(index)).then_some("step")]
                        aria-label={ "Show the scene at step " (index + 1) } { (index + 1) },
                    None => span.number { (index + 1) },
                }
                div.body {
                    p.what { (phrase(&step.explanation)) " " code { (call) } }
                    @if !changes.is_empty() { p.effect { (changes.join("; ")) } }
                    @for edit in edits { p.edit { strong { (edit_word(edit)) ": " } (edit.why) } }
                    @for violation in violations { p.problem { (violation.message) } }
                }
            }
        }
    }

    fn edits_at(&self, step: usize) -> impl Iterator<Item = &EditAnswer> {
        self.answer
            .iter()
            .flat_map(|answer| &answer.edits)
            .filter(move |edit| edit.at == step && edit.kind != "drop")
    }

    /// Lists the steps that a repair dropped.
    fn dropped(&self) -> Markup {
        let dropped: Vec<&EditAnswer> = self
            .answer
            .iter()
            .flat_map(|answer| &answer.edits)
            .filter(|edit| edit.kind == "drop")
            .collect();
        html! {
            @if !dropped.is_empty() {
                div.list {
                    h3 { "Dropped" }
                    ul { @for edit in dropped { li { code { (edit.before.as_deref().unwrap_or_default()) } " " (edit.why) } } }
                }
            }
        }
    }
}

fn edit_word(edit: &EditAnswer) -> &'static str {
    match edit.kind {
        "insert" => "Inserted",
        "replace" => "Replaced",
        "move" => "Moved",
        _ => "Changed",
    }
}
