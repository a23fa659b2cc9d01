//! Claims of a step: facts that its explanation asserts to hold after it.
//!
//! The paper's scripts write them in the comment, after the sentence:
//! `place it on the shelf; <spam>: on_something(<shelf>)`. Semicolons separate the claims of different entities, commas
//! separate several state words of one entity.

use longstep_model::call::Call;

/// Parts of an explanation.
#[derive(Debug, PartialEq, Eq)]
pub(crate) struct ExplanationParts<'t> {
    /// Description of the step for the user.
    pub(crate) sentence: &'t str,
    /// Claimed state words with the entity that each applies to, in order.
    pub(crate) claims: Vec<(&'t str, Call)>,
}

/// Splits an explanation into the sentence and the claims.
pub(crate) fn split_claims(explanation: &str) -> ExplanationParts<'_> {
    let mut sentence = explanation;
    let mut parts = Vec::new();
    loop {
        let (before, last) = match sentence.rsplit_once(';') {
            Some((before, last)) => (before, last),
            None => ("", sentence),
        };
        let Some(claims) = claims(last.trim()) else {
            break;
        };
        parts.push(claims);
        sentence = before;
        if before.is_empty() {
            break;
        }
    }
    ExplanationParts {
        sentence: sentence.trim(),
        claims: parts.into_iter().rev().flatten().collect(),
    }
}

/// Parses `<entity>: word(...), word(...)`.
fn claims(text: &str) -> Option<Vec<(&str, Call)>> {
    let end = text.starts_with('<').then(|| text.find('>'))?? + 1;
    let (entity, words) = (&text[..end], text[end..].trim_start().strip_prefix(':')?);
    let mut claims = Vec::new();
    let mut rest = words.trim();
    while !rest.is_empty() {
        let end = rest.find(')')? + 1;
        claims.push((entity, Call::parse(&rest[..end]).ok()?));
        rest = rest[end..].trim_start();
        rest = match rest.strip_prefix(',') {
            Some(more) => more.trim_start(),
            None if rest.is_empty() => rest,
            None => return None,
        };
    }
    (!claims.is_empty()).then_some(claims)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(explanation: &str, sentence: &str, claims: &[&str]) {
        let split = split_claims(explanation);
        let found: Vec<String> = split
            .claims
            .iter()
            .map(|(entity, call)| format!("{entity} {call}"))
            .collect();
        assert_eq!(
            (split.sentence, found.as_slice()),
            (
                sentence,
                &claims.iter().map(|c| (*c).to_owned()).collect::<Vec<_>>()[..]
            )
        );
    }

    #[test]
    fn claims_are_read_after_the_step_sentence() {
        check("take the cup", "take the cup", &[]);
        check("", "", &[]);
        check("take it; <cup>: inside_hand()", "take it", &["<cup> inside_hand()"]);
        check("<cup>: on(<rack>)", "", &["<cup> on(<rack>)"]);
        check(
            "do; it; <cup>: on(<rack>), dry() ; <rack>:full( )",
            "do; it",
            &["<cup> on(<rack>)", "<cup> dry()", "<rack> full()"],
        );
        check("see; <cup>: nice", "see; <cup>: nice", &[]);
        check("see; <cup>: on(<a>) and more", "see; <cup>: on(<a>) and more", &[]);
        check("; <cup>: dry()", "", &["<cup> dry()"]);
    }
}
