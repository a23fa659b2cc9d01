//! Worked examples from the state words of a domain, about things that no domain of this library has.

use super::sighting::{Sighting, Statement};
use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::model::StateWord;

const PLACES: [&str; 3] = ["workbench", "chest", "wagon"];
const THINGS: [&str; 4] = ["lantern", "rope", "drum", "bell"];

/// A description with the sighting of it.
pub(super) struct SightExample {
    pub(super) text: String,
    pub(super) sighting: Sighting,
}

/// What a person says about a sighting, with the lines that change.
pub(super) struct CorrectionExample {
    pub(super) before: Sighting,
    pub(super) text: String,
    pub(super) answer: String,
}

/// The words for relations between an object and an asset, and for states of one entity.
struct Words<'a> {
    vocabulary: &'a Vocabulary<'a>,
    places: Vec<&'a StateWord>,
    of_things: Vec<&'a StateWord>,
    of_places: Vec<&'a StateWord>,
}

impl<'a> Words<'a> {
    fn of(vocabulary: &'a Vocabulary<'a>) -> Self {
        let with = |list: List, arguments: usize| {
            let fits = move |word: &&StateWord| {
                word.parameters.len() == arguments
                    && vocabulary.fits(word, 0, list)
                    && (1..=arguments).all(|slot| vocabulary.fits(word, slot, List::Assets))
            };
            vocabulary.words().filter(fits).collect()
        };
        Self {
            vocabulary,
            places: with(List::Objects, 1),
            of_things: with(List::Objects, 0),
            of_places: with(List::Assets, 0),
        }
    }

    fn statement(&self, word: &StateWord, subject: &str, place: Option<&str>) -> (String, Statement) {
        let name = |slot: usize| format!("the {}", if slot == 0 { subject } else { place.unwrap_or_default() });
        let mut sentence = self.vocabulary.sentence(word, &name);
        sentence.push('.');
        let arguments = place.iter().map(|place| (*place).to_owned()).collect();
        let state = Call {
            name: word.word.clone(),
            arguments,
        };
        let subject = subject.to_owned();
        (capitalized(&sentence), Statement { subject, state })
    }
}

/// Makes examples from the words of a domain: other languages, states of one entity, a sentence for each relation, and
/// several entities in a place.
pub(super) fn sight_examples(vocabulary: &Vocabulary<'_>) -> Vec<SightExample> {
    let words = Words::of(vocabulary);
    let mut examples = foreign();
    examples.push(states(&words));
    examples.push(relations(&words));
    examples.extend(words.places.first().and_then(|word| several(&words, word)));
    examples.extend(words.places.get(1).and_then(|word| nested(&words, word)));
    examples.extend(equipped(&words));
    examples
}

/// Descriptions without states, in other languages.
fn foreign() -> Vec<SightExample> {
    let all: [(&str, &str, &[&str]); 2] = [
        (
            "Da sind ein Wagen, zwei Seile und eine Glocke.",
            "wagon",
            &["rope_1", "rope_2", "bell"],
        ),
        ("馬車とランタンがあります。", "wagon", &["lantern"]),
    ];
    let example = |(text, asset, objects): (&str, &str, &[&str])| SightExample {
        text: text.to_owned(),
        sighting: Sighting {
            assets: vec![asset.to_owned()],
            objects: objects.iter().map(|name| (*name).to_owned()).collect(),
            ..Sighting::default()
        },
    };
    all.into_iter().map(example).collect()
}

/// Places with what is there: "a workbench with a lantern on it".
fn equipped(words: &Words<'_>) -> Option<SightExample> {
    let (mut parts, mut sighting) = (Vec::new(), Sighting::default());
    for (index, word) in words.places.iter().take(PLACES.len()).enumerate() {
        let Some(short) = words.vocabulary.short(word, &|_| "it".to_owned()) else {
            continue;
        };
        let (place, thing) = (PLACES[index], THINGS[THINGS.len() - 1 - index]);
        parts.push(format!("a {place} with a {thing} {short}"));
        sighting.assets.push(place.to_owned());
        sighting.objects.push(thing.to_owned());
        sighting.statements.push(words.statement(word, thing, Some(place)).1);
    }
    let text = format!("There is {}.", parts.join(", and "));
    (!parts.is_empty()).then_some(SightExample { text, sighting })
}

