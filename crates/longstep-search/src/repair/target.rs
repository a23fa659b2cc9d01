//! Target state of a repair.

use rustc_hash::FxHashSet;

use crate::search::Wanted;
use longstep_model::model::{EntityId, Fact, State, World, broken_bindings, differences, subject_of};
use longstep_verify::plan::Resolved;
use longstep_verify::verify::{Milestone, Purpose, broken_at_end, can_be_brought_about, hides_places, places_claimed};

/// Hard and soft constraints on the final state.
pub(super) struct Meant {
    /// Hard: the goals and the rules.
    pub(super) required: Vec<Wanted>,
    /// Hard: the conditions to achieve in order.
    pub(super) stages: Vec<Vec<Milestone>>,
    /// Soft: changes that the draft claims or, where it claims none, would achieve.
    pub(super) promises: Vec<Promise>,
    /// Soft, at a lower cost: facts that the draft claims to be unchanged.
    pub(super) kept: Vec<Fact>,
    /// Claimed changes that cannot be achieved even approximately.
    pub(super) impossible: Vec<Fact>,
}

impl Meant {
    /// All facts in the promises, including related ones.
    pub(super) fn promised(&self) -> impl Iterator<Item = &Fact> {
        let promises = self.promises.iter();
        promises.flat_map(|promise| [&promise.fact].into_iter().chain(&promise.related))
    }
}

/// A change that the draft claims.
pub(super) struct Promise {
    pub(super) fact: Fact,
    /// Other relations between the same entities: an object that is claimed to be in the sink may lie on it.
    pub(super) related: Vec<Fact>,
}

/// Derives the target from the claims of the draft; where the claims are silent, from the effects of its steps.
///
/// A claim that the draft's own steps contradict is outdated and ignored. Unchanged facts count only for entities
/// without a claimed change in the same aspect: place (relations) or condition (properties).
pub(super) fn meant(world: &World, draft: &Resolved, purpose: &Purpose, as_if: &State) -> Meant {
    let domain = world.domain();
    let done: Vec<Fact> = differences(domain, &world.state, as_if)
        .into_iter()
        .filter(|difference| difference.now_holds)
        .map(|difference| difference.fact)
        .collect();
    let (claimed, stays) = match &purpose.claim {
        Some(claim) => {
            let mut claimed = claim.promises(world);
            let mut steps = draft.steps.iter().flatten();
            if steps.any(|step| hides_places(domain, step.action)) {
                claimed.extend(places_claimed(world, claim, &draft.objects));
            }
            (claimed, claim.kept(world))
        }
        None => {
            // Without a claim, nothing states that objects keep their places.
            let property = |fact: &Fact| !domain.is_relation(*fact);
            let before = differences(domain, &State::default(), &world.state).into_iter();
            let properties = before.map(|difference| difference.fact).filter(property);
            (done.clone(), properties.collect())
        }
    };
    // The entity and the aspect of a fact.
    let respect = |fact: &Fact| (subject_of(domain, *fact), domain.is_relation(*fact));
    // If the claim covers an entity's final state, or is outdated for it, the effects of the draft's steps are ignored.
    let mut stated: FxHashSet<EntityId> = claimed.iter().map(|fact| subject_of(domain, *fact)).collect();
    let contradicted = stays.iter().filter(|fact| !as_if.holds(**fact));
    stated.extend(contradicted.map(|fact| subject_of(domain, *fact)));
    let unclaimed = done.iter().filter(|fact| !stated.contains(&subject_of(domain, **fact)));
    let possible = |fact: &Fact| can_be_brought_about(world, *fact);
    // A fact that violates a rule in the final state is not promised: a hand that still holds an object is an
    // oversight.
    let broken = |state: &State| broken_at_end(world, state, purpose).filter(|own| own.binds).count();
    let breaks = broken(as_if);
    let forbidden = |fact: &Fact| breaks > 0 && broken(&with_fact(as_if, *fact, false)) < breaks;
    let unclaimed = unclaimed.filter(|fact| possible(fact) && !forbidden(fact));
    let mut promises = Vec::new();
    let mut impossible = Vec::new();
    for fact in claimed.iter().chain(unclaimed).copied() {
        let near = others(world, fact);
        // An unachievable relation is replaced by another one only if the draft relates the two entities at all.
        if possible(&fact) || as_if.holds(fact) || near.iter().any(|other| as_if.holds(*other)) {
            let related = near.into_iter().filter(possible).collect();
            promises.push(Promise { fact, related });
        } else if purpose.claim.is_some() {
            impossible.push(fact);
        }
    }
    // What only a person's prohibition prevents is not given up silently: then there is no repair.
    let forbidden = claimed.iter().filter(|fact| is_forbidden(world, as_if, **fact));
    let required = purpose.at_end(domain).into_iter();
    let required = required.chain(forbidden.map(|fact| Wanted::of_fact(domain, *fact)));
    let changed: FxHashSet<(EntityId, bool)> = promises.iter().map(|promise| respect(&promise.fact)).collect();
    let kept = stays
        .into_iter()
        .filter(|fact| as_if.holds(*fact) && !changed.contains(&respect(fact)))
        .collect();
    Meant {
        required: required.collect(),
        stages: purpose.stages.clone(),
        promises,
        kept,
        impossible,
    }
}

/// Returns true if the prohibitions in force prevent a fact that some action could achieve.
fn is_forbidden(world: &World, as_if: &State, fact: Fact) -> bool {
    if world.prohibitions().is_empty() || world.state.holds(fact) {
        return false;
    }
    let mut free = world.clone();
    free.set_prohibitions([]);
    let breaks = |holds: bool| broken_prohibitions(world, &with_fact(as_if, fact, holds));
    can_be_brought_about(&free, fact) && (!can_be_brought_about(world, fact) || breaks(true) > breaks(false))
}

fn with_fact(state: &State, fact: Fact, holds: bool) -> State {
    let mut state = state.clone();
    state.set(fact, holds);
    state
}

/// Counts the instances of prohibitions that a state breaks.
fn broken_prohibitions(world: &World, state: &State) -> usize {
    let rules = world.always_rules();
    let prohibitions = rules.filter(|(number, _)| world.prohibition(*number).is_some());
    prohibitions
        .map(|(_, rule)| broken_bindings(rule, world, state).len())
        .sum()
}

/// Returns the other relations that an environment can express between the arguments of a fact.
fn others(world: &World, fact: Fact) -> Vec<Fact> {
    let domain = world.domain();
    let arguments: Vec<EntityId> = domain.arguments(fact).collect();
    let mut others: Vec<Fact> = Vec::new();
    for word in domain.states.iter().filter(|_| domain.is_relation(fact)) {
        let predicate = word.atom.predicate;
        let parameters = &domain.predicate(predicate).parameters;
        let fits = parameters.len() == arguments.len()
            && parameters
                .iter()
                .zip(&arguments)
                .all(|(parameter, entity)| world.is_of_kind(*entity, parameter.kind));
        let other = Fact::new(predicate, arguments.iter().copied());
        if fits && other != fact && !others.contains(&other) {
            others.push(other);
        }
    }
    others
}
