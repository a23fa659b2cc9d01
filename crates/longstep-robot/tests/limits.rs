//! Random plans, skill values, levels and limits in the simulator: what a robot receives is within them.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub)]

#[path = "support/agreeing.rs"]
mod agreeing;

use std::collections::BTreeSet;
use std::time::{Duration, Instant};

use longstep_core::autonomy::Autonomy;
use longstep_core::environment::{self, Observation, World};
use longstep_core::execution::{
    Aim, Approval, BeginError, Event, Execution, Proposal, Settings, StepOrder, Stop, Unseen,
};
use longstep_core::search::{Limits, Outcome, solve};
use longstep_core::skill::Skills;
use longstep_core::verify::{VerifiedPlan, check};
use longstep_core::{domain, goal};
use longstep_robot::{
    Description, Driven, Handle, Order, Progress, Robot, RobotError, RunControl, Scope, Sim, StopSwitch, Watcher,
    drive, reports,
};
use serde_json::{Map, Value, json};

use agreeing::Agreeing;

const SCENE: &str = r#"{"assets": ["<table>", "<shelf>", "<desk>", "<fridge>", "<bin>"],
    "objects": ["<cup>", "<pen>", "<milk>", "<fridge_handle>"],
    "object_states": {"<cup>": "on_something(<table>)", "<pen>": "on_something(<desk>)",
        "<milk>": "inside_something(<fridge>)", "<fridge_handle>": "closed()"}}"#;

const GOALS: [&str; 5] = [
    "put(cup, shelf)",
    "put(pen, bin) & put(cup, desk)",
    "put(milk, table)",
    "put(cup, fridge) & closed(fridge)",
    "opened(fridge)",
];

const ACTIONS: [&str; 6] = [
    "move-hand",
    "grasp",
    "attach",
    "release",
    "open-by-rotate",
    "move-object",
];

/// Numbers that look random and are the same each time (SplitMix64).
struct Draws(u64);

impl Draws {
    fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % limit as u64) as usize
    }

    fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}

/// The household, in which two actions have a speed and one has a force.
fn household() -> World {
    let mut files = domain::shipped_files("household").unwrap();
    let declared = r#"
        [[action]]
        name = "move-hand"
        skill = [{ name = "speed", type = "number", unit = "m/s", from = "robot" }]
        [[action]]
        name = "move-object"
        skill = [{ name = "speed", type = "number", unit = "m/s", from = "robot" }]
        [[action]]
        name = "grasp"
        skill = [{ name = "grip", type = "force", unit = "N", from = "robot" }]"#;
    files.skills = Some(("skills.toml".to_owned(), declared.to_owned()));
    environment::parse(&domain::load(&files).unwrap(), "env.json", SCENE).unwrap()
}

fn plan_for(world: &World, text: &str) -> VerifiedPlan {
    let purpose = goal::parse(world, text).unwrap().purpose(world);
    let Outcome::Solved { plan, .. } = solve(world, &purpose, &Limits::default()) else {
        panic!("no plan for {text}")
    };
    check(world, plan, &purpose).into_verified().unwrap()
}

/// Tenths of a unit: 0.1 to 1.0.
fn tenths(draws: &mut Draws) -> f64 {
    (1 + draws.below(10)) as f64 / 10.0
}

/// Draws values for the skill parameters: for any argument, and for some arguments others.
fn skills(world: &World, draws: &mut Draws) -> Skills {
    let mut actions = Map::new();
    for (action, parameter, any) in [
        ("move-hand", "speed", json!(["_"])),
        ("move-object", "speed", json!(["_", "_"])),
        ("grasp", "grip", json!(["_"])),
    ] {
        let mut entries = vec![json!({"arguments": any, "values": {parameter: tenths(draws)}})];
        if action != "move-object" {
            let entity = draws.of(&["<cup>", "<pen>", "<milk>", "<fridge_handle>"]);
            entries.push(json!({"arguments": [entity], "values": {parameter: tenths(draws)}}));
        }
        actions.insert(action.to_owned(), Value::Array(entries));
    }
    Skills::from_value(world.domain(), Value::Object(actions)).unwrap()
}

