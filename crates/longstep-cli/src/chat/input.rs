//! Lines of input, from a terminal or a pipe.

use std::io::{BufRead, Read};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, RecvTimeoutError, sync_channel};
use std::time::Duration;

use anyhow::Result;
use longstep_files::{create_private_folder, session_directory};
use longstep_robot::StopRequest;
use rustyline::error::ReadlineError;
use rustyline::history::DefaultHistory;
use rustyline::{Config, Editor};

use super::screen;
use super::typed_ahead::{LINE_LIMIT, TypedAhead};
use crate::ask;
use crate::failure::{Failure, LIMIT};
use crate::output::remark;
use crate::run::Question;

/// Number of lines in the history.
const HISTORY: usize = 1000;

/// Interval at which Ctrl-C is checked while a pipe is silent.
const TICK: Duration = Duration::from_millis(50);

/// The result of reading from a terminal or a pipe.
#[derive(Debug)]
pub(super) enum Input {
    Line(String),
    /// The end of the input.
    End,
    /// Ctrl-C on a pipe.
    Interrupted,
}

/// The source of a conversation's lines.
pub(super) enum Lines {
    Terminal {
        editor: Box<Editor<(), DefaultHistory>>,
        history: Option<PathBuf>,
        typed_ahead: TypedAhead,
    },
    Pipe(Receiver<Result<String>>),
}

impl Lines {
    pub(super) fn open(interactive: bool) -> Result<Self> {
        if !interactive {
            return Ok(Self::Pipe(pipe()));
        }
        let history = session_directory().ok().map(|folder| folder.with_file_name("history"));
        let config = Config::builder()
            .max_history_size(HISTORY)?
            .auto_add_history(true)
            .build();
        let mut editor = Box::new(Editor::with_config(config)?);
        if let Some(history) = &history {
            // There is no history at the first start.
            let _ = editor.load_history(history);
        }
        Ok(Self::Terminal {
            editor,
            history,
            typed_ahead: TypedAhead::default(),
        })
    }

    /// Reads the next line; `prompt` is shown in a terminal, and `decides` is true if it expects a decision.
    ///
    /// A line that was typed before the prompt is shown in it, to be sent, changed or cleared: it answers nothing by
    /// itself. On a pipe each line is meant for its prompt.
    pub(super) fn next(&mut self, prompt: &'static str, decides: bool) -> Result<Input> {
        match self {
            Self::Terminal {
                editor, typed_ahead, ..
            } => loop {
                // A Ctrl-C during the last search has no effect any more.
                let _ = ask::take_interrupt();
                let early = typed_ahead.first().unwrap_or_default();
                if !early.is_empty() {
                    screen::typed_ahead(early);
                }
                match editor.readline_with_initial(prompt, (early, "")) {
                    Ok(line) => {
                        typed_ahead.answered(&line, decides);
                        return Ok(Input::Line(line));
                    }
                    // Ctrl-C discards the line.
                    Err(ReadlineError::Interrupted) => typed_ahead.drop_first(),
                    Err(ReadlineError::Eof) => return Ok(Input::End),
                    Err(error) => return Err(error.into()),
                }
            },
            Self::Pipe(lines) => loop {
                if ask::take_interrupt() {
                    return Ok(Input::Interrupted);
                }
                match lines.recv_timeout(TICK) {
                    Ok(line) => return line.map(Input::Line),
                    Err(RecvTimeoutError::Timeout) => {}
                    Err(RecvTimeoutError::Disconnected) => return Ok(Input::End),
                }
            },
        }
    }

    /// Asks a question about a run. None if nobody answers, or the run is to stop; Ctrl-C stops it.
    ///
    /// A line that was typed before the question does not answer it: it waits for the next prompt.
    pub(super) fn decide(&mut self, question: Question<'_>, request: &StopRequest) -> Result<Option<bool>> {
        match self {
            // The prompt has the answers.
            Self::Terminal { .. } => remark!("{}", question.text()),
            Self::Pipe(_) => remark!("{} {}", question.text(), question.answers().trim_end()),
        }
        loop {
            let line = match self {
                Self::Terminal {
                    editor, typed_ahead, ..
                } => {
                    typed_ahead.keep();
                    match editor.readline(question.answers()) {
                        Ok(line) => line,
                        Err(ReadlineError::Interrupted | ReadlineError::Eof) => return Ok(None),
                        Err(error) => return Err(error.into()),
                    }
                }
                Self::Pipe(lines) => match lines.recv_timeout(TICK) {
                    Ok(line) => line?,
                    Err(RecvTimeoutError::Timeout) if request.is_requested() => return Ok(None),
                    Err(RecvTimeoutError::Timeout) => continue,
                    Err(RecvTimeoutError::Disconnected) => {
                        remark!("nobody can answer; begin with `--approve never` to run without questions");
                        return Ok(None);
                    }
                },
            };
            if let Some(decision) = question.decision(&line) {
                return Ok(Some(decision));
            }
        }
    }

    /// Saves the history of a terminal. Without it, the next conversation starts with an empty history, which is no
    /// loss.
    pub(super) fn close(self) {
        if let Self::Terminal {
            mut editor,
            history: Some(history),
            ..
        } = self
        {
            let _ = history.parent().map(|folder: &Path| create_private_folder(folder));
            let _ = editor.save_history(&history);
        }
    }
}

/// Reads standard input on a thread of its own, one line ahead, so that Ctrl-C works while the pipe is silent.
fn pipe() -> Receiver<Result<String>> {
    let (sender, receiver) = sync_channel(1);
    std::thread::spawn(move || {
        let mut input = std::io::stdin().lock();
        while let Some(line) = read_line(&mut input).transpose() {
            let failed = line.is_err();
            // The receiver is gone when the conversation has ended.
            if sender.send(line).is_err() || failed {
                return;
            }
        }
    });
    receiver
}

/// Reads a line without its line end; `None` at the end of the input.
fn read_line(input: &mut impl BufRead) -> Result<Option<String>> {
    let mut bytes = Vec::new();
    input.take(LINE_LIMIT as u64 + 1).read_until(b'\n', &mut bytes)?;
    if bytes.is_empty() {
        return Ok(None);
    }
    let ended = bytes.last() == Some(&b'\n');
    if !ended && bytes.len() > LINE_LIMIT {
        let message = format!("a line of the input is longer than {} KiB", LINE_LIMIT >> 10);
        return Err(Failure::new(message, LIMIT)
            .hint("write one instruction on each line")
            .into());
    }
    let text = String::from_utf8(bytes)
        .map_err(|_| Failure::unreadable("the input is not text (not UTF-8)").hint("save it as UTF-8"))?;
    let line = text.strip_suffix('\n').unwrap_or(&text);
    Ok(Some(line.strip_suffix('\r').unwrap_or(line).to_owned()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_are_read_up_to_a_limit() {
        let mut input = "one\r\ntwo\n\nlast".as_bytes();
        let mut lines = Vec::new();
        while let Some(line) = read_line(&mut input).unwrap() {
            lines.push(line);
        }
        assert_eq!(lines, ["one", "two", "", "last"]);
        let longest = "x".repeat(LINE_LIMIT - 1) + "\n";
        assert!(read_line(&mut longest.as_bytes()).is_ok());
        assert!(read_line(&mut std::io::BufReader::new(std::io::repeat(0))).is_err());
        assert!(read_line(&mut &b"\xff\n"[..]).is_err());
    }
}
