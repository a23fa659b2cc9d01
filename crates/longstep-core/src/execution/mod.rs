//! Execution: a verified plan that a robot carries out, monitored and mended.
//!
//! An [`Execution`] never waits and calls no robot. [`Execution::next_need`] says what it needs ([`Need`]), and it is given
//! that: the end of a step, an observation, a decision of a person. Every event goes to a log ([`Event`]) that is
//! written before the need is met, so that an execution can be taken up again after a crash ([`Execution::resume`]).
//!
//! Invariants:
//!
//! - A step is ordered only if its precondition holds in the observed world and no constraint forbids it.
//! - The plan in force was verified from the world that was observed when it came into force.
//! - A step that the [limits](crate::autonomy) of the robot refuse is neither planned nor ordered.
//! - A change that a person has to approve is not performed before it is approved. An approval counts for one proposal only.
//! - "Done" is said only of what the verifier accepts, and of facts that were observed since a step could have changed
//!   them, unless [`Trust::Promised`] accepts promises; what no look has shown is listed.
//! - After a stop nothing is ordered, unless the execution is resumed from its log.
//! - While it is paused nothing is ordered; afterwards nothing before the world was observed.

mod aim;
mod announce;
mod approval;
mod assess;
mod board;
mod change;
mod error;
mod event;
mod evidence;
#[cfg(test)]
mod evidence_tests;
#[cfg(test)]
mod interruption_tests;
mod knowledge;
mod limits;
#[cfg(test)]
mod limits_tests;
mod monitor;
mod need;
mod order;
mod pause;
#[cfg(test)]
mod pause_tests;
mod resume;
mod settings;
#[cfg(test)]
mod tests;
mod written;

use rustc_hash::FxHashMap;

pub use aim::Aim;
pub use approval::{Proposal, ProposalId, Subject, plan_hash};
pub use board::{Board, BoardLine, BoardStep, Mark};
pub use change::{Change, ChangeKind};
pub use error::{BeginError, ExecutionError, RefusedPart};
pub use event::{Event, PlanText};
pub use knowledge::{Basis, Unseen};
pub use monitor::Noticed;
pub use need::{Effect, Need, StepOrder, Stop};
pub use resume::{ResumeError, Resumed};
pub use settings::{Approval, Settings, Trust, Watch};

use announce::Announcement;
use evidence::{Looks, TrustedProgress};
use knowledge::Knowledge;
use longstep_model::environment::{Environment, Observation, ObservedFacts};
use longstep_model::model::{State, StateVariable, World};
use longstep_search::search::GroundAction;
use longstep_verify::cursor::Cursor;
use longstep_verify::plan::{Node, StepId, tree};
use longstep_verify::verify::{Progress, Purpose, Report, VerifiedPlan, check};
use monitor::Completed;
use order::ground;
use pause::{Meanwhile, Pause};
use written::messages;

