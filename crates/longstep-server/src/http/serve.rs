//! Connections.

use std::future::{Future, poll_fn};
use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper::service::{Service, service_fn};
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::{AsyncReadExt, AsyncWriteExt};
use tokio::net::TcpStream;
use tokio::sync::{Semaphore, oneshot};

use super::Shared;
use super::access::Access;
use super::gate::{Admitted, Gate};
use super::router::{guard, routes};
use crate::hub::Hub;
#[cfg(feature = "mcp")]
use crate::mcp::{McpOptions, http_service};

/// The most connections at a time.
const CONNECTIONS: usize = 1_024;

/// The most connections that wait until the server takes them.
#[cfg(unix)]
const BACKLOG: i32 = 4_096;

/// The time for which a connection may be silent before a new one gets its place: some thousand idle connections a second
/// evict nobody who has something to say.
const SILENCE: Duration = Duration::from_millis(200);

/// The time in which the head of a request arrives.
const SLOWEST_HEAD: Duration = Duration::from_secs(15);

/// The time in which requests end after the server was asked to end.
const GRACE: Duration = Duration::from_secs(5);

/// The open files of a server at its bounds: connections, those that linger, and the logs of sessions and runs.
#[cfg(unix)]
const OPEN_FILES: u64 = 4_096;

/// The most connections that linger after their last answer.
const LINGERING: usize = 256;

/// The time for which a connection lingers.
const LINGER: Duration = Duration::from_secs(2);

/// The answer to a connection beyond the bound.
const FULL: &[u8] = b"HTTP/1.1 503 Service Unavailable\r\nContent-Type: application/json\r\nRetry-After: 2\r\nConnection: close\r\n\
Content-Length: 82\r\n\r\n{\"error\":{\"kind\":\"busy\",\"message\":\"too many connections at a time\",\"hint\":null}}\r\n";

/// The options of a server besides its hub.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct ServeOptions {
    /// Who may talk to it.
    pub access: Access,
    /// Threads that work on requests.
    pub threads: usize,
    /// The options of the Model Context Protocol at `/mcp`; none for a server without it.
    #[cfg(feature = "mcp")]
    pub mcp: Option<McpOptions>,
}

impl ServeOptions {
    /// Creates options with two threads.
    pub fn new(access: Access) -> Self {
        Self {
            access,
            threads: 2,
            #[cfg(feature = "mcp")]
            mcp: None,
        }
    }

    /// Sets the threads that work on requests.
    #[must_use]
    pub fn with_threads(self, threads: usize) -> Self {
        Self { threads, ..self }
    }

    /// Serves the Model Context Protocol at `/mcp` too, to clients that send the token.
    #[cfg(feature = "mcp")]
    #[must_use]
    pub fn with_mcp(self, mcp: impl Into<Option<McpOptions>>) -> Self {
        Self {
            mcp: mcp.into(),
            ..self
        }
    }
}

/// A server that cannot begin.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ServeError {
    /// The operating system does not let it.
    #[error("the server cannot begin: {0}")]
    System(#[from] io::Error),
    /// There are no random numbers.
    #[error("there are no random numbers: {0}")]
    Random(#[from] getrandom::Error),
    /// The Model Context Protocol cannot begin.
    #[cfg(feature = "mcp")]
    #[error(transparent)]
    Mcp(#[from] crate::mcp::McpError),
}

/// Serves a hub until `ended` completes; then stops all robots. Blocks the thread. Raises the limit of open files of the
/// program to 4,096, as far as it may.
///
/// # Errors
///
/// The server cannot begin.
pub fn serve(
    listener: TcpListener,
    hub: Arc<Hub>,
    options: ServeOptions,
    ended: impl Future<Output = ()>,
) -> Result<(), ServeError> {
    let shared = Shared::new(Arc::clone(&hub), options.access)?;
    let service = routes();
    #[cfg(feature = "mcp")]
    let service = match options.mcp {
        Some(mcp) => {
            let mcp = mcp.with_hosts(shared.access.hosts().to_vec());
            service.nest_service("/mcp", http_service(Arc::clone(&hub), mcp)?)
        }
        None => service,
    };
    let service = guard(service, shared);
    let runtime = tokio::runtime::Builder::new_multi_thread()
        .worker_threads(options.threads.max(1))
        .enable_all()
        .build()?;
    listener.set_nonblocking(true)?;
    // The standard library asks for 128. What does not fit is tried again by its client after a second.
    #[cfg(unix)]
    rustix::net::listen(&listener, BACKLOG).map_err(io::Error::from)?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::select! {
            () = accept(listener, service) => {}
            () = ended => {}
        }
        Ok::<(), io::Error>(())
    })?;
    // Whoever ends the server may not be able to stop a robot otherwise.
    hub.end("the end of the server");
    runtime.shutdown_timeout(GRACE);
    hub.give_back(GRACE);
    Ok(())
}

