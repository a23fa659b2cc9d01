//! The runs that a server knows: in memory those that it carries out, and others as the store has them.

use std::collections::{BTreeMap, HashMap};
use std::path::Path;
use std::sync::{Arc, MutexGuard, PoisonError};

use longstep_core::execution::Event;
use longstep_robot::{RunHeader, RunLog};

use crate::hosted::{EndedRun, Hosted};
use crate::hub::Hub;
use crate::id::{RunId, SessionId};
use crate::problem::Problem;
use crate::run::{EndView, HostedRun, RunRecord, RunState, RunView};
use crate::store::{LogName, RecordKey, StoredRun};

/// The most runs that are read from the store for a list.
const LISTED: usize = 500;

/// The most runs in memory; of more, those that ended and are there for the longest time leave it.
const RESIDENT: usize = 1_000;

impl Hub {
    pub(crate) fn hosted_runs(&self) -> MutexGuard<'_, HashMap<RunId, Arc<HostedRun>>> {
        self.runs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Keeps a run in memory.
    pub(crate) fn keep_run(&self, run: Arc<HostedRun>) {
        let mut runs = self.hosted_runs();
        while runs.len() >= RESIDENT {
            let ended = runs.values().filter(|run| run.view().state.is_ended());
            let Some(id) = ended.min_by_key(|run| run.since()).map(|run| run.record().id.clone()) else {
                break;
            };
            runs.remove(&id);
        }
        runs.insert(run.record().id.clone(), run);
    }

    /// Returns the runs that this server carries out.
    pub(crate) fn going_here(&self) -> Vec<Arc<HostedRun>> {
        let runs = self.hosted_runs();
        let going = runs.values().filter(|run| !run.view().state.is_ended());
        going.cloned().collect()
    }

    /// Returns a run from memory, or as the store has it.
    pub(crate) fn hosted_run(&self, id: &RunId) -> Result<Arc<HostedRun>, Problem> {
        let found = self.hosted_runs().get(id).cloned();
        let log = LogName::Run(id.clone());
        if let Some(run) = found {
            let is_known = !self.store.is_shared() || !run.view().state.is_ended();
            if is_known || is_current(&run, self.store.state(&log)?.map(|state| state.epoch)) {
                return Ok(run);
            }
        }
        let missing = || Problem::missing("run", id);
        let record = self.store.record(&RecordKey::Run(id.clone()))?.ok_or_else(missing)?;
        let stored = StoredRun {
            record,
            state: self.store.state(&log)?.ok_or_else(missing)?,
            last: self.store.tail(&log, 1)?.pop(),
        };
        self.stored(&stored).ok_or_else(missing)
    }

    /// Returns a run of the store; none if a newer program wrote it.
    pub(crate) fn stored(&self, stored: &StoredRun) -> Option<Arc<HostedRun>> {
        let record: RunRecord = serde_json::from_str(&stored.record).ok()?;
        let (state, end) = end_of(stored.last.as_deref(), stored.state.is_owned);
        let run = HostedRun::shown(record, Arc::clone(&self.feed), stored.state.epoch, state, end);
        Some(Arc::new(run))
    }

    /// Returns a run as it is now. Waits for nothing but the store.
    ///
    /// # Errors
    ///
    /// There is none with this id.
    pub fn run(&self, id: &RunId) -> Result<Arc<RunView>, Problem> {
        Ok(self.hosted_run(id)?.view())
    }

    /// Returns the runs, in the order of their ids: those of this server, those that other servers carry out, and the
    /// latest ones that have ended, at most 500 from the store. If the store fails, those of this server.
    pub fn runs(&self) -> Vec<Arc<RunView>> {
        let mut runs: BTreeMap<RunId, Arc<RunView>> = BTreeMap::new();
        for stored in self.listed() {
            let Some(run) = self.stored(&stored) else { continue };
            let id = run.record().id.clone();
            let own = self.hosted_runs().get(&id).cloned();
            let own = own.filter(|own| !own.view().state.is_ended() || is_current(own, Some(stored.state.epoch)));
            runs.insert(id, own.unwrap_or(run).view());
        }
        for (id, run) in &*self.hosted_runs() {
            runs.entry(id.clone()).or_insert_with(|| run.view());
        }
        runs.into_values().collect()
    }

    /// Returns the latest runs of a store that servers share. Nobody else adds to another one: its runs are read once, and
    /// are in memory from then on.
    fn listed(&self) -> Vec<StoredRun> {
        let is_read = self.are_runs_read.get().is_some();
        let listed = if is_read {
            Ok(Vec::new())
        } else {
            self.store.runs(LISTED)
        };
        let Ok(listed) = listed else { return Vec::new() };
        if self.store.is_shared() {
            return listed;
        }
        for run in listed.iter().filter_map(|stored| self.stored(stored)) {
            self.hosted_runs().entry(run.record().id.clone()).or_insert(run);
        }
        // Of two readers at once, either has read all.
        let _ = self.are_runs_read.set(());
        Vec::new()
    }

