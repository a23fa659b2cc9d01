//! How fast plans are verified and repaired.
//!
//! `cargo bench -p longstep --bench verification`. The recorded replies and their kitchen are used when
//! `LONGSTEP_CORPUS` names the folder of the recorded plans.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

use std::hint::black_box;
use std::path::PathBuf;
use std::time::{Duration, Instant};

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use longstep::domain::{self, Domain};
use longstep_core::environment::{Claim, EntityId, World};
use longstep_core::plan::{Node, Plan, PlanFile, Step, StepId, TaskCohesion, Test, resolve};
use longstep_core::repair::{RepairOutcome, repair};
use longstep_core::testing;
use longstep_core::verify::{self, Purpose};

/// Carries the item to and fro between two places, a thousand steps.
fn carrying(world: &World, item: &str, places: [&str; 2]) -> Plan {
    let mut calls = Vec::new();
    for trip in 0..250 {
        let (from, to) = (places[trip % 2], places[(trip + 1) % 2]);
        calls.push(format!("Walktowards({from})"));
        calls.push(format!("Grab({item})"));
        calls.push(format!("Walktowards({to})"));
        calls.push(format!("Put({item}, {to})"));
    }
    let written = TaskCohesion {
        task_sequence: calls,
        ..TaskCohesion::default()
    };
    let steps = resolve(world, &written).complete().unwrap();
    verify::bind(world, &steps, &[], None).unwrap().0
}

