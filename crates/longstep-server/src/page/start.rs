//! The first page: scenes, runs and sessions.

use maud::{Markup, html};

use super::form::{Attempt, problem_of};
use super::listing::{SessionLine, TimedRun, latest_runs, latest_sessions, time};
use super::run::state_words;
use super::sheet::Sheet;
use crate::domains::Scene;
use crate::hub::Hub;
use crate::problem::Problem;
use crate::run::Body;

/// The most sessions that the page lists.
const SESSIONS: usize = 20;

/// The most runs that have ended and that the page lists.
const ENDED_RUNS: usize = 8;

/// Writes the first page.
///
/// # Errors
///
/// The sessions cannot be listed.
pub(crate) fn start(hub: &Hub, attempt: Option<&Attempt>) -> Result<Sheet, Problem> {
    let (sessions, count) = latest_sessions(hub, SESSIONS)?;
    let (ended, going): (Vec<_>, Vec<_>) = latest_runs(hub).into_iter().partition(|(_, run)| run.state.is_ended());
    let live = html! {
        div.lead {
            h1 { "Tell the robot what to do" }
            p {
                "Longstep turns an instruction into a plan that it has verified step by step. Nothing moves before you have "
                "seen exactly that plan and approved it."
            }
            (equipment(hub))
        }
        (problem_of(attempt, "begin"))
        (runs("going", "Runs going on", &going, usize::MAX))
        section aria-labelledby="scenes" {
            h2 #scenes { "Begin a session" }
            @if hub.domains().scenes().is_empty() {
                p.quiet { "This server has no scenes. A program begins a session with an environment of its own." }
            }
            ul.cards { @for scene in hub.domains().scenes() { li { (card(scene)) } } }
        }
        (runs("ended", "Last runs", &ended, ENDED_RUNS))
        section aria-labelledby="sessions" {
            h2 #sessions { "Sessions" }
            @if sessions.is_empty() { p.quiet { "There are none yet." } }
            ul.rows { @for session in &sessions { li { (row(session)) } } }
            @if count > sessions.len() { p.quiet { (count - sessions.len()) " older ones are not shown." } }
        }
    };
    Ok(Sheet {
        follows: Some(String::new()),
        is_going: !going.is_empty(),
        ..Sheet::new("Start", "/", live)
    })
}

/// Names the model and the robots.
fn equipment(hub: &Hub) -> Markup {
    html! {
        dl.facts {
            div {
                dt { "Model" }
                dd { @if let Some(models) = hub.models() { (models.facts().name) } @else { "none: only existing plans are shown" } }
            }
            div {
                dt { "Robots" }
                dd {
                    @if hub.robots().is_empty() { "none" }
                    @for (number, robot) in hub.robots().iter().enumerate() {
                        @if number > 0 { ", " }
                        (robot.name)
                        @if robot.body == Body::PerSession { " (simulation)" }
                    }
                }
            }
        }
    }
}

fn card(scene: &Scene) -> Markup {
    html! {
        form.card method="post" action="/sessions" {
            h3 { (scene.name) }
            p.quiet { "Domain " (scene.domain) }
            @if !scene.example.is_empty() { p { "Try: " q { (scene.example) } } }
            input type="hidden" name="scene" value=(scene.name);
            button type="submit" { "Begin in " (scene.name) }
        }
    }
}

fn row(session: &SessionLine) -> Markup {
    let more = session.instructions.saturating_sub(1);
    html! {
        a href={ "/sessions/" (session.id) } {
            span.what { @match &session.instruction { Some(text) => (text), None => "No instruction yet" } }
            span.quiet {
                @if more > 0 { "and " (more) " before it · " }
                (time(session.changed))
            }
        }
    }
}

/// Lists runs under a heading, unless there are none.
fn runs(id: &str, title: &str, runs: &[TimedRun], limit: usize) -> Markup {
    html! {
        @if !runs.is_empty() {
            section aria-labelledby=(id) {
                h2 id=(id) { (title) }
                ul.rows {
                    @for (changed, run) in runs.iter().take(limit) {
                        li {
                            a href={ "/runs/" (run.record.id) } {
                                span.what { (run.record.instruction) }
                                span.state.(run.state.name()) { (state_words(run.state)) }
                                span.quiet { "on " (run.record.robot) " · " (time(*changed)) }
                            }
                        }
                    }
                }
            }
        }
    }
}
