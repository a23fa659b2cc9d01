//! A conversation with the program: its stderr is read as it comes, and answers are given when they are due.

use std::io::{Read, Write};
use std::process::{Child, ChildStdin, Command, Output, Stdio};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant};

use super::ended;

/// The longest wait for a text.
const LONGEST: Duration = Duration::from_secs(60);

/// A program that runs.
#[derive(Debug)]
pub struct Talk {
    child: Child,
    input: Option<ChildStdin>,
    pieces: Receiver<Vec<u8>>,
    /// The text so far, and the part of it that was waited for.
    text: String,
    seen: usize,
}

impl Talk {
    pub fn start(command: &mut Command) -> Self {
        let mut child = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap();
        let (input, mut errors) = (child.stdin.take(), child.stderr.take().unwrap());
        let (sender, pieces) = channel();
        thread::spawn(move || {
            let mut piece = [0; 4096];
            while let Ok(count @ 1..) = errors.read(&mut piece) {
                let _ = sender.send(piece[..count].to_vec());
            }
        });
        Self {
            child,
            input,
            pieces,
            text: String::new(),
            seen: 0,
        }
    }

    /// Waits for a text after the last one that was waited for.
    #[track_caller]
    pub fn until(&mut self, expected: &str) {
        let begun = Instant::now();
        loop {
            if let Some(place) = self.text[self.seen..].find(expected) {
                self.seen += place + expected.len();
                return;
            }
            let left = LONGEST.saturating_sub(begun.elapsed());
            match self.pieces.recv_timeout(left) {
                Ok(piece) => self.text.push_str(&String::from_utf8(piece).unwrap()),
                Err(_) => panic!(
                    "no `{expected}` in:\n{}\n---\n{}",
                    &self.text[..self.seen],
                    &self.text[self.seen..]
                ),
            }
        }
    }

    /// Writes a line.
    pub fn say(&mut self, line: &str) {
        let input = self.input.as_mut().unwrap();
        input.write_all(format!("{line}\n").as_bytes()).unwrap();
    }

    /// The number of its process.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Ends the input, waits for the end of the program, and returns its exit code and what it wrote to stderr and
    /// to stdout.
    pub fn finish(mut self) -> (i32, String, String) {
        self.input = None;
        let output: Output = ended(self.child, LONGEST);
        while let Ok(piece) = self.pieces.recv_timeout(Duration::from_secs(5)) {
            self.text.push_str(&String::from_utf8(piece).unwrap());
        }
        let results = String::from_utf8(output.stdout).unwrap();
        (output.status.code().unwrap_or(-1), self.text, results)
    }
}
