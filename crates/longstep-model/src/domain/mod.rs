//! Domains loaded from folders and files.
//!
//! A domain is a folder: `domain.pddl` holds the semantics, `domain.toml` the wording, and `prompt/` the prompts for
//! models. [`load`] reads the first two and reports every inconsistency between them; [`from_pddl`] needs only the
//! PDDL.

mod bare;
mod content_hash;
mod files;
mod load;
pub(crate) mod pddl;
mod problem;
#[doc(hidden)]
pub mod sexpr;
mod shipped;
mod starter;
#[doc(hidden)]
pub mod words;

pub use crate::model::{
    Action, ActionId, Application, Arithmetic, Atom, Comparison, Condition, DefaultFact, Derivation, DerivedPredicate,
    Domain, DomainData, Effect, EnvironmentTypes, FormPiece, Function, FunctionId, GoalWord, GoalWordId, Lexicon,
    Literal, NumberTest, NumericEffect, NumericExpression, OutOfRange, Parameter, Predicate, PredicateId,
    PredicateWords, PropertyWord, QuantityForm, RepairCosts, Rule, RuleTime, Slot, SpatialRelation, StateWord,
    Template, Term, TypeId, Types, Unknown, Value, ValueForm, ValueMention, ValueType, When, base_name, ends_with,
    head, label, matches_name, phrase, plain_words, singular, stem,
};
pub use bare::{DeclarationPositions, ForeignDomain, from_pddl, from_pddl_for, read_foreign};
pub use files::Files;
pub use load::{content_position, load, load_with_findings, read_toml};
pub use problem::{Problem, read_problem, read_start};
pub use shipped::{shipped, shipped_files, shipped_names};
pub use starter::{plain_name, starter};

use crate::model::{ActionSchema, applicability};
