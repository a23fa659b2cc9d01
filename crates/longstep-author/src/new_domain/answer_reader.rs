//! From sentences to the predicates, parameters and facts that they stand for.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::answers::{ActionAnswer, Answers, KindAnswer};
use super::sentence::{Pattern, Piece, Sentence, Which, kinds_of, plain, pop_article, pop_determiner};
use super::wording::identifier;
use longstep_core::diagnostic::{Diagnostic, Diagnostics};

/// Actions and sentences that one file may have; authors have dozens.
const LIMIT: usize = 200;

/// Reads the sentences of answers, and collects their predicates.
pub(super) struct AnswerReader<'a> {
    pub(super) answers: &'a Answers,
    /// The words of each kind's name.
    kinds: Vec<Vec<String>>,
    /// The things of the example environment, with their kinds.
    pub(super) things: Vec<(Vec<String>, usize)>,
    pub(super) patterns: Vec<Pattern>,
    pub(super) says: BTreeMap<String, String>,
    pub(super) findings: Vec<Diagnostic>,
}

impl<'a> AnswerReader<'a> {
    pub(super) fn new(answers: &'a Answers) -> Result<Self, Diagnostics> {
        let whole = |message: &str, hint: &str| Diagnostics(vec![Diagnostic::whole("the answers", message).hint(hint)]);
        let sentences = answers
            .action
            .iter()
            .map(|a| a.needs.len() + a.then.len() + 1)
            .sum::<usize>();
        if answers.action.len() > LIMIT || sentences > 10 * LIMIT || answers.kind.len() > LIMIT {
            return Err(whole(
                "there are too many answers",
                "describe at most 200 actions and kinds",
            ));
        }
        let kinds: Vec<Vec<String>> = answers.kind.iter().map(|kind| plain(&kind.name)).collect();
        let mut findings = Vec::new();
        for (index, kind) in kinds.iter().enumerate() {
            if kind.is_empty() || kinds[..index].contains(kind) {
                let name = &answers.kind[index].name;
                findings.push(Diagnostic::whole(
                    "the answers",
                    format!("the kind `{name}` has no name of its own"),
                ));
            }
        }
        if !findings.is_empty() {
            return Err(Diagnostics(findings));
        }
        let of_kind = |(index, kind): (usize, &'a KindAnswer)| {
            kind.examples
                .iter()
                .map(move |name| (plain(name), index))
                .collect::<Vec<_>>()
        };
        let things = answers.kind.iter().enumerate().flat_map(of_kind).collect();
        Ok(Self {
            answers,
            kinds,
            things,
            patterns: Vec::new(),
            says: BTreeMap::new(),
            findings,
        })
    }

    pub(super) fn report(&mut self, sentence: &str, message: &str, hint: &str) {
        let message = format!("\"{}\": {message}", sentence.trim());
        self.findings.push(Diagnostic::whole("the answers", message).hint(hint));
    }

    /// Reads a sentence: the longest name of a thing or a kind at each place, with the words before it.
    pub(super) fn sentence(&self, text: &str) -> Sentence {
        let words = plain(text);
        let mut pieces: Vec<Piece> = Vec::new();
        let mut holds = true;
        let mut at = 0;
        while at < words.len() {
            let starts = |name: &Vec<String>| !name.is_empty() && words[at..].starts_with(name);
            let things = self.things.iter().filter(|(name, _)| starts(name));
            let thing = things.max_by_key(|(name, _)| name.len());
            let kinds = self.kinds.iter().enumerate().filter(|(_, name)| starts(name));
            let kind = kinds.max_by_key(|(_, name)| name.len());
            // A thing may have the name of its kind: "the desk".
            if let Some((name, of)) = thing.filter(|(name, _)| kind.is_none_or(|(_, kind)| name.len() > kind.len())) {
                pop_article(&mut pieces);
                pieces.push(Piece::Thing(*of, identifier(&name.join("_"))));
                at += name.len();
            } else if let Some((index, name)) = kind {
                let which = pop_determiner(&mut pieces, &mut holds);
                pieces.push(Piece::Kind(index, which));
                at += name.len();
            } else {
                match words[at].as_str() {
                    "not" => holds = !holds,
                    word => pieces.push(Piece::Word(word.to_owned())),
                }
                at += 1;
            }
        }
        Sentence { pieces, holds }
    }

