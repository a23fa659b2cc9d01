//! An author's answers about a robot, in words, and the PDDL that they stand for.
//!
//! A sentence names kinds of things: "the box is on the shelf". Its other words are the name of a predicate, so two
//! sentences with the same words mean the same fact. "another box" is a second thing of the kind, "no box" and "any box"
//! speak of all of them, and "not" turns a sentence into its opposite.

use std::collections::BTreeMap;
use std::fmt::Write;

use serde::Deserialize;

use super::wording::{PredicateText, identifier};
use super::{Blueprint, problem};
use crate::diagnostic::{Diagnostic, Diagnostics};
use crate::model::{plain_name, read_toml};

/// Actions and sentences that one file may have; authors have dozens.
const LIMIT: usize = 200;

/// An author's answers about a robot.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Answers {
    /// The name of the domain.
    pub name: String,
    /// The robot's name in the sentences; "robot" if it is missing.
    #[serde(default)]
    pub robot: Option<String>,
    /// One sentence about the robot.
    #[serde(default)]
    pub about: Option<String>,
    /// The kinds of things.
    #[serde(default)]
    pub kind: Vec<KindAnswer>,
    /// The actions.
    #[serde(default)]
    pub action: Vec<ActionAnswer>,
    /// The facts in the example environment, with the things of [`KindAnswer::examples`].
    #[serde(default)]
    pub start: Vec<String>,
}

/// A kind of things.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KindAnswer {
    /// Its name: "box".
    pub name: String,
    /// True for places and furniture, which stay where they are.
    #[serde(default)]
    pub stays: bool,
    /// Things of this kind for the example environment: "red box".
    #[serde(default)]
    pub examples: Vec<String>,
}

/// An action.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ActionAnswer {
    /// The action in words: "put a box on a shelf".
    pub words: String,
    /// The conditions before it.
    #[serde(default)]
    pub needs: Vec<String>,
    /// The facts after it.
    pub then: Vec<String>,
    /// The facts that hold no longer; a default ([`guess_removed`]) if it is missing, nothing if it is empty.
    #[serde(default)]
    pub no_longer: Option<Vec<String>>,
}

/// The way in which a sentence speaks of a kind.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Which {
    One,
    Other,
    Any,
}

#[derive(Debug, Clone, PartialEq, Eq)]
enum Piece {
    Word(String),
    /// A kind by its index, or a thing of the example environment.
    Kind(usize, Which),
    Thing(usize, String),
}

#[derive(Debug, Clone, PartialEq, Eq)]
struct Sentence {
    pieces: Vec<Piece>,
    holds: bool,
}

/// A predicate: the words of its sentence, and the kinds in it.
struct Pattern {
    key: String,
    name: String,
    kinds: Vec<usize>,
    pieces: Vec<Piece>,
}

impl Answers {
    /// Reads answers from a TOML file; `file` is its name in diagnostics.
    ///
    /// # Errors
    ///
    /// Every place that is not TOML in this form.
    ///
    /// ```
    /// use longstep::domain::{Answers, from_answers};
    /// let text = r#"
    /// name = "porter"
    /// kind = [{ name = "box" }, { name = "shelf", stays = true }]
    /// [[action]]
    /// words = "pick up a box"
    /// needs = ["the box is on a shelf", "the robot holds no box"]
    /// then = ["the robot holds the box"]
    /// [[action]]
    /// words = "put a box on a shelf"
    /// needs = ["the robot holds the box"]
    /// then = ["the box is on the shelf"]
    /// "#;
    /// let new = from_answers(&Answers::read("answers.toml", text)?)?;
    /// assert_eq!(new.domain.actions.len(), 2);
    /// # Ok::<(), longstep::Diagnostics>(())
    /// ```
    pub fn read(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let mut findings = Vec::new();
        match read_toml(file, text, &mut findings) {
            Some(answers) => Ok(answers),
            None => Err(Diagnostics::sorted(findings)),
        }
    }

