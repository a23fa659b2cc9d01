//! The page of a run: what the robot does, what it asks, and how it ended.

use longstep_core::domain::phrase;
use longstep_core::environment;
use longstep_core::execution::{BoardLine, BoardStep, Mark};
use longstep_core::json;
use longstep_core::visible;
use maud::{Markup, html};

use super::audit::short;
use super::form::{Attempt, Button, problem_of, with_attempt};
use super::picture;
use super::sheet::{Sheet, Stops};
use crate::hub::Hub;
use crate::id::RunId;
use crate::problem::Problem;
use crate::run::{EndView, QuestionView, RunState, RunView};

/// The most notices that the page shows.
const NOTICES: usize = 40;

/// The words on the button that resumes a run.
const RESUME: &str = "Take it up again from the world as it is";

/// Writes the page of a run. `stop_was_sent` confirms a stop that was sent without the script.
///
/// # Errors
///
/// There is no such run.
pub(crate) fn run(hub: &Hub, id: &RunId, stop_was_sent: bool, attempt: Option<&Attempt>) -> Result<Sheet, Problem> {
    let run = hub.run(id)?;
    let is_going = !run.state.is_ended();
    let live = html! {
        div.lead {
            p.quiet {
                a href={ "/sessions/" (run.record.session) } { "Session " (short(run.record.session.as_str())) }
                " · on " strong { (run.record.robot) } " · begun by " (run.record.by)
                " · plan " code title=(run.record.plan) { (short(&run.record.plan)) }
                @if run.dry_run { " · dry run: nothing moves" }
                @if !matches!(run.state, RunState::Queued | RunState::Opening) {
                    " · " a href={ "/api/runs/" (run.record.id) "/mcap" } download { "Recording (MCAP)" }
                }
            }
            h1 { (run.record.instruction) }
            p #state role="status" data-state=(run.state.name()) { (sentence(&run)) }
            @if stop_was_sent && is_going { p.problem role="alert" { "Stop sent." } }
        }
        @if let Some(question) = &run.question { (ask(&run, question, attempt)) }
        @if let Some(end) = &run.end { (ended(&run, end, attempt)) }
        (controls(&run, attempt))
        div.split {
            div.main {
                section aria-labelledby="steps" { h2 #steps { "Steps" } (board(&run)) }
                (notices(&run))
            }
            div.side { (scene(hub, &run)) }
        }
    };
    Ok(Sheet {
        follows: Some(format!("?run={id}")),
        stops: Some(Stops {
            run: id.clone(),
            robot: run.record.robot.clone(),
        }),
        is_going,
        is_waiting: is_going && run.question.is_none(),
        ..Sheet::new(
            format!("{}: {}", state_words(run.state), visible::line(&run.record.instruction)),
            format!("/runs/{id}"),
            with_attempt(attempt, &live),
        )
    })
}

/// Names a state of a run.
pub(super) fn state_words(state: RunState) -> &'static str {
    match state {
        RunState::Queued => "waits for the robot",
        RunState::Opening => "the robot is being opened",
        RunState::Running => "going on",
        RunState::Asking => "asks a question",
        RunState::Paused => "paused",
        RunState::Done => "done",
        RunState::Stopped => "stopped",
        RunState::Interrupted => "interrupted",
    }
}

/// Describes the state of a run in a sentence, which is read aloud when it changes.
fn sentence(run: &RunView) -> String {
    let is_closed = |step: &&BoardStep| matches!(step.mark, Mark::Done | Mark::Skipped);
    let done = run.steps.iter().filter(is_closed).count();
    let progress = format!("{done} of {} steps are done", run.steps.len());
    match run.state {
        RunState::Queued => "It waits until the robot is free.".to_owned(),
        RunState::Opening => "The robot is being opened.".to_owned(),
        RunState::Running => {
            let under_way = run
                .steps
                .iter()
                .filter(|step| matches!(step.mark, Mark::UnderWay { .. }));
            let texts: Vec<&str> = under_way.map(|step| phrase(&step.text)).collect();
            match &texts[..] {
                [] => format!("{progress}. The robot looks around."),
                texts => format!("{progress}. Now: {}.", texts.join("; ")),
            }
        }
        RunState::Asking => {
            let asked = run.question.as_ref().map_or("", |question| question.text.as_str());
            format!("{progress}. The robot waits for your answer: {asked}")
        }
        RunState::Paused => format!("{progress}. Paused: no step begins before you continue."),
        RunState::Done => "Done.".to_owned(),
        RunState::Stopped => "Stopped.".to_owned(),
        RunState::Interrupted => "Interrupted: the server ended while the run went on.".to_owned(),
    }
}

/// Writes the question of a run. The buttons name the id of this question, so that no other one is answered.
fn ask(run: &RunView, question: &QuestionView, attempt: Option<&Attempt>) -> Markup {
    let (yes, no) = match question.kind {
        "judge" => ("Yes, it was done", "No, it was not"),
        "confirm" => ("Yes, it is so", "No, it is not"),
        "step" => ("Approve this step", "Refuse"),
        _ => ("Approve and go on", "Refuse"),
    };
    let to = format!("/runs/{}/decide", run.record.id);
    let answer = |label, class, value| {
        let fields = [("question", question.id.as_str()), ("answer", value)];
        Button {
            to: to.clone(),
            label,
            class,
            fields: &fields,
        }
        .html()
    };
    html! {
        section.decision.asks aria-labelledby="question" {
            h2 #question { (question.text) }
            (list("What changes", &question.edits))
            (list("The steps from here", &question.steps))
            (problem_of(attempt, "decide"))
            div.buttons {
                (answer(yes, "primary", "yes"))
                (answer(no, "plain", "no"))
            }
            @if matches!(question.kind, "plan" | "change" | "step") { p.quiet { "After a refusal the run stops." } }
        }
    }
}

