//! The notation of facts in an environment.

use super::{Domain, EntityId, Fact, PredicateId, StateWord, Term};

/// Returns the state word of a predicate; none for a predicate that environments do not write.
pub fn state_word(domain: &Domain, predicate: PredicateId) -> Option<&StateWord> {
    domain.states.iter().find(|word| word.atom.predicate == predicate)
}

/// Writes a fact in the notation of an environment; `name` gives the name of each entity.
pub fn written_fact(domain: &Domain, fact: Fact, name: &dyn Fn(EntityId) -> String) -> String {
    let word = state_word(domain, fact.predicate());
    // Predicates without a state word keep their PDDL name.
    let word = word.map_or_else(|| &domain.predicate(fact.predicate()).name, |word| &word.word);
    let arguments: Vec<String> = domain.arguments(fact).map(name).collect();
    format!("{word}({})", arguments.join(", "))
}

/// Returns the entity under which an environment lists the fact.
pub fn subject_of(domain: &Domain, fact: Fact) -> EntityId {
    let place = state_word(domain, fact.predicate())
        .and_then(|word| word.atom.terms.iter().position(|term| *term == Term::Variable(0)));
    fact.argument(place.unwrap_or(0))
}
