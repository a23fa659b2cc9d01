//! The data model: domains, facts, states, worlds, conditions, and the evaluation of conditions.
//!
//! This module reads no files, and does not search or verify. A [`Domain`] defines the actions of a robot, a [`World`]
//! its entities and initial state. [`holds`] evaluates a [`Condition`] in a [`Moment`], and [`apply`] applies an action
//! to a [`State`].

mod arithmetic;
mod article;
mod condition;
mod diff;
mod distinction;
mod domain;
mod environment;
mod evaluate;
mod fact;
mod id;
mod label;
mod lexicon;
mod naming;
mod number;
mod numeric_effect;
mod prohibition;
mod relation;
mod rules;
mod simulate;
mod skill;
mod support;
mod template;
mod trace;
mod value;
mod wanted;
mod wording;
mod world;

pub use arithmetic::{
    Application, Arithmetic, Comparison, Fluent, FunctionId, GroundExpression, GroundTest, NumberTest,
    NumericExpression, Operation,
};
pub use condition::{Atom, Condition, Effect, Slot, Term, When};
pub use diff::{Difference, changed_facts, differences};
pub use distinction::Distinctions;
pub(crate) use domain::ActionSchema;
pub use domain::{
    Action, ActionId, DefaultFact, Derivation, DerivedPredicate, Domain, DomainData, EnvironmentTypes, FormPiece,
    Function, GoalWord, GoalWordId, Literal, Parameter, Predicate, PredicateId, PredicateWords, PropertyWord,
    RepairCosts, Rule, RuleTime, StateWord, TypeId, Types, Unknown,
};
pub use environment::{Environment, EnvironmentError, Words};
pub use evaluate::{
    Bindings, Moment, ever_candidates, for_candidates, for_matching, ground, grounded_term, holds, static_value, unify,
};
pub use fact::{ChangedLists, EntityId, Fact, FactSet, State};
pub(crate) use id::id;
pub(crate) use label::{NameForms, unified};
pub use label::{base_name, ends_with, label, matches_name, stem};
pub(crate) use lexicon::is_mark;
pub use lexicon::{Lexicon, head, plain_words, singular};
pub(crate) use naming::name_entities;
pub use naming::{Voice, change_text, fact_text, fluent_text};
pub use number::Number;
pub use numeric_effect::{NumberChangeKind, NumericEffect, applicability, assigned};
pub use prohibition::{Prohibition, StepPattern};
pub use relation::SpatialRelation;
pub use rules::broken_bindings;
pub use simulate::{Missing, Shortfall, apply, apply_onto, fired, rests_on, unmet};
pub use skill::{SkillFit, SkillParameter, SkillSource, SkillType};
pub use support::{StateVariable, support};
pub use template::{Template, phrase};
pub use trace::{Change, Changes, Ending, NumberChange, StepId, Trace};
pub use value::{OutOfRange, QuantityForm, TEXT_VALUE_LIMIT, Value, ValueForm, ValueMention, ValueType};
pub use wanted::Wanted;
pub use wording::{entries_of, entry_of_number, state_word, subject_of, written_fact};
pub use world::{AssumptionSource, ENTITY_LIMIT, Entity, World};
