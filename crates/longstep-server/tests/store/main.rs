//! Stores: one table of rules for files and for a database.
//!
//! `export "$(scripts/postgres.sh --parent $$)"; cargo test -p longstep-server --features postgres --test store --
//! --include-ignored`

#![allow(clippy::panic, clippy::unwrap_used, missing_docs, unreachable_pub)]

#[cfg(feature = "postgres")]
#[path = "../support/database.rs"]
mod database;
#[cfg(feature = "postgres")]
mod postgres;

use std::sync::Arc;
use std::thread;

use longstep_server::{
    ApprovalId, CampaignId, Durability, FileStore, LONGEST_TAIL, LogName, RecordKey, RunId, SessionId, Store,
    StoreError, UnitKey,
};

/// Two servers at one store.
struct Two {
    one: Arc<dyn Store>,
    other: Arc<dyn Store>,
}

type Rule = fn(&Two);

/// The rules, each with a store that nobody else uses.
const RULES: [(&str, Rule); 9] = [
    ("a log has one owner at a time", one_owner),
    ("a log has whole lines in order", lines_in_order),
    (
        "a log that does not exist is not made by looking",
        looking_makes_nothing,
    ),
    ("the end of a log is read without the rest", tail),
    ("the time of a change grows", changed_at),
    ("sessions are listed by name", sessions),
    ("runs are listed with their ends", runs),
    ("a record is written once", record_once),
    ("a log is not longer than the limit", limit),
];

fn session(name: &str) -> LogName {
    LogName::Session(SessionId::parse(name).unwrap())
}

fn run(name: &str) -> LogName {
    LogName::Run(RunId::parse(name).unwrap())
}

/// Returns true if somebody else owns the log.
fn is_refused(store: &Arc<dyn Store>, log: &LogName) -> bool {
    match store.own(log) {
        Ok(_) => false,
        Err(StoreError::Open(_) | StoreError::Taken(_)) => true,
        Err(error) => panic!("{error}"),
    }
}

fn one_owner(two: &Two) {
    let unit = UnitKey {
        campaign: CampaignId::of(&"a".into()),
        number: 12,
    };
    for log in [
        session("s"),
        run("r"),
        LogName::Robot("arm/left: 1".to_owned()),
        LogName::Unit(unit),
    ] {
        let own = two.one.own(&log).unwrap();
        assert!(!own.is_lost());
        assert!(is_refused(&two.other, &log) && is_refused(&two.one, &log), "{log:?}");
        let state = two.one.state(&log).unwrap().unwrap();
        assert_eq!((state.epoch, state.is_owned), (own.epoch(), true), "{log:?}");
        drop(own);
        let again = two.one.own(&log).unwrap();
        drop(again);
        let next = two.other.own(&log).unwrap();
        assert!(is_refused(&two.one, &log), "{log:?}");
        drop(next);
    }
    // Of many at once one gets it.
    let log = session("many");
    let owners = thread::scope(|scope| {
        let tries: Vec<_> = (0..8)
            .map(|number: usize| {
                let (store, log) = (if number.is_multiple_of(2) { &two.one } else { &two.other }, &log);
                scope.spawn(move || store.own(log).ok())
            })
            .collect();
        let owners: Vec<_> = tries.into_iter().map(|attempt| attempt.join().unwrap()).collect();
        owners.iter().flatten().count()
    });
    assert_eq!(owners, 1);
}

fn lines_in_order(two: &Two) {
    let log = session("s");
    let own = two.one.own(&log).unwrap();
    own.append("a\nb\n", Durability::Now).unwrap();
    own.append("c \u{1f600} '\"; \\u0000\n", Durability::Later).unwrap();
    let length = own.length();
    drop(own);
    let next = two.other.own(&log).unwrap();
    assert_eq!(next.length(), length);
    next.append("d\n", Durability::Now).unwrap();
    let text = "a\nb\nc \u{1f600} '\"; \\u0000\nd\n";
    for store in [&two.one, &two.other] {
        assert_eq!(store.read(&log).unwrap().unwrap(), text.as_bytes());
        assert_eq!(store.state(&log).unwrap().unwrap().length, text.len() as u64);
    }
}

