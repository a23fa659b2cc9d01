//! A WebSocket to a bridge. Nothing in it waits but [`Connection::open`].

use std::net::{SocketAddr, TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use serde_json::Value;
use tungstenite::client::client_with_config;
use tungstenite::handshake::HandshakeError;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

use super::address::Address;

/// The longest message of a bridge, in bytes.
const MESSAGE_LIMIT: usize = 4 << 20;

/// The most that waits for a bridge that does not read, in bytes.
const UNSENT_LIMIT: usize = 8 << 20;

/// The time between two looks at a handshake.
const LOOK: Duration = Duration::from_millis(2);

/// A WebSocket to a bridge.
pub struct Connection {
    socket: WebSocket<TcpStream>,
    /// True if a part of a message is not sent yet.
    is_behind: bool,
}

/// The result of a read.
#[derive(Debug, PartialEq)]
pub enum Read {
    /// A message, which [`super::read`] reads.
    Text(String),
    /// A sign of life without content.
    Alive,
    /// Nothing is there.
    Nothing,
}

/// The reason why a connection cannot be used any more.
#[derive(Debug, PartialEq, thiserror::Error)]
pub enum Lost {
    /// It was closed, or broke.
    #[error("{0}")]
    Closed(String),
    /// The bridge sent what is no message of the protocol.
    #[error("the bridge broke the protocol: {0}")]
    Broken(String),
}

impl std::fmt::Debug for Connection {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Connection")
            .field("is_behind", &self.is_behind)
            .finish_non_exhaustive()
    }
}

/// Returns the addresses of a bridge.
fn socket_addresses(address: &Address) -> Result<Vec<SocketAddr>, String> {
    let found = (address.host.as_str(), address.port).to_socket_addrs();
    let found: Vec<SocketAddr> = found.map_err(|error| error.to_string())?.collect();
    if found.is_empty() {
        Err("the host has no address".to_owned())
    } else {
        Ok(found)
    }
}

impl Connection {
    /// Connects to a bridge, and waits at most as long as the limit for each of its addresses.
    ///
    /// # Errors
    ///
    /// The reason.
    pub fn open(address: &Address, limit: Duration) -> Result<Self, String> {
        let deadline = Instant::now() + limit;
        let mut reason = String::new();
        for socket in socket_addresses(address)? {
            let left = deadline.saturating_duration_since(Instant::now()).max(LOOK);
            match TcpStream::connect_timeout(&socket, left) {
                Ok(stream) => return Self::greet(address, stream, deadline),
                Err(error) => reason = error.to_string(),
            }
        }
        Err(reason)
    }

    fn greet(address: &Address, stream: TcpStream, deadline: Instant) -> Result<Self, String> {
        let prepared = stream.set_nodelay(true).and_then(|()| stream.set_nonblocking(true));
        prepared.map_err(|error| error.to_string())?;
        let config = WebSocketConfig::default()
            .max_message_size(Some(MESSAGE_LIMIT))
            .max_frame_size(Some(MESSAGE_LIMIT))
            .max_write_buffer_size(UNSENT_LIMIT);
        let mut attempt = client_with_config(address.written.as_str(), stream, Some(config));
        loop {
            match attempt {
                Ok((socket, _)) => {
                    return Ok(Self {
                        socket,
                        is_behind: false,
                    });
                }
                Err(HandshakeError::Failure(error)) => return Err(format!("it is no bridge: {error}")),
                Err(HandshakeError::Interrupted(_)) if Instant::now() >= deadline => {
                    return Err("it does not answer".to_owned());
                }
                Err(HandshakeError::Interrupted(handshake)) => {
                    std::thread::sleep(LOOK);
                    attempt = handshake.handshake();
                }
            }
        }
    }

    /// Returns a handle to wait for what the bridge sends.
    pub fn watched(&self) -> Option<TcpStream> {
        self.socket.get_ref().try_clone().ok()
    }

