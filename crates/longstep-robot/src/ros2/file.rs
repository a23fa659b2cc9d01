//! The schema of `robot.toml`. [`super::configuration`] interprets it.

use indexmap::IndexMap;
use longstep_core::spanned::Spanned;
use serde::Deserialize;
use serde::de::IgnoredAny;
use serde_json::{Map, Value};

pub(super) type Text = Spanned<String>;

/// Returns the JSON Schema of `robot.toml`.
///
/// ```
/// assert!(longstep_robot::ros2::schema()["properties"]["action"].is_object());
/// ```
#[cfg(feature = "schema")]
pub fn schema() -> Value {
    let mut schema = longstep_core::schema::of::<RobotFile>("A robot in ROS 2 for Longstep: robot.toml");
    let mut own = longstep_core::autonomy::schema();
    for key in ["properties", "definitions"] {
        if let (Some(Value::Object(all)), Some(Value::Object(more))) = (schema.get_mut(key), own.get_mut(key)) {
            all.append(more);
        }
    }
    schema
}

/// A robot in ROS 2: its actions as goals of action servers, and its observations as messages.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct RobotFile {
    /// The name of the robot.
    pub(super) name: Text,
    /// The address of the bridge: `ws://127.0.0.1:9090`.
    pub(super) url: Text,
    /// True if nothing moves.
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
    /// Timeouts in seconds.
    #[serde(default)]
    pub(super) timeouts: TimeoutEntry,
    /// A sign of life that is published during a run.
    pub(super) heartbeat: Option<HeartbeatEntry>,
    /// The service that stops the robot.
    pub(super) stop: Option<ServiceEntry>,
    /// Tables of values, by name, for the fields of messages.
    #[serde(default)]
    pub(super) table: IndexMap<Text, IndexMap<String, Value>>,
    /// The actions of the robot.
    #[serde(default)]
    pub(super) action: Vec<ActionEntry>,
    /// The messages that tell about the world.
    #[serde(default)]
    pub(super) observation: Vec<ObservationEntry>,
    /// The topics and services of a server.
    #[serde(default)]
    pub(super) serve: ServeEntry,
    /// Levels of autonomy and limits, which [`longstep_core::autonomy`] reads.
    #[serde(default, rename = "autonomy")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _autonomy: IgnoredAny,
    #[serde(default, rename = "limit")]
    #[cfg_attr(feature = "schema", schemars(skip))]
    _limit: IgnoredAny,
}

/// Timeouts in seconds.
#[derive(Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct TimeoutEntry {
    /// For a connection.
    pub(super) connect: Option<Spanned<f64>>,
    /// For the acceptance of a goal.
    pub(super) accept: Option<Spanned<f64>>,
    /// For an action.
    pub(super) perform: Option<Spanned<f64>>,
    /// For an observation.
    pub(super) observe: Option<Spanned<f64>>,
    /// For a stop.
    pub(super) stop: Option<Spanned<f64>>,
    /// For messages of an observation.
    pub(super) silence: Option<Spanned<f64>>,
}

/// A sign of life.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct HeartbeatEntry {
    /// The topic.
    pub(super) topic: Text,
    /// In seconds.
    pub(super) period: Option<Spanned<f64>>,
}

/// The topics and services of `longstep serve --ros2`.
#[derive(Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ServeEntry {
    /// The namespace of the topics.
    pub(super) namespace: Option<Text>,
    /// True if a caller may approve a plan.
    #[serde(default)]
    pub(super) approve: bool,
    /// True if there are services besides the topics for requests.
    #[serde(default)]
    pub(super) services: bool,
}

/// A service.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ServiceEntry {
    /// The name of the service.
    pub(super) service: Text,
    /// The type of the service.
    #[serde(rename = "type")]
    pub(super) kind: Text,
    /// The fields of the request.
    #[serde(default)]
    pub(super) request: Map<String, Value>,
}

/// An action of the domain, as a goal of an action server.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ActionEntry {
    /// An action of the domain, or `*` for all that have no entry.
    pub(super) name: Text,
    /// The action server.
    pub(super) server: Spanned<Servers>,
    /// The type of the action.
    #[serde(rename = "type")]
    pub(super) kind: Text,
    /// The fields of the goal.
    pub(super) goal: Spanned<Map<String, Value>>,
    /// In seconds.
    pub(super) timeout: Option<Spanned<f64>>,
    /// The fields of a result with which the step is done; otherwise it failed.
    pub(super) done: Option<Spanned<Map<String, Value>>>,
    /// The path of the reason in a result.
    pub(super) reason: Option<Text>,
    /// The path of the outcome in a result.
    pub(super) outcome: Option<Text>,
    /// The outcomes of a sensing action.
    #[serde(default)]
    pub(super) outcomes: Vec<OutcomeEntry>,
    /// The paths of the progress in a feedback message.
    #[serde(default)]
    pub(super) feedback: FeedbackEntry,
    /// The consequence of an aborted goal.
    #[serde(default = "failed")]
    pub(super) aborted: Consequence,
    /// The consequence of a cancelled goal.
    #[serde(default = "stop")]
    pub(super) cancelled: Consequence,
    /// The consequence of a rejected goal.
    #[serde(default = "stop")]
    pub(super) rejected: Consequence,
}

/// The name of an action server, or of one for each lane.
#[derive(Debug, Clone, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum Servers {
    /// One for all.
    One(String),
    /// One for each lane.
    ByLane(IndexMap<String, String>),
}

/// The consequence of a goal that did not succeed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
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

/// An outcome of a sensing action.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct OutcomeEntry {
    /// A fact: `(expired {item})`.
    pub(super) is: Text,
    /// The fields of a result with which it holds.
    pub(super) when: Spanned<Map<String, Value>>,
}

/// The progress of a goal.
#[derive(Debug, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct FeedbackEntry {
    /// The path of the share that is done, from 0 to 1.
    pub(super) fraction: Option<Text>,
    /// The path of a text.
    pub(super) text: Option<Text>,
}

/// A message that tells about the world.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct ObservationEntry {
    /// The topic.
    pub(super) topic: Option<Text>,
    /// The service.
    pub(super) service: Option<Text>,
    /// The type of the message, or of the service.
    #[serde(rename = "type")]
    pub(super) kind: Text,
    /// The fields of the request.
    pub(super) request: Option<Spanned<Map<String, Value>>>,
    /// True for a topic on which the last message stays true, however old it is.
    #[serde(default)]
    pub(super) latched: bool,
    /// The path of a text that holds JSON, which is read instead of the message.
    pub(super) json: Option<Text>,
    /// The path of a list of elements, one for each entity.
    pub(super) each: Option<Spanned<Lists>>,
    /// The entity of an element.
    pub(super) entity: Option<Text>,
    /// The path of the statements in an element.
    pub(super) states: Option<Text>,
    /// The statements about an element.
    #[serde(default)]
    pub(super) say: Vec<SayEntry>,
    /// The path of statements without a subject in the message.
    pub(super) facts: Option<Text>,
}

/// The path of a list of elements, or the paths of lists that are joined element by element.
#[derive(Debug, Clone, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(untagged)]
pub(super) enum Lists {
    /// The path of one list.
    One(String),
    /// The paths of lists that are joined element by element.
    Joined(Vec<String>),
}

/// A statement.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub(super) struct SayEntry {
    /// A statement about the entity.
    pub(super) state: Option<Text>,
    /// A statement without a subject.
    pub(super) fact: Option<Text>,
    /// The fields with which it holds.
    pub(super) when: Option<Spanned<Map<String, Value>>>,
}
