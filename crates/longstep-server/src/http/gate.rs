//! The bound on connections. A connection that has not sent a request makes room for a new one, so that idle connections,
//! which need no token, keep nobody out. It has a moment to send one: until then new connections wait in the queue of the
//! operating system, because a flood would evict those that are about to speak otherwise.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};
use tokio::time::{Instant, timeout_at};

/// The places of a server for connections.
#[derive(Debug)]
pub(super) struct Gate {
    places: Arc<Semaphore>,
    /// The time for which a connection may be silent before another one gets its place.
    grace: Duration,
    silent: Mutex<Silent>,
}

/// The connections that have sent no request so far, in the order of their arrival.
#[derive(Debug, Default)]
struct Silent {
    next: u64,
    held: BTreeMap<u64, Held>,
}

/// The place of a silent connection, and the way to end it.
#[derive(Debug)]
struct Held {
    since: Instant,
    place: OwnedSemaphorePermit,
    evict: oneshot::Sender<()>,
}

/// A connection with a place, which it gives back when it is dropped.
#[derive(Debug)]
pub(super) struct Admitted {
    gate: Arc<Gate>,
    number: u64,
    /// The place, from the first request on.
    place: Mutex<Option<OwnedSemaphorePermit>>,
}

impl Gate {
    /// Creates a gate with so many places, which a silent connection has to itself for a time of `grace`.
    pub(super) fn new(places: usize, grace: Duration) -> Arc<Self> {
        Arc::new(Self {
            places: Arc::new(Semaphore::new(places)),
            grace,
            silent: Mutex::default(),
        })
    }

    fn silent(&self) -> MutexGuard<'_, Silent> {
        self.silent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives a connection a place, and the receiver of its eviction. If all are taken, it is that of the connection that has
    /// been silent for the longest time, as soon as its time of grace is over. None if no connection is silent.
    pub(super) async fn admit(self: &Arc<Self>) -> Option<(Arc<Admitted>, oneshot::Receiver<()>)> {
        loop {
            if let Ok(place) = Arc::clone(&self.places).try_acquire_owned() {
                return Some(self.hold(place));
            }
            let patience = {
                let mut silent = self.silent();
                let oldest = silent.held.first_entry()?;
                let patience = oldest.get().since + self.grace;
                if patience <= Instant::now() {
                    let oldest = oldest.remove();
                    drop(silent);
                    // It may have ended already.
                    let _ = oldest.evict.send(());
                    return Some(self.hold(oldest.place));
                }
                patience
            };
            // Meanwhile a connection may end, or the oldest one may speak.
            if let Ok(Ok(place)) = timeout_at(patience, Arc::clone(&self.places).acquire_owned()).await {
                return Some(self.hold(place));
            }
        }
    }

    /// Gives a place to a connection that is silent so far.
    fn hold(self: &Arc<Self>, place: OwnedSemaphorePermit) -> (Arc<Admitted>, oneshot::Receiver<()>) {
        let (evict, evicted) = oneshot::channel();
        let mut silent = self.silent();
        let number = silent.next;
        silent.next += 1;
        let since = Instant::now();
        silent.held.insert(number, Held { since, place, evict });
        drop(silent);
        let admitted = Admitted {
            gate: Arc::clone(self),
            number,
            place: Mutex::default(),
        };
        (Arc::new(admitted), evicted)
    }
}

impl Admitted {
    /// Notes that the connection has sent a request: it keeps its place until it ends.
    pub(super) fn speak(&self) {
        let mut place = self.place.lock().unwrap_or_else(PoisonError::into_inner);
        if place.is_none() {
            *place = self.gate.silent().held.remove(&self.number).map(|held| held.place);
        }
    }
}

impl Drop for Admitted {
    fn drop(&mut self) {
        self.gate.silent().held.remove(&self.number);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const GRACE: Duration = Duration::from_millis(50);

    #[tokio::test]
    async fn a_silent_connection_makes_room_and_one_with_a_request_does_not() {
        let gate = Gate::new(2, Duration::ZERO);
        let (first, mut first_evicted) = gate.admit().await.unwrap();
        let (second, mut second_evicted) = gate.admit().await.unwrap();
        first.speak();
        let (third, mut third_evicted) = gate.admit().await.unwrap();
        assert!(first_evicted.try_recv().is_err() && second_evicted.try_recv().is_ok());
        third.speak();
        assert!(gate.admit().await.is_none() && third_evicted.try_recv().is_err());
        // The place of the second is that of the third now.
        drop(second);
        assert!(gate.admit().await.is_none());
        drop(first);
        assert!(gate.admit().await.is_some());
    }

    #[tokio::test]
    async fn a_connection_keeps_its_place_for_its_time_of_grace() {
        let gate = Gate::new(1, GRACE);
        let began = Instant::now();
        let (_first, mut evicted) = gate.admit().await.unwrap();
        assert!(gate.admit().await.is_some() && evicted.try_recv().is_ok());
        assert!(began.elapsed() >= GRACE);
    }

    #[tokio::test]
    async fn what_happens_in_the_time_of_grace_decides_about_the_next_connection() {
        type Event = fn(Arc<Admitted>);
        let speaks: Event = |admitted| {
            admitted.speak();
            // It stays.
            std::mem::forget(admitted);
        };
        for (event, is_admitted) in [(speaks, false), (drop as Event, true)] {
            let gate = Gate::new(1, GRACE);
            let (first, mut evicted) = gate.admit().await.unwrap();
            let (next, ()) = tokio::join!(gate.admit(), async {
                tokio::task::yield_now().await;
                event(first);
            });
            assert_eq!(next.is_some(), is_admitted);
            assert!(evicted.try_recv().is_err(), "nobody was evicted");
        }
    }

    #[tokio::test]
    async fn a_connection_that_ends_gives_its_place_back() {
        let gate = Gate::new(1, GRACE);
        for is_silent in [true, false, true] {
            let (own, _evicted) = gate.admit().await.unwrap();
            if !is_silent {
                own.speak();
            }
            drop(own);
            assert_eq!(gate.places.available_permits(), 1);
        }
    }
}
