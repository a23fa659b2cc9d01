//! The arguments that a plan does not show.
//!
//! `grasp_object()` names nothing: what is grasped is the plan's `object_name`, and where things go shows
//! only in the environment afterwards. The arguments are found by trying: a choice that can be executed to
//! the end and whose last state fits the claim is the one that was meant. Among choices that fit equally,
//! an entity that the step's explanation speaks of comes first; what is open even then is said.

use rustc_hash::FxHashSet;

use super::rules::{breaks_a_rule, broken_rules_at_end};
use super::{Assumption, Missing, Violation};
use super::{apply, unmet};
use crate::effort;
use crate::environment::Claim;
use crate::model::{
    Action, ChangedLists, Difference, Domain, EntityId, Fact, State, World, ground, plain_words, singular,
};
use crate::plan::claims::told;
use crate::plan::{DraftStep, Plan, Step};

/// States that are looked at before the best choice so far is taken.
const LIMIT: usize = 20_000;

/// States that are looked at for a choice that keeps the rules for the end, once one is found that ends as claimed.
const AFTER: usize = 2_000;

/// The units of work of finding the arguments of one way, and of seeing which of them could be others.
const WAY: u64 = effort::OPERATION / 3 * 2;
const OPEN: u64 = effort::OPERATION / 3;

/// Plans with more steps than this are bound step by step, by what lacks the least: each step more is a call deeper.
const LONGEST: usize = 2_000;

/// A step on a way through a plan, with what shows how it was meant.
#[derive(Debug, Clone)]
pub(super) struct Turn {
    pub(super) step: DraftStep,
    /// What it says that holds after it.
    pub(super) claims: Vec<Fact>,
    /// What the way takes to be known after it.
    pub(super) learned: Vec<Learned>,
}

/// What a way through a plan takes to be known.
#[derive(Debug, Clone)]
pub(super) enum Learned {
    /// Whether the first outcome came of the sensing step at this place of the way.
    Outcome(usize, bool),
    /// Whether a fact holds.
    Fact(Fact, bool),
}

/// Binds every open argument. A plan that cannot be executed whatever they are is bound to what lacks the least, so
/// that [`super::check`] can tell why.
///
/// # Errors
///
/// [`Violation::NothingFits`] for the first step with a hidden argument for which the environment has no entity at all;
/// [`Violation::TooMuchWork`] where looking for the arguments takes more than [`effort::OPERATION`] units.
pub fn bind(
    domain: &Domain,
    world: &World,
    steps: &[DraftStep],
    objects: &[EntityId],
    claim: Option<&Claim>,
) -> Result<(Plan, Vec<Assumption>), Violation> {
    let Bound {
        steps,
        assumptions,
        missing,
    } = bind_as_far(domain, world, steps, objects, claim);
    match missing {
        None => Ok((Plan::sequence(steps), assumptions)),
        Some(violation) => Err(violation),
    }
}

/// Steps with their arguments, as far as there are any.
pub(crate) struct Bound {
    /// The steps; those from the first one on that nothing fits are not among them.
    pub(crate) steps: Vec<Step>,
    pub(crate) assumptions: Vec<Assumption>,
    /// Why there are no more.
    pub(crate) missing: Option<Violation>,
}

/// Binds open arguments up to the first step that nothing fits.
pub(crate) fn bind_as_far(
    domain: &Domain,
    world: &World,
    steps: &[DraftStep],
    objects: &[EntityId],
    claim: Option<&Claim>,
) -> Bound {
    let turn = |step: &DraftStep| Turn {
        step: step.clone(),
        claims: Vec::new(),
        learned: Vec::new(),
    };
    let turns: Vec<Turn> = steps.iter().map(turn).collect();
    let WayArguments {
        arguments,
        assumptions,
        exhausted,
    } = bind_way(domain, world, &world.state, &turns, objects, claim);
    let missing = match steps.get(arguments.len()) {
        _ if exhausted => Some(Violation::TooMuchWork),
        Some(step) => Some(nothing_fits(domain, arguments.len(), step)),
        None => None,
    };
    let steps = steps
        .iter()
        .zip(arguments)
        .map(|(step, arguments)| bound(domain, world, step, arguments));
    Bound {
        steps: steps.collect(),
        assumptions,
        missing,
    }
}

/// The finding about a step for whose open arguments there is nothing.
pub(super) fn nothing_fits(domain: &Domain, index: usize, step: &DraftStep) -> Violation {
    let open = step.arguments.iter().position(Option::is_none);
    let parameters = &domain.action(step.action).parameters;
    Violation::NothingFits {
        step: index,
        parameter: open.map_or_else(String::new, |place| parameters[place].name.clone()),
    }
}

