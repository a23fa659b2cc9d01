//! Binding of implicit arguments, which the call syntax omits.
//!
//! `grasp_object()` names no argument: the object is the plan's `object_name`, and the place appears only in the
//! environment after the plan. Binding is a search over candidate arguments. The chosen binding is executable and its
//! final state differs least from the claims. Between equal bindings, entities that the step's explanation mentions
//! come first. Arguments that are still ambiguous are listed as assumptions.

use std::collections::hash_map::Entry;

use rustc_hash::{FxHashMap, FxHashSet};

use super::candidate::{candidates, claimed_places, explanation_words};
use super::rules::{breaks_a_rule, broken_rules_at_end};
use super::{Assumption, Missing, Violation, apply, unmet};
use crate::plan::{DraftStep, Plan, Step};
use longstep_model::effort;
use longstep_model::environment::Claim;
use longstep_model::model::{Action, ChangedLists, Difference, Domain, EntityId, Fact, State, World, ground};

/// Maximum number of visited states; then the best binding so far is used.
const LIMIT: usize = 20_000;

/// Maximum number of further states once a binding meets all claims, to find one that also keeps the rules for the
/// final state.
const AFTER: usize = 2_000;

/// Work budgets to bind one path, and to find its ambiguous arguments.
const WAY: u64 = effort::OPERATION / 3 * 2;
const OPEN: u64 = effort::OPERATION / 3;

/// Plans with more steps are bound greedily, since each step is a level of recursion.
const LONGEST: usize = 2_000;

/// A step on an execution path, with the evidence for its arguments.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) step: DraftStep,
    /// Facts that the step claims to hold after it.
    pub(super) claims: Vec<Fact>,
    /// Facts that the path assumes to be known after the step.
    pub(super) learned: Vec<Learned>,
}

impl Turn {
    /// Returns true for a sensing step with an implicit argument.
    fn is_open_look(&self, domain: &Domain) -> bool {
        let Self { step, .. } = self;
        !domain.action(step.action).senses.is_empty() && step.arguments.contains(&None)
    }
}

impl From<DraftStep> for Turn {
    /// The step without claims and assumptions.
    fn from(step: DraftStep) -> Self {
        Self {
            step,
            claims: Vec::new(),
            learned: Vec::new(),
        }
    }
}

/// An assumption of an execution path about a condition.
#[derive(Debug, Clone)]
pub(super) enum Learned {
    /// Outcome of the sensing step at this position on the path: true for its first outcome.
    Outcome(usize, bool),
    /// Truth value of a fact.
    Fact(Fact, bool),
}

/// Binds every implicit argument. If no binding is executable, uses the one that misses the fewest preconditions, so
/// that [`super::check`] can report them.
///
/// # Errors
///
/// [`Violation::NothingFits`] for the first step with an implicit argument that no entity of the environment fits;
/// [`Violation::TooMuchWork`] if binding exceeds [`effort::OPERATION`] units.
pub fn bind(
    world: &World,
    steps: &[DraftStep],
    objects: &[EntityId],
    claim: Option<&Claim>,
) -> Result<(Plan, Vec<Assumption>), Violation> {
    let Bound {
        steps,
        assumptions,
        missing,
    } = bind_as_far(world, steps, objects, claim);
    match missing {
        None => Ok((Plan::sequence(steps), assumptions)),
        Some(violation) => Err(violation),
    }
}

/// Steps with their arguments, up to the first step that cannot be bound.
pub struct Bound {
    /// The bound steps.
    pub steps: Vec<Step>,
    pub(crate) assumptions: Vec<Assumption>,
    /// Reason why later steps are not bound.
    pub missing: Option<Violation>,
}

/// Binds implicit arguments up to the first step that no entity fits.
pub fn bind_as_far(world: &World, steps: &[DraftStep], objects: &[EntityId], claim: Option<&Claim>) -> Bound {
    let turns: Vec<Turn> = steps.iter().cloned().map(Turn::from).collect();
    let WayArguments {
        arguments,
        assumptions,
        exhausted,
    } = bind_path(world, &world.state, &turns, objects, claim);
    let missing = match steps.get(arguments.len()) {
        _ if exhausted => Some(Violation::TooMuchWork),
        Some(step) => Some(nothing_fits(world.domain(), arguments.len(), step)),
        None => None,
    };
    let steps = steps
        .iter()
        .zip(arguments)
        .map(|(step, arguments)| bound(world, step, arguments));
    Bound {
        steps: steps.collect(),
        assumptions,
        missing,
    }
}

