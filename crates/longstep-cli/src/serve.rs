//! `longstep serve`: sessions, approvals and runs behind HTTP.

use std::net::{SocketAddr, TcpListener};
use std::path::Path;
use std::sync::Arc;

use anyhow::Result;
use longstep_files::session_directory;
use longstep_server::http::{Access, ServeOptions, Token, serve};
use longstep_server::{FileStore, Hub, Store};

use crate::arguments::{AccessArguments, ServeArguments};
use crate::exit_code::DONE;
use crate::failure::Failure;
use crate::hub::{configuration, database, failure, for_agents};
use crate::output::{Style, print_line, remark};
use crate::ros;
use crate::signals;

pub(crate) fn run(arguments: &ServeArguments) -> Result<u8> {
    // Read before anything begins, so that a mistake in a file is known now.
    let bridges = ros::bridges(&arguments.ros2)?;
    // The token is in a file, whatever the rest is in.
    let files = FileStore::open(&session_directory()?).map_err(|error| failure(error.into()))?;
    let page = Page::open(arguments.listen, &arguments.access, files.folder())?;
    let store: Arc<dyn Store> = match &arguments.store {
        Some(address) => database(address)?,
        None => Arc::new(files),
    };
    let configuration = configuration(&arguments.hub, store)?;
    let mcp = for_agents(&arguments.hub, &configuration.robots, Some(page.of_session()));
    let hub = Hub::open(configuration).map_err(failure)?;
    print_line!("{} {}", "Longstep is at".bold(), page.link());
    remark!(
        "The token is in {}; whoever has it can approve plans. Agents find their tools at {}/mcp. Ctrl-C stops all robots and \
         ends the server",
        page.token_file.display(),
        page.address
    );
    let _faces = ros::faces(&hub, bridges)?;
    let ended = signals::ended().map_err(|error| Failure::unreadable(format!("cannot watch for signals: {error}")))?;
    let options = ServeOptions::new(page.access).with_mcp(mcp);
    serve(page.listener, hub, options, ended)?;
    Ok(DONE)
}

/// An address at which a page is served, and who may open it.
pub(crate) struct Page {
    pub(crate) listener: TcpListener,
    pub(crate) access: Access,
    token: Token,
    token_file: std::path::PathBuf,
    /// `http://ADDRESS:PORT`
    address: String,
    /// The address for people: the first name, which has TLS in front, or that of this machine.
    shown: String,
}

impl Page {
    /// Opens the listener, and reads the token; without a file for it, it is one in `folder`.
    pub(crate) fn open(listen: SocketAddr, access: &AccessArguments, folder: &Path) -> Result<Self> {
        let listener = listener(listen, access)?;
        let address = listener.local_addr()?;
        let token_file = access.token_file.clone().unwrap_or_else(|| folder.join("token"));
        let token = Token::of_file(&token_file).map_err(|error| {
            Failure::unreadable(error.to_string()).hint("name another file with `--token-file FILE`")
        })?;
        let address_text = format!("http://{address}");
        let shown = access.name.first().map(|name| format!("https://{name}"));
        Ok(Self {
            access: Access::new(token.clone(), address, &access.name),
            listener,
            token,
            token_file,
            shown: shown.unwrap_or_else(|| address_text.clone()),
            address: address_text,
        })
    }

    /// The link to the page, with the token.
    pub(crate) fn link(&self) -> String {
        format!("{}/?token={}", self.address, self.token.text())
    }

    /// The address of the page for a session, without the token: an agent is told of it.
    pub(crate) fn of_session(&self) -> String {
        format!("{}/sessions/{{session}}", self.shown)
    }
}

/// Opens the listener. Beyond this machine nothing is encrypted: that is said before anything else.
fn listener(listen: SocketAddr, access: &AccessArguments) -> Result<TcpListener> {
    if !listen.ip().is_loopback() {
        if access.token_file.is_none() {
            return Err(
                Failure::unreadable(format!("other machines reach {}, so the token has to be yours", listen))
                    .hint(
                        "name a file with a token of at least 32 letters and digits: `--token-file FILE`; \
                           and put a server with TLS in front, see docs/guide/server.md",
                    )
                    .into(),
            );
        }
        remark!(
            "{} what is sent to {} is not encrypted: put a server with TLS in front, see docs/guide/server.md",
            "Warning:".yellow(),
            listen
        );
    }
    Ok(TcpListener::bind(listen).map_err(|error| {
        Failure::unreadable(format!("cannot listen at {}: {error}", listen))
            .hint("name another address with `--listen 127.0.0.1:PORT`; port 0 takes a free one")
    })?)
}
