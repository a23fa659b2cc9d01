//! The VirtualHome simulator as a robot: a client of its HTTP interface, which performs one line of a script at a time.
//!
//! `docs/guide/virtualhome.md` describes its use. Invariants:
//!
//! - Every request has a timeout, and every answer a limit of bytes.
//! - A scene is never reset while a robot is open: a run that is resumed continues in the scene as it is.
//! - The simulator has no way to stop a line. A stop sends nothing more, and is confirmed when the line under way ends.

mod api;
mod environment;
mod graph;
mod options;
mod robot;
mod script;
mod trial;

pub use api::Simulator;
pub use environment::{environment, statements};
pub use graph::{Edge, Graph, GraphError, Node};
pub use options::{VirtualHomeOptions, VirtualHomeOptionsError};
pub use robot::VirtualHome;
pub use script::{Line, LineError};
pub use trial::{Trial, feedback};
