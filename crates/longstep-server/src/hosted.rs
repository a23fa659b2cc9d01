//! A session in a server: its state, its log, and the model that works for it.

use std::collections::VecDeque;
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
use crate::store::{Durability, LogName, Store};
use crate::view::Snapshot;

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
    /// Takes a session; its log is owned and has the events before those of the session.
    pub(crate) fn new(
        id: SessionId,
        session: Session,
        store: Option<Arc<dyn Store>>,
        feed: Arc<Feed>,
    ) -> Result<Self, Problem> {
        let snapshot = Snapshot::of(&id, 0, &session, &[]);
        let hosted = Self {
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
        };
        hosted.change(|_| Ok(()))?;
        Ok(hosted)
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
        let mut runs = self.ended_runs.lock().unwrap_or_else(PoisonError::into_inner);
        runs.push_back(ended);
        drop(runs);
        self.change(|_| Ok(()))
    }

    fn take_ended_runs(&self, session: &mut Session) {
        let mut runs = self.ended_runs.lock().unwrap_or_else(PoisonError::into_inner);
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
        let Some(store) = self.store.as_ref().filter(|_| !events.is_empty()) else {
            return Ok(());
        };
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
        Ok(store.append(&LogName::Session(self.id.clone()), &lines, durability)?)
    }

    fn show(&self, session: &Session) {
        let version = *self.version.borrow() + 1;
        let mut shown = self.snapshot.write().unwrap_or_else(PoisonError::into_inner);
        *shown = Arc::new(Snapshot::of(&self.id, version, session, &shown.view.accepted));
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
        self.stop.set(false);
        !self.is_thinking.swap(true, Ordering::SeqCst)
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

    /// Calls the model until it is the person's turn. The session is free during each call.
    pub(crate) fn think(&self, model: &mut dyn ChatModel) {
        if let Err(problem) = self.requests(model) {
            let _ = self.change(|session| Ok(session.failed(&problem.message)?));
        }
        self.end_thinking();
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

/// Reads the log of a session and resumes it. The log is owned by then.
pub(crate) fn resumed(store: &dyn Store, id: &SessionId, domains: &Domains) -> Result<Session, Problem> {
    let bytes = store.read(&LogName::Session(id.clone()))?;
    let bytes = bytes.ok_or_else(|| Problem::missing("session", id))?;
    let log = Log::read(&bytes).map_err(|error| Problem::conflict(format!("session `{id}`: {error}")))?;
    let Some(Event::Begin { domain, .. }) = log.events().next() else {
        return Err(Problem::missing("session", id));
    };
    Ok(domains.of_log(domain)?.resume(&log)?.session)
}
