//! A connection: the state that it shares with all others, and its session.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use super::consent::Consent;
use super::offer::Offers;
use super::options::McpOptions;
use crate::hub::Hub;
use crate::id::{RunId, SessionId};
use crate::problem::{Problem, ProblemKind};

/// The most calls that search or wait for the disk at a time; others wait. `stop` is not among them.
const WORKERS: usize = 8;

/// The state that all connections of a server share.
pub(super) struct Shared {
    pub(super) hub: Arc<Hub>,
    pub(super) options: McpOptions,
    pub(super) consent: Consent,
    pub(super) offers: Offers,
    begun: Mutex<BTreeSet<RunId>>,
    workers: Arc<Semaphore>,
}

impl Shared {
    pub(super) fn new(hub: Arc<Hub>, options: McpOptions) -> Result<Arc<Self>, Problem> {
        Ok(Arc::new(Self {
            hub,
            consent: Consent::new(options.form_lifetime)?,
            offers: Offers::new(options.plan_lifetime),
            options,
            begun: Mutex::default(),
            workers: Arc::new(Semaphore::new(WORKERS)),
        }))
    }

    /// Remembers a run that this server began.
    pub(super) fn add_begun(&self, run: RunId) {
        self.begun.lock().unwrap_or_else(PoisonError::into_inner).insert(run);
    }

    /// Returns the runs that this server began.
    pub(super) fn begun(&self) -> Vec<RunId> {
        let begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
        begun.iter().cloned().collect()
    }
}

/// The handler of one connection, or of one request of the protocol without connections.
#[derive(Clone)]
pub struct Face {
    pub(super) shared: Arc<Shared>,
    /// The session of the connection: the last one that was planned in.
    session: Arc<Mutex<Option<SessionId>>>,
}

impl Face {
    pub(super) fn new(shared: Arc<Shared>) -> Self {
        Self {
            shared,
            session: Arc::default(),
        }
    }

    /// Does work that searches or waits for the disk. A failure of it is a problem like any other.
    pub(super) async fn work<T: Send + 'static>(
        &self,
        work: impl FnOnce(&Shared) -> Result<T, Problem> + Send + 'static,
    ) -> Result<T, Problem> {
        let failed = |reason: String| Problem::new(ProblemKind::Internal, format!("the work failed: {reason}"));
        let permit = Arc::clone(&self.shared.workers).acquire_owned().await;
        let permit = permit.map_err(|error| failed(error.to_string()))?;
        let shared = Arc::clone(&self.shared);
        let done = spawn_blocking(move || {
            // Work whose call was cancelled still counts.
            let _permit = permit;
            work(&shared)
        });
        done.await.map_err(|error| failed(error.to_string()))?
    }

    fn own_session(&self) -> MutexGuard<'_, Option<SessionId>> {
        self.session.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Makes a session that of the connection.
    pub(super) fn keep_session(&self, id: SessionId) {
        *self.own_session() = Some(id);
    }

    /// Returns the named session, or else that of the connection, if it has one.
    ///
    /// # Errors
    ///
    /// The name cannot be one.
    pub(super) fn session(&self, named: Option<&str>) -> Result<Option<SessionId>, Problem> {
        match named {
            Some(text) => match SessionId::parse(text) {
                Some(id) => Ok(Some(id)),
                None => Err(Problem::missing("session", text).hint("use the `session` that `plan` returned")),
            },
            None => Ok(self.own_session().clone()),
        }
    }

    /// Returns the named session, or else that of the connection.
    ///
    /// # Errors
    ///
    /// There is none.
    pub(super) fn known_session(&self, named: Option<&str>) -> Result<SessionId, Problem> {
        self.session(named)?.ok_or_else(|| {
            Problem::conflict("there is no session yet")
                .hint("call `plan` first; if you did, pass the `session` that it returned")
        })
    }
}
