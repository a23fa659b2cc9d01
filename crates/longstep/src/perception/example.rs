//! Worked examples from the state words of a domain, about things that no domain of this library has.

use super::sentence::{self, OTHER, Said, capitalized};
use super::sighting::{Sighting, Statement};
use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::model::StateWord;
use longstep_core::model::SpatialRelation;

const PLACES: [&str; 3] = ["workbench", "chest", "wagon"];
const THINGS: [&str; 4] = ["lantern", "rope", "drum", "bell"];

/// A description: its sentences, each with what it says in plain sentences.
pub(super) struct SightExample {
    pub(super) parts: Vec<(String, String)>,
}

impl SightExample {
    fn new(parts: impl IntoIterator<Item = (String, String)>) -> Self {
        Self {
            parts: parts.into_iter().collect(),
        }
    }

    /// Returns the description.
    pub(super) fn text(&self) -> String {
        let sentences: Vec<&str> = self.parts.iter().map(|(text, _)| text.as_str()).collect();
        sentences.join(" ")
    }

    /// Returns what the description says.
    pub(super) fn said(&self, vocabulary: &Vocabulary<'_>) -> Vec<Said> {
        self.parts
            .iter()
            .flat_map(|(_, plain)| sentence::read(vocabulary, plain))
            .collect()
    }

    /// Returns the names with their lists, in the order of the plain sentences.
    pub(super) fn names(&self, vocabulary: &Vocabulary<'_>) -> Vec<(String, List)> {
        let names = sentence::names(vocabulary, &self.said(vocabulary)).into_iter();
        let list = |name: &String| {
            if PLACES.contains(&name.as_str()) {
                List::Assets
            } else {
                List::Objects
            }
        };
        names.map(|name| (name.clone(), list(&name))).collect()
    }
}

/// A person's words about a sighting, with the sentences that are different.
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

    /// Returns the plain sentence of a state.
    fn plain(&self, word: &StateWord, subject: &str, place: Option<&str>) -> String {
        let state = Call {
            name: word.word.clone(),
            arguments: place.iter().map(|place| (*place).to_owned()).collect(),
        };
        let subject = subject.to_owned();
        let sentence = Sighting::sentence(self.vocabulary, &Statement { subject, state });
        capitalized(&sentence.unwrap_or_default()) + "."
    }

    /// Returns the short form of a relation to a place: "on the workbench".
    fn short(&self, word: &StateWord, place: &str) -> Option<String> {
        self.vocabulary.short(word, &|_| place.to_owned())
    }

    fn relation(&self, relation: SpatialRelation) -> Option<&'a StateWord> {
        self.places
            .iter()
            .copied()
            .find(|word| word.relations.contains(&relation))
    }
}

/// Makes examples from the words of a domain: other languages, states of one entity, a sentence for each relation, and
/// several entities in a place.
pub(super) fn sight_examples(vocabulary: &Vocabulary<'_>) -> Vec<SightExample> {
    let words = Words::of(vocabulary);
    let mut examples = foreign(&words);
    examples.push(relations(&words));
    examples.extend(words.places.first().and_then(|word| several(&words, word)));
    examples.push(states(&words));
    examples.extend(words.places.get(1).and_then(|word| nested(&words, word)));
    examples
}

/// Descriptions in other languages, for domains with words for on and inside.
fn foreign(words: &Words<'_>) -> Vec<SightExample> {
    let relation = |relation: SpatialRelation| words.relation(relation);
    let (Some(on), Some(inside)) = (relation(SpatialRelation::On), relation(SpatialRelation::Inside)) else {
        return Vec::new();
    };
    let plain = |word: &StateWord, thing: &str, place: &str| words.plain(word, thing, Some(place));
    let ropes = [
        plain(on, "rope_1", "workbench"),
        plain(on, "rope_2", "workbench"),
        plain(inside, "bell", "chest"),
    ];
    let bells = ["bell_1", "bell_2", "bell_3", "bell_4"].map(|bell| plain(inside, bell, "chest"));
    vec![
        SightExample::new([(
            "Op de werkbank liggen twee touwen, en in de kist ligt een bel.".to_owned(),
            ropes.join(" "),
        )]),
        SightExample::new([
            ("마차 위에 등불이 있습니다.".to_owned(), plain(on, "lantern", "wagon")),
            ("궤짝 안에 북이 있습니다.".to_owned(), plain(inside, "drum", "chest")),
        ]),
        SightExample::new([("Há quatro sinos dentro do baú.".to_owned(), bells.join(" "))]),
    ]
}

