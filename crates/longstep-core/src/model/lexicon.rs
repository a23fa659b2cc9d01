//! Everyday names for identifiers, and the rules of English needed to match them.

use indexmap::IndexMap;

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

    /// Returns the names of an identifier, the displayed one first and the cleaned identifier last.
    ///
    /// ```
    /// let domain = longstep_core::domain::shipped("household").unwrap().unwrap();
    /// assert_eq!(domain.lexicon.names("<shelf_top>").last().unwrap(), "shelf top");
    /// ```
    pub fn names(&self, identifier: &str) -> Vec<String> {
        let base = base_name(identifier);
        let mut names = self.entries.get(&base).cloned().unwrap_or_default();
        let cleaned = cleaned(identifier);
        if !names.contains(&cleaned) {
            names.push(cleaned);
        }
        names
    }
}

/// Returns the identifier in lower case, without angle brackets and trailing number: `<Plate_274>` is `plate`.
pub fn base_name(identifier: &str) -> String {
    let bare = identifier.trim_start_matches('<').trim_end_matches('>').to_lowercase();
    let base = bare
        .trim_end_matches(|c: char| c.is_ascii_digit())
        .trim_end_matches('_');
    if base.is_empty() { bare } else { base.to_owned() }
}

/// Returns true if the last word of an identifier is `name`. Identifiers are often compounds without a separator
/// (`coffeetable`), so a name of four letters or more may also end a longer word.
pub fn ends_with(base: &str, name: &str) -> bool {
    base.strip_suffix(name)
        .is_some_and(|rest| rest.is_empty() || rest.ends_with('_') || name.len() >= 4)
}

/// Returns an identifier as words: `<shelf_top>` is "shelf top", `<table2>` is "table 2". A number after an underscore
/// is an id and is removed; a number directly after letters is part of the name.
fn cleaned(identifier: &str) -> String {
    let bare = identifier.trim_start_matches('<').trim_end_matches('>').to_lowercase();
    let without_id = match bare.rsplit_once('_') {
        Some((name, id)) if !name.is_empty() && id.chars().all(|c| c.is_ascii_digit()) => name,
        _ => &bare,
    };
    let words = plain_words(without_id);
    // An identifier without letters and digits still needs a name.
    if words.is_empty() {
        "thing".to_owned()
    } else {
        words.join(" ")
    }
}

/// Splits a text into lower-case words, with letters and digits apart: `Put it on table2!` is put, it, on, table, 2.
pub fn plain_words(text: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for character in text.chars().flat_map(char::to_lowercase) {
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

/// Returns the head noun of a name, in the singular: "glass" of "water glass 2", "bunch" of "bunch of bananas".
pub fn head(name: &str) -> String {
    let words = plain_words(name);
    let end = words.iter().position(|word| word == "of").unwrap_or(words.len());
    let digit = |word: &&String| word.starts_with(|c: char| c.is_ascii_digit());
    let head = words[..end].iter().rev().find(|word| !digit(word)).or(words.last());
    head.map(|word| singular(word)).unwrap_or_default()
}

/// Returns the singular of an English noun by simple rules, and other words unchanged.
///
/// ```
/// use longstep_core::domain::singular;
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
        ] {
            assert_eq!(cleaned(identifier), words);
            assert_eq!(base_name(identifier), base);
        }
    }

    #[test]
    fn words_are_split_at_digits_and_signs() {
        let words = plain_words("Let's put it on table2!");
        assert_eq!(words, ["lets", "put", "it", "on", "table", "2"]);
    }
}
