//! States that are at least as good as others, whatever is done next.
//!
//! Some facts can only help when they hold, others only when they do not: nothing that is asked for, by the
//! goal, a precondition or the condition of an effect that matters, is ever hurt by them. Of two states that
//! differ only in such facts, one may be no worse in any of them; whatever can be done from the other can then
//! be done from it, step by step, and ends no worse. Who walks to a table reaches all that is on it, so walking
//! to the cup on it instead need not be tried as well.
//!
//! This keeps the length of the shortest plan, but not which of the shortest plans is found first; searches
//! whose plan is to look natural do without.

use rustc_hash::FxHashMap;

use super::bits::Bits;
use super::formula::Literal;
use super::task::Task;
use crate::effort;

/// Which way a fact helps.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Helps {
    /// Nobody asks for it.
    Anyhow,
    /// When it holds (`true`), or when it does not.
    When(bool),
    /// Sometimes this way and sometimes that.
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

/// The facts that only help one way, and the states that were seen.
#[derive(Debug)]
pub(super) struct Dominance {
    /// The facts that only help one way.
    one_way: Bits,
    /// Those of them that help when they hold.
    better: Bits,
    /// By what holds of the other facts: the states that were admitted, with their steps from the start.
    seen: FxHashMap<Bits, Vec<(u32, Bits)>>,
}

impl Dominance {
    pub(super) fn new(task: &Task) -> Self {
        let facts = task.initial.len();
        let (mut one_way, mut better) = (Bits::none(facts), Bits::none(facts));
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

    /// Whether the state, that many steps from the start, is worth pursuing: nothing seen so far, in as few
    /// steps, is no worse. A state that is worth it is remembered.
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

fn helps(task: &Task) -> Vec<Helps> {
    let mut helps = vec![Helps::Anyhow; task.initial.len()];
    let mut asked = |literal: Literal| {
        let helps = &mut helps[literal.fact as usize];
        *helps = helps.and(literal.holds);
    };
    task.goal.for_each(&mut asked);
    // A rule that is broken in one state and holds in the other forbids the other one more, so neither value helps.
    for rule in task.always.iter() {
        rule.for_each(&mut |literal| {
            asked(literal);
            asked(Literal {
                holds: !literal.holds,
                ..literal
            });
        });
    }
    for operator in &task.operators {
        operator.precondition.for_each(&mut asked);
    }
    // An effect's condition helps the way that the effect does; where the effect helps both ways, so does it.
    let units = task.units();
    loop {
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
