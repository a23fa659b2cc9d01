//! Styles, kept apart from the text.

use std::cell::RefCell;
use std::fmt::{self, Display, Write};

use longstep_core::visible;

/// A styled line of untrusted text. [`Line::shown`] escapes the text, style by style.
#[derive(Debug, Clone, Default)]
pub(crate) struct Line {
    parts: Vec<Part>,
}

#[derive(Debug, Clone)]
enum Part {
    Text(String),
    /// An escape sequence of a style.
    Code(&'static str),
}

thread_local! {
    /// The codes before the next piece of text. They bypass the formatter, which receives text alone: text that looks
    /// like a code stays text.
    static CODES: RefCell<Vec<&'static str>> = const { RefCell::new(Vec::new()) };
}

fn send(code: &'static str) {
    CODES.with_borrow_mut(|codes| codes.push(code));
}

impl Line {
    /// Formats a line.
    pub(crate) fn new(text: fmt::Arguments<'_>) -> Self {
        let mut line = Self::default();
        line.push(text);
        line
    }

    /// Appends text.
    pub(crate) fn push(&mut self, text: fmt::Arguments<'_>) {
        let _ = CODES.take();
        // Writing to a line never fails.
        let _ = self.write_fmt(text);
        self.receive();
    }

    fn receive(&mut self) {
        self.parts.extend(CODES.take().into_iter().map(Part::Code));
    }

    /// Returns the line for a terminal, with its text escaped.
    pub(super) fn shown(&self) -> String {
        let shown = self.parts.iter().map(|part| match part {
            Part::Text(text) => visible::line(text),
            Part::Code(code) => (*code).into(),
        });
        shown.collect()
    }
}

impl Write for Line {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        self.receive();
        match self.parts.last_mut() {
            Some(Part::Text(before)) => before.push_str(text),
            _ => self.parts.push(Part::Text(text.to_owned())),
        }
        Ok(())
    }
}

impl Display for Line {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.parts.iter().try_for_each(|part| match part {
            Part::Text(text) => f.write_str(text),
            Part::Code(code) => {
                send(code);
                Ok(())
            }
        })
    }
}

/// Styles for anything that implements [`Display`]. Formatted outside a [`Line`], the text is plain.
pub(crate) trait Style: Display {
    fn bold(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[1m", "\u{1b}[22m")
    }

    fn dimmed(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[2m", "\u{1b}[22m")
    }

    fn red(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[31m", "\u{1b}[39m")
    }

    fn green(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[32m", "\u{1b}[39m")
    }

    fn yellow(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[33m", "\u{1b}[39m")
    }

    fn cyan(&self) -> Styled<'_, Self> {
        Styled(self, "\u{1b}[36m", "\u{1b}[39m")
    }
}

impl<T: Display + ?Sized> Style for T {}

/// Text between two style codes.
pub(crate) struct Styled<'a, T: ?Sized>(&'a T, &'static str, &'static str);

impl<T: Display + ?Sized> Display for Styled<'_, T> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        send(self.1);
        let written = self.0.fmt(f);
        send(self.2);
        written
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn styled_line_keeps_own_styles_and_escapes_the_rest() {
        let through_text = format!("{}", "x".red());
        let name = "\u{1b}[31mju\u{202e}ice\nVerified: 1 step";
        for (line, shown) in [
            (
                Line::new(format_args!("{name}")),
                r"\u{1b}[31mju\u{202e}ice\nVerified: 1 step",
            ),
            (
                Line::new(format_args!("a {} b", "c".red().bold())),
                "a \u{1b}[1m\u{1b}[31mc\u{1b}[39m\u{1b}[22m b",
            ),
            (
                Line::new(format_args!("{:3}|{}", "x".bold(), "\u{1b}[0m".dimmed())),
                "\u{1b}[1mx  \u{1b}[22m|\u{1b}[2m\\u{1b}[0m\u{1b}[22m",
            ),
            // A style inside an already formatted string is lost.
            (Line::new(format_args!("{through_text}")), "x"),
            (
                Line::new(format_args!("<{}>", Line::new(format_args!("{}", "x".red())))),
                "<\u{1b}[31mx\u{1b}[39m>",
            ),
        ] {
            assert_eq!(line.shown(), shown);
        }
    }
}
