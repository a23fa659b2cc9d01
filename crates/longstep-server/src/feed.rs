//! The live stream of what happens, which many readers follow.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use serde::Serialize;
use tokio::sync::watch;

use crate::id::{RunId, SessionId};

/// The most events that are kept for readers that come later or read slowly.
const KEPT: usize = 20_000;

/// Something that happened: where, and how to learn more. The state itself is read from the session or the run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(tag = "kind", rename_all = "snake_case")]
#[non_exhaustive]
pub enum Happening {
    /// A session has another state.
    Session {
        /// The session.
        session: SessionId,
        /// Its state, as in its view.
        state: &'static str,
    },
    /// A run has another event in its log.
    Run {
        /// The run.
        run: RunId,
        /// The session of its plan.
        session: SessionId,
        /// The number of the last event in its log.
        event: usize,
        /// The state of the run, as in its view.
        state: &'static str,
    },
    /// A model works for a session.
    Progress {
        /// The session.
        session: SessionId,
        /// The work, for a person.
        text: String,
    },
}

impl Happening {
    /// Returns the session that it concerns.
    pub fn session(&self) -> &SessionId {
        match self {
            Self::Session { session, .. } | Self::Run { session, .. } | Self::Progress { session, .. } => session,
        }
    }

    /// Returns the run that it concerns.
    pub fn run(&self) -> Option<&RunId> {
        match self {
            Self::Run { run, .. } => Some(run),
            _ => None,
        }
    }
}

/// An event of the stream.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct FeedEvent {
    /// Its number, from 1, since the server began.
    pub number: u64,
    /// The change.
    #[serde(flatten)]
    pub happening: Happening,
}

/// The answer to a reader.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub enum Page {
    /// The events after the number that the reader had, in order; empty if there is none.
    Events(Vec<Arc<FeedEvent>>),
    /// Events that the reader did not get are gone, so that it must read the states anew. The number to go on from.
    Gone(u64),
}

/// The stream: the last events, with the number of the newest.
///
/// A reader asks for what comes after its last number, so a slow one holds nothing up and costs nothing.
#[derive(Debug)]
pub struct Feed {
    kept: Mutex<VecDeque<Arc<FeedEvent>>>,
    newest: watch::Sender<u64>,
}

impl Default for Feed {
    fn default() -> Self {
        Self {
            kept: Mutex::default(),
            newest: watch::channel(0).0,
        }
    }
}

impl Feed {
    fn kept(&self) -> MutexGuard<'_, VecDeque<Arc<FeedEvent>>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Adds an event.
    pub fn publish(&self, happening: Happening) {
        let mut kept = self.kept();
        let number = *self.newest.borrow() + 1;
        if kept.len() == KEPT {
            kept.pop_front();
        }
        kept.push_back(Arc::new(FeedEvent { number, happening }));
        // Under the lock, so that numbers are announced in order.
        self.newest.send_replace(number);
    }

    /// Returns the number of the newest event, which changes with each.
    pub fn newest(&self) -> watch::Receiver<u64> {
        self.newest.subscribe()
    }

    /// Returns at most `limit` events after a number.
    pub fn after(&self, number: u64, limit: usize) -> Page {
        let kept = self.kept();
        let newest = *self.newest.borrow();
        let first = kept.front().map_or(newest + 1, |event| event.number);
        if number > newest || number + 1 < first {
            return Page::Gone(newest);
        }
        let skipped = usize::try_from(number + 1 - first).unwrap_or(usize::MAX);
        Page::Events(kept.iter().skip(skipped).take(limit).cloned().collect())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn happening() -> Happening {
        Happening::Session {
            session: SessionId::parse("s").unwrap(),
            state: "ready",
        }
    }

    #[test]
    fn a_reader_gets_every_event_once_or_learns_that_some_are_gone() {
        let feed = Feed::default();
        assert!(matches!(feed.after(0, 10), Page::Events(events) if events.is_empty()));
        assert!(matches!(feed.after(7, 10), Page::Gone(0)));
        for _ in 0..KEPT + 5 {
            feed.publish(happening());
        }
        assert!(matches!(feed.after(4, 10), Page::Gone(newest) if newest == KEPT as u64 + 5));
        let (mut number, mut read) = (5, 0);
        while let Page::Events(events) = feed.after(number, 1_000) {
            let Some(last) = events.last() else { break };
            assert!(
                events
                    .iter()
                    .zip(number + 1..)
                    .all(|(event, expected)| event.number == expected)
            );
            (number, read) = (last.number, read + events.len());
        }
        assert_eq!((read, number), (KEPT, KEPT as u64 + 5));
    }
}
