//! Sentences for violations and assumptions, addressed to a person or to a model.

use longstep_model::effort;
use longstep_model::model::{AssumptionSource, Missing, Voice, World, fact_text};

use crate::plan::{Assumption, Step, Violation, tree};

/// The goals of a purpose as sentences. Verification knows a goal by its number; its words are those of a goal language.
pub trait GoalSentences {
    /// Writes the goal with this index as a sentence; `None` if there is no such goal.
    fn goal_sentence(&self, index: usize, voice: Voice, world: &World) -> Option<String>;
}

impl Violation {
    /// The missing facts of the violation, as sentences.
    pub fn missing(&self, world: &World) -> Vec<String> {
        self.missing_in(Voice::Person, world)
    }

    fn missing_in(&self, voice: Voice, world: &World) -> Vec<String> {
        let text = |missing: &Missing| match &missing.number {
            Some(shortfall) => Some(voice.shortfall(world, shortfall)),
            None => missing.fact.map(|fact| voice.fact(world, fact, missing.holds)),
        };
        match self {
            Self::Precondition { missing, .. } => missing.iter().filter_map(text).collect(),
            Self::Claim { fact } | Self::Unsensed { fact, .. } => vec![voice.fact(world, *fact, true)],
            Self::When { violation, .. } => violation.missing_in(voice, world),
            _ => Vec::new(),
        }
    }

    /// Writes the violation as one sentence for a person, with steps counted from 1.
    pub fn message(&self, world: &World, steps: &[Step], goal: Option<&dyn GoalSentences>) -> String {
        self.message_in(Voice::Person, world, steps, goal)
    }