    /// Returns an error while a robot of this server carries out a plan of a session. Another server that does so owns the
    /// session.
    pub(crate) fn refuse_during_run(&self, id: &SessionId) -> Result<(), Problem> {
        if self.going_here().iter().any(|run| run.record().session == *id) {
            return Err(
                Problem::conflict("a robot carries out a plan of this session").hint("wait for the run, or stop it")
            );
        }
        Ok(())
    }

    /// Reads the log of a run.
    pub(crate) fn run_log(&self, id: &RunId) -> Result<(RunHeader, Vec<Event>), Problem> {
        let bytes = self.store.read(&LogName::Run(id.clone()))?.unwrap_or_default();
        let text = String::from_utf8_lossy(&bytes);
        let read = RunLog::parse(Path::new(id.as_str()), &text);
        read.map_err(|error| Problem::conflict(format!("the log of the run cannot be read: {error}")))
    }

    /// Writes the record of a run, and its place among the runs of its plan.
    pub(crate) fn keep_record(&self, record: &RunRecord) -> Result<(), Problem> {
        let text = serde_json::to_string(record).unwrap_or_default();
        self.store.insert(&RecordKey::Run(record.id.clone()), &text)?;
        let mut attempt = 0;
        while !self.store.insert(&attempt_of(record, attempt), record.id.as_str())? {
            attempt += 1;
        }
        Ok(())
    }

    /// Gives a session that was read from its log the end of a run that it has not taken before a server ended.
    pub(crate) fn settle_runs(&self, hosted: &Hosted) -> Result<(), Problem> {
        let snapshot = hosted.snapshot();
        let Some(next) = snapshot.view.accepted.iter().find(|accepted| accepted.pending) else {
            return Ok(());
        };
        for attempt in 0.. {
            let key = RecordKey::Attempt {
                session: snapshot.view.id.clone(),
                number: next.number,
                attempt,
            };
            let Some(id) = self.store.record(&key)? else {
                return Ok(());
            };
            let Some(statements) = self.reached(&id, &next.plan)? else {
                continue;
            };
            return hosted.run_ended(EndedRun {
                number: next.number,
                is_reached: true,
                statements,
            });
        }
        Ok(())
    }

    /// Returns the last observation of a run that has reached the goal of a plan.
    fn reached(&self, id: &str, plan: &str) -> Result<Option<longstep_core::environment::Observation>, Problem> {
        let Some(id) = RunId::parse(id) else { return Ok(None) };
        let record = self.store.record(&RecordKey::Run(id.clone()))?;
        let record = record.and_then(|text| serde_json::from_str::<RunRecord>(&text).ok());
        let last = self.store.tail(&LogName::Run(id.clone()), 1)?.pop();
        let is_done = end_of(last.as_deref(), false).0 == RunState::Done;
        if !is_done || record.is_none_or(|record| record.plan != plan) {
            return Ok(None);
        }
        let (header, events) = self.run_log(&id)?;
        Ok(events.into_iter().rev().find_map(|event| match event {
            Event::Observed { statements } if !header.dry_run => Some(statements),
            _ => None,
        }))
    }
}

fn attempt_of(record: &RunRecord, attempt: usize) -> RecordKey {
    RecordKey::Attempt {
        session: record.session.clone(),
        number: record.number,
        attempt,
    }
}

/// Returns true if nobody has owned the log of a run since this server did.
fn is_current(run: &HostedRun, epoch: Option<u64>) -> bool {
    !run.is_lost() && epoch == Some(run.epoch())
}

/// Returns the state of a run by the last line of its log. The log of one that goes on has an owner.
fn end_of(last: Option<&str>, is_owned: bool) -> (RunState, Option<EndView>) {
    // A log that has its header alone is one of a run that has not begun.
    let last = last.filter(|line| serde_json::from_str::<RunHeader>(line).is_err());
    let event = last.map(|line| serde_json::from_str::<Event>(line).ok());
    let end = |done, text: &str, resumable| EndView {
        done,
        text: text.to_owned(),
        resumable,
    };
    match (event, is_owned) {
        (Some(Some(Event::Done { .. })), _) => {
            let end = end(true, "the goal is reached in the observed world", false);
            (RunState::Done, Some(end))
        }
        (Some(Some(Event::Stopped { why, .. })), _) => (RunState::Stopped, Some(end(false, &why, true))),
        (None, true) => (RunState::Queued, None),
        (None, false) => {
            let end = end(false, "its server ended before it began; nothing has moved", false);
            (RunState::Stopped, Some(end))
        }
        (Some(Some(Event::Paused)), true) => (RunState::Paused, None),
        (Some(_), true) => (RunState::Running, None),
        (Some(_), false) => (RunState::Interrupted, None),
    }
}
