//! The page of a session: an instruction, the way it was understood, its plan, and the decision about it.

use longstep_core::visible;
use maud::{Markup, html};

use super::audit::short;
use super::form::{Attempt, Button, problem_of, with_attempt};
use super::goal::{left_out, list, understood};
use super::listing::time;
use super::picture;
use super::plan::PlanTree;
use super::proposal::proposal;
use super::run::state_words;
use super::sheet::Sheet;
use super::shown::{Look, Shown, approve_form};
use crate::approval::Approval;
use crate::hub::Hub;
use crate::id::{RunId, SessionId};
use crate::problem::Problem;
use crate::run::RunView;
use crate::store::RecordKey;
use crate::view::AcceptedView;

/// Writes the page of a session.
///
/// # Errors
///
/// There is no such session, or another program has it open.
pub(crate) fn session(hub: &Hub, id: &SessionId, look: &Look, attempt: Option<&Attempt>) -> Result<Sheet, Problem> {
    let snapshot = hub.session(id)?;
    let shown = Shown {
        hub,
        snapshot: &snapshot,
        look,
        attempt,
    };
    let view = shown.view();
    let title = view.instruction.as_deref().unwrap_or("Session");
    let going = shown.going();
    let live = html! {
        (headline(&shown))
        @if let Some(run) = &going { (running(run)) }
        div.split {
            div.main { (stage(&shown)) (history(&shown)) }
            div.side { (side(&shown)) }
        }
    };
    Ok(Sheet {
        follows: Some(format!("?session={id}")),
        is_going: going.is_some(),
        is_waiting: view.state == "thinking",
        ..Sheet::new(
            visible::line(title),
            format!("/sessions/{id}"),
            with_attempt(attempt, &live),
        )
    })
}

fn headline(shown: &Shown<'_>) -> Markup {
    let view = shown.view();
    html! {
        div.lead {
            p.quiet { "Session " span title=(view.id) { (short(view.id.as_str())) } " · " (view.domain) " · " (view.model) }
            h1 { (view.instruction.as_deref().unwrap_or("What should the robot do?")) }
            p #state role="status" data-state=(view.state) { (sentence(shown)) }
        }
    }
}

/// Describes the state of a session in a sentence.
fn sentence(shown: &Shown<'_>) -> String {
    let view = shown.view();
    match view.state {
        "ready" => match next(shown) {
            None => "Ready for an instruction.".to_owned(),
            Some(next) if waiting_approval(shown, next).is_some() => {
                "The plan is approved. Nothing moves before you start it.".to_owned()
            }
            Some(_) => "A plan waits for a robot. Nothing moves before you approve and start it.".to_owned(),
        },
        "thinking" => "The model works on it. Nothing moves.".to_owned(),
        "question" => "There is a question.".to_owned(),
        "consent" => "There is a question about the plan. Nothing moves before you approve it.".to_owned(),
        "plan" => {
            let count = view.proposal.as_ref().map_or(0, |own| own.answer.steps.len());
            let steps = match count {
                0 => "The plan is empty".to_owned(),
                1 => "There is a verified plan of 1 step".to_owned(),
                many => format!("There is a verified plan of {many} steps"),
            };
            format!("{steps}. Nothing moves before you approve it.")
        }
        "no_plan" => "There is no plan for this.".to_owned(),
        "endings" => "The last plan can have ended in several ways.".to_owned(),
        _ => "This session is in a state that this page does not know.".to_owned(),
    }
}

fn running(run: &RunView) -> Markup {
    html! {
        p.running {
            strong { "A plan of this session: " (state_words(run.state)) " on " (run.record.robot) ". " }
            a href={ "/runs/" (run.record.id) } { "Look at the run" }
        }
    }
}

