//! Conditions, effects and the facts in them.

use super::{Dialect, Reader, Scope, Semantics};
use crate::domain::sexpr::{Expression, ExpressionKind};
use crate::domain::{Atom, Condition, Effect, Parameter, PredicateId, Term, TypeId};
use crate::model::{Comparison, EntityId, NumberChangeKind, NumberTest, NumericEffect, NumericExpression, When};

/// The effects of an action.
#[derive(Default)]
pub(super) struct Effects {
    pub(super) facts: Vec<Effect>,
    pub(super) numbers: Vec<NumericEffect>,
    pub(super) cost: Option<NumericExpression>,
}

/// Returns the notation of a condition or an effect that begins with a keyword.
fn form_of(word: &str) -> &'static str {
    match word {
        "not" => "(not (predicate argument ...))",
        "imply" => "(imply CONDITION CONDITION)",
        "when" => "(when CONDITION EFFECT)",
        "forall" => "(forall (?x - type) ...)",
        "exists" => "(exists (?x - type) CONDITION)",
        _ => "(= LEFT RIGHT)",
    }
}

impl Reader<'_> {
    /// Parses a condition; reports errors and returns `true` in place of each unreadable part.
    pub(crate) fn condition(&mut self, item: &Expression, scope: &mut Scope, names: &Semantics) -> Condition {
        let Some(list) = item.list() else {
            self.report(
                item.position,
                "expected a condition in parentheses",
                "write `(predicate argument ...)`",
            );
            return Condition::TRUE;
        };
        let Some((head, rest)) = list.split_first() else {
            return Condition::TRUE;
        };
        let all = |reader: &mut Self, scope: &mut Scope| -> Vec<Condition> {
            rest.iter().map(|c| reader.condition(c, scope, names)).collect()
        };
        match (head.word().unwrap_or_default(), rest) {
            ("and", _) => Condition::And(all(self, scope)),
            ("or", _) => Condition::Or(all(self, scope)),
            ("not", [inner]) => self.condition(inner, scope, names).negated(),
            ("imply", [when, then]) => Condition::Or(vec![
                self.condition(when, scope, names).negated(),
                self.condition(then, scope, names),
            ]),
            ("initially", [inner]) if self.dialect == Dialect::Longstep => {
                self.condition(inner, scope, names).initially()
            }
            ("forall" | "exists", [variables, inner]) => {
                let outer = scope.len();
                let (variables, guards) = self.guarded(variables.list().unwrap_or_default(), &names.types, outer);
                scope.extend(variables.into_iter().map(|own| (own.name, own.kind)));
                let quantified: Vec<TypeId> = scope[outer..].iter().map(|(_, kind)| *kind).collect();
                let mut inner = self.condition(inner, scope, names);
                if !guards.is_empty() {
                    inner = match head.word() {
                        Some("forall") => Condition::Or(vec![Condition::And(guards).negated(), inner]),
                        _ => Condition::And(guards.into_iter().chain([inner]).collect()),
                    };
                }
                scope.truncate(outer);
                quantified
                    .into_iter()
                    .enumerate()
                    .rev()
                    .fold(inner, |inner, (index, kind)| match head.word() {
                        Some("forall") => Condition::Forall(outer + index, kind, Box::new(inner)),
                        _ => Condition::Exists(outer + index, kind, Box::new(inner)),
                    })
            }
            (symbol @ ("=" | "<" | "<=" | ">" | ">="), [left, right])
                if symbol != "=" || Self::is_numeric(left, names) || Self::is_numeric(right, names) =>
            {
                let sides = (self.number(left, scope, names), self.number(right, scope, names));
                match (sides, Comparison::of(symbol)) {
                    ((Some(left), Some(right)), Some(comparison)) => {
                        Condition::Number(NumberTest::Compare(left, comparison, right))
                    }
                    _ => Condition::TRUE,
                }
            }
            ("=", [left, right]) => match (self.term(left, scope, names), self.term(right, scope, names)) {
                (Some((left, _)), Some((right, _))) => Condition::Equal {
                    left,
                    right,
                    holds: true,
                },
                _ => Condition::TRUE,
            },
            ("not" | "imply" | "forall" | "exists" | "=" | "<" | "<=" | ">" | ">=", _) => {
                let word = head.word().unwrap_or_default();
                let message = format!("`{word}` has the wrong number of parts");
                self.report(item.position, message, format!("write `{}`", form_of(word)));
                Condition::TRUE
            }
            _ => match self.atom(item, scope, names) {
                Some(atom) => self.defined(item, &atom, scope, names).unwrap_or(Condition::Atom {
                    atom,
                    holds: true,
                    at: When::Now,
                }),
                None => Condition::TRUE,
            },
        }
    }

    /// Returns true if the first part is a list: a fact has names as arguments, so a predicate may be called `assign`.
    fn changes_number(names: &Semantics, rest: &[Expression]) -> bool {
        rest.first().is_some_and(|first| first.list().is_some())
            || !names
                .predicates
                .iter()
                .any(|own| NumberChangeKind::of(&own.name).is_some())
    }

    pub(super) fn effect(
        &mut self,
        item: &Expression,
        scope: &mut Scope,
        forall: &mut Vec<(usize, TypeId)>,
        when: &Condition,
        names: &Semantics,
        effects: &mut Effects,
    ) {
        let Some(list) = item.list() else {
            return self.report(
                item.position,
                "expected an effect in parentheses",
                "write `(predicate argument ...)` or `(not (predicate argument ...))`",
            );
        };
        let Some((head, rest)) = list.split_first() else {
            return;
        };
        let fact = |atom, adds| Effect {
            forall: forall.clone(),
            condition: when.clone(),
            atom,
            adds,
        };
        match (head.word().unwrap_or_default(), rest) {
            ("and", _) => {
                for part in rest {
                    self.effect(part, scope, forall, when, names, effects);
                }
            }
            ("forall", [variables, inner]) => {
                let (outer, quantified) = (scope.len(), forall.len());
                let (variables, guards) = self.guarded(variables.list().unwrap_or_default(), &names.types, outer);
                for variable in variables {
                    forall.push((scope.len(), variable.kind));
                    scope.push((variable.name, variable.kind));
                }
                // Slots of an enclosing `when` move behind the variables of the effect.
                let own = scope.len() - outer;
                let mut when = when
                    .clone()
                    .with_slots(&|slot| if slot < outer { slot } else { slot + own });
                if !guards.is_empty() {
                    when = Condition::And(guards.into_iter().chain([when]).collect());
                }
                self.effect(inner, scope, forall, &when, names, effects);
                scope.truncate(outer);
                forall.truncate(quantified);
            }
            ("when", [condition, inner]) => {
                let condition = self.condition(condition, scope, names);
                let both = match when {
                    Condition::And(outer) if outer.is_empty() => condition,
                    outer => Condition::And(vec![outer.clone(), condition]),
                };
                self.effect(inner, scope, forall, &both, names, effects);
            }
            ("not", [inner]) => {
                let atom = self.changed(inner, scope, names);
                effects.facts.extend(atom.map(|atom| fact(atom, false)));
            }
            ("forall" | "when" | "not", _) => {
                let word = head.word().unwrap_or_default();
                let message = format!("`{word}` has the wrong number of parts");
                self.report(item.position, message, format!("write `{}`", form_of(word)));
            }
            (word, _) if NumberChangeKind::of(word).is_some_and(|_| Self::changes_number(names, rest)) => {
                if let Some(kind) = NumberChangeKind::of(word) {
                    self.numeric_effect((kind, item, rest), scope, forall, when, names, effects);
                }
            }
            _ => {
                let atom = self.changed(item, scope, names);
                effects.facts.extend(atom.map(|atom| fact(atom, true)));
            }
        }
    }

    /// Parses a fact that an effect or an initial state makes true or false.
    pub(crate) fn changed(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<Atom> {
        let atom = self.atom(item, scope, names)?;
        if names.derived.iter().any(|own| own.predicate == atom.predicate) {
            let name = &names.predicates[atom.predicate.index()].name;
            let message = format!("`{name}` is derived, so it follows from other facts and nothing else can set it");
            self.report(
                item.position,
                message,
                "leave it out here, or remove its `(:derived ...)`",
            );
            return None;
        }
        Some(atom)
    }

    pub(crate) fn atom(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<Atom> {
        let Some((head, arguments)) = item.list().and_then(<[_]>::split_first) else {
            self.report(
                item.position,
                "expected `(predicate argument ...)`",
                "write a fact in parentheses, with a predicate of the domain",
            );
            return None;
        };
        let Some(name) = head.word() else {
            self.report(
                head.position,
                "expected a predicate's name",
                "write a fact as `(predicate argument ...)`",
            );
            return None;
        };
        let Some(index) = names.predicates.iter().position(|p| p.name == name) else {
            let known = names.predicates.iter().map(|p| p.name.as_str());
            self.report_unknown(head.position, "predicate", name, known);
            return None;
        };
        let parameters = &names.predicates[index].parameters;
        let terms = self.arguments(item, name, arguments, parameters, scope, names)?;
        Some(Atom {
            predicate: PredicateId::new(index),
            terms,
        })
    }

    /// Parses the arguments of a predicate or a function; reports errors.
    pub(super) fn arguments(
        &mut self,
        item: &Expression,
        name: &str,
        arguments: &[Expression],
        parameters: &[Parameter],
        scope: &Scope,
        names: &Semantics,
    ) -> Option<Vec<Term>> {
        if parameters.len() != arguments.len() {
            let message = format!(
                "`{name}` takes {} argument(s), not {}",
                parameters.len(),
                arguments.len()
            );
            let variables = parameters
                .iter()
                .map(|own| format!(" ?{} - {}", own.name, names.types.name(own.kind)));
            let declared: String = variables.collect();
            self.report(
                item.position,
                message,
                format!("it is declared as `({name}{declared})`"),
            );
            return None;
        }
        let mut terms = Vec::with_capacity(arguments.len());
        for (argument, parameter) in arguments.iter().zip(parameters) {
            let (term, kind) = self.term(argument, scope, names)?;
            // A supertype is allowed: the atom is false for entities of other types.
            let fits = names.types.is_a(kind, parameter.kind) || names.types.is_a(parameter.kind, kind);
            if !fits && self.dialect == Dialect::Longstep {
                let message = format!(
                    "`{name}` takes a {} here, and this is a {}",
                    names.types.name(parameter.kind),
                    names.types.name(kind)
                );
                let hint = format!(
                    "use a {}, or declare a wider type for the argument of `{name}`",
                    names.types.name(parameter.kind)
                );
                self.report(argument.position, message, hint);
                return None;
            }
            terms.push(term);
        }
        Some(terms)
    }

    fn term(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<(Term, TypeId)> {
        let ExpressionKind::Word(word) = &item.kind else {
            self.report(
                item.position,
                "expected a variable or a constant",
                "an argument is one name, as in `?x` or `table`",
            );
            return None;
        };
        if let Some(variable) = word.strip_prefix('?') {
            // The innermost variable shadows others of the same name.
            if let Some(slot) = scope.iter().rposition(|(name, _)| name == variable) {
                return Some((Term::Variable(slot), scope[slot].1));
            }
            let known = scope.iter().map(|(name, _)| name.as_str());
            self.report_unknown(item.position, "variable", variable, known);
            return None;
        }
        match names.constants.iter().position(|(name, _)| name == word) {
            Some(index) => Some((Term::Constant(EntityId::new(index)), names.constants[index].1)),
            None => {
                let known = names.constants.iter().map(|(name, _)| name.as_str());
                self.report_unknown(item.position, "constant", word, known);
                None
            }
        }
    }
}
