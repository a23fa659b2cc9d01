//! The measures of a run.
//!
//! Each is defined here once; `docs/evaluation.md` says the same to users. Rates are of the attempts that they can be
//! asked of, and carry a 95 % interval ([`Rate::interval`]).

use std::collections::BTreeMap;

use serde::Serialize;

use crate::attempt::{Attempt, Key, Timing};
use crate::failure::Failure;
use crate::rate::Rate;

/// The measures of some attempts.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Summary {
    /// What was expected came of it, of all.
    pub correct: Rate,
    /// The same, of those that expect a plan.
    pub plans_correct: Rate,
    /// A plan came that can be carried out, of those that expect one.
    pub executable: Rate,
    /// The model's first word was such a plan, without repair or a round.
    pub first_shot: Rate,
    /// After so many rounds at most, without repair; as many as the attempt with the most rounds needed, and one more.
    pub after_rounds: Vec<Rate>,
    /// Asked or refused where that was expected.
    pub asked_rightly: Rate,
    /// Asked where a plan was expected.
    pub asked_needlessly: Rate,
    /// All steps correct, of the chains (cases of more than one step).
    pub chains: Rate,
    /// The model's claim of the environment afterwards was the simulated one, of those that claimed one.
    pub claims_right: Rate,
    /// Edits for each plan, on average.
    pub edits: f64,
    /// How many attempts went wrong in each way, in the order of [`Failure::ALL`]; ways that did not occur are missing.
    pub failures: Vec<(Failure, usize)>,
    /// What a model was asked, for each attempt.
    pub cost: Cost,
}

/// What attempts cost: medians, and sums where they are said to be.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Cost {
    /// Calls, all together.
    pub calls: u64,
    /// Tokens of the prompts of an attempt.
    pub prompt_tokens: u64,
    /// Tokens of its answers.
    pub completion_tokens: u64,
    /// Of the prompt tokens, how many needed no computation.
    pub cached_tokens: u64,
    /// Milliseconds in which the model was at work.
    pub model_ms: f64,
    /// From the instruction to what came of it, in milliseconds.
    pub total_ms: f64,
    /// The same, all together, in seconds.
    pub sum_seconds: f64,
}

impl Summary {
    /// The measures of attempts and of what they took.
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
            asked_needlessly: Rate::count(plans(), |attempt| attempt.asked()),
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

/// The median; 0 of nothing.
fn median(values: impl Iterator<Item = f64>) -> f64 {
    let mut values: Vec<f64> = values.collect();
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied().unwrap_or(0.0)
}
