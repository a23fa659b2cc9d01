//! `longstep mcp`: tools for a language-model agent, on standard input and output.

use std::fs::{File, TryLockError};
use std::future::pending;
use std::sync::Arc;
use std::thread;

use anyhow::Result;
use longstep_files::session_directory;
use longstep_server::http::{ServeOptions, serve};
use longstep_server::mcp::serve_stdio;
use longstep_server::{FileStore, Hub};

use crate::arguments::McpArguments;
use crate::exit_code::DONE;
use crate::failure::{self, Failure};
use crate::hub::{self, configuration, for_agents};
use crate::output::remark;
use crate::serve::Page;
use crate::signals;

/// The most servers for agents at a time: each agent begins one of its own.
const MOST: usize = 64;

/// Nothing but the protocol goes to standard output.
pub(crate) fn run(arguments: &McpArguments) -> Result<u8> {
    let (store, _lock) = store()?;
    let page = arguments
        .listen
        .map(|listen| Page::open(listen, &arguments.access, store.folder()))
        .transpose()?;
    let configuration = configuration(&arguments.hub, Arc::new(store))?;
    let options = for_agents(
        &arguments.hub,
        &configuration.robots,
        page.as_ref().map(Page::of_session),
    );
    let hub = Hub::open(configuration).map_err(hub::failure)?;
    let ended = signals::ended().map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
    if let Some(page) = page {
        remark!("A person approves at {}", page.link());
        let hub = Arc::clone(&hub);
        thread::spawn(move || {
            // It ends with the program.
            if let Err(error) = serve(page.listener, hub, ServeOptions::new(page.access), pending()) {
                failure::tell(&error.into());
            }
        });
    }
    serve_stdio(hub, options, ended)?;
    Ok(DONE)
}

/// Opens the first store that no other server for an agent has, and locks its folder until the file is dropped. Sessions and
/// runs are in the same folders for all of them; approvals and the audit log are not.
fn store() -> Result<(FileStore, File)> {
    let sessions = session_directory()?;
    for number in 1..=MOST {
        let name = if number == 1 {
            "mcp".to_owned()
        } else {
            format!("mcp-{number}")
        };
        let store = FileStore::open_named(&sessions, &name).map_err(|error| hub::failure(error.into()))?;
        let path = store.folder().join("lock");
        let unusable = |error: std::io::Error| Failure::unreadable(format!("cannot lock {}: {error}", path.display()));
        let file = longstep_files::append(&path).map_err(unusable)?;
        match file.try_lock() {
            Ok(()) => return Ok((store, file)),
            Err(TryLockError::WouldBlock) => {}
            Err(TryLockError::Error(error)) => return Err(unusable(error).into()),
        }
    }
    Err(Failure::unreadable(format!("{MOST} servers for agents run already"))
        .hint("end those that nobody uses")
        .into())
}
