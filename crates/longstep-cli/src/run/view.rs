//! The live view of a run, and its log.

use std::collections::BTreeMap;

use longstep_core::domain::phrase;
use longstep_core::environment::World;
use longstep_core::execution::{Effect, Event, Execution, Proposal, StepOrder, Stop, Subject, Unseen};
use longstep_core::plan::{Plan, outline};
use longstep_robot::{Feedback, RobotError, RunLog, Watcher};

use super::board::DrawnBoard;
use super::person::{Decide, Question};
use super::shown;
use crate::output::{self, Style, print_line, remark};
use crate::show;

/// Prints events as they come, after they are on disk.
pub(crate) struct View<'a> {
    log: RunLog,
    person: Box<dyn Decide + 'a>,
    /// True if a person approved the plan before the run.
    is_approved: bool,
    json: bool,
    /// True for a dry run, in which feedback is the result.
    is_dry: bool,
    /// The error that stopped the robot.
    robot_error: Option<RobotError>,
    /// The explanations of the orders under way.
    under_way: BTreeMap<u64, String>,
    /// None where it cannot be drawn; then each step is a line.
    board: Option<DrawnBoard>,
}

impl<'a> View<'a> {
    pub(crate) fn new(log: RunLog, person: impl Decide + 'a, json: bool, is_dry: bool) -> Self {
        Self {
            log,
            person: Box::new(person),
            is_approved: false,
            json,
            is_dry,
            robot_error: None,
            under_way: BTreeMap::new(),
            board: DrawnBoard::new().filter(|_| !json),
        }
    }

    /// Prints the steps of the board with how they ended.
    pub(crate) fn end(&mut self) {
        if let Some(board) = &mut self.board {
            board.end();
        }
    }

    /// Asks a person. The board is not drawn over the answer.
    fn ask(&mut self, question: Question<'_>) -> Option<bool> {
        if let Some(board) = &mut self.board {
            board.pause();
        }
        self.person.decide(question)
    }

    /// The error that stopped the robot, if one did.
    pub(super) fn robot_error(&self) -> Option<&RobotError> {
        self.robot_error.as_ref()
    }

    /// Returns the view of a plan that a person approved before the run.
    pub(crate) fn of_approved(self) -> Self {
        Self {
            is_approved: true,
            ..self
        }
    }

    fn print(&mut self, world: &World, event: &Event) {
        match event {
            Event::Ordered {
                order,
                lane,
                explanation,
                ..
            } => {
                let lane = lane
                    .as_ref()
                    .map_or(String::new(), |lane| format!("{}: ", shown(world, lane)));
                if self.board.is_none() {
                    print_line!("{order:>4}  {lane}{explanation}");
                }
                self.under_way.insert(*order, format!("{lane}{explanation}"));
            }
            Event::Announced {
                explanation, seconds, ..
            } => print_line!("      {} in {seconds} s: {}", "next:".cyan(), phrase(explanation)),
            Event::Performed { order, outcome } => {
                let done = self.under_way.remove(order);
                match (outcome, &self.board) {
                    (Some(outcome), None) => print_line!("{order:>4}  found: {outcome}"),
                    (Some(outcome), Some(_)) => {
                        print_line!("{}: {outcome}", phrase(&done.unwrap_or_default()));
                    }
                    (None, None) if !self.under_way.is_empty() => print_line!("{order:>4}  done"),
                    (None, _) => {}
                }
            }
            Event::Failed { order, why } => {
                let failed = self.under_way.remove(order);
                match self.board {
                    None => print_line!("{order:>4}  {} {why}", "failed:".red()),
                    Some(_) => print_line!("{} {} ({why})", "failed:".red(), phrase(&failed.unwrap_or_default())),
                }
            }
            Event::Assessed { effect, because, steps } => assessed(*effect, because, steps),
            Event::Changed { steps, edits, .. } => {
                for edit in edits {
                    print_line!("      {} {edit}", "change:".yellow());
                }
                print_line!("      the rest of the plan is now:");
                for step in steps {
                    print_line!("        - {step}");
                }
            }
            Event::Trusted { unseen } => unseen_facts(unseen),
            Event::Done { unseen, .. } if !self.is_dry => unseen_facts(unseen),
            Event::Found { order } => print_line!("{order:>4}  was done before the interruption, as the world shows"),
            _ => {}
        }
    }
}

