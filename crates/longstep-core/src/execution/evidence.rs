//! Evidence: the facts that the stages and the end of the purpose rest on, and the looks, questions and stops for those
//! that were not observed.

use super::monitor::Completed;
use super::{Approval, Basis, Event, Execution, ExecutionError, Need, Phase, Stop, Trust, Unseen};
use longstep_model::effort;
use longstep_model::environment::ObservedFacts;
use longstep_model::model::{Moment, State, StateVariable, Wanted, support};
use longstep_verify::plan::Plan;
use longstep_verify::verify::{Progress, check, rules_at_end};

/// Maximum number of looks for facts that were not observed, before a stage and at the end.
const LOOKS: u32 = 8;

/// The looks since the last order ended.
#[derive(Debug, Clone, Default)]
pub(super) struct Looks {
    count: u32,
    last: Option<ObservedFacts>,
    /// True if the last look listed the same entities as the one before it.
    repeats: bool,
}

impl Looks {
    /// Records a look.
    pub(super) fn add(&mut self, observation: &ObservedFacts) {
        self.count += 1;
        self.repeats = self.last.as_ref().is_some_and(|last| last.lists_as(observation));
        self.last = Some(observation.clone());
    }

    fn may_show_more(&self) -> bool {
        self.count < LOOKS && !self.repeats
    }
}

/// Progress that rests on promises.
#[derive(Debug, Clone)]
pub(super) struct TrustedProgress {
    /// The progress before.
    before: Progress,
    /// The promises, with the values on which the progress rests.
    promises: Vec<StateVariable>,
    state: State,
    tick: u64,
}

/// The preference of one foundation over another: a promise that a look could test weighs more than all others.
fn weight_of(basis: Option<Basis>) -> u32 {
    match basis {
        None => 0,
        Some(Basis::Seen | Basis::Word) => 1,
        Some(Basis::Promised | Basis::Assumed | Basis::BeforePause) => 1_000,
    }
}

impl Execution {
    fn basis(&self, variable: StateVariable) -> Option<(Basis, Option<u64>)> {
        let reports = &self.settings.reports;
        self.knowledge.basis(&self.world, reports, variable)
    }

    /// Returns true if only a promise or an assumption says how a variable is, although a look could show it.
    pub(super) fn is_unproven(&self, variable: StateVariable) -> bool {
        let basis = self.basis(variable);
        basis.is_some_and(|(basis, _)| basis.is_open())
    }

    fn unseen(&self, variable: StateVariable) -> Option<Unseen> {
        let (basis, order) = self.basis(variable)?;
        Some(Unseen {
            what: variable.sentence(&self.world, self.state()),
            basis,
            order,
        })
    }

    fn all_unseen(&self, variables: &[StateVariable]) -> Vec<Unseen> {
        variables.iter().filter_map(|own| self.unseen(*own)).collect()
    }

    /// Records the progress that the believed state shows. What rests on promises is kept apart until it is seen.
    pub(super) fn confirm_progress(&mut self) {
        if self.purpose.stages.is_empty() {
            return;
        }
        let mut progress = self.with_events(|step| !step.is_refuted());
        let weight = |variable| u32::from(self.is_unproven(variable));
        self.unproven = progress.confirm(&self.world, &self.purpose, self.cursor.state(), &weight);
        self.progress = progress;
        for step in self.recent.iter_mut().filter(|step| !step.is_refuted()) {
            step.counted = true;
        }
    }

    /// Returns the progress with the events of the recent steps that it lacks, as far as they count.
    fn with_events(&self, counts: impl Fn(&Completed) -> bool) -> Progress {
        let mut progress = self.progress.clone();
        let state = self.cursor.state();
        for step in self.recent.iter().filter(|step| !step.counted && counts(step)) {
            let action = self.world.domain().action(step.action.action);
            let states = (&step.before, state);
            progress.step(&self.world, &self.purpose, states, action, &step.action.arguments);
        }
        progress
    }