fn verification(criterion: &mut Criterion) {
    let flat = PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("../../examples/environments/flat.json");
    let mut scenes = vec![(
        "flat",
        std::fs::read_to_string(flat).unwrap(),
        "<magazine_11>",
        ["<coffeetable_3>", "<sofa_2>"],
    )];
    if let Some(corpus) = std::env::var_os("LONGSTEP_CORPUS") {
        let kitchen = PathBuf::from(corpus).join("virtualhome14/kitchen.json");
        let text = std::fs::read_to_string(kitchen).unwrap();
        scenes.push(("kitchen", text, "<book_269>", ["<kitchentable_231>", "<bookshelf_250>"]));
    }
    let mut group = criterion.benchmark_group("verify 1000 steps");
    for (name, text, item, places) in scenes {
        let world = testing::world("virtualhome", &text);
        let plan = carrying(&world, item, places);
        let report = verify::check(&world, plan.clone(), &Purpose::default());
        assert_eq!(report.violations, vec![], "{name}");
        group.throughput(Throughput::Elements(plan.steps().len() as u64));
        group.bench_function(name, |bencher| {
            bencher.iter_batched(
                || plan.clone(),
                |plan| verify::check(&world, black_box(plan), &Purpose::default()),
                criterion::BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

/// A hall with so many tables, and a sponge that the hand holds on the first one.
fn hall(domain: &Domain, tables: usize) -> World {
    let names: Vec<String> = (1..=tables).map(|number| format!("\"<table_{number}>\"")).collect();
    let text = format!(
        r#"{{"assets": [{}], "objects": ["<sponge>"], "object_states": {{"<sponge>": ["on_something(<table_1>)", "inside_hand()"]}}}}"#,
        names.join(", ")
    );
    testing::world_of(domain, &text)
}

/// A thousand branches, each on whether a table is clean: the first table again and again, which is wiped either way, or
/// each on another one.
fn branches(world: &World, apart: bool) -> Plan {
    let domain = world.domain();
    let named = |name: &str| domain.action_ids().find(|(_, action)| action.name == name).unwrap().0;
    let sponge = world.find("<sponge>").unwrap();
    let mut steps = Vec::new();
    let mut body = Vec::new();
    let mut add = |name: &str, arguments: Vec<EntityId>| {
        steps.push(Step::explained(world, named(name), arguments));
        StepId::new(steps.len() - 1)
    };
    let first = world.find("<table_1>").unwrap();
    if apart {
        body.push(Node::Step(add("release", vec![sponge])));
    } else {
        body.push(Node::Step(add("move-hand", vec![first])));
    }
    for number in 1..=1_000 {
        let table = if apart {
            world.find(&format!("<table_{number}>")).unwrap()
        } else {
            first
        };
        if apart {
            body.push(Node::Step(add("move-hand", vec![table])));
        }
        let condition = Test::Sense(add("check-cleanness", vec![table]));
        let mut wiped = |times: usize| -> Vec<Node> {
            let times = if apart { 0 } else { times };
            (0..times)
                .map(|_| Node::Step(add("wipe", vec![sponge, table])))
                .collect()
        };
        let (then, otherwise) = (wiped(1), wiped(2));
        body.push(Node::If {
            condition,
            then,
            otherwise,
        });
    }
    Plan::tree(steps, body).unwrap()
}

fn branching(criterion: &mut Criterion) {
    let domain = domain::shipped("household-checks").unwrap().unwrap();
    let mut group = criterion.benchmark_group("verify 1000 branches");
    for (name, apart) in [("that come together", false), ("that do not", true)] {
        let world = hall(&domain, 1_000);
        let plan = branches(&world, apart);
        let report = verify::check(&world, plan.clone(), &Purpose::default());
        let kinds: Vec<&str> = report.violations.iter().map(|violation| violation.kind()).collect();
        println!(
            "{name}: {} steps, {} endings, {kinds:?}",
            plan.steps().len(),
            report.endings.len()
        );
        group.bench_function(name, |bencher| {
            bencher.iter_batched(
                || plan.clone(),
                |plan| verify::check(&world, black_box(plan), &Purpose::default()),
                criterion::BatchSize::SmallInput,
            );
        });
    }
    group.finish();
}

/// Every recorded reply on its own: the median and the worst of their medians.
fn repairing(_: &mut Criterion) {
    let Some(corpus) = std::env::var_os("LONGSTEP_CORPUS") else {
        return;
    };
    let read = |file: &str| -> serde_json::Value {
        let path = PathBuf::from(&corpus).join("virtualhome14").join(file);
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
    };
    let domain = domain::shipped("virtualhome").unwrap().unwrap();
    let scenarios = read("scenarios.json");
    let kitchen = testing::world_of(&domain, read("kitchen.json"));
    let mut times: Vec<(Duration, String)> = Vec::new();
    let mut in_kitchen: Vec<(Duration, String)> = Vec::new();
    for trial in read("recorded_trials.json").as_array().unwrap() {
        let scenario = scenarios
            .as_array()
            .unwrap()
            .iter()
            .find(|s| s["id"] == trial["scenario"])
            .unwrap();
        let world = testing::world_of(&domain, &scenario["environment"]);
        let name = format!("scenario {}, trial {}", trial["scenario"], trial["trial"]);
        let file: PlanFile = serde_json::from_value(trial["reply"].clone()).unwrap();
        times.push((repair_time(&world, &file), name.clone()));
        in_kitchen.push((repair_time(&kitchen, &file), name));
    }
    for (place, mut times) in [("their own scenes", times), ("the kitchen of 40 things", in_kitchen)] {
        times.sort();
        let (median, (worst, which)) = (times[times.len() / 2].0, times.last().unwrap());
        let count = times.len();
        println!("repair of {count} recorded replies in {place}: median {median:?}, worst {worst:?} ({which})");
    }
}

/// The median of 21 repairs.
fn repair_time(world: &World, file: &PlanFile) -> Duration {
    let claim = file.environment_after.as_ref();
    let purpose = Purpose {
        claim: claim.map(|claimed| Claim::read(world, claimed)),
        ..Purpose::default()
    };
    let draft = resolve(world, &file.task_cohesion);
    let mut runs: Vec<Duration> = (0..21)
        .map(|_| {
            let started = Instant::now();
            let outcome = repair(world, black_box(&draft), &purpose);
            let time = started.elapsed();
            assert!(
                matches!(outcome, RepairOutcome::Valid(_) | RepairOutcome::Repaired(_)),
                "{outcome:?} {:?}",
                file.task_cohesion.task_sequence
            );
            time
        })
        .collect();
    runs.sort_unstable();
    runs[runs.len() / 2]
}

criterion_group!(benches, verification, branching, repairing);
criterion_main!(benches);
