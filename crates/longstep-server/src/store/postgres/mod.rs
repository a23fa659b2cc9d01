//! Logs and records in a PostgreSQL database, which several servers share.

mod connection;
mod lease;

use std::sync::Arc;
use std::time::Duration;

use jiff::Timestamp;
use longstep_files::LOG_LIMIT;

use self::connection::Connection;
use self::lease::{Leases, SharedRow};
use super::{LONGEST_TAIL, LogName, LogState, OwnedLog, RecordKey, Store, StoreError, StoredRun};
use crate::id::SessionId;

/// The time after which the logs of a server that no longer answers can be owned by another.
const LEASE: Duration = Duration::from_secs(10);

/// The shortest lease: one that is renewed three times in it must not be held up by a slow disk.
const SHORTEST_LEASE: Duration = Duration::from_millis(300);

/// Microseconds since 1970, as the driver reads them without a calendar of its own.
const STATE: &str = "
SELECT length, (extract(epoch FROM changed_at) * 1000000)::bigint, epoch, owner IS NOT NULL AND expires > clock_timestamp()
FROM longstep_log WHERE kind = $1 AND id = $2";

/// A length above the limit is told without the text.
const READ: &str = "
SELECT log.length, CASE WHEN log.length <= $3 THEN
    (SELECT coalesce(string_agg(line.text, '' ORDER BY line.place), '') FROM longstep_line AS line
     WHERE line.kind = log.kind AND line.id = log.id) END
FROM longstep_log AS log WHERE log.kind = $1 AND log.id = $2";

const TAIL: &str = "SELECT text FROM longstep_line WHERE kind = $1 AND id = $2 ORDER BY place DESC LIMIT $3";

/// Two indexes find those with an owner and the latest ones. A run that was refused has a log and no record.
const RUNS: &str = "
WITH picked AS (
    (SELECT id FROM longstep_log JOIN longstep_record AS record USING (kind, id)
     WHERE kind = 'run' AND owner IS NOT NULL AND expires > clock_timestamp() LIMIT $1)
    UNION
    (SELECT id FROM longstep_log JOIN longstep_record AS record USING (kind, id)
     WHERE kind = 'run' ORDER BY changed_at DESC LIMIT $1)
)
SELECT record.value,
    (SELECT line.text FROM longstep_line AS line WHERE line.kind = 'run' AND line.id = log.id
     ORDER BY line.place DESC LIMIT 1),
    log.length, (extract(epoch FROM log.changed_at) * 1000000)::bigint, log.epoch,
    log.owner IS NOT NULL AND log.expires > clock_timestamp() AS is_owned
FROM picked JOIN longstep_log AS log ON log.kind = 'run' AND log.id = picked.id
    JOIN longstep_record AS record ON record.kind = 'run' AND record.id = picked.id
ORDER BY is_owned DESC, log.changed_at DESC LIMIT $1";

