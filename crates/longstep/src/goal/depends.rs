//! Conditions in instructions: "if the milk is past its date".

use longstep_core::model::state_word;

use super::Spoken;
use crate::environment::{Fact, World};
use crate::model::plain_words;
use longstep_core::model::Domain;

/// Words that begin a condition.
const CONDITIONAL: &str = "if unless whether when whenever depending depends provided case";
/// Words after which "if" is only polite: "if you like", "if possible".
const POLITE: &str = "you i we possible necessary needed";
/// Words that refer to the negation of an earlier condition.
const ALTERNATIVE: &str = "otherwise else";
/// Words that begin the other case after "if" ("if not") and after "depending".
const OTHER_CASE: &str = "not on";
/// Words that end a condition.
const ENDING: &str = "then please just";

fn among(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|entry| entry == word)
}

/// A condition on which a goal may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dependence {
    /// The fact.
    pub(crate) fact: Fact,
    /// True if the goal depends on the absence of the fact.
    pub(crate) negated: bool,
}

/// The conditions of an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Clauses {
    words: Vec<Vec<String>>,
    /// Number of conditions that begin with "unless".
    unless: usize,
    /// True if the instruction is one sentence that begins with its condition.
    leading: bool,
    /// True if the instruction contains "otherwise" or "else".
    alternative: bool,
    /// True if a condition is not a time clause, such as "when you are done".
    strict: bool,
}

impl Clauses {
    pub(super) fn of(instruction: &str) -> Self {
        let mut clauses = Self::default();
        let sentences = instruction.split(['.', ';', '!', '?']).map(plain_words);
        let sentences: Vec<Vec<String>> = sentences.filter(|words| !words.is_empty()).collect();
        if let [sentence] = &sentences[..] {
            clauses.leading = sentence.first().is_some_and(|word| among(CONDITIONAL, word));
        }
        for clause in instruction.split([',', '.', ';', ':', '!', '?']) {
            let words = plain_words(clause);
            clauses.alternative |= words.iter().any(|word| among(ALTERNATIVE, word));
            for (at, word) in words.iter().enumerate() {
                let rest = &words[at + 1..];
                let polite = rest.first().is_none_or(|next| among(POLITE, next));
                if !among(CONDITIONAL, word) || polite {
                    continue;
                }
                clauses.unless += usize::from(word == "unless");
                clauses.strict |= !word.starts_with("when");
                let condition = rest.iter().take_while(|word| !among(ENDING, word));
                clauses.words.push(condition.cloned().collect());
            }
        }
        clauses
    }

    /// Appends the conditions of a later utterance.
    pub(super) fn add(&mut self, later: Self) {
        self.words.extend(later.words);
        self.unless += later.unless;
        self.leading = false;
        self.alternative |= later.alternative;
        self.strict |= later.strict;
    }

    /// Returns true if the instruction covers the other case too, by "otherwise", "if not" or a second condition.
    pub(super) fn has_other_case(&self) -> bool {
        let other = |words: &Vec<String>| words.first().is_some_and(|word| among(OTHER_CASE, word));
        self.alternative || self.words.len() > 1 || self.words.iter().any(other)
    }

    fn is_empty(&self) -> bool {
        self.words.is_empty() && !self.alternative
    }
}

/// Returns true if consecutive words begin with the stems of the cue.
fn has_cue(words: &[String], cue: &str) -> bool {
    let stems = plain_words(cue);
    let begins = |window: &[String]| {
        window
            .iter()
            .zip(&stems)
            .all(|(word, stem)| word.starts_with(stem.as_str()))
    };
    !stems.is_empty() && words.windows(stems.len()).any(begins)
}

/// Returns the conditions on which goals of the instruction can depend: outcomes of sensing actions whose cues it
/// contains, about entities that it mentions. Cues inside a condition take precedence over cues elsewhere. Empty if the
/// instruction has no condition.
///
/// With two outcomes, each is the negation of the other. With more, an outcome can also be negated; "unless" negates
/// the mentioned one.
pub(crate) fn conditions(world: &World, spoken: &Spoken) -> Vec<Dependence> {
    let domain = world.domain();
    let clauses = spoken.clauses();
    if clauses.is_empty() {
        return Vec::new();
    }
    let in_clauses = |cue: &String| clauses.words.iter().any(|words| has_cue(words, cue));
    let anywhere = |cue: &String| has_cue(spoken.words(), cue);
    let spoken_of = |predicate, said: &dyn Fn(&String) -> bool| domain.words(predicate).cues.iter().any(said);
    let by = |said: &dyn Fn(&String) -> bool| -> Vec<Dependence> {
        let mut found = Vec::new();
        for action in &domain.actions {
            if !action.senses.iter().any(|atom| spoken_of(atom.predicate, said)) {
                continue;
            }
            for atom in &action.senses {
                let [parameter] = &domain.predicate(atom.predicate).parameters[..] else {
                    continue;
                };
                if state_word(domain, atom.predicate).is_none() {
                    continue;
                }
                for entity in spoken.entities.iter().filter(|e| world.is_of_kind(**e, parameter.kind)) {
                    let fact = Fact::new(atom.predicate, [*entity]);
                    let negated: &[bool] = if action.senses.len() > 2 {
                        &[false, true]
                    } else {
                        &[false]
                    };
                    found.extend(negated.iter().map(|negated| Dependence {
                        fact,
                        negated: *negated,
                    }));
                }
            }
        }
        found
    };
    let mut found = by(&in_clauses);
    if found.is_empty() {
        found = by(&anywhere);
    }
    if clauses.unless > 0 && clauses.unless == clauses.words.len() {
        let fits = |depends: &Dependence| {
            let own = spoken_of(depends.fact.predicate(), &in_clauses);
            match domain.outcomes(depends.fact).len() {
                ..=2 => !own,
                _ => own && depends.negated,
            }
        };
        if found.iter().any(fits) {
            found.retain(fits);
        }
    }
    found
}

