//! Literals as people and models write them: JSON, Python, or a mix of both, with the deviations that were accepted.
//!
//! No existing crate fits. `jsonc-parser` and `json5` accept comments and trailing commas, but no Python (`#`, `None`,
//! tuples, triple quotes, `'the robot's hand'`). They do not list the deviations they accept, and do not distinguish a
//! truncated object from a malformed one. The reader of replies needs all three.
//!
//! The parser never reads text again after a failure, so the number of visits to each byte is bounded.

mod leniency;
mod parser;
mod quoted;

pub use leniency::{Leniency, LeniencyKind, Notes};
pub use parser::{FENCE, FaultReason};

use crate::json::Path;
use LeniencyKind as Kind;
use parser::{Parsed, Parser, malformed};
use quoted::is_quote;

/// Maximum nesting depth of brackets. A sequential plan needs four, a tree two for each level.
pub const DEEPEST: usize = 120;

/// A value with its byte offset; equality compares only the values.
#[derive(Debug)]
pub struct ValueNode {
    /// Byte offset of the value.
    pub at: usize,
    /// The value.
    pub value: LiteralValue,
}

impl PartialEq for ValueNode {
    fn eq(&self, other: &Self) -> bool {
        self.value == other.value
    }
}

/// A value. Plans contain no numeric data, so a number is kept as text.
#[derive(Debug, PartialEq)]
pub enum LiteralValue {
    /// `null` or `None`.
    Null,
    /// `true`, `True`, `false` or `False`.
    Bool(bool),
    /// A number as it is written.
    Number(String),
    /// A string without its quotes and escapes.
    Text(String),
    /// A list or a tuple.
    List(Vec<ValueNode>),
    /// An object or a dictionary, in the order of its keys.
    Object(Vec<Member>),
}

/// A key with its value.
#[derive(Debug)]
pub struct Member {
    /// Byte offset of the key.
    pub at: usize,
    /// The key.
    pub key: String,
    /// The value of the key.
    pub node: ValueNode,
}

impl PartialEq for Member {
    fn eq(&self, other: &Self) -> bool {
        self.key == other.key && self.node == other.node
    }
}

/// A completely parsed object.
#[derive(Debug)]
pub struct ParsedLiteral {
    /// The object, or another value where the text is one.
    pub node: ValueNode,
    /// Byte offset after the closing brace.
    pub end: usize,
    /// The deviations that were accepted.
    pub notes: Notes,
}

impl ParsedLiteral {
    /// Creates a literal of a value that another reader read.
    pub fn of_node(node: ValueNode, notes: Notes) -> Self {
        let end = node.at;
        Self { node, end, notes }
    }
}

/// A parse failure.
#[derive(Debug)]
pub struct Fault {
    /// Byte offset where parsing stopped.
    pub at: usize,
    /// The cause.
    pub reason: FaultReason,
    /// True if the object has a key that only plans have.
    pub of_plan: bool,
}

/// Parses the object or list whose opening bracket is at byte `start`.
pub fn bracketed(text: &str, start: usize) -> Result<ParsedLiteral, Fault> {
    let mut parser = Parser::new(text, start);
    match parser.value() {
        Ok(node) => Ok(ParsedLiteral {
            node,
            end: parser.at,
            notes: parser.notes,
        }),
        Err(reason) => Err(Fault {
            at: parser.at,
            reason,
            of_plan: parser.of_plan,
        }),
    }
}

/// Parses a text that is one value, with comments and an assignment to a name around it.
pub fn whole(text: &str) -> Result<ParsedLiteral, Fault> {
    let mut comments = Parser::new(text, 0);
    // An empty text fails below.
    let _ = comments.peek();
    let begin = comments.rest();
    let name = begin.trim_start_matches(|c: char| c.is_alphanumeric() || c == '_');
    let assigned = name.trim_start().strip_prefix('=').filter(|_| name.len() < begin.len());
    let literal = bracketed(text, text.len() - assigned.unwrap_or(begin).len())?;
    let mut behind = Parser::new(text, literal.end);
    // Behind the value, the end of the text is no mistake.
    if behind.peek().is_ok() || behind.at < text.len() {
        return Err(Fault {
            at: behind.at,
            reason: FaultReason::Malformed("expected the end of the text".to_owned()),
            of_plan: false,
        });
    }
    Ok(literal)
}

