//! Tests from plans to messages.

use super::super::*;
use crate::plan::{TaskCohesion, resolve};
use longstep_model::model::Environment;
use longstep_model::testing;

const KITCHEN: &str = r#"{
    "assets": ["<desk_1>", "<oven_2>", "<shelf_3>"],
    "objects": ["<pie_4>", "<mug_5>"],
    "object_states": {"<pie_4>": ["ON(<desk_1>)"], "<mug_5>": ["INSIDE(<oven_2>)"]},
    "asset_properties": {"<oven_2>": ["IS_OPENABLE"], "<desk_1>": ["NOT_OPENABLE"], "<shelf_3>": ["NOT_OPENABLE"]}}"#;

fn report(world: &World, calls: &[&str], object: Option<&str>) -> Report {
    let written = TaskCohesion {
        task_sequence: calls.iter().map(|call| (*call).to_owned()).collect(),
        object_name: object.map(str::to_owned),
        ..TaskCohesion::default()
    };
    let resolved = resolve(world, &written);
    let (plan, _) = bind(world, &resolved.complete().unwrap(), &resolved.objects, None).unwrap();
    check(world, plan, &Purpose::default())
}

#[track_caller]
fn check_messages(calls: &[&str], expected: &[&str]) {
    let world = testing::world("virtualhome", KITCHEN);
    let report = report(&world, calls, None);
    let messages: Vec<_> = report
        .violations
        .iter()
        .map(|v| v.message(&world, report.plan.steps(), None))
        .collect();
    assert_eq!(messages, expected);
    assert_eq!(report.into_verified().is_ok(), expected.is_empty());
}

#[test]
fn verify_reports_nothing_for_valid_plans() {
    check_messages(
        &[
            "Walktowards(<desk_1>)",
            "Grab(<pie_4>)",
            "Walktowards(<shelf_3>)",
            "Put(<pie_4>, <shelf_3>)",
        ],
        &[],
    );
    check_messages(&[], &[]);
}

#[test]
fn verify_reports_unsatisfied_preconditions() {
    check_messages(
        &["Grab(<pie_4>)"],
        &["step 1: Grab(<pie_4>) needs that the pie is within reach"],
    );
    check_messages(
        &["Walktowards(<oven_2>)", "Grab(<mug_5>)"],
        &["step 2: Grab(<mug_5>) needs that the oven is not closed"],
    );
    check_messages(
        &["Walktowards(<shelf_3>)", "Open(<shelf_3>)"],
        &["step 2: Open(<shelf_3>) needs that the shelf can be opened"],
    );
}

#[test]
fn violation_names_the_step_that_removed_the_precondition() {
    check_messages(
        &["Walktowards(<desk_1>)", "Walktowards(<shelf_3>)", "Grab(<pie_4>)"],
        &[
            "step 3: Grab(<pie_4>) needs that the pie is within reach; since step 2 (Walktowards(<shelf_3>)), the pie is not within reach",
        ],
    );
}

#[test]
fn verify_checks_rules_at_the_end_of_a_plan() {
    check_messages(
        &[
            "Walktowards(<desk_1>)",
            "Grab(<pie_4>)",
            "Walktowards(<oven_2>)",
            "Open(<oven_2>)",
            "PutIn(<pie_4>, <oven_2>)",
        ],
        &["at the end: the oven must be closed and switched on, since the pie was put into it to be heated"],
    );
}

#[test]
fn report_lists_assumptions_behind_the_verdict() {
    let text = r#"{"assets": ["<box>"], "objects": ["<box_lever>"], "object_states": {"<box_lever>": "closed()"}}"#;
    let world = testing::world("household", text);
    let calls = ["move_hand()", "grasp_object()", "open_by_slide()", "release_object()"];
    let report = report(&world, &calls, Some("<box_lever>"));
    assert_eq!(report.violations, vec![]);
    let assumed: Vec<_> = report.assumptions.iter().map(|a| a.message(&world)).collect();
    assert_eq!(assumed, ["the box lever slides (the environment does not say)"]);
}

