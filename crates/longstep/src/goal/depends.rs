//! What an instruction makes its wishes depend on: "if the milk is past its date".

use super::{Spoken, state_word};
use crate::domain::{Domain, plain_words};
use crate::world::{EntityId, Fact, World};

/// Words that begin a condition.
const CONDITIONAL: &str = "if unless whether when whenever depending depends provided case";
/// Words after which "if" is only polite: "if you like", "if possible".
const POLITE: &str = "you i we possible necessary needed";
/// Words that tell of a condition said before.
const ALTERNATIVE: &str = "otherwise else";
/// Words with which a condition ends.
const ENDING: &str = "then please just";

fn among(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|entry| entry == word)
}

/// The words of an instruction's conditions.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Clauses {
    words: Vec<Vec<String>>,
    /// Whether there is an "otherwise".
    alternative: bool,
    /// Whether there is a condition that is no point in time: "when you are done" is none.
    strict: bool,
}

impl Clauses {
    pub(super) fn of(instruction: &str) -> Self {
        let mut clauses = Self::default();
        for clause in instruction.split([',', '.', ';', ':', '!', '?']) {
            let words = plain_words(clause);
            clauses.alternative |= words.iter().any(|word| among(ALTERNATIVE, word));
            for (at, word) in words.iter().enumerate() {
                let rest = &words[at + 1..];
                let polite = rest.first().is_none_or(|next| among(POLITE, next));
                if !among(CONDITIONAL, word) || polite {
                    continue;
                }
                clauses.strict |= !word.starts_with("when");
                let condition = rest.iter().take_while(|word| !among(ENDING, word));
                clauses.words.push(condition.cloned().collect());
            }
        }
        clauses
    }

    /// Takes in what was said later.
    pub(super) fn add(&mut self, later: Self) {
        self.words.extend(later.words);
        self.alternative |= later.alternative;
        self.strict |= later.strict;
    }

    fn is_empty(&self) -> bool {
        self.words.is_empty() && !self.alternative
    }
}

/// Whether the words have a row of words that begin like those of the cue.
fn has_cue(words: &[String], cue: &str) -> bool {
    let stems = plain_words(cue);
    let begins = |window: &[String]| window.iter().zip(&stems).all(|(word, stem)| word.starts_with(stem.as_str()));
    !stems.is_empty() && words.windows(stems.len()).any(begins)
}

/// What the goals of an instruction can depend on: the outcomes of sensing of which it speaks with its things, where it
/// has a condition at all. What is said in the condition counts before what is said elsewhere.
pub(crate) fn conditions(domain: &Domain, world: &World, spoken: &Spoken) -> Vec<Fact> {
    if spoken.clauses().is_empty() {
        return Vec::new();
    }
    let in_clauses = |cue: &String| spoken.clauses().words.iter().any(|words| has_cue(words, cue));
    let anywhere = |cue: &String| has_cue(spoken.words(), cue);
    let by = |said: &dyn Fn(&String) -> bool| -> Vec<Fact> {
        let mut found = Vec::new();
        for action in &domain.actions {
            let spoken_of = |atom: &crate::domain::Atom| domain.words(atom.predicate).cues.iter().any(said);
            if !action.senses.iter().any(spoken_of) {
                continue;
            }
            for atom in &action.senses {
                let [parameter] = &domain.predicate(atom.predicate).parameters[..] else {
                    continue;
                };
                let of_kind = |entity: &&EntityId| world.is_of_kind(**entity, parameter.kind);
                let fact = |entity: &EntityId| Fact::new(atom.predicate, [*entity]);
                if state_word(domain, atom.predicate).is_some() {
                    found.extend(spoken.entities.iter().filter(of_kind).map(fact));
                }
            }
        }
        found
    };
    let found = by(&in_clauses);
    if found.is_empty() { by(&anywhere) } else { found }
}

/// Whether the instruction has a condition about which nothing here can tell anything.
pub(crate) fn cannot_be_told(domain: &Domain, world: &World, spoken: &Spoken) -> bool {
    let senses = domain.actions.iter().any(|action| !action.senses.is_empty());
    senses && spoken.clauses().strict && conditions(domain, world, spoken).is_empty()
}

/// Whether a word belongs to the ways in which people speak of what sensing tells: "the best-by date" is no thing.
pub(super) fn is_word_of_outcomes(domain: &Domain, word: &str) -> bool {
    let cues = domain.predicate_words.iter().flat_map(|words| &words.cues);
    cues.flat_map(|cue| plain_words(cue)).any(|stem| stem.len() > 2 && word.starts_with(&stem))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain;
    use crate::json::Path;
    use crate::world::{self, Environment};

    #[track_caller]
    fn check(domain: &str, instruction: &str, expected: &str) {
        let domain = domain::shipped(domain).unwrap().unwrap();
        let text = r#"{"assets": ["<table>", "<fridge>"], "objects": ["<milk>", "<sponge>", "<fridge_handle>"]}"#;
        let environment = Environment::from_json(text).unwrap();
        let world = world::read(&domain, &environment, "", "", &Path::default()).unwrap();
        let spoken = Spoken::of(&domain, &world, instruction);
        let facts = conditions(&domain, &world, &spoken).into_iter();
        let mut shown: Vec<String> = facts
            .map(|fact| super::super::GoalFact::Plain(fact).everyday(&domain, &world))
            .collect();
        if cannot_be_told(&domain, &world, &spoken) {
            shown.push("nobody knows".to_owned());
        }
        assert_eq!(shown.join(" "), expected, "{instruction}");
    }

    #[test]
    fn what_an_instruction_depends_on() {
        let checks = |instruction, expected| check("household-checks", instruction, expected);
        checks("If the milk is out of date, throw it away", "fresh(milk) expired(milk)");
        checks("Put the milk in the fridge unless it has gone bad", "fresh(milk) fresh(fridge) expired(milk)");
        checks("Check the milk: if it is empty, get rid of it", "full(milk) half_full(milk) empty(milk)");
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
