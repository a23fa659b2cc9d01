//! The person and the log beside a run.

use longstep_core::domain::phrase;
use longstep_core::execution::{Event, Execution, Proposal, StepOrder, Subject, Unseen};
use longstep_core::plan::{OutlineLine, outline};
use longstep_robot::{RunLog, Watcher};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use serde::Serialize;
use serde_json::Value;

use crate::argument::class_of;
use crate::interpreter::attach;
use crate::json;
use crate::plan::{Plan, quoted};
use crate::stopping::Raised;

/// The callables of the person.
pub(crate) struct Callables {
    /// Answers questions.
    pub(crate) ask: Option<Py<PyAny>>,
    /// Takes events.
    pub(crate) watch: Option<Py<PyAny>>,
}

/// The person and the log beside a run.
pub(crate) struct Beside {
    callables: Callables,
    log: Option<RunLog>,
    events: Vec<Value>,
    /// The steps and the edits of the last change.
    change: (Vec<String>, Vec<String>),
    /// The words of the instruction that the plan ignores.
    left_out: Vec<String>,
    is_watch_broken: bool,
    raised: Raised,
}

/// A question to the person.
#[derive(Serialize, Default)]
struct Question<'a> {
    kind: &'a str,
    text: String,
    steps: &'a [String],
    edits: &'a [String],
    left_out: &'a [String],
}

impl<'a> Question<'a> {
    /// Returns a question without lists.
    fn of(kind: &'a str, text: impl Into<String>) -> Self {
        Self {
            kind,
            text: text.into(),
            ..Self::default()
        }
    }
}

impl Beside {
    /// Returns what is beside a run of a plan.
    pub(crate) fn new(plan: &Plan, callables: Callables, log: Option<RunLog>, raised: Raised) -> Self {
        Self {
            callables,
            log,
            events: Vec::new(),
            change: Default::default(),
            left_out: plan.left_out(),
            is_watch_broken: false,
            raised,
        }
    }

    /// Returns the events so far.
    pub(crate) fn into_events(self) -> Vec<Value> {
        self.events
    }

    /// Asks the person; none without an answer.
    fn ask(&self, question: &Question<'_>) -> Option<bool> {
        let ask = self.callables.ask.as_ref()?;
        let answer = attach(|py| {
            let answer = ask.bind(py).call1((json::object(py, question)?,))?;
            answer.extract::<bool>().map_err(|_| {
                let class = class_of(&answer);
                PyTypeError::new_err(format!("`ask` must return True or False, not {class}"))
            })
        });
        answer.map_err(|error| self.raised.keep(error)).ok()
    }

    /// Shows events to the callable that watches the run. Its exception ends the run; then it is not called again.
    fn show(&self, events: &[Value]) -> PyResult<()> {
        let Some(watch) = &self.callables.watch else {
            return Ok(());
        };
        attach(|py| {
            events
                .iter()
                .try_for_each(|event| watch.bind(py).call1((json::object(py, event)?,)).map(|_| ()))
        })
    }
}

impl Watcher for Beside {
    fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
        let first = self.events.len();
        if let Some(log) = &mut self.log {
            log.append(events).map_err(|error| error.to_string())?;
        }
        for event in events {
            if let Event::Changed { steps, edits, .. } = event {
                self.change = (steps.clone(), edits.clone());
            }
            self.events
                .push(serde_json::to_value(event).map_err(|error| error.to_string())?);
        }
        if self.is_watch_broken {
            return Ok(());
        }
        self.show(&self.events[first..]).map_err(|error| {
            self.is_watch_broken = true;
            let text = error.to_string();
            self.raised.keep(error);
            format!("`watch` raised {text}")
        })
    }

    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool> {
        match &proposal.subject {
            Subject::Plan => {
                let plan = execution.plan();
                let rest = execution.cursor().rest();
                let lines = outline(plan.world(), rest.as_ref().map_or(plan.plan(), |rest| &rest.plan)).into_iter();
                let line = |own: OutlineLine| own.step.map_or(own.text, |_| own.explanation);
                let steps: Vec<String> = lines.map(line).collect();
                let text = match &self.left_out[..] {
                    [] => "Go on with this plan?".to_owned(),
                    words => format!("Go on with this plan? It leaves out {}.", quoted(words)),
                };
                self.ask(&Question {
                    steps: &steps,
                    left_out: &self.left_out,
                    ..Question::of("plan", text)
                })
            }
            Subject::Change(_) => self.ask(&Question {
                steps: &self.change.0,
                edits: &self.change.1,
                ..Question::of("change", "Go on with this change?")
            }),
            Subject::Step(order) => {
                let text = format!("Do this step: {}?", phrase(&order.explanation));
                self.ask(&Question::of("step", text))
            }
            _ => None,
        }
    }

    fn judge(&mut self, _: &Execution, order: &StepOrder) -> Option<bool> {
        let step = phrase(&order.explanation);
        let text = format!("This step was under way when the run was interrupted: {step}. Was it done?");
        self.ask(&Question::of("judge", text))
    }

    fn confirm(&mut self, _: &Execution, unseen: &Unseen) -> Option<bool> {
        let text = format!("Nobody has seen it: {}. Is it so?", unseen.what);
        self.ask(&Question::of("confirm", text))
    }
}
