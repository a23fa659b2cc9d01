//! Plans for robots: domains, environments, plans, verification, search and repair. This crate contains no
//! natural-language input, no prompts and no I/O.
//!
//! The modules are layers; none imports one below it in this list:
//!
//! - [`call`], [`diagnostic`], [`json`], [`visible`], [`secret`], [`effort`]: calls, source positions, escaping, the
//!   removal of passwords, and budgets of work.
//! - [`model`]: domains, facts, states and worlds as data.
//! - [`domain`], [`environment`]: domains and worlds read from files, and written.
//! - [`geometry`]: environments from scenes of boxes with poses.
//! - [`plan`]: plans as trees, their notations, and violations.
//! - [`verify`]: simulates a plan; a report without violations yields a [`verify::VerifiedPlan`].
//! - [`goal`]: goals over the goal words of a domain. [`message`]: violations as sentences.
//! - [`search`], [`repair`], [`schedule`], [`pddl`]: plans from goals, from invalid plans, for several actors, and from
//!   PDDL problems.
//! - [`cursor`], [`execution`]: a position in a verified plan; a plan that a robot carries out, monitored and mended.

pub mod call;
pub mod cursor;
pub mod diagnostic;
pub mod domain;
pub mod effort;
pub mod environment;
pub mod execution;
pub mod geometry;
pub mod goal;
pub mod json;
mod literal;
pub mod message;
pub mod model;
pub mod pddl;
pub mod plan;
pub mod repair;
pub mod schedule;
pub mod search;
pub mod secret;
pub mod skill;
pub mod verify;
pub mod visible;
