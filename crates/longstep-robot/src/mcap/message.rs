//! The messages of a recording, event by event.

use std::collections::BTreeMap;

use longstep_core::domain::phrase;
use longstep_core::execution::{Effect, Event, Unseen};
use serde_json::{Map, Value, json};

use super::channel::Channel;

/// A message for a topic.
pub(super) type Message = (Channel, Value);

/// Nanoseconds in a second.
const SECOND: u64 = 1_000_000_000;

/// The level of a line for people, with the numbers of `foxglove.Log`.
#[derive(Debug, Clone, Copy)]
enum Level {
    Info = 2,
    Warning = 3,
    Error = 4,
}

/// An order of the run, as later messages about it repeat it.
#[derive(Debug, Clone)]
struct Ordered {
    fields: Map<String, Value>,
    explanation: String,
    at: u64,
}

/// The messages of a run, event by event.
#[derive(Debug, Default)]
pub(super) struct Messages {
    orders: BTreeMap<u64, Ordered>,
    /// The number of plans until now.
    plans: u64,
}

impl Messages {
    /// Returns the messages of an event, with its number in the log from 0.
    pub(super) fn of(&mut self, index: usize, at: u64, event: &Event) -> Vec<Message> {
        let mut messages = match event {
            Event::Announced { .. }
            | Event::Ordered { .. }
            | Event::Performed { .. }
            | Event::Failed { .. }
            | Event::Found { .. }
            | Event::Judged { .. } => self.step(at, event).into_iter().collect(),
            Event::Observed { statements } => vec![(Channel::Observation, json!({ "statements": statements }))],
            Event::Assessed { effect, because, steps } => {
                let message = json!({"effect": effect, "because": because, "steps": steps});
                vec![(Channel::Assessment, message)]
            }
            Event::Changed {
                kind,
                plan,
                steps,
                edits,
            } => {
                self.plans += 1;
                let message = json!({"number": self.plans, "origin": kind, "steps": steps, "edits": edits,
                    "task_tree": plan});
                vec![(Channel::Plan, message)]
            }
            Event::Began { plan, goal, .. } => {
                let message = json!({"number": 0, "origin": "begun", "goal": goal.as_deref().unwrap_or_default(),
                    "steps": [], "edits": [], "task_tree": plan});
                vec![(Channel::Plan, message)]
            }
            _ => Vec::new(),
        };
        messages.extend(run(event).map(|message| (Channel::Run, message)));
        messages.extend(world(event).map(|message| (Channel::World, message)));
        messages.extend(self.line(index, at, event).map(|message| (Channel::Log, message)));
        messages
    }

    /// Returns the message about a step. Each has all of the order, so that a viewer can show it alone.
    fn step(&mut self, at: u64, event: &Event) -> Option<Message> {
        let (number, state, more) = match event {
            Event::Announced {
                order,
                call,
                lane,
                seconds,
                explanation,
            } => {
                let mut fields = fields_of(*order, lane.as_deref(), call, explanation);
                fields.insert("state".to_owned(), json!("announced"));
                fields.insert("announced_s".to_owned(), json!(seconds));
                return Some((Channel::Step, Value::Object(fields)));
            }
            Event::Ordered {
                order,
                step,
                lane,
                call,
                explanation,
            } => {
                let mut fields = fields_of(*order, lane.as_deref(), call, explanation);
                fields.insert("step".to_owned(), json!(step));
                let explanation = explanation.clone();
                self.orders.insert(
                    *order,
                    Ordered {
                        fields,
                        explanation,
                        at,
                    },
                );
                (*order, "ordered", None)
            }
            Event::Performed { order, outcome } => {
                let outcome = outcome.as_ref().map(|outcome| ("outcome", outcome.clone()));
                (*order, "performed", outcome)
            }
            Event::Failed { order, why } => (*order, "failed", Some(("why", why.clone()))),
            Event::Found { order } => (*order, "found", None),
            Event::Judged { order, done: true } => (*order, "judged-done", None),
            Event::Judged { order, done: false } => (*order, "judged-not-done", None),
            _ => return None,
        };
        let ordered = self.orders.get(&number);
        let mut fields = ordered.map_or_else(Map::new, |ordered| ordered.fields.clone());
        fields.insert("order".to_owned(), json!(number));
        fields.insert("state".to_owned(), json!(state));
        if let Some((name, text)) = more {
            fields.insert(name.to_owned(), json!(text));
        }
        if let Some(ordered) = ordered.filter(|_| state != "ordered") {
            let seconds = at.saturating_sub(ordered.at) as f64 / SECOND as f64;
            fields.insert("seconds".to_owned(), json!(seconds));
        }
        Some((Channel::Step, Value::Object(fields)))
    }

    /// Returns the event as a line for people; none for one that says nothing to them.
    fn line(&self, index: usize, at: u64, event: &Event) -> Option<Value> {
        let (level, text) = self.sentence(event)?;
        Some(json!({
            "timestamp": {"sec": at / SECOND, "nsec": at % SECOND},
            "level": level as u8,
            "message": text,
            "name": "longstep",
            "file": "run.jsonl",
            // The first line of a log is its header.
            "line": index + 2,
        }))
    }

