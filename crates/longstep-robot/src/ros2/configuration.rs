//! The content of `robot.toml`. [`super::read`] reads it, and [`super::check`] compares it with a domain.

use std::collections::BTreeMap;
use std::ops::Range;
use std::time::Duration;

use indexmap::IndexMap;
use longstep_core::autonomy::Autonomy;
use longstep_core::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_core::environment::World;
use longstep_core::model::Domain;
use serde_json::Value;

use super::criterion::Criterion;
use super::file::{Consequence, Lists, Servers, Text};
use super::template::{Table, Template};
use crate::lock;
use crate::rosbridge::Address;

/// The mark for every action without an entry of its own.
pub(super) const ANY: &str = "*";
/// The configuration of a robot behind a bridge to ROS 2: `robot.toml`.
///
/// ```
/// use longstep_robot::ros2::Configuration;
/// let text = r#"
/// name = "arm"
/// url = "ws://127.0.0.1:9090"
/// allow = ["grasp"]
/// [[action]]
/// name = "*"
/// server = "/execute_step"
/// type = "longstep_msgs/action/ExecuteStep"
/// goal = { action = "{action}", arguments = "{arguments}" }
/// [[observation]]
/// service = "/observe"
/// type = "longstep_msgs/srv/Observe"
/// each = "states"
/// entity = "{entity}"
/// states = "statements"
/// "#;
/// assert_eq!(Configuration::parse("robot.toml", text).unwrap().name(), "arm");
/// let wrong = Configuration::parse("robot.toml", &text.replace("{action}", "{action")).unwrap_err();
/// assert_eq!(wrong.to_string(), "robot.toml:9:20: `{action` is not closed");
/// ```
#[derive(Debug, Clone)]
pub struct Configuration {
    pub(super) source: Source,
    pub(super) name: String,
    pub(super) url: Address,
    pub(super) simulated: bool,
    pub(super) allow: Vec<Text>,
    pub(super) parallel: usize,
    /// The least time between two orders.
    pub(super) interval: Duration,
    pub(super) reports: Vec<Text>,
    pub(super) limits: Limits,
    pub(super) heartbeat: Option<Heartbeat>,
    pub(super) stop: Option<Service>,
    pub(super) tables: BTreeMap<String, Table>,
    pub(super) actions: Vec<ActionRule>,
    pub(super) observations: Vec<ObservationRule>,
    pub(super) serving: Serving,
}

/// The topics and services of `longstep serve --ros2`: the table `[serve]` of `robot.toml`.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Serving {
    /// The beginning of the names of all topics and services.
    pub namespace: String,
    /// True if a caller may approve a plan; otherwise it can only begin what a person approved elsewhere.
    pub approve: bool,
    /// True if there are services besides the topics for requests. Their type is `longstep_msgs/srv/Ask`.
    pub services: bool,
}

impl Default for Serving {
    fn default() -> Self {
        Self {
            namespace: "/longstep".to_owned(),
            approve: false,
            services: false,
        }
    }
}

/// The text of `robot.toml`, for the places of findings.
#[derive(Debug, Clone)]
pub(super) struct Source {
    pub(super) file: String,
    pub(super) text: String,
}

/// How long the bridge and the servers may take.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Limits {
    pub(super) connect: Duration,
    /// To the first sign that a goal was accepted.
    pub(super) accept: Duration,
    pub(super) perform: Duration,
    pub(super) observe: Duration,
    pub(super) stop: Duration,
    /// Without any message of the bridge.
    pub(super) silence: Duration,
}

#[derive(Debug, Clone)]
pub(super) struct Heartbeat {
    pub(super) topic: String,
    pub(super) period: Duration,
}

#[derive(Debug, Clone)]
pub(super) struct Service {
    pub(super) name: String,
    pub(super) kind: String,
    pub(super) request: Value,
}

/// How an action of the domain is performed.
#[derive(Debug, Clone)]
pub(super) struct ActionRule {
    /// The action, or [`ANY`].
    pub(super) name: Text,
    pub(super) servers: Servers,
    pub(super) server_span: Range<usize>,
    pub(super) kind: String,
    pub(super) goal: Template,
    pub(super) goal_span: Range<usize>,
    pub(super) timeout: Option<Duration>,
    pub(super) done: Criterion,
    pub(super) reason: Option<String>,
    pub(super) outcome: Option<String>,
    pub(super) outcomes: Vec<OutcomeRule>,
    pub(super) fraction: Option<String>,
    pub(super) text: Option<String>,
    pub(super) aborted: Consequence,
    pub(super) cancelled: Consequence,
    pub(super) rejected: Consequence,
}

#[derive(Debug, Clone)]
pub(super) struct OutcomeRule {
    pub(super) fact: Template,
    pub(super) span: Range<usize>,
    pub(super) when: Criterion,
}

