//! Help for people who describe a robot.
//!
//! - [`from_answers`] and [`from_any_pddl`] write all files of a new domain, from an author's answers or from a PDDL file.
//! - [`lint`](lint()) finds probable mistakes in a domain that loads, and [`lint_environment`] those of an environment.
//! - [`samples`] writes instructions with known goals for a domain.

mod lint;
mod new_domain;

pub use lint::{Finding, Lint, lint, lint_environment};
#[cfg(feature = "schema")]
pub use new_domain::answers_schema;
pub use new_domain::{
    ActionAnswer, AnswerMistake, Answers, KindAnswer, MissedRemoval, Misspelt, NewDomain, Sample, SourceText,
    UnmadeState, action_mistake, from_answers, from_any_pddl, guess_removed, guess_start, missed_removals,
    misspelt_kind, replace_state, same_state, samples, sentence_mistake, start_mistake, unmade_states, unused_kinds,
};