    fn sentence(&self, event: &Event) -> Option<(Level, String)> {
        use Level::{Error, Info, Warning};
        let step = |order: &u64| match self.orders.get(order) {
            Some(ordered) => format!("order {order} ({})", phrase(&ordered.explanation)),
            None => format!("order {order}"),
        };
        Some(match event {
            Event::Began { domain, .. } => (Info, format!("the run begins, in the domain `{domain}`")),
            Event::Approved { proposal } => (Info, format!("approved: {proposal}")),
            Event::Refused => (Warning, "refused".to_owned()),
            Event::Announced {
                explanation, seconds, ..
            } => (Info, format!("next, in {seconds} s: {}", phrase(explanation))),
            Event::Ordered { order, .. } => (Info, format!("{} is ordered", step(order))),
            Event::Performed { order, outcome } => match outcome {
                Some(outcome) => (Info, format!("{} is done; found: {outcome}", step(order))),
                None => (Info, format!("{} is done", step(order))),
            },
            Event::Failed { order, why } => (Warning, format!("{} failed: {why}", step(order))),
            Event::Observed { .. } => return None,
            Event::Assessed { effect, because, .. } => {
                let facts = because.join("; ");
                match effect {
                    Effect::Harmless if because.is_empty() => return None,
                    Effect::Harmless => (Info, format!("noticed: {facts}; the plan still works")),
                    Effect::Helpful => (Info, format!("noticed: {facts}; steps are skipped")),
                    Effect::Undone => (Warning, format!("noticed: {facts}; steps are repeated")),
                    Effect::Harmful => (Warning, format!("noticed: {facts}; the plan no longer works")),
                }
            }
            Event::Changed { steps, .. } => (Warning, format!("the plan is changed; {} steps are left", steps.len())),
            Event::Paused => (Info, "paused".to_owned()),
            Event::Continued => (Info, "continued".to_owned()),
            Event::Interrupted { under_way, .. } => {
                let orders: Vec<String> = under_way.iter().map(step).collect();
                let unknown = if orders.is_empty() {
                    "nothing".to_owned()
                } else {
                    orders.join(", ")
                };
                (
                    Warning,
                    format!("resumed after an interruption; {unknown} was under way"),
                )
            }
            Event::Found { order } => (Info, format!("{} was done, as the world shows", step(order))),
            Event::Judged { order, done } => {
                let done = if *done { "was done" } else { "was not done" };
                (Info, format!("{} {done}, a person says", step(order)))
            }
            Event::Confirmed { what, holds } => {
                let holds = if *holds { "yes" } else { "no" };
                (Info, format!("a person confirms that {what}: {holds}"))
            }
            Event::Trusted { unseen } => (Warning, format!("on promises: {}", listed(unseen))),
            Event::Stopped { why, .. } => (Error, format!("stopped: {why}")),
            Event::Done { unseen, .. } if unseen.is_empty() => (Info, "done".to_owned()),
            Event::Done { unseen, .. } => (Info, format!("done; not shown: {}", listed(unseen))),
            _ => return None,
        })
    }
}

fn fields_of(order: u64, lane: Option<&str>, call: &str, explanation: &str) -> Map<String, Value> {
    let mut fields = Map::new();
    fields.insert("order".to_owned(), json!(order));
    if let Some(lane) = lane {
        fields.insert("lane".to_owned(), json!(lane));
    }
    fields.insert("call".to_owned(), json!(call));
    fields.insert("explanation".to_owned(), json!(explanation));
    fields
}

fn listed(unseen: &[Unseen]) -> String {
    let sentences: Vec<String> = unseen.iter().map(Unseen::sentence).collect();
    sentences.join("; ")
}

/// Returns the state of the run after an event; none for an event about a step or the world.
fn run(event: &Event) -> Option<Value> {
    Some(match event {
        Event::Began { .. } => json!({"state": "running", "event": "began"}),
        Event::Approved { proposal } => json!({"state": "running", "event": "approved", "proposal": proposal}),
        Event::Refused => json!({"state": "running", "event": "refused"}),
        Event::Paused => json!({"state": "paused", "event": "paused"}),
        Event::Continued => json!({"state": "running", "event": "continued"}),
        Event::Interrupted { under_way, .. } => {
            json!({"state": "running", "event": "interrupted", "under_way": under_way})
        }
        Event::Confirmed { what, holds } => {
            json!({"state": "running", "event": "confirmed", "text": what, "holds": holds})
        }
        Event::Trusted { unseen } => json!({"state": "running", "event": "trusted", "unseen": sentences(unseen)}),
        Event::Stopped { why, under_way, .. } => {
            json!({"state": "stopped", "event": "stopped", "text": why, "under_way": under_way})
        }
        Event::Done { unseen, .. } => json!({"state": "done", "event": "done", "unseen": sentences(unseen)}),
        _ => return None,
    })
}

fn sentences(unseen: &[Unseen]) -> Vec<String> {
    unseen.iter().map(Unseen::sentence).collect()
}

/// Returns the whole world, at the beginning and at an end.
fn world(event: &Event) -> Option<Value> {
    match event {
        Event::Began { environment, .. } | Event::Stopped { environment, .. } | Event::Done { environment, .. } => {
            Some(json!({ "environment": environment }))
        }
        _ => None,
    }
}
