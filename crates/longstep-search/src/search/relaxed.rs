//! The delete relaxation of a task: a literal stays reached once it is reached.
//!
//! Conditions need not be conjunctions: each inner node of a formula becomes a proposition that is derived from its
//! parts at no cost. A literal that occurs in no condition is not a proposition.

use rustc_hash::FxHashMap;

use super::formula::{Formula, Literal};
use super::task::Task;
use longstep_model::effort;

/// Marker for "no proposition" or "no operator".
pub(super) const NONE: u32 = u32::MAX;

/// A list of numbers for each index, stored contiguously.
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

    /// Inverts the lists: for each of `count` items, the indices whose lists contain it.
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

/// Propositions and rules. Each rule derives its results from its conditions at the cost of the operator that pays for
/// it. Every rule has at least one condition.
#[derive(Debug)]
pub(super) struct Relaxed {
    /// By rule: its conditions.
    pub(super) needs: Lists,
    /// By rule: its results.
    pub(super) gives: Lists,
    /// By proposition: the rules with it as a condition.
    pub(super) needed_by: Lists,
    /// By proposition: the rules with it as a result.
    pub(super) given_by: Lists,
    /// By rule: the operator that pays; [`NONE`] for inner nodes of formulas.
    pub(super) payer: Vec<u32>,
    /// By operator: its cost.
    pub(super) costs: Vec<u32>,
    /// By operator: the rules that it pays for.
    pub(super) paid_by: Lists,
    /// By fact: the propositions for its negative and positive literal; [`NONE`] if no condition contains the literal.
    pub(super) literals: Vec<[u32; 2]>,
    /// The proposition that always holds.
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
        // Conditions first, so that all literals in conditions are numbered before the effects.
        let groups: Vec<Vec<EffectGroup>> = task.operators.iter().map(|o| builder.groups(o)).collect();
        for (number, groups) in groups.into_iter().enumerate() {
            for (needs, gives) in groups {
                let gives = gives.into_iter().map(|literal| *builder.known(literal));
                let gives: Vec<u32> = gives.filter(|proposition| *proposition != NONE).collect();
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

    /// Returns the number of propositions.
    pub(super) fn propositions(&self) -> usize {
        self.needed_by.len()
    }
}

const TRUTH: u32 = 0;

/// Conditions of a group of effects, and the literals that they produce.
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

    /// Returns the proposition of a literal; [`NONE`] if no condition so far contains it.
    fn known(&mut self, literal: Literal) -> &mut u32 {
        &mut self.literals[literal.fact as usize][usize::from(literal.holds)]
    }

    fn rule(&mut self, mut needs: Vec<u32>, gives: &[u32], payer: u32) {
        needs.sort_unstable();
        needs.dedup();
        // Landmark cuts follow each rule back to the condition that was reached last, so every rule needs one.
        if needs.is_empty() {
            needs.push(TRUTH);
        }
        self.needs.push(&needs);
        self.gives.push(gives);
        self.payer.push(payer);
    }

    /// Returns propositions whose conjunction is equivalent to the formula.
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
            Formula::Literal(literal) => {
                if *self.known(*literal) == NONE {
                    *self.known(*literal) = self.proposition();
                }
                vec![*self.known(*literal)]
            }
        }
    }

    /// Groups the effects of an operator by condition.
    fn groups(&mut self, operator: &super::operator::Operator) -> Vec<EffectGroup> {
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
            // One proposition for the precondition, shared by all groups.
            let applicable = self.proposition();
            self.rule(precondition, &[applicable], NONE);
            precondition = vec![applicable];
        }
        let mut groups = Vec::with_capacity(conditions.len());
        for (condition, literals) in conditions {
            let mut needs = self.propositions_of(condition);
            needs.extend(&precondition);
            groups.push((needs, literals));
        }
        groups
    }
}
