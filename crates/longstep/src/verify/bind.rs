//! The arguments that a plan does not show.
//!
//! `grasp_object()` names nothing: what is grasped is the plan's `object_name`, and where things go shows
//! only in the environment afterwards. The arguments are found by trying: a choice that can be executed to
//! the end and whose last state fits the claim is the one that was meant. Among choices that fit equally,
//! an entity that the step's explanation speaks of comes first; what is open even then is said.

use rustc_hash::FxHashSet;

use super::simulate::{apply, unmet};
use super::violation::Assumption;
use crate::domain::{Domain, plain_words, singular};
use crate::plan::{DraftStep, Plan, Step};
use crate::world::{Claim, Difference, EntityId, State, World};

/// States that are looked at before the best choice so far is taken.
const LIMIT: usize = 20_000;

/// Plans with more steps than this are bound step by step, by what lacks the least: each step more is a call deeper.
const LONGEST: usize = 2_000;

/// Binds every open argument. A plan that cannot be executed whatever they are is bound as far as it goes,
/// so that [`super::check`] can tell why.
pub fn bind(
    domain: &Domain,
    world: &World,
    steps: &[DraftStep],
    objects: &[EntityId],
    claim: Option<&Claim>,
) -> (Plan, Vec<Assumption>) {
    if steps.iter().all(|step| step.arguments.iter().all(Option::is_some)) {
        let plan = steps
            .iter()
            .map(|step| bound(domain, world, step, step.arguments.iter().flatten().copied().collect()));
        return (plan.collect(), Vec::new());
    }
    let mut binder = Binder {
        domain,
        world,
        claim,
        candidates: Vec::new(),
        seen: FxHashSet::default(),
        best: None,
        deepest: Vec::new(),
        chosen: Vec::new(),
    };
    let places = claimed_places(domain, world, claim, objects);
    let complete = |step: &DraftStep| {
        let all = candidates(domain, world, step, objects, &places).into_iter();
        all.map(|candidate| (step.action, candidate.arguments)).collect()
    };
    binder.candidates = steps.iter().map(complete).collect();
    if steps.len() <= LONGEST {
        binder.descend(&world.state);
    }
    let Some((_, arguments)) = binder.best.take() else {
        let plan = binder.as_far_as_it_goes(steps);
        return (plan, Vec::new());
    };
    let assumptions = binder.open(steps, &arguments);
    let steps = steps
        .iter()
        .zip(arguments)
        .map(|(step, arguments)| bound(domain, world, step, arguments));
    (steps.collect(), assumptions)
}

fn bound(domain: &Domain, world: &World, step: &DraftStep, arguments: Vec<EntityId>) -> Step {
    let mut bound = Step::explained(domain, world, step.action, arguments);
    if !step.explanation.is_empty() {
        bound.explanation.clone_from(&step.explanation);
    }
    bound
}

/// Complete arguments for a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Candidate {
    pub(crate) arguments: Vec<EntityId>,
    /// Whether the step's explanation speaks of something else in one of the open places.
    pub(crate) unspoken: bool,
}

