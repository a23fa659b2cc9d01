//! The live stream as server-sent events.

use std::collections::VecDeque;
use std::convert::Infallible;
use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Query, State};
use axum::http::HeaderMap;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use futures_util::stream;
use serde::Deserialize;
use tokio::sync::{OwnedSemaphorePermit, watch};

use super::Shared;
use crate::feed::{FeedEvent, Page};
use crate::problem::{Problem, ProblemKind};

/// The time between two signs of life.
const ALIVE: Duration = Duration::from_secs(15);

/// The most events that are read at once.
const AT_ONCE: usize = 500;

/// The events that a reader wants.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Wanted {
    /// Only events of this session.
    session: Option<String>,
    /// Only events of this run.
    run: Option<String>,
    /// The id of the last event that the reader has; the header `Last-Event-ID` counts more.
    after: Option<String>,
}

/// The time in which events gather before a reader looks: waking every reader for every event would take more time than
/// all requests.
const GATHER: Duration = Duration::from_millis(10);

/// A reader of the live stream.
struct Reader {
    shared: Shared,
    wanted: Wanted,
    /// The number of the last event that was looked at.
    number: u64,
    newest: watch::Receiver<u64>,
    ready: VecDeque<Arc<FeedEvent>>,
    /// An event with a number that the reader is told first.
    reset: Option<u64>,
    _permit: OwnedSemaphorePermit,
}

/// Streams events: from now on, or from the one after the id that the reader has. A reader that has missed events, or that
/// has the id of an earlier server, gets the event `reset` and reads the states anew.
pub(crate) async fn events(State(shared): State<Shared>, Query(wanted): Query<Wanted>, headers: HeaderMap) -> Response {
    let Ok(permit) = Arc::clone(&shared.readers).try_acquire_owned() else {
        return Problem::new(ProblemKind::Busy, "too many readers follow the events").into_response();
    };
    let newest = shared.hub.feed().newest();
    let had = headers
        .get("last-event-id")
        .and_then(|id| id.to_str().ok())
        .map(str::to_owned);
    let had = had.or_else(|| wanted.after.clone());
    let now = *newest.borrow();
    let number = match &had {
        Some(id) => id
            .strip_prefix(&*shared.boot)
            .and_then(|rest| rest.strip_prefix('-')?.parse().ok()),
        None => Some(now),
    };
    let reader = Reader {
        reset: number.is_none().then_some(now),
        number: number.unwrap_or(now),
        shared,
        wanted,
        newest,
        ready: VecDeque::new(),
        _permit: permit,
    };
    let stream = stream::unfold(reader, |mut reader| async move {
        let event = reader.next().await?;
        Some((Ok::<_, Infallible>(event), reader))
    });
    Sse::new(stream)
        .keep_alive(KeepAlive::new().interval(ALIVE))
        .into_response()
}

impl Reader {
    async fn next(&mut self) -> Option<Event> {
        loop {
            if let Some(number) = self.reset.take() {
                return Some(self.event("reset", number, "{}"));
            }
            if let Some(event) = self.ready.pop_front() {
                let data = serde_json::to_string(&*event).unwrap_or_default();
                return Some(self.event("happened", event.number, &data));
            }
            self.newest.borrow_and_update();
            match self.shared.hub.feed().after(self.number, AT_ONCE) {
                Page::Gone(newest) => {
                    self.number = newest;
                    self.reset = Some(newest);
                }
                Page::Events(events) => match events.last() {
                    Some(last) => {
                        self.number = last.number;
                        let wanted = events.into_iter().filter(|event| self.is_wanted(event));
                        self.ready = wanted.collect();
                    }
                    None => {
                        self.newest.changed().await.ok()?;
                        tokio::time::sleep(GATHER).await;
                    }
                },
            }
        }
    }

    fn is_wanted(&self, event: &FeedEvent) -> bool {
        let is_session = self
            .wanted
            .session
            .as_deref()
            .is_none_or(|id| event.happening.session().as_str() == id);
        let run = event.happening.run().map(|run| run.as_str());
        is_session && self.wanted.run.as_deref().is_none_or(|id| run == Some(id))
    }

    fn event(&self, kind: &str, number: u64, data: &str) -> Event {
        Event::default()
            .event(kind)
            .id(format!("{}-{number}", self.shared.boot))
            .data(data)
    }
}
