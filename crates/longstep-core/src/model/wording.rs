//! The words with which a domain says a fact.

use super::{Domain, EntityId, Fact, PredicateId, StateWord, Term};

/// The word with which an environment says a fact.
pub fn state_word(domain: &Domain, predicate: PredicateId) -> Option<&StateWord> {
    domain.states.iter().find(|word| word.atom.predicate == predicate)
}

/// A fact as an environment says it, with `name` called for each entity.
pub fn written_fact(domain: &Domain, fact: Fact, name: &dyn Fn(EntityId) -> String) -> String {
    let word = state_word(domain, fact.predicate());
    // What no environment says is called by its own name.
    let word = word.map_or_else(|| &domain.predicate(fact.predicate()).name, |word| &word.word);
    let arguments: Vec<String> = domain.arguments(fact).map(name).collect();
    format!("{word}({})", arguments.join(", "))
}

/// The entity in whose entry a fact is written.
pub fn subject_of(domain: &Domain, fact: Fact) -> EntityId {
    let place = state_word(domain, fact.predicate())
        .and_then(|word| word.atom.terms.iter().position(|term| *term == Term::Variable(0)));
    fact.argument(place.unwrap_or(0))
}