/// Every choice of arguments for a step, the likeliest first: what the explanation speaks of, then what is claimed to
/// be where the objects end.
pub(crate) fn candidates(
    domain: &Domain,
    world: &World,
    step: &DraftStep,
    objects: &[EntityId],
    claimed_places: &FxHashSet<EntityId>,
) -> Vec<Candidate> {
    let action = domain.action(step.action);
    let words: Vec<String> = plain_words(&step.explanation)
        .iter()
        .map(|word| singular(word))
        .collect();
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
                let mut handled: Vec<EntityId> = objects.iter().copied().filter(|o| open.contains(o)).collect();
                // Of several, the one that the sentence speaks of comes first; a place may be named after another.
                handled.sort_by_key(|object| std::cmp::Reverse(named(object)));
                let best = handled.first().map_or(0, named);
                handled
                    .into_iter()
                    .map(|object| (object, named(&object) < best))
                    .collect()
            }
            None => {
                let mentioned = |entity: EntityId| match action.object.is_some() && objects.contains(&entity) {
                    // The thing that is handled is named in every sentence, and is not its own place.
                    true => 0,
                    false => world.entity(entity).words_in(&words),
                };
                let mut ranked: Vec<(EntityId, usize)> = open.iter().map(|e| (*e, mentioned(*e))).collect();
                ranked.sort_by_key(|(entity, mentioned)| {
                    let itself = action.object.is_some() && objects.contains(entity);
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
    /// For each step, complete arguments, the likeliest first.
    candidates: Vec<Vec<(crate::domain::ActionId, Vec<EntityId>)>>,
    seen: FxHashSet<(usize, State)>,
    /// The choice that can be executed and differs least from the claim.
    best: Option<(usize, Vec<Vec<EntityId>>)>,
    /// The longest choice that can be executed.
    deepest: Vec<Vec<EntityId>>,
    chosen: Vec<Vec<EntityId>>,
}

impl Binder<'_> {
    fn claimed_differences(&self, state: &State) -> Vec<Difference> {
        self.claim
            .map_or_else(Vec::new, |claim| claim.differences(self.domain, state))
    }

    fn descend(&mut self, state: &State) {
        let depth = self.chosen.len();
        if self.seen.len() >= LIMIT || matches!(self.best, Some((0, _))) || !self.seen.insert((depth, state.clone())) {
            return;
        }
        if depth > self.deepest.len() {
            self.deepest.clone_from(&self.chosen);
        }
        if depth == self.candidates.len() {
            let distance = self.claimed_differences(state).len();
            if self.best.as_ref().is_none_or(|(best, _)| distance < *best) {
                self.best = Some((distance, self.chosen.clone()));
            }
            return;
        }
        for at in 0..self.candidates[depth].len() {
            let (action, mut arguments) = self.candidates[depth][at].clone();
            let action = self.domain.action(action);
            if unmet(self.world, state, &action.precondition, &mut arguments).is_empty() {
                let mut next = state.clone();
                apply(self.world, &mut next, action, &arguments);
                self.chosen.push(arguments);
                self.descend(&next);
                self.chosen.pop();
            }
        }
    }

    /// The longest executable beginning; from there on, at each step what lacks the fewest facts.
    fn as_far_as_it_goes(&self, steps: &[DraftStep]) -> Plan {
        let mut state = self.world.state.clone();
        let mut plan = Vec::new();
        for (index, step) in steps.iter().enumerate() {
            let action = self.domain.action(step.action);
            let arguments = self.deepest.get(index).cloned().or_else(|| {
                let lacking = |(_, arguments): &&(_, Vec<EntityId>)| {
                    let missing = unmet(self.world, &state, &action.precondition, &mut arguments.clone());
                    (missing.iter().any(|m| m.fact.is_none()), missing.len())
                };
                self.candidates[index]
                    .iter()
                    .min_by_key(lacking)
                    .map(|(_, arguments)| arguments.clone())
            });
            let Some(arguments) = arguments else { break };
            apply(self.world, &mut state, action, &arguments);
            plan.push(bound(self.domain, self.world, step, arguments));
        }
        Plan::sequence(plan)
    }

    /// Arguments that could be others without any difference that the plan shows.
    fn open(&self, steps: &[DraftStep], chosen: &[Vec<EntityId>]) -> Vec<Assumption> {
        let mut open = Vec::new();
        let best = self.distance(chosen).unwrap_or(usize::MAX);
        for (index, step) in steps.iter().enumerate() {
            let words: Vec<String> = plain_words(&step.explanation)
                .iter()
                .map(|word| singular(word))
                .collect();
            let action = self.domain.action(step.action);
            for (parameter, entity) in chosen[index].iter().enumerate() {
                let named = self.world.entity(*entity).words_in(&words) > 0;
                if step.arguments[parameter].is_some() || named || action.object == Some(parameter) {
                    continue;
                }
                let others = self.candidates[index]
                    .iter()
                    .map(|(_, arguments)| arguments)
                    .filter(|other| {
                        other[parameter] != *entity
                            && other
                                .iter()
                                .enumerate()
                                .all(|(i, e)| i == parameter || *e == chosen[index][i])
                    });
                let fits = |other: &Vec<EntityId>| {
                    let mut changed = chosen.to_vec();
                    changed[index].clone_from(other);
                    self.distance(&changed) == Some(best)
                };
                if others.into_iter().any(fits) {
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

    /// How far the last state is from the claim; none if the choice cannot be executed.
    fn distance(&self, chosen: &[Vec<EntityId>]) -> Option<usize> {
        let mut state = self.world.state.clone();
        for (candidates, arguments) in self.candidates.iter().zip(chosen) {
            let action = self.domain.action(candidates.first()?.0);
            if !unmet(self.world, &state, &action.precondition, &mut arguments.clone()).is_empty() {
                return None;
            }
            apply(self.world, &mut state, action, arguments);
        }
        Some(self.claimed_differences(&state).len())
    }
}