/// A sentence for each relation, after one that only names places.
fn relations(words: &Words<'_>) -> SightExample {
    let places = format!("There is a {} and a {}.", PLACES[0], PLACES[1]);
    let named = format!("There is a {}. There is a {}.", PLACES[0], PLACES[1]);
    let sentences = words.places.iter().take(THINGS.len()).enumerate().map(|(index, word)| {
        let plain = words.plain(word, THINGS[index], Some(PLACES[index % 2]));
        (plain.clone(), plain)
    });
    SightExample::new(std::iter::once((places, named)).chain(sentences))
}

/// Several entities of a kind in one place, and a place with what is there: "a wagon with a drum on it".
fn several(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let [first, _, other] = PLACES;
    let at = words.short(word, &format!("a {first}"))?;
    let objects = ["bell_1", "bell_2", "bell_3", "rope"];
    let plain: Vec<String> = objects
        .iter()
        .map(|name| words.plain(word, name, Some(first)))
        .collect();
    let mut parts = vec![(format!("Three bells and a rope {at}."), plain.join(" "))];
    if let Some(within) = words
        .places
        .get(1)
        .and_then(|word| Some((*word, words.short(word, "it")?)))
    {
        let plain = words.plain(within.0, "drum", Some(other));
        parts.push((format!("There is a {other} with a drum {}.", within.1), plain));
    }
    Some(SightExample::new(parts))
}

/// States of one entity, and relations and remarks for which the domain has no word.
fn states(words: &Words<'_>) -> SightExample {
    let mut parts = Vec::new();
    for (index, word) in words.of_places.iter().take(2).enumerate() {
        let plain = words.plain(word, PLACES[index], None);
        parts.push((plain.clone(), plain));
    }
    let own = words
        .of_things
        .iter()
        .filter(|word| words.of_places.iter().all(|other| other.word != word.word));
    for (index, word) in own.take(2).enumerate() {
        let plain = words.plain(word, THINGS[index], None);
        // People say it of the robot, whatever the domain says of its hand.
        let text = if word.relations.contains(&SpatialRelation::Held) {
            format!("The robot holds a {}.", THINGS[index])
        } else {
            plain.clone()
        };
        parts.push((text, plain));
    }
    for word in ["under", "behind"] {
        let is_said = |own: &StateWord| own.word.contains(word) || own.means.contains(word);
        if !words.vocabulary.words().any(is_said) {
            let [thing, place] = if word == "under" {
                ["drum", PLACES[2]]
            } else {
                ["ladder", PLACES[1]]
            };
            let plain = format!("There is a {thing}. There is a {place}. {OTHER}the {thing} is {word} the {place}.");
            parts.push((format!("A {thing} is {word} the {place}."), plain));
        }
    }
    let empty = |own: &StateWord| own.word.contains("empty");
    if !words.vocabulary.words().any(empty) {
        let place = PLACES[0];
        parts.push((format!("The {place} is empty."), format!("There is a {place}.")));
    }
    SightExample::new(parts)
}

/// Objects in a thing that is in a place.
fn nested(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let first = words.places.first()?;
    let [place, outer] = [PLACES[2], "bag"];
    let within = words.short(word, "it")?;
    let at = words.short(first, &format!("the {place}"))?;
    let plain = [
        words.plain(first, outer, Some(place)),
        words.plain(word, "lantern_1", Some(outer)),
        words.plain(word, "lantern_2", Some(outer)),
    ];
    let text = format!(
        "{} is a {outer}, and {within} there are two lanterns.",
        capitalized(&at)
    );
    Some(SightExample::new([(text, plain.join(" "))]))
}

/// Makes examples of corrections: a place that changes, and an entity that is not there.
pub(super) fn correction_examples(vocabulary: &Vocabulary<'_>) -> Vec<CorrectionExample> {
    let words = Words::of(vocabulary);
    let example = relations(&words);
    let before = sentence::sighting(example.said(vocabulary), &example.names(vocabulary));
    let mut examples = Vec::new();
    let mut add = |text: String, answer: String| {
        let before = before.clone();
        examples.push(CorrectionExample { before, text, answer });
    };
    if let Some(word) = words.places.first() {
        let answer = words.plain(word, THINGS[0], Some(PLACES[1]));
        add(format!("No, {}", answer.to_lowercase()), answer);
        if let Some(at) = words.short(word, &format!("the {}", PLACES[0])) {
            let answer = words.plain(word, "candle", Some(PLACES[0]));
            add(format!("There is also a candle {at}."), answer);
        }
    }
    if let Some(word) = words.of_places.first() {
        let answer = words.plain(word, PLACES[1], None);
        add(format!("Look again: {}", answer.to_lowercase()), answer);
    }
    if let Some(gone) = before.objects.last() {
        add(format!("I see no {gone}."), format!("There is no {gone}."));
    }
    examples
}
