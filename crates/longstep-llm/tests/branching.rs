//! Instructions that depend on what only shows when the robot looks, with a real model: five rooms, twenty-five
//! instructions, the goal that each means, or `question` where the person has to be asked. `LONGSTEP_MODEL` is a model
//! reference, by default the catalogue's default model, `LONGSTEP_THREADS` its threads (1).
//!
//! ```text
//! cargo test -p longstep-llm --test branching -- --ignored --nocapture
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

use longstep::domain::{self, Domain};
use longstep::goal::{self, Goal, GoalFact};
use longstep::json::Path;
use longstep::session::{Event, ModelFacts, Need, Session, Settings};
use longstep::solution;
use longstep::verify::VerifiedPlan;
use longstep::world::{self, Environment, World};
use longstep_llm::{ChatModel, ModelReference, OpenOptions, Progress, advance, cache_directory, catalogue, open};
use serde_json::Value;

fn read() -> Value {
    serde_json::from_str(include_str!("branching/instructions.json")).unwrap()
}

fn world_of(domain: &Domain, environment: &Value) -> World {
    let text = environment.to_string();
    let environment = Environment::from_json(&text).unwrap();
    world::read(domain, &environment, "scene", &text, &Path::default()).unwrap_or_else(|found| panic!("{found}"))
}

fn checks() -> Domain {
    domain::shipped("household-checks").unwrap().unwrap()
}

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

/// The goal with its parts in an order that does not depend on who wrote it.
fn sorted(domain: &Domain, world: &World, goal: &Goal) -> Vec<String> {
    let all = |facts: &[GoalFact]| {
        let mut texts: Vec<String> = facts.iter().map(|fact| fact.exact(domain, world)).collect();
        texts.sort();
        texts
    };
    let mut facts = goal.facts.clone();
    for fact in &mut facts {
        if let GoalFact::If(conditional) = fact {
            for side in [&mut conditional.then, &mut conditional.otherwise] {
                side.sort_by_key(|fact| fact.exact(domain, world));
            }
        }
    }
    all(&facts)
}

/// How a plan can end: what sensing told, and the environment.
fn endings(domain: &Domain, world: &World, plan: &VerifiedPlan) -> Vec<String> {
    let ending = |ending: &longstep::verify::Ending| {
        let after = world::write(domain, world, &ending.after);
        format!("{:?} {}", ending.when, serde_json::to_string(&after).unwrap())
    };
    let mut endings: Vec<String> = plan.endings().iter().map(ending).collect();
    endings.sort();
    endings
}

#[test]
fn every_instruction_has_a_plan_for_what_it_means() {
    let read = read();
    let domain = checks();
    for item in read["instructions"].as_array().unwrap() {
        let world = world_of(&domain, &read["scenes"][item["scene"].as_str().unwrap()]);
        let text = item["goal"].as_str().unwrap();
        if text == "question" {
            continue;
        }
        let goal = goal::parse(&domain, &world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        let solution = solution::of_goal(&domain, &world, &goal, "", || 0.0);
        let plan = solution.plan.unwrap_or_else(|| panic!("{text}: {:?}", solution.answer));
        // What is known already is not looked for.
        let known = text.contains("ointment");
        assert_eq!(plan.plan().is_sequence(), known, "{text}");
        assert!(solution.answer.notes.is_empty(), "{text}: {:?}", solution.answer.notes);
    }
}

#[test]
#[ignore = "asks a real model twenty-five times"]
fn twenty_five() {
    let read = read();
    let mut model = model();
    let (mut verified, mut asked_back, mut right, mut all) = (0, 0, 0, 0);
    for item in read["instructions"].as_array().unwrap() {
        let domain = checks();
        let world = world_of(&domain, &read["scenes"][item["scene"].as_str().unwrap()]);
        let (instruction, meant) = (item["instruction"].as_str().unwrap(), item["goal"].as_str().unwrap());
        let facts = ModelFacts {
            name: model.name().to_owned(),
            kind: model.constraint_kind(),
            context: model.context_tokens(),
        };
        let settings = Settings::default();
        let mut session = Session::new("household-checks", domain, world, settings, facts, || 0.0);
        session.instruct(instruction).unwrap();
        let need = advance(&mut session, model.as_mut(), None, &mut |_: Progress| {});
        let need = need.unwrap_or_else(|error| panic!("{error}"));
        let (mut wrote, mut milliseconds) = (String::new(), 0.0);
        for event in session.take_events() {
            if let Event::Reply {
                text,
                milliseconds: took,
                ..
            } = event
            {
                wrote.push_str(&text);
                milliseconds += took;
            }
        }
        all += 1;
        let (domain, world) = (session.domain(), session.world());
        let good = match need {
            Need::Decision => {
                // A proposal is a verified plan: it was followed on every path.
                verified += 1;
                let proposal = session.proposal().unwrap();
                goal::parse(domain, world, meant).is_ok_and(|meant| {
                    let same = |goal: &Goal| sorted(domain, world, goal) == sorted(domain, world, &meant);
                    let wanted = solution::of_goal(domain, world, &meant, "", || 0.0).plan.unwrap();
                    proposal.goal.as_ref().is_some_and(same)
                        || endings(domain, world, &proposal.plan) == endings(domain, world, &wanted)
                })
            }
            Need::Answer(question) => {
                asked_back += 1;
                wrote = format!("{wrote}  [asks: {question}]");
                meant == "question"
            }
            _ => {
                wrote = format!("{wrote}  [stuck: {}]", session.stuck().unwrap().why);
                false
            }
        };
        right += usize::from(good);
        println!(
            "{} {:6.2} s  {instruction}  ->  {wrote}{}",
            if good { "ok   " } else { "WRONG" },
            milliseconds / 1000.0,
            if good {
                String::new()
            } else {
                format!("  (meant {meant})")
            }
        );
    }
    println!("== {verified} of {all} verified on all paths, {asked_back} asked back, {right} right");
    assert_eq!(all, 25);
}
