//! Robots behind another program, which speaks JSON-RPC 2.0 over its standard input and output: one object a line.
//!
//! `docs/guide/robots.md` describes the messages. Invariants:
//!
//! - Before an order is sent, everything that the robot wrote until then is read. An order never follows a message that
//!   breaks the protocol.
//! - The first failure stops the robot: `stop` is sent, later orders are not, and the error stays the same.
//! - The program and its children are ended at the latest one stop timeout after a stop, and again one after that; also if this
//!   program is killed.
//! - Everything that is read has a bound: a line, the feedback of a step, the messages on standard error.

mod link;
mod message;

use std::path::PathBuf;
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};

use longstep_core::environment::Environment;
use serde_json::json;

use link::{Link, Reply};
use message::{initialized, observed};

use crate::description::Description;
use crate::error::RobotError;
use crate::order::{Handle, Order};
use crate::presence::{self, Presence};
use crate::program::{Child, CommandLine, Watched};
use crate::robot::{Progress, Robot, StopSwitch};
use crate::scope::Scope;
use crate::stop::StopRequest;
use longstep_core::environment::Observation;

/// The JSON Schema of the messages between Longstep and the program of a robot.
pub const SCHEMA: &str = include_str!("robot.schema.json");

pub use message::{LINE_LIMIT, PROTOCOL_VERSION};

/// The time between two looks at timeouts and at the state of the program. Messages are read as they come.
const TICK: Duration = Duration::from_millis(20);

/// The program of a robot.
#[derive(Debug, Clone)]
pub struct Command {
    line: CommandLine,
    domain: Option<String>,
    environment: Option<Environment>,
    startup: Duration,
    presences: Option<PathBuf>,
}

impl Command {
    /// Reads a command line: words with the quotes of a shell, without variables and pipes.
    ///
    /// ```
    /// use longstep_robot::process::Command;
    /// assert!(Command::parse("python3 'my robot.py' --speed 2").is_ok());
    /// let error = Command::parse("python3 'my robot.py").unwrap_err();
    /// assert_eq!(
    ///     error.to_string(),
    ///     "cannot start the robot `python3 'my robot.py`: a quote or a backslash at its end is not complete"
    /// );
    /// ```
    ///
    /// # Errors
    ///
    /// An empty command, and a quote that does not end.
    pub fn parse(text: &str) -> Result<Self, RobotError> {
        let line = CommandLine::parse(text).map_err(|error| RobotError::Unreachable {
            robot: longstep_core::visible::line(text).into_owned(),
            reason: error.to_string(),
        })?;
        Ok(Self::of(line))
    }

    /// Returns the command with these words; the first is the program.
    pub fn new<W: Into<String>>(words: impl IntoIterator<Item = W>) -> Self {
        Self::of(CommandLine::new(words))
    }

    fn of(line: CommandLine) -> Self {
        Self {
            line,
            domain: None,
            environment: None,
            startup: Duration::from_secs(30),
            presences: None,
        }
    }

    /// Runs the program in this folder.
    #[must_use]
    pub fn folder(mut self, folder: impl Into<PathBuf>) -> Self {
        self.line = self.line.folder(folder);
        self
    }

    /// Sends the domain's name and the environment in which the plan begins with `initialize`. Simulators build their
    /// scene from it.
    #[must_use]
    pub fn scene(mut self, domain: &str, environment: Environment) -> Self {
        (self.domain, self.environment) = (Some(domain.to_owned()), Some(environment));
        self
    }

    /// Sets the timeout for the answer to `initialize`, at most a day; 30 seconds without this.
    #[must_use]
    pub fn startup(mut self, limit: Duration) -> Self {
        self.startup = limit.min(Duration::from_secs(86_400));
        self
    }

    /// Keeps the presence of the program in this folder, which must exist: the folder of the locks of
    /// [`Exclusive`](crate::Exclusive). A program that drives a robot is not started a second time then, also after a Longstep
    /// that was killed has left it running.
    #[must_use]
    pub fn presences(mut self, folder: impl Into<PathBuf>) -> Self {
        self.presences = Some(folder.into());
        self
    }

    /// Starts the program and initializes the robot.
    ///
    /// # Errors
    ///
    /// A program that cannot be started, that ends or that does not answer, another protocol version, and an answer that
    /// breaks the protocol. The program is ended then. A program that drives a robot already, for another run or after one that
    /// was killed, is not started.
    pub fn open(self) -> Result<Process, RobotError> {
        self.open_until(&StopRequest::default())
    }

    /// Starts the program as [`Command::open`] does, unless a request to stop comes before the robot is initialized.
    ///
    /// # Errors
    ///
    /// As for [`Command::open`]; [`RobotError::Stopped`] after the request.
    pub fn open_until(self, request: &StopRequest) -> Result<Process, RobotError> {
        let unreachable = |error: std::io::Error| RobotError::Unreachable {
            robot: self.line.to_string(),
            reason: error.to_string(),
        };
        let presence = self.presence()?;
        let file = presence.as_ref().and_then(Presence::file);
        let (child, watched) = Child::spawn(&self.line, file).map_err(unreachable)?;
        let shared = Arc::new(Shared {
            link: Mutex::new(Link::new(child)),
            changed: Condvar::new(),
        });
        let watcher = Arc::clone(&shared);
        let thread = std::thread::Builder::new().spawn(move || watch(&watcher, &watched));
        let thread = thread.map_err(|error| {
            shared.lock().kill();
            unreachable(error)
        })?;
        let mut process = Process {
            description: Description::new(self.line.program()),
            shared,
            thread: Some(thread),
            presence,
        };
        request.attach(process.stop_switch());
        let mut parameters = json!({
            "protocol": PROTOCOL_VERSION,
            "client": { "name": "longstep", "version": env!("CARGO_PKG_VERSION") },
        });
        if let Some(domain) = &self.domain {
            parameters["domain"] = json!(domain);
        }
        if let Some(environment) = &self.environment {
            parameters["environment"] = json!(environment);
        }
        let answer = process.ask("initialize", &parameters, self.startup)?;
        let read = answer
            .map_err(|refusal| refusal.into_error("initialize"))
            .and_then(initialized);
        match read {
            Ok(description) => {
                let guarded = process.lock().guard(&description.timeouts);
                let (number, guard) = guarded.map_err(|error| process.failed(unreachable(error)))?;
                if let Some(presence) = &mut process.presence {
                    presence.set_processes(number, guard);
                }
                process.description = description;
                Ok(process)
            }
            Err(error) => Err(process.failed(error)),
        }
    }