    /// Returns the number of the sentence's predicate, a new one if no sentence had its words.
    pub(super) fn pattern(&mut self, sentence: &Sentence) -> usize {
        let kinds = sentence.pieces.iter().filter_map(|piece| match piece {
            Piece::Kind(kind, _) | Piece::Thing(kind, _) => Some(*kind),
            Piece::Word(_) => None,
        });
        let (kinds, key): (Vec<usize>, String) = (kinds.collect(), key_of(sentence));
        if let Some(index) = self.patterns.iter().position(|pattern| pattern.key == key) {
            return index;
        }
        let own = sentence.pieces.iter().filter_map(|piece| match piece {
            Piece::Word(word) if !matches!(word.as_str(), "is" | "are" | "the" | "a" | "an") => Some(word.as_str()),
            _ => None,
        });
        let mut name = identifier(&own.collect::<Vec<_>>().join("_")).replace('_', "-");
        if !name.starts_with(|c: char| c.is_alphabetic()) {
            name.insert_str(0, "is-");
        }
        if self.patterns.iter().any(|pattern| pattern.name == name) {
            for kind in &kinds {
                name.push('-');
                name.push_str(&self.kind_name(*kind));
            }
        }
        while self.patterns.iter().any(|pattern| pattern.name == name) {
            name.push_str("-also");
        }
        self.patterns.push(Pattern {
            key,
            name,
            kinds,
            pieces: sentence.pieces.clone(),
        });
        self.patterns.len() - 1
    }

    /// Returns what holds no longer after each action: what its author says, or the default.
    pub(super) fn removed(&self) -> Vec<Vec<String>> {
        let mut had = Had::new();
        let all = self.answers.action.iter();
        all.map(|action| self.removed_by(action, &mut had)).collect()
    }

    fn removed_by(&self, action: &ActionAnswer, had: &mut Had) -> Vec<String> {
        let removed = match &action.no_longer {
            Some(removed) => removed.clone(),
            None => self.excluded(action, had),
        };
        let takes = removed.iter().any(|text| kinds_of(&self.sentence(text)).len() > 1);
        for then in &action.then {
            *had.entry(key_of(&self.sentence(then))).or_default() |= takes;
        }
        removed
    }

    /// Returns what the new facts of an action exclude, after the actions before it.
    fn excluded(&self, action: &ActionAnswer, had: &Had) -> Vec<String> {
        let answers = self.answers;
        let robot = answers.robot();
        let speaks_of_robot = |text: &str| plain(text).join(" ").contains(&robot);
        let subject = kinds_of(&self.sentence(&action.words)).first().copied();
        let mut removed: Vec<String> = Vec::new();
        for then in &action.then {
            let after = self.sentence(then);
            let about = kinds_of(&after);
            removed.extend(
                self.other_places(&after)
                    .into_iter()
                    .filter(|own| !removed.contains(own))
                    .collect::<Vec<_>>(),
            );
            let Some(subject) = subject.filter(|own| !answers.kind[own.0].stays && about.contains(own)) else {
                continue;
            };
            for need in &action.needs {
                let before = self.sentence(need);
                let kinds = kinds_of(&before);
                if !before.holds || !after.holds || !kinds.contains(&subject) || removed.contains(need) {
                    continue;
                }
                // A relation to something else is a place. The robot has a thing where it was taken from its place.
                let excludes = match (speaks_of_robot(need), speaks_of_robot(then)) {
                    (false, true) => kinds.len() > 1,
                    (true, false) => about.len() > 1 && had.get(&key_of(&before)).is_none_or(|takes| *takes),
                    (false, false) => kinds.len() > 1 && about != kinds && words_of(&before).eq(words_of(&after)),
                    (true, true) => false,
                };
                if excludes {
                    removed.push(need.clone());
                }
            }
        }
        removed
    }

