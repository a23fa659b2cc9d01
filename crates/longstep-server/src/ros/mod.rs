//! ROS 2 as a face of the server: topics that show plans, progress and worlds, and requests to plan and to execute.
//!
//! A [`RosFace`] is a client of a bridge ([`longstep_robot::rosbridge`]), so it needs no ROS and no message types. The
//! topics are `std_msgs/msg/String` with JSON, below a namespace:
//!
//! | topic | content |
//! |---|---|
//! | `plan` | the last change of a session: its state, its question, its plan with the hash |
//! | `progress` | the last change of a run, as `GET /api/runs/ID` shows it, without the world |
//! | `world` | the world as the last session or run that changed knows it |
//! | `say/request`, `say/response` | an instruction, an answer or feedback; the session when it is the person's turn |
//! | `execute/request`, `execute/response` | the hash of a plan; the run, or the reason why there is none |
//!
//! The topics that go out are latched. Invariants:
//!
//! - A run begins only with an [`Approval`](crate::Approval) of that plan. A caller may approve only where `robot.toml`
//!   says so, and then the audit log names it.
//! - Requests have bounds: in bytes, in number at a time, and in rate. What is beyond is refused, and a flood is dropped.
//! - The bridge has a thread of its own, and each request another. Nothing in the hub waits for either.
//! - A bridge that goes away is connected again, with pauses that grow to ten seconds; then the latched messages are
//!   published again.

mod bridge;
mod publication;
mod rate;
mod request;
mod service;
#[cfg(test)]
mod tests;
mod topic;

use std::io;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use longstep_robot::ros2::{Configuration, Serving};
use longstep_robot::rosbridge::Address;

use crate::hub::Hub;
use bridge::Bridge;

/// Takes a line about the connection, for the person who started the server.
pub type Notice = Arc<dyn Fn(&str) + Send + Sync>;

/// The bridge of a face, and what it offers there.
#[derive(Clone)]
#[non_exhaustive]
pub struct RosOptions {
    /// The bridge.
    pub address: Address,
    /// The namespace, the permission of callers to approve, and the services.
    pub serving: Serving,
    /// The longest wait for a connection.
    pub connect: Duration,
    /// The longest time without any message of the bridge.
    pub silence: Duration,
    /// The robot of plans that a caller approves; the only robot of the server if none is set.
    pub robot: Option<String>,
    /// Takes the lines about the connection.
    pub notice: Notice,
}

impl RosOptions {
    /// Returns the options of a `robot.toml`: its bridge, its timeouts, and its table `[serve]`.
    pub fn new(configuration: &Configuration) -> Self {
        Self {
            address: configuration.address().clone(),
            serving: configuration.serving().clone(),
            connect: configuration.connect_limit(),
            silence: configuration.silence_limit(),
            robot: None,
            notice: Arc::new(|_| {}),
        }
    }

    /// Sets the robot of plans that a caller approves.
    #[must_use]
    pub fn with_robot(self, robot: impl Into<Option<String>>) -> Self {
        Self {
            robot: robot.into(),
            ..self
        }
    }

    /// Sets the recipient of the lines about the connection.
    #[must_use]
    pub fn with_notice(self, notice: Notice) -> Self {
        Self { notice, ..self }
    }
}

/// The state that a face shares with its threads.
#[derive(Debug, Default)]
pub(crate) struct Shared {
    is_ended: AtomicBool,
    is_connected: AtomicBool,
    /// The number of connections since the face began.
    connections: AtomicU64,
}

impl Shared {
    fn is_ended(&self) -> bool {
        self.is_ended.load(Ordering::SeqCst)
    }
}

/// A server in ROS 2. Dropping it ends its connection, and the requests that it waits for.
///
/// ```no_run
/// use longstep_robot::ros2::Configuration;
/// use longstep_server::ros::{RosFace, RosOptions};
/// # fn begin(hub: std::sync::Arc<longstep_server::Hub>) -> Result<(), Box<dyn std::error::Error>> {
/// let configuration = Configuration::parse("robot.toml", &std::fs::read_to_string("robot.toml")?)?;
/// let face = RosFace::start(hub, RosOptions::new(&configuration))?;
/// # Ok(()) }
/// ```
#[derive(Debug)]
pub struct RosFace {
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
}

impl RosFace {
    /// Begins to connect, and returns at once.
    ///
    /// # Errors
    ///
    /// The operating system has no thread left.
    pub fn start(hub: Arc<Hub>, options: RosOptions) -> io::Result<Self> {
        let shared = Arc::new(Shared::default());
        let bridge = Bridge::new(hub, options, Arc::clone(&shared));
        let thread = thread::Builder::new()
            .name("ros2".to_owned())
            .spawn(move || bridge.run())?;
        Ok(Self {
            shared,
            thread: Some(thread),
        })
    }

    /// Returns true while the bridge is connected.
    pub fn is_connected(&self) -> bool {
        self.shared.is_connected.load(Ordering::SeqCst)
    }

    /// Returns the number of connections since the beginning.
    pub fn connections(&self) -> u64 {
        self.shared.connections.load(Ordering::SeqCst)
    }
}

impl Drop for RosFace {
    fn drop(&mut self) {
        self.shared.is_ended.store(true, Ordering::SeqCst);
        if let Some(thread) = self.thread.take() {
            // A thread that panicked has ended.
            drop(thread.join());
        }
    }
}
