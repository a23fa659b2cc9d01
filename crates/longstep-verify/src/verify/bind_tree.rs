//! Binding of implicit arguments in plans with branches, loops or lanes.
//!
//! Binding proceeds by execution paths. The chosen paths together contain every step. Each path is bound like a
//! sequential plan and keeps the arguments that earlier paths have fixed. The condition values that a path assumes are
//! known from there on, like outcomes of sensing.

use super::bind::{Learned, Turn, bind_path, bound, learn, nothing_fits};
use super::{Assumption, Violation, claims};
use crate::plan::{DraftStep, Node, Plan, Resolved, StepId, Test, lanes, tree};
use longstep_model::effort;
use longstep_model::environment::Claim;
use longstep_model::model::{Fact, World};

/// Maximum number of paths; a step on none of them is bound on its own.
const WAYS: usize = 256;

/// Binds every implicit argument of a plan of any shape.
///
/// A sequential plan is bound as [`super::bind`] does, but the claims of its steps count as well.
///
/// # Errors
///
/// The issues of an unresolved draft; [`Violation::NothingFits`] for each step with an implicit argument that no entity
/// fits; [`Violation::TooMuchWork`] if binding exceeds [`effort::OPERATION`] units; [`Violation::TooDeep`] if the tree
/// is too deep.
pub fn bind_tree(
    world: &World,
    resolved: &Resolved,
    claim: Option<&Claim>,
) -> Result<(Plan, Vec<Assumption>), Vec<Violation>> {
    let mut steps = resolved.complete().map_err(<[Violation]>::to_vec)?;
    let mut assumptions = Vec::new();
    let spent = effort::within(effort::OPERATION, || {
        bind_paths(world, resolved, claim, &mut steps, &mut assumptions)
    });
    if spent.exhausted || !spent.result {
        return Err(vec![Violation::TooMuchWork]);
    }
    let whole = |step: &DraftStep| step.arguments.iter().copied().collect::<Option<Vec<_>>>();
    let (mut all, mut missing) = (Vec::with_capacity(steps.len()), Vec::new());
    for (index, step) in steps.iter().enumerate() {
        match whole(step) {
            Some(arguments) => all.push(bound(world, step, arguments)),
            None => missing.push(nothing_fits(world.domain(), index, step)),
        }
    }
    if !missing.is_empty() {
        return Err(missing);
    }
    match Plan::tree(all, resolved.body.clone()) {
        Some(plan) => Ok((plan, assumptions)),
        None => Err(vec![Violation::TooDeep]),
    }
}

/// Binds path after path until every step has been on one, then each remaining step on its own. Returns false if the
/// budget is exceeded.
fn bind_paths(
    world: &World,
    resolved: &Resolved,
    claim: Option<&Claim>,
    steps: &mut [DraftStep],
    assumptions: &mut Vec<Assumption>,
) -> bool {
    let written = steps.to_vec();
    let mut chooser = Chooser {
        steps: &written,
        done: vec![false; steps.len()],
        decided: Vec::new(),
        target: None,
    };
    for _ in 0..WAYS {
        let Some(path) = chooser.next(&resolved.body) else {
            break;
        };
        let turns: Vec<Turn> = path.turns(steps, resolved);
        let mut start = world.state.clone();
        for (fact, holds) in &path.before {
            learn(world.domain(), &mut start, *fact, *holds);
        }
        let found = bind_path(world, &start, &turns, &resolved.objects, claim);
        if found.exhausted {
            return false;
        }
        for (id, arguments) in path.steps.iter().zip(found.arguments) {
            steps[id.index()].arguments = arguments.into_iter().map(Some).collect();
        }
        assumptions.extend(found.assumptions.into_iter().map(|open| match open {
            Assumption::Argument {
                step,
                parameter,
                entity,
            } => Assumption::Argument {
                step: path.steps[step].index(),
                parameter,
                entity,
            },
            other => other,
        }));
    }
    let left_over = |index: &usize| steps[*index].arguments.iter().any(Option::is_none);
    for index in (0..steps.len()).filter(left_over).collect::<Vec<_>>() {
        let turn = Turn::from(steps[index].clone());
        let found = bind_path(world, &world.state, &[turn], &resolved.objects, claim);
        if found.exhausted {
            return false;
        }
        if let [arguments] = &found.arguments[..] {
            steps[index].arguments = arguments.iter().copied().map(Some).collect();
        }
    }
    true
}

/// One execution path of a plan.
#[derive(Debug, Default)]
struct BoundPath {
    /// Facts that are assumed before the first step.
    before: Vec<(Fact, bool)>,
    /// The steps, as often as they are executed.
    steps: Vec<StepId>,
    /// Assumptions after each step.
    learned: Vec<Vec<Learned>>,
}

impl BoundPath {
    fn step(&mut self, id: StepId) {
        self.steps.push(id);
        self.learned.push(Vec::new());
    }

    fn turns(&self, steps: &[DraftStep], resolved: &Resolved) -> Vec<Turn> {
        let mut turns = Vec::with_capacity(self.steps.len());
        for (id, learned) in self.steps.iter().zip(&self.learned) {
            let claims = claims::of_step(&resolved.claims, id.index());
            turns.push(Turn {
                step: steps[id.index()].clone(),
                claims: claims.map(|claim| claim.fact).collect(),
                learned: learned.clone(),
            });
        }
        turns
    }
}

