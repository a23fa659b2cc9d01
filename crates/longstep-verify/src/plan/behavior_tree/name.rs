//! Names of leaves and ports.

use std::borrow::Cow;

use super::OUTCOME;
use crate::plan::written::predicate_word;
use longstep_model::model::{Action, ActionId, Atom, Domain, Fact, PredicateId, World};

/// The nodes of BehaviorTree.CPP 4, which no leaf may be called.
const BUILT_IN: [&str; 52] = [
    "Action",
    "AlwaysFailure",
    "AlwaysSuccess",
    "AsyncFallback",
    "AsyncSequence",
    "BehaviorTree",
    "Condition",
    "ConsumeQueue",
    "Control",
    "Decorator",
    "Delay",
    "EntryUpdated",
    "Fallback",
    "ForceFailure",
    "ForceSuccess",
    "IfThenElse",
    "Inverter",
    "KeepRunningUntilFailure",
    "LoopBool",
    "LoopDouble",
    "LoopInt",
    "LoopString",
    "ManualSelector",
    "Parallel",
    "ParallelAll",
    "Precondition",
    "ReactiveFallback",
    "ReactiveSequence",
    "Repeat",
    "RetryUntilSuccesful",
    "RetryUntilSuccessful",
    "Root",
    "RunOnce",
    "Script",
    "ScriptCondition",
    "Sequence",
    "SequenceWithMemory",
    "SetBlackboard",
    "SkipUnlessUpdated",
    "Sleep",
    "SubTree",
    "SubTreePlus",
    "Switch2",
    "Switch3",
    "Switch4",
    "Switch5",
    "Switch6",
    "Timeout",
    "TryCatch",
    "UnsetBlackboard",
    "WaitValueUpdate",
    "WhileDoElse",
];

/// Prefix of the leaf of a predicate whose name an action or a built-in node has.
pub(in crate::plan) const IS: &str = "is_";

/// Prefix of the port of a parameter whose name no port may have.
pub(super) const ARGUMENT: &str = "arg_";

/// Suffix of the leaf of an action that is called like a built-in node.
const STEP: &str = "_step";

/// Returns true for a node that BehaviorTree.CPP has itself.
pub(super) fn is_built_in(name: &str) -> bool {
    BUILT_IN.binary_search(&name).is_ok()
}

/// Replaces the characters that no leaf and no port may have.
fn plain(name: &str) -> Cow<'_, str> {
    let odd = |character: char| !(character.is_alphanumeric() || matches!(character, '_' | '-'));
    if name.contains(odd) {
        Cow::Owned(name.replace(odd, "_"))
    } else {
        Cow::Borrowed(name)
    }
}

/// The name of an XML element begins with a letter or an underscore.
fn begins_well(name: &str) -> bool {
    name.starts_with(|first: char| first.is_alphabetic() || first == '_')
}

/// The names of the leaves of a domain, each different from the others.
pub(crate) struct LeafNames {
    actions: Vec<String>,
    predicates: Vec<String>,
}

impl LeafNames {
    pub(crate) fn of(domain: &Domain) -> Self {
        let mut taken: Vec<String> = Vec::new();
        let mut free = |mut name: String, tail: &str| {
            while is_built_in(&name) || !begins_well(&name) || taken.contains(&name) {
                name = if begins_well(&name) {
                    name + tail
                } else {
                    format!("_{name}")
                };
            }
            taken.push(name.clone());
            name
        };
        let actions = domain.actions.iter();
        let actions = actions
            .map(|action| free(plain(&action.call).into_owned(), STEP))
            .collect();
        let predicate = |name: &str| {
            let own = plain(&predicate_word(name)).into_owned();
            let is_other = is_built_in(&own) || domain.actions.iter().any(|action| action.call == own);
            if is_other { format!("{IS}{own}") } else { own }
        };
        let predicates = domain.predicates.iter();
        let predicates = predicates.map(|one| free(predicate(&one.name), "_fact")).collect();
        Self { actions, predicates }
    }

    pub(crate) fn action(&self, action: ActionId) -> &str {
        &self.actions[action.index()]
    }

    pub(crate) fn predicate(&self, predicate: PredicateId) -> &str {
        &self.predicates[predicate.index()]
    }
}

/// Returns the port of a parameter.
pub(crate) fn port(parameter: &str) -> String {
    let plain = plain(parameter);
    let is_reserved = matches!(&*plain, "name" | "ID" | OUTCOME) || plain.starts_with(ARGUMENT);
    let has_letter = plain.starts_with(|first: char| first.is_alphabetic());
    if is_reserved || !has_letter {
        format!("{ARGUMENT}{plain}")
    } else {
        plain.into_owned()
    }
}

/// Returns the parameter of a port.
pub(super) fn parameter(port: &str) -> &str {
    port.strip_prefix(ARGUMENT).unwrap_or(port)
}

/// Replaces the characters that no text in a script may have: those outside of ASCII too.
fn plain_ascii(text: &str) -> String {
    let is_odd = |character: char| !(character.is_ascii_alphanumeric() || matches!(character, '_' | '-'));
    text.replace(is_odd, "_")
}

/// Returns the name of each outcome's predicate as it begins the word for the outcome.
pub(super) fn outcome_stems(domain: &Domain, action: &Action) -> Vec<String> {
    let stem = |atom: &Atom| plain_ascii(&predicate_word(&domain.predicate(atom.predicate).name));
    action.senses.iter().map(stem).collect()
}

/// Returns the words for the outcomes of a sensing step: the name of the predicate if it tells them apart, else with its
/// arguments.
pub(crate) fn outcomes(world: &World, action: &Action, facts: &[Fact]) -> Vec<String> {
    let domain = world.domain();
    let mut words = outcome_stems(domain, action);
    for (index, fact) in facts.iter().enumerate() {
        let predicate = action.senses[index].predicate;
        if action.senses.iter().filter(|atom| atom.predicate == predicate).count() > 1 {
            for entity in domain.arguments(*fact) {
                words[index].push('_');
                words[index].push_str(&plain_ascii(world.entity(entity).identifier.trim_matches(['<', '>'])));
            }
        }
    }
    // Names that differ only in odd characters.
    for index in 1..words.len() {
        while words[..index].contains(&words[index]) {
            words[index].push('_');
        }
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn built_in_nodes_are_sorted() {
        assert!(BUILT_IN.is_sorted());
        assert!(is_built_in("Switch6") && !is_built_in("grasp_object"));
    }

    #[test]
    fn port_is_a_name_that_a_port_may_have() {
        for (parameter, expected) in [
            ("item", "item"),
            ("from-place", "from-place"),
            ("name", "arg_name"),
            ("ID", "arg_ID"),
            ("outcome", "arg_outcome"),
            ("_x", "arg__x"),
            ("2nd", "arg_2nd"),
            ("arg_x", "arg_arg_x"),
        ] {
            let port = port(parameter);
            assert_eq!(port, expected);
            assert_eq!(super::parameter(&port), parameter);
        }
    }
}
