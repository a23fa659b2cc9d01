//! How well a model puts stored plans together: scenes with stored plans, wishes, and the compositions that are right.
//! `LONGSTEP_MODEL` is a model reference, by default the catalogue's default model, `LONGSTEP_THREADS` its threads (1).
//!
//! ```text
//! cargo test -p longstep-llm --test compositions -- --ignored --nocapture
//! ```

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

mod opened;

use longstep::compose::{self, Composed, CompositionAnswer, CompositionDialogue, CompositionInput, Stored};
use longstep::dialogue::Dialogue;
use longstep::domain;
use longstep_core::environment::{self, Environment, World};
use longstep_core::json;
use longstep_core::plan::{Node, PlanFile, Written, script};
use longstep_core::testing;
use longstep_llm::{ConverseError, Progress, converse};
use serde_json::{Value, json};

fn scene(scene: &Value) -> (World, Vec<Stored>) {
    let domain = domain::shipped(scene["domain"].as_str().unwrap()).unwrap().unwrap();
    let text = scene["environment"].to_string();
    let world = testing::world_of(&domain, &text);
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
    (world, stored)
}

/// Returns true if two compositions are the same but for the order in which their lanes are written.
fn same(right: &CompositionAnswer, said: Option<&CompositionAnswer>) -> bool {
    let text = |said: &CompositionAnswer| {
        let CompositionAnswer::Composition(written) = said else {
            return String::new();
        };
        let mut written = written.clone();
        for node in &mut written.body {
            if let Node::Parallel { lanes } = node {
                lanes.sort_by(|one, other| one.actor.cmp(&other.actor));
            }
        }
        script::write(&written)
    };
    said.is_some_and(|said| text(said) == text(right))
}

#[test]
#[ignore = "asks a real model"]
fn own_cases() {
    let file: Value = serde_json::from_str(include_str!("compositions/cases.json")).unwrap();
    let mut model = opened::model();
    let (mut verified, mut right, mut all) = (0, 0, 0);
    for case in file["cases"].as_array().unwrap() {
        let (world, stored) = scene(&file["scenes"][case["scene"].as_str().unwrap()]);
        let instruction = case["instruction"].as_str().unwrap();
        let mut dialogue = CompositionDialogue::new(CompositionInput {
            world: &world,
            stored: &stored,
            instruction,
            rounds: &[],
            kind: model.constraint_kind(),
        });
        let request = dialogue.request();
        if std::env::var_os("LONGSTEP_SHOW").is_some() {
            println!("{}\n{:?}", request.messages.last().unwrap().text, request.constraint);
        }
        let started = std::time::Instant::now();
        let said = match converse(model.as_mut(), &mut dialogue, &mut |_: Progress| {}) {
            Err(ConverseError::Model(error)) => panic!("{error}"),
            said => said,
        };
        let seconds = started.elapsed().as_secs_f64();
        let is = |script: &Value| same(&compose::read(script.as_str().unwrap()).unwrap(), said.as_ref().ok());
        let good = case["right"].as_array().unwrap().iter().any(is);
        let came = match &said {
            Ok(CompositionAnswer::Composition(written)) => verdict(&world, written, &stored, instruction),
            Ok(CompositionAnswer::Question(question)) => Err(question.clone()),
            Err(error) => Err(error.to_string()),
        };
        all += 1;
        right += usize::from(good);
        verified += usize::from(came.is_ok());
        let came = came.map_or_else(|wrong| format!("not verified: {wrong}"), |_| "verified".to_owned());
        println!(
            "{} {seconds:5.1} s  {instruction}\n{}\n  {came}\n",
            mark(good),
            dialogue.transcript().answer()
        );
    }
    println!("== {verified} of {all} verified, {right} of {all} right");
    assert!(all >= 8 && verified >= right);
}

fn mark(right: bool) -> &'static str {
    if right { "ok   " } else { "WRONG" }
}

/// The verdict on a composition.
fn verdict(world: &World, written: &Written, stored: &[Stored], wish: &str) -> Result<(), String> {
    let inlined = compose::inline(world, written, stored);
    let inlined = inlined.map_err(|misfits| misfits.iter().map(ToString::to_string).collect::<Vec<_>>().join("; "))?;
    let composed = Composed::new(world, inlined, wish);
    if composed.verified().is_some() {
        return Ok(());
    }
    let wrong = composed.verdict().violations;
    Err(wrong
        .iter()
        .map(|violation| violation.message.clone())
        .collect::<Vec<_>>()
        .join("; "))
}

/// The right compositions are plans: a case whose own answer is not valid would count nothing.
#[test]
fn every_right_composition_is_valid() {
    let file: Value = serde_json::from_str(include_str!("compositions/cases.json")).unwrap();
    for case in file["cases"].as_array().unwrap() {
        let (world, stored) = scene(&file["scenes"][case["scene"].as_str().unwrap()]);
        for right in case["right"].as_array().unwrap() {
            let Ok(CompositionAnswer::Composition(written)) = compose::read(right.as_str().unwrap()) else {
                panic!("{right}")
            };
            let verdict = verdict(&world, &written, &stored, case["instruction"].as_str().unwrap());
            assert_eq!(verdict, Ok(()), "{right}");
        }
    }
}
