//! The simulator as a robot.

use std::collections::BTreeSet;
use std::fs;
use std::sync::mpsc::{Receiver, RecvTimeoutError, TryRecvError, channel};
use std::time::Duration;

use longstep_core::environment::World;

use super::api::{QUESTION, Simulator};
use super::environment::statements;
use super::graph::Graph;
use super::options::VirtualHomeOptions;
use super::script::{Line, entity};
use crate::description::{Description, Timeouts};
use crate::error::RobotError;
use crate::order::{Handle, Order};
use crate::robot::{Feedback, Progress, Robot, StopSwitch};
use crate::scope::Scope;
use longstep_core::environment::Observation;

/// The time in which a line that is under way may end before a stop counts as not confirmed.
const STOP: Duration = Duration::from_secs(2);

/// A character in a scene of VirtualHome, for plans of the `virtualhome` domain.
///
/// ```no_run
/// use longstep_core::{domain, environment};
/// use longstep_robot::virtualhome::VirtualHome;
/// use longstep_robot::{Order, Progress, Robot};
///
/// let domain = domain::shipped("virtualhome").unwrap()?;
/// let world = environment::parse(&domain, "kitchen.json", &std::fs::read_to_string("kitchen.json")?)?;
/// let mut robot = VirtualHome::open(world, &"http://127.0.0.1:8080".parse()?)?;
/// let handle = robot.start(&Order::new(1, "walk-towards", ["<fridge_306>"]))?;
/// while let Progress::Running(_) = robot.poll(handle)? {
///     robot.wait(std::time::Duration::from_millis(50));
/// }
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug)]
pub struct VirtualHome {
    description: Description,
    simulator: Simulator,
    world: World,
    options: VirtualHomeOptions,
    orders: u64,
    running: Option<Running>,
    failure: Option<RobotError>,
}

/// A line under way. A thread waits for its end.
#[derive(Debug)]
struct Running {
    handle: Handle,
    end: Receiver<End>,
    /// The end, once its picture was reported.
    ended: Option<Result<(), String>>,
}

#[derive(Debug)]
struct End {
    result: Result<Result<(), String>, RobotError>,
    /// The reason why there is no picture, if there was to be one.
    no_picture: Option<String>,
}

impl VirtualHome {
    /// Connects to a simulator whose scene has the entities of this world, and adds a character if there is none.
    ///
    /// # Errors
    ///
    /// A simulator that does not answer, and a scene without an entity of the world.
    pub fn open(world: World, options: &VirtualHomeOptions) -> Result<Self, RobotError> {
        let simulator = Simulator::new(&options.url)?;
        let unreachable = |reason: String| RobotError::Unreachable {
            robot: format!("virtualhome:{}", simulator.shown_url()),
            reason,
        };
        if let Some(folder) = &options.pictures {
            let made = fs::create_dir_all(folder);
            made.map_err(|error| unreachable(format!("cannot make {}: {error}", folder.display())))?;
        }
        simulator.settle(options.timeout.max(QUESTION))?;
        let graph = simulator.graph()?;
        missing(&graph, &world).map_or(Ok(()), |reason| Err(unreachable(reason)))?;
        if graph.character().is_none() {
            simulator.add_character(&options.character, options.room.as_deref())?;
        }
        let mut description = Description::new("VirtualHome");
        description.actions = Some(Line::actions().map(str::to_owned).collect());
        description.observes = true;
        description.simulated = true;
        description.drives = options.drives();
        description.timeouts = Timeouts {
            perform: options.timeout,
            observe: QUESTION,
            stop: STOP,
            ..Timeouts::default()
        };
        Ok(Self {
            description,
            simulator,
            world,
            options: options.clone(),
            orders: 0,
            running: None,
            failure: None,
        })
    }

    /// Returns the client of the simulator.
    pub fn simulator(&self) -> &Simulator {
        &self.simulator
    }

    fn check(&self) -> Result<(), RobotError> {
        match &self.failure {
            Some(error) => Err(error.clone()),
            None if self.simulator.is_stopped() => Err(RobotError::Stopped),
            None => Ok(()),
        }
    }

    /// Sends nothing more because of an error, and returns it.
    fn failed(&mut self, error: RobotError) -> RobotError {
        self.simulator.stop();
        self.failure.get_or_insert(error).clone()
    }
}