/// How messages become statements.
#[derive(Debug, Clone)]
pub(super) struct ObservationRule {
    pub(super) origin: Origin,
    pub(super) kind: String,
    pub(super) json: Option<String>,
    pub(super) each: Option<Lists>,
    pub(super) entity: Option<Template>,
    pub(super) states: Option<String>,
    pub(super) say: Vec<SayRule>,
    pub(super) facts: Option<String>,
}

/// Where the messages of an observation come from.
#[derive(Debug, Clone)]
pub(super) enum Origin {
    Topic { name: String, latched: bool },
    Service { name: String, request: Value },
}

impl Origin {
    /// The name of the topic or service.
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Topic { name, .. } | Self::Service { name, .. } => name,
        }
    }
}

/// A statement that follows from an element.
#[derive(Debug, Clone)]
pub(super) struct SayRule {
    pub(super) text: Template,
    pub(super) span: Range<usize>,
    /// True for a statement without a subject.
    pub(super) is_fact: bool,
    pub(super) when: Criterion,
}

impl Source {
    /// Returns the position of a place.
    pub(super) fn position(&self, place: usize) -> Position {
        Position::of(&self.text, place)
    }

    /// Returns the position of a part of a text in a span, or of the span's beginning.
    pub(super) fn position_of(&self, span: &Range<usize>, part: &str) -> Position {
        let start = span.start.min(self.text.len());
        let found = self.text.get(start..).and_then(|rest| rest.find(part));
        self.position(start + found.unwrap_or_default())
    }

    /// Returns a finding at a part of a text.
    pub(super) fn finding(&self, span: &Range<usize>, part: &str, message: impl Into<String>) -> Diagnostic {
        Diagnostic::at(&self.file, self.position_of(span, part), message)
    }

    /// Returns a finding about an unknown name.
    pub(super) fn unknown<'n>(
        &self,
        span: &Range<usize>,
        kind: &str,
        name: &str,
        known: impl IntoIterator<Item = &'n str>,
    ) -> Diagnostic {
        let finding = self.finding(span, name, format!("unknown {kind} `{name}`"));
        match nearest(name, known) {
            Some(near) => finding.hint(format!("did you mean `{near}`?")),
            None => finding,
        }
    }
}

impl Configuration {
    /// The name of the robot.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// True for a robot in a simulation: it moves without `--live`.
    pub fn is_simulated(&self) -> bool {
        self.simulated
    }

    /// The address of the bridge.
    pub fn address(&self) -> &Address {
        &self.url
    }

    /// The topics and services of a server behind the bridge.
    pub fn serving(&self) -> &Serving {
        &self.serving
    }

    /// The longest wait for a connection to the bridge.
    pub fn connect_limit(&self) -> Duration {
        self.limits.connect
    }

    /// The longest time without any message of the bridge.
    pub fn silence_limit(&self) -> Duration {
        self.limits.silence
    }

    /// Reads the levels of autonomy and the limits of the robot. Places are looked up in the world, if there is one.
    ///
    /// # Errors
    ///
    /// All mistakes in them, with their places.
    pub fn autonomy(&self, domain: &Domain, world: Option<&World>) -> Result<Autonomy, Diagnostics> {
        Autonomy::parse_within(domain, world, &self.source.file, &self.source.text)
    }

    /// The parts that the robot drives, by the names of their locks: each action server of its bridge.
    pub fn drives(&self) -> Vec<String> {
        let host = lock::computer(&self.url.host);
        let servers = self.servers().into_keys();
        servers
            .map(|server| format!("ros2 {host}:{} {server}", self.url.port))
            .collect()
    }

    /// Returns the rule for an action of the domain that the robot may perform.
    pub(super) fn rule(&self, action: &str) -> Option<&ActionRule> {
        if !self.allow.iter().any(|own| own.get_ref() == action) {
            return None;
        }
        let named = |name: &str| self.actions.iter().find(|rule| rule.name.get_ref() == name);
        named(action).or_else(|| named(ANY))
    }

    /// The servers of all actions that the robot may perform, each once, with their types.
    pub(super) fn servers(&self) -> IndexMap<&str, &str> {
        let rules = self.allow.iter().filter_map(|action| self.rule(action.get_ref()));
        rules
            .flat_map(|rule| rule.servers().map(|server| (server, rule.kind.as_str())))
            .collect()
    }
}

impl ActionRule {
    /// All servers of the action.
    pub(super) fn servers(&self) -> impl Iterator<Item = &str> {
        let (one, by_lane) = match &self.servers {
            Servers::One(server) => (Some(server), None),
            Servers::ByLane(servers) => (None, Some(servers.values())),
        };
        one.into_iter().chain(by_lane.into_iter().flatten()).map(String::as_str)
    }

    /// The server for a lane.
    pub(super) fn server_of(&self, lane: Option<&str>) -> Option<&str> {
        match &self.servers {
            Servers::One(server) => Some(server),
            Servers::ByLane(servers) => servers.get(lane?).map(String::as_str),
        }
    }
}
