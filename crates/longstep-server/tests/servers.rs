//! Several servers at one database.
//!
//! `export "$(scripts/postgres.sh --parent $$)"; cargo test -p longstep-server --features postgres --test servers --
//! --ignored`

#![allow(clippy::unwrap_used, missing_docs, unreachable_pub)]

#[path = "support/database.rs"]
mod database;
mod support;

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use database::Database;
use longstep_robot::SimOptions;
use longstep_server::{
    APPROVAL_LIFETIME, ApprovalId, Body, Deed, Hub, NewSession, PostgresOptions, PostgresStore, Problem, ProblemKind,
    RunId, RunState, Said, SessionId, Snapshot,
};
use support::{hub_at, runtime, simulated, until};

const LEASE: Duration = Duration::from_secs(1);

/// A server with the robots `sim`, `slow`, which takes a minute for each step, and `arm`, which all sessions share.
fn server(database: &Database) -> Arc<Hub> {
    let options = PostgresOptions::default().with_lease(LEASE);
    let store = PostgresStore::open(&database.address, options).unwrap();
    let slow: SimOptions = "ticks=1,pace=60000".parse().unwrap();
    let robots = vec![
        simulated("sim", SimOptions::default(), Body::PerSession),
        simulated("slow", slow.clone(), Body::PerSession),
        simulated("arm", slow, Body::Shared),
    ];
    hub_at(Arc::new(store), robots).unwrap()
}

fn said(hub: &Arc<Hub>, id: &SessionId, text: &str) -> Result<Arc<Snapshot>, Problem> {
    let waiting = hub.say(id, &Said::Instruction(text.to_owned()))?;
    Ok(runtime().block_on(waiting.turn()))
}

/// Begins a session, and accepts a plan in it. Returns its hash.
fn accepted(hub: &Arc<Hub>) -> (SessionId, String) {
    let id = hub.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
    let shown = said(hub, &id, "Put the pen on the shelf").unwrap();
    let plan = shown.view.proposal.as_ref().unwrap().plan.clone();
    hub.accept(&id, &plan, "ada").unwrap();
    (id, plan)
}

fn approved(hub: &Arc<Hub>, robot: &str) -> (SessionId, ApprovalId) {
    let (id, plan) = accepted(hub);
    let approval = hub.approve(&id, &plan, robot, "ada", APPROVAL_LIFETIME).unwrap();
    (id, approval.id)
}

fn started(hub: &Arc<Hub>, robot: &str) -> (SessionId, RunId) {
    let (id, approval) = approved(hub, robot);
    let run = hub.start(&approval, false, "ada").unwrap().record.id.clone();
    until(hub, &run, |run| run.state == RunState::Running);
    (id, run)
}

fn is_busy<T>(result: Result<T, Problem>) -> bool {
    result.is_err_and(|problem| problem.kind == ProblemKind::Busy && problem.hint.is_some())
}

/// Waits until something is so; returns the time that it took.
fn eventually(mut is_so: impl FnMut() -> bool) -> Duration {
    let began = Instant::now();
    while !is_so() {
        assert!(began.elapsed() < Duration::from_secs(20));
        thread::sleep(Duration::from_millis(5));
    }
    began.elapsed()
}

