//! Seeded runs in the simulator, in a sample; `docs/reference/execution.md` has the figures of more of them.
//!
//!     LONGSTEP_RUNS=1000 LONGSTEP_SEED=700000 cargo test -p longstep-robot --test seeded goal -- --nocapture
//!     LONGSTEP_LANES=200 cargo test -p longstep-robot --test seeded lanes -- --nocapture
//!     cargo test -p longstep-robot --test seeded monitoring -- --nocapture

#![allow(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs,
    unreachable_pub,
    dead_code
)]

mod seeded_runs;

use std::time::Duration;

use seeded_runs::{cases, costs, in_lanes, kitchen_of, lanes, monitored, plain};

const SUITES: [&str; 5] = ["household", "kitchen", "long", "branching", "two-arms"];

fn setting(name: &str) -> Option<u64> {
    std::env::var(name).ok().map(|text| text.parse().unwrap())
}

/// Prints the share of runs without monitoring that reach the goal, if the number of runs is given.
#[test]
fn every_run_ends_in_the_goal_or_with_a_proven_reason() {
    let count = setting("LONGSTEP_RUNS");
    let cases = match count {
        Some(_) => cases(&SUITES),
        None => cases(&["household", "branching"]),
    };
    assert!(cases.len() > 20, "{}", cases.len());
    let first = setting("LONGSTEP_SEED").unwrap_or(0);
    let (mut reached, mut proven, mut unmonitored, mut mishaps, mut changes) = (0, 0, 0, 0, 0);
    for index in 0..count.unwrap_or(60) {
        // A prime step spreads few runs over all suites.
        let case = &cases[index as usize * 97 % cases.len()];
        let (seed, faults) = (first + index, 1 + index as u32 % 3);
        let run = monitored(case, seed, faults);
        let name = format!("{} seed {seed} faults {faults}", case.name);
        assert_eq!((run.counts.inapplicable, run.watcher.unapproved), (0, 0), "{name}");
        match run.stop {
            None => assert!(run.reached, "{name}"),
            Some(ref stop) => assert!(stop.is_proven(), "{name}: {}", stop.sentence(&case.world)),
        }
        *(if run.stop.is_none() { &mut reached } else { &mut proven }) += 1;
        mishaps += run.counts.mishaps;
        changes += run.watcher.changes;
        unmonitored += u64::from(count.is_some() && plain(case, seed, faults));
    }
    println!("{reached} runs reach the goal, {proven} stop with a proof; {mishaps} mishaps, {changes} changes");
    if count.is_some() {
        println!("{unmonitored} reach the goal without monitoring");
        assert!(unmonitored < reached);
    }
}

#[test]
fn lanes_of_any_speed_end_as_promised() {
    let cases = lanes(setting("LONGSTEP_LANES").unwrap_or(8) as usize);
    let mut together = 0;
    for (seed, case) in cases.iter().enumerate() {
        let run = in_lanes(case, seed as u64, 0);
        assert!(run.stop.is_none() && run.as_promised, "{}", case.name);
        assert_eq!((run.counts.conflicts, run.counts.inapplicable), (0, 0), "{}", case.name);
        together += usize::from(run.together > 1);
    }
    println!("{} plans, {together} with steps at the same time", cases.len());
    assert!(together > 0);
}

/// A bound far above the figure, which is a hundredth of it: a test runs beside others.
#[test]
fn monitoring_a_step_takes_little_time() {
    let cases = kitchen_of(40);
    let mut costs: Vec<Duration> = cases.iter().take(4).flat_map(costs).collect();
    costs.sort_unstable();
    let (median, longest) = (costs[costs.len() / 2], costs[costs.len() - 1]);
    println!(
        "{} steps among 40 entities: median {median:?}, at most {longest:?}",
        costs.len()
    );
    assert!(median < Duration::from_millis(10), "{median:?}");
}
