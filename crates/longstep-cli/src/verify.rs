//! `longstep verify`: is a plan possible, and does it end where it claims?

use std::time::Instant;

use anyhow::Result;
use longstep::answer::Status;
use longstep::repair::Outcome;

use crate::arguments::VerifyArguments;
use crate::draft::Draft;
use crate::show;
use crate::solve::milliseconds;

pub(crate) fn run(arguments: &VerifyArguments) -> Result<u8> {
    let started = Instant::now();
    let draft = Draft::read(&arguments.plan, arguments.env.as_deref(), &arguments.domain)?;
    let verifying = Instant::now();
    let mut answer = draft.verdict();
    answer.timings_ms.verify = milliseconds(verifying);
    answer.timings_ms.total = milliseconds(started);
    if arguments.json {
        show::json(&answer)?;
    } else if arguments.feedback {
        if answer.status == Status::Invalid {
            anstream::print!("{}", draft.feedback());
        }
    } else {
        show::answer(&answer, &[]);
        if answer.status == Status::Invalid
            && let Outcome::Repaired(repaired) = draft.repair()
        {
            let length = draft.resolved.written.len();
            let told: Vec<String> = repaired.edits.iter().map(|edit| edit.told(length)).collect();
            show::hint(&format!("`longstep repair` makes it valid: {}", told.join("; ")));
        }
    }
    Ok(answer.status.exit_code())
}
