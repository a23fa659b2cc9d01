//! What is known of a plan besides the plan: its goal, the edits of a repair, and assumptions of its reading.

use longstep_core::goal::Goal;
use longstep_core::model::World;
use longstep_core::plan::Assumption;
use longstep_core::repair::Edit;
use longstep_core::verify::Purpose;

/// Knowledge about a plan that its diagram shows.
///
/// ```
/// use longstep_picture::plan::Annotations;
/// let annotations = Annotations::default().with_edits(&[]).with_assumptions(&[]);
/// # let _ = annotations;
/// ```
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct Annotations {
    /// The purpose of the plan; none for one without a goal.
    pub purpose: Option<Purpose>,
    /// The conditions of the purpose as sentences, by their index.
    pub goals: Vec<String>,
    /// The edits of the repair that the plan comes from.
    pub edits: Vec<Edit>,
    /// Assumptions besides those that verification finds: hidden arguments, misspelt names.
    pub assumptions: Vec<Assumption>,
}

impl Annotations {
    /// Sets the goal of the plan, in the plan's world.
    #[must_use]
    pub fn with_goal(mut self, world: &World, goal: &Goal) -> Self {
        self.purpose = Some(goal.purpose(world));
        self.goals = goal.sentences(world);
        self
    }

    /// Sets the purpose of a plan whose goal is not in the goal language, such as that of a PDDL problem.
    #[must_use]
    pub fn with_purpose(mut self, purpose: Purpose) -> Self {
        self.purpose = Some(purpose);
        self
    }

    /// Sets the edits of the repair that the plan comes from.
    #[must_use]
    pub fn with_edits(mut self, edits: &[Edit]) -> Self {
        self.edits = edits.to_vec();
        self
    }

    /// Adds assumptions.
    #[must_use]
    pub fn with_assumptions(mut self, assumptions: &[Assumption]) -> Self {
        self.assumptions.extend_from_slice(assumptions);
        self
    }
}
