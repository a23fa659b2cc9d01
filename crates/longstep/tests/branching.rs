//! Plans that branch, repeat and run side by side, from their text to a verdict.
#![allow(clippy::unwrap_used, clippy::panic)]

use longstep::domain::{self, Domain};
use longstep::report::{Answer, Assessment, Status};
use longstep_core::environment::{self, World};
use longstep_core::plan::{self, PlanFile, TaskCohesion, Written, script};
use longstep_core::testing;

fn kitchen() -> (Domain, World) {
    let domain = domain::shipped("household-checks").unwrap().unwrap();
    let text = r#"{
        "assets": ["<counter>", "<rack>", "<trash_bin>"],
        "objects": ["<yoghurt>", "<sponge>"],
        "object_states": {"<yoghurt>": "on_something(<counter>)", "<sponge>": "on_something(<counter>)"}
    }"#;
    let world = testing::world_of(&domain, text);
    (domain, world)
}

fn attempt<'a>(world: &'a World, text: &str) -> Assessment<'a> {
    Assessment::new(world, plan::read(text).unwrap(), None)
}

fn verdict(text: &str) -> Answer {
    let (_, world) = kitchen();
    attempt(&world, text).verdict()
}

#[track_caller]
fn check(text: &str, wrong: &[&str]) -> Answer {
    let answer = verdict(text);
    let found: Vec<&str> = answer
        .violations
        .iter()
        .map(|violation| violation.message.as_str())
        .collect();
    assert_eq!(found, wrong, "{text}");
    answer
}

const TAKE: &str = "move_hand() # move to the yoghurt; <yoghurt>: on_something(<counter>)\n\
    grasp_object() # take the yoghurt; <yoghurt>: inside_hand()\n\
    detach_from_plane() # lift the yoghurt off the counter\n";

const SORT: &str = "if check_best_by_date():\n    \
        move_object() # move it to the rack\n    \
        attach_to_plane() # put it on the rack; <yoghurt>: on_something(<rack>)\n    \
        release_object() # let go; <yoghurt>: on_something(<rack>)\n\
    else:\n    \
        move_object() # move it over the trash bin\n    \
        release_object() # drop it; <yoghurt>: inside_something(<trash_bin>)\n";

#[test]
fn a_script_that_senses_is_verified_on_both_ways() {
    let answer = check(&format!("{TAKE}{SORT}"), &[]);
    assert_eq!(answer.status, Status::Verified);
    let bound: Vec<Vec<&str>> = answer
        .steps
        .iter()
        .map(|step| step.implicit.values().map(String::as_str).collect())
        .collect();
    assert_eq!(bound[3], ["<yoghurt>"]);
    assert_eq!(bound[4], ["<yoghurt>", "<rack>"]);
    assert_eq!(bound[7], ["<yoghurt>", "<trash_bin>"]);
    assert!(
        answer.notes.iter().all(|note| !note.contains("claims")),
        "{:?}",
        answer.notes
    );
}

#[test]
fn written_branching_plan_reads_back_as_the_same_plan() {
    let (_, world) = kitchen();
    let verified = attempt(&world, &format!("{TAKE}{SORT}")).verified().unwrap();
    let file = PlanFile::from(TaskCohesion::new(&world, verified.plan()));
    let script = script::write(&Written::of_plan(&world, verified.plan()));
    for text in [script, serde_json::to_string_pretty(&file).unwrap()] {
        let again = attempt(&world, &text).verified().unwrap();
        assert_eq!(again.plan(), verified.plan(), "{text}");
    }
}

#[test]
fn verify_rejects_conditions_that_cannot_be_evaluated() {
    let asks = |condition: &str| format!("{TAKE}check_best_by_date()\nif {condition}:\n    pass\nelse:\n    pass\n");
    for (condition, kind) in [
        // The thing in the hand stays there, which breaks a rule; nothing else is wrong.
        ("expired()", None),
        ("not on_something(\"<sponge>\", \"<rack>\")", None),
        ("holding(\"<yoghurt>\")", None),
        ("expired(\"<yoghurt>\") and check_best_by_date()", None),
        ("release_object()", Some("not_sensing")),
        ("ripe(\"<yoghurt>\")", Some("unknown_condition")),
        ("expired(\"<yogurts>\", \"<rack>\")", Some("wrong_arguments")),
        ("expired(\"<butter>\")", Some("unknown_entity")),
        ("inside_hand(\"<rack>\")", Some("wrong_type")),
        ("expired(\"<yoghurt>\", to=\"<rack>\")", Some("unknown_parameter")),
        ("check_best_by_date(too=\"<rack>\")", Some("unknown_parameter")),
    ] {
        let answer = verdict(&asks(condition));
        let kinds: Vec<&str> = answer
            .violations
            .iter()
            .map(|violation| violation.kind)
            .filter(|kind| *kind != "rule")
            .collect();
        assert_eq!(kinds, kind.into_iter().collect::<Vec<_>>(), "{condition}");
        let place = answer.violations.iter().find(|violation| Some(violation.kind) == kind);
        assert!(
            place.is_none_or(|violation| violation.step == Some(4)),
            "{condition}: {place:?}"
        );
    }
}