/// Returns the violation for a step with an implicit argument that no entity fits.
pub(super) fn nothing_fits(domain: &Domain, index: usize, step: &DraftStep) -> Violation {
    let open = step.arguments.iter().position(Option::is_none);
    let parameters = &domain.action(step.action).parameters;
    Violation::NothingFits {
        step: index,
        parameter: open.map_or_else(String::new, |place| parameters[place].name.clone()),
    }
}

/// Arguments of the steps on one execution path.
#[derive(Debug, Default)]
pub(super) struct WayArguments {
    /// Arguments of each step; fewer than steps if no entity fits one.
    pub arguments: Vec<Vec<EntityId>>,
    /// The ambiguous arguments.
    pub(super) assumptions: Vec<Assumption>,
    /// True if the search exceeded the budget.
    pub(super) exhausted: bool,
}

/// Binds the steps of one execution path from the state `start`, as far as possible.
pub(super) fn bind_path(
    world: &World,
    start: &State,
    turns: &[Turn],
    objects: &[EntityId],
    claim: Option<&Claim>,
) -> WayArguments {
    let given = |turn: &Turn| turn.step.arguments.iter().copied().collect::<Option<Vec<EntityId>>>();
    if let Some(arguments) = turns.iter().map(given).collect() {
        return WayArguments {
            arguments,
            ..WayArguments::default()
        };
    }
    let mut binder = Binder::new(world, start, turns, claim);
    let found = effort::within(WAY, || {
        binder.list_candidates(objects);
        if turns.len() <= LONGEST {
            binder.descend(start);
        }
        match binder.best.take() {
            Some((_, arguments)) => (true, arguments),
            None => (false, binder.as_far_as_it_goes()),
        }
    });
    if found.exhausted {
        return WayArguments {
            exhausted: true,
            ..WayArguments::default()
        };
    }
    let (executable, arguments) = found.result;
    let assumptions = if executable {
        effort::within(OPEN, || binder.open(&arguments)).result
    } else {
        Vec::new()
    };
    WayArguments {
        arguments,
        assumptions,
        exhausted: false,
    }
}

pub(super) fn bound(world: &World, step: &DraftStep, arguments: Vec<EntityId>) -> Step {
    let mut bound = Step::explained(world, step.action, arguments);
    if !step.explanation.is_empty() {
        bound.explanation.clone_from(&step.explanation);
    }
    bound
}

/// All that the rest of a path depends on: bindings that reach equal nodes can be continued by the same arguments, and
/// then break the same claims and reach the same final state.
#[derive(PartialEq, Eq, Hash)]
struct BindingNode {
    /// Number of bound steps.
    depth: usize,
    /// Changes since the start state.
    changed: ChangedLists,
    /// For each assumption in [`Binder::assumed`] that is still to come: the fact that decides it and that an earlier step
    /// has sensed. Sensing itself leaves no trace in the state.
    sensed: Vec<Option<Fact>>,
}

struct Binder<'a> {
    domain: &'a Domain,
    world: &'a World,
    claim: Option<&'a Claim>,
    start: &'a State,
    turns: &'a [Turn],
    /// Candidate arguments of each step, the most likely first.
    candidates: Vec<Vec<Vec<EntityId>>>,
    /// The sensing steps with implicit arguments, by their place on the path.
    looks: Vec<usize>,
    /// The assumptions of the path that may depend on the arguments of `looks`, each with the place of the step that it
    /// follows, in order.
    assumed: Vec<(usize, &'a Learned)>,
    /// The visited nodes, each with the least number of broken claims before it.
    seen: FxHashMap<BindingNode, usize>,
    /// Number of visits to nodes.
    visits: usize,
    /// Maximum number of visits.
    most: usize,
    /// The best executable binding and its distance: differences from the claim plus broken rules for the final state.
    best: Option<(usize, Vec<Vec<EntityId>>)>,
    /// The longest executable partial binding.
    deepest: Vec<Vec<EntityId>>,
    chosen: Vec<Vec<EntityId>>,
    /// Number of step claims that do not hold under the current partial binding.
    broken: usize,
}

