//! Leases: rights to add to a log that end by themselves.

use std::collections::HashMap;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};
use std::time::{Duration, Instant};

use longstep_files::LOG_LIMIT;

use super::connection::Connection;
use super::{Key, key};
use crate::store::{Durability, LogName, OwnedLog, StoreError};

/// Takes a log that nobody owns, and makes it if there is none. The row is locked meanwhile, so of two one is refused.
const TAKE: &str = "
INSERT INTO longstep_log AS log (kind, id, owner, epoch, expires)
VALUES ($1, $2, $3, 1, clock_timestamp() + make_interval(secs => $4))
ON CONFLICT (kind, id) DO UPDATE SET owner = excluded.owner, epoch = log.epoch + 1,
    expires = clock_timestamp() + make_interval(secs => $4)
WHERE log.owner IS NULL OR log.expires <= clock_timestamp()
RETURNING epoch, length";

const RENEW: &str = "
UPDATE longstep_log AS log SET expires = clock_timestamp() + make_interval(secs => $2)
FROM unnest($3::text[], $4::text[], $5::bigint[]) AS mine (kind, id, epoch)
WHERE log.kind = mine.kind AND log.id = mine.id AND log.epoch = mine.epoch AND log.owner = $1
    AND log.expires > clock_timestamp()
RETURNING log.kind, log.id";

const GIVE_BACK: &str =
    "UPDATE longstep_log SET owner = NULL WHERE kind = $1 AND id = $2 AND owner = $3 AND epoch = $4";

/// Adds lines in one transaction with the check that the lease holds and that the log is as its owner knows it.
const APPEND: &str = "
WITH grown AS (
    UPDATE longstep_log SET length = length + $7, changed_at = clock_timestamp()
    WHERE kind = $1 AND id = $2 AND owner = $3 AND epoch = $4 AND length = $5 AND expires > clock_timestamp()
    RETURNING kind, id
)
INSERT INTO longstep_line (kind, id, place, epoch, text) SELECT kind, id, $5, $4, $6 FROM grown";

/// The append that does not wait for the disk.
const APPEND_LATER: &str = "
WITH later AS MATERIALIZED (SELECT set_config('synchronous_commit', 'off', true)),
grown AS (
    UPDATE longstep_log SET length = length + $7, changed_at = clock_timestamp() FROM later
    WHERE kind = $1 AND id = $2 AND owner = $3 AND epoch = $4 AND length = $5 AND expires > clock_timestamp()
    RETURNING kind, id
)
INSERT INTO longstep_line (kind, id, place, epoch, text) SELECT kind, id, $5, $4, $6 FROM grown";

/// Adds lines to a log that servers share.
const ADD: &str = "
WITH grown AS (
    UPDATE longstep_log SET length = length + $4, changed_at = clock_timestamp() WHERE kind = $1 AND id = $2
    RETURNING kind, id, length - $4 AS place
)
INSERT INTO longstep_line (kind, id, place, epoch, text) SELECT kind, id, place, 0, $3 FROM grown";

/// The leases of a server.
#[derive(Debug)]
pub(super) struct Leases {
    pub(super) connection: Connection,
    /// The server: a random name, so that one that is started again is another.
    owner: String,
    time: Duration,
    held: Mutex<HashMap<Key, Arc<Right>>>,
}

/// The right to add to one log.
#[derive(Debug)]
struct Right {
    epoch: i64,
    /// When it ends here: before it ends in the database, which counts from a later moment.
    ends: Mutex<Instant>,
    is_lost: AtomicBool,
}