/// The arguments of the steps of one way through a plan.
#[derive(Debug, Default)]
pub(super) struct WayArguments {
    /// For each step; there are fewer where nothing fits a step.
    pub arguments: Vec<Vec<EntityId>>,
    /// The arguments that could be others.
    pub(super) assumptions: Vec<Assumption>,
    /// True if finding them would have taken more than the budget.
    pub(super) exhausted: bool,
}

/// Arguments for the steps of one way from a state, as far as there are any.
pub(super) fn bind_way(
    domain: &Domain,
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
    let mut binder = Binder {
        domain,
        world,
        claim,
        start,
        turns,
        candidates: Vec::new(),
        seen: FxHashSet::default(),
        most: LIMIT,
        best: None,
        deepest: Vec::new(),
        chosen: Vec::new(),
        broken: 0,
    };
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
    let assumptions = match executable {
        true => effort::within(OPEN, || binder.open(&arguments)).result,
        false => Vec::new(),
    };
    WayArguments {
        arguments,
        assumptions,
        exhausted: false,
    }
}

pub(super) fn bound(domain: &Domain, world: &World, step: &DraftStep, arguments: Vec<EntityId>) -> Step {
    let mut bound = Step::explained(domain, world, step.action, arguments);
    if !step.explanation.is_empty() {
        bound.explanation.clone_from(&step.explanation);
    }
    bound
}

/// Complete arguments for a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// One entity for each parameter.
    pub arguments: Vec<EntityId>,
    /// Whether the step's explanation speaks of something else in one of the open places.
    pub(crate) unspoken: bool,
}

/// Every choice of arguments for a step, the likeliest first: what the explanation speaks of, then what is claimed to
/// be where the objects end.
pub fn candidates(
    domain: &Domain,
    world: &World,
    step: &DraftStep,
    objects: &[EntityId],
    claimed_places: &FxHashSet<EntityId>,
) -> Vec<Candidate> {
    let action = domain.action(step.action);
    let words = spoken(step);
    let handled: FxHashSet<EntityId> = objects.iter().copied().collect();
    let mut all = vec![Candidate {
        arguments: Vec::new(),
        unspoken: false,
    }];
    for (index, parameter) in action.parameters.iter().enumerate() {
        let open = world.of_kind(parameter.kind);
        let fitting: Vec<(EntityId, bool)> = match step.arguments[index] {
            Some(entity) => vec![(entity, false)],
            None if action.object == Some(index) && !objects.is_empty() => {
                let named = |object: &EntityId| world.entity(*object).words_in(&words);
                let fits = objects
                    .iter()
                    .filter(|object| world.is_of_kind(**object, parameter.kind));
                let mut handled: Vec<(EntityId, usize)> = fits.map(|object| (*object, named(object))).collect();
                effort::spend(handled.len() * (1 + words.len()));
                // Of several, the one that the sentence speaks of comes first; a place may be named after another.
                handled.sort_by_key(|(_, named)| std::cmp::Reverse(*named));
                let best = handled.first().map_or(0, |(_, named)| *named);
                handled
                    .into_iter()
                    .map(|(object, named)| (object, named < best))
                    .collect()
            }
            None => {
                // The object that is handled is named in every sentence, and is not its own place.
                let is_handled = |entity: &EntityId| action.object.is_some() && handled.contains(entity);
                let mentioned = |entity: EntityId| match is_handled(&entity) {
                    true => 0,
                    false => world.entity(entity).words_in(&words),
                };
                effort::spend(open.len() * (1 + words.len()));
                let mut ranked: Vec<(EntityId, usize)> = open.iter().map(|e| (*e, mentioned(*e))).collect();
                ranked.sort_by_key(|(entity, mentioned)| {
                    let itself = is_handled(entity);
                    (
                        itself,
                        std::cmp::Reverse(*mentioned),
                        !claimed_places.contains(entity),
                        *entity,
                    )
                });
                let best = ranked.iter().map(|(_, mentioned)| *mentioned).max().unwrap_or(0);
                ranked.into_iter().map(|(e, mentioned)| (e, mentioned < best)).collect()
            }
        };
        let longer = |candidate: &Candidate| {
            fitting
                .iter()
                .map(|(entity, unspoken)| Candidate {
                    arguments: [&candidate.arguments[..], &[*entity]].concat(),
                    unspoken: candidate.unspoken || *unspoken,
                })
                .collect::<Vec<_>>()
        };
        // Every choice of arguments is kept until the plan is bound.
        if !effort::spend(2 * effort::KEPT * all.len().saturating_mul(fitting.len())) {
            return Vec::new();
        }
        all = all.iter().flat_map(longer).collect();
    }
    all
}