impl<'a> Binder<'a> {
    fn new(world: &'a World, start: &'a State, turns: &'a [Turn], claim: Option<&'a Claim>) -> Self {
        let domain = world.domain();
        let looks = turns.iter().enumerate().filter(|(_, turn)| turn.is_open_look(domain));
        let looks: Vec<usize> = looks.map(|(place, _)| place).collect();
        let mut assumed = Vec::new();
        for (place, turn) in turns.iter().enumerate() {
            let earlier = &looks[..looks.partition_point(|look| *look < place)];
            for learned in &turn.learned {
                let may_depend = match learned {
                    Learned::Outcome(look, _) => earlier.binary_search(look).is_ok(),
                    Learned::Fact(fact, _) => !earlier.is_empty() && domain.is_sensed(fact.predicate()),
                };
                if may_depend {
                    assumed.push((place, learned));
                }
            }
        }
        Self {
            domain,
            world,
            claim,
            start,
            turns,
            candidates: Vec::new(),
            looks,
            assumed,
            seen: FxHashMap::default(),
            visits: 0,
            most: LIMIT,
            best: None,
            deepest: Vec::new(),
            chosen: Vec::new(),
            broken: 0,
        }
    }

    fn list_candidates(&mut self, objects: &[EntityId]) {
        let (domain, world) = (self.domain, self.world);
        let mut places = claimed_places(world, self.claim, objects);
        let claims = self.turns.iter().flat_map(|turn| &turn.claims);
        for fact in claims.filter(|fact| !self.start.holds(**fact)) {
            if domain.arguments(*fact).any(|entity| objects.contains(&entity)) {
                places.extend(domain.arguments(*fact));
            }
        }
        for turn in self.turns {
            let all = candidates(world, &turn.step, objects, &places).into_iter();
            self.candidates.push(all.map(|candidate| candidate.arguments).collect());
        }
    }

    fn claimed_differences(&self, state: &State) -> Vec<Difference> {
        self.claim
            .map_or_else(Vec::new, |claim| claim.differences(self.domain, state))
    }

    fn action(&self, depth: usize) -> &Action {
        self.domain.action(self.turns[depth].step.action)
    }

    fn lacks(&self, depth: usize, state: &State, arguments: &[EntityId]) -> Vec<Missing> {
        let precondition = &self.action(depth).precondition;
        unmet(self.world, state, precondition, &mut arguments.to_vec())
    }

    /// Applies the step after those of `way`. Returns the number of its claims that do not hold, plus the number of
    /// conditions after it that were not sensed or contradict the path.
    fn advance(&self, state: &mut State, way: &[Vec<EntityId>], arguments: &[EntityId]) -> usize {
        let turn = &self.turns[way.len()];
        apply(self.world, state, self.action(way.len()), arguments);
        let mut broken = turn.claims.iter().filter(|fact| !state.holds(**fact)).count();
        for learned in &turn.learned {
            match *learned {
                Learned::Fact(fact, holds) => {
                    // A condition that was not sensed, or that is known to contradict the path, counts like a broken
                    // claim.
                    let outcomes = self.domain.outcomes(fact);
                    let as_assumed = if outcomes.is_empty() {
                        state.holds(fact) == holds
                    } else {
                        let known = outcomes.iter().any(|outcome| state.holds(*outcome));
                        known || self.is_sensed(fact, way, arguments)
                    };
                    broken += usize::from(!as_assumed);
                    learn(self.domain, state, fact, holds);
                }
                Learned::Outcome(place, first) => {
                    let arguments = way.get(place).map_or(arguments, Vec::as_slice);
                    if let Some(atom) = self.action(place).senses.first() {
                        learn(self.domain, state, ground(atom, arguments), first);
                    }
                }
            }
        }
        broken
    }

    /// Returns true if a step of the path, or the next one with these arguments, senses the fact.
    fn is_sensed(&self, fact: Fact, way: &[Vec<EntityId>], arguments: &[EntityId]) -> bool {
        let done = way.iter().map(Vec::as_slice).chain([arguments]);
        let mut steps = self.turns.iter().zip(done);
        steps.any(|(turn, arguments)| {
            let mut senses = self.domain.action(turn.step.action).senses.iter();
            senses.any(|atom| ground(atom, arguments) == fact)
        })
    }

    /// Notes a visit to the node that the chosen arguments lead to. Returns false if another binding has led there with as
    /// few broken claims, so that no binding from here on is better than those that were looked at from there.
    fn visit(&mut self, state: &State) -> bool {
        let node = BindingNode {
            depth: self.chosen.len(),
            changed: state.changed_lists(self.start),
            sensed: self.sensed(),
        };
        match self.seen.entry(node) {
            Entry::Occupied(known) if *known.get() <= self.broken => return false,
            Entry::Occupied(mut known) => {
                known.insert(self.broken);
            }
            Entry::Vacant(new) => {
                new.insert(self.broken);
            }
        }
        self.visits += 1;
        true
    }

