//! Words that refer to entities without naming them, or tell how many with a name are meant, as data by language.

use std::sync::LazyLock;

use rustc_hash::FxHashSet;

/// The rows: a language, a role, and its words.
const ROWS: &str = include_str!("reference_words.txt");

static ANY: LazyLock<FxHashSet<&'static str>> = LazyLock::new(|| words("any"));
static CERTAIN: LazyLock<FxHashSet<&'static str>> = LazyLock::new(|| words("certain"));
static ONE: LazyLock<FxHashSet<&'static str>> = LazyLock::new(|| words("one"));
static GROUP: LazyLock<FxHashSet<&'static str>> = LazyLock::new(|| words("group"));
static SEVERAL: LazyLock<FxHashSet<&'static str>> = LazyLock::new(|| words("several"));

/// Returns the words of a role in all languages: the language of an instruction is not known.
fn words(role: &str) -> FxHashSet<&'static str> {
    let rows = ROWS.lines().filter(|line| !line.starts_with('#'));
    let rows = rows.filter_map(|line| line.split_once(": "));
    let of_role = rows.filter(|(key, _)| key.split_whitespace().nth(1) == Some(role));
    of_role.flat_map(|(_, words)| words.split_whitespace()).collect()
}

/// Returns true if any entity with the name that follows fits: "a mug".
pub(super) fn mark_any(word: &str) -> bool {
    ANY.contains(word)
}

/// Returns true if one certain entity with the name that follows is meant: "the mug".
pub(super) fn mark_certain(word: &str) -> bool {
    CERTAIN.contains(word)
}

/// Returns true if several entities with the name that follows are meant: "both mugs".
pub(super) fn mark_several(word: &str) -> bool {
    SEVERAL.contains(word)
}

/// Returns true if the word stands for an entity of an earlier instruction: "put it back".
pub(super) fn stand_for_one(word: &str) -> bool {
    ONE.contains(word)
}

/// Returns true if the word stands for several entities of an earlier instruction: "put them back".
pub(super) fn stand_for_several(word: &str) -> bool {
    GROUP.contains(word)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_row_has_a_role_that_is_read() {
        for line in ROWS.lines().filter(|line| !line.starts_with('#')) {
            let (key, words) = line.split_once(": ").unwrap();
            let role = key.split_once(' ').unwrap().1;
            assert!(["any", "certain", "several", "one", "group"].contains(&role), "{line}");
            assert!(!words.trim().is_empty(), "{line}");
        }
        for (language, any, certain, several) in [
            ("en", "a", "the", "both"),
            ("de", "eine", "dem", "beide"),
            ("fr", "une", "ce", "toutes"),
            ("es", "alguna", "los", "ambas"),
        ] {
            assert!(
                mark_any(any) && mark_certain(certain) && mark_several(several),
                "{language}"
            );
        }
    }
}
