//! Plans for robots that have been checked, step by step, against a model of the world.
//!
//! A language model says what is wanted; this library knows what is possible. It has no I/O: everything here is
//! a function of its inputs.
//!
//! The key types, in the order in which they meet:
//!
//! - [`domain::Domain`]: what a robot can do and what can be true, from a folder of PDDL and TOML.
//! - [`environment::Environment`] and [`environment::World`]: one state of the world, as JSON and as facts.
//! - [`dialogue::GoalDialogue`]: asks a model for goals; the caller carries the messages.
//! - [`compose`]: plans put together from stored ones.
//! - [`plan::read`]: the plan in the text of a model's reply, and what had to be forgiven to read it.
//! - [`goal::Goal`]: what is wanted. [`search::solve`] finds the steps.
//! - [`verify::check`]: simulates a plan; a [`verify::Report`] without violations becomes a
//!   [`verify::VerifiedPlan`], and nothing else does.
//!
//! ```
//! use longstep::plan::{Plan, Step};
//! use longstep::search::{Limits, Outcome};
//! use longstep::{domain, goal, json, search, verify, environment};
//!
//! let household = domain::shipped("household").unwrap()?;
//! let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
//!     "object_states": {"<milk>": "on_something(<counter>)", "<fridge_handle>": "closed()"}}"#;
//! let environment = environment::Environment::from_json(text)?;
//! let world = environment::read(&household, &environment, "env.json", text, &json::Path::default())?;
//!
//! let goal = goal::parse(&household, &world, "put(milk, fridge)")?;
//! let outcome = search::solve(&household, &world, &goal.wanted(&household), &Limits::default());
//! let Outcome::Solved { plan, .. } = outcome else { panic!("{outcome:?}") };
//!
//! let report = verify::check(&household, &world, plan, &goal.purpose(&household));
//! let verified = report.into_verified().expect("search makes plans that can be done");
//! assert_eq!(verified.steps()[2].explanation, "turn the fridge handle to open");
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub use longstep_core::{
    call, diagnostic, effort, environment, json, pddl, plan, repair, schedule, search, verify, visible,
};

pub mod compose;
pub mod dialogue;
pub mod domain;
pub mod feedback;
pub mod goal;
mod lint;
mod load;
mod model;
pub mod report;
pub mod session;
mod usage;
