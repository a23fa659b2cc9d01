//! Positions of values in a JSON text.

use std::cell::OnceCell;
use std::fmt;

use jsonc_parser::ast::Value;
use jsonc_parser::common::Ranged;
use jsonc_parser::{CollectOptions, ParseOptions, parse_to_ast};

use crate::diagnostic::Position;

/// The path to a value: keys and indexes.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Path(Vec<Segment>);

#[derive(Debug, Clone, PartialEq, Eq)]
enum Segment {
    Key(String),
    Index(usize),
}

impl Path {
    /// The path to a key of the outermost object.
    pub fn key(key: &str) -> Self {
        Self::default().push(key)
    }

    /// Returns the path extended by a key.
    #[must_use]
    pub fn push(&self, key: &str) -> Self {
        let mut path = self.clone();
        path.0.push(Segment::Key(key.to_owned()));
        path
    }

    /// Returns the path extended by an index.
    #[must_use]
    pub fn index(&self, index: usize) -> Self {
        let mut path = self.clone();
        path.0.push(Segment::Index(index));
        path
    }

    /// Returns the concatenation of both paths.
    #[must_use]
    pub fn join(&self, other: &Self) -> Self {
        Self(self.0.iter().chain(&other.0).cloned().collect())
    }
}

impl fmt::Display for Path {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, segment) in self.0.iter().enumerate() {
            match segment {
                Segment::Key(key) if index == 0 => write!(f, "{key}")?,
                Segment::Key(key) => write!(f, ".{key}")?,
                Segment::Index(at) => write!(f, "[{at}]")?,
            }
        }
        Ok(())
    }
}

/// Returns the position at which the value at `path` begins, or that of its nearest ancestor that exists; none if
/// `text` is not JSON.
///
/// ```
/// use longstep_model::json::{Path, locate};
/// let text = "{\"objects\": [\"<cup>\",\n \"<pan>\"]}";
/// let position = locate(text, &Path::key("objects").index(1)).unwrap();
/// assert_eq!((position.line, position.column), (2, 2));
/// ```
pub fn locate(text: &str, path: &Path) -> Option<Position> {
    Locator::new(text).locate(path)
}

/// Finds the positions of several values in one text, which is parsed once.
#[derive(Debug)]
pub struct Locator<'a> {
    text: &'a str,
    parsed: OnceCell<Option<Value<'a>>>,
}

impl<'a> Locator<'a> {
    /// Creates a locator for a text, which is parsed when the first position is asked for.
    pub fn new(text: &'a str) -> Self {
        Self {
            text,
            parsed: OnceCell::new(),
        }
    }

    /// Returns the position of a value as [`locate`] does.
    pub fn locate(&self, path: &Path) -> Option<Position> {
        let parse = || parse_to_ast(self.text, &CollectOptions::default(), &ParseOptions::default());
        let mut value = self.parsed.get_or_init(|| parse().ok()?.value).as_ref()?;
        for segment in &path.0 {
            let next = match (segment, value) {
                (Segment::Key(key), Value::Object(object)) => object.get(key).map(|property| &property.value),
                (Segment::Index(index), Value::Array(array)) => array.elements.get(*index),
                _ => None,
            };
            match next {
                Some(next) => value = next,
                None => break,
            }
        }
        Some(Position::of(self.text, value.start()))
    }
}
