//! The failure of one attempt.

use std::time::Duration;

use super::complaint::Complaint;
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
        /// The parameters that the server may name. It is never shown.
        complaint: Complaint,
    },
    /// The answer has ended without a word, which some servers do under load.
    Empty(ModelError),
    /// A retry cannot help, or must not happen.
    Final(ModelError),
    /// The connection failed before the answer began.
    Unreachable(ModelError),
}
