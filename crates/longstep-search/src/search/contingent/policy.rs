//! Policies: results of the contingent search, and their conversion to plans.

use std::rc::Rc;

use crate::search::task::Task;
use crate::search::{GroundAction, cost};
use longstep_model::effort;
use longstep_model::model::{Domain, Fact, Number, World};
use longstep_verify::plan::{Node, Plan, Step, StepId, Test};

/// A policy from a state on: a sequence of operator numbers, and the continuation.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Policy {
    pub(super) path: Vec<u32>,
    pub(super) then: Then,
    /// Cost in the worst case, with one iteration of each loop.
    pub(super) worst: u32,
    /// Total cost of all branches.
    pub(super) total: u32,
}

/// Continuation of a [`Policy`].
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Then {
    /// The goal holds.
    Done,
    /// Repeats the sensing that led here.
    Again,
    /// Sensing, with an operator and a policy for each outcome, in the order of the action's outcomes.
    Look(Vec<(u32, Rc<Policy>)>),
}

impl Policy {
    /// Returns the number of steps in the worst case, with one iteration of each loop.
    pub(super) fn steps(&self) -> u32 {
        let path = self.path.len() as u32;
        match &self.then {
            Then::Done | Then::Again => path,
            Then::Look(outcomes) => path + 1 + outcomes.iter().map(|(_, policy)| policy.steps()).max().unwrap_or(0),
        }
    }

    /// Returns the cost in the worst case, with one iteration of each loop; none in a domain without costs.
    pub(super) fn cost(&self, world: &World, task: &Task) -> Option<Number> {
        let step = |number: &u32| &task.operators[*number as usize].step;
        let path = cost::total(world, self.path.iter().map(step))?;
        let Then::Look(outcomes) = &self.then else {
            return Some(path);
        };
        let mut worst = Number::ZERO;
        for (operator, policy) in outcomes {
            let after = cost::total(world, [step(operator)])?.plus(policy.cost(world, task)?)?;
            worst = worst.max(after);
        }
        path.plus(worst)
    }

    /// Returns true if `self` is preferable: fewer steps in the worst case, fewer in total, earlier sensing.
    pub(super) fn is_better(&self, other: &Self) -> bool {
        let rank = |policy: &Self| (policy.worst, policy.total, policy.path.len());
        rank(self) < rank(other)
    }
}

/// A part of a plan before its steps are numbered.
#[derive(Debug, Clone, PartialEq, Eq)]
enum PlanPiece {
    Do(GroundAction),
    /// Sensing, and a branch for each outcome.
    Look(GroundAction, Vec<OutcomeBranch>),
    /// A sensing loop: a body for each outcome that repeats it, and the outcomes that end it.
    Loop(GroundAction, Vec<OutcomeBranch>, Vec<Fact>),
    /// A branch for each outcome that is already known.
    Known(Vec<OutcomeBranch>),
}

/// Work units for a step of the plan, which is explained and compared with other branches.
const PIECE: usize = 64;

/// An outcome with its branch.
type OutcomeBranch = (Fact, Vec<PlanPiece>);

/// Converts a policy to a plan.
///
/// Steps at the end of all branches are moved after the branch, and outcomes with equal branches share one. Returns
/// none if the branches are nested too deeply.
pub(super) fn plan(world: &World, task: &Task, policy: &Policy) -> Option<Plan> {
    let domain = world.domain();
    let mut writer = Writer {
        domain,
        world,
        steps: Vec::new(),
    };
    let body = writer.nodes(pieces(task, policy));
    Plan::tree(writer.steps, body)
}

fn pieces(task: &Task, policy: &Policy) -> Vec<PlanPiece> {
    // Policies share subtrees, plans do not, so a plan can be exponentially larger.
    if !effort::spend(PIECE * (1 + policy.path.len())) {
        return Vec::new();
    }
    let step = |number: &u32| task.operators[*number as usize].step.clone();
    let mut pieces: Vec<PlanPiece> = policy.path.iter().map(|number| PlanPiece::Do(step(number))).collect();
    let Then::Look(outcomes) = &policy.then else {
        return pieces;
    };
    let way = |outcome: &(u32, Rc<Policy>)| branch(task, outcome);
    let (again, on): (Vec<_>, Vec<_>) = outcomes.iter().partition(|(_, policy)| policy.then == Then::Again);
    let Some(sensing) = outcomes.first().map(|(number, _)| step(number)) else {
        return pieces;
    };
    let mut ways: Vec<OutcomeBranch> = on.into_iter().filter_map(way).collect();
    let tail = common_tail(&mut ways);
    if again.is_empty() {
        pieces.push(PlanPiece::Look(sensing, ways));
    } else {
        let exits = ways.iter().map(|(fact, _)| *fact).collect();
        pieces.push(PlanPiece::Loop(
            sensing,
            again.into_iter().filter_map(way).collect(),
            exits,
        ));
        pieces.push(PlanPiece::Known(ways));
    }
    pieces.extend(tail);
    pieces
}

