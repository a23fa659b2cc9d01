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

/// Somebody who decides.
pub(crate) trait Decide {
    /// Asks a question; none if nobody answers, or the run is to stop.
    fn decide(&mut self, question: &str) -> Option<bool>;
}

/// Reads an answer; none for another text.
pub(crate) fn decision(line: &str) -> Option<bool> {
    match line.trim().to_lowercase().as_str() {
        "y" | "yes" => Some(true),
        "n" | "no" => Some(false),
        _ => {
            remark!("Please answer y or n.");
            None
        }
    }
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
                    let why = match std::io::stdin().is_terminal() {
                        true => "the input has ended",
                        false => "nobody can answer; pass `--approve never` to run without questions",
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
    fn decide(&mut self, question: &str) -> Option<bool> {
        remark!("{question} [y/n]");
        loop {
            if let Some(decision) = decision(&self.line()?) {
                return Some(decision);
            }
        }
    }
}
