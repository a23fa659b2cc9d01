//! How much of what people say about plans a model understands: set LONGSTEP_FEEDBACK_MODEL to a model reference, and
//! run with `--ignored --nocapture`. With LONGSTEP_CORPUS, the folder of the recorded plans, two more cases are those
//! of the paper's figure. LONGSTEP_LANGUAGE (`de`, `es`) says the own cases in another language. Prints a line for each case
//! and the figures.

#![allow(clippy::unwrap_used, clippy::expect_used, clippy::panic, clippy::print_stdout)]

use std::path::{Path, PathBuf};

use longstep::dialogue::{Dialogue, Round};
use longstep::domain::Domain;
use longstep::feedback::{self, Amended, FeedbackDialogue, FeedbackInput, StepWish, Wish, amend};
use longstep::goal;
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_core::environment::{self, Claim, Environment, World};
use longstep_core::json;
use longstep_core::plan::{Plan, PlanFile, TaskCohesion, resolve};
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::verify::{Purpose, bind, check};
use longstep_core::testing;
use longstep_files::cache_directory;
use longstep_llm::{ChatModel, ConverseError, ModelReference, OpenOptions, Progress, converse, load_domain, open};
use serde_json::Value;

fn domain_named(name: &str) -> Domain {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    let folder = ["crates/longstep-model/domains", "examples"].map(|place| root.join(place).join(name));
    let folder = folder.iter().find(|folder| folder.is_dir()).unwrap();
    load_domain(&folder.display().to_string()).unwrap_or_else(|error| panic!("{error}"))
}

fn model() -> Box<dyn ChatModel> {
    let name = std::env::var("LONGSTEP_FEEDBACK_MODEL").expect("LONGSTEP_FEEDBACK_MODEL names a model");
    let reference: ModelReference = name.parse().unwrap_or_else(|error| panic!("{error}"));
    let threads = std::env::var("LONGSTEP_THREADS")
        .ok()
        .map(|threads| threads.parse().unwrap());
    let options = OpenOptions::new(cache_directory().unwrap()).with_threads(threads.or(Some(1)));
    open(&reference, &options, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"))
}

/// Returns the wish that the model understands, and its answer.
fn hear(
    model: &mut dyn ChatModel,
    domain: &Domain,
    world: &World,
    plan: &Plan,
    instruction: &str,
    says: &str,
) -> (Option<Wish>, String) {
    let mut dialogue = FeedbackDialogue::new(FeedbackInput {
        domain,
        world,
        plan,
        instruction,
        feedback: says,
        kind: model.constraint_kind(),
    });
    let request = dialogue.request();
    if std::env::var_os("LONGSTEP_SHOW").is_some() {
        println!("{}\n{:?}", request.messages.last().unwrap().text, request.constraint);
    }
    let wish = match converse(model, &mut dialogue, &mut |_: Progress| {}) {
        Err(ConverseError::Model(error)) => panic!("{error}"),
        wish => wish.ok(),
    };
    (wish, dialogue.transcript().answer().to_owned())
}

/// True if the changes are the same, in any order: they all refer to the original plan.
fn same_changes(one: &[StepWish], other: &[StepWish]) -> bool {
    one.len() == other.len() && one.iter().all(|wish| other.contains(wish))
}

/// Wishes without their sentences.
fn bare(wishes: &[StepWish]) -> Vec<StepWish> {
    let mut wishes = wishes.to_vec();
    for wish in &mut wishes {
        if let StepWish::Insert { explanation, .. } | StepWish::Replace { explanation, .. } = wish {
            explanation.clear();
        }
    }
    wishes
}

fn planned(world: &World, goal: &goal::Goal) -> Plan {
    let outcome = search::solve(world, &goal.purpose(world), &Limits::default());
    let Outcome::Solved { plan, .. } = outcome else {
        panic!("{outcome:?}")
    };
    plan
}

fn written_plan(world: &World, case: &Value) -> Option<Plan> {
    let calls = case.get("plan")?.as_array()?;
    let cohesion = TaskCohesion {
        task_sequence: calls.iter().map(|call| call.as_str().unwrap().to_owned()).collect(),
        object_name: case["object"].as_str().map(str::to_owned),
        ..TaskCohesion::default()
    };
    let resolved = resolve(world, &cohesion);
    Some(
        bind(world, &resolved.complete().unwrap(), &resolved.objects, None)
            .unwrap()
            .0,
    )
}

fn is_right(model: &mut dyn ChatModel, scenes: &Value, case: &Value) -> (bool, String) {
    let text = |key: &str| case[key].as_str().unwrap();
    let scene = &scenes[text("scene")];
    let domain = domain_named(scene["domain"].as_str().unwrap());
    let mut world = testing::world_of(&domain, &scene["environment"]);
    // A session adds the numbers and quotations of what is said.
    let right = case["right"].as_array().unwrap().iter();
    let texts = right
        .chain(case.as_object().unwrap().values())
        .filter_map(Value::as_str);
    for text in texts {
        world.add_values(text);
    }
    let goal = goal::parse(&world, text("goal")).unwrap_or_else(|error| panic!("{error}"));
    let plan = written_plan(&world, case).unwrap_or_else(|| planned(&world, &goal));
    let (wish, mut told) = hear(model, &domain, &world, &plan, text("instruction"), text("says"));
    let accepted: Vec<&str> = case["right"]
        .as_array()
        .unwrap()
        .iter()
        .map(|a| a.as_str().unwrap())
        .collect();
    match wish {
        Some(Wish::Steps(wishes)) => {
            let same = |answer: &&str| {
                let expected = feedback::parse(&world, answer, plan.steps().len());
                expected.is_ok_and(|expected| same_changes(&expected, &bare(&wishes)))
            };
            let mut right = accepted.iter().any(same);
            let outcome = match amend(&world, &plan, &wishes, &goal.purpose(&world)) {
                Amended::Done(amendment) => {
                    let edits: Vec<String> = amendment
                        .edits
                        .iter()
                        .map(|edit| edit.description(plan.steps().len()))
                        .collect();
                    told = format!("{told} [done {}]", edits.join("; "));
                    "done"
                }
                Amended::Impossible { why, .. } => {
                    told = format!(
                        "{told} [{}]",
                        why.iter().map(ToString::to_string).collect::<Vec<_>>().join("; ")
                    );
                    "impossible"
                }
            };
            right &= case["outcome"].as_str().is_none_or(|expected| expected == outcome);
            (right, told)
        }
        Some(Wish::Goal | Wish::Further) if accepted.contains(&"goal") => {
            let rounds = [Round {
                reply: text("goal").to_owned(),
                message: text("says").to_owned(),
            }];
            let mut dialogue = Understanding::new(UnderstandingInput {
                rounds: &rounds,
                ..UnderstandingInput::new(&domain, &world, text("instruction"), model.constraint_kind())
            });
            let understood = converse(model, &mut dialogue, &mut |_: Progress| {});
            told = format!("{told} -> {}", dialogue.transcript().answer());
            let expected = goal::parse(&world, text("then")).unwrap();
            let right = understood.is_ok_and(|meant| meant.question.is_none() && meant.goal == Some(expected));
            (right, told)
        }
        _ => (false, told),
    }
}

#[test]
#[ignore = "asks a real model"]
fn own_cases() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/feedback/cases.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut model = model();
    let (mut right, mut all) = (0, 0);
    let languages = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/feedback/languages.json");
    let languages: Value = serde_json::from_str(&std::fs::read_to_string(languages).unwrap()).unwrap();
    let language = std::env::var("LONGSTEP_LANGUAGE").ok();
    for (number, case) in file["cases"].as_array().unwrap().iter().enumerate() {
        let mut case = case.clone();
        if let Some(language) = &language {
            case["says"] = languages[language][number].clone();
        }
        let case = &case;
        let only = std::env::var("LONGSTEP_ONLY").unwrap_or_default();
        if !case["says"].as_str().unwrap().contains(&only) {
            continue;
        }
        let (ok, told) = is_right(model.as_mut(), &file["scenes"], case);
        all += 1;
        right += usize::from(ok);
        println!("{} {}  ->  {told}", if ok { "ok   " } else { "WRONG" }, case["says"]);
    }
    println!("== {right} of {all} right");
}

