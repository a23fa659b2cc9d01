//! The interface of every robot.

use std::sync::Arc;
use std::time::Duration;

use longstep_core::environment::World;
use serde_json::Value;

use crate::description::Description;
use crate::error::RobotError;
use crate::order::Order;
#[cfg(unix)]
use crate::presence::Presence;
use crate::scope::Scope;
use longstep_core::environment::Observation;

pub use crate::order::Handle;

/// The longest default wait between two polls.
const PAUSE: Duration = Duration::from_millis(5);

/// A robot: it performs orders, observes, and stops.
///
/// Invariants of every implementation:
///
/// - Nothing is sent after a stop or after an error that [`RobotError::is_final`]; both stop the robot.
/// - The end of an order is reported once. A failed step leaves the robot usable.
/// - An implementation never assumes that a step was done: [`Progress::Done`] comes from the robot.
///
/// # Example
///
/// ```
/// use std::sync::Arc;
/// use std::sync::atomic::{AtomicBool, Ordering};
/// use longstep_robot::{
///     Description, Handle, Observation, Order, Progress, Robot, RobotError, Scope, StopSwitch,
/// };
///
/// /// A lamp, which is a robot with one action.
/// struct Lamp { description: Description, lit: bool, orders: u64, stopped: Arc<AtomicBool> }
///
/// impl Lamp {
///     fn check(&self) -> Result<(), RobotError> {
///         if self.stopped.load(Ordering::SeqCst) { Err(RobotError::Stopped) } else { Ok(()) }
///     }
/// }
///
/// impl Robot for Lamp {
///     fn describe(&self) -> &Description { &self.description }
///     fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
///         self.check()?;
///         if order.action != "switch-on" {
///             return Err(RobotError::Unsupported { action: order.action.clone() });
///         }
///         (self.lit, self.orders) = (true, self.orders + 1);
///         Ok(Handle::new(self.orders))
///     }
///     fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
///         self.check()?;
///         if handle.number() != self.orders {
///             return Err(RobotError::UnknownHandle(handle));
///         }
///         Ok(Progress::Done { outcome: None })
///     }
///     fn observe(&mut self, _: &Scope) -> Result<Observation, RobotError> {
///         self.check()?;
///         let statements = if self.lit { vec!["on()".to_owned()] } else { Vec::new() };
///         let states = [("<lamp>".to_owned(), longstep_core::environment::Words::Many(statements))].into();
///         Ok(Observation { states, facts: None })
///     }
///     fn stop(&mut self) -> Result<(), RobotError> { self.stop_switch().press(); Ok(()) }
///     fn stop_switch(&self) -> StopSwitch {
///         let stopped = Arc::clone(&self.stopped);
///         StopSwitch::new(move || stopped.store(true, Ordering::SeqCst))
///     }
/// }
///
/// let mut lamp = Lamp { description: Description::new("lamp"), lit: false, orders: 0, stopped: Arc::default() };
/// let handle = lamp.start(&Order::new(1, "switch-on", ["<lamp>"]))?;
/// while let Progress::Running(_) = lamp.poll(handle)? {
///     lamp.wait(std::time::Duration::from_millis(50));
/// }
/// assert_eq!(lamp.observe(&Scope::All)?.of_entity("<lamp>"), Some(&["on()".to_owned()][..]));
/// lamp.stop()?;
/// lamp.stop()?;
/// assert_eq!(lamp.start(&Order::new(2, "switch-on", ["<lamp>"])), Err(RobotError::Stopped));
/// # Ok::<(), RobotError>(())
/// ```
pub trait Robot: Send {
    /// Returns the capabilities and the timeouts. They never change. See the [example](Self#example).
    fn describe(&self) -> &Description;

    /// Begins a step, without waiting for it. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// The order was not sent: the robot lacks the action, performs as many orders as it can, or is stopped. A failure
    /// after sending is an error of [`Robot::poll`].
    fn start(&mut self, order: &Order) -> Result<Handle, RobotError>;

    /// Returns the state of a step that was started. Never waits. The handle ends with [`Progress::Done`] or
    /// [`Progress::Failed`]. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// A handle that ended already. Otherwise the robot is stopped, for example because the step took longer than its
    /// timeout.
    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError>;

    /// Returns what the robot sees. Waits at most as long as the timeout for observations; a [`StopSwitch`] ends the
    /// wait. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// A robot that does not observe, or refuses. Otherwise the robot is stopped.
    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError>;

    /// Stops the robot, and all of its orders, at once. Does nothing if it is stopped already. Waits at most as long as
    /// the timeout for stops for the robot's confirmation. See the [example](Self#example).
    ///
    /// # Errors
    ///
    /// The robot did not confirm the stop. A robot behind a program was ended by force then.
    fn stop(&mut self) -> Result<(), RobotError>;

