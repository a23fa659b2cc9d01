//! A session in a server: its state, its log, and the model that works for it.

use std::collections::VecDeque;
use std::ops::Deref;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, RwLock};
use std::time::Instant;

use longstep::report;
use longstep::session::{Entry, Event, Log, ObserveError, Session};
use longstep_core::environment::Observation;
use longstep_llm::{ChatModel, ModelError, Progress, StopFlag, Watch};
use tokio::sync::watch;

use crate::domains::Domains;
use crate::feed::{Feed, Happening};
use crate::id::SessionId;
use crate::problem::Problem;
use crate::store::{Durability, LogName, OwnedLog, Store, StoreError};
use crate::view::{AcceptedView, Snapshot};

/// A session that is in memory.
///
/// Faces show a snapshot, so that looking at a session never waits for a search or a model.
pub(crate) struct Hosted {
    id: SessionId,
    /// None for a session that is not kept.
    store: Option<Arc<dyn Store>>,
    feed: Arc<Feed>,
    session: Mutex<Session>,
    snapshot: RwLock<Arc<Snapshot>>,
    /// Changes with each snapshot.
    version: watch::Sender<u64>,
    /// True from a request of a person until it is the person's turn again.
    is_thinking: AtomicBool,
    /// Ends the call of a model.
    stop: StopFlag,
    used: Mutex<Instant>,
    /// The ends of runs that the session takes when no instruction is in progress.
    ended_runs: Mutex<VecDeque<EndedRun>>,
    holding: Mutex<Holding>,
    /// True from a reading of the log until somebody has looked for what an earlier server left undone.
    is_unsettled: AtomicBool,
}

/// The right to change a session.
struct Holding {
    /// The log, while this server owns it.
    log: Option<Arc<dyn OwnedLog>>,
    /// The number of those who may change the session now.
    holders: usize,
    /// The length of the log of which the session was made, while this server does not own it.
    length: u64,
    /// The epoch of the log when this server owned it last.
    epoch: u64,
    /// True after the right was lost, or an addition to the log has failed: the session is not as its log.
    is_lost: bool,
}

impl Holding {
    /// Marks the session as other than its log, for good. Another one may be made of the log then.
    fn lose(&mut self) {
        self.is_lost = true;
        self.log = None;
    }
}

/// The right to change a session: its log is owned until the last one is dropped, or for longer if no other server can
/// have the session.
pub(crate) struct Held(Arc<Hosted>);

impl Deref for Held {
    type Target = Arc<Hosted>;

    fn deref(&self) -> &Arc<Hosted> {
        &self.0
    }
}

impl Clone for Held {
    fn clone(&self) -> Self {
        self.holding().holders += 1;
        Self(Arc::clone(&self.0))
    }
}

impl Drop for Held {
    fn drop(&mut self) {
        let mut holding = self.0.holding();
        holding.holders -= 1;
        let is_shared = self.0.store.as_ref().is_some_and(|store| store.is_shared());
        // The end of a run that the session has not taken yet is known here only.
        if holding.holders > 0 || !is_shared || !self.0.ended_runs().is_empty() {
            return;
        }
        // Given back under the lock: another request of this server waits for that, and is not refused.
        if let Some(log) = holding.log.take() {
            (holding.length, holding.epoch) = (log.length(), log.epoch());
        }
    }
}

/// The end of a run, as a session takes it.
#[derive(Debug, Clone)]
pub(crate) struct EndedRun {
    /// The number of the plan.
    pub(crate) number: usize,
    /// True if its goal is reached.
    pub(crate) is_reached: bool,
    /// The world at the end.
    pub(crate) statements: Observation,
}