fn looking_makes_nothing(two: &Two) {
    for log in [session("none"), run("none")] {
        assert!(two.one.read(&log).unwrap().is_none() && two.one.state(&log).unwrap().is_none());
        assert!(two.one.changed_at(&log).unwrap().is_none() && two.one.tail(&log, 3).unwrap().is_empty());
    }
    assert!(two.one.sessions().unwrap().is_empty() && two.one.runs(10).unwrap().is_empty());
    assert!(
        two.one
            .record(&RecordKey::Run(RunId::parse("none").unwrap()))
            .unwrap()
            .is_none()
    );
}

fn tail(two: &Two) {
    let log = session("s");
    let own = two.one.own(&log).unwrap();
    assert!(two.one.tail(&log, 3).unwrap().is_empty());
    for lines in ["1\n2\n3\n", "4\n", "5\n6\n"] {
        own.append(lines, Durability::Now).unwrap();
    }
    for (limit, expected) in [
        (0, &[][..]),
        (1, &["6"]),
        (3, &["4", "5", "6"]),
        (5, &["2", "3", "4", "5", "6"]),
        (usize::MAX, &["1", "2", "3", "4", "5", "6"]),
    ] {
        assert_eq!(two.one.tail(&log, limit).unwrap(), expected, "{limit}");
    }
    own.append(&"x\n".repeat(LONGEST_TAIL), Durability::Now).unwrap();
    assert_eq!(two.one.tail(&log, usize::MAX).unwrap().len(), LONGEST_TAIL);
}

fn changed_at(two: &Two) {
    let log = session("s");
    let own = two.one.own(&log).unwrap();
    let mut last = None;
    for _ in 0..3 {
        // The clock of a file system may be coarse.
        thread::sleep(std::time::Duration::from_millis(20));
        own.append("a\n", Durability::Now).unwrap();
        let changed = two.other.changed_at(&log).unwrap();
        assert!(changed > last, "{changed:?} {last:?}");
        last = changed;
    }
    drop(own);
    // To own a log is no change of it.
    drop(two.other.own(&log).unwrap());
    assert_eq!(two.one.changed_at(&log).unwrap(), last);
    let age = jiff::Timestamp::now().duration_since(last.unwrap());
    assert!(age.as_secs().abs() < 60, "{age}");
}

fn sessions(two: &Two) {
    for name in ["b", "B", "a-1", "_"] {
        two.one
            .own(&session(name))
            .unwrap()
            .append("x\n", Durability::Now)
            .unwrap();
    }
    let names: Vec<String> = two.other.sessions().unwrap().iter().map(ToString::to_string).collect();
    assert_eq!(names, ["B", "_", "a-1", "b"]);
}

fn runs(two: &Two) {
    for name in ["a", "b", "c", "d"] {
        thread::sleep(std::time::Duration::from_millis(20));
        let own = two.one.own(&run(name)).unwrap();
        own.append("header\n", Durability::Now).unwrap();
        own.append(&format!("begin {name}\nend {name}\n"), Durability::Now)
            .unwrap();
        // `d` is a run of the command line.
        if name != "d" {
            let key = RecordKey::Run(RunId::parse(name).unwrap());
            assert!(two.one.insert(&key, &format!("record {name}")).unwrap());
        }
    }
    let own = two.one.own(&run("a")).unwrap();
    let listed = |limit| -> Vec<(String, Option<String>, bool)> {
        let runs = two.one.runs(limit).unwrap().into_iter();
        runs.map(|run| (run.record, run.last, run.state.is_owned)).collect()
    };
    let expected = |name: &str, is_owned| (format!("record {name}"), Some(format!("end {name}")), is_owned);
    assert_eq!(
        listed(9),
        [expected("a", true), expected("c", false), expected("b", false)]
    );
    assert_eq!(listed(1), [expected("a", true)]);
    drop(own);
    assert_eq!(listed(1).len(), 1);
}