async fn accept(listener: tokio::net::TcpListener, service: Router) {
    let gate = Gate::new(CONNECTIONS.min(open_files() / 2), SILENCE);
    let lingering = Arc::new(Semaphore::new(LINGERING));
    let service = TowerToHyperService::new(service);
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // Too many open files: those that are open will end.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let (service, lingering) = (service.clone(), Arc::clone(&lingering));
        match gate.admit().await {
            Some((admitted, evicted)) => drop(tokio::spawn(async move {
                let (stream, end) = connected(stream, service, admitted, evicted).await;
                match end {
                    End::Served => linger(stream, &lingering).await,
                    End::Evicted => refuse(stream, &lingering).await,
                    End::Broken => {}
                }
            })),
            None => drop(tokio::spawn(async move { refuse(stream, &lingering).await })),
        }
    }
}

/// The end of a connection.
enum End {
    /// The last answer is sent.
    Served,
    /// Another connection needs its place.
    Evicted,
    /// The client went away, or was too slow.
    Broken,
}

/// Serves a connection until its end; gives the stream back.
async fn connected(
    stream: TcpStream,
    service: TowerToHyperService<Router>,
    admitted: Arc<Admitted>,
    evicted: oneshot::Receiver<()>,
) -> (TcpStream, End) {
    let spoken = Arc::clone(&admitted);
    let service = service_fn(move |request| {
        spoken.speak();
        Box::pin(service.call(request))
    });
    let mut connection = http1::Builder::new()
        .timer(TokioTimer::new())
        .header_read_timeout(SLOWEST_HEAD)
        .serve_connection(TokioIo::new(stream), service);
    let end = tokio::select! {
        served = poll_fn(|context| connection.poll_without_shutdown(context)) => match served {
            Ok(()) => End::Served,
            Err(_) => End::Broken,
        },
        Ok(()) = evicted => End::Evicted,
    };
    (connection.into_parts().io.into_inner(), end)
}

/// Tells a connection beyond the bound so, and ends it.
async fn refuse(mut stream: TcpStream, lingering: &Semaphore) {
    if let Ok(Ok(())) = tokio::time::timeout(Duration::from_secs(1), stream.write_all(FULL)).await {
        linger(stream, lingering).await;
    }
}

/// Ends a connection after its answer: reads for a moment what the client still sends, because the operating system drops the
/// answer of a connection that is closed with data unread.
async fn linger(mut stream: TcpStream, lingering: &Semaphore) {
    let Ok(_place) = lingering.try_acquire() else { return };
    if stream.shutdown().await.is_ok() {
        let rest = async { while matches!(stream.read(&mut [0; 4096]).await, Ok(1..)) {} };
        let _ = tokio::time::timeout(LINGER, rest).await;
    }
}

/// Raises the limit of open files of this program to what its bounds need, as far as it may; returns the limit.
#[cfg(unix)]
fn open_files() -> usize {
    use rustix::process::{Resource, Rlimit, getrlimit, setrlimit};
    let limit = getrlimit(Resource::Nofile);
    let most = limit.maximum.unwrap_or(u64::MAX);
    let current = limit.current.unwrap_or(u64::MAX);
    let wanted = OPEN_FILES.min(most);
    let raised = current < wanted
        && setrlimit(
            Resource::Nofile,
            Rlimit {
                current: Some(wanted),
                maximum: limit.maximum,
            },
        )
        .is_ok();
    usize::try_from(if raised { wanted } else { current }).unwrap_or(usize::MAX)
}

#[cfg(not(unix))]
fn open_files() -> usize {
    usize::MAX
}
