//! Converts a conversation to tokens with the chat template in the model's file.

use llama_cpp_2::model::{LlamaChatMessage, LlamaChatTemplate, LlamaModel};
use llama_cpp_2::token::LlamaToken;
use longstep::dialogue::{ChatRequest, Message, Role};

/// A conversation as tokens.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct PromptTokens {
    /// All tokens, including those that open the answer.
    pub(super) tokens: Vec<LlamaToken>,
    /// Number of leading tokens that belong to the request's fixed messages, and to the opening of the next one.
    pub(super) fixed: usize,
    /// Number of leading tokens before the last line of the last message: what other instructions share.
    pub(super) shared: usize,
    /// For each picture of the request the number of tokens before it.
    pub(super) pictures: Vec<usize>,
}

/// Converts conversations to tokens for one model.
pub(super) struct Template {
    template: LlamaChatTemplate,
}

impl Template {
    pub(super) fn of(model: &LlamaModel) -> Result<Self, String> {
        let template = model
            .chat_template(None)
            .map_err(|_| "it has no chat template".to_owned())?;
        Ok(Self { template })
    }

    /// The tokens of a request.
    ///
    /// Only the template's own text may become control tokens. The template is rendered around placeholders, and each
    /// message is tokenized separately as plain text: `<|im_end|>` in an instruction stays eleven characters.
    pub(super) fn tokens(&self, model: &LlamaModel, request: &ChatRequest) -> Result<PromptTokens, String> {
        let rendered = self.render(model, &request.messages)?;
        let vocabulary = model.vocab();
        let mut tokens = Vec::new();
        if vocabulary.should_add_bos() {
            tokens.push(vocabulary.bos());
        }
        let (mut fixed, mut shared) = (0, 0);
        let mut pictures = Vec::new();
        let mut rest = rendered.as_str();
        for (index, message) in request.messages.iter().enumerate() {
            let (marker, after) = rest
                .split_once(&placeholder(index))
                .ok_or("its chat template leaves out or reorders messages")?;
            add_marker(&mut tokens, model, marker);
            if index > 0 && index == request.fixed {
                fixed = tokens.len();
            }
            // Pictures come first: most models were trained on questions that follow their picture.
            pictures.extend(message.pictures.iter().map(|_| tokens.len()));
            let text = plain(model, &message.text);
            if index + 1 == request.messages.len() {
                shared = tokens.len() + before_last_line(model, &message.text, &text);
            }
            tokens.extend(text);
            rest = after;
        }
        if request.fixed >= request.messages.len() {
            fixed = tokens.len();
        }
        add_marker(&mut tokens, model, rest);
        tokens.extend(plain(model, &request.answer_so_far));
        Ok(PromptTokens {
            tokens,
            fixed,
            shared: shared.max(fixed),
            pictures,
        })
    }

    fn render(&self, model: &LlamaModel, messages: &[Message]) -> Result<String, String> {
        let turns: Result<Vec<_>, _> = messages
            .iter()
            .enumerate()
            .map(|(index, message)| LlamaChatMessage::new(role(message.role).into(), placeholder(index)))
            .collect();
        let turns = turns.map_err(|error| error.to_string())?;
        model
            .apply_chat_template(&self.template, &turns, true)
            .map_err(|error| format!("its chat template is unknown: {error}"))
    }
}

/// Returns how many tokens of a text stand before its last line.
fn before_last_line(model: &LlamaModel, text: &str, tokens: &[LlamaToken]) -> usize {
    let lines = text.rfind('\n').map_or("", |at| &text[..=at]);
    let pairs = plain(model, lines).into_iter().zip(tokens);
    pairs.take_while(|(own, token)| own == *token).count()
}

/// Placeholder for a message's text; the rendered text around it is the template's own.
fn placeholder(index: usize) -> String {
    format!("MESSAGE{index:06}HERE")
}

fn role(role: Role) -> &'static str {
    match role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

/// Adds text of the template, including control tokens. If the template writes the beginning-of-text token itself, it
/// is not added twice.
fn add_marker(tokens: &mut Vec<LlamaToken>, model: &LlamaModel, text: &str) {
    let marker = model.vocab().tokenize(text.as_bytes(), false, true);
    let twice = tokens.len() == 1 && marker.first() == tokens.first();
    tokens.extend(marker.into_iter().skip(usize::from(twice)));
}

/// Tokenizes a message's text, in which nothing is a control token.
fn plain(model: &LlamaModel, text: &str) -> Vec<LlamaToken> {
    if text.is_empty() {
        return Vec::new();
    }
    model.vocab().tokenize(text.as_bytes(), false, false)
}
