//! Names that a model is likely to confuse.
//!
//! Wake et al. (2023) trace wrong steps of their model to the names `Put` (onto) and `PutIn` (into an object with a
//! door). Names that state the difference made such errors rarer.

use super::places::{Place, Places};
use super::reach::Reach;
use super::{Finding, Lint};
use longstep::domain::{Action, Atom, Condition, Domain, Parameter, TypeId};

/// A name with the types of its written arguments.
struct Named<'a> {
    name: &'a str,
    kinds: Vec<TypeId>,
    /// Fact of a state word. Two words for one fact may be similar.
    fact: Option<&'a Atom>,
    place: Place<'a>,
}

pub(super) fn findings(domain: &Domain, reach: &Reach<'_>, places: &Places<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    let written = |action: &Action| -> Vec<TypeId> {
        let shown = action.explicit.iter().chain(&action.object);
        shown.map(|index| action.parameters[*index].kind).collect()
    };
    let calls: Vec<Named<'_>> = domain
        .actions
        .iter()
        .map(|action| Named {
            name: &action.call,
            kinds: written(action),
            fact: None,
            place: places.call(&action.name),
        })
        .collect();
    report(reach, &calls, ("the actions", ""), &mut findings, |left, right| {
        let action = |name: &str| domain.actions.iter().find(|action| action.call == name);
        tell_apart(domain, action(left), action(right))
    });
    let states: Vec<Named<'_>> = domain
        .states
        .iter()
        .zip(&places.words.state)
        .map(|(state, entry)| {
            let parameters = &domain.predicate(state.atom.predicate).parameters;
            Named {
                name: &state.word,
                kinds: parameters.iter().map(|parameter| parameter.kind).collect(),
                fact: Some(&state.atom),
                place: places.word(&entry.word),
            }
        })
        .collect();
    report(reach, &states, ("the states", ""), &mut findings, |_, _| None);
    let goals: Vec<Named<'_>> = domain
        .goal_words
        .iter()
        .zip(&places.words.goal)
        .map(|(word, entry)| Named {
            name: &word.word,
            kinds: word.parameters.iter().map(|parameter| parameter.kind).collect(),
            fact: None,
            place: places.word(&entry.form),
        })
        .collect();
    report(reach, &goals, ("the goals", ""), &mut findings, |_, _| None);
    for (word, entry) in domain.goal_words.iter().zip(&places.words.goal) {
        let parameters: Vec<Named<'_>> = word
            .parameters
            .iter()
            .map(|parameter| Named {
                name: &parameter.name,
                kinds: vec![parameter.kind],
                fact: None,
                place: places.word(&entry.parameters),
            })
            .collect();
        let of = format!(" of the goal `{}`", entry.form.get_ref());
        report(reach, &parameters, ("the parameters", &of), &mut findings, |_, _| None);
    }
    findings
}

