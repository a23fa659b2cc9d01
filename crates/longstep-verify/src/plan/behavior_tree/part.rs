//! The plan that a tree is, before its steps have numbers.

use std::collections::HashMap;

use crate::plan::StepId;
use crate::plan::tree::{Lane, LaneItem, Node, Test};
use crate::plan::written::{WrittenNode, WrittenStep};

/// Conditions that were computed into entries of the blackboard.
pub(super) type Flags = HashMap<String, Test<WrittenStep>>;

/// A node of the plan; the steps have no numbers yet.
pub(super) enum Part {
    Step(WrittenStep),
    If(Test<WrittenStep>, Vec<Part>, Vec<Part>),
    While(Test<WrittenStep>, Vec<Part>),
    Repeat(u32, Vec<Part>),
    Parallel(Vec<(String, Vec<LanePart>)>),
    Remark(String),
}

pub(super) enum LanePart {
    Step(WrittenStep),
    Sync(String),
    Remark(String),
}

/// Numbers the steps in reading order.
pub(super) fn number(parts: Vec<Part>, steps: &mut Vec<WrittenStep>) -> Vec<WrittenNode> {
    let add = |step: WrittenStep, steps: &mut Vec<WrittenStep>| {
        steps.push(step);
        StepId::new(steps.len() - 1)
    };
    let mut nodes = Vec::with_capacity(parts.len());
    for part in parts {
        nodes.push(match part {
            Part::Step(step) => Node::Step(add(step, steps)),
            Part::Remark(text) => Node::Remark(text),
            Part::Repeat(times, body) => Node::Repeat {
                times,
                body: number(body, steps),
            },
            Part::While(condition, body) => Node::While {
                condition,
                body: number(body, steps),
            },
            Part::If(condition, then, otherwise) => Node::If {
                condition,
                then: number(then, steps),
                otherwise: number(otherwise, steps),
            },
            Part::Parallel(lanes) => Node::Parallel {
                lanes: lanes
                    .into_iter()
                    .map(|(actor, items)| Lane {
                        actor,
                        items: items
                            .into_iter()
                            .map(|item| match item {
                                LanePart::Step(step) => LaneItem::Step(add(step, steps)),
                                LanePart::Sync(name) => LaneItem::Sync(name),
                                LanePart::Remark(text) => LaneItem::Remark(text),
                            })
                            .collect(),
                    })
                    .collect(),
            },
        });
    }
    nodes
}
