//! Pictures of plans and scenes, as data for a page and as SVG.
//!
//! - [`scene`]: a state of a world as nested boxes, with the changes between two states.
//! - [`plan`]: a plan as a tree, with the reason and the changes of every step.
//! - [`frames()`]: the states along a plan, step by step.
//!
//! Everything is a function of its arguments: the same plan gives the same bytes.

mod cause;
mod draw;
mod frames;
pub mod plan;
pub mod scene;
#[cfg(test)]
mod shipped;
mod walk;

pub use draw::{SvgOptions, stylesheet};
pub use frames::{Frame, frames};
