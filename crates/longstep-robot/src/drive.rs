//! An execution driven on a robot.

use std::time::{Duration, Instant};

use longstep_core::environment::{ObservedFacts, World};
use longstep_core::execution::{Event, Execution, Need, Proposal, StepOrder as Wanted, Stop, Unseen};
use longstep_core::model::PredicateId;

use crate::control::RunControl;
use crate::error::RobotError;
use crate::order::{ArgumentValue, Order};
use crate::robot::{Feedback, Handle, Progress, Robot};
use crate::scope::Scope;

/// The longest wait between two looks at the robot and at the request to stop.
const WAIT: Duration = Duration::from_millis(20);

/// The people and the log beside a run. See the example of [`drive`].
pub trait Watcher {
    /// Keeps events. The robot is not asked to move before this returns.
    ///
    /// # Errors
    ///
    /// The reason why an event could not be kept: the run stops then.
    fn record(&mut self, execution: &Execution, events: &[Event]) -> Result<(), String>;

    /// Decides about a proposal; none to stop.
    fn approve(&mut self, execution: &Execution, proposal: &Proposal) -> Option<bool>;

    /// Decides whether a step that was under way at a crash was done; none to stop.
    fn judge(&mut self, execution: &Execution, order: &Wanted) -> Option<bool>;

    /// Decides whether something is so that no look has shown; none to stop.
    fn confirm(&mut self, execution: &Execution, unseen: &Unseen) -> Option<bool>;

    /// Takes the feedback of a step that is under way.
    fn feedback(&mut self, _: &Wanted, _: &Feedback) {}

    /// Takes the error of the robot that stops the run.
    fn robot_failed(&mut self, _: &RobotError) {}
}

/// An order that the robot performs, or that waits until the robot can take it.
struct Running {
    wanted: Wanted,
    handle: Option<Handle>,
}

/// Returns the predicates that a robot reports besides the states of entities.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{Robot, Sim, SimOptions, reports};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"]}"#).unwrap();
/// let sim = Sim::new(world.clone(), &SimOptions::default())?;
/// assert_eq!(reports(&sim, &world)?.len(), sim.describe().reports.len());
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
///
/// # Errors
///
/// The name of a predicate that the domain does not have, or that this robot cannot report: environments have words for
/// it, no action changes it, or it is an event and the robot does not count events.
pub fn reports(robot: &dyn Robot, world: &World) -> Result<Vec<PredicateId>, RobotError> {
    let domain = world.domain();
    let mut reportable = ObservedFacts::reportable(domain);
    reportable.retain(|id| robot.describe().counts_events || !domain.words(*id).event);
    let find = |name: &String| {
        let named = |id: &PredicateId| domain.predicate(*id).name == *name;
        reportable.iter().copied().find(named).ok_or_else(|| {
            let names: Vec<&str> = reportable
                .iter()
                .map(|id| domain.predicate(*id).name.as_str())
                .collect();
            RobotError::Protocol {
                reason: format!(
                    "it reports `{name}`; a robot of this domain can report {}",
                    names.join(", ")
                ),
            }
        })
    };
    robot.describe().reports.iter().map(find).collect()
}

/// How far an execution was driven.
#[derive(Debug, Clone, PartialEq)]
pub enum Driven {
    /// The purpose is achieved in the observed world.
    Done,
    /// The execution has stopped, and so has the robot.
    Stopped(Stop),
    /// The execution is paused at a request, and no order is under way. [`drive`] continues it.
    Paused,
}

impl Driven {
    /// Returns the reason of a stop; none for another end.
    pub fn into_stop(self) -> Option<Stop> {
        match self {
            Self::Stopped(stop) => Some(stop),
            Self::Done | Self::Paused => None,
        }
    }
}

