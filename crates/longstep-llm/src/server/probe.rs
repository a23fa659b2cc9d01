//! Requests besides the chat: the size of the context, the tokens of a text. Nothing here fails or takes long; a
//! missing or implausible value is `None`. Unused parts of an answer are skipped, not built: a JSON value can take a
//! hundred times the memory of its text.

use std::collections::BTreeMap;
use std::fmt;

use serde::de::{DeserializeOwned, IgnoredAny, MapAccess, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer};
use serde_json::{Value, json};

use super::connection::Connection;
use super::endpoint::{Endpoint, Kind};
use super::limit::TOKENS;

/// Tokens of prompt and answer together, if the server reports them.
pub(super) fn context(endpoint: &Endpoint, connection: &Connection) -> Option<u64> {
    let context = match endpoint.kind {
        Kind::Other => {
            let props: Option<Props> = ask(endpoint, connection, "/props", None);
            let llama = props.map(|props| props.default_generation_settings.n_ctx);
            llama.or_else(|| {
                let models: Models = ask(endpoint, connection, "/v1/models", None)?;
                let ours = models.data.into_iter().find(|model| model.id == endpoint.model);
                ours?.max_model_len
            })
        }
        Kind::Ollama => {
            let loaded: Option<Loaded> = ask(endpoint, connection, "/api/ps", None);
            let ours =
                |own: &LoadedModel| own.name == endpoint.model || own.name == format!("{}:latest", endpoint.model);
            let loaded = loaded.and_then(|own| own.models.into_iter().find(ours)?.context_length);
            loaded.or_else(|| {
                let body = json!({"model": endpoint.model});
                let about: About = ask(endpoint, connection, "/api/show", Some(body))?;
                about.context()
            })
        }
        Kind::OpenAi | Kind::Azure | Kind::Anthropic | Kind::Gemini => None,
    };
    context.filter(|tokens| (1..=TOKENS).contains(tokens))
}

/// llama.cpp's answer.
#[derive(Deserialize)]
struct Props {
    default_generation_settings: GenerationSettings,
}

#[derive(Deserialize)]
struct GenerationSettings {
    n_ctx: u64,
}

/// vLLM's answer.
#[derive(Deserialize)]
struct Models {
    data: Vec<ModelEntry>,
}

#[derive(Deserialize)]
struct ModelEntry {
    #[serde(default)]
    id: String,
    max_model_len: Option<u64>,
}

/// Ollama's answer about the models in memory.
#[derive(Deserialize)]
struct Loaded {
    #[serde(default)]
    models: Vec<LoadedModel>,
}

#[derive(Deserialize)]
struct LoadedModel {
    #[serde(default)]
    name: String,
    context_length: Option<u64>,
}

/// Context that is asked for where neither the user nor the model has one: twice the one with which Ollama loads models by
/// itself.
const OLLAMA_DEFAULT: u64 = 8192;

/// Ollama's answer about a model.
#[derive(Deserialize)]
struct About {
    #[serde(default)]
    parameters: String,
    #[serde(default)]
    model_info: BTreeMap<String, Whole>,
}

/// A whole number; `None` for any other value, which is skipped.
struct Whole(Option<u64>);

impl<'de> Deserialize<'de> for Whole {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(WholeVisitor).map(Self)
    }
}

struct WholeVisitor;

impl<'de> Visitor<'de> for WholeVisitor {
    type Value = Option<u64>;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a value")
    }

    fn visit_u64<E>(self, number: u64) -> Result<Self::Value, E> {
        Ok(Some(number))
    }

    fn visit_i64<E>(self, _: i64) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_f64<E>(self, _: f64) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_bool<E>(self, _: bool) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_str<E>(self, _: &str) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_unit<E>(self) -> Result<Self::Value, E> {
        Ok(None)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, values: A) -> Result<Self::Value, A::Error> {
        IgnoredAny.visit_seq(values).map(|IgnoredAny| None)
    }

    fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<Self::Value, A::Error> {
        IgnoredAny.visit_map(entries).map(|IgnoredAny| None)
    }
}

impl About {
    /// The configured context (`num_ctx 8192` in a list of parameters), else one that the model was trained for.
    fn context(&self) -> Option<u64> {
        let configured = self.parameters.lines().find_map(|line| {
            let (name, value) = line.trim().split_once(char::is_whitespace)?;
            (name == "num_ctx").then(|| value.trim().parse().ok())?
        });
        let mut sizes = self.model_info.iter();
        let trained = sizes.find(|(name, _)| name.ends_with(".context_length"));
        configured.or_else(|| Some(trained?.1.0?.min(OLLAMA_DEFAULT)))
    }
}

/// An answer about a text's tokens: their number or a list. List elements are counted, not kept.
#[derive(Deserialize)]
struct Tokens {
    count: Option<u64>,
    tokens: Option<Vec<IgnoredAny>>,
}

/// Endpoint for counting tokens.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tokenizer {
    /// `/tokenize`: llama.cpp and vLLM, with different fields.
    Tokenize,
    /// `/extras/tokenize/count`: llama-cpp-python.
    Extras,
}

impl Tokenizer {
    pub(super) const ALL: [Self; 2] = [Self::Tokenize, Self::Extras];

    /// Tokens of a text alone, without special tokens.
    pub(super) fn count(self, text: &str, endpoint: &Endpoint, connection: &Connection) -> Option<u64> {
        let model = &endpoint.model;
        let (path, body) = match self {
            Self::Tokenize => (
                "/tokenize",
                json!({"model": model, "content": text, "add_special": false,
                       "prompt": text, "add_special_tokens": false}),
            ),
            Self::Extras => ("/extras/tokenize/count", json!({"model": model, "input": text})),
        };
        let answer: Tokens = ask(endpoint, connection, path, Some(body))?;
        let listed = answer.tokens.map(|tokens| tokens.len() as u64);
        // A token has at least one byte, except for a few special tokens around the text.
        answer.count.or(listed).filter(|count| *count <= text.len() as u64 + 16)
    }
}

/// Requests a path and parses the JSON answer: POST with a body, GET without one.
fn ask<T: DeserializeOwned>(
    endpoint: &Endpoint,
    connection: &Connection,
    path: &str,
    body: Option<Value>,
) -> Option<T> {
    let url = endpoint.beside(path);
    let answer = connection.question(|http| {
        let mut request = match body {
            Some(body) => http.post(url).json(&body),
            None => http.get(url),
        };
        if let Some((name, value)) = endpoint.key_header() {
            request = request.header(name, value);
        }
        request
    })?;
    serde_json::from_slice(&answer).ok()
}
