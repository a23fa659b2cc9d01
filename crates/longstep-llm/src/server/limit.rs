//! Limits on the size and duration of a server's answers. `docs/guide/models.md` lists them.
//!
//! Every byte is counted before it is kept, and no text grows without a limit.

use std::time::Duration;

use crate::{AnswerLimit, ModelError};

/// Bytes of a streamed answer for this token limit. In OpenAI's dialect a token takes about 300.
pub(super) fn answer_bytes(max_tokens: u32) -> u64 {
    const MOST: u64 = 64 << 20;
    ((4 << 20) + 1024 * u64::from(max_tokens)).min(MOST)
}

/// Bytes of one event and of one line in a streamed answer.
pub(super) const EVENT_BYTES: usize = 1 << 20;

/// Lines of a streamed answer, including empty ones and comments.
pub(super) const LINES: u64 = 500_000;

/// Bytes of an error body that are read, and the time for them. The rest is not needed for the message.
pub(super) const COMPLAINT_BYTES: usize = 64 << 10;
pub(super) const COMPLAINT_TIME: Duration = Duration::from_secs(5);

/// Longest wait for what follows the reason why an answer ends.
pub(super) const AFTER_FINISH: Duration = Duration::from_secs(3);

/// Bytes and time for the answer to a request besides the chat.
pub(super) const QUESTION_BYTES: usize = 4 << 20;
pub(super) const QUESTION_TIME: Duration = Duration::from_secs(2);

/// Total time for a model's token requests. Afterwards tokens are estimated.
pub(super) const COUNTING_TIME: Duration = Duration::from_secs(30);

/// Largest plausible number of tokens. A larger count or context is ignored.
pub(super) const TOKENS: u64 = 1_000_000_000;

/// Bytes of text, including reasoning, for this token limit. A token of JSON has about four bytes; 32 leaves room for
/// runs of blanks, which tokenizers join.
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
