//! The server without a network: sessions, approvals and runs, which every face shares.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, MutexGuard, OnceLock, PoisonError};

use longstep::dialogue::ConstraintKind;
use longstep::session::{ModelFacts, Settings};

use crate::approval::Approvals;
use crate::audit::Audit;
use crate::domains::Domains;
use crate::feed::Feed;
use crate::hosted::{Held, Hosted};
use crate::id::{RunId, SessionId};
use crate::models::Models;
use crate::problem::{Problem, ProblemKind};
use crate::run::{Body, HostedRun, Queues, RobotEntry};
use crate::session_locks::SessionLocks;
use crate::store::{LogName, Store, StoreError};
use crate::view::Snapshot;

/// The most sessions that are kept in memory; others are read again from their logs.
const RESIDENT: usize = 256;

/// The most characters of an instruction, an answer or feedback.
const LONGEST_TEXT: usize = 4_000;

/// The parts of a server.
#[non_exhaustive]
pub struct Configuration {
    /// Where sessions, approvals and runs are kept.
    pub store: Arc<dyn Store>,
    /// The domains and scenes.
    pub domains: Domains,
    /// The model; none for a server that only verifies and solves.
    pub models: Option<Models>,
    /// The robots.
    pub robots: Vec<RobotEntry>,
    /// The settings of new sessions.
    pub settings: Settings,
}

impl Configuration {
    /// Creates the configuration of a server without a model and without robots.
    pub fn new(store: Arc<dyn Store>, domains: Domains) -> Self {
        Self {
            store,
            domains,
            models: None,
            robots: Vec::new(),
            settings: Settings::default(),
        }
    }

    /// Sets the model.
    #[must_use]
    pub fn with_models(self, models: impl Into<Option<Models>>) -> Self {
        Self {
            models: models.into(),
            ..self
        }
    }

    /// Sets the robots.
    #[must_use]
    pub fn with_robots(self, robots: Vec<RobotEntry>) -> Self {
        Self { robots, ..self }
    }

    /// Sets the settings of new sessions.
    #[must_use]
    pub fn with_settings(self, settings: Settings) -> Self {
        Self { settings, ..self }
    }
}

/// The server without a network. All its methods may be called from any thread; those that change something may wait for
/// the disk.
pub struct Hub {
    pub(crate) store: Arc<dyn Store>,
    pub(crate) domains: Domains,
    pub(crate) models: Option<Models>,
    pub(crate) robots: Vec<RobotEntry>,
    settings: Settings,
    pub(crate) audit: Audit,
    pub(crate) approvals: Approvals,
    pub(crate) feed: Arc<Feed>,
    sessions: Mutex<HashMap<SessionId, Arc<Hosted>>>,
    /// Held while a session enters memory, so that nobody reads the log of one that is being begun.
    entering: SessionLocks,
    pub(crate) runs: Mutex<HashMap<RunId, Arc<HostedRun>>>,
    /// Set when the runs of a store that is not shared were read.
    pub(crate) are_runs_read: OnceLock<()>,
    /// Held while a run is begun, so that of two for one session one is refused, and while a plan is accepted.
    pub(crate) beginning: SessionLocks,
    pub(crate) queues: Queues,
}

/// Where a new session begins.
#[derive(Debug, Clone, Default)]
#[non_exhaustive]
pub struct NewSession {
    /// The domain; that of the scene if there is one.
    pub domain: Option<String>,
    /// The environment as JSON; that of the scene if there is one.
    pub environment: Option<String>,
    /// A scene of the server.
    pub scene: Option<String>,
    /// Standing rules in the goal language.
    pub rules: Vec<String>,
}

impl NewSession {
    /// Begins in a scene of the server.
    pub fn of_scene(scene: &str) -> Self {
        Self {
            scene: Some(scene.to_owned()),
            ..Self::default()
        }
    }

    /// Begins in an environment.
    pub fn of_environment(domain: &str, environment: &str) -> Self {
        Self {
            domain: Some(domain.to_owned()),
            environment: Some(environment.to_owned()),
            ..Self::default()
        }
    }

    /// Sets the standing rules.
    #[must_use]
    pub fn with_rules(self, rules: Vec<String>) -> Self {
        Self { rules, ..self }
    }
}

