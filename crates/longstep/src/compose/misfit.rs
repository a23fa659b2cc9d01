//! Errors in a composition that are found before any simulation.

use crate::environment::World;
use crate::report::{Answer, Status, ViolationAnswer};

/// A part of a composition that cannot be inlined.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum Misfit {
    /// A call of neither a stored plan nor an action.
    #[error("there is no stored plan `{name}`{}", .near.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    UnknownPlan {
        /// The called name.
        name: String,
        /// A stored plan or an action with a similar name.
        near: Option<String>,
    },
    /// A stored plan is called with arguments.
    #[error(
        "`{name}` is a stored plan, which takes nothing in its parentheses: what it handles was settled when it was made"
    )]
    Arguments {
        /// The plan.
        name: String,
    },
    /// A condition calls a stored plan.
    #[error("`{name}` is a stored plan, so it cannot be a condition: a condition is a sensing action or a state")]
    PlanInCondition {
        /// The plan.
        name: String,
    },
    /// A stored plan cannot be resolved, in this domain or in the world that it was made for.
    #[error("the stored plan `{name}` cannot be used: {why}")]
    Unusable {
        /// The plan.
        name: String,
        /// The reason, as a sentence.
        why: String,
    },
    /// A stored plan in a lane has branches, loops or lanes.
    #[error("`{name}` is no plain sequence, and a lane can only hold steps that come one after the other")]
    NoSequence {
        /// The plan.
        name: String,
    },
    /// A stored plan in a lane has several actors.
    #[error("`{name}` needs {}, and a lane has only one", .actors.join(" and "))]
    SeveralActors {
        /// The plan.
        name: String,
        /// Its actors.
        actors: Vec<String>,
    },
    /// A stored plan in a lane has a step without a single actor.
    #[error("`{name}` has a step that no single one of {} does, and a lane has only one", .actors.join(", "))]
    NoActor {
        /// The plan.
        name: String,
        /// The actors of the world.
        actors: Vec<String>,
    },
    /// A stored plan is in the lane of another actor.
    #[error("`{name}` is done by {actor}, and stands in the lane of {lane}")]
    WrongLane {
        /// The plan.
        name: String,
        /// The actor of the plan.
        actor: String,
        /// The actor of the lane.
        lane: String,
    },
    /// The composition has lanes, but no action of the domain names an actor.
    #[error("nothing can be done side by side in the domain `{domain}`: no action says who does it")]
    NoLanes {
        /// The domain.
        domain: String,
    },
    /// Branches and loops are nested too deeply.
    #[error("branches and loops stand in each other more than {limit} deep")]
    TooDeep {
        /// Maximum depth.
        limit: usize,
    },
    /// The inlined plan has too many steps.
    #[error("the plans have more than {limit} steps together")]
    TooLong {
        /// Maximum number of steps.
        limit: usize,
    },
}

impl Misfit {
    /// Returns the kind, as `--json` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::UnknownPlan { .. } => "unknown_plan",
            Self::Arguments { .. } => "plan_arguments",
            Self::PlanInCondition { .. } => "plan_in_condition",
            Self::Unusable { .. } => "unusable_plan",
            Self::NoSequence { .. } => "no_sequence",
            Self::SeveralActors { .. } => "several_actors",
            Self::NoActor { .. } => "no_actor",
            Self::WrongLane { .. } => "wrong_lane",
            Self::NoLanes { .. } => "no_lanes",
            Self::TooDeep { .. } => "too_deep",
            Self::TooLong { .. } => "too_long",
        }
    }
}

/// Returns the answer for a composition that cannot be inlined, with one violation for each misfit.
pub fn refused(world: &World, instruction: &str, misfits: &[Misfit]) -> Answer {
    let mut answer = Answer::without_plan(Status::Invalid, world, instruction, "");
    let violations = misfits.iter().map(|misfit| ViolationAnswer {
        kind: misfit.kind(),
        step: None,
        action: None,
        missing: Vec::new(),
        undone_by: None,
        when: Vec::new(),
        message: misfit.to_string(),
    });
    answer.violations = violations.collect();
    answer
}
