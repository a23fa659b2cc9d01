//! The published schema of run logs describes the logs of real runs, and nothing else.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub, dead_code)]

mod seeded_runs;

use std::collections::BTreeSet;
use std::path::Path;

use boon::{Compiler, SchemaIndex, Schemas};
use longstep_core::autonomy::Autonomy;
use longstep_core::execution::{Aim, Approval, Event, Execution, Need, Resumed, Settings};
use longstep_robot::{RunHeader, RunLog, Sim, reports};
use seeded_runs::{cases, lanes, monitored};
use serde_json::Value;

struct Schema {
    schemas: Schemas,
    line: SchemaIndex,
}

impl Schema {
    fn new() -> Self {
        let (mut compiler, mut schemas) = (Compiler::new(), Schemas::new());
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../schemas");
        let location = |name: &str| format!("https://github.com/longstep/longstep/schemas/{name}.schema.json");
        for name in ["plan", "robot", "run"] {
            let text = std::fs::read_to_string(folder.join(format!("{name}.schema.json"))).unwrap();
            let schema = serde_json::from_str(&text).unwrap();
            compiler.add_resource(&location(name), schema).unwrap();
        }
        let line = compiler.compile(&location("run"), &mut schemas).unwrap();
        Self { schemas, line }
    }

    #[track_caller]
    fn check(&self, line: &Value) {
        if let Err(error) = self.schemas.validate(line, self.line) {
            panic!("{line} does not fit: {error}");
        }
    }
}

/// Runs until a step is under way, ends there, and is taken up again with an observation that cannot show that step. The next
/// step is followed by a pause.
fn interrupted() -> Vec<Event> {
    let case = &cases(&["household"])[0];
    let sim = Sim::new(case.world.clone(), &"seed=1".parse().unwrap()).unwrap();
    let settings = Settings::default().with_approval(Approval::EachStep);
    let mut execution = Execution::new(&case.plan, &Aim::Goal(case.goal.clone()), settings).unwrap();
    let mut log = Vec::new();
    let mut orders = 0;
    for turn in 0..200 {
        let need = execution.next_need();
        log.extend(execution.take_events());
        match need {
            Need::Approve(_) if orders == 3 => {
                execution.refuse().unwrap();
            }
            Need::Approve(proposal) => execution.approve(&proposal.id).unwrap(),
            Need::Observe => execution.observed(&execution.statements()).unwrap(),
            Need::Judge(order) => execution.judged(order.number, true).unwrap(),
            Need::Paused => execution.go_on(),
            Need::Perform(order) => {
                orders += 1;
                if orders == 2 {
                    execution.pause();
                }
                if orders == 1 {
                    execution = Execution::resume(case.world.domain(), &log, Resumed::default()).unwrap();
                } else {
                    execution.performed(order.number, None).unwrap();
                }
            }
            Need::Stopped(_) => {
                log.extend(execution.take_events());
                assert!(reports(&sim, &case.world).is_ok());
                return log;
            }
            other => panic!("{turn}: {other:?}"),
        }
    }
    panic!("no end")
}

/// Runs with levels and limits, of which the beginning of the log has each kind.
fn announced() -> Vec<Event> {
    let case = &cases(&["household"])[0];
    let unused = case.world.entities().map(|(id, _)| id);
    let mut unused = unused.filter(|id| case.plan.steps().iter().all(|step| !step.arguments.contains(id)));
    let place = case.world.entity(unused.next().unwrap()).identifier.clone();
    let text = format!(
        "[autonomy]\ndefault = \"announce\"\nwipe = \"never\"\n[[limit]]\nforbidden = [\"{place}\"]\nsays = \"it is hot\""
    );
    let autonomy = Autonomy::parse(case.world.domain(), Some(&case.world), "autonomy.toml", &text).unwrap();
    let settings = Settings::default()
        .with_approval(Approval::Never)
        .with_autonomy(autonomy);
    let mut execution = Execution::new(&case.plan, &Aim::Goal(case.goal.clone()), settings).unwrap();
    execution.observed(&execution.statements()).unwrap();
    let Need::Announce(order) = execution.next_need() else {
        panic!()
    };
    execution.announced(order.number).unwrap();
    assert!(matches!(execution.next_need(), Need::Perform(_)));
    execution.take_events()
}

#[test]
fn the_schema_describes_the_logs_of_real_runs() {
    let schema = Schema::new();
    let folder = tempfile::tempdir().unwrap();
    let mut kinds = BTreeSet::new();
    let mut check = |number: usize, events: &[Event]| {
        let path = folder.path().join(format!("{number}.jsonl"));
        let mut log = RunLog::create(&path, &RunHeader::new("sim", "household").with_dry_run(true)).unwrap();
        log.append(events).unwrap();
        for line in std::fs::read_to_string(&path).unwrap().lines() {
            let line: Value = serde_json::from_str(line).unwrap();
            schema.check(&line);
            kinds.insert(
                line.get("event")
                    .map_or("header", |kind| kind.as_str().unwrap())
                    .to_owned(),
            );
        }
    };
    let mut all = cases(&["household", "branching"]);
    all.extend(lanes(1));
    for (number, case) in all.iter().cycle().take(90).enumerate() {
        let run = monitored(case, number as u64, number as u32 % 4);
        check(number, &run.watcher.events);
    }
    check(1_000, &interrupted());
    check(1_001, &announced());
    let expected = [
        "announced",
        "approved",
        "assessed",
        "began",
        "changed",
        "continued",
        "done",
        "failed",
        "header",
        "interrupted",
        "judged",
        "observed",
        "ordered",
        "paused",
        "performed",
        "refused",
        "stopped",
    ];
    let missing: Vec<&str> = expected.into_iter().filter(|kind| !kinds.contains(*kind)).collect();
    assert!(missing.is_empty(), "no run has {missing:?}");
}

#[test]
fn run_schema_rejects_lines_that_no_run_writes() {
    let schema = Schema::new();
    for line in [
        r#"{"event": "approved"}"#,
        r#"{"event": "approved", "proposal": "yes"}"#,
        r#"{"event": "ordered", "order": 0, "step": 1, "call": "grasp(<cup>)", "explanation": "grasp the cup"}"#,
        r#"{"event": "assessed", "effect": "fatal", "because": []}"#,
        r#"{"event": "found", "order": 1, "more": true}"#,
        r#"{"event": "moved"}"#,
        r#"{"event": "paused", "at": "yesterday"}"#,
        r#"{"event": "paused", "at": "2026-05-04T10:00:00+02:00"}"#,
        r#"{"longstep_run": 2, "robot": "sim", "domain": "household"}"#,
    ] {
        let line: Value = serde_json::from_str(line).unwrap();
        assert!(schema.schemas.validate(&line, schema.line).is_err(), "{line}");
    }
}
