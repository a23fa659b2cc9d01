//! The robot of pyrobosim: the instructions of its suite from their goals, and its refusals.
//!
//! `LONGSTEP_PYROBOSIM=$(scripts/robots/pyrobosim.sh) cargo test -p longstep-robot --test pyrobosim -- --ignored --nocapture`
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

mod support;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use longstep_core::environment::World;
use longstep_core::execution::{Aim, Event};
use longstep_core::model::Domain;
use longstep_core::{domain, testing};
use longstep_robot::process::{Command, Process};
use longstep_robot::{Order, Progress, Robot};
use support::{carried_out, root};

fn folder() -> PathBuf {
    root().join("examples/robots/pyrobosim")
}

fn domain() -> Domain {
    let text = |name: &str| {
        (
            name.to_owned(),
            std::fs::read_to_string(folder().join("domain").join(name)).unwrap(),
        )
    };
    let files = domain::Files::from_texts("pyrobosim", ["domain.pddl", "domain.toml"].map(text));
    domain::load(&files).unwrap_or_else(|error| panic!("{error}"))
}

fn scene_of(domain: &Domain, scene: &str) -> World {
    let file = folder().join(format!("domain/suite/scenes/{scene}.json"));
    testing::world_of(domain, std::fs::read_to_string(file).unwrap())
}

/// Starts the robot in the world of a scene.
fn robot_in(world: &World, scene: &str) -> Process {
    let python = std::env::var("LONGSTEP_PYROBOSIM").unwrap();
    let file = match scene {
        "simple_world" => "pddlstream_simple_world.yaml",
        _ => "test_world.yaml",
    };
    let program = folder().join("robot.py");
    let words = [python.as_str(), program.to_str().unwrap(), "--world", file];
    Command::new(words)
        .scene("pyrobosim", world.environment().clone())
        .open()
        .unwrap()
}

#[test]
#[ignore = "needs LONGSTEP_PYROBOSIM, the Python that scripts/robots/pyrobosim.sh prints"]
fn the_twenty_instructions_end_in_success() {
    let domain = domain();
    let suite: toml::Table = std::fs::read_to_string(folder().join("domain/suite/instructions.toml"))
        .unwrap()
        .parse()
        .unwrap();
    let begun = Instant::now();
    let (mut instructions, mut steps, mut repeated) = (0, 0, 0);
    for case in suite["case"].as_array().unwrap() {
        let (scene, goal) = (case["scene"].as_str().unwrap(), case["goal"].as_str().unwrap());
        let world = scene_of(&domain, scene);
        let plan = testing::plan_for(&world, goal);
        let mut robot = robot_in(&world, scene);
        let (execution, events, stop) = carried_out(&plan, &Aim::Goal(goal.to_owned()), &mut robot);
        assert_eq!(stop, None, "{goal}: {events:?}");
        let is_failure = |event: &&Event| matches!(event, Event::Failed { .. });
        let failures = events.iter().filter(is_failure).count();
        if failures == 0 {
            let is_difference = |event: &&Event| matches!(event, Event::Assessed { .. });
            assert_eq!(events.iter().find(is_difference), None, "{goal}");
            assert_eq!(execution.state(), &plan.ending().after, "{goal}");
        }
        repeated += failures;
        steps += events
            .iter()
            .filter(|event| matches!(event, Event::Performed { .. }))
            .count();
        instructions += 1;
    }
    println!(
        "{instructions} instructions, {steps} steps, {repeated} of them tried again, in {:.1} s",
        begun.elapsed().as_secs_f64()
    );
    assert_eq!(instructions, 20);
}

/// The robot's own refusals, one of each that it has for these actions.
#[test]
#[ignore = "needs LONGSTEP_PYROBOSIM, the Python that scripts/robots/pyrobosim.sh prints"]
fn every_refusal_is_a_failed_step_with_its_own_status() {
    let world = scene_of(&domain(), "test_world");
    let mut robot = robot_in(&world, "test_world");
    let mut perform = |action: &str, arguments: &[&str]| {
        let handle = robot.start(&Order::new(1, action, arguments.iter().copied())).unwrap();
        loop {
            match robot.poll(handle).unwrap() {
                Progress::Running(_) => robot.wait(Duration::from_millis(20)),
                Progress::Done { .. } => return "SUCCESS".to_owned(),
                Progress::Failed { reason } => return reason,
            }
        }
    };
    let mut statuses: BTreeMap<String, usize> = BTreeMap::new();
    for (action, arguments, expected) in [
        (
            "pick",
            &["<gala>", "<table_0>"][..],
            "PRECONDITION_FAILURE: Robot is at kitchen",
        ),
        ("approach", &["<trash>"], "SUCCESS"),
        (
            "pick",
            &["<fuji>", "<trash>"],
            "PRECONDITION_FAILURE: trash is not open",
        ),
        (
            "put-down",
            &["<gala>", "<trash>"],
            "PRECONDITION_FAILURE: No manipulated object",
        ),
        (
            "open",
            &["<my_desk>"],
            "PRECONDITION_FAILURE: Robot is at trash_top, not at my_desk_desktop",
        ),
        ("open", &["<trash>"], "SUCCESS"),
        (
            "pick",
            &["<gala>", "<trash>"],
            "PRECONDITION_FAILURE: gala is at table0_tabletop",
        ),
        ("pick", &["<fuji>", "<trash>"], "SUCCESS"),
        (
            "close",
            &["<trash>"],
            "PRECONDITION_FAILURE: Robot is holding an object",
        ),
        (
            "put-down",
            &["<gala>", "<trash>"],
            "PRECONDITION_FAILURE: Robot is holding fuji, not gala",
        ),
        ("approach", &["<table_0>"], "SUCCESS"),
        (
            "pick",
            &["<gala>", "<table_0>"],
            "PRECONDITION_FAILURE: Robot is already holding fuji",
        ),
        ("put-down", &["<fuji>", "<table_0>"], "SUCCESS"),
        (
            "close",
            &["<table_0>"],
            "PRECONDITION_FAILURE: Location: table0 is locked",
        ),
        ("enter", &["<kitchen>"], "SUCCESS"),
        (
            "close",
            &["<kitchen>"],
            "PRECONDITION_FAILURE: Robot is not at a closeable location",
        ),
        ("approach", &["<hall_bathroom_kitchen>"], "SUCCESS"),
        ("close", &["<hall_bathroom_kitchen>"], "SUCCESS"),
        ("approach", &["<hall_bedroom_kitchen>"], "SUCCESS"),
        ("close", &["<hall_bedroom_kitchen>"], "SUCCESS"),
        ("enter", &["<bedroom>"], "PLANNING_FAILURE: Failed to plan a path"),
    ] {
        let found = perform(action, arguments);
        assert!(found.starts_with(expected), "{action} {arguments:?}: {found}");
        *statuses.entry(found.split(':').next().unwrap().to_owned()).or_default() += 1;
    }
    println!("{statuses:?}");
    assert_eq!(statuses.len(), 3);
}