/// Sixty cases on other robots, in five languages, which nobody looks into: only the totals are printed.
#[test]
#[ignore = "asks a real model"]
fn held_cases() {
    let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/feedback/held.json");
    let file: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let mut model = model();
    let (mut steps, mut goals) = ((0, 0), (0, 0));
    for case in file["cases"].as_array().unwrap() {
        let (ok, _) = is_right(model.as_mut(), &file["scenes"], case);
        let is_goal = case["right"].as_array().unwrap().iter().any(|answer| answer == "goal");
        let counted = if is_goal { &mut goals } else { &mut steps };
        counted.0 += usize::from(ok);
        counted.1 += 1;
    }
    println!("== steps: {} of {} right", steps.0, steps.1);
    println!("== goals: {} of {} right", goals.0, goals.1);
}

#[test]
#[ignore = "asks a real model about the recorded plans"]
fn figure() {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("LONGSTEP_CORPUS names the folder of the recorded plans");
    let file = PathBuf::from(folder).join("household/shelf.json");
    let scene: Value = serde_json::from_str(&std::fs::read_to_string(file).unwrap()).unwrap();
    let recorded: PlanFile = serde_json::from_value(scene["steps"][0]["recorded"].clone()).unwrap();
    let instruction = scene["steps"][0]["instruction"].as_str().unwrap();
    let domain = domain_named("household");
    let world = testing::world_of(&domain, &scene["steps"][0]["recorded"]["environment_before"]);
    let purpose = Purpose {
        claim: recorded
            .environment_after
            .as_ref()
            .map(|after| Claim::read(&world, after)),
        ..Purpose::default()
    };
    let plan_without = |left_out: Option<usize>| {
        let mut cohesion = recorded.task_cohesion.clone();
        if let Some(index) = left_out {
            cohesion.task_sequence.remove(index);
            cohesion.step_instructions.remove(index);
        }
        let resolved = resolve(&world, &cohesion);
        let (plan, _) = bind(
            &world,
            &resolved.complete().unwrap(),
            &resolved.objects,
            purpose.claim.as_ref(),
        )
        .unwrap();
        check(&world, plan, &purpose).into_verified().unwrap().plan().clone()
    };
    let mut model = model();
    for (left_out, says, moves) in [
        (Some(4), "Insert another move_object() to move the juice upward.", 3),
        (None, "In this case, you can omit one move_object().", 2),
    ] {
        let plan = plan_without(left_out);
        let (wish, answer) = hear(model.as_mut(), &domain, &world, &plan, instruction, says);
        let Some(Wish::Steps(wishes)) = wish else {
            panic!("{answer}")
        };
        let Amended::Done(amendment) = amend(&world, &plan, &wishes, &purpose) else {
            panic!("{answer}")
        };
        let calls: Vec<String> = amendment
            .plan
            .steps()
            .iter()
            .map(|s| s.call(&world).to_string())
            .collect();
        println!("{says}  ->  {answer}  ->  {}", calls.join(", "));
        for step in amendment.plan.steps() {
            println!("    {}", step.explanation);
        }
        assert_eq!(calls.iter().filter(|call| *call == "move_object()").count(), moves);
        assert!(amendment.edits.is_empty());
    }
    println!("== 2 of 2 right");
}
