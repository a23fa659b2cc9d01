//! Plans for robots that have been checked, step by step, against a model of the world.
//!
//! A language model says what is wanted; this library finds the steps, verifies each of them, and carries the world
//! from one instruction to the next. It does no I/O and calls no model: everything here is a function of its inputs.
//! The crate `longstep-llm` has the models.
//!
//! - A [`Planner`] owns a robot's [`Domain`](domain::Domain): what it can do, and the words for it.
//! - A [`World`] is one environment, read with that domain.
//! - A [`VerifiedPlan`] was simulated from its first step to its last without a violation. Nothing else can be exported
//!   or executed.
//! - A [`Session`] turns instructions into verified plans, one after the other, in a world that changes with them.
//! - A [`Cursor`] walks a verified plan: the steps that come next, given what was observed.
//!
//! From an instruction to a robot, with a model that runs in this process:
//!
//! ```no_run
//! use longstep::session::{Response, Settings};
//! use longstep::{Planner, Step};
//! use longstep_llm::OpenOptions;
//! # fn perform(_: &Step) -> Option<longstep::Fact> { None }
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let planner = Planner::new(longstep_llm::load_domain("my_robot")?);
//! let world = planner.world(&std::fs::read_to_string("kitchen.json")?)?;
//! let options = OpenOptions::new(longstep_files::cache_directory()?);
//! let mut model = longstep_llm::open(&"qwen2.5-coder-1.5b".parse()?, &options, &mut |_| {})?;
//! let mut session = planner.session(world, Settings::default(), model.facts())?;
//! match longstep_llm::instruct(&mut session, &mut *model, "Put the juice on the top shelf")? {
//!     Response::Plan(proposal) => {
//!         let (mut cursor, mut observed) = (proposal.plan.cursor(), None);
//!         while let Some(step) = cursor.next(observed)? {
//!             observed = perform(cursor.step(step));
//!         }
//!         session.accept()?;
//!     }
//!     Response::Question(question) => println!("{question}"),
//!     other => println!("{other}"),
//! }
//! # Ok(())
//! # }
//! ```
//!
//! Without a model, a goal is enough:
//!
//! ```
//! let planner = longstep::Planner::shipped("household")?;
//! let world = planner.world(r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
//!     "object_states": {"<milk>": "on_something(<counter>)", "<fridge_handle>": "closed()"}}"#)?;
//! let plan = planner.solve(&world, "put(milk, fridge)")?;
//! assert_eq!(plan.steps()[2].explanation, "turn the fridge handle to open");
//! # Ok::<(), longstep::Error>(())
//! ```
//!
//! Errors are one opaque [`Error`] with a [`kind`](Error::kind). The modules hold the parts: [`dialogue`] asks a model
//! for goals, [`report`] makes the answers for programs, [`compose`] builds plans from stored ones. Verification, search,
//! repair, schedules and PDDL are functions of the crate `longstep-core`, below this one.

mod clock;
mod error;
mod planner;

pub use clock::Clock;
pub use error::{Error, ErrorKind};
pub use planner::Planner;

pub use longstep_core::cursor::{Cursor, CursorError};
pub use longstep_core::diagnostic::{Diagnostic, Diagnostics};
pub use longstep_core::environment::{Environment, World};
pub use longstep_core::model::{EntityId, Fact, State};
pub use longstep_core::plan::{Plan, Step, StepId, Violation};
pub use longstep_core::search::{Effort, Limits};
pub use longstep_core::verify::VerifiedPlan;

pub use goal::Goal;
pub use report::Assessment;
pub use session::Session;

// The modules of the ground floor, for `crate::` paths in this crate.
use longstep_core::{call, diagnostic, effort, environment, json, plan, repair, schedule, search, verify, visible};

pub mod compose;
pub mod coverage;
pub mod dialogue;
pub mod domain;
pub mod draft_text;
pub mod feedback;
pub mod goal {
    //! Goals of plans.
    //!
    //! A [`Goal`] is written as `put(cup, shelf) & closed(door)`. A model writes one ([`understanding`](crate::understanding)), and
    //! search turns it into steps.

    pub use longstep_core::goal::*;
}
pub mod instruction;
mod load;
mod model;
pub mod perception;
mod reading;
pub mod report;
#[cfg(feature = "schema")]
pub mod schema;
pub mod session;
pub mod understanding;
mod usage;
