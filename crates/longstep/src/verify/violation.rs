//! What can be wrong with a plan.

use super::history::{Here, History};
use super::trace::Change;
use crate::domain::Domain;
use crate::goal::Goal;
use crate::plan::Step;
use crate::world::{EntityId, Fact, Ground, Voice, World, fact_text};

/// A fact that a step needed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Missing {
    /// The fact; none when no fact could have helped.
    pub fact: Option<Fact>,
    /// Whether it had to hold, or not to hold.
    pub holds: bool,
    /// The step that took it away, counted from 0; none if it never was.
    pub undone_by: Option<usize>,
}

/// A finding about a plan. Steps count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
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
        /// What it says.
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
        ground: Ground,
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

/// Fills in which step on the way took each missing fact away.
pub(super) fn with_culprits(mut missing: Vec<Missing>, history: &History, here: Here) -> Vec<Missing> {
    for missing in &mut missing {
        let undoes = |change: &Change| Some(change.fact) == missing.fact && change.holds != missing.holds;
        missing.undone_by = history
            .back(here)
            .find(|(_, changes)| changes.iter().any(undoes))
            .map(|(step, _)| step.index());
    }
    missing
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
            | Self::Deadlock { .. } => None,
        }
    }

    /// Gives the steps that it speaks of other numbers.
    pub(crate) fn renumber(&mut self, number: impl Fn(usize) -> usize + Copy) {
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
            | Self::Deadlock { .. } => {}
        }
    }

    /// The same, where it is so only when sensing told these facts.
    pub(super) fn when(self, facts: Vec<Fact>) -> Self {
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

    /// The facts that were missing, as sentences.
    pub fn missing(&self, domain: &Domain, world: &World) -> Vec<String> {
        self.missing_in(Voice::Person, domain, world)
    }

    fn missing_in(&self, voice: Voice, domain: &Domain, world: &World) -> Vec<String> {
        let text = |m: &Missing| m.fact.map(|fact| voice.fact(domain, world, fact, m.holds));
        match self {
            Self::Precondition { missing, .. } => missing.iter().filter_map(text).collect(),
            Self::Claim { fact } | Self::Unsensed { fact, .. } => vec![voice.fact(domain, world, *fact, true)],
            Self::When { violation, .. } => violation.missing_in(voice, domain, world),
            _ => Vec::new(),
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

    /// One sentence for a person; steps are counted from 1 in it.
    pub fn message(&self, domain: &Domain, world: &World, steps: &[Step], goal: Option<&Goal>) -> String {
        self.message_in(Voice::Person, domain, world, steps, goal)
    }

    /// The same in either voice.
    pub fn message_in(
        &self,
        voice: Voice,
        domain: &Domain,
        world: &World,
        steps: &[Step],
        goal: Option<&Goal>,
    ) -> String {
        let near = |near: &Option<String>| {
            near.as_ref()
                .map_or(String::new(), |n| format!("; did you mean `{n}`?"))
        };
        match self {
            Self::UnknownAction { step, name, near: n } => {
                format!(
                    "step {}: `{name}` is no action of the domain `{}`{}",
                    step + 1,
                    domain.name,
                    near(n)
                )
            }
            Self::UnknownEntity { step, name, near: n } => {
                let place = step.map_or("`object_name`".to_owned(), |step| format!("step {}", step + 1));
                format!("{place}: the environment lists no `{name}`{}", near(n))
            }
            Self::NotSensing { step, call, senses } => {
                let mut message = format!("step {}: `{call}` tells nothing, so no condition can ask it", step + 1);
                if !senses.is_empty() {
                    message.push_str(&format!("; what can be asked is {}", senses.join(", ")));
                }
                message
            }
            Self::UnknownCondition { step, name, near: n } => {
                let near = near(n);
                format!(
                    "step {}: `{name}` is neither a sensing action nor a state{near}",
                    step + 1
                )
            }
            Self::UnknownParameter { step, name, near: n } => {
                let near = near(n);
                format!("step {}: the call hides no parameter `{name}`{near}", step + 1)
            }
            Self::UnknownActor { name, near: n } => {
                format!("a lane: the environment lists no `{name}`{}", near(n))
            }
            Self::StepClaim { step, fact } => {
                let text = voice.fact(domain, world, *fact, true);
                format!("step {} claims that {text}, which is not so after it", step + 1)
            }
            Self::WrongArguments { step, call, expected } => {
                format!("step {}: `{call}` should have {expected} argument(s)", step + 1)
            }
            Self::WrongType { step, name, expected } => {
                format!("step {}: `{name}` is no {expected}", step + 1)
            }
            Self::LengthMismatch { calls, explanations } => {
                format!("`task_sequence` has {calls} entries and `step_instructions` has {explanations}")
            }
            Self::Precondition { step, missing } => {
                let texts = self.missing_in(voice, domain, world);
                let call = steps[*step].call(domain, world);
                let mut message = if texts.is_empty() {
                    format!("step {}: {call} can never be done like this", step + 1)
                } else {
                    format!("step {}: {call} needs that {}", step + 1, texts.join(", and that "))
                };
                for missing in missing {
                    if let (Some(fact), Some(culprit)) = (missing.fact, missing.undone_by) {
                        let now = voice.fact(domain, world, fact, !missing.holds);
                        let call = steps[culprit].call(domain, world);
                        message.push_str(&format!("; since step {} ({call}), {now}", culprit + 1));
                    }
                }
                message
            }
            Self::Rule { step, rule, bindings } => {
                let says = domain.rules[*rule].says.fill(|slot| voice.name(world, bindings[slot]));
                match step {
                    Some(step) => format!("after step {}: {says}", step + 1),
                    None => format!("at the end: {says}"),
                }
            }
            Self::Goal { index } => match goal.and_then(|goal| goal.facts.get(*index)) {
                Some(fact) => format!(
                    "at the end, this is not reached: {}",
                    fact.sentence_in(voice, domain, world)
                ),
                None => "at the end, the goal is not reached".to_owned(),
            },
            Self::Claim { fact } => {
                let text = voice.fact(domain, world, *fact, true);
                format!("at the end, this is claimed and not so: {text}")
            }
            Self::NoEffect { step } => {
                let call = steps[*step].call(domain, world);
                format!("step {}: {call} changes nothing", step + 1)
            }
            Self::Unasked { entity } => {
                let name = voice.name(world, *entity);
                format!("{name} ends elsewhere, and nobody asked for that")
            }
            Self::Unsensed { step, fact } => {
                let text = voice.fact(domain, world, *fact, true);
                format!(
                    "{}a condition asks whether {text}, and nothing has sensed that",
                    at(*step)
                )
            }
            Self::Unreached { step } => {
                let call = steps[*step].call(domain, world);
                format!("step {}: {call} is never reached", step + 1)
            }
            Self::EndlessLoop { step } => {
                format!(
                    "{}the loop can come to where nothing in it changes what it asks, and never ends",
                    at(*step)
                )
            }
            Self::TooManyStates { step, states } => {
                format!(
                    "{}too many states: the plan can be in {states} of them and more",
                    at(*step)
                )
            }
            Self::SharedObject { step, other, entity } => {
                let name = voice.name(world, *entity);
                format!(
                    "{}, and both handle {name}",
                    together(domain, world, steps, *step, *other)
                )
            }
            Self::Race { step, other, fact } => {
                let text = voice.fact(domain, world, *fact, true);
                let pair = together(domain, world, steps, *step, *other);
                format!("{pair}, and which comes first decides whether {text}")
            }
            Self::WrongActor { step, actor } => {
                let call = steps[*step].call(domain, world);
                let whose = &world.entity(*actor).identifier;
                format!(
                    "step {}: {call} stands in the lane of `{whose}`, and is not its step alone",
                    step + 1
                )
            }
            Self::LaneTwice { actor } => {
                format!(
                    "there are two lanes of `{}` side by side",
                    world.entity(*actor).identifier
                )
            }
            Self::SensesInLane { step } => {
                let call = steps[*step].call(domain, world);
                format!(
                    "step {}: {call} senses while another lane goes on; sense before or after",
                    step + 1
                )
            }
            Self::Deadlock { sync } => {
                format!("the lanes wait for each other at `{sync}` for ever")
            }
            Self::When { facts, violation } => {
                let told: Vec<String> = facts
                    .iter()
                    .map(|fact| voice.fact(domain, world, *fact, true))
                    .collect();
                let message = violation.message_in(voice, domain, world, steps, goal);
                format!("{message} (when {})", told.join(" and "))
            }
        }
    }
}

/// The beginning of a sentence about a part of a plan.
fn at(step: Option<usize>) -> String {
    step.map_or(String::new(), |step| format!("step {}: ", step + 1))
}

fn together(domain: &Domain, world: &World, steps: &[Step], first: usize, second: usize) -> String {
    let call = |step: usize| steps[step].call(domain, world);
    format!(
        "step {}: {} may happen at the same time as step {} ({})",
        first + 1,
        call(first),
        second + 1,
        call(second)
    )
}

impl Assumption {
    /// One sentence for a person.
    pub fn message(&self, domain: &Domain, world: &World) -> String {
        match self {
            Self::Fact { fact, ground } => {
                let text = fact_text(domain, world, *fact, true);
                match ground {
                    Ground::Derived => format!("{text} (its name says so)"),
                    Ground::Default => format!("{text} (usual, the environment does not say)"),
                    Ground::Unknown => format!("{text} (the environment does not say)"),
                }
            }
            Self::Argument {
                step,
                parameter,
                entity,
            } => {
                let name = world.entity(*entity).with_article();
                format!("step {}: the {parameter} is {name} (the plan leaves it open)", step + 1)
            }
            Self::Reading { step, written, meant } => {
                let place = step.map_or("`object_name`".to_owned(), |step| format!("step {}", step + 1));
                format!("{place}: `{written}` was taken for `{meant}`")
            }
        }
    }
}
