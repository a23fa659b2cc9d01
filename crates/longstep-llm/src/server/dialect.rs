//! How a server wants to be asked; learnt from what it rejects.

use genai::chat::{ChatMessage, ChatOptions, ChatRequest as GenaiRequest, JsonSpec, ReasoningEffort};
use longstep::prompt::{ChatRequest, Constraint, Role};
use serde_json::{Map, Value, json};

use super::endpoint::{Endpoint, Kind};
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

    /// The options of a request.
    pub(super) fn options(&self, endpoint: &Endpoint, request: &ChatRequest, sampling: &Sampling) -> ChatOptions {
        let temperature = self.temperature.then_some(sampling.temperature);
        let top_p = sampling.top_p.filter(|_| self.top_p);
        let seed = sampling.seed.filter(|_| self.seed);
        let schema = match &request.constraint {
            Constraint::JsonSchema(schema) if self.sends_schema() => Some(schema),
            _ => None,
        };
        let mut options = ChatOptions::default().with_capture_usage(self.usage);
        let mut body = Map::new();
        // Exactly this name: genai takes ends such as `-high` for wishes of its own.
        body.insert("model".into(), endpoint.model.clone().into());
        match self.kind {
            Kind::Anthropic | Kind::Gemini => {
                options.temperature = temperature;
                options.top_p = top_p;
                options.seed = seed;
                options.max_tokens = Some(request.max_tokens);
                options.response_format = schema.map(|schema| JsonSpec::new("answer", schema.clone()).into());
                if self.kind == Kind::Gemini {
                    // It stands in the address there.
                    body.clear();
                }
            }
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => {
                // A budget means nothing in this dialect: it is not sent, and the name's end is left alone.
                options.reasoning_effort = Some(ReasoningEffort::Budget(0));
                let mut add = |name: &str, value: Option<Value>| {
                    if let Some(value) = value {
                        body.insert(name.into(), value);
                    }
                };
                add(self.limit, Some(request.max_tokens.into()));
                add("temperature", temperature.map(Value::from));
                add("top_p", top_p.map(Value::from));
                add("seed", seed.map(Value::from));
                add("response_format", schema.map(|schema| self.response_format(schema)));
            }
        }
        options.with_extra_body(Value::Object(body))
    }

    fn response_format(&self, schema: &Value) -> Value {
        if self.schema == SchemaForm::Object {
            return json!({"type": "json_object", "schema": schema});
        }
        json!({"type": "json_schema", "json_schema": {"name": "answer", "strict": true, "schema": schema}})
    }
}

/// The conversation, in genai's words.
pub(super) fn conversation(request: &ChatRequest) -> GenaiRequest {
    let turns = request.messages.iter().map(|message| match message.role {
        Role::System => ChatMessage::system(message.text.as_str()),
        Role::User => ChatMessage::user(message.text.as_str()),
        Role::Assistant => ChatMessage::assistant(message.text.as_str()),
    });
    GenaiRequest::new(turns.collect())
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
