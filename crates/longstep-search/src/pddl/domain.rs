//! The writer of PDDL domains.
//!
//! The text is written from the domain as it is verified, not copied from its file: derived predicates stand where they are used,
//! durative actions are steps, names are in lower case, and an argument always has the type that its predicate declares. Strict
//! readers (VAL, unified-planning) need the last one.

use std::fmt::Write;

use super::write::WriteError;
use longstep_model::model::{
    Action, Application, Arithmetic, Atom, Comparison, Condition, Domain, Effect, NumberTest, NumericEffect,
    NumericExpression, Parameter, PredicateId, Slot, Term, TypeId, When,
};

/// Requirements of every domain that is written: a goal may have negations, disjunctions and equalities even where no action has.
const REQUIREMENTS: &str = ":strips :typing :negative-preconditions :disjunctive-preconditions\n                 \
                            :quantified-preconditions :conditional-effects :equality";

/// Writes a domain for other planners and for validators, to go with [`write_problem`](super::write_problem).
///
/// Texts and words of the domain are left out, and so are its rules, which are conditions on plans and not on steps.
///
/// ```
/// use longstep_model::domain;
/// use longstep_search::pddl;
///
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = pddl::write_domain(&household)?;
/// let again = domain::from_pddl("domain.pddl", &text).unwrap();
/// assert_eq!(pddl::write_domain(&again)?, text);
/// # Ok::<(), pddl::WriteError>(())
/// ```
///
/// # Errors
///
/// [`WriteError::Past`] if an action depends on the state before the plan.
pub fn write_domain(domain: &Domain) -> Result<String, WriteError> {
    let mut text = format!("(define (domain {})\n  (:requirements {REQUIREMENTS}", domain.pddl_name);
    if !domain.functions.is_empty() {
        text.push_str(" :fluents");
    }
    if domain.has_costs() {
        text.push_str(" :action-costs");
    }
    text.push_str(")\n");
    text.push_str(&types(domain));
    if !domain.constants.is_empty() {
        let constants = domain.constants.iter();
        let constants = constants.map(|(name, kind)| format!("{name} - {}", domain.types.name(*kind)));
        section(&mut text, ":constants", constants);
    }
    section(&mut text, ":predicates", predicates(domain));
    if domain.has_costs() || !domain.functions.is_empty() {
        let functions = domain.functions.iter();
        let functions = functions.map(|own| format!("{} - number", head(domain, &own.name, &own.parameters)));
        let cost = domain.has_costs().then(|| "(total-cost) - number".to_owned());
        section(&mut text, ":functions", functions.chain(cost));
    }
    for action in &domain.actions {
        text.push_str(&ActionWriter { domain, action }.action()?);
    }
    text.push_str(")\n");
    Ok(text)
}

fn section(text: &mut String, name: &str, lines: impl IntoIterator<Item = String>) {
    let _ = write!(text, "  ({name}");
    for line in lines {
        let _ = write!(text, "\n    {line}");
    }
    text.push_str(")\n");
}

/// Writes the types in their order, neighbors with one supertype in one line.
fn types(domain: &Domain) -> String {
    let types = &domain.types;
    let all: Vec<TypeId> = (1..types.count()).map(TypeId::new).collect();
    let line = |kinds: &[TypeId]| {
        let names: Vec<&str> = kinds.iter().map(|kind| types.name(*kind)).collect();
        format!("{} - {}", names.join(" "), types.name(types.parent(kinds[0])))
    };
    let mut text = String::new();
    if !all.is_empty() {
        let groups = all.chunk_by(|one, other| types.parent(*one) == types.parent(*other));
        section(&mut text, ":types", groups.map(line));
    }
    text
}

fn head(domain: &Domain, name: &str, parameters: &[Parameter]) -> String {
    let mut text = format!("({name}");
    for parameter in parameters {
        let _ = write!(text, " ?{} - {}", parameter.name, domain.types.name(parameter.kind));
    }
    text.push(')');
    text
}

/// Writes the predicates. A parameter gets a supertype of its own where an action uses the predicate for one.
fn predicates(domain: &Domain) -> Vec<String> {
    let mut parameters: Vec<Vec<Parameter>> = domain.predicates.iter().map(|own| own.parameters.clone()).collect();
    for action in &domain.actions {
        let mut kinds: Vec<TypeId> = action.parameters.iter().map(|own| own.kind).collect();
        widen_in(domain, &action.precondition, &mut kinds, &mut parameters);
        let changes = action.effects.iter();
        for effect in changes {
            let mut kinds = bound(&kinds, &effect.forall);
            widen_in(domain, &effect.condition, &mut kinds, &mut parameters);
            widen(domain, &effect.atom, &kinds, &mut parameters);
        }
        for effect in &action.numeric {
            let mut kinds = bound(&kinds, &effect.forall);
            widen_in(domain, &effect.condition, &mut kinds, &mut parameters);
        }
    }
    let is_derived = |id: PredicateId| domain.derived.iter().any(|own| own.predicate == id);
    let predicates = domain.predicates.iter().zip(&parameters).enumerate();
    let written = predicates.filter(|(index, _)| !is_derived(PredicateId::new(*index)));
    written
        .map(|(_, (predicate, parameters))| head(domain, &predicate.name, parameters))
        .collect()
}

