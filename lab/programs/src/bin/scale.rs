//! A large world: 200 actions and 5,000 entities, all made up. Prints how long things take and how much memory
//! they took at most.
//!
//! `cargo run --release --manifest-path lab/programs/Cargo.toml --bin scale -- [ENTITIES]`
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout)]

use std::fmt::Write as _;
use std::time::Instant;

use longstep::{domain, goal};
use longstep_core::environment::{self, Environment, World};
use longstep_core::json::Path;
use longstep_core::plan::{TaskCohesion, resolve};
use longstep_core::repair::{self, repair};
use longstep_core::search::{self, Limits};
use longstep_core::verify::{Purpose, bind, check};

/// VirtualHome and as many tools more as make 200 actions.
fn large_domain() -> domain::Files {
    let mut files = domain::shipped_files("virtualhome").unwrap();
    let shipped = domain::shipped("virtualhome").unwrap().unwrap().actions.len();
    let (mut pddl, mut words, mut predicates) = (String::new(), String::new(), String::new());
    for number in shipped..200 {
        let _ = writeln!(predicates, "(treated-{number} ?item - item)");
        let _ = write!(
            pddl,
            "(:action treat-{number} :parameters (?tool - item ?item - item)
               :precondition (and (holding ?tool) (near ?item) (not (= ?tool ?item))
                 (forall (?around - thing) (imply (inside ?item ?around) (not (closed ?around)))))
               :effect (and (treated-{number} ?item)
                 (forall (?other - item) (when (on ?other ?item) (treated-{number} ?other)))))\n"
        );
        let _ = write!(
            words,
            "\n[[predicate]]\nname = \"treated-{number}\"\nsays = \"{{item}} had treatment {number}\"\n\
             denies = \"{{item}} did not have treatment {number}\"\n\n[[action]]\nname = \"treat-{number}\"\n\
             call = \"Treat{number}(?tool, ?item)\"\nsays = \"give {{item}} treatment {number} with {{tool}}\"\n\
             means = \"Treatment {number}.\"\n"
        );
    }
    files.pddl = files
        .pddl
        .replacen("(:predicates", &format!("(:predicates {predicates}"), 1);
    let end = files.pddl.rfind(')').unwrap();
    files.pddl.insert_str(end, &pddl);
    let lexicon = files.words.find("[lexicon]").unwrap();
    files.words.insert_str(lexicon, &format!("{words}\n"));
    files
}

/// A hundredth of the entities are rooms, a fifth furniture, and the rest lies on the furniture.
fn large_environment(entities: usize) -> String {
    let (rooms, furniture) = (entities / 100, entities / 5);
    let kinds = ["table", "shelf", "cabinet", "desk", "fridge"];
    let things = ["plate", "mug", "book", "pen", "bottle", "box", "spoon", "towel"];
    let room = |n: usize| format!("<office_{}>", n % rooms + 1);
    let place = |n: usize| format!("<{}_{}>", kinds[n % kinds.len()], 10_000 + n);
    let thing = |n: usize| format!("<{}_{}>", things[n % things.len()], 20_000 + n);
    let places: Vec<usize> = (0..furniture).collect();
    let objects: Vec<usize> = (0..entities - rooms - furniture).collect();
    let assets: Vec<String> = (0..rooms).map(room).chain(places.iter().map(|n| place(*n))).collect();
    let asset_states: serde_json::Map<_, _> = places
        .iter()
        .map(|n| (place(*n), serde_json::json!([format!("INSIDE({})", room(*n))])))
        .collect();
    let properties: serde_json::Map<_, _> = places
        .iter()
        .map(|n| {
            let opens = matches!(kinds[n % kinds.len()], "cabinet" | "fridge");
            (
                place(*n),
                serde_json::json!([if opens { "IS_OPENABLE" } else { "NOT_OPENABLE" }]),
            )
        })
        .collect();
    let object_states: serde_json::Map<_, _> = objects
        .iter()
        .map(|n| (thing(*n), serde_json::json!([format!("ON({})", place(n % furniture))])))
        .collect();
    serde_json::json!({"assets": assets, "asset_states": asset_states, "asset_properties": properties,
        "objects": objects.iter().map(|n| thing(*n)).collect::<Vec<_>>(), "object_states": object_states})
    .to_string()
}

