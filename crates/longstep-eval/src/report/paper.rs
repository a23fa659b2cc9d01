//! A run of the paper's scenarios, compared with the paper's figures.

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

/// Returns true for a run of the paper's scenarios.
pub(super) fn is_paper(results: &Results) -> bool {
    results.plan.suite == "paper"
}

/// Returns true if at least one attempt had feedback.
pub(super) fn has_rounds(results: &Results) -> bool {
    results.attempts.iter().any(|attempt| attempt.rounds > 0)
}

/// The number of the paper's five trials of a scenario that were correct.
pub(super) fn trials(case: &str) -> Option<u8> {
    TRIALS.get(place(case)?).copied()
}

/// The name of the paper's row in the table of trials, which is about plans before any feedback.
pub(super) fn first_row(results: &Results) -> &'static str {
    if has_rounds(results) {
        "The paper, at first"
    } else {
        "The paper"
    }
}

/// The number of rounds that the paper's model needed for a scenario.
pub(super) fn rounds(case: &str) -> Option<u32> {
    ROUNDS.get(place(case)?).copied()
}

/// Scenarios are numbered from 1.
fn place(case: &str) -> Option<usize> {
    case.parse::<usize>().ok()?.checked_sub(1)
}

/// Shares of the paper and of this run, with their names; `true` marks those of this run.
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

/// Agreement of the verifier with the paper's judgement of the paper's own replies.
pub(super) struct Agreement {
    pub(super) agree: usize,
    pub(super) of: usize,
    /// The unit of comparison: a cell of the table of trials, or an entry of the table of rounds.
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

/// The agreement, for recorded replies. The paper has no judgement of other models.
pub(super) fn agreement(results: &Results) -> Option<Agreement> {
    if !is_paper(results) || !results.plan.model.contains("recorded replies") {
        return None;
    }
    let rounds_matter = has_rounds(results);
    let agrees = |attempt: &Attempt| {
        let case = &attempt.key.case;
        if rounds_matter {
            Some(attempt.executable && attempt.rounds == rounds(case)?)
        } else {
            Some(attempt.executable == (trials(case)? == 5))
        }
    };
    let known = results
        .attempts
        .iter()
        .filter_map(|attempt| Some((attempt, agrees(attempt)?)));
    let (mut agree, mut of, mut differing) = (0, 0, Vec::new());
    for (attempt, agrees) in known {
        of += 1;
        if agrees {
            agree += 1
        } else {
            differing.push(super::label(results, attempt))
        }
    }
    Some(Agreement {
        agree,
        of,
        what: if rounds_matter { "entries" } else { "cells" },
        differing,
    })
}
