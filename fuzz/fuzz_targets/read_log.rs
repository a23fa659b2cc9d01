//! Any bytes are a session's log, or an error; a session that can be resumed can be resumed again from what it adds.
#![no_main]

use std::sync::{Arc, LazyLock};

use libfuzzer_sys::fuzz_target;
use longstep::Clock;
use longstep::dialogue::EstimatedTokens;
use longstep::domain::{self, Domain};
use longstep::session::{Entry, Event, Log, Session, replay};
use longstep_core::effort;

static CHECKS: LazyLock<Arc<Domain>> =
    LazyLock::new(|| Arc::new(domain::shipped("household-checks").expect("shipped").expect("valid")));

/// Events of a log at most: each may be a whole search.
const EVENTS: usize = 12;

fuzz_target!(|bytes: &[u8]| {
    let log = match Log::read(bytes) {
        Ok(log) => log,
        Err(error) => return drop(error.to_string()),
    };
    assert_eq!(log.whole + log.torn, bytes.len());
    let lines: String = log.entries.iter().map(Entry::line).collect();
    let again = Log::read(lines.as_bytes()).expect("what was written can be read");
    assert_eq!((again.entries, again.torn), (log.entries.clone(), 0));
    if log.entries.len() <= EVENTS {
        effort::within(effort::OPERATION / 10, || take_up(&log));
    }
});

fn take_up(log: &Log) {
    match replay(CHECKS.clone(), log) {
        Ok(replay) => assert!(replay.instructions <= log.entries.len()),
        Err(error) => drop(error.to_string()),
    }
    let mut resumed = match Session::resume(CHECKS.clone(), log, Clock::none()) {
        Ok(resumed) => resumed.session,
        Err(error) => return drop(error.to_string()),
    };
    let added = resumed.take_events();
    let entry = |event: Event| Entry::new(String::new(), event);
    let mut longer = log.clone();
    longer.entries.extend(added.into_iter().map(entry));
    let spent = effort::within(u64::MAX, || Session::resume(CHECKS.clone(), &longer, Clock::none()));
    if spent.exhausted {
        return;
    }
    let again = spent
        .result
        .expect("a session that was resumed can be resumed again")
        .session;
    assert_eq!(again.world().environment(), resumed.world().environment());
    assert_eq!(again.accepted().len(), resumed.accepted().len());
    drop(resumed.next_request(&mut EstimatedTokens::default()));
}
