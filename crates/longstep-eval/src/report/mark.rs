//! The mark of an attempt in a grid.

use crate::attempt::Attempt;

/// The kinds of results in a grid. Each has its own sign, for readers who do not see colours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Mark {
    Correct,
    RightQuestion,
    Executable,
    NeedlessQuestion,
    NotExecutable,
}

impl Mark {
    pub(super) const ALL: [Self; 5] = [
        Self::Correct,
        Self::RightQuestion,
        Self::Executable,
        Self::NeedlessQuestion,
        Self::NotExecutable,
    ];

    pub(super) fn of(attempt: &Attempt) -> Self {
        match (attempt.correct, attempt.is_question()) {
            (true, true) => Self::RightQuestion,
            (true, false) => Self::Correct,
            (false, true) => Self::NeedlessQuestion,
            (false, false) if attempt.executable => Self::Executable,
            (false, false) => Self::NotExecutable,
        }
    }

    /// The name in a legend.
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::RightQuestion => "asked rightly",
            Self::Executable => "executable only",
            Self::NeedlessQuestion => "asked needlessly",
            Self::NotExecutable => "not executable",
        }
    }

    /// The sign on a page.
    pub(super) fn sign(self) -> &'static str {
        match self {
            Self::Correct => "✓",
            Self::RightQuestion => "?",
            Self::Executable => "~",
            Self::NeedlessQuestion => "?!",
            Self::NotExecutable => "✗",
        }
    }

    /// The sign in ASCII.
    pub(super) fn letter(self) -> char {
        match self {
            Self::Correct => '+',
            Self::RightQuestion => '?',
            Self::Executable => '~',
            Self::NeedlessQuestion => '!',
            Self::NotExecutable => 'x',
        }
    }

    /// The CSS class.
    pub(super) fn class(self) -> &'static str {
        match self {
            Self::Correct => "correct",
            Self::RightQuestion => "asked",
            Self::Executable => "executable",
            Self::NeedlessQuestion => "needless",
            Self::NotExecutable => "failed",
        }
    }
}
