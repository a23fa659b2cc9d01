//! The JSON that goes to a server and comes back.

use longstep::prompt::{ChatRequest, Constraint, Finish, Reply, Role, Usage};
use serde::Deserialize;
use serde_json::{Map, Value, json};

/// How a server wants to be asked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Dialect {
    /// What the limit of tokens is called. OpenAI's newer models reject the old name, and
    /// several other servers do not know the new one and would ignore it.
    limit: &'static str,
    /// Whether it takes a JSON schema.
    schema: bool,
    /// Whether it takes a temperature; models that reason do not.
    temperature: bool,
}

const NEW_LIMIT: &str = "max_completion_tokens";
const OLD_LIMIT: &str = "max_tokens";

impl Dialect {
    /// What OpenAI takes.
    pub(super) fn openai() -> Self {
        Self {
            limit: NEW_LIMIT,
            schema: true,
            temperature: true,
        }
    }

    /// What most other servers take.
    pub(super) fn common() -> Self {
        Self {
            limit: OLD_LIMIT,
            ..Self::openai()
        }
    }

    /// The dialect without what the server's complaint names, and what to warn of; `None` if
    /// the complaint names nothing that can be left out.
    pub(super) fn without(self, complaint: &str, request: &ChatRequest) -> Option<(Self, Option<&'static str>)> {
        let complaint = complaint.to_lowercase();
        let names = |word: &str| complaint.contains(word);
        let asked = matches!(request.constraint, Constraint::JsonSchema(_));
        if self.schema && asked && (names("response_format") || names("json_schema")) {
            let dialect = Self { schema: false, ..self };
            return Some((dialect, Some("the server takes no JSON schema; asking without one")));
        }
        if self.temperature && names("temperature") {
            let dialect = Self {
                temperature: false,
                ..self
            };
            return Some((dialect, Some("the server takes no temperature; its answers may vary")));
        }
        let wrong = names(self.limit);
        match self.limit {
            NEW_LIMIT if wrong => Some((
                Self {
                    limit: OLD_LIMIT,
                    ..self
                },
                None,
            )),
            OLD_LIMIT if wrong && names(NEW_LIMIT) => Some((
                Self {
                    limit: NEW_LIMIT,
                    ..self
                },
                None,
            )),
            _ => None,
        }
    }
}

/// The body of a request.
pub(super) fn body(model: &str, request: &ChatRequest, dialect: Dialect) -> Value {
    let turns = request.messages.iter().map(|message| {
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        json!({"role": role, "content": message.text})
    });
    let mut body = Map::new();
    body.insert("model".into(), model.into());
    body.insert("messages".into(), turns.collect());
    body.insert(dialect.limit.into(), request.max_tokens.into());
    if dialect.temperature {
        body.insert("temperature".into(), 0.into());
    }
    if let Constraint::JsonSchema(schema) = &request.constraint
        && dialect.schema
    {
        let format = json!({"name": "answer", "strict": true, "schema": schema});
        body.insert(
            "response_format".into(),
            json!({"type": "json_schema", "json_schema": format}),
        );
    }
    Value::Object(body)
}

#[derive(Deserialize)]
struct WireAnswer {
    choices: Vec<WireChoice>,
    usage: Option<WireUsage>,
}

#[derive(Deserialize)]
struct WireChoice {
    message: WireMessage,
    finish_reason: Option<String>,
}

#[derive(Deserialize)]
struct WireMessage {
    content: Option<String>,
    refusal: Option<String>,
}

#[derive(Deserialize)]
struct WireUsage {
    #[serde(default)]
    prompt_tokens: u64,
    #[serde(default)]
    completion_tokens: u64,
    prompt_tokens_details: Option<WireDetails>,
}

#[derive(Deserialize)]
struct WireDetails {
    cached_tokens: Option<u64>,
}

/// What an answer says.
pub(super) fn reply(answer: &Value) -> Result<Reply, String> {
    let answer = WireAnswer::deserialize(answer).map_err(|error| error.to_string())?;
    let choice = answer.choices.into_iter().next().ok_or("it has no choices")?;
    let (text, finish) = match (choice.message.refusal, choice.message.content) {
        (Some(refusal), _) if !refusal.is_empty() => (refusal, Finish::Refused),
        (_, content) => {
            let finish = match choice.finish_reason.as_deref() {
                Some("length") => Finish::Length,
                Some("content_filter") => Finish::Refused,
                _ => Finish::Stop,
            };
            let missing = content.is_none() && finish == Finish::Stop;
            if missing {
                return Err("its message has no content".into());
            }
            (content.unwrap_or_default(), finish)
        }
    };
    let mut usage = Usage {
        calls: 1,
        ..Usage::default()
    };
    if let Some(told) = answer.usage {
        usage.prompt_tokens = told.prompt_tokens;
        usage.completion_tokens = told.completion_tokens;
        let cached = told.prompt_tokens_details.and_then(|details| details.cached_tokens);
        usage.cached_tokens = cached.unwrap_or(0);
    }
    Ok(Reply { text, finish, usage })
}
