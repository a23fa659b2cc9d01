//! The shape of `domain.toml` and `prompt/examples.toml`. [`super::load()`] gives them meaning.

use indexmap::IndexMap;
use serde::Deserialize;
use toml::Spanned;

type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DomainFile {
    pub(super) name: String,
    pub(super) about: String,
    pub(super) environment: EnvironmentEntry,
    #[serde(default)]
    pub(super) predicate: Vec<PredicateEntry>,
    #[serde(default)]
    pub(super) action: Vec<ActionEntry>,
    #[serde(default)]
    pub(super) state: Vec<StateEntry>,
    #[serde(default)]
    pub(super) property: Vec<PropertyEntry>,
    #[serde(default)]
    pub(super) derive: Vec<DeriveEntry>,
    #[serde(default)]
    pub(super) default: Vec<DefaultEntry>,
    #[serde(default)]
    pub(super) rule: Vec<RuleEntry>,
    #[serde(default)]
    pub(super) goal: Vec<GoalEntry>,
    /// Only [`super::lint()`] looks at these.
    #[serde(default)]
    pub(super) accept: Vec<AcceptEntry>,
    #[serde(default)]
    pub(super) repair: RepairEntry,
    #[serde(default)]
    pub(super) lexicon: IndexMap<String, Vec<String>>,
    #[serde(default)]
    pub(super) implied: IndexMap<String, Vec<String>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct EnvironmentEntry {
    pub(super) assets: Text,
    pub(super) objects: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PredicateEntry {
    pub(super) name: Text,
    pub(super) says: Text,
    pub(super) denies: Text,
    pub(super) short: Option<Text>,
    #[serde(default)]
    pub(super) event: bool,
    #[serde(default)]
    pub(super) unknown: UnknownEntry,
    #[serde(default)]
    pub(super) cues: Vec<String>,
    pub(super) past: Option<Text>,
}

#[derive(Debug, Deserialize, Default, Clone, Copy, PartialEq, Eq)]
#[serde(rename_all = "lowercase")]
pub(super) enum UnknownEntry {
    #[default]
    False,
    Assume,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ActionEntry {
    pub(super) name: Text,
    pub(super) call: Text,
    pub(super) object: Option<Text>,
    pub(super) actor: Option<Text>,
    #[serde(default)]
    pub(super) senses: Vec<Text>,
    pub(super) says: Text,
    pub(super) means: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct StateEntry {
    pub(super) word: Text,
    pub(super) fact: Text,
    pub(super) means: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct PropertyEntry {
    pub(super) word: Text,
    pub(super) facts: Vec<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DeriveEntry {
    pub(super) facts: Vec<Text>,
    #[serde(default)]
    pub(super) names: Vec<String>,
    #[serde(default)]
    pub(super) other_names: Vec<String>,
    pub(super) pattern: Option<Text>,
    pub(super) when: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct DefaultEntry {
    pub(super) fact: Text,
    pub(super) when: Text,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum TimeEntry {
    Start,
    Always,
    End,
    Tidy,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RuleEntry {
    pub(super) name: Text,
    pub(super) holds: TimeEntry,
    pub(super) condition: Text,
    pub(super) says: Text,
    #[serde(default)]
    pub(super) unless: Vec<Text>,
}

#[derive(Debug, Deserialize, Default)]
#[serde(deny_unknown_fields)]
pub(super) struct RepairEntry {
    pub(super) insert: Option<Spanned<u32>>,
    pub(super) replace: Option<Spanned<u32>>,
    pub(super) other_actor: Option<Spanned<u32>>,
    pub(super) postpone: Option<Spanned<u32>>,
    pub(super) rebind: Option<Spanned<u32>>,
    pub(super) drop_idle: Option<Spanned<u32>>,
    pub(super) drop_impossible: Option<Spanned<u32>>,
    pub(super) drop: Option<Spanned<u32>>,
    pub(super) other_relation: Option<Spanned<u32>>,
    pub(super) forgo: Option<Spanned<u32>>,
    pub(super) unsettle: Option<Spanned<u32>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct GoalEntry {
    pub(super) form: Text,
    pub(super) parameters: Text,
    pub(super) condition: Text,
    pub(super) offered: Option<Text>,
    #[serde(default)]
    pub(super) cues: Vec<String>,
    #[serde(default)]
    pub(super) destination_verbs: Vec<String>,
    #[serde(default)]
    pub(super) yields_to: Vec<String>,
    #[serde(default)]
    pub(super) phrases: Vec<Text>,
    pub(super) subject: Option<Text>,
    pub(super) exclusive: Option<String>,
    #[serde(default)]
    pub(super) disturbs: Vec<Text>,
    pub(super) says: Text,
    pub(super) means: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct AcceptEntry {
    pub(super) lint: Text,
    pub(super) of: Vec<String>,
    pub(super) why: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FeedbackFile {
    #[serde(default)]
    pub(super) example: Vec<FeedbackEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FeedbackEntry {
    pub(super) instruction: String,
    pub(super) plan: Vec<String>,
    pub(super) says: String,
    pub(super) answer: Text,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExamplesFile {
    #[serde(default)]
    pub(super) example: Vec<ExampleEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ExampleEntry {
    pub(super) objects: IndexMap<String, String>,
    pub(super) places: IndexMap<String, String>,
    pub(super) instruction: String,
    pub(super) answer: Text,
}
