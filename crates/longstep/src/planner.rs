//! The front door: one domain, its prompts, and the settings of all work with it.

use std::sync::Arc;

use crate::clock::Clock;
use crate::environment::{self, World};
use crate::error::Error;
use crate::goal::{self, Goal};
use crate::load;
use crate::model::Domain;
use crate::plan;
use crate::report::{self, Assessment, Solution};
use crate::search::Limits;
use crate::session::{Log, ModelFacts, Resumed, Session, Settings};
use crate::verify::VerifiedPlan;

/// A planner for one robot: it owns the domain with its prompts, the limits of searches, and a clock.
///
/// It does no I/O and holds no state of a conversation. Clones are cheap and share the domain, so one planner serves
/// many sessions and threads.
///
/// # Example
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
    clock: Clock,
}

impl Planner {
    /// Creates a planner with the default limits and without a clock.
    ///
    /// ```
    /// use longstep::{Planner, domain};
    /// let pddl = "(define (domain lamp) (:predicates (lit)) (:action press :effect (lit)))";
    /// let planner = Planner::new(domain::from_pddl("lamp.pddl", pddl).unwrap());
    /// assert_eq!(planner.domain().name, "lamp");
    /// ```
    pub fn new(domain: impl Into<Arc<Domain>>) -> Self {
        Self {
            domain: domain.into(),
            limits: Limits::default(),
            clock: Clock::none(),
        }
    }

    /// Creates a planner for a domain that is shipped with the library. Loads the domain anew: some milliseconds.
    ///
    /// ```
    /// use longstep::{ErrorKind, Planner};
    /// assert_eq!(Planner::shipped("household")?.domain().name, "household");
    /// assert_eq!(Planner::shipped("garage").unwrap_err().kind(), ErrorKind::Domain);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Domain`](crate::ErrorKind::Domain) when there is no such domain.
    pub fn shipped(name: &str) -> Result<Self, Error> {
        let domain = load::shipped(name).ok_or_else(|| Error::unknown_domain(name))?;
        Ok(Self::new(domain.map_err(Error::domain)?))
    }