/// The kind of a log and its name in the database.
type Key = (&'static str, String);

fn key(log: &LogName) -> Key {
    match log {
        LogName::Session(id) => ("session", id.to_string()),
        LogName::Run(id) => ("run", id.to_string()),
        LogName::Robot(key) => ("robot", key.clone()),
        LogName::Unit(key) => ("unit", key.to_string()),
        LogName::Audit => ("audit", String::new()),
    }
}

/// The options of a [`PostgresStore`].
#[derive(Debug, Clone, Copy)]
#[non_exhaustive]
pub struct PostgresOptions {
    /// The time after which the logs of a server that no longer answers can be owned by another: ten seconds.
    pub lease: Duration,
}

impl Default for PostgresOptions {
    fn default() -> Self {
        Self { lease: LEASE }
    }
}

impl PostgresOptions {
    /// Sets the time of a lease; at least 300 milliseconds. It is renewed at a third of it.
    #[must_use]
    pub fn with_lease(self, lease: Duration) -> Self {
        Self {
            lease: lease.max(SHORTEST_LEASE),
        }
    }
}

/// Logs and records in a PostgreSQL database, which several servers share.
///
/// The owner of a log has a lease, which ends by itself when its server no longer renews it. Each addition checks the lease
/// in its own transaction, by a number that grows with each owner. Only the clock of the database counts.
///
/// ```no_run
/// # use std::sync::Arc;
/// use longstep_server::{Configuration, Domains, Hub, PostgresOptions, PostgresStore, Scene};
///
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let store = PostgresStore::open("postgres://longstep@db.lab/longstep", PostgresOptions::default())?;
/// let hub = Hub::open(Configuration::new(Arc::new(store), Domains::new(&[], Scene::shipped())?))?;
/// # Ok(()) }
/// ```
pub struct PostgresStore {
    leases: Arc<Leases>,
}

impl PostgresStore {
    /// Connects to the database of an address, and makes its tables if there are none.
    ///
    /// The password may be in the address, in `PGPASSWORD`, or in `~/.pgpass`. No error has it.
    ///
    /// # Errors
    ///
    /// The address cannot be read, the database does not answer, or a newer program has changed its tables.
    pub fn open(address: &str, options: PostgresOptions) -> Result<Self, StoreError> {
        let connection = Connection::open(address)?;
        let owner = crate::id::random(16).map_err(|error| connection.failed(&error.to_string()))?;
        Ok(Self {
            leases: Leases::new(connection, owner, options.lease),
        })
    }

    fn connection(&self) -> &Connection {
        &self.leases.connection
    }
}

/// A row of the state of a log.
type StateRow = (i64, i64, i64, bool);

fn state((length, changed, epoch, is_owned): StateRow) -> LogState {
    LogState {
        length: length.unsigned_abs(),
        changed_at: Timestamp::from_microsecond(changed).ok(),
        epoch: epoch.unsigned_abs(),
        is_owned,
    }
}

impl Store for PostgresStore {
    fn is_shared(&self) -> bool {
        true
    }

    fn own(&self, log: &LogName) -> Result<Box<dyn OwnedLog>, StoreError> {
        if *log == LogName::Audit {
            return Ok(Box::new(SharedRow {
                leases: Arc::clone(&self.leases),
                log: log.clone(),
            }));
        }
        Ok(Box::new(self.leases.take(log)?))
    }

    fn state(&self, log: &LogName) -> Result<Option<LogState>, StoreError> {
        let ((kind, id), pool) = (key(log), self.connection().pool.clone());
        let row: Option<StateRow> = self
            .connection()
            .wait(async move { sqlx::query_as(STATE).bind(kind).bind(id).fetch_optional(&pool).await })?;
        Ok(row.map(state))
    }

    fn read(&self, log: &LogName) -> Result<Option<Vec<u8>>, StoreError> {
        let ((kind, id), pool) = (key(log), self.connection().pool.clone());
        let row: Option<(i64, Option<String>)> = self.connection().wait(async move {
            let query = sqlx::query_as(READ).bind(kind).bind(id).bind(LOG_LIMIT.cast_signed());
            query.fetch_optional(&pool).await
        })?;
        match row {
            None => Ok(None),
            Some((_, Some(text))) => Ok(Some(text.into_bytes())),
            Some((_, None)) => Err(StoreError::TooLarge(log.words())),
        }
    }

    fn tail(&self, log: &LogName, limit: usize) -> Result<Vec<String>, StoreError> {
        let ((kind, id), pool) = (key(log), self.connection().pool.clone());
        let limit = limit.min(LONGEST_TAIL);
        // Each addition has at least one line.
        let rows: Vec<(String,)> = self.connection().wait(async move {
            let query = sqlx::query_as(TAIL).bind(kind).bind(id).bind(limit as i64);
            query.fetch_all(&pool).await
        })?;
        let mut lines: Vec<String> = rows
            .iter()
            .rev()
            .flat_map(|(text,)| text.lines())
            .map(str::to_owned)
            .collect();
        lines.drain(..lines.len().saturating_sub(limit));
        Ok(lines)
    }

    fn sessions(&self) -> Result<Vec<SessionId>, StoreError> {
        let pool = self.connection().pool.clone();
        let rows: Vec<(String,)> = self.connection().wait(async move {
            let query = sqlx::query_as("SELECT id FROM longstep_log WHERE kind = 'session' ORDER BY id COLLATE \"C\"");
            query.fetch_all(&pool).await
        })?;
        Ok(rows.iter().filter_map(|(id,)| SessionId::parse(id)).collect())
    }

    fn runs(&self, limit: usize) -> Result<Vec<StoredRun>, StoreError> {
        let pool = self.connection().pool.clone();
        let rows: Vec<(String, Option<String>, i64, i64, i64, bool)> = self.connection().wait(async move {
            let limit = i64::try_from(limit).unwrap_or(i64::MAX);
            sqlx::query_as(RUNS).bind(limit).fetch_all(&pool).await
        })?;
        let run = |(record, last, length, changed, epoch, is_owned): (String, Option<String>, i64, i64, i64, bool)| {
            StoredRun {
                record,
                last: last.and_then(|text| text.lines().last().map(str::to_owned)),
                state: state((length, changed, epoch, is_owned)),
            }
        };
        Ok(rows.into_iter().map(run).collect())
    }

    fn insert(&self, key: &RecordKey, value: &str) -> Result<bool, StoreError> {
        let ((kind, id), value, pool) = (key.parts(), value.to_owned(), self.connection().pool.clone());
        let done = self.connection().wait(async move {
            let sql = "INSERT INTO longstep_record (kind, id, value) VALUES ($1, $2, $3) ON CONFLICT DO NOTHING";
            sqlx::query(sql).bind(kind).bind(id).bind(value).execute(&pool).await
        })?;
        Ok(done.rows_affected() == 1)
    }

    fn record(&self, key: &RecordKey) -> Result<Option<String>, StoreError> {
        let ((kind, id), pool) = (key.parts(), self.connection().pool.clone());
        let row: Option<(String,)> = self.connection().wait(async move {
            let sql = "SELECT value FROM longstep_record WHERE kind = $1 AND id = $2";
            sqlx::query_as(sql).bind(kind).bind(id).fetch_optional(&pool).await
        })?;
        Ok(row.map(|(value,)| value))
    }
}
