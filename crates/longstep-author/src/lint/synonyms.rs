//! Lints about everyday names that name nothing.

use super::places::Places;
use super::{Finding, Lint};
use longstep::domain::{Files, base_name, plain_words, stem};
use longstep_core::environment::World;

/// Finds entries of `[lexicon]` that no identifier can have, and names that no instruction can contain.
pub(super) fn findings(places: &Places<'_>) -> Vec<Finding> {
    let mut findings = Vec::new();
    for (name, synonyms) in &places.words.lexicon {
        let written = name.get_ref().as_str();
        if ![base_name(written), stem(written)].iter().any(|form| form == written) {
            findings.push(Finding::new(
                Lint::UnmatchedName,
                &[written],
                places.word(name),
                format!("the entry `{written}` of `[lexicon]` matches no identifier: they are compared in lower case, without brackets and number"),
                format!("write `{}`", stem(written)),
            ));
        }
        if synonyms.is_empty() {
            findings.push(Finding::new(
                Lint::UnmatchedName,
                &[written],
                places.word(name),
                format!("the entry `{written}` of `[lexicon]` has no names, so it changes nothing"),
                "add the names that people use, or take the entry out",
            ));
        }
    }
    let synonyms = places.words.lexicon.iter().flat_map(|(name, all)| {
        let of_entry = move |own| (name.get_ref().as_str(), own);
        all.iter().map(of_entry)
    });
    let keys = [
        ("speaker_names", &places.words.speaker_names),
        ("robot_names", &places.words.robot_names),
    ];
    let of_persons = keys
        .into_iter()
        .flat_map(|(key, names)| names.iter().map(move |own| (key, own)));
    for (entry, text) in synonyms.chain(of_persons) {
        if plain_words(text.get_ref()).is_empty() {
            findings.push(Finding::new(
                Lint::UnmatchedName,
                &[entry, text.get_ref()],
                places.word(text),
                format!(
                    "the name `{}` of `{entry}` has no letters and digits, so no instruction can contain it",
                    text.get_ref()
                ),
                "write a word that people say, or take it out",
            ));
        }
    }
    findings
}

/// Finds entries of `[lexicon]` that match no entity of the environment.
pub(super) fn unmatched_in(world: &World, files: &Files) -> Vec<Finding> {
    let Some(places) = Places::read(files) else {
        return Vec::new();
    };
    let is_matched = |written: &str| {
        world.entities().any(|(_, entity)| {
            let identifier = &entity.identifier;
            base_name(identifier) == written || stem(identifier) == written
        })
    };
    let unmatched = places
        .words
        .lexicon
        .iter()
        .filter(|(name, _)| !is_matched(name.get_ref()));
    let findings = unmatched.map(|(name, synonyms)| {
        let written = name.get_ref().as_str();
        let texts: Vec<&str> = synonyms.iter().map(|own| own.get_ref().as_str()).collect();
        Finding::new(
            Lint::IdleName,
            &[written],
            places.word(name),
            format!("no entity of the environment is a `{written}`, so {} mean nothing here", super::quoted(&texts)),
            "harmless if the names are for other environments; otherwise write the end of an identifier, without its number",
        )
    });
    findings.collect()
}
