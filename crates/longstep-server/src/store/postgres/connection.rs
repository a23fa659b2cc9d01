//! Connections to the database, on threads of their own, so that any thread may wait for an answer.

use std::borrow::Cow;
use std::future::Future;
use std::str::FromStr;
use std::sync::mpsc;
use std::time::Duration;

use longstep_core::secret;
use sqlx::migrate::{Migration, MigrationType, Migrator};
use sqlx::postgres::{PgConnectOptions, PgPool, PgPoolOptions};
use sqlx::{ConnectOptions, Connection as _};
use tokio::runtime::{Builder, Runtime};

use crate::store::StoreError;

/// The most connections of a server besides the one that renews leases.
const CONNECTIONS: u32 = 8;

/// The time in which the database answers.
const SLOWEST: Duration = Duration::from_secs(6);

/// The time after which the database ends a statement: before this side gives it up, so that its end is known.
const STATEMENT: &str = "5000";

/// The schema, a step for each version.
const MIGRATIONS: [(i64, &str, &str); 2] = [
    (1, "begin", include_str!("0001_begin.sql")),
    (2, "units of campaigns", include_str!("0002_units.sql")),
];

/// The database of a store.
#[derive(Debug)]
pub(super) struct Connection {
    /// None while it is dropped.
    runtime: Option<Runtime>,
    pub(super) pool: PgPool,
    /// One connection that no other work holds up.
    pub(super) reserved: PgPool,
    /// The address without its user and password.
    name: String,
}

impl Connection {
    /// Connects, and makes the schema what this program needs.
    pub(super) fn open(address: &str) -> Result<Self, StoreError> {
        let name = secret::address(address).into_owned();
        let wrong = |reason: &str| StoreError::Database {
            database: name.clone(),
            reason: reason.to_owned(),
        };
        // The error of the parser may quote the address.
        let options = PgConnectOptions::from_str(address)
            .map_err(|_| wrong("the address cannot be read; it is like postgres://host:5432/database"))?
            .application_name("longstep")
            .options([("statement_timeout", STATEMENT)])
            .disable_statement_logging();
        let runtime = Builder::new_multi_thread()
            .worker_threads(1)
            .thread_name("longstep-store")
            .enable_all()
            .build()
            .map_err(|error| wrong(&error.to_string()))?;
        let pools = {
            // A pool starts its work where it is made.
            let _inside = runtime.enter();
            let pool = PgPoolOptions::new().acquire_timeout(SLOWEST);
            let reserved = pool.clone().max_connections(1).connect_lazy_with(options.clone());
            (
                pool.max_connections(CONNECTIONS).connect_lazy_with(options.clone()),
                reserved,
            )
        };
        let connection = Self {
            runtime: Some(runtime),
            pool: pools.0,
            reserved: pools.1,
            name,
        };
        connection.migrate(options)?;
        Ok(connection)
    }

    /// Makes the schema what this program needs.
    fn migrate(&self, options: PgConnectOptions) -> Result<(), StoreError> {
        let migrations = MIGRATIONS.map(|(version, name, sql)| {
            Migration::new(
                version,
                Cow::Borrowed(name),
                MigrationType::Simple,
                Cow::Borrowed(sql),
                false,
            )
        });
        let migrator = Migrator {
            migrations: Cow::Owned(migrations.to_vec()),
            ..Migrator::DEFAULT
        };
        // A pool says only that it waited; the error of one connection says why.
        self.wait(async move { options.connect().await?.close().await })?;
        let pool = self.pool.clone();
        let migrated = self.wait(async move { Ok(migrator.run(&pool).await) })?;
        migrated.map_err(|error| self.failed(&error.to_string()))
    }

    /// Starts work beside that of the callers.
    pub(super) fn spawn(&self, work: impl Future<Output = ()> + Send + 'static) {
        if let Some(runtime) = &self.runtime {
            drop(runtime.spawn(work));
        }
    }

    /// Waits for work with the database. May be called on any thread, one of an asynchronous runtime included.
    pub(super) fn wait<T: Send + 'static>(
        &self,
        work: impl Future<Output = Result<T, sqlx::Error>> + Send + 'static,
    ) -> Result<T, StoreError> {
        let (done, result) = mpsc::sync_channel(1);
        self.spawn(async move {
            let _ = done.send(tokio::time::timeout(SLOWEST, work).await);
        });
        match result.recv() {
            Ok(Ok(Ok(value))) => Ok(value),
            Ok(Ok(Err(error))) => Err(self.failed(&error.to_string())),
            Ok(Err(_)) => Err(self.failed("it did not answer in time")),
            Err(_) => Err(self.failed("the work was lost")),
        }
    }

    pub(super) fn failed(&self, reason: &str) -> StoreError {
        StoreError::Database {
            database: self.name.clone(),
            reason: secret::redacted(reason).into_owned(),
        }
    }
}

impl Drop for Connection {
    fn drop(&mut self) {
        // Waiting is not allowed on a thread of another runtime.
        if let Some(runtime) = self.runtime.take() {
            runtime.shutdown_background();
        }
    }
}
