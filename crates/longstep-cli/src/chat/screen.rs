//! The output of a conversation.

use std::path::Path;

use longstep::goal::Goal;
use longstep::session::{Ended, Observed, Refusal, Response, Session};
use longstep_core::environment::{Environment, World};
use longstep_core::plan::{self, Plan};
use longstep_core::verify::{Purpose, VerifiedPlan};
use longstep_core::visible;
use longstep_files::session_directory;

use crate::output::{Style, counted, print_line, remark};
use crate::{output, show, solve};

/// Terminals in which rustyline does not edit lines, so a prompt cannot begin with one.
const PLAIN_TERMINALS: [&str; 3] = ["dumb", "cons25", "emacs"];

/// Prints a notice of the program.
pub(super) fn notice(text: &str) {
    remark!("{}", text.dimmed());
}

/// Says what becomes of a line that was typed before the prompt.
pub(super) fn typed_ahead(line: &str) {
    let can_edit = !std::env::var("TERM").is_ok_and(|terminal| PLAIN_TERMINALS.contains(&terminal.as_str()));
    if can_edit {
        notice("You typed this before the prompt. Enter sends it, Ctrl-U clears it:")
    } else {
        notice(&format!("You typed this before the prompt, and it is not sent: {line}"))
    }
}

/// The name of a session on the command line.
pub(super) fn session_name(folder: &Path) -> String {
    match (session_directory(), folder.parent(), folder.file_name()) {
        (Ok(all), Some(parent), Some(name)) if all == parent => name.to_string_lossy().into_owned(),
        _ => folder.display().to_string(),
    }
}

/// Prints the session's response.
pub(super) fn response(session: &Session, interactive: bool) {
    match session.response() {
        Response::Question(question) => print_line!("{} {question}", "Question:".yellow().bold()),
        Response::Plan(_) => {
            proposal(session);
            waiting(interactive);
        }
        Response::Consent(waits) => {
            proposal(session);
            if let Some(question) = &waits.question {
                print_line!("{} {question}", "Question:".yellow().bold());
            }
            consent(interactive);
        }
        Response::Endings(endings) => ended(session, &endings),
        Response::NoPlan(failure) => match failure.answer() {
            Some(answer) => show::answer(answer, show::Changes::Hidden),
            None => print_line!("{} {failure}", "No plan:".red().bold()),
        },
        // Nothing has happened that the person does not know.
        _ => {}
    }
}

/// Without a terminal there is no prompt, so a line says that the plan waits for a decision.
fn waiting(interactive: bool) {
    if !interactive {
        let line = "Waiting for a decision: an empty line accepts the plan, `no` cancels it.";
        print_line!("{}", line.dimmed());
        output::blank();
    }
}

/// Without a terminal there is no prompt, so a line says how the question is answered.
fn consent(interactive: bool) {
    if !interactive {
        print_line!(
            "{}",
            "Waiting for an answer: an empty line says yes, `no` cancels.".dimmed()
        );
        output::blank();
    }
}

/// Requests the outcome of a plan with several possible ends.
pub(super) fn ended(session: &Session, endings: &[Ended]) {
    print_line!("{}", "How did the plan end?".yellow().bold());
    for (number, ending) in endings.iter().enumerate() {
        let when = if ending.when.is_empty() {
            "in every other case".to_owned()
        } else {
            ending.when.join(", and ")
        };
        print_line!("  {} {when}", format!("{}.", number + 1).bold());
        show::changes(session.world().environment(), &ending.environment);
    }
    output::blank();
}

/// Prints what has changed since the last plan.
pub(super) fn observed(observed: &Observed) {
    if observed.changes.is_empty() {
        notice("The world is as expected");
    } else {
        show::list("Changed since the last plan", &observed.changes);
        output::blank();
    }
    if !observed.unknown.is_empty() {
        let unknown = observed.unknown.join(", ");
        notice(&format!(
            "The environment does not list these entities, and they are left out: {unknown}"
        ));
    }
}

fn proposal(session: &Session) {
    let Some(proposal) = session.proposal() else { return };
    if !proposal.refused.is_empty() {
        // The reasons refer to the changed plan, in which steps have other numbers.
        let of_steps = proposal
            .refused
            .iter()
            .any(|why| matches!(why, Refusal::Change(obstacle) if obstacle.step().is_some()));
        let title = if of_steps {
            "This change is not possible. In the plan with your change:"
        } else {
            "This change is not possible"
        };
        show::heading(title);
        for why in &proposal.refused {
            print_line!("  - {why}");
        }
        output::blank();
        print_line!("The plan is unchanged; `/plan` shows it.");
        return;
    }
    if let Some(goal) = &proposal.goal {
        goal_lines(session.world(), goal, &proposal.plan);
    }
    show::answer(&proposal.answer, show::Changes::Hidden);
}

