//! A model's account of a scene: names, and states of them.

use serde::Deserialize;

use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::dialogue::{DialogueError, object};

/// Maximum number of names in one list.
pub(super) const NAMES: usize = 40;
/// Maximum number of states that one reply may have.
const STATES: usize = 400;
/// Maximum number of characters of a name or text in a reply.
const CHARACTERS: usize = 60;
/// The absence of names or states in the line form.
pub(super) const NONE: &str = "none";
/// The labels of the lists in the line form.
pub(super) const LABELS: [(&str, List); 2] = [("assets: ", List::Assets), ("objects: ", List::Objects)];
/// The separator of names.
pub(super) const COMMA: &str = ", ";
/// The separator of the states of one name.
pub(super) const SEMICOLON: &str = "; ";

/// A scene in a model's words, not yet checked.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Sighting {
    /// Names of entities that cannot be manipulated.
    pub assets: Vec<String>,
    /// Names of entities that can be manipulated.
    pub objects: Vec<String>,
    /// The statements.
    pub statements: Vec<Statement>,
    /// Names of entities that are not there, in a correction.
    pub absent: Vec<String>,
    /// What cannot be seen well, in the model's words.
    pub unsure: Vec<String>,
}

/// A state of an entity.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub struct Statement {
    /// The name of the entity.
    pub subject: String,
    /// The state: a word of the domain, with the names of other entities.
    pub state: Call,
}

/// A server's answer.
#[derive(Debug, Deserialize)]
struct Answer {
    #[serde(default)]
    assets: Vec<String>,
    #[serde(default)]
    objects: Vec<String>,
    #[serde(default)]
    states: Vec<StateAnswer>,
    #[serde(default)]
    absent: Vec<String>,
    #[serde(default)]
    unsure: Vec<String>,
}

#[derive(Debug, Deserialize)]
struct StateAnswer {
    entity: String,
    state: String,
    #[serde(default)]
    arguments: Vec<String>,
}

impl Sighting {
    /// Reads a server's answer.
    ///
    /// # Errors
    ///
    /// The text is no such JSON, or has more names and states than a scene.
    pub(super) fn from_json(text: &str) -> Result<Self, DialogueError> {
        let answer: Answer = object(text)?;
        let too_many = |kind: &str, most: usize| DialogueError::Unreadable(format!("more than {most} {kind}"));
        if answer.assets.len() > NAMES || answer.objects.len() > NAMES || answer.absent.len() > NAMES {
            return Err(too_many("names", NAMES));
        }
        if answer.states.len() > STATES || answer.states.iter().any(|own| own.arguments.len() > NAMES) {
            return Err(too_many("states", STATES));
        }
        let names = |texts: Vec<String>| {
            texts
                .iter()
                .map(|text| plain(text))
                .filter(|name| !name.is_empty())
                .collect()
        };
        let statements = answer.states.into_iter().filter_map(|own| {
            // Some models write the whole state in place of its word.
            let written = Call::parse(&own.state).ok();
            let (word, mut arguments) =
                written.map_or((own.state.clone(), Vec::new()), |call| (call.name, call.arguments));
            if arguments.is_empty() {
                arguments = own.arguments;
            }
            let arguments = arguments.iter().map(|argument| plain(argument));
            let state = Call {
                name: shortened(word.trim()),
                arguments: arguments.filter(|argument| !argument.is_empty()).collect(),
            };
            let subject = plain(&own.entity);
            (!subject.is_empty()).then_some(Statement { subject, state })
        });
        Ok(Self {
            statements: statements.collect(),
            assets: names(answer.assets),
            objects: names(answer.objects),
            absent: names(answer.absent),
            unsure: answer
                .unsure
                .iter()
                .map(|text| shortened(text.trim()))
                .take(NAMES)
                .collect(),
        })
    }

