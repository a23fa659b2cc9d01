//! The stop: every goal under way is cancelled, until each has ended or the time is over.

use std::collections::{BTreeMap, BTreeSet};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::LISTING;
use super::configuration::{Configuration, Service};
use crate::error::RobotError;
use crate::rosbridge::Connection;
use crate::rosbridge::message::{self, Incoming};

/// The time between two attempts to cancel, or to connect again.
pub(super) const AGAIN: Duration = Duration::from_millis(150);
/// The type of the topic on which a server says which goals it has.
const STATUS: &str = "action_msgs/msg/GoalStatusArray";
/// The largest status of a goal that has not ended.
const LAST_ACTIVE: i64 = 3;

/// A stop that is under way.
#[derive(Debug)]
pub(super) struct Stopping {
    pub(super) error: RobotError,
    /// The goals that have not ended, with their servers.
    goals: BTreeMap<String, String>,
    /// The service of `[stop]` has to answer.
    is_service_due: bool,
    limit: Duration,
    deadline: Instant,
    next: Instant,
    tries: u64,
    /// True if the goals were sent over an earlier connection: their results do not come over this one.
    is_new: bool,
    /// The time at which the servers were first asked over a new connection.
    asked: Option<Instant>,
    /// The servers that listed a goal under way, or accepted a cancellation: only their list shows the end.
    active: BTreeSet<String>,
    /// The servers that had nothing to cancel.
    idle: BTreeSet<String>,
    prefix: String,
}

/// A stop that is over.
#[derive(Debug)]
pub(super) struct Ended {
    pub(super) error: RobotError,
    pub(super) stop: Result<(), RobotError>,
}

impl Stopping {
    /// Begins a stop for an error.
    pub(super) fn new(error: RobotError, goals: BTreeMap<String, String>, prefix: &str, limits: StopFacts) -> Self {
        let now = Instant::now();
        Self {
            error,
            is_service_due: limits.has_service,
            goals,
            limit: limits.stop,
            deadline: now + limits.stop,
            next: now,
            tries: 0,
            is_new: !limits.is_connected,
            asked: None,
            active: BTreeSet::new(),
            idle: BTreeSet::new(),
            prefix: format!("{prefix}-stop"),
        }
    }

    /// Uses a message of the bridge.
    pub(super) fn file(&mut self, incoming: &Incoming) {
        match incoming {
            Incoming::Result { id, .. } => {
                self.goals.remove(id);
            }
            Incoming::Response { id, is_success, values } => {
                let Some(request) = id.strip_prefix(&self.prefix) else {
                    return;
                };
                if request.starts_with("-service-") {
                    let refused = values.get("success").and_then(Value::as_bool) == Some(false);
                    self.is_service_due &= !is_success || refused;
                } else if self.is_new && *is_success {
                    let server = request
                        .split_once('/')
                        .map_or(String::new(), |(_, name)| format!("/{name}"));
                    if has_nothing_to_cancel(values) {
                        self.idle.insert(server);
                    } else if accepted(values) > 0 {
                        self.active.insert(server);
                    }
                }
            }
            Incoming::Published { topic, message } if self.is_new => {
                if let Some(server) = topic.strip_suffix("/_action/status") {
                    if has_no_active_goal(message) {
                        self.clear(server);
                    } else {
                        self.active.insert(server.to_owned());
                    }
                }
            }
            _ => {}
        }
    }

    fn clear(&mut self, server: &str) {
        self.goals.retain(|_, own| own != server);
    }

    /// Counts the goals of servers as ended that had nothing to cancel and listed nothing in time: a server that had goals lists them
    /// at once, and one that accepts no cancellation has nothing to cancel either.
    fn settle(&mut self, now: Instant) {
        if self.asked.is_some_and(|asked| now.duration_since(asked) >= LISTING) {
            let ended: BTreeSet<&String> = self.idle.difference(&self.active).collect();
            self.goals.retain(|_, own| !ended.contains(own));
        }
    }