/// One sentence for each relation.
fn relations(words: &Words<'_>) -> SightExample {
    let mut text = format!("There is a {} and a {}.", PLACES[0], PLACES[1]);
    let mut sighting = Sighting {
        assets: PLACES[..2].iter().map(|name| (*name).to_owned()).collect(),
        ..Sighting::default()
    };
    for (index, word) in words.places.iter().take(THINGS.len()).enumerate() {
        let (sentence, statement) = words.statement(word, THINGS[index], Some(PLACES[index % 2]));
        text.push(' ');
        text.push_str(&sentence);
        sighting.objects.push(THINGS[index].to_owned());
        sighting.statements.push(statement);
    }
    SightExample { text, sighting }
}

/// Several entities of a kind in one place.
fn several(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let place = PLACES[0];
    let short = words.vocabulary.short(word, &|_| format!("a {place}"))?;
    let objects = ["rope_1", "rope_2", "bell"];
    let statements = objects.map(|name| words.statement(word, name, Some(place)).1);
    Some(SightExample {
        text: format!("Two ropes and a bell {short}."),
        sighting: Sighting {
            assets: vec![place.to_owned()],
            objects: objects.map(str::to_owned).to_vec(),
            statements: statements.to_vec(),
            ..Sighting::default()
        },
    })
}

/// An object in a place that is in another one.
fn nested(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let first = words.places.first()?;
    let [place, outer, inner] = [PLACES[2], THINGS[2], THINGS[0]];
    let within = words.vocabulary.short(word, &|_| "it".to_owned())?;
    let at = words.vocabulary.short(first, &|_| format!("the {place}"))?;
    Some(SightExample {
        text: format!("{} is a {outer}, and {within} a {inner}.", capitalized(&at)),
        sighting: Sighting {
            assets: vec![place.to_owned()],
            objects: vec![outer.to_owned(), inner.to_owned()],
            statements: vec![
                words.statement(first, outer, Some(place)).1,
                words.statement(word, inner, Some(outer)).1,
            ],
            ..Sighting::default()
        },
    })
}

/// States of one entity; a last one of which nothing is said.
fn states(words: &Words<'_>) -> SightExample {
    let (mut text, mut sighting) = (String::new(), Sighting::default());
    for (index, word) in words.of_places.iter().take(2).enumerate() {
        let (sentence, statement) = words.statement(word, PLACES[index], None);
        text = format!("{text}{sentence} ");
        sighting.assets.push(PLACES[index].to_owned());
        sighting.statements.push(statement);
    }
    let own = words
        .of_things
        .iter()
        .filter(|word| words.of_places.iter().all(|other| other.word != word.word));
    let both = words
        .of_things
        .iter()
        .filter(|word| !words.of_places.is_empty() && word.parameters.is_empty());
    for (index, word) in own.chain(both).take(2).enumerate() {
        let (sentence, statement) = words.statement(word, THINGS[index], None);
        text = format!("{text}{sentence} ");
        sighting.objects.push(THINGS[index].to_owned());
        sighting.statements.push(statement);
    }
    text.push_str("A drum is there too.");
    sighting.objects.push("drum".to_owned());
    SightExample { text, sighting }
}

/// Makes examples of corrections: a place that changes, and an entity that is not there.
pub(super) fn correction_examples(vocabulary: &Vocabulary<'_>) -> Vec<CorrectionExample> {
    let words = Words::of(vocabulary);
    let SightExample { sighting: before, .. } = relations(&words);
    let mut examples = Vec::new();
    if let Some(word) = words.places.first() {
        let (text, statement) = words.statement(word, THINGS[0], Some(PLACES[1]));
        examples.push(CorrectionExample {
            before: before.clone(),
            text,
            answer: format!("{}: {}", THINGS[0], statement.state),
        });
        let (_, added) = words.statement(word, "candle", Some(PLACES[0]));
        if let Some(short) = words.vocabulary.short(word, &|_| format!("the {}", PLACES[0])) {
            examples.push(CorrectionExample {
                before: before.clone(),
                text: format!("There is also a candle {short}."),
                answer: format!("new candle: {}", added.state),
            });
        }
    }
    if let Some(word) = words.of_places.first() {
        let (text, statement) = words.statement(word, PLACES[1], None);
        examples.push(CorrectionExample {
            before: before.clone(),
            text,
            answer: format!("{}: {}", PLACES[1], statement.state),
        });
    }
    if let Some(gone) = before.objects.last().cloned() {
        examples.push(CorrectionExample {
            text: format!("There is no {gone}."),
            answer: format!("absent {gone}"),
            before,
        });
    }
    examples
}

fn capitalized(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}