/// The levels and limits of a case, as this test checks them, and the file that says so.
#[derive(Default)]
struct Drawn {
    never: BTreeSet<&'static str>,
    /// By parameter: the range.
    ranges: Vec<(&'static str, f64, f64)>,
    forbidden: BTreeSet<&'static str>,
    text: String,
}

fn drawn(draws: &mut Draws) -> Drawn {
    let mut drawn = Drawn::default();
    drawn.text.push_str("[autonomy]\nannounce_s = 0\n");
    for action in ACTIONS {
        match draws.below(12) {
            0 => {
                drawn.never.insert(action);
                drawn.text.push_str(&format!("{action} = \"never\"\n"));
            }
            1 => drawn.text.push_str(&format!("{action} = \"approve\"\n")),
            2 => drawn.text.push_str(&format!("{action} = \"announce\"\n")),
            _ => {}
        }
    }
    for (parameter, unit) in [("speed", "m/s"), ("grip", "N")] {
        if draws.below(2) == 0 {
            let (minimum, maximum) = (draws.below(6), 3 + draws.below(10));
            let [minimum, maximum] = [minimum, minimum.max(maximum)].map(|own| own as f64 / 10.0);
            drawn.ranges.push((parameter, minimum, maximum));
            drawn.text.push_str(&format!(
                "[[limit]]\nparameter = \"{parameter}\"\nmin = {minimum}\nmax = \"{maximum} {unit}\"\n"
            ));
        }
    }
    if draws.below(3) == 0 {
        let place = draws.of(&["desk", "bin", "shelf", "pen"]);
        drawn.forbidden.insert(place);
        drawn.text.push_str(&format!("[[limit]]\nforbidden = [\"{place}\"]\n"));
    }
    drawn
}

impl Drawn {
    /// Returns what is outside of the levels and limits in an order as the robot received it.
    fn mistake(&self, order: &Order) -> Option<String> {
        if self.never.contains(order.action.as_str()) {
            return Some(format!("{} is never performed", order.action));
        }
        let bare = |argument: &String| argument.trim_matches(['<', '>']).to_owned();
        let place = order
            .arguments
            .iter()
            .map(bare)
            .find(|own| self.forbidden.contains(own.as_str()));
        if let Some(place) = place {
            return Some(format!("{place} is forbidden"));
        }
        self.ranges.iter().find_map(|(parameter, minimum, maximum)| {
            let value = order.skills.get(*parameter)?.as_f64()?;
            let is_within = *minimum <= value && value <= *maximum;
            (!is_within).then(|| format!("{parameter} is {value}"))
        })
    }
}

/// A simulator that keeps the orders that it receives.
struct Recording {
    sim: Sim,
    orders: Vec<Order>,
}

impl Robot for Recording {
    fn describe(&self) -> &Description {
        self.sim.describe()
    }

    fn start(&mut self, order: &Order) -> Result<Handle, RobotError> {
        self.orders.push(order.clone());
        self.sim.start(order)
    }

    fn poll(&mut self, handle: Handle) -> Result<Progress, RobotError> {
        self.sim.poll(handle)
    }

    fn observe(&mut self, scope: &Scope) -> Result<Observation, RobotError> {
        self.sim.observe(scope)
    }

    fn stop(&mut self) -> Result<(), RobotError> {
        self.sim.stop()
    }