    /// Returns where the robot is not after it moved to a place: at no other one of its kind, and at none of the kinds that an action
    /// brings it to in the same words.
    fn other_places(&self, after: &Sentence) -> Vec<String> {
        let answers = self.answers;
        let place_of = |sentence: &Sentence| match kinds_of(sentence)[..] {
            [(place, Which::One)] if sentence.holds && answers.kind[place].stays => Some(place),
            _ => None,
        };
        let of_robot = words_of(after).collect::<Vec<_>>().join(" ").contains(&answers.robot());
        let Some(place) = place_of(after).filter(|_| of_robot) else {
            return Vec::new();
        };
        let mut kinds = vec![place];
        for then in answers.action.iter().flat_map(|action| &action.then) {
            let other = self.sentence(then);
            let is_one = words_of(&other).eq(words_of(after));
            kinds.extend(place_of(&other).filter(|kind| is_one && !kinds.contains(kind)));
        }
        let at = |kind: usize| {
            let words = after.pieces.iter().map(|piece| match piece {
                Piece::Word(word) => word.clone(),
                Piece::Kind(..) | Piece::Thing(..) => format!("any {}", answers.kind[kind].name),
            });
            words.collect::<Vec<_>>().join(" ")
        };
        kinds.into_iter().map(at).collect()
    }

    /// Reads a sentence about the first world, where a thing may have the name of its kind: "the dock".
    pub(super) fn start_sentence(&self, text: &str) -> Sentence {
        let mut sentence = self.sentence(text);
        for piece in &mut sentence.pieces {
            if let Piece::Kind(kind, Which::One) = piece
                && self
                    .things
                    .iter()
                    .any(|(name, of)| of == kind && *name == self.kinds[*kind])
            {
                *piece = Piece::Thing(*kind, identifier(&self.kinds[*kind].join("_")));
            }
        }
        sentence
    }

    pub(super) fn kind_name(&self, kind: usize) -> String {
        identifier(&self.kinds[kind].join("_"))
    }

    /// Returns the parameter for a kind in a sentence.
    pub(super) fn variable(&self, kind: usize, which: Which) -> String {
        let name = self.kind_name(kind);
        match which {
            Which::One => name,
            Which::Other => format!("other_{name}"),
            Which::Any => format!("any_{name}"),
        }
    }

    /// Writes a sentence as PDDL; an effect about "any" thing is about all of them.
    pub(super) fn fact(
        &mut self,
        text: &str,
        parameters: &mut Vec<(usize, Which)>,
        removes: bool,
        effect: bool,
    ) -> Option<String> {
        let mut sentence = self.sentence(text);
        if removes {
            sentence.holds = false;
        }
        if sentence.pieces.iter().any(|piece| matches!(piece, Piece::Thing(..))) {
            self.report(
                text,
                "it names one thing, not a kind",
                "say the kind: \"the box\", \"any box\"",
            );
            return None;
        }
        if !sentence
            .pieces
            .iter()
            .any(|piece| matches!(piece, Piece::Word(word) if word != "is"))
        {
            self.report(
                text,
                "it says nothing",
                "write a sentence such as \"the box is on the shelf\"",
            );
            return None;
        }
        let kinds = kinds_of(&sentence);
        let pattern = self.pattern(&sentence);
        let mut quantified = Vec::new();
        let mut variables = String::new();
        for (kind, which) in kinds {
            let name = self.variable(kind, which);
            let _ = write!(variables, " ?{name}");
            if which == Which::Any {
                quantified.push(format!("?{name} - {}", self.kind_name(kind)));
            } else if !parameters.contains(&(kind, which)) {
                parameters.push((kind, which));
            }
        }
        let mut fact = format!("({}{variables})", self.patterns[pattern].name);
        if !sentence.holds {
            fact = format!("(not {fact})");
        }
        if quantified.is_empty() {
            return Some(fact);
        }
        let quantifier = if effect || !sentence.holds { "forall" } else { "exists" };
        Some(format!("({quantifier} ({}) {fact})", quantified.join(" ")))
    }
}

