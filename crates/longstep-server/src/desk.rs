//! Plans without a session: verified, repaired, found, or made for one instruction.

use std::sync::Arc;

use longstep::Planner;
use longstep::report::{Answer, Assessment};
use longstep_core::environment::World;
use longstep_core::{goal, plan};

use crate::domains::world;
use crate::hosted::Hosted;
use crate::hub::{Hub, NewSession};
use crate::id::SessionId;
use crate::problem::{Problem, ProblemKind};
use crate::talk::{Said, Waiting};

impl Hub {
    /// Returns the planner and the world of a request.
    pub(crate) fn place(&self, new: &NewSession) -> Result<(Planner, World), Problem> {
        let scene = new.scene.as_deref().map(|name| self.domains.scene(name)).transpose()?;
        let domain = new.domain.as_deref().or(scene.map(|scene| scene.domain.as_str()));
        let planner = self.domains.planner(domain.unwrap_or("household"))?;
        let environment = new
            .environment
            .as_deref()
            .or(scene.map(|scene| scene.environment.as_str()));
        let environment = environment.ok_or_else(|| {
            Problem::unreadable("a world is missing").hint("pass `environment`, or the name of a `scene`")
        })?;
        let world = world(&planner, environment, &new.rules)?;
        Ok((planner, world))
    }

    /// Verifies the plan in a text: a plan file, a script, or a model's reply that contains one.
    ///
    /// # Errors
    ///
    /// The world, the plan or the goal cannot be read. A plan that is not valid is an answer.
    pub fn verify(&self, place: &NewSession, text: &str, goal: Option<&str>) -> Result<Answer, Problem> {
        self.assess(place, text, goal, |assessment| assessment.verdict())
    }

    /// Repairs the plan in a text with the cheapest edits.
    ///
    /// # Errors
    ///
    /// As for [`Hub::verify`].
    pub fn repair(&self, place: &NewSession, text: &str, goal: Option<&str>) -> Result<Answer, Problem> {
        self.assess(place, text, goal, |assessment| assessment.repaired())
    }

    fn assess(
        &self,
        place: &NewSession,
        text: &str,
        goal: Option<&str>,
        answer: impl Fn(&Assessment<'_>) -> Answer,
    ) -> Result<Answer, Problem> {
        let (_, world) = self.place(place)?;
        let draft = plan::read(text)
            .map_err(|error| Problem::unreadable(format!("the plan cannot be read: {error}")).hint(error.hint()))?;
        let read = |error: goal::GoalError| Problem::unreadable(format!("the goal cannot be read: {error}"));
        let mut purpose = draft.file.purpose.clone().unwrap_or_default();
        if goal.is_some() {
            // It takes the place of the goal in the file.
            purpose.goal = None;
        }
        let (mut world, mut wanted) = goal::with_purpose(world, &purpose).map_err(read)?;
        if let Some(text) = goal {
            goal::add_values(&mut world, text);
            wanted = Some(goal::parse(&world, text).map_err(read)?);
        }
        let assessment = Assessment::new(&world, draft, None);
        Ok(answer(&match wanted {
            Some(goal) => assessment.for_goal(goal),
            None => assessment,
        }))
    }

    /// Finds a plan for a goal.
    ///
    /// # Errors
    ///
    /// The world or the goal cannot be read. That there is no plan is an answer.
    pub fn solve(&self, place: &NewSession, goal: &str) -> Result<Answer, Problem> {
        let (planner, mut world) = self.place(place)?;
        goal::add_values(&mut world, goal);
        let goal = planner.goal(&world, goal)?;
        Ok(planner.solution(&world, &goal)?.answer)
    }

    /// Makes a plan for one instruction, in a session that is not kept. Drop what is returned, and the work is cancelled.
    ///
    /// # Errors
    ///
    /// The world cannot be read, the queue for the model is full, or there is no model.
    pub fn plan(self: &Arc<Self>, place: &NewSession, instruction: &str) -> Result<Planning, Problem> {
        let (planner, world) = self.place(place)?;
        let session = planner.session(world, self.settings(), self.facts())?;
        let held = Hosted::begin(SessionId::random()?, session, None, Arc::clone(self.feed()))?;
        self.say_to(&held, &Said::Instruction(instruction.to_owned()))?;
        Ok(Planning {
            waiting: Waiting::new(Arc::clone(&held)),
        })
    }
}

/// A plan that is being made for one instruction.
pub struct Planning {
    waiting: Waiting,
}

impl Planning {
    /// Waits for the answer, as `longstep plan --json` prints it.
    ///
    /// # Errors
    ///
    /// The model failed.
    pub async fn answer(self) -> Result<Answer, Problem> {
        let hosted = self.waiting.ended().await;
        hosted.look(|session| {
            let failed = || match session.failure() {
                Some(failure) => Problem::new(ProblemKind::Failed, failure.to_string()),
                None => Problem::new(ProblemKind::Failed, "the model was cancelled"),
            };
            session.report().ok_or_else(failed)
        })
    }
}
