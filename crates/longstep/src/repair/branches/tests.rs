//! Branching plans in, branching plans out.

use super::super::{Outcome, repair};
use crate::domain::{self, Domain};
use crate::json::Path;
use crate::plan::{TaskCohesion, resolve, script};
use crate::verify::Purpose;
use crate::world::{self, Environment, World};

const LARDER: &str = r#"{"assets": ["<worktop>", "<shelf>", "<compost_bin>", "<freezer>"],
    "objects": ["<cheese>", "<soup>", "<freezer_handle>", "<rag>"],
    "object_states": {"<cheese>": "on_something(<worktop>)", "<soup>": "on_something(<shelf>)",
        "<freezer_handle>": "closed()", "<rag>": "on_something(<worktop>)"}}"#;

fn larder() -> (Domain, World) {
    let domain = domain::shipped("household-checks").unwrap().unwrap();
    let environment = Environment::from_json(LARDER).unwrap();
    let world = world::read(&domain, &environment, "", LARDER, &Path::default()).unwrap();
    (domain, world)
}

/// What a script is repaired to, and the edits in a few words.
#[track_caller]
fn check(text: &str, expected: &str, edits: &[&str]) {
    let (domain, world) = larder();
    let written = script::read(text).unwrap();
    let length = written.steps.len();
    let draft = resolve(&domain, &world, &TaskCohesion::from_written(written));
    assert_eq!(draft.issues, vec![]);
    let outcome = repair(&domain, &world, &draft, &Purpose::default());
    let Outcome::Repaired(repaired) = outcome else {
        panic!("{outcome:?}")
    };
    let cohesion = TaskCohesion::new(&domain, &world, repaired.plan.plan());
    let mut calls: Vec<String> = Vec::new();
    for line in script::write(&cohesion.written().unwrap()).lines() {
        let call = line.split("  #").next().unwrap_or_default();
        // Hidden parameters are shown in the explanations.
        let call = match call.find('(') {
            Some(at) if call.trim_end().ends_with(')') => format!("{}()", &call[..at]),
            Some(at) if call.trim_end().ends_with("):") => format!("{}():", &call[..at]),
            _ => call.to_owned(),
        };
        calls.push(call);
    }
    let expected: Vec<&str> = expected.lines().filter(|line| !line.trim().is_empty()).collect();
    assert_eq!(calls, expected);
    let told: Vec<String> = repaired
        .edits
        .iter()
        .map(|edit| format!("{}: {}", edit.told(length), edit.why))
        .collect();
    assert_eq!(told, edits);
}

#[test]
fn each_side_is_mended_for_itself() {
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
fn what_comes_before_and_behind_a_branch_is_mended_once() {
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
fn what_is_asked_is_sensed_first() {
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
fn branches_that_double_are_given_up() {
    let (domain, world) = larder();
    // Nothing senses the date, so the plan is no plan; each branch doubles all that follow it, and none has a step.
    let text = "if expired('<cheese>'):\n    pass\n".repeat(40);
    let draft = resolve(
        &domain,
        &world,
        &TaskCohesion::from_written(script::read(&text).unwrap()),
    );
    let outcome = repair(&domain, &world, &draft, &Purpose::default());
    assert!(
        matches!(&outcome, Outcome::GaveUp { why, .. } if why.contains("too many branches")),
        "{outcome:?}"
    );
}