/// A verified plan that is carried out.
///
/// # Example
///
/// ```
/// use longstep_core::environment::{self, ObservedFacts};
/// use longstep_core::execution::{Aim, Approval, Execution, Need, Settings};
/// use longstep_core::{domain, goal, model::apply, search, verify};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(pen, shelf)").unwrap();
/// let outcome = search::solve(&world, &goal.purpose(&world), &search::Limits::default());
/// let search::Outcome::Solved { plan, .. } = outcome else { panic!() };
/// let plan = verify::check(&world, plan, &goal.purpose(&world)).into_verified().unwrap();
///
/// let settings = Settings::default().with_approval(Approval::Never);
/// let mut execution = Execution::new(&plan, &Aim::Goal("put(pen, shelf)".to_owned()), settings).unwrap();
/// // A world in which every step works.
/// let mut real = world.state.clone();
/// let everything: Vec<_> = world.entities().map(|(entity, _)| entity).collect();
/// loop {
///     match execution.next_need() {
///         Need::Perform(order) => {
///             apply(&world, &mut real, household.action(order.action), &order.arguments);
///             execution.performed(order.number, None).unwrap();
///         }
///         Need::Observe => {
///             let seen = ObservedFacts::statements(&world, &real, &everything, &[]);
///             execution.observed(&seen).unwrap();
///         }
///         Need::Done => break,
///         other => panic!("{other:?}"),
///     }
/// }
/// assert_eq!(execution.after().environment().object_states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
/// assert!(execution.is_ended() && execution.running().is_empty() && execution.changes() == 0);
/// ```
#[derive(Debug, Clone)]
pub struct Execution {
    /// The world in which the instruction was given, with the prohibitions in force.
    world: World,
    purpose: Purpose,
    settings: Settings,
    cursor: Cursor,
    /// The position at the last observation that agreed with the prediction.
    checkpoint: Cursor,
    /// The steps that were completed since then.
    since: Vec<GroundAction>,
    /// The steps that were completed since the last order before which the world was observed.
    recent: Vec<Completed>,
    /// True if the world was observed after the last completed step.
    seen_recent: bool,
    /// A look before an interruption, after which a person was asked and did not answer.
    earlier_look: Option<ObservedFacts>,
    knowledge: Knowledge,
    looks: Looks,
    /// The progress through the stages that was observed before the `recent` steps.
    base: Progress,
    /// The progress through the stages that was observed.
    progress: Progress,
    /// The promises on which further progress rests.
    unproven: Vec<StateVariable>,
    trusted: Vec<TrustedProgress>,
    /// True if a person has to approve the rest of the plan before the next order.
    unapproved: bool,
    running: Vec<StepOrder>,
    /// Orders that were under way at a crash.
    interrupted: Vec<StepOrder>,
    orders: u64,
    /// The failures of each step since it last worked.
    failures: FxHashMap<GroundAction, u32>,
    /// The steps that were performed since the last observation that agreed with the prediction, and did not fail since.
    worked: Vec<GroundAction>,
    /// Steps that failed too often, with the reasons.
    forbidden: Vec<(GroundAction, String)>,
    /// The worlds from which the plan was changed, with the rest of the plan.
    visited: Vec<(State, Vec<GroundAction>, usize)>,
    changes: u32,
    /// The number of steps of the plan of the beginning before those of the plan in force; none if it was changed.
    taught: Option<usize>,
    /// True if an observation is due before anything else.
    due: bool,
    /// True if the observed world differs from the prediction, or a step failed.
    suspicious: bool,
    differences: Vec<Noticed>,
    /// The step that a person approved and that is not ordered yet.
    approved: Option<StepOrder>,
    /// The step that was announced and is not ordered yet.
    announcement: Option<Announcement>,
    phase: Phase,
    pause: Pause,
    meanwhile: Meanwhile,
    /// The phase before a stop after which the execution can be taken up again.
    suspended: Option<Box<Phase>>,
    events: Vec<Event>,
    has_lanes: bool,
}

/// The state of an execution.
#[derive(Debug, Clone)]
enum Phase {
    Active,
    Approving(Proposal),
    /// Waits for a person who knows about interrupted orders; with the observation after the crash.
    Judging(ObservedFacts),
    /// Waits for a person who knows whether something is so that no look has shown.
    Confirming(StateVariable, Unseen),
    Done,
    Stopped(Stop),
}

