//! Labels of identifiers: the `A` of `<tube_A>`, the `2` of `<pallet_2>`.

/// Characters between the parts of an identifier.
pub(super) const SEPARATORS: [char; 5] = ['_', '.', '-', ' ', '#'];

/// Returns the identifier without its angle brackets.
pub(super) fn without_brackets(identifier: &str) -> &str {
    identifier.trim_start_matches('<').trim_end_matches('>')
}

/// Returns the identifier in lower case, without angle brackets and trailing number: `<Plate_274>` is `plate`.
pub fn base_name(identifier: &str) -> String {
    let bare = without_brackets(identifier).to_lowercase();
    let base = bare
        .trim_end_matches(|c: char| c.is_ascii_digit())
        .trim_end_matches(SEPARATORS);
    if base.is_empty() { bare } else { base.to_owned() }
}

/// Returns the identifier in lower case, without angle brackets and label: `<Tube_A>` and `<tube.1>` are `tube`.
pub fn stem(identifier: &str) -> String {
    split_label(identifier).0.to_lowercase()
}

/// Returns the label at the end of an identifier, with blanks between its parts: `<Bay.3-A>` has the label `3 A`. Empty
/// if there is none.
pub fn label(identifier: &str) -> String {
    let parts = split_label(identifier).1.split(SEPARATORS);
    parts.filter(|part| !part.is_empty()).collect::<Vec<_>>().join(" ")
}

/// Splits an identifier without its brackets into a stem and a label: its last parts that are [labels](is_label), and the
/// digits at the end of the stem (`table2`).
pub(super) fn split_label(identifier: &str) -> (&str, &str) {
    let bare = without_brackets(identifier);
    let mut stem = bare.trim_end_matches(SEPARATORS);
    while let Some(at) = stem.rfind(SEPARATORS) {
        let shorter = stem[..at].trim_end_matches(SEPARATORS);
        // A separator is one byte long.
        if shorter.is_empty() || !is_label(&stem[at + 1..]) {
            break;
        }
        stem = shorter;
    }
    let without_digits = stem
        .trim_end_matches(|c: char| c.is_ascii_digit())
        .trim_end_matches(SEPARATORS);
    if !without_digits.is_empty() {
        stem = without_digits;
    }
    bare.split_at(if stem.is_empty() { bare.len() } else { stem.len() })
}

/// Returns true for a number, a single letter, or a number with one letter: `3`, `A`, `B2`. In scripts without upper and
/// lower case a single character may be a word, and is no label.
pub(super) fn is_label(part: &str) -> bool {
    let mut letters = part.chars().filter(|c| !c.is_ascii_digit());
    let first = letters.next();
    !part.is_empty() && letters.next().is_none() && first.is_none_or(|c| c.is_uppercase() || c.is_lowercase())
}

/// Returns true if an identifier matches a name in a derivation: the name is its end, with or without its number or
/// label. Case and the kind of separators do not matter.
///
/// ```
/// use longstep_model::domain::matches_name;
/// for identifier in ["<tube>", "<Tube_A>", "<tube.1>", "<sample-tube-B2>"] {
///     assert!(matches_name(identifier, "tube"), "{identifier}");
/// }
/// assert!(!matches_name("<tube_rack>", "tube"));
/// ```
pub fn matches_name(identifier: &str, name: &str) -> bool {
    NameForms::of(identifier).end_with(&unified(name))
}

/// The forms of an identifier that the names of derivations are compared with.
#[derive(Debug, Clone)]
pub(crate) struct NameForms([String; 3]);

impl NameForms {
    /// Returns the whole identifier, without its number, and without its label.
    pub(crate) fn of(identifier: &str) -> Self {
        Self([
            unified(identifier),
            unified(&base_name(identifier)),
            unified(&stem(identifier)),
        ])
    }

    /// Returns true if one of the forms ends with the name, which is [`unified`].
    pub(crate) fn end_with(&self, name: &str) -> bool {
        !name.is_empty() && self.0.iter().any(|form| ends_with(form, name))
    }
}

/// Returns a text in lower case, without angle brackets, with one kind of separators.
pub(crate) fn unified(text: &str) -> String {
    without_brackets(text).to_lowercase().replace(SEPARATORS, "_")
}

/// Returns true if the last word of an identifier is `name`. Identifiers are often compounds without a separator
/// (`coffeetable`), so a name of four letters or more may also end a longer word.
pub fn ends_with(base: &str, name: &str) -> bool {
    base.strip_suffix(name)
        .is_some_and(|rest| rest.is_empty() || rest.ends_with('_') || name.len() >= 4)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn labels_are_numbers_and_single_letters() {
        for (identifier, stem_of, label_of) in [
            ("<tube_A>", "tube", "A"),
            ("<Tube>", "tube", ""),
            ("<tube.1>", "tube", "1"),
            ("<Bay.3-A>", "bay", "3 A"),
            ("<table2>", "table", "2"),
            ("<rack_B2>", "rack", "B2"),
            ("<杯子_1>", "杯子", "1"),
            ("<红_杯>", "红_杯", ""),
            ("<Стол_Б>", "стол", "Б"),
            ("<7>", "7", ""),
            ("<_>", "_", ""),
            ("<A>", "a", ""),
            ("<tube_rack>", "tube_rack", ""),
        ] {
            assert_eq!(stem(identifier), stem_of, "{identifier}");
            assert_eq!(label(identifier), label_of, "{identifier}");
        }
    }
}
