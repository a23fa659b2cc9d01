//! A plan that waits for a decision: what it is for, what it changes, its steps, and the buttons.

use longstep::session::{Proposal, why};
use longstep_core::domain::phrase;
use longstep_core::model::Voice;
use longstep_core::plan::StepId;
use maud::{Markup, html};

use super::audit::short;
use super::form::{Attempt, problem_of};
use super::goal::{left_out, list, understood};
use super::picture::{self, Moment, moments};
use super::plan::PlanTree;
use super::shown::{Shown, approve_form};
use crate::view::ProposalView;

/// Writes the plan that waits for a decision.
pub(super) fn proposal(shown: &Shown<'_>, waiting: &Proposal) -> Markup {
    let Some(view) = &shown.view().proposal else {
        return html! {};
    };
    let instruction = shown.view().instruction.as_deref().unwrap_or_default();
    let answer = &view.answer;
    let moments = moments(&waiting.plan);
    let tree = PlanTree::new(
        (waiting.plan.world(), waiting.plan.plan()),
        answer,
        &moments,
        shown.look.step,
        shown.path(""),
    );
    html! {
        @if !view.refused.is_empty() {
            section.left-out role="alert" {
                h2 { "Not changed" }
                p { "The plan below is the one before your last words:" }
                ul { @for reason in &view.refused { li { (reason) } } }
            }
        }
        (left_out(answer))
        (understood(instruction, answer, &sentences_of(waiting)))
        (decision(shown, waiting, view))
        section aria-labelledby="plan" {
            h2 #plan { "The plan" }
            (tree.html())
            (list("Assumptions", answer.assumptions.iter().map(String::as_str)))
            (list("Notes", answer.notes.iter().map(String::as_str)))
        }
    }
}

/// Returns the goal of a plan as sentences.
pub(super) fn sentences_of(waiting: &Proposal) -> Vec<String> {
    let goal = waiting.goal.as_ref();
    goal.map(|goal| goal.sentences(waiting.plan.world()))
        .unwrap_or_default()
}

/// Writes what the plan changes, and the buttons that decide about it. All of them name the hash of this plan.
fn decision(shown: &Shown<'_>, waiting: &Proposal, view: &ProposalView) -> Markup {
    let hash = [("plan", view.plan.as_str())];
    let earlier = shown.view().accepted.iter().any(|own| own.pending);
    let moves = !waiting.plan.steps().is_empty();
    let (accept, no) = match (&waiting.question, view.offers_rule) {
        (Some(_), true) => ("Yes, from now on", "No"),
        (Some(_), false) => ("Yes, only accept", "No, cancel"),
        (None, _) => ("Only accept", "Cancel"),
    };
    html! {
        section.decision aria-labelledby="decision" {
            h2 #decision { @match &waiting.question { Some(question) => (question), None => "Your decision" } }
            @if moves { (effects(waiting)) }
            (problem_of(shown.attempt, "approve"))
            @if moves && !earlier && !view.offers_rule {
                div.buttons {
                    @for robot in shown.hub.robots() {
                        (approve_form(shown, robot, &view.plan, if waiting.question.is_some() { "Yes, accept and approve for" } else { "Accept and approve for" }))
                    }
                }
            }
            div.buttons {
                (shown.button("accept", accept, "plain", &hash))
                (shown.button("cancel", no, "plain", &[]))
            }
            @if moves && !view.offers_rule {
                p.quiet {
                    @if earlier { "An earlier plan waits for a robot. Accept this one; it is approved after that one was carried out. " }
                    @else { "Approving moves nothing yet: a button to start follows. " }
                    "Only accept: the next instruction begins in the world after this plan. Plan "
                    code title=(view.plan) { (short(&view.plan)) }
                }
            }
            details data-key="different" open[Attempt::at(shown.attempt, "feedback").is_some()] {
                summary { "Say what is to be different" }
                (shown.feedback())
            }
        }
    }
}

