//! The failure of one attempt.

use std::time::Duration;

use crate::ModelError;

/// Failure of an attempt.
#[derive(Debug)]
pub(super) enum Failure {
    /// The server answered with an error, also with status 200; the message is one line, without the key.
    Rejected {
        status: u16,
        message: String,
        /// The wait that the server asks for, in `Retry-After` or in the body.
        wait: Option<Duration>,
        /// The beginning of the body, in which the server may name what it rejects. It is never shown.
        body: String,
    },
    /// A retry cannot help, or must not happen.
    Final(ModelError),
    /// The connection failed before the answer began.
    Unreachable(ModelError),
}
