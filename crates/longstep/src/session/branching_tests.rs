//! Sessions with plans that have several endings.

use super::tests::{goals, reply, scripted};
use super::{Entry, Event, Log, Response, Session, Settings};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::domain::{self, Domain};

const LARDER: &str = r#"{"assets": ["<worktop>", "<shelf>", "<trash_bin>"], "objects": ["<cheese>"],
    "object_states": {"<cheese>": "on_something(<worktop>)"}}"#;

fn checks() -> Domain {
    domain::shipped("household-checks").unwrap().unwrap()
}

fn session() -> Session {
    scripted(checks(), LARDER, ConstraintKind::JsonSchema, Settings::default())
}

fn log(events: &[Event]) -> Log {
    let line = |event: &Event| {
        let event = event.clone();
        Entry::new(String::new(), event).line()
    };
    Log::read(events.iter().map(line).collect::<String>().as_bytes()).unwrap()
}

fn where_is_the_cheese(session: &Session) -> Vec<String> {
    let states = &session.world().environment().object_states["<cheese>"];
    states.as_slice().to_vec()
}

#[test]
fn session_continues_from_the_reported_ending() {
    let mut session = session();
    session
        .instruct("If the cheese has expired put it in the trash bin, otherwise on the shelf")
        .unwrap();
    let counter = &mut EstimatedTokens::default();
    assert!(matches!(session.next_request(counter), Ok(Some(_))));
    let goal = "if expired(cheese) then put(cheese, trash bin) else put(cheese, shelf)";
    session.supply(&reply(&goals(&[goal])), 1.0).unwrap();
    assert!(!session.proposal().unwrap().plan.plan().is_sequence());
    session.accept().unwrap();
    let Response::Endings(endings) = session.response() else {
        panic!()
    };
    let when: Vec<&[String]> = endings.iter().map(|ending| ending.when.as_slice()).collect();
    assert_eq!(
        when.concat(),
        ["the cheese is not past its date", "the cheese is past its date"]
    );
    // Only an existing ending is accepted now.
    assert!(session.instruct("Put the cheese on the worktop").is_err());
    assert!(session.cancel().is_err());
    assert!(session.ended(2).is_err());
    let mut events = session.take_events();
    let resumed = Session::resume(checks(), &log(&events), Clock::none()).unwrap().session;
    assert_eq!(resumed.endings(), endings);

    session.ended(1).unwrap();
    assert!(where_is_the_cheese(&session).contains(&"inside_something(<trash_bin>)".to_owned()));
    events.extend(session.take_events());
    let resumed = Session::resume(checks(), &log(&events), Clock::none()).unwrap().session;
    assert_eq!(resumed.world().environment(), session.world().environment());
    assert!(resumed.endings().is_empty());
    let file = session.plan_file(0).unwrap();
    assert_eq!((file.environment_after, file.endings.len()), (None, 2));

    session.undo().unwrap();
    assert_eq!(where_is_the_cheese(&session), ["on_something(<worktop>)"]);
}
