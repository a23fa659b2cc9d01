//! Feedback that has more than one reading.

use super::tests::{edits, goals, household, reply, scripted, text_of};
use super::{Event, Log, Session, Settings, replay};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::domain;
use crate::plan::Step;

/// A household whose fridge was left open.
const LARDER: &str = r#"{"assets": ["<counter>", "<fridge>", "<table>"],
    "objects": ["<cereal>", "<milk>", "<sponge>", "<fridge_handle>"],
    "object_states": {"<cereal>": "on_something(<counter>)", "<milk>": "on_something(<counter>)",
        "<sponge>": "on_something(<table>)", "<fridge_handle>": "open()"}}"#;

const STUDIO: &str = r#"{
    "assets": ["<desk_1>", "<fridge_2>", "<sofa_3>", "<tablelamp_5>"],
    "objects": ["<milk_4>", "<mug_6>"],
    "object_states": {"<milk_4>": ["ON(<desk_1>)"], "<mug_6>": ["ON(<sofa_3>)"]},
    "asset_properties": {"<fridge_2>": ["IS_OPENABLE"], "<desk_1>": ["NOT_OPENABLE"], "<sofa_3>": ["NOT_OPENABLE"]}}"#;

fn session(name: &str, environment: &str, kind: ConstraintKind) -> Session {
    let domain = domain::shipped(name).unwrap().unwrap();
    scripted(domain, environment, kind, Settings::default())
}

/// Has a model answer the request that the session has for it.
fn answer(session: &mut Session, text: &str) {
    session.next_request(&mut EstimatedTokens::default()).unwrap();
    session.supply(&reply(text), 1.0).unwrap();
}

/// A session with a plan for an instruction, after feedback that was read as this change of the steps.
fn reread(name: &str, environment: &str, plan: (&str, &str), feedback: &str, change: &str) -> Session {
    let mut session = session(name, environment, ConstraintKind::JsonSchema);
    let (instruction, goal) = plan;
    session.instruct(instruction).unwrap();
    answer(&mut session, &goals(&[goal]));
    assert!(session.proposal().is_some(), "{instruction}");
    session.feedback(feedback).unwrap();
    answer(&mut session, &edits(&[change]));
    session
}

fn goal_texts(session: &Session) -> Vec<String> {
    let goal = session.proposal().unwrap().goal.as_ref().unwrap();
    goal.everyday(session.world())
}

fn sentences(session: &Session) -> Vec<&str> {
    let steps: &[Step] = session.proposal().unwrap().plan.steps();
    steps.iter().map(|step| step.explanation.as_str()).collect()
}

const CEREAL: (&str, &str) = ("Put the cereal in the fridge", "put(cereal, fridge)");
const MILK: (&str, &str) = ("Put the milk in the fridge", "put(milk, fridge)");

fn refusals(session: &Session) -> Vec<String> {
    let refused = &session.proposal().unwrap().refused;
    refused.iter().map(ToString::to_string).collect()
}

#[test]
fn request_for_a_further_goal_includes_the_earlier_goal() {
    let asked = || {
        let mut session = session("household", LARDER, ConstraintKind::Grammar);
        session.instruct(CEREAL.0).unwrap();
        answer(&mut session, CEREAL.1);
        session.feedback("And the milk too").unwrap();
        answer(&mut session, "further");
        session
    };
    let mut session = asked();
    let request = session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    let last: Vec<&str> = request
        .request
        .messages
        .iter()
        .rev()
        .map(|own| own.text.as_str())
        .take(2)
        .collect();
    assert_eq!(last, ["And the milk too", CEREAL.1]);
    let both = format!("{} & {}", CEREAL.1, MILK.1);
    answer(&mut session, &both);
    assert_eq!(goal_texts(&session).join(" & "), both);
    session.accept().unwrap();
    // The plan that stays is for the instruction alone.
    let mut session = asked();
    session.cancel().unwrap();
    session.accept().unwrap();
    assert_eq!(goal_texts_of_last(&session), [CEREAL.1]);
}

fn goal_texts_of_last(session: &Session) -> Vec<String> {
    let goal = session.accepted()[0].goal.as_ref().unwrap();
    goal.everyday(session.world())
}

