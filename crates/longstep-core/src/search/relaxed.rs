//! The relaxed task: nothing that was reached is ever lost.
//!
//! Conditions need not be conjunctions: every inner node of a formula becomes a proposition of its own that
//! costs nothing to derive from its parts. A literal that nothing asks for is no proposition at all.

use rustc_hash::FxHashMap;

use super::formula::{Formula, Literal};
use super::task::Task;
use crate::effort;

/// A number that stands for none: no proposition, no rule's payer.
pub(super) const NONE: u32 = u32::MAX;

/// A list of numbers for each of many things, one after the other in memory.
#[derive(Debug)]
pub(super) struct Lists {
    starts: Vec<u32>,
    items: Vec<u32>,
}

impl Lists {
    fn new() -> Self {
        Self {
            starts: vec![0],
            items: Vec::new(),
        }
    }

    fn push(&mut self, list: &[u32]) {
        self.items.extend_from_slice(list);
        self.starts.push(self.items.len() as u32);
    }

    /// The lists the other way round: for each of `count` items, whose list it is in.
    fn inverted(&self, count: usize) -> Self {
        let mut starts = vec![0; count + 1];
        for item in &self.items {
            starts[*item as usize + 1] += 1;
        }
        for index in 0..count {
            starts[index + 1] += starts[index];
        }
        let mut next = starts.clone();
        let mut items = vec![0; self.items.len()];
        for owner in 0..self.len() {
            for item in self.of(owner as u32) {
                let place = &mut next[*item as usize];
                items[*place as usize] = owner as u32;
                *place += 1;
            }
        }
        Self { starts, items }
    }

    pub(super) fn len(&self) -> usize {
        self.starts.len() - 1
    }

    pub(super) fn of(&self, index: u32) -> &[u32] {
        let index = index as usize;
        &self.items[self.starts[index] as usize..self.starts[index + 1] as usize]
    }
}

/// Propositions, and rules by which they follow from each other: from all that a rule needs, at the cost of the
/// operator that pays for it, follows all that it gives. Every rule needs something.
#[derive(Debug)]
pub(super) struct Relaxed {
    /// By rule: the propositions it needs.
    pub(super) needs: Lists,
    /// By rule: the propositions it gives.
    pub(super) gives: Lists,
    /// By proposition: the rules that need it.
    pub(super) needed_by: Lists,
    /// By proposition: the rules that give it.
    pub(super) given_by: Lists,
    /// By rule: the operator that pays, [`NONE`] for the inner nodes of formulas.
    pub(super) payer: Vec<u32>,
    /// By operator: what it costs.
    pub(super) costs: Vec<u32>,
    /// By operator: the rules that it pays for.
    pub(super) paid_by: Lists,
    /// By fact: the propositions for "holds not" and "holds"; [`NONE`] if nothing asks for it.
    pub(super) literals: Vec<[u32; 2]>,
    /// What always holds.
    pub(super) truth: u32,
    pub(super) goal: u32,
}

impl Relaxed {
    pub(super) fn new(task: &Task) -> Self {
        let mut builder = Builder {
            needs: Lists::new(),
            gives: Lists::new(),
            payer: Vec::new(),
            literals: vec![[NONE; 2]; task.initial.len()],
            propositions: 2,
        };
        effort::spend(4 * task.units());
        let (truth, goal) = (TRUTH, 1);
        let needs = builder.propositions_of(&task.goal);
        builder.rule(needs, &[goal], NONE);
        // Conditions first, so that every literal that is asked for is known when effects are looked at.
        let groups: Vec<Vec<EffectGroup>> = task.operators.iter().map(|o| builder.groups(o)).collect();
        for (number, groups) in groups.into_iter().enumerate() {
            for (needs, gives) in groups {
                let proposition =
                    |literal: Literal| builder.literals[literal.fact as usize][usize::from(literal.holds)];
                let gives: Vec<u32> = gives.into_iter().map(proposition).filter(|p| *p != NONE).collect();
                if !gives.is_empty() {
                    builder.rule(needs, &gives, number as u32);
                }
            }
        }
        let mut paid = vec![Vec::new(); task.operators.len()];
        for (rule, payer) in builder.payer.iter().enumerate().filter(|(_, payer)| **payer != NONE) {
            paid[*payer as usize].push(rule as u32);
        }
        let mut paid_by = Lists::new();
        paid.iter().for_each(|rules: &Vec<u32>| paid_by.push(rules));
        let (needs, gives) = (builder.needs, builder.gives);
        Self {
            needed_by: needs.inverted(builder.propositions as usize),
            given_by: gives.inverted(builder.propositions as usize),
            needs,
            gives,
            payer: builder.payer,
            costs: task.operators.iter().map(|operator| operator.cost).collect(),
            paid_by,
            literals: builder.literals,
            truth,
            goal,
        }
    }

    /// How many propositions there are.
    pub(super) fn propositions(&self) -> usize {
        self.needed_by.len()
    }
}

const TRUTH: u32 = 0;

/// What a part of an operator needs, and the literals that it brings about.
type EffectGroup = (Vec<u32>, Vec<Literal>);

struct Builder {
    needs: Lists,
    gives: Lists,
    payer: Vec<u32>,
    literals: Vec<[u32; 2]>,
    propositions: u32,
}

impl Builder {
    fn proposition(&mut self) -> u32 {
        self.propositions += 1;
        self.propositions - 1
    }

    fn rule(&mut self, mut needs: Vec<u32>, gives: &[u32], payer: u32) {
        needs.sort_unstable();
        needs.dedup();
        if needs.is_empty() {
            needs.push(TRUTH);
        }
        self.needs.push(&needs);
        self.gives.push(gives);
        self.payer.push(payer);
    }

    /// Propositions that together mean the formula.
    fn propositions_of(&mut self, formula: &Formula) -> Vec<u32> {
        match formula {
            Formula::And(all) => all.iter().flat_map(|part| self.propositions_of(part)).collect(),
            Formula::Or(any) => {
                let node = self.proposition();
                for part in any {
                    let needs = self.propositions_of(part);
                    self.rule(needs, &[node], NONE);
                }
                vec![node]
            }
            Formula::Literal(Literal { fact, holds }) => {
                if self.literals[*fact as usize][usize::from(*holds)] == NONE {
                    self.literals[*fact as usize][usize::from(*holds)] = self.proposition();
                }
                vec![self.literals[*fact as usize][usize::from(*holds)]]
            }
        }
    }

    /// An operator's effects by condition.
    fn groups(&mut self, operator: &super::task::Operator) -> Vec<EffectGroup> {
        let mut conditions: Vec<(&Formula, Vec<Literal>)> = Vec::new();
        let mut numbers: FxHashMap<&Formula, usize> = FxHashMap::default();
        for effect in &operator.effects {
            let number = *numbers.entry(&effect.condition).or_insert(conditions.len());
            match conditions.get_mut(number) {
                Some((_, literals)) => literals.push(effect.literal),
                None => conditions.push((&effect.condition, vec![effect.literal])),
            }
        }
        let mut precondition = self.propositions_of(&operator.precondition);
        if conditions.len() > 1 && precondition.len() > 1 {
            // Said once for all of them.
            let applicable = self.proposition();
            self.rule(precondition, &[applicable], NONE);
            precondition = vec![applicable];
        }
        let group = |(condition, literals): (&Formula, Vec<Literal>)| {
            let mut needs = self.propositions_of(condition);
            needs.extend(&precondition);
            (needs, literals)
        };
        conditions.into_iter().map(group).collect()
    }
}
