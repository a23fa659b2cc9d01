//! Sentences of an author: words, and the kinds of things that they speak of.

/// The way in which a sentence speaks of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Which {
    One,
    Other,
    Any,
}

/// A part of a sentence.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Piece {
    Word(String),
    /// A kind by its index, or a thing of the example environment.
    Kind(usize, Which),
    Thing(usize, String),
}

/// A sentence, or its opposite.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Sentence {
    pub(super) pieces: Vec<Piece>,
    pub(super) holds: bool,
}

/// A predicate: the words of its sentence, and the kinds in it.
pub(super) struct Pattern {
    pub(super) key: String,
    pub(super) name: String,
    pub(super) kinds: Vec<usize>,
    pub(super) pieces: Vec<Piece>,
}

/// Returns the kinds of a sentence, in order.
pub(super) fn kinds_of(sentence: &Sentence) -> Vec<(usize, Which)> {
    let kinds = sentence.pieces.iter().filter_map(|piece| match piece {
        Piece::Kind(kind, which) => Some((*kind, *which)),
        _ => None,
    });
    kinds.collect()
}

/// Returns the words of a sentence in lower case, without punctuation.
pub(super) fn plain(text: &str) -> Vec<String> {
    let words = text.split_whitespace().map(|word| {
        let inner = word.trim_matches(|c: char| !c.is_alphanumeric());
        inner.to_lowercase()
    });
    words.filter(|word| !word.is_empty()).collect()
}

/// Removes an article before the name of a thing.
pub(super) fn pop_article(pieces: &mut Vec<Piece>) {
    if matches!(pieces.last(), Some(Piece::Word(word)) if matches!(word.as_str(), "the" | "a" | "an")) {
        pieces.pop();
    }
}

/// Removes the words before a kind that say which thing is meant.
pub(super) fn pop_determiner(pieces: &mut Vec<Piece>, holds: &mut bool) -> Which {
    let mut which = Which::One;
    while let Some(Piece::Word(word)) = pieces.last() {
        match word.as_str() {
            "the" | "a" | "an" => {}
            "another" | "other" | "second" => which = Which::Other,
            "any" | "every" | "all" => which = Which::Any,
            "no" => {
                which = Which::Any;
                *holds = !*holds;
            }
            _ => break,
        }
        pieces.pop();
    }
    which
}
