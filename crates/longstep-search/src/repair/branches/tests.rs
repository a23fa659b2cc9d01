//! Tests from branching plans to branching plans.

use proptest::prelude::*;

use super::super::{EditKind, Pins, Reach, RepairOutcome, Unwanted, repair, repair_pinned};
use crate::testing;
use longstep_model::environment::Claim;
use longstep_model::model::{Domain, Environment, World};
use longstep_verify::plan::{Step, StepId, TaskCohesion, resolve, script};
use longstep_verify::verify::{Purpose, bind_tree};

const LARDER: &str = r#"{"assets": ["<worktop>", "<shelf>", "<compost_bin>", "<freezer>"],
    "objects": ["<cheese>", "<soup>", "<freezer_handle>", "<rag>"],
    "object_states": {"<cheese>": "on_something(<worktop>)", "<soup>": "on_something(<shelf>)",
        "<freezer_handle>": "closed()", "<rag>": "on_something(<worktop>)"}}"#;

fn larder() -> (Domain, World) {
    let domain = testing::domain("household-checks");
    let world = testing::world_of(&domain, LARDER);
    (domain, world)
}

/// Checks the repaired script and the edits in brief.
#[track_caller]
fn check(text: &str, expected: &str, edits: &[&str]) {
    let (_, world) = larder();
    let written = script::read(text).unwrap();
    let length = written.steps.len();
    let draft = resolve(&world, &TaskCohesion::from_written(written));
    assert_eq!(draft.issues, vec![]);
    let outcome = repair(&world, &draft, &Purpose::default());
    let RepairOutcome::Repaired(repaired) = outcome else {
        panic!("{outcome:?}")
    };
    let cohesion = TaskCohesion::new(&world, repaired.plan.plan());
    let mut calls: Vec<String> = Vec::new();
    for line in script::write(&cohesion.written().unwrap()).lines() {
        let call = line.split("  #").next().unwrap_or_default();
        // Omits implicit parameters; the explanations show them.
        let call = match call.find('(') {
            Some(at) if call.trim_end().ends_with(')') => format!("{}()", &call[..at]),
            Some(at) if call.trim_end().ends_with("):") => format!("{}():", &call[..at]),
            _ => call.to_owned(),
        };
        calls.push(call);
    }
    let expected: Vec<&str> = expected.lines().filter(|line| !line.trim().is_empty()).collect();
    assert_eq!(calls, expected);
    let found: Vec<String> = repaired
        .edits
        .iter()
        .map(|edit| format!("{}: {}", edit.description(length), edit.why))
        .collect();
    assert_eq!(found, edits);
}

#[test]
fn repair_corrects_each_branch_separately() {
    check(
        "
move_hand()  # move the hand to the <cheese>
grasp_object()  # grasp the <cheese>
detach_from_plane()  # pick up the <cheese> from the <worktop>
if check_best_by_date():  # look at the date of the <cheese>
    attach_to_plane()  # put the <cheese> down on the <shelf>
    release_object()  # release the <cheese>
else:
    move_hand()  # move over the <compost_bin>
",
        "
move_hand()
grasp_object()
detach_from_plane()
if check_best_by_date():
    move_object()
    attach_to_plane()
    release_object()
else:
    move_hand()
    release_object()
",
        &[
            "insert move_object() (move the cheese to the shelf) before step 5: attach_to_plane() needs that the hand is at the shelf",
            "add release_object() (release the cheese) at the end: the cheese must be released",
        ],
    );
}

#[test]
fn repair_changes_steps_outside_a_branch_only_once() {
    check(
        "
move_hand()  # move the hand to the <cheese>
grasp_object()  # grasp the <cheese>
if check_best_by_date():  # look at the date of the <cheese>
    move_object()  # move the <cheese> to the <shelf>
    attach_to_plane()  # put the <cheese> down on the <shelf>
else:
    move_object()  # move the <cheese> over the <compost_bin>
",
        "
move_hand()
grasp_object()
detach_from_plane()
if check_best_by_date():
    move_object()
    attach_to_plane()
else:
    move_object()
release_object()
",
        &[
            "insert detach_from_plane() (pick up the cheese from the worktop) before step 3: check_best_by_date() needs that the cheese is lifted",
            "add release_object() (release the cheese) at the end: the cheese must be released",
        ],
    );
}

