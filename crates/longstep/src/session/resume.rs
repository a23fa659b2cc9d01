//! Resumption and replay of sessions from their logs.

use std::collections::VecDeque;
use std::sync::Arc;

use serde_json::Value;

use super::{Accepted, Event, Log, ModelFacts, ObserveError, OutOfTurn, RuleError, Session, Stage, StepRecord};
use crate::clock::Clock;
use crate::diagnostic::Diagnostics;
use crate::dialogue::{ConstraintKind, Message, Role};
use crate::environment;
use crate::goal::{self, Goal};
use crate::json::Path;
use crate::model::Domain;
use crate::plan::{Plan, PlanFile, Step, resolve};
use crate::verify::{Purpose, check};

/// Reason why a session cannot be resumed.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// The domain has changed and does not accept the initial environment.
    #[error("the first environment of the session cannot be read any more: {0}")]
    Environment(#[from] Diagnostics),
    /// The domain has changed and an accepted plan is no longer valid.
    #[error("plan {number} of the session is not valid any more: {why}")]
    Plan {
        /// Its number.
        number: usize,
        /// The reason.
        why: String,
    },
    /// The log does not start a session, or it reverts a plan that was never accepted.
    #[error("the log of the session contradicts itself: {0}")]
    Contradiction(String),
}

/// A resumed session.
#[derive(Debug)]
#[non_exhaustive]
pub struct Resumed {
    /// The session in its last state.
    pub session: Session,
    /// The current instruction, if it could not be restored.
    pub dropped: Option<String>,
}

impl Session {
    /// Resumes a session at the end of its log.
    ///
    /// Every accepted plan is verified again, in the final world of the previous one. The events after the last
    /// accepted plan are replayed with the recorded replies, which restores an open question or a proposed plan.
    ///
    /// # Errors
    ///
    /// The domain has changed, and the environment or an accepted plan no longer fits it.
    pub fn resume(domain: impl Into<Arc<Domain>>, log: &Log, clock: Clock) -> Result<Resumed, ResumeError> {
        let mut session = begin(domain.into(), log, clock)?;
        let mut tail: Vec<&Event> = Vec::new();
        for event in log.events().skip(1) {
            match event {
                Event::Accept {
                    instruction,
                    goal,
                    steps,
                    plan,
                    ..
                } => {
                    session.accept_again(instruction, goal, steps, plan)?;
                    let ends = plan.environment_after.as_ref();
                    if ends.is_some_and(|environment| environment != session.world.environment()) {
                        return Err(ResumeError::Plan {
                            number: session.accepted.len() - 1,
                            why: "it ends in another environment than it did".to_owned(),
                        });
                    }
                    session.settle(&mut tail);
                }
                Event::Ended { number, environment } => {
                    let contradiction = |error: OutOfTurn| ResumeError::Contradiction(error.to_string());
                    session.ended(*number).map_err(contradiction)?;
                    if **environment != *session.world.environment() {
                        return Err(ResumeError::Plan {
                            number: session.accepted.len() - 1,
                            why: "it ends in another environment than it did".to_owned(),
                        });
                    }
                }
                Event::Undo { .. } => {
                    session
                        .undo()
                        .map_err(|error| ResumeError::Contradiction(error.to_string()))?;
                    session.settle(&mut tail);
                }
                Event::Rule { .. } | Event::Lifted { .. } => {
                    let contradiction = |error: OutOfTurn| ResumeError::Contradiction(error.to_string());
                    session.take(event, &mut None).map_err(contradiction)?;
                }
                Event::Observed { .. } | Event::CarriedOut { .. } => {
                    session.settle(&mut tail);
                    let contradiction = |error: OutOfTurn| ResumeError::Contradiction(error.to_string());
                    session.take(event, &mut None).map_err(contradiction)?;
                }
                Event::Prompt { messages, .. } => session.prompts.push(messages.iter().map(message).collect()),
                Event::Instruction { text } => {
                    session.settle(&mut tail);
                    session.world.add_values(text);
                    tail.push(event);
                }
                event => tail.push(event),
            }
        }
        session.events.clear();
        let mut dropped = None;
        let mut pending = None;
        let instruction = tail.iter().find_map(|event| match event {
            Event::Instruction { text } => Some(text),
            _ => None,
        });
        if let Some(text) = instruction.filter(|_| is_older(log)) {
            // The replies to requests that are not made any more.
            dropped = Some(text.clone());
            tail.retain(|event| matches!(event, Event::Model { .. } | Event::Settings(_)));
        }
        let gone_through = tail.iter().try_for_each(|event| session.take(event, &mut pending));
        // The only possible new event is the acceptance of a plan that the log merely proposes.
        session.events.retain(|event| matches!(event, Event::Accept { .. }));
        if gone_through.is_err() {
            dropped = session.instruction().map(str::to_owned);
            session.stage = Stage::Idle;
            session.events.push(Event::Cancel);
        }
        Ok(Resumed { session, dropped })
    }

