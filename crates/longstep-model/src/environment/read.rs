//! The reader: converts an environment to a world of entities, facts and assumptions.

use rustc_hash::FxHashSet;

use super::implied::add_implied;
use super::statement::{Misstatement, fact_alone, function_of, is_stated, number};
use super::{Bindings, Entity, EntityId, Environment, Fact, Words, World};
use crate::call::{Call, NOTATION};
use crate::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use crate::effort;
use crate::json::{Locator, Path};
use crate::model::{
    Domain, ENTITY_LIMIT, Literal, PredicateId, RuleTime, TypeId, ground, grounded_term, is_mark, name_entities,
};

/// The number of diagnostics for an environment after which further ones are dropped.
const FINDINGS: usize = 100;

/// Characters of names beside letters, digits and combining marks.
const NAME_SIGNS: [char; 6] = [' ', '-', '\'', '\u{2019}', '.', '_'];

/// Reads an environment as a world of the domain.
///
/// `file` and `text` are the source of the environment and give diagnostics their position; `text` may be empty.
/// `inside` is the path of the environment within the text.
///
/// # Errors
///
/// All problems of the environment: unknown states and properties, entities that are used but not listed, entities
/// listed twice, identifiers with signs of the [notation](NOTATION), contradictory facts, and derivations with too many
/// instances.
pub fn read(
    domain: &Domain,
    environment: &Environment,
    file: &str,
    text: &str,
    inside: &Path,
) -> Result<World, Diagnostics> {
    let mut reader = EnvironmentReader {
        domain,
        file,
        locator: Locator::new(text),
        inside,
        findings: Vec::new(),
    };
    let spent = effort::within(effort::OPERATION, || reader.world(environment));
    if spent.exhausted && reader.findings.is_empty() {
        let message = "what follows from the environment has too many instances".to_owned();
        reader.report(
            &Path::default(),
            message,
            Some("make the environment smaller".to_owned()),
        );
    }
    match spent.result {
        Some(world) if reader.findings.is_empty() => Ok(world),
        _ => Err(Diagnostics::sorted(reader.findings)),
    }
}

/// Parses and reads an environment, bare or wrapped in `{"environment": ...}`, as a world of the domain. `file` is the
/// name of the text in diagnostics.
///
/// ```
/// use longstep_model::{domain, environment};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#).unwrap();
/// assert_eq!(world.domain().name, "household");
///
/// let findings = environment::parse(&household, "env.json", r#"{"assets": ["<table>"#).unwrap_err();
/// assert!(findings.to_string().starts_with("env.json:1:20: EOF while parsing a string"));
/// ```
///
/// # Errors
///
/// The first place where the text is not JSON in the environment's form; otherwise as for [`read()`].
pub fn parse(domain: &Domain, file: &str, text: &str) -> Result<World, Diagnostics> {
    let (parsed, wrapped) = Environment::parse(text).map_err(|error| {
        let hint =
            "an environment is JSON, or a Python literal, with `assets`, `asset_states`, `objects` and `object_states`";
        let finding = match error.position {
            None => Diagnostic::whole(file, error.message),
            Some(Position { line, column }) => {
                let column = column.max(1);
                Diagnostic::at(file, Position { line, column }, error.message)
            }
        };
        Diagnostics(vec![finding.hint(hint)])
    })?;
    let inside = if wrapped {
        Path::key("environment")
    } else {
        Path::default()
    };
    read(domain, &parsed, file, text, &inside)
}

struct EnvironmentReader<'a> {
    domain: &'a Domain,
    file: &'a str,
    locator: Locator<'a>,
    inside: &'a Path,
    findings: Vec<Diagnostic>,
}

