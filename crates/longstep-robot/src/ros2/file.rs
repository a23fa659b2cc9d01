//! The schema of `robot.toml`. [`super::configuration`] interprets it.

use indexmap::IndexMap;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value};
use toml::Spanned;

pub(super) type Text = Spanned<String>;

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    pub(super) name: Text,
    pub(super) url: Text,
    #[serde(default)]
    pub(super) simulated: bool,
    /// The actions that may be performed.
    pub(super) allow: Vec<Text>,
    /// Orders at the same time.
    pub(super) parallel: Option<Spanned<usize>>,
    /// Orders a second.
    pub(super) rate: Option<Spanned<f64>>,
    /// Predicates without a state word, of which the observations list all facts.
    #[serde(default)]
    pub(super) reports: Vec<Text>,
    #[serde(default)]
    pub(super) timeouts: TimeoutEntry,
    pub(super) heartbeat: Option<HeartbeatEntry>,
    pub(super) stop: Option<ServiceEntry>,
    #[serde(default)]
    pub(super) table: IndexMap<Text, IndexMap<String, Value>>,
    #[serde(default)]
    pub(super) action: Vec<ActionEntry>,
    #[serde(default)]
    pub(super) observation: Vec<ObservationEntry>,
    /// The topics and services of a server.
    #[serde(default)]
    pub(super) serve: ServeEntry,
    /// Levels of autonomy and limits, which [`longstep_core::autonomy`] reads.
    #[serde(default, rename = "autonomy")]
    _autonomy: IgnoredAny,
    #[serde(default, rename = "limit")]
    _limit: IgnoredAny,
}

/// Timeouts in seconds.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct TimeoutEntry {
    pub(super) connect: Option<Spanned<f64>>,
    pub(super) accept: Option<Spanned<f64>>,
    pub(super) perform: Option<Spanned<f64>>,
    pub(super) observe: Option<Spanned<f64>>,
    pub(super) stop: Option<Spanned<f64>>,
    pub(super) silence: Option<Spanned<f64>>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct HeartbeatEntry {
    pub(super) topic: Text,
    /// In seconds.
    pub(super) period: Option<Spanned<f64>>,
}

/// The topics and services of `longstep serve --ros2`.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ServeEntry {
    pub(super) namespace: Option<Text>,
    /// True if a caller may approve a plan.
    #[serde(default)]
    pub(super) approve: bool,
    /// True if there are services besides the topics for requests.
    #[serde(default)]
    pub(super) services: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ServiceEntry {
    pub(super) service: Text,
    #[serde(rename = "type")]
    pub(super) kind: Text,
    #[serde(default)]
    pub(super) request: Map<String, Value>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ActionEntry {
    /// An action of the domain, or `*` for all that have no entry.
    pub(super) name: Text,
    pub(super) server: Spanned<Servers>,
    #[serde(rename = "type")]
    pub(super) kind: Text,
    pub(super) goal: Spanned<Map<String, Value>>,
    /// In seconds.
    pub(super) timeout: Option<Spanned<f64>>,
    /// The fields of a result with which the step is done; otherwise it failed.
    pub(super) done: Option<Spanned<Map<String, Value>>>,
    /// The path of the reason in a result.
    pub(super) reason: Option<Text>,
    /// The path of the outcome in a result.
    pub(super) outcome: Option<Text>,
    #[serde(default)]
    pub(super) outcomes: Vec<OutcomeEntry>,
    #[serde(default)]
    pub(super) feedback: FeedbackEntry,
    #[serde(default = "failed")]
    pub(super) aborted: Consequence,
    #[serde(default = "stop")]
    pub(super) cancelled: Consequence,
    #[serde(default = "stop")]
    pub(super) rejected: Consequence,
}

/// The name of an action server, or of one for each lane.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[serde(untagged)]
pub(super) enum Servers {
    One(String),
    ByLane(IndexMap<String, String>),
}

/// The consequence of a goal that did not succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(super) enum Consequence {
    /// The step failed; the world is observed, and the plan mended.
    Failed,
    /// The robot is stopped, and the run ends.
    Stop,
}

fn failed() -> Consequence {
    Consequence::Failed
}

fn stop() -> Consequence {
    Consequence::Stop
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OutcomeEntry {
    /// A fact: `(expired {item})`.
    pub(super) is: Text,
    pub(super) when: Spanned<Map<String, Value>>,
}

#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct FeedbackEntry {
    pub(super) fraction: Option<Text>,
    pub(super) text: Option<Text>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ObservationEntry {
    pub(super) topic: Option<Text>,
    pub(super) service: Option<Text>,
    #[serde(rename = "type")]
    pub(super) kind: Text,
    pub(super) request: Option<Spanned<Map<String, Value>>>,
    /// True for a topic on which the last message stays true, however old it is.
    #[serde(default)]
    pub(super) latched: bool,
    /// The path of a text that holds JSON, which is read instead of the message.
    pub(super) json: Option<Text>,
    pub(super) each: Option<Spanned<Lists>>,
    pub(super) entity: Option<Text>,
    /// The path of the statements in an element.
    pub(super) states: Option<Text>,
    #[serde(default)]
    pub(super) say: Vec<SayEntry>,
    /// The path of statements without a subject in the message.
    pub(super) facts: Option<Text>,
}

/// The path of a list of elements, or the paths of lists that are joined element by element.
#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
pub(super) enum Lists {
    One(String),
    Joined(Vec<String>),
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SayEntry {
    /// A statement about the entity.
    pub(super) state: Option<Text>,
    /// A statement without a subject.
    pub(super) fact: Option<Text>,
    pub(super) when: Option<Spanned<Map<String, Value>>>,
}
