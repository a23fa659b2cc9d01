//! Runs that are begun at the same time.

#![allow(clippy::unwrap_used, missing_docs)]

mod support;

use std::time::Duration;

use longstep_robot::SimOptions;
use longstep_server::{Body, NewSession, Said};
use support::{hub, runtime, simulated};

#[test]
fn one_plan_begins_one_run_whatever_the_number_of_approvals() {
    let folder = tempfile::tempdir().unwrap();
    let sim: SimOptions = "ticks=5,pace=50".parse().unwrap();
    let hub = hub(&folder, vec![simulated("sim", sim, Body::PerSession)]);
    for _ in 0..10 {
        let id = hub.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
        let said = Said::Instruction("Put the pen on the shelf".to_owned());
        let snapshot = runtime().block_on(hub.say(&id, &said).unwrap().turn());
        let plan = snapshot.view.proposal.as_ref().unwrap().plan.clone();
        hub.accept(&id, &plan, "ada").unwrap();
        let approve = |_| {
            hub.approve(&id, &plan, "sim", "ada", Duration::from_secs(60))
                .unwrap()
                .id
        };
        let approvals: Vec<_> = (0..4).map(approve).collect();
        let begun = std::thread::scope(|scope| {
            let starts: Vec<_> = approvals
                .iter()
                .map(|approval| scope.spawn(|| hub.start(approval, false, "ada").is_ok()))
                .collect();
            starts
                .into_iter()
                .map(|start| start.join().unwrap())
                .filter(|begun| *begun)
                .count()
        });
        assert_eq!(begun, 1);
    }
    hub.stop_all("ada").unwrap();
}