    /// Returns the presence of the program, which must not drive a robot already.
    fn presence(&self) -> Result<Option<Presence>, RobotError> {
        let Some(folder) = &self.presences else {
            return Ok(None);
        };
        let key = self.line.key();
        presence::refuse_command(folder, &key)?;
        let presence = Presence::create(folder, &self.line.to_string(), &key);
        presence.map(Some).map_err(|error| RobotError::Unreachable {
            robot: self.line.to_string(),
            reason: format!("its presence cannot be kept in {}: {error}", folder.display()),
        })
    }
}

/// A robot behind another program; see [`Command`].
///
/// Dropping it sends `shutdown` and waits for the program's end, at most as long as the timeout for stops. It sends
/// `stop` before if orders are under way.
///
/// ```no_run
/// use longstep_robot::process::Command;
/// use longstep_robot::{Order, Progress, Robot};
///
/// let mut robot = Command::parse("python3 robot.py")?.open()?;
/// let handle = robot.start(&Order::new(1, "grasp", ["<cup>"]))?;
/// loop {
///     match robot.poll(handle)? {
///         Progress::Running(feedback) => println!("{feedback:?}"),
///         Progress::Done { .. } => break,
///         Progress::Failed { reason } => { println!("{reason}"); break }
///     }
///     robot.wait(std::time::Duration::from_millis(100));
/// }
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
#[derive(Debug)]
pub struct Process {
    description: Description,
    shared: Arc<Shared>,
    thread: Option<JoinHandle<()>>,
    presence: Option<Presence>,
}

#[derive(Debug)]
struct Shared {
    link: Mutex<Link>,
    /// Signalled after every look at the program.
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

/// Reads what the program writes and enforces timeouts, until the program ended.
fn watch(shared: &Shared, watched: &Watched) {
    loop {
        {
            let mut link = shared.lock();
            link.tick(Instant::now());
            shared.changed.notify_all();
            if link.is_ended() {
                return;
            }
        }
        watched.wait(TICK);
    }
}

impl Process {
    fn lock(&self) -> MutexGuard<'_, Link> {
        self.shared.lock()
    }

    /// Sends a request and waits for its answer.
    fn ask(
        &self,
        method: &'static str,
        parameters: &serde_json::Value,
        limit: Duration,
    ) -> Result<Result<serde_json::Value, message::Refusal>, RobotError> {
        let mut link = self.lock();
        let id = link.request(method, parameters, limit)?;
        loop {
            if let Some(answer) = link.take_answer(id)? {
                return Ok(answer);
            }
            link = self.shared.pause(link, TICK);
        }
    }

    /// Stops the robot for an error and returns the error.
    fn failed(&self, error: RobotError) -> RobotError {
        self.lock().fail(error)
    }
}

impl Robot for Process {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        let mut link = self.lock();
        link.check()?;
        if !self.description.can_perform(&order.action) {
            let action = order.action.clone();
            return Err(RobotError::Unsupported { action });
        }
        let limit = self.description.parallel;
        if link.orders() >= limit {
            return Err(RobotError::Busy { limit });
        }
        let timeout = self.description.timeouts.of_action(&order.action);
        link.order(order, timeout).map(Handle::new)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        let mut link = self.lock();
        link.tick(Instant::now());
        match link.take(handle.number())? {
            Some(Reply::Feedback(feedback)) => Ok(Progress::Running(Some(feedback))),
            Some(Reply::Order(progress)) => Ok(progress),
            Some(Reply::Answer(_)) | None => Err(RobotError::UnknownHandle(handle)),
            Some(Reply::Waiting) => Ok(Progress::Running(None)),
        }
    }

    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError> {
        self.lock().check()?;
        if !self.description.observes {
            return Err(RobotError::NoObservation);
        }
        let parameters = match scope {
            Scope::All => json!({}),
            Scope::Entities(entities) => json!({ "entities": entities }),
        };
        match self.ask("observe", &parameters, self.description.timeouts.observe)? {
            Ok(value) => observed(value).map_err(|error| self.failed(error)),
            Err(refusal) => {
                let error = refusal.into_error("observe");
                Err(if error.is_final() { self.failed(error) } else { error })
            }
        }
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

    fn presence(&self) -> Option<&Presence> {
        self.presence.as_ref()
    }

    fn wait(&mut self, limit: Duration) {
        drop(self.shared.pause(self.lock(), limit));
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.lock().close();
        if let Some(thread) = self.thread.take() {
            // The thread ends with the program, which is ended by force after its timeouts.
            drop(thread.join());
        }
        let stopped = self.lock().stopped();
        if let Some(presence) = &mut self.presence {
            presence.end(stopped.is_some_and(|stopped| stopped.is_ok()));
        }
    }
}
