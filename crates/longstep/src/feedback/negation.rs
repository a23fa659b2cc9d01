//! The negated part of an utterance about a plan.

use crate::model::plain_words;

/// Words that begin a negation, up to the next punctuation mark or "but".
const DENYING: [&str; 7] = ["not", "dont", "isnt", "wasnt", "never", "neither", "nor"];

/// Splits an utterance into its asserted and its negated part: "not that plate, the blue one" gives "the blue one" and
/// "that plate".
pub(super) fn parts(said: &str) -> (String, String) {
    let (mut meant, mut denied) = (String::new(), String::new());
    for clause in said.split([',', '.', ';', '!', '?', ':']) {
        let mut denying = false;
        let words: Vec<&str> = clause.split_whitespace().collect();
        for (at, word) in words.iter().enumerate() {
            let plain = plain_words(word).concat();
            let pair =
                |first: &str, second: &str| plain == first && words.get(at + 1).is_some_and(|next| *next == second);
            if DENYING.contains(&plain.as_str()) || pair("instead", "of") || pair("rather", "than") {
                denying = true;
            } else if plain == "but" {
                denying = false;
            }
            let part = if denying { &mut denied } else { &mut meant };
            part.push_str(word);
            part.push(' ');
        }
        meant.push_str(", ");
    }
    (meant, denied)
}