    /// Returns, for each assumption that is still to come, the fact that decides it and that an earlier step has sensed.
    fn sensed(&self) -> Vec<Option<Fact>> {
        let depth = self.chosen.len();
        let assumed = &self.assumed[self.assumed.partition_point(|(place, _)| *place < depth)..];
        if assumed.is_empty() {
            return Vec::new();
        }
        let looks = &self.looks[..self.looks.partition_point(|look| *look < depth)];
        effort::spend(assumed.len() + looks.len());
        let sensed: FxHashSet<Fact> = looks.iter().flat_map(|look| self.outcomes(*look)).collect();
        let deciding = assumed.iter().map(|(_, learned)| match *learned {
            Learned::Outcome(look, _) if *look < depth => self.outcomes(*look).next(),
            Learned::Fact(fact, _) if sensed.contains(fact) => Some(*fact),
            Learned::Outcome(..) | Learned::Fact(..) => None,
        });
        deciding.collect()
    }

    /// Returns the possible outcomes of a sensing step with the chosen arguments.
    fn outcomes(&self, look: usize) -> impl Iterator<Item = Fact> {
        let atoms = self.action(look).senses.iter();
        atoms.map(move |atom| ground(atom, &self.chosen[look]))
    }

    fn descend(&mut self, state: &State) {
        let depth = self.chosen.len();
        let best = self.best.as_ref().map(|(distance, _)| *distance);
        // Broken claims of steps count in the final distance, so this branch cannot beat the best binding.
        let hopeless = best.is_some_and(|best| best == 0 || (self.broken > 0 && self.broken >= best));
        let stopped = self.visits >= self.most || effort::is_exhausted();
        if stopped || hopeless || !self.visit(state) {
            return;
        }
        if depth > self.deepest.len() {
            self.deepest.clone_from(&self.chosen);
        }
        if depth == self.candidates.len() {
            let claimed = self.broken + self.claimed_differences(state).len();
            if claimed == 0 {
                self.most = self.most.min(self.visits + AFTER);
            }
            let distance = claimed + broken_rules_at_end(self.world, state);
            if best.is_none_or(|best| distance < best) {
                self.best = Some((distance, self.chosen.clone()));
            }
            return;
        }
        let mut order: Vec<usize> = (0..self.candidates[depth].len()).collect();
        effort::spend(order.len());
        if !self.turns[depth].claims.is_empty() {
            // Likely candidates first, since the limit may end the search early.
            order.sort_by_cached_key(|at| self.advance(&mut state.clone(), &self.chosen, &self.candidates[depth][*at]));
        }
        for at in order {
            let arguments = self.candidates[depth][at].clone();
            if self.lacks(depth, state, &arguments).is_empty() {
                let mut next = state.clone();
                let broken = self.advance(&mut next, &self.chosen, &arguments);
                // An author does not mean an argument with which a step breaks a rule of the domain.
                if breaks_a_rule(self.world, state, &next) {
                    continue;
                }
                self.broken += broken;
                self.chosen.push(arguments);
                self.descend(&next);
                self.chosen.pop();
                self.broken -= broken;
            }
        }
    }

    /// Returns the longest executable prefix, continued greedily: each next step takes the arguments that break the
    /// fewest claims and miss the fewest preconditions.
    fn as_far_as_it_goes(&self) -> Vec<Vec<EntityId>> {
        let mut state = self.start.clone();
        let mut way: Vec<Vec<EntityId>> = Vec::new();
        for (depth, candidates) in self.candidates.iter().enumerate() {
            let best = || candidates.iter().min_by_key(|own| self.shortfall(&state, &way, own));
            let arguments = self.deepest.get(depth).or_else(best).cloned();
            let Some(arguments) = arguments else { break };
            self.advance(&mut state, &way, &arguments);
            way.push(arguments);
        }
        way
    }

    /// Returns how badly arguments fit the step after those of `way`: true if it is never applicable with them, and the numbers of
    /// broken claims and of missing preconditions.
    fn shortfall(&self, state: &State, way: &[Vec<EntityId>], arguments: &[EntityId]) -> (bool, usize, usize) {
        let missing = self.lacks(way.len(), state, arguments);
        let impossible = missing.iter().any(Missing::is_impossible);
        let broken = self.advance(&mut state.clone(), way, arguments);
        (impossible, broken, missing.len())
    }

