//! Everyday names for entities, and sentences for facts.

use indexmap::IndexMap;

use super::{Entity, EntityId, Fact, World};
use crate::domain::{Domain, base_name, head, plain_words, singular, with_article};

/// The everyday name of every identifier, unique, with all the names that it may be called by.
///
/// A name comes from the environment file, else from the domain's lexicon, else it is the identifier,
/// cleaned. Things of one kind are numbered in their order (plate 1, plate 2); things of different
/// kinds that share a name take their longer one (kitchen table, coffee table).
pub(super) fn name_entities(
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
    let mut shown: Vec<String> = choices.iter().map(|names| names[0].clone()).collect();
    for index in 0..shown.len() {
        let base = base_name(identifiers[index]);
        let clash = (0..shown.len())
            .any(|other| choices[other][0] == choices[index][0] && base_name(identifiers[other]) != base);
        if clash && choices[index].len() > 1 {
            shown[index] = choices[index][1].clone();
        }
    }
    let counts = shown.iter().fold(IndexMap::<&str, usize>::new(), |mut counts, name| {
        *counts.entry(name).or_default() += 1;
        counts
    });
    let mut seen: IndexMap<&str, usize> = IndexMap::new();
    let mut unique = Vec::with_capacity(shown.len());
    for name in &shown {
        let number = seen.entry(name).or_default();
        *number += 1;
        if counts[name.as_str()] == 1 {
            unique.push(name.clone());
            continue;
        }
        // "table 2" may be taken by a thing that is called so.
        let free = (*number..)
            .map(|n| format!("{name} {n}"))
            .find(|candidate| !shown.contains(candidate) && !unique.contains(candidate));
        unique.extend(free);
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
        let fit = |name: &String| {
            if !words.contains(&head(name)) {
                return 0;
            }
            let parts: Vec<String> = plain_words(name).iter().map(|part| singular(part)).collect();
            parts.iter().filter(|part| words.contains(part)).count()
        };
        self.names.iter().map(fit).max().unwrap_or(0)
    }
}