/// Runs an execution on a robot until it is done, stopped or paused. The robot is stopped before the execution is.
///
/// Blocks the thread. A [`RunControl`] stops the run from another thread: at the latest after 20 ms, or after the robot's
/// timeout for observations and stops. It also pauses the run: orders under way end, and their effects are observed. A
/// [`Watcher`] may end its wait for a person with no answer then; the question is asked again afterwards.
///
/// A paused execution continues with another call after [`RunControl::resume`], on the same robot or on one in the same world.
/// Another execution may use the robot in between. The world is observed before anything else then, and
/// [`Robot::begin_plan`] is called: a robot that counts events begins to count anew.
///
/// # Example
///
/// ```
/// use longstep_core::execution::{Aim, Approval, Event, Execution, StepOrder, Proposal, Settings, Unseen};
/// use longstep_core::{domain, environment, plan, verify::check_file};
/// use longstep_robot::{Driven, RunControl, Sim, SimOptions, Watcher, drive, reports};
///
/// /// Keeps events in memory, and answers no question.
/// struct Alone(Vec<Event>);
///
/// impl Watcher for Alone {
///     fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
///         self.0.extend_from_slice(events);
///         Ok(())
///     }
///     fn approve(&mut self, _: &Execution, _: &Proposal) -> Option<bool> { None }
///     fn judge(&mut self, _: &Execution, _: &StepOrder) -> Option<bool> { None }
///     fn confirm(&mut self, _: &Execution, _: &Unseen) -> Option<bool> { None }
/// }
///
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
///
/// let mut sim = Sim::new(world.clone(), &SimOptions::default())?;
/// let settings = Settings::default().with_approval(Approval::Never).with_reports(reports(&sim, &world)?);
/// let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
/// let (mut watcher, control) = (Alone(Vec::new()), RunControl::of(&sim));
/// control.pause();
/// assert_eq!(drive(&mut execution, &mut sim, &mut watcher, &control), Driven::Paused);
/// control.resume();
/// assert_eq!(drive(&mut execution, &mut sim, &mut watcher, &control), Driven::Done);
/// assert!(matches!(watcher.0.last(), Some(Event::Done { .. })));
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
pub fn drive(
    execution: &mut Execution,
    robot: &mut dyn Robot,
    watcher: &mut dyn Watcher,
    control: &RunControl,
) -> Driven {
    let mut driver = Driver {
        execution,
        robot,
        watcher,
        control,
        running: Vec::new(),
        announced: None,
        is_unanswered: false,
    };
    driver.run()
}

struct Driver<'a> {
    execution: &'a mut Execution,
    robot: &'a mut dyn Robot,
    watcher: &'a mut dyn Watcher,
    control: &'a RunControl,
    running: Vec<Running>,
    /// The time of the last announcement of a step.
    announced: Option<Instant>,
    /// True if the run stops because a question has no answer.
    is_unanswered: bool,
}

