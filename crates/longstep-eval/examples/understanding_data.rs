//! Prints what the adapter for understanding is trained on: one JSON object for each instruction of the given suites.
//!
//!     cargo run -p longstep-eval --no-default-features --example understanding_data -- scripts/understanding/training/*
//!
//! An object has the suite, the case, its tags, the fixed messages of the request (`fixed`, pairs of role and text), the last
//! message up to the instruction (`lead`), the instruction, and the expected answer, which is null where a question is expected.
//! A tag `meaning: GOAL` has the goal of a case that expects a question because it has no plan (a prohibition alone), and
//! `left out KIND: WORDS` the words that the goal does not say.
#![allow(clippy::print_stdout, clippy::print_stderr)]

use std::error::Error;
use std::path::Path;

use longstep::dialogue::Role;
use longstep::domain::Domain;
use longstep::understanding::{UnderstandingDialogue, UnderstandingInput};
use longstep_core::goal::{self, Goal};
use longstep_eval::suite::{self, Case, Expected, Files, Suite};
use longstep_llm::read_texts;
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn Error>> {
    for folder in std::env::args().skip(1) {
        let (domain, suite) = read_suite(Path::new(&folder))?;
        let mut written = 0;
        for case in &suite.cases {
            if let Some(object) = object(&suite, &domain, case) {
                println!("{object}");
                written += 1;
            }
        }
        eprintln!("{}: {written} of {} cases", suite.name, suite.cases.len());
    }
    Ok(())
}

fn object(suite: &Suite, domain: &Domain, case: &Case) -> Option<Value> {
    let [step] = &case.steps[..] else { return None };
    let judged = suite.judged_world(case);
    let text = |goal: &Goal| goal.everyday(&judged).join(" & ").replace("& then ", "then ");
    let tagged = |name: &str| case.tags.iter().find_map(|tag| tag.strip_prefix(name)).map(str::trim);
    let (mut is_grouped, mut is_new) = (false, false);
    let mut written = |goal: &Goal| {
        is_grouped = !goal.groups.is_empty();
        text(goal)
    };
    let answer = match (tagged("meaning:"), &step.expected) {
        (Some(meaning), _) => Some(match goal::parse(&judged, meaning) {
            Ok(goal) => written(&goal),
            Err(_) => {
                is_new = true;
                meaning.to_owned()
            }
        }),
        (None, Expected::Question) => None,
        (None, Expected::Plan(goals)) => Some(written(goals.first()?)),
        (None, Expected::Refusal | Expected::Either | Expected::Nothing) => return None,
    };
    let mut world = suite.world(case);
    world.add_values(&step.says);
    let dialogue = UnderstandingDialogue::new(UnderstandingInput {
        domain,
        world: &world,
        instruction: &step.says,
        examples: None,
        asks: true,
    });
    let (query, fixed) = dialogue.messages().split_last()?;
    let (scene, instruction) = query.text.rsplit_once("Instruction: ")?;
    let fixed: Vec<Value> = fixed.iter().map(|own| json!([role(own.role), own.text])).collect();
    Some(json!({
        "suite": suite.name, "id": case.id, "tags": case.tags, "fixed": fixed, "lead": format!("{scene}Instruction:"),
        "instruction": format!(" {instruction}"), "answer": answer, "grouped": is_grouped, "new": is_new,
    }))
}

fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

/// A suite in a folder, and its domain.
fn read_suite(folder: &Path) -> Result<(Domain, Suite), Box<dyn Error>> {
    let mut cases = read_texts(folder, |name| name.ends_with(".toml"))?;
    let scenes = read_texts(&folder.join("scenes"), |name| name.ends_with(".json"))?;
    let files = Files {
        folder: format!("{}/", folder.display()),
        suite: cases.remove("suite.toml").ok_or("there is no suite.toml")?,
        cases,
        scenes: scenes
            .into_iter()
            .map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text))
            .collect(),
    };
    let domain = suite::domain_name(&files)?;
    let beside = folder.join(&domain);
    let domain = if beside.is_dir() {
        beside.display().to_string()
    } else {
        domain
    };
    let domain = longstep_llm::load_domain(&domain)?;
    let suite = suite::load(&files, &domain)?;
    Ok((domain, suite))
}
