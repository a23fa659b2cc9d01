//! The only module that prints.
//!
//! [`print_line!`] and [`remark!`] take the arguments of `format!`. All text is untrusted: when it is printed, line
//! breaks, control characters, bidirectional controls and zero-width characters become escapes. Styles are kept apart
//! from the text, so that text cannot contain styles. `clippy.toml` forbids every other way to print.

mod styled;
mod terminal;
mod tree;
mod wrap;

use std::fmt;
use std::io::{ErrorKind, Write};
use std::sync::{Mutex, OnceLock, PoisonError};

use anyhow::Result;
use indicatif::ProgressBar;
use longstep_core::visible;
use longstep_files::plain_reason;
use serde::Serialize;

pub(crate) use styled::{Line, Style};
pub(crate) use terminal::{can_draw_board, can_redraw, columns, draws_lines, shows_remarks, terminal_size};
pub(crate) use tree::{Item, Tone, tree};
pub(crate) use wrap::wrapped;

/// The exit code when stdout could not be written.
pub(crate) const NOT_WRITTEN: u8 = 60;

/// Prints one line to stdout.
macro_rules! print_line {
    ($($arguments:tt)*) => { $crate::output::line_to_stdout(::std::format_args!($($arguments)*)) };
}

/// Prints one line to stderr.
macro_rules! remark {
    ($($arguments:tt)*) => { $crate::output::line_to_stderr(::std::format_args!($($arguments)*)) };
}

/// A styled line, to be printed later.
macro_rules! composed {
    ($($arguments:tt)*) => { $crate::output::Line::new(::std::format_args!($($arguments)*)) };
}

pub(crate) use {composed, print_line, remark};

/// The first error of stdout. Nothing is printed after it.
static FAILED: OnceLock<std::io::Error> = OnceLock::new();

/// Prints one line to stdout; [`print_line!`] calls it.
pub(crate) fn line_to_stdout(text: fmt::Arguments<'_>) {
    to_stdout(&(Line::new(text).shown() + "\n"));
}

/// Prints one line to stderr; [`remark!`] calls it.
pub(crate) fn line_to_stderr(text: fmt::Arguments<'_>) {
    to_stderr(&(Line::new(text).shown() + "\n"));
}

/// A number of things with a regular plural: "1 plan", "2 plans".
pub(crate) fn counted(number: usize, what: &str) -> String {
    match number {
        1 => format!("1 {what}"),
        many => format!("{many} {what}s"),
    }
}

/// Writes a path or a name as one word of a command for a shell.
pub(crate) fn shell_word(word: impl std::fmt::Display) -> String {
    let word = word.to_string();
    shlex::try_quote(&word)
        .map(|quoted| quoted.into_owned())
        .unwrap_or(word)
}

/// Prints an empty line to stdout.
pub(crate) fn blank() {
    to_stdout("\n");
}

/// Prints untrusted text of several lines to stdout, with a margin at its left.
pub(crate) fn quotation(text: &str) {
    for one in visible::block(text).lines() {
        to_stdout(format!("  | {one}").trim_end());
        blank();
    }
}

/// Prints text of several lines that is the whole output of a command, such as a script.
pub(crate) fn document(text: &str) {
    to_stdout(&visible::block(text));
}

/// Prints a value as indented JSON.
pub(crate) fn json(value: &impl Serialize) -> Result<()> {
    document(&(visible::json(&serde_json::to_string_pretty(value)?).into_owned() + "\n"));
    Ok(())
}

/// Prints a value as JSON in one line.
pub(crate) fn json_line(value: &impl Serialize) -> Result<()> {
    document(&(visible::json(&serde_json::to_string(value)?).into_owned() + "\n"));
    Ok(())
}

/// The progress that stands below everything that is printed; none while nothing is under way.
static PROGRESS: Mutex<Option<ProgressBar>> = Mutex::new(None);

fn progress_below() -> Option<ProgressBar> {
    PROGRESS.lock().unwrap_or_else(PoisonError::into_inner).clone()
}