    /// Applies the events that outlast an instruction: model and settings.
    fn settle(&mut self, tail: &mut Vec<&Event>) {
        for event in tail.drain(..) {
            if let Event::Model { .. } | Event::Settings(_) = event {
                // These events are valid in every state.
                let _ = self.take(event, &mut None);
            }
        }
    }

    /// Verifies an accepted plan of the log and accepts it again.
    fn accept_again(
        &mut self,
        instruction: &str,
        goal: &[String],
        steps: &[StepRecord],
        file: &PlanFile,
    ) -> Result<(), ResumeError> {
        let number = self.accepted.len();
        let invalid = |why: String| ResumeError::Plan { number, why };
        for part in goal {
            self.world.add_values(part);
        }
        self.world = file.world_of(&self.world).into_owned();
        let goal: Option<Goal> = match goal {
            [] => None,
            parts => Some(goal::parse(&self.world, &parts.join(" & ")).map_err(|error| invalid(error.to_string()))?),
        };
        // The person accepted the plan as it is; a tidy rule that the domain got since does not take it back.
        let purpose = Purpose {
            from_goal: false,
            ..goal
                .as_ref()
                .map_or_else(Purpose::default, |goal| goal.purpose(&self.world))
        };
        let steps: Option<Vec<Step>> = steps.iter().map(|step| self.step(step)).collect();
        let steps = steps.ok_or_else(|| invalid("it has steps that the domain does not know".to_owned()))?;
        // The record has the steps with all arguments; the file has the plan tree.
        let plan = match file.task_cohesion.task_tree {
            None => Some(Plan::sequence(steps)),
            Some(_) => Plan::tree(steps, resolve(&self.world, &file.task_cohesion).body),
        };
        let plan = plan.ok_or_else(|| invalid("its tree does not go with its steps".to_owned()))?;
        let report = check(&self.world, plan, &purpose);
        let plan = report.into_verified().map_err(|report| {
            let violations = report.violations.iter();
            let goal = goal.as_ref().map(Goal::as_sentences);
            let messages = violations.map(|v| v.message(&self.world, report.plan.steps(), goal));
            invalid(messages.collect::<Vec<_>>().join("; "))
        })?;
        self.carry_on(Accepted {
            instruction: instruction.to_owned(),
            before: self.world.clone(),
            plan,
            goal,
            not_in_plan: file.not_in_plan.clone(),
        });
        Ok(())
    }

    fn step(&self, record: &StepRecord) -> Option<Step> {
        let mut actions = self.domain.action_ids();
        let (action, declared) = actions.find(|(_, action)| action.name == record.action)?;
        let arguments: Option<Vec<_>> = record.arguments.iter().map(|name| self.world.find(name)).collect();
        let arguments = arguments.filter(|arguments| arguments.len() == declared.parameters.len())?;
        Some(Step {
            action,
            arguments,
            explanation: record.explanation.clone(),
        })
    }

    /// Applies an input event of the log; the events that follow from it are computed again. `kept` are the entities in
    /// the prompt, unless it shows all.
    fn take(&mut self, event: &Event, kept: &mut Option<Vec<String>>) -> Result<(), OutOfTurn> {
        match event {
            Event::Instruction { text } => self.instruct(text),
            Event::Answer { text } => self.answer(text),
            Event::Feedback { text } => self.feedback(text),
            Event::Failed { error } => self.failed(error),
            Event::Cancel => self.cancel(),
            Event::Undo { .. } => self.undo().map(|_| ()),
            Event::Ended { number, .. } => self.ended(*number),
            Event::Accept { .. } => self.accept(),
            Event::Focus { kept: identifiers } => {
                *kept = Some(identifiers.clone());
                Ok(())
            }
            Event::Model { name, schema, context } => {
                let kind = if *schema {
                    ConstraintKind::JsonSchema
                } else {
                    ConstraintKind::Grammar
                };
                self.set_model(ModelFacts::new(name, kind).with_context(*context));
                Ok(())
            }
            Event::Settings(settings) => {
                self.set_settings(*settings);
                Ok(())
            }
            Event::Rule { text } => self.add_rule(text).map_err(RuleError::in_a_log),
            Event::Lifted { number } => self.lift_rule(*number).map(|_| ()).map_err(RuleError::in_a_log),
            Event::Observed { statements, .. } => self.observed(statements).map(drop).map_err(ObserveError::in_a_log),
            Event::CarriedOut {
                number,
                reached,
                statements,
                ..
            } => {
                let carried_out = self.carried_out(*number, *reached, statements);
                carried_out.map(drop).map_err(ObserveError::in_a_log)
            }
            Event::Refused { why } => {
                self.refuse_as_recorded(why);
                Ok(())
            }
            Event::Reply { .. } => {
                self.focus(kept.take());
                match event.as_reply() {
                    Some((reply, milliseconds)) => self.supply(&reply, milliseconds),
                    None => Ok(()),
                }
            }
            Event::Begin { .. }
            | Event::Prompt { .. }
            | Event::Request { .. }
            | Event::Verdict { .. }
            | Event::Correction { .. }
            | Event::Question { .. }
            | Event::Stuck { .. } => Ok(()),
        }
    }
}