/// Entities that newly claimed facts about the objects speak of.
pub(crate) fn claimed_places(
    domain: &Domain,
    world: &World,
    claim: Option<&Claim>,
    objects: &[EntityId],
) -> FxHashSet<EntityId> {
    let mut places = FxHashSet::default();
    for fact in claim.map_or_else(Vec::new, |claim| claim.promises(domain, world)) {
        if domain.arguments(fact).any(|entity| objects.contains(&entity)) {
            places.extend(domain.arguments(fact));
        }
    }
    places
}

struct Binder<'a> {
    domain: &'a Domain,
    world: &'a World,
    claim: Option<&'a Claim>,
    start: &'a State,
    turns: &'a [Turn],
    /// For each step, complete arguments, the likeliest first.
    candidates: Vec<Vec<Vec<EntityId>>>,
    /// Where a choice has been followed from: before which step, and what is changed there since the start.
    seen: FxHashSet<(usize, ChangedLists)>,
    /// States that are looked at.
    most: usize,
    /// The choice that can be executed and differs least from what is claimed and what the rules want at the end.
    best: Option<(usize, Vec<Vec<EntityId>>)>,
    /// The longest choice that can be executed.
    deepest: Vec<Vec<EntityId>>,
    chosen: Vec<Vec<EntityId>>,
    /// How many claims of single steps do not hold under the choice so far.
    broken: usize,
}

