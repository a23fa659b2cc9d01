//! The bound on connections. A connection that has not sent a request makes room for a new one, so that idle connections,
//! which need no token, keep nobody out.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use tokio::sync::{OwnedSemaphorePermit, Semaphore, oneshot};

/// The places of a server for connections.
#[derive(Debug)]
pub(super) struct Gate {
    places: Arc<Semaphore>,
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
    /// Creates a gate with so many places.
    pub(super) fn new(places: usize) -> Arc<Self> {
        Arc::new(Self {
            places: Arc::new(Semaphore::new(places)),
            silent: Mutex::default(),
        })
    }

    fn silent(&self) -> MutexGuard<'_, Silent> {
        self.silent.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Gives a connection a place, and the receiver of its eviction. If all are taken, it is that of the connection that has
    /// been silent for the longest time. None if no connection is silent.
    pub(super) fn admit(self: &Arc<Self>) -> Option<(Arc<Admitted>, oneshot::Receiver<()>)> {
        let mut silent = self.silent();
        let place = match Arc::clone(&self.places).try_acquire_owned() {
            Ok(place) => place,
            Err(_) => {
                let (_, oldest) = silent.held.pop_first()?;
                // It may have ended already.
                let _ = oldest.evict.send(());
                oldest.place
            }
        };
        let (evict, evicted) = oneshot::channel();
        let number = silent.next;
        silent.next += 1;
        silent.held.insert(number, Held { place, evict });
        drop(silent);
        let admitted = Admitted {
            gate: Arc::clone(self),
            number,
            place: Mutex::default(),
        };
        Some((Arc::new(admitted), evicted))
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

    #[test]
    fn a_silent_connection_makes_room_and_one_with_a_request_does_not() {
        let gate = Gate::new(2);
        let (first, mut first_evicted) = gate.admit().unwrap();
        let (second, mut second_evicted) = gate.admit().unwrap();
        first.speak();
        let (third, mut third_evicted) = gate.admit().unwrap();
        assert!(first_evicted.try_recv().is_err() && second_evicted.try_recv().is_ok());
        third.speak();
        assert!(gate.admit().is_none() && third_evicted.try_recv().is_err());
        // The place of the second is that of the third now.
        drop(second);
        assert!(gate.admit().is_none());
        drop(first);
        assert!(gate.admit().is_some());
    }

    #[test]
    fn a_connection_that_ends_gives_its_place_back() {
        let gate = Gate::new(1);
        for is_silent in [true, false, true] {
            let (own, _evicted) = gate.admit().unwrap();
            if !is_silent {
                own.speak();
            }
            drop(own);
            assert_eq!(gate.places.available_permits(), 1);
        }
    }
}
