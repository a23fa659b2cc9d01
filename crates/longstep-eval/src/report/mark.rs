//! The mark of an attempt in a grid.

use crate::attempt::Attempt;

/// The kinds of results in a grid. Each has its own sign, for readers who do not see colours.
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
        match (attempt.correct, attempt.is_question()) {
            (true, true) => Self::AskedRightly,
            (true, false) => Self::Correct,
            (false, true) => Self::AskedNeedlessly,
            (false, false) if attempt.executable => Self::Executable,
            (false, false) => Self::NotExecutable,
        }
    }

    /// The name in a legend.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::AskedRightly => "asked rightly",
            Self::Executable => "executable only",
            Self::AskedNeedlessly => "asked needlessly",
            Self::NotExecutable => "not executable",
        }
    }

    /// The sign on a page.
    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Correct => "✓",
            Self::AskedRightly => "?",
            Self::Executable => "~",
            Self::AskedNeedlessly => "?!",
            Self::NotExecutable => "✗",
        }
    }

    /// The sign in ASCII.
    pub(super) fn letter(self) -> char {
        match self {
            Self::Correct => '+',
            Self::AskedRightly => '?',
            Self::Executable => '~',
            Self::AskedNeedlessly => '!',
            Self::NotExecutable => 'x',
        }
    }

    /// The CSS class.
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
