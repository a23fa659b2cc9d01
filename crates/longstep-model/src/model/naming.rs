//! Everyday names for entities, and sentences for facts.

use std::borrow::Cow;

use indexmap::IndexMap;
use rustc_hash::{FxHashMap, FxHashSet};

use super::label::{label, stem};
use super::{
    Arithmetic, Difference, Domain, Entity, EntityId, Fact, Fluent, GroundExpression, GroundTest, Missing, Number,
    NumberTest, Shortfall, World, head, plain_words, singular,
};

/// Returns for every identifier a unique everyday name and all its names, synonyms included.
///
/// A name comes from the environment file, else from the domain's lexicon, else from the cleaned identifier. A name that
/// the environment gives to one entity is no name of any other. Entities of one kind keep the labels of their
/// identifiers (`<pallet_2>` is pallet 2, `<tube_A>` is tube A), so a number never means another entity than the one that
/// carries it. Numbers that only identify, as in a simulator's graph ([`are_serial`]), say nothing to a person: then
/// entities are numbered in order (plate 1, plate 2), as are those without a label. Entities of different kinds that
/// share a name take their longer one (kitchen table, coffee table), unless the environment gave it to them.
pub(crate) fn name_entities(
    domain: &Domain,
    identifiers: &[&str],
    given: Option<&IndexMap<String, String>>,
) -> Vec<(String, Vec<String>)> {
    let given_to = |identifier: &str| given.and_then(|given| given.get(identifier));
    let given_names = given.into_iter().flat_map(IndexMap::values);
    // By given name: the number of entities that have it.
    let mut reserved: FxHashMap<String, usize> = FxHashMap::default();
    for name in given_names {
        *reserved.entry(name.to_lowercase()).or_default() += 1;
    }
    let mut choices: Vec<Vec<String>> = Vec::with_capacity(identifiers.len());
    for identifier in identifiers {
        let mut names = domain.lexicon.names(identifier);
        names.retain(|name| !reserved.contains_key(&name.to_lowercase()));
        names.splice(0..0, given_to(identifier).cloned());
        choices.push(names);
    }
    // By displayed name: the kinds of entities that have this name.
    let mut kinds: FxHashMap<&str, FxHashSet<String>> = FxHashMap::default();
    for (identifier, names) in identifiers.iter().zip(&choices) {
        if let Some(name) = names.first() {
            kinds.entry(name).or_default().insert(stem(identifier));
        }
    }
    let displayed = |(identifier, names): (&&str, &Vec<String>)| match (given_to(identifier), &names[..]) {
        (Some(name), _) => name.clone(),
        (None, [name, longer, ..]) if kinds[name.as_str()].len() > 1 => longer.clone(),
        (None, [name, ..]) => name.clone(),
        // Other entities were given every name of this one, which therefore needs a number.
        (None, []) => domain.lexicon.names(identifier).swap_remove(0),
    };
    let shown: Vec<String> = identifiers.iter().zip(&choices).map(displayed).collect();
    let mut counts: FxHashMap<&str, usize> = FxHashMap::default();
    for name in &shown {
        *counts.entry(name).or_default() += 1;
    }
    // An entity of its own may already have the name "table 2".
    let mut taken: FxHashSet<String> = shown.iter().map(|name| name.to_lowercase()).collect();
    // The domain's constants, which are the first entities, have no numbers of the environment.
    let serial = are_serial(identifiers.get(domain.constants.len()..).unwrap_or_default());
    let labelled = |(identifier, name): (&&str, &String)| {
        let is_alone = match given_to(identifier) {
            Some(_) => reserved.get(&name.to_lowercase()) == Some(&1),
            None => !reserved.contains_key(&name.to_lowercase()) && counts[name.as_str()] == 1,
        };
        if is_alone {
            return Some(name.clone());
        }
        let label = label(identifier);
        if serial || label.is_empty() {
            return None;
        }
        let own = format!("{name} {label}");
        taken.insert(own.to_lowercase()).then_some(own)
    };
    let kept: Vec<Option<String>> = identifiers.iter().zip(&shown).map(labelled).collect();
    let mut next: FxHashMap<&str, usize> = FxHashMap::default();
    let mut named = Vec::with_capacity(shown.len());
    for ((name, kept), mut names) in shown.iter().zip(kept).zip(choices) {
        let unique = kept.unwrap_or_else(|| {
            let number = next.entry(name).or_default();
            loop {
                *number += 1;
                let candidate = format!("{name} {number}");
                if taken.insert(candidate.to_lowercase()) {
                    break candidate;
                }
            }
        });
        if names.is_empty() {
            names.push(unique.clone());
        }
        named.push((unique, names));
    }
    named
}

