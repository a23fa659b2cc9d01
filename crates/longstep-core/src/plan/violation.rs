//! What can be wrong with a plan.

use crate::model::{AssumptionSource, EntityId, Fact, Missing};

/// A finding about a plan. Steps count from 0.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum Violation {
    /// A step calls an action that the domain does not have.
    UnknownAction {
        /// The step.
        step: usize,
        /// What it calls.
        name: String,
        /// An action of a similar name.
        near: Option<String>,
    },
    /// A name that the environment does not list.
    UnknownEntity {
        /// The step; none for `object_name`.
        step: Option<usize>,
        /// The name.
        name: String,
        /// A listed name like it.
        near: Option<String>,
    },
    /// A condition calls an action that tells nothing.
    NotSensing {
        /// The step.
        step: usize,
        /// What it calls.
        call: String,
        /// What can be asked: calls that sense.
        senses: Vec<String>,
    },
    /// A condition asks something that is neither a sensing action nor a state.
    UnknownCondition {
        /// The place that it would have as a step.
        step: usize,
        /// What it asks.
        name: String,
        /// A sensing action or a state of a similar name.
        near: Option<String>,
    },
    /// A call gives a parameter that its action does not have, or that stands in its parentheses already.
    UnknownParameter {
        /// The step.
        step: usize,
        /// The parameter.
        name: String,
        /// A hidden parameter of a similar name.
        near: Option<String>,
    },
    /// A lane of somebody whom the environment does not list.
    UnknownActor {
        /// The name.
        name: String,
        /// A listed name like it.
        near: Option<String>,
    },
    /// What a step says that holds after it, and does not.
    StepClaim {
        /// The step.
        step: usize,
        /// The claimed fact.
        fact: Fact,
    },
    /// A call with too few or too many arguments.
    WrongArguments {
        /// The step.
        step: usize,
        /// The call as written.
        call: String,
        /// How many arguments it takes.
        expected: usize,
    },
    /// An argument of the wrong type.
    WrongType {
        /// The step.
        step: usize,
        /// The argument.
        name: String,
        /// The type that it should have.
        expected: String,
    },
    /// There are not as many explanations as steps.
    LengthMismatch {
        /// How many steps there are.
        calls: usize,
        /// How many explanations.
        explanations: usize,
    },
    /// A step was not applicable.
    Precondition {
        /// The step.
        step: usize,
        /// What it needed.
        missing: Vec<Missing>,
    },
    /// A rule of the domain is broken.
    Rule {
        /// The step after which it is; none for the end.
        step: Option<usize>,
        /// The rule's place in the domain's list.
        rule: usize,
        /// The entities for which it is.
        bindings: Vec<EntityId>,
    },
    /// Something wanted does not hold at the end.
    Goal {
        /// Which, in the order of the purpose's list.
        index: usize,
    },
    /// The plan claims a change that it does not bring about and that could be brought about.
    Claim {
        /// What is claimed.
        fact: Fact,
    },
    /// A step changes nothing.
    NoEffect {
        /// The step.
        step: usize,
    },
    /// Something ends elsewhere that the instruction does not speak of.
    Unasked {
        /// What.
        entity: EntityId,
    },
    /// A condition asks for something that only sensing can tell, and nothing sensed it.
    Unsensed {
        /// The first step of the branch or loop; none if there is none in it.
        step: Option<usize>,
        /// What it asks for.
        fact: Fact,
    },
    /// No way leads to the step.
    Unreached {
        /// The step.
        step: usize,
    },
    /// A loop can come to where it never ends.
    EndlessLoop {
        /// The first step of the loop; none if there is none in it.
        step: Option<usize>,
    },
    /// A plan can be in more states than are followed.
    TooManyStates {
        /// The first step of the part where there are too many.
        step: Option<usize>,
        /// How many there were when it was given up.
        states: usize,
    },
    /// Checking the plan takes more work than is done for one plan ([`crate::effort::OPERATION`]).
    TooMuchWork,
    /// Branches and loops stand deeper in each other than [`crate::plan::tree::DEEPEST`].
    TooDeep,
    /// Nothing in the world fits an argument that the call hides.
    NothingFits {
        /// The step.
        step: usize,
        /// The parameter's name.
        parameter: String,
    },
    /// Two steps that may happen at the same time handle the same thing.
    SharedObject {
        /// The one.
        step: usize,
        /// The other.
        other: usize,
        /// The thing.
        entity: EntityId,
    },
    /// It matters which of two steps that may happen at the same time comes first.
    Race {
        /// The one.
        step: usize,
        /// The other.
        other: usize,
        /// A fact that then holds or does not.
        fact: Fact,
    },
    /// A lane holds a step that is another's, or nobody's alone.
    WrongActor {
        /// The step.
        step: usize,
        /// Whose lane it is.
        actor: EntityId,
    },
    /// Two lanes are of the same actor.
    LaneTwice {
        /// The actor.
        actor: EntityId,
    },
    /// A step senses while other lanes go on, so that nobody could act on what it tells.
    SensesInLane {
        /// The step.
        step: usize,
    },
    /// Lanes wait for each other for ever.
    Deadlock {
        /// What one of them waits at.
        sync: String,
    },
    /// Something that is so only where sensing told certain things.
    When {
        /// What it told.
        facts: Vec<Fact>,
        /// What is so then.
        violation: Box<Violation>,
    },
}

