//! A model's account of a scene: names, and states of them.

use serde::Deserialize;

use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::dialogue::{DialogueError, object};
use crate::model::singular;

/// Maximum number of names in one list.
pub(super) const NAMES: usize = 40;
/// Maximum number of states that one reply may have.
const STATES: usize = 400;
/// Maximum number of characters of a name or text in a reply.
const CHARACTERS: usize = 60;
/// The absence of names in an embedded model's answer.
const NONE: &str = "none";
/// The label of the names in an embedded model's answer.
pub(super) const LABEL: &str = "names: ";
/// Stands between a sentence of a description and what it says in plain sentences.
pub(super) const ARROW: &str = " => ";
/// The words after a name in an embedded model's answer.
pub(super) const KINDS: [(&str, List); 2] = [(" asset", List::Assets), (" object", List::Objects)];
/// The separator of names.
pub(super) const COMMA: &str = ", ";

/// A scene in a model's words, not yet checked.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Sighting {
    /// Names of entities that cannot be manipulated.
    pub assets: Vec<String>,
    /// Names of entities that can be manipulated.
    pub objects: Vec<String>,
    /// The statements.
    pub statements: Vec<Statement>,
    /// Names of entities that are not there, in a correction.
    pub absent: Vec<String>,
    /// The rest that no state of the domain says, in the model's words.
    pub left_out: Vec<String>,
    /// The parts that cannot be seen well, in the model's words.
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
struct ServerAnswer {
    assets: Vec<String>,
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
        let answer: ServerAnswer = object(text)?;
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
            left_out: Vec::new(),
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

    /// Reads the names at the beginning of the line form, in the order of the text.
    pub(super) fn named(text: &str) -> Result<Vec<(String, List)>, DialogueError> {
        let line = text.lines().find_map(|line| line.strip_prefix(LABEL));
        let line = line.ok_or_else(|| DialogueError::Unreadable(format!("there is no line `{LABEL}`")))?;
        let mut named: Vec<(String, List)> = Vec::new();
        for entry in line
            .split(COMMA.trim())
            .map(str::trim)
            .filter(|entry| *entry != NONE)
            .take(NAMES)
        {
            let kind = KINDS
                .iter()
                .find_map(|(kind, list)| Some((entry.strip_suffix(kind)?, *list)));
            let (name, list) =
                kind.ok_or_else(|| DialogueError::Unreadable(format!("a name without a list: `{entry}`")))?;
            let name = plain(name);
            // A list with "mug, mug" has two mugs.
            let numbered = (2..).map(|number| format!("{name}_{number}"));
            let mut names = std::iter::once(name.clone()).chain(numbered);
            let free = names.find(|name| !named.iter().any(|(own, _)| own == name));
            named.extend(free.filter(|name| !name.is_empty()).map(|name| (name, list)));
        }
        Ok(named)
    }

    /// Returns a sighting without statements.
    pub(super) fn of_names(named: &[(String, List)]) -> Self {
        let of = |list: List| {
            let own = named.iter().filter(move |(_, own)| *own == list);
            own.map(|(name, _)| name.clone()).collect()
        };
        Self {
            assets: of(List::Assets),
            objects: of(List::Objects),
            ..Self::default()
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
        if self.names().iter().any(|(own, _)| *own == name) {
            format!("<{name}>")
        } else {
            name.to_owned()
        }
    }

    /// Returns the sentence of a statement, with the names as they are: "the rope_1 is on the table".
    pub(super) fn sentence(vocabulary: &Vocabulary<'_>, statement: &Statement) -> Option<String> {
        let word = vocabulary.find(&statement.state.name)?;
        let name = |slot: usize| match slot {
            0 => format!("the {}", statement.subject),
            _ => statement
                .state
                .arguments
                .get(slot - 1)
                .map_or(String::new(), |own| format!("the {own}")),
        };
        Some(vocabulary.sentence(word, &name))
    }
}

/// Writes names with their lists.
pub(super) fn written_names(names: &[(String, List)]) -> String {
    let kind = |list: List| KINDS.iter().find(|(_, own)| *own == list).map_or("", |(kind, _)| *kind);
    let entries: Vec<String> = names
        .iter()
        .map(|(name, list)| format!("{name}{}", kind(*list)))
        .collect();
    if entries.is_empty() {
        format!("{LABEL}{NONE}")
    } else {
        format!("{LABEL}{}", entries.join(COMMA))
    }
}

/// Returns a name as identifiers are written between angle brackets: lower case, with underscores.
pub(super) fn plain(text: &str) -> String {
    let bare = text.trim().trim_start_matches('<').trim_end_matches('>');
    let fits = |c: char| if c.is_alphanumeric() { c } else { '_' };
    let joined: String = bare.to_lowercase().chars().map(fits).take(CHARACTERS).collect();
    let mut parts: Vec<&str> = joined.split('_').filter(|part| !part.is_empty()).collect();
    // One of several glasses is a glass.
    let noun = match &parts[..] {
        [.., noun, number] if number.chars().all(|c| c.is_ascii_digit()) => singular(noun),
        _ => return parts.join("_"),
    };
    let place = parts.len() - 2;
    parts[place] = &noun;
    parts.join("_")
}

fn shortened(text: &str) -> String {
    text.chars().take(CHARACTERS * 3).collect()
}
