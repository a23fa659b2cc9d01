//! Servers beside this one: rights that are lost to them, and stops from one to another.

use std::sync::{Arc, Weak};
use std::thread;
use std::time::{Duration, Instant};

use crate::audit::Deed;
use crate::hub::Hub;
use crate::id::RunId;
use crate::problem::Problem;
use crate::store::{RecordKey, StoreError};

/// The time between two looks for rights that were lost, which are known without the store.
const RIGHTS: Duration = Duration::from_millis(50);

/// The time between two looks for stops.
const STOPS: Duration = Duration::from_millis(200);

/// The most runs of other servers that are stopped at once.
const STOPPED: usize = 1_000;

/// The text of a run whose right was lost.
const LOST: &str = "this server lost the right to the run, and stopped the robot; look at the run again";

impl Hub {
    /// Watches the runs of this server until it ends.
    pub(crate) fn keep_watch(self: &Arc<Self>) {
        // Apart: a store that does not answer must not keep a robot going.
        let (rights, stops) = (Arc::downgrade(self), Arc::downgrade(self));
        thread::spawn(move || every(&rights, RIGHTS, Self::stop_lost));
        thread::spawn(move || every(&stops, STOPS, Self::take_stops));
    }

    /// Stops the robots of runs to which this server has lost a right.
    fn stop_lost(&self) {
        for run in self.going_here() {
            if run.is_lost() && !run.control().is_stop_requested() {
                run.control().stop();
                run.update(|view| view.notices.push(LOST.to_owned()));
            }
        }
    }

    /// Stops the runs for which another server has got a stop.
    fn take_stops(&self) {
        let going = self.going_here();
        for run in going.iter().filter(|run| !run.control().is_stop_requested()) {
            let key = stop_of(&run.record().id, run.epoch());
            if self.store.record(&key).is_ok_and(|stop| stop.is_some()) {
                run.control().stop();
            }
        }
    }

    /// Stops a run of another server: that one looks for stops all the time.
    pub(crate) fn stop_elsewhere(&self, run: &RunId, epoch: u64) -> Result<(), StoreError> {
        self.store.insert(&stop_of(run, epoch), "stop").map(drop)
    }

    /// Stops all runs of other servers; returns their number.
    pub(crate) fn stop_all_elsewhere(&self) -> Result<usize, Problem> {
        if !self.store.is_shared() {
            return Ok(0);
        }
        let mut count = 0;
        for stored in self.store.runs(STOPPED)? {
            let Some(run) = self.stored(&stored).filter(|run| run.is_elsewhere()) else {
                continue;
            };
            let id = &run.record().id;
            let is_here = self
                .hosted_runs()
                .get(id)
                .is_some_and(|own| !own.view().state.is_ended());
            if !is_here {
                self.stop_elsewhere(id, run.epoch())?;
                count += 1;
            }
        }
        Ok(count)
    }

    /// Stops the robots of this server and the models that work for it. Other servers go on.
    pub(crate) fn end(&self, by: &str) {
        self.stop_here();
        self.stop_models();
        // Nobody is there to be told that it could not be written.
        let _ = self.audit.add(by, Deed::Stopped { run: None });
    }

    /// Waits until this server has given all rights back, so that another one need not wait for their end; at the latest
    /// after a time.
    pub(crate) fn give_back(&self, grace: Duration) {
        let deadline = Instant::now() + grace;
        let is_busy = || !self.going_here().is_empty() || !self.queues.is_idle() || self.is_any_held();
        while self.store.is_shared() && is_busy() && Instant::now() < deadline {
            thread::sleep(Duration::from_millis(10));
        }
        self.forget_all();
    }
}

fn stop_of(run: &RunId, epoch: u64) -> RecordKey {
    RecordKey::Stop {
        run: run.clone(),
        epoch,
    }
}

/// Does work again and again until the hub ends.
fn every(hub: &Weak<Hub>, pause: Duration, work: fn(&Hub)) {
    while let Some(hub) = hub.upgrade() {
        work(&hub);
        drop(hub);
        thread::sleep(pause);
    }
}
