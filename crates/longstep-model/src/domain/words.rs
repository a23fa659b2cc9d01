//! The schema of `domain.toml` and `prompt/examples.toml`. [`super::load()`] interprets it.

use indexmap::IndexMap;
use serde::Deserialize;

use crate::spanned::Spanned;

type Text = Spanned<String>;

/// The words for a domain: `domain.toml` beside `domain.pddl`.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DomainFile {
    /// The name of the domain.
    pub name: String,
    /// A sentence about the robot.
    pub about: String,
    /// The types of the two lists of an environment.
    pub environment: EnvironmentEntry,
    /// The words of each predicate.
    #[serde(default)]
    pub predicate: Vec<PredicateEntry>,
    /// The words of each action.
    #[serde(default)]
    pub action: Vec<ActionEntry>,
    /// Words of an environment for facts about an entity.
    #[serde(default)]
    pub state: Vec<StateEntry>,
    /// Words of the numeric functions.
    #[serde(default)]
    pub number: Vec<NumberEntry>,
    /// Words of an environment for what never changes about an entity.
    #[serde(default)]
    pub property: Vec<PropertyEntry>,
    /// Facts that follow from names or from other facts.
    #[serde(default)]
    pub derive: Vec<DeriveEntry>,
    /// Facts that hold unless the environment mentions them.
    #[serde(default)]
    pub default: Vec<DefaultEntry>,
    /// Conditions for good plans.
    #[serde(default)]
    pub rule: Vec<RuleEntry>,
    /// The kinds of goals that people can ask for.
    #[serde(default)]
    pub goal: Vec<GoalEntry>,
    /// Lint findings that the author accepts.
    #[serde(default)]
    pub accept: Vec<AcceptEntry>,
    /// The cost of each edit of a repair.
    #[serde(default)]
    pub repair: RepairEntry,
    /// Types of quantities or texts, by the name of the type.
    #[serde(default)]
    pub value: IndexMap<Text, ValueEntry>,
    /// Names of identifiers: the one that is shown, a longer one, and synonyms.
    #[serde(default)]
    pub lexicon: IndexMap<Text, Vec<Text>>,
    /// Stems of words that refer to an entity without naming it, by the last word of its identifier.
    #[serde(default)]
    pub implied: IndexMap<Text, Vec<Text>>,
    /// The article before everyday names: `the` by default, an empty text for none.
    pub article: Option<Text>,
    /// Words for the person who gives an instruction, such as `me`.
    #[serde(default)]
    pub speaker_names: Vec<Text>,
    /// Words for the robot, such as `you`.
    #[serde(default)]
    pub robot_names: Vec<Text>,
}

/// The types of the two lists of an environment.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct EnvironmentEntry {
    /// The type of what stays in its place.
    pub assets: Text,
    /// The type of what can be moved.
    pub objects: Text,
}

/// The words of a predicate.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PredicateEntry {
    /// Its name in `domain.pddl`.
    pub name: Text,
    /// A sentence for a fact, with the parameters in braces, without a full stop.
    pub says: Text,
    /// A sentence for its opposite, with the parameters in braces.
    pub denies: Text,
    /// The fact in the entry of its first argument, as a model sees it.
    pub short: Option<Text>,
    /// True for what happens and does not last: it is false at the start of every instruction.
    #[serde(default)]
    pub event: bool,
    /// `assume` if facts that environments often omit are assumed, and listed.
    #[serde(default)]
    pub unknown: UnknownEntry,
    /// True if an environment that gives one fact gives them all.
    #[serde(default)]
    pub complete: bool,
    /// Without effect.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>", extend("deprecated" = true)))]
    pub cues: Option<Obsolete>,
    /// An event for "it held once", for outcomes that actions remove.
    pub past: Option<Text>,
}

/// The value of a fact that an environment does not give.
#[derive(Debug, Deserialize, Default, Clone, Copy, PartialEq, Eq)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum UnknownEntry {
    /// It does not hold.
    #[default]
    False,
    /// It is assumed.
    Assume,
}

