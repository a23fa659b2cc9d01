//! Environments that plans and goals lead to.

#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use longstep_model::json::Path;
use longstep_model::model::Domain;
use longstep_model::model::{Environment, World};
use longstep_model::{environment, testing};
use longstep_search::goal;
use longstep_search::search::{Limits, Outcome, solve};
use longstep_verify::verify::{VerifiedPlan, check};

fn read(domain: &Domain, environment: &Environment) -> World {
    environment::read(domain, environment, "", "", &Path::default()).unwrap()
}

fn plan(world: &World, text: &str) -> VerifiedPlan {
    let goal = goal::parse(world, text).unwrap();
    let Outcome::Solved { plan, .. } = solve(world, &goal.purpose(world), &Limits::default()) else {
        panic!("no plan for {text}");
    };
    check(world, plan, &goal.purpose(world)).into_verified().unwrap()
}

#[test]
fn next_world_equals_its_written_environment_and_keeps_facts() {
    let household = testing::domain("household");
    let text = r#"{"assets": ["<desk>", "<chest>", "<fridge>"], "objects": ["<pen>", "<fridge_handle>"],
        "object_states": {"<pen>": "inside_something(<chest>)", "<fridge_handle>": "closed()"}}"#;
    let mut world = read(&household, &Environment::from_json(text).unwrap());
    for (goal, expected) in [
        ("put(pen, desk)", "on_something(<desk>)"),
        ("put(pen, fridge)", "inside_something(<fridge>)"),
        // The environment no longer implies that the chest is a container.
        ("put(pen, chest)", "inside_something(<chest>)"),
    ] {
        let plan = plan(&world, goal);
        world = world.after(plan.ending());
        assert_eq!(
            world.environment().object_states["<pen>"].as_slice(),
            [expected],
            "{goal}"
        );
        let again = read(&household, world.environment());
        let lost: Vec<_> = again.state.iter().filter(|fact| !world.state.holds(*fact)).collect();
        assert!(lost.is_empty(), "{goal}: {lost:?}");
    }
}

/// Adds and removes facts in environment notation, and writes the environment.
#[track_caller]
fn check_written(before: &str, changes: &[(&str, bool)], expected: &str) {
    let household = testing::domain("household");
    let environment = Environment::from_json(before).unwrap();
    let world = read(&household, &environment);
    let mut state = world.state.clone();
    for (fact, holds) in changes {
        let goal = goal::parse(&world, fact).unwrap();
        let goal::GoalFact::Plain(fact) = goal.facts[0] else {
            panic!()
        };
        assert!(state.set(fact, *holds));
    }
    let after = serde_json::to_string(&environment::write(&world, &state)).unwrap();
    assert_eq!(after, expected);
}

#[test]
fn environment_writer_changes_only_changed_statements() {
    let before = r#"{"assets":["<a>","<b>"],"asset_states":{},"objects":["<cup>","<pan>"],"object_states":{"<pan>":"on_something(<a>)","<cup>":"on_something(<a>)"}}"#;
    check_written(before, &[], before);
    check_written(
        before,
        &[
            ("on_something(<cup>, <a>)", false),
            ("inside_something(<cup>, <b>)", true),
        ],
        &before.replace(r#""<cup>":"on_something(<a>)""#, r#""<cup>":"inside_something(<b>)""#),
    );
    check_written(
        before,
        &[("next_to(<a>, <b>)", true), ("inside_hand(<cup>)", true)],
        &before
            .replace(r#""asset_states":{}"#, r#""asset_states":{"<a>":"next_to(<b>)"}"#)
            .replace(
                r#""<cup>":"on_something(<a>)""#,
                r#""<cup>":["on_something(<a>)","inside_hand()"]"#,
            ),
    );
}
