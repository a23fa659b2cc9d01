//! Robots behind ROS 2, through a rosbridge server: JSON over a WebSocket.
//!
//! `robot.toml` ([`Configuration`]) says which action server performs each action, and how topics and services become
//! observations; `docs/guide/ros2.md` describes it. Types of ROS 2 stay data, so that this crate needs none of them. Invariants:
//!
//! - Only actions of the allow-list are sent, not faster than the rate, and only to servers that answered before.
//! - Before an order is sent, everything that the bridge sent until then is read.
//! - The first failure stops the robot: every goal under way is cancelled, nothing else is sent, and the error stays the same.
//!   If the connection is gone, the stop connects again to cancel.
//! - A bridge that keeps heartbeats back while a goal is under way ends the run: what the robot did then says nothing about the
//!   world.
//! - A stop is confirmed only if every goal under way ended.
//! - A run that goes on after an interruption ends the goals that it left ([`Ros2::reconnect`]) before it observes.
//! - Everything that is read has a bound.

mod check;
mod configuration;
mod criterion;
mod echo;
mod file;
mod leftover;
mod link;
mod mapping;
mod observe;
mod read;
mod stopping;
mod template;
mod trial;

use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use longstep_core::model::Domain;
use serde_json::{Value, json};

pub use check::{Checked, check};
pub use configuration::{Configuration, Serving};
#[cfg(feature = "schema")]
pub use file::schema;
pub use trial::{Trial, trials};

use configuration::{ObservationRule, Origin};
use link::{Answer, Link, status_topic};
use mapping::Mapping;
use stopping::has_no_active_goal;

use crate::description::{Description, Timeouts};
use crate::error::RobotError;
use crate::order::{Handle, Order};
use crate::robot::{Progress, Robot, StopSwitch};
use crate::rosbridge::{Connection, message, wait_for};
use crate::scope::Scope;
use longstep_core::environment::Observation;

/// The time between two looks at timeouts. Messages are read as they come.
const TICK: Duration = Duration::from_millis(20);

/// The wait for the list of the goals that a server had before.
const LISTING: Duration = Duration::from_millis(300);

/// The messages that a robot would be sent, without a connection to it.
///
/// ```
/// use longstep_core::domain;
/// use longstep_robot::{Order, ros2::{Configuration, Preview}};
/// let text = r#"
/// name = "arm"
/// url = "ws://127.0.0.1:9090"
/// allow = ["grasp"]
/// [[action]]
/// name = "grasp"
/// server = "/grasp"
/// type = "arm_msgs/action/Grasp"
/// goal = { target = "{item|bare}" }
/// "#;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let preview = Preview::new(Configuration::parse("robot.toml", text).unwrap(), &household);
/// let message = preview.message(&Order::new(1, "grasp", ["<cup>"]))?;
/// assert_eq!(message["args"]["target"], "cup");
/// assert_eq!(message["action"], "/grasp");
/// assert!(preview.message(&Order::new(2, "release", ["<cup>"])).is_err());
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
#[derive(Debug, Clone)]
pub struct Preview {
    mapping: Arc<Mapping>,
    description: Description,
}

impl Preview {
    /// Binds a configuration to a domain. [`check()`] finds what does not fit.
    pub fn new(configuration: Configuration, domain: &Domain) -> Self {
        let description = description(&configuration);
        let mapping = Arc::new(Mapping::new(configuration, domain));
        Self { mapping, description }
    }

    /// The robot as its configuration describes it.
    pub fn description(&self) -> &Description {
        &self.description
    }

    /// Returns the goal that would be sent for an order, as a message to the bridge.
    ///
    /// # Errors
    ///
    /// An action that the robot may not perform, and a value that is missing.
    pub fn message(&self, order: &Order) -> Result<Value, RobotError> {
        goal_message(&self.mapping, order)
    }
}

fn goal_message(mapping: &Mapping, order: &Order) -> Result<Value, RobotError> {
    let goal = mapping.goal(order)?;
    Ok(json!({"op": "send_action_goal", "action": goal.server, "action_type": goal.kind, "args": goal.fields}))
}

fn description(configuration: &Configuration) -> Description {
    let limits = &configuration.limits;
    let allowed = configuration.allow.iter().map(|own| own.get_ref().clone());
    let timeouts = configuration.allow.iter().filter_map(|own| {
        let limit = configuration.rule(own.get_ref())?.timeout?;
        Some((own.get_ref().clone(), limit))
    });
    let mut description = Description::new(&configuration.name);
    description.actions = Some(allowed.collect());
    description.parallel = configuration.parallel;
    description.observes = !configuration.observations.is_empty();
    description.reports = configuration.reports.iter().map(|own| own.get_ref().clone()).collect();
    description.timeouts = Timeouts {
        perform: limits.perform,
        actions: timeouts.collect(),
        observe: limits.observe,
        stop: limits.stop,
    };
    description.simulated = configuration.simulated;
    description.drives = configuration.drives();
    description
}

