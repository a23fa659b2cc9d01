//! Recordings of runs have every step of their log, with its end and its time, for the reader of the format and for Python's.
//!
//! `LONGSTEP_MCAP=$(scripts/mcap.sh) cargo test -p longstep-robot --test mcap -- --include-ignored`
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub, dead_code)]

mod seeded_runs;

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::process::Command;

use boon::{Compiler, Schemas};
use jiff::{SignedDuration, Timestamp};
use longstep_core::execution::Event;
use longstep_robot::mcap::Recording;
use longstep_robot::{RunHeader, RunLog, TimedEvent};
use mcap::MessageStream;
use seeded_runs::{cases, lanes, monitored};
use serde_json::{Value, json};

const HEADER: &str = r#"{"longstep_run":1,"robot":"sim:\"seed\"=1","domain":"household"}"#;

/// Names that break careless writers.
const HOSTILE: [&str; 7] = [
    r#"<say "hello">"#,
    "<it's>",
    r"<back\slash\n>",
    "<杯 ☕ \u{1F37A}>",
    "<e\u{301}\u{202e}abc>",
    "<\u{1}\u{7f}\u{2028}\t\n>",
    "<{\"op\": \"publish\"}, %s %n ${HOME}>",
];

fn began_at() -> Timestamp {
    "2026-05-04T10:00:00.123456789Z".parse().unwrap()
}

/// Returns the log of these events, one every 1,234,567 nanoseconds.
fn log_of(events: &[Event]) -> String {
    let mut text = format!("{HEADER}\n");
    for (number, event) in events.iter().enumerate() {
        let after = SignedDuration::from_nanos(1_234_567 * number as i64);
        text.push_str(&RunLog::lines(std::slice::from_ref(event), began_at() + after).unwrap());
    }
    text
}

fn parsed(log: &str) -> (RunHeader, Vec<TimedEvent>) {
    RunLog::parse_timed(Path::new("run.jsonl"), log).unwrap()
}

fn recorded(log: &str) -> Vec<u8> {
    let (header, events) = parsed(log);
    Recording::new(&header, &events).to_bytes().unwrap()
}

/// A step of a run: its order, state, call, words and time.
type Step = (u64, String, Option<String>, Option<String>, u64);

/// Returns the steps of a log.
fn steps_of_log(log: &str) -> Vec<Step> {
    let mut calls: BTreeMap<u64, String> = BTreeMap::new();
    let mut steps = Vec::new();
    for own in parsed(log).1 {
        let at = u64::try_from(own.at.unwrap().as_nanosecond()).unwrap();
        let (order, state, words) = match own.event {
            Event::Announced { order, call, .. } => {
                steps.push((order, "announced".to_owned(), Some(call), None, at));
                continue;
            }
            Event::Ordered { order, call, .. } => {
                calls.insert(order, call);
                (order, "ordered", None)
            }
            Event::Performed { order, outcome } => (order, "performed", outcome),
            Event::Failed { order, why } => (order, "failed", Some(why)),
            Event::Found { order } => (order, "found", None),
            Event::Judged { order, done: true } => (order, "judged-done", None),
            Event::Judged { order, done: false } => (order, "judged-not-done", None),
            _ => continue,
        };
        steps.push((order, state.to_owned(), calls.get(&order).cloned(), words, at));
    }
    steps
}

/// Returns the steps of a recording.
fn steps_of(recording: &[u8]) -> Vec<Step> {
    let messages = MessageStream::new(recording).unwrap().map(Result::unwrap);
    let steps = messages.filter(|message| message.channel.topic == "/longstep/step");
    let text = |message: &Value, name: &str| message.get(name).map(|own| own.as_str().unwrap().to_owned());
    steps
        .map(|message| {
            let step: Value = serde_json::from_slice(&message.data).unwrap();
            let words = text(&step, "outcome").or_else(|| text(&step, "why"));
            let state = text(&step, "state").unwrap();
            let order = step["order"].as_u64().unwrap();
            (order, state, text(&step, "call"), words, message.log_time)
        })
        .collect()
}

