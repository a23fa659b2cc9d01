//! A database of its own for a test, in the server that LONGSTEP_POSTGRES names.

#![allow(dead_code)]

use std::future::Future;

use sqlx::postgres::{PgConnectOptions, PgConnection};
use sqlx::{ConnectOptions, Connection, Executor};

pub struct Database {
    pub address: String,
    name: String,
    server: String,
}

fn wait<T>(work: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
    runtime.unwrap().block_on(work)
}

fn execute(address: &str, sql: &str) {
    wait(async {
        let options: PgConnectOptions = address.parse().unwrap();
        let mut connection: PgConnection = options.connect().await.unwrap();
        connection.execute(sql).await.unwrap();
        connection.close().await.unwrap();
    });
}

impl Database {
    pub fn new() -> Self {
        let server = std::env::var("LONGSTEP_POSTGRES").unwrap();
        let number = std::time::UNIX_EPOCH.elapsed().unwrap().as_nanos();
        let name = format!("test_{}_{number}", std::process::id());
        execute(&server, &format!("CREATE DATABASE {name}"));
        let place = server.rsplit_once('/').unwrap().0;
        Self {
            address: format!("{place}/{name}"),
            name,
            server,
        }
    }

    /// Executes a statement as somebody who is no server.
    pub fn run(&self, sql: &str) {
        execute(&self.address, sql);
    }

    /// Ends all connections and lets no new one in.
    pub fn shut(&self) {
        execute(
            &self.server,
            &format!("ALTER DATABASE {} ALLOW_CONNECTIONS false", self.name),
        );
        let sql = "SELECT pg_terminate_backend(pid) FROM pg_stat_activity WHERE datname = '";
        execute(&self.server, &format!("{sql}{}'", self.name));
    }

    /// Lets connections in again.
    pub fn open(&self) {
        execute(
            &self.server,
            &format!("ALTER DATABASE {} ALLOW_CONNECTIONS true", self.name),
        );
    }
}

impl Drop for Database {
    fn drop(&mut self) {
        execute(&self.server, &format!("DROP DATABASE {} WITH (FORCE)", self.name));
    }
}
