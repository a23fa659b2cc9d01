//! The error of the front door.

use std::fmt;

use crate::diagnostic::Diagnostics;
use crate::dialogue::PromptError;
use crate::goal::GoalError;
use crate::plan::Unreadable;
use crate::report::{Answer, Status};
use crate::session::{LogError, OutOfTurn, ResumeError};
use longstep_core::cursor::CursorError;

/// An error of [`Planner`](crate::Planner) and of what it makes. [`Error::kind`] tells the cases apart, `Display` is for
/// a person, and `source` leads to the causes.
///
/// ```
/// use longstep::{ErrorKind, Planner};
/// let planner = Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#)?;
/// let error = planner.solve(&world, "put(cup, tabel)").unwrap_err();
/// assert_eq!(error.kind(), ErrorKind::Goal);
/// assert!(error.to_string().ends_with("did you mean `table`?"));
/// # Ok::<(), longstep::Error>(())
/// ```
pub struct Error(Box<Cause>);

/// The part of an input, or the step of the work, that an [`Error`] is about.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
#[non_exhaustive]
pub enum ErrorKind {
    /// The files of a domain have errors or contradict each other, or there is no such domain.
    Domain,
    /// An environment has errors.
    Environment,
    /// A world was read with another domain than the planner's.
    OtherDomain,
    /// A goal cannot be read, or cannot be meant in this world.
    Goal,
    /// A text contains no plan.
    Plan,
    /// A plan has violations; [`Error::answer`] lists them.
    Invalid,
    /// No plan reaches the goal. This is proven.
    Unsolvable,
    /// A limit was reached before a plan was found.
    GaveUp,
    /// A prompt cannot be rendered, or does not fit into the model's context.
    Prompt,
    /// A call does not fit the state of the session.
    OutOfTurn,
    /// A session's log is damaged, or does not lead where it led before.
    Log,
    /// A completion does not fit the position of a cursor.
    Cursor,
}

#[derive(Debug, thiserror::Error)]
enum Cause {
    #[error("there is no shipped domain `{0}`")]
    UnknownDomain(String),
    #[error(transparent)]
    Domain(Diagnostics),
    #[error(transparent)]
    Environment(Diagnostics),
    #[error("the world was read with another domain than the planner's `{0}`")]
    OtherDomain(String),
    #[error(transparent)]
    Goal(GoalError),
    #[error(transparent)]
    Plan(Unreadable),
    #[error("{}", .0.sentence())]
    NoPlan(Box<Answer>),
    #[error(transparent)]
    Prompt(PromptError),
    #[error(transparent)]
    OutOfTurn(OutOfTurn),
    #[error(transparent)]
    Log(LogError),
    #[error(transparent)]
    Resume(ResumeError),
    #[error(transparent)]
    Cursor(CursorError),
}

impl Error {
    fn new(cause: Cause) -> Self {
        Self(Box::new(cause))
    }

    pub(crate) fn unknown_domain(name: &str) -> Self {
        Self::new(Cause::UnknownDomain(name.to_owned()))
    }

    pub(crate) fn domain(findings: Diagnostics) -> Self {
        Self::new(Cause::Domain(findings))
    }

    pub(crate) fn environment(findings: Diagnostics) -> Self {
        Self::new(Cause::Environment(findings))
    }

    pub(crate) fn other_domain(name: &str) -> Self {
        Self::new(Cause::OtherDomain(name.to_owned()))
    }

    pub(crate) fn no_plan(answer: Answer) -> Self {
        Self::new(Cause::NoPlan(Box::new(answer)))
    }

    /// The kind.
    pub fn kind(&self) -> ErrorKind {
        match &*self.0 {
            Cause::UnknownDomain(_) | Cause::Domain(_) => ErrorKind::Domain,
            Cause::Environment(_) => ErrorKind::Environment,
            Cause::OtherDomain(_) => ErrorKind::OtherDomain,
            Cause::Goal(_) => ErrorKind::Goal,
            Cause::Plan(_) => ErrorKind::Plan,
            Cause::NoPlan(answer) => match answer.status {
                Status::Unsolvable => ErrorKind::Unsolvable,
                Status::GaveUp => ErrorKind::GaveUp,
                _ => ErrorKind::Invalid,
            },
            Cause::Prompt(_) => ErrorKind::Prompt,
            Cause::OutOfTurn(_) => ErrorKind::OutOfTurn,
            Cause::Log(_) | Cause::Resume(_) => ErrorKind::Log,
            Cause::Cursor(_) => ErrorKind::Cursor,
        }
    }

    /// Every problem of a domain or an environment, with file, line and column.
    pub fn diagnostics(&self) -> Option<&Diagnostics> {
        match &*self.0 {
            Cause::Domain(findings) | Cause::Environment(findings) => Some(findings),
            _ => None,
        }
    }

    /// The answer to a plan that is invalid, or to a goal without a plan.
    pub fn answer(&self) -> Option<&Answer> {
        match &*self.0 {
            Cause::NoPlan(answer) => Some(answer),
            _ => None,
        }
    }
}

impl fmt::Debug for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl std::error::Error for Error {
    fn source(&self) -> Option<&(dyn std::error::Error + 'static)> {
        self.0.source()
    }
}

/// Conversions, so that `?` works on everything that the session and the cursor return.
macro_rules! from {
    ($($error:ty => $cause:ident),+ $(,)?) => {$(
        impl From<$error> for Error {
            fn from(error: $error) -> Self {
                Self::new(Cause::$cause(error))
            }
        }
    )+};
}

from! {
    GoalError => Goal,
    Unreadable => Plan,
    PromptError => Prompt,
    OutOfTurn => OutOfTurn,
    LogError => Log,
    ResumeError => Resume,
    CursorError => Cursor,
}