fn branch(task: &Task, (operator, policy): &(u32, Rc<Policy>)) -> Option<OutcomeBranch> {
    Some((task.operators[*operator as usize].outcome?, pieces(task, policy)))
}

/// Removes the common suffix of all branches and returns it.
fn common_tail(ways: &mut [OutcomeBranch]) -> Vec<PlanPiece> {
    let mut tail = Vec::new();
    while let Some(last) = ways.first().and_then(|(_, pieces)| pieces.last()).cloned()
        && ways.iter().all(|(_, pieces)| pieces.last() == Some(&last))
    {
        ways.iter_mut().for_each(|(_, pieces)| drop(pieces.pop()));
        tail.push(last);
    }
    tail.reverse();
    tail
}

struct Writer<'a> {
    domain: &'a Domain,
    world: &'a World,
    steps: Vec<Step>,
}

impl Writer<'_> {
    fn step(&mut self, step: GroundAction) -> StepId {
        let step = Step::explained(self.world, step.action, step.arguments);
        self.steps.push(step);
        StepId::new(self.steps.len() - 1)
    }

    fn nodes(&mut self, pieces: Vec<PlanPiece>) -> Vec<Node> {
        let mut nodes = Vec::new();
        for piece in pieces {
            match piece {
                PlanPiece::Do(step) => nodes.push(Node::Step(self.step(step))),
                PlanPiece::Look(step, ways) => self.look(step, ways, &mut nodes),
                PlanPiece::Loop(step, again, exits) => nodes.push(self.repeat(step, again, &exits)),
                PlanPiece::Known(ways) => nodes.extend(self.known(shared(ways))),
            }
        }
        nodes
    }

    fn look(&mut self, step: GroundAction, ways: Vec<OutcomeBranch>, nodes: &mut Vec<Node>) {
        let sides = shared(ways);
        let id = self.step(step);
        match <[Side; 2]>::try_from(sides) {
            // The sensing test holds for the first outcome, which is alone on the first side.
            Ok([(first, yes), (_, no)]) if first.len() == 1 => nodes.push(if yes.is_empty() {
                Node::If {
                    condition: Test::Not(Box::new(Test::Sense(id))),
                    then: self.nodes(no),
                    otherwise: Vec::new(),
                }
            } else {
                Node::If {
                    condition: Test::Sense(id),
                    then: self.nodes(yes),
                    otherwise: self.nodes(no),
                }
            }),
            Ok(sides) => {
                nodes.push(Node::Step(id));
                nodes.extend(self.known(sides.into()));
            }
            Err(sides) => {
                nodes.push(Node::Step(id));
                nodes.extend(self.known(sides));
            }
        }
    }

    /// Branches on known outcomes. The side with the most outcomes comes last, as the final `else`.
    fn known(&mut self, mut sides: Vec<Side>) -> Vec<Node> {
        // An empty side that comes last needs no `else`.
        sides.sort_by_key(|(facts, pieces)| (pieces.is_empty(), facts.len()));
        let mut sides = sides.into_iter();
        let Some((facts, pieces)) = sides.next() else {
            return Vec::new();
        };
        let rest: Vec<Side> = sides.collect();
        let then = self.nodes(pieces);
        if rest.is_empty() {
            return then;
        }
        vec![Node::If {
            condition: any(facts.into_iter().map(Test::Holds).collect()),
            then,
            otherwise: self.known(rest),
        }]
    }

    fn repeat(&mut self, step: GroundAction, again: Vec<OutcomeBranch>, exits: &[Fact]) -> Node {
        let first = self
            .domain
            .action(step.action)
            .senses
            .first()
            .map(|atom| longstep_model::model::ground(atom, &step.arguments));
        let sense = Test::Sense(self.step(step));
        let mut leaving: Vec<Test> = exits
            .iter()
            .filter(|fact| Some(**fact) != first)
            .map(|fact| Test::Holds(*fact))
            .collect();
        // The test of a sensing step is true for its first outcome only.
        let condition = if first.is_some_and(|fact| exits.contains(&fact)) {
            leaving.insert(0, sense);
            Test::Not(Box::new(any(leaving)))
        } else if again.len() == 1 {
            sense
        } else {
            Test::Any(vec![sense, Test::Not(Box::new(any(leaving)))])
        };
        Node::While {
            condition,
            body: self.known(shared(again)),
        }
    }
}

/// Outcomes with a common branch.
type Side = (Vec<Fact>, Vec<PlanPiece>);

/// Merges outcomes with equal branches.
fn shared(ways: Vec<OutcomeBranch>) -> Vec<Side> {
    let mut sides: Vec<Side> = Vec::new();
    for (fact, pieces) in ways {
        match sides.iter_mut().find(|(_, known)| *known == pieces) {
            Some((facts, _)) => facts.push(fact),
            None => sides.push((vec![fact], pieces)),
        }
    }
    sides
}

fn any(mut tests: Vec<Test>) -> Test {
    match tests.len() {
        1 => tests.remove(0),
        _ => Test::Any(tests),
    }
}