#[test]
fn verify_notes_step_claims_that_the_simulation_contradicts() {
    let answer = verdict(&format!(
        "{TAKE}move_object() # move it to the rack\nattach_to_plane() # put it down; <sponge>: inside_something(<trash_bin>)\n"
    ));
    let told: Vec<&String> = answer.notes.iter().filter(|note| note.contains("claims")).collect();
    assert_eq!(
        told,
        ["step 5 claims that the sponge is in the trash bin, which is not so after it"]
    );
    let answer = verdict(&format!("{TAKE}release_object() # let go; <broom>: dry()\n"));
    assert!(
        answer
            .notes
            .iter()
            .any(|note| note.ends_with("`<broom>: dry()` of step 4")),
        "{:?}",
        answer.notes
    );
}

#[test]
fn named_parameters_bind_hidden_arguments() {
    let answer = verdict("move_hand(to='<rack>')\n");
    assert_eq!(answer.steps[0].implicit["to"], "<rack>");
    check(
        "move_hand(at='<rack>')\n",
        &["step 1: the call has no free parameter `at`"],
    );
    check(
        "with parallel():\n  with lane('left'):\n    move_hand()\n",
        &["a lane: the environment lists no `left`"],
    );
}

#[test]
fn repair_inserts_steps_into_a_branching_plan() {
    let (_, world) = kitchen();
    let attempt = attempt(&world, SORT);
    let answer = attempt.repaired();
    assert_eq!(answer.status, Status::Verified);
    let after: Vec<Option<&str>> = answer.edits.iter().map(|edit| edit.after.as_deref()).collect();
    let calls = ["move_hand()", "grasp_object()", "detach_from_plane()"];
    assert_eq!(after, calls.map(Some));
}

/// The paper's branching plan, with the lines that its comments make of it.
const SHELF: &str = r#"# Grasp the spam and detach it from the table
move_hand()  # move hand to the spam; <spam>: on_something(<table>)
grasp_object()  # grasp the spam; <spam>: inside_hand()
"#;

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn the_published_branching_plan_is_read_and_every_line_of_its_verdict_has_a_reason() {
    let corpus = std::env::var("LONGSTEP_CORPUS").unwrap();
    let text = std::fs::read_to_string(format!("{corpus}/household_branching/shelf.json")).unwrap();
    let draft = plan::read(&text).unwrap();
    assert!(draft.leniencies.is_empty(), "{:?}", draft.leniencies);
    let written = draft.file.task_cohesion.task_tree.clone().unwrap();
    let read = script::write(&written);
    assert!(read.starts_with(SHELF), "{read}");
    let lines: Vec<&str> = read
        .lines()
        .map(str::trim)
        .filter(|line| !line.starts_with('#'))
        .collect();
    let calls: Vec<&str> = lines.iter().map(|line| line.split("  #").next().unwrap()).collect();
    assert_eq!(
        calls,
        [
            "move_hand()",
            "grasp_object()",
            "detach_from_plane()",
            "move_hand()",
            "check_best_by_date()",
            "if not check_best_by_date():",
            "move_hand()",
            "release_object()",
            "else:",
            "move_hand()",
            "move_hand()",
            "attach_to_plane()",
            "release_object()",
        ]
    );
    let environment = r#"{"assets": ["<table>", "<trash_bin>", "<shelf_top>", "<shelf_bottom>"],
        "objects": ["<spam>"], "object_states": {"<spam>": "on_something(<table>)"}}"#;
    let world = testing::world("household-checks", environment);
    let attempt = Assessment::new(&world, draft, None);
    let answer = attempt.verdict();
    // Each step is possible on each way, and the hand is empty at the end of both.
    assert_eq!(answer.status, Status::Verified, "{:?}", answer.violations);
    let verified = attempt.verified().unwrap();
    // Looking once splits the plan in two; looking again, in the condition, tells nothing new.
    let endings: Vec<String> = verified
        .endings()
        .iter()
        .map(|ending| {
            let told = |fact: &_| environment::fact_text(&world, *fact, true);
            let after = serde_json::to_string(&environment::write(&world, &ending.after).object_states).unwrap();
            format!(
                "{}: {after}",
                ending.when.iter().map(told).collect::<Vec<_>>().join(", ")
            )
        })
        .collect();
    assert_eq!(endings.len(), 2, "{endings:?}");
    assert!(
        endings
            .iter()
            .any(|ending| ending.contains("past its date") && ending.contains("inside_something(<trash_bin>)"))
    );
    assert!(
        endings
            .iter()
            .any(|ending| ending.contains("not past its date") && ending.contains("on_something(<shelf_top>)"))
    );
    // Its comments say after each step where the spam is: all of them are right, so none is told.
    assert!(
        answer.notes.iter().all(|note| !note.contains("claims")),
        "{:?}",
        answer.notes
    );
    let bound = script::write(&Written::of_plan(&world, verified.plan()));
    println!("{bound}\n{endings:#?}\n{:#?}\n{:#?}", answer.notes, answer.assumptions);
}
