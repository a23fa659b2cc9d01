//! A plan as a tree for people: every step with its reason, its changes, its edits and its assumptions.
//!
//! [`Diagram::of`] makes the data for a page, [`svg`] a picture of them, and [`mermaid`] and [`dot`] a flowchart for other
//! programs.

mod annotation;
mod card;
mod dot;
mod draw;
mod flowchart;
mod layout;
mod mermaid;
mod piece;
mod sentence;
#[cfg(test)]
mod tests;

pub use annotation::Annotations;
pub use dot::dot;
pub use draw::svg;
pub use mermaid::{exceeds_defaults_of_mermaid, mermaid};

use std::collections::VecDeque;
use std::ops::RangeBounds;

use longstep_core::model::World;
use longstep_core::plan::{Assumption, Lane, LaneItem, Node, Plan, StepId, Test};
use longstep_core::repair::{Edit, EditKind};
use longstep_core::schedule::{Row, timetable};
use longstep_core::verify::VerifiedPlan;
use serde::Serialize;

use crate::cause::{Role, Use, roles};
use crate::walk::possible_outcomes;

/// A plan as a tree.
///
/// ```
/// use longstep_core::{domain, environment, goal, plan, verify};
/// use longstep_picture::plan::{Annotations, Diagram, DiagramNode};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = verify::check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let diagram = Diagram::of(&plan, &Annotations::default());
/// let DiagramNode::Step(step) = &diagram.nodes[0] else { panic!() };
/// assert_eq!(step.text, "move the hand to the pen");
/// assert_eq!(step.reason.as_deref(), Some("needed for step 2: the hand is at the pen"));
/// ```
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Diagram {
    /// The parts of the plan, in order of execution.
    pub nodes: Vec<DiagramNode>,
    /// Assumptions of the plan that belong to no step, as sentences.
    pub assumptions: Vec<String>,
    /// Steps of the draft that a repair left out behind the last step, with the reasons.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// True if the reasons of the steps are known. They are not for a plan that takes too much work.
    pub has_reasons: bool,
}

/// A part of a [`Diagram`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum DiagramNode {
    /// A step.
    Step(StepNode),
    /// A branch.
    Branch {
        /// The condition as a sentence.
        condition: String,
        /// Its negation as a sentence.
        otherwise: String,
        /// The sensing steps of the condition.
        sensing: Vec<StepNode>,
        /// The parts if the condition holds.
        then: Vec<DiagramNode>,
        /// The parts if it does not; may be empty.
        #[serde(rename = "else")]
        other: Vec<DiagramNode>,
    },
    /// A loop that runs as long as its condition holds.
    Loop {
        /// The condition as a sentence.
        condition: String,
        /// The sensing steps of the condition, before each iteration.
        sensing: Vec<StepNode>,
        /// The parts of an iteration.
        body: Vec<DiagramNode>,
    },
    /// A loop with a fixed number of iterations.
    Repeat {
        /// The number of iterations.
        times: u32,
        /// The parts of an iteration.
        body: Vec<DiagramNode>,
    },
    /// Lanes side by side.
    Lanes {
        /// The names of the actors.
        lanes: Vec<String>,
        /// The timetable: every step takes one unit of time.
        rows: Vec<LaneRow>,
    },
    /// A remark for the reader.
    Remark {
        /// The remark.
        text: String,
    },
}

/// A row of lanes.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum LaneRow {
    /// A unit of time: the step of each lane, or none for a lane that waits or is done.
    Unit {
        /// The steps.
        cells: Vec<Option<StepNode>>,
    },
    /// A point where lanes wait for each other.
    Sync {
        /// Its name.
        name: String,
        /// The indices of the lanes that meet.
        lanes: Vec<usize>,
    },
    /// A remark of a lane.
    Remark {
        /// The index of the lane.
        lane: usize,
        /// The remark.
        text: String,
    },
}

/// A step of a [`Diagram`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct StepNode {
    /// The number of the step, from 1.
    pub number: usize,
    /// The explanation.
    pub text: String,
    /// The call in the notation of plans.
    pub call: String,
    /// The name of the hand, arm or robot; none in a domain with only one.
    pub lane: Option<String>,
    /// The later step or goal that needs the step; none if nothing needs it.
    pub reason: Option<String>,
    /// The reason without a fact that is among the changes.
    pub brief_reason: Option<String>,
    /// The numbers of the later steps that need it.
    pub needed_by: Vec<usize>,
    /// The changes, as sentences.
    pub changes: Vec<String>,
    /// True for a sensing step.
    pub senses: bool,
    /// The change by a repair, with its reason.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub edited: Option<String>,
    /// Steps of the draft that a repair left out before this one, with the reasons.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
    /// Assumptions of the step, as sentences.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub assumed: Vec<String>,
    /// True if no path through the plan reaches the step.
    #[serde(skip_serializing_if = "std::ops::Not::not")]
    pub unreached: bool,
}

