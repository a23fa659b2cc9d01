//! What is asked of a language model, and how its answer is read.

mod chat;

pub use chat::{ChatRequest, Constraint, ConstraintKind, Finish, Message, Reply, Role, Usage};