    /// Takes back the progress since the `recent` steps.
    pub(super) fn take_back_recent(&mut self) {
        self.progress = self.base.clone();
        for step in &mut self.recent {
            step.counted = false;
        }
    }

    /// Keeps the progress, before another order that ends: what comes is seen in other states.
    pub(super) fn keep_progress(&mut self) {
        if std::mem::take(&mut self.seen_recent) {
            self.recent.clear();
            self.base = self.progress.clone();
        }
    }

    /// Returns true if a step that was performed would achieve a condition of a stage, if it had its effects.
    pub(super) fn promises_progress(&self) -> bool {
        if self.purpose.stages.is_empty() {
            return false;
        }
        let mut promised = self.with_events(|_| true);
        let events_only = promised.clone();
        promised.advance(&self.world, &self.purpose, self.cursor.state());
        promised != events_only
    }

    /// Sees to it that the progress through the stages was observed. Returns a need, or nothing to go on; the execution may
    /// have stopped.
    pub(super) fn prove_stages(&mut self) -> Option<Need> {
        if self.unproven.is_empty() {
            return None;
        }
        if !self.running.is_empty() {
            return Some(Need::Wait);
        }
        if self.looks.may_show_more() {
            self.due = true;
            return Some(Need::Observe);
        }
        let unproven = std::mem::take(&mut self.unproven);
        match self.settings.trust {
            Trust::Observed => self.ask_about(&unproven),
            Trust::Promised => {
                self.trusted.push(TrustedProgress {
                    before: self.progress.clone(),
                    promises: unproven.clone(),
                    state: self.state().clone(),
                    tick: self.knowledge.now(),
                });
                let unseen = self.all_unseen(&unproven);
                self.events.push(Event::Trusted { unseen });
                let state = self.state().clone();
                self.progress.advance(&self.world, &self.purpose, &state);
                self.base = self.progress.clone();
                self.recent.clear();
                None
            }
        }
    }

    /// Takes back the progress that rests on promises which an observation refutes.
    pub(super) fn take_back(&mut self, observation: &ObservedFacts) {
        let refuted = |own: &TrustedProgress| {
            own.promises.iter().any(|variable| {
                observation.shows(&self.world, *variable)
                    && !self.knowledge.is_touched_since(&self.world, *variable, own.tick)
                    && match variable {
                        StateVariable::Fact(fact) => own.state.holds(*fact) != self.state().holds(*fact),
                        StateVariable::Number(fluent) => own.state.number(*fluent) != self.state().number(*fluent),
                    }
            })
        };
        if let Some(place) = self.trusted.iter().position(refuted) {
            self.base = self.trusted[place].before.clone();
            self.progress = self.base.clone();
            self.trusted.truncate(place);
            self.recent.clear();
        }
    }

    /// Returns the variables on which the end of the purpose rests and that were not seen since the last order ended; none if
    /// there are too many to look through.
    fn rests_on(&self) -> Option<Vec<StateVariable>> {
        let moment = Moment {
            world: &self.world,
            state: self.state(),
        };
        let weight = |variable| weight_of(self.basis(variable).map(|(basis, _)| basis));
        let of_rule = |variable| {
            if self.knowledge.is_touched(&self.world, variable) {
                weight(variable)
            } else {
                0
            }
        };
        let rests = |wanted: &Wanted, weight: &dyn Fn(StateVariable) -> u32| {
            let found = support(moment, &wanted.condition, &mut wanted.bindings.clone(), weight);
            found.unwrap_or_default()
        };
        let spent = effort::within(effort::OPERATION, || {
            let mut all: Vec<StateVariable> = Vec::new();
            for wanted in &self.purpose.wanted {
                all.extend(rests(wanted, &weight));
            }
            for wanted in rules_at_end(self.world.domain(), &self.purpose) {
                all.extend(rests(&wanted, &of_rule));
            }
            all
        });
        let mut all = spent.result;
        all.sort_unstable();
        all.dedup();
        (!spent.exhausted).then_some(all)
    }