/// Returns true if the condition governs the whole instruction: "if it is dirty, wipe it and put the cloth away".
pub(crate) fn governs_all(spoken: &Spoken) -> bool {
    spoken.clauses().leading
}

/// Returns true if the instruction covers the case that its condition does not hold.
pub(crate) fn has_other_case(spoken: &Spoken) -> bool {
    spoken.clauses().has_other_case()
}

/// Returns true if the instruction has a condition that no sensing action can decide.
pub(crate) fn cannot_be_told(world: &World, spoken: &Spoken) -> bool {
    let senses = world.domain().actions.iter().any(|action| !action.senses.is_empty());
    senses && spoken.is_english() && spoken.clauses().strict && conditions(world, spoken).is_empty()
}

/// Returns true if a word belongs to a cue for a sensing outcome: "the best-by date" is no object.
pub(super) fn is_word_of_outcomes(domain: &Domain, word: &str) -> bool {
    let cues = domain.predicate_words.iter().flat_map(|words| &words.cues);
    cues.flat_map(|cue| plain_words(cue))
        .any(|stem| stem.len() > 2 && word.starts_with(&stem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain;
    use crate::environment::{self, Environment};
    use crate::json::Path;

    #[track_caller]
    fn check(domain: &str, instruction: &str, expected: &str) {
        let domain = domain::shipped(domain).unwrap().unwrap();
        let text = r#"{"assets": ["<table>", "<fridge>"], "objects": ["<milk>", "<sponge>", "<fridge_handle>"]}"#;
        let environment = Environment::from_json(text).unwrap();
        let world = environment::read(&domain, &environment, "", "", &Path::default()).unwrap();
        let spoken = Spoken::of(&world, instruction);
        let shown = |depends: Dependence| {
            let text = super::super::GoalFact::Plain(depends.fact).everyday(&world);
            if depends.negated { format!("not {text}") } else { text }
        };
        let conditions = conditions(&world, &spoken).into_iter();
        let mut shown: Vec<String> = conditions.map(shown).collect();
        if cannot_be_told(&world, &spoken) {
            shown.push("nobody knows".to_owned());
        }
        assert_eq!(shown.join(" "), expected, "{instruction}");
    }

    #[test]
    fn the_other_case_is_said_or_not() {
        for (instruction, expected) in [
            (
                "If the milk is out of date, throw it away, otherwise put it in the fridge",
                true,
            ),
            (
                "If the milk is out of date, throw it away, and if not, put it in the fridge",
                true,
            ),
            (
                "If the milk is bad, throw it away, if it is good, put it in the fridge",
                true,
            ),
            ("If the milk is out of date, throw it away", false),
            ("Put the milk in the fridge unless it has gone bad", false),
        ] {
            assert_eq!(Clauses::of(instruction).has_other_case(), expected, "{instruction}");
        }
    }

    #[test]
    fn what_an_instruction_depends_on() {
        let checks = |instruction, expected| check("household-checks", instruction, expected);
        checks("If the milk is out of date, throw it away", "fresh(milk) expired(milk)");
        checks("Put the milk in the fridge unless it has gone bad", "fresh(milk)");
        checks("Put the milk in the fridge unless it is empty", "not empty(milk)");
        checks("Wipe the table unless it is clean", "dirty(table)");
        checks(
            "Check the milk: if it is empty, get rid of it",
            "full(milk) not full(milk) half_full(milk) not half_full(milk) empty(milk) not empty(milk)",
        );
        checks("Put the milk into the fridge", "");
        checks("Put the fresh milk into the fridge", "");
        checks("Put the milk into the fridge, if you can", "");
        checks("If the milk is cold, put it on the table", "nobody knows");
        checks("When you are done with the milk, close the fridge", "");
        checks(
            "If the milk is expired, clean the table with the sponge",
            "fresh(milk) fresh(sponge) expired(milk) expired(sponge)",
        );
        check("household", "If the milk is out of date, throw it away", "");
    }
}