impl Right {
    fn is_lost(&self) -> bool {
        self.is_lost.load(Ordering::SeqCst)
            || Instant::now() >= *self.ends.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Leases {
    pub(super) fn new(connection: Connection, owner: String, time: Duration) -> Arc<Self> {
        let leases = Arc::new(Self {
            connection,
            owner,
            time,
            held: Mutex::default(),
        });
        let weak = Arc::downgrade(&leases);
        leases.connection.spawn(keep_renewed(weak, time));
        leases
    }

    fn held(&self) -> MutexGuard<'_, HashMap<Key, Arc<Right>>> {
        self.held.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the end, here, of a lease for which a request is sent now.
    fn end_from(&self, sent: Instant) -> Instant {
        sent + self.time * 9 / 10
    }

    /// Takes a log that nobody owns.
    pub(super) fn take(self: &Arc<Self>, log: &LogName) -> Result<OwnedRow, StoreError> {
        let (kind, id) = key(log);
        let (pool, owner, seconds) = (
            self.connection.pool.clone(),
            self.owner.clone(),
            self.time.as_secs_f64(),
        );
        let (sent, bound) = (Instant::now(), id.clone());
        let taken: Option<(i64, i64)> = self.connection.wait(async move {
            let query = sqlx::query_as(TAKE).bind(kind).bind(bound).bind(owner).bind(seconds);
            query.fetch_optional(&pool).await
        })?;
        let Some((epoch, length)) = taken else {
            return Err(StoreError::Taken(log.words()));
        };
        let right = Arc::new(Right {
            epoch,
            ends: Mutex::new(self.end_from(sent)),
            is_lost: AtomicBool::new(false),
        });
        self.held().insert((kind, id), Arc::clone(&right));
        Ok(OwnedRow {
            leases: Arc::clone(self),
            log: log.clone(),
            right,
            length: Mutex::new(length),
        })
    }

    /// Renews all leases. Those that ended meanwhile are lost.
    async fn renew(&self) -> Result<(), sqlx::Error> {
        let mine: Vec<(Key, Arc<Right>)> = self
            .held()
            .iter()
            .filter(|(_, right)| !right.is_lost())
            .map(|(key, right)| (key.clone(), Arc::clone(right)))
            .collect();
        if mine.is_empty() {
            return Ok(());
        }
        let sent = Instant::now();
        let kinds: Vec<&str> = mine.iter().map(|((kind, _), _)| *kind).collect();
        let ids: Vec<&str> = mine.iter().map(|((_, id), _)| id.as_str()).collect();
        let epochs: Vec<i64> = mine.iter().map(|(_, right)| right.epoch).collect();
        let query = sqlx::query_as(RENEW)
            .bind(&self.owner)
            .bind(self.time.as_secs_f64())
            .bind(kinds)
            .bind(ids)
            .bind(epochs);
        let renewed: Vec<(String, String)> = query.fetch_all(&self.connection.reserved).await?;
        for ((kind, id), right) in mine {
            if renewed.iter().any(|(one, other)| one == kind && *other == id) {
                *right.ends.lock().unwrap_or_else(PoisonError::into_inner) = self.end_from(sent);
            } else {
                right.is_lost.store(true, Ordering::SeqCst);
            }
        }
        Ok(())
    }
}

/// Renews leases at a third of their time, until the store is closed. After an error, sooner.
async fn keep_renewed(leases: Weak<Leases>, time: Duration) {
    let mut pause = time / 3;
    loop {
        tokio::time::sleep(pause).await;
        let Some(leases) = leases.upgrade() else { return };
        let renewed = tokio::time::timeout(time / 3, leases.renew()).await;
        pause = if matches!(renewed, Ok(Ok(()))) {
            time / 3
        } else {
            time / 20
        };
    }
}

/// A log that this server owns for a time, which is renewed.
pub(super) struct OwnedRow {
    leases: Arc<Leases>,
    log: LogName,
    right: Arc<Right>,
    length: Mutex<i64>,
}

impl OwnedRow {
    fn lost(&self) -> StoreError {
        self.right.is_lost.store(true, Ordering::SeqCst);
        StoreError::Lost(self.log.words())
    }
}

impl OwnedLog for OwnedRow {
    fn length(&self) -> u64 {
        let length = self.length.lock().unwrap_or_else(PoisonError::into_inner);
        length.unsigned_abs()
    }

    fn epoch(&self) -> u64 {
        self.right.epoch.unsigned_abs()
    }

    fn append(&self, lines: &str, durability: Durability) -> Result<(), StoreError> {
        let mut length = self.length.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_lost() {
            return Err(self.lost());
        }
        let added = lines.len() as u64;
        if length.unsigned_abs() + added > LOG_LIMIT {
            return Err(StoreError::TooLarge(self.log.words()));
        }
        let sql = match durability {
            Durability::Now => APPEND,
            Durability::Later => APPEND_LATER,
        };
        let (kind, id) = key(&self.log);
        let query = sqlx::query(sql)
            .bind(kind)
            .bind(id)
            .bind(self.leases.owner.clone())
            .bind(self.right.epoch)
            .bind(*length)
            .bind(lines.to_owned())
            .bind(added.cast_signed());
        let pool = self.leases.connection.pool.clone();
        let done = self
            .leases
            .connection
            .wait(async move { query.execute(&pool).await })
            // Whether they were written is not known: nothing follows under this right.
            .inspect_err(|_| self.right.is_lost.store(true, Ordering::SeqCst))?;
        if done.rows_affected() == 0 {
            return Err(self.lost());
        }
        *length += added.cast_signed();
        Ok(())
    }

    fn is_lost(&self) -> bool {
        self.right.is_lost()
    }
}

impl Drop for OwnedRow {
    fn drop(&mut self) {
        let (kind, id) = key(&self.log);
        let mut held = self.leases.held();
        // A later right to the same log stays.
        if held
            .get(&(kind, id.clone()))
            .is_some_and(|own| Arc::ptr_eq(own, &self.right))
        {
            held.remove(&(kind, id.clone()));
        }
        drop(held);
        let (pool, owner, epoch) = (
            self.leases.connection.pool.clone(),
            self.leases.owner.clone(),
            self.right.epoch,
        );
        // If it fails, the lease ends by itself.
        let _ = self.leases.connection.wait(async move {
            let query = sqlx::query(GIVE_BACK).bind(kind).bind(id).bind(owner).bind(epoch);
            query.execute(&pool).await
        });
    }
}

/// A log to which all servers add.
pub(super) struct SharedRow {
    pub(super) leases: Arc<Leases>,
    pub(super) log: LogName,
}

impl OwnedLog for SharedRow {
    /// Returns zero: others add too.
    fn length(&self) -> u64 {
        0
    }

    fn epoch(&self) -> u64 {
        0
    }

    fn append(&self, lines: &str, _: Durability) -> Result<(), StoreError> {
        let (kind, id) = key(&self.log);
        let query = sqlx::query(ADD)
            .bind(kind)
            .bind(id)
            .bind(lines.to_owned())
            .bind((lines.len() as u64).cast_signed());
        let pool = self.leases.connection.pool.clone();
        let done = self.leases.connection.wait(async move { query.execute(&pool).await })?;
        if done.rows_affected() == 0 {
            return Err(self.leases.connection.failed("the audit log is gone"));
        }
        Ok(())
    }

    fn is_lost(&self) -> bool {
        false
    }
}
