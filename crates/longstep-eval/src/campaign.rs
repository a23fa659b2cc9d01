//! All units of a run, one after the other or several at a time.

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

/// Which cases are run, in which words, and how often.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Choice {
    /// Cases with all of these tags; every case if there are none.
    pub tags: Vec<String>,
    /// These cases; every case if there are none.
    pub cases: Vec<String>,
    /// These wordings; all that a case has if there are none.
    pub wordings: Vec<String>,
    /// At least 1.
    pub trials: u32,
}

/// The units of a run, in order: trial by trial, since each may open a model of its own.
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

/// How many steps each unit has, with the key of its first: what [`RunFolder::open`](crate::folder::RunFolder::open)
/// has to know.
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

/// What all units share.
#[derive(Debug, Clone)]
pub struct Campaign<'a> {
    /// The suite.
    pub suite: &'a Suite,
    /// Its domain.
    pub domain: Arc<Domain>,
    /// How sessions go about it.
    pub settings: Settings,
    /// Units that run at the same time, at least 1. Each worker has a source of its own.
    pub jobs: usize,
}

/// Calls off what is under way.
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
    /// Runs units. `done` is given the lines of each in the order of the units, whichever came first; what it returns as
    /// an error ends the run.
    ///
    /// # Errors
    ///
    /// The first one of a model, or that of `done`. What was given to `done` before stays.
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
                        // Nobody listens any more once the run has failed.
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
