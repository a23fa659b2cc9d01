//! Robot plans and their verification.
//!
//! The modules are layers; none imports one below it in this list:
//!
//! - [`plan`]: plans as trees, their notations, and violations.
//! - [`skill`]: the values of skill parameters.
//! - [`verify`]: simulates a plan; a report without violations yields a [`verify::VerifiedPlan`].
//! - [`message`]: violations and assumptions as sentences.
//! - [`cursor`]: a position in a verified plan.
//! - `tree_peer`: with the feature `testing`, BehaviorTree.CPP beside a cursor.

pub mod cursor;
pub mod message;
pub mod plan;
pub mod skill;
#[cfg(any(test, feature = "testing"))]
pub mod tree_peer;
pub mod verify;