    /// Returns the ambiguous arguments: another value would fit the claims equally well. Arguments count as ambiguous
    /// if the budget ends first.
    fn open(&self, chosen: &[Vec<EntityId>]) -> Vec<Assumption> {
        let mut open = Vec::new();
        let Some(along) = self.along(chosen) else {
            return open;
        };
        for (index, Turn { step, .. }) in self.turns.iter().enumerate() {
            let words = explanation_words(step);
            let action = self.domain.action(step.action);
            for (parameter, entity) in chosen[index].iter().enumerate() {
                let named = self.world.entity(*entity).words_in(&words) > 0;
                // The call, the explanation or the object of the plan decides such an argument.
                if step.arguments[parameter].is_some() || named || action.object == Some(parameter) {
                    continue;
                }
                effort::spend(self.candidates[index].len());
                let others = self.candidates[index].iter();
                let mut others = others.filter(|other| differ_only_in(parameter, &chosen[index], other));
                if others.any(|other| effort::is_exhausted() || self.fits_as_well(chosen, &along, index, other)) {
                    open.push(Assumption::Argument {
                        step: index,
                        parameter: action.parameters[parameter].name.clone(),
                        entity: *entity,
                    });
                }
            }
        }
        open
    }

    /// Returns the states along a binding, from the start state, each with the number of claims broken so far; none if
    /// the binding is not executable.
    fn along(&self, chosen: &[Vec<EntityId>]) -> Option<Vec<(State, usize)>> {
        let mut along = vec![(self.start.clone(), 0)];
        for (depth, arguments) in chosen.iter().enumerate() {
            let (mut state, mut broken) = along[depth].clone();
            if !self.lacks(depth, &state, arguments).is_empty() {
                return None;
            }
            broken += self.advance(&mut state, &chosen[..depth], arguments);
            along.push((state, broken));
        }
        Some(along)
    }

    /// Returns true if the plan is executable with `other` at step `index`, and no further from the claims.
    fn fits_as_well(
        &self,
        chosen: &[Vec<EntityId>],
        along: &[(State, usize)],
        index: usize,
        other: &[EntityId],
    ) -> bool {
        let depends = |learned: &Learned| self.may_depend(learned, index);
        let last_use = self.turns.iter().rposition(|turn| turn.learned.iter().any(depends));
        let mut changed = chosen[..=index].to_vec();
        changed[index] = other.to_vec();
        let (mut state, mut broken) = along[index].clone();
        // The states before the changed step are the same as before.
        for depth in index..chosen.len() {
            if depth > index {
                changed.push(chosen[depth].clone());
            }
            if !self.lacks(depth, &state, &changed[depth]).is_empty() {
                return false;
            }
            broken += self.advance(&mut state, &changed[..depth], &changed[depth]);
            // From an equal state, the rest of the plan runs equally.
            let (same, known) = &along[depth + 1];
            if state == *same && last_use.is_none_or(|last| last <= depth) {
                return broken == *known;
            }
        }
        let (end, known) = &along[chosen.len()];
        broken + self.distance(&state) == known + self.distance(end)
    }

    /// Returns true if the arguments of a step may decide whether an assumption is right.
    fn may_depend(&self, learned: &Learned, step: usize) -> bool {
        match learned {
            Learned::Outcome(place, _) => *place == step,
            Learned::Fact(fact, _) => !self.action(step).senses.is_empty() && self.domain.is_sensed(fact.predicate()),
        }
    }

    /// Returns the number of differences between a final state and the claim, plus the number of rules that it breaks.
    fn distance(&self, end: &State) -> usize {
        self.claimed_differences(end).len() + broken_rules_at_end(self.world, end)
    }
}

/// Returns true if arguments differ in this place and in no other one.
fn differ_only_in(place: usize, one: &[EntityId], other: &[EntityId]) -> bool {
    let mut pairs = one.iter().zip(other).enumerate();
    pairs.all(|(at, (one, other))| (one == other) == (at != place))
}

/// Sets a sensing outcome in the state, with its alternatives; other facts are left as simulated.
pub(super) fn learn(domain: &Domain, state: &mut State, fact: Fact, holds: bool) {
    let outcomes = domain.outcomes(fact);
    if outcomes.is_empty() {
        return;
    }
    state.set(fact, holds);
    let mut others = outcomes.into_iter().filter(|other| *other != fact);
    if holds {
        for other in others {
            state.set(other, false);
        }
    } else if !others.clone().any(|other| state.holds(other))
        && let Some(other) = others.next()
    {
        state.set(other, true);
    }
}
