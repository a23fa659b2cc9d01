//! Goals, search and repair.
//!
//! - [`goal`]: goals over the goal words of a domain.
//! - [`search`], [`repair`], [`schedule`]: plans from goals, from invalid plans, and for several actors.
//! - [`pddl`]: tasks and plans of other planners.
//!
//! The feature `testing` adds worlds and plans for tests, the module `testing`.

pub mod goal;
pub mod pddl;
pub mod repair;
pub mod schedule;
pub mod search;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