impl Binder<'_> {
    fn list_candidates(&mut self, objects: &[EntityId]) {
        let (domain, world) = (self.domain, self.world);
        let mut places = claimed_places(domain, world, self.claim, objects);
        let claims = self.turns.iter().flat_map(|turn| &turn.claims);
        for fact in claims.filter(|fact| !self.start.holds(**fact)) {
            if domain.arguments(*fact).any(|entity| objects.contains(&entity)) {
                places.extend(domain.arguments(*fact));
            }
        }
        let complete = |turn: &Turn| {
            let all = candidates(domain, world, &turn.step, objects, &places).into_iter();
            all.map(|candidate| candidate.arguments).collect()
        };
        self.candidates = self.turns.iter().map(complete).collect();
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

    /// Does the step behind those of `way`; returns how many of its claims do not hold then, and how many of the conditions
    /// behind it nothing has sensed or come out otherwise than on this way.
    fn advance(&self, state: &mut State, way: &[Vec<EntityId>], arguments: &[EntityId]) -> usize {
        let turn = &self.turns[way.len()];
        apply(self.world, state, self.action(way.len()), arguments);
        let mut broken = turn.claims.iter().filter(|fact| !state.holds(**fact)).count();
        for learned in &turn.learned {
            match *learned {
                Learned::Fact(fact, holds) => {
                    // A condition that nothing has sensed, or that is known to come out otherwise than on this way, speaks
                    // against the choice as a broken claim does.
                    let outcomes = self.domain.outcomes(fact);
                    let as_assumed = match outcomes.is_empty() {
                        true => state.holds(fact) == holds,
                        false => {
                            let known = outcomes.iter().any(|outcome| state.holds(*outcome));
                            known || self.is_sensed(fact, way, arguments)
                        }
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

    /// Returns whether a step of the way, or the one behind it with these arguments, tells whether the fact holds.
    fn is_sensed(&self, fact: Fact, way: &[Vec<EntityId>], arguments: &[EntityId]) -> bool {
        let done = way.iter().map(Vec::as_slice).chain([arguments]);
        let mut steps = self.turns.iter().zip(done);
        steps.any(|(turn, arguments)| {
            let mut senses = self.domain.action(turn.step.action).senses.iter();
            senses.any(|atom| ground(atom, arguments) == fact)
        })
    }

    fn descend(&mut self, state: &State) {
        let depth = self.chosen.len();
        let best = self.best.as_ref().map(|(distance, _)| *distance);
        let hopeless = best.is_some_and(|best| best == 0 || (self.broken > 0 && self.broken >= best));
        let stopped = self.seen.len() >= self.most || effort::is_exhausted();
        if stopped || hopeless || !self.seen.insert((depth, state.changed_lists(self.start))) {
            return;
        }
        if depth > self.deepest.len() {
            self.deepest.clone_from(&self.chosen);
        }
        if depth == self.candidates.len() {
            let claimed = self.broken + self.claimed_differences(state).len();
            if claimed == 0 {
                self.most = self.most.min(self.seen.len() + AFTER);
            }
            let distance = claimed + broken_rules_at_end(self.domain, self.world, state);
            if best.is_none_or(|best| distance < best) {
                self.best = Some((distance, self.chosen.clone()));
            }
            return;
        }
        let mut order: Vec<usize> = (0..self.candidates[depth].len()).collect();
        effort::spend(order.len());
        if !self.turns[depth].claims.is_empty() {
            order.sort_by_cached_key(|at| self.advance(&mut state.clone(), &self.chosen, &self.candidates[depth][*at]));
        }
        for at in order {
            let arguments = self.candidates[depth][at].clone();
            if self.lacks(depth, state, &arguments).is_empty() {
                let mut next = state.clone();
                let broken = self.advance(&mut next, &self.chosen, &arguments);
                if breaks_a_rule(self.domain, self.world, state, &next) {
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

    /// The longest executable beginning; from there on, at each step what breaks the fewest claims and lacks the fewest
    /// facts.
    fn as_far_as_it_goes(&self) -> Vec<Vec<EntityId>> {
        let mut state = self.start.clone();
        let mut way: Vec<Vec<EntityId>> = Vec::new();
        for (depth, candidates) in self.candidates.iter().enumerate() {
            let arguments = self.deepest.get(depth).cloned().or_else(|| {
                let lacking = |arguments: &&Vec<EntityId>| {
                    let missing = self.lacks(depth, &state, arguments);
                    let impossible = missing.iter().any(|m| m.fact.is_none());
                    let broken = self.advance(&mut state.clone(), &way, arguments);
                    (impossible, broken, missing.len())
                };
                candidates.iter().min_by_key(lacking).cloned()
            });
            let Some(arguments) = arguments else { break };
            self.advance(&mut state, &way, &arguments);
            way.push(arguments);
        }
        way
    }

    /// Arguments that could be others without any difference that the plan shows; where the budget does not suffice to
    /// find out, they could.
    fn open(&self, chosen: &[Vec<EntityId>]) -> Vec<Assumption> {
        let mut open = Vec::new();
        let Some(along) = self.along(chosen) else {
            return open;
        };
        for (index, Turn { step, .. }) in self.turns.iter().enumerate() {
            let words = spoken(step);
            let action = self.domain.action(step.action);
            for (parameter, entity) in chosen[index].iter().enumerate() {
                let named = self.world.entity(*entity).words_in(&words) > 0;
                if step.arguments[parameter].is_some() || named || action.object == Some(parameter) {
                    continue;
                }
                effort::spend(self.candidates[index].len());
                let mut others = self.candidates[index].iter().filter(|other| {
                    let differs =
                        |(at, entity): (usize, &EntityId)| (*entity != chosen[index][at]) == (at == parameter);
                    other.iter().enumerate().all(differs)
                });
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

    /// The states along a choice, the first state first, each with the claims that are broken so far; none if it cannot
    /// be executed.
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

    /// Returns whether the plan can be executed with `other` at one step, and is as far from what is claimed.
    fn fits_as_well(
        &self,
        chosen: &[Vec<EntityId>],
        along: &[(State, usize)],
        index: usize,
        other: &[EntityId],
    ) -> bool {
        let outcome_of_it = |learned: &Learned| matches!(learned, Learned::Outcome(place, _) if *place == index);
        let last_use = self
            .turns
            .iter()
            .rposition(|turn| turn.learned.iter().any(outcome_of_it));
        let mut changed = chosen[..=index].to_vec();
        changed[index] = other.to_vec();
        let (mut state, mut broken) = along[index].clone();
        for depth in index..chosen.len() {
            if depth > index {
                changed.push(chosen[depth].clone());
            }
            if !self.lacks(depth, &state, &changed[depth]).is_empty() {
                return false;
            }
            broken += self.advance(&mut state, &changed[..depth], &changed[depth]);
            // Where both come to the same state, the rest of the plan is the same.
            let (same, known) = &along[depth + 1];
            if state == *same && last_use.is_none_or(|last| last <= depth) {
                return broken == *known;
            }
        }
        let differences =
            |state: &State| self.claimed_differences(state).len() + broken_rules_at_end(self.domain, self.world, state);
        let (end, known) = &along[chosen.len()];
        broken + differences(&state) == known + differences(end)
    }
}

/// What a step's explanation speaks of, word by word.
fn spoken(step: &DraftStep) -> Vec<String> {
    let sentence = told(&step.explanation).sentence;
    plain_words(sentence).iter().map(|word| singular(word)).collect()
}

/// Takes a fact to hold, or not, where sensing tells it; what else is so shows without.
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
