//! Effects on numbers, and the requirements that they impose on their action.

use std::ops::ControlFlow;

use rustc_hash::FxHashSet;

use super::{
    Application, Arithmetic, Bindings, Comparison, Condition, Fluent, Moment, Number, NumberTest, NumericExpression,
    Operation, Slot, State, Term, TypeId, World, for_candidates, holds,
};
use crate::effort;

/// The way in which an effect changes a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum NumberChangeKind {
    /// The fluent gets the value.
    Assign,
    /// The value is added.
    Increase,
    /// The value is subtracted.
    Decrease,
}

impl NumberChangeKind {
    /// Returns the kind with this name in PDDL.
    pub(crate) fn of(word: &str) -> Option<Self> {
        Some(match word {
            "assign" => Self::Assign,
            "increase" => Self::Increase,
            "decrease" => Self::Decrease,
            _ => return None,
        })
    }

    /// Returns the name in PDDL.
    pub fn word(self) -> &'static str {
        match self {
            Self::Assign => "assign",
            Self::Increase => "increase",
            Self::Decrease => "decrease",
        }
    }

    /// Returns the new value as an expression.
    pub(crate) fn result<V>(self, before: Arithmetic<V>, value: Arithmetic<V>) -> Arithmetic<V> {
        match self {
            Self::Assign => value,
            Self::Increase => Arithmetic::operation(Operation::Plus, before, value),
            Self::Decrease => Arithmetic::operation(Operation::Minus, before, value),
        }
    }
}

/// An effect on one number, for every binding of `forall` under which `condition` held before the action.
///
/// The value is computed in the state before the action. Increases and decreases of one fluent add up.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct NumericEffect {
    /// The quantified variables with their types.
    pub forall: Vec<(Slot, TypeId)>,
    /// The condition, evaluated in the state before the action.
    pub condition: Condition,
    /// The fluent that changes.
    pub fluent: Application,
    /// The way in which it changes.
    pub kind: NumberChangeKind,
    /// The value that is assigned, added or subtracted.
    pub value: NumericExpression,
}

impl NumericEffect {
    /// Returns the effect with its quantified variables moved behind `more` other slots that follow the parameters.
    fn moved(&self, parameters: usize, more: usize) -> Self {
        let slot = |slot: Slot| if slot < parameters { slot } else { slot + more };
        let term = |term: Term| match term {
            Term::Variable(variable) => Term::Variable(slot(variable)),
            constant @ Term::Constant(_) => constant,
        };
        Self {
            forall: self.forall.iter().map(|(own, kind)| (slot(*own), *kind)).collect(),
            condition: self.condition.clone().with_slots(&slot),
            fluent: self.fluent.with_terms(&term),
            kind: self.kind,
            value: self.value.with_terms(&term),
        }
    }
}

/// Returns the conditions under which the effects of an action can be computed: the new numbers are known, and no two
/// effects give one fluent different values. They are part of the action's precondition.
pub fn applicability(effects: &[NumericEffect], parameters: usize) -> Vec<Condition> {
    let mut conditions: Vec<Condition> = effects.iter().filter_map(computable).collect();
    for (index, first) in effects.iter().enumerate() {
        for (other, second) in effects.iter().enumerate().skip(index) {
            if first.fluent.function != second.fluent.function {
                continue;
            }
            let adds = |effect: &NumericEffect| effect.kind != NumberChangeKind::Assign;
            // Instances of one effect change different fluents if all its variables occur in the fluent.
            let single = index == other
                && first
                    .forall
                    .iter()
                    .all(|(slot, _)| first.fluent.terms.contains(&Term::Variable(*slot)));
            if !(single || adds(first) && adds(second)) {
                conditions.extend(agreement(
                    first,
                    &second.moved(parameters, first.forall.len()),
                    parameters,
                ));
            }
        }
    }
    conditions
}