/// Writes what the session waits for.
fn stage(shown: &Shown<'_>) -> Markup {
    let view = shown.view();
    match view.state {
        "ready" => html! { (approve_next(shown)) (instruct(shown)) },
        "thinking" => html! {
            section.thinking {
                p #progress role="status" data-keep { "The request is on its way." }
                (shown.button("cancel", "Cancel", "plain", &[]))
            }
        },
        "question" => html! {
            section {
                h2 { (view.question.as_deref().unwrap_or_default()) }
                (shown.words("answer", "Your answer", "Answer"))
                (shown.button("cancel", "Cancel the instruction", "plain", &[]))
            }
        },
        "no_plan" => no_plan(shown),
        "endings" => html! { (approve_next(shown)) (endings(shown)) },
        _ => html! { @if let Some(waiting) = &shown.snapshot.proposal { (proposal(shown, waiting)) } },
    }
}

fn instruct(shown: &Shown<'_>) -> Markup {
    let scene = shown.look.scene.as_deref();
    let scene = scene.and_then(|name| shown.hub.domains().scenes().iter().find(|own| own.name == name));
    html! {
        section {
            (shown.words("instruct", "Say what the robot should do", "Make a plan"))
            @if let Some(scene) = scene.filter(|own| !own.example.is_empty()) {
                p.quiet { "For example: " q { (scene.example) } }
            }
        }
    }
}

fn no_plan(shown: &Shown<'_>) -> Markup {
    let view = shown.view();
    let answer = view.failure.as_ref().and_then(|failure| failure.answer.as_ref());
    html! {
        @if let Some(failure) = &view.failure {
            p.problem { (failure.message) }
        }
        @if let Some(answer) = answer {
            (left_out(answer))
            (understood(view.instruction.as_deref().unwrap_or_default(), answer, &[]))
        }
        section {
            @if let Some(answer) = answer { (list("Notes", answer.notes.iter().map(String::as_str))) }
            (shown.feedback())
            (shown.button("cancel", "Give this instruction up", "plain", &[]))
        }
        (instruct(shown))
    }
}

fn endings(shown: &Shown<'_>) -> Markup {
    html! {
        section aria-labelledby="endings" {
            h2 #endings { "How did it end?" }
            p { "The plan depends on what the robot finds. A run tells it; without one, say it here." }
            (problem_of(shown.attempt, "ended"))
            ul.choices {
                @for (number, ending) in shown.view().endings.iter().enumerate() {
                    li {
                        @let label = match &ending.when[..] { [] => "In every other way".to_owned(), when => when.join(" and ") };
                        (Button { to: shown.path("/ended"), label: &label, class: "plain", fields: &[("ending", &number.to_string())] }.html())
                    }
                }
            }
        }
    }
}

/// Returns the next accepted plan, if it waits for a robot.
fn next<'s>(shown: &'s Shown<'_>) -> Option<&'s AcceptedView> {
    let next = shown.view().accepted.iter().find(|own| own.pending);
    next.filter(|_| shown.snapshot.next.is_some() && shown.going().is_none())
}

/// Writes the next accepted plan with its approval, or its start.
fn approve_next(shown: &Shown<'_>) -> Markup {
    let (Some(next), Some(accepted)) = (next(shown), &shown.snapshot.next) else {
        return html! {};
    };
    html! {
        section.decision aria-labelledby="next" {
            h2 #next { "Accepted, and not carried out: " q { (next.instruction) } }
            (left_out_of(next))
            (PlanTree::accepted(&accepted.before, accepted.plan.plan()).html())
            @match waiting_approval(shown, next) {
                Some(approval) => (start_form(shown, &approval)),
                None => (approve_forms(shown, next)),
            }
        }
    }
}

fn left_out_of(accepted: &AcceptedView) -> Markup {
    html! {
        @if !accepted.not_in_plan.is_empty() {
            p { strong { "Not in the plan: " } @for (place, text) in accepted.not_in_plan.iter().enumerate() { @if place > 0 { ", " } q { (text) } } }
        }
    }
}

