//! What is asked of a language model, and how its answer is read.

mod chat;
mod count;
mod dialogue;
mod example;
mod scene;

pub use chat::{ChatRequest, Constraint, ConstraintKind, Finish, Message, Reply, Role, Usage};
pub use count::{Counting, EstimatedTokens, TokenCounter};
pub use dialogue::{DialogueError, GoalDialogue, Round, Turn};
pub(crate) use dialogue::{one_line, shortened};
pub use example::Example;
pub(crate) use example::{check_example, render_goal_prompt};
pub use scene::scene;
