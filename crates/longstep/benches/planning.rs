//! How fast verification and search are, without any model.
//!
//! The scenes are the example environments and, when `LONGSTEP_CORPUS` names the folder of the recorded plans,
//! its kitchen. `cargo bench -p longstep` prints the figures.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::hint::black_box;
use std::path::PathBuf;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use longstep::domain::{self, Domain};
use longstep::goal::{self, Goal};
use longstep_core::environment::World;
use longstep_core::plan::Plan;
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::testing;
use longstep_core::verify;

fn scene(domain: &Domain, file: PathBuf) -> World {
    let text = std::fs::read_to_string(&file).unwrap();
    testing::world_of(domain, &text)
}

fn example(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
        .join("../../examples/environments")
        .join(name)
}

fn plan_for(world: &World, goal: &Goal) -> Plan {
    let outcome = search::solve(world, &goal.purpose(world), &Limits::default());
    let Outcome::Solved { plan, .. } = outcome else {
        panic!("{outcome:?}")
    };
    plan
}

fn planning(criterion: &mut Criterion) {
    let mut cases = vec![
        ("pantry", "household", example("pantry.json"), "put(butter, shelf top)"),
        ("flat", "virtualhome", example("flat.json"), "heated(cupcake, oven)"),
    ];
    if let Some(corpus) = std::env::var_os("LONGSTEP_CORPUS") {
        let kitchen = PathBuf::from(corpus).join("virtualhome14/kitchen.json");
        cases.push((
            "kitchen, one goal",
            "virtualhome",
            kitchen.clone(),
            "put(book, bookshelf)",
        ));
        cases.push(("kitchen, heating", "virtualhome", kitchen.clone(), "heated(pie, stove)"));
        cases.push((
            "kitchen, four goals",
            "virtualhome",
            kitchen,
            "put(pie, fridge) & put(book, bookshelf) & on(tv) & wet(sponge)",
        ));
    }
    for (name, domain, file, goal) in cases {
        let domain = domain::shipped(domain).unwrap().unwrap();
        let world = scene(&domain, file);
        let goal = goal::parse(&world, goal).unwrap();
        let plan = plan_for(&world, &goal);
        let purpose = goal.purpose(&world);
        let mut group = criterion.benchmark_group(name);
        group.sample_size(20);
        group.bench_function("search", |bencher| {
            bencher.iter(|| search::solve(&world, black_box(&purpose), &Limits::default()));
        });
        group.throughput(Throughput::Elements(plan.steps().len() as u64));
        group.bench_function("verify", |bencher| {
            bencher.iter(|| verify::check(&world, black_box(plan.clone()), &purpose));
        });
        group.finish();
    }
}

criterion_group!(benches, planning);
criterion_main!(benches);
