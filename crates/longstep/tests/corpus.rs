//! The recorded plans of the paper. They stay outside the repository: `LONGSTEP_CORPUS` is their folder, and
//! without it these tests are ignored, never silently passed.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

use std::path::PathBuf;

use longstep::domain::{self, Domain};
use longstep::goal::{self, Goal};
use longstep::json::Path;
use longstep::plan::{self, Plan, PlanFile, Step, TaskCohesion};
use longstep::search::{self, Limits, Outcome};
use longstep::verify::{self, Purpose, Report};
use longstep::world::{self, Claim, Environment, World};
use serde_json::Value;

fn read(file: &str) -> Value {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("LONGSTEP_CORPUS names the folder of the recorded plans");
    let path = PathBuf::from(folder).join(file);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

fn domain(name: &str) -> Domain {
    domain::shipped(name).unwrap().unwrap()
}

fn world_of(domain: &Domain, environment: &Value) -> World {
    let text = environment.to_string();
    let environment = Environment::from_json(&text).unwrap();
    world::read(domain, &environment, "environment", &text, &Path::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The scenes of the household domain, each with its instructions.
fn household() -> Vec<(String, Value)> {
    let mut recorded = Vec::new();
    for scene in ["drawer", "fridge", "shelf", "table", "window"] {
        for step in read(&format!("household/{scene}.json"))["steps"].as_array().unwrap() {
            let name = format!("{scene}: {}", step["instruction"].as_str().unwrap());
            recorded.push((name, step["recorded"].clone()));
        }
    }
    recorded
}

#[track_caller]
fn check(domain: &Domain, world: &World, written: &TaskCohesion, purpose: &Purpose) -> Report {
    let (steps, objects) = plan::resolve(domain, world, written).unwrap();
    let (plan, _) = verify::bind(domain, world, &steps, &objects, purpose.claim.as_ref());
    verify::check(domain, world, plan, purpose)
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn recorded_household_plans_verify_and_end_where_they_claim() {
    let domain = domain("household");
    for (name, recorded) in household() {
        let file: PlanFile = serde_json::from_value(recorded.clone()).unwrap();
        let world = world_of(&domain, &recorded["environment_before"]);
        let claimed = file.environment_after.as_ref().unwrap();
        let purpose = Purpose {
            claim: Some(Claim::read(&domain, &world, claimed)),
            ..Purpose::default()
        };
        let report = check(&domain, &world, &file.task_cohesion, &purpose);
        let messages: Vec<_> = report
            .violations
            .iter()
            .map(|v| v.message(&domain, &world, report.plan.steps(), None))
            .collect();
        assert_eq!(messages, Vec::<String>::new(), "{name}");
        let after = world::write(&domain, &world, &report.after);
        assert_eq!(
            serde_json::to_value(after).unwrap(),
            recorded["environment_after"],
            "{name}"
        );
    }
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn environments_are_written_as_they_were_read() {
    for (name, recorded) in household() {
        let text = serde_json::to_string(&recorded["environment_before"]).unwrap();
        let again = serde_json::to_string(&Environment::from_json(&text).unwrap()).unwrap();
        assert_eq!(again, text, "{name}");
    }
    let kitchen = read("virtualhome14/kitchen.json").to_string();
    assert_eq!(
        serde_json::to_string(&Environment::from_json(&kitchen).unwrap()).unwrap(),
        kitchen
    );
}

/// The scenarios' goal facts in the words of the domain.
fn goal_of(domain: &Domain, world: &World, facts: &Value) -> Goal {
    let texts: Vec<String> = facts
        .as_array()
        .unwrap()
        .iter()
        .map(|fact| {
            let first = fact.as_str().unwrap().split(" | ").next().unwrap();
            let (word, arguments) = first.split_once('(').unwrap();
            match word {
                "DRUNK" => format!("drunk({arguments}"),
                "REPLACED" => format!("moved({})", arguments.split(',').next().unwrap()),
                _ => first.to_owned(),
            }
        })
        .collect();
    goal::parse(domain, world, &texts.join(" & ")).unwrap()
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn reference_programs_reach_the_goals_of_their_scenarios() {
    let domain = domain("virtualhome");
    for scenario in read("virtualhome14/scenarios.json").as_array().unwrap() {
        let world = world_of(&domain, &scenario["environment"]);
        let written: TaskCohesion = serde_json::from_value(serde_json::json!({
            "task_sequence": scenario["reference"].as_array().unwrap().iter()
                .map(|s| s.as_str().unwrap().replace("WalkTowards", "Walktowards")).collect::<Vec<_>>(),
        }))
        .unwrap();
        let mut purpose = goal_of(&domain, &world, &scenario["goal"]).purpose(&domain);
        purpose.from_goal = false;
        let report = check(&domain, &world, &written, &purpose);
        let messages: Vec<_> = report
            .violations
            .iter()
            .map(|v| v.message(&domain, &world, report.plan.steps(), None))
            .collect();
        assert_eq!(messages, Vec::<String>::new(), "{}", scenario["id"]);
    }
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn search_reaches_every_scenario_s_goal_by_a_shortest_plan() {
    let domain = domain("virtualhome");
    let kitchen = world_of(&domain, &read("virtualhome14/kitchen.json"));
    for scenario in read("virtualhome14/scenarios.json").as_array().unwrap() {
        for world in [&world_of(&domain, &scenario["environment"]), &kitchen] {
            let goal = goal_of(&domain, world, &scenario["goal"]);
            let outcome = search::solve(&domain, world, &goal.wanted(&domain, world), &Limits::default());
            let Outcome::Solved { steps, shortest, .. } = outcome else {
                panic!("{}: {outcome:?}", scenario["id"]);
            };
            let plan: Plan = steps
                .into_iter()
                .map(|step| Step::explained(&domain, world, step.action, step.arguments))
                .collect();
            let report = verify::check(&domain, world, plan, &goal.purpose(&domain));
            let calls: Vec<_> = report
                .plan
                .steps()
                .iter()
                .map(|step| step.call(&domain, world).to_string())
                .collect();
            assert!(report.violations.is_empty(), "{}: {calls:?}", scenario["id"]);
            let reference = scenario["reference"].as_array().unwrap().len();
            assert!(
                shortest && calls.len() <= reference + 1,
                "{}: {calls:?}",
                scenario["id"]
            );
        }
    }
}
