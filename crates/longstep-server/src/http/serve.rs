//! Connections.

use std::future::Future;
use std::io;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use axum::Router;
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::io::AsyncWriteExt;
use tokio::net::TcpStream;
use tokio::sync::Semaphore;

use super::Shared;
use super::access::Access;
use super::router::{guard, routes};
use crate::hub::Hub;
#[cfg(feature = "mcp")]
use crate::mcp::{McpOptions, http_service};

/// The most connections at a time.
const CONNECTIONS: usize = 1_024;

/// The time in which the head of a request arrives.
const SLOWEST_HEAD: Duration = Duration::from_secs(15);

/// The time in which requests end after the server was asked to end.
const GRACE: Duration = Duration::from_secs(5);

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

/// Serves a hub until `ended` completes; then stops all robots. Blocks the thread.
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
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener)?;
        tokio::select! {
            () = accept(listener, service) => {}
            () = ended => {}
        }
        Ok::<(), io::Error>(())
    })?;
    // Whoever ends the server may not be able to stop a robot otherwise.
    let _ = hub.stop_all("the end of the server");
    runtime.shutdown_timeout(GRACE);
    Ok(())
}

async fn accept(listener: tokio::net::TcpListener, service: Router) {
    let connections = Arc::new(Semaphore::new(CONNECTIONS));
    loop {
        let Ok((stream, _)) = listener.accept().await else {
            // Too many open files: those that are open will end.
            tokio::time::sleep(Duration::from_millis(50)).await;
            continue;
        };
        let service = service.clone();
        match Arc::clone(&connections).try_acquire_owned() {
            Ok(permit) => drop(tokio::spawn(async move {
                let service = TowerToHyperService::new(service);
                let _ = http1::Builder::new()
                    .timer(TokioTimer::new())
                    .header_read_timeout(SLOWEST_HEAD)
                    .serve_connection(TokioIo::new(stream), service)
                    .await;
                drop(permit);
            })),
            Err(_) => drop(tokio::spawn(refuse(stream))),
        }
    }
}

/// Tells a connection beyond the bound so, and ends it.
async fn refuse(mut stream: TcpStream) {
    let _ = tokio::time::timeout(Duration::from_secs(1), stream.write_all(FULL)).await;
}
