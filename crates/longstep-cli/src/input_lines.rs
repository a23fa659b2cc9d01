//! Lines of standard input, read in a thread, so that a wait for an answer has an end.

use std::io::{BufRead, Read};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

/// The end of a wait for a line.
#[derive(Debug)]
pub(crate) enum Waited {
    /// A line, with its end.
    Line(String),
    /// The input has ended.
    Ended,
    /// The time is over.
    Nothing,
}

/// The lines of standard input. Reading begins with the first wait; from then on nothing else may read the input.
#[derive(Debug)]
pub(crate) struct InputLines {
    /// The most bytes of a line; the rest counts as the next line.
    longest: u64,
    lines: Option<Receiver<std::io::Result<String>>>,
}

impl InputLines {
    pub(crate) fn new(longest: u64) -> Self {
        Self { longest, lines: None }
    }

    /// Forgets what was typed in the terminal and not read yet.
    pub(crate) fn forget(&mut self) {
        let lines = self.lines.iter();
        lines.for_each(|lines| while lines.try_recv().is_ok() {});
        #[cfg(unix)]
        {
            // A terminal that does not allow it keeps its lines, which then answer the question.
            let _ = rustix::termios::tcflush(std::io::stdin(), rustix::termios::QueueSelector::IFlush);
        }
    }

    /// Waits for the next line.
    ///
    /// # Errors
    ///
    /// The input cannot be read, or is no text.
    pub(crate) fn wait(&mut self, limit: Duration) -> std::io::Result<Waited> {
        let longest = self.longest;
        let lines = self.lines.get_or_insert_with(|| read_lines(longest));
        match lines.recv_timeout(limit) {
            Ok(line) => line.map(Waited::Line),
            Err(RecvTimeoutError::Disconnected) => Ok(Waited::Ended),
            Err(RecvTimeoutError::Timeout) => Ok(Waited::Nothing),
        }
    }
}

fn read_lines(longest: u64) -> Receiver<std::io::Result<String>> {
    // A line is read only when the one before it was taken: input that nobody asks for is not collected.
    let (sender, receiver) = sync_channel(0);
    std::thread::spawn(move || {
        let mut stdin = std::io::stdin().lock();
        loop {
            let mut line = String::new();
            let read = stdin.by_ref().take(longest).read_line(&mut line);
            let is_last = !matches!(read, Ok(1..));
            let sent = match read {
                Ok(0) => return,
                Ok(_) => sender.send(Ok(line)),
                Err(error) => sender.send(Err(error)),
            };
            if is_last || sent.is_err() {
                return;
            }
        }
    });
    receiver
}
