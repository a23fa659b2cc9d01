//! A position in a verified plan: the steps that come next, given the observations so far.
//!
//! A [`Cursor`] holds no clock and calls no robot. It names the steps that can begin ([`Cursor::ready`]) and takes each
//! one as it completes, with the outcome of a sensing step ([`Cursor::complete`]). Branches, loops and lanes are
//! followed as the verifier followed them, so the predicted state at the end is one of the plan's endings.

mod program;
mod rest;
#[cfg(test)]
mod tests;

use std::sync::Arc;

use program::{Op, Program};
pub use rest::Rest;

use crate::plan::{LaneItem, Step, StepId};
use crate::verify::VerifiedPlan;
use longstep_model::model::{Fact, State, World, apply, ground};

/// A position in a [`VerifiedPlan`], with the state that the simulation predicts there.
///
/// The cursor owns all its data; clones share the plan. A cursor that was moved by some completions is restored by
/// the same completions.
///
/// # Example
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_verify::{plan, verify::check_file};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
///
/// let mut cursor = plan.cursor();
/// let mut seen = None;
/// while let Some(step) = cursor.next(seen)? {
///     println!("{}", cursor.step(step).explanation);
///     // A robot does the step here. A sensing step reveals one of `cursor.outcomes(step)`.
///     seen = cursor.outcomes(step).first().copied();
/// }
/// assert!(cursor.is_finished());
/// assert_eq!(*cursor.state(), plan.ending().after);
/// # Ok::<(), longstep_verify::cursor::CursorError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Cursor {
    plan: Arc<VerifiedPlan>,
    program: Arc<Program>,
    position: Position,
    /// The position behind the last completed step, before the facts of conditions were looked up.
    unsettled: Position,
    state: State,
    ready: Vec<StepId>,
    /// The step that [`Cursor::next`] returned and that is not completed.
    current: Option<StepId>,
}

/// A place in the program.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Position {
    at: usize,
    /// The iterations that are left of each counted loop, and the number of completed steps when this one began.
    loops: Vec<(u32, u64)>,
    /// The number of items that are done in each lane, inside of lanes.
    lanes: Vec<usize>,
    completed: u64,
}

/// A completion that does not fit the position; the cursor stays where it was.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_verify::{cursor::CursorError, plan, verify::check_file};
/// let checks = domain::shipped("household-checks").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<milk>"], "object_states": {"<milk>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&checks, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "detach_from_plane()",
///     "check_best_by_date()", "move_object()", "attach_to_plane()", "release_object()"], "object_name": "<milk>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// let mut cursor = plan.cursor();
/// let step = (0..4).map_while(|_| cursor.next(None).unwrap()).last().unwrap();
/// assert_eq!(cursor.complete(step, None), Err(CursorError::MissingOutcome(step)));
/// let expired = cursor.outcomes(step)[0];
/// assert_eq!(cursor.complete(step, Some(expired)), Ok(()));
/// ```
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum CursorError {
    /// The step is not among [`Cursor::ready`].
    #[error("step {} is not ready", .0.index() + 1)]
    NotReady(StepId),
    /// A sensing step was completed without an outcome.
    #[error("step {} is a sensing step: its outcome is missing", .0.index() + 1)]
    MissingOutcome(StepId),
    /// The observation is none of [`Cursor::outcomes`].
    #[error("step {} does not have this outcome", .0.index() + 1)]
    UnknownOutcome(StepId),
    /// The outcome contradicts a fact that the plan relies on: another outcome is known already.
    #[error("the outcome of step {} contradicts what was known before it", .0.index() + 1)]
    Contradiction(StepId),
}

impl VerifiedPlan {
    /// Returns a cursor at the beginning of the plan. See the [example](Cursor#example).
    pub fn cursor(&self) -> Cursor {
        Cursor::new(self)
    }
}

