//! The environment of a sighting, checked by the rules of the domain.

use indexmap::IndexMap;

use super::sighting::{Sighting, Statement, plain};
use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::diagnostic::{Diagnostics, nearest};
use crate::environment::{self, Environment, World};
use crate::json;
use crate::model::{Domain, StateWord};
use longstep_core::environment::{AssumptionSource, Words, fact_text};
use longstep_core::model::SpatialRelation;

/// The name of the environment in diagnostics.
const FILE: &str = "the view";

/// An environment from a model's account of a scene.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct View {
    /// The environment.
    pub environment: Environment,
    /// The world of the environment, or everything that contradicts the rules of the domain.
    pub world: Result<World, Diagnostics>,
    /// The account in the names and words of the domain.
    pub sighting: Sighting,
    /// Changes and omissions that were needed to read the account.
    pub leniencies: Vec<Leniency>,
    /// The facts that the domain assumes, as sentences.
    pub assumed: Vec<String>,
    /// Points that the account leaves open, as sentences.
    pub unsaid: Vec<String>,
}

/// A deviation in the account of a model, and what was made of it.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Leniency {
    /// A name in both lists, or twice in one.
    #[error("`{0}` is listed twice; the first one counts")]
    Repeated(String),
    /// A name in a state that is in neither list.
    #[error("`{0}` is in neither list; it is added to the objects")]
    Unlisted(String),
    /// A misspelt name or word.
    #[error("`{0}` is read as `{1}`")]
    Misspelt(String, String),
    /// A state that the domain does not have in this form.
    #[error("`{subject}: {state}` is no state of this domain; it is left out")]
    NoState {
        /// The entity.
        subject: String,
        /// The state.
        state: String,
    },
    /// An entity that is more precise than its list.
    #[error("`{0}` is taken for {1}")]
    Narrowed(String, String),
    /// A name that a correction takes away, and that is not there.
    #[error("there is no `{0}` to take away")]
    NotThere(String),
}

impl View {
    /// Reads an account: resolves its names and words, and checks the environment by the rules of the domain.
    pub fn of(domain: &Domain, sighting: &Sighting) -> Self {
        let mut reader = Reader {
            vocabulary: Vocabulary::of(domain),
            domain,
            sighting: Sighting {
                unsure: sighting.unsure.clone(),
                left_out: sighting.left_out.clone(),
                ..Sighting::default()
            },
            leniencies: Vec::new(),
        };
        reader.names(sighting);
        for statement in &sighting.statements {
            reader.statement(statement);
        }
        reader.view()
    }

    /// Applies a correction: what it says about an entity takes the place of what contradicts it, by the rules of the domain.
    /// Entities that it says are not there are removed, with everything said about them.
    #[must_use]
    pub fn corrected(&self, domain: &Domain, change: &Sighting) -> Self {
        let mut sighting = self.sighting.clone();
        let known: Vec<String> = sighting.names().into_iter().map(|(name, _)| name.to_owned()).collect();
        let is_new = |name: &&String| !known.contains(*name);
        sighting.assets.extend(change.assets.iter().filter(is_new).cloned());
        sighting.objects.extend(change.objects.iter().filter(is_new).cloned());
        sighting.left_out.extend(change.left_out.iter().cloned());
        let mut missing = Vec::new();
        for gone in &change.absent {
            if !known.contains(gone) {
                missing.push(Leniency::NotThere(gone.clone()));
            }
            sighting.assets.retain(|name| name != gone);
            sighting.objects.retain(|name| name != gone);
            sighting
                .statements
                .retain(|own| own.subject != *gone && !own.state.arguments.contains(gone));
        }
        let is_corrected = |own: &Statement| change.statements.iter().any(|new| new.subject == own.subject);
        let (old, kept): (Vec<Statement>, Vec<Statement>) = sighting.statements.into_iter().partition(is_corrected);
        sighting.statements = kept;
        sighting.statements.extend(change.statements.iter().cloned());
        for statement in old {
            let is_replaced =
                |new: &Statement| new.subject == statement.subject && new.state.name == statement.state.name;
            if change.statements.iter().any(is_replaced) {
                continue;
            }
            let before = Self::of(domain, &sighting).contradictions();
            sighting.statements.push(statement);
            if Self::of(domain, &sighting).contradictions() > before {
                sighting.statements.pop();
            }
        }
        let mut view = Self::of(domain, &sighting);
        view.leniencies.extend(missing);
        view
    }

