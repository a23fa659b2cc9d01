//! Names that PDDL allows, for identifiers of any form.

use rustc_hash::FxHashSet;

use crate::model::{Domain, World};

/// The name of every entity in PDDL, by its id.
///
/// An identifier loses its angle brackets and its capitals, and whatever is neither a letter of ASCII, a digit,
/// `_` nor `-` becomes `_`; a name that does not begin with a letter gets `o_` in front. `<pie_320>` is `pie_320`.
/// Where two entities would be called the same, the later one gets `-2`, `-3` and so on behind its name, so that
/// every name stands for one entity of the world, and the same one each time. Constants of the domain keep their
/// names.
pub fn object_names(domain: &Domain, world: &World) -> Vec<String> {
    let constants = domain.constants.iter().map(|(name, _)| name.clone());
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

/// Text as a word that PDDL allows as a name.
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
