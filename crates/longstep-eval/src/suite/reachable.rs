//! The check that the expected goals of a suite can be reached, and do not hold already.

use longstep::Clock;
use longstep::Limits;
use longstep::report::{self, Status};

use super::{Case, Step, Suite};

/// An instruction without a plan for any of its expected goals.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
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

/// An expected goal that holds before anything is done, so an answer that does nothing is correct.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Settled {
    /// The id of the case.
    pub case: String,
    /// The number of the instruction in the case, from 1.
    pub number: usize,
    /// The instruction.
    pub says: String,
    /// The goal, with everyday names.
    pub goal: String,
}

impl std::fmt::Display for Settled {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self {
            case,
            number,
            says,
            goal,
        } = self;
        write!(
            f,
            "case `{case}`, instruction {number} ({says}): its goal `{goal}` holds already"
        )
    }
}

/// The findings about the expected goals of a suite.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct GoalFindings {
    /// The instructions without a plan for any of their goals.
    pub unreached: Vec<Unreached>,
    /// The goals that need no step.
    pub settled: Vec<Settled>,
}

impl Suite {
    /// Finds the instructions whose expected goals cannot all be reached, and the goals that hold already. Each instruction
    /// of a chain begins in the world after the first goal of the one before; a chain is followed up to the first instruction
    /// without a plan.
    ///
    /// The work is one search for each goal, and a second one where there is no plan.
    pub fn goal_findings(&self, limits: &Limits) -> GoalFindings {
        let mut found = GoalFindings::default();
        for case in &self.cases {
            self.examine(case, limits, &mut found);
        }
        found
    }

    fn examine(&self, case: &Case, limits: &Limits, found: &mut GoalFindings) {
        let Some(mut world) = self.judged.get(&case.scene).cloned() else {
            return;
        };
        for (index, Step { says, expected, .. }) in case.steps.iter().enumerate() {
            let mut next = None;
            let mut why = Vec::new();
            let mut proven = true;
            for goal in expected.goals() {
                let solution = report::of_goal(&world, goal, says, limits, &Clock::none());
                if let Some(plan) = &solution.plan {
                    if plan.steps().is_empty() {
                        found.settled.push(Settled {
                            case: case.id.clone(),
                            number: index + 1,
                            says: says.clone(),
                            goal: goal.everyday(&world).join(" & "),
                        });
                    }
                    next.get_or_insert_with(|| world.after(plan.ending()));
                    continue;
                }
                proven &= solution.answer.status == Status::Unsolvable;
                let reasons = solution.answer.notes.join("; ");
                why.push(format!("`{}`: {reasons}", goal.everyday(&world).join(" & ")));
            }
            if !why.is_empty() {
                found.unreached.push(Unreached {
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
    }
}
