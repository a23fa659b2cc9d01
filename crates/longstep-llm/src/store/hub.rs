//! The model hub: downloads one file over HTTP and resumes after interruptions.

use std::path::Path;
use std::time::{Duration, Instant};

use reqwest::header::{CONTENT_RANGE, RANGE};
use reqwest::{Client, Response, StatusCode};

use super::verified::HashedFile;
use super::{PACE_BYTES, PullOptions, PullProgress, SourceFailure, Tell, part_path};
use crate::ModelError;
use crate::call::{self, Call, GivenUp, root};
use crate::catalogue::Entry;

/// Number of consecutive connections that may break without enough data.
const FRUITLESS: u32 = 3;

/// Number of connections that may break in one pull.
const TRIES: u32 = 50;

/// Longest time for the head of a response, including redirects.
const HEAD: Duration = Duration::from_secs(30);

/// Number of redirects to follow: the hub redirects to a file server.
const REDIRECTS: usize = 10;

/// Downloads the model's file to `path`.
pub(super) fn fetch(
    entry: &Entry,
    path: &Path,
    options: &PullOptions,
    tell: &mut Tell<'_>,
) -> Result<(), SourceFailure> {
    let (Some(repository), Some(file)) = (entry.hub_repository, entry.hub_file) else {
        return Err(SourceFailure::Source("this model is not published there".into()));
    };
    let url = format!("{}/{repository}/resolve/main/{file}", options.hub.trim_end_matches('/'));
    let client = call::client(REDIRECTS).map_err(SourceFailure::Source)?;
    let mut incoming = HashedFile::resume(part_path(path))?;
    let stopped = || options.stop.is_set();
    let call = Call::new(Duration::MAX, &stopped);
    let (mut fruitless, mut tries) = (0, 0);
    while incoming.written() < entry.bytes {
        let before = incoming.written();
        let mut download = Download {
            entry,
            patience: options.patience,
            call: &call,
            incoming: &mut incoming,
        };
        let outcome = call::run(download.run(&client, &url, tell));
        match outcome.map_err(|error| SourceFailure::Source(error.to_string()))? {
            Ok(()) => {}
            Err(Interrupted::Final(failure)) => return Err(failure),
            Err(Interrupted::Connection(reason)) => {
                tries += 1;
                let brought = incoming.written().saturating_sub(before);
                fruitless = if brought >= worth_a_try(entry.bytes) {
                    0
                } else {
                    fruitless + 1
                };
                if fruitless >= FRUITLESS || tries >= TRIES {
                    return Err(SourceFailure::Source(reason));
                }
                tell(PullProgress::Note(format!("Model hub: {reason}; resuming")));
                call.rest(Duration::from_millis(200) * fruitless)
                    .map_err(|_| ModelError::Stopped)?;
            }
        }
    }
    incoming.finish(entry, path, &url)?;
    Ok(())
}

/// Bytes that make a connection count as useful: 1 MiB, or 1 % of a small file.
fn worth_a_try(all: u64) -> u64 {
    (1 << 20).min(all / 100).max(1)
}

/// Reason why a download was interrupted.
enum Interrupted {
    /// The connection broke; the received part is kept.
    Connection(String),
    /// A retry would not help.
    Final(SourceFailure),
}

impl<T: Into<SourceFailure>> From<T> for Interrupted {
    fn from(failure: T) -> Self {
        Self::Final(failure.into())
    }
}

/// The part of a file that one connection transfers.
struct Download<'a> {
    entry: &'a Entry,
    patience: Duration,
    call: &'a Call<'a>,
    incoming: &'a mut HashedFile,
}

impl Download<'_> {
    async fn run(&mut self, client: &Client, url: &str, tell: &mut Tell<'_>) -> Result<(), Interrupted> {
        let mut request = client.get(url);
        let from = self.incoming.written();
        if from > 0 {
            request = request.header(RANGE, format!("bytes={from}-"));
        }
        let response = match self.call.wait(HEAD, request.send()).await {
            Ok(response) => response.map_err(|error| not_answered(&error))?,
            Err(GivenUp::Stopped) => return Err(ModelError::Stopped.into()),
            Err(GivenUp::Late | GivenUp::TimedOut) => {
                let reason = format!("cannot be reached (no answer within {} s)", HEAD.as_secs());
                return Err(SourceFailure::Source(reason).into());
            }
        };
        match response.status() {
            StatusCode::PARTIAL_CONTENT if starts_at(&response, from) => {}
            // The server ignores ranges and sends the whole file, or a different range.
            StatusCode::OK => self.incoming.restart()?,
            StatusCode::PARTIAL_CONTENT | StatusCode::RANGE_NOT_SATISFIABLE if from > 0 => {
                self.incoming.restart()?;
                return Err(Interrupted::Connection("the server cannot resume the file".into()));
            }
            status => {
                let reason = format!("it answered with status {}", status.as_u16());
                let busy = status.is_server_error() || status == StatusCode::TOO_MANY_REQUESTS;
                return Err(if busy {
                    Interrupted::Connection(reason)
                } else {
                    SourceFailure::Source(reason).into()
                });
            }
        }
        self.body(response, tell).await
    }

    async fn body(&mut self, mut response: Response, tell: &mut Tell<'_>) -> Result<(), Interrupted> {
        let (mut since, mut brought) = (Instant::now(), 0);
        loop {
            let patience = self.patience.saturating_sub(since.elapsed());
            let part = match self.call.wait(patience, response.chunk()).await {
                Ok(Ok(part)) => part,
                Ok(Err(error)) => {
                    let reason = format!("the connection broke ({})", root(&error));
                    return Err(Interrupted::Connection(reason));
                }
                Err(GivenUp::Stopped) => return Err(ModelError::Stopped.into()),
                Err(GivenUp::Late | GivenUp::TimedOut) => {
                    let seconds = self.patience.as_secs_f64();
                    let reason = format!("it sent less than {PACE_BYTES} bytes in {seconds} s");
                    return Err(Interrupted::Connection(reason));
                }
            };
            let Some(part) = part else { break };
            if self.incoming.written() + part.len() as u64 > self.entry.bytes {
                self.incoming.restart()?;
                return Err(SourceFailure::Source("the file there is larger than the catalogue says".into()).into());
            }
            self.incoming.write(&part)?;
            tell(PullProgress::Bytes {
                done: self.incoming.written(),
                total: self.entry.bytes,
            });
            brought += part.len() as u64;
            if brought >= PACE_BYTES {
                (since, brought) = (Instant::now(), 0);
            }
        }
        if self.incoming.written() < self.entry.bytes {
            return Err(Interrupted::Connection("the connection ended early".into()));
        }
        Ok(())
    }
}

/// Maps a request that got no response. A retry does not help without a network, in a redirect loop, or if the server
/// does not speak HTTP.
fn not_answered(error: &reqwest::Error) -> Interrupted {
    let reason = format!("cannot be reached ({})", root(error));
    let malformed = call::http_error(error).is_some_and(hyper::Error::is_parse);
    if error.is_connect() || error.is_redirect() || error.is_builder() || malformed {
        SourceFailure::Source(reason).into()
    } else {
        Interrupted::Connection(reason)
    }
}

fn starts_at(response: &Response, from: u64) -> bool {
    let range = response.headers().get(CONTENT_RANGE);
    let range = range.and_then(|range| range.to_str().ok()).unwrap_or_default();
    range.starts_with(&format!("bytes {from}-"))
}