impl Hosted {
    /// Takes a new session with its log; none for one that is not kept.
    pub(crate) fn begin(
        id: SessionId,
        session: Session,
        kept: Option<(Arc<dyn Store>, Box<dyn OwnedLog>)>,
        feed: Arc<Feed>,
    ) -> Result<Held, Problem> {
        let (store, log) = kept.unzip();
        let hosted = Self::new(id, session, store, feed);
        let mut holding = hosted.holding();
        holding.log = log.map(Arc::from);
        holding.holders = 1;
        drop(holding);
        let held = Held(Arc::new(hosted));
        held.change(|_| Ok(()))?;
        Ok(held)
    }

    /// Reads a session from its log.
    pub(crate) fn read(
        id: SessionId,
        store: Arc<dyn Store>,
        domains: &Domains,
        feed: Arc<Feed>,
    ) -> Result<Self, Problem> {
        let (session, length) = resumed(store.as_ref(), &id, domains)?;
        let hosted = Self::new(id, session, Some(store), feed);
        hosted.holding().length = length;
        hosted.is_unsettled.store(true, Ordering::SeqCst);
        Ok(hosted)
    }

    fn new(id: SessionId, session: Session, store: Option<Arc<dyn Store>>, feed: Arc<Feed>) -> Self {
        let snapshot = Snapshot::of(&id, 0, &session, &[]);
        Self {
            id,
            store,
            feed,
            session: Mutex::new(session),
            snapshot: RwLock::new(Arc::new(snapshot)),
            version: watch::channel(0).0,
            is_thinking: AtomicBool::new(false),
            stop: StopFlag::default(),
            used: Mutex::new(Instant::now()),
            ended_runs: Mutex::default(),
            holding: Mutex::new(Holding {
                log: None,
                holders: 0,
                length: 0,
                epoch: 0,
                is_lost: false,
            }),
            is_unsettled: AtomicBool::new(false),
        }
    }

    fn holding(&self) -> MutexGuard<'_, Holding> {
        self.holding.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Takes the right to change the session, which is read again if another server has changed it. None if the right was
    /// lost: the session is to be read anew.
    ///
    /// # Errors
    ///
    /// Another server has the session, or its log cannot be read.
    pub(crate) fn hold(self: &Arc<Self>, domains: &Domains) -> Result<Option<Held>, Problem> {
        let mut holding = self.holding();
        if let (None, Some(store)) = (&holding.log, self.store.as_ref().filter(|_| !holding.is_lost)) {
            let log = store.own(&LogName::Session(self.id.clone()))?;
            if log.length() != holding.length {
                self.read_again(&mut holding, domains)?;
            } else if log.epoch() != holding.epoch + 1 {
                // Another server had it, and may have died with the end of a run.
                self.is_unsettled.store(true, Ordering::SeqCst);
            }
            holding.log = Some(log.into());
        }
        let is_lost = holding.is_lost || holding.log.as_ref().is_some_and(|log| log.is_lost());
        if is_lost {
            holding.lose();
            return Ok(None);
        }
        holding.holders += 1;
        Ok(Some(Held(Arc::clone(self))))
    }

    /// Reads the session again if its log has another length and nobody here may change it. False if the right to change
    /// it was lost: the session is to be read anew.
    pub(crate) fn follow(&self, length: u64, domains: &Domains) -> Result<bool, Problem> {
        let mut holding = self.holding();
        match &holding.log {
            Some(log) if log.is_lost() => holding.lose(),
            Some(_) => {}
            None if !holding.is_lost && holding.length != length => self.read_again(&mut holding, domains)?,
            None => {}
        }
        Ok(!holding.is_lost)
    }

    fn read_again(&self, holding: &mut Holding, domains: &Domains) -> Result<(), Problem> {
        let Some(store) = &self.store else { return Ok(()) };
        let (session, length) = resumed(store.as_ref(), &self.id, domains)?;
        let mut own = self.session();
        *own = session;
        holding.length = length;
        // Those that the session has not taken are found again.
        self.ended_runs().clear();
        self.is_unsettled.store(true, Ordering::SeqCst);
        // Plans with the same numbers may be others.
        self.show_after(&own, &[]);
        Ok(())
    }

