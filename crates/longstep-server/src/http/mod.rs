//! Longstep over HTTP.

mod access;
mod api;
mod events;
mod gate;
mod openapi;
mod pages;
mod reply;
mod router;
mod routes;
mod serve;

pub use access::{Access, Token, TokenError};
pub use openapi::{answer_schema, document};
pub use serve::{ServeError, ServeOptions, serve};

use std::sync::Arc;

use tokio::sync::Semaphore;

use crate::hub::Hub;

/// The most requests that are worked on at a time. Stops are not counted.
const REQUESTS: usize = 256;

/// The most readers of the live stream.
const READERS: usize = 512;

/// The state that all requests share.
#[derive(Clone)]
pub(crate) struct Shared {
    pub(crate) hub: Arc<Hub>,
    pub(crate) access: Arc<Access>,
    pub(crate) requests: Arc<Semaphore>,
    pub(crate) readers: Arc<Semaphore>,
    /// Distinguishes the numbers of events from those of an earlier server.
    pub(crate) boot: Arc<str>,
}

impl Shared {
    fn new(hub: Arc<Hub>, access: Access) -> Result<Self, getrandom::Error> {
        Ok(Self {
            hub,
            access: Arc::new(access),
            requests: Arc::new(Semaphore::new(REQUESTS)),
            readers: Arc::new(Semaphore::new(READERS)),
            boot: crate::id::random(4)?.into(),
        })
    }
}
