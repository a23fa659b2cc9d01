//! Everyday names for entities, and sentences for facts.

use indexmap::IndexMap;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Domain, Entity, EntityId, Fact, World, base_name, head, plain_words, singular, with_article};

/// Returns for every identifier a unique everyday name and all its names, synonyms included.
///
/// A name comes from the environment file, else from the domain's lexicon, else from the cleaned identifier. Entities
/// of one kind are numbered in order (plate 1, plate 2). Entities of different kinds that share a name take their
/// longer one (kitchen table, coffee table).
pub(crate) fn name_entities(
    domain: &Domain,
    identifiers: &[&str],
    given: Option<&IndexMap<String, String>>,
) -> Vec<(String, Vec<String>)> {
    let mut choices: Vec<Vec<String>> = Vec::with_capacity(identifiers.len());
    for identifier in identifiers {
        let mut names = domain.lexicon.names(identifier);
        if let Some(name) = given.and_then(|given| given.get(*identifier)) {
            names.retain(|other| other != name);
            names.insert(0, name.clone());
        }
        choices.push(names);
    }
    // By displayed name: the kinds of entities that have this name.
    let mut kinds: FxHashMap<&str, FxHashSet<String>> = FxHashMap::default();
    for (identifier, names) in identifiers.iter().zip(&choices) {
        kinds.entry(&names[0]).or_default().insert(base_name(identifier));
    }
    let longer_where_needed = |names: &Vec<String>| {
        let clash = kinds[names[0].as_str()].len() > 1 && names.len() > 1;
        names[usize::from(clash)].clone()
    };
    let shown: Vec<String> = choices.iter().map(longer_where_needed).collect();
    let mut counts: FxHashMap<&str, usize> = FxHashMap::default();
    for name in &shown {
        *counts.entry(name).or_default() += 1;
    }
    // An entity of its own may already have the name "table 2".
    let mut taken: FxHashSet<String> = shown.iter().cloned().collect();
    let mut next: FxHashMap<&str, usize> = FxHashMap::default();
    let mut unique = Vec::with_capacity(shown.len());
    for name in &shown {
        if counts[name.as_str()] == 1 {
            unique.push(name.clone());
            continue;
        }
        let number = next.entry(name).or_default();
        let free = loop {
            *number += 1;
            let candidate = format!("{name} {number}");
            if taken.insert(candidate.clone()) {
                break candidate;
            }
        };
        unique.push(free);
    }
    unique.into_iter().zip(choices).collect()
}

/// The reader of a sentence, which decides how it names entities.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Voice {
    /// A person, who reads everyday names: "the fridge".
    Person,
    /// A model, which reads and writes the environment's identifiers: `<fridge_306>`.
    Model,
}

impl Voice {
    /// Returns the name of an entity for this reader.
    pub fn name(self, world: &World, entity: EntityId) -> String {
        let entity = world.entity(entity);
        match self {
            Self::Person => with_article(&entity.name),
            Self::Model => entity.identifier.clone(),
        }
    }

    /// Writes a fact, or its negation, as a sentence for this reader.
    pub fn fact(self, world: &World, fact: Fact, holds: bool) -> String {
        let words = world.domain().words(fact.predicate());
        let template = if holds { &words.says } else { &words.denies };
        template.fill(|place| self.name(world, fact.argument(place)))
    }
}

/// Writes a fact, or its negation, as a sentence for a person.
pub fn fact_text(world: &World, fact: Fact, holds: bool) -> String {
    Voice::Person.fact(world, fact, holds)
}

impl Entity {
    /// Returns the everyday name with its article.
    pub fn with_article(&self) -> String {
        with_article(&self.name)
    }

    /// Returns the largest number of words of one of its names that occur in `words`, which are singular and in lower
    /// case. A name counts only if its head noun occurs: "kitchen" does not mention the kitchen table.
    pub fn words_in(&self, words: &[String]) -> usize {
        self.words_where(&|word| words.iter().any(|other| other == word))
    }

    /// Like [`words_in`](Self::words_in), with a predicate in place of the list of words.
    pub fn words_where(&self, occurs: &dyn Fn(&str) -> bool) -> usize {
        let fit = |name: &String| {
            if !occurs(&head(name)) {
                return 0;
            }
            let parts = plain_words(name).into_iter().map(|part| singular(&part));
            parts.filter(|part| occurs(part)).count()
        };
        self.names.iter().map(fit).max().unwrap_or(0)
    }
}
