//! An execution that is taken up again from its log.

use super::event::FORMAT;
use super::evidence::Looks;
use super::pause::Pause;
use super::written::{messages, written_outcome};
use super::{Aim, Approval, BeginError, Event, Execution, ExecutionError, Phase, Settings, Trust, Unseen};
use crate::autonomy::Autonomy;
use longstep_model::diagnostic::Diagnostics;
use longstep_model::environment;
use longstep_model::json::Path;
use longstep_model::model::{Domain, PredicateId, Prohibition, World};
use longstep_search::goal::{self, Goal, GoalError};
use longstep_verify::plan::{PlanFile, Step, TaskCohesion, TreeError, Violation, read_tree, resolve};
use longstep_verify::skill::Skills;
use longstep_verify::verify::{Purpose, VerifiedPlan, bind_tree, check};

/// The reason why an execution cannot be taken up again.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ResumeError {
    /// The log does not begin with [`Event::Began`], or another version wrote it.
    #[error("the log does not begin as this version writes it")]
    Beginning,
    /// The log is of another domain.
    #[error("the log is of the domain `{0}`")]
    Domain(String),
    /// The domain has no such predicate.
    #[error("the domain has no predicate `{0}`")]
    Predicate(String),
    /// The environment cannot be read.
    #[error("the environment of the log cannot be read: {0}")]
    Environment(Diagnostics),
    /// The plan cannot be read.
    #[error("the plan of the log cannot be read: {0}")]
    Plan(#[from] TreeError),
    /// The plan is not valid in the environment: the domain has changed.
    #[error("the plan of the log is not valid any more: {0}")]
    Invalid(String),
    /// The skills cannot be read.
    #[error("the skills of the log cannot be read: {0}")]
    Skills(Diagnostics),
    /// The levels and limits cannot be read.
    #[error("the levels and limits of the log cannot be read: {0}")]
    Autonomy(Diagnostics),
    /// The execution cannot begin.
    #[error(transparent)]
    Begin(#[from] BeginError),
    /// The goal or a constraint cannot be read.
    #[error("the goal of the log cannot be read: {0}")]
    Goal(#[from] GoalError),
    /// An event does not follow from those before it: the domain or the program has changed, or the log is damaged.
    #[error("event {0} of the log does not follow from those before it")]
    Event(usize),
    /// The execution has ended, and not because of a request or a failure of the robot.
    #[error("the execution has ended; there is nothing to resume")]
    Ended,
}

/// Settings with which an execution is resumed: they count where they are stricter than those of its log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Resumed {
    /// When a person is asked; none for the setting of the log.
    pub approval: Option<Approval>,
    /// The evidence that progress and the end need; none for the setting of the log.
    pub trust: Option<Trust>,
}

impl Resumed {
    /// Sets when a person is asked; none for the setting of the log.
    #[must_use]
    pub fn with_approval(self, approval: impl Into<Option<Approval>>) -> Self {
        Self {
            approval: approval.into(),
            ..self
        }
    }

    /// Sets the evidence that progress and the end need; none for the setting of the log.
    #[must_use]
    pub fn with_trust(self, trust: impl Into<Option<Trust>>) -> Self {
        Self {
            trust: trust.into(),
            ..self
        }
    }
}

impl Execution {
    /// Takes up an execution again from its log, after a crash, a stop at a request or a failure of the robot.
    ///
    /// An execution that stopped because the robot failed goes on too. What was done is known. A step that was under way is
    /// unknown: the next need is an observation, which shows whether it was done, or else a person is asked. Events that
    /// the log lacks are returned by [`Execution::take_events`]. Takes time proportional to the length of the log.
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
    /// execution.observed(&seen).unwrap();
    /// let Need::Perform(order) = execution.next_need() else { panic!() };
    /// let log = execution.take_events(); // on disk before the robot moves, and the program crashes
    ///
    /// let mut resumed = Execution::resume(&household, &log, Resumed::default()).unwrap();
    /// assert!(matches!(resumed.next_need(), Need::Observe));
    /// resumed.observed(&seen).unwrap();
    /// // No observation shows where the hand is: a person has to say whether it moved.
    /// let Need::Judge(interrupted) = resumed.next_need() else { panic!() };
    /// assert_eq!(interrupted, order);
    /// resumed.judged(order.number, true).unwrap();
    /// assert!(matches!(resumed.next_need(), Need::Perform(_)));
    /// ```
    ///
    /// # Errors
    ///
    /// A log that cannot be read, or whose execution has ended otherwise.
    pub fn resume(domain: &Domain, log: &[Event], resumed: Resumed) -> Result<Self, ResumeError> {
        let mut execution = Self::replay(domain, log)?;
        let is_stricter = resumed.trust.is_some_and(|own| own > execution.settings.trust);
        let mut lacked = std::mem::take(&mut execution.events);
        let goes_on = is_stricter && execution.take_back_end(&mut lacked);
        execution.events = lacked;
        if execution.is_ended() && execution.suspended.is_none() && !goes_on {
            // The log may lack the end that follows from its last event.
            return if execution.events.is_empty() {
                Err(ResumeError::Ended)
            } else {
                Ok(execution)
            };
        }
        let under_way = execution.unknown();
        let approval = resumed.approval.filter(|own| *own > execution.settings.approval);
        let trust = resumed.trust.filter(|own| *own > execution.settings.trust);
        execution.interrupt(Resumed { approval, trust });
        execution.events.push(Event::Interrupted {
            under_way,
            approval,
            trust,
        });
        Ok(execution)
    }

    /// Repeats the events of a log; the execution is where it was at the last of them. To go on from there, use
    /// [`Execution::resume`].
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
    /// execution.observed(&seen).unwrap();
    /// execution.next_need();
    /// let repeated = Execution::replay(&household, &execution.take_events()).unwrap();
    /// assert_eq!((repeated.running(), repeated.state()), (execution.running(), execution.state()));
    /// ```
    ///
    /// # Errors
    ///
    /// A log that cannot be read.
    pub fn replay(domain: &Domain, log: &[Event]) -> Result<Self, ResumeError> {
        let mut execution = begun(domain, log.first())?;
        let mut repeated = execution.take_events();
        for (index, event) in log.iter().enumerate().skip(1) {
            execution.repeat(event, index, &mut repeated)?;
            if let Some(Event::Interrupted { trust: Some(_), .. }) = log.get(repeated.len().saturating_sub(1)) {
                execution.take_back_end(&mut repeated);
            }
            let known = repeated.len().min(log.len());
            if repeated[..known] != log[..known] {
                let first = (0..known).find(|index| repeated[*index] != log[*index]);
                return Err(ResumeError::Event(first.unwrap_or(index) + 1));
            }
        }
        if repeated.len() < log.len() {
            return Err(ResumeError::Event(repeated.len() + 1));
        }
        execution.events = repeated.split_off(log.len());
        Ok(execution)
    }

    /// Repeats one event. Events that follow from others are there already, or come with the next input.
    fn repeat(&mut self, event: &Event, index: usize, repeated: &mut Vec<Event>) -> Result<(), ResumeError> {
        let wrong = |_: ExecutionError| ResumeError::Event(index + 1);
        if index < repeated.len() {
            return Ok(());
        }
        match event {
            Event::Approved { proposal } => {
                self.next_need();
                self.approve(proposal).map_err(wrong)?;
            }
            Event::Refused => {
                self.next_need();
                self.refuse().map_err(wrong)?;
            }
            Event::Performed { order, outcome } => {
                let own = self.running.iter().find(|own| own.number == *order);
                let outcomes = own.map(|own| own.outcomes.clone()).unwrap_or_default();
                let is = |text: &String| {
                    let mut outcomes = outcomes.iter().copied();
                    outcomes.find(|fact| written_outcome(&self.world, *fact) == *text)
                };
                let outcome = outcome.as_ref().and_then(is);
                self.performed(*order, outcome).map_err(wrong)?;
            }
            Event::Failed { order, why } => self.failed(*order, why).map_err(wrong)?,
            Event::Observed { statements } => {
                let looks_again = self.cursor.is_finished() || !self.unproven.is_empty();
                if !self.due && self.running.is_empty() && looks_again {
                    self.next_need();
                }
                self.observed(statements).map_err(wrong)?;
            }
            Event::Judged { order, done } => self.judged(*order, *done).map_err(wrong)?,
            Event::Confirmed { holds, .. } => {
                self.next_need();
                self.confirmed(*holds).map_err(wrong)?;
            }
            Event::Ordered { order, .. } => {
                // It was ordered, so the time of its announcement was over.
                drop(self.announced(*order));
                self.next_need();
            }
            Event::Paused => self.repeat_pause().map_err(wrong)?,
            Event::Continued => self.go_on(),
            Event::Interrupted { approval, trust, .. } => {
                self.interrupt(Resumed {
                    approval: *approval,
                    trust: *trust,
                });
                self.events.push(event.clone());
            }
            Event::Stopped { why, .. } => match why.strip_prefix(super::need::ROBOT_FAILED) {
                Some(why) => self.robot_failed(why),
                None => self.stop(why),
            },
            _ => {
                self.next_need();
            }
        }
        repeated.append(&mut self.events);
        Ok(())
    }

    /// Takes back an end that no log has yet and that rests on promises, where they do not count any more. Returns true if there
    /// was one.
    fn take_back_end(&mut self, events: &mut Vec<Event>) -> bool {
        let rests_on_promises =
            |event: &Event| matches!(event, Event::Done { unseen, .. } if unseen.iter().any(Unseen::is_open));
        let taken = events.pop_if(|event| rests_on_promises(event)).is_some();
        if taken {
            self.phase = Phase::Active;
        }
        taken
    }

    /// Marks the orders under way as unknown, and has the world observed. A stop because of the robot is over then. These
    /// settings are in force from now on.
    fn interrupt(&mut self, resumed: Resumed) {
        if let Some(phase) = self.suspended.take() {
            self.phase = *phase;
        }
        if self.is_ended() {
            return;
        }
        if self.is_paused() {
            self.look_again();
        }
        self.pause = Pause::Off;
        // Nobody has approved the plan of a run that nobody was asked about.
        self.unapproved |= self.settings.approval == Approval::Never && resumed.approval.is_some();
        self.settings.approval = resumed.approval.unwrap_or(self.settings.approval);
        self.settings.trust = resumed.trust.unwrap_or(self.settings.trust);
        self.keep_progress();
        self.interrupted.append(&mut self.running);
        match std::mem::replace(&mut self.phase, Phase::Active) {
            Phase::Judging(observation) => {
                self.knowledge
                    .observed(&observation, self.orders, &self.world, &self.interrupted);
                self.earlier_look = Some(self.with_earlier_look(observation));
            }
            Phase::Confirming(..) => {}
            other => self.phase = other,
        }
        for order in &self.interrupted {
            self.knowledge.ended(&self.world, order);
        }
        self.looks = Looks::default();
        self.approved = None;
        self.announcement = None;
        self.due = true;
    }
}

/// Returns the execution that begins with this event.
fn begun(domain: &Domain, event: Option<&Event>) -> Result<Execution, ResumeError> {
    let Some(Event::Began {
        format: FORMAT,
        domain: name,
        environment,
        plan,
        goal,
        constraints,
        approval,
        trust,
        watch,
        changes,
        reports,
        skills,
        autonomy,
    }) = event
    else {
        return Err(ResumeError::Beginning);
    };
    if *name != domain.name {
        return Err(ResumeError::Domain(name.clone()));
    }
    let predicate = |name: &String| {
        let place = domain.predicates.iter().position(|own| own.name == *name);
        place
            .map(PredicateId::new)
            .ok_or_else(|| ResumeError::Predicate(name.clone()))
    };
    let reports = reports.iter().map(predicate).collect::<Result<_, _>>()?;
    let world =
        environment::read(domain, environment, "log", "", &Path::default()).map_err(ResumeError::Environment)?;
    let written = read_tree(plan, Vec::new(), &Path::key("plan"))?;
    let file = PlanFile::from(TaskCohesion {
        task_tree: Some(written),
        ..TaskCohesion::default()
    });
    let mut world = file.world_of(&world).into_owned();
    if let Some(goal) = goal {
        world.add_values(goal);
    }
    let world = constrained(&world, constraints)?;
    let aim = Aim::from(goal.clone());
    let plan = verified(&world, &file.task_cohesion, aim.goal(&world).as_ref())?;
    let settings = Settings {
        approval: *approval,
        trust: *trust,
        watch: *watch,
        changes: *changes,
        reports,
        skills: Skills::from_value(domain, skills.clone()).map_err(ResumeError::Skills)?,
        autonomy: Autonomy::from_value(domain, autonomy).map_err(ResumeError::Autonomy)?,
    };
    Ok(Execution::new(&plan, &aim, settings)?)
}

fn constrained(world: &World, constraints: &[(String, bool)]) -> Result<World, ResumeError> {
    let mut all: Vec<Prohibition> = Vec::new();
    for (written, standing) in constraints {
        let mut values = world.clone();
        values.add_values(written);
        let own = goal::parse(&values, written)?.purpose(&values).prohibitions;
        let own = own.into_iter().map(|own| if *standing { own.standing() } else { own });
        all.extend(own);
    }
    Ok(world.with_prohibitions(all))
}

fn verified(world: &World, cohesion: &TaskCohesion, goal: Option<&Goal>) -> Result<VerifiedPlan, ResumeError> {
    let bound = bind_tree(world, &resolve(world, cohesion), None);
    let invalid = |violations: &[Violation], steps: &[Step]| {
        ResumeError::Invalid(messages(world, violations, steps, None).join("; "))
    };
    let (plan, _) = bound.map_err(|violations| invalid(&violations, &[]))?;
    // The rules that the goal waives do not bind the plan.
    let purpose = Purpose {
        prohibitions: Vec::new(),
        ..goal.map_or_else(Purpose::default, |goal| goal.purpose(world))
    };
    let report = check(world, plan, &purpose);
    report
        .into_verified()
        .map_err(|report| invalid(&report.violations, report.plan.steps()))
}