impl Hub {
    /// Opens a server. Runs that an earlier server left are shown as interrupted. In a store that servers share, those of a
    /// server that died are, when its leases have ended.
    ///
    /// # Errors
    ///
    /// The audit log is open in another server, and the store is not shared.
    pub fn open(configuration: Configuration) -> Result<Arc<Self>, Problem> {
        let Configuration {
            store,
            domains,
            models,
            robots,
            settings,
        } = configuration;
        let audit = Audit::open(Arc::clone(&store))?;
        let hub = Self {
            approvals: Approvals::new(Arc::clone(&store), audit.clone()),
            store,
            domains,
            models,
            robots,
            settings,
            audit,
            feed: Arc::default(),
            sessions: Mutex::default(),
            entering: SessionLocks::default(),
            runs: Mutex::default(),
            are_runs_read: OnceLock::new(),
            beginning: SessionLocks::default(),
            queues: Queues::default(),
        };
        let hub = Arc::new(hub);
        if hub.store.is_shared() {
            hub.keep_watch();
        }
        Ok(hub)
    }

    /// Returns the live stream.
    pub fn feed(&self) -> &Arc<Feed> {
        &self.feed
    }

    /// Returns the domains and scenes.
    pub fn domains(&self) -> &Domains {
        &self.domains
    }

    /// Returns the model; none for a server without one.
    pub fn models(&self) -> Option<&Models> {
        self.models.as_ref()
    }

    pub(crate) fn models_or_problem(&self) -> Result<&Models, Problem> {
        self.models.as_ref().ok_or_else(|| {
            Problem::new(ProblemKind::Failed, "this server has no model")
                .hint("start it with `longstep serve --model NAME`")
        })
    }

    /// Returns the robots.
    pub fn robots(&self) -> &[RobotEntry] {
        &self.robots
    }

    /// Returns the audit log.
    pub fn audit(&self) -> &Audit {
        &self.audit
    }

