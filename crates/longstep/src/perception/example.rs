//! Worked examples from the state words of a domain, about things that no domain of this library has.

use super::sentence::capitalized;
use super::sighting::{Sighting, Statement};
use super::vocabulary::{List, Vocabulary};
use crate::call::Call;
use crate::model::StateWord;
use longstep_core::model::SpatialRelation;

const PLACES: [&str; 3] = ["workbench", "chest", "wagon"];
const THINGS: [&str; 4] = ["lantern", "rope", "drum", "bell"];

/// A description with the sighting of it.
pub(super) struct SightExample {
    pub(super) text: String,
    pub(super) sighting: Sighting,
    /// The names in the order of the text, if it is not in English.
    order: Vec<String>,
}

impl SightExample {
    fn new(text: impl Into<String>, sighting: Sighting) -> Self {
        Self {
            text: text.into(),
            sighting,
            order: Vec::new(),
        }
    }

    /// Returns the names in the order of the text.
    pub(super) fn names(&self) -> Vec<(&str, List)> {
        let mut names = self.sighting.names();
        let bare = |name: &str| {
            name.trim_end_matches(|c: char| c == '_' || c.is_ascii_digit())
                .to_owned()
        };
        names.sort_by_key(|(name, _)| match self.order.iter().position(|own| own == name) {
            Some(place) => place,
            None => self.text.to_lowercase().find(&bare(name)).unwrap_or(usize::MAX),
        });
        names
    }
}

/// What a person says about a sighting, with the sentences that are different.
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
        let arguments = place.iter().map(|place| (*place).to_owned()).collect();
        let state = Call {
            name: word.word.clone(),
            arguments,
        };
        let subject = subject.to_owned();
        let statement = Statement { subject, state };
        let sentence = Sighting::sentence(self.vocabulary, &statement).unwrap_or_default();
        (capitalized(&sentence) + ".", statement)
    }
}

/// Makes examples from the words of a domain: other languages, states of one entity, a sentence for each relation, and
/// several entities in a place.
pub(super) fn sight_examples(vocabulary: &Vocabulary<'_>) -> Vec<SightExample> {
    let words = Words::of(vocabulary);
    let mut examples = foreign(&words);
    examples.push(states(&words));
    examples.push(relations(&words));
    examples.extend(words.places.first().and_then(|word| several(&words, word)));
    examples.extend(words.places.get(1).and_then(|word| nested(&words, word)));
    examples.extend(equipped(&words));
    examples
}

/// Descriptions in other languages, for domains with words for on and inside.
fn foreign(words: &Words<'_>) -> Vec<SightExample> {
    let of = |relation: SpatialRelation| words.places.iter().find(|word| word.relations.contains(&relation));
    let (Some(on), Some(inside)) = (of(SpatialRelation::On), of(SpatialRelation::Inside)) else {
        return Vec::new();
    };
    let dutch = [
        ("rope_1", on, "workbench"),
        ("rope_2", on, "workbench"),
        ("bell", inside, "chest"),
    ];
    let korean = [("lantern", on, "wagon"), ("drum", inside, "chest")];
    let texts = [
        (
            "Op de werkbank liggen twee touwen, en in de kist ligt een bel.",
            &dutch[..],
        ),
        ("마차 위에 등불이 있습니다. 궤짝 안에 북이 있습니다.", &korean[..]),
    ];
    let example = |(text, entries): (&str, &[(&str, &&StateWord, &str)])| {
        let mut example = SightExample::new(text, Sighting::default());
        for (thing, word, place) in entries {
            let sighting = &mut example.sighting;
            if !sighting.assets.iter().any(|own| own == place) {
                sighting.assets.push((*place).to_owned());
                example.order.push((*place).to_owned());
            }
            example.order.push((*thing).to_owned());
            sighting.objects.push((*thing).to_owned());
            sighting.statements.push(words.statement(word, thing, Some(place)).1);
        }
        example
    };
    texts.into_iter().map(example).collect()
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
    (!parts.is_empty()).then(|| SightExample::new(text, sighting))
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
    SightExample::new(text, sighting)
}

