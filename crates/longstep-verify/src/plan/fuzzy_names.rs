//! Fuzzy matching of misspelled names.
//!
//! A match needs exactly one candidate, which differs only in case or punctuation, is an unambiguous prefix match, or
//! lies within an edit distance of one or two. Digits and labels must match exactly: `<plate_3>` never matches
//! `<plate_4>`, and `<tube_A>` never `<tube_B>`.

use longstep_model::model::{ActionId, Domain, EntityId, World, base_name, label};

/// Letters and digits of the name, in lower case.
fn bare(name: &str) -> String {
    name.chars()
        .filter(|c| c.is_alphanumeric())
        .flat_map(char::to_lowercase)
        .collect()
}

/// Returns the first item if all other items are equal to it.
fn only<T: PartialEq>(mut all: impl Iterator<Item = T>) -> Option<T> {
    let first = all.next()?;
    all.all(|other| other == first).then_some(first)
}

/// Returns true if the edit distance between the names is at most 1, or 2 in names of eight letters or more (0 in names
/// of up to three).
fn slip(left: &str, right: &str) -> bool {
    let length = left.chars().count().min(right.chars().count());
    let allowed = match length {
        0..=3 => 0,
        4..=7 => 1,
        _ => 2,
    };
    strsim::damerau_levenshtein(left, right) <= allowed
}

/// Finds the only action that can be meant by this name and number of arguments. The name is not an exact match.
pub(super) fn action(domain: &Domain, written: &str, arguments: usize) -> Option<ActionId> {
    let written = bare(written);
    let named = |count: Option<usize>, fits: &dyn Fn(&str) -> bool| {
        let fitting = domain.action_ids().filter(|(_, action)| {
            count.is_none_or(|count| action.explicit.len() == count) && fits(&bare(&action.call))
        });
        only(fitting.map(|(id, _)| id))
    };
    let begins =
        |call: &str| call.len().min(written.len()) >= 3 && (call.starts_with(&written) || written.starts_with(call));
    named(None, &|call| call == written)
        .or_else(|| named(Some(arguments), &begins))
        .or_else(|| named(Some(arguments), &|call| slip(call, &written)))
}

/// Finds the only entity that can be meant by this name. The name is not an exact match.
pub(super) fn entity(world: &World, written: &str) -> Option<EntityId> {
    let written_bare = bare(written);
    let digits = |text: &str| text.chars().filter(char::is_ascii_digit).collect::<String>();
    let letters = |text: &str| text.chars().filter(|c| !c.is_ascii_digit()).collect::<String>();
    let named = |fits: &dyn Fn(&str) -> bool| {
        let fitting = world.entities().filter(|(_, entity)| fits(&entity.identifier));
        only(fitting.map(|(id, _)| id))
    };
    let same = named(&|identifier| bare(identifier) == written_bare);
    let slipped = || {
        named(&|identifier| {
            let known = bare(identifier);
            let same_label = label(identifier).eq_ignore_ascii_case(&label(written));
            same_label && digits(&known) == digits(&written_bare) && slip(&letters(&known), &letters(&written_bare))
        })
    };
    if written_bare.is_empty() || same.is_some() {
        return same;
    }
    if !digits(&written_bare).is_empty() {
        return slipped();
    }
    named(&|identifier| bare(&base_name(identifier)) == written_bare)
        .or_else(|| {
            let called = world
                .entities()
                .filter(|(_, entity)| entity.names.iter().any(|name| bare(name) == written_bare));
            only(called.map(|(id, _)| id))
        })
        .or_else(slipped)
}

#[cfg(test)]
mod tests {
    use super::*;
    use longstep_model::testing;

    #[test]
    fn fuzzy_names_never_change_a_label() {
        let text = r#"{"objects": ["<tube_A>", "<plate_3>"]}"#;
        let world = testing::world("household", text);
        for (written, expected) in [
            ("tubeA", Some("<tube_A>")),
            ("<tueb_A>", Some("<tube_A>")),
            ("<tube>", Some("<tube_A>")),
            ("<tube_C>", None),
            ("<tueb_B>", None),
            ("<plate_4>", None),
        ] {
            let found = entity(&world, written).map(|id| world.entity(id).identifier.as_str());
            assert_eq!(found, expected, "{written}");
        }
    }
}
