//! The PDDL that answers stand for.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::answer_reader::AnswerReader;
use super::answers::Answers;
use super::problem::MadeUp;
use super::sentence::{Pattern, Piece, Which, kinds_of, plain};
use super::wording::{PredicateText, identifier};
use super::{Blueprint, problem};
use longstep::domain::plain_name;
use longstep_core::diagnostic::{Diagnostic, Diagnostics};

impl Answers {
    /// Returns the meaning and an example problem.
    pub(super) fn blueprint(&self) -> Result<(Blueprint, MadeUp), Diagnostics> {
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
        let problem = if self.start.is_empty() {
            let domain = longstep_core::domain::from_pddl("the answers", &blueprint.pddl)?;
            problem::write(&domain, &reader.names())
        } else {
            MadeUp {
                text: reader.problem(),
                is_partial: false,
            }
        };
        if reader.findings.is_empty() {
            Ok((blueprint, problem))
        } else {
            Err(Diagnostics(reader.findings))
        }
    }
}

impl AnswerReader<'_> {
    /// Writes the domain.
    fn pddl(&mut self) -> String {
        let answers = self.answers;
        let all_removed = self.removed();
        let mut actions = String::new();
        let mut taken: Vec<String> = Vec::new();
        for (action, removed) in answers.action.iter().zip(&all_removed) {
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
            let mut effects = Vec::new();
            for text in removed {
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
            "; Made from answers about the robot; edit it as you like. docs/reference/domains.md explains the parts.\n\
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

    /// Returns the names of the examples by the name of their kind.
    fn names(&self) -> problem::Names {
        let mut names = problem::Names::new();
        for (name, kind) in &self.things {
            let own = names.entry(self.kind_name(*kind)).or_default();
            own.push(identifier(&name.join("_")));
        }
        names
    }

    /// Writes the example problem from the things and the facts at the start.
    fn problem(&mut self) -> String {
        let answers = self.answers;
        let mut objects = String::new();
        let mut names = self.names();
        for kind in (0..answers.kind.len()).map(|kind| self.kind_name(kind)) {
            let numbered = || [1, 2].map(|number| format!("{kind}_{number}")).to_vec();
            for name in names.remove(&kind).unwrap_or_else(numbered) {
                let _ = write!(objects, " {name} - {kind}");
            }
        }
        let mut facts = String::new();
        for text in &answers.start {
            let sentence = self.start_sentence(text);
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
