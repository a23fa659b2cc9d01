//! What a repaired plan must come to.

use rustc_hash::FxHashSet;

use crate::model::{Domain, EntityId, Fact, State, World, differences, subject_of};
use crate::plan::Resolved;
use crate::search::Wanted;
use crate::verify::{Purpose, broken_at_end, can_be_brought_about, hides_places, places_claimed, wanted_at_end};

/// What must hold at the end, and what should.
pub(super) struct Meant {
    /// What is wanted and what the rules ask: must.
    pub(super) required: Vec<Wanted>,
    /// What the draft says will have come about, in order: should.
    pub(super) promises: Vec<Promise>,
    /// What the draft says will be as before, in order: should, with less weight.
    pub(super) kept: Vec<Fact>,
    /// What it says will have come about, and nothing here can come near.
    pub(super) impossible: Vec<Fact>,
}

impl Meant {
    /// Everything that promises speak of.
    pub(super) fn promised(&self) -> impl Iterator<Item = &Fact> {
        let promises = self.promises.iter();
        promises.flat_map(|promise| [&promise.fact].into_iter().chain(&promise.related))
    }
}

/// A fact that a draft says will have come about.
pub(super) struct Promise {
    pub(super) fact: Fact,
    /// Other relations between the same things: what is said to be in the sink may lie on it.
    pub(super) related: Vec<Fact>,
}

/// Takes for what is meant what the draft claims, and what it would do if every step worked where the claim is silent.
///
/// A claim that the draft's own steps contradict is stale and counts for nothing. What is said to stay as it was
/// counts only of things that are not said to change in that respect: where they are (a relation), or how they are (a
/// property).
pub(super) fn meant(domain: &Domain, world: &World, draft: &Resolved, purpose: &Purpose, as_if: &State) -> Meant {
    let done: Vec<Fact> = differences(domain, &world.state, as_if)
        .into_iter()
        .filter(|difference| difference.now_holds)
        .map(|difference| difference.fact)
        .collect();
    let (claimed, stays) = match &purpose.claim {
        Some(claim) => {
            let mut claimed = claim.promises(domain, world);
            let mut steps = draft.steps.iter().flatten();
            if steps.any(|step| hides_places(domain, step.action)) {
                claimed.extend(places_claimed(domain, world, claim, &draft.objects));
            }
            (claimed, claim.kept(domain, world))
        }
        None => {
            // Nobody says that things stay where they are.
            let property = |fact: &Fact| !domain.is_relation(*fact);
            let before = differences(domain, &State::default(), &world.state).into_iter();
            let properties = before.map(|difference| difference.fact).filter(property);
            (done.clone(), properties.collect())
        }
    };
    // What is said of a thing in one respect.
    let respect = |fact: &Fact| (subject_of(domain, *fact), domain.is_relation(*fact));
    // Where the claim says how a thing ends, or takes the opposite for granted, the draft's own steps say nothing more.
    let mut spoken_of: FxHashSet<EntityId> = claimed.iter().map(|fact| subject_of(domain, *fact)).collect();
    let contradicted = stays.iter().filter(|fact| !as_if.holds(**fact));
    spoken_of.extend(contradicted.map(|fact| subject_of(domain, *fact)));
    let unclaimed = done
        .iter()
        .filter(|fact| !spoken_of.contains(&subject_of(domain, **fact)));
    let possible = |fact: &Fact| can_be_brought_about(domain, world, *fact);
    // What a rule forbids at the end nobody promises: a hand that was left full is an oversight.
    let broken = |state: &State| {
        broken_at_end(domain, world, state, purpose)
            .filter(|broken| broken.binds)
            .count()
    };
    let breaks = broken(as_if);
    let forbidden = |fact: &Fact| {
        let mut without = as_if.clone();
        without.set(*fact, false);
        breaks > 0 && broken(&without) < breaks
    };
    let unclaimed = unclaimed.filter(|fact| possible(fact) && !forbidden(fact));
    let mut promises = Vec::new();
    let mut impossible = Vec::new();
    for fact in claimed.iter().chain(unclaimed).copied() {
        let near = others(domain, world, fact);
        // A relation that nothing can bring about is meant as another one only if the draft relates the two at all.
        if possible(&fact) || as_if.holds(fact) || near.iter().any(|other| as_if.holds(*other)) {
            let related = near.into_iter().filter(possible).collect();
            promises.push(Promise { fact, related });
        } else if purpose.claim.is_some() {
            impossible.push(fact);
        }
    }
    let changed: FxHashSet<(EntityId, bool)> = promises.iter().map(|promise| respect(&promise.fact)).collect();
    let kept = stays
        .into_iter()
        .filter(|fact| as_if.holds(*fact) && !changed.contains(&respect(fact)))
        .collect();
    let mut required = purpose.wanted.clone();
    required.extend(wanted_at_end(domain, &purpose.waivers, purpose.from_goal));
    Meant {
        required,
        promises,
        kept,
        impossible,
    }
}

/// The other relations that an environment can tell between the things of a fact.
fn others(domain: &Domain, world: &World, fact: Fact) -> Vec<Fact> {
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
