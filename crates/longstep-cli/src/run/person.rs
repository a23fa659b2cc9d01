//! Decisions of the person at the terminal.

use std::io::{BufRead, IsTerminal, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::Duration;

use longstep_robot::StopRequest;

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

/// The person at the terminal. Lines are read in a thread, so that a signal ends the wait for an answer.
pub(super) struct Person {
    lines: Option<Receiver<String>>,
    request: StopRequest,
}

impl Person {
    pub(super) fn new(request: StopRequest) -> Self {
        Self { lines: None, request }
    }

    fn line(&mut self) -> Option<String> {
        let lines = self.lines.get_or_insert_with(read_lines);
        loop {
            match lines.recv_timeout(LOOK) {
                Ok(line) => return Some(line),
                Err(RecvTimeoutError::Disconnected) => {
                    let why = match std::io::stdin().is_terminal() {
                        true => "the input has ended",
                        false => "nobody can answer; pass `--approve never` to run without questions",
                    };
                    remark!("{why}");
                    return None;
                }
                Err(RecvTimeoutError::Timeout) if self.request.is_requested() => return None,
                Err(RecvTimeoutError::Timeout) => {}
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

fn read_lines() -> Receiver<String> {
    let (sender, receiver) = channel();
    std::thread::spawn(move || {
        let mut stdin = std::io::stdin().lock();
        loop {
            let mut line = String::new();
            match stdin.by_ref().take(LONGEST).read_line(&mut line) {
                Ok(1..) if sender.send(line).is_ok() => {}
                _ => return,
            }
        }
    });
    receiver
}
