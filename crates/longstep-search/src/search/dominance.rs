//! Dominance pruning: skips states that are no better than a known one.
//!
//! Some facts can only help when they hold, others only when they do not hold: the goal, the preconditions and the
//! conditions of relevant effects contain only one polarity of them. Let two states differ only in such facts, and let
//! one be no worse in any of them. Then every plan from the other state also works from this one and ends no worse. For
//! example, after a walk to a table everything on it is in reach, so a walk to a cup on the table need not be tried as
//! well.
//!
//! Pruning preserves the length of the shortest plan, but can change which shortest plan is found first. Searches whose
//! plan should look natural do not use it.

use rustc_hash::FxHashMap;

use super::bits::Bits;
use super::formula::{Formula, Literal};
use super::task::Task;
use longstep_model::effort;

/// Polarity in which a fact helps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Helps {
    /// Neither: no condition contains the fact.
    Anyhow,
    /// Only when the fact holds (`true`), or only when it does not (`false`).
    When(bool),
    /// Both polarities.
    Both,
}

impl Helps {
    fn and(self, holds: bool) -> Self {
        match self {
            Self::Anyhow => Self::When(holds),
            Self::When(known) if known == holds => self,
            _ => Self::Both,
        }
    }
}

/// The facts that help in one polarity only, and the states seen so far.
#[derive(Debug)]
pub(super) struct Dominance {
    /// The facts that help in at most one polarity.
    one_way: Bits,
    /// The facts of `one_way` that help when they hold.
    better: Bits,
    /// Admitted states with their costs from the start, grouped by the values of the remaining facts.
    seen: FxHashMap<Bits, Vec<(u32, Bits)>>,
}

impl Dominance {
    pub(super) fn new(task: &Task) -> Self {
        // Numbers are in neither: states with different numbers are not compared.
        let (mut one_way, mut better) = (Bits::none(task), Bits::none(task));
        for (fact, helps) in helps(task).into_iter().enumerate() {
            let holds = helps == Helps::When(true);
            let fact = fact as u32;
            one_way.set(Literal {
                fact,
                holds: helps != Helps::Both,
            });
            better.set(Literal { fact, holds });
        }
        Self {
            one_way,
            better,
            seen: FxHashMap::default(),
        }
    }

    /// Returns true if no admitted state of at most this cost is at least as good, and then stores the state.
    pub(super) fn admits(&mut self, state: &Bits, depth: u32) -> bool {
        let seen = self.seen.entry(state.without(&self.one_way)).or_default();
        effort::spend(seen.len() / 2 + 1);
        let no_worse = |(steps, other): &(u32, Bits)| *steps <= depth && other.no_worse_than(state, &self.better);
        let admitted = !seen.iter().any(no_worse);
        if admitted {
            seen.push((depth, state.clone()));
        }
        admitted
    }
}

fn require(helps: &mut [Helps], literal: Literal) {
    let helps = &mut helps[literal.fact as usize];
    *helps = helps.and(literal.holds);
}

/// Requires both polarities of the literals of a condition.
fn require_both(helps: &mut [Helps], condition: &Formula) {
    condition.for_each(&mut |literal| {
        require(helps, literal);
        require(helps, literal.opposite());
    });
}

fn helps(task: &Task) -> Vec<Helps> {
    let mut helps = vec![Helps::Anyhow; task.initial.len()];
    task.goal.for_each(&mut |literal| require(&mut helps, literal));
    // A state that breaks a rule permits successors that break it, so neither polarity of the rule's facts dominates.
    for rule in task.always.iter() {
        require_both(&mut helps, rule);
    }
    // Progress is recorded as soon as it is made, and too early is no better than too late.
    for mark in task.marks() {
        let conditions = mark.effects.iter().map(|effect| &effect.condition);
        for condition in conditions.chain([&mark.precondition]) {
            require_both(&mut helps, condition);
        }
    }
    // A change of a number is neither good nor bad.
    for effect in task.operators.iter().flat_map(|operator| &operator.numeric) {
        require_both(&mut helps, &effect.condition);
    }
    for operator in &task.operators {
        operator
            .precondition
            .for_each(&mut |literal| require(&mut helps, literal));
    }
    // A literal in an effect's condition helps as the effect does; if the effect has both polarities, so does the
    // literal.
    let units = task.units();
    // A value only moves from `Anyhow` through `When` to `Both`, so the loop ends.
    loop {
        // Incomplete values prune too much, but a search without budget proves nothing.
        if !effort::spend(units) {
            return helps;
        }
        let mut changed = false;
        for effect in task.operators.iter().flat_map(|operator| &operator.effects) {
            let effect_helps = helps[effect.literal.fact as usize];
            effect.condition.for_each(&mut |literal| {
                let known = helps[literal.fact as usize];
                let now = match effect_helps {
                    Helps::Anyhow => known,
                    Helps::When(holds) => known.and(literal.holds == (holds == effect.literal.holds)),
                    Helps::Both => Helps::Both,
                };
                changed |= now != known;
                helps[literal.fact as usize] = now;
            });
        }
        if !changed {
            return helps;
        }
    }
}
