//! The request format of a server, reduced by the parameters that it rejects.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use longstep::dialogue::{ChatRequest, Constraint, Message, Role};
use serde_json::{Map, Value, json};

use super::endpoint::Kind;
use crate::Sampling;

/// The form of a JSON schema in a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SchemaForm {
    /// `response_format: json_schema`, or the equivalent of the dialect.
    Schema,
    /// `response_format: json_object` with a schema beside it: the older form of llama.cpp and its relatives.
    Object,
    /// No schema.
    Nothing,
}

/// The parameters that a server accepts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    kind: Kind,
    /// Name of the token limit. OpenAI's newer models reject the old name; several other servers ignore the new one.
    limit: &'static str,
    schema: SchemaForm,
    /// Reasoning models reject it.
    temperature: bool,
    top_p: bool,
    seed: bool,
    /// True if the server reports the token usage of a streamed answer.
    usage: bool,
    /// False if the system's words go into the first message of the user.
    system: bool,
    /// False for a server that answers in one piece.
    streams: bool,
    /// True once the other name of the token limit was tried.
    renamed: bool,
}

/// Words by which servers and their parts complain about a JSON schema.
const SCHEMA: [&str; 12] = [
    "response_format",
    "json_schema",
    "json schema",
    "json mode",
    "json_object",
    "json_validate_failed",
    "structured output",
    "output_config",
    "responsejsonschema",
    "responseschema",
    "grammar",
    "required for format",
];

/// Words by which servers and chat templates complain about the role of the system.
const SYSTEM: [&str; 9] = [
    "system role",
    "conversation roles",
    "roles are supported",
    "system message",
    "developer instruction",
    "systeminstruction",
    "system_instruction",
    "only user and assistant roles",
    "roles must alternate",
];

const NEW_LIMIT: &str = "max_completion_tokens";
const OLD_LIMIT: &str = "max_tokens";

impl Dialect {
    /// The initial dialect for a kind of server.
    pub(super) fn of(kind: Kind) -> Self {
        let limit = match kind {
            Kind::OpenAi | Kind::Azure => NEW_LIMIT,
            Kind::Ollama | Kind::Other | Kind::Anthropic | Kind::Gemini => OLD_LIMIT,
        };
        Self {
            kind,
            limit,
            schema: SchemaForm::Schema,
            temperature: true,
            top_p: true,
            seed: kind != Kind::Anthropic,
            usage: true,
            system: true,
            streams: true,
            renamed: false,
        }
    }

    /// True if requests carry a schema.
    pub(super) fn sends_schema(&self) -> bool {
        self.schema != SchemaForm::Nothing
    }

    /// Removes the parameter that the server's error message names. Returns the smaller dialect and a warning, or
    /// `None` if the message names no parameter that can be omitted.
    pub(super) fn without(
        self,
        complaint: &str,
        request: &ChatRequest,
        sampling: &Sampling,
    ) -> Option<(Self, Option<&'static str>)> {
        let complaint = complaint.to_lowercase();
        let names = |words: &[&str]| words.iter().any(|word| complaint.contains(word));
        if self.usage && names(&["stream_options"]) {
            return Some((Self { usage: false, ..self }, None));
        }
        if self.streams && self.may_send_whole() && names(&["stream"]) {
            let streams = false;
            return Some((Self { streams, ..self }, None));
        }
        // "Too large for the context" names the limit, and another name does not help.
        if names(&["too large", "context length", "context size", "context window"]) {
            return None;
        }
        let has_system = request.messages.iter().any(|message| message.role == Role::System);
        if self.system && has_system && names(&SYSTEM) {
            return Some((Self { system: false, ..self }, None));
        }
        let has_schema = matches!(request.constraint, Constraint::JsonSchema(_)) && self.sends_schema();
        if has_schema && names(&SCHEMA) {
            // OpenAI and Azure have no second form of a schema; other servers may.
            if self.schema == SchemaForm::Schema && matches!(self.kind, Kind::Other | Kind::Ollama) {
                let schema = SchemaForm::Object;
                return Some((Self { schema, ..self }, None));
            }
            let schema = SchemaForm::Nothing;
            let warning = "the server does not support JSON schemas; continuing without one";
            return Some((Self { schema, ..self }, Some(warning)));
        }
        if self.temperature && names(&["temperature"]) {
            let temperature = false;
            let warning = "the server does not support a temperature; its answers may vary";
            return Some((Self { temperature, ..self }, Some(warning)));
        }
        if self.top_p && sampling.top_p.is_some() && names(&["top_p", "topp"]) {
            let warning = "the server does not support top_p; continuing without it";
            return Some((Self { top_p: false, ..self }, Some(warning)));
        }
        if self.seed && sampling.seed.is_some() && names(&["seed"]) {
            let warning = "the server does not support a seed; its answers may vary";
            return Some((Self { seed: false, ..self }, Some(warning)));
        }
        let limit = match self.limit {
            _ if self.renamed => return None,
            NEW_LIMIT if names(&[NEW_LIMIT]) => OLD_LIMIT,
            OLD_LIMIT if names(&[OLD_LIMIT]) && names(&[NEW_LIMIT]) => NEW_LIMIT,
            _ => return None,
        };
        let renamed = true;
        Some((Self { limit, renamed, ..self }, None))
    }

