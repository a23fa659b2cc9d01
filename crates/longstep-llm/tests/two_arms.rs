//! What a model understands of instructions to a robot with two arms, and what comes of them: four scenes of our own. That each
//! goal that is meant is offered and can be reached is tested without a model, in `crates/longstep/tests/arms.rs`.
//! `LONGSTEP_MODEL` is a model reference, by default the catalogue's default model, `LONGSTEP_THREADS` its threads (1).
//!
//! ```text
//! cargo test -p longstep-llm --test two_arms -- --ignored --nocapture
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

use longstep::domain;
use longstep::goal::{self, GoalFact};
use longstep::json::Path;
use longstep::session::{ModelFacts, Need, Session, Settings};
use longstep::world::{self, Environment, World};
use longstep_llm::{ChatModel, ModelReference, OpenOptions, Progress, advance, cache_directory, catalogue, open};
use serde_json::Value;

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

fn scenes() -> Vec<Value> {
    serde_json::from_str(include_str!("two_arms/cases.json")).unwrap()
}

fn cases(scene: &Value) -> impl Iterator<Item = (&str, &str)> {
    let cases = scene["cases"].as_array().unwrap().iter();
    cases.map(|case| (case["says"].as_str().unwrap(), case["goal"].as_str().unwrap()))
}

fn world_of(domain: &domain::Domain, scene: &Value) -> World {
    let text = scene["environment"].to_string();
    let environment = Environment::from_json(&text).unwrap();
    world::read(domain, &environment, "scene", &text, &Path::default()).unwrap_or_else(|e| panic!("{e}"))
}

/// The parts of a goal, in an order that does not matter.
fn parts(facts: &[GoalFact], domain: &domain::Domain, world: &World) -> Vec<String> {
    let mut parts: Vec<String> = facts.iter().map(|fact| fact.exact(domain, world)).collect();
    parts.sort();
    parts
}

#[test]
#[ignore = "asks a real model 25 times"]
fn instructions() {
    let mut model = model();
    let (mut all, mut verified, mut right) = (0, 0, 0);
    for scene in scenes() {
        let name = scene["scene"].as_str().unwrap();
        for (says, meant) in cases(&scene) {
            let domain = domain::shipped("household-dual").unwrap().unwrap();
            let world = world_of(&domain, &scene);
            let meant = goal::parse(&domain, &world, meant).unwrap();
            let facts = ModelFacts {
                name: model.name().to_owned(),
                kind: model.constraint_kind(),
                context: model.context_tokens(),
            };
            let mut session = Session::new("household-dual", domain, world, Settings::default(), facts, || 0.0);
            session.instruct(says).unwrap();
            let need = advance(&mut session, model.as_mut(), None, &mut |_: Progress| {}).unwrap();
            let (domain, world) = (session.domain(), session.world());
            let (good, came) = match (&need, session.proposal(), session.stuck()) {
                (_, Some(proposal), _) => {
                    verified += 1;
                    let facts = proposal.goal.as_ref().map_or(&[][..], |goal| &goal.facts);
                    let same = parts(facts, domain, world) == parts(&meant.facts, domain, world);
                    let told: Vec<String> = facts.iter().map(|fact| fact.everyday(domain, world)).collect();
                    (same, told.join(" & "))
                }
                (Need::Answer(question), ..) => (false, format!("asks: {question}")),
                (_, _, Some(stuck)) => (false, format!("stuck: {}", stuck.why)),
                _ => (false, "nothing".to_owned()),
            };
            all += 1;
            right += usize::from(good);
            let mark = if good { "ok   " } else { "WRONG" };
            println!("{mark} {name}: {says}  ->  {came}");
        }
    }
    println!("== {verified} of {all} verified, {right} right");
    assert!(verified >= 23 && right >= 21);
}
