//! The settings of an execution.

use serde::{Deserialize, Serialize};

use longstep_model::model::PredicateId;
use longstep_verify::skill::Skills;

/// When a person is asked.
///
/// A later value is stricter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approval {
    /// Never.
    Never,
    /// Before the first step, and before a change of the plan that adds or replaces steps.
    #[default]
    Changes,
    /// As for [`Approval::Changes`], and before every step.
    EachStep,
}

/// The evidence that progress and the end need. A later value is stricter.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Trust {
    /// The promise of a step that was performed.
    Promised,
    /// An observation since the last step that could have changed the fact.
    #[default]
    Observed,
}

/// When the world is observed. In either case it is observed before the first step, where a stage of the goal would be
/// achieved, and before the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Watch {
    /// After every step.
    #[default]
    EachStep,
    /// After a failed step.
    OnFailure,
}

/// The settings of an execution.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// When a person is asked.
    pub approval: Approval,
    /// The evidence that progress and the end need.
    pub trust: Trust,
    /// When the world is observed.
    pub watch: Watch,
    /// The number of changes of the plan after which the execution stops.
    pub changes: u32,
    /// The predicates that observations list besides the states of entities.
    pub reports: Vec<PredicateId>,
    /// The values of skill parameters.
    pub skills: Skills,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            approval: Approval::default(),
            trust: Trust::default(),
            watch: Watch::default(),
            changes: 8,
            reports: Vec::new(),
            skills: Skills::default(),
        }
    }
}