/// The words of an action.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ActionEntry {
    /// Its name in `domain.pddl`.
    pub name: Text,
    /// The notation in a plan, with the parameters that are written: `grasp({item})`.
    pub call: Text,
    /// The implicit parameter that a plan's `object_name` gives.
    pub object: Option<Text>,
    /// The parameter for the performer, if there is a choice.
    pub actor: Option<Text>,
    /// The outcomes of a sensing action: two or more facts, of which exactly one holds.
    #[serde(default)]
    pub senses: Vec<Text>,
    /// The explanation of a step, with the parameters in braces.
    pub says: Text,
    /// The explanation of the action for a model.
    pub means: String,
    /// The number of times that a run repeats a failed step; 2 by default.
    pub retries: Option<Spanned<u32>>,
    /// The skill parameters.
    #[serde(default)]
    pub skill: Vec<SkillEntry>,
}

/// A skill parameter of an action.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SkillEntry {
    /// Its name.
    pub name: Text,
    /// Its type.
    #[serde(rename = "type")]
    pub kind: Text,
    /// Its unit.
    pub unit: Option<Text>,
    /// Where its value comes from.
    pub from: Text,
    /// The way in which demonstrations give it.
    pub fit: Option<Text>,
    /// The values before any demonstration.
    pub prior: Option<Spanned<Vec<f64>>>,
}

/// The schema of `skills.toml`.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct SkillsFile {
    /// The name of the domain.
    pub name: Option<String>,
    /// The shipped domain that is extended.
    pub base: Option<String>,
    /// A sentence about the robot.
    pub about: Option<String>,
    /// The actions with their skill parameters.
    #[serde(default)]
    pub action: Vec<ActionSkillsEntry>,
}

/// The skill parameters of an action.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ActionSkillsEntry {
    /// The name of the action.
    pub name: Text,
    /// Its parameters.
    #[serde(default)]
    pub skill: Vec<SkillEntry>,
}

/// A word of an environment for a fact about an entity.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct StateEntry {
    /// The notation in an environment: `on_something(<something>)`.
    pub word: Text,
    /// The fact, where `?self` is the entity of the entry.
    pub fact: Text,
    /// The explanation for a model.
    pub means: String,
    /// The spatial relations that give it, for `longstep see`.
    #[serde(default)]
    pub geometry: Vec<Text>,
}

/// The words of a numeric function.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct NumberEntry {
    /// Its name in `domain.pddl`.
    pub name: Text,
    /// The word in an environment; by default the name.
    pub word: Option<Text>,
    /// The unit in messages.
    pub unit: Option<String>,
    /// The number in a sentence: `the level of {t}`.
    pub says: Option<Text>,
    /// The smallest number.
    pub min: Option<Spanned<NumberText>>,
    /// The largest number.
    pub max: Option<Spanned<NumberText>>,
}

/// A number, or a decimal in quotes. Floats are written with the fewest digits that identify them, which are the digits
/// in the file.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub enum NumberText {
    /// A whole number.
    Whole(i64),
    /// A decimal.
    Decimal(f64),
    /// A decimal in quotes.
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

/// A word of an environment for facts that never change.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct PropertyEntry {
    /// The notation in an environment.
    pub word: Text,
    /// The facts, where `?self` is the entity; negated ones too.
    pub facts: Vec<Text>,
}

/// Facts that follow from names or from other facts.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DeriveEntry {
    /// The facts; a negated one is not assumed.
    pub facts: Vec<Text>,
    /// Ends of identifiers of the first entity.
    #[serde(default)]
    pub names: Vec<Text>,
    /// Ends of identifiers of the second entity.
    #[serde(default)]
    pub other_names: Vec<Text>,
    /// An identifier inside another: `{other}_handle`.
    pub pattern: Option<Text>,
    /// The facts from which they follow.
    pub when: Option<Text>,
}

/// A fact that holds unless the environment mentions it.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct DefaultEntry {
    /// The fact.
    pub fact: Text,
    /// The condition.
    pub when: Text,
}

/// The time at which a rule binds.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(rename_all = "lowercase")]
pub enum TimeEntry {
    /// An environment that breaks it contradicts itself.
    Start,
    /// No step breaks it.
    Always,
    /// It holds at the end of every plan.
    End,
    /// It holds at the end of plans that are made from a goal.
    Tidy,
}

