//! Observations of robots.

use indexmap::IndexMap;
use longstep_core::environment::{Statements, Words};
use serde::{Deserialize, Serialize};

/// The entities that an observation is to cover.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Scope {
    /// Every entity that the robot can see.
    All,
    /// These entities. An observation may cover more.
    Entities(Vec<String>),
}

/// An observation of the world, in the words of an environment file.
///
/// An entity that is listed is described fully: a statement that its entry lacks does not hold. An entity that is not
/// listed was not seen, and nothing is known about it. Facts that environments have no words for are observed only of the
/// predicates in [`Description::reports`](crate::Description::reports).
///
/// ```
/// use longstep_robot::Observation;
/// let text = r#"{"states":{"<cup>":"on_something(<shelf>)","<fridge_handle>":["closed()"],"<spoon>":[]}}"#;
/// let observation: Observation = serde_json::from_str(text)?;
/// assert_eq!(observation.statements("<cup>"), Some(&["on_something(<shelf>)".to_owned()][..]));
/// assert_eq!(observation.statements("<spoon>"), Some(&[][..]));
/// assert_eq!(observation.statements("<plate>"), None);
/// assert_eq!(serde_json::to_string(&observation)?, text);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observation {
    /// The statements about each entity that was seen: a text, or a list of texts.
    pub states: IndexMap<String, Words>,
    /// Statements without a subject, as `facts` of an environment, and all facts of the reported predicates:
    /// `hand-at(<cup>)`. None if they were not observed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<Vec<String>>,
}

impl Observation {
    /// Returns the statements about an entity; none if it was not seen.
    pub fn statements(&self, entity: &str) -> Option<&[String]> {
        self.states.get(entity).map(Words::as_slice)
    }
}

impl From<Statements> for Observation {
    fn from(statements: Statements) -> Self {
        Self {
            states: statements.states,
            facts: statements.facts,
        }
    }
}

impl From<Observation> for Statements {
    fn from(observation: Observation) -> Self {
        Self {
            states: observation.states,
            facts: observation.facts,
        }
    }
}
