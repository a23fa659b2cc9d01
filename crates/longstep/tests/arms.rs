//! Two arms and two robots: what is wrong with plans for them, how they are mended, and what they do side by side.
//! With `LONGSTEP_CORPUS`, the folder of the recorded plans, the published two-arm plan is among them.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

use longstep::Clock;
use longstep::domain::{self, Domain, Files};
use longstep::report::Assessment;
use longstep::{goal, report};
use longstep_core::environment::World;
use longstep_core::plan::{self, Node};
use longstep_core::repair::RepairOutcome;
use longstep_core::schedule;
use longstep_core::testing;
use serde_json::{Value, json};

fn dual() -> Domain {
    domain::shipped("household-dual").unwrap().unwrap()
}

/// The errors of a plan, and the edits that mend it, each with its reason.
fn diagnosed(written: &Value) -> (Vec<String>, Vec<String>) {
    let domain = dual();
    let world = testing::world_of(&domain, &written["environment_before"]);
    let attempt = Assessment::new(&world, plan::read(&written.to_string()).unwrap(), None);
    let verdict = attempt.verdict();
    let messages = verdict
        .violations
        .into_iter()
        .map(|violation| violation.message)
        .collect();
    let length = attempt.resolved.written.len();
    let edits = match attempt.repair() {
        RepairOutcome::Valid(_) => Vec::new(),
        RepairOutcome::Repaired(repaired) => {
            assert!(repaired.given_up.is_empty(), "{:?}", repaired.given_up);
            let told = |edit: &longstep_core::repair::Edit| format!("{}: {}", edit.description(length), edit.why);
            repaired.edits.iter().map(told).collect()
        }
        other => panic!("{other:?}"),
    };
    (messages, edits)
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn the_published_plan_is_diagnosed_and_mended() {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("LONGSTEP_CORPUS names the folder of the recorded plans");
    let path = std::path::PathBuf::from(folder).join("household_dual_arm/fridge.json");
    let written: Value = serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    let (violations, edits) = diagnosed(&written);
    assert_eq!(
        violations,
        [
            "step 4: move_hand(right) needs that the right hand does not hold the fridge handle; since step 2 \
             (grasp_object(right)), the right hand holds the fridge handle",
            "step 5: grasp_object(left) needs that the left hand is at the juice",
            "step 6: detach_from_plane(right) needs that the right hand holds the juice, and that the left hand does \
             not hold the juice; since step 5 (grasp_object(left)), the left hand holds the juice",
            "at the end: the right hand must release the fridge handle",
        ]
    );
    assert_eq!(
        edits,
        [
            "in step 4, move_hand(left) (move the left hand to the juice) instead of move_hand(right): \
             move_hand(right) needs that the right hand does not hold the fridge handle",
            "in step 6, detach_from_plane(left) (pick up the juice with the left hand) instead of \
             detach_from_plane(right): detach_from_plane(right) needs that the right hand holds the juice, and that \
             the left hand does not hold the juice",
            "add release_object(right) (release the fridge handle with the right hand) at the end: the right hand \
             must release the fridge handle",
        ]
    );
}

/// A plan for a cup between a shelf and a sill that only the left hand reaches; calls with their sentences.
#[track_caller]
fn check_mended(steps: &[(&str, &str)], after: &str, expected: &[&str]) {
    let before = json!({
        "assets": ["<shelf>", "<sill>"], "asset_states": {"<sill>": "reachable_by(left)"},
        "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<shelf>)"}});
    let mut claimed = before.clone();
    claimed["object_states"]["<cup>"] = json!(after);
    let (calls, sentences): (Vec<&str>, Vec<&str>) = steps.iter().copied().unzip();
    let written = json!({
        "task_cohesion": {"task_sequence": calls, "step_instructions": sentences, "object_name": "<cup>"},
        "environment_before": before, "environment_after": claimed});
    let (_, edits) = diagnosed(&written);
    let short = |edit: &String| {
        edit.split(" (")
            .next()
            .unwrap_or_default()
            .split(": ")
            .next()
            .unwrap_or_default()
            .to_owned()
    };
    assert_eq!(edits.iter().map(short).collect::<Vec<_>>(), expected);
}

