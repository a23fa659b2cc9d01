//! Numeric functions, expressions and changes.

use super::conditions::Effects;
use super::{Dialect, Reader, Scope, Semantics, TOTAL_COST};
use crate::domain::sexpr::Expression;
use crate::domain::{Condition, Predicate, TypeId};
use crate::model::{
    Application, Arithmetic, FunctionId, Number, NumberChangeKind, NumericEffect, NumericExpression, Operation, When,
};

/// Returns true for the name of a function without arguments that stands without parentheses, as PDDL allows.
fn is_bare(item: &Expression, names: &Semantics) -> bool {
    let is_own = |own: &Predicate| own.parameters.is_empty() && Some(own.name.as_str()) == item.word();
    names.functions.iter().any(is_own)
}

impl Reader<'_> {
    /// Parses `(:functions ...)`: numeric functions, each optionally followed by `- number`.
    pub(super) fn functions(&mut self, items: &[Expression], semantics: &mut Semantics) {
        let mut items = items.iter();
        while let Some(item) = items.next() {
            if item.word() == Some("-") {
                match items.next() {
                    Some(kind) if kind.word() == Some("number") => {}
                    other => {
                        let position = other.map_or(item.position, |kind| kind.position);
                        self.report(
                            position,
                            "a function has the type `number`; other types are not supported",
                            "write a predicate with the value as its last argument",
                        );
                    }
                }
                continue;
            }
            let Some([head, parameters @ ..]) = item.list() else {
                self.report(
                    item.position,
                    "expected `(function ?x - type)`",
                    "write the declaration in parentheses",
                );
                continue;
            };
            let Some(name) = head.word() else {
                self.report(
                    head.position,
                    "expected a function's name",
                    "write `(function ?x - type)`",
                );
                continue;
            };
            // With arguments, it is a number like others.
            if name == TOTAL_COST && parameters.is_empty() {
                semantics.costs = true;
                continue;
            }
            let taken = |own: &Predicate| own.name == name;
            if semantics.functions.iter().any(taken) || semantics.predicates.iter().any(taken) {
                let message = format!("`{name}` is declared twice");
                self.report(head.position, message, "give one of them another name");
                continue;
            }
            if let Some(function) = self.declaration(head, name, parameters, &semantics.types) {
                semantics.function_positions.push(head.position);
                semantics.functions.push(function);
            }
        }
    }

    /// Parses a numeric expression; reports errors.
    pub(crate) fn number(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<NumericExpression> {
        if is_bare(item, names) {
            return self.application(item, scope, names).map(Arithmetic::Value);
        }
        let Some(list) = item.list() else {
            // Planners write numbers with more places than are kept.
            let parse = match self.dialect {
                Dialect::Longstep => Number::parse,
                Dialect::Standard => Number::parse_rounded,
            };
            let number = item.word().and_then(parse);
            if number.is_none() {
                let message = format!(
                    "`{}` is no number: expected digits with at most six places after the point, or `(function ...)`",
                    item.word().unwrap_or("?")
                );
                self.report(
                    item.position,
                    message,
                    "write a number, or declare the function in `(:functions ...)`",
                );
            }
            return number.map(Arithmetic::Constant);
        };
        let Some((head, rest)) = list.split_first() else {
            self.report(
                item.position,
                "expected a number or `(function argument ...)`",
                "write one of them",
            );
            return None;
        };
        let Some(operation) = head.word().and_then(Operation::of) else {
            return self.application(item, scope, names).map(Arithmetic::Value);
        };
        let mut values = Vec::with_capacity(rest.len());
        for part in rest {
            values.push(self.number(part, scope, names)?);
        }
        // Sums and products may have any number of parts; a single part of a difference is negated.
        let negation = operation == Operation::Minus && values.len() == 1;
        if negation {
            values.insert(0, Arithmetic::Constant(Number::ZERO));
        }
        let many = matches!(operation, Operation::Plus | Operation::Times);
        if values.len() < 2 || (values.len() > 2 && !many) {
            let message = format!("`{}` has the wrong number of parts", operation.symbol());
            self.report(
                item.position,
                message,
                "sums and products have two or more parts, differences and quotients two",
            );
            return None;
        }
        let folded = values
            .into_iter()
            .reduce(|left, right| Arithmetic::operation(operation, left, right));
        // Computes operations on constants.
        folded.map(|folded| folded.map(&mut |own: &Application| Arithmetic::Value(own.clone())))
    }

    /// Parses `(function argument ...)`; reports errors.
    pub(crate) fn application(&mut self, item: &Expression, scope: &Scope, names: &Semantics) -> Option<Application> {
        let bare = is_bare(item, names).then_some((item, &[][..]));
        let Some((head, arguments)) = bare.or_else(|| item.list().and_then(<[_]>::split_first)) else {
            self.report(
                item.position,
                "expected `(function argument ...)`",
                "write a number that the domain declares in `(:functions ...)`",
            );
            return None;
        };
        let name = head.word().unwrap_or_default();
        let Some(index) = names.functions.iter().position(|own| own.name == name) else {
            if name == TOTAL_COST {
                self.report(
                    head.position,
                    "`(total-cost)` is the cost of the plan; only effects may increase it",
                    "declare a function of another name and increase it too",
                );
            } else {
                let known = names.functions.iter().map(|own| own.name.as_str());
                self.report_unknown(head.position, "function", name, known);
            }
            return None;
        };
        let parameters = &names.functions[index].parameters;
        let terms = self.arguments(item, name, arguments, parameters, scope, names)?;
        Some(Application {
            function: FunctionId::new(index),
            terms,
            at: When::Now,
        })
    }

    /// Returns true if the text is a number or begins like a numeric expression.
    pub(super) fn is_numeric(item: &Expression, names: &Semantics) -> bool {
        match item.list() {
            None if is_bare(item, names) => true,
            None => item
                .word()
                .is_some_and(|word| Number::parse(word).is_some() && !word.starts_with('?')),
            Some(list) => list.first().and_then(Expression::word).is_some_and(|head| {
                Operation::of(head).is_some()
                    || names.functions.iter().any(|own| own.name == head)
                    || head == TOTAL_COST
            }),
        }
    }

    /// Parses `(increase FLUENT VALUE)` and the like.
    pub(super) fn numeric_effect(
        &mut self,
        (kind, item, rest): (NumberChangeKind, &Expression, &[Expression]),
        scope: &Scope,
        forall: &[(usize, TypeId)],
        when: &Condition,
        names: &Semantics,
        effects: &mut Effects,
    ) {
        let [fluent, value] = rest else {
            let message = format!("`{}` has the wrong number of parts", kind.word());
            return self.report(
                item.position,
                message,
                format!("write `({} (function argument ...) NUMBER)`", kind.word()),
            );
        };
        let is_cost = fluent
            .list()
            .is_some_and(|list| matches!(list, [head] if head.word() == Some(TOTAL_COST)));
        if is_cost && names.costs {
            let value = self.number(value, scope, names);
            if kind != NumberChangeKind::Increase || !forall.is_empty() || *when != Condition::TRUE {
                let message = "the cost of a step is one `(increase (total-cost) ...)` outside of `when` and `forall`";
                return self.report(item.position, message, "write it once in the effect, outside of them");
            }
            effects.cost = match (effects.cost.take(), value) {
                (Some(one), Some(other)) => Some(Arithmetic::operation(Operation::Plus, one, other)),
                (one, other) => one.or(other),
            };
            return;
        }
        let fluent = self.application(fluent, scope, names);
        let value = self.number(value, scope, names);
        if let (Some(fluent), Some(value)) = (fluent, value) {
            effects.numbers.push(NumericEffect {
                forall: forall.to_vec(),
                condition: when.clone(),
                fluent,
                kind,
                value,
            });
        }
    }
}