    /// Does what is due. Returns the end of the stop.
    pub(super) fn advance(
        &mut self,
        connection: &mut Option<Connection>,
        configuration: &Configuration,
        now: Instant,
    ) -> Option<Ended> {
        self.settle(now);
        let ended = |stop| {
            Some(Ended {
                error: self.error.clone(),
                stop,
            })
        };
        if self.goals.is_empty() && !self.is_service_due {
            return ended(Ok(()));
        }
        if self.deadline <= now {
            return ended(Err(match connection {
                Some(_) => RobotError::TimedOut {
                    what: "stop".to_owned(),
                    limit: self.limit,
                },
                None => RobotError::Gone {
                    reason: "the bridge cannot be reached to stop the robot".to_owned(),
                    messages: String::new(),
                },
            }));
        }
        if self.next > now {
            return None;
        }
        self.next = now + AGAIN;
        self.is_new |= connection.is_none();
        if connection.is_none() {
            *connection = Connection::open(&configuration.url, AGAIN).ok();
        }
        if let Some(open) = connection {
            if self.is_new {
                self.asked.get_or_insert(now);
            }
            let sent = self
                .messages(configuration.stop.as_ref())
                .iter()
                .all(|own| open.send(own).is_ok());
            if !sent {
                *connection = None;
            }
        }
        None
    }

    /// The messages of one attempt: cancel each goal; after the first attempt, and over a new connection, cancel all
    /// goals of their servers.
    fn messages(&mut self, service: Option<&Service>) -> Vec<Value> {
        let (prefix, try_number) = (&self.prefix, self.tries);
        let seconds = self.limit.as_secs_f64();
        let mut messages = Vec::new();
        if let Some(service) = service.filter(|_| self.is_service_due) {
            let id = format!("{prefix}-service-{try_number}");
            messages.push(message::call(
                &id,
                &service.name,
                Some(&service.kind),
                &service.request,
                seconds,
            ));
        }
        if !self.is_new {
            messages.extend(self.goals.iter().map(|(id, server)| message::cancel_goal(id, server)));
        }
        if self.is_new || try_number > 0 {
            for server in self.goals.values().collect::<BTreeSet<_>>() {
                let topic = format!("{server}/_action/status");
                messages.push(message::subscribe(
                    &format!("{prefix}-status-{try_number}"),
                    &topic,
                    STATUS,
                ));
                messages.push(message::cancel_call(
                    &format!("{prefix}-{try_number}{server}"),
                    server,
                    None,
                    seconds,
                ));
            }
        }
        self.tries += 1;
        messages
    }
}

/// The facts about a robot that a stop needs.
#[derive(Debug, Clone, Copy)]
pub(super) struct StopFacts {
    pub(super) stop: Duration,
    pub(super) has_service: bool,
    pub(super) is_connected: bool,
}

/// True for the answer of a server that has no goal which could be cancelled.
pub(super) fn has_nothing_to_cancel(values: &Value) -> bool {
    let is_empty = values
        .get("goals_canceling")
        .and_then(Value::as_array)
        .is_some_and(Vec::is_empty);
    // 1: the server refused to cancel.
    is_empty
        && values
            .get("return_code")
            .and_then(Value::as_i64)
            .is_some_and(|code| code != 1)
}

/// The number of goals whose cancellation a server accepted.
fn accepted(values: &Value) -> usize {
    let goals = values.get("goals_canceling").and_then(Value::as_array);
    goals.map_or(0, Vec::len)
}

