//! Solves PDDL tasks and verifies plans for them, for comparison with other programs.
//!
//! Each line of the standard input has the path of a domain, the path of a problem and, for verification, the path of a
//! plan, separated by tabs. Each line of the standard output is the result as JSON.

use std::io::{BufRead, Write};

use longstep_core::domain::from_pddl;
use longstep_core::pddl::{read_plan, read_problem, write_plan};
use longstep_core::plan::{Plan, Step, Violation};
use longstep_core::search::{GroundAction, Limits, Outcome, solve};
use longstep_core::verify::{Purpose, check};
use serde_json::{Value, json};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut out = std::io::stdout().lock();
    for line in std::io::stdin().lock().lines() {
        let line = line?;
        let paths: Vec<&str> = line.split('\t').collect();
        let result = task(&paths).unwrap_or_else(|error| json!({"outcome": "error", "why": error.to_string()}));
        writeln!(out, "{result}")?;
    }
    Ok(())
}

fn task(paths: &[&str]) -> Result<Value, Box<dyn std::error::Error>> {
    let [domain_path, problem_path, plan @ ..] = paths else {
        return Err("expected the paths of a domain and of a problem".into());
    };
    let domain = from_pddl(domain_path, &std::fs::read_to_string(domain_path)?)?;
    let problem = read_problem(&domain, problem_path, &std::fs::read_to_string(problem_path)?)?;
    let (world, purpose) = (&problem.world, Purpose::from(&problem));
    if let Some(path) = plan.first() {
        let steps = read_plan(world, path, &std::fs::read_to_string(path)?)?.steps;
        let explained = |step: GroundAction| Step::explained(world, step.action, step.arguments);
        let steps = steps.into_iter().map(explained).collect();
        let report = check(world, Plan::sequence(steps), &purpose);
        let inapplicable = report.violations.iter().find_map(|violation| match violation {
            Violation::Precondition { step, .. } => Some(*step),
            _ => None,
        });
        return Ok(json!({
            "outcome": "verdict",
            "valid": report.violations.is_empty(),
            "inapplicable": inapplicable,
            "cost": report.cost().map(|cost| cost.to_string()),
        }));
    }
    Ok(match solve(world, &purpose, &Limits::default()) {
        Outcome::Solved {
            plan, cost, shortest, ..
        } => json!({
            "outcome": "solved",
            "plan": write_plan(world, plan.steps()),
            "cost": cost.map(|cost| cost.to_string()),
            "best": shortest,
            "valid": check(world, plan, &purpose).violations.is_empty(),
        }),
        Outcome::ProvenUnsolvable { .. } => json!({"outcome": "unsolvable"}),
        Outcome::GaveUp { why, .. } => json!({"outcome": "gave_up", "why": why}),
    })
}
