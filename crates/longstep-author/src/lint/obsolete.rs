//! Keys without effect.

use super::places::Places;
use super::{Finding, Lint};

/// Returns a finding for each key of `domain.toml` that has no effect any more.
pub(super) fn findings(places: &Places<'_>) -> Vec<Finding> {
    let words = &places.words;
    let of_goals = words.goal.iter().flat_map(|goal| {
        let keys = [
            ("cues", &goal.cues),
            ("destination_verbs", &goal.destination_verbs),
            ("yields_to", &goal.yields_to),
            ("phrases", &goal.phrases),
        ];
        let given = keys.into_iter().filter_map(|(key, value)| Some((key, value.as_ref()?)));
        given.map(|(key, value)| (key, goal.form.get_ref().as_str(), value))
    });
    let predicates = words.predicate.iter();
    let of_outcomes =
        predicates.filter_map(|entry| Some(("cues", entry.name.get_ref().as_str(), entry.cues.as_ref()?)));
    of_outcomes
        .chain(of_goals)
        .map(|(key, named, value)| {
            let message =
                format!("`{key}` has no effect: what an instruction asks for is understood without lists of words");
            Finding::new(
                Lint::ObsoleteKey,
                &[named],
                places.word(value),
                message,
                "take it out; everyday names of entities go to `[lexicon]`, and examples to prompt/examples.toml",
            )
        })
        .collect()
}