/// Chooses execution paths until every step has been on one.
struct Chooser<'a> {
    steps: &'a [DraftStep],
    done: Vec<bool>,
    /// Assumed values of the conditions on the current path; a repeated condition keeps its value.
    decided: Vec<(Test, bool)>,
    /// A step that the path must reach, whatever was assumed before.
    target: Option<StepId>,
}

impl Chooser<'_> {
    fn next(&mut self, body: &[Node]) -> Option<BoundPath> {
        let missing = self.done.iter().position(|done| !done)?;
        // Free choices come first, since they cover many steps at once. A target is for what they never reach.
        for target in [None, Some(StepId::new(missing))] {
            self.target = target;
            self.decided.clear();
            let mut path = BoundPath::default();
            self.nodes(body, &mut path);
            let news = path.steps.iter().any(|step| !self.done[step.index()]);
            if news {
                path.steps.iter().for_each(|step| self.done[step.index()] = true);
                return Some(path);
            }
        }
        None
    }

    fn nodes(&mut self, nodes: &[Node], path: &mut BoundPath) {
        for node in nodes {
            if !effort::spend(1) {
                return;
            }
            match node {
                Node::Step(id) => path.step(*id),
                Node::If {
                    condition,
                    then,
                    otherwise,
                } => {
                    let holds = self.choose(condition, then, otherwise);
                    self.test(condition, holds, path);
                    self.nodes(if holds { then } else { otherwise }, path);
                }
                Node::While { condition, body } => {
                    // One iteration contains every step of the body.
                    self.test(condition, true, path);
                    self.nodes(body, path);
                    self.assume(condition, false, path);
                }
                Node::Repeat { body, .. } => self.nodes(body, path),
                Node::Parallel { lanes } => lanes::sequence(lanes).into_iter().for_each(|step| path.step(step)),
                Node::Remark(_) => {}
            }
        }
    }

    /// Decides which branch the path takes: true for `then`.
    fn choose(&self, condition: &Test, then: &[Node], otherwise: &[Node]) -> bool {
        effort::spend(self.decided.len() + tree::steps(then).chain(tree::steps(otherwise)).count());
        let leads = |nodes: &[Node]| tree::steps(nodes).any(|step| Some(step) == self.target);
        let news = |nodes: &[Node]| tree::steps(nodes).any(|step| !self.done[step.index()]);
        if leads(then) || leads(otherwise) {
            return leads(then);
        }
        self.known(condition).unwrap_or_else(|| news(then) || !news(otherwise))
    }

    /// Returns the value of the condition that follows from the assumptions of this path.
    fn known(&self, test: &Test) -> Option<bool> {
        match test {
            Test::Sense(_) | Test::Holds(_) => {
                let same = |(other, _): &&(Test, bool)| self.same(other, test);
                self.decided.iter().rev().find(same).map(|(_, holds)| *holds)
            }
            Test::Not(inner) => self.known(inner).map(|holds| !holds),
            Test::All(all) => self.known_parts(all, false),
            Test::Any(any) => self.known_parts(any, true),
        }
    }

    /// Returns the value of several parts, which one part with the value `decisive` decides.
    fn known_parts(&self, parts: &[Test], decisive: bool) -> Option<bool> {
        let known: Vec<Option<bool>> = parts.iter().map(|part| self.known(part)).collect();
        if known.contains(&Some(decisive)) {
            Some(decisive)
        } else {
            known.iter().all(Option::is_some).then_some(!decisive)
        }
    }

    /// Returns true if two conditions ask for the same fact or the same sensing.
    fn same(&self, one: &Test, other: &Test) -> bool {
        match (one, other) {
            (Test::Holds(one), Test::Holds(other)) => one == other,
            (Test::Sense(one), Test::Sense(other)) => {
                let (one, other) = (&self.steps[one.index()], &self.steps[other.index()]);
                (one.action, &one.arguments) == (other.action, &other.arguments)
            }
            _ => false,
        }
    }

    /// Adds the sensing steps of a condition, and assumes its value.
    fn test(&mut self, condition: &Test, holds: bool, path: &mut BoundPath) {
        condition.steps().for_each(|step| path.step(step));
        self.assume(condition, holds, path);
    }

    /// Assumes a value of the condition. All its parts take the value, even if one would suffice, so that all are bound
    /// alike.
    fn assume(&mut self, test: &Test, holds: bool, path: &mut BoundPath) {
        match test {
            Test::Not(inner) => self.assume(inner, !holds, path),
            Test::All(parts) | Test::Any(parts) => parts.iter().for_each(|part| self.assume(part, holds, path)),
            Test::Holds(fact) => {
                self.decided.push((test.clone(), holds));
                match path.learned.last_mut() {
                    Some(learned) => learned.push(Learned::Fact(*fact, holds)),
                    None => path.before.push((*fact, holds)),
                }
            }
            Test::Sense(id) => {
                self.decided.push((test.clone(), holds));
                let place = path.steps.iter().rposition(|step| step == id);
                if let (Some(place), Some(learned)) = (place, path.learned.last_mut()) {
                    learned.push(Learned::Outcome(place, holds));
                }
            }
        }
    }
}
