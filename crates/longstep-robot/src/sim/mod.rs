//! A simulated robot: the domain's own semantics, with seeded mishaps.
//!
//! The simulator knows the whole state and reports all of it, hidden facts included, unless it is told to see less. It
//! checks every order against its state, so that runs with it measure an execution.

mod mishap;
mod options;
mod random;
mod store;
#[cfg(test)]
mod tests;

use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use longstep_core::environment::{EntityId, Fact, Moment, ObservedFacts as Seen, State, World, holds};
use longstep_core::model::{ActionId, PredicateId, apply, unmet};
use longstep_core::plan::Step;
use longstep_core::schedule::independent;

use crate::description::Description;
use crate::error::RobotError;
use crate::order::Order;
use crate::robot::{Feedback, Handle, Progress, Robot, StopSwitch};
use crate::scope::Scope;
use longstep_core::environment::Observation;

use mishap::History;
pub use mishap::Mishap;
pub use options::{SimOptions, SimOptionsError};
use random::Random;

/// A simulated robot.
///
/// ```
/// use longstep_core::{domain, environment};
/// use longstep_robot::{Order, Progress, Robot, Scope, Sim};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let mut sim = Sim::new(world, &"seed=7".parse().unwrap())?;
/// for (step, action) in ["move-hand", "grasp"].into_iter().enumerate() {
///     let handle = sim.start(&Order::new(step + 1, action, ["<pen>"]))?;
///     while let Progress::Running(_) = sim.poll(handle)? {}
/// }
/// let seen = sim.observe(&Scope::All)?;
/// assert_eq!(seen.of_entity("<pen>").unwrap(), ["on_something(<desk>)", "inside_hand()"]);
/// # Ok::<(), longstep_robot::RobotError>(())
/// ```
#[derive(Debug)]
pub struct Sim {
    description: Description,
    world: World,
    state: State,
    reports: Vec<PredicateId>,
    options: SimOptions,
    random: Random,
    /// The mishaps by the number of the order.
    mishaps: BTreeMap<u64, Random>,
    history: History,
    running: BTreeMap<Handle, Running>,
    orders: u64,
    stopped: Arc<AtomicBool>,
    counts: SimCounts,
}

/// The counts of a simulator.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct SimCounts {
    /// Orders whose precondition did not hold when they were started.
    pub inapplicable: u64,
    /// Pairs of orders that were under way at the same time and are not independent.
    pub conflicts: u64,
    /// Mishaps that happened.
    pub mishaps: u64,
    /// Orders.
    pub orders: u64,
}

/// An order under way.
#[derive(Debug)]
struct Running {
    step: Step,
    ticks: u32,
    left: u32,
    next: Instant,
    outcomes: Vec<Fact>,
    number: u64,
    possible: bool,
}

impl Sim {
    /// Creates a robot in a world.
    ///
    /// # Errors
    ///
    /// A state file that cannot be read.
    pub fn new(world: World, options: &SimOptions) -> Result<Self, RobotError> {
        let domain = world.domain();
        let reports = Seen::reportable(domain);
        let mut random = Random::new(options.seed);
        let mut mishaps = BTreeMap::new();
        for _ in 0..options.faults {
            let order = 1 + random.below(u64::from(options.horizon));
            mishaps.insert(order, random.fork());
        }
        let mut description = Description::new("sim");
        description.observes = true;
        description.parallel = 64;
        description.simulated = true;
        description.counts_events = true;
        description.reports = reports.iter().map(|id| domain.predicate(*id).name.clone()).collect();
        let mut sim = Self {
            description,
            state: world.state.clone(),
            history: History::of(&world),
            world,
            reports,
            options: options.clone(),
            random,
            mishaps,
            running: BTreeMap::new(),
            orders: 0,
            stopped: Arc::default(),
            counts: SimCounts::default(),
        };
        sim.restore()?;
        Ok(sim)
    }

    /// The state of the simulated world.
    pub fn state(&self) -> &State {
        &self.state
    }

    /// The counts.
    pub fn counts(&self) -> SimCounts {
        self.counts
    }