    /// Returns true if the purpose is achieved only if promises or assumptions are true that no look has shown. See the
    /// example of [`Execution::confirmed`].
    pub fn rests_on_promises(&self) -> bool {
        let rests_on = self.rests_on();
        rests_on.is_none_or(|all| all.iter().any(|own| self.is_unproven(*own)))
    }

    /// Returns true if the verifier accepts the empty plan for what is left of the purpose, in the believed state.
    fn is_reached(&self) -> bool {
        let here = self.here(self.state().clone());
        check(&here, Plan::default(), &self.rest_of_purpose())
            .into_verified()
            .is_ok()
    }

    /// Ends the execution if its purpose is achieved, and was seen to be. Returns a need, or nothing if it goes on or has
    /// ended.
    pub(super) fn conclude(&mut self) -> Option<Need> {
        if !self.is_reached() {
            self.suspicious = true;
            return None;
        }
        let Some(rests_on) = self.rests_on() else {
            self.no_plan(|failed| Stop::GaveUp {
                why: "the goal rests on too many facts to see to all of them".to_owned(),
                failed,
            });
            return None;
        };
        let is_visible = |own: &&StateVariable| !matches!(self.basis(**own), Some((Basis::Word, _)) | None);
        if rests_on.iter().any(|own| is_visible(&own)) && self.looks.may_show_more() {
            self.due = true;
            return Some(Need::Observe);
        }
        let unproven: Vec<StateVariable> = rests_on.iter().copied().filter(|own| self.is_unproven(*own)).collect();
        if self.settings.trust == Trust::Observed && !unproven.is_empty() {
            return self.ask_about(&unproven);
        }
        self.events.push(Event::Done {
            environment: self.environment(),
            unseen: self.all_unseen(&rests_on),
        });
        self.phase = Phase::Done;
        None
    }

    /// Asks a person about the first of these variables, or stops where nobody is asked.
    fn ask_about(&mut self, unproven: &[StateVariable]) -> Option<Need> {
        let unseen = self.all_unseen(unproven);
        match (self.settings.approval, unproven.first(), unseen.first()) {
            (Approval::Changes | Approval::EachStep, Some(variable), Some(first)) => {
                let (variable, first) = (*variable, first.clone());
                self.phase = Phase::Confirming(variable, first.clone());
                Some(Need::Confirm(first))
            }
            _ => {
                self.end(Stop::Unseen { unseen, denied: false });
                None
            }
        }
    }

    /// Records the answer of a person to [`Need::Confirm`].
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
    /// let mut execution = Execution::new(&plan, &Aim::Endings, Settings::default()).unwrap();
    /// assert_eq!(execution.confirmed(true), Err(ExecutionError::NothingProposed));
    /// let nothing = Observation::default(); // the camera is covered
    /// let mut questions = Vec::new();
    /// loop {
    ///     match execution.next_need() {
    ///         Need::Approve(proposal) => execution.approve(&proposal.id).unwrap(),
    ///         Need::Observe => execution.observed(&nothing).unwrap(),
    ///         Need::Perform(order) => execution.performed(order.number, None).unwrap(),
    ///         Need::Confirm(unseen) => {
    ///             questions.push(unseen.what);
    ///             execution.confirmed(true).unwrap();
    ///         }
    ///         Need::Done => break,
    ///         other => panic!("{other:?}"),
    ///     }
    /// }
    /// assert_eq!(questions, ["the hand does not hold the pen"]);
    /// ```
    ///
    /// # Errors
    ///
    /// If nothing was asked.
    pub fn confirmed(&mut self, holds: bool) -> Result<(), ExecutionError> {
        let Phase::Confirming(variable, unseen) = &self.phase else {
            return Err(ExecutionError::NothingProposed);
        };
        let (variable, unseen) = (*variable, unseen.clone());
        self.phase = Phase::Active;
        self.events.push(Event::Confirmed {
            what: unseen.what.clone(),
            holds,
        });
        if holds {
            self.knowledge.learned([variable], self.orders);
            self.confirm_progress();
        } else {
            self.end(Stop::Unseen {
                unseen: vec![unseen],
                denied: true,
            });
        }
        Ok(())
    }
}
