//! The tree of a plan: branches, loops and parallel lanes.
//!
//! The nodes refer to steps by number. The tree of a written plan has names for facts and actors; the tree of a
//! resolved plan has facts and entities of a world.
//!
//! Code that visits, folds or rebuilds trees uses [`iter`], [`fold`] and [`Rebuild`]. Parsers, printers that indent, and
//! interpreters (`verify`, its binder, the blocks of `repair`, `cursor`) match on nodes themselves.

use super::StepId;
use longstep_model::model::{EntityId, Fact};

/// Maximum nesting depth of branches and loops. Each level takes two brackets in JSON, and common parsers accept 128.
pub const DEEPEST: usize = 48;

/// A node of the plan tree.
///
/// Exhaustive on purpose: code that does not know a new node would be wrong.
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
    /// Returns the direct parts of the condition; a sensing step and a fact have none.
    pub fn parts(&self) -> &[Self] {
        match self {
            Self::Sense(_) | Self::Holds(_) => &[],
            Self::Not(inner) => std::slice::from_ref(inner),
            Self::All(parts) | Self::Any(parts) => parts,
        }
    }

    /// Iterates over the condition and everything inside it in preorder.
    pub fn iter(&self) -> impl Iterator<Item = &Self> {
        preorder(vec![self], |test| [test.parts(), &[]])
    }

    /// Returns the sensing steps of the condition, in reading order.
    pub fn steps(&self) -> impl Iterator<Item = StepId> {
        self.iter().filter_map(|test| match test {
            Self::Sense(step) => Some(*step),
            _ => None,
        })
    }

    /// Returns the facts of the condition, in reading order.
    pub fn facts(&self) -> impl Iterator<Item = &F> {
        self.iter().filter_map(|test| match test {
            Self::Holds(fact) => Some(fact),
            _ => None,
        })
    }

    /// Rebuilds the condition: replaces each sensing step and each fact, in reading order.
    pub fn map<G>(&self, sense: &mut impl FnMut(StepId) -> Test<G>, holds: &mut impl FnMut(&F) -> Test<G>) -> Test<G> {
        let mut all = |parts: &[Self]| parts.iter().map(|part| part.map(sense, holds)).collect();
        match self {
            Self::Sense(step) => sense(*step),
            Self::Holds(fact) => holds(fact),
            Self::Not(inner) => Test::Not(Box::new(inner.map(sense, holds))),
            Self::All(parts) => Test::All(all(parts)),
            Self::Any(parts) => Test::Any(all(parts)),
        }
    }

    pub(super) fn depth(&self) -> usize {
        match self {
            Self::Sense(_) | Self::Holds(_) => 0,
            _ => 1 + self.parts().iter().map(Self::depth).max().unwrap_or(0),
        }
    }
}

impl Test {
    /// Renumbers the sensing steps of the condition.
    pub fn renumbered(&self, number: &mut impl FnMut(StepId) -> StepId) -> Self {
        self.map(&mut |step| Self::Sense(number(step)), &mut |fact| Self::Holds(*fact))
    }
}

impl<F, A> Node<F, A> {
    /// Returns the condition of a branch or of a loop.
    pub fn condition(&self) -> Option<&Test<F>> {
        match self {
            Self::If { condition, .. } | Self::While { condition, .. } => Some(condition),
            _ => None,
        }
    }

    /// Returns the blocks of the node: both sides of a branch, or the body of a loop and an empty block.
    pub fn blocks(&self) -> [&[Self]; 2] {
        match self {
            Self::If { then, otherwise, .. } => [then, otherwise],
            Self::While { body, .. } | Self::Repeat { body, .. } => [body, &[]],
            Self::Step(_) | Self::Parallel { .. } | Self::Remark(_) => [&[], &[]],
        }
    }

    /// Returns the steps of the node itself, without those in its blocks.
    fn own_steps(&self) -> Vec<StepId> {
        match self {
            Self::Step(step) => vec![*step],
            Self::If { condition, .. } | Self::While { condition, .. } => condition.steps().collect(),
            Self::Parallel { lanes } => lanes.iter().flat_map(Lane::steps).collect(),
            Self::Repeat { .. } | Self::Remark(_) => Vec::new(),
        }
    }
}

impl LaneItem {
    /// Returns the step of the item, if it is one.
    pub fn step(&self) -> Option<StepId> {
        match self {
            Self::Step(step) => Some(*step),
            Self::Sync(_) | Self::Remark(_) => None,
        }
    }

    /// Returns the name of the synchronisation point, if the item is one.
    pub fn sync(&self) -> Option<&str> {
        match self {
            Self::Sync(name) => Some(name),
            Self::Step(_) | Self::Remark(_) => None,
        }
    }
}

impl<A> Lane<A> {
    /// Returns the items of the lane without remarks.
    pub fn acts(&self) -> impl Iterator<Item = &LaneItem> {
        let items = self.items.iter();
        items.filter(|item| !matches!(item, LaneItem::Remark(_)))
    }

    /// Returns the steps of the lane, in order.
    pub fn steps(&self) -> impl Iterator<Item = StepId> {
        self.items.iter().filter_map(LaneItem::step)
    }

    /// Rebuilds the lane for `actor` with renumbered steps; steps without a new number are left out.
    pub fn map<B>(&self, actor: B, mut step: impl FnMut(StepId) -> Option<StepId>) -> Lane<B> {
        let item = |item: &LaneItem| match item {
            LaneItem::Step(id) => step(*id).map(LaneItem::Step),
            other => Some(other.clone()),
        };
        let items = self.items.iter().filter_map(item).collect();
        Lane { actor, items }
    }
}

