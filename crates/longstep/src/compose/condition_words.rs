//! Conditions in the words of a composition: "if the milk is past its date".
//!
//! The words are English. A composition in another language has no conditions yet (docs/limits.md).

use longstep_core::model::state_word;

use crate::environment::{Fact, World};
use crate::goal::Mentions;
use crate::model::plain_words;

/// Words that begin a condition.
const CONDITIONAL: &str = "if unless whether when whenever depending depends provided case";
/// Words after which "if" is only polite: "if you like", "if possible".
const POLITE: &str = "you i we possible necessary needed";
/// Words that refer to the negation of an earlier condition.
const ALTERNATIVE: &str = "otherwise else";
/// Words that end a condition.
const ENDING: &str = "then please just";

fn among(list: &str, word: &str) -> bool {
    list.split_whitespace().any(|entry| entry == word)
}

/// The conditions of an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(super) struct Clauses {
    words: Vec<Vec<String>>,
    /// Number of conditions that begin with "unless".
    unless: usize,
    /// True if the instruction contains "otherwise" or "else".
    has_alternative: bool,
    /// True if a condition is not a time clause, such as "when you are done".
    is_strict: bool,
}

impl Clauses {
    pub(super) fn of(instruction: &str) -> Self {
        let mut clauses = Self::default();
        for clause in instruction.split([',', '.', ';', ':', '!', '?']) {
            let words = plain_words(clause);
            clauses.has_alternative |= words.iter().any(|word| among(ALTERNATIVE, word));
            for (at, word) in words.iter().enumerate() {
                let rest = &words[at + 1..];
                let is_polite = rest.first().is_none_or(|next| among(POLITE, next));
                if !among(CONDITIONAL, word) || is_polite {
                    continue;
                }
                clauses.unless += usize::from(word == "unless");
                clauses.is_strict |= !word.starts_with("when");
                let condition = rest.iter().take_while(|word| !among(ENDING, word));
                clauses.words.push(condition.cloned().collect());
            }
        }
        clauses
    }

    /// Returns true if the instruction has a condition that none of `found` decides.
    pub(super) fn are_undecided(&self, world: &World, found: &[Fact]) -> bool {
        let senses = world.domain().actions.iter().any(|action| !action.senses.is_empty());
        senses && self.is_strict && found.is_empty()
    }

    /// Returns the outcomes of sensing actions that the conditions are about: their cues are in the instruction, and it
    /// names their entity. Cues inside a condition take precedence over cues elsewhere. Empty if there is no condition.
    ///
    /// With two outcomes, "unless" means the other one.
    pub(super) fn outcomes(&self, world: &World, instruction: &str, mentions: &Mentions) -> Vec<Fact> {
        if self.words.is_empty() && !self.has_alternative {
            return Vec::new();
        }
        let all = plain_words(instruction);
        let is_in_clause = |cue: &String| self.words.iter().any(|words| has_cue(words, cue));
        let is_anywhere = |cue: &String| has_cue(&all, cue);
        let mut found = outcomes_with(world, mentions, &is_in_clause);
        if found.is_empty() {
            found = outcomes_with(world, mentions, &is_anywhere);
        }
        if self.unless > 0 && self.unless == self.words.len() {
            let domain = world.domain();
            let has_own = |fact: &Fact| domain.words(fact.predicate()).cues.iter().any(is_in_clause);
            let fits = |fact: &Fact| has_own(fact) == (domain.outcomes(*fact).len() > 2);
            if found.iter().any(fits) {
                found.retain(fits);
            }
        }
        found
    }
}

/// Returns the outcomes about named entities of all sensing actions with an outcome that has such a cue.
fn outcomes_with(world: &World, mentions: &Mentions, is_said: &dyn Fn(&String) -> bool) -> Vec<Fact> {
    let domain = world.domain();
    let mut found = Vec::new();
    for action in &domain.actions {
        let mut cues = action.senses.iter().flat_map(|atom| &domain.words(atom.predicate).cues);
        if !cues.any(is_said) {
            continue;
        }
        for atom in &action.senses {
            let [parameter] = &domain.predicate(atom.predicate).parameters[..] else {
                continue;
            };
            if state_word(domain, atom.predicate).is_some() {
                let named = mentions
                    .entities
                    .iter()
                    .filter(|entity| world.is_of_kind(**entity, parameter.kind));
                found.extend(named.map(|entity| Fact::new(atom.predicate, [*entity])));
            }
        }
    }
    found
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
