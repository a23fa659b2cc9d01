//! The queue of a run that several programs share, in a database.

use std::fmt::Display;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use anyhow::{Error, Result};
use longstep_eval::attempt::Key;
use longstep_eval::folder::Plan;
use longstep_eval::run::Lines;
use longstep_eval::{Queue, Turn, kept_text, read_kept};
use longstep_llm::{AdvanceError, ModelError};
use longstep_server::{CampaignId, LogName, OwnedLog, RecordKey, Store, StoreError, UnitKey};

use crate::failure::{Failure, MODEL};
use crate::hub;

/// The time for which a database may be away.
const PATIENCE: Duration = Duration::from_secs(60);

/// The time between two tries.
const PAUSE: Duration = Duration::from_secs(1);

/// A run in a database. It is known by what its results depend on, so programs with the same arguments share it.
pub(super) struct SharedQueue<'a> {
    store: Arc<dyn Store>,
    campaign: CampaignId,
    units: &'a [(Key, usize)],
    /// The number of units that the folder has.
    done: usize,
    stop: &'a AtomicBool,
}

impl<'a> SharedQueue<'a> {
    /// Connects to the database of an address. `units` contains the number of steps of each unit, in order, with the key of its
    /// first step.
    pub(super) fn open(address: &str, plan: &Plan, units: &'a [(Key, usize)], stop: &'a AtomicBool) -> Result<Self> {
        // Each program may reach the model at an address of its own.
        let plan = Plan {
            server: None,
            ..plan.clone()
        };
        Ok(Self {
            store: hub::database(address)?,
            campaign: CampaignId::of(&serde_json::to_value(plan)?),
            units,
            done: 0,
            stop,
        })
    }

    /// Hands over what the folder has: the lines of the first units, each with its steps. They are the same in all folders of a
    /// run.
    pub(super) fn with_done(mut self, done: Vec<Lines>) -> Result<Self> {
        for (number, lines) in done.into_iter().enumerate() {
            let attempts = |lines: &Lines| lines.iter().map(|(attempt, _)| attempt.clone()).collect::<Vec<_>>();
            let own = attempts(&lines);
            if attempts(&self.keep(0, lines)?) != own {
                let message = format!("{} has another result in the queue than in the folder", self.name(0));
                return Err(Failure::unreadable(message)
                    .hint("begin with a new folder, which gets the results of the queue: `--out FOLDER`")
                    .into());
            }
            self.done = number + 1;
        }
        Ok(self)
    }

    fn key(&self, number: usize) -> UnitKey {
        UnitKey {
            campaign: self.campaign.clone(),
            number: self.done + number,
        }
    }

    /// Names a unit for a person.
    fn name(&self, number: usize) -> impl Display {
        let key = &self.units[self.done + number].0;
        format!("`{}` (wording `{}`, trial {})", key.case, key.wording, key.trial)
    }

    /// Tries again while the database is away.
    fn patiently<T>(&self, mut ask: impl FnMut() -> Result<T, StoreError>) -> Result<T> {
        let began = Instant::now();
        loop {
            match ask() {
                Err(StoreError::Database { .. }) if began.elapsed() < PATIENCE => std::thread::sleep(PAUSE),
                Err(error) => {
                    return Err(Failure::new(error.to_string(), MODEL)
                        .hint("run the same command again to resume")
                        .into());
                }
                Ok(value) => return Ok(value),
            }
            if self.stop.load(Ordering::Relaxed) {
                return Err(AdvanceError::from(ModelError::Stopped).into());
            }
        }
    }

    /// Returns the lines of a unit that was run.
    fn kept(&self, number: usize) -> Result<Option<Lines>> {
        let key = RecordKey::Unit(self.key(number));
        let Some(text) = self.patiently(|| self.store.record(&key))? else {
            return Ok(None);
        };
        let damaged = |reason: &dyn Display| -> Error {
            Failure::unreadable(format!(
                "the result of {} in the queue cannot be read: {reason}",
                self.name(number)
            ))
            .hint("remove the record `unit` with this campaign from the database, or measure with another `--seed`")
            .into()
        };
        let lines = read_kept(&text).map_err(|error| damaged(&error))?;
        let (first, steps) = &self.units[self.done + number];
        let is_unit = lines.len() == *steps
            && lines.iter().enumerate().all(|(step, (attempt, timing))| {
                let wanted = Key { step, ..first.clone() };
                attempt.key == wanted && timing.key == wanted
            });
        if !is_unit {
            return Err(damaged(&"it is one of another unit"));
        }
        Ok(Some(lines))
    }
}

impl Queue for SharedQueue<'_> {
    type Right = Box<dyn OwnedLog>;
    type Error = Error;

    fn turn(&self, number: usize) -> Result<Turn<Self::Right>> {
        if let Some(lines) = self.kept(number)? {
            return Ok(Turn::Done(lines));
        }
        let name = LogName::Unit(self.key(number));
        let right = self.patiently(|| match self.store.own(&name) {
            Err(StoreError::Taken(_) | StoreError::Open(_)) => Ok(None),
            other => other.map(Some),
        })?;
        let Some(right) = right else {
            return Ok(Turn::Elsewhere);
        };
        // Somebody may have ended it in between.
        Ok(match self.kept(number)? {
            Some(lines) => Turn::Done(lines),
            None => Turn::Mine(right),
        })
    }

    fn keep(&self, number: usize, lines: Lines) -> Result<Lines> {
        let (key, text) = (RecordKey::Unit(self.key(number)), kept_text(&lines));
        if self.patiently(|| self.store.insert(&key, &text))? {
            return Ok(lines);
        }
        // A right that has ended does not end the work on the unit, so another one may have been first.
        Ok(self.kept(number)?.unwrap_or(lines))
    }
}