/// Makes all that is owned now the property of a server that died just now.
fn let_owners_die(database: &Database) {
    database.run(&format!(
        "UPDATE longstep_log SET owner = 'dead', epoch = epoch + 1, expires = clock_timestamp() + interval '{} seconds'
         WHERE owner IS NOT NULL",
        LEASE.as_secs()
    ));
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn any_server_serves_any_session() {
    let database = Database::new();
    let servers = [server(&database), server(&database), server(&database)];
    let [one, two, three] = &servers;
    let id = one.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
    let plan = said(two, &id, "Put the pen on the shelf").unwrap();
    let plan = plan.view.proposal.as_ref().unwrap().plan.clone();
    for hub in &servers {
        let view = &hub.session(&id).unwrap().view;
        assert_eq!((view.state, &view.proposal.as_ref().unwrap().plan), ("plan", &plan));
    }
    three.accept(&id, &plan, "ada").unwrap();
    assert_eq!(one.accept(&id, &plan, "ada").unwrap_err().kind, ProblemKind::Conflict);
    let approval = two.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    let run = one.start(&approval.id, false, "ada").unwrap().record.id.clone();
    for hub in &servers {
        assert_eq!(until(hub, &run, |run| run.state.is_ended()).state, RunState::Done);
        assert_eq!(hub.runs().len(), 1);
    }
    // Whoever sees the end of the run can go on with the session.
    let next = said(three, &id, "Put the cup on the shelf").unwrap();
    assert_eq!(next.view.state, "plan");
    for hub in &servers {
        let view = &hub.session(&id).unwrap().view;
        assert!(!view.accepted[0].pending && view.proposal.is_some());
        assert_eq!(
            view.environment.object_states["<pen>"].as_slice(),
            ["on_something(<shelf>)"]
        );
        assert_eq!(hub.sessions().unwrap(), std::slice::from_ref(&id));
        let deeds = hub.audit().last(100).unwrap();
        assert_eq!(
            deeds
                .iter()
                .filter(|entry| matches!(entry.deed, Deed::Ended { .. }))
                .count(),
            1
        );
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_session_on_which_a_server_works_is_shown_and_not_changed_by_others() {
    let database = Database::new();
    let (one, other) = (server(&database), server(&database));
    let (id, plan) = accepted(&one);
    one.say(&id, &Said::Instruction("wait for me".to_owned()))
        .unwrap()
        .leave();
    let view = &other.session(&id).unwrap().view;
    assert_eq!((view.state, view.accepted.len()), ("thinking", 1));
    assert!(is_busy(said(&other, &id, "Put the cup on the shelf")) && is_busy(other.cancel(&id)));
    assert!(is_busy(other.undo(&id)) && is_busy(other.accept(&id, &plan, "ada")));
    one.cancel(&id).unwrap();
    eventually(|| said(&other, &id, "Put the cup on the shelf").is_ok());
    assert_eq!(one.session(&id).unwrap().view.state, "plan");
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn an_approval_is_used_once_whatever_server_gets_the_request() {
    let database = Database::new();
    let servers = [server(&database), server(&database)];
    for _ in 0..6 {
        let (_, approval) = approved(&servers[0], "sim");
        let begun = thread::scope(|scope| {
            let starts: Vec<_> = (0..6)
                .map(|number| {
                    let (hub, approval) = (&servers[number % 2], &approval);
                    // A refusal because of the other server is no answer.
                    scope.spawn(move || {
                        loop {
                            match hub.start(approval, false, "ada") {
                                Err(problem) if problem.kind == ProblemKind::Busy => thread::yield_now(),
                                result => return result.is_ok(),
                            }
                        }
                    })
                })
                .collect();
            let begun: Vec<bool> = starts.into_iter().map(|start| start.join().unwrap()).collect();
            begun.iter().filter(|begun| **begun).count()
        });
        assert_eq!(begun, 1);
    }
    eventually(|| servers[0].runs().iter().all(|run| run.state == RunState::Done));
    assert_eq!(servers[1].runs().len(), 6);
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_stop_reaches_the_robot_of_another_server() {
    let database = Database::new();
    let (one, other) = (server(&database), server(&database));
    for stops_all in [false, true] {
        let (_, run) = started(&one, "slow");
        assert_eq!(other.run(&run).unwrap().state, RunState::Running);
        assert!(is_busy(other.pause(&run, "ada")) && is_busy(other.go_on(&run, "ada")));
        assert!(is_busy(other.decide(&run, "question-1", true, "ada")));
        if stops_all {
            assert_eq!(other.stop_all("ada").unwrap(), 1);
        } else {
            other.stop(&run, "ada").unwrap();
        }
        let time = eventually(|| one.run(&run).unwrap().state == RunState::Stopped);
        assert!(time < Duration::from_secs(2), "{time:?}");
        assert_eq!(other.run(&run).unwrap().state, RunState::Stopped);
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_robot_moves_for_one_server_at_a_time() {
    let database = Database::new();
    let (one, other) = (server(&database), server(&database));
    let (_, run) = started(&one, "arm");
    let (_, approval) = approved(&other, "arm");
    assert!(is_busy(other.start(&approval, false, "ada")));
    // Through the server of the robot it waits for the robot.
    let (_, waits) = approved(&other, "arm");
    let waits = one.start(&waits, false, "ada").unwrap().record.id.clone();
    assert_eq!(other.run(&waits).unwrap().state, RunState::Queued);
    one.stop(&waits, "ada").unwrap();
    one.stop(&run, "ada").unwrap();
    until(&one, &run, |run| run.state.is_ended());
    // The approval was not used up.
    eventually(|| other.start(&approval, false, "ada").is_ok());
    assert!(other.start(&approval, false, "ada").is_err());
    assert_eq!(other.stop_all("ada").unwrap(), 1);
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_run_whose_lease_is_lost_stops_its_robot() {
    let database = Database::new();
    let (one, other) = (server(&database), server(&database));
    let (id, run) = started(&one, "slow");
    let before = Instant::now();
    let_owners_die(&database);
    // The right is gone at the next renewal at the latest; until then the robot is slow, not stopped.
    eventually(|| one.runs().iter().all(|run| run.state != RunState::Running) || before.elapsed() > LEASE);
    assert!(other.run(&run).unwrap().state != RunState::Done);
    let time = eventually(|| other.run(&run).unwrap().state == RunState::Interrupted);
    assert!(time < LEASE * 2, "{time:?}");
    assert_eq!(one.run(&run).unwrap().state, RunState::Interrupted);
    // The session goes on with both, and the run can be resumed.
    assert_eq!(
        said(&other, &id, "Put the cup on the shelf").unwrap().view.state,
        "plan"
    );
    assert_eq!(one.session(&id).unwrap().view.state, "plan");
    other.resume(&run, "ada").unwrap();
    eventually(|| one.run(&run).unwrap().state != RunState::Interrupted);
    one.stop_all("ada").unwrap();
    eventually(|| other.run(&run).unwrap().state == RunState::Stopped);
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn the_work_of_a_dead_server_is_taken_over_when_its_leases_have_ended() {
    let database = Database::new();
    let (one, other) = (server(&database), server(&database));
    let (moving, run) = started(&one, "slow");
    let (thinking, _) = accepted(&one);
    one.say(&thinking, &Said::Instruction("wait for me".to_owned()))
        .unwrap()
        .leave();
    let began = Instant::now();
    let_owners_die(&database);
    assert_eq!(other.session(&thinking).unwrap().view.state, "thinking");
    assert_eq!(other.run(&run).unwrap().state, RunState::Running);
    assert!(is_busy(other.undo(&moving)) && is_busy(other.resume(&run, "ada")));
    eventually(|| other.run(&run).unwrap().state == RunState::Interrupted);
    // The model of the other server goes on with the instruction, which is cancelled there now.
    eventually(|| other.cancel(&thinking).is_ok());
    eventually(|| other.session(&thinking).unwrap().view.state == "ready");
    assert!(
        began.elapsed() > LEASE - Duration::from_millis(50),
        "{:?}",
        began.elapsed()
    );
    assert!(began.elapsed() < LEASE * 3, "{:?}", began.elapsed());
    assert_eq!(
        said(&other, &thinking, "Put the cup on the shelf").unwrap().view.state,
        "plan"
    );
    other.undo(&moving).unwrap();
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn the_end_of_a_run_reaches_its_session_when_its_turn_comes() {
    let database = Database::new();
    for dies in [false, true] {
        let (one, other) = (server(&database), server(&database));
        let (id, approval) = approved(&one, "sim");
        // Another plan waits for a decision when the run ends.
        assert_eq!(
            said(&other, &id, "Put the cup on the shelf").unwrap().view.state,
            "plan"
        );
        let run = one.start(&approval, false, "ada").unwrap().record.id.clone();
        until(&other, &run, |run| run.state == RunState::Done);
        until(&one, &run, |run| run.state == RunState::Done);
        if dies {
            let_owners_die(&database);
        }
        // The server that has the end keeps the session until it is told.
        assert!(is_busy(other.cancel(&id)));
        if dies {
            eventually(|| other.cancel(&id).is_ok());
        } else {
            one.cancel(&id).unwrap();
        }
        for hub in [&other, &one] {
            let view = &hub.session(&id).unwrap().view;
            assert_eq!((view.state, view.accepted[0].pending), ("ready", false));
        }
    }
}
