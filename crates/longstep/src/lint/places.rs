//! Where in its files a domain says what.

use toml::Spanned;

use crate::diagnostic::Position;
use crate::model::Files;
use crate::model::content_position;
use crate::model::sexpr::{self, Expression};
use crate::model::words::DomainFile;

/// A place in one of a domain's files.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place<'a> {
    pub(super) file: &'a str,
    pub(super) position: Position,
}

/// The files once more, as they are written: a [`crate::model::Domain`] keeps no places.
pub(super) struct Places<'a> {
    pddl_file: String,
    words_file: String,
    examples_file: String,
    words_text: &'a str,
    sections: Vec<Expression>,
    /// The entries of `domain.toml`; those of states, rules and goals are in the order of the domain's lists.
    pub(super) words: DomainFile,
}

impl<'a> Places<'a> {
    /// None if the files do not read.
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

    /// The place of a text of `domain.toml`.
    pub(super) fn word<T>(&self, text: &Spanned<T>) -> Place<'_> {
        Place {
            file: &self.words_file,
            position: content_position(self.words_text, text),
        }
    }

    /// The beginning of `prompt/examples.toml`.
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

    /// Where a type is declared.
    pub(super) fn kind(&self, name: &str) -> Place<'_> {
        let mut declared = self.of(":types").flatten();
        self.pddl(
            declared
                .find(|item| item.word() == Some(name))
                .map(|item| item.position),
        )
    }

    /// Where a predicate is declared.
    pub(super) fn predicate(&self, name: &str) -> Place<'_> {
        let mut heads = self.of(":predicates").flatten().filter_map(|item| item.list()?.first());
        self.pddl(heads.find(|head| head.word() == Some(name)).map(|head| head.position))
    }

    /// Where an action is declared.
    pub(super) fn action(&self, name: &str) -> Place<'_> {
        let mut heads = self.of(":action").filter_map(<[Expression]>::first);
        self.pddl(heads.find(|head| head.word() == Some(name)).map(|head| head.position))
    }

    /// Where the `part` of an action (`:parameters`, `:precondition`, `:effect`) first writes `word`, else where the
    /// action is declared.
    pub(super) fn within_action(&self, action: &str, part: &str, word: &str) -> Place<'_> {
        let named = |items: &&[Expression]| items.first().is_some_and(|name| name.word() == Some(action));
        let fields = self.of(":action").find(named);
        let part = fields.and_then(|fields| fields.iter().skip_while(|field| field.word() != Some(part)).nth(1));
        match part.and_then(|part| first(part, word)) {
            Some(position) => self.pddl(Some(position)),
            None => self.action(action),
        }
    }

    /// Where `domain.toml` names an action's call, else where the action is declared.
    pub(super) fn call(&self, action: &str) -> Place<'_> {
        let entry = self.words.action.iter().find(|entry| entry.name.get_ref() == action);
        entry.map_or_else(|| self.action(action), |entry| self.word(&entry.call))
    }
}

/// The first place of a word: for a list that begins with it, the place of the list.
fn first(expression: &Expression, word: &str) -> Option<Position> {
    match expression.list() {
        Some(items) if items.first().is_some_and(|head| head.word() == Some(word)) => Some(expression.position),
        Some(items) => items.iter().find_map(|item| first(item, word)),
        None => (expression.word() == Some(word)).then_some(expression.position),
    }
}