impl Driver<'_> {
    /// Stops because a question has no answer, unless a request ended the wait for it.
    fn leave(&mut self) {
        if self.control.is_stop_requested() {
            return;
        }
        // After a pause it is asked again.
        if !self.control.is_pause_requested() {
            self.is_unanswered = true;
            self.control.stop();
        }
    }

    /// Hands on a request to stop, to pause or to go on.
    fn follow_control(&mut self) {
        if self.control.is_stop_requested() {
            // The switch has stopped the robot already; this waits for its confirmation.
            let confirmed = self.robot.stop();
            self.execution.stop(match (self.is_unanswered, confirmed) {
                (false, Ok(())) => "stopped at a request",
                (false, Err(_)) => "stopped at a request; the robot did not confirm it",
                (true, Ok(())) => "stopped, since nobody answered",
                (true, Err(_)) => "stopped, since nobody answered; the robot did not confirm it",
            });
        } else if self.control.is_pause_requested() {
            self.execution.pause();
        } else {
            if self.execution.is_paused() {
                self.robot.begin_plan(self.execution.world());
            }
            self.execution.go_on();
        }
    }

    fn run(&mut self) -> Driven {
        loop {
            self.follow_control();
            let need = self.execution.next_need();
            if !self.record() {
                continue;
            }
            match need {
                Need::Perform(order) | Need::Sense(order) => {
                    self.running.push(Running {
                        wanted: order,
                        handle: None,
                    });
                    self.start();
                }
                Need::Observe => self.observe(),
                Need::Approve(proposal) => match self.watcher.approve(self.execution, &proposal) {
                    // Refused by the execution only if something else is proposed, which is asked for then.
                    Some(true) => drop(self.execution.approve(&proposal.id)),
                    Some(false) => self.refuse(),
                    None => self.leave(),
                },
                Need::Judge(order) => match self.watcher.judge(self.execution, &order) {
                    Some(done) => {
                        if let Err(error) = self.execution.judged(order.number, done) {
                            self.fail(&error.to_string());
                        }
                    }
                    None => self.leave(),
                },
                Need::Confirm(unseen) => match self.watcher.confirm(self.execution, &unseen) {
                    Some(holds) => {
                        if let Err(error) = self.execution.confirmed(holds) {
                            self.fail(&error.to_string());
                        }
                    }
                    None => self.leave(),
                },
                Need::Announce(order) => self.announce(&order),
                Need::Wait => self.wait(),
                Need::Paused => return Driven::Paused,
                Need::Done => return Driven::Done,
                Need::Stopped(stop) => {
                    // Nothing is under way unless the robot was stopped before; a second stop does nothing.
                    if !self.running.is_empty() {
                        drop(self.robot.stop());
                    }
                    return Driven::Stopped(stop);
                }
                other => self.fail(&format!("unexpected need: {other:?}")),
            }
        }
    }

    /// Has the new events kept. Returns false if that failed: then the execution has stopped, and nothing moves.
    fn record(&mut self) -> bool {
        let events = self.execution.take_events();
        if events.is_empty() {
            return true;
        }
        if events.iter().any(|event| matches!(event, Event::Announced { .. })) {
            self.announced = Some(Instant::now());
        }
        let Err(why) = self.watcher.record(self.execution, &events) else {
            return true;
        };
        let was_ended = self.execution.is_ended();
        drop(self.robot.stop());
        self.execution
            .robot_failed(&format!("the log could not be written: {why}"));
        // A log that fails for good must not keep the run alive.
        drop(self.execution.take_events());
        was_ended
    }

    fn refuse(&mut self) {
        drop(self.robot.stop());
        drop(self.execution.refuse());
    }

    /// Stops everything because the robot failed.
    fn fail(&mut self, why: &str) {
        drop(self.robot.stop());
        if !self.control.is_stop_requested() {
            self.execution.robot_failed(why);
        }
    }

    /// Stops everything because of an error of the robot.
    fn fail_robot(&mut self, error: &RobotError) {
        if !self.control.is_stop_requested() {
            self.watcher.robot_failed(error);
        }
        self.fail(&error.to_string());
    }

    /// Starts the orders that the robot can take now.
    fn start(&mut self) {
        let limit = self.robot.describe().parallel;
        for index in 0..self.running.len() {
            let busy = self.running.iter().filter(|own| own.handle.is_some()).count();
            if self.running[index].handle.is_some() || busy >= limit {
                continue;
            }
            let order = order_of(self.execution.world(), &self.running[index].wanted);
            match self.robot.start(&order) {
                Ok(handle) => self.running[index].handle = Some(handle),
                Err(error) if error.is_final() => return self.fail_robot(&error),
                Err(error) => {
                    let number = self.running.remove(index).wanted.number;
                    return self.failed(number, &error.to_string());
                }
            }
        }
    }

    fn failed(&mut self, number: u64, why: &str) {
        if let Err(error) = self.execution.failed(number, why)
            && !self.execution.is_ended()
        {
            self.fail(&error.to_string());
        }
    }

    fn observe(&mut self) {
        match self.robot.observe(&Scope::All) {
            Ok(observation) => {
                if let Err(error) = self.execution.observed(&observation) {
                    self.fail(&error.to_string());
                }
            }
            Err(error) => self.fail_robot(&error),
        }
    }

    /// Waits a little until the time after an announcement is over, so that a request comes before the step.
    fn announce(&mut self, order: &Wanted) {
        let whole = self.execution.settings().autonomy.announcement();
        let passed = self.announced.map_or(Duration::ZERO, |since| since.elapsed());
        match whole.checked_sub(passed).filter(|left| !left.is_zero()) {
            // An order that is gone was withdrawn: the next need says what follows.
            None => drop(self.execution.announced(order.number)),
            Some(left) if self.running.is_empty() => {
                let limit = left.min(WAIT);
                let begun = Instant::now();
                self.robot.wait(limit);
                std::thread::sleep(limit.saturating_sub(begun.elapsed()));
            }
            Some(_) => self.wait(),
        }
    }

    /// Polls the orders under way until one of them ends.
    fn wait(&mut self) {
        self.start();
        let mut ended = Vec::new();
        for index in 0..self.running.len() {
            let Some(handle) = self.running[index].handle else {
                continue;
            };
            match self.robot.poll(handle) {
                Ok(Progress::Running(feedback)) => {
                    if let Some(feedback) = feedback {
                        self.watcher.feedback(&self.running[index].wanted, &feedback);
                    }
                }
                Ok(end) => ended.push((index, end)),
                Err(error) => return self.fail_robot(&error),
            }
        }
        if ended.is_empty() {
            return self.robot.wait(WAIT);
        }
        for (index, end) in ended.into_iter().rev() {
            let wanted = self.running.remove(index).wanted;
            match end {
                Progress::Done { outcome } => {
                    let outcome = outcome.and_then(|outcome| wanted.outcomes.get(outcome).copied());
                    if let Err(error) = self.execution.performed(wanted.number, outcome) {
                        return self.fail(&error.to_string());
                    }
                }
                Progress::Failed { reason } => self.failed(wanted.number, &reason),
                Progress::Running(_) => {}
            }
        }
    }
}