/// Returns the condition that the new number is known wherever the effect fires; none if it always is.
fn computable(effect: &NumericEffect) -> Option<Condition> {
    let before = Arithmetic::Value(effect.fluent.clone());
    let result = effect.kind.result(before, effect.value.clone());
    if matches!(result, Arithmetic::Constant(_)) {
        return None;
    }
    let known = Condition::Number(NumberTest::Known(result, true));
    let guarded = match &effect.condition {
        Condition::And(parts) if parts.is_empty() => known,
        condition => Condition::Or(vec![condition.clone().complement(), known]),
    };
    Some(everywhere(guarded, &effect.forall))
}

/// Returns the condition that two effects on one function do not contradict each other; none if their arguments always
/// differ.
fn agreement(first: &NumericEffect, second: &NumericEffect, parameters: usize) -> Option<Condition> {
    // Quantifiers inside the first condition move behind the variables of the second effect.
    let own = parameters + first.forall.len();
    let inner = |slot: Slot| if slot < own { slot } else { slot + second.forall.len() };
    let condition = first.condition.clone().with_slots(&inner);
    let mut alternatives = vec![condition.complement(), second.condition.clone().complement()];
    for (left, right) in first.fluent.terms.iter().zip(&second.fluent.terms) {
        match (left, right) {
            (Term::Constant(left), Term::Constant(right)) if left != right => return None,
            _ if left == right => {}
            _ => alternatives.push(Condition::Equal {
                left: *left,
                right: *right,
                holds: false,
            }),
        }
    }
    if first.kind == NumberChangeKind::Assign && second.kind == NumberChangeKind::Assign {
        let (left, right) = (first.value.clone(), second.value.clone());
        alternatives.push(Condition::Number(NumberTest::Compare(left, Comparison::Equal, right)));
    }
    let forall: Vec<_> = first.forall.iter().chain(&second.forall).copied().collect();
    Some(everywhere(Condition::Or(alternatives), &forall))
}

/// Quantifies a condition, which may have quantifiers of its own behind these slots.
fn everywhere(condition: Condition, forall: &[(Slot, TypeId)]) -> Condition {
    forall.iter().rev().fold(condition, |inner, (slot, kind)| {
        Condition::Forall(*slot, *kind, Box::new(inner))
    })
}

/// Returns the numbers that effects give to fluents in a state, sorted by fluent. A fluent whose number cannot be
/// computed is left out, so it keeps its number.
pub fn assigned(
    world: &World,
    state: &State,
    effects: &[NumericEffect],
    bindings: &mut Bindings,
) -> Vec<(Fluent, Number)> {
    let mut fired: Vec<(Fluent, NumberChangeKind, Option<Number>)> = Vec::new();
    for effect in effects {
        fire(Moment { world, state }, effect, 0, bindings, &mut fired);
    }
    fired.sort_unstable();
    let result = |fired: &[(Fluent, NumberChangeKind, Option<Number>)]| {
        let (fluent, kind, value) = *fired.first()?;
        let after = match kind {
            NumberChangeKind::Assign => fired.iter().all(|own| *own == fired[0]).then_some(value?)?,
            _ => fired
                .iter()
                .try_fold(state.number(fluent)?, |sum, (_, kind, value)| match kind {
                    NumberChangeKind::Decrease => sum.minus((*value)?),
                    _ => sum.plus((*value)?),
                })?,
        };
        Some((fluent, after))
    };
    fired
        .chunk_by(|one, other| one.0 == other.0)
        .filter_map(result)
        .collect()
}

fn fire(
    moment: Moment<'_>,
    effect: &NumericEffect,
    depth: usize,
    bindings: &mut Bindings,
    fired: &mut Vec<(Fluent, NumberChangeKind, Option<Number>)>,
) {
    let Some(variable) = effect.forall.get(depth).copied() else {
        if holds(moment, &effect.condition, bindings) {
            effort::spend(effort::KEPT);
            let value = effect.value.value(moment, bindings);
            fired.push((effect.fluent.ground(bindings), effect.kind, value));
        }
        return;
    };
    // Candidates may come twice, and an effect counts once for each binding.
    let mut seen = FxHashSet::default();
    let _ = for_candidates(moment, variable, &effect.condition, true, bindings, &mut |bindings| {
        let entity = bindings[bindings.len() - 1];
        if seen.insert(entity) {
            fire(moment, effect, depth + 1, bindings, fired);
        }
        ControlFlow::Continue(())
    });
}
