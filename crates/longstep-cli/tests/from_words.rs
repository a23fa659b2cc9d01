//! Instructions from words to a world in which objects have moved, with one `longstep run` for each instruction: the fifteen of
//! the `household` suite (five scenes, each a chain) in MuJoCo, and the twenty of pyrobosim.
//!
//!     LONGSTEP_TEST_MODEL=MODEL cargo test -p longstep-cli --test from_words -- --ignored --nocapture
//!
//! `LONGSTEP_TEST_MODEL` is the reference for `--model`. The robots are those that `scripts/robots/mujoco.sh` and
//! `scripts/robots/pyrobosim.sh` install; `LONGSTEP_TEST_ROBOT` names another one for the household.
#![cfg(unix)]
#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::disallowed_macros,
    clippy::print_stdout,
    missing_docs
)]

mod common;

use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use common::{Server, goals, longstep, root};
use longstep_core::environment::{self, Moment, World, holds};
use longstep_core::execution::{Event, Execution};
use longstep_core::goal;
use longstep_core::model::Domain;
use longstep_llm::load_domain;
use longstep_robot::RunLog;

/// A suite, and the robot for each of its scenes.
struct Suite {
    /// The name of a shipped domain, or its folder.
    domain: String,
    folder: PathBuf,
    cases: &'static str,
    robot: fn(&str) -> String,
}

impl Suite {
    fn household(robot: fn(&str) -> String) -> Self {
        Self {
            domain: "household".to_owned(),
            folder: root().join("crates/longstep-eval/suites/household"),
            cases: "chains.toml",
            robot,
        }
    }

    fn pyrobosim() -> Self {
        let domain = root().join("examples/robots/pyrobosim/domain");
        Self {
            folder: domain.join("suite"),
            domain: domain.display().to_string(),
            cases: "instructions.toml",
            robot: |scene| {
                let world = match scene {
                    "simple_world" => "pddlstream_simple_world.yaml",
                    _ => "test_world.yaml",
                };
                format!("process:examples/robots/pyrobosim/run --world {world}")
            },
        }
    }

    fn chains(&self) -> Vec<Chain> {
        let text = fs::read_to_string(self.folder.join(self.cases)).unwrap();
        let table: toml::Table = text.parse().unwrap();
        let instruction = |step: &toml::Value| Instruction {
            says: step["says"].as_str().unwrap().to_owned(),
            goal: step["goal"].as_str().unwrap().to_owned(),
        };
        let chain = |case: &toml::Value| Chain {
            scene: case["scene"].as_str().unwrap().to_owned(),
            instructions: match case.get("steps") {
                Some(steps) => steps.as_array().unwrap().iter().map(instruction).collect(),
                None => vec![instruction(case)],
            },
        };
        table["case"].as_array().unwrap().iter().map(chain).collect()
    }
}

/// One instruction of a chain.
struct Instruction {
    says: String,
    goal: String,
}

/// A scene with its instructions.
struct Chain {
    scene: String,
    instructions: Vec<Instruction>,
}

/// The end of an instruction.
struct Outcome {
    code: i32,
    /// True if the goal of the suite holds in the state at the end of the log, events included.
    reached: bool,
    time: Duration,
    steps: usize,
    stderr: String,
}

/// Returns true if a goal of the suite holds at the end of a run, from the world in which the instruction was given.
fn is_reached(domain: &Domain, world: &World, wanted: &str, events: &[Event]) -> bool {
    let Ok(execution) = Execution::replay(domain, events) else {
        return false;
    };
    let mut world = world.clone();
    world.add_values(wanted);
    let purpose = goal::parse(&world, wanted).unwrap().purpose(&world);
    let world = world.continued(execution.state().clone());
    let moment = Moment {
        world: &world,
        state: &world.state,
    };
    let wanted = purpose.at_end(domain);
    let met = |own: &longstep_core::model::Wanted| holds(moment, &own.condition, &mut own.bindings.clone());
    wanted.iter().all(met)
}

