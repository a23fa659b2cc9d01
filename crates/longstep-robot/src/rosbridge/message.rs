//! Messages of the rosbridge protocol: reading the bridge's, writing ours.

use longstep_core::{secret, visible};
use serde_json::{Map, Value, json};

use crate::error::RobotError;

/// The longest quotation of a robot in a message, in characters.
const QUOTE_LIMIT: usize = 300;

/// A goal for an action server.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Goal {
    pub(crate) server: String,
    pub(crate) kind: String,
    pub(crate) fields: Value,
}

/// The state of a goal, with the numbers of `action_msgs/msg/GoalStatus`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum GoalStatus {
    /// Nothing is known.
    Unknown,
    /// The server accepted it.
    Accepted,
    /// It is under way.
    Executing,
    /// It is being cancelled.
    Canceling,
    /// It succeeded.
    Succeeded,
    /// It was cancelled.
    Cancelled,
    /// It failed.
    Aborted,
}

impl GoalStatus {
    fn of(number: i64) -> Option<Self> {
        Some(match number {
            0 => Self::Unknown,
            1 => Self::Accepted,
            2 => Self::Executing,
            3 => Self::Canceling,
            4 => Self::Succeeded,
            5 => Self::Cancelled,
            6 => Self::Aborted,
            _ => return None,
        })
    }
}

/// A message of the bridge.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum Incoming {
    /// Feedback of an action server about a goal.
    Feedback {
        /// The id of the goal.
        id: String,
        /// The fields of the feedback.
        values: Value,
    },
    /// The end of a goal.
    Result {
        /// The id of the goal.
        id: String,
        /// The state in which it ended, if the bridge says it.
        status: Option<GoalStatus>,
        /// The fields of the result, or a text.
        values: Value,
    },
    /// The answer to a call of a service.
    Response {
        /// The id of the call.
        id: String,
        /// False if the call failed; then `values` is a text.
        is_success: bool,
        /// The fields of the answer.
        values: Value,
    },
    /// A call of a service that this program offers.
    Called {
        /// The id that the answer names.
        id: String,
        /// The service.
        service: String,
        /// The fields of the request.
        arguments: Value,
    },
    /// A message of a subscribed topic.
    Published {
        /// The topic.
        topic: String,
        /// The fields of the message.
        message: Value,
    },
    /// A remark about a request, or about the bridge itself.
    Status {
        /// The id of the request.
        id: Option<String>,
        /// True if the request failed.
        is_error: bool,
        /// The remark.
        text: String,
    },
    /// An operation that nothing here asked for.
    Other,
}

/// Returns foreign text on one line, shortened.
pub(crate) fn quotation(text: &str) -> String {
    let text = secret::redacted(text);
    let mut short: String = text.chars().take(QUOTE_LIMIT).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    visible::line(&short).into_owned()
}

/// Returns the error for a message that breaks the protocol.
pub(crate) fn broken(reason: impl Into<String>) -> RobotError {
    RobotError::Protocol { reason: reason.into() }
}

/// Reads a message of the bridge.
///
/// # Errors
///
/// A text that is no message, or that lacks what its operation needs.
pub fn read(text: &str) -> Result<Incoming, RobotError> {
    let quoted = || format!("`{}`", quotation(text));
    let value: Value =
        serde_json::from_str(text).map_err(|_| broken(format!("the bridge sent what is not JSON: {}", quoted())))?;
    let unfit = |reason: &str| broken(format!("the bridge sent a message that {reason}: {}", quoted()));
    let Value::Object(mut fields) = value else {
        return Err(unfit("is no object"));
    };
    let operation = text_of(&fields, "op").ok_or_else(|| unfit("has no `op`"))?;
    let id = text_of(&fields, "id");
    let needed = || id.clone().ok_or_else(|| unfit("has no `id`"));
    Ok(match operation.as_str() {
        "action_feedback" => Incoming::Feedback {
            id: needed()?,
            values: take(&mut fields, "values"),
        },
        "action_result" => Incoming::Result {
            id: needed()?,
            status: fields.get("status").and_then(Value::as_i64).and_then(GoalStatus::of),
            values: take(&mut fields, "values"),
        },
        "service_response" => Incoming::Response {
            id: needed()?,
            is_success: fields.get("result").and_then(Value::as_bool).unwrap_or(true),
            values: take(&mut fields, "values"),
        },
        "call_service" => Incoming::Called {
            id: needed()?,
            service: text_of(&fields, "service").ok_or_else(|| unfit("has no `service`"))?,
            arguments: take(&mut fields, "args"),
        },
        "publish" => Incoming::Published {
            topic: text_of(&fields, "topic").ok_or_else(|| unfit("has no `topic`"))?,
            message: take(&mut fields, "msg"),
        },
        "status" => Incoming::Status {
            id,
            is_error: text_of(&fields, "level").is_some_and(|level| level == "error"),
            text: quotation(&text_of(&fields, "msg").unwrap_or_default()),
        },
        _ => Incoming::Other,
    })
}

fn text_of(fields: &Map<String, Value>, name: &str) -> Option<String> {
    fields.get(name).and_then(Value::as_str).map(str::to_owned)
}

fn take(fields: &mut Map<String, Value>, name: &str) -> Value {
    fields.remove(name).unwrap_or(Value::Null)
}

