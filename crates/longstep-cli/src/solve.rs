//! `longstep solve`, and the printing of answers that it shares with other commands.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use longstep::goal::{self, Goal};
use longstep::report::{self, Answer, Status};
use longstep_core::environment::World;
use longstep_core::model::DomainData;
use longstep_core::pddl::{self, WriteError};
use longstep_llm::load_domain;

use crate::arguments::{SolveArguments, domain_or_default, required};
use crate::clock::{clock, milliseconds};
use crate::failure::Failure;
use crate::output::{self, Line, print_line, remark};
use crate::{exit_code, inputs, lanes, problem, show};

pub(crate) fn run(arguments: &SolveArguments) -> Result<u8> {
    let started = Instant::now();
    let goal = match (&arguments.goal, &arguments.problem) {
        (Some(goal), None) => goal,
        // clap requires exactly one of `--goal` and `--problem`.
        (_, problem) => return problem::run(arguments, problem.as_deref().unwrap_or(Path::new(""))),
    };
    let env = required(arguments.env.as_deref())?;
    let domain = load_domain(domain_or_default(arguments.domain.as_ref()))?;
    let mut world = inputs::world(&domain, env, arguments.rules.as_deref())?;
    let text = goal;
    goal::add_values(&mut world, text);
    let goal = goal::parse(&world, text)?;
    if arguments.pddl {
        let name = env.file_stem().unwrap_or_default().to_string_lossy();
        let written = pddl::write_problem(&world, &goal.purpose(&world), &name).map_err(|error| {
            let failure = Failure::unreadable(error.to_string());
            match error {
                WriteError::Order | WriteError::Always { .. } => {
                    failure.hint("`--pddl-task FOLDER` writes a domain and a problem that can")
                }
                _ => failure,
            }
        })?;
        output::document(&written);
        return Ok(exit_code::DONE);
    }
    if let Some(folder) = &arguments.pddl_task {
        let name = env.file_stem().unwrap_or_default().to_string_lossy();
        let task = pddl::GroundTask::write(&world, &goal.purpose(&world), &name)?;
        inputs::write_files(
            folder,
            &[("domain.pddl", &task.domain), ("problem.pddl", &task.problem)],
        )?;
        remark!("Wrote domain.pddl and problem.pddl to {}", folder.display());
        return Ok(exit_code::DONE);
    }
    let report::Solution { plan, mut answer, .. } =
        report::of_goal(&world, &goal, text, &longstep::Limits::from(arguments.effort), &clock());
    let shown = match plan.filter(|_| arguments.parallel) {
        Some(plan) => lanes::side_by_side(&world, &plan, &goal.purpose(&world), &mut answer),
        None => Vec::new(),
    };
    answer.timings_ms.total = milliseconds(started);
    finish(
        &answer,
        &goal_lines(&world, &goal),
        &shown,
        arguments.save.as_deref().map(|path| (path, &**world.domain())),
        arguments.json,
    )
}

/// The sentences for a goal.
pub(crate) fn goal_lines(world: &World, goal: &Goal) -> Vec<String> {
    goal.sentences(world)
}

/// Saves and prints an answer, and returns the exit code. `lanes` are the lines of a parallel plan, empty for a
/// sequential one. A plan is saved with its domain.
pub(crate) fn finish(
    answer: &Answer,
    goal: &[String],
    lanes: &[Line],
    save: Option<(&Path, &DomainData)>,
    json: bool,
) -> Result<u8> {
    let saved = save.filter(|_| answer.status == Status::Verified);
    if let Some((path, domain)) = saved {
        inputs::save(path, &answer.plan, domain)?;
    }
    if json {
        show::json(answer)?;
    } else {
        if !goal.is_empty() {
            show::heading("Goal");
            for line in goal {
                print_line!("  {line}");
            }
            if !answer.steps.is_empty() {
                output::blank();
            }
        }
        let body = show::Body {
            lines: lanes,
            ..show::Body::default()
        };
        show::answer_with(answer, show::Changes::Shown, body);
        if let Some((path, _)) = saved {
            remark!("Saved to {}", path.display());
        }
    }
    Ok(exit_code::of_status(answer.status))
}
