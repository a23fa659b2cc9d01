//! Everyday names for entities, and sentences for facts.

use indexmap::IndexMap;
use rustc_hash::{FxHashMap, FxHashSet};

use super::{Domain, Entity, EntityId, Fact, World, base_name, head, plain_words, singular, with_article};

/// Returns for every identifier a unique everyday name and all its names, synonyms included.
///
/// A name comes from the environment file, else from the domain's lexicon, else from the cleaned identifier. Entities of
/// one kind keep the numbers of their identifiers (`<pallet_2>` is pallet 2), so a number never means another entity than
/// the one that carries it. Numbers that only identify, as in a simulator's graph ([`are_serial`]), say nothing to a
/// person: then entities are numbered in order (plate 1, plate 2), as are those without a number. Entities of different
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
    // The domain's constants, which are the first entities, have no numbers of the environment.
    let serial = are_serial(identifiers.get(domain.constants.len()..).unwrap_or_default());
    let numbered = |(identifier, name): (&&str, &String)| match counts[name.as_str()] {
        1 => Some(name.clone()),
        _ if serial => None,
        _ => {
            let own = format!("{name} {}", number_of(identifier)?);
            taken.insert(own.clone()).then_some(own)
        }
    };
    let kept: Vec<Option<String>> = identifiers.iter().zip(&shown).map(numbered).collect();
    let mut next: FxHashMap<&str, usize> = FxHashMap::default();
    let mut unique = Vec::with_capacity(shown.len());
    for (name, kept) in shown.iter().zip(kept) {
        if let Some(kept) = kept {
            unique.push(kept);
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

/// Minimum number of kinds of entities for their numbers to be serial.
const KINDS: usize = 4;

/// Returns true if the numbers of identifiers are serial numbers of the environment and no labels: every identifier has
/// one, no two are equal, and there are several kinds. Labels begin anew for each kind (`<pallet_1>`, `<dock_1>`).
fn are_serial(identifiers: &[&str]) -> bool {
    let mut seen = FxHashSet::default();
    let kinds: FxHashSet<String> = identifiers.iter().map(|identifier| base_name(identifier)).collect();
    kinds.len() >= KINDS
        && identifiers
            .iter()
            .all(|identifier| number_of(identifier).is_some_and(|number| seen.insert(number)))
}

/// Returns the number at the end of an identifier, after an underscore.
fn number_of(identifier: &str) -> Option<&str> {
    let bare = identifier.trim_start_matches('<').trim_end_matches('>');
    let (_, number) = bare.rsplit_once('_')?;
    let digits = !number.is_empty() && number.bytes().all(|byte| byte.is_ascii_digit());
    digits.then_some(number)
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
            Self::Person => entity.with_article(),
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
    /// Returns the everyday name with its article, which a value does not take.
    pub fn with_article(&self) -> String {
        if self.is_value {
            return self.name.clone();
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_names(identifiers: &[&str], expected: &[&str]) {
        let household = crate::domain::shipped("household").unwrap().unwrap();
        let names = name_entities(&household, identifiers, None);
        let names: Vec<String> = names.into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, expected, "{identifiers:?}");
    }

    #[test]
    fn numbers_that_label_are_kept_and_those_that_identify_are_not() {
        check_names(
            &["<pallet_2>", "<pallet_3>", "<pallet_4>"],
            &["pallet 2", "pallet 3", "pallet 4"],
        );
        check_names(
            &["<pallet_3>", "<pallet_1>", "<dock>"],
            &["pallet 3", "pallet 1", "dock"],
        );
        check_names(&["<bay_01>", "<bay_02>", "<hook_1>"], &["bay 01", "bay 02", "hook"]);
        // What has no number takes one that nothing carries.
        check_names(
            &["<table>", "<table_1>", "<table_3>"],
            &["table 2", "table 1", "table 3"],
        );
        // A simulator's graph.
        let graph = ["<plate_274>", "<plate_278>", "<sink_11>", "<fridge_306>", "<table_7>"];
        check_names(&graph, &["plate 1", "plate 2", "sink", "fridge", "table"]);
        // Labels begin anew for each kind.
        let labelled = ["<cup_5>", "<cup_7>", "<sink_1>", "<shelf_1>", "<table_2>"];
        check_names(&labelled, &["cup 5", "cup 7", "sink", "shelf", "table"]);
    }
}
