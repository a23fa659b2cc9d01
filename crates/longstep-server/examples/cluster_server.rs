//! One of several servers at a database, with a model that answers from a table and simulated robots: tools/server/cluster.py
//! starts some, and ends them at random.
//!
//! ```text
//! cluster_server --store postgres://... --port N --token-file FILE --lease MILLISECONDS
//! ```
//!
//! It ends properly when its standard input ends.

#![allow(unreachable_pub, clippy::unwrap_used, clippy::print_stdout, clippy::panic)]

#[path = "../tests/support/mod.rs"]
mod support;

use std::collections::HashMap;
use std::io::Read;
use std::net::TcpListener;
use std::sync::Arc;
use std::time::Duration;

use longstep_server::Body;
use longstep_server::http::{Access, ServeOptions, Token, serve};
use longstep_server::{PostgresOptions, PostgresStore};
use support::{hub_at, simulated};

fn main() {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let named: HashMap<&str, &str> = words
        .chunks(2)
        .map(|pair| (pair[0].as_str(), pair[1].as_str()))
        .collect();
    let value = |name| *named.get(name).unwrap_or_else(|| panic!("{name} is missing"));
    let lease = Duration::from_millis(value("--lease").parse().unwrap());
    let options = PostgresOptions::default().with_lease(lease);
    let store = PostgresStore::open(value("--store"), options).unwrap_or_else(|error| panic!("{error}"));
    // Each step takes long enough that servers end during it.
    let robot = |(name, options): (&str, &str)| simulated(name, options.parse().unwrap(), Body::PerSession);
    let robots = [("sim", "ticks=2,pace=120"), ("quick", "")]
        .into_iter()
        .map(robot)
        .collect();
    let hub = hub_at(Arc::new(store), robots).unwrap();
    let listener = TcpListener::bind(format!("127.0.0.1:{}", value("--port"))).unwrap();
    let address = listener.local_addr().unwrap();
    let token = Token::of_file(value("--token-file").as_ref()).unwrap();
    println!("ready at {address}");
    let (end, ended) = tokio::sync::oneshot::channel::<()>();
    std::thread::spawn(move || {
        let _ = std::io::stdin().read_to_end(&mut Vec::new());
        drop(end);
    });
    let ended = async { drop(ended.await) };
    serve(
        listener,
        hub,
        ServeOptions::new(Access::new(token, address, &[])),
        ended,
    )
    .unwrap();
}