/// Minimum number of kinds of entities for their numbers to be serial.
const KINDS: usize = 4;

/// Returns true if the numbers of identifiers are serial numbers of the environment and no labels: every identifier has
/// one, no two are equal, and there are several kinds. Labels begin anew for each kind (`<pallet_1>`, `<dock_1>`).
fn are_serial(identifiers: &[&str]) -> bool {
    let mut seen = FxHashSet::default();
    let kinds: FxHashSet<String> = identifiers.iter().map(|identifier| stem(identifier)).collect();
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
        match self {
            Self::Person => world.with_article(entity),
            Self::Model => world.entity(entity).identifier.clone(),
        }
    }

    /// Writes a fact, or its negation, as a sentence for this reader.
    pub fn fact(self, world: &World, fact: Fact, holds: bool) -> String {
        let words = world.domain().words(fact.predicate());
        let template = if holds { &words.says } else { &words.denies };
        template.fill(|place| self.name(world, fact.argument(place)))
    }

    /// Writes the name of a number for this reader: `the level of the tank`.
    pub fn fluent(self, world: &World, fluent: Fluent) -> String {
        let says = &world.domain().function(fluent.function()).says;
        says.fill(|place| self.name(world, fluent.argument(place)))
    }

    /// Writes a number with the unit of its function.
    pub fn number(self, world: &World, fluent: Fluent, number: Number) -> String {
        match &world.domain().function(fluent.function()).unit {
            Some(unit) => format!("{number} {unit}"),
            None => number.to_string(),
        }
    }

    /// Writes a requirement on numbers as a sentence for this reader.
    pub fn requirement(self, world: &World, test: &GroundTest) -> String {
        let written = |expression: &GroundExpression| expression.written(&|fluent| self.fluent(world, *fluent));
        match test {
            NumberTest::Compare(Arithmetic::Value(fluent), comparison, Arithmetic::Constant(number)) => {
                let number = self.number(world, *fluent, *number);
                format!("{} {comparison} {number}", self.fluent(world, *fluent))
            }
            NumberTest::Compare(left, comparison, right) => {
                format!("{} {comparison} {}", written(left), written(right))
            }
            NumberTest::Known(expression, true) => format!("{} is known", written(expression)),
            NumberTest::Known(expression, false) => format!("{} is not known", written(expression)),
        }
    }

    /// Writes what a state lacks for a requirement on numbers, with the numbers that it has.
    pub fn shortfall(self, world: &World, shortfall: &Shortfall) -> String {
        let number = |(fluent, number): &(Fluent, Option<Number>)| {
            let name = self.fluent(world, *fluent);
            match number {
                Some(number) if shortfall.numbers.len() == 1 => {
                    format!("it is {}", self.number(world, *fluent, *number))
                }
                Some(number) => format!("{name} is {}", self.number(world, *fluent, *number)),
                None => format!("{name} is not known"),
            }
        };
        let numbers: Vec<String> = shortfall.numbers.iter().map(number).collect();
        let requirement = self.requirement(world, &shortfall.test);
        if numbers.is_empty() {
            requirement
        } else {
            format!("{requirement} ({})", numbers.join(", "))
        }
    }
}

impl Missing {
    /// Writes the missing precondition for a person; none if nothing could satisfy it.
    pub fn text(&self, world: &World) -> Option<String> {
        match &self.number {
            Some(shortfall) => Some(Voice::Person.shortfall(world, shortfall)),
            None => self.fact.map(|fact| fact_text(world, fact, self.holds)),
        }
    }
}