fn milliseconds<T>(what: &str, work: impl FnOnce() -> T) -> T {
    let started = Instant::now();
    let made = work();
    println!(
        "{what:<32} {:>9.2} ms   {:>5} MiB at most so far",
        started.elapsed().as_secs_f64() * 1e3,
        memory()
    );
    made
}

/// The most memory that the process had, where the system tells.
fn memory() -> String {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|line| line.strip_prefix("VmHWM:"));
    let kibibytes: Option<u64> = line.and_then(|rest| rest.trim().strip_suffix(" kB")?.trim().parse().ok());
    kibibytes.map_or_else(|| "?".to_owned(), |k| (k / 1024).to_string())
}

/// Carries things from where they are to other places, four steps each.
fn errands(world: &World, steps: usize, broken: bool) -> TaskCohesion {
    let identifiers: Vec<&str> = world.entities().map(|(_, e)| e.identifier.as_str()).collect();
    let of = |kind: &str| -> Vec<&str> {
        let named = |i: &&&str| i.starts_with(&format!("<{kind}_"));
        identifiers.iter().filter(named).copied().collect()
    };
    let (mugs, tables) = (of("mug"), of("table"));
    let mut calls = Vec::new();
    for errand in 0..steps / 4 {
        let (mug, table) = (mugs[errand * 7 % mugs.len()], tables[(errand * 13 + 5) % tables.len()]);
        calls.push(format!("Walktowards({mug})"));
        calls.push(format!("Grab({mug})"));
        calls.push(format!("Walktowards({table})"));
        // The verb that a model gets wrong.
        calls.push(format!("{}({mug}, {table})", if broken { "PutIn" } else { "Put" }));
    }
    TaskCohesion {
        task_sequence: calls,
        ..TaskCohesion::default()
    }
}

fn verified(world: &World, written: &TaskCohesion) -> usize {
    let steps = resolve(world, written).complete().unwrap();
    let (plan, _) = bind(world, &steps, &[], None).unwrap();
    check(world, plan, &Purpose::default()).violations.len()
}

fn main() {
    let entities = std::env::args().nth(1).map_or(5_000, |count| count.parse().unwrap());
    let files = large_domain();
    let text = large_environment(entities);
    println!(
        "200 actions, {entities} entities, {} KiB of environment\n",
        text.len() / 1024
    );
    let domain = milliseconds("load the domain", || {
        domain::load(&files).unwrap_or_else(|e| panic!("{e}"))
    });
    let world = milliseconds("read the environment", || {
        let environment = Environment::from_json(&text).unwrap();
        environment::read(&domain, &environment, "environment", &text, &Path::default())
            .unwrap_or_else(|e| panic!("{e}"))
    });
    let plan = errands(&world, 100, false);
    let violations = milliseconds("verify 100 steps", || verified(&world, &plan));
    assert_eq!(violations, 0);
    let broken = errands(&world, 4, true);
    milliseconds("repair 4 steps", || {
        let outcome = repair(&world, &resolve(&world, &broken), &Purpose::default());
        assert!(matches!(outcome, repair::RepairOutcome::Repaired(_)), "{outcome:?}");
    });
    let identifier = |prefix: &str| {
        let mut all = world.entities().map(|(_, e)| &e.identifier);
        all.find(|identifier| identifier.starts_with(prefix)).unwrap().clone()
    };
    let wanted = format!("put({}, {})", identifier("<mug_"), identifier("<desk_"));
    let goal = goal::parse(&world, &wanted).unwrap_or_else(|e| panic!("{e}"));
    milliseconds("search for one goal", || {
        let outcome = search::solve(&world, &goal.purpose(&world), &Limits::default());
        assert!(matches!(outcome, search::Outcome::Solved { .. }), "{outcome:?}");
    });
}
