//! S-expressions, the syntax of PDDL, with the position of every part.

use crate::diagnostic::{Diagnostic, Position};

/// A name, variable, keyword or list.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Expression {
    pub(crate) kind: ExpressionKind,
    pub position: Position,
}

#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum ExpressionKind {
    /// A word, in lower case, since PDDL ignores case.
    Word(String),
    List(Vec<Expression>),
}

impl Expression {
    /// Creates a word.
    pub(crate) fn of_word(word: &str, position: Position) -> Self {
        Self {
            kind: ExpressionKind::Word(word.to_owned()),
            position,
        }
    }

    /// Creates a list.
    pub(crate) fn of_items(items: Vec<Self>, position: Position) -> Self {
        Self {
            kind: ExpressionKind::List(items),
            position,
        }
    }

    pub fn word(&self) -> Option<&str> {
        match &self.kind {
            ExpressionKind::Word(word) => Some(word),
            ExpressionKind::List(_) => None,
        }
    }

    pub fn list(&self) -> Option<&[Expression]> {
        match &self.kind {
            ExpressionKind::List(items) => Some(items),
            ExpressionKind::Word(_) => None,
        }
    }

    /// Returns true if two expressions are equal, wherever they stand.
    pub(crate) fn is_same(&self, other: &Self) -> bool {
        match (&self.kind, &other.kind) {
            (ExpressionKind::Word(own), ExpressionKind::Word(other)) => own == other,
            (ExpressionKind::List(own), ExpressionKind::List(other)) => {
                own.len() == other.len() && own.iter().zip(other).all(|(own, other)| own.is_same(other))
            }
            _ => false,
        }
    }

    /// Returns the items of a list after its first word, if that word is `head`.
    pub fn tail_of(&self, head: &str) -> Option<&[Expression]> {
        match self.list()? {
            [first, rest @ ..] if first.word() == Some(head) => Some(rest),
            _ => None,
        }
    }
}

/// The maximal depth of nested lists, so that a hostile file cannot exhaust the stack.
const DEPTH_LIMIT: usize = 200;

/// Parses all expressions of `text`.
pub fn read(file: &str, text: &str) -> Result<Vec<Expression>, Diagnostic> {
    let mut open: Vec<(Position, Vec<Expression>)> = Vec::new();
    let mut done = Vec::new();
    let mut position = Position { line: 1, column: 1 };
    let mut characters = text.chars().peekable();
    while let Some(character) = characters.next() {
        let here = position;
        advance(&mut position, character);
        let finished = match character {
            ';' => {
                while let Some(skipped) = characters.next_if(|c| *c != '\n') {
                    advance(&mut position, skipped);
                }
                continue;
            }
            '(' if open.len() == DEPTH_LIMIT => {
                let message = format!("lists are nested more than {DEPTH_LIMIT} deep");
                return Err(Diagnostic::at(file, here, message));
            }
            '(' => {
                open.push((here, Vec::new()));
                continue;
            }
            ')' => match open.pop() {
                Some((start, items)) => Expression {
                    kind: ExpressionKind::List(items),
                    position: start,
                },
                None => {
                    return Err(Diagnostic::at(file, here, "`)` closes nothing")
                        .hint("remove it, or open the list that it should close"));
                }
            },
            c if c.is_whitespace() => continue,
            c => {
                let mut word = String::from(c);
                while let Some(next) = characters.next_if(|c| !c.is_whitespace() && !matches!(c, '(' | ')' | ';')) {
                    advance(&mut position, next);
                    word.push(next);
                }
                Expression {
                    kind: ExpressionKind::Word(word.to_lowercase()),
                    position: here,
                }
            }
        };
        match open.last_mut() {
            Some((_, items)) => items.push(finished),
            None => done.push(finished),
        }
    }
    match open.pop() {
        Some((start, _)) => Err(Diagnostic::at(file, start, "this `(` is never closed").hint("add the missing `)`")),
        None => Ok(done),
    }
}

fn advance(position: &mut Position, character: char) {
    if character == '\n' {
        position.line += 1;
        position.column = 1;
    } else {
        position.column += 1;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check_error(text: &str, expected: &str) {
        assert_eq!(read("d.pddl", text).unwrap_err().to_string(), expected);
    }

    #[test]
    fn words_are_lower_case_and_comments_are_skipped() {
        let read = read("d.pddl", "(Define ; a note (\n (X))").unwrap();
        assert_eq!(
            read[0].tail_of("define").unwrap()[0].list().unwrap()[0].word(),
            Some("x")
        );
        assert_eq!(read[0].list().unwrap()[1].position, Position { line: 2, column: 2 });
    }

    #[test]
    fn unbalanced_lists_are_told_with_their_place() {
        check_error(
            "(a\n  (b)",
            "d.pddl:1:1: this `(` is never closed\n  hint: add the missing `)`",
        );
        check_error(
            "(a))",
            "d.pddl:1:4: `)` closes nothing\n  hint: remove it, or open the list that it should close",
        );
    }

    #[test]
    fn deep_nesting_is_refused() {
        assert!(read("d.pddl", &"(".repeat(100_000)).is_err());
    }
}
