//! Our side of `tools/peers/diagrams.mjs`: every EVERYth plan of the shipped suites as a diagram, and one with hostile names.
//!
//! `diagrams EVERY` writes one JSON object to a line for each plan: its name, its steps, Mermaid, and the language of Graphviz.
#![allow(clippy::print_stdout)]

use std::error::Error;

use longstep_core::schedule;
use longstep_core::search::{Limits, Outcome, solve};
use longstep_core::verify::{Purpose, VerifiedPlan, check};
use longstep_core::{environment, goal};
use longstep_eval::suite;
use longstep_picture::plan::{Annotations, Diagram, dot, mermaid};
use serde_json::json;

type Anyhow<T> = Result<T, Box<dyn Error>>;

fn main() -> Anyhow<()> {
    let every = std::env::args()
        .nth(1)
        .ok_or("usage: diagrams EVERY")?
        .parse::<usize>()?
        .max(1);
    let mut count = 0;
    for name in suite::shipped_names() {
        let (_, suite) = suite::load_shipped(name).ok_or("no such suite")??;
        let plans = suite.plans().map_err(|report| format!("{:?}", report.violations))?;
        for (plan, purpose) in plans {
            // Plans that branch, loop or have lanes are few, and are all drawn.
            let shared = schedule::share(plan.world(), &plan, &Purpose::default()).map(|shared| shared.plan);
            let is_drawn = count % every == 0 || !plan.plan().is_sequence();
            for (form, plan) in [("", is_drawn.then_some(plan)), (" in lanes", shared)] {
                if let Some(plan) = plan {
                    let annotations = Annotations::default().with_purpose(purpose.clone());
                    write(&format!("{name} {count}{form}"), &plan, &annotations);
                }
            }
            count += 1;
        }
    }
    write("hostile names", &plan_with_hostile_names()?, &Annotations::default());
    Ok(())
}

fn write(name: &str, plan: &VerifiedPlan, annotations: &Annotations) {
    let diagram = Diagram::of(plan, annotations);
    let steps = plan.plan().steps().len();
    println!(
        "{}",
        json!({"name": name, "steps": steps, "mermaid": mermaid(&diagram), "dot": dot(&diagram)})
    );
}

/// Names that are keywords, or that begin markup, in one of the languages.
const NAMES: [&str; 12] = [
    "end",
    "subgraph",
    "graph",
    "o--x",
    "a] --> b[c",
    "<b>bold</b>",
    "`**bold**`",
    "1. first",
    "\\N \\n \\l",
    "%%{init: {}}%%",
    "$$x^2$$",
    "杯子 \u{1f600}",
];

/// Ends of sentences about actions: what ends a text, entities, and a word that becomes a picture.
const ENDS: [&str; 8] = [
    "\"] --> b[\"c",
    "&lt;&amp;#35;",
    "fa:fa-ban",
    "<br/><script>alert(1)</script>",
    "\\\"];",
    "C:\\new",
    "$$x^2$$",
    "\n9. fire the laser",
];

fn toml_escaped(text: &str) -> String {
    text.replace('\\', "\\\\").replace('"', "\\\"").replace('\n', "\\n")
}

fn plan_with_hostile_names() -> Anyhow<VerifiedPlan> {
    let mut files = longstep::domain::shipped_files("household").ok_or("no such domain")?;
    let mut ends = ENDS.iter().cycle();
    let lines = files.words.lines().map(|line| match line.strip_suffix('"') {
        Some(start) if start.starts_with("says = ") => {
            format!("{start}{}\"", toml_escaped(ends.next().unwrap_or(&"")))
        }
        _ => line.to_owned(),
    });
    files.words = lines.collect::<Vec<_>>().join("\n");
    let domain = longstep::domain::load(&files)?;
    let objects = NAMES.map(|name| format!("<{name}>"));
    let states = objects
        .iter()
        .map(|name| (name.clone(), json!("on_something(<table>)")));
    let states: serde_json::Map<_, _> = states.collect();
    let long = format!("<{}>", "n".repeat(198));
    let text = json!({"assets": ["<table>", long], "objects": objects, "object_states": states});
    let world = environment::parse(&domain, "hostile.json", &text.to_string())?;
    let facts = objects.map(|name| format!("put({name}, {long})"));
    let purpose = goal::parse(&world, &facts.join(" & "))?.purpose(&world);
    let Outcome::Solved { plan, .. } = solve(&world, &purpose, &Limits::default()) else {
        return Err("the task with hostile names has no plan".into());
    };
    let plan = check(&world, plan, &purpose).into_verified();
    Ok(plan.map_err(|report| format!("{:?}", report.violations))?)
}
