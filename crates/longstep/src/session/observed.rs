//! Observations between instructions, and accepted plans that a robot carried out.

use std::ops::Range;

use super::{Event, OutOfTurn, Session, Stage};
use crate::environment::World;
use longstep_core::environment::{Observation, ObservationError, ObservedFacts};
use longstep_core::model::{Voice, change_text, changed_facts};

/// The result of an observation.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Observed {
    /// The differences from the world that the session expected, as sentences: "the milk is not in the fridge any more".
    pub changes: Vec<String>,
    /// The entities that the world does not have. Nothing is known about them.
    pub unknown: Vec<String>,
}

/// The reason why a session did not take an observation. The session is unchanged.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ObserveError {
    /// A statement that cannot be read in this world.
    #[error(transparent)]
    Observation(#[from] ObservationError),
    /// An instruction is in progress.
    #[error(transparent)]
    OutOfTurn(#[from] OutOfTurn),
    /// The plan does not come next among those that wait for a robot ([`Session::pending`]).
    #[error("plan {0} is not the next one that waits for a robot")]
    NotNext(usize),
}

impl ObserveError {
    /// Returns the error for a log with this observation.
    pub(super) fn in_a_log(self) -> OutOfTurn {
        match self {
            Self::OutOfTurn(error) => error,
            _ => OutOfTurn {
                what: "an observation",
                state: "is in a world that does not have it",
            },
        }
    }
}

/// An observation that the session took.
#[derive(Debug, Clone)]
pub(super) struct Taken {
    /// The number of accepted plans at that time.
    accepted: usize,
    /// The plan that a robot had carried out before.
    plan: Option<usize>,
    statements: Observation,
}

/// The accepted plans that wait for a robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Pending {
    /// The number of the first one.
    first: usize,
    /// True if the session's world does not contain their effects, because the world was observed before a robot
    /// carried them out. The next accepted plan begins in that world, so it takes their place.
    is_left: bool,
}

impl Session {
    /// Takes an observation between two instructions. The next instruction begins in the observed world; an entity that
    /// the observation does not list stays as it was expected.
    ///
    /// An instruction that led to no plan ends. Accepted plans stay accepted. If the last one can end in several ways,
    /// those that the observation contradicts are dropped, and [`Session::endings`] has the rest.
    ///
    /// ```
    /// use longstep::Planner;
    /// use longstep::dialogue::ConstraintKind;
    /// use longstep::session::{ModelFacts, Settings};
    ///
    /// let planner = Planner::shipped("household")?;
    /// let world = planner.world(r#"{"assets": ["<table>", "<fridge>"], "objects": ["<milk>"],
    ///     "object_states": {"<milk>": "inside_something(<fridge>)"}}"#)?;
    /// let model = ModelFacts::new("mine", ConstraintKind::JsonSchema);
    /// let mut session = planner.session(world, Settings::default(), model)?;
    /// let seen = serde_json::from_str(r#"{"states": {"<milk>": "on_something(<table>)"}}"#)?;
    /// let observed = session.observed(&seen)?;
    /// assert_eq!(observed.changes, ["the milk is not in the fridge any more", "the milk is on the table"]);
    /// assert_eq!(session.world().environment().object_states["<milk>"].as_slice(), ["on_something(<table>)"]);
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// A statement that the world does not have, or an instruction in progress.
    pub fn observed(&mut self, statements: &Observation) -> Result<Observed, ObserveError> {
        let observed = self.take_observation(None, statements)?;
        self.pending.is_left = !self.pending().is_empty();
        self.events.push(Event::Observed {
            statements: statements.clone(),
            changes: observed.changes.clone(),
        });
        Ok(observed)
    }

    /// Records that a robot carried out an accepted plan, the first of [`Session::pending`], with what was observed at
    /// the end. `reached` is false if the run stopped before the plan's goal: then the plan still waits.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put the pen on the shelf")?;
    /// # session.next_request(&mut EstimatedTokens::default())?;
    /// session.supply(&Reply::complete(r#"{"question": "", "goal": "put(pen, shelf)", "left_out": []}"#), 0.0)?;
    /// session.accept()?;
    /// assert_eq!(session.pending(), 0..1);
    /// assert_eq!(session.robot_world().environment().object_states["<pen>"].as_slice(), ["on_something(<desk>)"]);
    /// let seen = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<shelf>)"}}"#)?;
    /// assert!(session.carried_out(0, true, &seen)?.changes.is_empty());
    /// assert!(session.pending().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`Session::observed`]; and a plan that does not come next.
    pub fn carried_out(
        &mut self,
        number: usize,
        reached: bool,
        statements: &Observation,
    ) -> Result<Observed, ObserveError> {
        if self.pending().next() != Some(number) {
            return Err(ObserveError::NotNext(number));
        }
        let observed = self.take_observation(Some(number), statements)?;
        self.pending.first = number + usize::from(reached);
        self.pending.is_left = !self.pending().is_empty();
        self.events.push(Event::CarriedOut {
            number,
            reached,
            statements: statements.clone(),
            changes: observed.changes.clone(),
        });
        Ok(observed)
    }

    /// Returns the numbers of the accepted plans that wait for a robot, in order. See the example of
    /// [`Session::carried_out`].
    ///
    /// A plan waits until a robot has carried it out ([`Session::carried_out`]). Plans that a robot has not carried out
    /// when the world is observed wait until another plan is accepted, which begins in the observed world.
    pub fn pending(&self) -> Range<usize> {
        self.pending.first..self.accepted.len()
    }

