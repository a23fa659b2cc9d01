//! `longstep export`: a verified plan in another notation.

use anyhow::Result;
use longstep::report::Status;
use longstep_core::plan::{Written, script};

use crate::arguments::{ExportArguments, PlanFormat};
use crate::draft::Draft;
use crate::exit_code;
use crate::output::{self, remark};

/// Prints the plan to stdout if it is valid; otherwise its verdict to stderr, and nothing to stdout.
pub(crate) fn run(arguments: &ExportArguments) -> Result<u8> {
    let draft = Draft::read(&arguments.draft)?;
    let assessment = draft.assessment();
    let answer = assessment.verdict();
    let verified = assessment.verified();
    let (Status::Verified, Some(verified)) = (answer.status, verified) else {
        match answer.status {
            Status::Question => remark!("The plan is a clarifying question: {}", answer.plan.question),
            _ => remark!("Not exported, because the plan is not valid:"),
        }
        for violation in &answer.violations {
            remark!("  - {}", violation.message);
        }
        return Ok(exit_code::of_status(answer.status));
    };
    match arguments.format {
        PlanFormat::Python => {
            let written = Written::of_plan(&draft.world, verified.plan());
            output::document(&script::write(&written));
        }
        PlanFormat::Json => output::json(&answer.plan.clone().of_domain(draft.world.domain()))?,
    }
    Ok(exit_code::of_status(answer.status))
}
