//! The handler of a connection: it lists tools and resources, and passes calls on.

use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use rmcp::ServerHandler;
use rmcp::model::{
    CallToolRequestParams, CallToolResponse, ErrorData, Implementation, ListResourceTemplatesResult,
    ListResourcesResult, ListToolsResult, PaginatedRequestParams, ReadResourceRequestParams, ReadResourceResponse,
    ServerCapabilities, ServerConfig, Tool,
};
use rmcp::service::{RequestContext, RoleServer};
use tokio::sync::Semaphore;
use tokio::task::spawn_blocking;

use super::caller::Caller;
use super::consent::Consent;
use super::offer::Offers;
use super::options::McpOptions;
use super::{call, resource, tool};
use crate::hub::Hub;
use crate::id::{RunId, SessionId};
use crate::problem::{Problem, ProblemKind};

/// The most calls that search or wait for the disk at a time; others wait. `stop` is not among them.
const WORKERS: usize = 8;

/// The instructions for a model that uses the server.
const INSTRUCTIONS: &str = "Longstep turns an instruction into a verified plan for a robot. Call `plan` with the \
    instruction in plain words; if it returns a question, call `answer`. Show the plan to the person; `revise` changes it. \
    `execute_plan` asks the person and, only after a yes, moves the robot. `run_status` shows the run, `stop` stops it at \
    once.";

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

impl ServerHandler for Face {
    fn get_info(&self) -> ServerConfig {
        let capabilities = ServerCapabilities::builder().enable_tools().enable_resources().build();
        let mut own = Implementation::new("longstep", env!("CARGO_PKG_VERSION"));
        own.title = Some("Longstep".to_owned());
        ServerConfig::new(capabilities)
            .with_server_info(own)
            .with_instructions(INSTRUCTIONS)
    }

    async fn list_tools(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListToolsResult, ErrorData> {
        Ok(ListToolsResult::with_all_items(tool::all()))
    }

    fn get_tool(&self, name: &str) -> Option<Tool> {
        tool::all().into_iter().find(|tool| tool.name == name)
    }

    async fn call_tool(
        &self,
        request: CallToolRequestParams,
        context: RequestContext<RoleServer>,
    ) -> Result<CallToolResponse, ErrorData> {
        call::call(self, &Caller::of(&context), request).await
    }

    async fn list_resources(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListResourcesResult, ErrorData> {
        Ok(ListResourcesResult::with_all_items(resource::all()))
    }

    async fn list_resource_templates(
        &self,
        _: Option<PaginatedRequestParams>,
        _: RequestContext<RoleServer>,
    ) -> Result<ListResourceTemplatesResult, ErrorData> {
        Ok(ListResourceTemplatesResult::with_all_items(resource::templates()))
    }

    async fn read_resource(
        &self,
        request: ReadResourceRequestParams,
        _: RequestContext<RoleServer>,
    ) -> Result<ReadResourceResponse, ErrorData> {
        self.resource(&request.uri).await
    }
}
