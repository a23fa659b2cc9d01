//! Counts the descriptions from which a model makes the whole environment (docs/guide/seeing.md has the figures).
//!
//!     cargo run --release --manifest-path lab/programs/Cargo.toml --features embedded --bin descriptions -- development
//!
//! The argument names a file of `lab/programs/data/descriptions`: `descriptions` and `development` are for development, `held` is held-out.
//! [`open_model`] names the settings.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;
use std::error::Error;

use longstep::Planner;
use longstep::perception::{SightDialogue, SightInput, Sighting, View};
use longstep_lab::{mark, open_model};
use longstep_llm::{Progress, converse};
use serde::Deserialize;

const FILES: [(&str, &str); 3] = [
    (
        "descriptions",
        include_str!("../../data/descriptions/descriptions.toml"),
    ),
    ("development", include_str!("../../data/descriptions/development.toml")),
    ("held", include_str!("../../data/descriptions/held.toml")),
];

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct File {
    description: Vec<Description>,
}

/// A description and its environment. Entries are `NAME: STATE STATE`.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Description {
    #[serde(default)]
    language: String,
    text: String,
    assets: Vec<String>,
    objects: Vec<String>,
    #[serde(default)]
    either: Vec<String>,
    #[serde(default)]
    also: BTreeMap<String, Vec<String>>,
}

/// An entity for comparison: its list (none if it may be in either), its name without a number, and its states, sorted.
type Entity = (Option<&'static str>, String, Vec<String>);

impl Description {
    /// Returns the name that the description has for an entity.
    fn name(&self, text: &str) -> String {
        let bare = text.trim_matches(['<', '>']);
        let without_number = bare
            .trim_end_matches(|c: char| c.is_ascii_digit())
            .trim_end_matches('_');
        let own =
            |(_, others): &(&String, &Vec<String>)| others.iter().any(|other| other == bare || other == without_number);
        match self.also.iter().find(own) {
            Some((name, _)) => name.clone(),
            None => without_number.to_owned(),
        }
    }

    fn entity(&self, list: &'static str, name: &str, states: impl Iterator<Item = String>) -> Entity {
        let name = self.name(name);
        let mut states: Vec<String> = states
            .map(|state| match state.split_once('(') {
                Some((word, rest)) => {
                    let arguments = rest.trim_end_matches(')').split(", ").filter(|own| !own.is_empty());
                    let arguments: Vec<String> = arguments.map(|argument| self.name(argument)).collect();
                    format!("{word}({})", arguments.join(", "))
                }
                None => state,
            })
            .collect();
        states.sort();
        ((!self.either.contains(&name)).then_some(list), name, states)
    }

    fn expected(&self) -> Vec<Entity> {
        let lists = [("assets", &self.assets), ("objects", &self.objects)];
        let all = lists
            .into_iter()
            .flat_map(|(list, entries)| entries.iter().map(move |entry| (list, entry)));
        let mut entities: Vec<Entity> = all
            .map(|(list, entry)| {
                let (name, states) = entry.split_once(": ").unwrap_or((entry, ""));
                self.entity(list, name, states.split_whitespace().map(str::to_owned))
            })
            .collect();
        mirror(&mut entities);
        entities.sort();
        entities
    }

    fn found(&self, view: &View) -> Vec<Entity> {
        let environment = &view.environment;
        let lists = [
            ("assets", &environment.assets, &environment.asset_states),
            ("objects", &environment.objects, &environment.object_states),
        ];
        let mut entities = Vec::new();
        for (list, names, states) in lists {
            for name in names {
                let own = states.get(name).map_or(&[][..], |words| words.as_slice());
                entities.push(self.entity(list, name, own.iter().cloned()));
            }
        }
        mirror(&mut entities);
        // What may be in either list may also be left out, if nothing is said of it.
        let known = |name: &String| {
            self.assets
                .iter()
                .chain(&self.objects)
                .any(|own| self.name(own.split(':').next().unwrap_or_default()) == *name)
        };
        entities.retain(|(_, name, states)| !(states.is_empty() && self.either.contains(name) && !known(name)));
        entities.sort();
        entities
    }
}

/// States of neighbours hold both ways, whichever of them the description begins with.
fn mirror(entities: &mut [Entity]) {
    let pairs: Vec<(String, String)> = entities
        .iter()
        .flat_map(|(_, name, states)| states.iter().map(move |state| (name.clone(), state.clone())))
        .filter_map(|(name, state)| {
            let other = state.strip_prefix("next_to(")?.trim_end_matches(')').to_owned();
            Some((other, format!("next_to({name})")))
        })
        .collect();
    for (_, name, states) in entities {
        states.extend(
            pairs
                .iter()
                .filter(|(own, _)| own == name)
                .map(|(_, state)| state.clone()),
        );
        states.sort();
        states.dedup();
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let name = std::env::args().nth(1).unwrap_or_default();
    let file = FILES.iter().find(|(own, _)| *own == name);
    let (_, text) = file.ok_or("usage: descriptions development|descriptions|held")?;
    let file: File = toml::from_str(text)?;
    let planner = Planner::shipped("household")?;
    let domain = planner.domain();
    let mut model = open_model()?;
    let (mut right, mut contradictory) = (0, 0);
    for description in &file.description {
        let input = SightInput {
            domain,
            words: &description.text,
            pictures: &[],
            kind: model.constraint_kind(),
        };
        let sighting: Sighting = converse(&mut *model, &mut SightDialogue::new(&input), &mut |_: Progress| {})?;
        let view = View::of(domain, &sighting);
        let (found, expected) = (description.found(&view), description.expected());
        let is_right = found == expected;
        right += usize::from(is_right);
        contradictory += usize::from(view.world.is_err());
        println!("{} {} {}", mark(is_right), description.language, description.text);
        if !is_right {
            let sentences = view.sentences(domain).join("; ");
            println!("      found    {found:?}\n      expected {expected:?}\n      shown    {sentences}");
        }
        if let Err(findings) = &view.world {
            println!("      contradictory, which is shown: {findings}");
        }
    }
    let count = file.description.len();
    println!("{right} of {count} right, {contradictory} shown as contradictory");
    Ok(())
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used, clippy::panic)]

    use super::*;

    /// The expected environments are environments of the domain.
    #[test]
    fn every_expectation_is_an_environment_of_the_domain() {
        let planner = Planner::shipped("household").unwrap();
        for (_, text) in FILES {
            let file: File = toml::from_str(text).unwrap();
            for description in &file.description {
                let mut counts: BTreeMap<String, usize> = BTreeMap::new();
                let mut written =
                    serde_json::json!({"assets": [], "objects": [], "asset_states": {}, "object_states": {}});
                for (list, states, entries) in [
                    ("assets", "asset_states", &description.assets),
                    ("objects", "object_states", &description.objects),
                ] {
                    for entry in entries {
                        let (name, own) = entry.split_once(": ").unwrap_or((entry, ""));
                        let count = counts.entry(name.to_owned()).or_default();
                        *count += 1;
                        let name = if *count == 1 {
                            name.to_owned()
                        } else {
                            format!("{name}_{count}")
                        };
                        written[list].as_array_mut().unwrap().push(name.clone().into());
                        let own: Vec<&str> = own.split_whitespace().collect();
                        written[states][name] = own.into();
                    }
                }
                planner
                    .world(&written.to_string())
                    .unwrap_or_else(|error| panic!("{}: {error}", description.text));
            }
            assert!(file.description.len() >= 10);
        }
    }
}
