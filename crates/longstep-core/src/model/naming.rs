//! Everyday names for entities, and sentences for facts.

use indexmap::IndexMap;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Domain, Entity, EntityId, Fact, World, base_name, head, plain_words, singular, with_article};

/// The everyday name of every identifier, unique, with all the names that it may be called by.
///
/// A name comes from the environment file, else from the domain's lexicon, else it is the identifier,
/// cleaned. Things of one kind are numbered in their order (plate 1, plate 2); things of different
/// kinds that share a name take their longer one (kitchen table, coffee table).
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
    // By shown name: the kinds of things that are called so.
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
    // "table 2" may be taken by a thing that is called so.
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

/// How things are called, depending on who is told.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Voice {
    /// For a person: "the fridge".
    Person,
    /// For a model, which reads and writes the environment's identifiers: `<fridge_306>`.
    Model,
}

impl Voice {
    /// The entity in this voice.
    pub fn name(self, world: &World, entity: EntityId) -> String {
        let entity = world.entity(entity);
        match self {
            Self::Person => with_article(&entity.name),
            Self::Model => entity.identifier.clone(),
        }
    }

    /// A fact, or its opposite, as a sentence.
    pub fn fact(self, domain: &Domain, world: &World, fact: Fact, holds: bool) -> String {
        let words = domain.words(fact.predicate());
        let template = if holds { &words.says } else { &words.denies };
        template.fill(|place| self.name(world, fact.argument(place)))
    }
}

/// A fact, or its opposite, as a sentence for a person.
pub fn fact_text(domain: &Domain, world: &World, fact: Fact, holds: bool) -> String {
    Voice::Person.fact(domain, world, fact, holds)
}

impl Entity {
    /// The name with its article.
    pub fn with_article(&self) -> String {
        with_article(&self.name)
    }

    /// How many words of its best fitting name stand among `words`, which are singular and in lower case.
    /// A name counts only if its head does: "kitchen" is not a mention of the kitchen table.
    pub fn words_in(&self, words: &[String]) -> usize {
        self.words_said(&|word| words.iter().any(|said| said == word))
    }

    /// The same for words that a set has.
    pub fn words_said(&self, is_said: &dyn Fn(&str) -> bool) -> usize {
        let fit = |name: &String| {
            if !is_said(&head(name)) {
                return 0;
            }
            let parts = plain_words(name).into_iter().map(|part| singular(&part));
            parts.filter(|part| is_said(part)).count()
        };
        self.names.iter().map(fit).max().unwrap_or(0)
    }
}