    fn check(&self) -> Result<(), RobotError> {
        if self.stopped.load(Ordering::SeqCst) {
            Err(RobotError::Stopped)
        } else {
            Ok(())
        }
    }

    /// Returns the action and the arguments of an order.
    fn step_of(&self, order: &Order) -> Result<Step, RobotError> {
        let domain = self.world.domain();
        let mut actions = domain.action_ids();
        let found: Option<ActionId> = actions.find(|(_, own)| own.name == order.action).map(|(id, _)| id);
        let action = found.ok_or_else(|| RobotError::Unsupported {
            action: order.action.clone(),
        })?;
        let invalid = |reason: String| RobotError::InvalidOrder {
            step: order.step,
            reason,
        };
        let entity = |name: &String| {
            self.world
                .find(name)
                .ok_or_else(|| invalid(format!("no entity `{name}`")))
        };
        let arguments: Vec<EntityId> = order.arguments.iter().map(entity).collect::<Result<_, _>>()?;
        let parameters = &domain.action(action).parameters;
        if arguments.len() != parameters.len() {
            return Err(invalid(format!(
                "{} arguments where `{}` takes {}",
                arguments.len(),
                order.action,
                parameters.len()
            )));
        }
        for (argument, parameter) in arguments.iter().zip(parameters) {
            if !self.world.is_of_kind(*argument, parameter.kind) {
                let (name, kind) = (self.world.entity(*argument), domain.types.name(parameter.kind));
                let reason = format!("`{}` is no `{kind}`, which `{}` takes", name.identifier, order.action);
                return Err(invalid(reason));
            }
        }
        Ok(Step {
            action,
            arguments,
            explanation: String::new(),
        })
    }

    fn is_possible(&self, step: &Step) -> bool {
        let moment = Moment {
            world: &self.world,
            state: &self.state,
        };
        let action = self.world.domain().action(step.action);
        holds(moment, &action.precondition, &mut step.arguments.clone())
    }

    fn why_impossible(&self, step: &Step) -> String {
        let action = self.world.domain().action(step.action);
        let missing = unmet(
            &self.world,
            &self.state,
            &action.precondition,
            &mut step.arguments.clone(),
        );
        let texts: Vec<String> = missing.iter().filter_map(|own| own.text(&self.world)).collect();
        format!("it needs that {}", texts.join(", and that "))
    }

    /// Ends an order: its effects, and the mishap that was drawn for it.
    fn finish(&mut self, running: Running) -> Result<Progress, RobotError> {
        let Running {
            step,
            outcomes,
            number,
            possible,
            ..
        } = running;
        if !possible {
            return Ok(Progress::Failed {
                reason: self.why_impossible(&step),
            });
        }
        let drawn = self.mishaps.remove(&number);
        let kind = drawn.map(|mut random| {
            let kind = Mishap::drawn(&mut random, &self.options.kinds);
            (kind, random)
        });
        self.counts.mishaps += u64::from(kind.is_some());
        let mut failed = None;
        match &kind {
            Some((Mishap::Fails, _)) => failed = Some("it slipped off".to_owned()),
            Some((Mishap::NoEffect, _)) => {}
            _ => {
                let action = self.world.domain().action(step.action).clone();
                let changes = apply(&self.world, &mut self.state, &action, &step.arguments);
                self.history.record(&self.world, &changes);
            }
        }
        if let Some((kind, mut random)) = kind {
            self.history.befall(kind, &self.world, &mut self.state, &mut random);
        }
        let outcome = self.outcome(&outcomes);
        self.keep()?;
        Ok(match failed {
            Some(reason) => Progress::Failed { reason },
            None => Progress::Done { outcome },
        })
    }

    /// Draws the outcome of a sensing step; one that is known stays as it is.
    fn outcome(&mut self, outcomes: &[Fact]) -> Option<usize> {
        if outcomes.is_empty() {
            return None;
        }
        let known = outcomes.iter().position(|fact| self.state.holds(*fact));
        let drawn = known.unwrap_or_else(|| self.random.below(outcomes.len() as u64) as usize);
        self.state.set(outcomes[drawn], true);
        Some(drawn)
    }
}