fn record_once(two: &Two) {
    let id = ApprovalId::parse("a").unwrap();
    let key = RecordKey::Use(id.clone());
    let written = thread::scope(|scope| {
        let writers: Vec<_> = (0..16)
            .map(|number: usize| {
                let (store, key) = (if number.is_multiple_of(2) { &two.one } else { &two.other }, &key);
                scope.spawn(move || store.insert(key, &number.to_string()).unwrap())
            })
            .collect();
        let written: Vec<bool> = writers.into_iter().map(|writer| writer.join().unwrap()).collect();
        (0..16).filter(|number| written[*number]).collect::<Vec<_>>()
    });
    assert_eq!(written.len(), 1);
    let value = Some(written[0].to_string());
    assert_eq!(two.one.record(&key).unwrap(), value);
    assert_eq!(two.other.record(&key).unwrap(), value);
    // Records of other kinds have names of their own.
    let run = RunId::parse("a").unwrap();
    let session = SessionId::parse("a").unwrap();
    for key in [
        RecordKey::Approval(id),
        RecordKey::Run(run.clone()),
        RecordKey::Attempt {
            session,
            number: 0,
            attempt: 1,
        },
        RecordKey::Stop { run, epoch: 1 },
    ] {
        assert!(two.one.record(&key).unwrap().is_none());
        assert!(two.other.insert(&key, "x").unwrap() && !two.one.insert(&key, "y").unwrap());
    }
}

fn limit(two: &Two) {
    let log = session("s");
    let own = two.one.own(&log).unwrap();
    own.append("a\n", Durability::Now).unwrap();
    let long = "x".repeat(256 << 20);
    assert!(matches!(
        own.append(&long, Durability::Now),
        Err(StoreError::TooLarge(_))
    ));
    own.append("b\n", Durability::Now).unwrap();
    assert_eq!(two.other.read(&log).unwrap().unwrap(), b"a\nb\n");
}

#[test]
fn files_keep_the_rules_of_stores() {
    for (name, rule) in RULES {
        println!("{name}");
        let folder = tempfile::tempdir().unwrap();
        let open = || Arc::new(FileStore::open(&folder.path().join("sessions")).unwrap());
        rule(&Two {
            one: open(),
            other: open(),
        });
    }
}

#[test]
fn a_torn_line_of_a_file_is_removed_by_its_next_owner() {
    let folder = tempfile::tempdir().unwrap();
    let store = FileStore::open(&folder.path().join("sessions")).unwrap();
    let log = session("s");
    store.own(&log).unwrap().append("a\n", Durability::Now).unwrap();
    let path = folder.path().join("sessions/s/session.jsonl");
    std::fs::write(&path, "a\ntorn").unwrap();
    assert_eq!(store.tail(&log, 2).unwrap(), ["a"]);
    store.own(&log).unwrap().append("b\n", Durability::Now).unwrap();
    assert_eq!(std::fs::read_to_string(&path).unwrap(), "a\nb\n");
}

#[test]
fn a_run_without_lines_leaves_no_file() {
    let folder = tempfile::tempdir().unwrap();
    let store = FileStore::open(&folder.path().join("sessions")).unwrap();
    drop(store.own(&run("r")).unwrap());
    assert!(store.state(&run("r")).unwrap().is_none());
}

#[test]
fn the_audit_log_of_files_has_one_server() {
    let folder = tempfile::tempdir().unwrap();
    let open = || FileStore::open(&folder.path().join("sessions")).unwrap();
    let own = open().own(&LogName::Audit).unwrap();
    assert!(matches!(open().own(&LogName::Audit), Err(StoreError::Open(_))));
    drop(own);
    open().own(&LogName::Audit).unwrap();
}
