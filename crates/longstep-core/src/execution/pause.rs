//! Pauses: an execution that orders nothing for a while, and goes on from the observed world.

use super::evidence::Looks;
use super::{Event, Execution, ExecutionError, Need, Phase};
use longstep_model::environment::ObservedFacts;
use longstep_model::model::{Condition, Domain, Fact, PredicateId, StateVariable};

/// The pause of an execution.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Pause {
    /// There is none.
    #[default]
    Off,
    /// Nothing is ordered any more; the orders under way end first.
    Requested,
    /// Nothing is under way.
    Reached,
}

/// The state of knowledge after a pause, in which others may have used the robot.
#[derive(Debug, Clone, Default)]
pub(super) struct Meanwhile {
    /// True until the world was observed after the pause.
    pub(super) is_unknown: bool,
    /// True until the first difference after the pause was assessed: it is no failure of a step.
    pub(super) is_blameless: bool,
    /// The events of this run before a pause. A robot may count anew since then.
    events: Vec<Fact>,
}

impl Execution {
    /// Pauses the execution: nothing is ordered from now on. The orders under way end first, and their effects are observed;
    /// then the need is [`Need::Paused`]. Does nothing if the execution has ended. A stop ends a paused execution too.
    ///
    /// ```
    /// # use longstep_core::environment::{self, Observation};
    /// # use longstep_core::execution::{Aim, Approval, Event, Execution, Need, Settings};
    /// # use longstep_core::{domain, plan, verify::check_file};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// # let world = environment::parse(&household, "env.json", text).unwrap();
    /// # let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
    /// # let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    /// # let seen: Observation = serde_json::from_str(r#"{"states": {"<pen>": "on_something(<desk>)"}}"#).unwrap();
    /// let settings = Settings::default().with_approval(Approval::Never);
    /// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
    /// execution.observed(&seen).unwrap();
    /// let Need::Perform(order) = execution.next_need() else { panic!() };
    /// execution.pause();
    /// assert!(matches!(execution.next_need(), Need::Wait));
    /// execution.performed(order.number, None).unwrap();
    /// assert!(matches!(execution.next_need(), Need::Observe));
    /// execution.observed(&seen).unwrap();
    /// assert!(matches!(execution.next_need(), Need::Paused));
    ///
    /// execution.go_on();
    /// assert!(matches!(execution.next_need(), Need::Observe));
    /// assert!(matches!(execution.take_events().last(), Some(Event::Continued)));
    /// ```
    pub fn pause(&mut self) {
        if self.pause == Pause::Off && !self.is_ended() {
            self.pause = Pause::Requested;
        }
    }

    /// Returns true if the execution is paused and nothing is under way. See the example of [`Execution::pause`].
    pub fn is_paused(&self) -> bool {
        self.pause == Pause::Reached && !self.is_ended()
    }

    /// Ends a pause, in which others may have used the robot. The next need is an observation, before any order and any
    /// question. What was seen before the pause counts as not seen. What no observation of this robot shows, such as the position
    /// of a hand, is believed not to hold, if every precondition is stricter then; events of this run and outcomes of sensing
    /// are kept. A difference is not counted as a failure of a step. See the example of [`Execution::pause`].
    pub fn go_on(&mut self) {
        let before = std::mem::take(&mut self.pause);
        if before == Pause::Reached && !self.is_ended() {
            self.events.push(Event::Continued);
            self.look_again();
        }
    }

    /// Has the world observed before anything else, as after a time in which others used the robot.
    pub(super) fn look_again(&mut self) {
        self.pause = Pause::Off;
        self.meanwhile.is_unknown = true;
        self.meanwhile.is_blameless = true;
        self.keep_progress();
        self.knowledge.others_acted();
        self.looks = Looks::default();
        match std::mem::replace(&mut self.phase, Phase::Active) {
            Phase::Judging(observation) => self.earlier_look = Some(self.with_earlier_look(observation)),
            // The question is asked again if no look answers it.
            Phase::Confirming(..) => {}
            other => self.phase = other,
        }
        self.approved = None;
        self.announcement = None;
        self.due = true;
    }

    /// Returns the need of an execution that pauses; none if it does not.
    pub(super) fn pause_need(&mut self) -> Option<Need> {
        if self.pause == Pause::Off {
            return None;
        }
        if !self.running.is_empty() {
            return Some(Need::Wait);
        }
        if self.pause == Pause::Requested {
            self.reach_pause();
        }
        // The effects of its own orders are seen before others act.
        let is_unobserved = self.orders > 0 && self.due;
        Some(if is_unobserved { Need::Observe } else { Need::Paused })
    }

    fn reach_pause(&mut self) {
        self.pause = Pause::Reached;
        self.due |= !self.since.is_empty();
        self.events.push(Event::Paused);
    }

    /// Repeats a pause of a log.
    ///
    /// # Errors
    ///
    /// Orders under way, and an execution that is paused or has ended.
    pub(super) fn repeat_pause(&mut self) -> Result<(), ExecutionError> {
        if let Some(order) = self.running.first() {
            return Err(ExecutionError::UnknownOrder(order.number));
        }
        if self.is_ended() || self.pause == Pause::Reached {
            return Err(ExecutionError::Ended);
        }
        self.reach_pause();
        Ok(())
    }

    /// Brings the believed state to what is known after a pause, when the world is observed: a fact that no observation can
    /// show does not hold, unless a step could be ordered because of that.
    pub(super) fn forget_hidden(&mut self) {
        if !std::mem::take(&mut self.meanwhile.is_unknown) {
            return;
        }
        let domain = self.world.domain();
        let is_event = |fact: &Fact| domain.words(fact.predicate()).event;
        let is_hidden = |fact: &Fact| {
            domain.words(fact.predicate()).fluent
                && !is_event(fact)
                && !domain.is_sensed(fact.predicate())
                && !is_denied_before_a_step(domain, fact.predicate())
                && !ObservedFacts::can_show(&self.world, &self.settings.reports, StateVariable::Fact(*fact))
        };
        self.meanwhile.events = self.state().iter().filter(is_event).collect();
        let hidden: Vec<Fact> = self.state().iter().filter(is_hidden).collect();
        if hidden.is_empty() {
            return;
        }
        let mut state = self.state().clone();
        for fact in hidden {
            state.set(fact, false);
        }
        self.withdraw();
        self.cursor.correct(state);
        self.suspicious = true;
    }

    /// Returns the events of this run before a pause that a robot which counts anew does not report.
    pub(super) fn events_before_pause(&self) -> &[Fact] {
        &self.meanwhile.events
    }

    /// Forgets that these events were before a pause, because a step of this run decides them again.
    pub(super) fn decided_again(&mut self, mut is_changed: impl FnMut(Fact) -> bool) {
        self.meanwhile.events.retain(|event| !is_changed(*event));
    }
}

/// Returns true if the precondition of an action requires that a fact of this predicate does not hold.
fn is_denied_before_a_step(domain: &Domain, predicate: PredicateId) -> bool {
    let mut actions = domain.action_ids().map(|(_, action)| action);
    actions.any(|action| {
        let denies =
            |own: &Condition| matches!(own, Condition::Atom { atom, holds: false, .. } if atom.predicate == predicate);
        action.precondition.iter().any(denies)
    })
}