/// A robot behind a bridge to ROS 2.
///
/// Dropping it cancels the goals under way.
///
/// ```no_run
/// use longstep_core::domain;
/// use longstep_robot::ros2::{Configuration, Ros2};
/// use longstep_robot::{Order, Progress, Robot};
///
/// let household = domain::shipped("household").unwrap()?;
/// let configuration = Configuration::parse("robot.toml", &std::fs::read_to_string("robot.toml")?)?;
/// let mut robot = Ros2::connect(configuration, &household)?;
/// let handle = robot.start(&Order::new(1, "grasp", ["<cup>"]))?;
/// while let Progress::Running(feedback) = robot.poll(handle)? {
///     println!("{feedback:?}");
///     robot.wait(std::time::Duration::from_millis(100));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct Ros2 {
    description: Description,
    mapping: Arc<Mapping>,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    /// The goals of an interrupted run that were cancelled.
    cancelled: usize,
}

#[derive(Debug)]
struct Shared {
    link: Mutex<Link>,
    /// Signalled after every look at the connection.
    changed: Condvar,
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Link> {
        self.link.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Releases the lock until something changed, or the time is over.
    fn pause<'a>(&self, link: MutexGuard<'a, Link>, limit: Duration) -> MutexGuard<'a, Link> {
        self.changed
            .wait_timeout(link, limit)
            .unwrap_or_else(PoisonError::into_inner)
            .0
    }
}

/// Reads what the bridge sends and enforces timeouts, until the robot is stopped.
fn watch(shared: &Shared) {
    loop {
        let watched = {
            let mut link = shared.lock();
            link.tick(Instant::now());
            shared.changed.notify_all();
            if link.is_ended() {
                return;
            }
            link.watched()
        };
        match watched {
            Some(stream) => wait_for(&stream, TICK),
            None => std::thread::sleep(TICK),
        }
    }
}

impl Ros2 {
    /// Connects to the bridge and looks for every server that the configuration allows. Nothing moves.
    ///
    /// # Errors
    ///
    /// A bridge that cannot be reached, a server that does not answer or has another type, and an observation that cannot
    /// be subscribed; [`RobotError::UnderWay`] for a server that has a goal under way.
    pub fn connect(configuration: Configuration, domain: &Domain) -> Result<Self, RobotError> {
        let robot = Self::find(configuration, domain)?;
        robot.find_idle(robot.mapping.configuration.servers().into_keys())?;
        Ok(robot)
    }

    /// Connects to the bridge, looks for every server, and subscribes everything.
    fn find(configuration: Configuration, domain: &Domain) -> Result<Self, RobotError> {
        let robot = Self::open(configuration, domain)?;
        robot.find_threads()?;
        for (server, kind) in robot.mapping.configuration.servers() {
            robot.find_server(server, kind)?;
            robot.lock().subscribe_status(server)?;
        }
        robot.subscribe_observations()?;
        Ok(robot)
    }

    /// Fails if one of the servers has a goal that has not ended: somebody else moves the robot, or an earlier run left it
    /// moving.
    fn find_idle<'s>(&self, servers: impl Iterator<Item = &'s str>) -> Result<(), RobotError> {
        let mut unknown: Vec<&str> = servers.collect();
        let begun = Instant::now();
        let mut link = self.lock();
        // A server that had goals lists them at once. One that had none lists nothing.
        while !unknown.is_empty() && begun.elapsed() < LISTING {
            let mut waiting = Vec::new();
            for server in unknown {
                match link.latest(&status_topic(server), None) {
                    Ok(Some(list)) if !has_no_active_goal(&list) => {
                        let server = server.to_owned();
                        let reason =
                            "another program sent it, or a run that was killed, which can be resumed".to_owned();
                        return Err(link.fail(RobotError::UnderWay { server, reason }));
                    }
                    Ok(Some(_)) => {}
                    // A bridge that cannot list goals: nothing more can be known.
                    Err(RobotError::Refused { .. }) => {}
                    Ok(None) => waiting.push(server),
                    Err(error) => return Err(error),
                }
            }
            unknown = waiting;
            link = self.shared.pause(link, TICK);
        }
        Ok(())
    }

    /// Connects to the bridge alone.
    fn open(configuration: Configuration, domain: &Domain) -> Result<Self, RobotError> {
        let url = configuration.url.clone();
        let unreachable = |reason: String| RobotError::Unreachable {
            robot: url.written.clone(),
            reason,
        };
        let connection = Connection::open(&configuration.url, configuration.limits.connect).map_err(unreachable)?;
        let description = description(&configuration);
        let mapping = Arc::new(Mapping::new(configuration, domain));
        let shared = Arc::new(Shared {
            link: Mutex::new(Link::new(Arc::clone(&mapping), connection)),
            changed: Condvar::new(),
        });
        let watcher = Arc::clone(&shared);
        let thread = std::thread::Builder::new().spawn(move || watch(&watcher));
        let thread = thread.map_err(|error| unreachable(error.to_string()))?;
        Ok(Self {
            description,
            mapping,
            shared,
            thread: Some(thread),
            cancelled: 0,
        })
    }

    fn lock(&self) -> MutexGuard<'_, Link> {
        self.shared.lock()
    }

    /// Sends a request and waits for its answer; none if the bridge is silent.
    fn ask(&self, message: impl FnOnce(&str) -> Value, limit: Duration) -> Result<Option<Answer>, RobotError> {
        let deadline = Instant::now() + limit;
        let mut link = self.lock();
        let id = link.request(message)?;
        loop {
            if let Some(answer) = link.take_answer(&id)? {
                return Ok(Some(answer));
            }
            if Instant::now() >= deadline {
                link.forget(&id);
                return Ok(None);
            }
            link = self.shared.pause(link, TICK);
        }
    }

    fn observe_all(&self) -> Result<Observation, RobotError> {
        let begun = Instant::now();
        let limit = self.mapping.configuration.limits.observe;
        let rules = &self.mapping.configuration.observations;
        let mut waiting: Vec<Waiting<'_>> = Vec::new();
        let mut link = self.lock();
        for rule in rules {
            waiting.push(Waiting::begin(&mut link, rule, begun, limit)?);
        }
        loop {
            for own in &mut waiting {
                own.look(&mut link)?;
            }
            let Some(late) = waiting.iter().find(|own| own.message.is_none()) else {
                break;
            };
            if begun.elapsed() > limit {
                let what = format!("observe (`{}`)", late.rule.origin.name());
                return Err(link.fail(RobotError::TimedOut { what, limit }));
            }
            link = self.shared.pause(link, TICK);
        }
        let messages: Vec<Value> = waiting.into_iter().filter_map(|own| own.message).collect();
        let observed = observe::observation(&self.mapping.configuration, &messages);
        observed.map_err(|error| link.fail(error))
    }
}