/// Returns true if the log was written when an instruction had other requests.
fn is_older(log: &Log) -> bool {
    matches!(log.events().next(), Some(Event::Begin { version, .. }) if *version < ONE_REQUEST)
}

/// The version of logs since which an instruction has one request.
const ONE_REQUEST: u32 = 5;

fn begin(domain: Arc<Domain>, log: &Log, clock: Clock) -> Result<Session, ResumeError> {
    let Some(Event::Begin {
        domain: name,
        environment,
        settings,
        ..
    }) = log.events().next()
    else {
        return Err(ResumeError::Contradiction("it does not begin".to_owned()));
    };
    // The second line of the log names the model.
    let model = ModelFacts::new("", ConstraintKind::Grammar);
    let world = environment::read(&domain, environment, "environment", "", &Path::default())?;
    let mut session = Session::new(name, domain, world, *settings, model, clock);
    session.events.clear();
    Ok(session)
}

fn message(record: &super::MessageRecord) -> Message {
    let role = match record.role.as_str() {
        "system" => Role::System,
        "assistant" => Role::Assistant,
        _ => Role::User,
    };
    Message::new(role, record.text.clone())
}

/// Result of a replay.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Replay {
    /// Number of instructions in the log.
    pub instructions: usize,
    /// Number of accepted plans at its end.
    pub accepted: usize,
    /// Differences from the log.
    pub differing: Vec<ReplayDifference>,
}

/// A difference between a log and its replay.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct ReplayDifference {
    /// Line of the log, from 1.
    pub line: usize,
    /// The recorded event; none for an additional event today.
    pub recorded: Option<Value>,
    /// The event today; none for a missing event.
    pub today: Option<Value>,
}

/// Replays a log without a model: replies come from the log, and all other events are computed again and compared.
/// Durations are ignored.
///
/// # Errors
///
/// The first environment of the log does not fit the domain, or the log does not start a session.
pub fn replay(domain: impl Into<Arc<Domain>>, log: &Log) -> Result<Replay, ResumeError> {
    let mut session = begin(domain.into(), log, Clock::none())?;
    let mut replay = Replay {
        instructions: 0,
        accepted: 0,
        differing: Vec::new(),
    };
    let mut kept = None;
    let mut happened: VecDeque<Event> = VecDeque::new();
    let differ = |replay: &mut Replay, line: usize, recorded: Option<&Event>, today: Option<&Event>| {
        replay.differing.push(ReplayDifference {
            line,
            recorded: recorded.map(comparable),
            today: today.map(comparable),
        });
    };
    for (index, event) in log.events().enumerate().skip(1) {
        let line = index + 1;
        let expected = happened.front().is_some_and(|today| same_kind(today, event));
        match event {
            Event::Prompt { .. } | Event::Request { .. } => continue,
            Event::Focus { .. } => {
                let _ = session.take(event, &mut kept);
                continue;
            }
            event if event.is_given() && !expected => {
                for today in happened.drain(..) {
                    differ(&mut replay, line, None, Some(&today));
                }
                replay.instructions += usize::from(matches!(event, Event::Instruction { .. }));
                if session.take(event, &mut kept).is_err() {
                    differ(&mut replay, line, Some(event), None);
                    continue;
                }
                happened.extend(session.take_events());
            }
            _ => {}
        }
        if happened.is_empty() && matches!(event, Event::Refused { .. }) {
            let _ = session.take(event, &mut kept);
        }
        match happened.pop_front() {
            Some(today) if comparable(&today) == comparable(event) => {}
            today => differ(&mut replay, line, Some(event), today.as_ref()),
        }
    }
    replay.accepted = session.accepted.len();
    Ok(replay)
}

impl Event {
    /// Returns true for inputs from the person or the model, false for events that follow from them.
    fn is_given(&self) -> bool {
        matches!(
            self,
            Self::Model { .. }
                | Self::Settings(_)
                | Self::Rule { .. }
                | Self::Lifted { .. }
                | Self::Instruction { .. }
                | Self::Reply { .. }
                | Self::Failed { .. }
                | Self::Answer { .. }
                | Self::Feedback { .. }
                | Self::Accept { .. }
                | Self::Ended { .. }
                | Self::Observed { .. }
                | Self::CarriedOut { .. }
                | Self::Undo { .. }
                | Self::Cancel
        )
    }
}

fn same_kind(one: &Event, other: &Event) -> bool {
    std::mem::discriminant(one) == std::mem::discriminant(other)
}

/// Returns an event as JSON, without durations and readings: these explain a decision and are none.
fn comparable(event: &Event) -> Value {
    // Serialization cannot fail: an event is plain data with string keys.
    let mut value = serde_json::to_value(event).unwrap_or_default();
    for part in ["", "/answer"] {
        if let Some(part) = value.pointer_mut(part).and_then(Value::as_object_mut) {
            part.remove("timings_ms");
            part.remove("readings");
        }
    }
    value
}
