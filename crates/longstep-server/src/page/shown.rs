//! What the parts of the page of a session need, and the forms that they share.

use std::sync::Arc;

use maud::{Markup, html};

use super::form::{Attempt, Button, problem_of};
use crate::hub::Hub;
use crate::id::ApprovalId;
use crate::run::{Body, RobotEntry, RunView};
use crate::view::{SessionView, Snapshot};

/// What a person looks at in a session.
#[derive(Debug, Clone, Default)]
pub(crate) struct Look {
    /// The step whose picture is shown, from 0; none for the beginning.
    pub(crate) step: Option<usize>,
    /// The approval that waits for its start.
    pub(crate) approval: Option<ApprovalId>,
    /// The scene in which the session began, for its example.
    pub(crate) scene: Option<String>,
}

impl Look {
    /// Reads a query: `step` from 1, as the page numbers the steps.
    pub(crate) fn read(query: &str) -> Self {
        let mut look = Self::default();
        for (name, value) in form_urlencoded::parse(query.as_bytes()) {
            match &*name {
                "step" => look.step = value.parse::<usize>().ok().and_then(|step| step.checked_sub(1)),
                "approval" => look.approval = ApprovalId::parse(&value),
                "scene" => look.scene = Some(value.into_owned()),
                _ => {}
            }
        }
        look
    }
}

/// What the parts of the page of a session need.
pub(super) struct Shown<'a> {
    pub(super) hub: &'a Hub,
    pub(super) snapshot: &'a Snapshot,
    pub(super) look: &'a Look,
    pub(super) attempt: Option<&'a Attempt>,
}

impl Shown<'_> {
    pub(super) fn view(&self) -> &SessionView {
        &self.snapshot.view
    }

    /// Returns the path of the session, or of a form of it.
    pub(super) fn path(&self, form: &str) -> String {
        format!("/sessions/{}{form}", self.view().id)
    }

    /// Returns the run of this session that goes on.
    pub(super) fn going(&self) -> Option<Arc<RunView>> {
        let own = |run: &Arc<RunView>| run.record.session == self.view().id && !run.state.is_ended();
        self.hub.runs().into_iter().find(own)
    }

    /// Writes a form with a field for text; the text of a failed attempt is kept.
    pub(super) fn words(&self, form: &'static str, label: &str, button: &str) -> Markup {
        let attempt = Attempt::at(self.attempt, form);
        let text = attempt.map_or("", |own| own.text.as_str());
        html! {
            form.words method="post" action=(self.path(&format!("/{form}"))) {
                label for=(form) { (label) }
                textarea id=(form) name="text" rows="2" maxlength="4000" required
                    aria-describedby=[attempt.map(|_| format!("{form}-problem"))] { (text) }
                div id={ (form) "-problem" } { (problem_of(self.attempt, form)) }
                button.primary[form != "feedback"] type="submit" { (button) }
            }
        }
    }

    /// Writes the form for feedback on a plan.
    pub(super) fn feedback(&self) -> Markup {
        self.words("feedback", "Say what is to be different", "Change the plan")
    }

    /// Writes a button of this session that needs no text.
    pub(super) fn button(&self, form: &'static str, label: &str, class: &str, fields: &[(&str, &str)]) -> Markup {
        let button = Button {
            to: self.path(&format!("/{form}")),
            label,
            class,
            fields,
        };
        html! { (problem_of(self.attempt, form)) (button.html()) }
    }
}

/// Writes the form that approves a plan for a robot. It names the hash of the plan that the page shows.
pub(super) fn approve_form(shown: &Shown<'_>, robot: &RobotEntry, plan: &str, verb: &str) -> Markup {
    html! {
        form.approve method="post" action=(shown.path("/approve")) {
            input type="hidden" name="plan" value=(plan);
            input type="hidden" name="robot" value=(robot.name);
            button.primary type="submit" { (verb) " " (robot.name) }
            @if robot.body == Body::PerSession { span.quiet { "a simulation: nothing real moves" } }
            @else { span.quiet { (robot.reference) ": a shared robot" } }
        }
    }
}
