//! Suites of test cases: instructions and their expected results.
//!
//! A suite is a folder: `suite.toml` describes it and names its domain, `scenes/NAME.json` are environments, and every
//! other `.toml` file contains cases. [`load`] reads all of it or returns every fault with its position.

mod load;
pub mod paper;
mod reachable;
mod shipped;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;

use longstep::goal::Goal;
use longstep_core::environment::World;
use longstep_core::model::Prohibition;
use longstep_core::search::{Limits, Outcome, solve};
use longstep_core::verify::{Purpose, Report, VerifiedPlan, check};

pub use load::{Files, domain_name, load};
#[cfg(feature = "schema")]
pub use load::{cases_schema, schema};
pub use reachable::{GoalFindings, Settled, Unreached};
pub use shipped::{load_shipped, shipped, shipped_names};

/// A suite of test cases for one domain.
#[derive(Debug, Clone)]
pub struct Suite {
    /// Its name.
    pub name: String,
    /// Its purpose, in one sentence.
    pub about: String,
    /// The domain's name, or its folder.
    pub domain: String,
    /// The initial worlds of its cases.
    pub scenes: BTreeMap<String, World>,
    /// These worlds with the values (numbers, quotations) of the expected goals, in which these goals are read. A model never
    /// sees them: it has the values of its instruction.
    pub judged: BTreeMap<String, World>,
    /// The cases, in the order of the files and of their content.
    pub cases: Vec<Case>,
}

/// One instruction, or a chain of them in which each begins in the world after the one before.
#[derive(Debug, Clone)]
pub struct Case {
    /// The id, unique in the suite.
    pub id: String,
    /// The name of its initial world.
    pub scene: String,
    /// The rules that bind all its plans.
    pub rules: Vec<Prohibition>,
    /// The steps, at least one.
    pub steps: Vec<Step>,
    /// Tags for selection and grouping.
    pub tags: Vec<String>,
}

/// An instruction and its expected result.
#[derive(Debug, Clone)]
pub struct Step {
    /// The instruction.
    pub says: String,
    /// Paraphrases of the instruction, by the name of the wording.
    pub wordings: BTreeMap<String, String>,
    /// The expected result.
    pub expected: Expected,
}

/// An expected result.
#[derive(Debug, Clone, PartialEq)]
pub enum Expected {
    /// A plan to one of these goals, at least one.
    Plan(Vec<Goal>),
    /// A clarifying question.
    Question,
    /// A proof that there is no plan.
    Refusal,
    /// A clarifying question, or no plan, with or without a proof.
    Either,
    /// Nothing is done: an empty plan, or a clarifying question.
    Nothing,
}

impl Expected {
    /// The goals; empty if no plan is expected.
    pub fn goals(&self) -> &[Goal] {
        match self {
            Self::Plan(goals) => goals,
            Self::Question | Self::Refusal | Self::Either | Self::Nothing => &[],
        }
    }
}

impl Suite {
    /// The initial world of a case, with its rules in force.
    pub fn world(&self, case: &Case) -> World {
        self.scenes[&case.scene].with_prohibitions(case.rules.iter().cloned())
    }

    /// The initial world of a case with the values of the expected goals.
    pub fn judged_world(&self, case: &Case) -> World {
        self.judged[&case.scene].with_prohibitions(case.rules.iter().cloned())
    }

    /// Returns the plan that search finds for each instruction, with its purpose: each in the world after the one before. An
    /// instruction without an expected goal, or without a plan within the usual limits, is left out.
    ///
    /// ```
    /// use longstep_eval::suite;
    /// let (_, suite) = suite::load_shipped("two-arms").unwrap().unwrap();
    /// let plans = suite.plans().unwrap();
    /// assert!(!plans.is_empty());
    /// ```
    ///
    /// # Errors
    ///
    /// The report on a plan of the search that the verifier refuses.
    pub fn plans(&self) -> Result<Vec<(VerifiedPlan, Purpose)>, Box<Report>> {
        let mut plans = Vec::new();
        for case in &self.cases {
            let mut world = self.world(case);
            let judged = &self.judged[&case.scene];
            for step in &case.steps {
                world.share_values(judged);
                let goal = step.expected.goals().first();
                let Some(goal) = goal.and_then(|goal| goal.carried(world.domain(), judged, &world)) else {
                    continue;
                };
                let purpose = goal.purpose(&world);
                let Outcome::Solved { plan, .. } = solve(&world, &purpose, &Limits::default()) else {
                    continue;
                };
                let plan = check(&world, plan, &purpose).into_verified()?;
                world = world.after(plan.ending());
                plans.push((plan, purpose));
            }
        }
        Ok(plans)
    }
}

/// The name of a case's original wording.
pub const PLAIN: &str = "plain";

impl Case {
    /// The wordings that all its steps have, [`PLAIN`] first.
    pub fn wordings(&self) -> Vec<&str> {
        let mut wordings = vec![PLAIN];
        if let [step] = &self.steps[..] {
            wordings.extend(step.wordings.keys().map(String::as_str));
        }
        wordings
    }
}

impl Step {
    /// The instruction in a wording, if it has one.
    pub fn in_words(&self, wording: &str) -> Option<&str> {
        match wording {
            PLAIN => Some(&self.says),
            other => self.wordings.get(other).map(String::as_str),
        }
    }
}
