//! The rules that only a database has: leases, fencing, and an audit log that servers share.

use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

use longstep_server::{Durability, LogName, OwnedLog, PostgresOptions, PostgresStore, Store, StoreError};

use super::{RULES, Two, is_refused, session};
use crate::database::Database;

const LEASE: Duration = Duration::from_millis(600);

fn opened(database: &Database) -> Arc<dyn Store> {
    let options = PostgresOptions::default().with_lease(LEASE);
    Arc::new(PostgresStore::open(&database.address, options).unwrap())
}

fn two(database: &Database) -> Two {
    Two {
        one: opened(database),
        other: opened(database),
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_database_keeps_the_rules_of_stores() {
    for (name, rule) in RULES {
        println!("{name}");
        rule(&two(&Database::new()));
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_lease_is_renewed_while_its_owner_lives() {
    let database = Database::new();
    let two = two(&database);
    let own = two.one.own(&session("s")).unwrap();
    let began = Instant::now();
    while began.elapsed() < LEASE * 4 {
        assert!(is_refused(&two.other, &session("s")) && !own.is_lost());
        own.append("a\n", Durability::Now).unwrap();
        thread::sleep(LEASE / 10);
    }
}

/// Checks that an owner that has lost its lease writes nothing, and learns that it has.
fn is_fenced(two: &Two, own: &dyn OwnedLog, next: Option<&dyn OwnedLog>) {
    let before = two.one.read(&session("s")).unwrap();
    for durability in [Durability::Now, Durability::Later, Durability::Now] {
        assert!(matches!(own.append("late\n", durability), Err(StoreError::Lost(_))));
    }
    assert!(own.is_lost());
    assert_eq!(two.one.read(&session("s")).unwrap(), before);
    if let Some(next) = next {
        next.append("next\n", Durability::Now).unwrap();
        let text = [before.unwrap(), b"next\n".to_vec()].concat();
        assert_eq!(two.other.read(&session("s")).unwrap().unwrap(), text);
    }
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn an_owner_whose_lease_was_taken_writes_nothing() {
    let database = Database::new();
    let two = two(&database);
    let own = two.one.own(&session("s")).unwrap();
    own.append("a\n", Durability::Now).unwrap();
    database.run("UPDATE longstep_log SET expires = clock_timestamp()");
    let next = two.other.own(&session("s")).unwrap();
    assert_eq!(next.epoch(), own.epoch() + 1);
    is_fenced(&two, own.as_ref(), Some(next.as_ref()));
    // What the late owner gives back is not the lease of the next one.
    drop(own);
    assert!(is_refused(&two.one, &session("s")));
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn an_owner_whose_lease_has_ended_writes_nothing() {
    let database = Database::new();
    let two = two(&database);
    let own = two.one.own(&session("s")).unwrap();
    database.run("UPDATE longstep_log SET expires = clock_timestamp()");
    is_fenced(&two, own.as_ref(), None);
    // Nobody needs to write to learn it.
    let own = two.one.own(&session("s")).unwrap();
    database.run("UPDATE longstep_log SET owner = 'another', epoch = epoch + 1");
    thread::sleep(LEASE);
    assert!(own.is_lost());
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn an_owner_that_does_not_know_the_log_writes_nothing() {
    let database = Database::new();
    let two = two(&database);
    let own = two.one.own(&session("s")).unwrap();
    own.append("a\n", Durability::Now).unwrap();
    // An addition whose answer was lost on its way.
    database.run("UPDATE longstep_log SET length = length + 2 WHERE kind = 'session'");
    database.run("INSERT INTO longstep_line (kind, id, place, epoch, text) VALUES ('session', 's', 2, 1, E'b\\n')");
    is_fenced(&two, own.as_ref(), None);
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn a_database_that_is_away_ends_the_rights_of_a_server() {
    let database = Database::new();
    let store = opened(&database);
    let own = store.own(&session("s")).unwrap();
    own.append("a\n", Durability::Now).unwrap();
    database.shut();
    let began = Instant::now();
    while !own.is_lost() {
        assert!(began.elapsed() < LEASE, "{:?}", began.elapsed());
        thread::sleep(Duration::from_millis(5));
    }
    assert!(own.append("b\n", Durability::Now).is_err());
    database.open();
    drop(own);
    let again = store.own(&session("s")).unwrap();
    again.append("c\n", Durability::Now).unwrap();
    assert_eq!(store.read(&session("s")).unwrap().unwrap(), b"a\nc\n");
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn the_audit_log_of_a_database_has_many_servers() {
    let database = Database::new();
    let two = two(&database);
    thread::scope(|scope| {
        for (name, store) in [("one", &two.one), ("other", &two.other)] {
            let log = store.own(&LogName::Audit).unwrap();
            scope.spawn(move || {
                for number in 0..100 {
                    log.append(&format!("{name} {number}\n"), Durability::Now).unwrap();
                }
            });
        }
    });
    let text = String::from_utf8(two.one.read(&LogName::Audit).unwrap().unwrap()).unwrap();
    for name in ["one", "other"] {
        let own: Vec<&str> = text.lines().filter(|line| line.starts_with(name)).collect();
        let expected: Vec<String> = (0..100).map(|number| format!("{name} {number}")).collect();
        assert_eq!(own, expected);
    }
    assert_eq!(two.other.tail(&LogName::Audit, 1_000).unwrap().len(), 200);
}

#[test]
#[ignore = "needs LONGSTEP_POSTGRES, which scripts/postgres.sh prints"]
fn no_error_of_a_database_has_its_password() {
    let database = Database::new();
    let place = database.address.rsplit_once('@').unwrap().1;
    let (host, name) = place.split_once('/').unwrap();
    let port = host.rsplit_once(':').unwrap().1;
    for address in [
        format!("postgres://postgres:hunter2@{place}"),
        format!("postgres://postgres:hunter2@127.0.0.1:1/{name}"),
        format!("postgres://postgres:hunter2@127.0.0.1:{port}/there/is/none"),
        "postgres://postgres:hunter2@no host/x".to_owned(),
        "postgres://postgres:hun/ter2@127.0.0.1:99999/x".to_owned(),
        "postgres://postgres:hunter2@127.0.0.1/x?sslmode=always".to_owned(),
        "postgres://127.0.0.1/x?password=hunter2&port=y".to_owned(),
        "hunter2".to_owned(),
    ] {
        let error = PostgresStore::open(&address, PostgresOptions::default()).err().unwrap();
        let shown = format!("{error} {error:?}");
        let is_shown = shown.contains("ter2") && address.contains("://");
        assert!(!is_shown, "{address}: {shown}");
    }
}
