//! The front door: one domain, its prompts, and the settings of all work with it.

use std::sync::Arc;

use crate::environment::{self, World};
use crate::error::Error;
use crate::goal::{self, Goal};
use crate::load;
use crate::model::Domain;
use crate::plan;
use crate::report::{self, Assessment, Solution, Stopwatch};
use crate::search::Limits;
use crate::session::{Log, ModelFacts, Resumed, Session, Settings};
use crate::verify::VerifiedPlan;

/// A planner for one robot: it owns the domain with its prompts, the limits of searches, and a clock.
///
/// It does no I/O and holds no state of a conversation. Clones are cheap and share the domain, so one planner serves
/// many sessions and threads.
///
/// ```
/// use longstep::Planner;
/// let planner = Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
///     "object_states": {"<milk>": "on_something(<counter>)", "<fridge_handle>": "closed()"}}"#)?;
/// let plan = planner.solve(&world, "put(milk, fridge)")?;
/// assert_eq!(plan.steps()[2].explanation, "turn the fridge handle to open");
/// # Ok::<(), longstep::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Planner {
    domain: Arc<Domain>,
    limits: Limits,
    clock: Stopwatch,
}

impl Planner {
    /// Creates a planner with the default limits and without a clock.
    pub fn new(domain: impl Into<Arc<Domain>>) -> Self {
        Self {
            domain: domain.into(),
            limits: Limits::default(),
            clock: || 0.0,
        }
    }

    /// Creates a planner for a domain that is shipped with the library.
    ///
    /// # Errors
    ///
    /// [`Domain`](crate::ErrorKind::Domain) when there is no such domain.
    pub fn shipped(name: &str) -> Result<Self, Error> {
        let domain = load::shipped(name).ok_or_else(|| Error::unknown_domain(name))?;
        Ok(Self::new(domain.map_err(Error::domain)?))
    }

    /// Sets the limits of searches.
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Sets the clock that the timings in answers come from: milliseconds since some moment.
    #[must_use]
    pub fn with_clock(self, clock: Stopwatch) -> Self {
        Self { clock, ..self }
    }

    /// The domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Reads an environment, bare or wrapped in `{"environment": ...}`, as JSON. Diagnostics call it `environment`.
    ///
    /// # Errors
    ///
    /// [`Environment`](crate::ErrorKind::Environment) with every problem and its place.
    pub fn world(&self, environment: &str) -> Result<World, Error> {
        self.world_from("environment", environment)
    }

    /// Reads an environment as [`Planner::world`] does; `file` is its name in diagnostics.
    ///
    /// # Errors
    ///
    /// [`Environment`](crate::ErrorKind::Environment) with every problem and its place.
    pub fn world_from(&self, file: &str, environment: &str) -> Result<World, Error> {
        environment::parse(&self.domain, file, environment).map_err(Error::environment)
    }

    /// Reads a goal, for example `put(milk, fridge) & closed(fridge handle)`. Values in it must have been added to the
    /// world ([`World::add_values`]).
    ///
    /// # Errors
    ///
    /// [`Goal`](crate::ErrorKind::Goal) when the domain has no such goal or the world no such entity.
    pub fn goal(&self, world: &World, goal: &str) -> Result<Goal, Error> {
        self.own(world)?;
        Ok(goal::parse(world, goal)?)
    }

    /// Finds a plan for a goal and verifies it; a shortest one if the limits allow for the proof.
    ///
    /// # Errors
    ///
    /// [`Goal`](crate::ErrorKind::Goal), [`Unsolvable`](crate::ErrorKind::Unsolvable), [`GaveUp`](crate::ErrorKind::GaveUp).
    pub fn solve(&self, world: &World, goal: &str) -> Result<VerifiedPlan, Error> {
        let mut world = world.clone();
        world.add_values(goal);
        let solution = self.solution(&world, &self.goal(&world, goal)?)?;
        solution.plan.ok_or_else(|| Error::no_plan(solution.answer))
    }

    /// Finds and verifies a plan as [`Planner::solve`] does, and returns the whole answer to it.
    ///
    /// # Errors
    ///
    /// [`OtherDomain`](crate::ErrorKind::OtherDomain). A goal without a plan is not an error here.
    pub fn solution(&self, world: &World, goal: &Goal) -> Result<Solution, Error> {
        self.own(world)?;
        Ok(report::of_goal(world, goal, "", &self.limits, self.clock))
    }

    /// Reads the plan in a text: the JSON of the paper, a script, or a model's reply that contains one. The assessment
    /// verifies and repairs it on demand.
    ///
    /// ```
    /// use longstep::Planner;
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>"], "objects": ["<pen>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// let reply = r#"{"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}"#;
    /// let assessment = planner.assess(&world, reply)?;
    /// assert!(assessment.verified().is_none());
    /// assert_eq!(assessment.repaired().edits.len(), 2);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Plan`](crate::ErrorKind::Plan) when the text contains no plan.
    pub fn assess<'a>(&self, world: &'a World, text: &str) -> Result<Assessment<'a>, Error> {
        self.own(world)?;
        Ok(Assessment::new(world, plan::read(text)?, None))
    }

    /// Verifies the plan in a text.
    ///
    /// # Errors
    ///
    /// [`Plan`](crate::ErrorKind::Plan); [`Invalid`](crate::ErrorKind::Invalid) with every violation in the answer.
    pub fn verify(&self, world: &World, text: &str) -> Result<VerifiedPlan, Error> {
        let assessment = self.assess(world, text)?;
        let verified = assessment.verified();
        verified.ok_or_else(|| Error::no_plan(assessment.verdict()))
    }

    /// Begins a session in a world. `model` describes the model that will answer its requests.
    ///
    /// # Errors
    ///
    /// [`OtherDomain`](crate::ErrorKind::OtherDomain).
    pub fn session(&self, world: World, settings: Settings, model: ModelFacts) -> Result<Session, Error> {
        self.own(&world)?;
        let (domain, name) = (Arc::clone(&self.domain), &self.domain.origin);
        Ok(Session::new(name, domain, world, settings, model, self.clock).limited(self.limits))
    }

    /// Restores a session from its log.
    ///
    /// # Errors
    ///
    /// [`Log`](crate::ErrorKind::Log) when the log does not lead where it led before, as with another domain.
    pub fn resume(&self, log: &Log) -> Result<Resumed, Error> {
        let mut resumed = Session::resume(Arc::clone(&self.domain), log, self.clock)?;
        resumed.session = resumed.session.limited(self.limits);
        Ok(resumed)
    }

    fn own(&self, world: &World) -> Result<(), Error> {
        if world.domain().is_same(&self.domain.domain) {
            Ok(())
        } else {
            Err(Error::other_domain(&self.domain.name))
        }
    }
}
