//! The bodies of chat requests, in the format of each kind of server.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use longstep::dialogue::{ChatRequest, Message, Role};
use serde_json::{Map, Value, json};

use crate::Reasoning;

/// The parts of a request that not every server accepts.
#[derive(Debug, Clone, Copy)]
pub(super) struct Choice<'a> {
    pub(super) schema: Option<&'a Value>,
    pub(super) temperature: Option<f64>,
    pub(super) top_p: Option<f64>,
    pub(super) seed: Option<u64>,
    pub(super) reasoning: Option<Reasoning>,
    /// False for an answer in one piece.
    pub(super) streams: bool,
    /// Limit of the answer with its reasoning.
    pub(super) max_tokens: u32,
}

/// The parts of a request in OpenAI's format that differ between servers.
#[derive(Debug, Clone, Copy)]
pub(super) struct OpenAiForm {
    /// The name of the token limit.
    pub(super) limit: &'static str,
    /// True if the server reports the token usage of a streamed answer.
    pub(super) usage: bool,
    /// True for a schema beside `json_object`: the older form of llama.cpp and its relatives.
    pub(super) is_older: bool,
}

/// The body in OpenAI's format.
pub(super) fn openai(model: &str, request: &ChatRequest, choice: Choice<'_>, form: OpenAiForm) -> Value {
    let messages = request
        .messages
        .iter()
        .map(|message| json!({"role": role(message), "content": openai_content(message)}));
    let mut body = Map::new();
    body.insert("model".into(), model.into());
    body.insert("messages".into(), messages.collect());
    body.insert("stream".into(), choice.streams.into());
    if form.usage && choice.streams {
        body.insert("stream_options".into(), json!({"include_usage": true}));
    }
    body.insert(form.limit.into(), choice.max_tokens.into());
    add(&mut body, "temperature", choice.temperature);
    add(&mut body, "top_p", choice.top_p);
    add(&mut body, "seed", choice.seed);
    add(
        &mut body,
        "reasoning_effort",
        choice.reasoning.and_then(Reasoning::effort),
    );
    let format = choice.schema.map(|schema| {
        if form.is_older {
            json!({"type": "json_object", "schema": schema})
        } else {
            json!({"type": "json_schema", "json_schema": {"name": "answer", "strict": true, "schema": schema}})
        }
    });
    add(&mut body, "response_format", format);
    body.into()
}

fn role(message: &Message) -> &'static str {
    match message.role {
        Role::System => "system",
        Role::User => "user",
        Role::Assistant => "assistant",
    }
}

/// A text, or with pictures a list of parts.
fn openai_content(message: &Message) -> Value {
    if message.pictures.is_empty() {
        return message.text.as_str().into();
    }
    let pictures = message.pictures.iter().map(|picture| {
        let url = format!(
            "data:{};base64,{}",
            picture.media_type(),
            STANDARD.encode(picture.bytes())
        );
        json!({"type": "image_url", "image_url": {"url": url}})
    });
    let text = json!({"type": "text", "text": message.text});
    std::iter::once(text).chain(pictures).collect()
}

fn anthropic_content(message: &Message) -> Value {
    if message.pictures.is_empty() {
        return message.text.as_str().into();
    }
    let pictures = message.pictures.iter().map(|picture| {
        let data = STANDARD.encode(picture.bytes());
        json!({"type": "image", "source": {"type": "base64", "media_type": picture.media_type(), "data": data}})
    });
    let text = json!({"type": "text", "text": message.text});
    std::iter::once(text).chain(pictures).collect()
}

/// Returns the request with the words of the system at the beginning of the first message of the user.
pub(super) fn without_system(request: &ChatRequest) -> ChatRequest {
    let (system, rest) = parted(request);
    let mut messages: Vec<Message> = rest.cloned().collect();
    if let (Some(system), Some(first)) = (system, messages.iter_mut().find(|own| own.role == Role::User)) {
        first.text = format!("{system}\n\n{}", first.text);
    }
    ChatRequest {
        messages,
        ..request.clone()
    }
}

/// Adds a field if it has a value.
fn add(fields: &mut Map<String, Value>, name: &str, value: Option<impl Into<Value>>) {
    if let Some(value) = value {
        fields.insert(name.to_owned(), value.into());
    }
}

/// Joins the system messages to one text, which these dialects send apart from the conversation; also returns the other
/// messages.
fn parted(request: &ChatRequest) -> (Option<String>, impl Iterator<Item = &Message>) {
    let (system, rest): (Vec<_>, Vec<_>) = request
        .messages
        .iter()
        .partition(|message| message.role == Role::System);
    let texts: Vec<&str> = system.iter().map(|message| message.text.as_str()).collect();
    ((!texts.is_empty()).then(|| texts.join("\n\n")), rest.into_iter())
}

