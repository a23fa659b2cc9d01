//! PDDL names for arbitrary identifiers.

use rustc_hash::FxHashSet;

use longstep_model::model::World;

/// Returns the PDDL name of every entity, by id.
///
/// The name is the identifier in lower case, without angle brackets, and with `_` for all characters except ASCII
/// letters, digits, `_` and `-`. A name that does not begin with a letter gets the prefix `o_`. `<pie_320>` is
/// `pie_320`. Where two entities would have the same name, the later one gets the suffix `-2`, `-3` and so on. So names
/// are unique and deterministic. Constants of the domain keep their names.
pub fn object_names(world: &World) -> Vec<String> {
    let constants = world.domain().constants.iter().map(|(name, _)| name.clone());
    let mut names: Vec<String> = constants.collect();
    let mut taken: FxHashSet<String> = names.iter().cloned().collect();
    for (_, entity) in world.entities().skip(names.len()) {
        let plain = plain(&entity.identifier);
        let mut name = plain.clone();
        let mut number = 2;
        while !taken.insert(name.clone()) {
            name = format!("{plain}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// Converts a text to a valid PDDL name.
pub(super) fn plain(text: &str) -> String {
    let inner = text.strip_prefix('<').and_then(|text| text.strip_suffix('>'));
    let allowed = |c: char| match c.to_ascii_lowercase() {
        c @ ('a'..='z' | '0'..='9' | '_' | '-') => c,
        _ => '_',
    };
    let mut name: String = inner.unwrap_or(text).chars().map(allowed).collect();
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        name.insert_str(0, "o_");
    }
    name
}
