//! Standing rules: what they forbid, and how long they last.

use super::tests::{MOVE_PEN, direct, goals, household, pen_plan, reply, scripted};
use super::{Entry, Event, Failure, Log, Response, RuleError, Session, Settings};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::report::Status;
use longstep_core::testing;

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<ruler>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<desk>)"}}"#;

fn session(settings: Settings) -> Session {
    scripted(household(), SCENE, ConstraintKind::JsonSchema, settings)
}

fn answered(session: &mut Session, instruction: &str, text: &str) {
    session.instruct(instruction).unwrap();
    session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    session.supply(&reply(text), 1.0).unwrap();
}

fn status(session: &Session) -> Status {
    match session.response() {
        Response::Plan(_) => Status::Verified,
        Response::NoPlan(Failure::NoPlan(answer)) => answer.status,
        other => panic!("{other:?}"),
    }
}

#[test]
fn a_rule_binds_every_plan_until_it_is_lifted() {
    let mut session = session(Settings::default());
    session.add_rule("untouched(ruler)").unwrap();
    session.add_rule("never put(pen, shelf)").unwrap();
    for thing in ["ruler", "pen"] {
        let instruction = format!("put the {thing} on the shelf");
        answered(&mut session, &instruction, &goals(&[&format!("put({thing}, shelf)")]));
        assert_eq!(status(&session), Status::Unsolvable, "{thing}");
    }
    assert_eq!(session.lift_rule(1).unwrap(), "never put(<pen>, <shelf>)");
    answered(&mut session, "put the pen on the shelf", &goals(&["put(pen, shelf)"]));
    assert_eq!(status(&session), Status::Verified);
    session.accept().unwrap();
    // The rule passes on to the next world, and undoing a plan does not bring a lifted one back.
    assert_eq!(session.rules().len(), 1);
    session.undo().unwrap();
    assert_eq!(session.rules().len(), 1);
    answered(
        &mut session,
        "put the ruler on the shelf",
        &goals(&["put(ruler, shelf)"]),
    );
    assert_eq!(status(&session), Status::Unsolvable);
}

#[test]
fn session_expands_groups_in_goals_of_the_model() {
    let mut session = session(Settings::default());
    session.add_rule("untouched(all ruler)").unwrap();
    let text = "put(all item where on_something(desk) except ruler, shelf)";
    answered(
        &mut session,
        "put everything on the desk but the ruler on the shelf",
        &goals(&[text]),
    );
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response())
    };
    let answer = &proposal.answer;
    assert_eq!(answer.goal, ["put(<pen>, <shelf>)"]);
    assert_eq!(
        answer.groups[0].group,
        "all item where on_something(<desk>) except <ruler>"
    );
    assert_eq!(
        answer.groups[0].says,
        "each item (it is on the desk) except the ruler: the pen"
    );
    session.cancel().unwrap();
    let text = "put(any item, shelf)";
    answered(&mut session, "put any item on the shelf", &goals(&[text]));
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response())
    };
    assert_eq!(proposal.answer.goal, ["put(any item, <shelf>)"]);
    assert_eq!(proposal.answer.choices[0].chosen, ["put(<pen>, <shelf>)"]);
}

#[test]
fn a_plan_that_cannot_be_repaired_has_a_reason() {
    let world = testing::world_of(&household(), SCENE);
    let rules = longstep_core::goal::rules(&world, "untouched(pen)").unwrap();
    let world = world.with_prohibitions(rules);
    let draft = longstep_core::plan::read(&pen_plan(&MOVE_PEN, "shelf")).unwrap();
    let answer = crate::report::Assessment::new(&world, draft, None).repaired();
    assert_eq!(answer.status, Status::Unsolvable);
    assert!(
        answer
            .notes
            .iter()
            .any(|note| note.contains("`untouched(<pen>)` prevents it")),
        "{:?}",
        answer.notes
    );
}

#[test]
fn a_plan_that_a_model_writes_keeps_to_the_rules() {
    let mut session = session(direct().with_rounds(0));
    session.add_rule("untouched(pen)").unwrap();
    answered(&mut session, "put the pen on the shelf", &pen_plan(&MOVE_PEN, "shelf"));
    assert!(
        matches!(session.response(), Response::NoPlan(_)),
        "{}",
        session.response()
    );
}

#[test]
fn session_rejects_invalid_rules_without_changes() {
    let mut session = session(Settings::default());
    for (text, expected) in [
        ("put(pen, shelf)", "is a goal and no rule"),
        ("never put(cup, shelf)", "`cup`"),
        ("never dance(pen)", "is not a goal"),
        ("", "empty"),
    ] {
        let error = session.add_rule(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
    session.add_rule("untouched(pen)").unwrap();
    assert!(matches!(session.add_rule("untouched(<pen>)"), Err(RuleError::Known(_))));
    assert_eq!(session.lift_rule(1), Err(RuleError::Unknown(1)));
    session.instruct("put the ruler on the shelf").unwrap();
    assert!(matches!(
        session.add_rule("untouched(ruler)"),
        Err(RuleError::OutOfTurn(_))
    ));
    assert_eq!(session.rules().len(), 1);
}

#[test]
fn a_log_keeps_rules() {
    let mut session = session(Settings::default());
    session.add_rule("untouched(ruler)").unwrap();
    session.add_rule("never put(pen, shelf)").unwrap();
    session.lift_rule(1).unwrap();
    answered(&mut session, "put the pen on the shelf", &goals(&["put(pen, shelf)"]));
    session.accept().unwrap();
    let line = |event: Event| {
        let at = "2026-01-01T00:00:00Z".to_owned();
        Entry::new(at, event).line()
    };
    let text: String = session.take_events().into_iter().map(line).collect();
    let log = Log::read(text.as_bytes()).unwrap();
    let mut resumed = Session::resume(household(), &log, Clock::none()).unwrap().session;
    let written: Vec<&str> = resumed.rules().iter().map(|rule| rule.written.as_str()).collect();
    assert_eq!(written, ["untouched(<ruler>)"]);
    answered(
        &mut resumed,
        "put the ruler on the shelf",
        &goals(&["put(ruler, shelf)"]),
    );
    assert_eq!(status(&resumed), Status::Unsolvable);
}

#[test]
fn a_goal_with_an_order_keeps_it_in_the_plan_and_in_the_log() {
    let mut session = session(Settings::default());
    let parts = ["put(pen, shelf)", "then put(ruler, shelf)", "never put(ruler, desk)"];
    answered(
        &mut session,
        "the pen goes to the shelf and then the ruler",
        &goals(&parts),
    );
    session.accept().unwrap();
    let exact = [
        "put(<pen>, <shelf>)",
        "then put(<ruler>, <shelf>)",
        "never put(<ruler>, <desk>)",
    ];
    let events = session.take_events();
    let kept = events.iter().find_map(|event| match event {
        Event::Accept { goal, .. } => Some(goal),
        _ => None,
    });
    assert_eq!(kept.unwrap(), &exact);
}