/// Returns a step as a robot receives it.
pub fn order_of(world: &World, wanted: &Wanted) -> Order {
    let domain = world.domain();
    let identifiers = wanted
        .arguments
        .iter()
        .map(|entity| world.entity(*entity).identifier.clone());
    let step = usize::try_from(wanted.number).unwrap_or(usize::MAX);
    let mut order = Order::new(step, &domain.action(wanted.action).name, identifiers);
    order.lane = wanted.lane.map(|lane| world.entity(lane).identifier.clone());
    order.skills = wanted.skills.clone();
    order.outcomes = wanted
        .outcomes
        .iter()
        .map(|fact| {
            let words = domain
                .arguments(*fact)
                .map(|entity| world.entity(entity).identifier.as_str());
            let name = domain.predicate(fact.predicate()).name.as_str();
            let words: Vec<&str> = [name].into_iter().chain(words).collect();
            format!("({})", words.join(" "))
        })
        .collect();
    for (argument, entity) in wanted.arguments.iter().enumerate() {
        let entity = world.entity(*entity);
        if entity.is_value {
            order.values.push(value(argument, &entity.identifier));
        }
    }
    order
}

/// Returns a value as a number with its unit, or as a text: `180 s`, `"Good morning"`.
fn value(argument: usize, written: &str) -> ArgumentValue {
    let mut value = ArgumentValue {
        argument,
        number: None,
        unit: None,
        text: None,
    };
    let (number, unit) = written.split_once(' ').unwrap_or((written, ""));
    match number.parse::<f64>() {
        Ok(number) => {
            value.number = Some(number);
            value.unit = (!unit.is_empty()).then(|| unit.to_owned());
        }
        Err(_) => value.text = Some(written.trim_matches('"').to_owned()),
    }
    value
}
