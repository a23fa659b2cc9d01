//! The model of a running server, lent to other programs: they build the requests and read the answers as with a model of
//! their own, so the results are the same, and nothing is loaded.
//!
//! [`facts`], [`ChatCall`] and [`CountCall`] are the side of the server; `longstep:URL` is opened on the other side.

mod client;
mod service;

pub(crate) use client::LentModel;
pub use service::{ChatCall, CountCall, facts};
