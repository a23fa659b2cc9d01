//! Domains without a wording file, from PDDL written for any planner.

use super::content_hash::content_hash;
use super::pddl::{self, Dialect, Semantics};
use super::{
    Action, Atom, Domain, DomainData, EnvironmentTypes, Function, Lexicon, Predicate, PredicateWords, RepairCosts,
    StateWord, Template, Term, TypeId, Unknown,
};
use crate::diagnostic::{Diagnostic, Diagnostics, Position};

/// Reads a `domain.pddl` that has no `domain.toml` beside it.
///
/// The wording is PDDL's own: a fact is written `(on cup table)`, a step `stack(cup, table)`, and the states of an
/// entity are all facts with that entity as first argument. There are no goal words and no rules; goals come from a
/// problem file, read by `longstep_search::pddl::read_problem`.
///
/// `file` is the name of the text in diagnostics. Inexact PDDL that most planners accept (arguments of a type other
/// than the declared one, `object` declared as a type) is accepted, while [`super::load`] rejects it.
///
/// # Errors
///
/// All errors in the text, with their positions.
///
/// ```
/// let text = "(define (domain lamps) (:predicates (lit ?lamp))
///     (:action light :parameters (?lamp) :precondition () :effect (lit ?lamp)))";
/// let domain = longstep_model::domain::from_pddl("lamps.pddl", text)?;
/// assert_eq!((domain.name.as_str(), domain.actions[0].call.as_str()), ("lamps", "light"));
/// # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
/// ```
pub fn from_pddl(file: &str, text: &str) -> Result<Domain, Diagnostics> {
    read_foreign(file, text, None).map(|own| own.domain)
}

/// Reads a domain as [`from_pddl`] does, together with the text of a problem: objects of the problem that the actions name are
/// constants, which some planners accept without a declaration.
///
/// # Errors
///
/// All errors in the text of the domain, with their positions. What is wrong in the problem is told by
/// `longstep_search::pddl::read_problem`.
///
/// ```
/// let domain = "(define (domain dock) (:predicates (at ?x))
///     (:action return :parameters () :precondition () :effect (at base)))";
/// let problem = "(define (problem p) (:domain dock) (:objects base) (:init) (:goal (at base)))";
/// let domain = longstep_model::domain::from_pddl_for("dock.pddl", domain, problem)?;
/// assert_eq!(domain.constants.len(), 1);
/// # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
/// ```
pub fn from_pddl_for(file: &str, text: &str, problem: &str) -> Result<Domain, Diagnostics> {
    read_foreign(file, text, Some(problem)).map(|own| own.domain)
}

/// A domain file of any origin, as this library reads it.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ForeignDomain {
    /// The domain, with PDDL's own wording.
    pub domain: Domain,
    /// The text in which this library would write it, if that is another one.
    pub rewritten: Option<String>,
    /// Notes on the parts that were rewritten or left out.
    pub notes: Vec<Diagnostic>,
    /// The places of its declarations.
    pub positions: DeclarationPositions,
}

/// Reads a domain as [`from_pddl`] and [`from_pddl_for`] do, and returns what was rewritten in it.
///
/// # Errors
///
/// All errors in the text of the domain, with their positions.
///
/// ```
/// let text = "(define (domain lamps) (:predicates (lit ?lamp))
///     (:durative-action light :parameters (?lamp) :duration (= ?duration 3) :condition () :effect (at end (lit ?lamp))))";
/// let own = longstep_model::domain::read_foreign("lamps.pddl", text, None)?;
/// assert!(own.rewritten.unwrap().contains("(:action light") && own.notes.len() == 1);
/// # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
/// ```
pub fn read_foreign(file: &str, text: &str, problem: Option<&str>) -> Result<ForeignDomain, Diagnostics> {
    let problem = problem.and_then(|text| pddl::foreign::read_problem("", text).ok());
    let problem = problem.as_ref().and_then(|own| own.expressions.first());
    let own = pddl::foreign::read(file, text, problem).map_err(|finding| Diagnostics(vec![finding]))?;
    let mut findings = Vec::new();
    let semantics = pddl::read_expressions(file, &own.expressions, Dialect::Standard, &mut findings);
    let counts = [
        semantics.types.count(),
        semantics.constants.len(),
        semantics.predicates.len(),
        semantics.actions.len(),
    ];
    if counts.iter().any(|count| *count > crate::model::ENTITY_LIMIT) {
        let finding = Diagnostic::whole(file, "too many names for one domain");
        findings.push(finding.hint(format!(
            "a domain has at most {} of each kind",
            crate::model::ENTITY_LIMIT
        )));
    }
    if !findings.is_empty() {
        return Err(Diagnostics::sorted(findings));
    }
    let positions = DeclarationPositions {
        predicates: semantics.predicate_positions.clone(),
        functions: semantics.function_positions.clone(),
        actions: semantics.action_positions.clone(),
    };
    Ok(ForeignDomain {
        domain: with_plain_words(semantics, content_hash(&[text])),
        rewritten: own.is_rewritten.then(|| pddl::written::written(&own.expressions)),
        notes: own.notes,
        positions,
    })
}

