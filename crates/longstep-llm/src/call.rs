//! Network calls: every wait has a limit and can be cancelled.

use std::error::Error;
use std::time::{Duration, Instant};

use crate::ModelError;

/// Interval at which a wait checks for cancellation.
pub(crate) const TICK: Duration = Duration::from_millis(50);

/// Longest time to connect: name resolution, TCP and TLS.
pub(crate) const CONNECT: Duration = Duration::from_secs(10);

/// Reason why a call was given up.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum GivenUp {
    /// The user cancelled the call.
    Stopped,
    /// One operation of the call took too long.
    Late,
    /// The call as a whole took too long.
    TimedOut,
}

/// One call: its start, its time limit and the check for cancellation.
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

    /// The remaining time of the call.
    pub(crate) fn left(&self) -> Duration {
        self.time.saturating_sub(self.began.elapsed())
    }

    pub(crate) fn stopped(&self) -> bool {
        (self.stopped)()
    }

    /// Waits for `work`, at most for `patience` and the remaining time of the call. Checks for cancellation every
    /// [`TICK`].
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

    /// Pauses between two attempts.
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

    /// The error for a call that exceeded its time limit.
    pub(crate) fn timed_out(&self, server: &str) -> ModelError {
        ModelError::TimedOut {
            server: server.to_owned(),
            seconds: self.time.as_secs_f64(),
        }
    }
}

/// An HTTP client that follows up to `redirects` redirects.
pub(crate) fn client(redirects: usize) -> Result<reqwest::Client, String> {
    // A program that has installed its own cryptography provider keeps it.
    let _ = rustls::crypto::ring::default_provider().install_default();
    let policy = match redirects {
        0 => reqwest::redirect::Policy::none(),
        most => reqwest::redirect::Policy::limited(most),
    };
    let client = reqwest::Client::builder()
        .connect_timeout(CONNECT)
        .redirect(policy)
        // An idle connection does not notice when the server closes it.
        .pool_max_idle_per_host(0)
        .user_agent(concat!("longstep/", env!("CARGO_PKG_VERSION")))
        .build();
    client.map_err(|error| root(&error))
}

/// Runs `work` to its end on the current thread. Afterwards pending operations (connecting, resolving a name) are
/// dropped.
pub(crate) fn run<T>(work: impl Future<Output = T>) -> std::io::Result<T> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build()?;
    let outcome = runtime.block_on(work);
    runtime.shutdown_background();
    Ok(outcome)
}

/// The innermost source of an error. The outer errors contain the address, which may include a password.
pub(crate) fn root(error: &(dyn Error + 'static)) -> String {
    let mut deepest = error;
    while let Some(source) = deepest.source() {
        deepest = source;
    }
    deepest.to_string()
}

/// The HTTP parser's error among the sources of `error`, if there is one.
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
