//! `longstep repair`: the least change that makes a plan valid.

use std::time::Instant;

use anyhow::Result;
use longstep::repair::Pins;

use crate::arguments::RepairArguments;
use crate::draft::Draft;
use crate::solve::{finish, milliseconds};

pub(crate) fn run(arguments: &RepairArguments) -> Result<u8> {
    let started = Instant::now();
    let Draft { domain, world, attempt } = Draft::read(&arguments.draft)?;
    let searching = Instant::now();
    let mut answer = match attempt.question() {
        Some(_) => attempt.verdict(&domain, &world),
        None => {
            let outcome = attempt.repair(&domain, &world, &Pins::default());
            let search = milliseconds(searching);
            let verifying = Instant::now();
            let mut answer = attempt.repaired(&domain, &world, outcome);
            answer.timings_ms.verify = milliseconds(verifying);
            answer.timings_ms.search = search;
            answer
        }
    };
    answer.timings_ms.total = milliseconds(started);
    finish(&answer, &[], &[], arguments.save.as_deref(), arguments.json)
}
