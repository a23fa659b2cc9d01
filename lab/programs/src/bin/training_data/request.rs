//! The parts of a request and a reply that all kinds of training data share.

use std::fmt::Display;

use longstep::dialogue::{Likelihood, Message, Reply, Role};
use serde_json::{Value, json};

/// Returns messages as pairs of role and text.
pub(crate) fn pairs(messages: &[Message]) -> Vec<Value> {
    messages
        .iter()
        .map(|message| json!([role(message.role), message.text]))
        .collect()
}

pub(crate) fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

/// Returns the reply of a model that is trained for the request.
pub(crate) fn reply(text: &str) -> Reply {
    Reply {
        likelihood: Some(Likelihood {
            is_trained: true,
            ..Likelihood::default()
        }),
        ..Reply::complete(text)
    }
}

/// Returns an answer, and none for a question: the program composes the words of a question.
pub(crate) fn learned_answer(answer: &str) -> Option<&str> {
    Some(answer).filter(|answer| !answer.starts_with("question:"))
}

/// Returns the message for a mistake in a paragraph of a text file.
pub(crate) fn mistake(file: &str, paragraph: &str, reason: impl Display) -> String {
    format!("{file}: {reason} in `{paragraph}`")
}
