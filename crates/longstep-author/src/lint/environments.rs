//! Lints about a domain together with an environment: names that derivations miss, and entities without a use.

use super::{Finding, Lint};
use longstep::domain::{Action, Condition, Derivation, Files, StateWord, Term, matches_name, stem};
use longstep_core::diagnostic::{Diagnostic, nearest};
use longstep_core::environment::{EntityId, World};
use longstep_core::json::{self, Path};

/// An environment file.
struct EnvironmentFile<'a> {
    name: &'a str,
    text: &'a str,
}

impl EnvironmentFile<'_> {
    fn finding(&self, lint: Lint, world: &World, entity: EntityId, message: String, hint: &str) -> Finding {
        let identifier = &world.entity(entity).identifier;
        let environment = world.environment();
        let listed = [("assets", &environment.assets), ("objects", &environment.objects)];
        let at = |list: &[String]| list.iter().position(|other| other == identifier);
        let path = listed
            .iter()
            .find_map(|(key, list)| Some(Path::key(key).index(at(list)?)));
        let wrapped = path.as_ref().map(|path| Path::key("environment").join(path));
        let position = path
            .into_iter()
            .chain(wrapped)
            .find_map(|path| json::locate(self.text, &path));
        let diagnostic = Diagnostic::whole(self.name, message).hint(hint).with_position(position);
        Finding {
            lint,
            of: vec![identifier.clone()],
            diagnostic,
        }
    }
}

/// Lints a domain with an environment; `file` and `text` are the source of the environment. The findings that the domain
/// accepts are left out.
pub fn lint_environment(world: &World, files: &Files, file: &str, text: &str) -> Vec<Finding> {
    let source = EnvironmentFile { name: file, text };
    let mut findings = idle_entities(world, &source);
    findings.extend(near_misses(world, &source));
    findings.extend(idle_derivations(world, files));
    findings.extend(unused_states(world, files));
    findings.extend(super::synonyms::unmatched_in(world, files));
    super::without_accepted_of(findings, files)
}

/// Finds entities that no parameter of an action admits, by its type and its static conditions.
fn idle_entities(world: &World, source: &EnvironmentFile<'_>) -> Vec<Finding> {
    let domain = world.domain();
    let is_idle = |entity: &EntityId| {
        let mut actions = domain.actions.iter();
        !actions.any(|action| (0..action.parameters.len()).any(|place| admits(world, action, place, *entity)))
    };
    let listed = world.entities().skip(domain.constants.len());
    let idle = listed.map(|(id, _)| id).filter(is_idle);
    let found = idle.map(|entity| {
        let message = format!("no action admits `{}`", world.entity(entity).identifier);
        let hint =
            "give it the properties that actions need, or another type; `longstep domain show --env` lists its facts";
        source.finding(Lint::IdleEntity, world, entity, message, hint)
    });
    found.collect()
}

/// Returns true if the type and the static conditions on the parameter alone admit the entity.
fn admits(world: &World, action: &Action, place: usize, entity: EntityId) -> bool {
    let domain = world.domain();
    let is_met = |condition: &Condition| match condition {
        Condition::Atom { atom, holds, .. } => {
            let alone = atom.terms.len() == 1 && atom.terms[0] == Term::Variable(place);
            let is_static = !domain.words(atom.predicate).fluent;
            let fact = longstep_core::environment::Fact::new(atom.predicate, [entity]);
            !alone || !is_static || world.state.holds(fact) == *holds
        }
        _ => true,
    };
    world.is_of_kind(entity, action.parameters[place].kind) && action.precondition.conjuncts().all(is_met)
}

fn names(derivation: &Derivation) -> impl Iterator<Item = &str> {
    derivation
        .names
        .iter()
        .chain(&derivation.other_names)
        .map(String::as_str)
}

/// Finds entities that no derivation matches by name, although a name of one nearly does.
fn near_misses(world: &World, source: &EnvironmentFile<'_>) -> Vec<Finding> {
    let domain = world.domain();
    let known: Vec<&str> = domain.derivations.iter().flat_map(names).collect();
    let listed = world.entities().skip(domain.constants.len());
    let found = listed.filter_map(|(id, entity)| {
        if known.iter().any(|name| matches_name(&entity.identifier, name)) {
            return None;
        }
        let stem = stem(&entity.identifier);
        let words: Vec<&str> = stem
            .split(|c: char| !c.is_alphanumeric())
            .filter(|word| !word.is_empty())
            .collect();
        let within = words.iter().find_map(|word| known.iter().find(|name| *name == word));
        let near = words.last().filter(|word| word.chars().count() > 3);
        let near = within.copied().or_else(|| nearest(near?, known.iter().copied()))?;
        let message = format!(
            "`{}` almost matches the name `{near}` of a derivation",
            entity.identifier
        );
        let hint = "write the name at the end of the identifier if the derivation is meant for it";
        Some(source.finding(Lint::NearMiss, world, id, message, hint))
    });
    found.collect()
}

fn in_domain(lint: Lint, of: Vec<String>, files: &Files, line: u32, message: String, hint: &str) -> Finding {
    let position = longstep_core::diagnostic::Position { line, column: 1 };
    let diagnostic = Diagnostic::at(&format!("{}domain.toml", files.folder), position, message).hint(hint);
    Finding { lint, of, diagnostic }
}

/// Finds derivations by name that match no entity.
fn idle_derivations(world: &World, files: &Files) -> Vec<Finding> {
    let is_matched = |name: &str| {
        world
            .entities()
            .any(|(_, entity)| matches_name(&entity.identifier, name))
    };
    let idle = |derivation: &&Derivation| names(derivation).next().is_some() && !names(derivation).any(is_matched);
    let found = world.domain().derivations.iter().filter(idle).map(|derivation| {
        let of: Vec<String> = names(derivation).map(str::to_owned).collect();
        let message = format!("no entity has a name of this derivation: {}", of.join(", "));
        let hint = "harmless if the derivation is for other environments; otherwise correct its names";
        in_domain(Lint::IdleDerivation, of, files, derivation.line, message, hint)
    });
    found.collect()
}

/// Finds state words that the environment does not use, of facts that no action makes true.
fn unused_states(world: &World, files: &Files) -> Vec<Finding> {
    let domain = world.domain();
    let is_made = |word: &StateWord| {
        let adds = |action: &Action| {
            let mut effects = action.effects.iter();
            effects.any(|effect| effect.adds && effect.atom.predicate == word.atom.predicate)
        };
        domain.actions.iter().any(adds)
    };
    let holds = |word: &StateWord| world.state.iter().any(|fact| fact.predicate() == word.atom.predicate);
    let unused = domain.states.iter().filter(|word| !is_made(word) && !holds(word));
    let found = unused.map(|word| {
        let message = format!(
            "the environment does not use the state `{}`, and no action makes it true",
            word.word
        );
        let hint = "harmless if no entity is in this state; conditions on it fail here";
        let line = files
            .words
            .lines()
            .position(|line| line.contains(&word.word))
            .map_or(1, |index| index as u32 + 1);
        in_domain(Lint::UnusedState, vec![word.word.clone()], files, line, message, hint)
    });
    found.collect()
}