impl Execution {
    /// Begins to carry out a plan. Verifies it again, for the purpose of the aim. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// The error in the goal of the aim; a plan that does not reach it; steps that a person has to teach first; steps and values
    /// that the levels and limits of the robot refuse.
    pub fn new(plan: &VerifiedPlan, aim: &Aim, settings: Settings) -> Result<Self, BeginError> {
        let missing = settings.skills.missing(plan.world(), plan.plan());
        if !missing.is_empty() {
            return Err(BeginError::Untaught(missing));
        }
        let (unlimited, purpose) = aim.purpose(plan)?;
        limits::check(&unlimited, plan, aim, &settings)?;
        let world = unlimited.with_prohibitions(settings.autonomy.prohibitions(&unlimited));
        let report = check(&world, plan.plan().clone(), &purpose).into_verified();
        let refused = |report: Box<Report>| {
            let goal = aim.goal(&world);
            BeginError::Purpose(messages(&world, &report.violations, report.plan.steps(), goal.as_ref()))
        };
        let plan = &report.map_err(refused)?;
        let began = Event::began(&unlimited, plan, aim, &settings);
        let cursor = Cursor::new(plan);
        let lanes = |node: &Node| matches!(node, Node::Parallel { .. });
        let mut execution = Self {
            has_lanes: tree::iter(plan.plan().body()).any(lanes),
            // The world may have changed since the plan was made.
            due: true,
            checkpoint: cursor.clone(),
            cursor,
            world,
            purpose,
            settings,
            since: Vec::new(),
            recent: Vec::new(),
            seen_recent: false,
            earlier_look: None,
            knowledge: Knowledge::default(),
            looks: Looks::default(),
            base: Progress::default(),
            progress: Progress::default(),
            unproven: Vec::new(),
            trusted: Vec::new(),
            unapproved: false,
            running: Vec::new(),
            interrupted: Vec::new(),
            orders: 0,
            failures: FxHashMap::default(),
            worked: Vec::new(),
            forbidden: Vec::new(),
            visited: Vec::new(),
            changes: 0,
            taught: Some(0),
            suspicious: false,
            differences: Vec::new(),
            approved: None,
            announcement: None,
            phase: Phase::Active,
            pause: Pause::Off,
            meanwhile: Meanwhile::default(),
            suspended: None,
            events: vec![began],
        };
        if execution.settings.approval != Approval::Never {
            execution.propose(Subject::Plan);
        }
        Ok(execution)
    }

    /// Returns the world in which the instruction was given.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the settings.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// Returns the plan in force: that of the beginning, or the last change.
    pub fn plan(&self) -> &VerifiedPlan {
        self.cursor.plan()
    }

    /// Returns the position in the plan in force.
    pub fn cursor(&self) -> &Cursor {
        &self.cursor
    }

    /// Returns the state that is known or, where nothing was observed, predicted.
    pub fn state(&self) -> &State {
        self.cursor.state()
    }

    /// Returns the state that is known as an observation of every entity.
    pub fn statements(&self) -> Observation {
        let entities = self.world.entities().filter(|(_, entity)| !entity.is_value);
        let entities: Vec<_> = entities.map(|(id, _)| id).collect();
        ObservedFacts::statements(&self.world, self.state(), &entities, &[])
    }

    /// Returns the orders that are under way. See the [example](Self#example).
    pub fn running(&self) -> &[StepOrder] {
        &self.running
    }

    /// Returns the number of changes of the plan so far. See the [example](Self#example).
    pub fn changes(&self) -> u32 {
        self.changes
    }

    /// Returns the events since the last call. Write them to the log before the next need is met. See the example of
    /// [`Execution::resume`].
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Returns the world after the execution, or after its steps so far, in which the next instruction is given. See
    /// the [example](Self#example).
    pub fn after(&self) -> World {
        self.world.after_state(self.state())
    }

    /// Returns the environment after the execution, or after its steps so far.
    pub fn environment(&self) -> Environment {
        self.after().environment().clone()
    }

    /// Returns the environment with an observation that waits for a person's answer.
    fn environment_seen(&self) -> Environment {
        let pending = match &self.phase {
            Phase::Judging(observation) => Some(self.with_earlier_look(observation.clone())),
            _ => self.earlier_look.clone(),
        };
        match pending {
            Some(observation) => {
                let state = observation.revised(&self.world, self.state());
                self.world.after_state(&state).environment().clone()
            }
            None => self.environment(),
        }
    }

