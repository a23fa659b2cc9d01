//! Sessions, approvals and runs, without a network.

#![allow(clippy::unwrap_used, missing_docs, unreachable_pub)]

mod support;

use std::sync::Arc;
use std::time::Duration;

use longstep_robot::SimOptions;
use longstep_server::{
    APPROVAL_LIFETIME, Body, Deed, Hub, NewSession, ProblemKind, RunState, Said, SessionId, Snapshot,
};
use support::{hub, runtime, simulated, until};

fn said(hub: &Arc<Hub>, id: &SessionId, said: Said) -> Arc<Snapshot> {
    let waiting = hub.say(id, &said).unwrap();
    runtime().block_on(waiting.turn())
}

fn instructed(hub: &Arc<Hub>, id: &SessionId, text: &str) -> Arc<Snapshot> {
    said(hub, id, Said::Instruction(text.to_owned()))
}

/// Returns the hash of the plan that waits for a decision.
fn hash(snapshot: &Snapshot) -> String {
    snapshot.view.proposal.as_ref().unwrap().plan.clone()
}

fn desk(hub: &Hub) -> SessionId {
    hub.create(&NewSession::of_scene("desk")).unwrap().view.id.clone()
}

#[test]
fn an_approved_plan_moves_the_robot_once() {
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, vec![simulated("sim", SimOptions::default(), Body::PerSession)]);
    let id = desk(&hub);
    let plan = hash(&instructed(&hub, &id, "Put the pen on the shelf"));

    // Nothing is approved by its accepting, and nothing else than what was seen can be accepted or approved.
    assert_eq!(
        hub.accept(&id, "another", "ada").unwrap_err().kind,
        ProblemKind::Conflict
    );
    assert!(hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).is_err());
    hub.accept(&id, &plan, "ada").unwrap();
    assert!(hub.approve(&id, "another", "sim", "ada", APPROVAL_LIFETIME).is_err());
    assert!(hub.approve(&id, &plan, "arm", "ada", APPROVAL_LIFETIME).is_err());
    let approval = hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    let second = hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();

    let run = hub.start(&approval.id, false, "ada").unwrap().record.id.clone();
    assert!(hub.start(&approval.id, false, "ada").is_err());
    let done = until(&hub, &run, |run| run.state.is_ended());
    assert_eq!(done.state, RunState::Done, "{done:#?}");
    assert!(!done.steps.is_empty() && done.end.as_ref().unwrap().done);
    let view = &hub.session(&id).unwrap().view;
    assert!(!view.accepted[0].pending);
    assert_eq!(
        view.environment.object_states["<pen>"].as_slice(),
        ["on_something(<shelf>)"]
    );
    let recording = hub.recording(&run).unwrap();
    let messages: Vec<_> = mcap::MessageStream::new(&recording)
        .unwrap()
        .map(Result::unwrap)
        .collect();
    let performed = messages.iter().filter(|message| {
        message.channel.topic == "/longstep/step" && String::from_utf8_lossy(&message.data).contains("performed")
    });
    assert_eq!(performed.count(), done.steps.len());
    let summary = mcap::Summary::read(&recording).unwrap().unwrap();
    let metadata = mcap::read::metadata(&recording, &summary.metadata_indexes[0])
        .unwrap()
        .metadata;
    assert_eq!((&metadata["approved_plan"], metadata["by"].as_str()), (&plan, "ada"));
    assert_eq!(
        (metadata["instruction"].as_str(), metadata["times"].as_str()),
        ("Put the pen on the shelf", "recorded")
    );
    assert_eq!(recording, hub.recording(&run).unwrap());
    // The second approval of the same plan came too late.
    assert!(hub.start(&second.id, false, "ada").is_err());

    let deeds = hub.audit().last(100).unwrap();
    let count = |is: fn(&Deed) -> bool| deeds.iter().filter(|entry| is(&entry.deed)).count();
    assert_eq!(count(|deed| matches!(deed, Deed::Accepted { .. })), 1);
    assert_eq!(count(|deed| matches!(deed, Deed::Approved { .. })), 2);
    assert_eq!(count(|deed| matches!(deed, Deed::Started { .. })), 1);
    assert_eq!(count(|deed| matches!(deed, Deed::Ended { .. })), 1);
    assert!(deeds.iter().filter(|entry| entry.by == "ada").count() >= 4);
}

#[test]
fn an_approval_lapses_when_the_world_changes_or_its_time_is_over() {
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, vec![simulated("sim", SimOptions::default(), Body::PerSession)]);
    let id = desk(&hub);
    let plan = hash(&instructed(&hub, &id, "Put the pen on the shelf"));
    hub.accept(&id, &plan, "ada").unwrap();
    let short = hub.approve(&id, &plan, "sim", "ada", Duration::from_millis(1)).unwrap();
    std::thread::sleep(Duration::from_millis(5));
    assert!(
        hub.start(&short.id, false, "ada")
            .unwrap_err()
            .message
            .contains("expired")
    );

    let approval = hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    let seen = serde_json::from_str(r#"{"states": {"<cup>": "on_something(<table>)"}}"#).unwrap();
    hub.observed(&id, &seen).unwrap();
    let refused = hub.start(&approval.id, false, "ada").unwrap_err();
    assert!(refused.message.contains("the world has changed"), "{refused}");
    assert!(hub.runs().is_empty());
}