    fn stop_switch(&self) -> StopSwitch {
        self.sim.stop_switch()
    }
}

/// Robots with mishaps, so that plans are changed within the limits too.
#[test]
fn no_order_is_outside_of_the_levels_and_limits() {
    let world = household();
    let plans = GOALS.map(|text| (text, plan_for(&world, text)));
    let (mut refused, mut done, mut stopped, mut changed) = (0, 0, 0, 0);
    for seed in 0..400 {
        let draws = &mut Draws(seed);
        let (text, plan) = &plans[draws.below(plans.len())];
        let (skills, drawn) = (skills(&world, draws), drawn(draws));
        let autonomy = Autonomy::parse(world.domain(), Some(&world), "autonomy.toml", &drawn.text).unwrap();
        let sim = Sim::new(
            world.clone(),
            &format!("seed={seed},faults=3,horizon=8").parse().unwrap(),
        )
        .unwrap();
        let mut robot = Recording {
            sim,
            orders: Vec::new(),
        };
        let settings = Settings::default()
            .with_approval(Approval::Never)
            .with_reports(reports(&robot, &world).unwrap())
            .with_skills(skills.clone())
            .with_autonomy(autonomy);
        // Refused exactly if a step of the plan is outside.
        let steps = 0..plan.steps().len();
        let orders = steps.map(|index| {
            let wanted = StepOrder::of_step(plan, longstep_core::plan::StepId::new(index), &skills);
            longstep_robot::order_of(&world, &wanted)
        });
        let outside: Vec<String> = orders.filter_map(|order| drawn.mistake(&order)).collect();
        let mut execution = match Execution::new(plan, &Aim::Goal((*text).to_owned()), settings) {
            Ok(execution) => execution,
            Err(BeginError::Refused(parts)) => {
                assert_eq!(parts.len(), outside.len(), "{seed}: {parts:?} {outside:?}");
                refused += 1;
                continue;
            }
            Err(error) => panic!("{seed}: {error}"),
        };
        assert!(outside.is_empty(), "{seed}: {outside:?}\n{}", drawn.text);
        let control = RunControl::of(&robot);
        let mut watcher = Agreeing(|_: &Execution, events: &[Event]| {
            changed += events.iter().filter(|own| matches!(own, Event::Changed { .. })).count();
        });
        match drive(&mut execution, &mut robot, &mut watcher, &control) {
            Driven::Done => done += 1,
            Driven::Stopped(Stop::NoPlan { .. } | Stop::GaveUp { .. }) => stopped += 1,
            other => panic!("{seed}: {other:?}"),
        }
        for order in &robot.orders {
            assert_eq!(drawn.mistake(order), None, "{seed}: {order:?}\n{}", drawn.text);
        }
    }
    assert!(
        refused > 100 && done > 50 && stopped > 0 && changed > 20,
        "{refused} {done} {stopped} {changed}"
    );
}

/// A person who presses stop at an announcement.
struct Careful {
    control: RunControl,
    presses: bool,
    announced: u32,
    ordered: Option<(Instant, Duration)>,
    last: Option<Instant>,
}

impl Watcher for Careful {
    fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
        for event in events {
            match event {
                Event::Announced { .. } => {
                    self.announced += 1;
                    self.last = Some(Instant::now());
                    if self.presses {
                        self.control.stop();
                    }
                }
                Event::Ordered { .. } => {
                    if let Some(last) = self.last.take() {
                        self.ordered = Some((last, last.elapsed()));
                    }
                }
                _ => {}
            }
        }
        Ok(())
    }

    fn approve(&mut self, _: &Execution, _: &Proposal) -> Option<bool> {
        Some(true)
    }

    fn judge(&mut self, _: &Execution, _: &StepOrder) -> Option<bool> {
        None
    }

    fn confirm(&mut self, _: &Execution, _: &Unseen) -> Option<bool> {
        None
    }
}

#[test]
fn announced_step_comes_after_its_time_unless_somebody_stops_the_run() {
    let world = household();
    let plan = plan_for(&world, GOALS[0]);
    let text = "[autonomy]\nannounce_s = 0.15\ngrasp = \"announce\"";
    for presses in [false, true] {
        let autonomy = Autonomy::parse(world.domain(), Some(&world), "autonomy.toml", text).unwrap();
        let sim = Sim::new(world.clone(), &"".parse().unwrap()).unwrap();
        let mut robot = Recording {
            sim,
            orders: Vec::new(),
        };
        let settings = Settings::default()
            .with_approval(Approval::Never)
            .with_reports(reports(&robot, &world).unwrap())
            .with_autonomy(autonomy);
        let mut execution = Execution::new(&plan, &Aim::Goal(GOALS[0].to_owned()), settings).unwrap();
        let control = RunControl::of(&robot);
        let mut careful = Careful {
            control: control.clone(),
            presses,
            announced: 0,
            ordered: None,
            last: None,
        };
        let driven = drive(&mut execution, &mut robot, &mut careful, &control);
        assert_eq!(careful.announced, 1);
        let has_grasped = robot.orders.iter().any(|order| order.action == "grasp");
        if presses {
            assert!(
                matches!(driven, Driven::Stopped(Stop::Requested(_))) && !has_grasped,
                "{driven:?}"
            );
        } else {
            let (_, waited) = careful.ordered.unwrap();
            assert!(driven == Driven::Done && has_grasped);
            assert!(waited >= Duration::from_millis(150), "{waited:?}");
        }
    }
}
