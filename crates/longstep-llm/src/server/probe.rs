//! Questions beside the chat: how large the context is, how many tokens a text has. No answer is an answer too; nothing
//! here fails, and nothing takes long.

use std::time::Duration;

use serde_json::{Value, json};

use super::connection::Connection;
use super::endpoint::{Endpoint, Kind};

/// How long a server may take for such an answer.
const PATIENCE: Duration = Duration::from_secs(2);

/// How many tokens prompt and answer may have together, where the server says it.
pub(super) fn context(endpoint: &Endpoint, connection: &Connection) -> Option<u64> {
    let get = |path: &str| ask(endpoint, connection, path, None);
    match endpoint.kind {
        Kind::Other => {
            let llama = || get("/props")?.pointer("/default_generation_settings/n_ctx")?.as_u64();
            let vllm = || {
                let models = get("/v1/models")?;
                let models = models["data"].as_array()?;
                let ours = models.iter().find(|model| model["id"] == endpoint.model.as_str())?;
                ours["max_model_len"].as_u64()
            };
            llama().or_else(vllm)
        }
        Kind::Ollama => {
            let about = ask(
                endpoint,
                connection,
                "/api/show",
                Some(json!({"model": endpoint.model})),
            )?;
            // What it was told to use, before what the model could: `num_ctx 8192` in a list of parameters.
            let parameters = about["parameters"].as_str().unwrap_or_default();
            let told = parameters.lines().find_map(|line| {
                let (name, value) = line.trim().split_once(char::is_whitespace)?;
                (name == "num_ctx").then(|| value.trim().parse().ok())?
            });
            let sizes = about["model_info"].as_object()?;
            let trained = sizes.iter().find(|(name, _)| name.ends_with(".context_length"));
            told.or_else(|| trained?.1.as_u64())
        }
        Kind::OpenAi | Kind::Azure | Kind::Anthropic | Kind::Gemini => None,
    }
}

/// Which of a server's ways to count tokens answers.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Tokenizer {
    /// `/tokenize`: llama.cpp and vLLM, each with words of its own.
    Tokenize,
    /// `/extras/tokenize/count`: llama-cpp-python.
    Extras,
}

impl Tokenizer {
    pub(super) const ALL: [Self; 2] = [Self::Tokenize, Self::Extras];

    /// Tokens of a text, without any around it.
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
        let answer = ask(endpoint, connection, path, Some(body))?;
        let counted = answer["count"].as_u64();
        counted.or_else(|| answer["tokens"].as_array().map(|tokens| tokens.len() as u64))
    }
}

/// A question and the JSON that is answered: sent with `body` or, without one, just asked for.
fn ask(endpoint: &Endpoint, connection: &Connection, path: &str, body: Option<Value>) -> Option<Value> {
    let url = endpoint.beside(path);
    let mut request = match body {
        Some(body) => connection.http.post(url).json(&body),
        None => connection.http.get(url),
    };
    if let Some((name, value)) = endpoint.key_header() {
        request = request.header(name, value);
    }
    let work = async {
        let answer = request.timeout(PATIENCE).send().await.ok()?;
        let answer = answer.error_for_status().ok()?;
        answer.json().await.ok()
    };
    Connection::wait(work).ok().flatten()
}
