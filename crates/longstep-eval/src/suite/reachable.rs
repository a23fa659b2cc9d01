//! The check that the expected goals of a suite can be reached.

use longstep::Limits;
use longstep::report::{self, Status};

use super::{Case, Step, Suite};

/// An instruction without a plan for any of its expected goals.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Unreached {
    /// The id of the case.
    pub case: String,
    /// The number of the instruction in the case, from 1.
    pub number: usize,
    /// The instruction.
    pub says: String,
    /// True if it is proven that there is no plan; false if the search gave up.
    pub proven: bool,
    /// The reasons, for each expected goal.
    pub why: Vec<String>,
}

impl std::fmt::Display for Unreached {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let result = if self.proven {
            "cannot be reached"
        } else {
            "was not reached"
        };
        let Self { case, number, says, .. } = self;
        write!(f, "case `{case}`, instruction {number} ({says}): its goal {result}")?;
        for why in &self.why {
            write!(f, "; {why}")?;
        }
        Ok(())
    }
}

impl Suite {
    /// Finds the instructions whose expected goals cannot all be reached. Each instruction of a chain begins in the world
    /// after the first goal of the one before; a chain is followed up to the first instruction without a plan.
    ///
    /// The work is one search for each goal, and a second one where there is no plan.
    pub fn unreached(&self, limits: &Limits) -> Vec<Unreached> {
        self.cases
            .iter()
            .flat_map(|case| self.unreached_in(case, limits))
            .collect()
    }

    fn unreached_in(&self, case: &Case, limits: &Limits) -> Vec<Unreached> {
        let mut found = Vec::new();
        let Some(mut world) = self.judged.get(&case.scene).cloned() else {
            return found;
        };
        for (index, Step { says, expected, .. }) in case.steps.iter().enumerate() {
            let mut next = None;
            let mut why = Vec::new();
            let mut proven = true;
            for goal in expected.goals() {
                let solution = report::of_goal(&world, goal, says, limits, || 0.0);
                if let Some(plan) = &solution.plan {
                    next.get_or_insert_with(|| world.after(plan.ending()));
                    continue;
                }
                proven &= solution.answer.status == Status::Unsolvable;
                let reasons = solution.answer.notes.join("; ");
                why.push(format!("`{}`: {reasons}", goal.everyday(&world).join(" & ")));
            }
            if !why.is_empty() {
                found.push(Unreached {
                    case: case.id.clone(),
                    number: index + 1,
                    says: says.clone(),
                    proven,
                    why,
                });
            }
            match next {
                Some(next) => world = next,
                None if expected.goals().is_empty() => {}
                None => break,
            }
        }
        found
    }
}
