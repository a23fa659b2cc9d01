//! Runs that are interrupted at random: by urgent ones, pauses and stops.

#![allow(clippy::unwrap_used, missing_docs, unreachable_pub)]

mod support;

use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use longstep_core::execution::Event;
use longstep_server::{APPROVAL_LIFETIME, Body, Deed, Hub, NewSession, RunId, RunState, Said, SessionId};
use support::{hub, runtime, simulated};

/// Scenarios, each with up to four interruptions.
const SCENARIOS: u64 = 90;

/// A generator of random numbers (splitmix64).
struct Random(u64);

impl Random {
    fn below(&mut self, bound: u64) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut mixed = self.0;
        mixed = (mixed ^ (mixed >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ (mixed >> 31)) % bound
    }
}

/// Makes a plan in a session, approves it, and begins a run.
fn started(hub: &Arc<Hub>, session: &SessionId, text: &str, urgent: bool) -> Option<RunId> {
    let waiting = hub.say(session, &Said::Instruction(text.to_owned())).unwrap();
    let snapshot = runtime().block_on(waiting.turn());
    // The world may be so that there is nothing to do.
    let plan = snapshot.view.proposal.as_ref()?.plan.clone();
    if snapshot.view.state != "plan" {
        return None;
    }
    hub.accept(session, &plan, "ada").unwrap();
    let approval = hub.approve(session, &plan, "sim", "ada", APPROVAL_LIFETIME).unwrap();
    Some(hub.start(&approval.id, urgent, "ada").unwrap().record.id.clone())
}

/// Begins an urgent run in the world as the first run knows it.
fn interrupted(hub: &Arc<Hub>, first: &RunId, text: &str) -> Option<RunId> {
    let environment = serde_json::to_string(hub.run(first).unwrap().environment.as_ref()?).unwrap();
    let session = hub
        .create(&NewSession::of_environment("household", &environment))
        .ok()?;
    started(hub, &session.view.id, text, true)
}

/// Answers what runs ask, until all have ended: one may wait for another that asks.
fn ended(hub: &Arc<Hub>, runs: &[RunId]) {
    let began = Instant::now();
    loop {
        let views: Vec<_> = runs.iter().map(|run| hub.run(run).unwrap()).collect();
        if views.iter().all(|view| view.state.is_ended()) {
            return;
        }
        for view in &views {
            if let Some(question) = &view.question {
                // A run that was answered in the meantime asks the next question.
                let _ = hub.decide(&view.record.id, &question.id, true, "ada");
            }
        }
        assert!(began.elapsed() < Duration::from_secs(120), "{views:#?}");
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Checks that nothing was ordered during a pause, and no step again without a reason in the log.
fn check_log(folder: &Path, run: &RunId) -> usize {
    let text = std::fs::read_to_string(folder.join("runs").join(format!("{run}.jsonl"))).unwrap_or_default();
    let events: Vec<Event> = text
        .lines()
        .skip(1)
        .map(|line| serde_json::from_str(line).unwrap())
        .collect();
    let (mut is_paused, mut pauses) = (false, 0);
    let mut done: Vec<String> = Vec::new();
    let mut call_of = std::collections::BTreeMap::new();
    for event in &events {
        match event {
            Event::Paused => (is_paused, pauses) = (true, pauses + 1),
            Event::Continued => {
                is_paused = false;
                done.clear();
            }
            Event::Ordered { order, call, .. } => {
                assert!(!is_paused, "{run}: {call} during a pause");
                assert!(!done.contains(call), "{run}: {call} again, without a reason: {text}");
                call_of.insert(*order, call.clone());
            }
            Event::Performed { order, .. } => done.push(call_of[order].clone()),
            Event::Assessed { .. } | Event::Changed { .. } | Event::Failed { .. } | Event::Interrupted { .. } => {
                done.clear()
            }
            // Each place of the hand is visited once for each object.
            _ => {}
        }
    }
    pauses
}

#[test]
fn runs_that_are_interrupted_end_in_their_goal_or_a_proven_stop() {
    let (mut interruptions, mut reached, mut stopped, mut pauses) = (0, 0, 0, 0);
    for seed in 0..SCENARIOS {
        let mut random = Random(seed);
        let folder = tempfile::tempdir().unwrap();
        let state = folder.path().join("state.json");
        let faults = random.below(3);
        let options = format!("seed={seed},faults={faults},ticks=2,pace=2,state={}", state.display());
        let hub = hub(&folder, vec![simulated("sim", options.parse().unwrap(), Body::Shared)]);
        let session = hub.create(&NewSession::of_scene("desk")).unwrap().view.id.clone();
        let first = started(&hub, &session, "Put the pen on the shelf", false).unwrap();
        let mut runs = vec![first.clone()];
        let (mut is_stopped, mut is_paused) = (false, false);
        for _ in 0..=random.below(4) {
            std::thread::sleep(Duration::from_millis(random.below(40)));
            interruptions += 1;
            match random.below(8) {
                0..3 => {
                    let text = [
                        "Put the cup on the shelf",
                        "Put the cup on the table",
                        "Put the pen on the table",
                    ];
                    let text = text[usize::try_from(random.below(3)).unwrap()];
                    runs.extend(interrupted(&hub, &first, text));
                }
                3..6 => is_paused |= hub.pause(&first, "ada").is_ok(),
                6 => drop(hub.go_on(&first, "ada")),
                _ => {
                    hub.stop(&first, "ada").unwrap();
                    is_stopped = true;
                }
            }
        }
        if is_paused {
            let _ = hub.go_on(&first, "ada");
        }
        ended(&hub, &runs);
        for run in &runs {
            let view = hub.run(run).unwrap();
            pauses += check_log(folder.path(), run);
            match view.state {
                RunState::Done => reached += 1,
                _ => stopped += 1,
            }
            // Only a person or a robot with mishaps stops a run, and every end has its reason.
            let end = view.end.as_ref().unwrap();
            assert!(
                view.state == RunState::Done || is_stopped || faults > 0,
                "seed {seed}: {end:?}"
            );
        }
        let started = hub.audit().last(1_000).unwrap();
        let count = started
            .iter()
            .filter(|entry| matches!(entry.deed, Deed::Started { .. }))
            .count();
        assert_eq!(count, runs.len());
    }
    assert!(
        interruptions >= 100 && reached >= 60 && stopped >= 3 && pauses >= 20,
        "{interruptions} {reached} {stopped} {pauses}"
    );
}
