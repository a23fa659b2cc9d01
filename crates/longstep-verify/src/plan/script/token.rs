//! Lexer for scripts: text to tokens, with the begin and end of blocks.

use std::ops::Range;

use super::super::written::in_name;
use super::write::OBJECTS;
use super::{Fault, fault};

/// A token with its byte offset.
#[derive(Debug)]
pub(super) struct Token<'t> {
    pub(super) at: usize,
    pub(super) kind: Kind<'t>,
}

#[derive(Debug, PartialEq)]
pub(super) enum Kind<'t> {
    /// A word, or a name in angle brackets.
    Name(&'t str),
    /// A quoted string.
    Text(String),
    /// Digits with the name characters that follow them.
    Number(&'t str),
    /// An operator or punctuation mark.
    Sign(&'t str),
    /// A trailing comment.
    Comment(String),
    /// A comment on a line of its own, at a place where a statement can stand.
    Remark(String),
    /// A comment like [`Kind::Remark`] that lists the handled objects.
    Objects(String),
    /// The end of a statement's line.
    Newline,
    Indent,
    Dedent,
    End,
}

/// Splits a part of a text into tokens. Indents and dedents are balanced, whatever the indentation of the part as a
/// whole. The last token is [`Kind::End`].
pub(super) fn tokens(text: &str, part: Range<usize>) -> Result<Vec<Token<'_>>, Fault> {
    let mut lexer = Lexer {
        text: &text[..part.end],
        at: part.start,
        tokens: Vec::new(),
        levels: Vec::new(),
        opened: Vec::new(),
        indented_with: None,
        waiting: Vec::new(),
    };
    while lexer.at < lexer.text.len() {
        lexer.line()?;
    }
    if let Some(open) = lexer.opened.first() {
        return fault(*open, "this parenthesis is never closed", "close it with `)`");
    }
    let outermost = lexer.levels.first().copied().unwrap_or(0);
    lexer.blocks(outermost, part.end)?;
    lexer.push(part.end, Kind::End);
    Ok(lexer.tokens)
}

struct Lexer<'t> {
    text: &'t str,
    at: usize,
    tokens: Vec<Token<'t>>,
    /// Indentation columns of the open blocks.
    levels: Vec<usize>,
    /// Byte offsets of the open parentheses.
    opened: Vec<usize>,
    /// The first indentation character, a blank or a tab.
    indented_with: Option<char>,
    /// Comments on lines of their own, with offset and column; the next statement determines their block.
    waiting: Vec<(usize, usize, Kind<'t>)>,
}

/// Tab width.
const TAB: usize = 8;

impl<'t> Lexer<'t> {
    fn push(&mut self, at: usize, kind: Kind<'t>) {
        self.tokens.push(Token { at, kind });
    }

    fn rest(&self) -> &'t str {
        &self.text[self.at..]
    }

    /// Reads a line, or several lines joined by parentheses.
    fn line(&mut self) -> Result<(), Fault> {
        let start = self.at;
        let column = self.indentation();
        match self.rest().chars().next() {
            None => return Ok(()),
            Some('\n') => {
                self.at += 1;
                return Ok(());
            }
            Some('#') => {
                let at = self.at;
                let names = self.rest().trim_start_matches('#').trim_start().starts_with(OBJECTS);
                if let Some(comment) = self.comment() {
                    let kind = if names {
                        Kind::Objects(comment)
                    } else {
                        Kind::Remark(comment)
                    };
                    self.waiting.push((at, column, kind));
                }
                return Ok(());
            }
            Some(_) => {}
        }
        let indentation = &self.text[start..self.at];
        for character in indentation.chars().filter(|c| matches!(c, ' ' | '\t')) {
            if *self.indented_with.get_or_insert(character) != character {
                return fault(start, "blanks and tabs are mixed here", "indent with blanks alone");
            }
        }
        self.blocks(column, self.at)?;
        self.statement()
    }

    /// Skips the indentation of a line; returns the column.
    fn indentation(&mut self) -> usize {
        let mut column = 0;
        for character in self.rest().chars() {
            match character {
                '\r' | '\u{feff}' => {}
                '\t' => column = (column / TAB + 1) * TAB,
                '\n' => break,
                _ if character.is_whitespace() => column += 1,
                _ => break,
            }
            self.at += character.len_utf8();
        }
        column
    }

    /// Opens and closes blocks for a statement at this column. A pending comment that is indented deeper than the
    /// statement goes into a block that ends here.
    fn blocks(&mut self, column: usize, at: usize) -> Result<(), Fault> {
        let mut waiting = std::mem::take(&mut self.waiting).into_iter().peekable();
        match self.levels.last() {
            None => self.levels.push(column),
            Some(level) if column > *level => {
                self.levels.push(column);
                self.push(at, Kind::Indent);
            }
            Some(_) => {
                while let Some((at, indented, comment)) = waiting.next_if(|(_, indented, _)| *indented > column) {
                    self.dedent(indented, at);
                    self.push(at, comment);
                }
                self.dedent(column, at);
            }
        }
        if self.levels.last() != Some(&column) {
            return fault(
                at,
                "this line is indented like none before it",
                "indent it as far as the block that it belongs to",
            );
        }
        for (at, _, comment) in waiting {
            self.push(at, comment);
        }
        Ok(())
    }

    /// Closes the blocks that are indented deeper than the column, except the outermost.
    fn dedent(&mut self, column: usize, at: usize) {
        while self.levels.len() > 1 && self.levels.last().is_some_and(|level| *level > column) {
            self.levels.pop();
            self.push(at, Kind::Dedent);
        }
    }

    /// Reads a comment; none if it is empty.
    fn comment(&mut self) -> Option<String> {
        let rest = self.rest();
        let length = rest.find('\n').unwrap_or(rest.len());
        self.at += length;
        let words = rest[..length].trim_start_matches('#').trim();
        // A comment that cannot be written literally is a quoted JSON string.
        let quoted = words.starts_with('"').then(|| serde_json::from_str(words).ok());
        (!words.is_empty()).then(|| quoted.flatten().unwrap_or_else(|| words.to_owned()))
    }

    /// Reads the tokens up to the end of a line outside of parentheses.
    fn statement(&mut self) -> Result<(), Fault> {
        while let Some(next) = self.rest().chars().next() {
            let at = self.at;
            match next {
                '\n' => {
                    self.at += 1;
                    if self.opened.is_empty() {
                        self.push(at, Kind::Newline);
                        return Ok(());
                    }
                }
                _ if next.is_whitespace() => self.at += next.len_utf8(),
                '\\' if self.rest()[1..].trim_start_matches('\r').starts_with('\n') => {
                    self.at += self.rest().find('\n').unwrap_or(0) + 1;
                }
                '#' => {
                    if let Some(comment) = self.comment() {
                        self.push(at, Kind::Comment(comment));
                    }
                }
                '"' | '\'' => {
                    let text = self.quoted(next)?;
                    self.push(at, Kind::Text(text));
                }
                _ => {
                    let kind = self.word(next)?;
                    self.push(at, kind);
                }
            }
        }
        if self.opened.is_empty() {
            self.push(self.at, Kind::Newline);
        }
        Ok(())
    }

    /// Reads a name, a number or a sign.
    fn word(&mut self, next: char) -> Result<Kind<'t>, Fault> {
        let rest = self.rest();
        let word = &rest[..rest.find(|c| !in_name(c)).unwrap_or(rest.len())];
        // No name begins with a minus.
        if !word.is_empty() && next != '-' {
            self.at += word.len();
            return Ok(if next.is_numeric() {
                Kind::Number(word)
            } else {
                Kind::Name(word)
            });
        }
        if next == '<'
            && let Some(bracketed) = bracketed(rest)
        {
            self.at += bracketed.len();
            return Ok(Kind::Name(bracketed));
        }
        let long = LONG_SIGNS.iter().find(|sign| rest.starts_with(**sign));
        let sign = &rest[..long.map_or(next.len_utf8(), |sign| sign.len())];
        match sign {
            "(" => self.opened.push(self.at),
            ")" if self.opened.pop().is_none() => {
                return fault(self.at, "this parenthesis closes nothing", "take it out");
            }
            _ => {}
        }
        self.at += sign.len();
        Ok(Kind::Sign(sign))
    }

    /// Reads a quoted string on one line.
    fn quoted(&mut self, quote: char) -> Result<String, Fault> {
        let start = self.at;
        if self.rest().starts_with(&quote.to_string().repeat(3)) {
            return fault(
                start,
                "this is a text in three quotes",
                "say what a step does in a comment, `# ...`",
            );
        }
        self.at += 1;
        let mut text = String::new();
        loop {
            let at = self.at;
            let Some(next) = self.rest().chars().next().filter(|next| *next != '\n') else {
                return fault(
                    start,
                    "this text does not end on its line",
                    format!("close it with `{quote}`"),
                );
            };
            self.at += next.len_utf8();
            match next {
                _ if next == quote => return Ok(text),
                '\\' => match self.escaped() {
                    Some(character) => text.push(character),
                    None => {
                        return fault(at, "this escape means nothing in a plan", "write the character itself");
                    }
                },
                _ => text.push(next),
            }
        }
    }

    /// Reads an escape sequence after its backslash.
    fn escaped(&mut self) -> Option<char> {
        let next = self.rest().chars().next()?;
        self.at += next.len_utf8();
        match next {
            '\\' | '\'' | '"' => Some(next),
            'n' => Some('\n'),
            'r' => Some('\r'),
            't' => Some('\t'),
            'b' => Some('\u{8}'),
            'f' => Some('\u{c}'),
            'U' | 'u' | 'x' => {
                let length = match next {
                    'U' => 8,
                    'u' => 4,
                    _ => 2,
                };
                let digits = self.rest().get(..length)?;
                let hexadecimal = digits.bytes().all(|digit| digit.is_ascii_hexdigit());
                let number = u32::from_str_radix(digits, 16).ok().filter(|_| hexadecimal)?;
                self.at += digits.len();
                char::from_u32(number)
            }
            _ => None,
        }
    }
}

/// Signs of several characters; longer ones first.
const LONG_SIGNS: [&str; 17] = [
    "**=", "//=", "...", "==", "!=", "<=", ">=", "->", ":=", "+=", "-=", "*=", "/=", "%=", "|=", "**", "//",
];

/// Returns the unquoted name in angle brackets at the start of `rest`.
fn bracketed(rest: &str) -> Option<&str> {
    let inside = &rest[1..];
    let length = inside.find(|c| !in_name(c)).filter(|length| *length > 0)?;
    inside[length..].starts_with('>').then(|| &rest[..length + 2])
}
