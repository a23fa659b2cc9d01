//! The tree of a plan: branches, loops, and lanes that run side by side.
//!
//! The nodes refer to steps by number, and the same tree serves a plan as it was written (facts and actors are words)
//! and one that was resolved (facts and actors are things of a world).

use super::StepId;
use crate::model::{EntityId, Fact};

/// How deep branches and loops may stand in each other. Each level is two brackets in JSON, of which common readers
/// follow 128.
pub const DEEPEST: usize = 48;

/// A part of a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Node<F = Fact, A = EntityId> {
    /// One step.
    Step(StepId),
    /// One of two ways, whichever the condition says.
    If {
        /// What decides.
        condition: Test<F>,
        /// The way where it holds.
        then: Vec<Node<F, A>>,
        /// The way where it does not; empty if nothing is to be done then.
        otherwise: Vec<Node<F, A>>,
    },
    /// Again and again, as long as the condition holds; it is asked before each time.
    While {
        /// What decides.
        condition: Test<F>,
        /// What is repeated.
        body: Vec<Node<F, A>>,
    },
    /// So many times.
    Repeat {
        /// How often.
        times: u32,
        /// What is repeated.
        body: Vec<Node<F, A>>,
    },
    /// Side by side, each lane by its own actor; done when all lanes are.
    Parallel {
        /// The lanes, at least one, no two of the same actor.
        lanes: Vec<Lane<A>>,
    },
    /// Words for whoever reads the plan, about what follows.
    Remark(String),
}

/// What one hand, arm or robot does while others do something else.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Lane<A = EntityId> {
    /// Who does it.
    pub actor: A,
    /// What, in turn.
    pub items: Vec<LaneItem>,
}

/// A part of a lane.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LaneItem {
    /// One step.
    Step(StepId),
    /// All lanes in which this name stands wait for each other here.
    Sync(String),
    /// Words for whoever reads the plan, about what follows.
    Remark(String),
}

/// What a branch or a loop asks.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Test<F = Fact> {
    /// Does this sensing step; holds when the first of its outcomes came.
    Sense(StepId),
    /// A fact that is known.
    Holds(F),
    /// The opposite.
    Not(Box<Test<F>>),
    /// All of them, asked in turn until one does not hold.
    All(Vec<Test<F>>),
    /// At least one of them, asked in turn until one holds.
    Any(Vec<Test<F>>),
}

impl<F> Test<F> {
    /// The sensing steps that it does, in reading order.
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
    /// The same without a step, those behind it counted by `number`; none if it asks for that very step.
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

/// The steps of nodes, in reading order.
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

/// The nodes without a step, those behind it counted anew; none if it stands in a condition.
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

/// How deep branches, loops and conditions stand in each other.
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

/// Whether the first `count` steps stand in the nodes, each once and in order, and nothing stands too deep.
pub(super) fn is_sound<F, A>(nodes: &[Node<F, A>], count: usize) -> bool {
    depth(nodes) <= DEEPEST && steps(nodes).into_iter().map(StepId::index).eq(0..count)
}
