//! Sessions whose world is observed between instructions, and whose plans a robot carries out.

use super::tests::{goals, household, reply, scripted, text_of};
use super::{Log, ObserveError, Session, Settings, replay};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::domain;
use longstep_core::environment::Observation;

const KITCHEN: &str = r#"{"assets": ["<table>", "<shelf>", "<fridge>"], "objects": ["<milk>", "<cup>"],
    "object_states": {"<milk>": "inside_something(<fridge>)", "<cup>": "on_something(<table>)"}}"#;

const CHECKS: &str = r#"{"assets": ["<worktop>", "<shelf>", "<trash_bin>"], "objects": ["<cheese>"],
    "object_states": {"<cheese>": "on_something(<worktop>)"}}"#;

fn session_of(name: &str, text: &str) -> Session {
    let domain = domain::shipped(name).unwrap().unwrap();
    scripted(domain, text, ConstraintKind::JsonSchema, Settings::default())
}

fn session() -> Session {
    session_of("household", KITCHEN)
}

fn planned(session: &mut Session, instruction: &str, goal: &str) {
    session.instruct(instruction).unwrap();
    session.next_request(&mut EstimatedTokens::default()).unwrap();
    session.supply(&reply(&goals(&[goal])), 1.0).unwrap();
}

fn accepted(session: &mut Session, instruction: &str, goal: &str) {
    planned(session, instruction, goal);
    session.accept().unwrap();
}

fn seen(text: &str) -> Observation {
    serde_json::from_str(text).unwrap()
}

fn place(session: &Session, object: &str) -> String {
    let states = &session.world().environment().object_states;
    states
        .get(object)
        .map_or_else(String::new, |words| words.as_slice().join(", "))
}

/// Resumes the session from its log at every step of a test, and compares.
fn resumed(session: &Session, log: &str) -> Session {
    let read = Log::read(log.as_bytes()).unwrap();
    let again = Session::resume(session.domain().clone(), &read, Clock::none()).unwrap();
    assert_eq!(again.dropped, None);
    let mut again = again.session;
    assert_eq!(again.world().environment(), session.world().environment());
    assert_eq!(again.world().state, session.world().state);
    assert_eq!(again.pending(), session.pending());
    assert_eq!(again.robot_world().environment(), session.robot_world().environment());
    assert_eq!(again.endings(), session.endings());
    assert_eq!(again.take_events(), []);
    let same = replay(session.domain().clone(), &read).unwrap();
    assert_eq!(same.differing, []);
    again
}

#[test]
fn the_next_plan_begins_in_the_observed_world() {
    let mut session = session();
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    let observed = session
        .observed(&seen(
            r#"{"states": {"<milk>": "on_something(<table>)", "<cup>": "on_something(<shelf>)", "<cat>": []}}"#,
        ))
        .unwrap();
    assert_eq!(
        observed.changes,
        ["the milk is not in the fridge any more", "the milk is on the table"]
    );
    assert_eq!(observed.unknown, ["<cat>"]);
    planned(&mut session, "The milk goes on the shelf", "put(milk, shelf)");
    let detach = &session.proposal().unwrap().answer.plan.task_cohesion.task_sequence;
    assert!(detach.contains(&"detach_from_plane()".to_owned()), "{detach:?}");
    session.accept().unwrap();
    assert_eq!(session.accepted().len(), 2);
    let log = text_of(session.take_events());
    resumed(&session, &log);
}

