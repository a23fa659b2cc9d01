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
//! - A change that a person has to approve is not performed before it is approved.
//! - After a stop nothing is ordered, unless the execution is resumed from its log.

mod aim;
mod assess;
mod change;
mod event;
mod need;
mod resume;
#[cfg(test)]
mod tests;

use rustc_hash::{FxHashMap, FxHashSet};
use serde::{Deserialize, Serialize};

pub use aim::Aim;
pub use change::{Change, ChangeKind};
pub use event::{Event, PlanText};
pub use need::{Effect, Need, Order, Proposal, Stop};
pub use resume::ResumeError;

use crate::cursor::{Cursor, CursorError};
use crate::environment::{Environment, Observation, ObservationError, Statements};
use crate::goal::GoalError;
use crate::model::{
    Change as FactChange, Changes, Difference, Ending, Fact, Moment, PredicateId, State, Trace, World, apply,
    broken_bindings, fired, holds,
};
use crate::plan::StepId;
use crate::search::GroundAction;
use crate::skill::{MissingSkill, Skills};
use crate::verify::{Progress, Purpose, VerifiedPlan};

/// When a person is asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Approval {
    /// Never.
    Never,
    /// Before the first step, and before a change of the plan that adds or replaces steps.
    #[default]
    Changes,
    /// As for [`Approval::Changes`], and before every step.
    EachStep,
}

/// When the world is observed. In either case it is observed before the end.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "kebab-case")]
pub enum Watch {
    /// Before the first step and after every step.
    #[default]
    EachStep,
    /// After a failed step.
    OnFailure,
}

/// The settings of an execution.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// When a person is asked.
    pub approval: Approval,
    /// When the world is observed.
    pub watch: Watch,
    /// The number of changes of the plan after which the execution stops.
    pub changes: u32,
    /// The predicates that observations list besides the states of entities.
    pub reports: Vec<PredicateId>,
    /// The values of skill parameters.
    pub skills: Skills,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            approval: Approval::default(),
            watch: Watch::default(),
            changes: 8,
            reports: Vec::new(),
            skills: Skills::default(),
        }
    }
}

/// A plan that cannot be carried out. Nothing has moved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum BeginError {
    /// The goal cannot be read.
    #[error(transparent)]
    Goal(#[from] GoalError),
    /// Steps that a person has to teach first, in order; at least one.
    #[error("{}", .0.iter().map(ToString::to_string).collect::<Vec<_>>().join("\n"))]
    Untaught(Vec<MissingSkill>),
}

/// An input that does not fit the state of the execution, which is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ExecutionError {
    /// No order with this number is under way.
    #[error("no order {0} is under way")]
    UnknownOrder(u64),
    /// The outcome of a sensing step is missing, or is none of its outcomes.
    #[error(transparent)]
    Outcome(#[from] CursorError),
    /// An observation that cannot be read.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// Nothing waits for a decision.
    #[error("nothing waits for a decision")]
    NothingProposed,
    /// The execution has ended.
    #[error("the execution has ended")]
    Ended,
}

/// A verified plan that is carried out.
///
/// ```
/// use longstep_core::environment::{self, Observation};
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
/// let settings = Settings { approval: Approval::Never, ..Settings::default() };
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
///             let seen = Observation::statements(&world, &real, &everything, &[]);
///             execution.observed(&seen).unwrap();
///         }
///         Need::Done => break,
///         other => panic!("{other:?}"),
///     }
/// }
/// assert_eq!(execution.after().environment().object_states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
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
    progress: Progress,
    running: Vec<Order>,
    /// Orders that were under way at a crash.
    interrupted: Vec<Order>,
    orders: u64,
    /// The failures of each step since it last worked.
    failures: FxHashMap<GroundAction, u32>,
    /// Steps that failed too often, with the reasons.
    forbidden: Vec<(GroundAction, String)>,
    /// The worlds from which the plan was changed, with the rest of the plan.
    visited: Vec<(State, Vec<GroundAction>, usize)>,
    changes: u32,
    /// True if an observation is due before anything else.
    due: bool,
    /// True if the observed world differs from the prediction, or a step failed.
    suspicious: bool,
    differences: Vec<Difference>,
    approved: Option<StepId>,
    phase: Phase,
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
    Judging(Observation),
    Done,
    Stopped(Stop),
}

