//! The paper's fourteen scenarios, read from their recordings.
//!
//! The recordings are not part of Longstep; the user passes their folder.

use std::collections::BTreeMap;

use longstep::domain::Domain;
use longstep::goal;
use longstep_core::diagnostic::{Diagnostic, Diagnostics};
use longstep_core::environment::{self, Environment, World};
use longstep_core::json::Path;
use serde::Deserialize;

use super::{Case, Expected, Step, Suite};

/// The wording by purpose ("Let's watch TV").
pub const GOAL_LEVEL: &str = "goal_level";

/// The number of correct trials, of five, for each scenario in the paper (table "Executability of the output action
/// sequence across trials").
pub const TRIALS: [u8; 14] = [0, 0, 0, 0, 5, 5, 0, 5, 0, 0, 0, 5, 5, 0];

/// The number of rounds of feedback for each scenario in the paper (table "The number of rounds of feedback needed to
/// reach a successful sequence").
pub const ROUNDS: [u32; 14] = [1, 1, 3, 1, 0, 0, 1, 0, 1, 2, 1, 0, 0, 1];

#[derive(Debug, Deserialize)]
struct Scenario {
    id: u32,
    instruction: String,
    instruction_goal_level: String,
    environment: serde_json::Value,
    goal: Vec<String>,
}

/// Reads `virtualhome14/scenarios.json`.
///
/// # Errors
///
/// All entries that are not scenarios of this domain.
pub fn load(domain: &Domain, file: &str, text: &str) -> Result<Suite, Diagnostics> {
    let scenarios: Vec<Scenario> = serde_json::from_str(text)
        .map_err(|error| Diagnostics(vec![Diagnostic::whole(file, format!("no list of scenarios: {error}"))]))?;
    let (mut scenes, mut cases, mut faults) = (BTreeMap::new(), Vec::new(), Vec::new());
    for scenario in scenarios {
        let scene = format!("scenario-{}", scenario.id);
        match read(domain, file, &scenario) {
            Ok((world, expected)) => {
                let mut says = scenario.instruction;
                // Starts with a capital letter.
                if let Some(first) = says.get(..1) {
                    says.replace_range(..1, &first.to_uppercase());
                }
                scenes.insert(scene.clone(), world);
                cases.push(Case {
                    rules: Vec::new(),
                    id: scenario.id.to_string(),
                    scene,
                    steps: vec![Step {
                        says,
                        wordings: [(GOAL_LEVEL.to_owned(), scenario.instruction_goal_level)].into(),
                        expected,
                    }],
                    tags: Vec::new(),
                });
            }
            Err(found) => faults.extend(found.0),
        }
    }
    if !faults.is_empty() {
        return Err(Diagnostics::sorted(faults));
    }
    Ok(Suite {
        name: "paper".to_owned(),
        about: "The fourteen scenarios of the paper, each in its own environment.".to_owned(),
        domain: "virtualhome".to_owned(),
        judged: scenes.clone(),
        scenes,
        cases,
    })
}

fn read(domain: &Domain, file: &str, scenario: &Scenario) -> Result<(World, Expected), Diagnostics> {
    let text = scenario.environment.to_string();
    let fault = |message: String| {
        let message = format!("scenario {}: {message}", scenario.id);
        Diagnostics(vec![Diagnostic::whole(file, message)])
    };
    let environment = Environment::from_json(&text).map_err(|error| fault(error.to_string()))?;
    let world = environment::read(domain, &environment, file, &text, &Path::default())?;
    let mut goals = Vec::new();
    for facts in alternatives(&scenario.goal) {
        let text = facts.join(" & ");
        goals.push(goal::parse(&world, &text).map_err(|error| fault(format!("`{text}`: {error}")))?);
    }
    Ok((world, Expected::Plan(goals)))
}

/// All combinations of the alternatives that `|` separates, in goal words of the domain.
fn alternatives(facts: &[String]) -> Vec<Vec<String>> {
    let mut all: Vec<Vec<String>> = vec![Vec::new()];
    for fact in facts {
        let options: Vec<String> = fact.split('|').map(|option| in_goal_words(option.trim())).collect();
        let with = |so_far: &Vec<String>| {
            let longer = |option: &String| [&so_far[..], std::slice::from_ref(option)].concat();
            options.iter().map(longer).collect::<Vec<_>>()
        };
        all = all.iter().flat_map(with).collect();
    }
    all
}

/// Maps the scenarios' words for acts to goal words.
fn in_goal_words(fact: &str) -> String {
    match fact.split_once('(') {
        Some(("DRUNK", arguments)) => format!("drunk({arguments}"),
        Some(("REPLACED", arguments)) => {
            let thing = arguments.split([',', ')']).next().unwrap_or_default();
            format!("moved({thing})")
        }
        _ => fact.to_owned(),
    }
}