/// Converts a value to JSON.
///
/// # Errors
///
/// The path of a key that stands there twice.
pub fn json(node: &ValueNode, path: &Path) -> Result<serde_json::Value, Path> {
    Ok(match &node.value {
        LiteralValue::Null => serde_json::Value::Null,
        LiteralValue::Bool(value) => serde_json::Value::Bool(*value),
        LiteralValue::Number(digits) => serde_json::from_str(digits).unwrap_or(serde_json::Value::Null),
        LiteralValue::Text(text) => serde_json::Value::String(text.clone()),
        LiteralValue::List(items) => {
            let items = items.iter().enumerate();
            let items = items.map(|(index, item)| json(item, &path.index(index)));
            serde_json::Value::Array(items.collect::<Result<_, _>>()?)
        }
        LiteralValue::Object(entries) => {
            let mut object = serde_json::Map::new();
            for Member { key, node, .. } in entries {
                let path = path.push(&shorten(key));
                if object.insert(key.clone(), json(node, &path)?).is_some() {
                    return Err(path);
                }
            }
            serde_json::Value::Object(object)
        }
    })
}

/// Keys that distinguish a plan from other objects in a reply.
pub const PLAN_KEYS: [&str; 9] = [
    "task_cohesion",
    "task_sequence",
    "task_tree",
    "python_script",
    "step_instructions",
    "environment_before",
    "environment_after",
    "instruction_summary",
    "question",
];

