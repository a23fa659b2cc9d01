//! Measures executions in the simulator; `docs/reference/execution.md` has the figures.
//!
//!     cargo run -p longstep-robot --example measure_execution -- runs 1000 [FIRST SEED]
//!     cargo run -p longstep-robot --example measure_execution -- lanes 200
//!     cargo run -p longstep-robot --example measure_execution -- cost 40

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs,
    unreachable_pub,
    dead_code
)]

mod campaign;

use std::time::Duration;

use campaign::{cases, costs, in_lanes, kitchen_of, lanes, monitored, plain};

const SUITES: [&str; 5] = ["household", "kitchen", "long", "branching", "two-arms"];

fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let count = arguments.get(2).and_then(|text| text.parse().ok());
    let first = arguments.get(3).and_then(|text| text.parse().ok());
    match arguments.get(1).map(String::as_str) {
        Some("runs") => runs(count.unwrap_or(1_000), first.unwrap_or(0)),
        Some("lanes") => side_by_side(count.unwrap_or(200)),
        Some("cost") => cost(count.unwrap_or(40)),
        _ => println!("runs [COUNT [FIRST SEED]] | lanes [COUNT] | cost [ENTITIES]"),
    }
}

fn runs(count: usize, first: u64) {
    let cases = cases(&SUITES);
    let (mut reached, mut proven, mut other, mut wrong, mut plainly) = (0, 0, Vec::new(), Vec::new(), 0);
    let (mut inapplicable, mut unapproved, mut changes, mut skipped, mut mishaps, mut steps) = (0, 0, 0, 0, 0, 0);
    for index in 0..count {
        // A prime step spreads few runs over all suites.
        let case = &cases[index * 97 % cases.len()];
        let (seed, faults) = (first + index as u64, 1 + index as u32 % 3);
        let run = monitored(case, seed, faults);
        inapplicable += run.counts.inapplicable;
        mishaps += run.counts.mishaps;
        steps += run.counts.orders;
        unapproved += run.watcher.unapproved;
        changes += run.watcher.changes;
        skipped += run.watcher.skipped;
        match &run.stop {
            None if run.reached => reached += 1,
            None => wrong.push(format!("{} seed {seed} faults {faults}", case.name)),
            Some(stop) if stop.is_proven() => proven += 1,
            Some(stop) => other.push(format!(
                "{} seed {seed} faults {faults}: {}",
                case.name,
                stop.sentence(&case.world)
            )),
        }
        plainly += usize::from(plain(case, seed, faults));
    }
    let share = |part: usize| 100.0 * part as f64 / count as f64;
    println!("cases {}, runs {count}, mishaps {mishaps}, steps {steps}", cases.len());
    println!(
        "goal reached in the observed world: {reached} ({:.1} %)",
        share(reached)
    );
    println!("stopped with a proven reason: {proven} ({:.1} %)", share(proven));
    println!("stopped without a proof: {}", other.len());
    println!("claimed and not reached: {}", wrong.len());
    println!("steps whose precondition did not hold: {inapplicable}");
    println!("unapproved changes performed: {unapproved}; changes {changes}, skips {skipped}");
    println!("plain executor reaches the goal: {plainly} ({:.1} %)", share(plainly));
    other
        .iter()
        .chain(&wrong)
        .take(20)
        .for_each(|line| println!("  {line}"));
}

fn side_by_side(count: usize) {
    let plans = lanes(count);
    let (mut promised, mut conflicts, mut inapplicable, mut together) = (0, 0, 0, 0);
    for (seed, plan) in plans.iter().enumerate() {
        let run = in_lanes(plan, seed as u64, 0);
        promised += usize::from(run.as_promised && run.stop.is_none());
        conflicts += run.counts.conflicts;
        inapplicable += run.counts.inapplicable;
        together += usize::from(run.together > 1);
    }
    println!(
        "different plans with lanes {}, as promised {promised}, with steps at the same time {together}",
        plans.len()
    );
    println!("conflicting steps at the same time {conflicts}, steps whose precondition did not hold {inapplicable}");
}

fn cost(entities: usize) {
    let cases = kitchen_of(entities);
    let mut all: Vec<Duration> = cases.iter().flat_map(costs).collect();
    if all.is_empty() {
        return println!("no kitchen");
    }
    all.sort_unstable();
    let at = |percent: usize| all[(all.len() - 1) * percent / 100];
    println!("entities {}, steps {}", cases[0].world.entities().count(), all.len());
    println!(
        "monitoring a step: median {:?}, 99 % {:?}, most {:?}",
        at(50),
        at(99),
        at(100)
    );
}
