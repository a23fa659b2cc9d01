//! Plans for robots, verified step by step against a model of the world: domains, worlds, plans, verification, search and
//! repair. No language, no prompts, no I/O.
//!
//! The modules stand on each other in this order, and none imports one that comes after it:
//!
//! - [`call`], [`diagnostic`], [`json`], [`visible`], [`effort`]: text with places in it, and budgets of work.
//! - [`model`]: domains, facts, states and worlds as data.
//! - [`domain`] and [`world`]: the same from files, and back.
//! - [`plan`]: plans as trees, their notations, and what can be wrong with them.
//! - [`verify`]: simulates a plan; a report without violations becomes a [`verify::VerifiedPlan`].
//! - [`goal`]: goals in the words of a domain. [`message`]: violations in sentences.
//! - [`search`], [`repair`], [`arms`], [`pddl`]: plans from goals, from invalid plans, for several arms, and from problems.

pub mod call;
pub mod diagnostic;
pub mod domain;
pub mod effort;
pub mod environment;
pub mod goal;
pub mod json;
pub mod message;
pub mod model;
pub mod pddl;
pub mod plan;
pub mod repair;
pub mod schedule;
pub mod search;
pub mod verify;
pub mod visible;