impl Diagram {
    /// Returns all steps, in reading order; those of lanes by their unit of time.
    pub fn steps(&self) -> Vec<&StepNode> {
        steps_of(&self.nodes)
    }

    /// Describes a plan.
    ///
    /// The work is bounded by that of a verification; beyond it, the diagram has no reasons and no changes.
    pub fn of(plan: &VerifiedPlan, annotations: &Annotations) -> Self {
        let found = roles(plan, annotations.purpose.as_ref());
        let has_reasons = found.is_some();
        let builder = Builder {
            world: plan.world(),
            plan: plan.plan(),
            annotations,
            roles: found,
        };
        Self {
            nodes: builder.nodes(plan.plan().body()),
            assumptions: builder.general_assumptions(&plan.report().assumptions),
            left_out: builder.left_out(plan.steps().len()..),
            has_reasons,
        }
    }
}

fn steps_of(nodes: &[DiagramNode]) -> Vec<&StepNode> {
    let mut steps = Vec::new();
    for node in nodes {
        match node {
            DiagramNode::Step(step) => steps.push(step),
            DiagramNode::Branch {
                sensing, then, other, ..
            } => {
                steps.extend(sensing);
                steps.extend(steps_of(then));
                steps.extend(steps_of(other));
            }
            DiagramNode::Loop { sensing, body, .. } => {
                steps.extend(sensing);
                steps.extend(steps_of(body));
            }
            DiagramNode::Repeat { body, .. } => steps.extend(steps_of(body)),
            DiagramNode::Lanes { rows, .. } => {
                for row in rows {
                    if let LaneRow::Unit { cells } = row {
                        steps.extend(cells.iter().flatten());
                    }
                }
            }
            DiagramNode::Remark { .. } => {}
        }
    }
    steps
}

struct Builder<'a> {
    world: &'a World,
    plan: &'a Plan,
    annotations: &'a Annotations,
    roles: Option<Vec<Role>>,
}

