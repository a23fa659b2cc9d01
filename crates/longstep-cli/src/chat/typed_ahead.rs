//! Text that was typed in a terminal before the program was ready for it, while a model worked.
//!
//! The terminal keeps such text, and would give it to the next prompt as if it were an answer to it: an empty line would
//! accept a plan that nobody has seen yet. So it is taken out before each prompt, and the person decides what becomes of
//! it.

use std::collections::VecDeque;

/// Limit for a line of a pipe, and for what was typed too early, in bytes.
pub(super) const LINE_LIMIT: usize = 64 << 10;

/// Lines that were typed too early, in order.
#[derive(Debug, Default)]
pub(super) struct TypedAhead(VecDeque<String>);

impl TypedAhead {
    /// Takes what the terminal has, for a later prompt.
    pub(super) fn keep(&mut self) {
        self.add(&pending());
    }

    /// Takes what the terminal has, and returns the first line that waits.
    pub(super) fn first(&mut self) -> Option<&str> {
        self.keep();
        self.0.front().map(String::as_str)
    }

    /// Adds the lines of a text. Empty ones and control characters are left out: an early Enter or an arrow key says
    /// nothing.
    fn add(&mut self, text: &str) {
        let lines = text.split(['\n', '\r']).map(plain);
        self.0.extend(lines.filter(|line| !line.is_empty()));
    }

    /// Forgets the first line that waits.
    pub(super) fn drop_first(&mut self) {
        self.0.pop_front();
    }

    /// Forgets the first line that waits if the person's line was made of it: it is the same, or nothing else is meant by
    /// it. A decision and a command in place of another line are not made of it: that line waits for the next prompt.
    /// Where nothing is decided, an emptied line is dropped.
    pub(super) fn answered(&mut self, line: &str, decides: bool) {
        let line = line.trim();
        let is_sent = self.0.front().is_some_and(|waiting| waiting == line);
        let is_command = |text: &str| text.starts_with('/');
        let replaces_command = self.0.front().is_some_and(|waiting| is_command(waiting)) && is_command(line);
        let stands_alone = is_command(line) || (decides && super::is_decision(line));
        if is_sent || replaces_command || !stands_alone {
            self.drop_first();
        }
    }
}

/// The text without control characters and the escape sequences of keys.
fn plain(line: &str) -> String {
    let mut text = String::new();
    let mut characters = line.chars().peekable();
    while let Some(c) = characters.next() {
        if c == '\u{1b}' {
            // `ESC [ 1 ; 5 C`, `ESC O P` or `ESC x`: a letter or a tilde ends it.
            if characters.next_if(|c| matches!(c, '[' | 'O')).is_some() {
                while characters.next_if(|c| !c.is_ascii_alphabetic() && *c != '~').is_some() {}
            }
            characters.next();
        } else if c == '\t' {
            text.push(' ');
        } else if !c.is_control() {
            text.push(c);
        }
    }
    text.trim().to_owned()
}

/// Takes the bytes that wait in the terminal. Between two prompts it gives whole lines only, so it is switched to single
/// characters for the moment.
#[cfg(unix)]
fn pending() -> String {
    use rustix::termios::{LocalModes, OptionalActions, SpecialCodeIndex, tcgetattr, tcsetattr};

    let input = std::io::stdin();
    let Ok(before) = tcgetattr(&input) else {
        return String::new();
    };
    let mut single = before.clone();
    single.local_modes -= LocalModes::ICANON;
    single.special_codes[SpecialCodeIndex::VMIN] = 0;
    single.special_codes[SpecialCodeIndex::VTIME] = 0;
    if tcsetattr(&input, OptionalActions::Now, &single).is_err() {
        return String::new();
    }
    let (mut bytes, mut buffer) = (Vec::new(), [0; 1024]);
    while let Ok(count @ 1..) = rustix::io::read(&input, &mut buffer) {
        bytes.extend_from_slice(&buffer[..count]);
        // The queue of a terminal has a few KiB; somebody who keeps a key pressed does not hold up the prompt.
        if bytes.len() > LINE_LIMIT {
            break;
        }
    }
    // The prompt sets its own mode in any case.
    let _ = tcsetattr(&input, OptionalActions::Now, &before);
    String::from_utf8_lossy(&bytes).into_owned()
}

/// Other consoles keep no lines apart; nothing is taken from them.
#[cfg(not(unix))]
fn pending() -> String {
    String::new()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn typed_ahead_keeps_early_lines_until_they_are_used() {
        let mut typed = TypedAhead::default();
        typed.add("\n\nclose the\tfridge\x1b[A\x1b[1;5C\x00\r\nwipe the table\x1bOP");
        let first = |typed: &TypedAhead| typed.0.front().cloned();
        for (line, decides) in [
            ("", true),
            ("yes", true),
            ("No.", true),
            ("/plan", true),
            ("/plan", false),
        ] {
            typed.answered(line, decides);
            assert_eq!(first(&typed).as_deref(), Some("close the fridge"), "{line}");
        }
        typed.answered("close the fridge please", true);
        assert_eq!(first(&typed).as_deref(), Some("wipe the table"));
        typed.answered("", false);
        assert_eq!(first(&typed), None);
    }

    #[test]
    fn typed_ahead_uses_a_line_that_is_submitted_unchanged() {
        for (early, line, decides, is_used) in [
            ("/plan", "/plan", false, true),
            ("/plan", "/plan", true, true),
            ("/paln", "/plan", true, true),
            ("/plan", "", true, false),
            ("/plan", "", false, true),
            ("yes", "yes", true, true),
            ("yes", "no", true, false),
            ("wipe the table", "/plan", true, false),
        ] {
            let mut typed = TypedAhead::default();
            typed.add(early);
            typed.answered(line, decides);
            assert_eq!(typed.0.is_empty(), is_used, "{early} {line} {decides}");
        }
    }
}
