//! Errors for the user: one line with the problem and its place, a hint, and the exit code.

use longstep::dialogue::{DialogueError, PromptError};
use longstep::goal::GoalError;
use longstep::session::ResumeError;
use longstep_core::diagnostic::Diagnostics;
use longstep_core::secret;
use longstep_llm::{AdvanceError, ConverseError, DomainError, FolderError, ModelError, TextFileError};

use crate::output::{Style, remark};

pub(crate) use crate::exit_code::{LIMIT, MODEL, NOT_VALID, UNREADABLE};

/// An error of the program itself.
#[derive(Debug)]
pub(crate) struct Failure {
    message: String,
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
            hint: None,
            code,
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

/// Prints an error to stderr and returns the exit code for it.
pub(crate) fn tell(error: &anyhow::Error) -> u8 {
    if let Some(findings) = findings(error) {
        for finding in &findings.0 {
            let mut finding = finding.clone();
            let hint = finding.hint.take();
            remark!("{} {finding}", "error:".red().bold());
            if let Some(hint) = hint {
                remark!("{} {hint}", "hint:".cyan().bold());
            }
        }
        return UNREADABLE;
    }
    let (hint, code) = classify(error);
    // Errors quote what a person wrote, such as an address with a password.
    let text = format!("{error:#}");
    remark!("{} {}", "error:".red().bold(), secret::redacted(&text));
    if let Some(hint) = hint {
        remark!("{} {}", "hint:".cyan().bold(), secret::redacted(&hint));
    }
    code
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