#[test]
fn repair_inserts_sensing_before_a_condition_that_needs_it() {
    check(
        "
move_hand()  # move the hand to the <cheese>
grasp_object()  # grasp the <cheese>
detach_from_plane()  # pick up the <cheese> from the <worktop>
if expired('<cheese>'):
    move_object()  # move the <cheese> over the <compost_bin>
else:
    move_object()  # move the <cheese> to the <shelf>
    attach_to_plane()  # put the <cheese> down on the <shelf>
release_object()  # release the <cheese>
",
        "
move_hand()
grasp_object()
detach_from_plane()
check_best_by_date()
if expired():
    move_object()
else:
    move_object()
    attach_to_plane()
release_object()
",
        &[
            "insert check_best_by_date() (check whether the cheese is past its date) before step 4: a condition asks whether the cheese is past its date, and nothing had sensed that",
        ],
    );
}

#[test]
fn repair_gives_up_on_exponentially_many_branches() {
    let (_, world) = larder();
    // The date is never sensed, so the plan is invalid. Each branch doubles the following ones, and none has a step.
    let text = "if expired('<cheese>'):\n    pass\n".repeat(40);
    let draft = resolve(&world, &TaskCohesion::from_written(script::read(&text).unwrap()));
    let outcome = repair(&world, &draft, &Purpose::default());
    assert!(
        matches!(&outcome, RepairOutcome::GaveUp { why, .. } if why.contains("too many branches")),
        "{outcome:?}"
    );
}

#[test]
fn repair_keeps_all_arguments_of_unreachable_steps() {
    let (domain, world) = larder();
    let text = "# objects: [\"<cheese>\"]\nif check_best_by_date():\n    move_object()\nif check_best_by_date():\n    move_object()\n";
    let draft = resolve(&world, &TaskCohesion::from_written(script::read(text).unwrap()));
    match repair(&world, &draft, &Purpose::default()) {
        RepairOutcome::Repaired(repaired) => {
            for step in repaired.plan.steps() {
                let parameters = &domain.action(step.action).parameters;
                assert_eq!(step.arguments.len(), parameters.len(), "{step:?}");
            }
        }
        other => assert!(!matches!(other, RepairOutcome::Valid(_)), "{other:?}"),
    }
}

#[test]
fn repair_keeps_pinned_steps_on_every_branch() {
    let (_, world) = larder();
    let text = "
move_hand()  # move the hand to the <cheese>
grasp_object()  # grasp the <cheese>
detach_from_plane()  # pick up the <cheese> from the <worktop>
if check_best_by_date():  # look at the date of the <cheese>
    attach_to_plane()  # put the <cheese> down on the <shelf>
    release_object()  # release the <cheese>
else:
    move_hand()  # move over the <compost_bin>
";
    let draft = resolve(&world, &TaskCohesion::from_written(script::read(text).unwrap()));
    let free = repair(&world, &draft, &Purpose::default());
    let RepairOutcome::Repaired(free) = free else {
        panic!("{free:?}")
    };
    let added = free
        .edits
        .iter()
        .find(|edit| edit.kind == EditKind::Insert && edit.step == 4);
    let added = free.plan.plan().step(StepId::new(added.unwrap().at)).clone();

    // A removed step does not return to its position, and neither does a step with equal effects.
    let unwanted = |reach| Pins {
        unwanted: vec![Unwanted {
            action: added.action,
            arguments: added.arguments.clone(),
            before: 4,
            reach,
        }],
        ..Pins::default()
    };
    for reach in [Reach::Here, Reach::ThisStep, Reach::ThisAction] {
        if let RepairOutcome::Repaired(repaired) = repair_pinned(&world, &draft, &Purpose::default(), &unwanted(reach))
        {
            let same = |edit: &&super::super::Edit| {
                let step = repaired.plan.plan().steps().get(edit.at);
                edit.kind == EditKind::Insert && edit.step == 4 && step == Some(&added)
            };
            assert_eq!(repaired.edits.iter().find(same), None, "{reach:?}");
        }
    }

    // A pinned step is not dropped, replaced or moved on any path.
    for step in 0..draft.steps.len() {
        let pins = Pins {
            kept: vec![step],
            ..Pins::default()
        };
        if let RepairOutcome::Repaired(repaired) = repair_pinned(&world, &draft, &Purpose::default(), &pins) {
            let changed = |edit: &&super::super::Edit| edit.kind != EditKind::Insert && edit.step == step;
            assert_eq!(repaired.edits.iter().find(changed), None, "step {step}");
        }
    }
}

