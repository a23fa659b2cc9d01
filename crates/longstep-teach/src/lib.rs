//! Skill parameters from demonstrations.

mod circle;
mod demonstration;
mod line;
mod noise;
mod plane;
mod posture;
mod read;

pub use circle::{Arc, fit_arc};
pub use demonstration::{Demonstration, Frame, Hand};
pub use line::{Line, fit_line};
pub use noise::noise;
pub use plane::{Plane, fit_plane};
pub use posture::{directions, posture};
pub use read::{BYTES, Format, ReadError};