    /// Returns true if this server may change the session now.
    pub(crate) fn is_held(&self) -> bool {
        self.holding().holders > 0
    }

    /// Returns true if the right to change the session was lost.
    pub(crate) fn is_lost(&self) -> bool {
        let holding = self.holding();
        holding.is_lost || holding.log.as_ref().is_some_and(|log| log.is_lost())
    }

    /// Returns true the first time after the session was read from its log.
    pub(crate) fn take_unsettled(&self) -> bool {
        self.is_unsettled.swap(false, Ordering::SeqCst)
    }

    /// Returns the id.
    pub(crate) fn id(&self) -> &SessionId {
        &self.id
    }

    /// Returns the last snapshot. Never waits.
    pub(crate) fn snapshot(&self) -> Arc<Snapshot> {
        *self.used.lock().unwrap_or_else(PoisonError::into_inner) = Instant::now();
        Arc::clone(&self.snapshot.read().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns the time of the last use.
    pub(crate) fn used(&self) -> Instant {
        *self.used.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the number of changes, which changes with each.
    pub(crate) fn version(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    /// Returns true while a model works for the session, or it waits for one.
    pub(crate) fn is_thinking(&self) -> bool {
        self.is_thinking.load(Ordering::SeqCst)
    }

    fn session(&self) -> MutexGuard<'_, Session> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Looks at the session itself. Waits for a search that is under way.
    pub(crate) fn look<T>(&self, look: impl FnOnce(&Session) -> T) -> T {
        look(&self.session())
    }

    /// Changes the session, keeps its events, and shows it.
    ///
    /// # Errors
    ///
    /// Those of the change, and of the store.
    pub(crate) fn change<T>(&self, change: impl FnOnce(&mut Session) -> Result<T, Problem>) -> Result<T, Problem> {
        let mut session = self.session();
        let result = change(&mut session);
        self.take_ended_runs(&mut session);
        self.keep(&mut session)?;
        self.show(&session);
        result
    }

    /// Takes the end of a run, now or when the instruction in progress has ended.
    pub(crate) fn run_ended(&self, ended: EndedRun) -> Result<(), Problem> {
        self.ended_runs().push_back(ended);
        self.change(|_| Ok(()))
    }

    fn ended_runs(&self) -> MutexGuard<'_, VecDeque<EndedRun>> {
        self.ended_runs.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn take_ended_runs(&self, session: &mut Session) {
        let mut runs = self.ended_runs();
        while let Some(run) = runs.front() {
            let taken = session.carried_out(run.number, run.is_reached, &run.statements);
            // A plan that was undone, or a world that does not have it, will not take it later either.
            if matches!(taken, Err(ObserveError::OutOfTurn(_))) {
                return;
            }
            runs.pop_front();
        }
    }

    /// Adds the new events to the log.
    fn keep(&self, session: &mut Session) -> Result<(), Problem> {
        let events = session.take_events();
        if events.is_empty() || self.store.is_none() {
            return Ok(());
        }
        let log = self.holding().log.clone();
        let durability = if events.iter().any(Event::is_lasting) {
            Durability::Now
        } else {
            Durability::Later
        };
        let at = jiff::Timestamp::now().to_string();
        let lines: String = events
            .into_iter()
            .map(|event| Entry::new(at.clone(), event).line())
            .collect();
        let log = log.ok_or_else(|| StoreError::Lost(LogName::Session(self.id.clone()).words()));
        let kept = log.and_then(|log| log.append(&lines, durability));
        Ok(kept.inspect_err(|_| self.holding().lose())?)
    }

    fn show(&self, session: &Session) {
        let before = self.snapshot.read().unwrap_or_else(PoisonError::into_inner).clone();
        self.show_after(session, &before.view.accepted);
    }

    /// Shows the session; `before` has accepted plans that are in it too.
    fn show_after(&self, session: &Session, before: &[AcceptedView]) {
        let version = *self.version.borrow() + 1;
        let mut shown = self.snapshot.write().unwrap_or_else(PoisonError::into_inner);
        *shown = Arc::new(Snapshot::of(&self.id, version, session, before));
        let state = shown.view.state;
        drop(shown);
        self.version.send_replace(version);
        if self.store.is_some() {
            self.feed.publish(Happening::Session {
                session: self.id.clone(),
                state,
            });
        }
    }

    /// Marks that a model is to work for the session; false if one does already.
    pub(crate) fn begin_thinking(&self) -> bool {
        let has_begun = !self.is_thinking.swap(true, Ordering::SeqCst);
        // Somebody may just have stopped the one that works.
        if has_begun {
            self.stop.set(false);
        }
        has_begun
    }

    /// Marks that no model works for the session any more.
    pub(crate) fn end_thinking(&self) {
        self.is_thinking.store(false, Ordering::SeqCst);
        // Those who wait for the person's turn look again.
        self.version.send_modify(|_| {});
    }

    /// Ends the call of the model. The session is cancelled then.
    pub(crate) fn stop_thinking(&self) {
        self.stop.set(true);
    }

    fn requests(&self, model: &mut dyn ChatModel) -> Result<(), Problem> {
        loop {
            if self.stop.is_set() {
                return self.change(|session| Ok(session.cancel()?));
            }
            // A prompt that does not fit has ended the instruction: the session says so itself.
            let request = self.change(|session| Ok(session.next_request(&mut *model).ok().flatten()))?;
            let Some(prepared) = request else { return Ok(()) };
            let started = Instant::now();
            let reply = model.chat(&prepared.request, &mut Calling { hosted: self });
            let milliseconds = report::milliseconds(started.elapsed());
            match reply {
                Ok(reply) => self.change(|session| Ok(session.supply(&reply, milliseconds)?))?,
                Err(ModelError::Stopped) => return self.change(|session| Ok(session.cancel()?)),
                Err(error) => return Err(error.into()),
            }
        }
    }
}

impl Held {
    /// Calls the model until it is the person's turn, and gives the session back. The session is free during each call.
    pub(crate) fn think(self, model: &mut dyn ChatModel) {
        if let Err(problem) = self.requests(model) {
            let _ = self.change(|session| Ok(session.failed(&problem.message)?));
        }
        let hosted = Arc::clone(&self.0);
        // Before those who wait are told: the person may go on with another server.
        drop(self);
        hosted.end_thinking();
    }
}

/// Watches the call of a model for a session.
struct Calling<'h> {
    hosted: &'h Hosted,
}

impl Watch for Calling<'_> {
    fn tell(&mut self, progress: Progress) {
        let text = match progress {
            Progress::Loading => "loading the model".to_owned(),
            Progress::ReadingPrompt { done: 0, .. } | Progress::Waiting => "reading".to_owned(),
            Progress::Writing { tokens: 1 } => "writing".to_owned(),
            Progress::Warning(text) => text,
            _ => return,
        };
        if self.hosted.store.is_some() {
            self.hosted.feed.publish(Happening::Progress {
                session: self.hosted.id.clone(),
                text,
            });
        }
    }

    fn stop(&self) -> bool {
        self.hosted.stop.is_set()
    }
}

/// Reads the log of a session and resumes it. Returns the length of the log too.
fn resumed(store: &dyn Store, id: &SessionId, domains: &Domains) -> Result<(Session, u64), Problem> {
    let bytes = store.read(&LogName::Session(id.clone()))?;
    let bytes = bytes.ok_or_else(|| Problem::missing("session", id))?;
    let log = Log::read(&bytes).map_err(|error| Problem::conflict(format!("session `{id}`: {error}")))?;
    let Some(Event::Begin { domain, .. }) = log.events().next() else {
        return Err(Problem::missing("session", id));
    };
    Ok((domains.of_log(domain)?.resume(&log)?.session, bytes.len() as u64))
}
