//! The tree of a plan: branches, loops and parallel lanes.
//!
//! The nodes refer to steps by number. The tree of a written plan has names for facts and actors; the tree of a
//! resolved plan has facts and entities of a world.

use super::StepId;
use crate::model::{EntityId, Fact};

/// Maximum nesting depth of branches and loops. Each level takes two brackets in JSON, and common parsers accept 128.
pub const DEEPEST: usize = 48;

/// A node of the plan tree.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Node<F = Fact, A = EntityId> {
    /// A step.
    Step(StepId),
    /// A branch: `then` if the condition holds, `otherwise` if not.
    If {
        /// The branch condition.
        condition: Test<F>,
        /// Nodes executed if the condition holds.
        then: Vec<Node<F, A>>,
        /// Nodes executed if it does not; may be empty.
        otherwise: Vec<Node<F, A>>,
    },
    /// A loop that runs as long as the condition holds; the condition is evaluated before each iteration.
    While {
        /// The loop condition.
        condition: Test<F>,
        /// The loop body.
        body: Vec<Node<F, A>>,
    },
    /// A loop with a fixed number of iterations.
    Repeat {
        /// Number of iterations.
        times: u32,
        /// The loop body.
        body: Vec<Node<F, A>>,
    },
    /// Parallel lanes, one for each actor; the node is complete when all lanes are.
    Parallel {
        /// The lanes, at least one, with distinct actors.
        lanes: Vec<Lane<A>>,
    },
    /// A remark for the reader about the following nodes.
    Remark(String),
}

/// The steps of one hand, arm or robot in a parallel node.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lane<A = EntityId> {
    /// The hand, arm or robot.
    pub actor: A,
    /// Items in execution order.
    pub items: Vec<LaneItem>,
}

/// An item of a lane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LaneItem {
    /// A step.
    Step(StepId),
    /// A synchronization point: all lanes that contain this name wait for each other.
    Sync(String),
    /// A remark for the reader about the following items.
    Remark(String),
}

/// Condition of a branch or a loop.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Test<F = Fact> {
    /// Executes this sensing step; holds if the step's first outcome occurs.
    Sense(StepId),
    /// Holds if this fact is known to hold.
    Holds(F),
    /// Negation.
    Not(Box<Test<F>>),
    /// Conjunction, evaluated in order until a part does not hold.
    All(Vec<Test<F>>),
    /// Disjunction, evaluated in order until a part holds.
    Any(Vec<Test<F>>),
}

impl<F> Test<F> {
    /// Returns the sensing steps of the condition, in reading order.
    pub fn steps(&self) -> Vec<StepId> {
        let mut steps = Vec::new();
        self.collect_steps(&mut steps);
        steps
    }

    fn collect_steps(&self, steps: &mut Vec<StepId>) {
        match self {
            Self::Sense(step) => steps.push(*step),
            Self::Holds(_) => {}
            Self::Not(inner) => inner.collect_steps(steps),
            Self::All(parts) | Self::Any(parts) => parts.iter().for_each(|part| part.collect_steps(steps)),
        }
    }

    pub(super) fn depth(&self) -> usize {
        match self {
            Self::Sense(_) | Self::Holds(_) => 0,
            Self::Not(inner) => 1 + inner.depth(),
            Self::All(parts) | Self::Any(parts) => 1 + parts.iter().map(Self::depth).max().unwrap_or(0),
        }
    }
}

impl Test {
    /// Removes a step and renumbers the other steps with `number`; none if the condition contains the removed step.
    fn without(&self, gone: StepId, number: &dyn Fn(&StepId) -> StepId) -> Option<Self> {
        let all = |parts: &[Self]| {
            parts
                .iter()
                .map(|part| part.without(gone, number))
                .collect::<Option<Vec<_>>>()
        };
        Some(match self {
            Self::Sense(id) if *id == gone => return None,
            Self::Sense(id) => Self::Sense(number(id)),
            Self::Holds(fact) => Self::Holds(*fact),
            Self::Not(inner) => Self::Not(Box::new(inner.without(gone, number)?)),
            Self::All(parts) => Self::All(all(parts)?),
            Self::Any(parts) => Self::Any(all(parts)?),
        })
    }
}