impl Cursor {
    /// Returns a cursor at the beginning of a plan. Copies the plan once; takes time linear in its length.
    pub fn new(plan: &VerifiedPlan) -> Self {
        let program = Program::new(plan.plan().body());
        let position = Position {
            at: 0,
            loops: vec![(0, 0); program.loops],
            lanes: Vec::new(),
            completed: 0,
        };
        let mut cursor = Self {
            state: plan.world().state.clone(),
            plan: Arc::new(plan.clone()),
            program: Arc::new(program),
            unsettled: position.clone(),
            position,
            ready: Vec::new(),
            current: None,
        };
        cursor.settle();
        cursor
    }

    /// Returns the plan.
    pub fn plan(&self) -> &VerifiedPlan {
        &self.plan
    }

    /// Returns the steps that can begin now: one outside of lanes, at most one per lane inside of them, none at the end.
    /// See the example of [`Cursor::complete`].
    pub fn ready(&self) -> &[StepId] {
        &self.ready
    }

    /// Returns true when no step is left. See the [example](Self#example).
    pub fn is_finished(&self) -> bool {
        self.ready.is_empty()
    }

    /// Returns the state that the simulation predicts at this position. See the [example](Self#example).
    pub fn state(&self) -> &State {
        &self.state
    }

    /// Returns the step with this id. See the [example](Self#example).
    ///
    /// # Panics
    ///
    /// If the id is of another plan and larger than every id of this one.
    pub fn step(&self, id: StepId) -> &Step {
        self.plan.plan().step(id)
    }

    /// Returns the outcomes of a sensing step, of which exactly one holds; none for any other step. See the
    /// example of [`CursorError`].
    pub fn outcomes(&self, id: StepId) -> Vec<Fact> {
        let step = self.step(id);
        let senses = &self.world().domain().action(step.action).senses;
        senses.iter().map(|atom| ground(atom, &step.arguments)).collect()
    }

    /// Completes the step that it returned last, with what that step observed, and returns the next one; none at the
    /// end. For a robot that does one step at a time; steps of lanes come one after the other. See the
    /// [example](Self#example).
    ///
    /// # Errors
    ///
    /// As for [`Cursor::complete`].
    pub fn next(&mut self, observed: Option<Fact>) -> Result<Option<StepId>, CursorError> {
        if let Some(done) = self.current {
            self.complete(done, observed)?;
        }
        self.current = self.ready.first().copied();
        Ok(self.current)
    }

    /// Moves on behind a step that was carried out. `observed` is the outcome of a sensing step; it may be omitted
    /// where the outcome is known already, and is ignored for other steps.
    ///
    /// ```
    /// # use longstep_model::{domain, environment};
    /// # use longstep_verify::{plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// let mut cursor = plan.cursor();
    /// for _ in 0..3 {
    ///     let step = cursor.ready()[0];
    ///     cursor.complete(step, None)?;
    ///     assert!(cursor.complete(step, None).is_err());
    /// }
    /// assert!(cursor.is_finished());
    /// # Ok::<(), longstep_verify::cursor::CursorError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When the step is not ready, or its outcome is missing, is none of its outcomes, or contradicts the state. The
    /// cursor then stays where it was.
    pub fn complete(&mut self, id: StepId, observed: Option<Fact>) -> Result<(), CursorError> {
        if !self.ready.contains(&id) {
            return Err(CursorError::NotReady(id));
        }
        let (plan, world) = (Arc::clone(&self.plan), self.world().clone());
        let step = plan.plan().step(id);
        let action = world.domain().action(step.action);
        let mut after = self.state.clone();
        apply(&world, &mut after, action, &step.arguments);
        let outcomes = self.outcomes(id);
        if let Some(first) = outcomes.first() {
            let known = outcomes.iter().find(|fact| after.holds(**fact)).copied();
            let outcome = match (observed, known) {
                (None, None) => return Err(CursorError::MissingOutcome(id)),
                (Some(seen), _) if !outcomes.contains(&seen) => return Err(CursorError::UnknownOutcome(id)),
                (Some(seen), Some(known)) if seen != known => return Err(CursorError::Contradiction(id)),
                (seen, known) => seen.or(known).unwrap_or(*first),
            };
            after.set(outcome, true);
        }
        self.state = after;
        self.current = None;
        self.position.completed += 1;
        self.pass(id);
        self.unsettled = self.position.clone();
        self.settle();
        Ok(())
    }

