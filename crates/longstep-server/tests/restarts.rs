//! Servers that begin on the files of one that was killed. `tools/server/kills.py` kills real ones.

#![allow(clippy::unwrap_used, missing_docs, unreachable_pub)]

mod support;

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep_server::{
    APPROVAL_LIFETIME, Body, Hub, NewSession, ProblemKind, RobotEntry, RunId, RunState, Said, SessionId, Snapshot,
};
use support::{hub, runtime, simulated, until};
use tempfile::TempDir;

fn robots(options: &str) -> Vec<RobotEntry> {
    vec![simulated("sim", options.parse().unwrap(), Body::PerSession)]
}

fn instructed(hub: &Arc<Hub>, id: &SessionId, text: &str) -> Arc<Snapshot> {
    let waiting = hub.say(id, &Said::Instruction(text.to_owned())).unwrap();
    runtime().block_on(waiting.turn())
}

/// Makes a plan and accepts it.
fn accepted(hub: &Arc<Hub>, id: &SessionId, text: &str) -> String {
    let plan = instructed(hub, id, text).view.proposal.as_ref().unwrap().plan.clone();
    hub.accept(id, &plan, "ada").unwrap();
    plan
}

fn started(hub: &Arc<Hub>, id: &SessionId, plan: &str) -> RunId {
    let approval = hub.approve(id, plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    hub.start(&approval.id, false, "ada").unwrap().record.id.clone()
}

/// Copies the files of a server that goes on, as they are at a crash.
fn crashed(folder: &TempDir) -> TempDir {
    fn copy(from: &Path, to: &Path) {
        fs::create_dir_all(to).unwrap();
        for entry in fs::read_dir(from).unwrap() {
            let entry = entry.unwrap();
            if entry.file_type().unwrap().is_dir() {
                copy(&entry.path(), &to.join(entry.file_name()));
            } else {
                fs::copy(entry.path(), to.join(entry.file_name())).unwrap();
            }
        }
    }
    let files = tempfile::tempdir().unwrap();
    copy(folder.path(), files.path());
    files
}

/// Returns the files of a server that crashed in the first step of a run, with the session, its plan and the run.
fn crashed_in_a_run() -> (TempDir, SessionId, String, RunId) {
    let folder = tempfile::tempdir().unwrap();
    let first = hub(&folder, robots("ticks=1,pace=60000"));
    let id = first.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
    let plan = accepted(&first, &id, "Put the pen on the shelf");
    let run = started(&first, &id, &plan);
    until(&first, &run, |run| run.events > 0);
    let files = crashed(&folder);
    first.stop_all("ada").unwrap();
    (files, id, plan, run)
}

#[test]
fn a_request_without_an_answer_goes_on() {
    let folder = tempfile::tempdir().unwrap();
    let first = hub(&folder, Vec::new());
    let id = first.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
    instructed(&first, &id, "Put the pen on the shelf");
    let files = crashed(&folder);
    let log = files.path().join(format!("sessions/{id}/session.jsonl"));
    let text = fs::read_to_string(&log).unwrap();
    let end = text.find("\"event\":\"instruction\"").unwrap();
    let end = end + text[end..].find('\n').unwrap() + 1;
    fs::write(&log, &text[..end]).unwrap();

    let second = hub(&files, Vec::new());
    let began = Instant::now();
    while second.session(&id).unwrap().view.state == "thinking" {
        assert!(began.elapsed() < Duration::from_secs(60));
        std::thread::sleep(Duration::from_millis(2));
    }
    let view = &second.session(&id).unwrap().view;
    assert_eq!(view.proposal.as_ref().unwrap().answer.goal, ["put(<pen>, <shelf>)"]);
}

#[test]
fn a_run_that_had_not_begun_is_shown_and_its_plan_is_approved_again() {
    let (files, id, plan, run) = crashed_in_a_run();
    let log = files.path().join(format!("runs/{run}.jsonl"));
    let header = fs::read_to_string(&log).unwrap().lines().next().unwrap().to_owned() + "\n";
    for beginning in ["", "{\"longstep", &header] {
        fs::write(&log, beginning).unwrap();
        let second = hub(&files, robots(""));
        let view = second.run(&run).unwrap();
        let end = view.end.as_ref().unwrap();
        assert!(
            view.state == RunState::Stopped && !end.resumable,
            "{beginning}: {view:#?}"
        );
        assert!(end.text.contains("nothing has moved"), "{}", end.text);
        assert_eq!(second.resume(&run, "ada").unwrap_err().kind, ProblemKind::Conflict);
    }
    let second = hub(&files, robots(""));
    let again = started(&second, &id, &plan);
    assert_eq!(until(&second, &again, |run| run.state.is_ended()).state, RunState::Done);
}

#[test]
fn an_interrupted_run_is_resumed_only_for_the_plan_that_waits() {
    let (files, id, plan, run) = crashed_in_a_run();

    let second = hub(&files, robots(""));
    assert_eq!(second.run(&run).unwrap().state, RunState::Interrupted);
    second.undo(&id).unwrap();
    let refused = second.resume(&run, "ada").unwrap_err();
    assert!(refused.message.contains("does not wait"), "{refused}");
    // The same plan again is the same number and the same hash.
    assert_eq!(accepted(&second, &id, "Put the pen on the shelf"), plan);
    let again = started(&second, &id, &plan);
    assert_eq!(until(&second, &again, |run| run.state.is_ended()).state, RunState::Done);
    assert!(second.resume(&run, "ada").is_err());
}

#[test]
fn no_plan_takes_the_place_of_the_one_that_a_robot_carries_out() {
    let folder = tempfile::tempdir().unwrap();
    let slow = simulated("slow", "ticks=1,pace=60000".parse().unwrap(), Body::PerSession);
    let hub = hub(&folder, [robots(""), vec![slow]].concat());
    let id = hub.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
    let first = accepted(&hub, &id, "Put the pen on the shelf");
    let second = accepted(&hub, &id, "Put the cup on the shelf");
    let run = started(&hub, &id, &first);
    until(&hub, &run, |run| run.state == RunState::Done);
    // The world was observed: a further plan begins in it, without the second one.
    let approval = hub.approve(&id, &second, "slow", "ada", APPROVAL_LIFETIME).unwrap();
    hub.start(&approval.id, false, "ada").unwrap();
    let third = instructed(&hub, &id, "Put the pen on the table");
    let third = third.view.proposal.as_ref().unwrap().plan.clone();
    let refused = hub.accept(&id, &third, "ada").unwrap_err();
    assert!(refused.message.contains("a robot carries out"), "{refused}");
    hub.stop_all("ada").unwrap();
}