/// Returns the steps of the nodes, in reading order.
pub fn steps<F, A>(nodes: &[Node<F, A>]) -> Vec<StepId> {
    let mut found = Vec::new();
    collect_steps(nodes, &mut found);
    found
}

fn collect_steps<F, A>(nodes: &[Node<F, A>], found: &mut Vec<StepId>) {
    for node in nodes {
        match node {
            Node::Step(step) => found.push(*step),
            Node::If {
                condition,
                then,
                otherwise,
            } => {
                condition.collect_steps(found);
                collect_steps(then, found);
                collect_steps(otherwise, found);
            }
            Node::While { condition, body } => {
                condition.collect_steps(found);
                collect_steps(body, found);
            }
            Node::Repeat { body, .. } => collect_steps(body, found),
            Node::Parallel { lanes } => {
                let items = lanes.iter().flat_map(|lane| &lane.items);
                found.extend(items.filter_map(|item| match item {
                    LaneItem::Step(step) => Some(*step),
                    LaneItem::Sync(_) | LaneItem::Remark(_) => None,
                }));
            }
            Node::Remark(_) => {}
        }
    }
}

/// Removes a step and renumbers the later ones; none if a condition contains the removed step.
pub(super) fn without(nodes: &[Node], gone: StepId) -> Option<Vec<Node>> {
    let number = |id: &StepId| StepId::new(id.index() - usize::from(*id > gone));
    let test = |condition: &Test| condition.without(gone, &number);
    let item = |item: &LaneItem| match item {
        LaneItem::Step(id) if *id == gone => None,
        LaneItem::Step(id) => Some(LaneItem::Step(number(id))),
        other => Some(other.clone()),
    };
    let node = |node: &Node| {
        Some(match node {
            Node::Step(id) => Node::Step(number(id)),
            Node::If {
                condition,
                then,
                otherwise,
            } => Node::If {
                condition: test(condition)?,
                then: without(then, gone)?,
                otherwise: without(otherwise, gone)?,
            },
            Node::While { condition, body } => Node::While {
                condition: test(condition)?,
                body: without(body, gone)?,
            },
            Node::Repeat { times, body } => Node::Repeat {
                times: *times,
                body: without(body, gone)?,
            },
            Node::Parallel { lanes } => Node::Parallel {
                lanes: lanes
                    .iter()
                    .map(|lane| Lane {
                        actor: lane.actor,
                        items: lane.items.iter().filter_map(item).collect(),
                    })
                    .collect(),
            },
            Node::Remark(text) => Node::Remark(text.clone()),
        })
    };
    let stays = |node: &&Node| !matches!(node, Node::Step(id) if *id == gone);
    nodes.iter().filter(stays).map(node).collect()
}

/// Returns the nesting depth of branches, loops and conditions.
pub fn depth<F, A>(nodes: &[Node<F, A>]) -> usize {
    let of = |node: &Node<F, A>| match node {
        Node::Step(_) | Node::Remark(_) => 0,
        Node::If {
            condition,
            then,
            otherwise,
        } => 1 + condition.depth().max(depth(then)).max(depth(otherwise)),
        Node::While { condition, body } => 1 + condition.depth().max(depth(body)),
        Node::Repeat { body, .. } => 1 + depth(body),
        Node::Parallel { .. } => 1,
    };
    nodes.iter().map(of).max().unwrap_or(0)
}

/// Returns true if the nodes contain the steps `0..count` once each, in order, and are no deeper than [`DEEPEST`].
pub(super) fn is_sound<F, A>(nodes: &[Node<F, A>], count: usize) -> bool {
    depth(nodes) <= DEEPEST && steps(nodes).into_iter().map(StepId::index).eq(0..count)
}
