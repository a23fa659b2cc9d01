//! The request format of a server, reduced by the parameters that it rejects.

use longstep::dialogue::{ChatRequest, Constraint, Role};
use serde_json::Value;

use super::body::{self, Choice, OpenAiForm, without_system};
use super::complaint::Complaint;
use super::endpoint::{Endpoint, Kind};
use crate::{Reasoning, Sampling};

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
    /// False if the server rejects a limit of reasoning.
    reasoning: bool,
    /// True for Ollama's own API.
    native: bool,
    /// True once the other name of the token limit was tried.
    renamed: bool,
}

/// Names by which servers reject a JSON schema.
const SCHEMA: [&str; 12] = [
    "response_format",
    "responseformat",
    "json_schema",
    "json_object",
    "json_validate_failed",
    "output_config",
    "output_format",
    "responsejsonschema",
    "responseschema",
    "responsemimetype",
    "guided_json",
    "structured_outputs",
];

/// Words by which servers and their parts complain about a JSON schema.
const ABOUT_SCHEMA: [&str; 6] = [
    "json schema",
    "json mode",
    "structured output",
    "grammar",
    "required for format",
    "specified schema",
];

/// Words of complaints for which another form of the schema is no remedy.
const BEYOND_FORM: [&str; 4] = ["json mode", "grammar", "required for format", "missing field"];

/// Names by which servers reject the role of the system.
const SYSTEM: [&str; 2] = ["systeminstruction", "system_instruction"];

/// Words by which servers and chat templates complain about the role of the system.
const ABOUT_SYSTEM: [&str; 7] = [
    "system role",
    "conversation roles",
    "roles are supported",
    "system message",
    "developer instruction",
    "only user and assistant roles",
    "roles must alternate",
];

/// Names by which servers reject a limit of reasoning.
const REASONING: [&str; 9] = [
    "reasoning_effort",
    "reasoning",
    "effort",
    "think",
    "thinking",
    "thinkingconfig",
    "thinkingbudget",
    "thinking_budget",
    "budget_tokens",
];

