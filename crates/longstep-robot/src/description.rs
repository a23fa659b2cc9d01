//! Descriptions of robots.

use std::collections::{BTreeMap, BTreeSet};
use std::time::Duration;

/// The capabilities and the timeouts of a robot.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Description {
    /// The name of the robot, for messages.
    pub name: String,
    /// The actions that it can perform; none if it does not restrict them.
    pub actions: Option<BTreeSet<String>>,
    /// The number of orders that it performs at the same time, at least 1.
    pub parallel: usize,
    /// True if [`Robot::observe`](crate::Robot::observe) returns what the robot sees.
    pub observes: bool,
    /// The predicates without a state word whose facts the robot lists in
    /// [`Observation::facts`](crate::Observation::facts), all of them each time, by their names in `domain.pddl`: where
    /// its hand is, for example. Most robots report none.
    pub reports: Vec<String>,
    /// True if the robot begins to count events anew with each plan ([`Robot::begin_plan`](crate::Robot::begin_plan)), so
    /// that it may report them. An event of an earlier plan would make a step of this one needless.
    pub counts_events: bool,
    /// The time that the robot may take.
    pub timeouts: Timeouts,
    /// True for a robot in a simulation, which nobody has to keep away from.
    pub simulated: bool,
    /// The parts that it drives, for [`Exclusive`](crate::Exclusive): no two programs drive the same. Empty for a simulation that is the
    /// program's own.
    pub drives: Vec<String>,
}

/// The time after which a robot that does not answer counts as failed.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Timeouts {
    /// For a step whose action is not in `actions`.
    pub perform: Duration,
    /// For a step, by the name of its action.
    pub actions: BTreeMap<String, Duration>,
    /// For an observation.
    pub observe: Duration,
    /// For the confirmation of a stop.
    pub stop: Duration,
}

impl Description {
    /// Returns a description with one order at a time, no observations and the default timeouts.
    pub fn new(name: &str) -> Self {
        Self {
            name: name.to_owned(),
            actions: None,
            parallel: 1,
            observes: false,
            reports: Vec::new(),
            counts_events: false,
            timeouts: Timeouts::default(),
            simulated: false,
            drives: Vec::new(),
        }
    }

    /// Returns true if the robot can perform the action.
    pub fn can_perform(&self, action: &str) -> bool {
        self.actions.as_ref().is_none_or(|actions| actions.contains(action))
    }
}

impl Timeouts {
    /// Returns the timeout of a step.
    pub fn of_action(&self, action: &str) -> Duration {
        self.actions.get(action).copied().unwrap_or(self.perform)
    }
}

impl Default for Timeouts {
    /// A minute for a step, ten seconds for an observation, two for a stop.
    fn default() -> Self {
        Self {
            perform: Duration::from_secs(60),
            actions: BTreeMap::new(),
            observe: Duration::from_secs(10),
            stop: Duration::from_secs(2),
        }
    }
}