fn goal_lines(world: &World, goal: &Goal, plan: &VerifiedPlan) {
    show::heading("Goal");
    for line in solve::goal_lines(world, goal) {
        print_line!("  {line}");
    }
    if !plan.steps().is_empty() {
        output::blank();
    }
}

/// Prints the last accepted plan and its changes.
pub(super) fn accepted(session: &Session) {
    let number = session.accepted().len() - 1;
    let Some(last) = session.accepted().last() else { return };
    // With `--yes` the user has not seen the plan yet.
    if session.settings().accept {
        if let Some(goal) = &last.goal {
            goal_lines(&last.before, goal, &last.plan);
        }
        let lines = plan::outline(&last.before, last.plan.plan());
        show::steps(&lines, |_| false);
        output::blank();
    }
    print_line!("{} as plan {number}", "Accepted".green().bold());
    let endings = session.endings();
    if !endings.is_empty() {
        return ended(session, &endings);
    }
    show::changes(last.before.environment(), session.world().environment());
    output::blank();
}

/// The current plan or the last accepted one: its initial world, the plan, its purpose and its goal.
pub(super) fn at_hand(session: &Session) -> Option<(&World, &Plan, Purpose, Option<&Goal>)> {
    if let Some(proposal) = session.proposal() {
        let plan = proposal.plan.plan();
        return Some((session.world(), plan, proposal.purpose.clone(), proposal.goal.as_ref()));
    }
    let last = session.accepted().last()?;
    let goal = last.goal.as_ref();
    let purpose = goal.map_or_else(Purpose::default, |goal| goal.purpose(session.world()));
    Some((&last.before, last.plan.plan(), purpose, goal))
}

pub(super) fn plan(session: &Session) {
    if let Some(proposal) = session.proposal() {
        if let Some(goal) = &proposal.goal {
            goal_lines(session.world(), goal, &proposal.plan);
        }
        show::answer(&proposal.answer, show::Changes::Shown);
        return;
    }
    match session.accepted().last() {
        Some(last) => {
            let number = session.accepted().len() - 1;
            print_line!("{} {}", format!("Plan {number}:").bold(), last.instruction);
            let lines = plan::outline(&last.before, last.plan.plan());
            show::steps(&lines, |_| false);
        }
        None => print_line!("There is no plan yet"),
    }
}

/// Prints the rules in force with their numbers.
pub(super) fn rules(session: &Session) {
    if session.rules().is_empty() {
        notice("No rules; `/rules never opened(fridge)` adds one");
    }
    for (number, rule) in session.rules().iter().enumerate() {
        let (written, says) = (visible::line(&rule.written), visible::line(&rule.says));
        print_line!("  {}. {written}  ({says})", number + 1);
    }
}

/// Prints the world, one line an entity.
pub(super) fn environment(session: &Session) {
    let environment = session.world().environment();
    let all = environment.assets.iter().chain(&environment.objects);
    let width = all
        .clone()
        .map(|identifier| visible::line(identifier).chars().count())
        .max()
        .unwrap_or(0);
    for (title, list) in [("Assets", &environment.assets), ("Objects", &environment.objects)] {
        show::heading(title);
        for identifier in list {
            let states = states(environment, identifier);
            let identifier = visible::line(identifier);
            match states {
                nothing if nothing.is_empty() => print_line!("  {identifier}"),
                states => print_line!("  {identifier:width$}  {}", states.dimmed()),
            }
        }
    }
}

fn states(environment: &Environment, identifier: &str) -> String {
    let states = [&environment.asset_states, &environment.object_states];
    let words = states.iter().find_map(|states| states.get(identifier));
    words.map_or_else(String::new, |words| words.as_slice().join(", "))
}

/// Prints the state of a resumed session.
pub(super) fn where_we_are(session: &Session, interactive: bool) {
    let count = session.accepted().len();
    notice(&format!("{} so far", counted(count, "accepted plan")));
    if let Some(instruction) = session.instruction() {
        notice(&format!("Current instruction: {instruction}"));
    }
    if let Response::Plan(_) = session.response() {
        plan(session);
        waiting(interactive);
    } else {
        response(session, interactive);
    }
}
