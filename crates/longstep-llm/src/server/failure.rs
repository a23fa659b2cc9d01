//! The failure of one attempt.

use std::time::Duration;

use crate::ModelError;

/// Failure of an attempt.
#[derive(Debug)]
pub(super) enum Failure {
    /// The server answered with an error; the message is one line, without the key.
    Rejected {
        status: u16,
        message: String,
        /// The wait that the server asks for (`Retry-After`).
        wait: Option<Duration>,
    },
    /// A retry cannot help, or must not happen.
    Final(ModelError),
    /// The connection failed before the answer began.
    Unreachable(ModelError),
}