    /// Returns the world as far as robots have brought it: before the accepted plans that wait, unless the world was
    /// observed since they were accepted. See the example of [`Session::carried_out`].
    pub fn robot_world(&self) -> &World {
        match self.accepted.get(self.pending.first) {
            Some(first) if !self.pending.is_left => &first.before,
            _ => &self.world,
        }
    }

    /// Returns true if the next plan that is accepted takes the place of those that wait for a robot: the world was observed
    /// since they were accepted, so it begins in a world without their effects. A robot should not be carrying one of them
    /// out then.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put the pen on the shelf")?;
    /// # session.next_request(&mut EstimatedTokens::default())?;
    /// session.supply(&Reply::complete(r#"{"question": "", "goal": "put(pen, shelf)", "left_out": []}"#), 0.0)?;
    /// session.accept()?;
    /// assert!(!session.replaces_pending());
    /// session.observed(&serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#)?)?;
    /// assert!(session.replaces_pending());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn replaces_pending(&self) -> bool {
        self.pending.is_left
    }

    /// Notes that a plan is about to be accepted.
    pub(super) fn extend_pending(&mut self) {
        if std::mem::take(&mut self.pending.is_left) {
            self.pending.first = self.accepted.len();
        }
    }

    /// Observes the world again after the last plan was taken back: what was seen since stays as it was seen.
    pub(super) fn observe_again(&mut self) {
        let count = self.accepted.len();
        self.pending.first = self.pending.first.min(count);
        self.pending.is_left &= !self.pending().is_empty();
        let since = self.observations.partition_point(|taken| taken.accepted <= count);
        for index in since..self.observations.len() {
            let taken = &self.observations[index];
            // The statements were read in a world of the same entities before.
            if let Ok((world, _)) = revised(self.basis(taken.plan), &taken.statements) {
                self.enter(world);
            }
            self.observations[index].accepted = count;
        }
    }

    fn take_observation(&mut self, plan: Option<usize>, statements: &Observation) -> Result<Observed, ObserveError> {
        let expected = self.world.clone();
        let unknown = match &self.stage {
            Stage::Ending(_) if plan.is_none() => self.narrow(statements)?,
            Stage::Idle | Stage::Stuck(..) | Stage::Ending(_) => {
                let (world, unknown) = revised(self.basis(plan), statements)?;
                self.enter(world);
                self.stage = Stage::Idle;
                unknown
            }
            _ => return Err(self.out_of_turn("an observation").into()),
        };
        self.observations.push(Taken {
            accepted: self.accepted.len(),
            plan,
            statements: statements.clone(),
        });
        Ok(Observed {
            changes: changes(&expected, &self.world),
            unknown,
        })
    }

    /// The world that an observation revises: after a run the one before the plan, because the robot may have stopped at
    /// any step of it.
    fn basis(&self, plan: Option<usize>) -> &World {
        match plan.and_then(|number| self.accepted.get(number)) {
            Some(accepted) => &accepted.before,
            None => &self.world,
        }
    }

    /// Goes on in a world. The rules in force, and the values that were mentioned, stay.
    fn enter(&mut self, mut world: World) {
        world.share_values(&self.world);
        world.set_prohibitions(self.world.prohibitions().to_vec());
        self.world = world;
    }

    /// Drops the possible endings of the last plan that an observation contradicts, unless it contradicts all of them.
    fn narrow(&mut self, statements: &Observation) -> Result<Vec<String>, ObserveError> {
        let Stage::Ending(left) = &self.stage else {
            return Ok(Vec::new());
        };
        let mut unknown = Vec::new();
        let (mut agreeing, mut all) = (Vec::new(), Vec::new());
        for ending in left {
            let (world, strangers) = revised(&ending.world, statements)?;
            unknown = strangers;
            let agrees = world.environment() == ending.world.environment();
            let mut ending = ending.clone();
            ending.world = world;
            if agrees {
                agreeing.push(ending.clone());
            }
            all.push(ending);
        }
        let mut left = if agreeing.is_empty() { all } else { agreeing };
        let rest = left.split_off(1);
        match (left.pop(), rest.is_empty()) {
            (Some(only), true) => {
                self.enter(only.world);
                self.stage = Stage::Idle;
            }
            (first, _) => self.stage = Stage::Ending(first.into_iter().chain(rest).collect()),
        }
        Ok(unknown)
    }
}

/// Returns the world after an observation, and the entities that it does not have.
fn revised(world: &World, statements: &Observation) -> Result<(World, Vec<String>), ObservationError> {
    let reports = ObservedFacts::reportable(world.domain());
    let observation = ObservedFacts::read(world, &reports, statements)?;
    let state = observation.revised(world, &world.state);
    Ok((world.after_state(&state), observation.unknown))
}

/// Returns the differences between two worlds of the same entities as sentences.
fn changes(before: &World, after: &World) -> Vec<String> {
    let mut facts = changed_facts(&before.state, &after.state);
    facts.sort_by_key(|own| own.now_holds);
    let mut changes: Vec<String> = facts.into_iter().map(|own| change_text(after, own)).collect();
    for (fluent, number) in after.state.numbers() {
        if before.state.number(*fluent) != Some(*number) {
            let name = Voice::Person.fluent(after, *fluent);
            changes.push(format!(
                "{name} is {} now",
                Voice::Person.number(after, *fluent, *number)
            ));
        }
    }
    changes
}
