//! Errors for the user: one line with the problem and its place, a hint, and the exit code.

use longstep::dialogue::{DialogueError, PromptError};
use longstep::goal::GoalError;
use longstep::session::ResumeError;
use longstep_core::diagnostic::{Diagnostic, Diagnostics};
use longstep_core::secret;
use longstep_files::{DomainError, NoHomeFolder, TextFileError};
use longstep_llm::{AdvanceError, ConverseError, FolderError, ModelError};
use serde::Serialize;

use crate::output::{self, Form, Style, remark};

pub(crate) use crate::exit_code::{LIMIT, MODEL, NOT_VALID, UNREADABLE};

/// An error of the program itself.
#[derive(Debug)]
pub(crate) struct Failure {
    message: String,
    /// The messages after the first, of a failure that has several.
    further: Vec<String>,
    hint: Option<String>,
    code: u8,
}

impl Failure {
    pub(crate) fn unreadable(message: impl Into<String>) -> Self {
        Self::new(message, UNREADABLE)
    }

    pub(crate) fn new(message: impl Into<String>, code: u8) -> Self {
        Self {
            message: message.into(),
            further: Vec::new(),
            hint: None,
            code,
        }
    }

    /// A failure for several reasons, each of which is a line.
    pub(crate) fn several(messages: Vec<String>) -> Self {
        Self::several_of(messages, UNREADABLE)
    }

    /// As [`Failure::several`], with an exit code.
    pub(crate) fn several_of(messages: Vec<String>, code: u8) -> Self {
        let mut messages = messages.into_iter();
        let first = Self::new(messages.next().unwrap_or_default(), code);
        Self {
            further: messages.collect(),
            ..first
        }
    }

    pub(crate) fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

impl std::fmt::Display for Failure {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Failure {}

/// The most findings that are printed as lines.
const LINES: usize = 20;

/// An error as it is printed. `schemas/error.schema.json` describes the object.
#[derive(Debug, Serialize)]
struct Report {
    code: u8,
    /// The error in one line; of several findings the first.
    message: String,
    hint: Option<String>,
    /// The findings of an error that has several, or that has a place in a file.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    findings: Vec<FindingReport>,
}

#[derive(Debug, Serialize)]
struct FindingReport {
    file: Option<String>,
    line: Option<u32>,
    column: Option<u32>,
    message: String,
    hint: Option<String>,
    /// The finding as a line of text.
    #[serde(skip)]
    line_of_text: String,
}

impl FindingReport {
    fn of_diagnostic(finding: &Diagnostic) -> Self {
        let mut finding = finding.clone();
        let hint = finding.hint.take();
        Self {
            line_of_text: finding.to_string(),
            file: Some(finding.file),
            line: finding.position.map(|position| position.line),
            column: finding.position.map(|position| position.column),
            message: finding.message,
            hint,
        }
    }

    fn of_text(text: &str) -> Self {
        let message = secret::redacted(text).into_owned();
        Self {
            file: None,
            line: None,
            column: None,
            line_of_text: message.clone(),
            message,
            hint: None,
        }
    }
}

impl Report {
    fn of(error: &anyhow::Error) -> Self {
        if let Some(findings) = findings(error) {
            let findings: Vec<_> = findings.0.iter().map(FindingReport::of_diagnostic).collect();
            let first = findings.first();
            return Self {
                code: UNREADABLE,
                message: first.map_or_else(String::new, |first| first.line_of_text.clone()),
                hint: first.and_then(|first| first.hint.clone()),
                findings,
            };
        }
        let (hint, code) = classify(error);
        // Errors quote what a person wrote, such as an address with a password.
        let message = secret::redacted(&format!("{error:#}")).into_owned();
        let further = error
            .downcast_ref::<Failure>()
            .map_or(&[][..], |failure| &failure.further);
        let findings = match further {
            [] => Vec::new(),
            further => {
                let all = std::iter::once(&message).chain(further);
                all.map(|text| FindingReport::of_text(text)).collect()
            }
        };
        Self {
            code,
            message,
            hint: hint.map(|hint| secret::redacted(&hint).into_owned()),
            findings,
        }
    }