    fn robot(&self) -> String {
        let name = self.robot.as_deref().unwrap_or("robot").trim().to_lowercase();
        name.strip_prefix("the ").map(str::to_owned).unwrap_or(name)
    }

    /// Returns the meaning and an example problem.
    pub(super) fn blueprint(&self) -> Result<(Blueprint, String), Diagnostics> {
        if self.kind.is_empty() || self.action.is_empty() {
            let finding = Diagnostic::whole("the answers", "a domain needs a kind of things and an action");
            let hint = "add `[[kind]] name = \"box\"` and `[[action]] words = \"pick up a box\"`";
            return Err(Diagnostics(vec![finding.hint(hint)]));
        }
        let mut reader = AnswerReader::new(self)?;
        let pddl = reader.pddl();
        let lexicon = Vec::new();
        if !reader.findings.is_empty() {
            return Err(Diagnostics(reader.findings));
        }
        let about = self.about.clone().unwrap_or_else(|| {
            let words: Vec<&str> = self.action.iter().map(|action| action.words.trim()).collect();
            format!("A robot that can do this: {}.", words.join("; "))
        });
        let blueprint = Blueprint {
            name: plain_name(&self.name),
            about,
            predicates: reader.texts(),
            actions: std::mem::take(&mut reader.says),
            lexicon,
            places: Some(reader.places()),
            pddl,
        };
        let given = self.kind.iter().all(|kind| !kind.examples.is_empty()) && !self.start.is_empty();
        let problem = match given {
            true => reader.problem(),
            false => problem::write(&longstep_core::domain::from_pddl("the answers", &blueprint.pddl)?),
        };
        match reader.findings.is_empty() {
            true => Ok((blueprint, problem)),
            false => Err(Diagnostics(reader.findings)),
        }
    }
}

/// Returns what holds no longer after an action, as a proposal for the author.
///
/// Picking up: where the thing was. Putting down: that the robot has it. Driving: the robot is nowhere else.
///
/// # Errors
///
/// None: sentences that cannot be read propose nothing.
pub fn guess_removed(answers: &Answers, action: &ActionAnswer) -> Vec<String> {
    let Ok(reader) = AnswerReader::new(answers) else {
        return Vec::new();
    };
    let robot = answers.robot();
    let speaks_of_robot = |text: &str| plain(text).contains(&robot);
    let subject = kinds_of(&reader.sentence(&action.words)).first().copied();
    let mut removed: Vec<String> = Vec::new();
    for then in &action.then {
        let after = reader.sentence(then);
        let about = kinds_of(&after);
        // The robot moves: it is at no other place.
        if let ([(place, Which::One)], true) = (&about[..], speaks_of_robot(then) && after.holds)
            && answers.kind[*place].stays
        {
            let name = &answers.kind[*place].name;
            let words = after.pieces.iter().map(|piece| match piece {
                Piece::Word(word) => word.clone(),
                Piece::Kind(..) | Piece::Thing(..) => format!("any {name}"),
            });
            removed.push(words.collect::<Vec<_>>().join(" "));
        }
        for need in &action.needs {
            let before = reader.sentence(need);
            let kinds = kinds_of(&before);
            let is_about = subject.is_some_and(|subject| kinds.contains(&subject) && about.contains(&subject));
            let handed = speaks_of_robot(need) != speaks_of_robot(then);
            if before.holds && is_about && handed && !removed.contains(need) {
                removed.push(need.clone());
            }
        }
    }
    removed
}

fn kinds_of(sentence: &Sentence) -> Vec<(usize, Which)> {
    let kinds = sentence.pieces.iter().filter_map(|piece| match piece {
        Piece::Kind(kind, which) => Some((*kind, *which)),
        _ => None,
    });
    kinds.collect()
}

