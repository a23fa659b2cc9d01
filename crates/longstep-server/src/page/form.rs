//! Forms: what is sent, and what is shown when it fails.

use std::cell::Cell;

use maud::{Markup, html};

use crate::problem::Problem;

/// The fields of a form that was sent.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Fields(Vec<(String, String)>);

impl Fields {
    /// Reads a body of the type `application/x-www-form-urlencoded`.
    pub(crate) fn read(body: &[u8]) -> Self {
        Self(form_urlencoded::parse(body).into_owned().collect())
    }

    /// Returns the value of a field; none if it is missing or empty.
    pub(crate) fn get(&self, name: &str) -> Option<&str> {
        let found = self.0.iter().find(|(own, _)| own == name);
        found.map(|(_, value)| value.as_str()).filter(|value| !value.is_empty())
    }

    /// Returns the value of a field.
    ///
    /// # Errors
    ///
    /// It is missing or empty.
    pub(crate) fn require(&self, name: &str) -> Result<&str, Problem> {
        self.get(name).ok_or_else(|| {
            Problem::unreadable(format!("the form has no `{name}`")).hint("load the page again, and send its form")
        })
    }
}

/// A form that was sent and failed: it is shown again with the text and the reason.
#[derive(Debug, Clone)]
pub(crate) struct Attempt {
    /// The name of the form.
    pub(crate) form: &'static str,
    /// The text that the person wrote.
    pub(crate) text: String,
    /// The reason.
    pub(crate) problem: Problem,
    /// True once a form has shown it.
    is_shown: Cell<bool>,
}

impl Attempt {
    /// Creates the attempt with the fields that were sent.
    pub(crate) fn new(form: &'static str, fields: &Fields, problem: Problem) -> Self {
        Self {
            form,
            text: fields.get("text").unwrap_or_default().to_owned(),
            problem,
            is_shown: Cell::new(false),
        }
    }

    /// Returns the attempt if it is one with this form.
    pub(super) fn at<'a>(attempt: Option<&'a Self>, form: &str) -> Option<&'a Self> {
        attempt.filter(|own| own.form == form)
    }
}

/// Shows a problem with its hint.
pub(super) fn problem(problem: &Problem) -> Markup {
    html! {
        div.problem.attempt role="alert" {
            p { strong { "Not done: " } (problem.message) }
            @if let Some(hint) = &problem.hint { p.hint { "Hint: " (hint) } }
        }
    }
}

/// Shows the problem of the last attempt with a form.
pub(super) fn problem_of(attempt: Option<&Attempt>, form: &str) -> Markup {
    html! {
        @if let Some(attempt) = Attempt::at(attempt, form).filter(|own| !own.is_shown.replace(true)) {
            (problem(&attempt.problem))
        }
    }
}

/// Shows an attempt whose form is no longer on the page, with its text; `page` is written before.
pub(super) fn with_attempt(attempt: Option<&Attempt>, page: &Markup) -> Markup {
    html! {
        @if let Some(attempt) = attempt.filter(|own| !own.is_shown.get()) {
            div.attempt data-key="attempt" {
                (problem(&attempt.problem))
                @if !attempt.text.is_empty() { p { "You wrote: " q { (attempt.text) } } }
            }
        }
        (page)
    }
}

/// A form that is one button.
pub(super) struct Button<'a> {
    /// The path to which it is sent.
    pub(super) to: String,
    /// The words on the button.
    pub(super) label: &'a str,
    /// The class of the button.
    pub(super) class: &'a str,
    /// The hidden fields.
    pub(super) fields: &'a [(&'a str, &'a str)],
}

impl Button<'_> {
    /// Writes the form.
    pub(super) fn html(&self) -> Markup {
        html! {
            form method="post" action=(self.to) {
                @for (name, value) in self.fields { input type="hidden" name=(name) value=(value); }
                button.(self.class) type="submit" { (self.label) }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_decoded_and_empty_ones_are_missing() {
        let fields = Fields::read(b"text=Put+the+caf%C3%A9%20%26%20more&empty=&text=second&%ff=x");
        assert_eq!(fields.get("text"), Some("Put the café & more"));
        assert_eq!((fields.get("empty"), fields.get("other")), (None, None));
        assert!(fields.require("plan").unwrap_err().message.contains("`plan`"));
    }
}
