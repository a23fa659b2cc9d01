//! Orders: steps that a robot performs, and how they end.

use rustc_hash::FxHashSet;

use super::evidence::Looks;
use super::monitor::Completed;
use super::{Approval, Event, Execution, ExecutionError, Need, StepOrder, Subject, Watch};
use crate::autonomy::Level;
use longstep_model::model::{Fact, Moment, StateVariable, apply, holds};
use longstep_search::search::GroundAction;
use longstep_verify::cursor::CursorError;
use longstep_verify::plan::{Step, StepId};

impl Execution {
    /// Orders a step, unless it has to be assessed first.
    pub(super) fn order(&mut self, id: StepId) -> Option<Need> {
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
        if std::mem::take(&mut self.unapproved) {
            self.propose(Subject::Plan);
            return None;
        }
        let order = StepOrder {
            number: self.orders + 1,
            step: id,
            lane: step.actor(domain),
            action: step.action,
            outcomes: self.cursor.outcomes(id),
            skills: self.settings.skills.values(
                &self.world,
                taught_step(self.taught, id),
                step.action,
                &step.arguments,
            ),
            arguments: step.arguments,
            explanation: step.explanation,
        };
        if let Some(stop) = self.refused_by_limits(&order) {
            self.end(stop);
            return None;
        }
        let is_approved = self.approved.take().as_ref() == Some(&order);
        let level = self.settings.autonomy.level(order.action);
        let is_asked = self.settings.approval == Approval::EachStep || level == Level::Approve;
        if is_asked && !is_approved {
            self.propose(Subject::Step(order));
            return None;
        }
        if level == Level::Announce && !is_approved && !self.was_announced(&order) {
            return Some(self.announce(order));
        }
        self.announcement = None;
        self.orders += 1;
        self.events.push(Event::ordered(&self.world, &order));
        self.running.push(order.clone());
        self.knowledge.touch(&self.world, &order);
        Some(if order.outcomes.is_empty() {
            Need::Perform(order)
        } else {
            Need::Sense(order)
        })
    }

    pub(super) fn is_forbidden(&self, step: &GroundAction) -> bool {
        self.forbidden.iter().any(|(own, _)| own == step)
    }

    fn take_running(&mut self, number: u64) -> Result<StepOrder, ExecutionError> {
        if self.is_ended() {
            return Err(ExecutionError::Ended);
        }
        let place = self.running.iter().position(|order| order.number == number);
        let place = place.ok_or(ExecutionError::UnknownOrder(number))?;
        Ok(self.running.remove(place))
    }

    /// Records that the robot says that it performed a step, with the outcome of a sensing step. See the
    /// [example](Self#example).
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
        self.due |= self.settings.watch == Watch::EachStep || self.suspicious || self.promises_progress();
        Ok(())
    }

    /// Moves on behind a step.
    pub(super) fn complete(&mut self, order: &StepOrder, outcome: Option<Fact>) -> Result<(), CursorError> {
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
        self.keep_progress();
        let action = self.world.domain().action(order.action);
        let mut changed = before.clone();
        let ground = GroundAction {
            action: order.action,
            arguments: order.arguments.clone(),
        };
        let changes = apply(&self.world, &mut changed, action, &order.arguments);
        self.decided_again(|event| changes.facts.iter().any(|own| own.fact == event));
        self.recent.push(Completed {
            action: ground.clone(),
            changes,
            before,
            shown: FxHashSet::default(),
            denied: FxHashSet::default(),
            counted: false,
        });
        self.cursor = cursor;
        self.since.push(ground.clone());
        self.worked.push(ground);
        self.ended(order);
        if outcome.is_some() {
            let outcomes = order.outcomes.iter().copied();
            self.knowledge.learned(outcomes.map(StateVariable::Fact), self.orders);
        }
        Ok(())
    }

    /// Notes that an order has ended: what it could have changed is not known until it is seen.
    fn ended(&mut self, order: &StepOrder) {
        self.knowledge.ended(&self.world, order);
        self.looks = Looks::default();
    }

    /// Records that the robot could not do a step. The world is observed then. The reason is cut after 500 characters.
    ///
    /// ```
    /// # use longstep_core::environment::{self, Observation};
    /// # use longstep_core::execution::{Aim, Approval, Execution, ExecutionError, Need, Resumed, Settings, Stop};
    /// # use longstep_core::{domain, goal, search, verify};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let purpose = goal::parse(&world, "put(pen, shelf)").unwrap().purpose(&world);
    /// # let outcome = search::solve(&world, &purpose, &search::Limits::default());
    /// # let search::Outcome::Solved { plan, .. } = outcome else { panic!() };
    /// # let plan = verify::check(&world, plan, &purpose).into_verified().unwrap();
    /// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
    /// let settings = Settings::default().with_approval(Approval::Never);
    /// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
    /// execution.observed(&seen).unwrap();
    /// let Need::Perform(order) = execution.next_need() else { panic!() };
    /// execution.failed(order.number, "the arm is stuck").unwrap();
    /// assert!(matches!(execution.next_need(), Need::Observe));
    /// execution.observed(&seen).unwrap();
    /// let Need::Perform(again) = execution.next_need() else { panic!() };
    /// assert_eq!((again.number, again.explanation), (2, order.explanation));
    /// ```
    ///
    /// # Errors
    ///
    /// An order that is not under way.
    pub fn failed(&mut self, number: u64, why: &str) -> Result<(), ExecutionError> {
        let order = self.take_running(number)?;
        self.keep_progress();
        self.ended(&order);
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
    pub(super) fn count_failure(&mut self, step: GroundAction, why: &str) {
        self.worked.retain(|own| *own != step);
        let failures = self.failures.entry(step.clone()).or_default();
        *failures += 1;
        if *failures > self.world.domain().action(step.action).retries && !self.is_forbidden(&step) {
            self.forbidden.push((step, why.to_owned()));
        }
    }
}

/// The step for which the skills file has values, of a plan that follows `taught` steps of the plan of the beginning; none
/// in a plan that was changed.
pub(super) fn taught_step(taught: Option<usize>, id: StepId) -> Option<StepId> {
    taught.map(|before| StepId::new(before + id.index()))
}

pub(super) fn ground(step: &Step) -> GroundAction {
    GroundAction {
        action: step.action,
        arguments: step.arguments.clone(),
    }
}