/// Iterates over the roots and everything inside them in preorder.
fn preorder<'t, T>(
    roots: impl IntoIterator<Item = &'t T, IntoIter: DoubleEndedIterator>,
    inside: fn(&'t T) -> [&'t [T]; 2],
) -> impl Iterator<Item = &'t T> {
    let mut open: Vec<&T> = roots.into_iter().rev().collect();
    std::iter::from_fn(move || {
        let next = open.pop()?;
        let [first, second] = inside(next);
        open.extend(second.iter().rev().chain(first.iter().rev()));
        Some(next)
    })
}

/// Iterates over the nodes and everything inside them in preorder, which is reading order.
pub fn iter<F, A>(nodes: &[Node<F, A>]) -> impl Iterator<Item = &Node<F, A>> {
    preorder(nodes, Node::blocks)
}

/// Returns the steps of the nodes, in reading order.
pub fn steps<F, A>(nodes: &[Node<F, A>]) -> impl Iterator<Item = StepId> {
    iter(nodes).flat_map(Node::own_steps)
}

/// Folds the nodes bottom-up: `value` gets each node with the values of its [`Node::blocks`]. Returns the values of the
/// outermost nodes.
pub fn fold<F, A, T>(nodes: &[Node<F, A>], value: &impl Fn(&Node<F, A>, [Vec<T>; 2]) -> T) -> Vec<T> {
    let of = |node: &Node<F, A>| value(node, node.blocks().map(|block| fold(block, value)));
    nodes.iter().map(of).collect()
}

/// A transformation of trees. It replaces steps, conditions and lanes, and is called for them in reading order.
pub trait Rebuild<F, A> {
    /// The facts of the new tree.
    type Fact;
    /// The actors of the new tree.
    type Actor;

    /// Adds the replacement of a step to `nodes`.
    fn step(&mut self, step: StepId, nodes: &mut Vec<Node<Self::Fact, Self::Actor>>);

    /// Returns the replacement of a condition.
    fn condition(&mut self, condition: &Test<F>) -> Test<Self::Fact>;

    /// Returns the replacement of a lane.
    fn lane(&mut self, lane: &Lane<A>) -> Lane<Self::Actor>;

    /// Rebuilds the nodes.
    fn nodes(&mut self, nodes: &[Node<F, A>]) -> Vec<Node<Self::Fact, Self::Actor>> {
        let mut rebuilt = Vec::with_capacity(nodes.len());
        for node in nodes {
            let node = match node {
                Node::Step(step) => {
                    self.step(*step, &mut rebuilt);
                    continue;
                }
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => Node::If {
                    condition: self.condition(condition),
                    then: self.nodes(then),
                    otherwise: self.nodes(otherwise),
                },
                Node::While { condition, body } => Node::While {
                    condition: self.condition(condition),
                    body: self.nodes(body),
                },
                Node::Repeat { times, body } => Node::Repeat {
                    times: *times,
                    body: self.nodes(body),
                },
                Node::Parallel { lanes } => Node::Parallel {
                    lanes: lanes.iter().map(|lane| self.lane(lane)).collect(),
                },
                Node::Remark(text) => Node::Remark(text.clone()),
            };
            rebuilt.push(node);
        }
        rebuilt
    }
}

/// Removes a step from a tree and renumbers the later ones.
struct Without(StepId);

impl Without {
    fn number(&self, step: StepId) -> Option<StepId> {
        (step != self.0).then(|| StepId::new(step.index() - usize::from(step > self.0)))
    }
}

impl Rebuild<Fact, EntityId> for Without {
    type Fact = Fact;
    type Actor = EntityId;

    fn step(&mut self, step: StepId, nodes: &mut Vec<Node>) {
        nodes.extend(self.number(step).map(Node::Step));
    }

    fn condition(&mut self, condition: &Test) -> Test {
        condition.renumbered(&mut |step| self.number(step).unwrap_or(step))
    }

    fn lane(&mut self, lane: &Lane) -> Lane {
        lane.map(lane.actor, |step| self.number(step))
    }
}

/// Removes a step and renumbers the later ones; none if a condition contains the removed step.
pub(super) fn without(nodes: &[Node], gone: StepId) -> Option<Vec<Node>> {
    let mut sensing = iter(nodes).filter_map(Node::condition).flat_map(Test::steps);
    (!sensing.any(|step| step == gone)).then(|| Without(gone).nodes(nodes))
}

/// Returns the nesting depth of branches, loops and conditions.
pub fn depth<F, A>(nodes: &[Node<F, A>]) -> usize {
    let levels = fold(nodes, &|node, inside| match node {
        Node::Step(_) | Node::Remark(_) => 0,
        _ => {
            let inside = inside.into_iter().flatten();
            1 + inside.chain(node.condition().map(Test::depth)).max().unwrap_or(0)
        }
    });
    levels.into_iter().max().unwrap_or(0)
}

/// Returns true if the nodes contain the steps `0..count` once each, in order, and are no deeper than [`DEEPEST`].
pub(super) fn is_sound<F, A>(nodes: &[Node<F, A>], count: usize) -> bool {
    depth(nodes) <= DEEPEST && steps(nodes).map(StepId::index).eq(0..count)
}
