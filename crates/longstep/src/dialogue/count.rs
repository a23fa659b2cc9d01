//! Counting tokens: only a model knows how many it makes of a text.

use super::Message;

/// Counts tokens as one model would. The library has no tokenizer of its own: whoever holds the model gives this.
pub trait TokenCounter {
    /// Tokens of a message, with what the model's template puts around it.
    fn message_tokens(&mut self, message: &Message) -> u64;

    /// Tokens that a conversation has beyond those of its messages: its beginning, and the opening of the answer.
    fn frame_tokens(&mut self) -> u64;

    /// How it counts.
    fn counting(&self) -> Counting;

    /// Tokens of a whole conversation.
    fn tokens(&mut self, messages: &[Message]) -> u64 {
        let all: u64 = messages.iter().map(|message| self.message_tokens(message)).sum();
        self.frame_tokens() + all
    }
}

/// How far a count can be trusted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Counting {
    /// By the model's own tokenizer, named here.
    Exact(String),
    /// By something else, said here.
    Estimate(String),
}

/// Counts characters and takes so many for a token: what is left where nobody offers a tokenizer.
///
/// ```
/// use longstep::dialogue::{EstimatedTokens, Message, Role, TokenCounter};
/// let mut counter = EstimatedTokens::default();
/// assert_eq!(counter.message_tokens(&Message::new(Role::User, "put the cup on the shelf")), 11);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedTokens {
    /// Characters of a token, on average.
    pub characters: f64,
    /// Tokens around each message.
    pub around: u64,
}

impl Default for EstimatedTokens {
    /// Three and a half characters for a token: a little low for English prose and about right for the JSON of an
    /// environment, so that an estimate is rather too high than too low.
    fn default() -> Self {
        Self {
            characters: 3.5,
            around: 4,
        }
    }
}

impl TokenCounter for EstimatedTokens {
    fn message_tokens(&mut self, message: &Message) -> u64 {
        let characters = message.text.chars().count() as f64;
        (characters / self.characters).ceil() as u64 + self.around
    }

    fn frame_tokens(&mut self) -> u64 {
        self.around
    }

    fn counting(&self) -> Counting {
        Counting::Estimate(format!("{} characters taken for a token", self.characters))
    }
}
