//! Messages: reading the robot's, writing ours.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

use longstep_core::{secret, visible};
use serde::Deserialize;
use serde_json::{Value, json};

use crate::description::{Description, Timeouts};
use crate::error::RobotError;
use crate::robot::{Feedback, Progress};
use longstep_core::environment::Observation;

/// The version of the protocol that this crate speaks.
pub const PROTOCOL_VERSION: u64 = 1;

/// The longest line of a robot and of an order, in bytes.
pub const LINE_LIMIT: usize = 1 << 20;

/// The longest feedback, in bytes.
const FEEDBACK_LIMIT: usize = 16 << 10;

/// The longest quotation of a robot in a message, in characters.
const QUOTE_LIMIT: usize = 200;

/// The error codes that JSON-RPC reserves. With one of these a robot says that it does not understand a request; with
/// any other, that it understood and could not do it.
const RESERVED_CODES: std::ops::RangeInclusive<i64> = -32768..=-32000;

/// The longest timeout that a robot may declare, in seconds: a day.
const TIMEOUT_LIMIT: f64 = 86_400.0;

/// The most orders at the same time that a robot may declare.
const PARALLEL_LIMIT: usize = 64;

/// A message of a robot.
#[derive(Debug, PartialEq)]
pub(super) enum Incoming {
    /// The answer to the request with this number.
    Answer(u64, Result<Value, Refusal>),
    /// Feedback about the order with this number.
    Feedback(u64, Feedback),
}

/// An error object of JSON-RPC.
#[derive(Debug, Clone, PartialEq, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Refusal {
    code: i64,
    message: String,
    #[serde(default, rename = "data")]
    _data: Option<Value>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Envelope {
    jsonrpc: String,
    id: Option<u64>,
    #[serde(default, deserialize_with = "present")]
    result: Option<Value>,
    error: Option<Refusal>,
    method: Option<String>,
    params: Option<Value>,
}

