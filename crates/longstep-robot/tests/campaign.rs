//! A sample of the runs that `examples/measure_execution` measures.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub, dead_code)]

#[path = "../examples/measure_execution/campaign.rs"]
mod campaign;

use campaign::{cases, in_lanes, lanes, monitored};

#[test]
fn every_run_ends_in_the_goal_or_with_a_proven_reason() {
    let cases = cases(&["household", "branching"]);
    assert!(cases.len() > 20, "{}", cases.len());
    for index in 0..60 {
        let case = &cases[index * 7 % cases.len()];
        let run = monitored(case, index as u64, 1 + index as u32 % 3);
        let name = format!("{} seed {index}", case.name);
        assert_eq!((run.counts.inapplicable, run.watcher.unapproved), (0, 0), "{name}");
        match run.stop {
            None => assert!(run.reached, "{name}"),
            Some(stop) => assert!(stop.is_proven(), "{name}: {}", stop.sentence(&case.world)),
        }
    }
}

#[test]
fn lanes_of_any_speed_reach_the_predicted_end() {
    for (seed, case) in lanes(8).iter().enumerate() {
        let run = in_lanes(case, seed as u64, 0);
        assert!(run.stop.is_none() && run.as_promised, "{}", case.name);
        assert_eq!((run.counts.conflicts, run.counts.inapplicable), (0, 0), "{}", case.name);
    }
}
