//! How well a model puts stored plans together: scenes with stored plans, wishes, and the compositions that are right.
//! `LONGSTEP_MODEL` is a model reference, by default the catalogue's default model, `LONGSTEP_THREADS` its threads (1).
//!
//! ```text
//! cargo test -p longstep-llm --test compositions -- --ignored --nocapture
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

use std::path::Path;

use longstep::compose::{self, Said, Stored};
use longstep::domain::{self, Domain};
use longstep::json;
use longstep::plan::{Node, PlanFile, script};
use longstep::world::{self, Environment, World};
use longstep_llm::{ChatModel, ModelReference, OpenOptions, Progress, cache_directory, catalogue, open};
use serde_json::{Value, json};

fn model() -> Box<dyn ChatModel> {
    let name = std::env::var("LONGSTEP_MODEL").unwrap_or_else(|_| catalogue::DEFAULT.to_owned());
    let reference: ModelReference = name.parse().unwrap_or_else(|error| panic!("{error}"));
    let threads = std::env::var("LONGSTEP_THREADS").map_or(1, |threads| threads.parse().unwrap());
    let options = OpenOptions {
        threads: Some(threads),
        ..OpenOptions::new(cache_directory().unwrap())
    };
    open(&reference, &options, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"))
}

fn scene(scene: &Value) -> (Domain, World, Vec<Stored>) {
    let domain = domain::shipped(scene["domain"].as_str().unwrap()).unwrap().unwrap();
    let text = scene["environment"].to_string();
    let environment = Environment::from_json(&text).unwrap();
    let world = world::read(&domain, &environment, "environment", &text, &json::Path::default()).unwrap();
    let stored = scene["plans"].as_object().unwrap().iter().map(|(name, plan)| {
        let column = |column: usize| -> Vec<&Value> {
            plan["steps"].as_array().unwrap().iter().map(|step| &step[column]).collect()
        };
        let before = plan.get("environment").unwrap_or(&scene["environment"]);
        let file = json!({
            "task_cohesion": {"task_sequence": column(0), "step_instructions": column(1), "object_name": plan["object"]},
            "environment_before": before,
            "instruction_summary": plan["summary"],
        });
        Stored::new(name, serde_json::from_value::<PlanFile>(file).unwrap())
    });
    let stored = stored.collect();
    (domain, world, stored)
}

/// Whether two compositions are the same but for the order in which their lanes are written.
fn same(right: &Said, said: Option<&Said>) -> bool {
    let lines = |said: &Said| {
        let Said::Composition(written) = said else {
            return Vec::new();
        };
        let mut written = written.clone();
        for node in &mut written.body {
            if let Node::Parallel { lanes } = node {
                lanes.sort_by(|one, other| one.actor.cmp(&other.actor));
            }
        }
        let mut lines = Vec::new();
        for line in script::write(&written).lines() {
            lines.push(line.to_owned());
        }
        lines
    };
    said.is_some_and(|said| lines(said) == lines(right))
}

#[test]
#[ignore = "asks a real model"]
fn own_cases() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/compositions/cases.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut model = model();
    let (mut right, mut all) = (0, 0);
    for case in file["cases"].as_array().unwrap() {
        let (domain, world, stored) = scene(&file["scenes"][case["scene"].as_str().unwrap()]);
        let instruction = case["instruction"].as_str().unwrap();
        let request = compose::request(&domain, &world, &stored, instruction, &[], model.constraint_kind());
        if std::env::var_os("LONGSTEP_SHOW").is_some() {
            println!("{}\n{:?}", request.messages.last().unwrap().text, request.constraint);
        }
        let started = std::time::Instant::now();
        let reply = model.chat(&request, &mut |_: Progress| {}).unwrap();
        let seconds = started.elapsed().as_secs_f64();
        let said = compose::read(&reply.text);
        let is = |script: &Value| same(&compose::read(script.as_str().unwrap()).unwrap(), said.as_ref().ok());
        let good = case["right"].as_array().unwrap().iter().any(is);
        all += 1;
        right += usize::from(good);
        println!(
            "{} {seconds:5.1} s  {instruction}\n{}\n",
            if good { "ok   " } else { "WRONG" },
            reply.text
        );
        if let Err(error) = said {
            println!("{error}");
        }
    }
    println!("== {right} of {all} right");
}
