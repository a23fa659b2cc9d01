//! A* in which sensing branches.
//!
//! From each state, the search goes forward over what changes the world, as for a plan without sensing. Wherever
//! something can be sensed that is not known, one more choice is open: to sense here, which costs one step and then
//! whatever the worst outcome costs, each solved in the same way. Choices are taken up in the order of what they cost at
//! least, so that the first one whose cost is known is the best.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::rc::Rc;

use indexmap::IndexMap;
use rustc_hash::FxHashMap;

use super::bound::{Bounds, outcome};
use super::policy::{Course, Then};
use crate::effort;
use crate::search::GroundAction;
use crate::search::bits::Bits;
use crate::search::dominance::Dominance;
use crate::search::formula::Literal;
use crate::search::task::Task;

/// How deep sensing may follow on sensing.
const DEEPEST: usize = 48;

/// The limit was reached.
#[derive(Debug)]
pub(super) struct TooFar;

/// What is known of solving from a state.
struct Known {
    /// No course has a worst case of fewer steps.
    at_least: u32,
    course: Option<Rc<Course>>,
}

/// How a search goes about it.
#[derive(Debug, Clone, Copy)]
pub(super) struct Manner {
    /// States looked at before it gives up.
    pub(super) limit: usize,
    /// States looked at for fewer steps in all, once the worst case is known.
    pub(super) ties: usize,
    /// How much it prefers states that look close to the goal; 1 finds the best course.
    pub(super) weight: u32,
    /// Whether sensing may be done again and again until it tells what is hoped for.
    pub(super) looping: bool,
}

pub(super) struct Search<'a> {
    task: &'a Task,
    bounds: Bounds,
    manner: Manner,
    /// By sensing step: the operators for its outcomes.
    looks: Vec<Vec<u32>>,
    /// The units for expanding a node, without what it leads to.
    expanding: usize,
    known: FxHashMap<Bits, Known>,
    /// The states at which sensing is being solved for.
    heads: Vec<Bits>,
    /// Searches begun, which count against the limit like states.
    begun: usize,
}

struct Node {
    state: Bits,
    parent: Option<(u32, u32)>,
    depth: u32,
    estimate: u32,
    estimated: bool,
    expanded: bool,
}

/// Something to take up.
#[derive(Clone)]
enum Choice {
    /// A node, by number.
    Node(u32),
    /// Sensing at a node, by their numbers: nothing is known of its outcomes yet.
    Look(u32, u32),
    /// The same, with the least number of steps in all.
    Outcomes(u32, u32, u32),
    /// A course that is solved.
    Solved(Rc<Course>),
}

/// The choices of one search, cheapest first; then closest to the goal, preferred, in the order of discovery.
#[derive(Default)]
struct Open {
    heap: BinaryHeap<Reverse<(u32, u32, bool, u32)>>,
    choices: Vec<Choice>,
}

impl Open {
    fn push(&mut self, cost: u32, closeness: u32, preferred: bool, choice: Choice) {
        let number = self.choices.len() as u32;
        self.choices.push(choice);
        self.heap.push(Reverse((cost, closeness, !preferred, number)));
    }

    fn pop(&mut self) -> Option<(u32, Choice)> {
        let Reverse((cost, _, _, number)) = self.heap.pop()?;
        Some((cost, self.choices[number as usize].clone()))
    }
}

/// The nodes of one search.
struct Nodes {
    all: Vec<Node>,
    numbers: FxHashMap<Bits, u32>,
    dominance: Option<Dominance>,
}

impl<'a> Search<'a> {
    pub(super) fn new(task: &'a Task, manner: Manner) -> Self {
        let mut looks: IndexMap<&GroundAction, Vec<u32>> = IndexMap::new();
        for (number, operator) in task.operators.iter().enumerate().filter(|(_, o)| o.told.is_some()) {
            looks.entry(&operator.step).or_default().push(number as u32);
        }
        Self {
            task,
            bounds: Bounds::new(task, manner.looping),
            manner,
            looks: looks.into_values().collect(),
            expanding: task.units(),
            known: FxHashMap::default(),
            heads: Vec::new(),
            begun: 0,
        }
    }