#[test]
fn reread_takes_an_impossible_step_as_a_further_goal() {
    for (name, environment, plan, feedback, change, further) in [
        (
            "household",
            LARDER,
            CEREAL,
            "close the fridge afterwards",
            "insert close_by_rotate() after 3",
            "closed(fridge)",
        ),
        (
            "household",
            LARDER,
            CEREAL,
            "close it",
            "insert close_by_rotate() after 4",
            "closed(fridge)",
        ),
        (
            "household",
            LARDER,
            CEREAL,
            "wipe the table with the sponge before that",
            "insert wipe_on_plane() before 1",
            "wiped(table, sponge)",
        ),
        (
            "household",
            LARDER,
            CEREAL,
            "the milk should be put there too",
            "insert detach_from_plane() after 1",
            "put(milk, fridge)",
        ),
        (
            "virtualhome",
            STUDIO,
            MILK,
            "leave the fridge open",
            "drop 6",
            "opened(fridge)",
        ),
        (
            "virtualhome",
            STUDIO,
            MILK,
            "it is dark, switch on the lamp",
            "insert SwitchOff(tablelamp) after 3",
            "on(lamp)",
        ),
    ] {
        let mut session = reread(name, environment, plan, feedback, change);
        assert!(session.wants_model(), "{feedback}: {:?}", session.proposal());
        answer(&mut session, &goals(&[plan.1, further]));
        assert_eq!(goal_texts(&session), [plan.1, further], "{feedback}");
        assert!(session.proposal().unwrap().refused.is_empty(), "{feedback}");
    }
}

#[test]
fn reread_moves_an_existing_step_as_requested() {
    let both = "put(cereal, fridge) & wiped(table, sponge)";
    let both = ("Put the cereal in the fridge and wipe the table with the sponge", both);
    let wipe = "insert wipe_on_plane() before 1";
    let session = reread("household", LARDER, both, "wipe the table first", wipe);
    let expected = [
        "move the hand to the sponge",
        "grasp the sponge",
        "wipe the table with the sponge",
        "release the sponge",
        "move the hand to the cereal",
        "grasp the cereal",
        "pick up the cereal from the counter",
        "move the cereal to the fridge",
        "put down the cereal at the fridge",
        "release the cereal",
    ];
    assert_eq!(sentences(&session), expected);
}

#[test]
fn reread_refuses_a_wish_with_all_reasons() {
    let take = ("Take the milk", "held(milk)");
    let mut session = reread("virtualhome", STUDIO, take, "take the mug too", "drop 2");
    answer(&mut session, &goals(&["held(milk)", "held(mug)"]));
    let reasons = [
        "at the end, this is not reached: the milk is in hand",
        "as a further goal: no plan can do this",
    ];
    assert_eq!(refusals(&session), reasons);
    assert_eq!(goal_texts(&session), ["held(milk)"]);
}

#[test]
fn reread_is_skipped_if_feedback_names_a_step() {
    let session = reread(
        "virtualhome",
        STUDIO,
        MILK,
        "skip step 4, leave the fridge open",
        "drop 4",
    );
    assert!(!session.wants_model());
    assert_eq!(session.proposal().unwrap().refused.len(), 2);
}

#[test]
fn reread_keeps_the_first_reasons_after_a_failed_call() {
    let refused = || {
        let edit = "insert close_by_rotate() after 3";
        reread("household", LARDER, CEREAL, "close the fridge", edit)
    };
    let mut session = refused();
    session.failed("the server is down").unwrap();
    let reasons = [
        "step 4: close_by_rotate() needs that the cereal is open",
        "as a further goal: the server is down",
    ];
    assert_eq!(refusals(&session), reasons);
    let mut session = refused();
    session.cancel().unwrap();
    assert!(session.proposal().unwrap().refused.is_empty());
    // The reading is forgotten: the words of later feedback stand alone.
    session.feedback("put it on the table instead").unwrap();
    answer(&mut session, r#"{"question": "", "goal": true, "edits": []}"#);
    answer(&mut session, &goals(&["put(cereal, table)"]));
    assert_eq!(goal_texts(&session), ["put(cereal, table)"]);
}

#[test]
fn resume_accepts_a_log_that_refuses_at_once() {
    let mut session = reread(
        "household",
        LARDER,
        CEREAL,
        "close the fridge",
        "insert close_by_rotate() after 3",
    );
    let mut events = session.take_events();
    events.push(Event::Refused {
        why: vec!["step 4: no".to_owned()],
    });
    let log = Log::read(text_of(events).as_bytes()).unwrap();
    let resumed = Session::resume(household(), &log, Clock::none()).unwrap();
    assert_eq!(refusals(&resumed.session), ["step 4: no"]);
    let replayed = replay(household(), &log).unwrap();
    assert_eq!(replayed.differing.len(), 1);
}