    /// Replaces the predicted state by an observed one, and looks up the facts of conditions behind the last completed
    /// step in it. The cursor does not check that the rest of the plan is valid from there.
    ///
    /// ```
    /// # use longstep_model::{domain, environment};
    /// # use longstep_verify::{plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// let mut cursor = plan.cursor();
    /// let mut seen = cursor.state().clone();
    /// let on_desk = world.state.iter().next().unwrap();
    /// seen.set(on_desk, false);
    /// cursor.correct(seen);
    /// assert!(!cursor.state().holds(on_desk) && cursor.ready().len() == 1);
    /// ```
    pub fn correct(&mut self, state: State) {
        self.state = state;
        self.position = self.unsettled.clone();
        self.settle();
    }

    fn world(&self) -> &World {
        self.plan.world()
    }

    /// Moves behind a completed step.
    fn pass(&mut self, id: StepId) {
        match &self.program.ops[self.position.at] {
            Op::Sense { holds, fails, .. } => {
                let first = self.outcomes(id).first().copied();
                let came = first.is_some_and(|fact| self.state.holds(fact));
                self.position.at = if came { *holds } else { *fails };
            }
            Op::Lanes(lanes) => {
                let places = self.position.lanes.iter_mut().zip(lanes);
                let is_at = |(place, lane): &(&mut usize, &Vec<LaneItem>)| {
                    lane.get(**place).and_then(LaneItem::step) == Some(id)
                };
                if let Some((place, _)) = places.into_iter().find(is_at) {
                    *place += 1;
                }
            }
            _ => self.position.at += 1,
        }
    }

    /// Follows the program to the next steps, or to its end.
    fn settle(&mut self) {
        self.ready.clear();
        let program = Arc::clone(&self.program);
        let position = &mut self.position;
        while let Some(op) = program.ops.get(position.at) {
            match op {
                Op::Step(id) | Op::Sense { step: id, .. } => {
                    self.ready.push(*id);
                    return;
                }
                Op::Holds { fact, holds, fails } => {
                    position.at = if self.state.holds(*fact) { *holds } else { *fails };
                }
                Op::Jump(to) => position.at = *to,
                Op::Repeat { number, times, end } => {
                    position.loops[*number] = (*times, position.completed);
                    position.at = if *times == 0 { *end } else { position.at + 1 };
                }
                Op::Again { number, begin } => {
                    let (left, completed) = &mut position.loops[*number];
                    *left -= 1;
                    // An iteration without steps changes nothing, and neither do those that follow it.
                    let goes_on = *left > 0 && position.completed > *completed;
                    *completed = position.completed;
                    position.at = if goes_on { *begin } else { position.at + 1 };
                }
                Op::Lanes(lanes) => {
                    if position.lanes.is_empty() {
                        position.lanes = vec![0; lanes.len()];
                    }
                    meet(lanes, &mut position.lanes);
                    let heads = lanes.iter().zip(&position.lanes).map(|(lane, place)| lane.get(*place));
                    self.ready.extend(heads.flatten().filter_map(LaneItem::step));
                    if !self.ready.is_empty() {
                        return;
                    }
                    position.lanes.clear();
                    position.at += 1;
                }
            }
        }
    }
}

/// Passes every synchronization that all its lanes have reached.
fn meet(lanes: &[Vec<LaneItem>], places: &mut [usize]) {
    loop {
        let waits = |lane: usize| lanes[lane].get(places[lane]).filter(|item| item.sync().is_some());
        let all_wait = |sync: &LaneItem| {
            (0..lanes.len()).all(|lane| waits(lane) == Some(sync) || !lanes[lane][places[lane]..].contains(sync))
        };
        let Some(met) = (0..lanes.len()).filter_map(waits).find(|sync| all_wait(sync)).cloned() else {
            return;
        };
        for (lane, place) in lanes.iter().zip(places.iter_mut()) {
            *place += usize::from(lane.get(*place) == Some(&met));
        }
    }
}
