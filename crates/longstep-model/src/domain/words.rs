//! The schema of `domain.toml` and `prompt/examples.toml`. [`super::load()`] interprets it.

use indexmap::IndexMap;
use serde::Deserialize;
use toml::Spanned;

type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    pub name: String,
    pub about: String,
    pub environment: EnvironmentEntry,
    #[serde(default)]
    pub predicate: Vec<PredicateEntry>,
    #[serde(default)]
    pub action: Vec<ActionEntry>,
    #[serde(default)]
    pub state: Vec<StateEntry>,
    /// Words of the numeric functions.
    #[serde(default)]
    pub number: Vec<NumberEntry>,
    #[serde(default)]
    pub property: Vec<PropertyEntry>,
    #[serde(default)]
    pub derive: Vec<DeriveEntry>,
    #[serde(default)]
    pub default: Vec<DefaultEntry>,
    #[serde(default)]
    pub rule: Vec<RuleEntry>,
    #[serde(default)]
    pub goal: Vec<GoalEntry>,
    /// Lint findings that the author accepts.
    #[serde(default)]
    pub accept: Vec<AcceptEntry>,
    #[serde(default)]
    pub repair: RepairEntry,
    #[serde(default)]
    pub value: IndexMap<Text, ValueEntry>,
    #[serde(default)]
    pub lexicon: IndexMap<Text, Vec<Text>>,
    #[serde(default)]
    pub implied: IndexMap<Text, Vec<Text>>,
    pub article: Option<Text>,
    #[serde(default)]
    pub speaker_names: Vec<Text>,
    #[serde(default)]
    pub robot_names: Vec<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EnvironmentEntry {
    pub assets: Text,
    pub objects: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PredicateEntry {
    pub name: Text,
    pub says: Text,
    pub denies: Text,
    pub short: Option<Text>,
    #[serde(default)]
    pub event: bool,
    #[serde(default)]
    pub unknown: UnknownEntry,
    #[serde(default)]
    pub complete: bool,
    pub cues: Option<Obsolete>,
    pub past: Option<Text>,
}

#[derive(Debug, Deserialize, Default, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub enum UnknownEntry {
    #[default]
    False,
    Assume,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionEntry {
    pub name: Text,
    pub call: Text,
    pub object: Option<Text>,
    pub actor: Option<Text>,
    #[serde(default)]
    pub senses: Vec<Text>,
    pub says: Text,
    pub means: String,
    pub retries: Option<Spanned<u32>>,
    #[serde(default)]
    pub skill: Vec<SkillEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillEntry {
    pub name: Text,
    #[serde(rename = "type")]
    pub kind: Text,
    pub unit: Option<Text>,
    pub from: Text,
    pub fit: Option<Text>,
    pub prior: Option<Spanned<Vec<f64>>>,
}

/// The schema of `skills.toml`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SkillsFile {
    pub name: Option<String>,
    pub base: Option<String>,
    pub about: Option<String>,
    #[serde(default)]
    pub action: Vec<ActionSkillsEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionSkillsEntry {
    pub name: Text,
    #[serde(default)]
    pub skill: Vec<SkillEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StateEntry {
    pub word: Text,
    pub fact: Text,
    pub means: String,
    #[serde(default)]
    pub geometry: Vec<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NumberEntry {
    pub name: Text,
    pub word: Option<Text>,
    pub unit: Option<String>,
    pub says: Option<Text>,
    pub min: Option<Spanned<NumberText>>,
    pub max: Option<Spanned<NumberText>>,
}

/// A number, or a decimal in quotes. Floats are written with the fewest digits that identify them, which are the digits
/// in the file.
#[derive(Debug, Deserialize)]
#[serde(untagged)]
pub enum NumberText {
    Whole(i64),
    Decimal(f64),
    Text(String),
}

impl NumberText {
    /// Returns the digits.
    pub fn digits(&self) -> String {
        match self {
            Self::Whole(number) => number.to_string(),
            Self::Decimal(number) => number.to_string(),
            Self::Text(text) => text.clone(),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PropertyEntry {
    pub word: Text,
    pub facts: Vec<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DeriveEntry {
    pub facts: Vec<Text>,
    #[serde(default)]
    pub names: Vec<Text>,
    #[serde(default)]
    pub other_names: Vec<Text>,
    pub pattern: Option<Text>,
    pub when: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DefaultEntry {
    pub fact: Text,
    pub when: Text,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum TimeEntry {
    Start,
    Always,
    End,
    Tidy,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RuleEntry {
    pub name: Text,
    pub holds: TimeEntry,
    pub condition: Text,
    pub says: Text,
    #[serde(default)]
    pub unless: Vec<Text>,
}

#[derive(Debug, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub struct RepairEntry {
    pub insert: Option<Spanned<u32>>,
    pub replace: Option<Spanned<u32>>,
    pub other_actor: Option<Spanned<u32>>,
    pub postpone: Option<Spanned<u32>>,
    pub rebind: Option<Spanned<u32>>,
    pub drop_idle: Option<Spanned<u32>>,
    pub drop_impossible: Option<Spanned<u32>>,
    pub drop: Option<Spanned<u32>>,
    pub other_relation: Option<Spanned<u32>>,
    pub forgo: Option<Spanned<u32>>,
    pub unsettle: Option<Spanned<u32>>,
}

/// The value of a key that has no effect any more. Domains that have it still load, and a lint reports it.
pub type Obsolete = Spanned<toml::Value>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GoalEntry {
    pub form: Text,
    pub parameters: Text,
    pub condition: Text,
    pub offered: Option<Text>,
    /// Without effect.
    pub cues: Option<Obsolete>,
    /// Without effect.
    pub destination_verbs: Option<Obsolete>,
    /// Without effect.
    pub yields_to: Option<Obsolete>,
    /// Without effect.
    pub phrases: Option<Obsolete>,
    pub subject: Option<Text>,
    pub exclusive: Option<String>,
    #[serde(default)]
    pub disturbs: Vec<Text>,
    pub says: Text,
    /// The act that a person asks the robot for, after "Should I".
    pub asks: Option<Text>,
    pub means: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AcceptEntry {
    pub lint: Text,
    pub of: Vec<String>,
    pub why: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ValueEntry {
    pub unit: Option<Text>,
    #[serde(default)]
    pub units: IndexMap<Text, Spanned<NumberText>>,
    pub min: Option<Spanned<NumberText>>,
    pub max: Option<Spanned<NumberText>>,
    #[serde(default)]
    pub text: bool,
}
