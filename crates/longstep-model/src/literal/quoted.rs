//! String literals in quotes of any style: JSON, Python or typographic.

use super::leniency::LeniencyKind as Kind;
use super::parser::{FENCE, FaultReason, Parsed, Parser, malformed};

/// Opening quotes with their closing quotes; longer ones first.
const QUOTES: [(&str, Quote); 10] = [
    ("\"\"\"", Quote::new(&["\"\"\""], Some(Kind::TripleQuotes))),
    ("'''", Quote::new(&["'''"], Some(Kind::TripleQuotes))),
    ("\"", Quote::new(&["\""], None)),
    ("'", Quote::new(&["'"], Some(Kind::SingleQuotes)).or_apostrophe()),
    ("“", DOUBLE),
    ("”", DOUBLE),
    ("„", DOUBLE),
    ("‘", SINGLE),
    ("’", SINGLE),
    ("‚", SINGLE),
];
const DOUBLE: Quote = Quote::new(&["“", "”"], Some(Kind::TypographicQuotes));
const SINGLE: Quote = Quote::new(&["‘", "’"], Some(Kind::TypographicQuotes)).or_apostrophe();

#[derive(Clone, Copy)]
struct Quote {
    close: &'static [&'static str],
    kind: Option<Kind>,
    /// True if the closing quote is also used as an apostrophe.
    apostrophe: bool,
}

impl Quote {
    const fn new(close: &'static [&'static str], kind: Option<Kind>) -> Self {
        Self {
            close,
            kind,
            apostrophe: false,
        }
    }

    const fn or_apostrophe(self) -> Self {
        Self {
            apostrophe: true,
            ..self
        }
    }

    /// Returns the quote at the start of `rest`, and the length of its opening mark.
    fn opening(rest: &str) -> Option<(usize, Self)> {
        let (open, quote) = QUOTES.iter().find(|(open, _)| rest.starts_with(open))?;
        Some((open.len(), *quote))
    }

    /// Returns the length of the closing quote at the start of `rest`.
    ///
    /// The next character distinguishes the closing quote from an apostrophe, as in `'the robots' hand'`: a string is
    /// followed by a comma, a colon, a bracket, a comment, another string or the end, an apostrophe by none of these.
    fn closing(&self, rest: &str) -> Option<usize> {
        let length = self.close.iter().find(|close| rest.starts_with(**close))?.len();
        if self.apostrophe {
            let next = rest[length..].trim_start();
            let ends = next.is_empty()
                || next.starts_with([',', ':', '}', ']', ')', '#'])
                || ["//", "/*", FENCE].iter().any(|mark| next.starts_with(mark))
                || Self::opening(next).is_some();
            return ends.then_some(length);
        }
        Some(length)
    }

    /// Returns true if the string may contain line breaks.
    fn is_triple(&self) -> bool {
        self.kind == Some(Kind::TripleQuotes)
    }
}

/// Returns true if a quoted string begins here.
pub(crate) fn is_quote(rest: &str) -> bool {
    Quote::opening(rest).is_some()
}

