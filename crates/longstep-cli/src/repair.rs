//! `longstep repair`: the cheapest change that makes a plan valid.

use std::time::Instant;

use anyhow::Result;

use crate::arguments::RepairArguments;
use crate::clock::milliseconds;
use crate::draft::Draft;
use crate::solve::finish;

pub(crate) fn run(arguments: &RepairArguments) -> Result<u8> {
    let started = Instant::now();
    let draft = Draft::read(&arguments.draft)?;
    let assessment = draft.assessment();
    let searching = Instant::now();
    let mut answer = match assessment.question() {
        Some(_) => assessment.verdict(),
        None => {
            assessment.repair();
            let search = milliseconds(searching);
            let verifying = Instant::now();
            let mut answer = assessment.repaired();
            answer.timings_ms.verify = milliseconds(verifying);
            answer.timings_ms.search = search;
            answer
        }
    };
    answer.timings_ms.total = milliseconds(started);
    let save = arguments.save.as_deref().map(|path| (path, &**draft.world.domain()));
    finish(&answer, &[], &[], save, arguments.json)
}
