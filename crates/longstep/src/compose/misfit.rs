//! What keeps a composition from becoming a plan, before anything is simulated.

use crate::environment::World;
use crate::report::{Answer, Status, ViolationAnswer};

/// A part of a composition that cannot be put in its place.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum Misfit {
    /// A call that is neither a stored plan nor an action.
    #[error("there is no stored plan `{name}`{}", .near.as_ref().map_or(String::new(), |near| format!("; did you mean `{near}`?")))]
    UnknownPlan {
        /// What is called.
        name: String,
        /// A plan or an action of a similar name.
        near: Option<String>,
    },
    /// A stored plan is called with something in its parentheses.
    #[error(
        "`{name}` is a stored plan, which takes nothing in its parentheses: what it handles was settled when it was made"
    )]
    Arguments {
        /// The plan.
        name: String,
    },
    /// A stored plan stands in a condition.
    #[error(
        "`{name}` is a stored plan, which tells nothing that could be asked: a condition asks a sensing action or a state"
    )]
    Asked {
        /// The plan.
        name: String,
    },
    /// A stored plan means nothing in this domain, or in the world that it was made for.
    #[error("the stored plan `{name}` cannot be used: {why}")]
    Unusable {
        /// The plan.
        name: String,
        /// Why, in a sentence.
        why: String,
    },
    /// A stored plan in a lane branches, loops, or has lanes itself.
    #[error("`{name}` is no plain sequence, and a lane can only hold steps that come one after the other")]
    NoSequence {
        /// The plan.
        name: String,
    },
    /// A stored plan in a lane is done by several hands, arms or robots.
    #[error("`{name}` needs {}, and a lane has only one", .actors.join(" and "))]
    SeveralActors {
        /// The plan.
        name: String,
        /// Who does it.
        actors: Vec<String>,
    },
    /// A stored plan in a lane has a step that no single hand, arm or robot does.
    #[error("`{name}` has a step that no single one of {} does, and a lane has only one", .actors.join(", "))]
    NoActor {
        /// The plan.
        name: String,
        /// Those that there are.
        actors: Vec<String>,
    },
    /// A stored plan stands in the lane of another hand, arm or robot than the one that does it.
    #[error("`{name}` is done by {actor}, and stands in the lane of {lane}")]
    WrongLane {
        /// The plan.
        name: String,
        /// Who does it.
        actor: String,
        /// Whose lane it is.
        lane: String,
    },
    /// There is only one that could do anything.
    #[error("nothing can be done side by side in the domain `{domain}`: no action says who does it")]
    NoLanes {
        /// The domain.
        domain: String,
    },
    /// Branches and loops stand too deep in each other.
    #[error("branches and loops stand in each other more than {limit} deep")]
    TooDeep {
        /// How deep they may.
        limit: usize,
    },
    /// The stored plans have too many steps together.
    #[error("the plans have more than {limit} steps together")]
    TooLong {
        /// How many they may have.
        limit: usize,
    },
}

impl Misfit {
    /// The kind, as `--json` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::UnknownPlan { .. } => "unknown_plan",
            Self::Arguments { .. } => "plan_arguments",
            Self::Asked { .. } => "plan_in_condition",
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

/// The answer to a composition that is no plan: everything that does not fit.
pub fn refused(world: &World, instruction: &str, misfits: &[Misfit]) -> Answer {
    let mut answer = Answer::without_plan(Status::Invalid, world, instruction, "");
    let told = misfits.iter().map(|misfit| ViolationAnswer {
        kind: misfit.kind(),
        step: None,
        action: None,
        missing: Vec::new(),
        undone_by: None,
        when: Vec::new(),
        message: misfit.to_string(),
    });
    answer.violations = told.collect();
    answer
}