#[test]
fn repair_takes_the_hand_from_the_step_sentence() {
    let fetch = |hand: &str| {
        [
            (format!("move_hand({hand})"), "move the left hand to the cup"),
            ("grasp_object(left)".to_owned(), "grasp the cup with the left hand"),
            ("detach_from_plane(left)".to_owned(), "pick up the cup"),
            ("move_object(left)".to_owned(), "move the cup to the sill"),
            ("attach_to_plane(left)".to_owned(), "put the cup on the sill"),
            ("release_object(left)".to_owned(), "release the cup"),
        ]
    };
    fn words<'a>(steps: &'a [(String, &'static str)]) -> Vec<(&'a str, &'a str)> {
        steps
            .iter()
            .map(|(call, sentence)| (call.as_str(), *sentence))
            .collect()
    }
    let on_sill = "on_something(<sill>)";
    check_mended(&words(&fetch("left")), on_sill, &[]);
    // The call is a slip, as its sentence says.
    check_mended(&words(&fetch("right")), on_sill, &["in step 1, move_hand(left)"]);
    // Without a sentence that says which hand, the call that fits the others is the smaller change.
    let mut silent = fetch("right");
    silent[0].1 = "move to the cup";
    check_mended(&words(&silent), on_sill, &["in step 1, move_hand(left)"]);
    // Call and sentence agree: the hand was moved for a reason, and the other one has to come as well.
    let mut agreed = fetch("right");
    agreed[0].1 = "move the right hand to the cup";
    check_mended(&words(&agreed), on_sill, &["insert move_hand(left)"]);
}

/// The instructions of the suite `two-arms`, each with its world and what it means.
fn instructions(domain: &Domain) -> Vec<(World, String, String)> {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../longstep-eval/suites/two-arms");
    let text = |file: &str| std::fs::read_to_string(format!("{folder}/{file}")).unwrap();
    let cases: toml::Table = text("cases.toml").parse().unwrap();
    let case = |case: &toml::Value| {
        let word = |key: &str| case[key].as_str().unwrap().to_owned();
        let scene = text(&format!("scenes/{}.json", word("scene")));
        let world = testing::world_of(domain, &scene);
        (world, word("says"), word("goal"))
    };
    cases["case"].as_array().unwrap().iter().map(case).collect()
}

#[test]
fn search_solves_the_goal_of_each_two_armed_instruction() {
    let domain = dual();
    let all = instructions(&domain);
    assert_eq!(all.len(), 25);
    for (world, says, meant) in all {
        let goal = goal::parse(&world, &meant).unwrap();
        let solution = report::of_goal(&world, &goal, &says, &longstep::Limits::default(), &Clock::none());
        let plan = solution
            .plan
            .unwrap_or_else(|| panic!("{says}: {:?}", solution.answer.notes));
        let shared = schedule::share(&world, &plan, &goal.purpose(&world));
        let time = shared.map_or_else(|| schedule::makespan(plan.plan()), |shared| shared.after);
        println!("    {} steps, {time}", plan.steps().len());
    }
}

/// Two porters that carry boxes between rooms, one of which only one of them may enter.
const PORTERS: &str = r#"(define (domain porters)
  (:requirements :strips :typing :negative-preconditions :quantified-preconditions)
  (:types room parcel - thing robot)
  (:constants ada bo - robot)
  (:predicates (may-enter ?robot - robot ?room - room) (in ?robot - robot ?room - room) (at ?parcel - parcel ?room - room)
               (carries ?robot - robot ?parcel - parcel))
  (:action go
    :parameters (?robot - robot ?to - room)
    :precondition (and (may-enter ?robot ?to) (not (in ?robot ?to)))
    :effect (and (forall (?other - room) (not (in ?robot ?other))) (in ?robot ?to)))
  (:action load
    :parameters (?robot - robot ?parcel - parcel ?from - room)
    :precondition (and (in ?robot ?from) (at ?parcel ?from) (forall (?other - parcel) (not (carries ?robot ?other))))
    :effect (and (not (at ?parcel ?from)) (carries ?robot ?parcel)))
  (:action unload
    :parameters (?robot - robot ?parcel - parcel ?to - room)
    :precondition (and (in ?robot ?to) (carries ?robot ?parcel))
    :effect (and (at ?parcel ?to) (not (carries ?robot ?parcel)))))"#;

