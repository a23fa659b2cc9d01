//! Violations: findings of verification about a plan.

use longstep_model::model::{AssumptionSource, EntityId, Fact, Fluent, Missing, Number, OutOfRange};

/// A violation in a plan. Steps count from 0.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum Violation {
    /// A step calls an unknown action.
    UnknownAction {
        /// The step.
        step: usize,
        /// The called name.
        name: String,
        /// A known action with a similar name.
        near: Option<String>,
    },
    /// The environment does not list this name.
    UnknownEntity {
        /// The step; none for a name in `object_name` or `object_names`.
        step: Option<usize>,
        /// The name.
        name: String,
        /// A listed name that is similar.
        near: Option<String>,
    },
    /// A value is out of range for its type.
    OutOfRange {
        /// The step; none for a name in `object_name` or `object_names`.
        step: Option<usize>,
        /// The value and the limit.
        error: OutOfRange,
    },
    /// A condition calls an action that is not a sensing action.
    NotSensing {
        /// The step.
        step: usize,
        /// The call.
        call: String,
        /// The calls of the domain's sensing actions.
        senses: Vec<String>,
    },
    /// A condition contains a name that is neither a sensing action nor a state word.
    UnknownCondition {
        /// The step number that the call would have.
        step: usize,
        /// The name.
        name: String,
        /// A sensing action or state word with a similar name.
        near: Option<String>,
    },
    /// A call names a parameter that its action does not have or that has an argument already.
    UnknownParameter {
        /// The step.
        step: usize,
        /// The parameter.
        name: String,
        /// A free parameter with a similar name.
        near: Option<String>,
    },
    /// The environment does not list the actor of a lane.
    UnknownActor {
        /// The name.
        name: String,
        /// A listed name that is similar.
        near: Option<String>,
    },
    /// A fact that a step claims to hold after it does not hold.
    StepClaim {
        /// The step.
        step: usize,
        /// The claimed fact.
        fact: Fact,
    },
    /// A call has too few or too many arguments.
    WrongArguments {
        /// The step.
        step: usize,
        /// The call as written.
        call: String,
        /// Number of arguments that the action takes.
        expected: usize,
    },
    /// An argument has the wrong type.
    WrongType {
        /// The step.
        step: usize,
        /// The argument.
        name: String,
        /// The expected type.
        expected: String,
    },
    /// The number of explanations differs from the number of steps.
    LengthMismatch {
        /// Number of steps.
        calls: usize,
        /// Number of explanations.
        explanations: usize,
    },
    /// A step is not applicable.
    Precondition {
        /// The step.
        step: usize,
        /// The missing preconditions.
        missing: Vec<Missing>,
    },
    /// The plan breaks a rule of the domain.
    Rule {
        /// The step after which the rule is broken; none for the final state.
        step: Option<usize>,
        /// Index of the rule in the domain's list.
        rule: usize,
        /// The entities that the rule is broken for.
        bindings: Vec<EntityId>,
    },
    /// A step that a person has forbidden, or a step into a state that a person has forbidden.
    Prohibited {
        /// The step.
        step: usize,
        /// The prohibition in the goal language.
        prohibition: String,
        /// The prohibition as a sentence.
        says: String,
    },
    /// A goal is never achieved, or only before a goal that comes first.
    Order {
        /// Index of the goal in the list of the purpose.
        index: usize,
        /// True for a goal of the first stage.
        first: bool,
    },
    /// A goal does not hold in the final state.
    Goal {
        /// Index of the goal in the list of the purpose.
        index: usize,
    },
    /// The plan claims a change that it does not achieve, although some plan could achieve it.
    Claim {
        /// The claimed fact.
        fact: Fact,
    },
    /// The plan claims another number for a fluent than it ends with.
    NumberClaim {
        /// The fluent.
        fluent: Fluent,
        /// The claimed number.
        claimed: Number,
        /// The number after the last step; none if it is not known.
        simulated: Option<Number>,
    },
    /// A step has no effect.
    NoEffect {
        /// The step.
        step: usize,
    },
    /// The plan moves an entity that the instruction does not mention.
    Unasked {
        /// The moved entity.
        entity: EntityId,
    },
    /// A condition depends on a fact that only sensing can reveal, and no earlier step senses it.
    Unsensed {
        /// The first step of the branch or loop; none if it has no steps.
        step: Option<usize>,
        /// The fact.
        fact: Fact,
    },
    /// No execution path reaches the step.
    Unreached {
        /// The step.
        step: usize,
    },
    /// A loop may never end.
    EndlessLoop {
        /// The first step of the loop; none if it has no steps.
        step: Option<usize>,
    },
    /// The number of reachable states exceeds the limit of the simulation.
    TooManyStates {
        /// The first step of the part where the limit is exceeded.
        step: Option<usize>,
        /// Number of states when the simulation stopped.
        states: usize,
    },
    /// Verification of the plan exceeds the work budget ([`longstep_model::effort::OPERATION`]).
    TooMuchWork,
    /// Branches and loops are nested deeper than [`crate::plan::tree::DEEPEST`].
    TooDeep,
    /// No entity in the world fits an implicit argument.
    NothingFits {
        /// The step.
        step: usize,
        /// The parameter's name.
        parameter: String,
    },
    /// Two concurrent steps use the same object.
    SharedObject {
        /// The first step.
        step: usize,
        /// The second step.
        other: usize,
        /// The shared object.
        entity: EntityId,
    },
    /// The order of two concurrent steps changes the outcome.
    Race {
        /// The first step.
        step: usize,
        /// The second step.
        other: usize,
        /// A fact whose value depends on the order.
        fact: Fact,
    },
    /// The order of two concurrent steps changes a number.
    NumberRace {
        /// The first step.
        step: usize,
        /// The second step.
        other: usize,
        /// A fluent whose number depends on the order.
        fluent: Fluent,
    },
    /// A step in a lane belongs to another actor, or to no single actor.
    WrongActor {
        /// The step.
        step: usize,
        /// The actor of the lane.
        actor: EntityId,
    },
    /// Two lanes have the same actor.
    LaneTwice {
        /// The actor.
        actor: EntityId,
    },
    /// A sensing step runs while other lanes continue, so that no branch can use its outcome.
    SensesInLane {
        /// The step.
        step: usize,
    },
    /// Lanes wait for each other forever.
    Deadlock {
        /// Name of a synchronization point where one of them waits.
        sync: String,
    },
    /// A violation that occurs only after certain sensing outcomes.
    When {
        /// The sensing outcomes.
        facts: Vec<Fact>,
        /// The violation.
        violation: Box<Violation>,
    },
}