/// Returns the types of the slots behind those of an effect's own variables.
fn bound(kinds: &[TypeId], forall: &[(Slot, TypeId)]) -> Vec<TypeId> {
    let mut kinds = kinds.to_vec();
    for (slot, kind) in forall {
        bind(&mut kinds, *slot, *kind);
    }
    kinds
}

fn bind(kinds: &mut Vec<TypeId>, slot: Slot, kind: TypeId) {
    kinds.resize(kinds.len().max(slot + 1), TypeId::OBJECT);
    kinds[slot] = kind;
}

fn widen_in(domain: &Domain, condition: &Condition, kinds: &mut Vec<TypeId>, parameters: &mut [Vec<Parameter>]) {
    match condition {
        Condition::And(parts) | Condition::Or(parts) => {
            for part in parts {
                widen_in(domain, part, kinds, parameters);
            }
        }
        Condition::Forall(slot, kind, inner) | Condition::Exists(slot, kind, inner) => {
            bind(kinds, *slot, *kind);
            widen_in(domain, inner, kinds, parameters);
        }
        Condition::Atom { atom, .. } => widen(domain, atom, kinds, parameters),
        Condition::Equal { .. } | Condition::Number(_) => {}
    }
}

fn widen(domain: &Domain, atom: &Atom, kinds: &[TypeId], parameters: &mut [Vec<Parameter>]) {
    for (term, parameter) in atom.terms.iter().zip(&mut parameters[atom.predicate.index()]) {
        let kind = match term {
            Term::Variable(slot) => kinds[*slot],
            Term::Constant(id) => domain.constants[id.index()].1,
        };
        while !domain.types.is_a(kind, parameter.kind) {
            parameter.kind = domain.types.parent(parameter.kind);
        }
    }
}

struct ActionWriter<'a> {
    domain: &'a Domain,
    action: &'a Action,
}