/// From now on a progress bar stands below everything that is printed.
pub(crate) fn begin_progress(bar: &ProgressBar) {
    *PROGRESS.lock().unwrap_or_else(PoisonError::into_inner) = Some(bar.clone());
}

/// Removes a progress bar from the terminal.
pub(crate) fn end_progress(bar: &ProgressBar) {
    drop(PROGRESS.lock().unwrap_or_else(PoisonError::into_inner).take());
    bar.finish_and_clear();
}

/// Shows lines on a progress bar, each of which has to fit the terminal.
#[expect(clippy::disallowed_methods, reason = "the lines are made visible first")]
pub(crate) fn board(bar: &ProgressBar, lines: &[Line]) {
    let lines: Vec<String> = lines.iter().map(Line::shown).collect();
    let text = lines.join("\n");
    bar.set_message(if std::env::var_os("NO_COLOR").is_some_and(|value| !value.is_empty()) {
        anstream::adapter::strip_str(&text).to_string()
    } else {
        text
    });
}

/// The form of what a command prints.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Form {
    Text,
    /// One JSON object.
    Json,
    /// JSON objects, one a line.
    JsonLines,
}

static FORM: OnceLock<Form> = OnceLock::new();

/// Sets the form of results and errors, once.
pub(crate) fn set_form(form: Form) {
    let _ = FORM.set(form);
}

/// The form that the arguments of the program ask for.
pub(crate) fn form() -> Form {
    FORM.get().copied().unwrap_or(Form::Text)
}

/// Prints a value in a form of JSON. A value that JSON cannot express is not printed.
pub(crate) fn in_form(form: Form, value: &impl Serialize) {
    let printed = match form {
        Form::JsonLines => json_line(value),
        Form::Json | Form::Text => json(value),
    };
    if let Err(error) = printed {
        remark!("{} {error}", "error:".red().bold());
    }
}

/// Shows a message on a progress bar.
#[expect(clippy::disallowed_methods, reason = "the message is made visible first")]
pub(crate) fn progress(bar: &ProgressBar, message: &str) {
    bar.set_message(visible::line(message).into_owned());
}

/// Returns true if stdout has failed, so that the user no longer sees any output.
pub(crate) fn failed() -> bool {
    FAILED.get().is_some()
}

/// Returns the exit code of the program: `code`, or [`NOT_WRITTEN`] if stdout has failed. A closed pipe, for example to
/// `head`, is not reported.
pub(crate) fn finished(code: u8) -> u8 {
    let Some(error) = FAILED.get() else { return code };
    if error.kind() != ErrorKind::BrokenPipe {
        let reason = plain_reason(error);
        remark!("{} cannot write to standard output: {reason}", "error:".red().bold());
        let hint = "the output is incomplete: free some space, or redirect it to another place";
        remark!("{} {hint}", "hint:".cyan().bold());
    }
    NOT_WRITTEN
}

pub(crate) fn to_stdout(shown: &str) {
    match progress_below() {
        Some(bar) if !failed() => bar.suspend(|| write_stdout(shown)),
        _ => write_stdout(shown),
    }
}

fn write_stdout(shown: &str) {
    if failed() {
        return;
    }
    #[expect(clippy::disallowed_methods, reason = "this is the one place")]
    let mut stdout = anstream::stdout().lock();
    let written = stdout.write_all(shown.as_bytes()).and_then(|()| stdout.flush());
    if let Err(error) = written {
        let _ = FAILED.set(error);
    }
}

pub(crate) fn to_stderr(shown: &str) {
    match progress_below() {
        Some(bar) => bar.suspend(|| write_stderr(shown)),
        None => write_stderr(shown),
    }
}

fn write_stderr(shown: &str) {
    #[expect(clippy::disallowed_methods, reason = "this is the one place")]
    let mut stderr = anstream::stderr().lock();
    // There is no other place to report an error.
    let _ = stderr.write_all(shown.as_bytes()).and_then(|()| stderr.flush());
}