/// Several entities of a kind in one place.
fn several(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let place = PLACES[0];
    let short = words.vocabulary.short(word, &|_| format!("a {place}"))?;
    let objects = ["bell_1", "bell_2", "bell_3", "rope"];
    let sighting = Sighting {
        assets: vec![place.to_owned()],
        objects: objects.map(str::to_owned).to_vec(),
        statements: objects.map(|name| words.statement(word, name, Some(place)).1).to_vec(),
        ..Sighting::default()
    };
    Some(SightExample::new(format!("Three bells and a rope {short}."), sighting))
}

/// An object in a place that is in another one.
fn nested(words: &Words<'_>, word: &StateWord) -> Option<SightExample> {
    let first = words.places.first()?;
    let [place, outer, inner] = [PLACES[2], THINGS[2], THINGS[0]];
    let within = words.vocabulary.short(word, &|_| "it".to_owned())?;
    let at = words.vocabulary.short(first, &|_| format!("the {place}"))?;
    let statements = vec![
        words.statement(first, outer, Some(place)).1,
        words.statement(word, inner, Some(outer)).1,
    ];
    let sighting = Sighting {
        assets: vec![place.to_owned()],
        objects: vec![outer.to_owned(), inner.to_owned()],
        statements,
        ..Sighting::default()
    };
    let text = format!("{} is a {outer}, and {within} a {inner}.", capitalized(&at));
    Some(SightExample::new(text, sighting))
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
        // People say it of the robot, whatever the domain says of its hand.
        let sentence = match word.relations.contains(&SpatialRelation::Held) {
            true => format!("The robot holds a {}.", THINGS[index]),
            false => sentence,
        };
        text = format!("{text}{sentence} ");
        sighting.objects.push(THINGS[index].to_owned());
        sighting.statements.push(statement);
    }
    // A relation for which the domain has no word.
    let has_under = words
        .vocabulary
        .words()
        .any(|word| word.word.contains("under") || word.means.contains("under"));
    let (subject, place) = ("drum", PLACES[2]);
    text.push_str(&match has_under {
        true => format!("There is a {subject}, and a {place}."),
        false => {
            sighting.left_out.push(format!("the {subject} is under the {place}"));
            format!("The {subject} is under the {place}.")
        }
    });
    sighting.objects.push(subject.to_owned());
    sighting.assets.push(place.to_owned());
    SightExample::new(text, sighting)
}

/// Makes examples of corrections: a place that changes, and an entity that is not there.
pub(super) fn correction_examples(vocabulary: &Vocabulary<'_>) -> Vec<CorrectionExample> {
    let words = Words::of(vocabulary);
    let before = relations(&words).sighting;
    let mut examples = Vec::new();
    if let Some(word) = words.places.first() {
        let (answer, _) = words.statement(word, THINGS[0], Some(PLACES[1]));
        examples.push(CorrectionExample {
            before: before.clone(),
            text: format!("No, {}", answer.to_lowercase()),
            answer,
        });
        let (added, _) = words.statement(word, "candle", Some(PLACES[0]));
        if let Some(short) = words.vocabulary.short(word, &|_| format!("the {}", PLACES[0])) {
            examples.push(CorrectionExample {
                before: before.clone(),
                text: format!("There is also a candle {short}."),
                answer: added,
            });
        }
    }
    if let Some(word) = words.of_places.first() {
        let (answer, _) = words.statement(word, PLACES[1], None);
        examples.push(CorrectionExample {
            before: before.clone(),
            text: format!("Look again: {}", answer.to_lowercase()),
            answer,
        });
    }
    if let Some(gone) = before.objects.last().cloned() {
        examples.push(CorrectionExample {
            text: format!("I see no {gone}."),
            answer: format!("There is no {gone}."),
            before,
        });
    }
    examples
}
