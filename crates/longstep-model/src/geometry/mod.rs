//! Environments from scenes: named boxes with poses, as any detector or simulator writes them.
//!
//! [`Scene::parse`] reads a scene file. [`look`] finds the relations between its boxes by geometry, and states them in
//! the words of a domain: a `[[state]]` lists the relations that it says in `geometry`. Every statement has a reason
//! with the measures behind it, and every box that fits no world is a finding.

mod forms;
mod look;
mod relation;
mod scene;
mod solid;
#[cfg(test)]
mod tests;

pub use forms::{Orientation, QuaternionOrder};
pub use look::{Assumed, Look, LookError, Reason, look};
pub use relation::{SceneFinding, SceneFindingKind};
pub use scene::{Body, Hand, Joint, Kind, Scene, Tolerances};