/// True for a list of goals that have all ended.
pub(super) fn has_no_active_goal(message: &Value) -> bool {
    let listed = message.get("status_list").and_then(Value::as_array);
    let is_active = |entry: &Value| {
        let status = entry.get("status").and_then(Value::as_i64);
        status.is_none_or(|status| (1..=LAST_ACTIVE).contains(&status))
    };
    listed.is_some_and(|listed| !listed.iter().any(is_active))
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    fn stopping(is_connected: bool, has_service: bool) -> Stopping {
        let goals = [("g1", "/left"), ("g2", "/right"), ("g3", "/right")];
        let goals = goals.map(|(id, server)| (id.to_owned(), server.to_owned())).into();
        let limits = StopFacts {
            stop: Duration::from_secs(2),
            has_service,
            is_connected,
        };
        Stopping::new(RobotError::Stopped, goals, "run", limits)
    }

    fn operations(messages: &[Value]) -> Vec<String> {
        let words = |own: &Value| format!("{} {}", own["op"].as_str().unwrap(), own["id"].as_str().unwrap());
        messages.iter().map(words).collect()
    }

    #[test]
    fn goals_are_cancelled_one_by_one_and_then_all() {
        let mut stopping = stopping(true, false);
        let first = operations(&stopping.messages(None));
        assert_eq!(
            first,
            [
                "cancel_action_goal g1",
                "cancel_action_goal g2",
                "cancel_action_goal g3"
            ]
        );
        let end = |id: &str| Incoming::Result {
            id: id.to_owned(),
            status: None,
            values: json!({}),
        };
        stopping.file(&end("g2"));
        stopping.file(&end("other"));
        let second = operations(&stopping.messages(None));
        assert_eq!(
            second,
            [
                "cancel_action_goal g1",
                "cancel_action_goal g3",
                "subscribe run-stop-status-1",
                "call_service run-stop-1/left",
                "subscribe run-stop-status-1",
                "call_service run-stop-1/right"
            ]
        );
        stopping.file(&end("g1"));
        stopping.file(&end("g3"));
        assert!(stopping.goals.is_empty());
    }

    #[test]
    fn stopping_after_a_reconnect_relies_on_server_status() {
        let mut stopping = stopping(false, false);
        assert_eq!(operations(&stopping.messages(None)).len(), 4);
        let (asked, later) = (Instant::now(), Instant::now() + LISTING);
        stopping.asked = Some(asked);
        let answer = |id: &str, values: Value| Incoming::Response {
            id: id.to_owned(),
            is_success: true,
            values,
        };
        stopping.file(&answer(
            "run-stop-0/left",
            json!({"return_code": 1, "goals_canceling": []}),
        ));
        stopping.file(&answer("else-0/left", json!({"return_code": 0, "goals_canceling": []})));
        stopping.settle(later);
        assert_eq!(stopping.goals.len(), 3);
        let nothing = |server: &str| {
            answer(
                &format!("run-stop-0{server}"),
                json!({"return_code": 0, "goals_canceling": []}),
            )
        };
        stopping.file(&nothing("/left"));
        stopping.settle(asked);
        assert_eq!(stopping.goals.len(), 3, "a list may still come");
        stopping.settle(later);
        assert_eq!(stopping.goals.len(), 2);
        let listed = |status: i64| Incoming::Published {
            topic: "/right/_action/status".to_owned(),
            message: json!({"status_list": [{"status": 4}, {"status": status}]}),
        };
        stopping.file(&listed(2));
        // A server that accepts no cancellation answers so, and one whose goal is being cancelled.
        stopping.file(&nothing("/right"));
        stopping.settle(later);
        assert_eq!(stopping.goals.len(), 2);
        stopping.file(&listed(3));
        assert_eq!(stopping.goals.len(), 2);
        stopping.file(&listed(5));
        assert!(stopping.goals.is_empty());
    }

    #[test]
    fn a_goal_that_is_being_cancelled_has_not_ended() {
        let mut stopping = stopping(false, false);
        stopping.asked = Some(Instant::now());
        let answer = |goals: Value| Incoming::Response {
            id: "run-stop-0/left".to_owned(),
            is_success: true,
            values: json!({"return_code": 0, "goals_canceling": goals}),
        };
        stopping.file(&answer(json!([{}])));
        stopping.file(&answer(json!([])));
        stopping.settle(Instant::now() + LISTING);
        assert_eq!(stopping.goals.len(), 3);
    }

    #[test]
    fn stop_service_has_to_confirm_the_stop() {
        let mut stopping = stopping(true, true);
        stopping.goals.clear();
        let service = Service {
            name: "/stop".to_owned(),
            kind: "std_srvs/srv/Trigger".to_owned(),
            request: json!({}),
        };
        assert_eq!(
            operations(&stopping.messages(Some(&service))),
            ["call_service run-stop-service-0"]
        );
        for (is_success, values, due) in [
            (false, json!("late"), true),
            (true, json!({"success": false}), true),
            (true, json!({"success": true}), false),
        ] {
            let id = "run-stop-service-0".to_owned();
            stopping.file(&Incoming::Response { id, is_success, values });
            assert_eq!(stopping.is_service_due, due);
        }
    }
}
