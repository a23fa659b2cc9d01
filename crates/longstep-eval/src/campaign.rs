//! All units of a run, sequentially or in parallel.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, mpsc};

use longstep::domain::Domain;
use longstep::session::Settings;
use longstep_llm::{AdvanceError, ModelError, Progress, Watch};

use crate::attempt::Key;
use crate::run::{Lines, Unit, run};
use crate::source::Source;
use crate::suite::Suite;

/// The selection of cases, wordings and trials.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Choice {
    /// Cases with all of these tags; empty means all cases.
    pub tags: Vec<String>,
    /// Ids of cases; empty means all cases.
    pub cases: Vec<String>,
    /// Wordings; empty means all wordings of a case.
    pub wordings: Vec<String>,
    /// Number of trials, at least 1.
    pub trials: u32,
}

/// The units of a run, ordered by trial, because each trial may open a model of its own.
pub fn units<'a>(suite: &'a Suite, choice: &Choice) -> Vec<Unit<'a>> {
    let mut units = Vec::new();
    for trial in 1..=choice.trials.max(1) {
        for case in &suite.cases {
            let tagged = choice.tags.iter().all(|tag| case.tags.contains(tag));
            let named = choice.cases.is_empty() || choice.cases.contains(&case.id);
            if !tagged || !named {
                continue;
            }
            let mut wordings = case.wordings();
            wordings.retain(|wording| choice.wordings.is_empty() || choice.wordings.iter().any(|w| w == wording));
            units.extend(wordings.into_iter().map(|wording| Unit { case, wording, trial }));
        }
    }
    units
}

/// The key of the first step and the number of steps of each unit, for
/// [`RunFolder::open`](crate::folder::RunFolder::open).
pub fn lengths(units: &[Unit<'_>]) -> Vec<(Key, usize)> {
    let length = |unit: &Unit<'_>| {
        let key = Key {
            case: unit.case.id.clone(),
            step: 0,
            wording: unit.wording.to_owned(),
            trial: unit.trial,
        };
        (key, unit.case.steps.len())
    };
    units.iter().map(length).collect()
}

/// The common settings of all units.
#[derive(Debug, Clone)]
pub struct Campaign<'a> {
    /// The suite.
    pub suite: &'a Suite,
    /// Its domain.
    pub domain: Arc<Domain>,
    /// Settings of the sessions.
    pub settings: Settings,
    /// Number of units that run in parallel, at least 1. Each worker has a source of its own.
    pub jobs: usize,
}

/// A watch that cancels running calls when `stop` is set.
struct Stopping<'a> {
    stop: &'a AtomicBool,
    tell: &'a (dyn Fn(Progress) + Sync),
}

impl Watch for Stopping<'_> {
    fn tell(&mut self, progress: Progress) {
        (self.tell)(progress);
    }

    fn stop(&self) -> bool {
        self.stop.load(Ordering::Relaxed)
    }
}

impl Campaign<'_> {
    /// Runs units. `done` receives the lines of each unit in the order of the units; an error of `done` ends the run.
    ///
    /// # Errors
    ///
    /// The first error of a model, or the error of `done`. Lines that `done` received before are valid.
    pub fn run<E: From<AdvanceError>>(
        &self,
        units: &[Unit<'_>],
        source: &(dyn Fn() -> Box<dyn Source> + Sync),
        stop: &AtomicBool,
        tell: &(dyn Fn(Progress) + Sync),
        mut done: impl FnMut(Lines) -> Result<(), E>,
    ) -> Result<(), E> {
        let next = AtomicUsize::new(0);
        let halted = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            for _ in 0..self.jobs.clamp(1, units.len().max(1)) {
                let (sender, next, halted) = (sender.clone(), &next, &halted);
                scope.spawn(move || {
                    let mut source = source();
                    while !halted.load(Ordering::Relaxed) {
                        let number = next.fetch_add(1, Ordering::Relaxed);
                        let Some(unit) = units.get(number) else { return };
                        let lines = self.unit(*unit, source.as_mut(), stop, tell);
                        let failed = lines.is_err();
                        // After a failure the receiver is gone.
                        if sender.send((number, lines)).is_err() || failed {
                            return;
                        }
                    }
                });
            }
            drop(sender);
            let mut waiting: BTreeMap<usize, Lines> = BTreeMap::new();
            let mut written = 0;
            let mut outcome = Ok(());
            for (number, lines) in receiver {
                match lines {
                    Ok(lines) => {
                        waiting.insert(number, lines);
                    }
                    Err(error) if outcome.is_ok() => outcome = Err(E::from(error)),
                    Err(_) => {}
                }
                while let Some(lines) = waiting.remove(&written) {
                    written += 1;
                    if outcome.is_ok() {
                        outcome = done(lines);
                    }
                }
                if outcome.is_err() {
                    halted.store(true, Ordering::Relaxed);
                }
            }
            outcome
        })
    }

    fn unit(
        &self,
        unit: Unit<'_>,
        source: &mut dyn Source,
        stop: &AtomicBool,
        tell: &(dyn Fn(Progress) + Sync),
    ) -> Result<Lines, AdvanceError> {
        if stop.load(Ordering::Relaxed) {
            return Err(ModelError::Stopped.into());
        }
        let mut settings = self.settings;
        if let Some(rounds) = source.rounds(&unit.case.id, unit.trial) {
            settings.rounds = settings.rounds.min(rounds);
        }
        let model = source.model(&unit.case.id, unit.trial)?;
        let mut watch = Stopping { stop, tell };
        run(self.suite, &self.domain, unit, settings, model, &mut watch)
    }
}
