//! Tests of values: quantities and texts as arguments.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, missing_docs)]

use longstep_model::environment::*;
use longstep_model::model::Domain;
use longstep_model::testing;
use longstep_search::goal::{self, GoalError};
use longstep_search::pddl;
use longstep_search::search::{Limits, Outcome, solve};
use longstep_verify::plan::{PlanFile, TaskCohesion, Written, resolve, script};
use longstep_verify::verify::check;

fn home() -> Domain {
    testing::domain("home")
}

const FLAT: &str = r#"{"assets": ["<thermostat>", "<oven>"], "objects": ["<pie>"],
    "asset_states": {"<thermostat>": "set_to(18 degC)"}, "asset_properties": {"<oven>": ["OVEN"]}}"#;

fn flat(text: &str) -> World {
    let mut world = testing::world("home", FLAT);
    goal::add_values(&mut world, text);
    world
}

#[track_caller]
fn check_plan(text: &str, expected: &[&str]) {
    let world = flat(text);
    let goal = goal::parse(&world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
    assert_eq!(
        goal::parse(&world, &goal.exact(&world).join(" & ")).unwrap(),
        goal,
        "{text}"
    );
    let purpose = goal.purpose(&world);
    let Outcome::Solved { plan, .. } = solve(&world, &purpose, &Limits::default()) else {
        panic!("no plan for {text}");
    };
    let calls: Vec<String> = plan.steps().iter().map(|step| step.call(&world).to_string()).collect();
    assert_eq!(calls, expected, "{text}");
    let verified = check(&world, plan.clone(), &purpose).into_verified().unwrap();

    // Every notation of the plan is read back in a world without the values.
    let fresh = flat("");
    let written = Written::of_plan(&world, &plan);
    let texts = [
        TaskCohesion {
            task_sequence: calls,
            ..TaskCohesion::default()
        },
        TaskCohesion::from_written(script::read(&script::write(&written)).unwrap()),
    ];
    for cohesion in texts {
        let file = PlanFile::from(cohesion);
        let own = file.world_of(&fresh);
        let resolved = resolve(&own, &file.task_cohesion);
        assert_eq!(
            (resolved.issues.len(), resolved.readings.len()),
            (0, 0),
            "{text}: {:?}",
            resolved.issues
        );
    }

    // The environment after the plan is read as the state after the plan.
    let after = world.after(verified.ending());
    let again = read(&home(), after.environment(), "", "", &Default::default()).unwrap();
    assert_eq!(write(&again, &again.state), *after.environment(), "{text}");
    if !goal.stages.is_empty() {
        // A PDDL problem has no order.
        return;
    }
    let problem = pddl::write_problem(&world, &purpose, "flat").unwrap();
    assert!(
        pddl::read_problem(&home(), "flat.pddl", &problem).is_ok(),
        "{text}: {problem}"
    );
}

#[test]
fn goals_with_values_are_solved_written_and_read_again() {
    check_plan("set(thermostat, 22 degrees)", &["Set(<thermostat>, 22 degC)"]);
    check_plan("set(thermostat, 20.5°C)", &["Set(<thermostat>, 20.5 degC)"]);
    check_plan("heated(pie, oven, 3 min)", &["Heat(<pie>, <oven>, 180 s)"]);
    check_plan(
        "announced(\"soup & bread, (hot) then tea\") then set(thermostat, 18 degC)",
        &["Announce(\"soup & bread, (hot) then tea\")"],
    );
}

#[test]
fn an_amount_may_be_relative_to_what_is_now() {
    check_plan("set(thermostat, now + 2 degC)", &["Set(<thermostat>, 20 degC)"]);
    let text = "set(all thermostat, now - 0.5)";
    let world = flat(text);
    let goal = goal::parse(&world, text).unwrap();
    assert_eq!(goal.exact(&world), ["set(<thermostat>, 17.5 degC)"]);
    check_plan("set(thermostat, now * 1.5)", &["Set(<thermostat>, 27 degC)"]);
    for (text, expected) in [
        (
            "set(thermostat, now + 20 degC)",
            "`38 degC` is more than `30 degC`, the limit for a temperature",
        ),
        (
            "heated(pie, oven, now + 3 min)",
            "`now + 3 min` in `heated(pie, oven, now + 3 min)` is relative to an amount that is not known",
        ),
        (
            "set(thermostat, now + 2 min)",
            "`now + 2 min` in `set(thermostat, now + 2 min)` is relative to an amount that is not known",
        ),
    ] {
        let error = goal::parse(&flat(text), text).unwrap_err().to_string();
        assert_eq!(error, expected, "{text}");
    }
}

#[test]
fn a_value_out_of_range_is_an_error_with_its_limit() {
    let world = flat("set(thermostat, 35 degC)");
    let error = goal::parse(&world, "set(thermostat, 35 degC)").unwrap_err();
    assert_eq!(
        error.to_string(),
        "`35 degC` is more than `30 degC`, the limit for a temperature"
    );
    let plan = PlanFile::from(TaskCohesion {
        task_sequence: vec!["Set(<thermostat>, 35 degC)".to_owned()],
        ..TaskCohesion::default()
    });
    let own = plan.world_of(&world);
    let issues = resolve(&own, &plan.task_cohesion).issues;
    let messages: Vec<String> = issues.iter().map(|issue| issue.message(&own, &[], None)).collect();
    assert_eq!(
        messages,
        ["step 1: `35 degC` is more than `30 degC`, the limit for a temperature"]
    );
    let text = FLAT.replace("18 degC", "50 degC");
    let findings = parse(&home(), "flat.json", &text).unwrap_err().to_string();
    assert!(findings.contains("`50 degC` is more than `30 degC`"), "{findings}");
}

#[test]
fn a_value_that_was_not_added_is_an_error_and_no_panic() {
    let world = flat("");
    let error = goal::parse(&world, "set(thermostat, 22 degC)").unwrap_err();
    assert_eq!(
        error,
        GoalError::NewValue {
            written: "22 degC".to_owned()
        }
    );
}

#[test]
fn a_name_in_place_of_a_value_is_an_error_with_its_notation() {
    for (text, expected) in [
        (
            "announced(dinner is ready)",
            "`dinner is ready` in `announced(dinner is ready)` is no message; write a text in double quotes: `\"dinner is ready\"`",
        ),
        (
            "set(thermostat, warm)",
            "`warm` in `set(thermostat, warm)` is no temperature; write a number with its unit, `degC`",
        ),
        ("announced(oven)", "is no message"),
    ] {
        let error = goal::parse(&flat(text), text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}");
    }
}

#[test]
fn added_values_leave_other_ids_as_they_are() {
    let before = flat("");
    let mut world = before.clone();
    world.add_values("22 degrees, 3 min, 22 °C, \"hello\"");
    assert_eq!(world.entities().count(), before.entities().count() + 3);
    for (id, entity) in before.entities() {
        assert_eq!(world.entity(id).identifier, entity.identifier);
    }
    let value = world.exactly("22 degC").unwrap();
    assert_eq!(world.entity(value).names, ["22 degC", "22 degrees", "22 °C"]);
    assert!(world.narrowed(&[]).find("180 s").is_some());
}
