//! Language models for Longstep, behind one trait.
//!
//! [`open`] turns a [`ModelReference`] into a [`ChatModel`]: the embedded engine for a model of the [`catalogue`] or a
//! `.gguf` file (feature `embedded`, on by default), a client for a server, or the replay of a recording.
//! [`store::pull`] downloads models of the catalogue into the cache. Answers of servers are streamed. A parameter that
//! a server rejects is omitted with a warning, and a busy server gets the request again.
//!
//! ```no_run
//! use longstep::dialogue::{ChatRequest, Constraint, Message, Role, Task};
//! use longstep_files::cache_directory;
//! use longstep_llm::{ChatModel, ModelReference, OpenOptions, open};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let reference: ModelReference = longstep_llm::catalogue::DEFAULT.parse()?;
//! let options = OpenOptions::new(cache_directory()?);
//! let mut model = open(&reference, &options, &mut |_| {})?;
//! let request = ChatRequest {
//!     task: Task::Other,
//!     messages: vec![Message::new(Role::User, "Is the door open? Answer yes or no.")],
//!     fixed: 0,
//!     answer_so_far: String::new(),
//!     constraint: Constraint::Lark(r#"start: "yes" | "no""#.into()),
//!     max_tokens: 8,
//! };
//! let reply = model.chat(&request, &mut |progress: longstep_llm::Progress| eprintln!("{progress:?}"))?;
//! assert!(["yes", "no"].contains(&reply.text.as_str()));
//! # Ok(())
//! # }
//! ```

mod advance;
mod call;
pub mod catalogue;
mod converse;
#[cfg(feature = "embedded")]
mod embedded;
mod error;
pub mod lent;
mod load_domain;
mod model;
mod open;
mod pace;
mod reasoning;
mod record;
mod reference;
mod server;
mod session_folder;
pub mod store;
#[cfg(test)]
mod test_server;
mod wire;

pub use advance::{AdvanceError, advance, instruct};
pub use converse::{ConverseError, converse};
pub use error::{AnswerLimit, ModelError};
pub use load_domain::{load_domain, load_domain_with_prompt};
pub use model::{AdapterChoice, ChatModel, OpenOptions, Progress, Sampling, StopFlag, Watch};
pub use open::open;
pub use pace::{Pace, Speed};
pub use reasoning::Reasoning;
pub use record::Recording;
pub use reference::ModelReference;
pub use server::server_address;
pub use session_folder::{FolderError, LOG, SessionFolder};
