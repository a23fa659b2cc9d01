//! Robot domains with their prompts: shipped ones, and ones loaded from a folder.
//!
//! A domain is a folder: `domain.pddl` holds the semantics, `domain.toml` the vocabulary, `prompt/` the texts for a
//! model. [`load`] reads all three and reports every contradiction between them. [`from_pddl`] needs the PDDL only.

pub use crate::lint::{Finding, Lint, lint, lint_environment};
pub use crate::load::{from_pddl, load, shipped};
pub use crate::model::*;
pub use crate::new_domain::{
    ActionAnswer, AnswerMistake, Answers, KindAnswer, MissedRemoval, Misspelt, NewDomain, Sample, SourceText,
    UnmadeState, action_mistake, from_answers, from_any_pddl, guess_removed, guess_start, missed_removals,
    misspelt_kind, replace_state, same_state, samples, sentence_mistake, start_mistake, unmade_states, unused_kinds,
};