impl Parser<'_> {
    fn value(&mut self) -> Parsed<ValueNode> {
        let next = self.peek()?;
        let at = self.at;
        let value = match next {
            '{' => LiteralValue::Object(self.nested(Self::members)?),
            '[' => LiteralValue::List(self.nested(|parser| Ok(parser.items(']')?.0))?),
            '(' => self.nested(Self::parenthesised)?,
            '-' | '0'..='9' => LiteralValue::Number(self.number()?),
            _ if is_quote(self.rest()) => LiteralValue::Text(self.texts()?),
            _ => self.bare_word(next)?,
        };
        Ok(ValueNode { at, value })
    }

    /// Parses the content after an opening bracket, within the depth limit.
    fn nested<T>(&mut self, read: impl FnOnce(&mut Self) -> Parsed<T>) -> Parsed<T> {
        if self.depth == DEEPEST {
            return Err(FaultReason::TooDeep);
        }
        self.at += 1;
        self.depth += 1;
        let inside = read(self)?;
        self.depth -= 1;
        Ok(inside)
    }

    fn members(&mut self) -> Parsed<Vec<Member>> {
        let mut members = Vec::new();
        while !self.closed('}', !members.is_empty())? {
            let at = self.at;
            let key = self.key()?;
            self.of_plan |= PLAN_KEYS.contains(&key.as_str());
            if self.peek()? != ':' {
                return malformed("expected `:` after the key");
            }
            self.at += 1;
            let node = self.value()?;
            members.push(Member { at, key, node });
            if !self.comma('}')? {
                break;
            }
        }
        Ok(members)
    }

    /// Parses items up to the closing bracket; the flag is true if there was a comma.
    fn items(&mut self, close: char) -> Parsed<(Vec<ValueNode>, bool)> {
        let mut items = Vec::new();
        let mut commas = false;
        while !self.closed(close, commas && close != ')')? {
            items.push(self.value()?);
            if !self.comma(close)? {
                break;
            }
            commas = true;
        }
        Ok((items, commas))
    }

    /// Consumes the closing bracket if it is next.
    fn closed(&mut self, close: char, after_comma: bool) -> Parsed<bool> {
        let closed = self.peek()? == close;
        if closed {
            if after_comma {
                self.note(Kind::TrailingComma);
            }
            self.at += 1;
        }
        Ok(closed)
    }

    /// Consumes the comma or closing bracket after an item; returns true for a comma.
    fn comma(&mut self, close: char) -> Parsed<bool> {
        let next = self.peek()?;
        if next != ',' && next != close {
            return malformed(format!("expected `,` or `{close}`, found `{next}`"));
        }
        self.at += 1;
        Ok(next == ',')
    }

    /// Parses a tuple, `(a, b)`, `(a,)` or `()`, or a parenthesized value, `(a)`.
    fn parenthesised(&mut self) -> Parsed<LiteralValue> {
        let at = self.at - 1;
        let (mut items, commas) = self.items(')')?;
        match items.pop() {
            Some(only) if items.is_empty() && !commas => {
                self.notes.add(Kind::Parentheses, at);
                Ok(only.value)
            }
            last => {
                self.notes.add(Kind::Tuple, at);
                items.extend(last);
                Ok(LiteralValue::List(items))
            }
        }
    }

    fn key(&mut self) -> Parsed<String> {
        if is_quote(self.rest()) {
            // Keys must not contain line breaks, so that a stray brace in prose affects only its own line.
            return self.quoted(false);
        }
        let rest = self.rest();
        let length = word_length(rest);
        if length == 0 {
            return malformed(format!("expected a key, found `{}`", self.peek()?));
        }
        self.note(Kind::UnquotedKey);
        self.at += length;
        Ok(rest[..length].to_owned())
    }

    fn number(&mut self) -> Parsed<String> {
        let rest = self.rest();
        let inside = |c: char| c.is_ascii_alphanumeric() || matches!(c, '+' | '-' | '.' | '_');
        let length = rest.find(|c| !inside(c)).ok_or(FaultReason::CutOff)?;
        let number = &rest[..length];
        if !is_json_number(number) {
            return malformed(format!("`{}` is not a number", shorten(number)));
        }
        self.at += length;
        Ok(number.to_owned())
    }

    fn bare_word(&mut self, next: char) -> Parsed<LiteralValue> {
        let rest = self.rest();
        let length = word_length(rest);
        let word = &rest[..length];
        if length == rest.len() {
            return Err(FaultReason::CutOff);
        }
        let (value, python) = match word {
            "null" => (LiteralValue::Null, false),
            "true" => (LiteralValue::Bool(true), false),
            "false" => (LiteralValue::Bool(false), false),
            "None" => (LiteralValue::Null, true),
            "True" => (LiteralValue::Bool(true), true),
            "False" => (LiteralValue::Bool(false), true),
            "" if rest.starts_with("...") => return malformed("`...` stands for something that was left out"),
            "" => return malformed(format!("expected a value, found `{next}`")),
            _ => return malformed(format!("`{}` is not in quotes", shorten(word))),
        };
        if python {
            self.note(Kind::PythonWord);
        }
        self.at += length;
        Ok(value)
    }
}

/// Returns the length of the word at the start of `rest`; a word does not begin with a digit.
fn word_length(rest: &str) -> usize {
    if rest.starts_with(|c: char| c.is_ascii_digit()) {
        return 0;
    }
    let inside = |c: char| c.is_alphanumeric() || matches!(c, '_' | '$');
    rest.find(|c| !inside(c)).unwrap_or(rest.len())
}

/// Returns true if `text` is a JSON number.
fn is_json_number(text: &str) -> bool {
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|b| b.is_ascii_digit());
    let unsigned = text.strip_prefix('-').unwrap_or(text);
    let (mantissa, exponent) = match unsigned.split_once(['e', 'E']) {
        Some((mantissa, exponent)) => (mantissa, exponent.strip_prefix(['+', '-']).unwrap_or(exponent)),
        None => (unsigned, "0"),
    };
    let (whole, fraction) = mantissa.split_once('.').unwrap_or((mantissa, "0"));
    digits(whole) && digits(fraction) && digits(exponent) && (whole == "0" || !whole.starts_with('0'))
}

/// Limits the length of a word in messages, since the reply is untrusted input.
pub fn shorten(word: &str) -> String {
    const SHOWN: usize = 60;
    match word.char_indices().nth(SHOWN) {
        Some((end, _)) => format!("{}…", &word[..end]),
        None => word.to_owned(),
    }
}
