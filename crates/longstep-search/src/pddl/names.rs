//! PDDL names for arbitrary identifiers.

use rustc_hash::FxHashSet;

use longstep_model::model::{Domain, World};

/// Keywords of PDDL and their parts (`at start`), which strict parsers accept nowhere as the name of an object.
const KEYWORDS: [&str; 43] = [
    "after",
    "all",
    "always",
    "always-within",
    "and",
    "assign",
    "at",
    "at-most-once",
    "decrease",
    "define",
    "domain",
    "duration",
    "either",
    "end",
    "exists",
    "forall",
    "hold-after",
    "hold-during",
    "imply",
    "increase",
    "is-violated",
    "maximize",
    "minimize",
    "name",
    "not",
    "number",
    "object",
    "or",
    "over",
    "preference",
    "problem",
    "scale-down",
    "scale-up",
    "sometime",
    "sometime-after",
    "sometime-before",
    "start",
    "supply-demand",
    "total-cost",
    "total-time",
    "undefined",
    "when",
    "within",
];

/// Returns the PDDL name of every entity, by id.
///
/// The name is the identifier in lower case, without angle brackets, and with `_` for all characters except ASCII
/// letters, digits, `_` and `-`. A name that does not begin with a letter gets the prefix `o_`. `<pie_320>` is
/// `pie_320`. Where two entities would have the same name, the later one gets the suffix `-2`, `-3` and so on. So names
/// are unique and deterministic. Constants of the domain keep their names.
///
/// No name is a keyword of PDDL, or the name of a predicate, a function, a type or an action, because some parsers know
/// one name space only. Names that are PDDL already keep such a name if they come from a problem file: in a domain
/// without goal words, which was read from PDDL alone.
pub fn object_names(world: &World) -> Vec<String> {
    let domain = world.domain();
    let constants = domain.constants.iter().map(|(name, _)| name.clone());
    let mut names: Vec<String> = constants.collect();
    let mut taken: FxHashSet<String> = names.iter().cloned().collect();
    let (avoided, from_pddl) = (avoided(domain), domain.goal_words.is_empty());
    for (_, entity) in world.entities().skip(names.len()) {
        let plain = plain(&entity.identifier);
        let is_kept = from_pddl && plain == entity.identifier;
        let mut name = plain.clone();
        let mut number = 2;
        while (!is_kept && avoided.contains(name.as_str())) || !taken.insert(name.clone()) {
            name = format!("{plain}-{number}");
            number += 1;
        }
        names.push(name);
    }
    names
}

/// Returns keywords, and the names that the domain gives to anything but objects.
fn avoided(domain: &Domain) -> FxHashSet<&str> {
    let predicates = domain.predicates.iter().map(|own| own.name.as_str());
    let functions = domain.functions.iter().map(|own| own.name.as_str());
    let actions = domain.actions.iter().map(|own| own.name.as_str());
    let own = predicates.chain(functions).chain(actions).chain(domain.types.names());
    own.chain(KEYWORDS).collect()
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
