//! A run of the paper's scenarios beside the paper's own figures.

use super::words::several;
use crate::attempt::Attempt;
use crate::folder::Results;
use crate::rate::Rate;
use crate::suite::paper::{ROUNDS, TRIALS};
use crate::summary::Summary;

/// Executable without feedback: five of fourteen scenarios, each in all of five trials.
pub(super) const WITHOUT_FEEDBACK: Rate = Rate { hits: 5, of: 14 };

/// Executable after feedback.
pub(super) const AFTER_FEEDBACK: Rate = Rate { hits: 14, of: 14 };

/// Whether this is a run of the paper's scenarios.
pub(super) fn is_paper(results: &Results) -> bool {
    results.plan.suite == "paper"
}

/// Whether a model was told what was wrong, at least once.
pub(super) fn has_rounds(results: &Results) -> bool {
    results.attempts.iter().any(|attempt| attempt.rounds > 0)
}

/// How many of the paper's five trials with a scenario came out right.
pub(super) fn trials(case: &str) -> Option<u8> {
    TRIALS.get(place(case)?).copied()
}

/// What the paper's row in the table of trials is called. It is about what came before any feedback.
pub(super) fn first_row(results: &Results) -> &'static str {
    match has_rounds(results) {
        true => "The paper, at first",
        false => "The paper",
    }
}

/// How many rounds the paper's model needed for a scenario.
pub(super) fn rounds(case: &str) -> Option<u32> {
    ROUNDS.get(place(case)?).copied()
}

/// Scenarios are numbered from 1.
fn place(case: &str) -> Option<usize> {
    case.parse::<usize>().ok()?.checked_sub(1)
}

/// Shares with what they are of: the paper's, and this run's.
pub(super) fn shares(results: &Results, summary: &Summary) -> Vec<(String, Rate, bool)> {
    let mut shares = vec![
        ("The paper, without feedback".to_owned(), WITHOUT_FEEDBACK, false),
        ("This run, first shot".to_owned(), summary.first_shot, true),
    ];
    if has_rounds(results) {
        shares.push(("The paper, after feedback".to_owned(), AFTER_FEEDBACK, false));
        for (rounds, rate) in summary.after_rounds.iter().enumerate().skip(1) {
            let rounds = several(rounds as u64, "round");
            shares.push((format!("This run, after {rounds}"), *rate, true));
        }
    }
    // Only repair can make more plans executable than rounds did.
    if Some(&summary.executable) != summary.after_rounds.last() {
        shares.push(("This run, with repair".to_owned(), summary.executable, true));
    }
    shares
}

/// How far the verifier says of the paper's own replies what the paper says of them.
pub(super) struct Agreement {
    pub(super) agree: usize,
    pub(super) of: usize,
    /// What is compared: a cell of the table of trials, or an entry of the table of rounds.
    pub(super) what: &'static str,
    /// The attempts that do not agree.
    pub(super) differing: Vec<String>,
}

impl Agreement {
    pub(super) fn sentence(&self) -> String {
        let mut text = format!("{} of {} {} agree with the paper", self.agree, self.of, self.what);
        if !self.differing.is_empty() {
            text += &format!("; not {}", self.differing.join("; "));
        }
        text
    }
}

/// The agreement, for recorded replies. Of any other model the paper says nothing.
pub(super) fn agreement(results: &Results) -> Option<Agreement> {
    if !is_paper(results) || !results.plan.model.contains("recorded replies") {
        return None;
    }
    let rounds_matter = has_rounds(results);
    let agrees = |attempt: &Attempt| {
        let case = &attempt.key.case;
        match rounds_matter {
            true => Some(attempt.executable && attempt.rounds == rounds(case)?),
            false => Some(attempt.executable == (trials(case)? == 5)),
        }
    };
    let known = results
        .attempts
        .iter()
        .filter_map(|attempt| Some((attempt, agrees(attempt)?)));
    let (mut agree, mut of, mut differing) = (0, 0, Vec::new());
    for (attempt, agrees) in known {
        of += 1;
        match agrees {
            true => agree += 1,
            false => differing.push(super::label(results, attempt)),
        }
    }
    Some(Agreement {
        agree,
        of,
        what: if rounds_matter { "entries" } else { "cells" },
        differing,
    })
}