fn list(title: &str, entries: &[String]) -> Markup {
    html! { @if !entries.is_empty() { div.list { h3 { (title) } ol { @for entry in entries { li { (entry) } } } } } }
}

fn ended(run: &RunView, end: &EndView, attempt: Option<&Attempt>) -> Markup {
    html! {
        section.end.(run.state.name()) aria-labelledby="end" {
            h2 #end { @if end.done { "Done" } @else { "Stopped" } }
            p.sentence { (end.text) }
            p { a href={ "/sessions/" (run.record.session) } { "Back to the session" } }
            @if end.resumable { (button(run, "resume", RESUME, attempt)) }
        }
    }
}

fn controls(run: &RunView, attempt: Option<&Attempt>) -> Markup {
    let control = match run.state {
        RunState::Running | RunState::Asking => ("pause", "Pause after this step"),
        RunState::Paused => ("continue", "Continue"),
        RunState::Interrupted => ("resume", RESUME),
        _ => return html! {},
    };
    html! { div.buttons { (button(run, control.0, control.1, attempt)) } }
}

/// Writes a button of a run that needs no fields.
fn button(run: &RunView, form: &'static str, label: &str, attempt: Option<&Attempt>) -> Markup {
    let to = format!("/runs/{}/{form}", run.record.id);
    let button = Button {
        to,
        label,
        class: "plain",
        fields: &[],
    };
    html! { (problem_of(attempt, form)) (button.html()) }
}

/// Writes the steps with their states, as they are on the board of the run.
fn board(run: &RunView) -> Markup {
    let step = |entry: usize| run.steps.get(entry);
    let mut lines = run.lines.iter().peekable();
    html! {
        @if run.lines.is_empty() { p.quiet { "No step has begun." } }
        @while let Some(line) = lines.next() {
            @match line {
                BoardLine::Step { depth, entry } => @if let Some(step) = step(*entry) { div class={ "indent-" (depth.min(&6)) } { (board_step(step)) } },
                BoardLine::Text { depth, text } => p class={ "case indent-" (depth.min(&6)) } { (text) },
                BoardLine::Heads(names) => {
                    @let rows = std::iter::from_fn(|| lines.next_if(|line| matches!(line, BoardLine::Beside(_)))).collect::<Vec<_>>();
                    div.wide tabindex="0" role="region" aria-label="Steps at the same time" {
                        table.lanes {
                            caption { "At the same time" }
                            thead { tr { @for name in names { th scope="col" { (name) } } } }
                            tbody { @for row in rows { (beside(run, row)) } }
                        }
                    }
                }
                _ => {}
            }
        }
    }
}

fn beside(run: &RunView, line: &BoardLine) -> Markup {
    let entries = match line {
        BoardLine::Beside(entries) => &entries[..],
        _ => &[],
    };
    html! {
        tr { @for entry in entries { td { @if let Some(step) = entry.and_then(|entry| run.steps.get(entry)) { (board_step(step)) } } } }
    }
}

fn board_step(step: &BoardStep) -> Markup {
    let (class, word) = match step.mark {
        Mark::Waiting => ("waiting", "waits".to_owned()),
        Mark::New => ("new", "new".to_owned()),
        Mark::UnderWay { tries: 0 | 1 } => ("under-way", "under way".to_owned()),
        Mark::UnderWay { tries } => ("under-way", format!("under way, try {tries}")),
        Mark::Done => ("done", "done".to_owned()),
        Mark::Failed => ("failed", "failed".to_owned()),
        Mark::Undone => ("undone", "to be done again".to_owned()),
        Mark::Skipped => ("skipped", "skipped".to_owned()),
        _ => ("waiting", "unknown".to_owned()),
    };
    html! {
        div.step.(class) {
            span.mark { (word) }
            div.body { p.what { (phrase(&step.text)) } }
        }
    }
}

fn notices(run: &RunView) -> Markup {
    html! {
        @if let Some(feedback) = &run.feedback { p.feedback { strong { "The robot says: " } (feedback) } }
        @if !run.notices.is_empty() {
            section aria-labelledby="notices" {
                h2 #notices { "Noticed" }
                ul.notices tabindex="0" aria-labelledby="notices" { @for notice in run.notices.iter().rev().take(NOTICES) { li { (notice) } } }
            }
        }
    }
}

/// Writes the scene as the run knows it; while it goes on, with the changes since its beginning.
fn scene(hub: &Hub, run: &RunView) -> Markup {
    let session = hub.session(&run.record.session).ok();
    let known = run
        .environment
        .as_ref()
        .zip(session.as_ref())
        .and_then(|(known, session)| {
            let domain = session.robot_world.domain();
            let world = environment::read(domain, known, "the run", "", &json::Path::default()).ok()?;
            Some((world, session))
        });
    html! {
        @if let Some((world, session)) = known {
            section.scene aria-labelledby="scene" {
                h2 #scene { "The scene as it is known now" }
                div.pictures.single {
                    figure {
                        @if run.state.is_ended() { (picture::of_world(&world)) }
                        @else { (picture::since(&world, &session.robot_world)) }
                    }
                }
            }
        }
    }
}