/// Writes the name of a number for a person.
pub fn fluent_text(world: &World, fluent: Fluent) -> String {
    Voice::Person.fluent(world, fluent)
}

/// Writes a difference between two states as a sentence for a person.
pub fn change_text(world: &World, difference: Difference) -> String {
    let sentence = fact_text(world, difference.fact, difference.now_holds);
    if difference.now_holds {
        sentence
    } else {
        format!("{sentence} any more")
    }
}

/// Writes a fact, or its negation, as a sentence for a person.
pub fn fact_text(world: &World, fact: Fact, holds: bool) -> String {
    Voice::Person.fact(world, fact, holds)
}

impl Entity {
    /// Iterates over everything that the entity is called: its everyday name, its names, and its names with the number or label of the
    /// everyday name ("room 102" is "habitación 102", too).
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<trash_bin_1>", "<trash_bin_2>"], "objects": ["<cup>"]}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let bin = world.entity(world.find("<trash_bin_2>").unwrap());
    /// assert_eq!(bin.name, "trash bin 2");
    /// assert!(bin.called().any(|name| name == "trash can 2"));
    /// ```
    pub fn called(&self) -> impl Iterator<Item = Cow<'_, str>> {
        let label = self.names.iter().find_map(|name| self.name.strip_prefix(name.as_str()));
        let label = label.filter(|label| label.starts_with(' '));
        let with_label = label.into_iter().flat_map(|label| {
            let names = self.names.iter().map(move |name| format!("{name}{label}"));
            names.filter(|name| *name != self.name).map(Cow::Owned)
        });
        let plain = std::iter::once(&self.name).chain(&self.names);
        plain.map(|name| Cow::Borrowed(name.as_str())).chain(with_label)
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
    use crate::testing;

    #[track_caller]
    fn check_names(identifiers: &[&str], expected: &[&str]) {
        let household = testing::domain("household");
        check_given(&household, identifiers, &[], expected);
    }

    #[track_caller]
    fn check_given(domain: &Domain, identifiers: &[&str], given: &[(&str, &str)], expected: &[&str]) {
        let given = given.iter().map(|(id, name)| ((*id).to_owned(), (*name).to_owned()));
        let names = name_entities(domain, identifiers, Some(&given.collect()));
        let names: Vec<String> = names.into_iter().map(|(name, _)| name).collect();
        assert_eq!(names, expected, "{identifiers:?}");
    }

    #[test]
    fn labels_of_any_kind_are_kept() {
        check_names(&["<tube_A>", "<tube_B>"], &["tube A", "tube B"]);
        check_names(&["<tube.1>", "<Tube.2>"], &["tube 1", "tube 2"]);
        check_names(&["<table2>", "<table3>"], &["table 2", "table 3"]);
        check_names(&["<杯子_1>", "<杯子_3>"], &["杯子 1", "杯子 3"]);
        check_names(&["<Bay.3-A>", "<Bay.3-B>"], &["bay 3 A", "bay 3 B"]);
    }

    #[test]
    fn a_given_name_is_shown_and_means_no_other_entity() {
        let household = testing::domain("household");
        let check = |identifiers: &[&str], given: &[(&str, &str)], expected: &[&str]| {
            check_given(&household, identifiers, given, expected);
        };
        check(&["<x>", "<cup_7>"], &[("<x>", "cup")], &["cup", "cup 7"]);
        check(&["<x>", "<Cup>"], &[("<x>", "cup")], &["cup", "cup 1"]);
        let crates = [("<p_x>", "crate"), ("<q_y>", "crate")];
        check(&["<p_x>", "<q_y>"], &crates, &["crate x", "crate y"]);
        let crates = [("<ab>", "crate"), ("<cd>", "crate")];
        check(&["<ab>", "<cd>"], &crates, &["crate 1", "crate 2"]);
        let pallet = [("<pallet_1>", "pallet 2")];
        check(&["<pallet_1>", "<pallet_2>"], &pallet, &["pallet 2", "pallet"]);
        let given = [("<x>".to_owned(), "cup".to_owned())].into_iter().collect();
        let names = name_entities(&household, &["<x>", "<cup_7>"], Some(&given));
        assert_eq!(names[1].1, ["cup 7"]);
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
