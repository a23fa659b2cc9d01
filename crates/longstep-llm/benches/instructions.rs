//! How many instructions of the recorded scenes a model gets right, and how long each takes.
//!
//! `LONGSTEP_CORPUS` is the folder of the recordings; the argument or `LONGSTEP_MODEL` is a model reference,
//! by default the catalogue's default model. Prints a line for each instruction and the figures at the end.
//!
//! ```text
//! LONGSTEP_CORPUS=../shared/corpus cargo bench -p longstep-llm --bench instructions
//! ```
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::print_stdout,
    clippy::print_stderr,
    clippy::panic,
    missing_docs
)]

use std::path::PathBuf;
use std::time::{Duration, Instant};

use longstep::dialogue::Dialogue;
use longstep::domain::{self, Domain};
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_core::environment::{self, World, differences};
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::testing;
use longstep_core::verify::{self, Report};
use longstep_files::cache_directory;
use longstep_llm::{ChatModel, ModelReference, OpenOptions, Progress, catalogue, converse, open};
use serde_json::Value;

fn read(file: &str) -> Value {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("set LONGSTEP_CORPUS to the folder of the recordings");
    serde_json::from_str(&std::fs::read_to_string(PathBuf::from(folder).join(file)).unwrap()).unwrap()
}

/// The result of an instruction.
struct Made {
    answer: String,
    report: Option<Report>,
    model_time: Duration,
    search_time: Duration,
}

fn plan(model: &mut dyn ChatModel, domain: &Domain, world: &World, instruction: &str) -> Made {
    let started = Instant::now();
    let mut dialogue = Understanding::new(UnderstandingInput::new(
        domain,
        world,
        instruction,
        model.constraint_kind(),
    ));
    let meant = match converse(model, &mut dialogue, &mut |_: Progress| {}) {
        Ok(meant) => meant.goal.filter(|_| meant.question.is_none()),
        Err(error) => {
            println!("    {error}");
            None
        }
    };
    let mut made = Made {
        answer: dialogue.transcript().answer().to_owned(),
        report: None,
        model_time: started.elapsed(),
        search_time: Duration::ZERO,
    };
    if let Some(goal) = meant {
        let started = Instant::now();
        let outcome = search::solve(world, &goal.purpose(world), &Limits::default());
        made.search_time = started.elapsed();
        if let Outcome::Solved { plan, .. } = outcome {
            made.report = Some(verify::check(world, plan, &goal.purpose(world)));
        }
    }
    made
}

#[derive(Default)]
struct Tally {
    verified: usize,
    right: usize,
    all: usize,
    times: Vec<Duration>,
    searches: Vec<Duration>,
}

impl Tally {
    fn count(&mut self, name: &str, made: &Made, right: bool) {
        let verified = made.report.as_ref().is_some_and(|report| report.violations.is_empty());
        self.all += 1;
        self.verified += usize::from(verified);
        self.right += usize::from(right);
        self.times.push(made.model_time);
        self.searches.push(made.search_time);
        let mark = if right { "ok   " } else { "WRONG" };
        println!(
            "{mark} {:5.2} s  {name}  ->  {}",
            made.model_time.as_secs_f64(),
            made.answer
        );
    }

    fn print(&mut self, title: &str) {
        let median = |times: &mut Vec<Duration>| {
            times.sort();
            times.get(times.len() / 2).copied().unwrap_or_default()
        };
        println!(
            "== {title}: {} of {} right, {} verified; median {:.2} s for the model, {:.2} ms for the search",
            self.right,
            self.all,
            self.verified,
            median(&mut self.times).as_secs_f64(),
            median(&mut self.searches).as_secs_f64() * 1000.0
        );
    }
}

fn household(model: &mut dyn ChatModel) {
    let domain = domain::shipped("household").unwrap().unwrap();
    let mut tally = Tally::default();
    for scene in ["drawer", "fridge", "shelf", "table", "window"] {
        for step in read(&format!("household/{scene}.json"))["steps"].as_array().unwrap() {
            let world = testing::world_of(&domain, &step["recorded"]["environment_before"]);
            let instruction = step["instruction"].as_str().unwrap();
            let made = plan(model, &domain, &world, instruction);
            let right = made.report.as_ref().is_some_and(|report| {
                let after = environment::write(&world, &report.ending().after);
                serde_json::to_value(after).unwrap() == step["recorded"]["environment_after"]
            });
            tally.count(&format!("{scene}: {instruction}"), &made, right);
        }
    }
    tally.print("household");
}

