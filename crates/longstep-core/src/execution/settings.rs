//! The settings of an execution.

use serde::{Deserialize, Serialize};

use crate::autonomy::Autonomy;
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
///
/// # Example
///
/// ```
/// use longstep_core::execution::{Approval, Settings, Watch};
/// let settings = Settings::default().with_approval(Approval::Never).with_watch(Watch::OnFailure);
/// assert_eq!((settings.approval, settings.changes), (Approval::Never, 8));
/// ```
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
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
    /// The levels of autonomy, and the limits, of the robot.
    pub autonomy: Autonomy,
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
            autonomy: Autonomy::default(),
        }
    }
}

impl Settings {
    /// Sets when a person is asked. See the [example](Self#example).
    #[must_use]
    pub fn with_approval(self, approval: Approval) -> Self {
        Self { approval, ..self }
    }

    /// Sets the evidence that progress and the end need.
    #[must_use]
    pub fn with_trust(self, trust: Trust) -> Self {
        Self { trust, ..self }
    }

    /// Sets when the world is observed.
    #[must_use]
    pub fn with_watch(self, watch: Watch) -> Self {
        Self { watch, ..self }
    }

    /// Sets the number of changes of the plan after which the execution stops.
    #[must_use]
    pub fn with_changes(self, changes: u32) -> Self {
        Self { changes, ..self }
    }

    /// Sets the predicates that observations list besides the states of entities.
    #[must_use]
    pub fn with_reports(self, reports: Vec<PredicateId>) -> Self {
        Self { reports, ..self }
    }

    /// Sets the values of skill parameters.
    #[must_use]
    pub fn with_skills(self, skills: Skills) -> Self {
        Self { skills, ..self }
    }

    /// Sets the levels of autonomy, and the limits, of the robot.
    #[must_use]
    pub fn with_autonomy(self, autonomy: Autonomy) -> Self {
        Self { autonomy, ..self }
    }
}