impl Robot for Sim {
    fn describe(&self) -> &Description {
        &self.description
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.check()?;
        let step = self.step_of(order)?;
        let action = self.world.domain().action(step.action);
        let senses = action.senses.iter();
        let arguments = &step.arguments;
        let outcomes = senses.map(|atom| {
            let entity = |term: &longstep_core::model::Term| match term {
                longstep_core::model::Term::Variable(slot) => arguments[*slot],
                longstep_core::model::Term::Constant(entity) => *entity,
            };
            Fact::new(atom.predicate, atom.terms.iter().map(entity))
        });
        let outcomes = outcomes.collect();
        let possible = self.is_possible(&step);
        self.counts.inapplicable += u64::from(!possible);
        for other in self.running.values() {
            let apart = independent(&self.world, &self.state, &step, &other.step);
            self.counts.conflicts += u64::from(!apart);
        }
        self.orders += 1;
        self.counts.orders = self.orders;
        let handle = Handle::new(self.orders);
        let ticks = 1 + self.random.below(u64::from(self.options.ticks)) as u32;
        self.running.insert(
            handle,
            Running {
                step,
                ticks,
                left: ticks,
                next: Instant::now() + self.options.pace,
                outcomes,
                number: self.orders,
                possible,
            },
        );
        Ok(handle)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        self.check()?;
        let pace = self.options.pace;
        let running = self.running.get_mut(&handle).ok_or(RobotError::UnknownHandle(handle))?;
        let now = Instant::now();
        if now < running.next {
            return Ok(Progress::Running(None));
        }
        running.left = running.left.saturating_sub(1);
        running.next = now + pace;
        if running.left > 0 {
            return Ok(Progress::Running(Some(Feedback {
                fraction: Some(1.0 - f64::from(running.left) / f64::from(running.ticks)),
                ..Feedback::default()
            })));
        }
        match self.running.remove(&handle) {
            Some(running) => self.finish(running),
            None => Err(RobotError::UnknownHandle(handle)),
        }
    }

    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError> {
        self.check()?;
        let mut entities: Vec<EntityId> = match scope {
            Scope::All => self.world.entities().map(|(entity, _)| entity).collect(),
            Scope::Entities(names) => names.iter().filter_map(|name| self.world.find(name)).collect(),
        };
        if self.options.sees < 100 {
            let (random, sees) = (&mut self.random, u64::from(self.options.sees));
            entities.retain(|_| random.below(100) < sees);
        }
        entities.retain(|entity| !self.world.entity(*entity).is_value);
        Ok(Seen::statements(&self.world, &self.state, &entities, &self.reports))
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.stop_switch().press();
        self.running.clear();
        Ok(())
    }

    fn stop_switch(&self) -> StopSwitch {
        let stopped = Arc::clone(&self.stopped);
        StopSwitch::new(move || stopped.store(true, Ordering::SeqCst))
    }

    fn begin_plan(&mut self, world: &World) {
        self.world.share_values(world);
        let domain = self.world.domain();
        let events = self.state.iter().filter(|fact| domain.words(fact.predicate()).event);
        for event in events.collect::<Vec<_>>() {
            self.state.set(event, false);
        }
    }

    fn revived(&self) -> Option<Box<dyn Robot>> {
        Some(Box::new(Self {
            description: self.description.clone(),
            world: self.world.clone(),
            state: self.state.clone(),
            reports: self.reports.clone(),
            options: self.options.clone(),
            random: self.random.clone(),
            mishaps: self.mishaps.clone(),
            history: self.history.clone(),
            running: BTreeMap::new(),
            orders: self.orders,
            stopped: Arc::default(),
            counts: self.counts,
        }))
    }

    fn wait(&mut self, limit: Duration) {
        if !self.options.pace.is_zero() {
            std::thread::sleep(limit.min(self.options.pace).min(Duration::from_millis(5)));
        }
    }
}
