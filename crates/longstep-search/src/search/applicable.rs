//! The operators that are applicable in a state.
//!
//! Each operator is filed under one literal of its precondition. Only operators whose literal holds in the state are
//! tested: of a thousand walks between places, those from the place of the robot.

use super::bits::Bits;
use super::formula::{Formula, Literal};
use super::operator::Operator;
use super::relevance::index;
use super::task::Task;
use longstep_model::effort;

/// The steps of a task, filed under literals of their preconditions.
#[derive(Debug)]
pub(super) struct Applicable {
    /// By literal: the operators that are filed there.
    under: Vec<Vec<u32>>,
    /// The literals with operators.
    used: Vec<Literal>,
    /// Operators without a literal that each applicable state satisfies.
    others: Vec<u32>,
}

impl Applicable {
    pub(super) fn new(task: &Task) -> Self {
        effort::spend(task.units());
        let mut under = vec![Vec::new(); task.initial.len() * 2];
        let (mut used, mut others) = (Vec::new(), Vec::new());
        for (number, operator) in task.steps() {
            match filed_under(task, operator) {
                Some(literal) => {
                    let filed: &mut Vec<u32> = &mut under[index(literal)];
                    if filed.is_empty() {
                        used.push(literal);
                    }
                    filed.push(number as u32);
                }
                None => others.push(number as u32),
            }
        }
        Self { under, used, others }
    }

    /// Fills `found` with the numbers of the applicable steps, sorted.
    pub(super) fn find(&self, task: &Task, state: &Bits, found: &mut Vec<u32>) {
        found.clear();
        let mut tested = self.used.len() / 8;
        let filed = self.used.iter().filter(|literal| state.is(**literal));
        for list in filed.map(|literal| &self.under[index(*literal)]).chain([&self.others]) {
            tested += list.len();
            for number in list {
                let precondition = &task.operators[*number as usize].precondition;
                if precondition.holds(&|literal| state.is(literal)) {
                    found.push(*number);
                }
            }
        }
        // The order of the task begins with operators about entities of the goal.
        found.sort_unstable();
        effort::spend(1 + tested / 4);
    }
}

/// Returns the literal of the precondition that holds most rarely: one that is false at the start, or one that says where
/// something is rather than where it is not.
fn filed_under(task: &Task, operator: &Operator) -> Option<Literal> {
    let conjuncts = match &operator.precondition {
        Formula::And(parts) => parts.as_slice(),
        other => std::slice::from_ref(other),
    };
    let literals = conjuncts.iter().filter_map(|part| match part {
        Formula::Literal(literal) => Some(*literal),
        _ => None,
    });
    let starts = |literal: &Literal| task.initial[literal.fact as usize] == literal.holds;
    literals.min_by_key(|literal| (starts(literal), !literal.holds))
}