    /// Writes the violation as one sentence for a person or a model, with steps counted from 1.
    pub fn message_in(&self, voice: Voice, world: &World, steps: &[Step], goal: Option<&dyn GoalSentences>) -> String {
        let domain = world.domain();
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
            Self::OutOfRange { step, error } => {
                let place = step.map_or("`object_name`".to_owned(), |step| format!("step {}", step + 1));
                format!("{place}: {error}")
            }
            Self::NotSensing { step, call, senses } => {
                let mut message = format!(
                    "step {}: `{call}` is not a sensing action, so it cannot be a condition",
                    step + 1
                );
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
                format!("step {}: the call has no free parameter `{name}`{near}", step + 1)
            }
            Self::UnknownActor { name, near: n } => {
                format!("a lane: the environment lists no `{name}`{}", near(n))
            }
            Self::StepClaim { step, fact } => {
                let text = voice.fact(world, *fact, true);
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
                let texts = self.missing_in(voice, world);
                let call = called(world, steps, *step);
                let mut message = if texts.is_empty() {
                    format!("step {}: {call} can never be done like this", step + 1)
                } else {
                    format!("step {}: {call} needs that {}", step + 1, texts.join(", and that "))
                };
                for missing in missing {
                    let Some(culprit) = missing.undone_by else { continue };
                    let call = called(world, steps, culprit);
                    if let Some(fact) = missing.fact {
                        let now = voice.fact(world, fact, !missing.holds);
                        message.push_str(&format!("; since step {} ({call}), {now}", culprit + 1));
                    } else if let Some(shortfall) = &missing.number {
                        let requirement = voice.requirement(world, &shortfall.test);
                        message.push_str(&format!("; before step {} ({call}), {requirement}", culprit + 1));
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
            Self::Goal { index } => match goal.and_then(|goal| goal.goal_sentence(*index, voice, world)) {
                Some(text) => format!("at the end, this is not reached: {text}"),
                None => "at the end, the goal is not reached".to_owned(),
            },
            Self::Order { index, first } => {
                let text = goal.and_then(|goal| goal.goal_sentence(*index, voice, world));
                let text = text.unwrap_or_else(|| "a goal".to_owned());
                match first {
                    true => format!("the plan never achieves this: {text}"),
                    false => format!("the plan does not achieve this after what comes before it: {text}"),
                }
            }
            Self::Prohibited {
                step,
                prohibition,
                says,
            } => {
                let call = called(world, steps, *step);
                format!("step {}: {call} is forbidden by `{prohibition}`: {says}", step + 1)
            }
            Self::Claim { fact } => {
                let text = voice.fact(world, *fact, true);
                format!("the plan claims that {text}, but it does not hold at the end")
            }
            Self::NumberClaim {
                fluent,
                claimed,
                simulated,
            } => {
                let name = voice.fluent(world, *fluent);
                let claimed = voice.number(world, *fluent, *claimed);
                match simulated {
                    Some(number) => {
                        let number = voice.number(world, *fluent, *number);
                        format!("the plan claims that {name} is {claimed} at the end, but it is {number}")
                    }
                    None => format!("the plan claims that {name} is {claimed} at the end, but it is not known"),
                }
            }
            Self::NoEffect { step } => {
                let call = called(world, steps, *step);
                format!("step {}: {call} changes nothing", step + 1)
            }
            Self::Unasked { entity } => {
                let name = voice.name(world, *entity);
                format!("the plan moves {name}, which the instruction does not mention")
            }
            Self::Unsensed { step, fact } => {
                let text = voice.fact(world, *fact, true);
                format!(
                    "{}a condition asks whether {text}, and nothing has sensed that",
                    at(*step)
                )
            }
            Self::Unreached { step } => {
                let call = called(world, steps, *step);
                format!("step {}: {call} is never reached", step + 1)
            }
            Self::EndlessLoop { step } => {
                format!(
                    "{}the loop may never end: in some state no step in it changes its condition",
                    at(*step)
                )
            }
            Self::TooManyStates { step, states } => {
                format!(
                    "{}too many states: the plan can be in {states} of them and more",
                    at(*step)
                )
            }
            Self::TooMuchWork => format!(
                "checking the plan takes more than {} units of work; shorten it, or ask for fewer things at once",
                effort::OPERATION
            ),
            Self::TooDeep => format!(
                "branches and loops stand more than {} deep in each other",
                tree::DEEPEST
            ),
            Self::NothingFits { step, parameter } => {
                format!(
                    "step {}: nothing in the environment fits the hidden argument `{parameter}`",
                    step + 1
                )
            }
            Self::SharedObject { step, other, entity } => {
                let name = voice.name(world, *entity);
                format!("{}, and both handle {name}", together(world, steps, *step, *other))
            }
            Self::Race { step, other, fact } => {
                let text = voice.fact(world, *fact, true);
                let pair = together(world, steps, *step, *other);
                format!("{pair}, and which comes first decides whether {text}")
            }
            Self::NumberRace { step, other, fluent } => {
                let name = voice.fluent(world, *fluent);
                let pair = together(world, steps, *step, *other);
                format!("{pair}, and which comes first decides {name}")
            }
            Self::WrongActor { step, actor } => {
                let call = called(world, steps, *step);
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
                let call = called(world, steps, *step);
                format!(
                    "step {}: {call} senses while another lane goes on; sense before or after",
                    step + 1
                )
            }
            Self::Deadlock { sync } => {
                format!("the lanes wait for each other at `{sync}` for ever")
            }
            Self::When { facts, violation } => {
                let outcomes: Vec<String> = facts.iter().map(|fact| voice.fact(world, *fact, true)).collect();
                let message = violation.message_in(voice, world, steps, goal);
                format!("{message} (when {})", outcomes.join(" and "))
            }
        }
    }
}

/// The call of a step; "the step" where the caller knows no steps.
fn called(world: &World, steps: &[Step], step: usize) -> String {
    steps
        .get(step)
        .map_or_else(|| "the step".to_owned(), |step| step.call(world).to_string())
}

/// The prefix of a sentence about a step.
fn at(step: Option<usize>) -> String {
    step.map_or(String::new(), |step| format!("step {}: ", step + 1))
}

fn together(world: &World, steps: &[Step], first: usize, second: usize) -> String {
    let call = |step: usize| called(world, steps, step);
    format!(
        "step {}: {} may happen at the same time as step {} ({})",
        first + 1,
        call(first),
        second + 1,
        call(second)
    )
}

impl Assumption {
    /// Writes the assumption as one sentence for a person.
    pub fn message(&self, world: &World) -> String {
        match self {
            Self::Fact { fact, ground } => {
                let text = fact_text(world, *fact, true);
                match ground {
                    AssumptionSource::Derived { derivation }
                        if world.domain().derivations[*derivation].is_from_names() =>
                    {
                        format!("{text} (its name says so)")
                    }
                    AssumptionSource::Derived { .. } => format!("{text} (it follows from other facts)"),
                    AssumptionSource::Default => format!("{text} (usual, the environment does not say)"),
                    AssumptionSource::Unknown => format!("{text} (the environment does not say)"),
                }
            }
            Self::Argument {
                step,
                parameter,
                entity,
            } => {
                let name = world.with_article(*entity);
                format!("step {}: the {parameter} is {name} (the plan leaves it open)", step + 1)
            }
            Self::Reading { step, written, meant } => {
                let place = step.map_or("`object_name`".to_owned(), |step| format!("step {}", step + 1));
                format!("{place}: `{written}` was taken for `{meant}`")
            }
        }
    }
}
