//! `longstep solve`, and what it shares with `longstep plan`: from a goal to an answer.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use longstep::answer::{Answer, Status};
use longstep::domain::Domain;
use longstep::goal::{self, Goal};
use longstep::pddl;
use longstep::plan::{Plan, Step};
use longstep::search::{self, Limits, Outcome, Wanted};
use longstep::verify::{self, Purpose};
use longstep::world::World;

use crate::arguments::SolveArguments;
use crate::{inputs, problem, show};

pub(crate) fn run(arguments: &SolveArguments) -> Result<u8> {
    let started = Instant::now();
    let (goal, env) = match (&arguments.goal, &arguments.env, &arguments.problem) {
        (Some(goal), Some(env), None) => (goal, env),
        // The arguments are declared so that it is one or the other.
        (_, _, problem) => return problem::run(arguments, problem.as_deref().unwrap_or(Path::new(""))),
    };
    let domain = inputs::domain(arguments.domain.as_deref().unwrap_or("household"))?;
    let world = inputs::world(&domain, env)?;
    let text = goal;
    let goal = goal::parse(&domain, &world, text)?;
    if arguments.pddl {
        let name = env.file_stem().unwrap_or_default().to_string_lossy();
        let written = pddl::write_problem(&domain, &world, &goal.wanted(&domain), &name)?;
        anstream::print!("{written}");
        return Ok(Status::Verified.exit_code());
    }
    let (mut answer, notes) = answer(&domain, &world, &goal, text);
    answer.timings_ms.total = milliseconds(started);
    finish(
        &answer,
        &goal_lines(&domain, &world, &goal),
        &notes,
        arguments.save.as_deref(),
        arguments.json,
    )
}

/// The sentences for a goal.
pub(crate) fn goal_lines(domain: &Domain, world: &World, goal: &Goal) -> Vec<String> {
    goal.facts.iter().map(|fact| fact.sentence(domain, world)).collect()
}

/// Plans for a goal and verifies the plan. The second part is for a person's eyes only.
pub(crate) fn answer(domain: &Domain, world: &World, goal: &Goal, summary: &str) -> (Answer, Vec<String>) {
    let wanted = goal.wanted(domain);
    let (mut answer, notes) = plan_for(domain, world, &wanted, &goal.purpose(domain), Some(goal), summary);
    answer.goal = goal.facts.iter().map(|fact| fact.exact(domain, world)).collect();
    (answer, notes)
}

/// Plans for what is wanted and verifies the plan against its purpose; the goal is there for what is said.
pub(crate) fn plan_for(
    domain: &Domain,
    world: &World,
    wanted: &[Wanted],
    purpose: &Purpose,
    goal: Option<&Goal>,
    summary: &str,
) -> (Answer, Vec<String>) {
    let started = Instant::now();
    let outcome = search::solve(domain, world, wanted, &Limits::default());
    let search_time = milliseconds(started);
    let mut notes = Vec::new();
    let started = Instant::now();
    let mut answer = match outcome {
        Outcome::Solved { steps, shortest, .. } => {
            if !shortest {
                notes.push("a shorter plan may exist: the search for it was cut short".to_owned());
            }
            let explained = |s: search::GroundAction| Step::explained(domain, world, s.action, s.arguments);
            let plan: Plan = steps.into_iter().map(explained).collect();
            let report = verify::check(domain, world, plan, purpose);
            let verify_time = milliseconds(started);
            let mut answer = Answer::of_report(domain, world, &report, goal, summary);
            answer.timings_ms.verify = verify_time;
            answer
        }
        Outcome::ProvenUnsolvable { .. } => Answer::without_plan(Status::Unsolvable, world, summary, ""),
        Outcome::GaveUp { why, .. } => {
            notes.push(why);
            Answer::without_plan(Status::GaveUp, world, summary, "")
        }
    };
    answer.timings_ms.search = search_time;
    (answer, notes)
}

/// Saves, prints, and returns the exit code.
pub(crate) fn finish(
    answer: &Answer,
    goal: &[String],
    notes: &[String],
    save: Option<&Path>,
    json: bool,
) -> Result<u8> {
    if let Some(path) = save.filter(|_| answer.status == Status::Verified) {
        inputs::save(path, &answer.plan)?;
    }
    if json {
        show::json(answer)?;
    } else {
        if !goal.is_empty() && answer.status != Status::Question {
            show::heading("Goal");
            for line in goal {
                anstream::println!("  {line}");
            }
            if !answer.steps.is_empty() {
                anstream::println!();
            }
        }
        show::answer(answer, notes);
        if let Some(path) = save.filter(|_| answer.status == Status::Verified) {
            anstream::eprintln!("saved to {}", path.display());
        }
    }
    Ok(answer.status.exit_code())
}

/// Milliseconds since then.
pub(crate) fn milliseconds(since: Instant) -> f64 {
    // Microseconds are as fine as anybody reads.
    (since.elapsed().as_secs_f64() * 1_000_000.0).round() / 1000.0
}
