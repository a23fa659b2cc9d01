//! Source positions of a domain's items.

use longstep_core::spanned::Spanned;

use longstep::domain::sexpr::{self, Expression};
use longstep::domain::words::DomainFile;
use longstep::domain::{Files, content_position};
use longstep_core::diagnostic::Position;

/// A position in one of the files of a domain.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) file: &'a str,
    pub(super) position: Position,
}

/// The parsed files of a domain, since [`longstep::domain::Domain`] stores no positions.
pub(super) struct Places<'a> {
    pddl_file: String,
    words_file: String,
    examples_file: String,
    words_text: &'a str,
    sections: Vec<Expression>,
    /// Entries of `domain.toml`. States, rules and goals are in the order of the domain.
    pub(super) words: DomainFile,
}

impl<'a> Places<'a> {
    /// Parses the files. Returns none on a syntax error.
    pub(super) fn read(files: &'a Files) -> Option<Self> {
        let pddl_file = format!("{}domain.pddl", files.folder);
        let define = sexpr::read(&pddl_file, &files.pddl).ok()?.into_iter().next()?;
        Some(Self {
            sections: define.tail_of("define")?.to_vec(),
            words: toml::from_str(&files.words).ok()?,
            words_text: &files.words,
            words_file: format!("{}domain.toml", files.folder),
            examples_file: files.prompt_path("examples.toml"),
            pddl_file,
        })
    }

    /// Returns the position of a string in `domain.toml`.
    pub(super) fn word<T>(&self, text: &Spanned<T>) -> Place<'_> {
        Place {
            file: &self.words_file,
            position: content_position(self.words_text, text),
        }
    }

    /// Returns the start of `prompt/examples.toml`.
    pub(super) fn examples(&self) -> Place<'_> {
        Place {
            file: &self.examples_file,
            position: Position { line: 1, column: 1 },
        }
    }

    fn pddl(&self, found: Option<Position>) -> Place<'_> {
        Place {
            file: &self.pddl_file,
            position: found.unwrap_or(Position { line: 1, column: 1 }),
        }
    }

    fn of<'s>(&'s self, head: &'s str) -> impl Iterator<Item = &'s [Expression]> {
        self.sections.iter().filter_map(move |section| section.tail_of(head))
    }

    /// Returns the declaration of a type.
    pub(super) fn kind(&self, name: &str) -> Place<'_> {
        let mut declared = self.of(":types").flatten();
        self.pddl(
            declared
                .find(|item| item.word() == Some(name))
                .map(|item| item.position),
        )
    }

    /// Returns the declaration of a predicate.
    pub(super) fn predicate(&self, name: &str) -> Place<'_> {
        let mut heads = self.of(":predicates").flatten().filter_map(|item| item.list()?.first());
        self.pddl(heads.find(|head| head.word() == Some(name)).map(|head| head.position))
    }

    /// Returns the declaration of an action.
    pub(super) fn action(&self, name: &str) -> Place<'_> {
        let mut heads = self.of(":action").filter_map(<[Expression]>::first);
        self.pddl(heads.find(|head| head.word() == Some(name)).map(|head| head.position))
    }

    /// Returns the first occurrence of `word` in a `part` of an action (`:parameters`, `:precondition`, `:effect`),
    /// else the declaration of the action.
    pub(super) fn within_action(&self, action: &str, part: &str, word: &str) -> Place<'_> {
        let named = |items: &&[Expression]| items.first().is_some_and(|name| name.word() == Some(action));
        let fields = self.of(":action").find(named);
        let part = fields.and_then(|fields| fields.iter().skip_while(|field| field.word() != Some(part)).nth(1));
        match part.and_then(|part| first(part, word)) {
            Some(position) => self.pddl(Some(position)),
            None => self.action(action),
        }
    }

    /// Returns the entry of an action's call in `domain.toml`, else the declaration of the action.
    pub(super) fn call(&self, action: &str) -> Place<'_> {
        let entry = self.words.action.iter().find(|entry| entry.name.get_ref() == action);
        entry.map_or_else(|| self.action(action), |entry| self.word(&entry.call))
    }
}

/// Finds the first occurrence of a word. For the head of a list, this is the position of the list.
fn first(expression: &Expression, word: &str) -> Option<Position> {
    match expression.list() {
        Some(items) if items.first().is_some_and(|head| head.word() == Some(word)) => Some(expression.position),
        Some(items) => items.iter().find_map(|item| first(item, word)),
        None => (expression.word() == Some(word)).then_some(expression.position),
    }
}