    /// How many states were looked at.
    pub(super) fn looked_at(&self) -> usize {
        self.bounds.looked_at
    }

    /// The best course from the task's first state, if there is one with a worst case of fewer steps than `below`.
    pub(super) fn run(&mut self, below: u32) -> Result<Option<Rc<Course>>, TooFar> {
        let mut start = Bits::none(self.task.initial.len());
        for (fact, holds) in self.task.initial.iter().enumerate() {
            let fact = fact as u32;
            start.set(Literal { fact, holds: *holds });
        }
        self.best(&start, below)
    }

    fn best(&mut self, start: &Bits, below: u32) -> Result<Option<Rc<Course>>, TooFar> {
        if let Some(known) = self.known.get(start) {
            match &known.course {
                Some(course) => return Ok((course.worst < below).then(|| Rc::clone(course))),
                None if known.at_least >= below => return Ok(None),
                None => {}
            }
        }
        self.begun += 1;
        if self.begun > self.manner.limit || self.heads.len() > DEEPEST {
            return Err(TooFar);
        }
        let course = self.search(start, below)?;
        // What leads back to a sensing that is being solved for is a course there only.
        if !self.manner.looping {
            let known = Known {
                at_least: course.as_ref().map_or(below, |course| course.worst),
                course: course.clone(),
            };
            self.known.insert(start.clone(), known);
        }
        Ok(course)
    }

    fn search(&mut self, start: &Bits, below: u32) -> Result<Option<Rc<Course>>, TooFar> {
        let mut nodes = Nodes {
            all: Vec::new(),
            numbers: FxHashMap::default(),
            dominance: (!self.manner.looping).then(|| Dominance::new(self.task)),
        };
        let mut open = Open::default();
        let mut best: Option<Rc<Course>> = None;
        self.discover(&mut nodes, &mut open, start.clone(), None, (0, 0, false));
        while let Some((cost, choice)) = open.pop() {
            if !effort::spend(1) {
                return Err(TooFar);
            }
            let exact = self.manner.weight == 1;
            if exact && cost >= below {
                break;
            }
            if let Some(best) = &best
                && (!exact || cost > best.worst || self.manner.ties == 0)
            {
                break;
            }
            let in_all = best.as_ref().map_or(u32::MAX, |best| best.total);
            match choice {
                Choice::Node(number) => {
                    let node = &nodes.all[number as usize];
                    if node.expanded || cost > self.promise(node) || node.depth + node.estimate >= in_all {
                        continue;
                    }
                    if let Some(then) = self.is_end(node) {
                        return Ok(Some(Rc::new(nodes.straight(number, then))));
                    }
                    self.take_up(&mut nodes, &mut open, number, best.is_some())?;
                }
                Choice::Look(number, look) => {
                    let node = &nodes.all[number as usize];
                    let (depth, state) = (node.depth, node.state.clone());
                    if let Some((worst, sum)) = self.outcomes_at_least(&state, look)? {
                        let cost = (depth + 1 + self.manner.weight * worst).max(cost);
                        open.push(cost, worst, true, Choice::Outcomes(number, look, depth + 1 + sum));
                    }
                }
                Choice::Outcomes(number, look, total) => {
                    let depth = nodes.all[number as usize].depth as usize;
                    let earlier = best.as_ref().is_none_or(|best| depth < best.path.len());
                    if total > in_all || (total == in_all && !earlier) {
                        continue;
                    }
                    let below = best
                        .as_ref()
                        .map_or(below, |best| below.min(best.worst.saturating_add(1)));
                    if let Some(course) = self.solved(&nodes, number, look, below)? {
                        open.push(course.worst, 0, true, Choice::Solved(Rc::new(course)));
                    }
                }
                Choice::Solved(course) => {
                    if best.as_ref().is_none_or(|best| course.is_better(best)) {
                        best = Some(course);
                    }
                }
            }
        }
        Ok(best)
    }