impl Execution {
    /// Begins to carry out a plan.
    ///
    /// # Errors
    ///
    /// The error in the goal of the aim; steps that a person has to teach first.
    pub fn new(plan: &VerifiedPlan, aim: &Aim, settings: Settings) -> Result<Self, BeginError> {
        let missing = settings.skills.missing(plan.world(), plan.plan());
        if !missing.is_empty() {
            return Err(BeginError::Untaught(missing));
        }
        let purpose = Purpose {
            // The plan was verified with them in force.
            prohibitions: Vec::new(),
            ..aim.purpose(plan)?
        };
        let world = plan.world().clone();
        let began = Event::began(plan, aim, &settings);
        let phase = match settings.approval {
            Approval::Never => Phase::Active,
            Approval::Changes | Approval::EachStep => Phase::Approving(Proposal::Plan),
        };
        let cursor = Cursor::new(plan);
        let lanes = |node: &crate::plan::Node| matches!(node, crate::plan::Node::Parallel { .. });
        Ok(Self {
            progress: Progress::begun(&world, &purpose),
            has_lanes: crate::plan::tree::iter(plan.plan().body()).any(lanes),
            due: settings.watch == Watch::EachStep,
            checkpoint: cursor.clone(),
            cursor,
            world,
            purpose,
            settings,
            since: Vec::new(),
            running: Vec::new(),
            interrupted: Vec::new(),
            orders: 0,
            failures: FxHashMap::default(),
            forbidden: Vec::new(),
            visited: Vec::new(),
            changes: 0,
            suspicious: false,
            differences: Vec::new(),
            approved: None,
            phase,
            suspended: None,
            events: vec![began],
        })
    }

    /// The world in which the instruction was given.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// The plan in force.
    pub fn plan(&self) -> &VerifiedPlan {
        self.cursor.plan()
    }

    /// The position in the plan in force.
    pub fn cursor(&self) -> &Cursor {
        &self.cursor
    }

    /// The state that is known or, where nothing was observed, predicted.
    pub fn state(&self) -> &State {
        self.cursor.state()
    }

    /// The orders that are under way.
    pub fn running(&self) -> &[Order] {
        &self.running
    }

    /// The number of changes of the plan so far.
    pub fn changes(&self) -> u32 {
        self.changes
    }

    /// Returns the events since the last call. Write them to the log before the next need is met.
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Returns the world after the execution, or after its steps so far, in which the next instruction is given.
    pub fn after(&self) -> World {
        let after = self.state().clone();
        let mut changes: Vec<FactChange> = Vec::new();
        let before = &self.world.state;
        let gone = before.iter().filter(|fact| !after.holds(*fact));
        changes.extend(gone.map(|fact| FactChange { fact, holds: false }));
        let new = after.iter().filter(|fact| !before.holds(*fact));
        changes.extend(new.map(|fact| FactChange { fact, holds: true }));
        let mut trace = Trace::default();
        trace.add(StepId::new(0), &changes, &[]);
        self.world.after(&Ending {
            when: Vec::new(),
            trace,
            after,
        })
    }

    /// Returns the environment after the execution, or after its steps so far.
    pub fn environment(&self) -> Environment {
        self.after().environment().clone()
    }

