//! `longstep export`: a verified plan in another notation.

use anyhow::Result;
use longstep::answer::Status;
use longstep::plan::{Written, script};

use crate::arguments::{ExportArguments, PlanFormat};
use crate::draft::Draft;

/// Writes the plan to stdout if it is valid; else its verdict to stderr, and nothing to stdout.
pub(crate) fn run(arguments: &ExportArguments) -> Result<u8> {
    let Draft { domain, world, attempt } = Draft::read(&arguments.draft)?;
    let answer = attempt.verdict(&domain, &world);
    let verified = attempt.verified(&domain, &world);
    let (Status::Verified, Some(verified)) = (answer.status, verified) else {
        match answer.status {
            Status::Question => anstream::eprintln!("The plan asks back: {}", answer.plan.question),
            _ => anstream::eprintln!("Not exported, since the plan is not valid:"),
        }
        for violation in &answer.violations {
            anstream::eprintln!("  - {}", violation.message);
        }
        return Ok(answer.status.exit_code());
    };
    match arguments.format {
        PlanFormat::Python => {
            anstream::print!("{}", script::write(&Written::of_plan(&domain, &world, verified.plan())))
        }
        PlanFormat::Json => anstream::println!("{}", serde_json::to_string_pretty(&answer.plan)?),
    }
    Ok(answer.status.exit_code())
}