/// Keeps `null` apart from a member that is missing.
fn present<'de, D: serde::Deserializer<'de>>(deserializer: D) -> Result<Option<Value>, D::Error> {
    Value::deserialize(deserializer).map(Some)
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct FeedbackParams {
    id: u64,
    fraction: Option<f64>,
    text: Option<String>,
    data: Option<Value>,
}

#[derive(Deserialize)]
struct Version {
    protocol: Value,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Initialized {
    #[serde(rename = "protocol")]
    _protocol: u64,
    name: String,
    #[serde(default)]
    simulated: bool,
    #[serde(default)]
    capabilities: Capabilities,
    #[serde(default)]
    timeouts: WrittenTimeouts,
}

#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct Capabilities {
    actions: Option<BTreeSet<String>>,
    parallel: Option<usize>,
    #[serde(default)]
    observe: bool,
    #[serde(default)]
    reports: Vec<String>,
}

/// Timeouts in seconds.
#[derive(Deserialize, Default)]
#[serde(deny_unknown_fields)]
struct WrittenTimeouts {
    perform: Option<f64>,
    #[serde(default)]
    actions: BTreeMap<String, f64>,
    observe: Option<f64>,
    stop: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct Performed {
    outcome: Option<String>,
}

impl Refusal {
    /// The robot's reason, on one line and shortened.
    pub(super) fn reason(&self) -> String {
        quotation(&self.message)
    }

    /// Returns the error for a refused request.
    pub(super) fn into_error(self, method: &str) -> RobotError {
        let reason = self.reason();
        if RESERVED_CODES.contains(&self.code) {
            broken(format!("it answered `{method}` with error {}: {reason}", self.code))
        } else {
            RobotError::Refused {
                method: method.to_owned(),
                reason,
            }
        }
    }
}

/// Returns the error for a message that breaks the protocol.
pub(super) fn broken(reason: impl Into<String>) -> RobotError {
    RobotError::Protocol { reason: reason.into() }
}

/// Returns foreign text on one line, shortened.
fn quotation(text: &str) -> String {
    let text = secret::redacted(text);
    let mut short: String = text.chars().take(QUOTE_LIMIT).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    visible::line(&short).into_owned()
}

/// Returns a request as a line.
pub(super) fn request(id: u64, method: &str, parameters: &Value) -> Vec<u8> {
    line(&json!({ "jsonrpc": "2.0", "id": id, "method": method, "params": parameters }))
}

fn line(message: &Value) -> Vec<u8> {
    let mut bytes = message.to_string().into_bytes();
    bytes.push(b'\n');
    bytes
}

/// Reads a line of a robot.
pub(super) fn read(line: &[u8]) -> Result<Incoming, RobotError> {
    let quoted = || format!("`{}`", quotation(&String::from_utf8_lossy(line)));
    let value: Value =
        serde_json::from_slice(line).map_err(|_| broken(format!("it wrote a line that is not JSON: {}", quoted())))?;
    let unfit = |reason: &str| broken(format!("it wrote a message that {reason}: {}", quoted()));
    let envelope: Envelope =
        serde_json::from_value(value).map_err(|error| unfit(&format!("does not fit ({error})")))?;
    if envelope.jsonrpc != "2.0" {
        return Err(unfit("is not JSON-RPC 2.0"));
    }
    match envelope {
        Envelope {
            id: Some(id),
            result: Some(result),
            error: None,
            method: None,
            params: None,
            ..
        } => Ok(Incoming::Answer(id, Ok(result))),
        Envelope {
            id: Some(id),
            result: None,
            error: Some(refusal),
            method: None,
            params: None,
            ..
        } => Ok(Incoming::Answer(id, Err(refusal))),
        Envelope {
            id: None,
            result: None,
            error: None,
            method: Some(method),
            params: Some(params),
            ..
        } if method == "feedback" => {
            if line.len() > FEEDBACK_LIMIT {
                return Err(unfit(&format!("is longer than {} KiB", FEEDBACK_LIMIT >> 10)));
            }
            let read: FeedbackParams =
                serde_json::from_value(params).map_err(|error| unfit(&format!("does not fit ({error})")))?;
            if read.fraction.is_some_and(|fraction| !(0.0..=1.0).contains(&fraction)) {
                return Err(unfit("has a `fraction` outside of 0 to 1"));
            }
            let feedback = Feedback {
                fraction: read.fraction,
                text: read.text,
                data: read.data,
            };
            Ok(Incoming::Feedback(read.id, feedback))
        }
        _ => Err(unfit("is neither an answer nor `feedback`")),
    }
}

/// Reads the result of `initialize`.
pub(super) fn initialized(value: Value) -> Result<Description, RobotError> {
    let unfit = |error: serde_json::Error| broken(format!("its answer to `initialize` does not fit ({error})"));
    let version = Version::deserialize(&value).map_err(unfit)?.protocol;
    if version.as_u64() != Some(PROTOCOL_VERSION) {
        return Err(RobotError::Incompatible {
            expected: PROTOCOL_VERSION,
            found: quotation(&version.to_string()),
        });
    }
    let read: Initialized = serde_json::from_value(value).map_err(unfit)?;
    let parallel = read.capabilities.parallel.unwrap_or(1);
    if !(1..=PARALLEL_LIMIT).contains(&parallel) {
        return Err(broken(format!(
            "its `parallel` is {parallel}, not 1 to {PARALLEL_LIMIT}"
        )));
    }
    let defaults = Timeouts::default();
    let actions = read.timeouts.actions.into_iter();
    let actions = actions.map(|(action, seconds)| Ok((action, duration(Some(seconds), defaults.perform)?)));
    let name = quotation(&read.name);
    Ok(Description {
        drives: Vec::from_iter((!read.simulated).then(|| format!("process {name}"))),
        simulated: read.simulated,
        name,
        actions: read.capabilities.actions,
        parallel,
        observes: read.capabilities.observe,
        reports: read.capabilities.reports,
        counts_events: false,
        timeouts: Timeouts {
            perform: duration(read.timeouts.perform, defaults.perform)?,
            actions: actions.collect::<Result<_, RobotError>>()?,
            observe: duration(read.timeouts.observe, defaults.observe)?,
            stop: duration(read.timeouts.stop, defaults.stop)?,
        },
    })
}

fn duration(seconds: Option<f64>, default: Duration) -> Result<Duration, RobotError> {
    match seconds {
        None => Ok(default),
        Some(seconds) if seconds > 0.0 && seconds <= TIMEOUT_LIMIT => Ok(Duration::from_secs_f64(seconds)),
        Some(seconds) => Err(broken(format!(
            "it declares a timeout of {seconds} s, not more than 0 s and at most a day"
        ))),
    }
}

/// Reads the answer to `perform`.
pub(super) fn performed(
    step: usize,
    outcomes: &[String],
    answer: Result<Value, Refusal>,
) -> Result<Progress, RobotError> {
    let value = match answer {
        Ok(value) => value,
        Err(refusal) => {
            return match refusal.into_error("perform") {
                RobotError::Refused { reason, .. } => Ok(Progress::Failed { reason }),
                error => Err(error),
            };
        }
    };
    let unfit = |what: &str| broken(format!("its answer to step {step} does not fit ({what})"));
    let read: Performed = serde_json::from_value(value).map_err(|error| unfit(&error.to_string()))?;
    match read.outcome {
        None if outcomes.is_empty() => Ok(Progress::Done { outcome: None }),
        None => Err(unfit("a sensing action needs an `outcome`")),
        Some(outcome) => match outcomes.iter().position(|known| *known == outcome) {
            Some(place) => Ok(Progress::Done { outcome: Some(place) }),
            None => Err(unfit(&format!("`{}` is no outcome of the order", quotation(&outcome)))),
        },
    }
}

/// Reads the answer to `observe`.
pub(super) fn observed(value: Value) -> Result<Observation, RobotError> {
    serde_json::from_value(value).map_err(|error| broken(format!("its answer to `observe` does not fit ({error})")))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_broken(line: &str, expected: &str) {
        let error = read(line.as_bytes()).unwrap_err().to_string();
        assert_eq!(error, format!("the robot broke the protocol: {expected}"));
    }

    #[test]
    fn answers_and_feedback_are_read() {
        let answer = read(br#"{"jsonrpc":"2.0","id":3,"result":null}"#).unwrap();
        assert_eq!(answer, Incoming::Answer(3, Ok(Value::Null)));
        let line = br#"{"jsonrpc": "2.0", "method": "feedback", "params": {"id": 2, "fraction": 0.5, "text": "half"}}"#;
        let Incoming::Feedback(2, feedback) = read(line).unwrap() else {
            panic!("no feedback");
        };
        assert_eq!((feedback.fraction, feedback.text.as_deref()), (Some(0.5), Some("half")));
    }

    #[test]
    fn other_lines_break_the_protocol() {
        check_broken("ready", "it wrote a line that is not JSON: `ready`");
        check_broken("", "it wrote a line that is not JSON: ``");
        check_broken("\u{1b}[31m", "it wrote a line that is not JSON: `\\u{1b}[31m`");
        check_broken(
            r#"{"jsonrpc":"1.0","id":1,"result":{}}"#,
            r#"it wrote a message that is not JSON-RPC 2.0: `{"jsonrpc":"1.0","id":1,"result":{}}`"#,
        );
        let neither = "it wrote a message that is neither an answer nor `feedback`";
        for line in [
            r#"{"jsonrpc":"2.0"}"#,
            r#"{"jsonrpc":"2.0","id":1}"#,
            r#"{"jsonrpc":"2.0","id":1,"result":{},"error":{"code":1,"message":"no"}}"#,
            r#"{"jsonrpc":"2.0","id":1,"method":"perform","params":{}}"#,
            r#"{"jsonrpc":"2.0","method":"ready","params":{}}"#,
        ] {
            check_broken(line, &format!("{neither}: `{line}`"));
        }
        for line in [
            "[]",
            "3",
            r#"[{"jsonrpc":"2.0","id":1,"result":{}}]"#,
            r#"{"jsonrpc":"2.0","id":-1,"result":{}}"#,
            r#"{"jsonrpc":"2.0","id":"1","result":{}}"#,
            r#"{"jsonrpc":"2.0","id":1,"result":{},"more":1}"#,
            r#"{"jsonrpc":"2.0","id":1,"error":"no"}"#,
            r#"{"jsonrpc":"2.0","method":"feedback","params":{"fraction":0.5}}"#,
            r#"{"jsonrpc":"2.0","method":"feedback","params":{"id":1,"fraction":1.5}}"#,
        ] {
            assert!(read(line.as_bytes()).is_err(), "{line}");
        }
        assert!(read(b"{\"jsonrpc\":\"2.0\",\"id\":1,\"result\":\"\xff\"}").is_err());
        assert!(read("[".repeat(LINE_LIMIT).as_bytes()).is_err());
    }

    #[test]
    fn answers_to_initialize_are_checked() {
        let table = [
            (json!({"protocol": 1, "name": "r"}), ""),
            (
                json!({"protocol": 1, "name": "r", "timeouts": {"perform": 1.5, "actions": {"wipe": 90}}}),
                "",
            ),
            (json!({"protocol": 1, "name": "r", "simulated": true}), ""),
            (
                json!({"protocol": 2, "name": "r", "news": 1}),
                "the robot speaks protocol version 2, but version 1 is required",
            ),
            (
                json!({"protocol": 1}),
                "the robot broke the protocol: its answer to `initialize` does not fit (missing field `name`)",
            ),
            (
                json!({"protocol": 1, "name": "r", "capabilities": {"parallel": 0}}),
                "the robot broke the protocol: its `parallel` is 0, not 1 to 64",
            ),
            (
                json!({"protocol": 1, "name": "r", "timeouts": {"stop": -1}}),
                "the robot broke the protocol: it declares a timeout of -1 s, not more than 0 s and at most a day",
            ),
        ];
        for (value, expected) in table {
            let error = initialized(value).err().map(|error| error.to_string());
            assert_eq!(error.unwrap_or_default(), expected);
        }
    }

    #[test]
    fn answers_to_orders_are_checked() {
        let outcomes = ["(expired <milk>)".to_owned(), "(fresh <milk>)".to_owned()];
        let sensed = performed(2, &outcomes, Ok(json!({"outcome": "(fresh <milk>)"})));
        assert_eq!(sensed, Ok(Progress::Done { outcome: Some(1) }));
        assert_eq!(performed(2, &[], Ok(json!({}))), Ok(Progress::Done { outcome: None }));
        let refusal = |code| Refusal {
            code,
            message: "it slipped".to_owned(),
            _data: None,
        };
        let reason = "it slipped".to_owned();
        assert_eq!(performed(2, &[], Err(refusal(1))), Ok(Progress::Failed { reason }));
        assert!(performed(2, &[], Err(refusal(-32601))).is_err());
        assert!(performed(2, &outcomes, Ok(json!({}))).is_err());
        assert!(performed(2, &outcomes, Ok(json!({"outcome": "(sour <milk>)"}))).is_err());
        assert!(performed(2, &[], Ok(json!({"outcome": "(fresh <milk>)"}))).is_err());
        assert!(performed(2, &[], Ok(json!(null))).is_err());
    }
}
