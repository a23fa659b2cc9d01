//! First sentences for the names of a PDDL file, for the author to improve.
//!
//! Only authors see these rules at work: they write text into a new `domain.toml`. No instruction is read with them.

use longstep_core::model::Domain;

use longstep::domain::{ActionId, Atom, Condition, Parameter, Predicate, PredicateId, Term};

/// Words after which a place or a companion follows.
const PREPOSITIONS: [&str; 20] = [
    "at", "in", "on", "into", "onto", "inside", "under", "near", "above", "below", "of", "to", "from", "by", "with",
    "behind", "over", "beside", "against", "aboard",
];

/// The texts for a predicate.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PredicateText {
    pub(super) says: String,
    pub(super) denies: String,
    pub(super) short: Option<String>,
}

/// Splits a PDDL name into its words.
pub(super) fn words(name: &str) -> Vec<&str> {
    let parts = name.split(|c: char| !c.is_alphanumeric());
    parts.filter(|part| !part.is_empty()).collect()
}

/// Returns a name as the notation of plans and environments admits it: letters, digits and `_`.
pub(super) fn identifier(name: &str) -> String {
    match words(name).join("_") {
        empty if empty.is_empty() => "item".to_owned(),
        joined => joined,
    }
}

/// Returns the text with a capital first letter.
pub(super) fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    match letters.next() {
        Some(first) => first.to_uppercase().chain(letters).collect(),
        None => String::new(),
    }
}

fn is_preposition(word: &str) -> bool {
    PREPOSITIONS.contains(&word)
}

/// Returns the words of a predicate without the names of its arguments' types: `truck-at` of a truck is `at`.
fn own_words<'n>(domain: &Domain, predicate: &'n Predicate) -> Vec<&'n str> {
    let kinds: Vec<&str> = predicate.parameters.iter().map(|p| domain.types.name(p.kind)).collect();
    let all = words(&predicate.name);
    let own: Vec<&str> = all.iter().copied().filter(|word| !kinds.contains(word)).collect();
    if own.is_empty() { all } else { own }
}