/// Checks every message with the schema of its channel. Returns the topics.
#[track_caller]
fn check_schemas(recording: &[u8]) -> BTreeSet<String> {
    let (mut compiled, mut schemas) = (BTreeMap::new(), Schemas::new());
    let mut topics = BTreeSet::new();
    for message in MessageStream::new(recording).unwrap() {
        let message = message.unwrap();
        let schema = message.channel.schema.as_ref().unwrap();
        assert_eq!(
            (message.channel.message_encoding.as_str(), schema.encoding.as_str()),
            ("json", "jsonschema")
        );
        let index = *compiled.entry(schema.name.clone()).or_insert_with(|| {
            let location = format!("https://example.org/{}.json", schema.name);
            let mut compiler = Compiler::new();
            let mut text: Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!((&text["type"], &text["title"]), (&json!("object"), &json!(schema.name)));
            // A field that the schema does not have is a mistake.
            text["additionalProperties"] = json!(false);
            compiler.add_resource(&location, text).unwrap();
            compiler.compile(&location, &mut schemas).unwrap()
        });
        let value: Value = serde_json::from_slice(&message.data).unwrap();
        if let Err(error) = schemas.validate(&value, index) {
            panic!("{}: {value} does not fit: {error}", message.channel.topic);
        }
        topics.insert(message.channel.topic.clone());
    }
    topics
}

/// Seeded runs with mishaps, of one hand and of two.
fn seeded_logs() -> Vec<String> {
    let mut all = cases(&["household", "branching"]);
    all.extend(lanes(1));
    let runs = all.iter().cycle().take(40).enumerate();
    runs.map(|(number, case)| log_of(&monitored(case, number as u64, number as u32 % 4).watcher.events))
        .collect()
}

/// A log as no world of the tests has it: hostile names everywhere, and every kind of event about a step.
fn hostile_log() -> String {
    let mut events = Vec::new();
    let mut add = |event: Value| events.push(serde_json::from_value(event).unwrap());
    for (number, name) in HOSTILE.into_iter().enumerate() {
        let order = number + 1;
        let call = format!("grasp({name})");
        add(json!({"event": "announced", "order": order, "call": call, "explanation": name, "seconds": 3.5}));
        add(
            json!({"event": "ordered", "order": order, "step": order, "lane": name, "call": call, "explanation": name}),
        );
        add(match number % 5 {
            0 => json!({"event": "performed", "order": order, "outcome": name}),
            1 => json!({"event": "failed", "order": order, "why": name}),
            2 => json!({"event": "found", "order": order}),
            3 => json!({"event": "judged", "order": order, "done": true}),
            _ => json!({"event": "judged", "order": order, "done": false}),
        });
        add(json!({"event": "assessed", "effect": "harmful", "because": [name], "steps": [name]}));
        add(json!({"event": "changed", "kind": "repaired", "plan": [call], "steps": [name], "edits": [name]}));
        add(json!({"event": "confirmed", "what": name, "holds": false}));
        add(json!({"event": "trusted", "unseen": [{"what": name, "basis": "promised", "order": order}]}));
    }
    add(json!({"event": "performed", "order": 999}));
    add(json!({"event": "interrupted", "under_way": [1, 999]}));
    add(json!({"event": "paused"}));
    add(json!({"event": "continued"}));
    add(json!({"event": "refused"}));
    log_of(&events)
}

/// A log of a thousand steps.
fn long_log() -> String {
    let order = |order: u64| {
        [
            json!({"event": "ordered", "order": order, "step": order, "call": "wipe(<desk>)", "explanation": "1. wipe the desk"}),
            json!({"event": "performed", "order": order}),
        ]
    };
    let events: Vec<Event> = (1..=1_000)
        .flat_map(order)
        .map(|event| serde_json::from_value(event).unwrap())
        .collect();
    log_of(&events)
}

#[test]
fn recording_has_every_step_of_its_log() {
    let mut topics = BTreeSet::new();
    let mut states = BTreeSet::new();
    for log in seeded_logs().into_iter().chain([hostile_log(), long_log()]) {
        let recording = recorded(&log);
        let steps = steps_of(&recording);
        assert_eq!(steps, steps_of_log(&log));
        assert!(!steps.is_empty());
        topics.extend(check_schemas(&recording));
        states.extend(steps.into_iter().map(|step| step.1));
        // The same log gives the same bytes.
        assert_eq!(recording, recorded(&log));
    }
    let topics: Vec<&str> = topics.iter().map(String::as_str).collect();
    assert_eq!(
        topics,
        [
            "/longstep/assessment",
            "/longstep/log",
            "/longstep/observation",
            "/longstep/plan",
            "/longstep/run",
            "/longstep/step",
            "/longstep/world",
        ]
    );
    assert_eq!(states.len(), 7, "{states:?}");
}

