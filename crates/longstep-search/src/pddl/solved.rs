//! A domain, a problem and a plan that belong together.

use super::domain::write_domain;
use super::plan::write_plan;
use super::write::{WriteError, write_problem_for};
use longstep_verify::verify::{Purpose, VerifiedPlan};

/// A domain, a problem and a plan for it in PDDL: the input of a validator such as VAL.
///
/// The problem has the goal of the purpose. For a purpose without a goal it has the facts and numbers that the plan changes, as they
/// are at its end, and says so in a comment.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::pddl;
/// use longstep_verify::plan;
/// use longstep_verify::verify::{Purpose, check_file};
///
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let task = pddl::SolvedTask::write(&plan, &Purpose::default(), "desk")?;
/// assert_eq!(task.plan, "(move-hand pen)\n(grasp pen)\n(release pen)\n");
/// assert!(task.problem.contains("(hand-at pen)"));
/// # Ok::<(), pddl::WriteError>(())
/// ```
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct SolvedTask {
    /// The PDDL domain.
    pub domain: String,
    /// The PDDL problem.
    pub problem: String,
    /// The plan, one `(action argument ...)` per line.
    pub plan: String,
}

impl SolvedTask {
    /// Writes the task that a plan solves; `name` is the name of the problem.
    ///
    /// # Errors
    ///
    /// [`WriteError::Branches`] for a plan that is no sequence; the errors of [`write_domain`] and of
    /// [`write_problem`](super::write_problem).
    pub fn write(plan: &VerifiedPlan, purpose: &Purpose, name: &str) -> Result<Self, WriteError> {
        if !plan.plan().is_sequence() {
            return Err(WriteError::Branches);
        }
        let has_goal = !purpose.wanted.is_empty() || !purpose.stages.is_empty();
        let ending = (!has_goal).then(|| &plan.ending().after);
        Ok(Self {
            domain: write_domain(plan.world().domain())?,
            problem: write_problem_for(plan.world(), purpose, name, ending)?,
            plan: write_plan(plan.world(), plan.steps()),
        })
    }

    /// Returns the three texts with the names of their files.
    pub fn files(&self) -> [(&'static str, &str); 3] {
        [
            ("domain.pddl", self.domain.as_str()),
            ("problem.pddl", self.problem.as_str()),
            ("plan.pddl", self.plan.as_str()),
        ]
    }
}