/// Something that a verdict rests on and the environment does not say.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Assumption {
    /// A fact.
    Fact {
        /// The fact.
        fact: Fact,
        /// Why it is assumed.
        ground: AssumptionSource,
    },
    /// An argument that the plan does not show and that could be another.
    Argument {
        /// The step, from 0.
        step: usize,
        /// The parameter's name.
        parameter: String,
        /// What it was taken to be.
        entity: EntityId,
    },
    /// A name that was nearly right.
    Reading {
        /// The step, from 0; none for `object_name`.
        step: Option<usize>,
        /// What is written.
        written: String,
        /// What it was taken for.
        meant: String,
    },
}

impl Violation {
    /// The kind, as `--json` names it.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::UnknownAction { .. } => "unknown_action",
            Self::UnknownEntity { .. } => "unknown_entity",
            Self::NotSensing { .. } => "not_sensing",
            Self::UnknownCondition { .. } => "unknown_condition",
            Self::UnknownParameter { .. } => "unknown_parameter",
            Self::UnknownActor { .. } => "unknown_actor",
            Self::StepClaim { .. } => "step_claim",
            Self::WrongArguments { .. } => "wrong_arguments",
            Self::WrongType { .. } => "wrong_type",
            Self::LengthMismatch { .. } => "length_mismatch",
            Self::Precondition { .. } => "precondition",
            Self::Rule { .. } => "rule",
            Self::Goal { .. } => "goal",
            Self::Claim { .. } => "claim",
            Self::NoEffect { .. } => "no_effect",
            Self::Unasked { .. } => "unasked",
            Self::Unsensed { .. } => "unsensed",
            Self::Unreached { .. } => "unreached",
            Self::EndlessLoop { .. } => "endless_loop",
            Self::TooManyStates { .. } => "too_many_states",
            Self::TooMuchWork => "too_much_work",
            Self::TooDeep => "too_deep",
            Self::NothingFits { .. } => "nothing_fits",
            Self::SharedObject { .. } => "shared_object",
            Self::Race { .. } => "race",
            Self::WrongActor { .. } => "wrong_actor",
            Self::LaneTwice { .. } => "lane_twice",
            Self::SensesInLane { .. } => "senses_in_lane",
            Self::Deadlock { .. } => "deadlock",
            Self::When { violation, .. } => violation.kind(),
        }
    }

    /// The step that it is about, from 0.
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::UnknownAction { step, .. }
            | Self::WrongArguments { step, .. }
            | Self::WrongType { step, .. }
            | Self::NoEffect { step }
            | Self::Unreached { step }
            | Self::SharedObject { step, .. }
            | Self::Race { step, .. }
            | Self::WrongActor { step, .. }
            | Self::SensesInLane { step }
            | Self::NotSensing { step, .. }
            | Self::UnknownCondition { step, .. }
            | Self::UnknownParameter { step, .. }
            | Self::NothingFits { step, .. }
            | Self::StepClaim { step, .. }
            | Self::Precondition { step, .. } => Some(*step),
            Self::UnknownEntity { step, .. }
            | Self::Rule { step, .. }
            | Self::Unsensed { step, .. }
            | Self::EndlessLoop { step }
            | Self::TooManyStates { step, .. } => *step,
            Self::When { violation, .. } => violation.step(),
            Self::LengthMismatch { .. }
            | Self::Goal { .. }
            | Self::Claim { .. }
            | Self::UnknownActor { .. }
            | Self::Unasked { .. }
            | Self::LaneTwice { .. }
            | Self::TooMuchWork
            | Self::TooDeep
            | Self::Deadlock { .. } => None,
        }
    }

    /// Gives the steps that it speaks of other numbers.
    pub fn renumber(&mut self, number: impl Fn(usize) -> usize + Copy) {
        match self {
            Self::UnknownAction { step, .. }
            | Self::WrongArguments { step, .. }
            | Self::WrongType { step, .. }
            | Self::NoEffect { step }
            | Self::Unreached { step }
            | Self::WrongActor { step, .. }
            | Self::SensesInLane { step }
            | Self::NotSensing { step, .. }
            | Self::UnknownCondition { step, .. }
            | Self::UnknownParameter { step, .. }
            | Self::NothingFits { step, .. }
            | Self::StepClaim { step, .. } => *step = number(*step),
            Self::SharedObject { step, other, .. } | Self::Race { step, other, .. } => {
                *step = number(*step);
                *other = number(*other);
            }
            Self::Precondition { step, missing } => {
                *step = number(*step);
                for culprit in missing.iter_mut().filter_map(|missing| missing.undone_by.as_mut()) {
                    *culprit = number(*culprit);
                }
            }
            Self::UnknownEntity { step, .. }
            | Self::Rule { step, .. }
            | Self::Unsensed { step, .. }
            | Self::EndlessLoop { step }
            | Self::TooManyStates { step, .. } => *step = step.map(number),
            Self::When { violation, .. } => violation.renumber(number),
            Self::LengthMismatch { .. }
            | Self::Goal { .. }
            | Self::Claim { .. }
            | Self::UnknownActor { .. }
            | Self::Unasked { .. }
            | Self::LaneTwice { .. }
            | Self::TooMuchWork
            | Self::TooDeep
            | Self::Deadlock { .. } => {}
        }
    }

    /// The same, where it is so only when sensing told these facts.
    pub(crate) fn when(self, facts: Vec<Fact>) -> Self {
        if facts.is_empty() {
            return self;
        }
        Self::When {
            facts,
            violation: Box::new(self),
        }
    }

    /// What sensing told where it is so; empty if it is so in any case.
    pub fn told(&self) -> &[Fact] {
        match self {
            Self::When { facts, .. } => facts,
            _ => &[],
        }
    }

    /// The last step that took a missing fact away.
    pub fn undone_by(&self) -> Option<usize> {
        match self {
            Self::Precondition { missing, .. } => missing.iter().filter_map(|m| m.undone_by).max(),
            Self::When { violation, .. } => violation.undone_by(),
            _ => None,
        }
    }
}

/// Fact that a step claims to hold after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepClaim {
    /// The step, from 0.
    pub step: usize,
    /// What it says.
    pub fact: Fact,
}
