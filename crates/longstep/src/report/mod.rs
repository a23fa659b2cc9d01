//! Results for people and programs.
//!
//! An [`Assessment`] is a written plan: simulated once, repaired once. A [`Solution`] is a plan that search found. Both
//! have an [`Answer`], the JSON that programs read and the text that people read are made of.

mod answer;
mod assessment;
mod feedback;
mod solution;

pub use answer::*;
pub use assessment::Assessment;
pub use solution::{Solution, Stopwatch, of_goal, of_wanted};
