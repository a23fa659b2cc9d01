//! Identifiers that C++ and Python allow, one for each name of a domain.

use std::collections::BTreeSet;
use std::fmt::Write;

/// The words that no function, parameter or outcome may have as its name, in either language: keywords, macros of the C
/// library, types in the signatures, and the names of the written text itself.
const RESERVED: &str = include_str!("reserved_words.txt");

/// Identifiers in one scope, each different from the others.
#[derive(Debug, Default)]
pub(super) struct Scope {
    taken: BTreeSet<String>,
}

impl Scope {
    /// Returns the identifier for a name. It depends on the name alone, unless another name of the scope has it already.
    pub(super) fn identifier(&mut self, name: &str) -> String {
        let plain = plain(name);
        let mut identifier = plain.clone();
        let mut number = 1;
        while self.taken.contains(&identifier) {
            number += 1;
            identifier = format!("{}_{number}", plain.trim_end_matches('_'));
        }
        self.taken.insert(identifier.clone());
        identifier
    }
}

/// Returns a name as an identifier of ASCII letters, digits and single underscores, which is not reserved. A letter outside
/// of ASCII becomes its number, so that a function keeps its name when others are added.
fn plain(name: &str) -> String {
    let mut identifier = String::new();
    for character in name.chars() {
        if character.is_ascii_alphanumeric() {
            identifier.push(character);
        } else if character.is_alphanumeric() {
            let _ = write!(identifier, "u{:04x}", u32::from(character));
        } else if !identifier.is_empty() && !identifier.ends_with('_') {
            identifier.push('_');
        }
    }
    identifier.truncate(identifier.trim_end_matches('_').len());
    if !identifier.starts_with(|first: char| first.is_ascii_alphabetic()) {
        identifier.insert_str(0, "n_");
        identifier.truncate(identifier.trim_end_matches('_').len());
    }
    if RESERVED.split_whitespace().any(|word| word == identifier) {
        identifier.push('_');
    }
    identifier
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn identifier_is_legal_in_both_languages() {
        for (name, expected) in [
            ("grasp_object", "grasp_object"),
            ("PutIn", "PutIn"),
            ("from", "from_"),
            ("class", "class_"),
            ("new", "new_"),
            ("self", "self_"),
            ("NULL", "NULL_"),
            ("2nd-shelf", "n_2nd_shelf"),
            ("_Upper", "Upper"),
            ("__x__y__", "x_y"),
            ("say \"hi\"*/", "say_hi"),
            ("grüßen", "gru00fcu00dfen"),
            ("開ける", "u958bu3051u308b"),
            ("-", "n"),
            ("", "n"),
        ] {
            assert_eq!(plain(name), expected, "{name}");
        }
    }

    #[test]
    fn identifiers_of_a_scope_differ() {
        let mut scope = Scope::default();
        let found = ["put-in", "put_in", "put_in_2", "put in", "class", "class_"].map(|name| scope.identifier(name));
        assert_eq!(
            found,
            ["put_in", "put_in_2", "put_in_2_2", "put_in_3", "class_", "class_2"]
        );
    }
}