    /// Returns what the execution needs. Steps of several lanes are ordered by several calls; [`Need::Wait`] follows
    /// them.
    pub fn next_need(&mut self) -> Need {
        loop {
            match &self.phase {
                Phase::Active => {}
                Phase::Approving(proposal) => return Need::Approve(proposal.clone()),
                Phase::Judging(_) => match self.interrupted.first() {
                    Some(order) => return Need::Judge(order.clone()),
                    None => self.phase = Phase::Active,
                },
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
            if self.cursor.is_finished() {
                if self.checkpoint.is_finished() && self.since.is_empty() {
                    self.events.push(Event::Done {
                        environment: self.environment(),
                    });
                    self.phase = Phase::Done;
                } else {
                    // The end is never claimed without an observation.
                    self.due = true;
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

    /// Orders a step, unless it has to be assessed first.
    fn order(&mut self, id: StepId) -> Option<Need> {
        let step = self.cursor.step(id).clone();
        let domain = self.world.domain();
        let action = domain.action(step.action);
        let moment = Moment {
            world: &self.world,
            state: self.cursor.state(),
        };
        let is_possible = holds(moment, &action.precondition, &mut step.arguments.clone())
            && self.world.forbids(step.action, &step.arguments).is_none()
            && !self.is_forbidden(&ground(&step));
        if !is_possible {
            // The prediction was wrong where nothing was observed.
            self.suspicious = true;
            return None;
        }
        let order = Order {
            number: self.orders + 1,
            step: id,
            lane: step.actor(domain),
            action: step.action,
            outcomes: self.cursor.outcomes(id),
            skills: self.settings.skills.values(&self.world, step.action, &step.arguments),
            arguments: step.arguments,
            explanation: step.explanation,
        };
        if self.settings.approval == Approval::EachStep && self.approved != Some(id) {
            self.phase = Phase::Approving(Proposal::Step(order));
            return None;
        }
        self.approved = None;
        self.orders += 1;
        self.events.push(Event::ordered(&self.world, &order));
        self.running.push(order.clone());
        Some(match order.outcomes.is_empty() {
            true => Need::Perform(order),
            false => Need::Sense(order),
        })
    }

    fn is_forbidden(&self, step: &GroundAction) -> bool {
        self.forbidden.iter().any(|(own, _)| own == step)
    }

    fn take_running(&mut self, number: u64) -> Result<Order, ExecutionError> {
        if self.is_ended() {
            return Err(ExecutionError::Ended);
        }
        let place = self.running.iter().position(|order| order.number == number);
        let place = place.ok_or(ExecutionError::UnknownOrder(number))?;
        Ok(self.running.remove(place))
    }

    /// Returns true if nothing is needed any more.
    pub fn is_ended(&self) -> bool {
        matches!(self.phase, Phase::Done | Phase::Stopped(_))
    }

    /// Records that the robot says that it performed a step, with the outcome of a sensing step.
    ///
    /// # Errors
    ///
    /// An order that is not under way, and an outcome that is missing or is none of the step's. The execution is
    /// unchanged then.
    pub fn performed(&mut self, number: u64, outcome: Option<Fact>) -> Result<(), ExecutionError> {
        let order = self.take_running(number)?;
        if let Err(error) = self.complete(&order, outcome) {
            self.running.push(order);
            self.running.sort_by_key(|order| order.number);
            return Err(error.into());
        }
        self.events.push(Event::performed(&self.world, number, outcome));
        self.due = self.settings.watch == Watch::EachStep || self.suspicious;
        Ok(())
    }

    /// Moves on behind a step.
    fn complete(&mut self, order: &Order, outcome: Option<Fact>) -> Result<(), CursorError> {
        let mut cursor = self.cursor.clone();
        let other = |fact: &&Fact| outcome.is_some_and(|seen| seen != **fact) && cursor.state().holds(**fact);
        let contradicts = order.outcomes.iter().find(other).copied();
        if let Some(known) = contradicts.filter(|_| outcome.is_some_and(|seen| order.outcomes.contains(&seen))) {
            // What was known has changed: what is seen now counts.
            let mut state = cursor.state().clone();
            state.set(known, false);
            cursor.correct(state);
        }
        let before = cursor.state().clone();
        cursor.complete(order.step, outcome)?;
        self.suspicious |= contradicts.is_some();
        let action = self.world.domain().action(order.action);
        let states = (&before, cursor.state());
        self.progress
            .step(&self.world, &self.purpose, states, action, &order.arguments);
        self.cursor = cursor;
        self.since.push(GroundAction {
            action: order.action,
            arguments: order.arguments.clone(),
        });
        Ok(())
    }

    /// Records that the robot could not do a step. The world is observed then.
    ///
    /// # Errors
    ///
    /// An order that is not under way.
    pub fn failed(&mut self, number: u64, why: &str) -> Result<(), ExecutionError> {
        let order = self.take_running(number)?;
        let why: String = why.chars().take(500).collect();
        self.events.push(Event::Failed {
            order: number,
            why: why.clone(),
        });
        let step = GroundAction {
            action: order.action,
            arguments: order.arguments,
        };
        self.count_failure(step, &why);
        self.due = true;
        self.suspicious = true;
        Ok(())
    }

    /// Counts a failure of a step, which is forbidden when it has failed too often.
    fn count_failure(&mut self, step: GroundAction, why: &str) {
        let failures = self.failures.entry(step.clone()).or_default();
        *failures += 1;
        if *failures > self.world.domain().action(step.action).retries && !self.is_forbidden(&step) {
            self.forbidden.push((step, why.to_owned()));
        }
    }

    /// Takes an observation, which may be partial.
    ///
    /// # Errors
    ///
    /// An observation that cannot be read in this world. It is still needed then.
    pub fn observed(&mut self, statements: &Statements) -> Result<(), ExecutionError> {
        if self.is_ended() {
            return Err(ExecutionError::Ended);
        }
        let observation = Observation::read(&self.world, &self.settings.reports, statements)?;
        self.events.push(Event::Observed {
            statements: statements.clone(),
        });
        self.due = false;
        if self.settle_interrupted(&observation) {
            self.compare(&observation);
        } else {
            self.phase = Phase::Judging(observation);
        }
        Ok(())
    }

    /// Compares the prediction with an observation.
    fn compare(&mut self, observation: &Observation) {
        let mut masked = FxHashSet::default();
        for order in &self.running {
            let action = self.world.domain().action(order.action);
            let mut facts = Vec::new();
            fired(
                &self.world,
                self.state(),
                action,
                &mut order.arguments.clone(),
                &mut facts,
            );
            masked.extend(facts.into_iter().map(|(fact, _)| fact));
        }
        let seen = observation.revised_but(&self.world, self.state(), &masked);
        if seen != *self.state() {
            self.differences = differences(self.state(), &seen);
            let broken = self.newly_broken(&seen);
            self.cursor.correct(seen);
            self.suspicious = true;
            if let Some(constraint) = broken {
                let because = self.differences.clone();
                self.end(Stop::Broken { constraint, because });
                return;
            }
            let state = self.cursor.state().clone();
            self.progress.advance(&self.world, &self.purpose, &state);
        }
        if !self.suspicious && self.running.is_empty() {
            self.confirm();
        }
        if self.suspicious && self.running.is_empty() {
            self.assess();
        }
    }

    /// Records that the observed world is as predicted, or as good.
    fn confirm(&mut self) {
        for step in self.since.drain(..) {
            self.failures.remove(&step);
        }
        self.checkpoint = self.cursor.clone();
    }

    /// Returns a constraint, or a rule for every state, that held in the predicted state and does not hold in the
    /// observed one. An entity that is to be left untouched may be moved by others.
    fn newly_broken(&self, seen: &State) -> Option<String> {
        let world = &self.world;
        world.always_rules().find_map(|(number, rule)| {
            let prohibition = world.prohibition(number);
            let concerns_steps = |pattern: &crate::model::StepPattern| pattern.anywhere.is_some();
            if prohibition.is_some_and(|own| own.steps.iter().any(concerns_steps)) {
                return None;
            }
            let broken = broken_bindings(rule, world, seen);
            if broken.is_empty() {
                return None;
            }
            let known = broken_bindings(rule, world, self.state());
            let is_new = broken.iter().any(|bindings| known.binary_search(bindings).is_err());
            let name = || match prohibition {
                Some(own) => own.says.clone(),
                None => rule.name.clone(),
            };
            is_new.then(name)
        })
    }

    /// Approves what was proposed.
    ///
    /// # Errors
    ///
    /// If nothing waits for a decision.
    pub fn approve(&mut self) -> Result<(), ExecutionError> {
        let proposal = self.take_proposal()?;
        self.events.push(Event::Approved);
        match proposal {
            Proposal::Plan => {}
            Proposal::Step(order) => self.approved = Some(order.step),
            Proposal::Change(change) => self.install(&change.plan),
        }
        Ok(())
    }

    /// Refuses what was proposed: the execution stops.
    ///
    /// # Errors
    ///
    /// If nothing waits for a decision.
    pub fn refuse(&mut self) -> Result<(), ExecutionError> {
        self.take_proposal()?;
        self.events.push(Event::Refused);
        self.end(Stop::Refused);
        Ok(())
    }

    fn take_proposal(&mut self) -> Result<Proposal, ExecutionError> {
        match std::mem::replace(&mut self.phase, Phase::Active) {
            Phase::Approving(proposal) => Ok(proposal),
            other => {
                self.phase = other;
                Err(ExecutionError::NothingProposed)
            }
        }
    }

    /// Stops at a request. Nothing is ordered afterwards; stop the robot first.
    pub fn stop(&mut self, why: &str) {
        self.end(Stop::Requested(why.to_owned()));
    }

    /// Stops because the robot failed, and not only one of its steps.
    pub fn robot_failed(&mut self, why: &str) {
        self.end(Stop::Robot(why.chars().take(1_000).collect()));
    }

    /// Returns the numbers of the orders of which nobody knows whether they were done.
    fn unknown(&self) -> Vec<u64> {
        let orders = self.running.iter().chain(&self.interrupted);
        orders.map(|order| order.number).collect()
    }

    fn end(&mut self, stop: Stop) {
        if self.is_ended() {
            return;
        }
        self.events.push(Event::Stopped {
            why: stop.sentence(&self.world),
            proven: stop.is_proven(),
            under_way: self.unknown(),
            environment: self.environment(),
        });
        let is_resumable = stop.is_resumable();
        let before = std::mem::replace(&mut self.phase, Phase::Stopped(stop));
        self.suspended = is_resumable.then(|| Box::new(before));
    }

    /// Replaces the plan in force by one that was verified from the observed world.
    fn install(&mut self, plan: &VerifiedPlan) {
        self.cursor = Cursor::new(plan);
        self.approved = None;
        self.confirm();
    }

    /// Decides about an interrupted order.
    ///
    /// # Errors
    ///
    /// If no person was asked about this order.
    pub fn judged(&mut self, number: u64, done: bool) -> Result<(), ExecutionError> {
        let Phase::Judging(observation) = &self.phase else {
            return Err(ExecutionError::UnknownOrder(number));
        };
        let observation = observation.clone();
        let place = self.interrupted.iter().position(|order| order.number == number);
        let order = self
            .interrupted
            .remove(place.ok_or(ExecutionError::UnknownOrder(number))?);
        self.events.push(Event::Judged { order: number, done });
        if done {
            self.complete(&order, None)?;
        }
        if self.interrupted.is_empty() {
            self.phase = Phase::Active;
            self.compare(&observation);
        }
        Ok(())
    }

    /// Decides by an observation which of the interrupted orders were done. Returns false if a person has to be asked
    /// about some of them.
    fn settle_interrupted(&mut self, observation: &Observation) -> bool {
        let seen = observation.revised(&self.world, self.state());
        for order in std::mem::take(&mut self.interrupted) {
            // Sensing changes nothing, so it is simply repeated.
            if !order.outcomes.is_empty() {
                continue;
            }
            let action = self.world.domain().action(order.action);
            let Changes { facts, .. } = apply(&self.world, &mut self.state().clone(), action, &order.arguments);
            let mut visible = facts
                .iter()
                .filter(|own| observation.decides(&self.world, own.fact))
                .peekable();
            let is_visible = visible.peek().is_some();
            let came_about = visible.all(|own| seen.holds(own.fact) == own.holds);
            if !is_visible {
                self.interrupted.push(order);
            } else if came_about && self.complete(&order, None).is_ok() {
                self.events.push(Event::Found { order: order.number });
            }
        }
        self.interrupted.is_empty()
    }
}

fn ground(step: &crate::plan::Step) -> GroundAction {
    GroundAction {
        action: step.action,
        arguments: step.arguments.clone(),
    }
}

/// Returns the facts that hold in exactly one of two states, sorted.
fn differences(before: &State, after: &State) -> Vec<Difference> {
    let gone = before.iter().filter(|fact| !after.holds(*fact));
    let new = after.iter().filter(|fact| !before.holds(*fact));
    let of = |now_holds: bool| move |fact: Fact| Difference { fact, now_holds };
    let mut all: Vec<Difference> = gone.map(of(false)).chain(new.map(of(true))).collect();
    all.sort_unstable();
    all
}
