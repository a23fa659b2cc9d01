//! The hand that a name means: of a topic, a column, a marker, a rigid body.

use crate::demonstration::Hand;

/// The most names in a message.
const NAMES: usize = 6;

/// The words that a name of a hand has.
const HAND: [&str; 4] = ["hand", "wrist", "gripper", "palm"];

/// Chooses the names that stand for hands. A hand that no name says is `fallback`.
///
/// # Errors
///
/// A sentence with the names, if they do not say which one is the hand.
pub(super) fn hands_among(names: &[&str], fallback: Hand) -> Result<Vec<(usize, Hand)>, String> {
    if let [only] = names {
        return Ok(vec![(0, side_of(only).unwrap_or(fallback))]);
    }
    let named: Vec<(usize, Vec<String>)> = names.iter().map(|name| words(name)).enumerate().collect();
    let of = |hand: Hand| {
        let own: Vec<_> = named.iter().filter(|(_, words)| side(words) == Some(hand)).collect();
        only_hand(&own)
    };
    let sides: Vec<(usize, Hand)> = [Hand::Left, Hand::Right]
        .into_iter()
        .filter_map(|hand| Some((of(hand)?, hand)))
        .collect();
    if !sides.is_empty() {
        return Ok(sides);
    }
    let all: Vec<_> = named.iter().collect();
    match only_hand(&all) {
        Some(index) => Ok(vec![(index, fallback)]),
        None => Err(format!(
            "{} have positions, and no name says which one is the hand; keep one, or name it `hand`, or two `left_hand` and \
             `right_hand`",
            listed(names)
        )),
    }
}

/// Returns the only one of these names, or the only one that names a hand.
fn only_hand(names: &[&(usize, Vec<String>)]) -> Option<usize> {
    if let [(index, _)] = names {
        return Some(*index);
    }
    let is_hand = |words: &[String]| words.iter().any(|word| HAND.iter().any(|own| word.ends_with(own)));
    let mut hands = names.iter().filter(|(_, words)| is_hand(words));
    match (hands.next(), hands.next()) {
        (Some((index, _)), None) => Some(*index),
        _ => None,
    }
}

/// Returns the hand that a name says.
pub(super) fn side_of(name: &str) -> Option<Hand> {
    side(&words(name))
}

fn side(words: &[String]) -> Option<Hand> {
    let begins = |hand: Hand| words.iter().any(|word| word.starts_with(hand.name()));
    match (begins(Hand::Left), begins(Hand::Right)) {
        (true, false) => Some(Hand::Left),
        (false, true) => Some(Hand::Right),
        _ => None,
    }
}

/// Splits a name into words: `/leftHand_2` has `left` and `hand`.
fn words(name: &str) -> Vec<String> {
    let mut words = vec![String::new()];
    let mut before = ' ';
    for letter in name.chars() {
        if !letter.is_alphabetic() || (letter.is_uppercase() && before.is_lowercase()) {
            words.push(String::new());
        }
        if let Some(word) = words.last_mut().filter(|_| letter.is_alphabetic()) {
            word.extend(letter.to_lowercase());
        }
        before = letter;
    }
    words.retain(|word| !word.is_empty());
    words
}

/// Lists names for a message.
pub(super) fn listed(names: &[&str]) -> String {
    let quoted = |name: &&str| format!("`{}`", super::shortened(name));
    let mut list = names.iter().take(NAMES).map(quoted).collect::<Vec<_>>().join(", ");
    if names.len() > NAMES {
        list.push_str(&format!(" and {} more", names.len() - NAMES));
    }
    list
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn recording_names_identify_the_hand() {
        use Hand::{Left, Right};
        for (names, expected) in [
            (&["/hand"][..], Some(vec![(0, Right)])),
            (&["/teleop/leftHand/pose"], Some(vec![(0, Left)])),
            (&["upright"], Some(vec![(0, Right)])),
            (&["L_Shoulder", "Hand 1"], Some(vec![(1, Right)])),
            (&["/left_hand", "/right_hand"], Some(vec![(0, Left), (1, Right)])),
            (&["left_elbow", "left_wrist", "head"], Some(vec![(1, Left)])),
            (&["/camera", "/base"], None),
            (&["/hand_1", "/hand_2"], None),
        ] {
            assert_eq!(hands_among(names, Right).ok(), expected, "{names:?}");
        }
    }
}