    /// Prints a line for each finding, with its hint.
    fn print(&self) {
        let error = |text: &str| remark!("{} {text}", "error:".red().bold());
        let hint = |text: &Option<String>| {
            if let Some(text) = text {
                remark!("{} {text}", "hint:".cyan().bold());
            }
        };
        for finding in self.findings.iter().take(LINES) {
            error(&finding.line_of_text);
            hint(&finding.hint);
        }
        match self.findings.len() {
            0 => error(&self.message),
            count if count > LINES => remark!("and {} more", count - LINES),
            _ => {}
        }
        // The hints of findings in files are printed with them.
        if self.findings.iter().all(|finding| finding.hint.is_none()) {
            hint(&self.hint);
        }
    }
}

/// Prints an error to stderr and returns the exit code for it. With `--json` it is an object on stdout as well.
pub(crate) fn tell(error: &anyhow::Error) -> u8 {
    let report = Report::of(error);
    report.print();
    match output::form() {
        Form::Text => {}
        form => output::in_form(form, &serde_json::json!({ "error": report })),
    }
    report.code
}

/// Findings about files that the person wrote; each is printed with its own hint.
fn findings(error: &anyhow::Error) -> Option<&Diagnostics> {
    if let Some(AdvanceError::Prompt(PromptError::Broken(findings))) = error.downcast_ref() {
        return Some(findings);
    }
    if let Some(DomainError::Findings(findings)) = error.downcast_ref() {
        return Some(findings);
    }
    error.downcast_ref()
}

fn classify(error: &anyhow::Error) -> (Option<String>, u8) {
    if let Some(failure) = error.downcast_ref::<Failure>() {
        return (failure.hint.clone(), failure.code);
    }
    if let Some(error) = error.downcast_ref::<DomainError>() {
        return (error.hint(), UNREADABLE);
    }
    if let Some(error) = error.downcast_ref::<NoHomeFolder>() {
        return (Some(error.hint().to_owned()), MODEL);
    }
    if let Some(error) = error.downcast_ref::<TextFileError>() {
        return (error.hint().map(str::to_owned), UNREADABLE);
    }
    let (advance, converse) = (
        error.downcast_ref::<AdvanceError>(),
        error.downcast_ref::<ConverseError>(),
    );
    if let Some(ConverseError::Answer(error)) = converse {
        let code = match error {
            DialogueError::CutOff(_) | DialogueError::TooMuchWork => LIMIT,
            _ => MODEL,
        };
        let hint = "rephrase the instruction, or use another model with `--model`";
        return (Some(hint.to_owned()), code);
    }
    let model = error.downcast_ref::<ModelError>().or(match (advance, converse) {
        (Some(AdvanceError::Model(error)), _) | (_, Some(ConverseError::Model(error))) => Some(error),
        _ => None,
    });
    if let Some(error) = model {
        let code = match error {
            ModelError::TooLong { .. } | ModelError::TimedOut { .. } | ModelError::TooLarge { .. } => LIMIT,
            ModelError::UnknownReference { .. }
            | ModelError::NoVisionEngine { .. }
            | ModelError::NoProjector { .. }
            | ModelError::BadProjector { .. }
            | ModelError::BadPicture { .. } => UNREADABLE,
            ModelError::File { source, .. } if source.kind() == std::io::ErrorKind::FileTooLarge => UNREADABLE,
            _ => MODEL,
        };
        return (error.hint(), code);
    }
    let folder = error.downcast_ref::<FolderError>().or(match advance {
        Some(AdvanceError::Folder(error)) => Some(error),
        _ => None,
    });
    if let Some(error) = folder {
        return (error.hint(), UNREADABLE);
    }
    if let Some(error) = error.downcast_ref::<longstep_eval::folder::FolderError>() {
        return (error.hint().map(str::to_owned), UNREADABLE);
    }
    if let Some(AdvanceError::Prompt(PromptError::OverBudget(_))) = advance {
        let hint = "use a smaller environment, `--strategy goal`, `--context N`, a server with a larger context, or shorter \
                    prompt parts with `--prompt FOLDER`";
        return (Some(hint.to_owned()), LIMIT);
    }
    if let Some(AdvanceError::Prompt(PromptError::TooMuchWork)) = advance {
        let hint = "declare fewer goals with fewer parameters, or use `--strategy direct`";
        return (Some(hint.to_owned()), LIMIT);
    }
    if let Some(ResumeError::Plan { .. } | ResumeError::Environment(_)) = error.downcast_ref::<ResumeError>() {
        let hint = "the domain has changed: restore its old version, or begin a new session; this session is unchanged, \
                    and `longstep session show` still lists it";
        return (Some(hint.to_owned()), UNREADABLE);
    }
    if let Some(error) = error.downcast_ref::<GoalError>() {
        return (goal_hint(error).map(str::to_owned), UNREADABLE);
    }
    (None, UNREADABLE)
}

/// The next step after an error in a goal; none where the error says it.
fn goal_hint(error: &GoalError) -> Option<&'static str> {
    match error {
        GoalError::Empty => Some("write a goal on each side of every `&` and every `then`"),
        GoalError::UnknownName { .. } | GoalError::UnknownKind { .. } => {
            Some("`longstep domain show DOMAIN --env ENV` lists the names of an environment")
        }
        GoalError::UnknownWord { .. } | GoalError::WrongType { .. } => {
            Some("`longstep domain show DOMAIN` lists the goals")
        }
        GoalError::UnknownState { .. } => Some("`longstep domain show DOMAIN` lists the states"),
        GoalError::NeverHolds { .. } => Some("leave the rule out, or check the names in it"),
        GoalError::NoMember { .. } => Some("change the conditions after `where` or the names after `except`"),
        _ => None,
    }
}
