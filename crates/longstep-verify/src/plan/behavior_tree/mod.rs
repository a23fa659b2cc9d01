//! Behavior trees in the XML of BehaviorTree.CPP 4.
//!
//! Each step is a leaf with a port for every parameter. A step that fails makes the tree fail, also in loops and lanes. A
//! sensing step writes its outcome to the blackboard, where conditions read it; a fact in a condition is a condition leaf.
//! `TreeNodesModel` lists all leaves, as Groot2 needs it. [`read`](super::read()) reads such trees, and those that people write with the
//! nodes that a plan can have.
//!
//! ```
//! use longstep_model::{domain, environment};
//! use longstep_verify::plan::{behavior_tree, read};
//! use longstep_verify::verify::check_file;
//! let household = domain::shipped("household").unwrap()?;
//! let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
//! let world = environment::parse(&household, "env.json", text)?;
//! let draft = read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
//! let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
//!
//! let xml = behavior_tree::write(&world, plan.plan(), behavior_tree::Guards::None).unwrap();
//! assert!(xml.contains("<grasp_object "));
//! let again = read(&xml).unwrap();
//! assert_eq!(check_file(&world, &again.file).unwrap().into_verified().unwrap().plan(), plan.plan());
//! # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
//! ```

mod condition;
mod element;
mod guard;
mod name;
pub mod nodes;
mod part;
mod read;
mod read_condition;
mod read_lanes;
#[cfg(test)]
mod tests;
mod write;
mod xml;

pub(super) use name::IS;
pub(crate) use name::outcomes;
#[cfg(any(test, feature = "testing"))]
pub(crate) use name::{LeafNames, port};
pub(super) use read::{find, read};
pub use write::{Guards, WriteError, write};

/// The version of the format that is written and read.
const FORMAT: &str = "4";

/// The tree that is ticked. It comes first, because Groot2 drops the attribute that names it.
const MAIN: &str = "Main";

/// The attribute of a lane with its hand, arm or robot.
const ACTOR: &str = "_actor";

/// The attribute of what makes lanes wait for each other, with the name of the synchronization point.
const SYNC: &str = "_sync";

/// The attribute of a sequence that begins with the preconditions of its last child.
const GUARD: &str = "_guard";

/// The attribute of a leaf with the call of the step, if the leaf cannot have its name.
const CALL: &str = "_call";

/// The output port of a sensing step.
pub(super) const OUTCOME: &str = "outcome";