    fn promise(&self, node: &Node) -> u32 {
        node.depth + self.manner.weight * node.estimate
    }

    /// What a course that has come to the node ends with, if it may end there.
    fn is_end(&self, node: &Node) -> Option<Then> {
        if self.task.goal.holds(&|literal| node.state.is(literal)) {
            return Some(Then::Done);
        }
        let back = self.manner.looping && node.depth > 0 && self.heads.last() == Some(&node.state);
        back.then_some(Then::Again)
    }

    /// Estimates a node; if it is still worth it, expands it.
    fn take_up(&mut self, nodes: &mut Nodes, open: &mut Open, number: u32, tie: bool) -> Result<(), TooFar> {
        let node = &nodes.all[number as usize];
        let state = node.state.clone();
        let before = self.promise(node);
        let estimate = self.estimate(&state, tie)?;
        let node = &mut nodes.all[number as usize];
        let Some(cost) = estimate.cost else {
            // A dead end, whatever sensing tells or for one thing that it can tell.
            node.expanded = true;
            return Ok(());
        };
        if !std::mem::replace(&mut node.estimated, true) {
            node.estimate = node.estimate.max(cost);
            let node = &nodes.all[number as usize];
            let later = self.promise(node);
            if later > before {
                open.push(later, node.estimate, false, Choice::Node(number));
                return Ok(());
            }
        }
        self.expand(nodes, open, number, &estimate.preferred);
        Ok(())
    }

    fn estimate(&mut self, state: &Bits, tie: bool) -> Result<super::bound::Estimate, TooFar> {
        let before = self.bounds.looked_at;
        let estimate = self.bounds.estimate(state);
        if tie {
            self.manner.ties = self.manner.ties.saturating_sub(self.bounds.looked_at - before);
        }
        match self.bounds.looked_at > self.manner.limit {
            true => Err(TooFar),
            false => Ok(estimate),
        }
    }

    fn expand(&mut self, nodes: &mut Nodes, open: &mut Open, number: u32, preferred: &[u32]) {
        let task = self.task;
        nodes.all[number as usize].expanded = true;
        effort::spend(self.expanding + self.looks.len());
        for (index, operator) in task.operators.iter().enumerate().filter(|(_, o)| o.told.is_none()) {
            let node = &nodes.all[number as usize];
            if !operator.precondition.holds(&|literal| node.state.is(literal)) {
                continue;
            }
            if !effort::spend(1 + task.initial.len() / 256) {
                return;
            }
            let next = after(task, &node.state, index as u32);
            let allowed = |before: &Bits| {
                task.always
                    .allows(&|literal| before.is(literal), &|literal| next.is(literal))
            };
            if next == node.state || !allowed(&node.state) {
                continue;
            }
            let (depth, estimate) = (node.depth + operator.cost, node.estimate.saturating_sub(operator.cost));
            let is_preferred = preferred.binary_search(&(index as u32)).is_ok();
            self.discover(
                nodes,
                open,
                next,
                Some((number, index as u32)),
                (depth, estimate, is_preferred),
            );
        }
        for look in 0..self.looks.len() {
            let node = &nodes.all[number as usize];
            let operator = &task.operators[self.looks[look][0] as usize];
            if operator.precondition.holds(&|literal| node.state.is(literal)) {
                open.push(
                    self.promise(node),
                    node.estimate,
                    true,
                    Choice::Look(number, look as u32),
                );
            }
        }
    }

