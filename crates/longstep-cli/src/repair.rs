//! `longstep repair`: the least change that makes a plan valid.

use std::time::Instant;

use anyhow::Result;
use longstep::answer::{Answer, EditAnswer, Status};
use longstep::repair::Outcome;

use crate::arguments::RepairArguments;
use crate::draft::Draft;
use crate::solve::{finish, milliseconds};

pub(crate) fn run(arguments: &RepairArguments) -> Result<u8> {
    let started = Instant::now();
    let draft = Draft::read(&arguments.draft)?;
    let mut answer = match draft.question() {
        Some(question) => question,
        None => answer(&draft),
    };
    answer.timings_ms.total = milliseconds(started);
    finish(&answer, &[], &[], arguments.save.as_deref(), arguments.json)
}

fn answer(draft: &Draft) -> Answer {
    let searching = Instant::now();
    let outcome = draft.repair();
    let search = milliseconds(searching);
    let verifying = Instant::now();
    let mut answer = match outcome {
        Outcome::Valid(_) => draft.verdict(),
        Outcome::Repaired(repaired) => {
            let mut answer = draft.answer(repaired.plan.report(), &[]);
            answer.edits = repaired.edits.iter().map(EditAnswer::from).collect();
            if !repaired.cheapest {
                let note = "a smaller change may exist: the search for it was cut short";
                answer.notes.push(note.to_owned());
            }
            // What is wrong with a step shows as an edit; the rest was put right without one.
            let whole = draft.resolved.issues.iter().filter(|issue| issue.step().is_none());
            let told = whole.map(|issue| issue.message(&draft.domain, &draft.world, &[], None));
            answer.notes.extend(told);
            let given_up = draft.given_up(&repaired).into_iter();
            answer
                .notes
                .extend(given_up.map(|fact| format!("claimed and given up: {fact}")));
            answer
        }
        Outcome::Unclear { why } => {
            let mut answer = draft.verdict();
            answer
                .notes
                .push(format!("not repaired, since that would be guessing: {why}"));
            answer
        }
        Outcome::ProvenUnsolvable { .. } => {
            let mut answer = draft.verdict();
            answer.status = Status::Unsolvable;
            answer
        }
        Outcome::GaveUp { why, .. } => {
            let mut answer = draft.verdict();
            answer.status = Status::GaveUp;
            answer.notes.push(why);
            answer
        }
    };
    answer.timings_ms.verify = milliseconds(verifying);
    answer.timings_ms.search = search;
    answer
}