/// The places in a PDDL file where its names are declared, in the order of the domain's lists.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct DeclarationPositions {
    /// The predicates.
    pub predicates: Vec<Position>,
    /// The numeric functions.
    pub functions: Vec<Position>,
    /// The actions.
    pub actions: Vec<Position>,
}

fn with_plain_words(semantics: Semantics, hash: String) -> Domain {
    let mut fluent = vec![false; semantics.predicates.len()];
    for effect in semantics.actions.iter().flat_map(|action| &action.effects) {
        fluent[effect.atom.predicate.index()] = true;
    }
    let words = |(predicate, fluent): (&Predicate, bool)| PredicateWords {
        says: Template::pddl(&predicate.name, predicate.parameters.len()),
        denies: Template::pddl_not(&predicate.name, predicate.parameters.len()),
        short: None,
        event: false,
        unknown: Unknown::False,
        complete: false,
        fluent,
        past: None,
    };
    // A fact without arguments has no entity under which an environment could list it.
    let about_something = semantics.predicates.iter().enumerate();
    let is_derived = |index: usize| semantics.derived.iter().any(|own| own.predicate.index() == index);
    let states = about_something.filter(|(index, predicate)| !predicate.parameters.is_empty() && !is_derived(*index));
    let state = |(index, predicate): (usize, &Predicate)| StateWord {
        word: predicate.name.clone(),
        parameters: predicate.parameters[1..].iter().map(|p| p.name.clone()).collect(),
        atom: Atom {
            predicate: super::PredicateId::new(index),
            terms: (0..predicate.parameters.len()).map(Term::Variable).collect(),
        },
        means: String::new(),
        relations: Vec::new(),
    };
    let functions = semantics.functions.iter().enumerate();
    let functions = functions.map(|(index, function)| plain_function(function, is_changed(&semantics, index)));
    let functions = functions.collect();
    let data = DomainData {
        hash,
        about: format!("The PDDL domain {}, without words of its own.", semantics.name),
        environment: EnvironmentTypes {
            asset: TypeId::OBJECT,
            object: TypeId::OBJECT,
        },
        predicate_words: semantics.predicates.iter().zip(fluent).map(words).collect(),
        states: states.map(state).collect(),
        properties: Vec::new(),
        derived: semantics.derived,
        derivations: Vec::new(),
        defaults: Vec::new(),
        rules: Vec::new(),
        functions,
        goal_words: Vec::new(),
        repair: RepairCosts::default(),
        values: Vec::new(),
        lexicon: Lexicon::default(),
        implied: indexmap::IndexMap::new(),
        article: String::new(),
        speaker_names: Vec::new(),
        robot_names: Vec::new(),
        actions: semantics
            .actions
            .into_iter()
            .map(|schema| Action {
                explicit: (0..schema.parameters.len()).collect(),
                object: None,
                actor: None,
                senses: Vec::new(),
                says: Template::pddl(&schema.name, schema.parameters.len()),
                means: String::new(),
                retries: 2,
                skills: Vec::new(),
                call: schema.name.clone(),
                name: schema.name,
                parameters: schema.parameters,
                precondition: schema.precondition,
                effects: schema.effects,
                numeric: schema.numeric,
                cost: schema.cost,
            })
            .collect(),
        name: semantics.name.clone(),
        pddl_name: semantics.name,
        types: semantics.types,
        constants: semantics.constants,
        predicates: semantics.predicates,
    };
    data.into()
}

/// Returns true if an action changes the numeric function.
pub(super) fn is_changed(semantics: &Semantics, function: usize) -> bool {
    let effects = semantics.actions.iter().flat_map(|action| &action.numeric);
    effects
        .into_iter()
        .any(|effect| effect.fluent.function.index() == function)
}

/// Returns a numeric function with PDDL's own wording: `(level tank)`.
pub(super) fn plain_function(function: &Predicate, changes: bool) -> Function {
    Function {
        name: function.name.clone(),
        parameters: function.parameters.clone(),
        changes,
        word: function.name.clone(),
        unit: None,
        says: Template::pddl(&function.name, function.parameters.len()),
        min: None,
        max: None,
    }
}