/// The body in Anthropic's format.
pub(super) fn anthropic(model: &str, request: &ChatRequest, choice: Choice<'_>) -> Value {
    let (system, messages) = parted(request);
    let messages = messages.map(|message| json!({"role": role(message), "content": anthropic_content(message)}));
    let mut body = Map::new();
    body.insert("model".into(), model.into());
    add(&mut body, "system", system);
    body.insert("messages".into(), messages.collect());
    body.insert("stream".into(), true.into());
    body.insert("max_tokens".into(), choice.max_tokens.into());
    let mut output = Map::new();
    let format = choice
        .schema
        .map(|schema| json!({"type": "json_schema", "schema": schema}));
    add(&mut output, "format", format);
    let mut temperature = choice.temperature;
    match choice.reasoning {
        Some(Reasoning::Off) => add(&mut body, "thinking", Some(json!({"type": "disabled"}))),
        Some(Reasoning::Tokens(tokens)) => {
            let thinking = json!({"type": "enabled", "budget_tokens": tokens});
            add(&mut body, "thinking", Some(thinking));
            // The API accepts none beside a budget.
            temperature = None;
        }
        Some(effort) => add(&mut output, "effort", effort.effort()),
        None => {}
    }
    add(
        &mut body,
        "output_config",
        (!output.is_empty()).then_some(Value::Object(output)),
    );
    add(&mut body, "temperature", temperature);
    add(&mut body, "top_p", choice.top_p);
    body.into()
}

/// The body in Gemini's format. The model is part of the address.
pub(super) fn gemini(request: &ChatRequest, choice: Choice<'_>) -> Value {
    let (system, messages) = parted(request);
    let contents = messages.map(|message| {
        let role = if message.role == Role::Assistant {
            "model"
        } else {
            "user"
        };
        let pictures = message.pictures.iter().map(|picture| {
            json!({"inlineData": {"mimeType": picture.media_type(), "data": STANDARD.encode(picture.bytes())}})
        });
        let parts: Vec<Value> = std::iter::once(json!({"text": message.text})).chain(pictures).collect();
        json!({"role": role, "parts": parts})
    });
    let mut settings = Map::new();
    if let Some(schema) = choice.schema {
        settings.insert("responseMimeType".into(), "application/json".into());
        settings.insert("responseJsonSchema".into(), schema.clone());
    }
    add(&mut settings, "temperature", choice.temperature);
    settings.insert("maxOutputTokens".into(), choice.max_tokens.into());
    add(&mut settings, "topP", choice.top_p);
    add(&mut settings, "seed", choice.seed);
    let thinking = choice
        .reasoning
        .map(|reasoning| json!({"thinkingBudget": reasoning.tokens()}));
    add(&mut settings, "thinkingConfig", thinking);
    let mut body = Map::new();
    add(
        &mut body,
        "systemInstruction",
        system.map(|text| json!({"parts": [{"text": text}]})),
    );
    body.insert("contents".into(), contents.collect());
    body.insert("generationConfig".into(), settings.into());
    body.into()
}

/// The body in Ollama's own format, which alone can set the size of the context.
pub(super) fn ollama(model: &str, request: &ChatRequest, choice: Choice<'_>, context: Option<u64>) -> Value {
    let messages = request.messages.iter().map(|message| {
        let mut own = Map::new();
        own.insert("role".into(), role(message).into());
        own.insert("content".into(), message.text.as_str().into());
        let pictures = message.pictures.iter();
        let pictures: Vec<String> = pictures.map(|picture| STANDARD.encode(picture.bytes())).collect();
        add(&mut own, "images", (!pictures.is_empty()).then_some(pictures));
        Value::Object(own)
    });
    let mut options = Map::new();
    add(&mut options, "num_ctx", context);
    options.insert("num_predict".into(), choice.max_tokens.into());
    add(&mut options, "temperature", choice.temperature);
    add(&mut options, "top_p", choice.top_p);
    add(&mut options, "seed", choice.seed);
    let mut body = Map::new();
    body.insert("model".into(), model.into());
    body.insert("messages".into(), messages.collect());
    body.insert("stream".into(), choice.streams.into());
    let thinks = choice.reasoning.map(|reasoning| match reasoning {
        Reasoning::Off => Value::Bool(false),
        Reasoning::Tokens(_) => Value::Bool(true),
        effort => effort.effort().into(),
    });
    add(&mut body, "think", thinks);
    add(&mut body, "format", choice.schema.cloned());
    body.insert("options".into(), options.into());
    body.into()
}
