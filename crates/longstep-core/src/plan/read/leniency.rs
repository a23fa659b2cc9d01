//! What a reply got away with.

use crate::diagnostic::Position;
use crate::json::Path;

/// A liberty that a reply took with the form, and that reading it forgave.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Leniency {
    /// Which liberty.
    pub kind: LeniencyKind,
    /// Where it was taken first.
    pub position: Position,
    /// How often; one that has a path is listed by itself.
    pub times: usize,
    /// The key it is about, when it is about one.
    pub path: Option<Path>,
}

/// The liberties that are forgiven.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum LeniencyKind {
    /// A byte order mark, or space that JSON does not have.
    OddSpace,
    /// A Markdown code block around the plan.
    CodeFence,
    /// Words before or after the plan.
    Prose,
    /// A name that the plan is assigned to.
    Assignment,
    /// An object beside the plan that is no plan.
    OtherObject,
    /// The same plan once more.
    RepeatedPlan,
    /// A comment inside the plan.
    Comment,
    /// A comma after the last item.
    TrailingComma,
    /// A text in `'single quotes'`.
    SingleQuotes,
    /// A text in “typographic” quotes.
    TypographicQuotes,
    /// A text in `"""three quotes"""`.
    TripleQuotes,
    /// An apostrophe that is not escaped although it is the quote, too.
    Apostrophe,
    /// Texts side by side, joined as Python does.
    JoinedTexts,
    /// A line break or control character in a text, not escaped.
    RawControl,
    /// An escape that JSON does not have.
    Escape,
    /// A key without quotes.
    UnquotedKey,
    /// `True`, `False` or `None`.
    PythonWord,
    /// `(a, b)` for a list.
    Tuple,
    /// Parentheses around a value.
    Parentheses,
    /// A key that plans do not have, ignored.
    ExtraKey,
    /// The same key with the same value once more.
    RepeatedKey,
    /// A key that should be there; what it says is taken as empty.
    MissingKey,
    /// Nothing (`null`) where the key might have been left out.
    Null,
    /// A key around what was expected in its place.
    Wrapped,
    /// The fields of `task_cohesion` without `task_cohesion` around them.
    Flattened,
}

impl Leniency {
    /// One sentence for a person, with the place.
    pub fn message(&self) -> String {
        use LeniencyKind as Kind;
        let key = self.path.as_ref().map(ToString::to_string).unwrap_or_default();
        let what = match self.kind {
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
            Kind::Wrapped => format!("what was expected stands one level deeper, under `{key}`"),
            Kind::Flattened => "the fields of `task_cohesion` stand outside of it".to_owned(),
        };
        let Position { line, column } = self.position;
        match self.times {
            1 => format!("line {line}, column {column}: {what}"),
            times => format!("line {line}, column {column}: {what} ({times} times)"),
        }
    }
}

/// The leniencies of one reply while it is being read, by byte.
#[derive(Debug, Default)]
pub(super) struct Notes(Vec<Note>);

#[derive(Debug)]
struct Note {
    kind: LeniencyKind,
    at: usize,
    path: Option<Path>,
}

impl Notes {
    pub(super) fn add(&mut self, kind: LeniencyKind, at: usize) {
        self.0.push(Note { kind, at, path: None });
    }

    pub(super) fn add_about(&mut self, kind: LeniencyKind, at: usize, path: Path) {
        let path = Some(path);
        self.0.push(Note { kind, at, path });
    }

    pub(super) fn contain(&self, kind: LeniencyKind) -> bool {
        self.0.iter().any(|note| note.kind == kind)
    }

    pub(super) fn append(&mut self, mut other: Self) {
        self.0.append(&mut other.0);
    }

    /// In the order of the text, those of a kind together at the place of the first.
    pub(super) fn into_leniencies(mut self, text: &str) -> Vec<Leniency> {
        self.0.sort_by_key(|note| (note.kind, note.at));
        let mut merged: Vec<(Note, usize)> = Vec::new();
        for note in self.0 {
            match merged.last_mut() {
                Some((last, times)) if last.kind == note.kind && note.path.is_none() => *times += 1,
                _ => merged.push((note, 1)),
            }
        }
        merged.sort_by_key(|(note, _)| note.at);
        // One pass over the text for all places: counting from the start for each would take quadratic time.
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
