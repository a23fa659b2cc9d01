//! Robots, environments and worlds as data.
//!
//! The modules are layers; none imports one below it in this list:
//!
//! - [`call`], [`diagnostic`], [`json`], [`literal`], [`visible`], [`secret`], [`effort`], [`spanned`]: calls, source positions,
//!   JSON and Python literals, escaping, the removal of passwords, budgets of work, and places in TOML files.
//! - [`model`]: domains, facts, states and worlds.
//! - [`domain`], [`environment`]: domains and worlds read from files, and written. The shipped domains are in this crate.
//! - [`geometry`]: environments from scenes of boxes with poses.
//!
//! The feature `testing` adds worlds for tests, the module `testing`; `schema` adds JSON Schemas of the files, the module
//! `schema`.

pub mod call;
pub mod diagnostic;
pub mod domain;
pub mod effort;
pub mod environment;
pub mod geometry;
pub mod json;
pub mod literal;
pub mod model;
#[cfg(feature = "schema")]
pub mod schema;
pub mod secret;
pub mod spanned;
#[cfg(any(test, feature = "testing"))]
pub mod testing;
pub mod visible;
