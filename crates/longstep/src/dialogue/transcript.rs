//! Dialogues that a caller carries out with a model, and their transcripts.

use serde::de::DeserializeOwned;
use serde_json::Value;

use super::{ChatRequest, Constraint, ConstraintKind, Finish, Message, Picture, Reply, Role, Task, Usage, object_text};
use crate::goal::GoalError;

/// A dialogue with a model about one matter: requests, and the replies to them.
///
/// A dialogue never calls the model. The caller sends [`Dialogue::request`] and passes the reply to
/// [`Dialogue::supply`] until that returns a result; `longstep_llm::converse` does both.
pub trait Dialogue {
    /// The result of the dialogue.
    type Output;

    /// Returns the next request to the model.
    fn request(&self) -> ChatRequest;

    /// Interprets the reply to the last request. Returns none if the model must answer a further request.
    ///
    /// # Errors
    ///
    /// The reply is cut off, refused or invalid.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Self::Output>, DialogueError>;

    /// Returns the messages and replies so far.
    fn transcript(&self) -> &Transcript;
}

/// The messages of a dialogue, the model's answer so far, and its cost.
#[derive(Debug, Clone)]
pub struct Transcript {
    pub(crate) kind: ConstraintKind,
    task: Task,
    pub(crate) messages: Vec<Message>,
    pub(crate) fixed: usize,
    pub(crate) answer: String,
    usage: Usage,
    /// True once another answer was requested in place of one that could not be read.
    is_repeated: bool,
}

impl Transcript {
    /// Starts with messages that are equal in all requests of the domain.
    pub(crate) fn new(kind: ConstraintKind, messages: Vec<Message>) -> Self {
        Self {
            kind,
            task: Task::Other,
            fixed: messages.len(),
            messages,
            answer: String::new(),
            usage: Usage::default(),
            is_repeated: false,
        }
    }

    /// Sets the task of all requests.
    pub(crate) fn for_task(self, task: Task) -> Self {
        Self { task, ..self }
    }

    pub(crate) fn push(&mut self, role: Role, text: impl Into<String>) {
        self.messages.push(Message::new(role, text));
    }

    pub(crate) fn push_with_pictures(&mut self, role: Role, text: impl Into<String>, pictures: Vec<Picture>) {
        self.messages.push(Message::new(role, text).with_pictures(pictures));
    }

    /// Returns the request for any answer.
    pub(crate) fn free(&self, max_tokens: u32) -> ChatRequest {
        self.request(Constraint::Free, max_tokens)
    }

    /// Returns the request for an answer under a grammar.
    pub(crate) fn under_grammar(&self, grammar: String, max_tokens: u32) -> ChatRequest {
        self.request(Constraint::Lark(grammar), max_tokens)
    }

    /// Returns the request for an answer under a JSON schema.
    pub(crate) fn under_schema(&self, schema: Value, max_tokens: u32) -> ChatRequest {
        self.request(Constraint::JsonSchema(schema), max_tokens)
    }

    fn request(&self, constraint: Constraint, max_tokens: u32) -> ChatRequest {
        ChatRequest {
            task: self.task,
            messages: self.messages.clone(),
            fixed: self.fixed,
            answer_so_far: self.answer.clone(),
            constraint,
            max_tokens,
        }
    }

    /// Adds a reply to the answer.
    ///
    /// # Errors
    ///
    /// The reply was cut off or refused.
    pub(crate) fn receive(&mut self, reply: &Reply) -> Result<(), DialogueError> {
        self.usage += reply.usage;
        self.answer.push_str(&reply.text);
        whole(reply)
    }

