//! Skill parameters from demonstrations: recordings of a hand, cut into the steps of a plan, and fitted. This crate contains
//! no model and no I/O.
//!
//! 1. [`requests`] lists the steps of a plan with the parameters that a person teaches.
//! 2. [`Demonstration::read`] reads a recording: CSV, JSON or MCAP, as trackers, spreadsheets and ROS 2 write them.
//! 3. [`cut`], [`cut_at_times`] or [`one_each`] assign the parts of recordings to steps.
//! 4. [`learn`] fits each parameter, with a standard uncertainty, and reports [`Finding`]s.
//! 5. [`skills_file`] writes the values for `longstep run --skills`.
//!
//! Positions are in metres: x to the right, y forward, z up, in one frame for all recordings of a plan.

mod circle;
mod demonstration;
mod finding;
mod fits;
mod lesson;
mod line;
mod noise;
mod plane;
mod posture;
mod recording;
mod request;
mod segment;
mod shown;
mod skills_file;

pub use circle::{Arc, fit_arc};
pub use demonstration::{Demonstration, Frame, Hand};
pub use finding::{Finding, Problem};
pub use lesson::{Lesson, TaughtStep, learn};
pub use line::{Line, fit_line};
pub use noise::noise;
pub use plane::{Plane, fit_plane};
pub use posture::{directions, posture};
pub use recording::{BYTES, Format, ReadError};
pub use request::{Request, requests};
pub use segment::{Segment, StepTime, cut, cut_at_times, one_each, step_times};
pub use shown::{Expectations, TaughtValue};
pub use skills_file::skills_file;