/// Returns the approval that the person has just given, if it may still be used for this plan.
fn waiting_approval(shown: &Shown<'_>, next: &AcceptedView) -> Option<Approval> {
    let approval = shown.hub.approvals.find(shown.look.approval.as_ref()?).ok()?;
    let used = shown.hub.store.record(&RecordKey::Use(approval.id.clone())).ok()?;
    let is_own = approval.session == shown.view().id && approval.plan == next.plan;
    let holds = used.is_none() && jiff::Timestamp::now() < approval.expires;
    (is_own && holds).then_some(approval)
}

fn start_form(shown: &Shown<'_>, approval: &Approval) -> Markup {
    html! {
        p { "Approved for " strong { (approval.robot) } " until " (time(Some(approval.expires))) ". Start moves the robot." }
        (problem_of(shown.attempt, "start"))
        form method="post" action=(shown.path("/start")) {
            input type="hidden" name="approval" value=(approval.id);
            button.primary.large type="submit" data-guard { "Start on " (approval.robot) }
        }
    }
}

fn approve_forms(shown: &Shown<'_>, next: &AcceptedView) -> Markup {
    html! {
        (problem_of(shown.attempt, "start"))
        (problem_of(shown.attempt, "approve"))
        div.buttons { @for robot in shown.hub.robots() { (approve_form(shown, robot, &next.plan, "Approve for")) } }
        @if shown.hub.robots().is_empty() { p.quiet { "This server has no robot." } }
        p.quiet { "Plan " code title=(next.plan) { (short(&next.plan)) } }
    }
}

/// Lists the accepted plans and the rules.
fn history(shown: &Shown<'_>) -> Markup {
    let view = shown.view();
    let can_undo = matches!(view.state, "ready" | "no_plan" | "endings") && shown.going().is_none();
    html! {
        @if !view.accepted.is_empty() {
            section aria-labelledby="accepted" {
                h2 #accepted { "Accepted plans" }
                ol.accepted { @for accepted in view.accepted.iter().rev() { li value=(accepted.number + 1) { (accepted_plan(shown, accepted)) } } }
                @if can_undo { (shown.button("undo", "Undo the last one", "plain", &[])) }
            }
        }
        @if !view.rules.is_empty() {
            section aria-labelledby="rules" {
                h2 #rules { "Standing rules" }
                p.quiet { "Every plan of this session keeps them." }
                ul { @for rule in &view.rules { li { code { (rule) } } } }
            }
        }
    }
}

fn accepted_plan(shown: &Shown<'_>, accepted: &AcceptedView) -> Markup {
    let run = latest_run(shown, accepted);
    html! {
        details data-key={ "accepted-" (accepted.number) } {
            summary {
                span.what { (accepted.instruction) }
                span.state { @if accepted.pending { "not carried out" } @else { "carried out" } }
            }
            (left_out_of(accepted))
            ol.short { @for step in &accepted.steps { li { (step) } } }
            p.quiet { "Plan " code title=(accepted.plan) { (short(&accepted.plan)) } }
        }
        @if let Some(run) = run { a href={ "/runs/" (run) } { "Its last run" } }
    }
}

/// Returns the last run of an accepted plan.
fn latest_run(shown: &Shown<'_>, accepted: &AcceptedView) -> Option<RunId> {
    let runs = super::listing::latest_runs(shown.hub).into_iter();
    let mut own = runs.filter(|(_, run)| {
        run.record.session == shown.view().id
            && run.record.number == accepted.number
            && run.record.plan == accepted.plan
    });
    own.next().map(|(_, run)| run.record.id.clone())
}

/// Writes the picture beside the stage: of the plan, or of the world as it is.
fn side(shown: &Shown<'_>) -> Markup {
    match &shown.snapshot.proposal {
        Some(waiting) if !waiting.plan.steps().is_empty() => super::proposal::slider(shown, waiting),
        _ => html! {
            section.scene aria-labelledby="scene" {
                h2 #scene { "The scene" }
                div.pictures.single { figure { figcaption { "Before the next instruction" } (picture::of_world(&shown.snapshot.world)) } }
            }
        },
    }
}
