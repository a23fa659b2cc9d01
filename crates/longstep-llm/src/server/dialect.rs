//! How a server wants to be asked; learnt from what it rejects.

use longstep::dialogue::{ChatRequest, Constraint, Message, Role};
use serde_json::{Map, Value, json};

use super::endpoint::Kind;
use crate::Sampling;

/// How a schema is sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum SchemaForm {
    /// `response_format: json_schema`, or what the dialect has for it.
    Schema,
    /// `response_format: json_object` with a schema beside it: what llama.cpp's relatives had first.
    Object,
    /// Not at all.
    Nothing,
}

/// What a server takes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    kind: Kind,
    /// What the limit of tokens is called. OpenAI's newer models reject the old name, and several other servers do not
    /// know the new one and would ignore it.
    limit: &'static str,
    schema: SchemaForm,
    /// Models that reason take none.
    temperature: bool,
    top_p: bool,
    seed: bool,
    /// Whether it tells what a streamed answer cost.
    usage: bool,
}

const NEW_LIMIT: &str = "max_completion_tokens";
const OLD_LIMIT: &str = "max_tokens";

impl Dialect {
    /// What this kind of server takes, as far as is known before it was asked.
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
        }
    }

    /// Whether a schema is sent.
    pub(super) fn sends_schema(&self) -> bool {
        self.schema != SchemaForm::Nothing
    }

    /// The dialect without what the server's complaint names, and what to warn of; `None` if the complaint names nothing
    /// that can be left out.
    pub(super) fn without(
        self,
        complaint: &str,
        request: &ChatRequest,
        sampling: &Sampling,
    ) -> Option<(Self, Option<&'static str>)> {
        let complaint = complaint.to_lowercase();
        let names = |words: &[&str]| words.iter().any(|word| complaint.contains(word));
        let asked = matches!(request.constraint, Constraint::JsonSchema(_)) && self.sends_schema();
        if asked && names(&["response_format", "json_schema", "output_config", "responsejsonschema"]) {
            // OpenAI itself has nothing between a schema and none; others do.
            if self.schema == SchemaForm::Schema && matches!(self.kind, Kind::Other | Kind::Ollama) {
                let schema = SchemaForm::Object;
                return Some((Self { schema, ..self }, None));
            }
            let schema = SchemaForm::Nothing;
            let warning = "the server takes no JSON schema; asking without one";
            return Some((Self { schema, ..self }, Some(warning)));
        }
        if self.usage && names(&["stream_options"]) {
            return Some((Self { usage: false, ..self }, None));
        }
        if self.temperature && names(&["temperature"]) {
            let temperature = false;
            let warning = "the server takes no temperature; its answers may vary";
            return Some((Self { temperature, ..self }, Some(warning)));
        }
        if self.top_p && sampling.top_p.is_some() && names(&["top_p", "topp"]) {
            let warning = "the server takes no top_p; asking without one";
            return Some((Self { top_p: false, ..self }, Some(warning)));
        }
        if self.seed && sampling.seed.is_some() && names(&["seed"]) {
            let warning = "the server takes no seed; its answers may vary";
            return Some((Self { seed: false, ..self }, Some(warning)));
        }
        let limit = match self.limit {
            NEW_LIMIT if names(&[NEW_LIMIT]) => OLD_LIMIT,
            OLD_LIMIT if names(&[OLD_LIMIT]) && names(&[NEW_LIMIT]) => NEW_LIMIT,
            _ => return None,
        };
        Some((Self { limit, ..self }, None))
    }

    /// The body of a request.
    pub(super) fn body(&self, model: &str, request: &ChatRequest, sampling: &Sampling) -> Value {
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
            json!({"role": role, "content": message.text})
        });
        let mut body = Map::new();
        body.insert("model".into(), model.into());
        body.insert("messages".into(), messages.collect());
        body.insert("stream".into(), true.into());
        if self.usage {
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

/// What is sent of a [`Sampling`].
#[derive(Debug, Clone, Copy)]
struct Choice {
    temperature: Option<f64>,
    top_p: Option<f64>,
    seed: Option<u64>,
}

/// Adds a field that is given.
fn add(fields: &mut Map<String, Value>, name: &str, value: Option<impl Into<Value>>) {
    if let Some(value) = value {
        fields.insert(name.to_owned(), value.into());
    }
}

/// The system messages as one text, which these dialects keep apart from the conversation; and the other messages.
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
        json!({"role": role, "content": message.text})
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

/// The model stands in the address.
fn gemini(request: &ChatRequest, schema: Option<&Value>, choice: Choice) -> Value {
    let (system, messages) = parted(request);
    let contents = messages.map(|message| {
        let role = if message.role == Role::Assistant {
            "model"
        } else {
            "user"
        };
        json!({"role": role, "parts": [{"text": message.text}]})
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

/// Whether an answer is what the schema asks for, as far as can be told at a glance: JSON of the right kind, with the
/// keys that must be there. Whoever reads the answer looks closer.
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
