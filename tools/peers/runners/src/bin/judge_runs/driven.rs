//! A run that `longstep_robot::drive` drives: the robot and the person are at the other end of the pipe.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use longstep_core::execution::{Event, Execution, Proposal, StepOrder as Wanted, Subject, Unseen};
use longstep_robot::{
    Description, Handle, Observation, Order, Progress, Robot, RobotError, Scope, StopRequest, StopSwitch, Watcher,
};
use serde_json::{Value, json};

use crate::pipe::Pipe;

/// A robot at the other end of the pipe.
pub(crate) struct PipeRobot {
    pipe: Pipe,
    description: Description,
    request: StopRequest,
    stopped: Arc<AtomicBool>,
    confirmed: bool,
    orders: u64,
}

impl PipeRobot {
    /// Returns a robot with these capabilities.
    pub(crate) fn new(pipe: Pipe, description: Description, request: StopRequest) -> Self {
        Self {
            pipe,
            description,
            request,
            stopped: Arc::default(),
            confirmed: false,
            orders: 0,
        }
    }

    fn ask(&mut self, question: &Value) -> Result<Value, RobotError> {
        if self.stopped.load(Ordering::SeqCst) {
            return Err(RobotError::Stopped);
        }
        let answer = self.pipe.ask(question, &self.request);
        match error_of(&answer) {
            Some(error) => {
                if error.is_final() {
                    self.stopped.store(true, Ordering::SeqCst);
                }
                Err(error)
            }
            None => Ok(answer),
        }
    }
}

/// Returns the error of an answer `{"error": KIND}`.
fn error_of(answer: &Value) -> Option<RobotError> {
    let reason = "said by the judge".to_owned();
    Some(match answer["error"].as_str()? {
        "timed-out" => RobotError::TimedOut {
            what: "the judge".to_owned(),
            limit: Duration::from_secs(1),
        },
        "protocol" => RobotError::Protocol { reason },
        "rejected" => RobotError::Rejected { step: 1, reason },
        "unsupported" => RobotError::Unsupported { action: reason },
        "refused" => RobotError::Refused {
            method: "observe".to_owned(),
            reason,
        },
        _ => RobotError::Gone {
            reason,
            messages: String::new(),
        },
    })
}

impl Robot for PipeRobot {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.ask(&json!({"start": order}))?;
        self.orders += 1;
        Ok(Handle::new(self.orders))
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        let answer = self.ask(&json!({"poll": handle.number()}))?;
        Ok(match (answer.get("done"), answer["failed"].as_str()) {
            (Some(outcome), _) => Progress::Done {
                outcome: outcome.as_u64().and_then(|own| usize::try_from(own).ok()),
            },
            (None, Some(reason)) => Progress::Failed {
                reason: reason.to_owned(),
            },
            (None, None) => Progress::Running(None),
        })
    }

    fn observe(&mut self, _: &Scope) -> Result<Observation, RobotError> {
        let answer = self.ask(&json!({"observe": null}))?;
        serde_json::from_value(answer["observation"].clone()).map_err(|error| RobotError::Protocol {
            reason: error.to_string(),
        })
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.stopped.store(true, Ordering::SeqCst);
        if !self.confirmed {
            self.confirmed = true;
            let answer = self.pipe.ask(&json!({"stop": null}), &self.request);
            if let Some(error) = error_of(&answer) {
                return Err(error);
            }
        }
        Ok(())
    }

    fn stop_switch(&self) -> StopSwitch {
        let stopped = Arc::clone(&self.stopped);
        StopSwitch::new(move || stopped.store(true, Ordering::SeqCst))
    }

    fn wait(&mut self, _: Duration) {}
}

/// The log and the person at the other end of the pipe.
pub(crate) struct PipeWatcher {
    pipe: Pipe,
    request: StopRequest,
}

impl PipeWatcher {
    pub(crate) fn new(pipe: Pipe, request: StopRequest) -> Self {
        Self { pipe, request }
    }

    fn decide(&self, question: &Value) -> Option<bool> {
        self.pipe.ask(question, &self.request)["answer"].as_bool()
    }
}

/// Writes events as the lines of a log.
pub(crate) fn record(events: &[Event]) -> Result<Value, String> {
    let lines: Result<Vec<String>, _> = events.iter().map(serde_json::to_string).collect();
    Ok(json!({"record": lines.map_err(|error| error.to_string())?}))
}

/// Writes a proposal as a question.
pub(crate) fn approval(execution: &Execution, proposal: &Proposal) -> Value {
    let (subject, call) = match &proposal.subject {
        Subject::Plan => ("plan", Value::Null),
        Subject::Change(_) => ("change", Value::Null),
        Subject::Step(order) => ("step", order.written(execution.world()).into()),
        _ => ("other", Value::Null),
    };
    json!({"approve": {"id": proposal.id.to_string(), "subject": subject, "call": call}})
}

/// Writes the question whether an order was done.
pub(crate) fn judging(execution: &Execution, order: &Wanted) -> Value {
    json!({"judge": {"order": order.number, "call": order.written(execution.world())}})
}

/// Writes the question whether something is so that no look has shown.
pub(crate) fn confirming(unseen: &Unseen) -> Value {
    json!({"confirm": unseen})
}

impl Watcher for PipeWatcher {
    fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
        let answer = self.pipe.ask(&record(events)?, &self.request);
        match answer["error"].as_str() {
            Some(error) => Err(error.to_owned()),
            None => Ok(()),
        }
    }

    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool> {
        self.decide(&approval(execution, proposal))
    }

    fn judge(&mut self, execution: &Execution, order: &Wanted) -> Option<bool> {
        self.decide(&judging(execution, order))
    }
    fn confirm(&mut self, _: &Execution, unseen: &Unseen) -> Option<bool> {
        self.decide(&confirming(unseen))
    }
}