    /// Sends a message, or as much of it as the bridge takes.
    ///
    /// # Errors
    ///
    /// The connection cannot be used any more.
    pub fn send(&mut self, message: &Value) -> Result<(), Lost> {
        let sent = self.socket.send(Message::text(message.to_string()));
        self.written(sent)
    }

    /// Sends what is left.
    ///
    /// # Errors
    ///
    /// The connection cannot be used any more.
    pub fn flush(&mut self) -> Result<(), Lost> {
        let sent = self.socket.flush();
        self.written(sent)
    }

    /// Asks for a sign of life.
    ///
    /// # Errors
    ///
    /// The connection cannot be used any more.
    pub fn ping(&mut self) -> Result<(), Lost> {
        let sent = self.socket.send(Message::Ping(Vec::new().into()));
        self.written(sent)
    }

    fn written(&mut self, result: Result<(), Error>) -> Result<(), Lost> {
        self.is_behind = false;
        match result {
            Ok(()) => Ok(()),
            Err(error) if would_block(&error) => {
                self.is_behind = true;
                Ok(())
            }
            Err(Error::WriteBufferFull(_)) => Err(Lost::Closed("the bridge does not read".to_owned())),
            Err(error) => Err(lost(error)),
        }
    }

    /// True if a part of a message is not sent yet.
    pub fn is_behind(&self) -> bool {
        self.is_behind
    }

    /// Reads a message, if one is there.
    ///
    /// # Errors
    ///
    /// The connection cannot be used any more.
    pub fn read(&mut self) -> Result<Read, Lost> {
        match self.socket.read() {
            Ok(Message::Text(text)) => Ok(Read::Text(text.as_str().to_owned())),
            Ok(Message::Binary(_)) => Err(Lost::Broken("it sent a binary message".to_owned())),
            Ok(Message::Close(_)) => Err(Lost::Closed("the bridge closed the connection".to_owned())),
            Ok(_) => Ok(Read::Alive),
            Err(error) if would_block(&error) => Ok(Read::Nothing),
            Err(error) => Err(lost(error)),
        }
    }

    /// Closes the connection in order.
    pub fn close(&mut self) {
        // The connection ends in any case: an error changes nothing.
        drop(self.socket.close(None));
        drop(self.socket.flush());
    }
}

fn would_block(error: &Error) -> bool {
    matches!(error, Error::Io(error) if error.kind() == std::io::ErrorKind::WouldBlock)
}

fn lost(error: Error) -> Lost {
    match error {
        Error::ConnectionClosed | Error::AlreadyClosed => Lost::Closed("the bridge closed the connection".to_owned()),
        Error::Io(error) => Lost::Closed(error.to_string()),
        Error::Protocol(tungstenite::error::ProtocolError::ResetWithoutClosingHandshake) => {
            Lost::Closed("the connection to the bridge broke".to_owned())
        }
        Error::Capacity(_) => Lost::Broken(format!("it sent a message longer than {} MiB", MESSAGE_LIMIT >> 20)),
        other => Lost::Broken(other.to_string()),
    }
}

/// Waits until the bridge sends something, or the time is over.
#[cfg(unix)]
pub fn wait_for(stream: &TcpStream, limit: Duration) {
    use rustix::event::{PollFd, PollFlags, Timespec, poll};
    let limit = Timespec {
        tv_sec: limit.as_secs().cast_signed(),
        tv_nsec: limit.subsec_nanos().into(),
    };
    let mut watched = [PollFd::new(stream, PollFlags::IN)];
    let result = poll(&mut watched, Some(&limit));
    // A closed connection is always ready: without a pause, the wait would be a busy loop.
    if result.is_err() || watched[0].revents().intersects(PollFlags::HUP | PollFlags::ERR) {
        std::thread::sleep(Duration::from_millis(2));
    }
}

/// Waits a moment.
#[cfg(not(unix))]
pub fn wait_for(_: &TcpStream, limit: Duration) {
    std::thread::sleep(limit.min(Duration::from_millis(5)));
}