#[test]
fn binding_takes_unstated_places_from_the_claim() {
    let text = r#"{"assets": ["<table>", "<bin>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
    let world = testing::world("household", text);
    let messages = |calls: &[&str]| -> Vec<String> {
        let written = TaskCohesion {
            task_sequence: calls.iter().map(|call| (*call).to_owned()).collect(),
            object_name: Some("<cup>".to_owned()),
            ..TaskCohesion::default()
        };
        let resolved = resolve(&world, &written);
        let purpose = Purpose {
            claim: Some(Claim::read(&world, world.environment())),
            ..Purpose::default()
        };
        let (plan, _) = bind(
            &world,
            &resolved.complete().unwrap(),
            &resolved.objects,
            purpose.claim.as_ref(),
        )
        .unwrap();
        let report = check(&world, plan, &purpose);
        let violations = report.violations.iter();
        violations
            .map(|v| v.message(&world, report.plan.steps(), None))
            .collect()
    };
    let lifted = ["move_hand()", "grasp_object()", "detach_from_plane()", "move_object()"];
    assert_eq!(
        messages(&[&lifted[..], &["attach_to_plane()", "release_object()"]].concat()),
        Vec::<String>::new()
    );
    // Without a step that puts it down, the cup can only have been dropped into the bin.
    assert_eq!(
        messages(&[&lifted[..], &["release_object()"]].concat()),
        ["the plan claims that the cup is on the table, but it does not hold at the end"]
    );
}

#[test]
fn binding_does_not_take_a_hand_for_a_place() {
    let text = r#"{"assets": ["<table>"], "objects": ["<cup>"], "object_states": {"<cup>": "inside_hand(right)"}}"#;
    let world = testing::world("household-dual", text);
    let calls = ["move_object(right)", "attach_to_plane(right)", "release_object(right)"];
    let written = TaskCohesion {
        task_sequence: calls.iter().map(|call| (*call).to_owned()).collect(),
        object_name: Some("<cup>".to_owned()),
        ..TaskCohesion::default()
    };
    let purpose = Purpose {
        claim: Some(Claim::read(&world, world.environment())),
        ..Purpose::default()
    };
    let resolved = resolve(&world, &written);
    let (plan, _) = bind_tree(&world, &resolved, purpose.claim.as_ref()).unwrap();
    assert_eq!(check(&world, plan, &purpose).violations, vec![]);
}

#[test]
fn claim_makes_no_promise_about_unmentioned_states() {
    let text = r#"{"assets": ["<room_1>", "<desk_2>"], "objects": ["<mug_4>"],
        "asset_states": {"<desk_2>": ["INSIDE(<room_1>)"]}}"#;
    let world = testing::world("virtualhome", text);
    let claimed = Environment::from_json(r#"{"assets": ["<desk_2>"], "objects": []}"#).unwrap();
    let claim = Claim::read(&world, &claimed);
    assert_eq!(claim.promises(&world), vec![]);
}

#[test]
fn reachability_respects_the_conditions_of_effects() {
    let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
        "object_states": {"<milk>": "on_something(<counter>)", "<fridge_handle>": "closed()"}}"#;
    let world = testing::world("household", text);
    let inside = |place: &str| {
        let claimed =
            format!(r#"{{"objects": ["<milk>"], "object_states": {{"<milk>": "inside_something({place})"}}}}"#);
        let claim = Claim::read(&world, &Environment::from_json(&claimed).unwrap());
        let [promised] = claim.promises(&world)[..] else {
            panic!("{claim:?}")
        };
        can_be_brought_about(&world, promised)
    };
    assert!(inside("<fridge>"));
    assert!(!inside("<counter>"));
}

#[test]
fn binding_senses_the_object_of_a_later_condition() {
    let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>", "<sponge>"],
        "object_states": {"<cup>": "on_something(<table>)", "<sponge>": "on_something(<shelf>)"}}"#;
    let world = testing::world("household-checks", text);
    for place in ["<table>", "<shelf>"] {
        let script = format!("move_hand()\ncheck_cleanness()\nif clean(\"{place}\"):\n    pass\n");
        let written = TaskCohesion::from_written(crate::plan::script::read(&script).unwrap());
        let resolved = resolve(&world, &written);
        let (plan, _) = bind_tree(&world, &resolved, None).unwrap();
        let report = check(&world, plan, &Purpose::default());
        assert_eq!(report.violations, vec![], "{place}");
    }
}
