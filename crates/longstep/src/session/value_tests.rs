//! Values in a session: quantities and texts that instructions and replies mention.

use super::tests::{goals, reply};
use super::{Entry, Event, Log, ModelFacts, Response, Session, Settings};
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::domain::Domain;
use longstep_core::domain::{Files, load};
use longstep_core::environment;

const FLAT: &str = r#"{"assets": ["<thermostat>", "<oven>"], "objects": ["<pie>"],
    "asset_states": {"<thermostat>": "set_to(18 degC)"}, "asset_properties": {"<oven>": ["OVEN"]}}"#;

fn home() -> longstep_core::domain::Domain {
    let files = Files {
        pddl: include_str!("../../../longstep-model/tests/domains/home/domain.pddl").to_owned(),
        words: include_str!("../../../longstep-model/tests/domains/home/domain.toml").to_owned(),
        ..Files::default()
    };
    load(&files).unwrap_or_else(|findings| panic!("{findings}"))
}

fn session(domain: &Domain, strategy: super::Strategy) -> Session {
    let world = environment::parse(domain, "flat.json", FLAT).unwrap();
    let model = ModelFacts {
        name: "script".to_owned(),
        kind: ConstraintKind::JsonSchema,
        context: None,
    };
    let settings = Settings {
        strategy,
        ..Settings::default()
    };
    Session::new("home", domain.clone(), world, settings, model, || 0.0)
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
    let domain: Domain = home().into();
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
        Entry { at, event }.line()
    };
    let text: String = events.into_iter().map(line).collect();
    let log = Log::read(text.as_bytes()).unwrap();
    let resumed = Session::resume(domain, &log, || 0.0).unwrap().session;
    assert_eq!(states(&resumed), ["set_to(22 degC)"]);
    assert_eq!(resumed.rules().len(), 1);
    assert_eq!(resumed.accepted().len(), 2);
}

#[test]
fn direct_strategy_accepts_values_that_nobody_mentioned() {
    let domain: Domain = home().into();
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