    /// Returns what was read from a reply under a schema. For the first one that cannot be read, adds what is wrong with it to
    /// the conversation and returns none: the next request asks for another answer. A cut or refused reply is not asked
    /// for again.
    ///
    /// # Errors
    ///
    /// The reply cannot be read, and it is the second one or was written under a grammar.
    pub(crate) fn read_or_repeat<T>(
        &mut self,
        reply: &Reply,
        read: Result<T, DialogueError>,
    ) -> Result<Option<T>, DialogueError> {
        let may_repeat = self.kind == ConstraintKind::JsonSchema && !self.is_repeated;
        let wrong = match &read {
            Err(error) if may_repeat => error.wrong_form(),
            _ => None,
        };
        let Some(wrong) = wrong else {
            return read.map(Some);
        };
        self.is_repeated = true;
        self.answer.clear();
        // An assistant's message may not be empty.
        let text = match one_line(&reply.text) {
            text if text.is_empty() => "{}".to_owned(),
            text => text.chars().take(REPEATED).collect(),
        };
        self.push(Role::Assistant, text);
        self.push(
            Role::User,
            format!("This answer cannot be used: {wrong}. Write nothing but one JSON object in the form of the answers before."),
        );
        Ok(None)
    }

    /// Returns the messages, the fixed ones first.
    pub fn messages(&self) -> &[Message] {
        &self.messages
    }

    /// Returns the number of messages that are equal in all requests of the domain.
    pub(crate) fn fixed(&self) -> usize {
        self.fixed
    }

    /// Counts a reply that is not kept: the beginning of an answer.
    pub(crate) fn receive_beginning(&mut self, reply: &Reply) {
        self.usage += reply.usage;
    }

    /// Sets the beginning of the next answer.
    pub(crate) fn begin_answer(&mut self, begin: &str) {
        begin.clone_into(&mut self.answer);
    }

    /// Forgets the answer so far: the next request is for another one.
    pub(crate) fn clear_answer(&mut self) {
        self.answer.clear();
    }

    /// Returns the model's answer so far.
    pub fn answer(&self) -> &str {
        &self.answer
    }

    /// Returns the token counts of all replies.
    pub fn usage(&self) -> Usage {
        self.usage
    }
}

/// Reason why a reply is unusable. Replies are never completed by guesses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum DialogueError {
    /// The reply was cut off.
    #[error("the model's answer was cut off: `{0}`")]
    CutOff(String),
    /// The model or its server refused to answer.
    #[error("the model refused to answer")]
    Refused,
    /// The reply does not have the required form.
    #[error("the model's answer cannot be read: {0}")]
    Unreadable(String),
    /// The reply names an unknown goal or entity.
    #[error("the model's answer is no goal here: {0}")]
    NoGoal(#[from] GoalError),
    /// The reply is no change of the plan.
    #[error("the model's answer is no change of this plan: {0}")]
    NoWish(String),
    /// Enumerating the possible goals exceeds the work budget.
    #[error("{TOO_MUCH_WORK}")]
    TooMuchWork,
}

impl DialogueError {
    /// Returns what is wrong with the form of the reply, if that is what is wrong. What is no change of a plan may be a goal,
    /// which the caller finds out.
    fn wrong_form(&self) -> Option<String> {
        match self {
            Self::Unreadable(reason) => Some(reason.clone()),
            Self::NoGoal(error) => Some(error.to_string()),
            Self::CutOff(_) | Self::Refused | Self::NoWish(_) | Self::TooMuchWork => None,
        }
    }
}

/// Characters of an unreadable reply that the next request repeats.
const REPEATED: usize = 400;

/// Error for a domain and world with too many goals to enumerate.
pub(super) const TOO_MUCH_WORK: &str =
    "there are too many goals in this domain and world, or their conditions take too much work";

/// Checks that a reply is complete.
///
/// # Errors
///
/// The reply was cut off or refused.
pub(crate) fn whole(reply: &Reply) -> Result<(), DialogueError> {
    match reply.finish {
        Finish::Stop => Ok(()),
        Finish::Length => Err(DialogueError::CutOff(shortened(&reply.text))),
        Finish::Refused => Err(DialogueError::Refused),
    }
}

/// Parses the JSON object of a server's answer.
///
/// # Errors
///
/// The text is no such object.
pub(crate) fn object<T: DeserializeOwned>(text: &str) -> Result<T, DialogueError> {
    let bare = object_text(text);
    serde_json::from_str(bare.as_deref().unwrap_or(text.trim()))
        .map_err(|error| DialogueError::Unreadable(format!("{error}: `{}`", shortened(text))))
}

/// Returns a text as one line.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn shortened(text: &str) -> String {
    let mut short: String = one_line(text).chars().take(120).collect();
    if short.len() < text.trim().len() {
        short.push('…');
    }
    short
}