    /// Returns the next input that the execution needs. Steps of several lanes are ordered by several calls; [`Need::Wait`]
    /// follows them. A change of the plan is searched for here, within the default limits. See the [example](Self#example).
    pub fn next_need(&mut self) -> Need {
        loop {
            if !self.is_ended()
                && let Some(need) = self.pause_need()
            {
                return need;
            }
            match &self.phase {
                Phase::Active => {}
                // After a pause a person decides about the observed world.
                Phase::Approving(_) if self.meanwhile.is_unknown => return Need::Observe,
                Phase::Approving(proposal) => return Need::Approve(proposal.clone()),
                Phase::Judging(_) => match self.interrupted.first() {
                    Some(order) => return Need::Judge(order.clone()),
                    None => self.phase = Phase::Active,
                },
                Phase::Confirming(_, unseen) => return Need::Confirm(unseen.clone()),
                Phase::Done => return Need::Done,
                Phase::Stopped(stop) => return Need::Stopped(stop.clone()),
            }
            if self.due {
                return Need::Observe;
            }
            if self.suspicious {
                if !self.running.is_empty() {
                    return Need::Wait;
                }
                self.assess();
                continue;
            }
            if !self.unproven.is_empty() {
                match self.prove_stages() {
                    Some(need) => return need,
                    None => continue,
                }
            }
            if self.cursor.is_finished() {
                // The end is never claimed without an observation.
                if !(self.checkpoint.is_finished() && self.since.is_empty()) {
                    self.due = true;
                } else if let Some(need) = self.conclude() {
                    return need;
                }
                continue;
            }
            let is_running = |step: &&StepId| !self.running.iter().any(|order| order.step == **step);
            let Some(step) = self.cursor.ready().iter().find(is_running).copied() else {
                return Need::Wait;
            };
            if let Some(need) = self.order(step) {
                return need;
            }
        }
    }

    /// Returns true if nothing is needed any more. See the [example](Self#example).
    pub fn is_ended(&self) -> bool {
        matches!(self.phase, Phase::Done | Phase::Stopped(_))
    }

    /// Stops at a request. Nothing is ordered afterwards; stop the robot first.
    ///
    /// ```
    /// # use longstep_core::environment::{self, Observation};
    /// # use longstep_core::execution::{Aim, Approval, Execution, ExecutionError, Need, Resumed, Settings, Stop};
    /// # use longstep_core::{domain, plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
    /// let settings = Settings::default().with_approval(Approval::Never);
    /// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
    /// execution.stop("the person pressed stop");
    /// assert!(matches!(execution.next_need(), Need::Stopped(Stop::Requested(_))));
    /// assert_eq!(execution.observed(&seen), Err(ExecutionError::Ended));
    /// ```
    pub fn stop(&mut self, why: &str) {
        self.end(Stop::Requested(why.to_owned()));
    }

    /// Stops because the robot failed, and not only one of its steps. The reason is cut after 1,000 characters. See the
    /// example of [`Execution::stop`].
    pub fn robot_failed(&mut self, why: &str) {
        self.end(Stop::Robot(why.chars().take(1_000).collect()));
    }

    /// Returns the numbers of the orders of which nobody knows whether they were done.
    fn unknown(&self) -> Vec<u64> {
        let orders = self.running.iter().chain(&self.interrupted);
        orders.map(|order| order.number).collect()
    }

    pub(super) fn end(&mut self, stop: Stop) {
        if self.is_ended() {
            return;
        }
        self.events.push(Event::Stopped {
            why: stop.sentence(&self.world),
            proven: stop.is_proven(),
            under_way: self.unknown(),
            environment: self.environment_seen(),
        });
        let is_resumable = stop.is_resumable();
        let before = std::mem::replace(&mut self.phase, Phase::Stopped(stop));
        self.suspended = is_resumable.then(|| Box::new(before));
    }

    /// Replaces the plan in force by one that was verified from the observed world. `taught` is the number of steps of the
    /// plan of the beginning before it; none if it is no rest of that plan.
    fn install(&mut self, plan: &VerifiedPlan, taught: Option<usize>) {
        self.taught = taught;
        self.cursor = Cursor::new(plan);
        self.approved = None;
        self.announcement = None;
        self.confirm();
    }
}
