//! Negation in instructions: "not the milk, the wine", "don't touch the cake".
//!
//! Ruled-out entities do not count as mentioned. The cues are English and deliberately narrow: "don't leave the fridge
//! open" does mention the fridge.

use super::mention::{DETERMINERS, NOT_THINGS, among};
use crate::model::plain_words;

/// Verbs that, when negated, tell the robot to leave an object alone.
const TOUCHING: &str = "touch move take use disturb want mean need bring grab pick mind bother include";
/// Words before "not" that make a statement or a condition.
const STATING: &str = "is are was were its if or whether do does am has have why";
/// Word pairs before an object that is replaced or excepted.
const IN_PLACE_OF: [[&str; 2]; 5] = [
    ["instead", "of"],
    ["rather", "than"],
    ["other", "than"],
    ["apart", "from"],
    ["except", "for"],
];
/// Endings of "leave the cup ..." after which the cup stays as it is.
const AS_IT_IS: [&str; 6] = ["alone", "be", "where it is", "where they are", "as it is", "out of it"];

/// Returns the words of an instruction that are not ruled out, or all words if none remain.
pub(super) fn asserted(instruction: &str) -> Vec<String> {
    let mut kept = Vec::new();
    for clause in instruction.split([',', '.', ';', ':', '!', '?']) {
        let words = plain_words(clause);
        let mut at = 0;
        while at < words.len() {
            match ruled_out(&words, at) {
                0 => {
                    kept.push(words[at].clone());
                    at += 1;
                }
                length => at += length,
            }
        }
    }
    match kept.is_empty() {
        true => plain_words(instruction),
        false => kept,
    }
}

/// Returns the number of words from `at` that rule something out.
fn ruled_out(words: &[String], at: usize) -> usize {
    let word = |place: usize| words.get(place).map_or("", String::as_str);
    let before = at.checked_sub(1).map_or("", word);
    let rest = &words[at..];
    // "Not the milk", in contrast to the statement "it is not the milk".
    if word(at) == "not" && among(DETERMINERS, word(at + 1)) && !among(STATING, before) {
        return 1 + noun_phrase(&words[at + 1..]);
    }
    let verb = match (word(at), word(at + 1)) {
        ("dont" | "never", _) => 1,
        ("do", "not") => 2,
        _ => 0,
    };
    if verb > 0 && among(TOUCHING, word(at + verb)) {
        return until_next_wish(rest);
    }
    let forgotten = word(at) == "forget" && !matches!(before, "dont" | "not" | "never");
    if forgotten && (among(DETERMINERS, word(at + 1)) || word(at + 1) == "about") {
        return until_next_wish(rest);
    }
    if matches!(word(at), "let" | "leave") && among(DETERMINERS, word(at + 1)) {
        let text = rest[..until_next_wish(rest)].join(" ");
        let stays = AS_IT_IS.iter().any(|ending| text.ends_with(&format!(" {ending}")));
        return if stays { until_next_wish(rest) } else { 0 };
    }
    if IN_PLACE_OF
        .iter()
        .any(|[first, second]| word(at) == *first && word(at + 1) == *second)
    {
        return 2 + noun_phrase(&words[at + 2..]);
    }
    match word(at) {
        "except" => 1 + noun_phrase(&words[at + 1..]),
        "but" if matches!(before, "everything" | "anything" | "nothing" | "all") => 1 + noun_phrase(&words[at + 1..]),
        _ => 0,
    }
}

/// Returns the length of a noun phrase: its article and the words up to one that names no object.
fn noun_phrase(words: &[String]) -> usize {
    let article = usize::from(words.first().is_some_and(|word| among(DETERMINERS, word)));
    let names = words[article..].iter().take_while(|word| !among(NOT_THINGS, word));
    article + names.count()
}

/// Returns the number of words until "and" begins another clause: "... and put the milk away", not "... and the milk".
fn until_next_wish(words: &[String]) -> usize {
    let begins = |place: &usize| {
        let next = words.get(place + 1);
        matches!(words[*place].as_str(), "and" | "but" | "just") && next.is_some_and(|next| !among(DETERMINERS, next))
    };
    (1..words.len()).find(begins).unwrap_or(words.len())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(instruction: &str, expected: &str) {
        assert_eq!(asserted(instruction).join(" "), expected, "{instruction}");
    }

    #[test]
    fn what_is_ruled_out_is_not_said() {
        check("Not the milk, the wine: take that out", "the wine take that out");
        check("Bring me the pen, not the red pencil", "bring me the pen");
        check(
            "Don't touch the cake, but put the jam on the shelf",
            "but put the jam on the shelf",
        );
        check(
            "Do not move the lamp and put the book on the desk",
            "and put the book on the desk",
        );
        check(
            "No, let the dog be. It's the cat that I want fed.",
            "no its the cat that i want fed",
        );
        check("Leave the vase where it is and wipe the table", "and wipe the table");
        check("Forget the soup", "forget the soup");
        check("Forget about the soup, heat the pie", "heat the pie");
        check(
            "Put the juice on the table instead of the shelf",
            "put the juice on the table",
        );
        check(
            "Take the fork rather than the big spoon to the sink",
            "take the fork to the sink",
        );
        check(
            "Put everything but the lamp on the shelf",
            "put everything on the shelf",
        );
    }

    #[test]
    fn what_only_sounds_so_stays() {
        check("Don't leave the fridge open", "dont leave the fridge open");
        check("Don't forget the milk", "dont forget the milk");
        check("If it is not the red one, bin it", "if it is not the red one bin it");
        check("Leave the fridge open", "leave the fridge open");
        check("Leave the keys on the table", "leave the keys on the table");
        check("Do not put the pan on the stove", "do not put the pan on the stove");
    }
}
