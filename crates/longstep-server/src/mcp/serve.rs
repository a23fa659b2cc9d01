//! The transports.

use std::io;
use std::sync::Arc;
use std::time::{Duration, Instant};

use rmcp::ServiceExt;
use rmcp::transport::streamable_http_server::session::local::LocalSessionManager;
use rmcp::transport::{IntoTransport, StreamableHttpServerConfig, StreamableHttpService};
use tokio::runtime::Builder;

use super::face::{Face, Shared};
use super::options::McpOptions;
use crate::hub::Hub;
use crate::problem::Problem;

/// The threads of a server on standard input and output: `stop` runs while the other is busy.
const THREADS: usize = 2;

/// The time in which stopped runs end before the program does.
const GRACE: Duration = Duration::from_secs(5);

/// The longest wait between two looks at runs that are to end.
const LOOK: Duration = Duration::from_millis(20);

/// The largest request over HTTP, in bytes.
const LARGEST_REQUEST: usize = 1 << 20;

/// A server that cannot begin, or whose connection broke.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum McpError {
    /// There are no threads or no random numbers.
    #[error("the server cannot begin: {0}")]
    Begin(String),
    /// The client does not speak the protocol, or left before it began.
    #[error("the client did not begin the protocol: {0}")]
    Client(String),
}

impl From<Problem> for McpError {
    fn from(problem: Problem) -> Self {
        Self::Begin(problem.message)
    }
}

/// Serves one client on standard input and output, and blocks until it has gone or `ended` completes. All robots are stopped
/// then.
///
/// Nothing else may write to standard output. The function has a runtime of its own: call it outside of one.
///
/// # Errors
///
/// The server cannot begin, or the client does not speak the protocol. A client that goes away is none.
pub fn serve_stdio(hub: Arc<Hub>, options: McpOptions, ended: impl Future<Output = ()>) -> Result<(), McpError> {
    let runtime = Builder::new_multi_thread().worker_threads(THREADS).enable_all().build();
    let runtime = runtime.map_err(|error| McpError::Begin(error.to_string()))?;
    let result = runtime.block_on(async {
        tokio::select! {
            result = serve(Arc::clone(&hub), options, rmcp::transport::stdio()) => result,
            () = ended => Ok(()),
        }
    });
    // Whoever ends the server may not be able to stop a robot otherwise.
    let _ = hub.stop_all("the end of the server");
    // The thread that reads standard input cannot be interrupted.
    runtime.shutdown_background();
    result
}

/// Serves one client on a transport until it has gone. Robots that still move are stopped then.
///
/// # Errors
///
/// As for [`serve_stdio`].
pub async fn serve<T, E, A>(hub: Arc<Hub>, options: McpOptions, transport: T) -> Result<(), McpError>
where
    T: IntoTransport<rmcp::RoleServer, E, A>,
    E: std::error::Error + Send + Sync + 'static,
{
    let shared = Shared::new(Arc::clone(&hub), options)?;
    let face = Face::new(Arc::clone(&shared));
    let running = face.serve(transport).await;
    let running = running.map_err(|error| McpError::Client(error.to_string()))?;
    // It ends with the client, or by a failure of the task, which ends the connection too.
    let _ = running.waiting().await;
    stop_runs(&hub, &shared).await;
    Ok(())
}

/// Stops the runs that this server began, and waits a moment for their ends.
async fn stop_runs(hub: &Hub, shared: &Shared) {
    let going = || {
        let runs = shared.begun().into_iter().filter_map(|run| hub.run(&run).ok());
        runs.filter(|run| !run.state.is_ended()).collect::<Vec<_>>()
    };
    for run in going() {
        // The robot has stopped even if the audit log could not be written.
        let _ = hub.stop(&run.record.id, "mcp");
    }
    let began = Instant::now();
    while !going().is_empty() && began.elapsed() < GRACE {
        tokio::time::sleep(LOOK).await;
    }
}

/// The service of many clients over streamable HTTP; see [`http_service`].
pub type HttpService = StreamableHttpService<Face, LocalSessionManager>;

/// Returns a service for many clients over streamable HTTP, to be mounted in a router of axum.
///
/// Hosts and origins are checked as the options say. Who may call is decided before the service, by the router.
///
/// ```
/// # use std::sync::Arc;
/// # use longstep_server::mcp::{McpOptions, http_service};
/// # use longstep_server::{Configuration, Domains, FileStore, Hub, NewSession, Scene};
/// # let folder = tempfile::tempdir()?;
/// # let store = Arc::new(FileStore::open(&folder.path().join("sessions"))?);
/// # let hub = Hub::open(Configuration::new(store, Domains::new(&[], Scene::shipped())?))?;
/// let service = http_service(hub, McpOptions::new(NewSession::of_scene("pantry")))?;
/// let router: axum::Router = axum::Router::new().nest_service("/mcp", service);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// # Errors
///
/// There are no random numbers.
pub fn http_service(hub: Arc<Hub>, options: McpOptions) -> Result<HttpService, McpError> {
    let configuration = StreamableHttpServerConfig::default()
        .with_allowed_hosts(options.hosts.clone())
        .with_allowed_origins(options.origins.clone())
        .enforce_origin_validation()
        .with_max_request_body_bytes(LARGEST_REQUEST);
    let shared = Shared::new(hub, options)?;
    // Of the protocol with a handshake each connection has a face; of the other one, each request.
    let face = move || Ok::<_, io::Error>(Face::new(Arc::clone(&shared)));
    Ok(StreamableHttpService::new(face, Arc::default(), configuration))
}
