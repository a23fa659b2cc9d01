//! The people beside a run: its log, its view, and their answers.

use jiff::Timestamp;
use longstep_core::domain::phrase;
use longstep_core::execution::{Board, Effect, Event, Execution, Proposal, StepOrder, Subject, Unseen};
use longstep_core::plan::outline;
use longstep_robot::{Feedback, RobotError, RunLog, Watcher};

use super::hosted::HostedRun;
use super::view::{QuestionView, RunState};
use crate::store::Durability;

/// The watcher of a run: its log in the store, its view, and the people who answer.
pub(crate) struct Watching<'r> {
    pub(crate) run: &'r HostedRun,
    pub(crate) board: Board,
    /// True until the plan that was approved is proposed.
    pub(crate) is_approved: bool,
    questions: usize,
    /// The steps of the last change, and its edits.
    change: (Vec<String>, Vec<String>),
}

impl<'r> Watching<'r> {
    pub(crate) fn new(run: &'r HostedRun, execution: &Execution, is_approved: bool) -> Self {
        let watching = Self {
            run,
            board: Board::of(execution),
            is_approved,
            questions: 0,
            change: (Vec::new(), Vec::new()),
        };
        watching.show(execution, 0, &[]);
        watching
    }

    fn show(&self, execution: &Execution, events: usize, notices: &[String]) {
        self.run.update(|view| {
            view.state = RunState::Running;
            view.steps = self.board.steps().to_vec();
            view.lines = self.board.lines().to_vec();
            view.events += events;
            view.notices.extend_from_slice(notices);
            view.environment = Some(execution.environment());
        });
    }

    fn ask_proposal(
        &mut self,
        kind: &'static str,
        proposal: &Proposal,
        text: String,
        steps: Vec<String>,
    ) -> Option<bool> {
        self.run.ask(QuestionView {
            id: proposal.id.to_string(),
            kind,
            text,
            steps,
            edits: Vec::new(),
        })
    }

    fn ask_fact(&mut self, kind: &'static str, text: String) -> Option<bool> {
        self.questions += 1;
        self.run.ask(QuestionView {
            id: format!("question-{}", self.questions),
            kind,
            text,
            steps: Vec::new(),
            edits: Vec::new(),
        })
    }
}

impl Watcher for Watching<'_> {
    fn record(&mut self, execution: &Execution, events: &[Event]) -> Result<(), String> {
        let lines = RunLog::lines(events, Timestamp::now()).map_err(|error| error.to_string())?;
        let rights = self.run.rights();
        let kept = rights.and_then(|rights| rights.log.append(&lines, Durability::Now));
        kept.map_err(|error| error.to_string())?;
        let mut notices = Vec::new();
        for event in events {
            self.board.take(execution, event);
            if let Event::Changed { steps, edits, .. } = event {
                self.change = (steps.clone(), edits.clone());
            }
            notices.extend(notices_of(event));
        }
        self.show(execution, events.len(), &notices);
        Ok(())
    }

    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool> {
        match &proposal.subject {
            // The run was begun with the approval of this plan; the execution was made of it.
            Subject::Plan if std::mem::take(&mut self.is_approved) => Some(true),
            Subject::Plan => {
                let plan = execution.plan();
                let rest = execution.cursor().rest();
                let lines = outline(plan.world(), rest.as_ref().map_or(plan.plan(), |rest| &rest.plan));
                let steps = lines.into_iter().map(|line| match line.step {
                    Some(_) => line.explanation,
                    None => line.text,
                });
                self.ask_proposal("plan", proposal, "Go on with this plan?".to_owned(), steps.collect())
            }
            Subject::Change(_) => {
                // The event with its steps came before.
                let (steps, edits) = self.change.clone();
                self.run.ask(QuestionView {
                    id: proposal.id.to_string(),
                    kind: "change",
                    text: "Go on with this change?".to_owned(),
                    steps,
                    edits,
                })
            }
            Subject::Step(order) => {
                let text = format!("Do this step: {}?", phrase(&order.explanation));
                self.ask_proposal("step", proposal, text, Vec::new())
            }
            _ => None,
        }
    }

    fn judge(&mut self, _: &Execution, order: &StepOrder) -> Option<bool> {
        let step = phrase(&order.explanation);
        self.ask_fact(
            "judge",
            format!("This step was under way when the run was interrupted: {step}. Was it done?"),
        )
    }

    fn confirm(&mut self, _: &Execution, unseen: &Unseen) -> Option<bool> {
        self.ask_fact("confirm", format!("Nobody has seen it: {}. Is it so?", unseen.what))
    }

    fn feedback(&mut self, _: &StepOrder, feedback: &Feedback) {
        if feedback.text.is_some() {
            self.run.update(|view| view.feedback.clone_from(&feedback.text));
        }
    }

    fn robot_failed(&mut self, error: &RobotError) {
        let hint = error.hint().map_or(String::new(), |hint| format!(" ({hint})"));
        self.run
            .update(|view| view.notices.push(format!("the robot failed: {error}{hint}")));
    }
}

/// Returns what an event tells a person besides the states of steps.
fn notices_of(event: &Event) -> Vec<String> {
    match event {
        Event::Failed { why, .. } => vec![format!("failed: {why}")],
        Event::Assessed { effect, because, steps } => {
            let mut notices: Vec<String> = because.iter().map(|fact| format!("noticed: {fact}")).collect();
            let phrases: Vec<&str> = steps.iter().map(|step| phrase(step)).collect();
            match effect {
                Effect::Harmless if because.is_empty() => {}
                Effect::Harmless => notices.push("the plan still works".to_owned()),
                Effect::Helpful => notices.push(format!("skipped as needless: {}", phrases.join(", "))),
                Effect::Undone => notices.push(format!("to be done again: {}", phrases.join(", "))),
                Effect::Harmful => notices.push("the plan no longer works from here".to_owned()),
            }
            notices
        }
        Event::Changed { edits, .. } => edits.iter().map(|edit| format!("change: {edit}")).collect(),
        Event::Performed {
            outcome: Some(outcome), ..
        } => vec![format!("found: {outcome}")],
        Event::Trusted { unseen } | Event::Done { unseen, .. } => unseen
            .iter()
            .map(|fact| format!("not shown: {}", fact.sentence()))
            .collect(),
        _ => Vec::new(),
    }
}