#[test]
fn a_session_goes_on_after_the_server_died() {
    let folder = tempfile::tempdir().unwrap();
    let robots = || vec![simulated("sim", SimOptions::default(), Body::PerSession)];
    let (id, plan) = {
        let hub = hub(&folder, robots());
        let id = desk(&hub);
        let plan = hash(&instructed(&hub, &id, "Put the pen on the shelf"));
        hub.accept(&id, &plan, "ada").unwrap();
        instructed(&hub, &id, "Put something away");
        (id, plan)
    };
    let hub = hub(&folder, robots());
    assert_eq!(hub.sessions().unwrap(), std::slice::from_ref(&id));
    let view = &hub.session(&id).unwrap().view;
    assert_eq!((view.state, view.question.as_deref()), ("question", Some("Which one?")));
    assert_eq!(view.accepted[0].plan, plan);
    let answered = said(&hub, &id, Said::Answer("the cup on the shelf".to_owned()));
    assert_eq!(answered.view.state, "plan");
    let approval = hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    let run = hub.start(&approval.id, false, "ada").unwrap().record.id.clone();
    // The run ends while another plan waits for a decision: the session takes its end afterwards.
    assert_eq!(until(&hub, &run, |run| run.state.is_ended()).state, RunState::Done);
    hub.cancel(&id).unwrap();
    assert!(!hub.session(&id).unwrap().view.accepted[0].pending);
}

#[test]
fn a_call_of_the_model_ends_with_its_client_or_when_it_is_cancelled() {
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, Vec::new());
    let (one, other) = (desk(&hub), desk(&hub));
    let wait = Said::Instruction("wait for me".to_owned());
    let waiting = hub.say(&one, &wait).unwrap();
    assert_eq!(waiting.snapshot().view.state, "thinking");
    assert_eq!(hub.say(&one, &wait).err().unwrap().kind, ProblemKind::Conflict);
    drop(waiting);
    // The model is free again for another session.
    assert_eq!(instructed(&hub, &other, "Put the pen on the shelf").view.state, "plan");
    assert_eq!(hub.session(&one).unwrap().view.state, "ready");

    hub.say(&one, &wait).unwrap().leave();
    hub.cancel(&one).unwrap();
    hub.cancel(&other).unwrap();
    assert_eq!(instructed(&hub, &other, "Put the pen on the shelf").view.state, "plan");
}

/// Removes the last lines of a file, as a server that died before it wrote them left it.
fn cut(path: &std::path::Path, lines: usize) {
    let text = std::fs::read_to_string(path).unwrap();
    let kept: Vec<&str> = text.split_inclusive('\n').collect();
    std::fs::write(path, kept[..kept.len() - lines].concat()).unwrap();
}

#[test]
fn runs_of_an_earlier_server_are_shown_as_their_logs_end() {
    let folder = tempfile::tempdir().unwrap();
    let robots = || vec![simulated("sim", SimOptions::default(), Body::PerSession)];
    let (id, run) = {
        let hub = hub(&folder, robots());
        let id = desk(&hub);
        let plan = hash(&instructed(&hub, &id, "Put the pen on the shelf"));
        hub.accept(&id, &plan, "ada").unwrap();
        let approval = hub.approve(&id, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
        let run = hub.start(&approval.id, false, "ada").unwrap().record.id.clone();
        until(&hub, &run, |run| run.state.is_ended());
        (id, run)
    };
    // The server died after the run was done, and before its session had its end.
    let session = folder.path().join(format!("sessions/{id}/session.jsonl"));
    let text = std::fs::read_to_string(&session).unwrap();
    assert!(text.lines().last().unwrap().contains("carried_out"));
    cut(&session, 1);
    let (log, events) = (folder.path().join(format!("runs/{run}.jsonl")), 3);
    for (cuts, state, pending) in [(0, RunState::Done, false), (events, RunState::Interrupted, true)] {
        cut(&log, cuts);
        let hub = hub(&folder, robots());
        assert_eq!(hub.run(&run).unwrap().state, state);
        let listed: Vec<_> = hub
            .runs()
            .iter()
            .map(|run| (run.record.id.clone(), run.state))
            .collect();
        assert_eq!(listed, [(run.clone(), state)]);
        assert_eq!(hub.session(&id).unwrap().view.accepted[0].pending, pending);
        drop(hub);
        if !pending {
            cut(&session, 1);
        }
    }
}

/// A session is listed from the moment its log has a file. Whoever reads the list looks at it at once.
#[test]
fn a_session_that_is_listed_can_be_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let hub = hub(&folder, vec![]);
    let begun = std::thread::scope(|scope| {
        let beginners: Vec<_> = (0..2)
            .map(|_| scope.spawn(|| (0..60).for_each(|_| drop(desk(&hub)))))
            .collect();
        let mut looks = 0;
        while !beginners.iter().all(|beginner| beginner.is_finished()) {
            for id in hub.sessions().unwrap() {
                hub.session(&id).unwrap();
                looks += 1;
            }
        }
        assert!(looks > 0);
        beginners.into_iter().for_each(|beginner| beginner.join().unwrap());
        hub.sessions().unwrap().len()
    });
    assert_eq!(begun, 120);
}