    /// Reads the two lists at the beginning of the line form.
    pub(super) fn lists(text: &str) -> Result<Self, DialogueError> {
        let mut sighting = Self::default();
        for (label, list) in LABELS {
            let line = text.lines().find_map(|line| line.strip_prefix(label));
            let line = line.ok_or_else(|| DialogueError::Unreadable(format!("there is no line `{label}`")))?;
            let own = match list {
                List::Assets => &mut sighting.assets,
                List::Objects => &mut sighting.objects,
            };
            let names = line.split(COMMA.trim()).map(plain);
            own.extend(names.filter(|name| !name.is_empty() && name != NONE).take(NAMES));
        }
        sighting.number();
        Ok(sighting)
    }

    /// Gives a name that is listed several times a number each time: a list with "mug, mug" has two mugs.
    fn number(&mut self) {
        let mut known: Vec<String> = Vec::new();
        for name in self.assets.iter_mut().chain(&mut self.objects) {
            let mut numbers = 2..;
            let first = name.clone();
            while known.contains(name) {
                *name = format!("{first}_{}", numbers.next().unwrap_or_default());
            }
            known.push(name.clone());
        }
    }

    /// Adds the states of a line `NAME: STATE; STATE`.
    pub(super) fn add_line(&mut self, subject: &str, states: &str) {
        for state in states
            .split(SEMICOLON.trim())
            .map(str::trim)
            .filter(|state| *state != NONE)
        {
            if let Ok(state) = Call::parse(state) {
                let subject = subject.to_owned();
                self.statements.push(Statement { subject, state });
            }
        }
    }

    /// Returns the names with their lists, in order.
    pub(super) fn names(&self) -> Vec<(&str, List)> {
        let assets = self.assets.iter().map(|name| (name.as_str(), List::Assets));
        let objects = self.objects.iter().map(|name| (name.as_str(), List::Objects));
        assets.chain(objects).collect()
    }

    /// Returns the identifier of a name in an environment. Constants of the domain, which are in no list, keep theirs.
    pub(super) fn identifier(&self, name: &str) -> String {
        match self.names().iter().any(|(own, _)| *own == name) {
            true => format!("<{name}>"),
            false => name.to_owned(),
        }
    }

    /// Writes the line form.
    pub(super) fn written(&self) -> String {
        let mut text = self.written_lists();
        let lines: Vec<String> = self.names().into_iter().map(|(name, _)| self.line(name)).collect();
        text.push_str(&lines.join("\n"));
        text
    }

    /// Writes the line of a name.
    pub(super) fn line(&self, name: &str) -> String {
        let own = self.statements.iter().filter(|statement| statement.subject == name);
        let states: Vec<String> = own.map(|statement| statement.state.to_string()).collect();
        let states = if states.is_empty() {
            NONE.to_owned()
        } else {
            states.join(SEMICOLON)
        };
        format!("{name}: {states}")
    }

    fn written_lists(&self) -> String {
        let list = |names: &[String]| match names.is_empty() {
            true => NONE.to_owned(),
            false => names.join(COMMA),
        };
        let [(assets, _), (objects, _)] = LABELS;
        format!("{assets}{}\n{objects}{}\n", list(&self.assets), list(&self.objects))
    }

    /// Returns the sentence of a statement, with the names as they are.
    pub(super) fn sentence(vocabulary: &Vocabulary<'_>, statement: &Statement) -> Option<String> {
        let word = vocabulary.find(&statement.state.name)?;
        let name = |slot: usize| match slot {
            0 => statement.subject.replace('_', " "),
            _ => statement
                .state
                .arguments
                .get(slot - 1)
                .map_or(String::new(), |own| own.replace('_', " ")),
        };
        Some(vocabulary.sentence(word, &name))
    }
}

/// Returns a name as identifiers are written between angle brackets: lower case, with underscores.
pub(super) fn plain(text: &str) -> String {
    let bare = text.trim().trim_start_matches('<').trim_end_matches('>');
    let fits = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let joined: String = bare.to_lowercase().chars().map(fits).take(CHARACTERS).collect();
    let parts: Vec<&str> = joined.split('_').filter(|part| !part.is_empty()).collect();
    parts.join("_")
}

fn shortened(text: &str) -> String {
    text.chars().take(CHARACTERS * 3).collect()
}
