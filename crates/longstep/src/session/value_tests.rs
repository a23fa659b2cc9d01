//! Values in a session: quantities and texts that instructions and replies mention.

use super::tests::{goals, reply, scripted};
use super::{Entry, Event, Log, Response, Session, Settings};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::domain::Domain;
use longstep_core::testing;

const FLAT: &str = r#"{"assets": ["<thermostat>", "<oven>"], "objects": ["<pie>"],
    "asset_states": {"<thermostat>": "set_to(18 degC)"}, "asset_properties": {"<oven>": ["OVEN"]}}"#;

fn home() -> Domain {
    testing::domain("home").into()
}

fn session(domain: &Domain, strategy: super::Strategy) -> Session {
    let settings = Settings::default().with_strategy(strategy);
    scripted(domain.clone(), FLAT, ConstraintKind::JsonSchema, settings)
}

fn answered(session: &mut Session, instruction: &str, text: &str) {
    session.instruct(instruction).unwrap();
    session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    session.supply(&reply(text), 1.0).unwrap();
}

#[track_caller]
fn check_steps(session: &Session, expected: &[&str]) {
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response());
    };
    let world = proposal.plan.world();
    let steps = proposal.plan.plan().steps().iter();
    let calls: Vec<String> = steps.map(|step| step.call(world).to_string()).collect();
    assert_eq!(calls, expected);
}

#[test]
fn values_come_from_instructions_and_replies_and_last_as_long_as_their_facts() {
    let domain = home();
    let mut session = session(&domain, super::Strategy::Goal);
    let mut events = session.take_events();
    // The instruction gives the value in another unit than the reply.
    answered(
        &mut session,
        "set the thermostat to 22 degrees",
        &goals(&["set(thermostat, 22 °C)"]),
    );
    check_steps(&session, &["Set(<thermostat>, 22 degC)"]);
    session.accept().unwrap();
    let states = |session: &Session| {
        session.world().environment().asset_states["<thermostat>"]
            .as_slice()
            .to_vec()
    };
    assert_eq!(states(&session), ["set_to(22 degC)"]);
    // The reply alone has a value.
    answered(
        &mut session,
        "heat the pie in the oven",
        &goals(&["heated(pie, oven, 2 min)"]),
    );
    check_steps(&session, &["Heat(<pie>, <oven>, 120 s)"]);
    session.accept().unwrap();
    session.add_rule("never set(thermostat, 25 degC)").unwrap();
    answered(
        &mut session,
        "the thermostat at 25 degrees",
        &goals(&["set(thermostat, 25 degC)"]),
    );
    assert!(matches!(session.response(), Response::NoPlan(_)));
    events.extend(session.take_events());
    let line = |event: Event| {
        let at = "2026-01-01T00:00:00Z".to_owned();
        Entry::new(at, event).line()
    };
    let text: String = events.into_iter().map(line).collect();
    let log = Log::read(text.as_bytes()).unwrap();
    let resumed = Session::resume(domain, &log, Clock::none()).unwrap().session;
    assert_eq!(states(&resumed), ["set_to(22 degC)"]);
    assert_eq!(resumed.rules().len(), 1);
    assert_eq!(resumed.accepted().len(), 2);
}

#[test]
fn direct_strategy_accepts_values_that_nobody_mentioned() {
    let domain = home();
    let mut session = session(&domain, super::Strategy::Direct);
    let plan = |call: &str, state: &str| {
        serde_json::json!({
            "task_cohesion": {"task_sequence": [call], "step_instructions": ["warmer"]},
            "environment_after": {"assets": ["<thermostat>", "<oven>"], "objects": ["<pie>"],
                "asset_states": {"<thermostat>": state}},
        })
        .to_string()
    };
    answered(
        &mut session,
        "make it warm",
        &plan("Set(<thermostat>, 24 degC)", "set_to(24 degC)"),
    );
    check_steps(&session, &["Set(<thermostat>, 24 degC)"]);
    session.accept().unwrap();
    answered(
        &mut session,
        "even warmer",
        &plan("Set(<thermostat>, 40 degC)", "set_to(40 degC)"),
    );
    assert!(!matches!(session.response(), Response::Plan(_)));
}