/// A message of an observation that is waited for.
struct Waiting<'a> {
    rule: &'a ObservationRule,
    /// The call of a service.
    call: Option<String>,
    /// The moment after which a message of a topic counts.
    after: Option<Instant>,
    message: Option<Value>,
}

impl<'a> Waiting<'a> {
    fn begin(link: &mut Link, rule: &'a ObservationRule, now: Instant, limit: Duration) -> Result<Self, RobotError> {
        let mut own = Self {
            rule,
            call: None,
            after: None,
            message: None,
        };
        match &rule.origin {
            Origin::Topic { latched, .. } => own.after = (!latched).then_some(now),
            Origin::Service { name, request } => {
                let seconds = limit.as_secs_f64();
                let call = |id: &str| message::call(id, name, Some(&rule.kind), request, seconds);
                own.call = Some(link.request(call)?);
            }
        }
        Ok(own)
    }

    fn look(&mut self, link: &mut Link) -> Result<(), RobotError> {
        if self.message.is_some() {
            return Ok(());
        }
        let name = self.rule.origin.name();
        let Some(call) = &self.call else {
            self.message = link.latest(name, self.after)?;
            return Ok(());
        };
        if let Some(answer) = link.take_answer(call)? {
            if !answer.is_success {
                let reason = message::quotation(answer.values.as_str().unwrap_or("it failed"));
                let method = format!("observe (`{name}`)");
                return Err(link.fail(RobotError::Refused { method, reason }));
            }
            self.message = Some(answer.values);
        }
        Ok(())
    }
}

impl Robot for Ros2 {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        let mut link = self.lock();
        link.check()?;
        let goal = self.mapping.goal(order)?;
        let limit = self.description.parallel;
        if link.orders() >= limit {
            return Err(RobotError::Busy { limit });
        }
        let timeout = self.description.timeouts.of_action(&order.action);
        link.order(order, goal, timeout).map(Handle::new)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        match self.lock().take(handle.number())? {
            Some(progress) => Ok(progress),
            None => Err(RobotError::UnknownHandle(handle)),
        }
    }

    fn observe(&mut self, _: &Scope) -> Result<Observation, RobotError> {
        self.lock().check()?;
        if !self.description.observes {
            return Err(RobotError::NoObservation);
        }
        self.observe_all()
    }

    fn message(&self, order: &Order) -> Result<Value, RobotError> {
        goal_message(&self.mapping, order)
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        let mut link = self.lock();
        link.fail(RobotError::Stopped);
        loop {
            if let Some(result) = link.stopped() {
                return result;
            }
            link = self.shared.pause(link, TICK);
        }
    }

    fn stop_switch(&self) -> StopSwitch {
        let shared = Arc::clone(&self.shared);
        StopSwitch::new(move || {
            shared.lock().fail(RobotError::Stopped);
        })
    }

    fn wait(&mut self, limit: Duration) {
        drop(self.shared.pause(self.lock(), limit));
    }
}

impl Drop for Ros2 {
    fn drop(&mut self) {
        self.lock().fail(RobotError::Stopped);
        if let Some(thread) = self.thread.take() {
            // The thread ends with the stop, which has a limit.
            drop(thread.join());
        }
    }
}
