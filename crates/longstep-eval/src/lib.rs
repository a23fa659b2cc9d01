//! Evaluation for Longstep: the share of correct instructions, and the kinds of failures of the others.
//!
//! A [`Suite`](suite::Suite) is data: scenes, instructions and their expected results. [`run::run`] runs a case in a
//! session with a model, as `longstep chat` does, and compares the result with goals that a verifier checks; no model
//! judges. The result is an [`Attempt`](attempt::Attempt). [`folder::RunFolder`] saves attempts, so that a run can be
//! interrupted and resumed, and [`Summary`] counts them.
//!
//! ```
//! use std::sync::Arc;
//! use longstep::domain;
//! use longstep::session::{Settings, Strategy};
//! use longstep_eval::{Source, Recorded, run, suite};
//! use longstep_eval::suite::PLAIN;
//!
//! let household = Arc::new(domain::shipped("household").unwrap()?);
//! let files = suite::Files {
//!     suite: "name = 'desk'\nabout = 'A pen.'\ndomain = 'household'".to_owned(),
//!     cases: [("cases.toml".to_owned(),
//!         "[[case]]\nid = 'pen'\nscene = 'desk'\nsays = 'The pen belongs on the shelf.'\ngoal = 'put(pen, shelf)'".to_owned())].into(),
//!     scenes: [("desk".to_owned(), r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
//!         "object_states": {"<pen>": "on_something(<desk>)"}}"#.to_owned())].into(),
//!     ..suite::Files::default()
//! };
//! let suite = suite::load(&files, &household)?;
//! // A recorded reply of a model.
//! let replies = r#"[{"case": "pen", "reply": {"goal": "put(pen, shelf)", "left_out": [], "question": ""}}]"#;
//! let mut recorded = Recorded::read(replies)?;
//! let unit = run::Unit { case: &suite.cases[0], wording: PLAIN, trial: 1 };
//! let model = recorded.model("pen", 1)?;
//! let lines = run::run(&suite, &household, unit, Settings::default(), model, &mut |_: longstep_llm::Progress| {})?;
//! assert!(lines[0].0.correct);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod ablation;
pub mod attempt;
mod campaign;
pub mod compare;
pub mod failure;
pub mod folder;
mod judge;
#[cfg(test)]
mod judged_tests;
mod queue;
mod rate;
pub mod report;
pub mod run;
mod source;
pub mod suite;
mod summary;

pub use ablation::{AblationError, Changes, domain_sha256, sha256};
pub use campaign::{Campaign, Choice, lengths, units};
pub use queue::{Alone, Queue, Turn, kept_text, read_kept};
pub use rate::Rate;
pub use source::{Opened, Opener, Recorded, RecordedError, Source};
pub use summary::{Cost, Summary};
