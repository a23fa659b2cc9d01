//! Plans for robots: domains, environments, plans, verification, search, repair and execution. No natural-language input,
//! no prompts, no I/O.
//!
//! This crate is the roof over three smaller ones, whose modules it offers as its own:
//!
//! - `longstep-model`: [`model`], [`domain`], [`environment`], [`geometry`], and the ground that they stand on.
//! - `longstep-verify`: [`plan`], [`skill`], [`verify`], [`message`], [`cursor`].
//! - `longstep-search`: [`goal`], [`search`], [`repair`], [`schedule`], [`pddl`].
//!
//! Its own modules are [`autonomy`], the levels and limits of a robot, and [`execution`]: a plan that a robot carries out,
//! monitored and mended. A program that only verifies
//! plans depends on `longstep-verify`. The feature `testing` adds worlds and plans for tests, the module `testing`;
//! `schema` adds JSON Schemas of files, the module `schema`.

#[cfg(feature = "schema")]
pub use longstep_model::schema;
pub use longstep_model::{
    call, diagnostic, domain, effort, environment, geometry, json, model, secret, spanned, visible,
};
#[cfg(feature = "testing")]
pub use longstep_search::testing;
pub use longstep_search::{goal, pddl, repair, schedule, search};
#[cfg(feature = "testing")]
pub use longstep_verify::tree_peer;
pub use longstep_verify::{cursor, message, plan, skill, verify};

pub mod autonomy;
pub mod execution;
