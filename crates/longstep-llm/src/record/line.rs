//! The lines of a recording.

use serde::{Deserialize, Serialize};

use crate::wire::{WireHead, WireMessage, WireReply, WireRequest};

/// One line: an object with one key, which names its kind.
#[derive(Debug, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Line {
    /// The recorded model; the first line.
    Recording(WireHead),
    /// A request and its reply.
    Turn { request: WireRequest, reply: WireReply },
    /// A counted message.
    Count(WireCount),
    /// The tokens around the messages of a conversation.
    Frame(u64),
}

#[derive(Debug, Clone, Serialize, Deserialize)]
pub(super) struct WireCount {
    #[serde(flatten)]
    pub(super) message: WireMessage,
    pub(super) tokens: u64,
}
