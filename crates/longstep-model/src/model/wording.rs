//! The notation of facts in an environment.

use super::{Domain, EntityId, Fact, Fluent, Number, PredicateId, StateWord, Term, World};
use crate::call::Call;

impl StateWord {
    /// Returns the position in the atom of each argument of the word, the entity of the entry first.
    pub fn places(&self) -> impl Iterator<Item = Option<usize>> {
        let place = |slot| self.atom.terms.iter().position(|term| *term == Term::Variable(slot));
        (0..=self.parameters.len()).map(place)
    }
}

/// Returns every state word of a predicate.
fn state_words(domain: &Domain, predicate: PredicateId) -> impl Iterator<Item = &StateWord> {
    let words = domain.states.iter();
    words.filter(move |word| word.atom.predicate == predicate)
}

/// Returns the first state word of a predicate; none for a predicate that environments do not write.
pub fn state_word(domain: &Domain, predicate: PredicateId) -> Option<&StateWord> {
    state_words(domain, predicate).next()
}

/// Returns every notation of a fact, with the entity under which an environment lists it.
pub fn entries_of(world: &World, fact: Fact) -> impl Iterator<Item = (EntityId, String)> {
    state_words(world.domain(), fact.predicate()).map(move |word| {
        let mut entities = word.places().map(|place| place.map(|place| fact.argument(place)));
        let subject = entities.next().flatten().unwrap_or(fact.argument(0));
        let call = Call {
            name: word.word.clone(),
            arguments: entities
                .flatten()
                .map(|id| world.entity(id).identifier.clone())
                .collect(),
        };
        (subject, call.to_string())
    })
}

/// Writes a fact in the notation of an environment; `name` gives the name of each entity.
pub fn written_fact(domain: &Domain, fact: Fact, name: &dyn Fn(EntityId) -> String) -> String {
    let word = state_word(domain, fact.predicate());
    // Predicates without a state word keep their PDDL name.
    let word = word.map_or_else(|| &domain.predicate(fact.predicate()).name, |word| &word.word);
    let arguments: Vec<String> = domain.arguments(fact).map(name).collect();
    format!("{word}({})", arguments.join(", "))
}

/// Returns the notation of a number, with the entity under which an environment lists it; none for a statement without
/// a subject.
pub fn entry_of_number(world: &World, fluent: Fluent, number: Number) -> (Option<EntityId>, String) {
    let mut arguments = world.domain().arguments_of(fluent);
    let subject = arguments.next();
    let others = arguments.map(|other| world.entity(other).identifier.clone());
    let call = Call {
        name: world.domain().function(fluent.function()).word.clone(),
        arguments: others.chain([number.to_string()]).collect(),
    };
    (subject, call.to_string())
}

/// Returns the entity under which an environment lists the fact.
pub fn subject_of(domain: &Domain, fact: Fact) -> EntityId {
    let place = state_word(domain, fact.predicate()).and_then(|word| word.places().next()?);
    fact.argument(place.unwrap_or(0))
}