/// An assumption: the verdict depends on it, and the environment does not state it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Assumption {
    /// An assumed fact.
    Fact {
        /// The fact.
        fact: Fact,
        /// The reason for the assumption.
        ground: AssumptionSource,
    },
    /// An implicit argument that has more than one possible value.
    Argument {
        /// The step, from 0.
        step: usize,
        /// The parameter's name.
        parameter: String,
        /// The chosen entity.
        entity: EntityId,
    },
    /// A misspelled name that was matched to a known name.
    Reading {
        /// The step, from 0; none for a name in `object_name` or `object_names`.
        step: Option<usize>,
        /// The name in the plan.
        written: String,
        /// The name that it was matched to.
        meant: String,
    },
}

impl Violation {
    /// The kind of the violation in `--json` output.
    pub fn kind(&self) -> &'static str {
        match self {
            Self::UnknownAction { .. } => "unknown_action",
            Self::UnknownEntity { .. } => "unknown_entity",
            Self::OutOfRange { .. } => "out_of_range",
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
            Self::Order { .. } => "order",
            Self::Prohibited { .. } => "prohibited",
            Self::Claim { .. } | Self::NumberClaim { .. } => "claim",
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
            Self::Race { .. } | Self::NumberRace { .. } => "race",
            Self::WrongActor { .. } => "wrong_actor",
            Self::LaneTwice { .. } => "lane_twice",
            Self::SensesInLane { .. } => "senses_in_lane",
            Self::Deadlock { .. } => "deadlock",
            Self::When { violation, .. } => violation.kind(),
        }
    }

    /// The step that the violation is about, from 0.
    pub fn step(&self) -> Option<usize> {
        match self {
            Self::UnknownAction { step, .. }
            | Self::WrongArguments { step, .. }
            | Self::WrongType { step, .. }
            | Self::NoEffect { step }
            | Self::Unreached { step }
            | Self::SharedObject { step, .. }
            | Self::Race { step, .. }
            | Self::NumberRace { step, .. }
            | Self::WrongActor { step, .. }
            | Self::SensesInLane { step }
            | Self::NotSensing { step, .. }
            | Self::UnknownCondition { step, .. }
            | Self::UnknownParameter { step, .. }
            | Self::NothingFits { step, .. }
            | Self::StepClaim { step, .. }
            | Self::Prohibited { step, .. }
            | Self::Precondition { step, .. } => Some(*step),
            Self::UnknownEntity { step, .. }
            | Self::OutOfRange { step, .. }
            | Self::Rule { step, .. }
            | Self::Unsensed { step, .. }
            | Self::EndlessLoop { step }
            | Self::TooManyStates { step, .. } => *step,
            Self::When { violation, .. } => violation.step(),
            Self::LengthMismatch { .. }
            | Self::Goal { .. }
            | Self::Order { .. }
            | Self::Claim { .. }
            | Self::NumberClaim { .. }
            | Self::UnknownActor { .. }
            | Self::Unasked { .. }
            | Self::LaneTwice { .. }
            | Self::TooMuchWork
            | Self::TooDeep
            | Self::Deadlock { .. } => None,
        }
    }

    /// Replaces each step number by the result of `number`.
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
            | Self::Prohibited { step, .. }
            | Self::StepClaim { step, .. } => *step = number(*step),
            Self::SharedObject { step, other, .. }
            | Self::Race { step, other, .. }
            | Self::NumberRace { step, other, .. } => {
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
            | Self::OutOfRange { step, .. }
            | Self::Rule { step, .. }
            | Self::Unsensed { step, .. }
            | Self::EndlessLoop { step }
            | Self::TooManyStates { step, .. } => *step = step.map(number),
            Self::When { violation, .. } => violation.renumber(number),
            Self::LengthMismatch { .. }
            | Self::Goal { .. }
            | Self::Order { .. }
            | Self::Claim { .. }
            | Self::NumberClaim { .. }
            | Self::UnknownActor { .. }
            | Self::Unasked { .. }
            | Self::LaneTwice { .. }
            | Self::TooMuchWork
            | Self::TooDeep
            | Self::Deadlock { .. } => {}
        }
    }

    /// Limits the violation to certain sensing outcomes; unchanged if there are none.
    pub(crate) fn when(self, facts: Vec<Fact>) -> Self {
        if facts.is_empty() {
            return self;
        }
        Self::When {
            facts,
            violation: Box::new(self),
        }
    }

    /// The sensing outcomes that lead to the violation; empty if it occurs in any case.
    pub fn outcomes(&self) -> &[Fact] {
        match self {
            Self::When { facts, .. } => facts,
            _ => &[],
        }
    }

    /// The last step that deleted a missing precondition.
    pub fn undone_by(&self) -> Option<usize> {
        match self {
            Self::Precondition { missing, .. } => missing.iter().filter_map(|m| m.undone_by).max(),
            Self::When { violation, .. } => violation.undone_by(),
            _ => None,
        }
    }
}

/// A fact that a step claims to hold after it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct StepClaim {
    /// The step, from 0.
    pub step: usize,
    /// The claimed fact.
    pub fact: Fact,
}