#[test]
fn recording_has_the_versions_the_robot_and_the_hash_of_the_plan() {
    let case = &cases(&["household"])[0];
    let log = log_of(&monitored(case, 1, 0).watcher.events);
    let (header, events) = parsed(&log);
    let bytes = Recording::new(&header, &events)
        .with("instruction", HOSTILE[0])
        .to_bytes()
        .unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let metadata = mcap::read::metadata(&bytes, &summary.metadata_indexes[0]).unwrap();
    assert_eq!(metadata.name, "longstep");
    let value = |name: &str| metadata.metadata[name].as_str();
    assert_eq!(value("instruction"), HOSTILE[0]);
    assert_eq!(value("robot"), r#"sim:"seed"=1"#);
    assert_eq!((value("domain"), value("goal")), ("household", case.goal.as_str()));
    assert_eq!((value("log_version"), value("times")), ("1", "recorded"));
    assert_eq!(value("plan_sha256").len(), 64);
    // Another plan has another hash.
    let other = log_of(&monitored(&cases(&["household"])[1], 1, 0).watcher.events);
    let hash = |bytes: &[u8]| {
        let summary = mcap::Summary::read(bytes).unwrap().unwrap();
        let metadata = mcap::read::metadata(bytes, &summary.metadata_indexes[0]).unwrap();
        metadata.metadata["plan_sha256"].clone()
    };
    assert_eq!(hash(&recorded(&log)), value("plan_sha256"));
    assert_ne!(hash(&recorded(&other)), value("plan_sha256"));
    let statistics = summary.stats.unwrap();
    assert_eq!(statistics.channel_count, 7);
}

#[test]
fn times_stay_in_order_when_the_clock_is_set_back_or_was_not_kept() {
    let event = |text: &str| serde_json::from_str::<Event>(text).unwrap();
    let pause = || event(r#"{"event": "paused"}"#);
    let at = |text: &str| Some(text.parse::<Timestamp>().unwrap());
    let (header, _) = parsed(&format!("{HEADER}\n"));
    let times = |events: &[TimedEvent]| -> Vec<(u64, u64)> {
        let bytes = Recording::new(&header, events).to_bytes().unwrap();
        let messages = MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let messages = messages.filter(|message| message.channel.topic == "/longstep/run");
        messages
            .map(|message| (message.log_time, message.publish_time))
            .collect()
    };
    let set_back = [
        TimedEvent::new(at("1970-01-01T00:00:02Z"), pause()),
        TimedEvent::new(at("1970-01-01T00:00:01Z"), pause()),
        TimedEvent::new(None, pause()),
        TimedEvent::new(at("1960-01-01T00:00:00Z"), pause()),
    ];
    let second = 1_000_000_000;
    assert_eq!(
        times(&set_back),
        [
            (2 * second, 2 * second),
            (2 * second, second),
            (2_001_000_000, 2_001_000_000),
            (2_002_000_000, 2_002_000_000),
        ]
    );
    let untimed = [TimedEvent::new(None, pause()), TimedEvent::new(None, pause())];
    assert_eq!(times(&untimed), [(1_000_000, 1_000_000), (2_000_000, 2_000_000)]);
}

#[test]
fn logs_without_times_are_read() {
    let log = format!(
        "{HEADER}\n{{\"event\":\"paused\"}}\n{{\"event\":\"continued\",\"at\":\"2026-05-04T10:00:00Z\"}}\n{{\"ev"
    );
    let (_, events) = parsed(&log);
    assert_eq!(events.len(), 2);
    assert!(events[0].at.is_none() && events[1].at.is_some());
    let wrong = format!("{HEADER}\n{{\"event\":\"paused\",\"at\":\"yesterday\"}}\n");
    let error = RunLog::parse_timed(Path::new("run.jsonl"), &wrong)
        .unwrap_err()
        .to_string();
    assert!(error.starts_with("run.jsonl:2: "), "{error}");
}

#[test]
#[ignore = "needs LONGSTEP_MCAP"]
fn recordings_are_what_python_reads_in_their_logs() {
    let python = std::env::var("LONGSTEP_MCAP").unwrap();
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tools/peers/recorded_run.py");
    let folder = tempfile::tempdir().unwrap();
    let mut pairs = Vec::new();
    let logs = seeded_logs().into_iter().chain([hostile_log(), long_log()]);
    for (number, log) in logs.enumerate() {
        let (written, recording) = (
            folder.path().join(format!("{number}.jsonl")),
            folder.path().join(format!("{number}.mcap")),
        );
        std::fs::write(&written, &log).unwrap();
        std::fs::write(&recording, recorded(&log)).unwrap();
        pairs.extend([written, recording]);
    }
    let compared = |pairs: &[std::path::PathBuf]| Command::new(&python).arg(&script).args(pairs).output().unwrap();
    let output = compared(&pairs);
    let text = String::from_utf8_lossy(&output.stdout) + String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}");
    assert!(text.contains("42 recordings"), "{text}");
    // A recording of another run is noticed.
    let output = compared(&[pairs[0].clone(), pairs[3].clone()]);
    assert_eq!(output.status.code(), Some(1));
}
