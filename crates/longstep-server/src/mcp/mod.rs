//! A server of the Model Context Protocol: agents plan with Longstep, and a person approves before a robot moves.
//!
//! It speaks the protocol with a handshake (2025-11-25 and before) and the one without (2026-07-28), over standard input
//! and output ([`serve_stdio`]) and over streamable HTTP ([`http_service`]). Tools return the program's own JSON and a
//! short text. A refusal is a result with its reason and the next step, and no protocol error.
//!
//! `execute_plan` shows a form with the steps, the goal, the robot and the hash of the plan. Only a form that comes back
//! with `approve` set and with this hash is an approval; it is used as [`Hub::approve`] and [`Hub::start`] use it, and is in
//! the audit log as `mcp:` and the name of the client. If the client cannot show a form, the plan waits for the page.
//!
//! ```no_run
//! use std::sync::Arc;
//! use longstep_server::mcp::{McpOptions, serve_stdio};
//! use longstep_server::{Configuration, Domains, FileStore, Hub, NewSession, Scene};
//!
//! let store = Arc::new(FileStore::open("state/sessions".as_ref())?);
//! let hub = Hub::open(Configuration::new(store, Domains::new(&[], Scene::shipped())?))?;
//! serve_stdio(hub, McpOptions::new(NewSession::of_scene("pantry")), std::future::pending())?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod call;
mod caller;
mod consent;
mod execute;
mod explain;
mod face;
mod handler;
mod offer;
mod operate;
mod options;
mod planning;
mod reply;
mod resource;
mod schema;
mod serve;
mod text;
mod tool;

pub use face::Face;
pub use options::McpOptions;
pub use serve::{HttpService, McpError, http_service, serve, serve_stdio};

#[cfg(doc)]
use crate::hub::Hub;
