//! The measures of a run.
//!
//! They are defined here; `docs/guide/evaluation.md` documents them for users. Rates have a 95 % confidence interval
//! ([`Rate::interval`]).

use std::collections::BTreeMap;

use serde::Serialize;

use crate::attempt::{Attempt, Key, Timing};
use crate::failure::Failure;
use crate::rate::Rate;

/// The measures of some attempts.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Summary {
    /// Attempts with the expected result.
    pub correct: Rate,
    /// Attempts with the expected result, of those that expect a plan.
    pub plans_correct: Rate,
    /// Attempts with an executable plan, of those that expect one.
    pub executable: Rate,
    /// Attempts whose first reply is an executable plan, without feedback or repair.
    pub first_shot: Rate,
    /// Executable plans without repair after at most 0, 1, 2, ... rounds of feedback, up to the largest number of
    /// rounds that an attempt needed.
    pub after_rounds: Vec<Rate>,
    /// Attempts with a question or refusal where that was expected.
    pub asked_rightly: Rate,
    /// Attempts with a question where a plan was expected.
    pub asked_needlessly: Rate,
    /// Chains (cases of more than one step) in which all steps are correct.
    pub chains: Rate,
    /// Attempts whose claimed environment equals the simulated one, of those with a claim.
    pub claims_right: Rate,
    /// Mean number of edits per plan.
    pub edits: f64,
    /// Number of attempts with each kind of failure, in the order of [`Failure::ALL`]; kinds that do not occur are
    /// omitted.
    pub failures: Vec<(Failure, usize)>,
    /// The cost of the attempts.
    pub cost: Cost,
}

/// The cost of attempts: medians, except for totals.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Cost {
    /// Total number of model calls.
    pub calls: u64,
    /// Prompt tokens of an attempt.
    pub prompt_tokens: u64,
    /// Answer tokens of an attempt.
    pub completion_tokens: u64,
    /// Prompt tokens from the prefix cache.
    pub cached_tokens: u64,
    /// Milliseconds in the model.
    pub model_ms: f64,
    /// Milliseconds from the instruction to the result.
    pub total_ms: f64,
    /// Total time in seconds.
    pub sum_seconds: f64,
}

impl Summary {
    /// The measures of attempts and their timings.
    pub fn of<'a>(attempts: impl IntoIterator<Item = &'a Attempt>, timings: &BTreeMap<Key, Timing>) -> Self {
        let all: Vec<&Attempt> = attempts.into_iter().collect();
        let plans = || all.iter().filter(|attempt| attempt.wants_plan());
        let asks = || all.iter().filter(|attempt| !attempt.wants_plan());
        let unaided = |attempt: &Attempt| attempt.executable && attempt.edits.is_empty();
        let rounds = plans()
            .filter(|a| unaided(a))
            .map(|attempt| attempt.rounds)
            .max()
            .unwrap_or(0);
        let with_plan = all.iter().filter(|attempt| attempt.executable).count();
        let edits: usize = all
            .iter()
            .filter(|a| a.executable)
            .map(|attempt| attempt.edits.len())
            .sum();
        let failures = Failure::ALL.iter().map(|kind| {
            let count = all.iter().filter(|attempt| attempt.failures.contains(kind)).count();
            (*kind, count)
        });
        Self {
            correct: Rate::count(&all, |attempt| attempt.correct),
            plans_correct: Rate::count(plans(), |attempt| attempt.correct),
            executable: Rate::count(plans(), |attempt| attempt.executable),
            first_shot: Rate::count(plans(), |attempt| attempt.is_first_shot()),
            after_rounds: (0..=rounds)
                .map(|most| Rate::count(plans(), |attempt| unaided(attempt) && attempt.rounds <= most))
                .collect(),
            asked_rightly: Rate::count(asks(), |attempt| attempt.correct),
            asked_needlessly: Rate::count(plans(), |attempt| attempt.is_question()),
            chains: chains(&all),
            claims_right: Rate::count(all.iter().filter_map(|attempt| attempt.claim_right), |right| *right),
            edits: edits as f64 / with_plan.max(1) as f64,
            failures: failures.filter(|(_, count)| *count > 0).collect(),
            cost: Cost::of(&all, timings),
        }
    }
}

fn chains(all: &[&Attempt]) -> Rate {
    let mut chains: BTreeMap<(&str, &str, u32), Vec<bool>> = BTreeMap::new();
    for attempt in all {
        let key = &attempt.key;
        let chain = chains.entry((&key.case, &key.wording, key.trial)).or_default();
        chain.push(attempt.correct);
    }
    let long = chains.values().filter(|steps| steps.len() > 1);
    Rate::count(long, |steps| steps.iter().all(|right| *right))
}

impl Cost {
    fn of(all: &[&Attempt], timings: &BTreeMap<Key, Timing>) -> Self {
        let timed: Vec<&Timing> = all.iter().filter_map(|attempt| timings.get(&attempt.key)).collect();
        let total: f64 = timed.iter().map(|timing| timing.total_ms).sum();
        Self {
            calls: all.iter().map(|attempt| u64::from(attempt.calls)).sum(),
            prompt_tokens: median(all.iter().map(|attempt| attempt.prompt_tokens as f64)) as u64,
            completion_tokens: median(all.iter().map(|attempt| attempt.completion_tokens as f64)) as u64,
            cached_tokens: median(timed.iter().map(|timing| timing.cached_tokens as f64)) as u64,
            model_ms: median(timed.iter().map(|timing| timing.model_ms)),
            total_ms: median(timed.iter().map(|timing| timing.total_ms)),
            sum_seconds: total / 1000.0,
        }
    }
}

/// The median; 0 without values.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
