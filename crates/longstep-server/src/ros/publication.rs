//! The state of the server as its topics show it.

use std::collections::BTreeMap;
use std::time::{Duration, Instant};

use serde_json::{Map, Value, json};

use super::topic::Shown;
use crate::feed::{Happening, Page};
use crate::hub::Hub;
use crate::id::{RunId, SessionId};
use crate::run::RunView;
use crate::view::Snapshot;

/// The least time between two publications: what changes faster is shown as it is then.
const PERIOD: Duration = Duration::from_millis(100);

/// The most events that are read at once.
const EVENTS: usize = 1_000;

/// The most sessions and runs that are shown in one publication.
const CHANGES: usize = 16;

/// The largest message, in bytes. One that would be larger is replaced by a note.
const LARGEST: usize = 1 << 20;

/// A session or a run that has changed.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Changed {
    Session(SessionId),
    Run(RunId),
}

/// The last messages of the topics, and what has changed since.
#[derive(Debug)]
pub(super) struct Publication {
    /// The number of the last event that was read.
    event: u64,
    changed: Vec<Changed>,
    latest: BTreeMap<Shown, String>,
    next: Instant,
}

impl Publication {
    /// Begins with the events after now.
    pub(super) fn new(hub: &Hub, now: Instant) -> Self {
        Self {
            event: *hub.feed().newest().borrow(),
            changed: Vec::new(),
            latest: BTreeMap::new(),
            next: now,
        }
    }

    /// Returns the last message of each topic, for a new connection.
    pub(super) fn latest(&self) -> impl Iterator<Item = (Shown, &str)> {
        self.latest.iter().map(|(shown, text)| (*shown, text.as_str()))
    }

    /// Returns the messages that are due.
    pub(super) fn due(&mut self, hub: &Hub, now: Instant) -> Vec<(Shown, String)> {
        if now < self.next {
            return Vec::new();
        }
        self.follow(hub);
        if self.changed.is_empty() {
            return Vec::new();
        }
        self.next = now + PERIOD;
        let count = self.changed.len().min(CHANGES);
        let changed: Vec<Changed> = self.changed.drain(..count).collect();
        let messages = changed.iter().flat_map(|changed| messages_of(hub, changed));
        let mut due = Vec::new();
        for (shown, value) in messages.collect::<Vec<_>>() {
            let text = bounded(value);
            if self.latest.get(&shown) != Some(&text) {
                self.latest.insert(shown, text.clone());
                due.push((shown, text));
            }
        }
        due
    }

    /// Reads what has happened.
    fn follow(&mut self, hub: &Hub) {
        match hub.feed().after(self.event, EVENTS) {
            Page::Events(events) => {
                for event in events {
                    self.event = event.number;
                    match &event.happening {
                        Happening::Session { session, .. } => self.add(Changed::Session(session.clone())),
                        Happening::Run { run, .. } => self.add(Changed::Run(run.clone())),
                        Happening::Progress { .. } => {}
                    }
                }
            }
            // Much has happened without a bridge: what goes on is shown, and what has ended is not.
            Page::Gone(newest) => {
                self.event = newest;
                let runs = hub.runs();
                let going = runs.iter().filter(|run| !run.state.is_ended());
                going.for_each(|run| self.add(Changed::Run(run.record.id.clone())));
            }
        }
    }

    fn add(&mut self, changed: Changed) {
        if !self.changed.contains(&changed) {
            self.changed.push(changed);
        }
    }
}

/// Returns the messages about a session or a run as it is now.
fn messages_of(hub: &Hub, changed: &Changed) -> Vec<(Shown, Value)> {
    match changed {
        // A session that another program has taken is not shown.
        Changed::Session(id) => hub.session(id).map_or_else(
            |_| Vec::new(),
            |snapshot| {
                let environment = snapshot.robot_world.environment();
                let world = json!({"session": id, "run": null, "environment": environment});
                vec![(Shown::Plan, Value::Object(plan_of(&snapshot))), (Shown::World, world)]
            },
        ),
        Changed::Run(id) => hub.run(id).map_or_else(
            |_| Vec::new(),
            |run| {
                let mut messages = vec![(Shown::Progress, progress_of(&run))];
                if let Some(environment) = &run.environment {
                    let world = json!({"session": run.record.session, "run": id, "environment": environment});
                    messages.push((Shown::World, world));
                }
                messages
            },
        ),
    }
}

/// Returns a session with the plan that waits: for a decision, or else for a robot.
pub(super) fn plan_of(snapshot: &Snapshot) -> Map<String, Value> {
    let view = &snapshot.view;
    let mut fields = Map::new();
    let mut add = |name: &str, value: Value| drop(fields.insert(name.to_owned(), value));
    add("session", json!(view.id));
    add("version", json!(view.version));
    add("state", json!(view.state));
    add("instruction", json!(view.instruction));
    add("question", json!(view.question));
    add("failure", json!(view.failure.as_ref().map(|failure| &failure.message)));
    let pending = view.accepted.iter().find(|accepted| accepted.pending);
    match (&view.proposal, &snapshot.proposal, pending) {
        (Some(shown), Some(proposal), _) => {
            let steps = proposal.plan.steps().iter();
            let steps: Vec<&str> = steps.map(|step| step.explanation.as_str()).collect();
            let not_in_plan: Vec<&str> = shown
                .answer
                .not_represented
                .iter()
                .map(|gap| gap.text.as_str())
                .collect();
            add("plan", json!(shown.plan));
            add("decision", json!("proposed"));
            add("goal", json!(shown.answer.goal));
            add("steps", json!(steps));
            add("not_in_plan", json!(not_in_plan));
        }
        (_, _, Some(accepted)) => {
            add("plan", json!(accepted.plan));
            add("decision", json!("accepted"));
            add("goal", json!(accepted.goal));
            add("steps", json!(accepted.steps));
            add("not_in_plan", json!(accepted.not_in_plan));
        }
        _ => add("plan", Value::Null),
    }
    fields
}

/// Returns a run as HTTP shows it, without the world, which has a topic of its own.
fn progress_of(run: &RunView) -> Value {
    let mut view = serde_json::to_value(run).unwrap_or_default();
    if let Some(fields) = view.as_object_mut() {
        fields.shift_remove("environment");
    }
    view
}

/// Returns the text of a message, or a note in place of one that is too large.
fn bounded(value: Value) -> String {
    let text = value.to_string();
    if text.len() <= LARGEST {
        return text;
    }
    let id = |name: &str| value.get(name).cloned().unwrap_or_default();
    json!({"session": id("session"), "run": id("run"), "id": id("id"), "too_large": text.len()}).to_string()
}