fn report(
    reach: &Reach<'_>,
    names: &[Named<'_>],
    (what, of): (&str, &str),
    findings: &mut Vec<Finding>,
    tell_apart: impl Fn(&str, &str) -> Option<String>,
) {
    for (index, later) in names.iter().enumerate() {
        for earlier in &names[..index] {
            let alike = |(left, right): (&TypeId, &TypeId)| reach.overlap(*left, *right);
            let same_kinds =
                later.kinds.len() == earlier.kinds.len() && later.kinds.iter().zip(&earlier.kinds).all(alike);
            let same_fact = later.fact.is_some() && later.fact == earlier.fact;
            if !same_kinds || same_fact || !are_confusable(earlier.name, later.name) {
                continue;
            }
            let (left, right) = (earlier.name, later.name);
            let hint = match tell_apart(left, right) {
                Some(difference) => format!("say in each name what only that one is for: {difference}"),
                None => "say in each name what only that one is for".to_owned(),
            };
            findings.push(Finding::new(
                Lint::ConfusableNames,
                &[left, right],
                later.place,
                format!("{what} `{left}` and `{right}`{of} take the same things, and a model will confuse their names"),
                hint,
            ));
        }
    }
}

/// Describes the difference between two actions: their parameter names, else a precondition that only one has.
fn tell_apart(domain: &Domain, left: Option<&Action>, right: Option<&Action>) -> Option<String> {
    let (left, right) = (left?, right?);
    let differing = left
        .parameters
        .iter()
        .zip(&right.parameters)
        .find(|(l, r)| l.name != r.name);
    let start = common_start(&left.call, &right.call);
    if let Some((of_left, of_right)) = differing
        && !start.is_empty()
    {
        let named = |parameter: &Parameter| format!("`{}`", joined(&left.call, &start, &parameter.name));
        return Some(format!("as in {} and {}", named(of_left), named(of_right)));
    }
    let only = |one: &Action, other: &Action| {
        let others: Vec<&Condition> = other.precondition.conjuncts().collect();
        let own = one.precondition.conjuncts();
        own.filter(|part| !others.contains(part)).find_map(|part| match part {
            Condition::Atom { atom, holds: true, .. } => {
                let needed = &domain.predicate(atom.predicate).name;
                Some(format!("only `{}` needs `{needed}`", one.call))
            }
            _ => None,
        })
    };
    only(right, left).or_else(|| only(left, right))
}

/// Returns the words that begin both names.
fn common_start(left: &str, right: &str) -> Vec<String> {
    let pairs = words_of(left).into_iter().zip(words_of(right));
    pairs.take_while(|(l, r)| l == r).map(|(word, _)| word).collect()
}

/// Joins words to a name in the style of `like`.
fn joined(like: &str, start: &[String], end: &str) -> String {
    let words: Vec<String> = start.iter().cloned().chain(words_of(end)).collect();
    let capitals = like.starts_with(char::is_uppercase);
    if !capitals {
        return words.join("_");
    }
    let capital = |word: &String| {
        let mut characters = word.chars();
        characters
            .next()
            .map(|first| first.to_uppercase().chain(characters).collect::<String>())
    };
    words.iter().filter_map(capital).collect()
}

/// Returns true if one name extends the other or they differ by one edit.
fn are_confusable(left: &str, right: &str) -> bool {
    if left == right {
        // Two forms of one goal word.
        return false;
    }
    let (left, right) = (words_of(left), words_of(right));
    if left.concat() == right.concat() {
        return true;
    }
    let (short, long) = if left.len() <= right.len() {
        (&left, &right)
    } else {
        (&right, &left)
    };
    if short.len() < long.len() {
        // A number at the end marks one of a series.
        let number = |word: &String| word.chars().all(|c| c.is_ascii_digit());
        return long.starts_with(short) && !long[short.len()..].iter().all(number);
    }
    let mut differing = left.iter().zip(&right).filter(|(l, r)| l != r);
    match (differing.next(), differing.next()) {
        (Some((l, r)), None) => differ_in_a_letter(l, r),
        _ => false,
    }
}

/// Compares words of at least four letters; shorter ones are often one letter apart and still distinct (`in` and `on`).
fn differ_in_a_letter(left: &str, right: &str) -> bool {
    left.chars().count().max(right.chars().count()) >= 4 && strsim::damerau_levenshtein(left, right) == 1
}

/// Splits a name into words in lower case: `PutIn`, `put_in` and `put-in` all give put, in.
pub(super) fn words_of(name: &str) -> Vec<String> {
    let mut words: Vec<String> = Vec::new();
    let mut last = ' ';
    for character in name.chars() {
        let begins = !last.is_alphanumeric()
            || last.is_ascii_digit() != character.is_ascii_digit()
            || (last.is_lowercase() && character.is_uppercase());
        if character.is_alphanumeric() {
            match words.last_mut() {
                Some(word) if !begins => word.extend(character.to_lowercase()),
                _ => words.push(character.to_lowercase().collect()),
            }
        }
        last = character;
    }
    words
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_are_confusable_by_a_shared_prefix_or_one_letter() {
        for (left, right, confusable) in [
            ("Put", "PutIn", true),
            ("put_in", "PutIn", true),
            ("PutIn", "Putin", true),
            ("open", "open_vent", true),
            ("reheat", "preheat", true),
            ("lift", "left", true),
            ("put", "put", false),
            ("Open", "Close", false),
            ("SwitchOn", "SwitchOff", false),
            ("PutIn", "PutOn", false),
            ("lock", "unlock", false),
            ("open_by_rotate", "open_by_slide", false),
            ("attach_to_plane", "detach_from_plane", false),
            ("arm", "arm2", false),
            ("arm1", "arm2", false),
        ] {
            assert_eq!(are_confusable(left, right), confusable, "{left} {right}");
            assert_eq!(are_confusable(right, left), confusable, "{right} {left}");
        }
    }
}