impl ActionWriter<'_> {
    fn action(&self) -> Result<String, WriteError> {
        let action = self.action;
        let parameters = action.parameters.iter();
        let parameters = parameters.map(|own| format!("?{} - {}", own.name, self.domain.types.name(own.kind)));
        let mut text = format!(
            "  (:action {}\n    :parameters ({})\n",
            action.name,
            parameters.collect::<Vec<_>>().join(" ")
        );
        // VAL cannot read a domain in which an action has no precondition.
        let _ = writeln!(text, "    :precondition {}", self.condition(&action.precondition)?);
        let _ = writeln!(text, "    :effect {})", self.effect()?);
        Ok(text)
    }

    fn effect(&self) -> Result<String, WriteError> {
        let mut parts = Vec::new();
        let groups = self
            .action
            .effects
            .chunk_by(|one, other| one.forall == other.forall && one.condition == other.condition);
        for group in groups {
            let Effect { forall, condition, .. } = &group[0];
            let changes = group.iter().map(|effect| self.change(effect));
            if forall.is_empty() && *condition == Condition::TRUE {
                parts.extend(changes);
            } else {
                parts.push(self.conditional(forall, condition, changes.collect())?);
            }
        }
        for effect in &self.action.numeric {
            let change = self.numeric_change(effect)?;
            parts.push(self.conditional(&effect.forall, &effect.condition, vec![change])?);
        }
        if let Some(cost) = &self.action.cost {
            parts.push(format!("(increase (total-cost) {})", self.number(cost)?));
        }
        Ok(listed("and", parts, "\n      "))
    }

    /// Writes what holds for every binding of variables under which a condition holds.
    fn conditional(
        &self,
        forall: &[(Slot, TypeId)],
        condition: &Condition,
        changes: Vec<String>,
    ) -> Result<String, WriteError> {
        let mut text = joined("and", changes);
        let condition = self.condition(condition)?;
        if condition != "(and)" {
            text = format!("(when {condition} {text})");
        }
        if !forall.is_empty() {
            let variables = forall.iter().map(|(slot, kind)| self.quantified(*slot, *kind));
            text = format!("(forall ({}) {text})", variables.collect::<Vec<_>>().join(" "));
        }
        Ok(text)
    }

    fn change(&self, effect: &Effect) -> String {
        let atom = self.atom(&effect.atom);
        if effect.adds { atom } else { format!("(not {atom})") }
    }

    fn numeric_change(&self, effect: &NumericEffect) -> Result<String, WriteError> {
        let (fluent, value) = (self.application(&effect.fluent)?, self.number(&effect.value)?);
        Ok(format!("({} {fluent} {value})", effect.kind.word()))
    }

    fn condition(&self, condition: &Condition) -> Result<String, WriteError> {
        Ok(match condition {
            Condition::And(_) => {
                let mut parts = Vec::new();
                for part in conjuncts(condition) {
                    let part = self.condition(part)?;
                    if part != "(and)" {
                        parts.push(part);
                    }
                }
                joined("and", parts)
            }
            Condition::Or(parts) => {
                let parts = parts.iter().map(|part| self.condition(part));
                joined("or", parts.collect::<Result<_, _>>()?)
            }
            Condition::Forall(slot, kind, inner) => self.quantifier("forall", *slot, *kind, inner)?,
            Condition::Exists(slot, kind, inner) => self.quantifier("exists", *slot, *kind, inner)?,
            Condition::Atom { atom, holds, at } => {
                self.present(*at)?;
                let atom = self.atom(atom);
                if *holds { atom } else { format!("(not {atom})") }
            }
            Condition::Equal { left, right, holds } => {
                let equality = format!("(= {} {})", self.term(*left), self.term(*right));
                if *holds { equality } else { format!("(not {equality})") }
            }
            Condition::Number(test) => self.test(test)?,
        })
    }

    fn quantifier(&self, word: &str, slot: Slot, kind: TypeId, inner: &Condition) -> Result<String, WriteError> {
        Ok(format!(
            "({word} ({}) {})",
            self.quantified(slot, kind),
            self.condition(inner)?
        ))
    }

    /// Writes a requirement on numbers. A planner knows a number wherever a comparison with it holds, so the requirement that it is
    /// known is left out.
    fn test(&self, test: &NumberTest<Application>) -> Result<String, WriteError> {
        Ok(match test {
            NumberTest::Compare(left, comparison, right) => {
                let (left, right) = (self.number(left)?, self.number(right)?);
                match comparison {
                    Comparison::NotEqual => format!("(not (= {left} {right}))"),
                    comparison => format!("({comparison} {left} {right})"),
                }
            }
            NumberTest::Known(..) => "(and)".to_owned(),
        })
    }

    fn number(&self, expression: &NumericExpression) -> Result<String, WriteError> {
        Ok(match expression {
            Arithmetic::Constant(number) => number.to_string(),
            Arithmetic::Value(own) => self.application(own)?,
            Arithmetic::Operation(operation, left, right) => {
                format!(
                    "({} {} {})",
                    operation.symbol(),
                    self.number(left)?,
                    self.number(right)?
                )
            }
        })
    }

    fn application(&self, own: &Application) -> Result<String, WriteError> {
        self.present(own.at)?;
        Ok(self.applied(&self.domain.function(own.function).name, &own.terms))
    }

    fn atom(&self, atom: &Atom) -> String {
        self.applied(&self.domain.predicate(atom.predicate).name, &atom.terms)
    }

    fn applied(&self, name: &str, terms: &[Term]) -> String {
        let terms = terms.iter().map(|term| format!(" {}", self.term(*term)));
        format!("({name}{})", terms.collect::<String>())
    }

    fn present(&self, at: When) -> Result<(), WriteError> {
        match at {
            When::Now => Ok(()),
            When::Start | When::Initially => Err(WriteError::Past {
                action: self.action.name.clone(),
            }),
        }
    }

    fn term(&self, term: Term) -> String {
        match term {
            Term::Variable(slot) => self.variable(slot),
            Term::Constant(id) => self.domain.constants[id.index()].0.clone(),
        }
    }

    fn quantified(&self, slot: Slot, kind: TypeId) -> String {
        format!("{} - {}", self.variable(slot), self.domain.types.name(kind))
    }

    /// Returns the name of a parameter, or one that no parameter has.
    fn variable(&self, slot: Slot) -> String {
        let parameters = &self.action.parameters;
        match parameters.get(slot) {
            Some(parameter) => format!("?{}", parameter.name),
            None => {
                let mut name = format!("x{}", slot - parameters.len() + 1);
                while parameters.iter().any(|own| own.name == name) {
                    name.push('_');
                }
                format!("?{name}")
            }
        }
    }
}

/// Returns the conjuncts of a condition, also those of a disjunction of one part.
fn conjuncts(condition: &Condition) -> Vec<&Condition> {
    let inner = condition.conjuncts().flat_map(|part| match part {
        Condition::Or(parts) if parts.len() == 1 => conjuncts(&parts[0]),
        part => vec![part],
    });
    inner.collect()
}

/// Joins conditions; a single one needs no word.
fn joined(word: &str, parts: Vec<String>) -> String {
    match <[String; 1]>::try_from(parts) {
        Ok([part]) => part,
        Err(parts) => listed(word, parts, " "),
    }
}

fn listed(word: &str, parts: Vec<String>, between: &str) -> String {
    let parts = parts.into_iter().map(|part| format!("{between}{part}"));
    let text = parts.collect::<String>();
    format!("({word}{text})")
}