    /// Returns a switch that stops the robot from any thread. It does not wait for a confirmation: call
    /// [`Robot::stop`] afterwards for that. See the [example](Self#example).
    fn stop_switch(&self) -> StopSwitch;

    /// Prepares for another plan, which begins in this world. A robot that counts events, such as a wiped table, begins
    /// to count anew.
    fn begin_plan(&mut self, _: &World) {}

    /// Returns the robot that goes on in the same world after a stop; none if the robot has to be opened again.
    ///
    /// ```
    /// # use longstep_core::{domain, environment};
    /// # use longstep_robot::{Order, Robot, Scope, Sim, SimOptions};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
    /// let mut sim = Sim::new(world, &SimOptions::default())?;
    /// sim.stop()?;
    /// assert!(sim.observe(&Scope::All).is_err());
    /// assert!(sim.revived().unwrap().observe(&Scope::All).is_ok());
    /// # Ok::<(), longstep_robot::RobotError>(())
    /// ```
    fn revived(&self) -> Option<Box<dyn Robot>> {
        None
    }

    /// Returns the message that an order would be sent as, without sending it: a robot that understands a plan can be asked
    /// so for each step before anything moves.
    ///
    /// ```
    /// # use longstep_core::{domain, environment};
    /// # use longstep_robot::{Order, Robot, Scope, Sim, SimOptions};
    /// # let household = domain::shipped("household").unwrap().unwrap();
    /// # let world = environment::parse(&household, "env.json", r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
    /// let sim = Sim::new(world, &SimOptions::default())?;
    /// assert_eq!(sim.message(&Order::new(1, "grasp", ["<pen>"]))?["action"], "grasp");
    /// # Ok::<(), longstep_robot::RobotError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// An action that the robot lacks, and an order that cannot be written as a message.
    fn message(&self, order: &Order) -> Result<Value, RobotError> {
        if !self.describe().can_perform(&order.action) {
            let action = order.action.clone();
            return Err(RobotError::Unsupported { action });
        }
        serde_json::to_value(order).map_err(|error| RobotError::InvalidOrder {
            step: order.step,
            reason: error.to_string(),
        })
    }

    /// Returns the presence of the program that performs the orders, and goes on if this program is killed; none for a robot
    /// whose orders end with this program, and for one that is reached over a connection.
    #[cfg(unix)]
    fn presence(&self) -> Option<&Presence> {
        None
    }

    /// Waits until a poll may have something new, at most `limit` long. May return early. See the [example](Self#example).
    fn wait(&mut self, limit: Duration) {
        std::thread::sleep(limit.min(PAUSE));
    }
}

/// The state of a step that was started.
#[derive(Debug, Clone, PartialEq)]
pub enum Progress {
    /// The step is under way. With the oldest feedback that was not returned yet, if there is one.
    Running(Option<Feedback>),
    /// The robot says that it did the step.
    Done {
        /// The outcome of a sensing step: an index in [`Order::outcomes`].
        outcome: Option<usize>,
    },
    /// The robot says that it could not do the step. The state of the world is unknown until it is observed.
    Failed {
        /// The robot's reason.
        reason: String,
    },
}

/// A message about a step that is under way, for people.
///
/// ```
/// use longstep_robot::Feedback;
/// let feedback = Feedback::default().with_fraction(0.5).with_text("half way".to_owned());
/// assert_eq!((feedback.fraction, feedback.data), (Some(0.5), None));
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
#[non_exhaustive]
pub struct Feedback {
    /// The share of the step that is done, from 0 to 1.
    pub fraction: Option<f64>,
    /// A sentence.
    pub text: Option<String>,
    /// Further data of the robot, such as a pose.
    pub data: Option<Value>,
}

impl Feedback {
    /// Sets the share of the step that is done, from 0 to 1.
    #[must_use]
    pub fn with_fraction(self, fraction: impl Into<Option<f64>>) -> Self {
        Self {
            fraction: fraction.into(),
            ..self
        }
    }

    /// Sets the sentence.
    #[must_use]
    pub fn with_text(self, text: impl Into<Option<String>>) -> Self {
        Self {
            text: text.into(),
            ..self
        }
    }

    /// Sets further data of the robot.
    #[must_use]
    pub fn with_data(self, data: impl Into<Option<Value>>) -> Self {
        Self {
            data: data.into(),
            ..self
        }
    }
}

/// A switch that stops a robot from any thread. Clones stop the same robot.
#[derive(Clone)]
pub struct StopSwitch(Arc<dyn Fn() + Send + Sync>);

impl StopSwitch {
    /// Returns a switch that calls `stop`, which must not wait for the robot and may be called any number of times.
    pub fn new(stop: impl Fn() + Send + Sync + 'static) -> Self {
        Self(Arc::new(stop))
    }

    /// Stops the robot.
    pub fn press(&self) {
        (self.0)();
    }
}

impl std::fmt::Debug for StopSwitch {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter.write_str("StopSwitch")
    }
}
