//! Decisions of the person at the terminal.

use std::io::IsTerminal;
use std::time::Duration;

use longstep_robot::StopRequest;

use crate::input_lines::{InputLines, Waited};
use crate::output::remark;

/// Maximum length of an answer.
const LONGEST: u64 = 1_000;
/// The time between two looks at a request to stop.
const LOOK: Duration = Duration::from_millis(20);

/// A question with two answers.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Question<'q> {
    /// A plan, a change or a step; an empty line accepts it, as it accepts a plan in `chat`.
    Proposal(&'q str),
    /// A fact that nobody has seen; it needs a word.
    Fact(&'q str),
}

impl<'q> Question<'q> {
    /// The question.
    pub(crate) fn text(self) -> &'q str {
        match self {
            Self::Proposal(text) | Self::Fact(text) => text,
        }
    }

    /// The answers, as they are shown behind a question.
    pub(crate) fn answers(self) -> &'static str {
        match self {
            Self::Proposal(_) => "[Enter, or `no`] ",
            Self::Fact(_) => "[y/n] ",
        }
    }

    /// Reads an answer; none for another text.
    pub(crate) fn decision(self, line: &str) -> Option<bool> {
        match (line.trim().to_lowercase().as_str(), self) {
            ("y" | "yes", _) | ("", Self::Proposal(_)) => Some(true),
            ("n" | "no", _) => Some(false),
            (_, Self::Proposal(_)) => {
                remark!("Please press Enter to accept, or answer no.");
                None
            }
            (_, Self::Fact(_)) => {
                remark!("Please answer y or n.");
                None
            }
        }
    }
}

/// Somebody who decides.
pub(crate) trait Decide {
    /// Asks a question; none if nobody answers, or the run is to stop.
    fn decide(&mut self, question: Question<'_>) -> Option<bool>;
}

/// The person at the terminal. A signal ends the wait for an answer.
pub(super) struct Person {
    lines: InputLines,
    request: StopRequest,
}

impl Person {
    pub(super) fn new(request: StopRequest) -> Self {
        let lines = InputLines::new(LONGEST);
        Self { lines, request }
    }

    fn line(&mut self) -> Option<String> {
        loop {
            match self.lines.wait(LOOK) {
                Ok(Waited::Line(line)) => return Some(line),
                Ok(Waited::Ended) | Err(_) => {
                    let why = if std::io::stdin().is_terminal() {
                        "the input has ended"
                    } else {
                        "nobody can answer; pass `--approve never` to run without questions"
                    };
                    remark!("{why}");
                    return None;
                }
                Ok(Waited::Nothing) if self.request.is_requested() => return None,
                Ok(Waited::Nothing) => {}
            }
        }
    }
}

impl Decide for Person {
    fn decide(&mut self, question: Question<'_>) -> Option<bool> {
        // What was typed in a terminal before the question does not answer it. On a pipe each line is meant for its question.
        if std::io::stdin().is_terminal() {
            self.lines.forget();
        }
        remark!("{} {}", question.text(), question.answers().trim_end());
        loop {
            if let Some(decision) = question.decision(&self.line()?) {
                return Some(decision);
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn enter_accepts_a_proposal_and_no_fact() {
        for (line, proposal, fact) in [
            ("", Some(true), None),
            (" \n", Some(true), None),
            ("Y", Some(true), Some(true)),
            ("no\n", Some(false), Some(false)),
            ("perhaps", None, None),
        ] {
            assert_eq!(Question::Proposal("p").decision(line), proposal, "{line}");
            assert_eq!(Question::Fact("f").decision(line), fact, "{line}");
        }
    }
}
