//! Locks that are held for one session at a time, without one for each.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::id::SessionId;

/// Locks that the sessions share: two sessions rarely have the same one.
#[derive(Debug)]
pub(crate) struct SessionLocks([Mutex<()>; 64]);

impl Default for SessionLocks {
    fn default() -> Self {
        Self(std::array::from_fn(|_| Mutex::default()))
    }
}

impl SessionLocks {
    /// Waits until nobody else holds the lock of a session.
    pub(crate) fn lock(&self, id: &SessionId) -> MutexGuard<'_, ()> {
        let mut hasher = DefaultHasher::new();
        id.hash(&mut hasher);
        // The remainder is less than 64.
        let index = usize::try_from(hasher.finish() % self.0.len() as u64).unwrap_or_default();
        self.0[index].lock().unwrap_or_else(PoisonError::into_inner)
    }
}