    /// Sets the limits of searches. A limit counts states and units of work, so the result is the same on every machine.
    ///
    /// ```
    /// use longstep::{Effort, ErrorKind, Limits, Planner};
    /// let planner = Planner::shipped("household")?.with_limits(Limits::from(Effort::LARGE));
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// assert!(planner.solve(&world, "put(pen, shelf)").is_ok());
    /// # let limits = Limits::default().with_direct(1).with_proof(1).with_shortest(1).with_any(1);
    /// # let error = planner.with_limits(limits).solve(&world, "put(pen, shelf)").unwrap_err();
    /// # assert_eq!(error.kind(), ErrorKind::GaveUp);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    #[must_use]
    pub fn with_limits(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Sets the clock of the durations in answers. See the example of [`Clock`].
    #[must_use]
    pub fn with_clock(self, clock: Clock) -> Self {
        Self { clock, ..self }
    }

    /// Returns the domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Reads an environment, bare or wrapped in `{"environment": ...}`, as JSON. Diagnostics call it `environment`. Takes
    /// time linear in the length of the text.
    ///
    /// ```
    /// use longstep::{ErrorKind, Planner};
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#)?;
    /// assert!(world.find("<pen>").is_some());
    /// let error = planner.world(r#"{"assets": ["<desk>"], "object_states": {"<pen>": "closed()"}}"#).unwrap_err();
    /// assert_eq!((error.kind(), error.diagnostics().unwrap().0.len()), (ErrorKind::Environment, 1));
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Environment`](crate::ErrorKind::Environment) with every problem and its place.
    pub fn world(&self, environment: &str) -> Result<World, Error> {
        self.world_from("environment", environment)
    }

    /// Reads an environment as [`Planner::world`] does; `file` is its name in diagnostics.
    ///
    /// ```
    /// let planner = longstep::Planner::shipped("household")?;
    /// let error = planner.world_from("kitchen.json", r#"{"assets": ["<desk>", "<desk>"]}"#).unwrap_err();
    /// assert!(error.to_string().starts_with("kitchen.json:1:"));
    /// # Ok::<(), longstep::Error>(())
    /// ```
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
    /// ```
    /// let planner = longstep::Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"]}"#)?;
    /// let goal = planner.goal(&world, "put(pen, shelf)")?;
    /// assert_eq!(goal.sentences(&world), ["the pen is at the shelf"]);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Goal`](crate::ErrorKind::Goal) when the domain has no such goal or the world no such entity.
    pub fn goal(&self, world: &World, goal: &str) -> Result<Goal, Error> {
        self.own(world)?;
        Ok(goal::parse(world, goal)?)
    }

    /// Finds a plan for a goal and verifies it; a shortest one if the limits allow for the proof. The work is bounded by
    /// the limits of the planner.
    ///
    /// ```
    /// use longstep::{ErrorKind, Planner};
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// let plan = planner.solve(&world, "put(pen, shelf)")?;
    /// assert_eq!(plan.steps().len(), 6);
    /// assert_eq!(world.after(plan.ending()).environment().object_states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
    /// let error = planner.solve(&world, "put(pen, shelf) & untouched(pen)").unwrap_err();
    /// assert_eq!(error.kind(), ErrorKind::Unsolvable);
    /// # Ok::<(), longstep::Error>(())
    /// ```
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
    /// ```
    /// use longstep::Planner;
    /// use longstep::report::Status;
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// let solution = planner.solution(&world, &planner.goal(&world, "put(pen, shelf)")?)?;
    /// assert_eq!(solution.answer.status, Status::Verified);
    /// assert!(solution.answer.search.unwrap().shortest);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`OtherDomain`](crate::ErrorKind::OtherDomain). A goal without a plan is not an error here.
    pub fn solution(&self, world: &World, goal: &Goal) -> Result<Solution, Error> {
        self.own(world)?;
        Ok(report::of_goal(world, goal, "", &self.limits, &self.clock))
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

    /// Verifies the plan in a text. The plan is neither repaired nor completed: [`Planner::assess`] can repair it.
    ///
    /// ```
    /// use longstep::{ErrorKind, Planner};
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>"], "objects": ["<pen>"],
    ///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// let plan = planner.verify(&world, r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#)?;
    /// assert_eq!(plan.steps().len(), 3);
    /// let error = planner.verify(&world, r#"{"task_sequence": ["grasp_object()"], "object_name": "<pen>"}"#).unwrap_err();
    /// assert_eq!((error.kind(), error.answer().unwrap().violations.len()), (ErrorKind::Invalid, 2));
    /// # Ok::<(), longstep::Error>(())
    /// ```
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
    /// See the [example of a session](crate::session).
    ///
    /// # Errors
    ///
    /// [`OtherDomain`](crate::ErrorKind::OtherDomain).
    pub fn session(&self, world: World, settings: Settings, model: ModelFacts) -> Result<Session, Error> {
        self.own(&world)?;
        let (domain, name) = (Arc::clone(&self.domain), &self.domain.origin);
        Ok(Session::new(name, domain, world, settings, model, self.clock.clone()).limited(self.limits))
    }

    /// Restores a session from its log. Verifies each accepted plan again; calls no model.
    ///
    /// ```
    /// use longstep::Planner;
    /// use longstep::dialogue::ConstraintKind;
    /// use longstep::session::{Entry, Log, ModelFacts, Settings};
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#)?;
    /// let model = ModelFacts::new("mine", ConstraintKind::JsonSchema);
    /// let mut session = planner.session(world, Settings::default(), model)?;
    /// session.add_rule("untouched(pen)").unwrap();
    ///
    /// let entry = |event| Entry::new("2026-07-01T12:00:00Z", event).line();
    /// let log: String = session.take_events().into_iter().map(entry).collect();
    /// let resumed = planner.resume(&Log::read(log.as_bytes())?)?;
    /// assert_eq!(resumed.session.rules().len(), 1);
    /// # Ok::<(), longstep::Error>(())
    /// ```
    ///
    /// # Errors
    ///
    /// [`Log`](crate::ErrorKind::Log) when the log does not lead where it led before, as with another domain.
    pub fn resume(&self, log: &Log) -> Result<Resumed, Error> {
        let mut resumed = Session::resume(Arc::clone(&self.domain), log, self.clock.clone())?;
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
