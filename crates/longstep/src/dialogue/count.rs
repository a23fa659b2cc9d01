//! Token counting. Only a model's tokenizer gives exact counts.

use super::Message;

/// Counts tokens for a model. The library has no tokenizer; the owner of the model implements this trait.
pub trait TokenCounter {
    /// Returns the tokens of a message, including its chat-template markers.
    fn message_tokens(&mut self, message: &Message) -> u64;

    /// Returns the tokens of a conversation outside its messages: its start, and the start of the answer.
    fn frame_tokens(&mut self) -> u64;

    /// Returns the method of counting.
    fn counting(&self) -> Counting;

    /// Returns the tokens of a whole conversation.
    fn tokens(&mut self, messages: &[Message]) -> u64 {
        let all: u64 = messages.iter().map(|message| self.message_tokens(message)).sum();
        self.frame_tokens() + all
    }
}

/// Accuracy of a token count.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Counting {
    /// Exact, by the named tokenizer.
    Exact(String),
    /// Estimated, by the described method.
    Estimate(String),
}

/// Estimates tokens from the number of characters, for use without a tokenizer.
///
/// ```
/// use longstep::dialogue::{EstimatedTokens, Message, Role, TokenCounter};
/// let mut counter = EstimatedTokens::default();
/// assert_eq!(counter.message_tokens(&Message::new(Role::User, "put the cup on the shelf")), 11);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct EstimatedTokens {
    /// Average number of characters in a token.
    pub characters: f64,
    /// Tokens around each message.
    pub around: u64,
}

impl Default for EstimatedTokens {
    /// 3.5 characters per token: a little low for English prose and about right for environment JSON, so estimates are
    /// high rather than low.
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