/// Returns true if a goal fact of the scenarios holds at the end. Any of the kitchen's plates is as good as another
/// that shares its place.
fn reached(world: &World, report: &Report, fact: &str, any_plate: bool) -> bool {
    let domain = world.domain();
    let (word, arguments) = fact.trim().split_once('(').unwrap();
    let names: Vec<&str> = arguments.trim_end_matches(')').split(',').map(str::trim).collect();
    let predicate = match word {
        "REPLACED" => "placed",
        "SWITCHED_ON" => "switched-on",
        other => &other.to_lowercase(),
    };
    let index = domain.predicates.iter().position(|p| p.name == predicate).unwrap();
    let fits = |id: environment::EntityId, name: &str| {
        let identifier = &world.entity(id).identifier;
        identifier == name || (any_plate && identifier.starts_with("<plate_") && name.starts_with("<plate_"))
    };
    report
        .ending()
        .after
        .clone()
        .of_predicate(domain::PredicateId::new(index))
        .iter()
        .any(|fact| {
            names
                .iter()
                .enumerate()
                .all(|(place, name)| fits(fact.argument(place), name))
        })
}

fn kitchen(model: &mut dyn ChatModel, shared: bool) {
    let domain = domain::shipped("virtualhome").unwrap().unwrap();
    let kitchen = testing::world_of(&domain, read("virtualhome14/kitchen.json"));
    let mut tally = Tally::default();
    for scenario in read("virtualhome14/scenarios.json").as_array().unwrap() {
        let world = if shared {
            kitchen.clone()
        } else {
            testing::world_of(&domain, &scenario["environment"])
        };
        for key in ["instruction", "instruction_goal_level"] {
            let instruction = scenario[key].as_str().unwrap();
            let made = plan(model, &domain, &world, instruction);
            let goals: Vec<&str> = scenario["goal"]
                .as_array()
                .unwrap()
                .iter()
                .map(|g| g.as_str().unwrap())
                .collect();
            let right = made.report.as_ref().is_some_and(|report| {
                let all = goals
                    .iter()
                    .all(|goal| goal.split('|').any(|fact| reached(&world, report, fact, shared)));
                let named = |identifier: &str| {
                    goals.iter().any(|goal| goal.contains(identifier))
                        || (identifier.starts_with("<plate_") && goals.iter().any(|goal| goal.contains("(<plate_")))
                };
                let unasked = differences(&domain, &world.state, &report.ending().after)
                    .iter()
                    .any(|difference| !named(&world.entity(difference.fact.argument(0)).identifier));
                report.violations.is_empty() && all && !unasked
            });
            tally.count(&format!("{}: {instruction}", scenario["id"]), &made, right);
        }
    }
    tally.print(if shared {
        "fourteen scenarios in kitchen.json"
    } else {
        "fourteen scenarios, own environments"
    });
}

fn main() {
    let name = std::env::var("LONGSTEP_MODEL").unwrap_or_else(|_| catalogue::DEFAULT.to_owned());
    let only = std::env::args()
        .skip(1)
        .find(|argument| !argument.starts_with('-'))
        .unwrap_or_default();
    let reference: ModelReference = name.parse().unwrap_or_else(|error| panic!("{error}"));
    let options = OpenOptions::new(cache_directory().unwrap());
    let mut model = open(&reference, &options, &mut |_| {}).unwrap_or_else(|error| panic!("{error}"));
    if "household".contains(&only) {
        household(model.as_mut());
    }
    if "own".contains(&only) {
        kitchen(model.as_mut(), false);
    }
    if "kitchen".contains(&only) {
        kitchen(model.as_mut(), true);
    }
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let peak = status
        .lines()
        .find(|line| line.starts_with("VmHWM"))
        .unwrap_or_default();
    println!("peak memory {}", peak.trim_start_matches("VmHWM:").trim());
}
