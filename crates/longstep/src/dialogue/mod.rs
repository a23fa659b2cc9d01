//! Requests to a language model and the parsing of its replies.
//!
//! There are two strategies. In the goal strategy, [`Understanding`](crate::understanding::Understanding) requests a goal. In the direct
//! strategy, [`direct_request`] requests a whole plan: five fixed parts ([`fixed_parts`]), the history, and the
//! [`query`]; [`crate::plan::read`] parses the reply. A prompt beyond the token budget is shortened ([`fit`],
//! [`focus`]), and the result reports the omissions.

pub(crate) mod answer_grammar;
mod budget;
mod chat;
mod count;
mod direct;
mod example;
mod explain;
mod focus;
mod forecast;
mod forms;
mod object_text;
mod parts;
mod picture;
mod query;
mod rendered;
mod reply;
mod scene;
mod template;
mod template_context;
#[cfg(test)]
mod tests;
mod transcript;
mod tree_schema;
mod worked;

pub use crate::model::{Example, PartTexts, Prompts};
pub(crate) use crate::reading::nats;
pub use crate::reading::{Candidate, Decision, Reading};
pub use crate::usage::Usage;
pub use budget::{Conversation, Exchange, Fitted, OverBudget, PartCost, fit};
pub use chat::{ChatRequest, Constraint, ConstraintKind, Finish, Likelihood, Message, Reply, Role, Round, Task};
pub use count::{Counting, EstimatedTokens, TokenCounter};
pub use direct::{Prepared, direct_request};
pub(crate) use example::{check_example, fixed_turns, render_goal_prompt, scene_and_instruction};
pub use explain::{Explanation, PartShare, explain};
pub use focus::{Focus, focus};
pub use forecast::Forecast;
pub(crate) use forms::actors;
pub use object_text::object_text;
pub use parts::{Part, PartName, PromptError, broken_parts, fixed_parts};
pub use picture::{PICTURE_LIMIT, Picture, PictureError};
pub(crate) use query::plain_line;
pub use query::query;
pub(crate) use reply::answered;
pub use reply::direct_schema;
pub use scene::{scene, scene_lists};
pub use transcript::{Dialogue, DialogueError, Transcript};
pub(crate) use transcript::{object, one_line, whole};
pub(crate) use tree_schema::{TreeForms, in_schema, tree_schema};
#[cfg(feature = "schema")]
pub(crate) use worked::schema as plans_schema;
