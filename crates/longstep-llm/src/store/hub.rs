//! The model hub: one file over HTTP, resumed where it stopped.

use std::io::Read;
use std::path::Path;
use std::time::Duration;

use ureq::Agent;
use ureq::http::{StatusCode, header};

use super::verified::Incoming;
use super::{Failure, PullProgress, Tell};
use crate::catalogue::Entry;

/// How often in a row a connection may break without having brought anything.
const FRUITLESS: u32 = 3;

/// Downloads the file to its place.
pub(super) fn fetch(entry: &Entry, path: &Path, hub: &str, tell: &mut Tell<'_>) -> Result<(), Failure> {
    let (Some(repository), Some(file)) = (entry.hub_repository, entry.hub_file) else {
        return Err(Failure::Source("this model is not published there".into()));
    };
    let url = format!("{}/{repository}/resolve/main/{file}", hub.trim_end_matches('/'));
    let agent = agent();
    let mut incoming = Incoming::resume(path.with_extension("gguf.part"))?;
    let mut fruitless = 0;
    while incoming.written() < entry.bytes {
        let before = incoming.written();
        match download(&agent, &url, entry, &mut incoming, tell) {
            Ok(()) => {}
            Err(Interrupted::Final(failure)) => return Err(failure),
            Err(Interrupted::Connection(reason)) => {
                fruitless = if incoming.written() > before { 0 } else { fruitless + 1 };
                if fruitless >= FRUITLESS {
                    return Err(Failure::Source(reason));
                }
                tell(PullProgress::Note(format!("model hub: {reason}; going on")));
                std::thread::sleep(Duration::from_millis(200) * fruitless);
            }
        }
    }
    incoming.finish(entry, path, &url)?;
    Ok(())
}

fn agent() -> Agent {
    let config = Agent::config_builder()
        .http_status_as_error(false)
        .timeout_connect(Some(Duration::from_secs(10)))
        .timeout_recv_response(Some(Duration::from_secs(30)))
        .timeout_per_read(Some(Duration::from_secs(60)))
        .user_agent(concat!("longstep/", env!("CARGO_PKG_VERSION")))
        .build();
    config.new_agent()
}

/// Why a download stopped before its end.
enum Interrupted {
    /// The connection broke; what came so far is kept.
    Connection(String),
    /// Trying again is no use.
    Final(Failure),
}

impl<T: Into<Failure>> From<T> for Interrupted {
    fn from(failure: T) -> Self {
        Self::Final(failure.into())
    }
}

fn download(
    agent: &Agent,
    url: &str,
    entry: &Entry,
    incoming: &mut Incoming,
    tell: &mut Tell<'_>,
) -> Result<(), Interrupted> {
    let mut request = agent.get(url);
    let from = incoming.written();
    if from > 0 {
        request = request.header(header::RANGE, format!("bytes={from}-"));
    }
    let response = request.call().map_err(|error| not_answered(&error))?;
    match response.status() {
        StatusCode::PARTIAL_CONTENT if starts_at(&response, from) => {}
        // The server does not do ranges and sends everything, or something else than asked for.
        StatusCode::OK => incoming.restart()?,
        StatusCode::PARTIAL_CONTENT | StatusCode::RANGE_NOT_SATISFIABLE if from > 0 => {
            incoming.restart()?;
            return Err(Interrupted::Connection("the server cannot go on with the file".into()));
        }
        status if status.is_server_error() || status == StatusCode::TOO_MANY_REQUESTS => {
            return Err(Interrupted::Connection(format!(
                "it answered with status {}",
                status.as_u16()
            )));
        }
        status => {
            let reason = format!("it answered with status {}", status.as_u16());
            return Err(Failure::Source(reason).into());
        }
    }
    let mut body = response.into_body().into_reader();
    let mut buffer = vec![0; 1 << 18];
    loop {
        let read = body
            .read(&mut buffer)
            .map_err(|error| Interrupted::Connection(format!("the connection broke ({error})")))?;
        let Some(part) = buffer.get(..read).filter(|part| !part.is_empty()) else {
            break;
        };
        if incoming.written() + read as u64 > entry.bytes {
            incoming.restart()?;
            return Err(Failure::Source("the file there is larger than the catalogue says".into()).into());
        }
        incoming.write(part)?;
        let done = incoming.written();
        let total = entry.bytes;
        tell(PullProgress::Bytes { done, total });
    }
    if incoming.written() < entry.bytes {
        return Err(Interrupted::Connection("the connection ended early".into()));
    }
    Ok(())
}

/// No answer at all: no network, most likely, so that trying again at once is no use.
fn not_answered(error: &ureq::Error) -> Interrupted {
    let reason = format!("cannot be reached ({error})");
    match error {
        ureq::Error::HostNotFound | ureq::Error::ConnectionFailed | ureq::Error::Timeout(_) => {
            Failure::Source(reason).into()
        }
        ureq::Error::Io(io) if io.kind() == std::io::ErrorKind::ConnectionRefused => Failure::Source(reason).into(),
        _ => Interrupted::Connection(reason),
    }
}

fn starts_at<T>(response: &ureq::http::Response<T>, from: u64) -> bool {
    let range = response.headers().get(header::CONTENT_RANGE);
    let range = range.and_then(|range| range.to_str().ok()).unwrap_or_default();
    range.starts_with(&format!("bytes {from}-"))
}
