//! All units of a run, sequentially or in parallel.

use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, mpsc};
use std::time::Duration;

use longstep::domain::Domain;
use longstep::session::Settings;
use longstep_llm::{AdvanceError, ModelError, Progress, Watch};

use crate::attempt::Key;
use crate::queue::{Next, Open, Queue, Turn};
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

/// The time until units are looked at again that other programs run.
const PAUSE: Duration = Duration::from_millis(250);

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
    /// Runs units, and takes from the queue what other programs ran. `done` receives the lines of each unit in the order
    /// of the units; an error of `done` ends the run.
    ///
    /// # Errors
    ///
    /// The first error of a model or of the queue, or the error of `done`. Lines that `done` received before are valid.
    pub fn run<Q: Queue, E: From<AdvanceError> + From<Q::Error> + Send>(
        &self,
        units: &[Unit<'_>],
        queue: &Q,
        source: &(dyn Fn() -> Box<dyn Source> + Sync),
        stop: &AtomicBool,
        tell: &(dyn Fn(Progress) + Sync),
        mut done: impl FnMut(Lines) -> Result<(), E>,
    ) -> Result<(), E> {
        let work = Work {
            campaign: self,
            units,
            queue,
            open: Open::new(units.len()),
            stop,
            tell,
        };
        let halted = AtomicBool::new(false);
        std::thread::scope(|scope| {
            let (sender, receiver) = mpsc::channel();
            for _ in 0..self.jobs.clamp(1, units.len().max(1)) {
                let (sender, work, halted) = (sender.clone(), &work, &halted);
                scope.spawn(move || {
                    let mut source = source();
                    while !halted.load(Ordering::Relaxed) {
                        let number = match work.open.next() {
                            Next::Unit(number) => number,
                            Next::Wait => {
                                std::thread::sleep(PAUSE);
                                work.open.look_again();
                                continue;
                            }
                            Next::End => return,
                        };
                        let lines = work.turn(number, source.as_mut());
                        let failed = lines.is_err();
                        let Some(lines) = lines.transpose() else { continue };
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
                    Err(error) if outcome.is_ok() => outcome = Err(error),
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
}

/// The state that the workers of one program share.
struct Work<'a, Q> {
    campaign: &'a Campaign<'a>,
    units: &'a [Unit<'a>],
    queue: &'a Q,
    open: Open,
    stop: &'a AtomicBool,
    tell: &'a (dyn Fn(Progress) + Sync),
}

impl<Q: Queue> Work<'_, Q> {
    /// Runs a unit, or takes its lines from the queue; none if another program runs it.
    fn turn<E>(&self, number: usize, source: &mut dyn Source) -> Result<Option<Lines>, E>
    where
        E: From<AdvanceError> + From<Q::Error>,
    {
        if self.stop.load(Ordering::Relaxed) {
            return Err(AdvanceError::from(ModelError::Stopped).into());
        }
        let _right = match self.queue.turn(number)? {
            Turn::Mine(right) => right,
            Turn::Elsewhere => {
                self.open.put_aside(number);
                return Ok(None);
            }
            Turn::Done(lines) => return Ok(Some(lines)),
        };
        let lines = self.unit(self.units[number], source)?;
        self.open.look_again();
        Ok(Some(self.queue.keep(number, lines)?))
    }

    fn unit(&self, unit: Unit<'_>, source: &mut dyn Source) -> Result<Lines, AdvanceError> {
        let mut settings = self.campaign.settings;
        if let Some(rounds) = source.rounds(&unit.case.id, unit.trial) {
            settings.rounds = settings.rounds.min(rounds);
        }
        let model = source.model(&unit.case.id, unit.trial)?;
        let mut watch = Stopping {
            stop: self.stop,
            tell: self.tell,
        };
        run(
            self.campaign.suite,
            &self.campaign.domain,
            unit,
            settings,
            model,
            &mut watch,
        )
    }
}