/// A state that an action ends without saying so.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct MissedRemoval {
    /// The index of the action.
    pub action: usize,
    /// The sentence of its needs.
    pub state: String,
}

/// Returns the states that actions end without saying so: what one action needs and replaces, the other one replaces back, as
/// "open" and "closed"; and the other places at which the robot is not after it moved.
pub fn missed_removals(answers: &Answers) -> Vec<MissedRemoval> {
    let Ok(reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let mut missed = Vec::new();
    for (index, action) in answers.action.iter().enumerate() {
        let places = action
            .then
            .iter()
            .flat_map(|then| reader.other_places(&reader.sentence(then)));
        for state in reader.reversed(action).into_iter().chain(places) {
            let key = key_of(&reader.sentence(&state));
            let mut removed = action.no_longer.iter().flatten();
            if action.no_longer.is_some() && removed.all(|own| key_of(&reader.sentence(own)) != key) {
                missed.push(MissedRemoval { action: index, state });
            }
        }
    }
    missed
}

impl AnswerReader<'_> {
    /// Returns the needs of the action that another one brings about again, where it needs what this one brings about. Only
    /// states of one thing: another place is [excluded](Self::excluded).
    fn reversed(&self, action: &ActionAnswer) -> Vec<String> {
        let key = |text: &String| {
            let sentence = self.sentence(text);
            (sentence.holds && kinds_of(&sentence).len() == 1).then(|| key_of(&sentence))
        };
        let keys = |texts: &[String]| texts.iter().filter_map(key).collect::<Vec<String>>();
        let reverses = |other: &ActionAnswer, own: &String| {
            let made = keys(&action.then);
            let given_back = !made.contains(own) && keys(&other.then).contains(own);
            given_back && keys(&other.needs).iter().any(|need| made.contains(need))
        };
        let is_reversed = |need: &&String| {
            let own = key(need);
            own.is_some_and(|own| {
                self.answers
                    .action
                    .iter()
                    .any(|other| other != action && reverses(other, &own))
            })
        };
        action.needs.iter().filter(is_reversed).cloned().collect()
    }
}

/// By fact that some action brings about: true if the action takes a thing from its place.
type Had = BTreeMap<String, bool>;

/// Returns what two sentences have in common if they mean the same fact.
fn key_of(sentence: &Sentence) -> String {
    let words = sentence.pieces.iter().filter_map(|piece| match piece {
        // "Anna is at the desk" is "the anna is at the desk".
        Piece::Word(word) => (!matches!(word.as_str(), "the" | "a" | "an")).then(|| word.clone()),
        Piece::Kind(kind, _) | Piece::Thing(kind, _) => Some(format!("<{kind}>")),
    });
    words.collect::<Vec<_>>().join(" ")
}

fn words_of(sentence: &Sentence) -> impl Iterator<Item = &str> {
    sentence.pieces.iter().map(|piece| match piece {
        Piece::Word(word) => word.as_str(),
        Piece::Kind(..) | Piece::Thing(..) => "",
    })
}

/// Returns what holds no longer after an action, as a proposal for the author.
///
/// Only what the new facts exclude. Picking up: where the thing was. Putting down: that the robot has it. Moving a thing: where it
/// was. Driving: the robot is nowhere else. What is true of a place, or of a thing by itself, stays so.
///
/// # Errors
///
/// None: sentences that cannot be read propose nothing.
pub fn guess_removed(answers: &Answers, action: &ActionAnswer) -> Vec<String> {
    let Ok(reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let mut had = Had::new();
    for own in answers.action.iter().take_while(|own| *own != action) {
        reader.removed_by(own, &mut had);
    }
    let mut removed = reader.excluded(action, &had);
    let reversed = reader.reversed(action);
    removed.extend(
        reversed
            .into_iter()
            .filter(|own| !removed.contains(own))
            .collect::<Vec<_>>(),
    );
    removed
}