const PORTERS_WORDS: &str = r#"
name = "porters"
about = "Two robots that carry parcels between rooms."
[environment]
assets = "room"
objects = "parcel"
[[predicate]]
name = "may-enter"
says = "{robot} may enter {room}"
denies = "{robot} may not enter {room}"
[[predicate]]
name = "in"
says = "{robot} is in {room}"
denies = "{robot} is not in {room}"
[[predicate]]
name = "at"
says = "{parcel} is in {room}"
denies = "{parcel} is not in {room}"
[[predicate]]
name = "carries"
says = "{robot} carries {parcel}"
denies = "{robot} does not carry {parcel}"
[[state]]
word = "AT(<room>)"
fact = "(at ?self ?room)"
means = "The parcel is in <room>."
[[state]]
word = "OPEN_TO(<robot>)"
fact = "(may-enter ?robot ?self)"
means = "<robot> may enter the room."
[[action]]
name = "go"
call = "Go(?robot, ?to)"
actor = "?robot"
says = "{robot} goes to {to}"
means = "Go to a room."
[[action]]
name = "load"
call = "Load(?robot, ?parcel, ?from)"
actor = "?robot"
says = "{robot} takes {parcel} from {from}"
means = "Take a parcel."
[[action]]
name = "unload"
call = "Unload(?robot, ?parcel, ?to)"
actor = "?robot"
says = "{robot} leaves {parcel} in {to}"
means = "Leave a parcel."
[[goal]]
form = "bring({parcel}, {room})"
parameters = "?parcel - parcel ?room - room"
condition = "(at ?parcel ?room)"
subject = "?parcel"
says = "{parcel} is in {room}"
means = "the parcel ends in the room"
"#;

#[test]
fn two_robots_share_work_as_two_hands_do() {
    let files = Files {
        folder: "porters/".to_owned(),
        pddl: PORTERS.to_owned(),
        words: PORTERS_WORDS.to_owned(),
        goal_prompt: "Say the goal.".to_owned(),
        ..Files::default()
    };
    let domain = domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    let both = ["OPEN_TO(ada)", "OPEN_TO(bo)"];
    let world = testing::world_of(
        &domain,
        json!({
            "assets": ["<lobby>", "<office>", "<vault>"],
            "asset_states": {"<lobby>": both, "<office>": both, "<vault>": ["OPEN_TO(bo)"]},
            "objects": ["<letter>", "<safe>", "<lamp>"],
            "object_states": {"<letter>": "AT(<lobby>)", "<safe>": "AT(<lobby>)", "<lamp>": "AT(<office>)"}}),
    );
    let told = |wanted: &str| {
        let goal = goal::parse(&world, wanted).unwrap();
        let plan = report::of_goal(&world, &goal, "", &longstep::Limits::default(), &Clock::none())
            .plan
            .unwrap();
        let shared = schedule::share(&world, &plan, &goal.purpose(&world));
        (plan.steps().len(), shared)
    };
    // Only one of them may enter the vault, so the other one brings the letter.
    let (steps, shared) = told("bring(safe, vault) & bring(letter, office)");
    let shared = shared.unwrap();
    assert_eq!((steps, shared.before.units(), shared.after.units()), (8, 8, 4));
    let [Node::Parallel { lanes }] = shared.plan.plan().body() else {
        panic!("{:?}", shared.plan.plan());
    };
    assert_eq!(lanes.len(), 2);
    let bo = world.find("bo").unwrap();
    let into_vault = |step: &&plan::Step| step.arguments.contains(&world.find("<vault>").unwrap());
    assert!(
        shared
            .plan
            .steps()
            .iter()
            .filter(into_vault)
            .all(|step| step.actor(&domain) == Some(bo))
    );
    // One parcel is the work of one robot.
    assert!(told("bring(letter, office)").1.is_none());
}