/// Returns the sentences of a predicate; `fluent` is true if an action changes it.
pub(super) fn predicate(domain: &Domain, predicate: &Predicate, fluent: bool) -> PredicateText {
    let own = own_words(domain, predicate);
    let all = own.join(" ");
    let hole = |index: usize| format!("{{{}}}", predicate.parameters[index].name);
    let with = |start: &str, verb: (&str, &str), rest: &str, short: String| PredicateText {
        says: format!("{start} {}{rest}", verb.0),
        denies: format!("{start} {}{rest}", verb.1),
        short: Some(short),
    };
    const IS: (&str, &str) = ("is ", "is not ");
    const HAS: (&str, &str) = ("has ", "does not have ");
    let (first, last) = (own.first().copied().unwrap_or(""), own.last().copied().unwrap_or(""));
    let rest = own.get(1..).unwrap_or_default().join(" ");
    let before = own[..own.len().saturating_sub(1)].join(" ");
    match predicate.parameters.len() {
        0 => PredicateText {
            says: format!("\"{all}\" holds"),
            denies: format!("\"{all}\" does not hold"),
            short: None,
        },
        1 => match (first, last) {
            _ if own.len() > 1 && is_preposition(last) => {
                let text = format!("{last} {}", hole(0));
                with(&format!("the {before}"), IS, &text, format!("the {before} is here"))
            }
            ("at", _) if own.len() > 1 => {
                let text = format!("at {}", hole(0));
                with(&format!("the {rest}"), IS, &text, format!("the {rest} is here"))
            }
            (preposition, _) if own.len() > 1 && is_preposition(preposition) => {
                let text = format!("{preposition} the {rest}");
                with(&hole(0), IS, &text, text.clone())
            }
            ("has", _) if own.len() > 1 => with(&hole(0), HAS, &rest, all.clone()),
            ("can", _) if own.len() > 1 => with(&hole(0), ("can ", "cannot "), &rest, all.clone()),
            ("is", _) if own.len() > 1 => with(&hole(0), IS, &rest, rest.clone()),
            _ if fluent && last.len() > 5 && last.ends_with("ing") => {
                let who = if before.is_empty() { "robot" } else { before.as_str() };
                let text = format!("{last} {}", hole(0));
                with(&format!("the {who}"), IS, &text, format!("the {who} is {last} it"))
            }
            _ if fluent => with(&hole(0), IS, &all, all.clone()),
            _ if own.len() > 1 && own.iter().any(|word| is_preposition(word) || *word == "for") => {
                with(&hole(0), IS, &all, all.clone())
            }
            _ => {
                let article = if first.starts_with(['a', 'e', 'i', 'o', 'u']) {
                    "an"
                } else {
                    "a"
                };
                with(&hole(0), IS, &format!("{article} {all}"), format!("{article} {all}"))
            }
        },
        2 => {
            let other = hole(1);
            let relative = format!("{all} {other}");
            let mut text = match (first, last) {
                _ if is_preposition(last) || (last.len() > 5 && last.ends_with("ing")) => {
                    with(&hole(0), IS, &relative, relative.clone())
                }
                ("has" | "have", _) => with(&hole(0), HAS, format!("{rest} {other}").trim(), relative.clone()),
                ("is", _) if own.len() > 1 => with(&hole(0), IS, &format!("{rest} {other}"), relative.clone()),
                _ => PredicateText {
                    says: format!("\"{all}\" holds for {} and {other}", hole(0)),
                    denies: format!("\"{all}\" does not hold for {} and {other}", hole(0)),
                    short: Some(relative.clone()),
                },
            };
            // Relations that never change (roads, neighbours) would fill the prompt.
            text.short = text.short.filter(|_| fluent);
            text
        }
        count => {
            let listed: Vec<String> = (0..count - 1).map(hole).collect();
            let listed = format!("{} and {}", listed.join(", "), hole(count - 1));
            let others: Vec<String> = (1..count).map(hole).collect();
            PredicateText {
                says: format!("\"{all}\" holds for {listed}"),
                denies: format!("\"{all}\" does not hold for {listed}"),
                short: fluent.then(|| format!("{all} {}", others.join(" "))),
            }
        }
    }
}

/// Returns the sentence of an action: its words, and each parameter with the preposition that its effects suggest.
pub(super) fn action(domain: &Domain, id: ActionId) -> String {
    let action = domain.action(id);
    let kinds: Vec<&str> = action.parameters.iter().map(|p| domain.types.name(p.kind)).collect();
    let all = words(&action.name);
    let verb: Vec<&str> = all.iter().copied().filter(|word| !kinds.contains(word)).collect();
    let mut text = if verb.is_empty() { all.join(" ") } else { verb.join(" ") };
    for (index, parameter) in action.parameters.iter().enumerate() {
        text.push(' ');
        if let Some(preposition) = preposition(domain, id, index, parameter) {
            // "pick up {x} on {y}", but not "put on on {y}".
            if !text.trim_end().ends_with(&format!(" {preposition}")) {
                text.push_str(preposition);
                text.push(' ');
            }
        }
        text.push_str(&format!("{{{}}}", parameter.name));
    }
    text
}

