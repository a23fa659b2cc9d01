//! The server without a network: sessions, approvals and runs, which every face shares.

use std::collections::{HashMap, VecDeque};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use longstep::dialogue::ConstraintKind;
use longstep::session::{ModelFacts, Session, Settings};

use crate::approval::Approvals;
use crate::audit::Audit;
use crate::domains::Domains;
use crate::feed::Feed;
use crate::hosted::{Hosted, resumed};
use crate::id::{RunId, SessionId};
use crate::models::Models;
use crate::problem::{Problem, ProblemKind};
use crate::run::{Body, HostedRun, Queues, RobotEntry};
use crate::session_locks::SessionLocks;
use crate::store::{LogName, Store};
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
    /// Held while a session is read from its log: two copies of a session would each add to the log.
    opening: SessionLocks,
    pub(crate) runs: Mutex<HashMap<RunId, Arc<HostedRun>>>,
    /// The runs of this server whose views have their steps, in the order of their beginnings.
    pub(crate) whole_runs: Mutex<VecDeque<Arc<HostedRun>>>,
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
    /// Opens a server. Runs that an earlier server left are shown as interrupted.
    ///
    /// # Errors
    ///
    /// The audit log is open in another server, or the runs cannot be read.
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
            opening: SessionLocks::default(),
            runs: Mutex::default(),
            whole_runs: Mutex::default(),
            beginning: SessionLocks::default(),
            queues: Queues::default(),
        };
        hub.load_runs()?;
        Ok(Arc::new(hub))
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
        self.store.own(&LogName::Session(id.clone()))?;
        Ok(self.admit(id, session)?.snapshot())
    }

    /// Returns the facts about the model, or those of a model that will never be asked.
    pub(crate) fn facts(&self) -> ModelFacts {
        let none = || ModelFacts::new("none", ConstraintKind::JsonSchema);
        self.models.as_ref().map_or_else(none, |models| models.facts().clone())
    }

    pub(crate) fn settings(&self) -> Settings {
        self.settings
    }

    /// Keeps a session in memory; those that nobody has used for the longest time leave it.
    fn admit(&self, id: SessionId, session: Session) -> Result<Arc<Hosted>, Problem> {
        let (store, feed) = (Some(Arc::clone(&self.store)), Arc::clone(&self.feed));
        let hosted = Arc::new(Hosted::new(id, session, store, feed)?);
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
            self.store.release(&LogName::Session(id));
        }
        resident.insert(hosted.id().clone(), Arc::clone(&hosted));
        Ok(hosted)
    }

    /// Returns a session, from memory or from its log.
    ///
    /// # Errors
    ///
    /// There is none, or another program has it open.
    pub(crate) fn hosted(&self, id: &SessionId) -> Result<Arc<Hosted>, Problem> {
        if let Some(hosted) = self.resident().get(id) {
            return Ok(Arc::clone(hosted));
        }
        let log = LogName::Session(id.clone());
        // To own a log makes its file.
        if self.store.changed_at(&log)?.is_none() {
            return Err(Problem::missing("session", id));
        }
        let _opening = self.opening.lock(id);
        // Of two requests at once, the first has read the log.
        if let Some(hosted) = self.resident().get(id) {
            return Ok(Arc::clone(hosted));
        }
        self.store.own(&log)?;
        let session = resumed(self.store.as_ref(), id, &self.domains).inspect_err(|_| self.store.release(&log))?;
        let hosted = self.admit(id.clone(), session)?;
        self.settle_runs(&hosted)?;
        self.think_on(&hosted);
        Ok(hosted)
    }

    /// Returns a session as it is now. Never waits for a model or a search.
    ///
    /// # Errors
    ///
    /// There is none, or another program has it open.
    pub fn session(&self, id: &SessionId) -> Result<Arc<Snapshot>, Problem> {
        Ok(self.hosted(id)?.snapshot())
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