/// Gemini's words for a schema that exceeds its budget, among other things.
const BARE: &str = "request contains an invalid argument.";

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
            reasoning: true,
            native: kind == Kind::Ollama,
            renamed: false,
        }
    }

    /// True if requests carry a schema.
    pub(super) fn sends_schema(&self) -> bool {
        self.schema != SchemaForm::Nothing
    }

    /// True for Ollama's own API.
    pub(super) fn is_native(&self) -> bool {
        self.native
    }

    /// The dialect for a server that has OpenAI's API alone.
    pub(super) fn compatible(self) -> Self {
        Self { native: false, ..self }
    }

    /// The address of chat requests.
    pub(super) fn chat_url(&self, endpoint: &Endpoint) -> String {
        if self.native {
            endpoint.beside("/api/chat")
        } else {
            endpoint.chat_url().to_owned()
        }
    }

    /// Removes the parameter that the server's error names. Returns the smaller dialect and a warning, or `None` if it names
    /// no parameter that can be omitted.
    pub(super) fn without(
        self,
        complaint: &Complaint,
        request: &ChatRequest,
        sampling: &Sampling,
    ) -> Option<(Self, Option<&'static str>)> {
        let names = |names: &[&str]| complaint.names(names);
        if self.usage && names(&["stream_options", "include_usage"]) {
            return Some((Self { usage: false, ..self }, None));
        }
        if self.streams && self.may_send_whole() && names(&["stream", "streaming"]) {
            let streams = false;
            return Some((Self { streams, ..self }, None));
        }
        // "Too large for the context" names the limit, and another name does not help.
        if complaint.says(&["too large", "context length", "context size", "context window"]) {
            return None;
        }
        let has_system = request.messages.iter().any(|message| message.role == Role::System);
        if self.system && has_system && (names(&SYSTEM) || complaint.says(&ABOUT_SYSTEM)) {
            return Some((Self { system: false, ..self }, None));
        }
        if self.reasoning && sampling.reasoning.is_some() && names(&REASONING) {
            let warning = "the server does not support this limit of reasoning; continuing without it";
            let reasoning = false;
            return Some((Self { reasoning, ..self }, Some(warning)));
        }
        let has_schema = matches!(request.constraint, Constraint::JsonSchema(_)) && self.sends_schema();
        if has_schema && self.is_about_schema(complaint) {
            return Some(self.without_schema(complaint));
        }
        self.without_sampling(complaint, sampling)
            .or_else(|| self.with_other_limit(complaint))
    }

    fn is_about_schema(&self, complaint: &Complaint) -> bool {
        let is_bare = self.kind == Kind::Gemini && complaint.message.trim().eq_ignore_ascii_case(BARE);
        is_bare || complaint.names(&SCHEMA) || complaint.says(&ABOUT_SCHEMA)
    }

    /// Tries the other form of a schema, if the complaint is about the form, then none. OpenAI and Azure have no second form;
    /// other servers may.
    fn without_schema(self, complaint: &Complaint) -> (Self, Option<&'static str>) {
        let is_about_form = complaint.names(&["response_format", "json_schema"]) && !complaint.says(&BEYOND_FORM);
        let has_other = matches!(self.kind, Kind::Other | Kind::Ollama) && !self.native && is_about_form;
        if self.schema == SchemaForm::Schema && has_other {
            let schema = SchemaForm::Object;
            return (Self { schema, ..self }, None);
        }
        let schema = SchemaForm::Nothing;
        let warning = "the server does not support JSON schemas; continuing without one";
        (Self { schema, ..self }, Some(warning))
    }

    fn without_sampling(self, complaint: &Complaint, sampling: &Sampling) -> Option<(Self, Option<&'static str>)> {
        if self.temperature && complaint.names(&["temperature"]) {
            let temperature = false;
            let warning = "the server does not support a temperature; its answers may vary";
            return Some((Self { temperature, ..self }, Some(warning)));
        }
        if self.top_p && sampling.top_p.is_some() && complaint.names(&["top_p", "topp"]) {
            let warning = "the server does not support top_p; continuing without it";
            return Some((Self { top_p: false, ..self }, Some(warning)));
        }
        if self.seed && sampling.seed.is_some() && complaint.names(&["seed"]) {
            let warning = "the server does not support a seed; its answers may vary";
            return Some((Self { seed: false, ..self }, Some(warning)));
        }
        None
    }

    fn with_other_limit(self, complaint: &Complaint) -> Option<(Self, Option<&'static str>)> {
        let limit = match self.limit {
            _ if self.renamed => return None,
            NEW_LIMIT if complaint.names(&[NEW_LIMIT]) => OLD_LIMIT,
            OLD_LIMIT if complaint.names(&[OLD_LIMIT]) && complaint.names(&[NEW_LIMIT]) => NEW_LIMIT,
            _ => return None,
        };
        let renamed = true;
        Some((Self { limit, renamed, ..self }, None))
    }

    /// True if a server's complaint is about a JSON schema or the role of the system, whatever its status.
    pub(super) fn is_about_request(complaint: &Complaint) -> bool {
        complaint.says(&ABOUT_SCHEMA)
            || complaint.says(&ABOUT_SYSTEM)
            || complaint.names(&SCHEMA)
            || complaint.names(&SYSTEM)
    }

    /// True for the dialects whose answers in one piece are read.
    fn may_send_whole(&self) -> bool {
        matches!(self.kind, Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other)
    }

    /// The limit of reasoning that is in force.
    fn reasoning(&self, sampling: &Sampling) -> Option<Reasoning> {
        sampling.reasoning.filter(|_| self.reasoning)
    }

    /// The limit of an answer with its reasoning. The tokens for reasoning remain where the server rejects the limit.
    pub(super) fn max_tokens(request: &ChatRequest, sampling: &Sampling) -> u32 {
        let reasoning = sampling.reasoning.map_or(0, Reasoning::tokens);
        request.max_tokens.saturating_add(reasoning)
    }

    /// The body of a request. Ollama's own API also sets the size of the context.
    pub(super) fn body(&self, model: &str, request: &ChatRequest, sampling: &Sampling, context: Option<u64>) -> Value {
        let merged;
        let request = if self.system {
            request
        } else {
            merged = without_system(request);
            &merged
        };
        let schema = match &request.constraint {
            Constraint::JsonSchema(schema) if self.sends_schema() => Some(schema),
            _ => None,
        };
        let choice = Choice {
            schema,
            temperature: self.temperature.then_some(sampling.temperature),
            top_p: sampling.top_p.filter(|_| self.top_p),
            seed: sampling.seed.filter(|_| self.seed),
            reasoning: self.reasoning(sampling),
            streams: self.streams,
            max_tokens: Self::max_tokens(request, sampling),
        };
        let form = OpenAiForm {
            limit: self.limit,
            usage: self.usage,
            is_older: self.schema == SchemaForm::Object,
        };
        match self.kind {
            Kind::Anthropic => body::anthropic(model, request, choice),
            Kind::Gemini => body::gemini(request, choice),
            Kind::Ollama if self.native => body::ollama(model, request, choice, context),
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => body::openai(model, request, choice, form),
        }
    }
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
