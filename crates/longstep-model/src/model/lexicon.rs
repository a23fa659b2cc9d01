//! Everyday names for identifiers, and the rules of English needed to match them.

use indexmap::IndexMap;

use super::label::{base_name, is_label, split_label, stem, without_brackets};
use crate::visible;

/// Everyday names by identifier, without angle brackets and number. The first name is displayed, the second, longer one
/// distinguishes entities that share the first, and the others are synonyms.
#[derive(Debug, Clone, Default)]
pub struct Lexicon {
    entries: IndexMap<String, Vec<String>>,
}

impl Lexicon {
    pub(crate) fn new(entries: IndexMap<String, Vec<String>>) -> Self {
        Self { entries }
    }

    /// Returns the names of an identifier: those of its entry, the cleaned identifier, and the latter without its label.
    /// The first one is displayed. The entry of the whole identifier (`vitamin_c`) precedes the one without its label.
    ///
    /// ```
    /// let domain = longstep_model::domain::shipped("household").unwrap().unwrap();
    /// assert_eq!(domain.lexicon.names("<shelf_top>").last().unwrap(), "shelf top");
    /// ```
    pub fn names(&self, identifier: &str) -> Vec<String> {
        let entry = self.entries.get(&base_name(identifier));
        let entry = entry.or_else(|| self.entries.get(&stem(identifier)));
        let mut names = entry.cloned().unwrap_or_default();
        for name in [cleaned(identifier), plain_words(split_label(identifier).0).join(" ")] {
            if !name.is_empty() && !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }
}

/// Returns an identifier as words: `<shelf_top>` is "shelf top", `<table2>` is "table 2". A number after an underscore
/// is an id and is removed; a number directly after letters is part of the name. A letter that is a label keeps its case:
/// `<tube_A>` is "tube A".
fn cleaned(identifier: &str) -> String {
    let bare = without_brackets(identifier);
    let without_id = match bare.rsplit_once('_') {
        Some((name, id)) if !name.is_empty() && id.chars().all(|c| c.is_ascii_digit()) => name,
        _ => bare,
    };
    let (stem, label) = split_label(without_id);
    let mut words = plain_words(stem);
    words.extend(split_words(label.chars()));
    // An identifier without letters and digits still needs a name.
    if words.is_empty() {
        "thing".to_owned()
    } else {
        words.join(" ")
    }
}

/// Splits a text into lower-case words, with letters and digits apart: `Put it on table2!` is put, it, on, table, 2.
pub fn plain_words(text: &str) -> Vec<String> {
    split_words(text.chars().flat_map(char::to_lowercase))
}

fn split_words(text: impl Iterator<Item = char>) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for character in text {
        if is_mark(character) && last.is_alphanumeric() {
            words.last_mut().into_iter().for_each(|word| word.push(character));
            continue;
        }
        let joins = character.is_alphanumeric()
            && last.is_alphanumeric()
            && character.is_ascii_digit() == last.is_ascii_digit();
        match words.last_mut() {
            Some(word) if joins => word.push(character),
            _ if character.is_alphanumeric() => words.push(character.to_string()),
            _ => {}
        }
        // An apostrophe is part of its word: "let's" is one word.
        last = if character == '\'' || character == '\u{2019}' {
            last
        } else {
            character
        };
    }
    words
}

/// Returns true for a combining mark that is no letter, such as the virama in हिन्दी or the dot over the lower case of İ. It
/// belongs to the letter before it.
///
/// The standard library has no such test, but `escape_debug` escapes exactly these characters beside those that are not
/// visible.
pub(crate) fn is_mark(character: char) -> bool {
    !character.is_ascii()
        && !character.is_alphanumeric()
        && !character.is_whitespace()
        && !visible::is_hidden(character)
        && character.escape_debug().len() > 1
}

/// Returns the head noun of a name, in the singular: "glass" of "water glass 2", "bunch" of "bunch of bananas".
pub fn head(name: &str) -> String {
    let words = plain_words(name);
    let end = words.iter().position(|word| word == "of").unwrap_or(words.len());
    let digit = |word: &String| word.starts_with(|c: char| c.is_ascii_digit());
    let is_noun = |(index, word): &(usize, &String)| !digit(word) && (*index == 0 || !is_label(word));
    let mut nouns = words[..end].iter().enumerate().filter(is_noun).map(|(_, word)| word);
    let head = nouns.next_back().or(words.last());
    head.map(|word| singular(word)).unwrap_or_default()
}

/// Returns the singular of an English noun by simple rules, and other words unchanged.
///
/// ```
/// use longstep_model::domain::singular;
/// assert_eq!(singular("glasses"), "glass");
/// assert_eq!(singular("shelves"), "shelf");
/// assert_eq!(singular("knives"), "knife");
/// assert_eq!(singular("plates"), "plate");
/// assert_eq!(singular("glass"), "glass");
/// ```
pub fn singular(word: &str) -> String {
    for (plural, single) in [
        ("knives", "knife"),
        ("lives", "life"),
        ("leaves", "leaf"),
        ("ves", "f"),
        ("ies", "y"),
        ("sses", "ss"),
        ("shes", "sh"),
        ("ches", "ch"),
        ("xes", "x"),
        ("toes", "to"),
        ("ss", "ss"),
        ("us", "us"),
        ("s", ""),
    ] {
        if let Some(stem) = word.strip_suffix(plural)
            && (stem.len() + single.len() >= 2 && !word.is_empty())
        {
            return format!("{stem}{single}");
        }
    }
    word.to_owned()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifiers_become_words() {
        for (identifier, words, base) in [
            ("<shelf_top>", "shelf top", "shelf_top"),
            ("<plate_274>", "plate", "plate"),
            ("<table2>", "table 2", "table"),
            ("<Trash_Bin>", "trash bin", "trash_bin"),
            ("cup", "cup", "cup"),
            ("<7>", "7", "7"),
            ("<tube_A>", "tube A", "tube_a"),
            ("<tube.1>", "tube 1", "tube"),
            ("<Bay.3-A>", "bay 3 A", "bay.3-a"),
            ("<vitamin_c>", "vitamin c", "vitamin_c"),
            ("<杯子_1>", "杯子", "杯子"),
            ("<红_杯>", "红 杯", "红_杯"),
            ("<Чашка>", "чашка", "чашка"),
            ("<İstanbul>", "i\u{307}stanbul", "i\u{307}stanbul"),
            ("<कुर्सी_2>", "कुर्सी", "कुर्सी"),
        ] {
            assert_eq!(cleaned(identifier), words);
            assert_eq!(base_name(identifier), base);
        }
    }

    #[test]
    fn head_noun_excludes_a_trailing_label() {
        for (name, noun) in [
            ("tube A", "tube"),
            ("pallet 2", "pallet"),
            ("vitamin c", "vitamin"),
            ("a", "a"),
            ("7", "7"),
        ] {
            assert_eq!(head(name), noun);
        }
    }

    #[test]
    fn words_are_split_at_digits_and_signs() {
        let words = plain_words("Let's put it on table2!");
        assert_eq!(words, ["lets", "put", "it", "on", "table", "2"]);
    }
}
