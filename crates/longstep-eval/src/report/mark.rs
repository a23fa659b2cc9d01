//! What an attempt is shown as in a grid.

use crate::attempt::Attempt;

/// One of the ways in which an attempt can end. Each has a sign of its own, since colours do not reach everybody.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Correct,
    AskedRightly,
    Executable,
    AskedNeedlessly,
    NotExecutable,
}

impl Mark {
    pub(super) const ALL: [Self; 5] = [
        Self::Correct,
        Self::AskedRightly,
        Self::Executable,
        Self::AskedNeedlessly,
        Self::NotExecutable,
    ];

    pub(super) fn of(attempt: &Attempt) -> Self {
        match (attempt.correct, attempt.asked()) {
            (true, true) => Self::AskedRightly,
            (true, false) => Self::Correct,
            (false, true) => Self::AskedNeedlessly,
            (false, false) if attempt.executable => Self::Executable,
            (false, false) => Self::NotExecutable,
        }
    }

    /// For a person.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::AskedRightly => "asked rightly",
            Self::Executable => "executable only",
            Self::AskedNeedlessly => "asked needlessly",
            Self::NotExecutable => "not executable",
        }
    }

    /// Its sign on a page.
    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Correct => "✓",
            Self::AskedRightly => "?",
            Self::Executable => "~",
            Self::AskedNeedlessly => "?!",
            Self::NotExecutable => "✗",
        }
    }

    /// Its sign where only ASCII is sure to be shown.
    pub(super) fn letter(self) -> char {
        match self {
            Self::Correct => '+',
            Self::AskedRightly => '?',
            Self::Executable => '~',
            Self::AskedNeedlessly => '!',
            Self::NotExecutable => 'x',
        }
    }

    /// The class of its style.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::AskedRightly => "asked",
            Self::Executable => "executable",
            Self::AskedNeedlessly => "needless",
            Self::NotExecutable => "failed",
        }
    }
}