impl Builder<'_> {
    fn nodes(&self, nodes: &[Node]) -> Vec<DiagramNode> {
        nodes.iter().map(|node| self.node(node)).collect()
    }

    fn node(&self, node: &Node) -> DiagramNode {
        match node {
            Node::Step(step) => DiagramNode::Step(self.step(*step)),
            Node::If {
                condition,
                then,
                otherwise,
            } => DiagramNode::Branch {
                condition: sentence::condition(self.world, self.plan, condition, true),
                otherwise: sentence::condition(self.world, self.plan, condition, false),
                sensing: self.sensing(condition),
                then: self.nodes(then),
                other: self.nodes(otherwise),
            },
            Node::While { condition, body } => DiagramNode::Loop {
                condition: sentence::condition(self.world, self.plan, condition, true),
                sensing: self.sensing(condition),
                body: self.nodes(body),
            },
            Node::Repeat { times, body } => DiagramNode::Repeat {
                times: *times,
                body: self.nodes(body),
            },
            Node::Parallel { lanes } => self.lanes(lanes),
            Node::Remark(text) => DiagramNode::Remark { text: text.clone() },
        }
    }

    fn sensing(&self, condition: &Test) -> Vec<StepNode> {
        condition.steps().map(|step| self.step(step)).collect()
    }

    fn lanes(&self, lanes: &[Lane]) -> DiagramNode {
        let names = lanes.iter().map(|lane| self.world.entity(lane.actor).name.clone());
        let mut rows = Vec::new();
        let mut remarks = Remarks::of(lanes);
        for row in timetable(lanes) {
            match row {
                Row::Unit(steps) => {
                    let met = steps.iter().enumerate().filter(|(_, step)| step.is_some());
                    met.for_each(|(lane, _)| rows.extend(remarks.before_next(lane)));
                    let cells = steps.into_iter().map(|step| step.map(|step| self.step(step)));
                    rows.push(LaneRow::Unit { cells: cells.collect() });
                }
                Row::Sync { name, lanes } => {
                    lanes.iter().for_each(|lane| rows.extend(remarks.before_next(*lane)));
                    rows.push(LaneRow::Sync { name, lanes });
                }
            }
        }
        (0..lanes.len()).for_each(|lane| rows.extend(remarks.before_next(lane)));
        DiagramNode::Lanes {
            lanes: names.collect(),
            rows,
        }
    }

    fn step(&self, id: StepId) -> StepNode {
        let (world, step) = (self.world, self.plan.step(id));
        let domain = world.domain();
        let role = self.roles.as_ref().map(|roles| &roles[id.index()]);
        let uses = role.map(|role| &role.uses);
        let later = uses.into_iter().flatten().filter_map(|used| match used {
            Use::Step(step, _) => Some(step.index() + 1),
            _ => None,
        });
        let mut needed_by: Vec<usize> = later.collect();
        needed_by.dedup();
        let outcomes = possible_outcomes(world, step);
        let changes = match role.and_then(|role| role.changes.as_ref()) {
            Some(_) if !outcomes.is_empty() => vec![sentence::sensing(world, &outcomes)],
            Some(changes) => sentence::changes(world, changes),
            None => Vec::new(),
        };
        let reason = |known: &[String]| sentence::reason(world, &self.annotations.goals, uses?, known);
        StepNode {
            number: id.index() + 1,
            text: step.explanation.clone(),
            call: step.call(world).to_string(),
            lane: step.actor(domain).map(|actor| world.entity(actor).name.clone()),
            reason: reason(&[]),
            brief_reason: reason(&changes),
            needed_by,
            changes,
            senses: !outcomes.is_empty(),
            edited: self.edited(id),
            left_out: self.left_out(id.index()..id.index() + 1),
            assumed: self.assumed(id, role),
            unreached: role.is_some_and(|role| role.changes.is_none()),
        }
    }

    fn edited(&self, id: StepId) -> Option<String> {
        let mut edits = self.annotations.edits.iter();
        let edit = edits.find(|edit| edit.at == id.index() && edit.kind != EditKind::Drop)?;
        let change = match (edit.kind, &edit.before) {
            (EditKind::Replace, Some(before)) => format!("instead of {before}"),
            (EditKind::Move, _) => format!("was step {}", edit.step + 1),
            _ => "added".to_owned(),
        };
        Some(with_reason(change, edit))
    }

    /// Returns the steps that a repair left out at these positions.
    fn left_out(&self, at: impl RangeBounds<usize>) -> Vec<String> {
        let edits = self.annotations.edits.iter();
        let dropped = edits.filter(|edit| edit.kind == EditKind::Drop && at.contains(&edit.at));
        dropped
            .map(|edit| with_reason(edit.before.clone().unwrap_or_default(), edit))
            .collect()
    }

    fn assumed(&self, id: StepId, role: Option<&Role>) -> Vec<String> {
        let of_step = |own: &&Assumption| match own {
            Assumption::Argument { step, .. } => *step == id.index(),
            Assumption::Reading { step, .. } => *step == Some(id.index()),
            Assumption::Fact { .. } => false,
        };
        let facts = role.into_iter().flat_map(|role| &role.assumed);
        let facts = facts.filter_map(|fact| {
            let ground = self.world.assumed(*fact)?;
            Some(Assumption::Fact { fact: *fact, ground }.message(self.world))
        });
        let others = self.annotations.assumptions.iter().filter(of_step);
        facts.chain(others.map(|own| own.message(self.world))).collect()
    }

    /// Returns the assumptions that no step has, those of verification included.
    fn general_assumptions(&self, verified: &[Assumption]) -> Vec<String> {
        let roles = self.roles.iter().flatten();
        let known: Vec<_> = roles.flat_map(|role| &role.assumed).collect();
        let is_general = |own: &&Assumption| match own {
            Assumption::Argument { .. } => false,
            Assumption::Reading { step, .. } => step.is_none(),
            Assumption::Fact { fact, .. } => !known.contains(&fact),
        };
        let all = verified.iter().chain(&self.annotations.assumptions);
        let mut sentences: Vec<String> = Vec::new();
        for sentence in all.filter(is_general).map(|own| own.message(self.world)) {
            if !sentences.contains(&sentence) {
                sentences.push(sentence);
            }
        }
        sentences
    }
}

fn with_reason(change: String, edit: &Edit) -> String {
    if edit.why.is_empty() {
        change
    } else {
        format!("{change}: {}", edit.why)
    }
}

/// The remarks of lanes that have not been shown yet.
struct Remarks<'l> {
    items: Vec<VecDeque<&'l LaneItem>>,
}

impl<'l> Remarks<'l> {
    fn of(lanes: &'l [Lane]) -> Self {
        Self {
            items: lanes.iter().map(|lane| lane.items.iter().collect()).collect(),
        }
    }

    /// Removes the next act of a lane, and returns the remarks before it.
    fn before_next(&mut self, lane: usize) -> Vec<LaneRow> {
        let mut rows = Vec::new();
        while let Some(item) = self.items[lane].pop_front() {
            let LaneItem::Remark(text) = item else { break };
            let text = text.clone();
            rows.push(LaneRow::Remark { lane, text });
        }
        rows
    }
}
