//! A run that moves nothing.

use std::collections::BTreeMap;
use std::time::Duration;

use longstep_core::environment::World;
use serde_json::Value;

use crate::description::Description;
use crate::error::RobotError;
use crate::order::{Handle, Order};
use crate::robot::{Feedback, Progress, Robot, StopSwitch};
use crate::scope::Scope;
use crate::sim::{Sim, SimOptions};
use longstep_core::environment::Observation;

/// Writes the message that a robot would be sent for an order.
type Messages = Box<dyn Fn(&Order) -> Result<Value, RobotError> + Send>;

/// A robot that shows what another one would be sent, and sends nothing.
///
/// The world is the one that the plan predicts: every step does what the domain says, and sensing steps have an outcome
/// that is drawn. The first feedback of each step is the message that the robot would be sent.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{Description, DryRun, Order, Progress, Robot};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let message = |order: &Order| Ok(serde_json::json!({"reach": order.arguments[0]}));
/// let mut dry = DryRun::new(&Description::new("arm"), world, message)?;
/// let handle = dry.start(&Order::new(1, "move-hand", ["<pen>"]))?;
/// let Progress::Running(Some(feedback)) = dry.poll(handle)? else { panic!() };
/// assert_eq!(feedback.text.unwrap(), r#"would send {"reach":"<pen>"}"#);
/// assert_eq!(dry.poll(handle)?, Progress::Done { outcome: None });
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
pub struct DryRun {
    description: Description,
    sim: Sim,
    message: Messages,
    /// The messages that were not shown yet.
    unseen: BTreeMap<Handle, Value>,
}

impl DryRun {
    /// Creates a dry run of a robot in a world.
    ///
    /// # Errors
    ///
    /// Those of [`Sim::new`].
    pub fn new(
        description: &Description,
        world: World,
        message: impl Fn(&Order) -> Result<Value, RobotError> + Send + 'static,
    ) -> Result<Self, RobotError> {
        let sim = Sim::new(world, &SimOptions::default())?;
        // What is observed is the simulated world.
        let description = Description {
            observes: true,
            reports: sim.describe().reports.clone(),
            counts_events: sim.describe().counts_events,
            drives: Vec::new(),
            ..description.clone()
        };
        Ok(Self {
            description,
            sim,
            message: Box::new(message),
            unseen: BTreeMap::new(),
        })
    }
}

impl Robot for DryRun {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        let message = self.message(order)?;
        let handle = self.sim.start(order)?;
        self.unseen.insert(handle, message);
        Ok(handle)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        if let Some(message) = self.unseen.remove(&handle) {
            let feedback = Feedback {
                text: Some(format!("would send {message}")),
                data: Some(message),
                ..Feedback::default()
            };
            return Ok(Progress::Running(Some(feedback)));
        }
        self.sim.poll(handle)
    }

    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError> {
        self.sim.observe(scope)
    }

    fn message(&self, order: &Order) -> Result<Value, RobotError> {
        if !self.description.can_perform(&order.action) {
            let action = order.action.clone();
            return Err(RobotError::Unsupported { action });
        }
        (self.message)(order)
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.sim.stop()
    }

    fn stop_switch(&self) -> StopSwitch {
        self.sim.stop_switch()
    }

    fn begin_plan(&mut self, world: &World) {
        self.sim.begin_plan(world);
    }

    fn wait(&mut self, _: Duration) {}
}
