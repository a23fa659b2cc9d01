//! One step as a robot receives it, and its handle once it is started.

use serde::{Deserialize, Serialize};
use serde_json::{Map, Value};

/// An order to perform one step.
///
/// Its JSON form is the one that programs receive; empty fields are omitted.
///
/// ```
/// use longstep_robot::Order;
/// let order = Order::new(4, "attach", ["<cup>", "<shelf>"]);
/// let json = serde_json::to_string(&order)?;
/// assert_eq!(json, r#"{"step":4,"action":"attach","arguments":["<cup>","<shelf>"]}"#);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
#[non_exhaustive]
pub struct Order {
    /// The number of the step in its plan, from 1.
    pub step: usize,
    /// The lane (hand, arm or robot) that performs the step; none in a plan without lanes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub lane: Option<String>,
    /// The name of the action in `domain.pddl`.
    pub action: String,
    /// The identifiers of the arguments, in the order of the action's parameters. Values stand here as they are written
    /// in a plan: `180 s`.
    pub arguments: Vec<String>,
    /// The arguments that are values, as numbers and texts.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub values: Vec<ArgumentValue>,
    /// The values of the action's skill parameters, by name.
    #[serde(default, skip_serializing_if = "Map::is_empty")]
    pub skills: Map<String, Value>,
    /// The possible outcomes of a sensing action as facts, `(expired <milk>)`; empty for other actions.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub outcomes: Vec<String>,
}

/// An argument that is a value: a quantity or a text.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ArgumentValue {
    /// The index of the argument in [`Order::arguments`], from 0.
    pub argument: usize,
    /// The number of a quantity, in `unit`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub number: Option<f64>,
    /// The unit of a quantity; none for plain numbers.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unit: Option<String>,
    /// The text of a text value, without quotes.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub text: Option<String>,
}

impl Order {
    /// Returns an order without lane, values, skills and outcomes.
    pub fn new<A: Into<String>>(step: usize, action: &str, arguments: impl IntoIterator<Item = A>) -> Self {
        Self {
            step,
            lane: None,
            action: action.to_owned(),
            arguments: arguments.into_iter().map(Into::into).collect(),
            values: Vec::new(),
            skills: Map::new(),
            outcomes: Vec::new(),
        }
    }
}

/// An order that was started.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct Handle(u64);

impl Handle {
    /// Returns the handle with a number that is unique for the robot.
    pub fn new(number: u64) -> Self {
        Self(number)
    }

    /// Returns its number.
    pub fn number(self) -> u64 {
        self.0
    }
}