    /// True if a server's complaint is about a JSON schema or the role of the system, whatever its status.
    pub(super) fn is_about_request(complaint: &str) -> bool {
        let complaint = complaint.to_lowercase();
        SCHEMA.iter().chain(&SYSTEM).any(|word| complaint.contains(word))
    }

    /// True for the dialects whose answers in one piece are read.
    fn may_send_whole(&self) -> bool {
        matches!(self.kind, Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other)
    }

    /// The body of a request.
    pub(super) fn body(&self, model: &str, request: &ChatRequest, sampling: &Sampling) -> Value {
        let merged;
        let request = match self.system {
            true => request,
            false => {
                merged = without_system(request);
                &merged
            }
        };
        let schema = match &request.constraint {
            Constraint::JsonSchema(schema) if self.sends_schema() => Some(schema),
            _ => None,
        };
        let choice = Choice {
            temperature: self.temperature.then_some(sampling.temperature),
            top_p: sampling.top_p.filter(|_| self.top_p),
            seed: sampling.seed.filter(|_| self.seed),
        };
        match self.kind {
            Kind::Anthropic => anthropic(model, request, schema, choice),
            Kind::Gemini => gemini(request, schema, choice),
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => self.openai(model, request, schema, choice),
        }
    }

    fn openai(&self, model: &str, request: &ChatRequest, schema: Option<&Value>, choice: Choice) -> Value {
        let messages = request.messages.iter().map(|message| {
            let role = match message.role {
                Role::System => "system",
                Role::User => "user",
                Role::Assistant => "assistant",
            };
            json!({"role": role, "content": openai_content(message)})
        });
        let mut body = Map::new();
        body.insert("model".into(), model.into());
        body.insert("messages".into(), messages.collect());
        body.insert("stream".into(), self.streams.into());
        if self.usage && self.streams {
            body.insert("stream_options".into(), json!({"include_usage": true}));
        }
        body.insert(self.limit.into(), request.max_tokens.into());
        add(&mut body, "temperature", choice.temperature);
        add(&mut body, "top_p", choice.top_p);
        add(&mut body, "seed", choice.seed);
        add(
            &mut body,
            "response_format",
            schema.map(|schema| self.response_format(schema)),
        );
        body.into()
    }

    fn response_format(&self, schema: &Value) -> Value {
        if self.schema == SchemaForm::Object {
            return json!({"type": "json_object", "schema": schema});
        }
        json!({"type": "json_schema", "json_schema": {"name": "answer", "strict": true, "schema": schema}})
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

/// The parts of a [`Sampling`] that are sent.
#[derive(Debug, Clone, Copy)]
struct Choice {
    temperature: Option<f64>,
    top_p: Option<f64>,
    seed: Option<u64>,
}

/// Returns the request with the words of the system at the beginning of the first message of the user.
fn without_system(request: &ChatRequest) -> ChatRequest {
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

fn anthropic(model: &str, request: &ChatRequest, schema: Option<&Value>, choice: Choice) -> Value {
    let (system, messages) = parted(request);
    let messages = messages.map(|message| {
        let role = if message.role == Role::Assistant {
            "assistant"
        } else {
            "user"
        };
        json!({"role": role, "content": anthropic_content(message)})
    });
    let mut body = Map::new();
    body.insert("model".into(), model.into());
    add(&mut body, "system", system);
    body.insert("messages".into(), messages.collect());
    body.insert("stream".into(), true.into());
    body.insert("max_tokens".into(), request.max_tokens.into());
    let format = schema.map(|schema| json!({"format": {"type": "json_schema", "schema": schema}}));
    add(&mut body, "output_config", format);
    add(&mut body, "temperature", choice.temperature);
    add(&mut body, "top_p", choice.top_p);
    body.into()
}

/// The model is part of the address.
fn gemini(request: &ChatRequest, schema: Option<&Value>, choice: Choice) -> Value {
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
    if let Some(schema) = schema {
        settings.insert("responseMimeType".into(), "application/json".into());
        settings.insert("responseJsonSchema".into(), schema.clone());
    }
    add(&mut settings, "temperature", choice.temperature);
    settings.insert("maxOutputTokens".into(), request.max_tokens.into());
    add(&mut settings, "topP", choice.top_p);
    add(&mut settings, "seed", choice.seed);
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

/// Returns true if an answer plausibly matches the schema: JSON of the right kind, with the required keys. The reader
/// of the answer checks the rest.
pub(super) fn fits(text: &str, schema: &Value) -> bool {
    let Ok(value) = serde_json::from_str::<Value>(text.trim()) else {
        return false;
    };
    if schema["type"] == "object" && !value.is_object() {
        return false;
    }
    let required = schema["required"].as_array().map_or(&[][..], Vec::as_slice);
    required
        .iter()
        .filter_map(Value::as_str)
        .all(|key| value.get(key).is_some())
}