fn preposition(domain: &Domain, id: ActionId, index: usize, parameter: &Parameter) -> Option<&'static str> {
    let action = domain.action(id);
    for (hints, word) in [
        (&["from", "source", "origin"][..], "from"),
        (&["to", "dest", "destination", "target"][..], "to"),
    ] {
        if words(&parameter.name).iter().any(|part| hints.contains(part)) {
            return Some(word);
        }
    }
    let is_here = |atom: &Atom| {
        let place = atom.terms.iter().position(|term| *term == Term::Variable(index));
        place.filter(|place| *place > 0 || atom.terms.len() == 1)
    };
    let word_of = |predicate: PredicateId| {
        let own = own_words(domain, domain.predicate(predicate));
        let found = [own.last(), own.first()].into_iter().flatten();
        found
            .filter_map(|word| PREPOSITIONS.iter().find(|known| *known == word))
            .copied()
            .next()
    };
    let effects = |adds: bool| action.effects.iter().filter(move |effect| effect.adds == adds);
    for effect in effects(true) {
        if let (Some(_), Some(word)) = (is_here(&effect.atom), word_of(effect.atom.predicate)) {
            let leaves = effects(false).any(|other| other.atom.predicate == effect.atom.predicate);
            if effect.atom.terms.len() > 1 || word == "at" {
                return Some(if leaves && matches!(word, "at" | "in") {
                    "to"
                } else {
                    word
                });
            }
        }
    }
    if index == 0 {
        return None;
    }
    for effect in effects(false) {
        if is_here(&effect.atom).is_some() && word_of(effect.atom.predicate).is_some() {
            return Some("from");
        }
    }
    let needed = action.precondition.conjuncts().filter_map(|part| match part {
        Condition::Atom { atom, holds: true, .. } => Some(atom),
        _ => None,
    });
    for atom in needed {
        if let (Some(_), Some(word)) = (is_here(atom), word_of(atom.predicate)) {
            return Some(word);
        }
    }
    Some("with")
}

#[cfg(test)]
mod tests {
    use super::*;
    use longstep_core::domain::from_pddl;

    fn domain() -> Domain {
        from_pddl(
            "d.pddl",
            "(define (domain d) (:types truck box room - object)
              (:predicates (on ?x ?y - box) (clear ?x - box) (hand-empty) (holding ?x - box) (robot-at ?r - room)
                (truck-at ?t - truck ?r - room) (connected-to ?a ?b - room) (light ?x - box) (link ?a ?b - room)
                (on-table ?x - box) (at-robby ?r - room))
              (:action stack :parameters (?x ?y - box) :precondition (holding ?x)
                :effect (and (on ?x ?y) (clear ?x) (hand-empty) (on-table ?x) (not (holding ?x))))
              (:action drive-truck :parameters (?t - truck ?a ?b - room) :precondition (truck-at ?t ?a)
                :effect (and (truck-at ?t ?b) (not (truck-at ?t ?a)) (robot-at ?b) (at-robby ?b)))
              (:action pick-up :parameters (?x - box ?r - room) :precondition (robot-at ?r)
                :effect (holding ?x)))",
        )
        .unwrap()
    }

    #[test]
    fn predicates_become_sentences() {
        let domain = domain();
        for (name, says, denies) in [
            ("on", "{x} is on {y}", "{x} is not on {y}"),
            ("clear", "{x} is clear", "{x} is not clear"),
            ("hand-empty", "\"hand empty\" holds", "\"hand empty\" does not hold"),
            ("holding", "the robot is holding {x}", "the robot is not holding {x}"),
            ("robot-at", "the robot is at {r}", "the robot is not at {r}"),
            ("truck-at", "{t} is at {r}", "{t} is not at {r}"),
            ("connected-to", "{a} is connected to {b}", "{a} is not connected to {b}"),
            ("light", "{x} is a light", "{x} is not a light"),
            (
                "link",
                "\"link\" holds for {a} and {b}",
                "\"link\" does not hold for {a} and {b}",
            ),
            ("on-table", "{x} is on the table", "{x} is not on the table"),
            ("at-robby", "the robby is at {r}", "the robby is not at {r}"),
        ] {
            let index = domain.predicates.iter().position(|p| p.name == name).unwrap();
            let text = predicate(&domain, &domain.predicates[index], domain.predicate_words[index].fluent);
            assert_eq!((text.says.as_str(), text.denies.as_str()), (says, denies), "{name}");
        }
    }

    #[test]
    fn actions_become_sentences() {
        let domain = domain();
        let found: Vec<String> = domain.action_ids().map(|(id, _)| action(&domain, id)).collect();
        assert_eq!(
            found,
            ["stack {x} on {y}", "drive {t} from {a} to {b}", "pick up {x} at {r}"]
        );
    }
}
