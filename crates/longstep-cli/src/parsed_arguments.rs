//! Parses arguments; prints help and errors of arguments.

use std::ffi::OsString;

use clap::Parser;
use clap::error::{ContextKind, ContextValue};
use longstep_core::{secret, visible};

use crate::arguments::Arguments;
use crate::output::{self, Form};

/// Parses the arguments of the program. Help and errors are printed; the returned error is the exit code.
pub(crate) fn parsed() -> Result<Arguments, u8> {
    let typed: Vec<OsString> = std::env::args_os().collect();
    output::set_form(form(&typed));
    Arguments::try_parse_from(&typed).map_err(|error| {
        // The error repeats arguments inside styled text, so arguments are escaped before.
        let shown = typed.iter().map(|argument| shown_argument(&argument.to_string_lossy()));
        match Arguments::try_parse_from(shown) {
            Err(same) if same.kind() == error.kind() => print(same),
            _ => print(error),
        }
    })
}

/// Returns the form that `--json` asks for: `run` prints lines, all other commands one object.
fn form(typed: &[OsString]) -> Form {
    let options = typed.iter().take_while(|argument| *argument != "--");
    let is_json = options.skip(1).any(|argument| argument == "--json");
    match (is_json, typed.get(1)) {
        (false, _) => Form::Text,
        (true, Some(command)) if command == "run" => Form::JsonLines,
        (true, _) => Form::Json,
    }
}

/// Prints an error of the arguments as the object of all errors: its first paragraph is the message.
fn print_object(error: &clap::Error, code: u8) {
    let text = error.render().to_string();
    let mut paragraphs = text.trim().split("\n\n");
    let message = paragraphs.next().unwrap_or_default();
    let message = message.strip_prefix("error: ").unwrap_or(message);
    let words: Vec<&str> = message.split_whitespace().collect();
    let object = serde_json::json!({
        "error": { "code": code, "message": words.join(" "), "hint": "`longstep help` lists the commands and their options" },
    });
    output::in_form(output::form(), &object);
}

fn print(mut error: clap::Error) -> u8 {
    // Values may also come from environment variables.
    let values: Vec<(ContextKind, ContextValue)> = error
        .context()
        .filter_map(|(kind, value)| Some((kind, visible_value(value)?)))
        .collect();
    for (kind, value) in values {
        error.insert(kind, value);
    }
    let code = u8::try_from(error.exit_code()).unwrap_or(crate::exit_code::UNREADABLE);
    if error.use_stderr() && output::form() != Form::Text {
        print_object(&error, code);
    }
    let shown = visible_but_styles(&error.render().ansi().to_string());
    if error.use_stderr() {
        output::to_stderr(&shown)
    } else {
        output::to_stdout(&shown)
    }
    code
}

/// Escapes an argument, without the passwords of addresses.
fn shown_argument(argument: &str) -> String {
    secret::redacted(&visible::line(argument)).into_owned()
}

fn visible_value(value: &ContextValue) -> Option<ContextValue> {
    let line = |text: &String| shown_argument(text);
    match value {
        ContextValue::String(text) => Some(ContextValue::String(line(text))),
        ContextValue::Strings(texts) => Some(ContextValue::Strings(texts.iter().map(line).collect())),
        _ => None,
    }
}

/// Escapes everything except clap's styles (`ESC [ digits m`).
fn visible_but_styles(text: &str) -> String {
    let mut parts = text.split("\u{1b}[");
    let mut shown = visible::block(parts.next().unwrap_or_default()).into_owned();
    for part in parts {
        let length = part
            .find(|c: char| !c.is_ascii_digit() && c != ';')
            .unwrap_or(part.len());
        let (code, rest) = part.split_at(length);
        match rest.strip_prefix('m') {
            Some(rest) => {
                shown.extend(["\u{1b}[", code, "m"]);
                shown += &visible::block(rest);
            }
            None => {
                shown += r"\u{1b}[";
                shown += &visible::block(part);
            }
        }
    }
    shown
}