impl EnvironmentReader<'_> {
    fn report(&mut self, path: &Path, message: String, hint: Option<String>) {
        if self.is_full() {
            return;
        }
        let path = self.inside.join(path);
        let message = match path.to_string().as_str() {
            "" => message,
            path => format!("{path}: {message}"),
        };
        let mut finding = Diagnostic::whole(self.file, message);
        finding.position = self.locator.locate(&path);
        self.findings.push(match hint {
            Some(hint) => finding.hint(hint),
            None => finding,
        });
    }

    /// Returns true if no more diagnostics are recorded: each one takes time to locate it and to find similar names.
    fn is_full(&self) -> bool {
        self.findings.len() >= FINDINGS
    }

    fn world(&mut self, environment: &Environment) -> Option<World> {
        let domain = self.domain;
        let lists = [
            ("assets", &environment.assets, domain.environment.asset),
            ("objects", &environment.objects, domain.environment.object),
        ];
        let mut identifiers: Vec<(&str, TypeId)> = domain
            .constants
            .iter()
            .map(|(name, kind)| (name.as_str(), *kind))
            .collect();
        let mut by_identifier: indexmap::IndexMap<String, EntityId> = identifiers
            .iter()
            .enumerate()
            .map(|(i, (name, _))| ((*name).to_owned(), EntityId::new(i)))
            .collect();
        if environment.assets.len() + environment.objects.len() > ENTITY_LIMIT {
            let message = format!("more than {ENTITY_LIMIT} entities");
            self.report(&Path::default(), message, None);
            return None;
        }
        for (list, entries, kind) in lists {
            for (index, identifier) in entries.iter().enumerate() {
                let path = Path::key(list).index(index);
                if identifier.trim().is_empty() {
                    self.report(&path, "an entity needs a name".to_owned(), None);
                } else if let Some(sign) = identifier.chars().find(|c| NOTATION.contains(c)) {
                    let message =
                        format!("`{identifier}` has {sign:?} in it, which separates the parts of steps and goals");
                    self.report(&path, message, Some("leave it out, or write `_`".to_owned()));
                } else if by_identifier.contains_key(identifier) {
                    let message = format!("`{identifier}` is listed twice");
                    self.report(&path, message, Some("keep one of the two".to_owned()));
                } else {
                    by_identifier.insert(identifier.clone(), EntityId::new(identifiers.len()));
                    identifiers.push((identifier, kind));
                }
            }
        }
        // An unlisted place in a state is an error below. A room may occur only in the properties, which is harmless.
        let only_names: Vec<&str> = identifiers.iter().map(|(name, _)| *name).collect();
        for (identifier, name) in environment.names.iter().flatten() {
            self.given_name(identifier, name, &by_identifier);
        }
        let mut entities: Vec<Entity> = name_entities(domain, &only_names, environment.names.as_ref())
            .into_iter()
            .zip(&identifiers)
            .map(|((name, names), (identifier, kind))| Entity {
                identifier: (*identifier).to_owned(),
                kind: *kind,
                name,
                names,
                is_value: false,
            })
            .collect();
        for (identifier, name) in environment.types.iter().flatten() {
            if let Some((entity, kind)) = self.given_type(identifier, name, &entities, &by_identifier) {
                entities[entity.index()].kind = kind;
            }
        }
        for (key, identifier, names) in [
            ("speaker", &environment.speaker, &domain.speaker_names),
            ("robot", &environment.robot, &domain.robot_names),
        ] {
            let Some(identifier) = identifier else { continue };
            match by_identifier.get(identifier) {
                Some(entity) => entities[entity.index()].names.extend(names.iter().cloned()),
                None => self.unlisted(&Path::key(key), identifier, &by_identifier),
            }
        }
        let mut world = World::new(domain, entities, environment.clone());
        self.states(&mut world, "asset_states", &environment.asset_states);
        self.states(&mut world, "object_states", &environment.object_states);
        self.facts(&mut world, environment.facts.as_deref().unwrap_or_default());
        let mut denied: FxHashSet<Fact> = FxHashSet::default();
        let mut given: FxHashSet<usize> = FxHashSet::default();
        for (section, properties) in [
            ("asset_properties", &environment.asset_properties),
            ("object_properties", &environment.object_properties),
        ] {
            for (identifier, words) in properties.iter().flatten() {
                self.properties(&mut world, section, identifier, words, &mut denied, &mut given);
            }
        }
        add_implied(&mut world, denied, &given);
        self.contradictions(&world);
        Some(world)
    }

    fn given_name(&mut self, identifier: &str, name: &str, known: &indexmap::IndexMap<String, EntityId>) {
        let path = Path::key("names").push(identifier);
        if !known.contains_key(identifier) {
            self.unlisted(&path, identifier, known);
        }
        let fits = |c: char| c.is_alphanumeric() || is_mark(c) || NAME_SIGNS.contains(&c);
        let has_letter = name.contains(char::is_alphanumeric);
        if !has_letter || !name.chars().all(fits) || name.chars().count() > 60 {
            let message = "a name is up to 60 letters, digits, blanks, hyphens, apostrophes, dots and underscores";
            self.report(&path, message.to_owned(), None);
        }
    }

    /// Returns the entity and its type, which has to be a subtype of its list's type.
    fn given_type(
        &mut self,
        identifier: &str,
        name: &str,
        entities: &[Entity],
        known: &indexmap::IndexMap<String, EntityId>,
    ) -> Option<(EntityId, TypeId)> {
        let path = Path::key("types").push(identifier);
        let types = &self.domain.types;
        let Some(entity) = known.get(identifier) else {
            self.unlisted(&path, identifier, known);
            return None;
        };
        let listed = entities[entity.index()].kind;
        let is_fitting = |name: &&str| types.find(name).is_some_and(|kind| types.is_a(kind, listed));
        let fitting: Vec<&str> = types.names().filter(is_fitting).collect();
        let Some(kind) = types.find(name) else {
            let hint = match nearest(name, fitting.iter().copied()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!("types of this list are {}", fitting.join(", ")),
            };
            self.report(&path, format!("the domain has no type `{name}`"), Some(hint));
            return None;
        };
        if !types.is_a(kind, listed) {
            let message = format!(
                "`{identifier}` is listed as `{}`, and `{name}` is no such type",
                types.name(listed)
            );
            let hint = format!("types of this list are {}", fitting.join(", "));
            self.report(&path, message, Some(hint));
            return None;
        }
        Some((*entity, kind))
    }

    fn unlisted(&mut self, path: &Path, identifier: &str, known: &indexmap::IndexMap<String, EntityId>) {
        if self.is_full() {
            return;
        }
        let near = nearest(identifier, known.keys().map(String::as_str));
        let hint = near.map_or_else(
            || "add it to `assets` or `objects`".to_owned(),
            |near| format!("did you mean `{near}`? Otherwise add it to `assets` or `objects`"),
        );
        self.report(
            path,
            format!("`{identifier}` is listed neither in `assets` nor in `objects`"),
            Some(hint),
        );
    }

    fn states(&mut self, world: &mut World, section: &str, states: &indexmap::IndexMap<String, Words>) {
        for (identifier, words) in states {
            let path = Path::key(section).push(identifier);
            let Some(subject) = self.entity(world, identifier) else {
                self.unlisted(&path, identifier, &world.by_identifier);
                continue;
            };
            for (index, word) in words.as_slice().iter().enumerate() {
                let path = match words {
                    Words::One(_) => path.clone(),
                    Words::Many(_) => path.index(index),
                };
                if self.is_number(world, &path, Some(subject), word) {
                    continue;
                }
                for argument in Call::parse(word).into_iter().flat_map(|call| call.arguments) {
                    self.entity(world, &argument);
                }
                if let Some(fact) = self.state(world, &path, subject, word) {
                    world.state.set(fact, true);
                }
            }
        }
    }

    /// Returns the entity with this identifier. A value is added to the world.
    fn entity(&self, world: &mut World, identifier: &str) -> Option<EntityId> {
        match self.domain.value(identifier) {
            Some(Ok(value)) if world.find(identifier).is_none() => world.add_value(&value, identifier),
            _ => world.find(identifier),
        }
    }

    /// Reads the statements without a subject.
    fn facts(&mut self, world: &mut World, facts: &[String]) {
        let domain = self.domain;
        for (index, text) in facts.iter().enumerate() {
            let path = Path::key("facts").index(index);
            if self.is_number(world, &path, None, text) {
                continue;
            }
            let call = match Call::parse(text) {
                Ok(call) => call,
                Err(error) => {
                    self.report(&path, error.to_string(), None);
                    continue;
                }
            };
            if let Some(fact) = fact_alone(domain, &call) {
                world.state.set(fact, true);
                continue;
            }
            let predicates = domain.predicates.iter().enumerate();
            let predicates = predicates.filter(|(index, _)| is_stated(domain, PredicateId::new(*index)));
            let functions = domain
                .functions
                .iter()
                .filter(|function| function.parameters.is_empty());
            let known = predicates.map(|(_, predicate)| predicate.name.as_str());
            let known: Vec<&str> = known.chain(functions.map(|function| function.word.as_str())).collect();
            let hint = match (nearest(&call.name, known.iter().copied()), known.is_empty()) {
                (Some(near), _) => format!("did you mean `{near}`?"),
                (None, true) => format!("the domain `{}` has no statements without a subject", domain.name),
                (None, false) => format!("the domain `{}` knows {}", domain.name, known.join(", ")),
            };
            self.report(&path, format!("unknown statement `{}`", call.name), Some(hint));
        }
    }

    /// Reads the number of a fluent and reports its mistakes; returns false for a text that is no such statement.
    fn is_number(&mut self, world: &mut World, path: &Path, subject: Option<EntityId>, text: &str) -> bool {
        let domain = self.domain;
        let Ok(call) = Call::parse(text) else { return false };
        let Some(function) = function_of(domain, &call.name) else {
            return false;
        };
        let message = match number(world, function, subject, &call) {
            Ok((fluent, number)) => {
                let own = domain.function(function);
                let known = world.state.number(fluent);
                match (own.range(), known) {
                    (Some(range), _) if !own.allows(number) => {
                        let unit = own.unit.as_ref().map_or_else(String::new, |unit| format!(" {unit}"));
                        Some(format!(
                            "`{text}` is outside of the range of `{}`, {range}{unit}",
                            own.word
                        ))
                    }
                    (_, Some(known)) if known != number => {
                        Some(format!("`{text}` contradicts another number, {known}"))
                    }
                    _ => {
                        world.state.set_number(fluent, number);
                        None
                    }
                }
            }
            Err(Misstatement::Arguments(expected)) => {
                Some(match (subject, domain.function(function).parameters.is_empty()) {
                    (Some(_), true) => format!("`{}` is a statement without a subject: write it in `facts`", call.name),
                    (None, false) => format!(
                        "`{}` needs a subject: write it among the states of an entity",
                        call.name
                    ),
                    _ => format!(
                        "`{}` takes {expected} argument(s), the number last, not {}",
                        call.name,
                        call.arguments.len()
                    ),
                })
            }
            Err(Misstatement::NoNumber(text)) => Some(format!(
                "`{text}` is no number: expected digits with at most six places after the point"
            )),
            Err(Misstatement::Unlisted(name)) => {
                self.unlisted(path, &name, &world.by_identifier);
                None
            }
            Err(Misstatement::Kind(entity, kind)) => Some(format!(
                "`{}` cannot be said of `{}`, which is no {kind}",
                call.name,
                world.entity(entity).identifier
            )),
        };
        if let Some(message) = message {
            self.report(path, message, None);
        }
        true
    }

    fn state(&mut self, world: &World, path: &Path, subject: EntityId, text: &str) -> Option<Fact> {
        let call = match Call::parse(text) {
            Ok(call) => call,
            Err(error) => {
                self.report(path, error.to_string(), None);
                return None;
            }
        };
        let domain = self.domain;
        let Some(word) = domain.states.iter().find(|s| s.word == call.name) else {
            let functions = domain.functions.iter().map(|function| function.word.as_str());
            let known = domain.states.iter().map(|s| s.word.as_str()).chain(functions);
            let hint = match nearest(&call.name, known.clone()) {
                Some(near) => format!("did you mean `{near}`?"),
                None => format!(
                    "the domain `{}` knows {}",
                    domain.name,
                    known.collect::<Vec<_>>().join(", ")
                ),
            };
            self.report(path, format!("unknown state `{}`", call.name), Some(hint));
            return None;
        };
        if word.parameters.len() != call.arguments.len() {
            let message = format!(
                "`{}` takes {} argument(s), not {}",
                word.word,
                word.parameters.len(),
                call.arguments.len()
            );
            self.report(path, message, None);
            return None;
        }
        let mut bindings: Bindings = vec![subject];
        for argument in &call.arguments {
            match (world.exactly(argument), domain.value(argument)) {
                (Some(entity), _) => bindings.push(entity),
                (None, Some(Err(beyond))) => {
                    self.report(path, beyond.to_string(), None);
                    return None;
                }
                (None, _) => {
                    self.unlisted(path, argument, &world.by_identifier);
                    return None;
                }
            }
        }
        let parameters = &domain.predicate(word.atom.predicate).parameters;
        for (term, parameter) in word.atom.terms.iter().zip(parameters) {
            let entity = world.entity(grounded_term(*term, &bindings));
            if !domain.types.is_a(entity.kind, parameter.kind) {
                let message = format!(
                    "`{}` cannot be said of `{}`, which is no {}",
                    word.word,
                    entity.identifier,
                    domain.types.name(parameter.kind)
                );
                self.report(path, message, None);
                return None;
            }
        }
        Some(ground(&word.atom, &bindings))
    }

    fn properties(
        &mut self,
        world: &mut World,
        section: &str,
        identifier: &str,
        words: &Words,
        denied: &mut FxHashSet<Fact>,
        given: &mut FxHashSet<usize>,
    ) {
        let path = Path::key(section).push(identifier);
        let subject = world.find(identifier);
        for (index, text) in words.as_slice().iter().enumerate() {
            let path = match words {
                Words::One(_) => path.clone(),
                Words::Many(_) => path.index(index),
            };
            let Some(word) = self.domain.properties.iter().find(|p| p.word == *text) else {
                let known = self.domain.properties.iter().map(|p| p.word.as_str());
                let hint = nearest(text, known).map(|near| format!("did you mean `{near}`?"));
                self.report(&path, format!("unknown property `{text}`"), hint);
                continue;
            };
            let Some(subject) = subject else { continue };
            for Literal { atom, holds } in &word.literals {
                let fact = ground(atom, &[subject]);
                let opposite = if *holds {
                    given.insert(atom.predicate.index());
                    world.state.set(fact, true);
                    denied.contains(&fact)
                } else {
                    denied.insert(fact);
                    world.state.holds(fact)
                };
                if opposite {
                    let message = format!("`{text}` contradicts another property of `{identifier}`");
                    self.report(&path, message, Some("keep one of the two".to_owned()));
                }
            }
        }
    }

    /// Checks the rules with time `start`.
    fn contradictions(&mut self, world: &World) {
        let domain = self.domain;
        for rule in domain.rules.iter().filter(|rule| rule.time == RuleTime::Start) {
            // A contradiction between two entities is reported once, not once per order.
            let mut reported: FxHashSet<Bindings> = FxHashSet::default();
            for bindings in crate::model::broken_bindings(rule, world, &world.state) {
                let mut sorted = bindings.clone();
                sorted.sort_unstable();
                if self.is_full() {
                    return;
                }
                if !reported.insert(sorted) {
                    continue;
                }
                let says = rule.says.fill(|slot| world.entity(bindings[slot]).identifier.clone());
                let path = bindings
                    .iter()
                    .map(|entity| &world.entity(*entity).identifier)
                    .find_map(|identifier| {
                        let states = world.environment();
                        ["object_states", "asset_states"]
                            .into_iter()
                            .zip([&states.object_states, &states.asset_states])
                            .find(|(_, map)| map.contains_key(identifier))
                            .map(|(section, _)| Path::key(section).push(identifier))
                    })
                    .unwrap_or_default();
                self.report(&path, format!("contradictory facts: {says}"), None);
            }
        }
    }
}
