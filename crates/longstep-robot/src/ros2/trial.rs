//! Trials of a connection: what the configuration names is looked for, without moving anything.

use std::time::Duration;

use longstep_core::environment::{ObservedFacts as Seen, World};
use longstep_core::model::Domain;
use serde_json::Value;

use super::configuration::{Configuration, Origin};
use super::link::Answer;
use super::{Ros2, message};
use crate::drive::reports;
use crate::error::RobotError;
use crate::robot::Robot;

/// A type that every bridge knows, and that no action server has.
const OTHER_TYPE: &str = "std_msgs/msg/Empty";
/// The wait for a complaint about a type, which a bridge sends at once if at all.
const COMPLAINT: Duration = Duration::from_millis(700);
/// The time that the answer of a bridge may take beyond the timeout that it was given itself.
const MARGIN: Duration = Duration::from_millis(500);

/// The service of rosbridge_server that tells its parameters, by the usual name of its node.
const PARAMETERS: &str = "/rosbridge_websocket/get_parameters";
/// The parameter without which a goal keeps everything else waiting.
const NEW_THREAD: &str = "send_action_goals_in_new_thread";
/// The wait for the parameters of a bridge. One that has none says so at once, or never.
const TELLING: Duration = Duration::from_millis(1500);
/// The number of a parameter that is true or false, in `rcl_interfaces/msg/ParameterType`.
const IS_BOOL: u64 = 1;

/// The result of looking for one thing.
#[derive(Debug, Clone, PartialEq)]
pub struct Trial {
    /// The part that was looked for: the bridge, a server, a topic, a service.
    pub subject: String,
    /// The finding.
    pub result: Result<String, RobotError>,
}

/// Tries the connection: the bridge, every allowed server, every observation. Nothing moves; services of observations are
/// called.
pub fn trials(configuration: Configuration, domain: &Domain, world: Option<&World>) -> Vec<Trial> {
    let subject = configuration.url.written.clone();
    let robot = match Ros2::open(configuration, domain) {
        Ok(robot) => robot,
        Err(error) => {
            let result = Err(error);
            return vec![Trial { subject, result }];
        }
    };
    let result = robot.find_threads().map(|threads| threads.to_owned());
    let is_blocked = result.is_err();
    let mut trials = vec![Trial { subject, result }];
    if is_blocked {
        return trials;
    }
    for (server, kind) in robot.mapping.configuration.servers() {
        let found = robot.find_server(server, kind);
        let says = |is_sure| {
            if is_sure {
                format!("answers, {kind}")
            } else {
                format!("answers; the bridge does not say if its type is {kind}")
            }
        };
        trials.push(Trial {
            subject: server.to_owned(),
            result: found.map(says),
        });
    }
    if !robot.mapping.configuration.observations.is_empty() {
        trials.push(robot.try_observation(world));
    }
    trials
}

impl Ros2 {
    /// Asks the bridge if it passes messages on while a goal is under way. A bridge that is no rosbridge_suite, or whose node
    /// has another name, does not say: then the heartbeats of a run show it.
    ///
    /// # Errors
    ///
    /// [`RobotError::Blocked`] for a bridge that says no.
    pub(super) fn find_threads(&self) -> Result<&'static str, RobotError> {
        let request = serde_json::json!({"names": [NEW_THREAD]});
        let kind = Some("rcl_interfaces/srv/GetParameters");
        let ask = |id: &str| message::call(id, PARAMETERS, kind, &request, TELLING.as_secs_f64());
        let answer = self.ask(ask, TELLING)?.filter(|answer| answer.is_success);
        let parameter = answer.as_ref().and_then(|answer| answer.values.pointer("/values/0"));
        let is_bool = |parameter: &&Value| parameter["type"].as_u64() == Some(IS_BOOL);
        match parameter
            .filter(is_bool)
            .and_then(|parameter| parameter["bool_value"].as_bool())
        {
            Some(false) => {
                let reason = format!("its parameter `{NEW_THREAD}` is false");
                Err(self.lock().fail(RobotError::Blocked { reason }))
            }
            Some(true) => Ok("connected; goals have threads of their own"),
            None => Ok("connected; the bridge does not say if goals have threads of their own"),
        }
    }

    /// Looks for an action server: its service for cancelling is asked for a goal that does not exist, which moves nothing.
    /// Returns true if its type is known to be right.
    pub(super) fn find_server(&self, server: &str, kind: &str) -> Result<bool, RobotError> {
        let limit = self.mapping.configuration.limits.connect;
        let missing = |reason: String| RobotError::Missing {
            kind: "action server",
            name: server.to_owned(),
            reason,
        };
        let ask = |id: &str| message::cancel_call(id, server, Some(*b"longstep looks\0\0"), limit.as_secs_f64());
        match self.ask(ask, limit + MARGIN)? {
            Some(Answer { is_success: true, .. }) => self.type_is(server, kind),
            Some(Answer { values, .. }) => Err(missing(words(&values))),
            None => Err(missing(format!("no answer within {} s", limit.as_secs_f64()))),
        }
    }

    /// Asks for the type of an action server, by a subscription that cannot fit: the complaint of the bridge names the right
    /// type. Returns false if the bridge does not complain.
    fn type_is(&self, server: &str, kind: &str) -> Result<bool, RobotError> {
        let topic = format!("{server}/_action/feedback");
        let answer = self.ask(|id| message::subscribe(id, &topic, OTHER_TYPE), COMPLAINT)?;
        let complaint = answer.map_or(String::new(), |answer| words(&answer.values));
        let names = |kind: &str| complaint.contains(&format!("{kind}_FeedbackMessage"));
        if names(kind) {
            return Ok(true);
        }
        if names("") {
            return Err(RobotError::WrongType {
                name: server.to_owned(),
                expected: kind.to_owned(),
                reason: complaint,
            });
        }
        let mut link = self.lock();
        let id = link.next_id();
        link.send(&message::unsubscribe(&id, &topic));
        Ok(false)
    }

    /// Subscribes the topics of the observations.
    pub(super) fn subscribe_observations(&self) -> Result<(), RobotError> {
        let mut link = self.lock();
        for rule in &self.mapping.configuration.observations {
            if let Origin::Topic { name, .. } = &rule.origin {
                link.subscribe(name, &rule.kind)?;
            }
        }
        Ok(())
    }

    fn try_observation(&self, world: Option<&World>) -> Trial {
        let observed = self.subscribe_observations().and_then(|()| self.observe_all());
        let read = observed.and_then(|observation| {
            let entities = observation.states.len();
            let Some(world) = world else {
                return Ok(format!("entities described: {entities}"));
            };
            let reported = reports(self as &dyn Robot, world)?;
            let seen = Seen::read(world, &reported, &observation);
            let seen = seen.map_err(|error| message::broken(error.to_string()))?;
            Ok(match seen.unknown.len() {
                0 => format!("entities described: {entities}, all in the environment"),
                _ => format!(
                    "entities described: {entities}; not in the environment: {}",
                    seen.unknown.iter().take(5).cloned().collect::<Vec<_>>().join(", ")
                ),
            })
        });
        Trial {
            subject: "observation".to_owned(),
            result: read,
        }
    }
}

fn words(values: &Value) -> String {
    let text = values.as_str().map_or_else(|| values.to_string(), str::to_owned);
    message::quotation(&text)
}