    /// Returns the number of contradictions.
    fn contradictions(&self) -> usize {
        self.world.as_ref().map_or_else(|found| found.0.len(), |_| 0)
    }

    /// Returns every statement as a sentence: "the milk is in the fridge".
    pub fn sentences(&self, domain: &Domain) -> Vec<String> {
        let vocabulary = Vocabulary::of(domain);
        let sentence = |statement: &Statement| match &self.world {
            Ok(world) => {
                let subject = world.find(&self.identifier(&statement.subject))?;
                let arguments = statement.state.arguments.iter().map(|name| self.identifier(name));
                let state = Call {
                    name: statement.state.name.clone(),
                    arguments: arguments.collect(),
                };
                let fact = environment::fact_of(world, subject, &state.to_string())?;
                Some(fact_text(world, fact, true))
            }
            // There is no world that names the entities.
            Err(_) => Sighting::sentence(&vocabulary, statement),
        };
        self.sighting.statements.iter().filter_map(sentence).collect()
    }

    fn identifier(&self, name: &str) -> String {
        self.sighting.identifier(name)
    }
}

struct Reader<'a> {
    vocabulary: Vocabulary<'a>,
    domain: &'a Domain,
    sighting: Sighting,
    leniencies: Vec<Leniency>,
}

impl Reader<'_> {
    fn names(&mut self, given: &Sighting) {
        for (name, list) in given.names() {
            let name = plain(name);
            if name.is_empty() {
                continue;
            }
            if self.list_of(&name).is_some() {
                self.leniencies.push(Leniency::Repeated(name));
                continue;
            }
            match list {
                List::Assets => self.sighting.assets.push(name),
                List::Objects => self.sighting.objects.push(name),
            }
        }
    }

    fn list_of(&self, name: &str) -> Option<List> {
        let all = self.sighting.names();
        all.into_iter().find(|(own, _)| *own == name).map(|(_, list)| list)
    }

    /// Resolves a name of a state: one of the lists, a constant of the domain, a name that is nearly that, or a new object.
    fn name(&mut self, text: &str, constants: &[&str]) -> String {
        let constant = constants
            .iter()
            .find(|constant| **constant == text || plain(constant) == text);
        if let Some(constant) = constant {
            return (*constant).to_owned();
        }
        let name = plain(text);
        if self.list_of(&name).is_some() {
            return name;
        }
        let names = self.sighting.names();
        if let Some(near) = nearest(&name, names.iter().map(|(own, _)| *own)) {
            let near = near.to_owned();
            self.leniencies.push(Leniency::Misspelt(name, near.clone()));
            return near;
        }
        self.leniencies.push(Leniency::Unlisted(name.clone()));
        self.sighting.objects.push(name.clone());
        name
    }

    fn word(&mut self, name: &str) -> Option<&'_ StateWord> {
        if let Some(word) = self.vocabulary.find(name) {
            return Some(word);
        }
        let near = nearest(name, self.vocabulary.words().map(|word| word.word.as_str()))?.to_owned();
        self.leniencies.push(Leniency::Misspelt(name.to_owned(), near.clone()));
        self.vocabulary.find(&near)
    }

    fn statement(&mut self, given: &Statement) {
        let no_state = || Leniency::NoState {
            subject: given.subject.clone(),
            state: given.state.to_string(),
        };
        let word = self.word(&given.state.name).cloned();
        let Some(word) = word.filter(|word| word.parameters.len() == given.state.arguments.len()) else {
            return self.leniencies.push(no_state());
        };
        let subject = self.name(&given.subject, &[]);
        let mut arguments = Vec::new();
        for (index, argument) in given.state.arguments.iter().enumerate() {
            let constants: Vec<&str> = self.vocabulary.constants(&word, index + 1).collect();
            arguments.push(self.name(argument, &constants));
        }
        let is_possible = |(slot, name): (usize, &String)| match self.list_of(name) {
            Some(list) => self.vocabulary.fits(&word, slot, list),
            None => true,
        };
        let mut all = std::iter::once(&subject).chain(&arguments).enumerate();
        if arguments.contains(&subject) || !all.all(is_possible) {
            return self.leniencies.push(no_state());
        }
        let state = Call {
            name: word.word,
            arguments,
        };
        let statement = Statement { subject, state };
        if !self.sighting.statements.contains(&statement) {
            self.sighting.statements.push(statement);
        }
    }

    fn view(mut self) -> View {
        let types = self.types();
        let mut environment = Environment {
            assets: self.sighting.assets.iter().map(|name| format!("<{name}>")).collect(),
            objects: self.sighting.objects.iter().map(|name| format!("<{name}>")).collect(),
            types: (!types.is_empty()).then_some(types),
            ..Environment::default()
        };
        for (name, list) in self.sighting.names() {
            let own = self
                .sighting
                .statements
                .iter()
                .filter(|statement| statement.subject == name);
            let mut texts: Vec<String> = own
                .map(|statement| {
                    let arguments = statement
                        .state
                        .arguments
                        .iter()
                        .map(|argument| self.sighting.identifier(argument));
                    let (name, arguments) = (statement.state.name.clone(), arguments.collect());
                    Call { name, arguments }.to_string()
                })
                .collect();
            let words = match texts.len() {
                0 => continue,
                1 => Words::One(texts.remove(0)),
                _ => Words::Many(texts),
            };
            let states = match list {
                List::Assets => &mut environment.asset_states,
                List::Objects => &mut environment.object_states,
            };
            states.insert(format!("<{name}>"), words);
        }
        let world = environment::read(self.domain, &environment, FILE, "", &json::Path::default());
        let assumed = world.as_ref().map_or_else(|_| Vec::new(), assumed);
        View {
            unsaid: self.unsaid(),
            environment,
            world,
            sighting: self.sighting,
            leniencies: self.leniencies,
            assumed,
        }
    }

    /// Returns the types of entities of which a state needs a more precise type than that of their list.
    fn types(&mut self) -> IndexMap<String, String> {
        let mut types = IndexMap::new();
        for statement in &self.sighting.statements {
            let Some(word) = self.vocabulary.find(&statement.state.name) else {
                continue;
            };
            let names = std::iter::once(&statement.subject).chain(&statement.state.arguments);
            for (slot, name) in names.enumerate() {
                let Some(list) = self.list_of(name) else { continue };
                let (own, kind) = (self.vocabulary.kind_of(list), self.vocabulary.slot_kind(word, slot));
                let Some(kind) = kind.filter(|kind| !self.domain.types.is_a(own, *kind)) else {
                    continue;
                };
                let type_name = self.domain.types.name(kind).to_owned();
                types.entry(format!("<{name}>")).or_insert_with(|| {
                    self.leniencies
                        .push(Leniency::Narrowed(name.clone(), type_name.clone()));
                    type_name
                });
            }
        }
        types
    }

    /// Returns what is left open: the places of objects, if the domain has words for places.
    fn unsaid(&self) -> Vec<String> {
        let places = place_words(&self.vocabulary);
        if places.is_empty() {
            return Vec::new();
        }
        let has_place = |name: &String| {
            let mut own = self
                .sighting
                .statements
                .iter()
                .filter(|statement| statement.subject == *name);
            own.any(|statement| places.contains(&statement.state.name.as_str()))
        };
        let open = self.sighting.objects.iter().filter(|name| !has_place(name));
        open.map(|name| format!("nothing says where the {} is", name.replace('_', " ")))
            .collect()
    }
}

/// Returns the words for places: on, inside and held.
fn place_words<'a>(vocabulary: &Vocabulary<'a>) -> Vec<&'a str> {
    let is_place = |own: &SpatialRelation| {
        matches!(
            own,
            SpatialRelation::On | SpatialRelation::Inside | SpatialRelation::Held
        )
    };
    let words = vocabulary.words().filter(|word| word.relations.iter().any(is_place));
    words.map(|word| word.word.as_str()).collect()
}

/// Returns the facts that the domain assumes in a world, as sentences.
fn assumed(world: &World) -> Vec<String> {
    // What is assumed of everything of which nothing is said tells nothing about this scene.
    let is_assumed = |fact: &_| !matches!(world.assumed(*fact), None | Some(AssumptionSource::Unknown));
    world
        .state
        .iter()
        .filter(is_assumed)
        .map(|fact| fact_text(world, fact, true))
        .collect()
}
