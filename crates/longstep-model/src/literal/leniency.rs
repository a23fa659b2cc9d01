//! Leniencies: deviations from the plan format that the reader accepts.

use crate::diagnostic::Position;
use crate::json::Path;

/// A deviation from the plan format that the reader accepted.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Leniency {
    /// The kind of deviation.
    pub kind: LeniencyKind,
    /// Position of the first occurrence.
    pub position: Position,
    /// Number of occurrences; always 1 for a deviation with a path.
    pub times: usize,
    /// The key that the deviation is about, if any.
    pub path: Option<Path>,
}

/// The kinds of accepted deviations.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[non_exhaustive]
pub enum LeniencyKind {
    /// A notation other than the paper's JSON and scripts.
    Notation(&'static str),
    /// Quotes around the whole reply.
    Quoted,
    /// Thoughts before the answer, which were not read.
    Thoughts,
    /// A byte order mark, or whitespace that JSON does not allow.
    OddSpace,
    /// A Markdown code block around the plan.
    CodeFence,
    /// Prose before or after the plan.
    Prose,
    /// An assignment of the plan to a variable.
    Assignment,
    /// An object that is not a plan.
    OtherObject,
    /// A second copy of the plan.
    RepeatedPlan,
    /// A comment inside the plan.
    Comment,
    /// A comma after the last item of a list or object.
    TrailingComma,
    /// A string in `'single quotes'`.
    SingleQuotes,
    /// A string in “typographic” quotes.
    TypographicQuotes,
    /// A string in `"""triple quotes"""`.
    TripleQuotes,
    /// An unescaped apostrophe in a string that is delimited by apostrophes.
    Apostrophe,
    /// Adjacent string literals, joined as in Python.
    JoinedTexts,
    /// An unescaped line break or control character in a string.
    RawControl,
    /// An escape sequence that JSON does not have.
    Escape,
    /// A key without quotes.
    UnquotedKey,
    /// `True`, `False` or `None`.
    PythonWord,
    /// A tuple `(a, b)` in place of a list.
    Tuple,
    /// Parentheses around a value.
    Parentheses,
    /// An unknown key, ignored.
    ExtraKey,
    /// A repeated key with an equal value.
    RepeatedKey,
    /// A missing key, read as empty.
    MissingKey,
    /// A `null` value in place of an absent key.
    Null,
    /// Extra levels: the expected value stands under additional keys.
    Wrapped,
    /// The fields of `task_cohesion` without the enclosing `task_cohesion`.
    Flattened,
    /// A check of a fact before a step, which verification makes by itself.
    Check,
}

impl Leniency {
    /// One sentence for the user, with the position.
    pub fn message(&self) -> String {
        use LeniencyKind as Kind;
        let key = self.path.as_ref().map(ToString::to_string).unwrap_or_default();
        let what = match self.kind {
            Kind::Notation(name) => format!("the plan was read as {name}"),
            Kind::Quoted => "the reply stands in quotes".to_owned(),
            Kind::Thoughts => "the thoughts before the answer were ignored".to_owned(),
            Kind::OddSpace => "a byte order mark or unusual space was skipped".to_owned(),
            Kind::CodeFence => "the plan stands in a code block".to_owned(),
            Kind::Prose => "words around the plan were ignored".to_owned(),
            Kind::Assignment => "the plan is assigned to a name".to_owned(),
            Kind::OtherObject => "an object that is no plan was ignored".to_owned(),
            Kind::RepeatedPlan => "the same plan stands there again".to_owned(),
            Kind::Comment => "a comment was skipped".to_owned(),
            Kind::TrailingComma => "a comma follows the last item".to_owned(),
            Kind::SingleQuotes => "a text stands in single quotes".to_owned(),
            Kind::TypographicQuotes => "a text stands in typographic quotes".to_owned(),
            Kind::TripleQuotes => "a text stands in triple quotes".to_owned(),
            Kind::Apostrophe => "an apostrophe is not escaped".to_owned(),
            Kind::JoinedTexts => "texts without a comma between them were joined".to_owned(),
            Kind::RawControl => "a line break or control character in a text is not escaped".to_owned(),
            Kind::Escape => "an escape is not one of JSON's".to_owned(),
            Kind::UnquotedKey => "a key is not in quotes".to_owned(),
            Kind::PythonWord => "a value is written the Python way".to_owned(),
            Kind::Tuple => "a list is written as a tuple".to_owned(),
            Kind::Parentheses => "a value stands in parentheses".to_owned(),
            Kind::ExtraKey => format!("`{key}` is no key of a plan and was ignored"),
            Kind::RepeatedKey => format!("`{key}` stands there again with the same value"),
            Kind::MissingKey => format!("`{key}` is missing and was taken as empty"),
            Kind::Null => format!("`{key}` is null and was taken as absent"),
            Kind::Wrapped => format!("what was expected stands deeper, under `{key}`"),
            Kind::Check => {
                "a check before a step was ignored: verification checks the preconditions of all steps".to_owned()
            }
            Kind::Flattened => "the fields of `task_cohesion` stand outside of it".to_owned(),
        };
        let Position { line, column } = self.position;
        match self.times {
            1 => format!("line {line}, column {column}: {what}"),
            times => format!("line {line}, column {column}: {what} ({times} times)"),
        }
    }
}

/// The leniencies of a reply during parsing, by byte offset.
#[derive(Debug, Default)]
pub struct Notes(Vec<Note>);

#[derive(Debug)]
struct Note {
    kind: LeniencyKind,
    at: usize,
    path: Option<Path>,
}

impl Notes {
    /// Adds a deviation at a byte offset.
    pub fn add(&mut self, kind: LeniencyKind, at: usize) {
        self.0.push(Note { kind, at, path: None });
    }

    /// Adds a deviation at a byte offset about the value at `path`.
    pub fn add_about(&mut self, kind: LeniencyKind, at: usize, path: Path) {
        let path = Some(path);
        self.0.push(Note { kind, at, path });
    }

    /// Returns true if there is a deviation of this kind.
    pub fn contain(&self, kind: LeniencyKind) -> bool {
        self.0.iter().any(|note| note.kind == kind)
    }

    /// Iterates over the notations that were noted.
    pub fn notations(&self) -> impl Iterator<Item = &'static str> {
        self.0.iter().filter_map(|note| match note.kind {
            LeniencyKind::Notation(name) => Some(name),
            _ => None,
        })
    }

    /// Adds all deviations of another list.
    pub fn append(&mut self, mut other: Self) {
        self.0.append(&mut other.0);
    }

    /// Returns the leniencies in text order; occurrences of one kind are merged at the first position.
    pub fn into_leniencies(mut self, text: &str) -> Vec<Leniency> {
        self.0.sort_by_key(|note| (note.kind, note.at));
        let mut merged: Vec<(Note, usize)> = Vec::new();
        for note in self.0 {
            match merged.last_mut() {
                Some((last, times)) if last.kind == note.kind && note.path.is_none() => *times += 1,
                _ => merged.push((note, 1)),
            }
        }
        merged.sort_by_key(|(note, _)| note.at);
        // One pass over the text for all positions: counting from the start for each would take quadratic time.
        let mut position = Position { line: 1, column: 1 };
        let mut counted = 0;
        let leniency = |(note, times): (Note, usize)| {
            for character in text[counted..note.at].chars() {
                if character == '\n' {
                    position.line += 1;
                    position.column = 1;
                } else {
                    position.column += 1;
                }
            }
            counted = note.at;
            Leniency {
                kind: note.kind,
                position,
                times,
                path: note.path,
            }
        };
        merged.into_iter().map(leniency).collect()
    }
}