    fn discover(
        &self,
        nodes: &mut Nodes,
        open: &mut Open,
        state: Bits,
        parent: Option<(u32, u32)>,
        (depth, estimate, preferred): (u32, u32, bool),
    ) {
        let number = match nodes.numbers.get(&state).copied() {
            Some(number) => {
                let node = &mut nodes.all[number as usize];
                if depth >= node.depth {
                    return;
                }
                node.depth = depth;
                node.parent = parent;
                // An estimate that is not consistent may have expanded it too early.
                node.expanded = false;
                number
            }
            None => {
                let admitted = |dominance: &mut Dominance| dominance.admits(&state, depth);
                if !nodes.dominance.as_mut().is_none_or(admitted) {
                    return;
                }
                let number = nodes.all.len() as u32;
                effort::spend(Bits::units(self.task.initial.len()));
                nodes.numbers.insert(state.clone(), number);
                nodes.all.push(Node {
                    state,
                    parent,
                    depth,
                    estimate,
                    estimated: false,
                    expanded: false,
                });
                number
            }
        };
        let node = &nodes.all[number as usize];
        open.push(self.promise(node), node.estimate, preferred, Choice::Node(number));
    }

    /// What the outcomes of sensing cost at least: the worst of them, and all together. None if one of them is hopeless.
    fn outcomes_at_least(&mut self, state: &Bits, look: u32) -> Result<Option<(u32, u32)>, TooFar> {
        let (mut worst, mut sum) = (0, 0);
        for operator in self.looks[look as usize].clone() {
            let told = after(self.task, state, operator);
            let Some(cost) = self.estimate(&told, false)?.cost else {
                return Ok(None);
            };
            worst = worst.max(cost);
            sum += cost;
        }
        Ok(Some((worst, sum)))
    }

    /// The best course that senses at a node.
    fn solved(&mut self, nodes: &Nodes, number: u32, look: u32, below: u32) -> Result<Option<Course>, TooFar> {
        let node = &nodes.all[number as usize];
        let Some(left) = below.checked_sub(node.depth + 1) else {
            return Ok(None);
        };
        let mut outcomes = Vec::new();
        self.heads.push(node.state.clone());
        for operator in self.looks[look as usize].clone() {
            let told = after(self.task, &node.state, operator);
            match self.best(&told, left)? {
                Some(course) => outcomes.push((operator, course)),
                None => break,
            }
        }
        self.heads.pop();
        let all = outcomes.len() == self.looks[look as usize].len();
        // A loop that nothing ends is no course.
        let ends = outcomes.iter().any(|(_, course)| course.then != Then::Again);
        if !all || !ends {
            return Ok(None);
        }
        let worst = outcomes.iter().map(|(_, course)| course.worst).max().unwrap_or(0);
        let total: u32 = outcomes.iter().map(|(_, course)| course.total).sum();
        Ok(Some(Course {
            path: nodes.path(number),
            then: Then::Look(outcomes),
            worst: node.depth + 1 + worst,
            total: node.depth + 1 + total,
        }))
    }
}

impl Nodes {
    /// The operators that lead to a node.
    fn path(&self, number: u32) -> Vec<u32> {
        let mut path = Vec::new();
        let mut at = number;
        while let Some((parent, operator)) = self.all[at as usize].parent {
            path.push(operator);
            at = parent;
        }
        path.reverse();
        path
    }

    /// The course that only leads to a node.
    fn straight(&self, number: u32, then: Then) -> Course {
        let depth = self.all[number as usize].depth;
        Course {
            path: self.path(number),
            then,
            worst: depth,
            total: depth,
        }
    }
}

/// The state after an operator.
fn after(task: &Task, state: &Bits, operator: u32) -> Bits {
    let operator = &task.operators[operator as usize];
    debug_assert!(operator.told.is_none() || outcome(operator).is_some());
    let mut next = state.clone();
    let fires = |holds: bool| {
        operator
            .effects
            .iter()
            .filter(move |effect| effect.literal.holds == holds && effect.condition.holds(&|literal| state.is(literal)))
    };
    // What is both taken away and given stays, as PDDL has it.
    for effect in fires(false).chain(fires(true)) {
        next.set(effect.literal);
    }
    next
}
