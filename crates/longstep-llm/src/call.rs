//! Waiting for a network: every wait has an end, and can be called off.

use std::error::Error;
use std::time::{Duration, Instant};

use crate::ModelError;

/// The interval at which a wait looks for a request to stop.
pub(crate) const TICK: Duration = Duration::from_millis(50);

/// The longest time for a connection: name, TCP and TLS.
pub(crate) const CONNECT: Duration = Duration::from_secs(10);

/// Why work with a server was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GivenUp {
    /// The person does not want the answer any more.
    Stopped,
    /// The time for one piece of work is over.
    Late,
    /// The time for the whole call is over.
    TimedOut,
}

/// One call: its deadline, and the person who may call it off.
pub(crate) struct Call<'a> {
    began: Instant,
    time: Duration,
    stopped: &'a dyn Fn() -> bool,
}

impl<'a> Call<'a> {
    pub(crate) fn new(time: Duration, stopped: &'a dyn Fn() -> bool) -> Self {
        Self {
            began: Instant::now(),
            time,
            stopped,
        }
    }

    /// The time that is left of the call.
    pub(crate) fn left(&self) -> Duration {
        self.time.saturating_sub(self.began.elapsed())
    }

    pub(crate) fn stopped(&self) -> bool {
        (self.stopped)()
    }

    /// Waits for `work`, at most for `patience`, and no longer than the call may take. Looks every [`TICK`] for a request
    /// to stop.
    pub(crate) async fn wait<T>(&self, patience: Duration, work: impl Future<Output = T>) -> Result<T, GivenUp> {
        let mut work = std::pin::pin!(work);
        let began = Instant::now();
        loop {
            if self.stopped() {
                return Err(GivenUp::Stopped);
            }
            let left = self.left();
            if left.is_zero() {
                return Err(GivenUp::TimedOut);
            }
            let patience = patience.saturating_sub(began.elapsed());
            if patience.is_zero() {
                return Err(GivenUp::Late);
            }
            let tick = TICK.min(left).min(patience);
            if let Ok(done) = tokio::time::timeout(tick, work.as_mut()).await {
                return Ok(done);
            }
        }
    }

    /// Pauses between two tries.
    pub(crate) fn rest(&self, pause: Duration) -> Result<(), GivenUp> {
        let began = Instant::now();
        loop {
            if self.stopped() {
                return Err(GivenUp::Stopped);
            }
            let rest = pause.saturating_sub(began.elapsed());
            if rest.is_zero() {
                return Ok(());
            }
            std::thread::sleep(rest.min(TICK));
        }
    }

    /// The error for a call whose time is over.
    pub(crate) fn timed_out(&self, server: &str) -> ModelError {
        ModelError::TimedOut {
            server: server.to_owned(),
            seconds: self.time.as_secs_f64(),
        }
    }
}

/// A client for HTTP that follows so many redirects.
pub(crate) fn client(redirects: usize) -> Result<reqwest::Client, String> {
    // A program that has chosen its cryptography already keeps it.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let policy = match redirects {
        0 => reqwest::redirect::Policy::none(),
        most => reqwest::redirect::Policy::limited(most),
    };
    let client = reqwest::Client::builder()
        .connect_timeout(CONNECT)
        .redirect(policy)
        // Between calls nobody would notice that a server hung up.
        .pool_max_idle_per_host(0)
        .user_agent(concat!("longstep/", env!("CARGO_PKG_VERSION")))
        .build();
    client.map_err(|error| root(&error))
}

/// Runs to the end, on this thread alone. What is still under way afterwards (a connection, a name being looked up) is
/// let go.
pub(crate) fn run<T>(work: impl Future<Output = T>) -> std::io::Result<T> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let outcome = runtime.block_on(work);
    runtime.shutdown_background();
    Ok(outcome)
}

/// The error at the bottom of another: those above it name the address, which may have a password in it.
pub(crate) fn root(error: &(dyn Error + 'static)) -> String {
    let mut deepest = error;
    while let Some(source) = deepest.source() {
        deepest = source;
    }
    deepest.to_string()
}

/// The error of the HTTP parser under another, if there is one.
pub(crate) fn http_error(error: &reqwest::Error) -> Option<&hyper::Error> {
    let mut source = error.source();
    while let Some(error) = source {
        if let Some(error) = error.downcast_ref() {
            return Some(error);
        }
        source = error.source();
    }
    None
}
