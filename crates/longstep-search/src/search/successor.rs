//! Successors of states, under the rules that a step must keep.
//!
//! A step can break a rule only by changing a fact in it, so each rule is filed under its facts. Of a thousand rules, a
//! step tests the few that mention what it changes.

use rustc_hash::FxHashSet;

use super::bits::Bits;
use super::formula::Formula;
use super::node::after;
use super::operator::Operator;
use super::task::Task;
use longstep_model::effort;

/// Nodes of a condition that are evaluated in one unit of work.
const NODES: usize = 8;

/// The rules of a task by fact, and the work of its steps.
pub(super) struct Successors<'a> {
    task: &'a Task,
    rules: Vec<&'a Formula>,
    /// By fact: the rules that mention it.
    mentions: Vec<Vec<u32>>,
    /// Work units to record the progress after a step.
    marks: usize,
}

impl<'a> Successors<'a> {
    pub(super) fn new(task: &'a Task) -> Self {
        let mut mentions: Vec<Vec<u32>> = vec![Vec::new(); task.initial.len()];
        let mut rules = Vec::new();
        for rule in task.always.iter() {
            if !effort::spend(1 + rule.size() / NODES) {
                break;
            }
            let number = rules.len() as u32;
            let mut facts = FxHashSet::default();
            rule.for_each(&mut |literal| {
                if facts.insert(literal.fact) {
                    mentions[literal.fact as usize].push(number);
                }
            });
            rules.push(rule);
        }
        let marks = task.marks().iter().map(|mark| units(&mark.precondition)).sum();
        Self {
            task,
            rules,
            mentions,
            marks,
        }
    }

    /// Returns the state after an applicable operator, with the progress that it makes; none if it equals `state` or
    /// breaks a rule that holds in it. Spends units for the conditions that it evaluates.
    pub(super) fn of(&self, state: &Bits, operator: &Operator) -> Option<Bits> {
        let effects = operator.effects.iter().map(|effect| units(&effect.condition));
        if !effort::spend(1 + self.task.initial.len() / 256 + self.marks + effects.sum::<usize>()) {
            return None;
        }
        let next = after(self.task, state, operator);
        // A step that changes nothing only makes a plan longer.
        (next != *state && self.keeps_rules(state, &next)).then_some(next)
    }

    /// Returns true if every rule that holds before a step holds after it.
    fn keeps_rules(&self, before: &Bits, after: &Bits) -> bool {
        if self.rules.is_empty() {
            return true;
        }
        let mut changed = before.changed_facts(after, self.task.initial.len());
        changed.all(|fact| {
            self.mentions[fact as usize].iter().all(|number| {
                let rule = self.rules[*number as usize];
                effort::spend(1 + units(rule));
                // As in verification, a rule that is broken binds only from the state in which it holds again.
                rule.holds(&|literal| after.is(literal)) || !rule.holds(&|literal| before.is(literal))
            })
        })
    }
}

/// Returns the work units to evaluate a condition.
fn units(condition: &Formula) -> usize {
    condition.size() / NODES
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search::task::Always;
    use crate::search::{GroundAction, GroundEffect, Literal};

    const fn literal(fact: u32, holds: bool) -> Literal {
        Literal { fact, holds }
    }

    /// A task of so many facts, none of which holds, with these rules.
    fn task(facts: usize, rules: Vec<Formula>) -> Task {
        Task {
            initial: vec![false; facts],
            operators: Vec::new(),
            goal: Formula::TRUE,
            always: Always::of(rules),
            numbers: Default::default(),
        }
    }

    fn adding(fact: u32) -> Operator {
        Operator {
            step: GroundAction {
                action: longstep_model::model::ActionId::new(0),
                arguments: Vec::new(),
            },
            is_mark: false,
            cost: 1,
            tag: 0,
            outcome: None,
            precondition: Formula::TRUE,
            effects: vec![GroundEffect {
                condition: Formula::TRUE,
                literal: literal(fact, true),
                may: false,
            }],
            numeric: Vec::new(),
        }
    }

    #[test]
    fn a_step_tests_the_rules_that_mention_what_it_changes_and_pays_for_them() {
        // Fact 0 is in no rule, fact 1 is forbidden, and fact 2 is in many rules, which permit it.
        let long = |other: u32| {
            Formula::or(
                (2..40)
                    .chain([other])
                    .map(|fact| Formula::Literal(literal(fact, fact == 2))),
            )
        };
        let mut rules = vec![Formula::Literal(literal(1, false))];
        rules.extend((40..80).map(long));
        let task = task(80, rules);
        let (successors, state) = (Successors::new(&task), Bits::none(&task));
        let units = |fact: u32| {
            let spent = effort::within(u64::MAX, || successors.of(&state, &adding(fact)).is_some());
            (spent.result, spent.units)
        };
        let (is_possible, free) = units(0);
        assert!(is_possible && free < 5, "{free} units");
        assert!(!units(1).0, "it breaks a rule");
        let (is_possible, dear) = units(2);
        assert!(is_possible && dear > free + 40 * 4, "{dear} units");
        let exhausted = effort::within(3, || successors.of(&state, &adding(2)));
        assert!(exhausted.exhausted);
    }

    #[test]
    fn a_rule_that_is_broken_already_permits_every_step() {
        let rule = Formula::and([literal(0, true), literal(1, false)].map(Formula::Literal));
        let task = task(3, vec![rule.clone(), rule, Formula::TRUE]);
        assert_eq!(
            task.always.iter().count(),
            1,
            "a rule that is stated twice is tested once"
        );
        let successors = Successors::new(&task);
        let before = Bits::none(&task);
        assert!(successors.of(&before, &adding(1)).is_some());
        let holding = successors.of(&before, &adding(0)).unwrap();
        assert!(successors.of(&holding, &adding(1)).is_none());
        assert!(successors.of(&holding, &adding(2)).is_some());
        assert!(successors.of(&holding, &adding(0)).is_none(), "nothing changes");
    }
}