impl Parser<'_> {
    /// Parses a string and the adjacent strings after it, which Python joins.
    pub(crate) fn texts(&mut self) -> Parsed<String> {
        let mut joined = self.quoted(true)?;
        self.peek()?;
        while is_quote(self.rest()) {
            self.note(Kind::JoinedTexts);
            joined.push_str(&self.quoted(true)?);
            self.peek()?;
        }
        Ok(joined)
    }

    pub(crate) fn quoted(&mut self, line_breaks: bool) -> Parsed<String> {
        let Some((length, quote)) = Quote::opening(self.rest()) else {
            return malformed("expected a text in quotes");
        };
        if let Some(kind) = quote.kind {
            self.note(kind);
        }
        self.at += length;
        let mut text = String::new();
        loop {
            let rest = self.rest();
            if let Some(length) = quote.closing(rest) {
                self.at += length;
                return Ok(text);
            }
            match rest.chars().next() {
                None => return Err(FaultReason::CutOff),
                Some('\\') => text.extend(self.escape()?),
                Some(next) => {
                    if next == '\n' && !line_breaks {
                        return malformed("a key breaks off at the end of the line");
                    }
                    if next == '\n' && rest[1..].trim_start_matches([' ', '\t']).starts_with(FENCE) {
                        return Err(FaultReason::CutOff);
                    }
                    if next < ' ' && !quote.is_triple() {
                        self.note(Kind::RawControl);
                    }
                    if quote.close.iter().any(|close| rest.starts_with(close)) {
                        self.note(Kind::Apostrophe);
                    }
                    text.push(next);
                    self.at += next.len_utf8();
                }
            }
        }
    }

    /// Parses an escape sequence; returns none for an escaped line break.
    fn escape(&mut self) -> Parsed<Option<char>> {
        let rest = &self.rest()[1..];
        let next = rest.chars().next().ok_or(FaultReason::CutOff)?;
        let plain = match next {
            '"' | '\\' | '/' => Some(next),
            'b' => Some('\u{8}'),
            'f' => Some('\u{c}'),
            'n' => Some('\n'),
            'r' => Some('\r'),
            't' => Some('\t'),
            _ => None,
        };
        if plain.is_some() {
            self.at += 2;
            return Ok(plain);
        }
        if next == 'u' {
            return self.utf16().map(Some);
        }
        self.note(Kind::Escape);
        match next {
            'x' => self.code_point(2).map(Some),
            'U' => self.code_point(8).map(Some),
            '\n' => {
                self.at += 2;
                Ok(None)
            }
            '\r' if rest.starts_with("\r\n") => {
                self.at += 3;
                Ok(None)
            }
            // Markdown escapes punctuation, as in `move\_hand()`; Python escapes quotes.
            _ if next.is_ascii_punctuation() || QUOTES.iter().any(|(open, _)| rest.starts_with(open)) => {
                self.at += 1 + next.len_utf8();
                Ok(Some(next))
            }
            _ => malformed(format!("`\\{}` is no escape", next.escape_debug())),
        }
    }

    /// Parses `\u` with four hexadecimal digits, or a surrogate pair of two such escapes.
    fn utf16(&mut self) -> Parsed<char> {
        let first = self.hexadecimal(4)?;
        let code = if (0xd800..0xdc00).contains(&first) {
            let rest = self.rest();
            if rest.is_empty() || rest == "\\" {
                return Err(FaultReason::CutOff);
            }
            if !rest.starts_with("\\u") {
                return malformed("half a character: a second `\\u` must follow");
            }
            let second = self.hexadecimal(4)?;
            if !(0xdc00..0xe000).contains(&second) {
                return malformed("half a character: the second `\\u` does not fit the first");
            }
            0x10000 + ((first - 0xd800) << 10) + (second - 0xdc00)
        } else {
            first
        };
        char::from_u32(code).map_or_else(|| malformed("`\\u` names no character"), Ok)
    }

    fn code_point(&mut self, digits: usize) -> Parsed<char> {
        let code = self.hexadecimal(digits)?;
        char::from_u32(code).map_or_else(|| malformed("the escape names no character"), Ok)
    }

    /// Parses the hexadecimal number after a backslash and a letter.
    fn hexadecimal(&mut self, digits: usize) -> Parsed<u32> {
        let rest = &self.rest()[2..];
        let found: String = rest.chars().take(digits).take_while(char::is_ascii_hexdigit).collect();
        match u32::from_str_radix(&found, 16) {
            Ok(code) if found.len() == digits => {
                self.at += 2 + digits;
                Ok(code)
            }
            _ if found.len() == rest.len() => Err(FaultReason::CutOff),
            _ => malformed(format!("expected {digits} hexadecimal digits after the backslash")),
        }
    }
}