/// Returns the words of a sentence in lower case, without punctuation.
fn plain(text: &str) -> Vec<String> {
    let words = text.split_whitespace().map(|word| {
        let inner = word.trim_matches(|c: char| !c.is_alphanumeric());
        inner.to_lowercase()
    });
    words.filter(|word| !word.is_empty()).collect()
}

struct AnswerReader<'a> {
    answers: &'a Answers,
    /// The words of each kind's name.
    kinds: Vec<Vec<String>>,
    /// The things of the example environment, with their kinds.
    things: Vec<(Vec<String>, usize)>,
    patterns: Vec<Pattern>,
    says: BTreeMap<String, String>,
    findings: Vec<Diagnostic>,
}

impl<'a> AnswerReader<'a> {
    fn new(answers: &'a Answers) -> Result<Self, Diagnostics> {
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

    fn report(&mut self, sentence: &str, message: &str, hint: &str) {
        let message = format!("\"{}\": {message}", sentence.trim());
        self.findings.push(Diagnostic::whole("the answers", message).hint(hint));
    }

    /// Reads a sentence: the longest name of a thing or a kind at each place, with the words before it.
    fn sentence(&self, text: &str) -> Sentence {
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
    fn pattern(&mut self, sentence: &Sentence) -> usize {
        let mut kinds = Vec::new();
        let words = sentence.pieces.iter().map(|piece| match piece {
            Piece::Word(word) => word.clone(),
            Piece::Kind(kind, _) | Piece::Thing(kind, _) => {
                kinds.push(*kind);
                format!("<{kind}>")
            }
        });
        let key = words.collect::<Vec<_>>().join(" ");
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

    fn kind_name(&self, kind: usize) -> String {
        identifier(&self.kinds[kind].join("_"))
    }

    /// Returns the parameter for a kind in a sentence.
    fn variable(&self, kind: usize, which: Which) -> String {
        let name = self.kind_name(kind);
        match which {
            Which::One => name,
            Which::Other => format!("other_{name}"),
            Which::Any => format!("any_{name}"),
        }
    }

    /// Writes a sentence as PDDL; an effect about "any" thing is about all of them.
    fn fact(
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

    /// Writes the domain.
    fn pddl(&mut self) -> String {
        let answers = self.answers;
        let mut actions = String::new();
        let mut taken: Vec<String> = Vec::new();
        for action in &answers.action {
            let words = self.sentence(&action.words);
            let mut parameters: Vec<(usize, Which)> = kinds_of(&words);
            parameters.dedup();
            if parameters.iter().any(|(_, which)| *which == Which::Any) || parameters.is_empty() {
                let hint = "say it of one thing of each kind: \"put a box on a shelf\"";
                self.report(
                    &action.words,
                    "an action names the kinds of things that it concerns",
                    hint,
                );
                continue;
            }
            if action.then.is_empty() {
                self.report(
                    &action.words,
                    "it changes nothing",
                    "say in `then` what holds afterwards",
                );
                continue;
            }
            let mut needs = Vec::new();
            for need in &action.needs {
                needs.extend(self.fact(need, &mut parameters, false, false));
            }
            let removed = match &action.no_longer {
                Some(removed) => removed.clone(),
                None => guess_removed(answers, action),
            };
            let mut effects = Vec::new();
            for text in &removed {
                effects.extend(self.fact(text, &mut parameters, true, true));
            }
            for text in &action.then {
                effects.extend(self.fact(text, &mut parameters, false, true));
            }
            for (kind, which) in parameters.clone() {
                if which == Which::Other && parameters.contains(&(kind, Which::One)) {
                    let (one, other) = (self.variable(kind, Which::One), self.variable(kind, which));
                    needs.push(format!("(not (= ?{one} ?{other}))"));
                }
            }
            let own = words.pieces.iter().filter_map(|piece| match piece {
                Piece::Word(word) if !matches!(word.as_str(), "the" | "a" | "an") => Some(word.clone()),
                _ => None,
            });
            let mut name = identifier(&own.collect::<Vec<_>>().join("_")).replace('_', "-");
            if taken.contains(&name) {
                for (kind, _) in kinds_of(&words) {
                    name.push('-');
                    name.push_str(&self.kind_name(kind));
                }
            }
            let mut earlier = answers.action.iter().take_while(|other| !std::ptr::eq(*other, action));
            let is_repeated = earlier.any(|other| plain(&other.words) == plain(&action.words));
            if is_repeated || taken.contains(&name) {
                self.report(&action.words, "two actions have the same words", "say the difference");
                continue;
            }
            taken.push(name.clone());
            let says: Vec<String> = words.pieces.iter().map(|piece| self.hole(piece)).collect();
            self.says.insert(name.clone(), says.join(" "));
            let typed: Vec<String> = parameters
                .iter()
                .map(|(kind, which)| format!("?{} - {}", self.variable(*kind, *which), self.kind_name(*kind)))
                .collect();
            let _ = write!(
                actions,
                "\n  (:action {name}\n    :parameters ({})\n    :precondition (and {})\n    :effect (and {}))\n",
                typed.join(" "),
                needs.join("\n                       "),
                effects.join("\n                 "),
            );
        }
        let mut predicates = String::new();
        for pattern in &self.patterns {
            let names = self.parameters_of(pattern).into_iter().zip(&pattern.kinds);
            let typed: String = names
                .map(|(name, kind)| format!(" ?{name} - {}", self.kind_name(*kind)))
                .collect();
            let _ = write!(predicates, "\n    ({}{typed})", pattern.name);
        }
        format!(
            "; Made from answers about the robot; edit it as you like. docs/domains.md explains the parts.\n\
             (define (domain {})\n  (:requirements :strips :typing :negative-preconditions :disjunctive-preconditions\n\
             \x20                :quantified-preconditions :conditional-effects :equality)\n\n  (:types{})\n\n\
             \x20 (:predicates{predicates})\n{actions})\n",
            plain_name(&answers.name),
            self.types()
        )
    }

    fn hole(&self, piece: &Piece) -> String {
        match piece {
            Piece::Word(word) => word.clone(),
            Piece::Kind(kind, which) => format!("{{{}}}", self.variable(*kind, *which)),
            Piece::Thing(_, name) => name.clone(),
        }
    }

    /// Returns a different name for each argument of a pattern.
    fn parameters_of(&self, pattern: &Pattern) -> Vec<String> {
        let mut names: Vec<String> = Vec::new();
        for kind in &pattern.kinds {
            let mut name = self.kind_name(*kind);
            while names.contains(&name) {
                name.insert_str(0, "other_");
            }
            names.push(name);
        }
        names
    }

    /// Returns the names of the kinds that stay, or do not.
    fn group(&self, stays: bool) -> Vec<String> {
        let kinds = self.answers.kind.iter().enumerate();
        let kinds = kinds.filter(|(_, kind)| kind.stays == stays);
        kinds.map(|(index, _)| self.kind_name(index)).collect()
    }

    /// Returns the type of a group: its only kind, or a common parent.
    fn parent(&self, stays: bool) -> Option<String> {
        match &self.group(stays)[..] {
            [] => None,
            [only] => Some(only.clone()),
            _ => {
                let mut name = if stays { "place" } else { "thing" }.to_owned();
                while self
                    .answers
                    .kind
                    .iter()
                    .enumerate()
                    .any(|(index, _)| self.kind_name(index) == name)
                {
                    name.insert_str(0, "any-");
                }
                Some(name)
            }
        }
    }

    fn types(&self) -> String {
        let mut text = String::new();
        let mut tops = Vec::new();
        for stays in [false, true] {
            let group = self.group(stays);
            let Some(parent) = self.parent(stays) else { continue };
            if group.len() > 1 {
                let _ = write!(text, " {} - {parent}", group.join(" "));
            }
            tops.push(parent);
        }
        format!("{text} {} - object", tops.join(" "))
    }

    fn places(&self) -> Vec<String> {
        self.parent(true).into_iter().collect()
    }

    /// Returns the sentences of the predicates.
    fn texts(&self) -> BTreeMap<String, PredicateText> {
        let texts = self.patterns.iter().map(|pattern| {
            let mut names = self.parameters_of(pattern).into_iter();
            let mut words: Vec<String> = pattern
                .pieces
                .iter()
                .map(|piece| match piece {
                    Piece::Word(word) => word.clone(),
                    Piece::Kind(..) | Piece::Thing(..) => format!("{{{}}}", names.next().unwrap_or_default()),
                })
                .collect();
            let says = words.join(" ");
            let verb = pattern
                .pieces
                .iter()
                .position(|piece| matches!(piece, Piece::Word(w) if w == "is" || w == "are"));
            let denies = match verb {
                Some(verb) => {
                    let mut denied = words.clone();
                    denied.insert(verb + 1, "not".to_owned());
                    denied.join(" ")
                }
                None => format!("it is not true that {says}"),
            };
            let begins = matches!(pattern.pieces.first(), Some(Piece::Kind(..)));
            let short = match (begins, pattern.kinds.len()) {
                (true, _) => {
                    words.remove(0);
                    if words.first().is_some_and(|word| word == "is") {
                        words.remove(0);
                    }
                    Some(words.join(" "))
                }
                (false, 1) => {
                    let it = |word: &String| {
                        if word.starts_with('{') {
                            "it".to_owned()
                        } else {
                            word.clone()
                        }
                    };
                    Some(words.iter().map(it).collect::<Vec<_>>().join(" "))
                }
                _ => None,
            };
            (pattern.name.clone(), PredicateText { says, denies, short })
        });
        texts.collect()
    }

    /// Writes the example problem from the things and the facts at the start.
    fn problem(&mut self) -> String {
        let answers = self.answers;
        let mut objects = String::new();
        for (name, kind) in &self.things {
            let _ = write!(objects, " {} - {}", identifier(&name.join("_")), self.kind_name(*kind));
        }
        let mut facts = String::new();
        for text in &answers.start {
            let sentence = self.sentence(text);
            let known = self.patterns.len();
            let pattern = self.pattern(&sentence);
            if pattern >= known {
                let hint = "use the words of a sentence of the actions, with the examples of your kinds";
                self.report(text, "no action speaks of this", hint);
                continue;
            }
            let mut named = String::new();
            for piece in &sentence.pieces {
                match piece {
                    Piece::Thing(_, name) => {
                        let _ = write!(named, " {name}");
                    }
                    Piece::Kind(..) => self.report(text, "it names a kind, not a thing", "name one of its examples"),
                    Piece::Word(_) => {}
                }
            }
            if !sentence.holds {
                self.report(text, "only what holds is listed", "leave it out");
            }
            let _ = write!(facts, "\n    ({}{named})", self.patterns[pattern].name);
        }
        let name = plain_name(&answers.name);
        format!(
            "(define (problem example) (:domain {name})\n  (:objects{objects})\n  (:init{facts})\n  (:goal (and)))\n"
        )
    }
}

fn pop_article(pieces: &mut Vec<Piece>) {
    if matches!(pieces.last(), Some(Piece::Word(word)) if matches!(word.as_str(), "the" | "a" | "an")) {
        pieces.pop();
    }
}

/// Removes the words before a kind that say which thing is meant.
fn pop_determiner(pieces: &mut Vec<Piece>, holds: &mut bool) -> Which {
    let mut which = Which::One;
    while let Some(Piece::Word(word)) = pieces.last() {
        match word.as_str() {
            "the" | "a" | "an" => {}
            "another" | "other" | "second" => which = Which::Other,
            "any" | "every" | "all" => which = Which::Any,
            "no" => {
                which = Which::Any;
                *holds = !*holds;
            }
            _ => break,
        }
        pieces.pop();
    }
    which
}