/// Returns why a scene is not the one of a world: it lacks an entity.
fn missing(graph: &Graph, world: &World) -> Option<String> {
    let known: BTreeSet<String> = graph.nodes.iter().map(|node| node.identifier()).collect();
    let environment = world.environment();
    let lacking = |name: &&String| !known.contains(*name);
    let missing: Vec<&String> = environment
        .assets
        .iter()
        .chain(&environment.objects)
        .filter(lacking)
        .collect();
    let first = missing.first()?;
    let why = match entity(first) {
        Err(error) => error.to_string(),
        Ok(_) => format!("its scene has no {first}; make the environment with `longstep robot environment`"),
    };
    Some(match missing.len() {
        1 => why,
        count => format!("{why} ({} more are missing)", count - 1),
    })
}

impl Robot for VirtualHome {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.check()?;
        if !self.description.can_perform(&order.action) {
            let action = order.action.clone();
            return Err(RobotError::Unsupported { action });
        }
        if self.running.is_some() {
            return Err(RobotError::Busy { limit: 1 });
        }
        let line = Line::new(&order.action, &order.arguments).map_err(|error| RobotError::InvalidOrder {
            step: order.step,
            reason: error.to_string(),
        })?;
        let (sender, end) = channel();
        let (simulator, limit) = (self.simulator.clone(), self.options.timeout);
        let picture = self.options.pictures.as_ref();
        let picture = picture.map(|folder| folder.join(format!("step-{:03}.png", order.step)));
        let perform = move || {
            let result = simulator.render(&line, limit);
            let write = |path: &std::path::PathBuf| {
                let picture = simulator.picture().map_err(|error| error.to_string())?;
                fs::write(path, picture).map_err(|error| format!("{}: {error}", path.display()))
            };
            let no_picture = match (&result, &picture) {
                (Ok(_), Some(path)) => write(path).err(),
                _ => None,
            };
            // The robot may be gone by now.
            let _ = sender.send(End { result, no_picture });
        };
        let thread = std::thread::Builder::new().spawn(perform);
        if let Err(error) = thread {
            return Err(self.failed(RobotError::Gone {
                reason: error.to_string(),
                messages: String::new(),
            }));
        }
        self.orders += 1;
        let handle = Handle::new(self.orders);
        self.running = Some(Running {
            handle,
            end,
            ended: None,
        });
        Ok(handle)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        self.check()?;
        let Some(running) = self.running.as_mut().filter(|running| running.handle == handle) else {
            return Err(RobotError::UnknownHandle(handle));
        };
        let mut ended = running.ended.take();
        if ended.is_none() {
            match running.end.try_recv() {
                Err(TryRecvError::Empty) => return Ok(Progress::Running(None)),
                Err(TryRecvError::Disconnected) => {
                    return Err(self.failed(RobotError::Gone {
                        reason: "the thread that waited for it has ended".to_owned(),
                        messages: String::new(),
                    }));
                }
                Ok(End { result: Err(error), .. }) => return Err(self.failed(error)),
                Ok(End {
                    result: Ok(result),
                    no_picture: Some(why),
                }) => {
                    running.ended = Some(result);
                    let text = Some(format!("no picture: {why}"));
                    return Ok(Progress::Running(Some(Feedback {
                        text,
                        ..Feedback::default()
                    })));
                }
                Ok(End { result: Ok(result), .. }) => ended = Some(result),
            }
        }
        self.running = None;
        Ok(match ended {
            Some(Err(reason)) => Progress::Failed { reason },
            _ => Progress::Done { outcome: None },
        })
    }

    fn observe(&mut self, _: &Scope) -> Result<Observation, RobotError> {
        self.check()?;
        match self.simulator.graph() {
            Ok(graph) => Ok(statements(&graph, &self.world)),
            Err(error) if error.is_final() => Err(self.failed(error)),
            Err(error) => Err(error),
        }
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.simulator.stop();
        self.failure.get_or_insert(RobotError::Stopped);
        let Some(running) = self.running.take() else {
            return Ok(());
        };
        match running.end.recv_timeout(STOP) {
            Err(RecvTimeoutError::Timeout) => Err(RobotError::TimedOut {
                what: "stop: the simulator cannot stop a line, and has not ended it".to_owned(),
                limit: STOP,
            }),
            _ => Ok(()),
        }
    }

    fn stop_switch(&self) -> StopSwitch {
        let simulator = self.simulator.clone();
        StopSwitch::new(move || simulator.stop())
    }
}