    pub(crate) fn robot(&self, name: &str) -> Result<&RobotEntry, Problem> {
        let found = self.robots.iter().find(|robot| robot.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = self.robots.iter().map(|robot| robot.name.as_str()).collect();
            Problem::missing("robot", name).hint(match &names[..] {
                [] => "the server was started without `--robot`".to_owned(),
                names => format!("there are {}", names.join(", ")),
            })
        })
    }

    /// Returns the key of the queue for a robot and a session.
    pub(crate) fn body(robot: &RobotEntry, session: &SessionId) -> String {
        match robot.body {
            Body::Shared => robot.name.clone(),
            Body::PerSession => format!("{}/{session}", robot.name),
        }
    }

    fn resident(&self) -> MutexGuard<'_, HashMap<SessionId, Arc<Hosted>>> {
        self.sessions.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Begins a session.
    ///
    /// # Errors
    ///
    /// There is no such scene or domain, or the environment or a rule cannot be read.
    pub fn create(&self, new: &NewSession) -> Result<Arc<Snapshot>, Problem> {
        let (planner, world) = self.place(new)?;
        let session = planner.session(world, self.settings, self.facts())?;
        let id = SessionId::random()?;
        // Its log is listed from here on, and is not to be read before this server has it in memory.
        let _entering = self.entering.lock(&id);
        let log = self.store.own(&LogName::Session(id.clone()))?;
        let kept = Some((Arc::clone(&self.store), log));
        let held = Hosted::begin(id, session, kept, Arc::clone(&self.feed))?;
        self.admit(&held);
        Ok(held.snapshot())
    }

    /// Returns the facts about the model, or those of a model that will never be asked.
    pub(crate) fn facts(&self) -> ModelFacts {
        let none = || ModelFacts::new("none", ConstraintKind::JsonSchema);
        self.models.as_ref().map_or_else(none, |models| models.facts().clone())
    }

    pub(crate) fn settings(&self) -> Settings {
        self.settings
    }

    /// Keeps a session in memory; those that nobody has used for the longest time leave it. Of two that were read at once
    /// the first one stays, and is returned.
    fn admit(&self, hosted: &Arc<Hosted>) -> Arc<Hosted> {
        let mut resident = self.resident();
        while resident.len() >= RESIDENT {
            // Nobody else holds a session that is idle.
            let idle = resident
                .values()
                .filter(|own| Arc::strong_count(own) == 1 && !own.is_thinking());
            let Some(id) = idle.min_by_key(|own| own.used()).map(|own| own.id().clone()) else {
                break;
            };
            resident.remove(&id);
        }
        Arc::clone(
            resident
                .entry(hosted.id().clone())
                .or_insert_with(|| Arc::clone(hosted)),
        )
    }

    /// Returns a session from memory, or from its log.
    fn found(&self, id: &SessionId) -> Result<Arc<Hosted>, Problem> {
        if let Some(hosted) = self.resident().get(id) {
            return Ok(Arc::clone(hosted));
        }
        let _entering = self.entering.lock(id);
        if let Some(hosted) = self.resident().get(id) {
            return Ok(Arc::clone(hosted));
        }
        // To own a log makes its file.
        if self.store.state(&LogName::Session(id.clone()))?.is_none() {
            return Err(Problem::missing("session", id));
        }
        let (store, feed) = (Arc::clone(&self.store), Arc::clone(&self.feed));
        let hosted = Hosted::read(id.clone(), store, &self.domains, feed)?;
        Ok(self.admit(&Arc::new(hosted)))
    }

    /// Ends the calls of models for the sessions in memory.
    pub(crate) fn stop_models(&self) {
        let resident = self.resident();
        let thinking = resident.values().filter(|session| session.is_thinking());
        thinking.for_each(|session| session.stop_thinking());
    }

    /// Drops all sessions from memory, and with each its right to be changed unless somebody uses it.
    pub(crate) fn forget_all(&self) {
        let sessions = std::mem::take(&mut *self.resident());
        drop(sessions);
    }

    /// Returns true if anything may change a session in memory.
    pub(crate) fn is_any_held(&self) -> bool {
        self.resident().values().any(|session| session.is_held())
    }

    /// Drops a session from memory whose right was lost: it is read from its log when it is needed.
    fn forget(&self, hosted: &Arc<Hosted>) {
        let mut resident = self.resident();
        if resident.get(hosted.id()).is_some_and(|own| Arc::ptr_eq(own, hosted)) {
            resident.remove(hosted.id());
        }
    }

    /// Returns a session with the right to change it. No other server has it until that is dropped.
    ///
    /// # Errors
    ///
    /// There is none, another server works on it, or another program has it open.
    pub(crate) fn held(&self, id: &SessionId) -> Result<Held, Problem> {
        for _ in 0..2 {
            let hosted = self.found(id)?;
            // What was read without the lock of a file does not stay.
            let held = hosted.hold(&self.domains).inspect_err(|_| {
                if !self.store.is_shared() {
                    self.forget(&hosted);
                }
            })?;
            if let Some(held) = held {
                if held.take_unsettled() {
                    self.settle_runs(&held)?;
                    self.think_on(&held);
                }
                return Ok(held);
            }
            self.forget(&hosted);
        }
        Err(StoreError::Lost(LogName::Session(id.clone()).words()).into())
    }

    /// Returns a session to look at it: as this server has it, or as its log has it.
    ///
    /// # Errors
    ///
    /// There is none, or another program has it open.
    pub(crate) fn seen(&self, id: &SessionId) -> Result<Arc<Hosted>, Problem> {
        if !self.store.is_shared() {
            return Ok(Arc::clone(&*self.held(id)?));
        }
        let hosted = self.found(id)?;
        let state = self.store.state(&LogName::Session(id.clone()))?;
        let Some(state) = state else {
            return Err(Problem::missing("session", id));
        };
        if !hosted.follow(state.length, &self.domains)? {
            self.forget(&hosted);
            return self.found(id);
        }
        let is_abandoned = hosted.snapshot().view.state == "thinking" && !hosted.is_held() && !state.is_owned;
        if is_abandoned {
            // The server of its model has ended. Another one may be faster to see that.
            drop(self.held(id));
        }
        Ok(hosted)
    }

    /// Returns a session as it is now. Never waits for a model or a search.
    ///
    /// # Errors
    ///
    /// There is none, or another program has it open.
    pub fn session(&self, id: &SessionId) -> Result<Arc<Snapshot>, Problem> {
        Ok(self.seen(id)?.snapshot())
    }

    /// Returns the ids of all sessions.
    ///
    /// # Errors
    ///
    /// When they cannot be listed.
    pub fn sessions(&self) -> Result<Vec<SessionId>, Problem> {
        Ok(self.store.sessions()?)
    }
}

/// Returns the trimmed text of a person.
///
/// # Errors
///
/// It is empty, or too long.
pub(crate) fn checked_text(text: &str) -> Result<&str, Problem> {
    let text = text.trim();
    if text.is_empty() {
        return Err(Problem::unreadable("the text is empty").hint("write what the robot should do"));
    }
    let length = text.chars().count();
    if length > LONGEST_TEXT {
        let message = format!("the text has {length} characters; the limit is {LONGEST_TEXT}");
        return Err(Problem::new(ProblemKind::TooLarge, message).hint("shorten it to one or two sentences"));
    }
    Ok(text)
}
