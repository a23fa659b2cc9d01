//! A stored plan as it was when it was made: every argument known.

use super::{Misfit, Stored};
use crate::attempt::Attempt;
use crate::domain::Domain;
use crate::json::Path;
use crate::call::Call;
use crate::plan::{Draft, Lane, LaneItem, Node, Plan, Step, StepId, Test, Written, WrittenNode, WrittenStep};
use crate::world::{self, World};

/// A stored plan, bound in the world that it was made for.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Recalled {
    /// The plan with all of its arguments, by identifier.
    pub(super) written: Written,
    /// What it does, in a few words.
    pub(super) summary: String,
    /// Who does its steps, by identifier, in the order in which they first do something.
    pub(super) actors: Vec<String>,
    /// Whether it has a step that no single one of them does, in a domain where others have somebody who does them.
    pub(super) joint: bool,
    /// What its steps are about, by identifier.
    pub(super) handled: Vec<String>,
}

impl Recalled {
    /// Reads a stored plan in the world that its file gives, or else in the one at hand, and finds every argument.
    ///
    /// Whether it is a good plan is not asked: one that picks a thing up and keeps it breaks a rule by itself, and is a
    /// good part of another plan.
    pub(super) fn of(domain: &Domain, world: &World, stored: &Stored) -> Result<Self, Misfit> {
        let unusable = |why: String| Misfit::Unusable {
            name: stored.name.clone(),
            why,
        };
        let own = match &stored.file.environment_before {
            Some(environment) => world::read(domain, environment, "environment_before", "", &Path::default())
                .map_err(|findings| unusable(joined(findings.0.iter().map(|finding| finding.message.clone()))))?,
            None => world.clone(),
        };
        let draft = Draft {
            file: stored.file.clone(),
            leniencies: Vec::new(),
        };
        let attempt = Attempt::new(domain, &own, draft, None);
        let Some((report, _)) = attempt.simulate(domain, &own) else {
            let issues = attempt.resolved.issues.iter();
            return Err(unusable(joined(
                issues.map(|issue| issue.message(domain, &own, &[], None)),
            )));
        };
        if report.plan.steps().len() < attempt.resolved.steps.len() {
            let told = report.violations.iter();
            let steps = report.plan.steps();
            return Err(unusable(joined(
                told.map(|violation| violation.message(domain, &own, steps, None)),
            )));
        }
        Ok(Self::of_plan(domain, &own, &report.plan, &stored.summary))
    }

    fn of_plan(domain: &Domain, own: &World, plan: &Plan, summary: &str) -> Self {
        let mut recalled = Self {
            written: written(domain, own, plan),
            summary: summary.to_owned(),
            ..Self::default()
        };
        let some_act = domain.actions.iter().any(|action| action.actor.is_some());
        for step in plan.steps() {
            match step.actor(domain) {
                Some(actor) => add(&mut recalled.actors, &own.entity(actor).identifier),
                None => recalled.joint |= some_act,
            }
            for entity in things(domain, step) {
                add(&mut recalled.handled, &own.entity(entity).identifier);
            }
        }
        recalled
    }

    /// What a person is told before its steps.
    pub(super) fn remark(&self, name: &str) -> String {
        match self.summary.is_empty() {
            true => name.to_owned(),
            false => format!("{name}: {}", self.summary),
        }
    }
}

/// A plan as it would be written with every argument: what calls hide is given by name.
fn written(domain: &Domain, world: &World, plan: &Plan) -> Written {
    let steps: Vec<WrittenStep> = plan.steps().iter().map(|step| written_step(domain, world, step)).collect();
    let mut written = Written::default();
    written.body = nodes(domain, world, &steps, plan.body(), &mut written.steps);
    written
}

fn written_step(domain: &Domain, world: &World, step: &Step) -> WrittenStep {
    let action = domain.action(step.action);
    let hidden = action.implicit().map(|parameter| {
        let identifier = &world.entity(step.arguments[parameter]).identifier;
        (action.parameters[parameter].name.clone(), identifier.clone())
    });
    WrittenStep {
        call: step.call(domain, world),
        implicit: hidden.collect(),
        explanation: step.explanation.clone(),
    }
}

/// The nodes over steps; what is sensed in conditions is left out of `kept`, the list of steps.
fn nodes(
    domain: &Domain,
    world: &World,
    all: &[WrittenStep],
    nodes_: &[Node],
    kept: &mut Vec<WrittenStep>,
) -> Vec<WrittenNode> {
    let keep = |step: StepId, kept: &mut Vec<WrittenStep>| {
        kept.push(all[step.index()].clone());
        StepId::new(kept.len() - 1)
    };
    let asked = |condition: &Test| asked(domain, world, all, condition);
    let mut written = Vec::with_capacity(nodes_.len());
    for node in nodes_ {
        written.push(match node {
            Node::Step(step) => Node::Step(keep(*step, kept)),
            Node::If {
                condition,
                then,
                otherwise,
            } => Node::If {
                condition: asked(condition),
                then: nodes(domain, world, all, then, kept),
                otherwise: nodes(domain, world, all, otherwise, kept),
            },
            Node::While { condition, body } => Node::While {
                condition: asked(condition),
                body: nodes(domain, world, all, body, kept),
            },
            Node::Repeat { times, body } => Node::Repeat {
                times: *times,
                body: nodes(domain, world, all, body, kept),
            },
            Node::Parallel { lanes } => Node::Parallel {
                lanes: lanes
                    .iter()
                    .map(|lane| Lane {
                        actor: world.entity(lane.actor).identifier.clone(),
                        items: lane
                            .items
                            .iter()
                            .map(|item| match item {
                                LaneItem::Step(step) => LaneItem::Step(keep(*step, kept)),
                                other => other.clone(),
                            })
                            .collect(),
                    })
                    .collect(),
            },
            Node::Remark(text) => Node::Remark(text.clone()),
        });
    }
    written
}

fn asked(domain: &Domain, world: &World, all: &[WrittenStep], condition: &Test) -> Test<WrittenStep> {
    let parts = |parts: &[Test]| parts.iter().map(|part| asked(domain, world, all, part)).collect();
    match condition {
        Test::Sense(step) => Test::Holds(all[step.index()].clone()),
        Test::Holds(fact) => Test::Holds(WrittenStep {
            call: Call {
                name: String::new(),
                arguments: domain.arguments(*fact).map(|e| world.entity(e).identifier.clone()).collect(),
            },
            implicit: Vec::new(),
            explanation: String::new(),
        }),
        Test::Not(inner) => Test::Not(Box::new(asked(domain, world, all, inner))),
        Test::All(inner) => Test::All(parts(inner)),
        Test::Any(inner) => Test::Any(parts(inner)),
    }
}

fn things<'a>(domain: &'a Domain, step: &'a Step) -> impl Iterator<Item = crate::world::EntityId> + 'a {
    let actor = domain.action(step.action).actor;
    let arguments = step.arguments.iter().enumerate();
    arguments.filter(move |(place, _)| Some(*place) != actor).map(|(_, entity)| *entity)
}

fn add(list: &mut Vec<String>, identifier: &str) {
    if !list.iter().any(|known| known == identifier) {
        list.push(identifier.to_owned());
    }
}

fn joined(messages: impl Iterator<Item = String>) -> String {
    messages.collect::<Vec<_>>().join("; ")
}
