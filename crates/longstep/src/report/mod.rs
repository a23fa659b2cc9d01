//! Results for people and programs.
//!
//! An [`Assessment`] covers a written plan, a [`Solution`] a plan from search. Both produce an [`Answer`], which is
//! printed as JSON or as text.

mod answer;
mod assessment;
mod feedback;
mod solution;

pub use crate::clock::milliseconds;
pub use answer::*;
pub use assessment::Assessment;
pub use solution::{Solution, of_goal, of_purpose};
