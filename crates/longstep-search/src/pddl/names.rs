//! PDDL names for arbitrary identifiers.

use rustc_hash::FxHashSet;

use longstep_model::model::{Domain, World};

/// Keywords of PDDL, which strict parsers accept nowhere as the name of an object.
const KEYWORDS: [&str; 38] = [
    "after", "always", "always-within", "and", "assign", "at-most-once", "decrease", "define", "domain", "duration", "either",
    "exists", "forall", "hold-after", "hold-during", "imply", "increase", "is-violated", "maximize", "minimize", "name",
    "not", "number", "or", "preference", "problem", "scale-down", "scale-up", "sometime", "sometime-after",
    "sometime-before", "supply-demand", "total-cost", "total-time", "undefined", "when", "within", "object",
];
/// Words that are keywords of PDDL behind or before another one: `at start`, `over all`.
const PARTS_OF_KEYWORDS: [&str; 5] = ["all", "at", "end", "over", "start"];

/// Returns the PDDL name of every entity, by id.
///
/// The name is the identifier in lower case, without angle brackets, and with `_` for all characters except ASCII
/// letters, digits, `_` and `-`. A name that does not begin with a letter gets the prefix `o_`. `<pie_320>` is
/// `pie_320`. Where two entities would have the same name, the later one gets the suffix `-2`, `-3` and so on. So names
/// are unique and deterministic. Constants of the domain keep their names.
///
/// No name is a keyword of PDDL. An identifier with other characters, such as `<bin>`, does not get the name of a
/// predicate, a function, a type or an action either, because some parsers know one name space only; one that is a
/// name of PDDL already, from a problem file, keeps it.
pub fn object_names(world: &World) -> Vec<String> {
    let domain = world.domain();
    let constants = domain.constants.iter().map(|(name, _)| name.clone());
    let mut names: Vec<String> = constants.collect();
    let mut taken: FxHashSet<String> = names.iter().cloned().collect();
    taken.extend(KEYWORDS.map(str::to_owned));
    let of_domain = names_of(domain);
    for (_, entity) in world.entities().skip(names.len()) {
        let plain = plain(&entity.identifier);
        let is_written = plain != entity.identifier;
        let mut name = plain.clone();
        let mut number = 2;
        while (is_written && of_domain.contains(name.as_str())) || !taken.insert(name.clone()) {
            name = format!("{plain}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// Returns the names that the domain gives to anything but objects, and words that are half a keyword.
fn names_of(domain: &Domain) -> FxHashSet<&str> {
    let predicates = domain.predicates.iter().map(|own| own.name.as_str());
    let functions = domain.functions.iter().map(|own| own.name.as_str());
    let actions = domain.actions.iter().map(|own| own.name.as_str());
    let own = predicates.chain(functions).chain(actions).chain(domain.types.names());
    own.chain(PARTS_OF_KEYWORDS).collect()
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