#[test]
fn an_observation_belongs_between_instructions_and_changes_nothing_if_it_cannot_be_read() {
    let mut session = session();
    let milk = seen(r#"{"states": {"<milk>": "on_something(<table>)"}}"#);
    planned(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    assert!(matches!(session.observed(&milk), Err(ObserveError::OutOfTurn(_))));
    assert!(session.proposal().is_some());
    session.cancel().unwrap();
    for wrong in [
        r#"{"states": {"<milk>": "flying()"}}"#,
        r#"{"states": {"<milk>": "on_something(<moon>)"}}"#,
        r#"{"facts": ["raining()"]}"#,
    ] {
        let before = session.take_events();
        assert!(matches!(
            session.observed(&seen(wrong)),
            Err(ObserveError::Observation(_))
        ));
        assert_eq!(session.take_events(), [], "{wrong} {before:?}");
        assert_eq!(place(&session, "<milk>"), "inside_something(<fridge>)");
    }
    // An instruction that is stuck ends with it.
    planned(
        &mut session,
        "The milk goes on the shelf, but do not take it",
        "put(milk, shelf) & untouched(milk)",
    );
    assert!(session.failure().is_some(), "{}", session.response());
    session.observed(&milk).unwrap();
    assert!(session.failure().is_none());
}

#[test]
fn session_undo_keeps_observed_facts() {
    let mut session = session();
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    session
        .observed(&seen(r#"{"states": {"<milk>": "on_something(<table>)"}}"#))
        .unwrap();
    accepted(&mut session, "The milk goes on the shelf", "put(milk, shelf)");
    let mut log = text_of(session.take_events());
    for (left, cup, milk) in [
        (1, "on_something(<shelf>)", "on_something(<table>)"),
        (0, "on_something(<table>)", "on_something(<table>)"),
    ] {
        session.undo().unwrap();
        assert_eq!(session.accepted().len(), left);
        assert_eq!(
            (place(&session, "<cup>").as_str(), place(&session, "<milk>").as_str()),
            (cup, milk)
        );
        log += &text_of(session.take_events());
        resumed(&session, &log);
    }
}

#[test]
fn plans_wait_for_a_robot_until_it_has_carried_them_out() {
    let mut session = session();
    assert_eq!(session.pending(), 0..0);
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    accepted(&mut session, "The milk goes on the table", "put(milk, table)");
    assert_eq!(session.pending(), 0..2);
    assert_eq!(
        session.robot_world().environment().object_states["<cup>"].as_slice(),
        ["on_something(<table>)"]
    );
    let end = seen(r#"{"states": {"<cup>": "on_something(<shelf>)", "<milk>": "inside_something(<fridge>)"}}"#);
    assert_eq!(session.carried_out(1, true, &end), Err(ObserveError::NotNext(1)));
    session.carried_out(0, true, &end).unwrap();
    assert_eq!(session.pending(), 1..2);
    // The second one stops; the cup has fallen on the table.
    let stopped = seen(r#"{"states": {"<cup>": "on_something(<table>)", "<milk>": "inside_hand()"}}"#);
    session.carried_out(1, false, &stopped).unwrap();
    assert_eq!(session.pending(), 1..2);
    assert_eq!(place(&session, "<milk>"), "inside_hand()");
    assert_eq!(place(&session, "<cup>"), "on_something(<table>)");
    let mut log = text_of(session.take_events());
    resumed(&session, &log);
    // A plan from here takes the place of the one that stopped.
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    assert_eq!((session.pending(), session.accepted().len()), (2..3, 3));
    log += &text_of(session.take_events());
    resumed(&session, &log);
    session.undo().unwrap();
    assert_eq!(session.pending(), 2..2);
    assert_eq!(place(&session, "<milk>"), "inside_hand()");
    log += &text_of(session.take_events());
    resumed(&session, &log);
    // What a robot did is not undone with its plan.
    session.undo().unwrap();
    session.undo().unwrap();
    assert_eq!(
        (session.pending(), place(&session, "<cup>").as_str()),
        (0..0, "on_something(<table>)")
    );
    assert_eq!(place(&session, "<milk>"), "inside_hand()");
    log += &text_of(session.take_events());
    resumed(&session, &log);
}

#[test]
fn observation_selects_the_ending_of_a_branching_plan() {
    let goal = "if expired(cheese) then put(cheese, trash bin) else put(cheese, shelf)";
    let said = "If the cheese has expired put it in the trash bin, otherwise on the shelf";
    for (statements, left, cheese) in [
        (
            r#"{"states": {"<cheese>": "inside_something(<trash_bin>)"}}"#,
            0,
            "inside_something(<trash_bin>)",
        ),
        (r#"{"states": {"<cheese>": "on_something(<worktop>)"}}"#, 2, ""),
        ("{}", 2, ""),
    ] {
        let mut session = session_of("household-checks", CHECKS);
        accepted(&mut session, said, goal);
        assert_eq!(session.endings().len(), 2);
        session.observed(&seen(statements)).unwrap();
        assert_eq!(session.endings().len(), left, "{statements}");
        assert_eq!(session.accepted().len(), 1);
        if left == 0 {
            assert!(
                place(&session, "<cheese>").contains(cheese),
                "{}",
                place(&session, "<cheese>")
            );
        }
        let log = text_of(session.take_events());
        resumed(&session, &log);
    }
    // A run knows which ending it was.
    let mut session = session_of("household-checks", CHECKS);
    accepted(&mut session, said, goal);
    let end = seen(r#"{"states": {"<cheese>": ["on_something(<shelf>)"]}}"#);
    session.carried_out(0, true, &end).unwrap();
    assert!(session.endings().is_empty());
    let log = text_of(session.take_events());
    resumed(&session, &log);
}

/// The log of a session with observations is cut at any byte: every accepted plan is there.
#[test]
fn an_interrupted_session_loses_no_plan_by_an_observation() {
    let mut session = session();
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    let end = seen(r#"{"states": {"<cup>": "on_something(<shelf>)"}}"#);
    session.carried_out(0, true, &end).unwrap();
    session
        .observed(&seen(r#"{"states": {"<cup>": "on_something(<table>)"}}"#))
        .unwrap();
    accepted(&mut session, "The cup goes on the shelf", "put(cup, shelf)");
    let text = text_of(session.take_events());
    let first = text.find('\n').unwrap() + 1;
    for cut in (first..=text.len()).step_by(41) {
        let log = Log::read(&text.as_bytes()[..cut]).unwrap();
        let plans = log
            .events()
            .filter(|event| matches!(event, super::Event::Accept { .. }));
        let plans = plans.count();
        let again = Session::resume(household(), &log, Clock::none()).unwrap();
        assert_eq!(again.session.accepted().len(), plans, "cut at {cut}");
    }
}
