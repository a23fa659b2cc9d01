//! `longstep verify`: checks that a plan is executable and that its claims hold.

use std::time::Instant;

use anyhow::Result;
use longstep::report::Status;

use crate::arguments::VerifyArguments;
use crate::draft::{Draft, timed_verdict};
use crate::{exit_code, output, show};

pub(crate) fn run(arguments: &VerifyArguments) -> Result<u8> {
    let started = Instant::now();
    let draft = Draft::read(&arguments.draft)?;
    let assessment = draft.assessment();
    let answer = timed_verdict(&assessment, started);
    if arguments.json {
        show::json(&answer)?;
    } else if arguments.feedback && answer.status == Status::Invalid {
        output::document(&assessment.feedback());
    } else if !arguments.feedback || answer.status == Status::Question {
        show::answer(&answer, show::Changes::Shown);
        let advice = (answer.status == Status::Invalid)
            .then(|| assessment.advice())
            .flatten();
        if let Some(advice) = advice {
            show::hint(&advice);
        }
    }
    Ok(exit_code::of_status(answer.status))
}