#[test]
fn repair_lists_a_claim_that_no_ending_can_keep() {
    let (_, world) = larder();
    let text =
        "# objects: [\"<cheese>\"]\nif check_best_by_date():\n    move_hand()  # move the hand to the <cheese>\n";
    let draft = resolve(&world, &TaskCohesion::from_written(script::read(text).unwrap()));
    let after = r#"{"assets": [], "objects": ["<cheese>"], "object_states": {"<cheese>": "on_something(<shelf>)"}}"#;
    let claim = Claim::read(&world, &Environment::from_json(after).unwrap());
    let purpose = Purpose {
        claim: Some(claim),
        ..Purpose::default()
    };
    let outcome = repair(&world, &draft, &purpose);
    let RepairOutcome::Repaired(repaired) = outcome else {
        panic!("{outcome:?}")
    };
    assert_eq!(repaired.given_up.len(), 1);
}

const CALLS: [&str; 9] = [
    "move_hand()",
    "grasp_object()",
    "release_object()",
    "detach_from_plane()",
    "attach_to_plane()",
    "move_object()",
    "check_best_by_date()",
    "open_by_rotate()",
    "move_object(to=\"<shelf>\")",
];

/// Generates scripts with calls that omit their arguments, in branches and loops.
fn scripts() -> impl Strategy<Value = String> {
    let call = prop::sample::select(CALLS.to_vec()).prop_map(|call| vec![call.to_owned()]);
    let nodes = call.prop_recursive(3, 12, 4, |inner| {
        let body = prop::collection::vec(inner, 1..4).prop_map(|all| all.concat());
        let head = prop::sample::select(vec![
            "if check_best_by_date():",
            "if expired(\"<cheese>\") and not fresh(\"<soup>\"):",
            "if inside_hand(\"<cheese>\"):",
            "while inside_hand(\"<soup>\"):",
            "for _ in range(3):",
        ]);
        (head, body.clone(), prop::option::of(body)).prop_map(|(head, body, other)| {
            let indented = |lines: Vec<String>| lines.into_iter().map(|line| format!("    {line}"));
            let mut lines = vec![head.to_owned()];
            lines.extend(indented(body));
            if let Some(other) = other.filter(|_| head.starts_with("if")) {
                lines.push("else:".to_owned());
                lines.extend(indented(other));
            }
            lines
        })
    });
    let objects = prop::sample::select(vec!["[\"<cheese>\"]", "[\"<cheese>\", \"<soup>\"]", "[]"]);
    (objects, prop::collection::vec(nodes, 1..5))
        .prop_map(|(objects, nodes)| format!("# objects: {objects}\n{}\n", nodes.concat().join("\n")))
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 32, ..ProptestConfig::default() })]

    #[test]
    fn repair_keeps_hidden_arguments_in_parameter_order(text in scripts()) {
        let (domain, world) = larder();
        let draft = resolve(&world, &TaskCohesion::from_written(script::read(&text).unwrap()));
        let whole = |steps: &[Step]| -> Result<(), TestCaseError> {
            for step in steps {
                let parameters = &domain.action(step.action).parameters;
                prop_assert_eq!(step.arguments.len(), parameters.len());
                for (argument, parameter) in step.arguments.iter().zip(parameters) {
                    prop_assert!(world.is_of_kind(*argument, parameter.kind), "{step:?}");
                }
            }
            Ok(())
        };
        match bind_tree(&world, &draft, None) {
            Ok((plan, _)) => {
                whole(plan.steps())?;
                for (step, drafted) in plan.steps().iter().zip(draft.steps.iter().flatten()) {
                    let given = drafted.arguments.iter().zip(&step.arguments);
                    prop_assert!(given.into_iter().all(|(given, bound)| given.is_none_or(|given| given == *bound)));
                }
                prop_assert_eq!(plan.steps().len(), draft.steps.len());
            }
            Err(violations) => prop_assert!(!violations.is_empty()),
        }
        if let RepairOutcome::Repaired(repaired) = repair(&world, &draft, &Purpose::default()) {
            whole(repaired.plan.steps())?;
        }
    }
}
