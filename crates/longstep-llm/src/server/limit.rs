//! Limits on what a server may send and on how long it may take. `docs/models.md` lists them.
//!
//! Every byte is counted before it is kept, and no text grows without a limit: a server decides how much it sends, and
//! these numbers decide how much is read.

use std::time::Duration;

use crate::{AnswerLimit, ModelError};

/// Bytes of a streamed answer off the wire, where so many tokens are asked for. In OpenAI's dialect a token takes about 300.
pub(super) fn answer_bytes(max_tokens: u32) -> u64 {
    const MOST: u64 = 64 << 20;
    ((4 << 20) + 1024 * u64::from(max_tokens)).min(MOST)
}

/// Bytes of one event and of one line in a streamed answer.
pub(super) const EVENT_BYTES: usize = 1 << 20;

/// Lines of a streamed answer, empty ones and comments included.
pub(super) const LINES: u64 = 500_000;

/// Bytes that are read of an error's body, and the time for them. What comes later is not needed to say what is wrong.
pub(super) const COMPLAINT_BYTES: usize = 64 << 10;
pub(super) const COMPLAINT_TIME: Duration = Duration::from_secs(5);

/// Bytes and time for the answer to a question beside the chat.
pub(super) const QUESTION_BYTES: usize = 4 << 20;
pub(super) const QUESTION_TIME: Duration = Duration::from_secs(2);

/// The time for all questions about tokens that one model is asked. Afterwards tokens are estimated.
pub(super) const COUNTING_TIME: Duration = Duration::from_secs(30);

/// The largest number of tokens that is believed. A larger one, in a count or as a context, counts as not given.
pub(super) const TOKENS: u64 = 1_000_000_000;

/// Bytes of text, reasoning included, that so many tokens can have. A token of JSON has about four bytes; 32 leaves
/// room for blanks, which tokenizers join.
pub(super) fn text_bytes(max_tokens: u32) -> usize {
    4096 + 32 * max_tokens as usize
}

/// The error for an answer that is too large.
pub(super) fn too_large(server: &str, limit: AnswerLimit) -> ModelError {
    ModelError::TooLarge {
        server: server.to_owned(),
        limit,
    }
}
