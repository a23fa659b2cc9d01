//! Inputs of up to 20 kB that ask for as much work as they can, each through the operation that a command uses for it.
//!
//! Every operation has a budget in units of work (`longstep_core::effort`). A row of the table says what an input may cost; a
//! row fails if it costs more, or if an operation whose budget was cut short calls a plan verified or a goal solved. Each
//! runs in a thread with the ordinary stack of 2 MiB, so deep nesting fails here, too. Time is shown and never judged:
//!
//!     cargo test -p longstep --test hostile -- --nocapture
//!
//! `HOSTILE=name` runs the rows whose names begin so.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

mod domains;
mod goals;
mod plans;
mod readers;

use longstep::domain::{self, Domain};
use longstep_core::effort;
use longstep_core::environment::{self, Environment, World};
use longstep_core::json::Path;
use longstep_core::testing;
use serde_json::{Value, json};

/// The bytes of an input.
const LARGEST: usize = 20_000;

/// An operation on an input that was generated; tells whether the answer is a verified plan or a solved goal.
type Work = Box<dyn Fn() -> bool + Send>;

/// An input, the units that its operation may spend, and how it is made.
struct Row {
    name: &'static str,
    ceiling: u64,
    make: fn() -> Work,
}

fn rows() -> Vec<Row> {
    [readers::rows(), plans::rows(), goals::rows(), domains::rows()]
        .into_iter()
        .flatten()
        .collect()
}

fn chosen() -> Vec<Row> {
    let wanted = std::env::var("HOSTILE").unwrap_or_default();
    rows().into_iter().filter(|row| row.name.starts_with(&wanted)).collect()
}

/// Runs in a thread with a stack as tests and programs have it.
fn in_thread<T: Send + 'static>(work: impl FnOnce() -> T + Send + 'static) -> T {
    let thread = std::thread::Builder::new().stack_size(2 << 20);
    thread.spawn(work).unwrap().join().unwrap()
}

#[test]
fn no_input_exceeds_its_effort_ceiling() {
    let mut over = Vec::new();
    for row in chosen() {
        let (name, ceiling, make) = (row.name, row.ceiling, row.make);
        println!("{name} ...");
        let units = in_thread(move || {
            let work = make();
            let started = std::time::Instant::now();
            let spent = effort::within(u64::MAX, &*work);
            println!(
                "{name}: {} of {ceiling} units, {:?}, good: {}",
                spent.units,
                started.elapsed(),
                spent.result
            );
            spent.units
        });
        if units > ceiling {
            over.push(format!("{name}: {units} units, at most {ceiling}"));
        }
    }
    assert!(over.is_empty(), "{}", over.join("\n"));
}

#[test]
fn exhausted_budget_never_yields_a_positive_result() {
    for row in chosen() {
        let (name, make) = (row.name, row.make);
        in_thread(move || {
            let work = make();
            for limit in [1_000, 50_000] {
                let spent = effort::within(limit, &*work);
                assert!(
                    !(spent.exhausted && spent.result),
                    "{name}: called good after {limit} units"
                );
            }
        });
    }
}

// ---- Worlds.

fn shipped(name: &str) -> Domain {
    domain::shipped(name).unwrap().unwrap()
}

/// The world of an environment that must be a good one.
fn world_of(domain: &Domain, environment: &Value) -> World {
    let text = environment.to_string();
    assert!(text.len() <= LARGEST, "an environment of {} bytes", text.len());
    testing::world_of(domain, text)
}

/// Reads an environment; tells nothing about it.
fn read_environment(domain: &str, environment: &Value) -> Work {
    let (domain, text) = (shipped(domain), environment.to_string());
    assert!(text.len() <= LARGEST, "an environment of {} bytes", text.len());
    Box::new(move || {
        if let Ok(environment) = Environment::from_json(&text) {
            let _ = environment::read(&domain, &environment, "environment", &text, &Path::default());
        }
        false
    })
}

fn numbered(prefix: &str, numbers: impl Iterator<Item = usize>) -> Vec<String> {
    numbers.map(|number| format!("<{prefix}{number}>")).collect()
}

/// So many places, and so many objects on the first of them.
fn many(places: usize, objects: usize) -> Value {
    let (assets, objects) = (numbered("p", 0..places), numbered("o", 0..objects));
    let on: serde_json::Map<String, Value> = objects
        .iter()
        .map(|object| (object.clone(), json!("on_something(<p0>)")))
        .collect();
    json!({"assets": assets, "asset_states": {}, "objects": objects, "object_states": on})
}

/// A text that is cut to the largest size.
fn fill(piece: &str) -> String {
    piece.repeat(LARGEST / piece.len())
}

/// Deep nesting, as much of it as fits.
fn nest(open: &str, middle: &str, close: &str) -> String {
    let depth = (LARGEST - middle.len()) / (open.len() + close.len());
    format!("{}{middle}{}", open.repeat(depth), close.repeat(depth))
}
