//! The plans of all shipped suites as behavior trees, ticked by BehaviorTree.CPP.
//!
//! `export LONGSTEP_BEHAVIOR_TREES="$(tools/peers/behavior_trees/build.sh)"
//! LONGSTEP_BEHAVIOR_TREES_PYTHON="$(tools/peers/behavior_trees/python.sh)"; cargo test -p longstep-eval --test behavior_trees --
//! --ignored`

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic)]

mod example;
mod hostile;
mod nodes;
mod workshop;

use longstep_core::plan::behavior_tree::{Guards, write};
use longstep_core::plan::read;
use longstep_core::tree_peer::{End, Peer, Trouble};
use longstep_core::verify::check_file;
use longstep_eval::suite;

/// Numbers below a bound from a seed.
fn choices(seed: usize) -> impl FnMut(usize) -> usize {
    let mut state = seed as u64 + 1;
    move |bound| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % bound as u64).unwrap()
    }
}

#[test]
#[ignore = "needs LONGSTEP_BEHAVIOR_TREES, which tools/peers/behavior_trees/build.sh prints"]
fn behavior_tree_cpp_ticks_the_plans_of_all_suites() {
    let folder = tempfile::tempdir().unwrap();
    let program = std::env::var("LONGSTEP_BEHAVIOR_TREES").unwrap();
    let mut peer = Peer::start(program.as_ref(), folder.path()).unwrap();
    let (mut count, mut runs, mut failed) = (0, 0, 0);
    for name in suite::shipped_names() {
        let (_, suite) = suite::load_shipped(name).unwrap().unwrap();
        for (plan, _) in suite.plans().unwrap() {
            count += 1;
            let mut choose = choices(count);
            for guards in [Guards::None, Guards::Preconditions] {
                let xml = write(plan.world(), plan.plan(), guards).unwrap();
                let again = read(&xml).unwrap();
                let again = check_file(plan.world(), &again.file).unwrap();
                assert_eq!(again.plan.steps(), plan.plan().steps(), "{xml}");
                let change = Trouble::Change(1 + choose(plan.steps().len().max(1)));
                let failure = Trouble::Failure(choose(plan.steps().len().max(1)));
                for trouble in [Trouble::None, Trouble::None, Trouble::None, failure, change] {
                    if guards == Guards::None && trouble == change {
                        continue;
                    }
                    let end = peer.tick(&plan, &xml, trouble, &mut choose);
                    let end = end.unwrap_or_else(|error| panic!("{name}, {trouble:?}: {error}\n{xml}"));
                    assert_ne!(end, End::Endless);
                    runs += 1;
                    failed += usize::from(end == End::Failed);
                }
            }
        }
    }
    println!("{count} plans, {runs} runs, of which {failed} failed where they had to");
    assert!(count > 300 && failed > 300, "{count} {failed}");
}
