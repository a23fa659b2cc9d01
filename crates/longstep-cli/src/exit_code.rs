//! Exit codes that are not the status of an answer.

/// A plan, domain or recording that was checked is not valid.
pub(crate) const NOT_VALID: u8 = 10;
/// Input that cannot be read.
pub(crate) const UNREADABLE: u8 = 30;
/// A limit was reached.
pub(crate) const LIMIT: u8 = 20;
/// A run was stopped by a person or a signal.
pub(crate) const STOPPED: u8 = 50;
/// The robot failed.
pub(crate) const ROBOT: u8 = 51;
/// The model or the network failed.
pub(crate) const MODEL: u8 = 40;