/// Describes what is different after the plan, for each way in which it can end.
fn effects(waiting: &Proposal) -> Markup {
    let world = waiting.plan.world();
    let mut endings: Vec<(Vec<String>, Vec<String>)> = Vec::new();
    for ending in waiting.plan.endings() {
        let changes = picture::changes_between(world, &world.state, &ending.after);
        let when = ending.when.iter().map(|fact| Voice::Person.fact(world, *fact, true));
        if endings.iter().all(|(_, own)| *own != changes) {
            endings.push((when.collect(), changes));
        }
    }
    html! {
        div.effects {
            @for (when, changes) in &endings {
                h3 {
                    @if endings.len() == 1 { "What will be different" }
                    @else if when.is_empty() { "In every other case" }
                    @else { "If " (when.join(" and ")) }
                }
                ul {
                    @if changes.is_empty() { li { "Nothing" } }
                    @for change in changes { li { (change) } }
                }
            }
        }
    }
}

/// Writes the scene before and after a step, with a slider through the steps.
pub(super) fn slider(shown: &Shown<'_>, waiting: &Proposal) -> Markup {
    let moments = moments(&waiting.plan);
    let last = moments.len().saturating_sub(1);
    let place = shown
        .look
        .step
        .and_then(|step| moments.iter().position(|own| own.frame.step == Some(step)));
    let place = place.unwrap_or(0);
    let Some(moment) = moments.get(place) else {
        return html! {};
    };
    let link = |place: Option<usize>| {
        let step = moments.get(place?)?.frame.step.map_or(0, |step| step + 1);
        Some(format!("{}?step={step}#scene", shown.path("")))
    };
    let step = moment.frame.step.map_or(0, |step| step + 1);
    html! {
        section.scene aria-labelledby="scene" {
            h2 #scene { "The scene, step by step" }
            form.slider method="get" action=(shown.path("")) {
                label for="slider" { "Step " (step) " of " (last) }
                a.turn rel="prev" href=[link(place.checked_sub(1))] { "Back" }
                input #slider type="range" name="step" min="0" max=(last) value=(step) data-keep
                    aria-valuetext={ "Step " (step) ": " (title(moment)) };
                a.turn rel="next" href=[link(Some(place + 1).filter(|next| *next <= last))] { "Next" }
                noscript { button type="submit" { "Show" } }
            }
            div #moment role="status" {
                p.what { strong { (title(moment)) } }
                @if !moment.frame.way.is_empty() { p.quiet { "If " (moment.frame.way.join(" and ")) } }
                @if let Some(outcome) = &moment.frame.outcome { p.quiet { "Shown for the case that " (outcome) } }
                @if !moment.changes.is_empty() { ul.changes { @for change in &moment.changes { li { (change) } } } }
                (reason(waiting, moment))
            }
            div.pictures {
                @if moment.frame.step.is_some() {
                    figure { figcaption { "Before" } (moment.before(waiting.plan.world())) }
                    figure { figcaption { "After" } (moment.after(waiting.plan.world())) }
                } @else {
                    figure { figcaption { "At the beginning" } (moment.after(waiting.plan.world())) }
                }
            }
        }
    }
}

fn title(moment: &Moment) -> &str {
    match moment.frame.step {
        Some(_) => phrase(&moment.frame.text),
        None => "The beginning",
    }
}

/// Explains a step: what would go wrong without it.
fn reason(waiting: &Proposal, moment: &Moment) -> Markup {
    let Some(step) = moment.frame.step else {
        return html! {};
    };
    let plan = &waiting.plan;
    let why = why(
        plan.world(),
        plan.plan(),
        &waiting.purpose,
        waiting.goal.as_ref(),
        StepId::new(step),
    );
    html! {
        @match &why.without_it[..] {
            [] => p.quiet { "The plan would be valid without this step." },
            [first, ..] => p.quiet { "Without it: " (first) },
        }
    }
}