/// A condition for good plans.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RuleEntry {
    /// Its name.
    pub name: Text,
    /// The time at which it binds.
    pub holds: TimeEntry,
    /// The condition in PDDL; `(initially ...)` is about the first state.
    pub condition: Text,
    /// A sentence.
    pub says: Text,
    /// Goal words that suspend it.
    #[serde(default)]
    pub unless: Vec<Text>,
}

/// The costs of edits, from 1 to 1000.
#[derive(Debug, Deserialize, Default)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct RepairEntry {
    /// Adds a step; 4 by default.
    pub insert: Option<Spanned<u32>>,
    /// Another verb for the same objects; 5 by default.
    pub replace: Option<Spanned<u32>>,
    /// Another actor; 3 by default.
    pub other_actor: Option<Spanned<u32>>,
    /// Moves a step to a later place; 3 by default.
    pub postpone: Option<Spanned<u32>>,
    /// Another hidden argument than in the step's explanation; 2 by default.
    pub rebind: Option<Spanned<u32>>,
    /// Removes a step that would change nothing; 2 by default.
    pub drop_idle: Option<Spanned<u32>>,
    /// Removes a step that is impossible in this world; 4 by default.
    pub drop_impossible: Option<Spanned<u32>>,
    /// Removes a step that has an effect; 80 by default.
    pub drop: Option<Spanned<u32>>,
    /// Ends with another relation than claimed; 15 by default.
    pub other_relation: Option<Spanned<u32>>,
    /// Gives up a fact that is claimed to be new; 60 by default.
    pub forgo: Option<Spanned<u32>>,
    /// Gives up a fact that is claimed to be unchanged; 20 by default.
    pub unsettle: Option<Spanned<u32>>,
}

/// The value of a key that has no effect any more. Domains that have it still load, and a lint reports it.
pub type Obsolete = Spanned<toml::Value>;

/// A kind of goal.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct GoalEntry {
    /// The notation: `put({item}, {place})`.
    pub form: Text,
    /// The typed parameters, in PDDL.
    pub parameters: Text,
    /// The meaning, in PDDL.
    pub condition: Text,
    /// A condition on the arguments that make sense.
    pub offered: Option<Text>,
    /// Without effect.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>", extend("deprecated" = true)))]
    pub cues: Option<Obsolete>,
    /// Without effect.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>", extend("deprecated" = true)))]
    pub destination_verbs: Option<Obsolete>,
    /// Without effect.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>", extend("deprecated" = true)))]
    pub yields_to: Option<Obsolete>,
    /// Without effect.
    #[cfg_attr(feature = "schema", schemars(with = "Option<serde_json::Value>", extend("deprecated" = true)))]
    pub phrases: Option<Obsolete>,
    /// The parameter that an instruction has to name.
    pub subject: Option<Text>,
    /// A mark: goals that share it cannot both be asked for one object.
    pub exclusive: Option<String>,
    /// Parameters that achieving the goal may move.
    #[serde(default)]
    pub disturbs: Vec<Text>,
    /// A sentence for a person.
    pub says: Text,
    /// The act that a person asks the robot for, after "Should I".
    pub asks: Option<Text>,
    /// The explanation for a model.
    pub means: String,
}

/// A lint finding that the author accepts.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct AcceptEntry {
    /// The lint.
    pub lint: Text,
    /// The declarations that it is about.
    pub of: Vec<String>,
    /// The reason.
    pub why: Text,
}

/// A type of quantities or texts.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ValueEntry {
    /// The unit in which values are written; without it, plain numbers.
    pub unit: Option<Text>,
    /// Other units, each with its size in `unit`.
    #[serde(default)]
    pub units: IndexMap<Text, Spanned<NumberText>>,
    /// The smallest value.
    pub min: Option<Spanned<NumberText>>,
    /// The largest value.
    pub max: Option<Spanned<NumberText>>,
    /// True for texts.
    #[serde(default)]
    pub text: bool,
}
