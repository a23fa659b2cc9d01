//! `longstep solve --problem`: a PDDL task, and its plan in the format of planners.

use std::path::Path;
use std::time::Instant;

use anyhow::Result;
use longstep::report::{self, Answer, Status};
use longstep_core::pddl::{self, Problem};
use longstep_core::verify::Purpose;
use longstep_files::read_text;

use crate::arguments::SolveArguments;
use crate::clock::{clock, milliseconds};
use crate::output::print_line;
use crate::{exit_code, inputs, show};

pub(crate) fn run(arguments: &SolveArguments, problem_file: &Path) -> Result<u8> {
    let started = Instant::now();
    let problem = read(arguments.domain.as_deref(), problem_file)?;
    let purpose = Purpose::from(&problem);
    let mut answer = report::of_purpose(
        &problem.world,
        &purpose,
        None,
        &problem.name,
        &longstep::Limits::from(arguments.effort),
        &clock(),
    )
    .answer;
    answer.notes.extend(problem.notes.iter().map(ToString::to_string));
    answer.goal = pddl::write_goal(&problem.world, &problem.wanted)?;
    answer.timings_ms.total = milliseconds(started);
    if let Some(path) = arguments.save.as_deref().filter(|_| answer.status == Status::Verified) {
        inputs::save(path, &answer.plan, problem.world.domain())?;
    }
    if arguments.json {
        show::json(&answer)?;
    } else {
        print(&answer);
    }
    Ok(exit_code::of_status(answer.status))
}

/// Reads a PDDL problem, and its domain: a file, or a folder with a `domain.pddl`.
pub(crate) fn read(domain: Option<&str>, problem_file: &Path) -> Result<Problem> {
    let named = Path::new(domain.unwrap_or("domain.pddl"));
    let domain_file = if named.is_dir() {
        named.join("domain.pddl")
    } else {
        named.to_owned()
    };
    let text = read_text(problem_file)?;
    let domain_text = read_text(&domain_file)?;
    let own = longstep_core::domain::read_foreign(&domain_file.display().to_string(), &domain_text, Some(&text))?;
    let mut problem = pddl::read_problem(&own.domain, &problem_file.display().to_string(), &text)?;
    problem.notes.splice(0..0, own.notes);
    Ok(problem)
}

/// Prints the plan, one step a line. All other lines are comments, so that other programs can read the plan.
fn print(answer: &Answer) {
    for step in &answer.steps {
        let words: Vec<&str> = std::iter::once(step.action.as_str())
            .chain(step.arguments.iter().map(String::as_str))
            .collect();
        print_line!("({})", words.join(" "));
    }
    for note in answer
        .notes
        .iter()
        .chain(answer.violations.iter().map(|violation| &violation.message))
    {
        print_line!("; {note}");
    }
    let verdict = match answer.status {
        Status::Verified => format!("verified, {} step(s)", answer.steps.len()),
        Status::Unsolvable => "unsolvable: no plan reaches this goal".to_owned(),
        Status::GaveUp => "gave up: no plan found within the limits".to_owned(),
        Status::Invalid | Status::Question => "not valid".to_owned(),
    };
    let (search, verify) = (answer.timings_ms.search, answer.timings_ms.verify);
    print_line!("; {verdict} (search {search:.2} ms, verification {verify:.2} ms)");
}