fn run(
    suite: &Suite,
    home: &Path,
    environment: &Path,
    instruction: &Instruction,
    (model, robot): (&str, &str),
    number: usize,
) -> Outcome {
    let domain = load_domain(&suite.domain).unwrap();
    let text = fs::read_to_string(environment).unwrap();
    let world = environment::parse(&domain, "env.json", &text).unwrap();
    let log = home.join(format!("{number}.jsonl"));
    let begun = Instant::now();
    let mut command = longstep(home);
    command.args([
        "run",
        &instruction.says,
        "--model",
        model,
        "--robot",
        robot,
        "--domain",
        &suite.domain,
    ]);
    command.args(["--approve", "never", "--json", "--env"]).arg(environment);
    command
        .arg("--log")
        .arg(&log)
        .arg("--save-after")
        .arg(home.join("after.json"));
    // The model and MuJoCo are in the cache of the person who runs this.
    if let Some(cache) = std::env::var_os("LONGSTEP_CACHE") {
        command.env("LONGSTEP_CACHE", cache);
    } else {
        command.env_remove("LONGSTEP_CACHE");
    }
    command.env("HOME", std::env::var_os("HOME").unwrap_or_default());
    let output = command.output().unwrap();
    let time = begun.elapsed();
    let events = RunLog::read(&log).map(|(_, events)| events).unwrap_or_default();
    Outcome {
        code: output.status.code().unwrap_or(-1),
        reached: is_reached(&domain, &world, &instruction.goal, &events),
        time,
        steps: events
            .iter()
            .filter(|event| matches!(event, Event::Ordered { .. }))
            .count(),
        stderr: String::from_utf8_lossy(&output.stderr).into_owned(),
    }
}

/// Runs all chains; returns the number of instructions, and of those that reach the goal of the suite.
fn run_all(suite: &Suite, model: &str) -> (usize, usize) {
    let (mut count, mut reached, mut whole) = (0, 0, Duration::ZERO);
    for chain in suite.chains() {
        let home = tempfile::tempdir().unwrap();
        let mut environment = suite.folder.join(format!("scenes/{}.json", chain.scene));
        let robot = (suite.robot)(&chain.scene);
        for instruction in &chain.instructions {
            let outcome = run(suite, home.path(), &environment, instruction, (model, &robot), count);
            count += 1;
            reached += usize::from(outcome.reached);
            whole += outcome.time;
            println!(
                "{:>2} {} exit {:<2} {:>2} steps {:>6.1} s  {}",
                count,
                if outcome.reached { "reached" } else { "MISSED " },
                outcome.code,
                outcome.steps,
                outcome.time.as_secs_f64(),
                instruction.says
            );
            if !outcome.reached {
                println!("{}", outcome.stderr);
            }
            // The next instruction begins in the world that was observed.
            if home.path().join("after.json").exists() {
                let next = home.path().join(format!("env-{count}.json"));
                fs::rename(home.path().join("after.json"), &next).unwrap();
                environment = next;
            }
        }
    }
    println!("{reached} of {count} reach the goal, {:.1} s", whole.as_secs_f64());
    (count, reached)
}

fn model() -> String {
    std::env::var("LONGSTEP_TEST_MODEL").expect("LONGSTEP_TEST_MODEL is the reference for `--model`")
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL, and MuJoCo or LONGSTEP_TEST_ROBOT"]
fn the_household_in_mujoco() {
    let mujoco = |_: &str| {
        let other = std::env::var("LONGSTEP_TEST_ROBOT");
        other.unwrap_or_else(|_| "process:examples/robots/mujoco/run".to_owned())
    };
    let (count, reached) = run_all(&Suite::household(mujoco), &model());
    assert_eq!(count, 15);
    assert!(reached > 0, "no instruction reached its goal");
}

#[test]
#[ignore = "needs LONGSTEP_TEST_MODEL, and pyrobosim"]
fn twenty_instructions_in_pyrobosim() {
    let (count, reached) = run_all(&Suite::pyrobosim(), &model());
    assert_eq!(count, 20);
    assert!(reached > 0, "no instruction reached its goal");
}

/// These commands with a small server in place of a model, which wants the goals of the suite, in the simulator.
#[test]
fn fifteen_instructions_move_objects() {
    let suite = Suite::household(|_| "sim:seed=5".to_owned());
    let chains = suite.chains();
    let wanted: Vec<(String, String)> = chains
        .iter()
        .flat_map(|chain| &chain.instructions)
        .map(|own| (own.says.clone(), own.goal.clone()))
        .collect();
    let server = Server::answering(move |_, body| {
        let asked = body["messages"].to_string();
        // The last instruction that the request quotes: examples come before it.
        let place = |says: &String| asked.rfind(serde_json::to_string(says).unwrap().trim_matches('"'));
        let (_, goal) = wanted.iter().max_by_key(|(says, _)| place(says)).unwrap();
        goals(&[goal])
    });
    assert_eq!(run_all(&suite, &server.reference()), (15, 15));
}