/// Returns the message that sends a goal.
pub(crate) fn send_goal(id: &str, goal: &Goal) -> Value {
    json!({"op": "send_action_goal", "id": id, "action": goal.server, "action_type": goal.kind, "args": goal.fields,
           "feedback": true})
}

/// Returns the message that cancels a goal.
pub(crate) fn cancel_goal(id: &str, server: &str) -> Value {
    json!({"op": "cancel_action_goal", "id": id, "action": server})
}

/// Returns the call of a service.
pub(crate) fn call(id: &str, service: &str, kind: Option<&str>, request: &Value, seconds: f64) -> Value {
    let mut call = json!({"op": "call_service", "id": id, "service": service, "args": request, "timeout": seconds});
    if let Some(kind) = kind {
        call["type"] = json!(kind);
    }
    call
}

/// Returns the call that cancels goals of a server: the goal with an identifier, or all with none.
pub(crate) fn cancel_call(id: &str, server: &str, goal: Option<[u8; 16]>, seconds: f64) -> Value {
    let uuid = goal.unwrap_or_default();
    let request = json!({"goal_info": {"goal_id": {"uuid": uuid}, "stamp": {"sec": 0, "nanosec": 0}}});
    let service = format!("{server}/_action/cancel_goal");
    call(id, &service, Some("action_msgs/srv/CancelGoal"), &request, seconds)
}

/// Returns the subscription of a topic.
pub fn subscribe(id: &str, topic: &str, kind: &str) -> Value {
    json!({"op": "subscribe", "id": id, "topic": topic, "type": kind})
}

/// Returns the end of a subscription.
pub(crate) fn unsubscribe(id: &str, topic: &str) -> Value {
    json!({"op": "unsubscribe", "id": id, "topic": topic})
}

/// Returns the announcement of a topic that messages are sent to. Subscribers that come later get the last message of a
/// latched topic.
pub fn advertise(id: &str, topic: &str, kind: &str, is_latched: bool) -> Value {
    json!({"op": "advertise", "id": id, "topic": topic, "type": kind, "latch": is_latched})
}

/// Returns the announcement of a service whose calls come as [`Incoming::Called`].
pub fn advertise_service(service: &str, kind: &str) -> Value {
    json!({"op": "advertise_service", "service": service, "type": kind})
}

/// Returns the answer to a call of a service.
pub fn respond(id: &str, service: &str, values: &Value) -> Value {
    json!({"op": "service_response", "id": id, "service": service, "values": values, "result": true})
}

/// Returns a message to a topic.
pub fn publish(topic: &str, message: &Value) -> Value {
    json!({"op": "publish", "topic": topic, "msg": message})
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_of_the_bridge_are_read() {
        let id = || "g1".to_owned();
        for (text, expected) in [
            (
                r#"{"op":"action_feedback","action":"/a","values":{"x":1},"id":"g1"}"#,
                Incoming::Feedback {
                    id: id(),
                    values: json!({"x": 1}),
                },
            ),
            (
                r#"{"op":"action_result","action":"/a","values":"goal rejected","status":6,"result":false,"id":"g1"}"#,
                Incoming::Result {
                    id: id(),
                    status: Some(GoalStatus::Aborted),
                    values: json!("goal rejected"),
                },
            ),
            (
                r#"{"op":"action_result","values":{},"id":"g1"}"#,
                Incoming::Result {
                    id: id(),
                    status: None,
                    values: json!({}),
                },
            ),
            (
                r#"{"op":"service_response","service":"/s","values":"late","result":false,"id":"g1"}"#,
                Incoming::Response {
                    id: id(),
                    is_success: false,
                    values: json!("late"),
                },
            ),
            (
                r#"{"op":"publish","topic":"/t","msg":{"data":"x"}}"#,
                Incoming::Published {
                    topic: "/t".to_owned(),
                    message: json!({"data": "x"}),
                },
            ),
            (
                r#"{"op":"status","level":"error","msg":"unknown\u001b","id":"g1"}"#,
                Incoming::Status {
                    id: Some(id()),
                    is_error: true,
                    text: "unknown\\u{1b}".to_owned(),
                },
            ),
            (
                r#"{"op":"call_service","service":"/s","id":"g1","args":{"request":"x"}}"#,
                Incoming::Called {
                    id: id(),
                    service: "/s".to_owned(),
                    arguments: json!({"request": "x"}),
                },
            ),
            (r#"{"op":"png","data":""}"#, Incoming::Other),
        ] {
            assert_eq!(read(text), Ok(expected), "{text}");
        }
    }

    #[test]
    fn other_texts_break_the_protocol() {
        for (text, expected) in [
            ("hello", "the bridge sent what is not JSON: `hello`"),
            ("", "the bridge sent what is not JSON: ``"),
            ("3", "the bridge sent a message that is no object: `3`"),
            ("{}", "the bridge sent a message that has no `op`: `{}`"),
            (
                r#"{"op":"action_result"}"#,
                "the bridge sent a message that has no `id`: `{\"op\":\"action_result\"}`",
            ),
            (
                r#"{"op":"publish"}"#,
                "the bridge sent a message that has no `topic`: `{\"op\":\"publish\"}`",
            ),
        ] {
            let error = read(text).unwrap_err().to_string();
            assert_eq!(error, format!("the robot broke the protocol: {expected}"));
        }
        assert!(read(&"[".repeat(1 << 20)).is_err());
    }
}