fn unseen_facts(unseen: &[Unseen]) {
    for fact in unseen {
        print_line!("      {} {}", "not shown:".yellow(), fact.sentence());
    }
}

fn assessed(effect: Effect, because: &[String], steps: &[String]) {
    for fact in because {
        print_line!("      {} {fact}", "noticed:".yellow());
    }
    match effect {
        Effect::Harmless => {
            if !because.is_empty() {
                print_line!("      the plan still works");
            }
        }
        Effect::Helpful => print_line!("      skipped as needless: {}", listed(steps)),
        Effect::Undone => print_line!("      to be done again: {}", listed(steps)),
        Effect::Harmful => print_line!("      the plan no longer works from here"),
    }
}

/// Lists sentences in one line.
fn listed(sentences: &[String]) -> String {
    let phrases: Vec<&str> = sentences.iter().map(|sentence| phrase(sentence)).collect();
    phrases.join(", ")
}

impl Watcher for View<'_> {
    fn record(&mut self, execution: &Execution, events: &[Event]) -> Result<(), String> {
        self.log.append(events).map_err(|error| error.to_string())?;
        for event in events {
            if self.json {
                output::json_line(event).map_err(|error| error.to_string())?;
                continue;
            }
            self.print(execution.world(), event);
            if let Some(board) = &mut self.board {
                board.take(execution, event);
            }
        }
        if let Some(board) = &mut self.board {
            board.draw();
        }
        if output::failed() {
            Err("the output can no longer be written".to_owned())
        } else {
            Ok(())
        }
    }

    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool> {
        match &proposal.subject {
            Subject::Plan if self.is_approved => Some(true),
            Subject::Plan => {
                let rest = execution.cursor().rest();
                if !self.json {
                    let plan = execution.plan();
                    steps(plan.world(), rest.as_ref().map_or(plan.plan(), |rest| &rest.plan));
                }
                self.ask(Question::Proposal("Run this plan?"))
            }
            // Its steps were printed with the event.
            Subject::Change(_) => self.ask(Question::Proposal("Go on with this change?")),
            Subject::Step(order) => {
                let question = format!("Do this step: {}?", phrase(&order.explanation));
                self.ask(Question::Proposal(&question))
            }
            _ => None,
        }
    }

    fn judge(&mut self, _: &Execution, order: &StepOrder) -> Option<bool> {
        let question = format!(
            "Step {} was under way when the program ended: {}. Was it done?",
            order.number,
            phrase(&order.explanation)
        );
        self.ask(Question::Fact(&question))
    }

    fn confirm(&mut self, _: &Execution, unseen: &Unseen) -> Option<bool> {
        let since = match unseen.order {
            Some(order) => format!("Nobody has seen it since step {order}"),
            None => "Nobody has seen it".to_owned(),
        };
        self.ask(Question::Fact(&format!("{since}: {}. Is it so?", unseen.what)))
    }

    fn feedback(&mut self, order: &StepOrder, feedback: &Feedback) {
        let Some(text) = &feedback.text else {
            return;
        };
        match (self.json, self.is_dry) {
            (false, _) => print_line!("{:>4}  {text}", order.number),
            (true, true) => remark!("{:>4}  {text}", order.number),
            (true, false) => {}
        }
    }

    fn robot_failed(&mut self, error: &RobotError) {
        self.robot_error = Some(error.clone());
    }
}

fn steps(world: &World, plan: &Plan) {
    show::heading("Plan");
    show::steps(&outline(world, plan), |_| false);
    output::blank();
}

/// Prints how a run ended.
pub(crate) fn end(execution: &Execution, stop: Option<&Stop>, is_dry: bool) {
    output::blank();
    match stop {
        None if is_dry => print_line!(
            "{} the plan would reach the goal; nothing was sent. `--live` moves the robot",
            "Dry run:".green().bold()
        ),
        None if execution.rests_on_promises() => print_line!(
            "{} the goal is reached if what was not shown is as promised",
            "Done:".yellow().bold()
        ),
        None => print_line!("{} the goal is reached in the observed world", "Done:".green().bold()),
        Some(stop) => remark!("{} {}", "Stopped:".red().bold(), stop.sentence(execution.world())),
    }
}
