//! Address, API and key of a server.

use super::redaction::Redaction;
use super::secret::Secret;
use crate::{ModelError, ModelReference};

/// Looks up an environment variable; an empty one counts as unset.
pub(super) type Lookup<'a> = &'a dyn Fn(&str) -> Option<String>;

/// Default version of Azure's API: the oldest generally available one with JSON schemas.
const AZURE_VERSION: &str = "2024-10-21";

/// Version of Anthropic's API.
const ANTHROPIC_VERSION: &str = "2023-06-01";

/// The kind of server, as far as requests differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    OpenAi,
    Azure,
    Ollama,
    /// llama.cpp, vLLM and other servers with OpenAI's API.
    Other,
    Anthropic,
    Gemini,
}

/// A model on a server.
#[derive(Debug, Clone)]
pub(super) struct Endpoint {
    pub(super) kind: Kind,
    /// The model's name there.
    pub(super) model: String,
    /// The base address without user and password, for messages.
    pub(super) server: String,
    /// The base address, without a trailing slash.
    base: String,
    /// The address of chat requests.
    chat: String,
    key: Option<Secret>,
    /// Removes the key and the address's password from texts.
    redaction: Redaction,
}

impl Endpoint {
    /// The endpoint of a reference, with keys and addresses from the environment; `None` if the reference is not a
    /// server.
    pub(super) fn of(reference: &ModelReference, variable: Lookup<'_>) -> Option<Result<Self, ModelError>> {
        Some(match reference {
            ModelReference::OpenAi { model } => Self::openai(model, variable),
            ModelReference::Azure { deployment } => Self::azure(deployment, variable),
            ModelReference::Ollama { model } => Ok(Self::ollama(model, variable)),
            ModelReference::Anthropic { model } => Self::anthropic(model, variable),
            ModelReference::Gemini { model } => Self::gemini(model, variable),
            ModelReference::Server { url, model } => Ok(Self::other(url, model, variable)),
            ModelReference::Catalogue(_)
            | ModelReference::File(_)
            | ModelReference::Replay(_)
            | ModelReference::Lent { .. } => return None,
        })
    }

    fn openai(model: &str, variable: Lookup<'_>) -> Result<Self, ModelError> {
        let base = variable("OPENAI_BASE_URL").unwrap_or_else(|| "https://api.openai.com/v1".into());
        let key = key(&["OPENAI_API_KEY"], &base, variable)?;
        Ok(Self::new(Kind::OpenAi, &base, model, Some(key)))
    }

    fn azure(deployment: &str, variable: Lookup<'_>) -> Result<Self, ModelError> {
        let base = variable("AZURE_OPENAI_ENDPOINT").ok_or(ModelError::NoAddress {
            server: "Azure OpenAI",
            variable: "AZURE_OPENAI_ENDPOINT",
        })?;
        let token = variable("AZURE_OPENAI_AD_TOKEN").map(Secret::bearer);
        let key = match variable("AZURE_OPENAI_API_KEY") {
            Some(key) => Secret::new("api-key", key),
            None => match token {
                Some(token) => token,
                None => key(&["AZURE_OPENAI_API_KEY"], &base, variable)?,
            },
        };
        let address = AzureAddress::of(&base);
        let mut endpoint = Self::new(Kind::Azure, address.resource, deployment, Some(key));
        let base = &endpoint.base;
        endpoint.chat = if address.is_v1 {
            format!("{base}/openai/v1/chat/completions")
        } else {
            let version = variable("OPENAI_API_VERSION").or(address.version);
            let version = version.unwrap_or_else(|| AZURE_VERSION.into());
            format!("{base}/openai/deployments/{deployment}/chat/completions?api-version={version}")
        };
        Ok(endpoint)
    }

    /// The base is that of OpenAI's API. Chat requests go to Ollama's own API beside it, if the server has one.
    fn ollama(model: &str, variable: Lookup<'_>) -> Self {
        let host = variable("OLLAMA_HOST").unwrap_or_else(|| "http://localhost:11434".into());
        Self::new(Kind::Ollama, &format!("{}/v1", ollama_address(&host)), model, None)
    }

    fn anthropic(model: &str, variable: Lookup<'_>) -> Result<Self, ModelError> {
        let base = variable("ANTHROPIC_BASE_URL").unwrap_or_else(|| "https://api.anthropic.com".into());
        let key = key(&["ANTHROPIC_API_KEY"], &base, variable)?;
        let base = format!("{}/v1", base.trim_end_matches('/'));
        Ok(Self::new(Kind::Anthropic, &base, model, Some(key)))
    }

    fn gemini(model: &str, variable: Lookup<'_>) -> Result<Self, ModelError> {
        let base = variable("GOOGLE_GEMINI_BASE_URL");
        let base = base.unwrap_or_else(|| "https://generativelanguage.googleapis.com".into());
        let key = key(&["GEMINI_API_KEY", "GOOGLE_API_KEY"], &base, variable)?;
        let base = format!("{}/v1beta", base.trim_end_matches('/'));
        Ok(Self::new(Kind::Gemini, &base, model, Some(key)))
    }

    /// OpenAI's key is sent to OpenAI alone.
    fn other(url: &str, model: &str, variable: Lookup<'_>) -> Self {
        let openai = is_openai(url);
        let key = variable("LONGSTEP_API_KEY").or_else(|| variable("OPENAI_API_KEY").filter(|_| openai));
        let kind = if openai { Kind::OpenAi } else { Kind::Other };
        Self::new(kind, url, model, key.map(Secret::bearer))
    }

    pub(super) fn new(kind: Kind, base: &str, model: &str, key: Option<Secret>) -> Self {
        let base = base.trim_end_matches('/').to_owned();
        let chat = match kind {
            Kind::Anthropic => format!("{base}/messages"),
            Kind::Gemini => format!("{base}/models/{model}:streamGenerateContent?alt=sse"),
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => format!("{base}/chat/completions"),
        };
        let password = password(&base);
        let secrets = key.iter().map(Secret::reveal).chain(password.as_deref());
        Self {
            redaction: Redaction::of(secrets),
            kind,
            model: model.to_owned(),
            server: without_password(&base),
            chat,
            base,
            key,
        }
    }

    /// The address of chat requests.
    pub(super) fn chat_url(&self) -> &str {
        &self.chat
    }

    /// The headers of a chat request: the key, and others that the dialect requires.
    pub(super) fn chat_headers(&self) -> Vec<(String, String)> {
        let key_in = |name: &str| {
            let key = self.key.as_ref();
            key.map(|key| (name.to_owned(), key.reveal().to_owned()))
        };
        let headers = match self.kind {
            Kind::Anthropic => [
                key_in("x-api-key"),
                Some(("anthropic-version".to_owned(), ANTHROPIC_VERSION.to_owned())),
            ],
            Kind::Gemini => [key_in("x-goog-api-key"), None],
            Kind::OpenAi | Kind::Azure | Kind::Ollama | Kind::Other => [self.key_header(), None],
        };
        headers.into_iter().flatten().collect()
    }

    /// Canonical form of the address: without user, password and query, so that equal addresses are equal texts.
    pub(super) fn normal_address(&self) -> String {
        let Ok(mut url) = reqwest::Url::parse(&self.base) else {
            return self.server.clone();
        };
        // Fails only for an address without a host, which has no user either.
        let _ = url.set_username("").and_then(|()| url.set_password(None));
        url.set_query(None);
        url.set_fragment(None);
        url.as_str().trim_end_matches('/').to_owned()
    }

    /// The header with the key.
    pub(super) fn key_header(&self) -> Option<(String, String)> {
        self.key.as_ref().map(Secret::header)
    }

    /// An address next to the base's `/v1`, such as `/tokenize`.
    pub(super) fn beside(&self, path: &str) -> String {
        format!("{}{path}", self.base.strip_suffix("/v1").unwrap_or(&self.base))
    }

    /// Removes keys from a model's reply: some servers repeat what they receive.
    pub(super) fn without_keys(&self, reply: &str) -> String {
        self.redaction.of_reply(reply)
    }

    /// Makes a text safe to print: without the key, on one line, shortened.
    pub(super) fn one_line(&self, text: &str) -> String {
        /// Limit for a server's error message, in characters.
        const MOST: usize = 300;
        let text = self.redaction.of_message(text);
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        match line.char_indices().nth(MOST) {
            Some((end, _)) => format!("{}...", line.get(..end).unwrap_or_default()),
            None => line,
        }
    }
}

/// An address of Azure OpenAI in one of the forms that Azure's portal shows: of the resource, of a deployment, or of the API
/// without versions.
struct AzureAddress<'a> {
    resource: &'a str,
    version: Option<String>,
    is_v1: bool,
}

impl<'a> AzureAddress<'a> {
    fn of(written: &'a str) -> Self {
        let (path, query) = written.split_once('?').unwrap_or((written, ""));
        let version = query.split('&').find_map(|part| part.strip_prefix("api-version="));
        let (resource, rest) = path.split_once("/openai").unwrap_or((path, ""));
        Self {
            resource,
            version: version.map(str::to_owned),
            is_v1: rest == "/v1" || rest.starts_with("/v1/"),
        }
    }
}

/// The first of these variables that is set, as a bearer key.
fn key(names: &[&'static str], base: &str, variable: Lookup<'_>) -> Result<Secret, ModelError> {
    let found = names.iter().find_map(|name| variable(name));
    found.map(Secret::bearer).ok_or_else(|| ModelError::NoKey {
        server: without_password(base),
        variable: names.first().copied().unwrap_or_default(),
    })
}

/// True for OpenAI's own host over HTTPS.
pub(super) fn is_openai(url: &str) -> bool {
    let url = reqwest::Url::parse(url).ok();
    url.is_some_and(|url| url.scheme() == "https" && url.host_str() == Some("api.openai.com"))
}

/// The address of Ollama, in any form that Ollama accepts: `0.0.0.0`, `host:port`, or a full address.
fn ollama_address(host: &str) -> String {
    let host = host.trim().trim_end_matches('/');
    let whole = if host.contains("://") {
        host.to_owned()
    } else {
        format!("http://{host}")
    };
    let Ok(mut url) = reqwest::Url::parse(&whole) else {
        return whole;
    };
    let authority = whole.split_once("://").map_or("", |(_, rest)| rest);
    let authority = authority.split_once('/').map_or(authority, |(authority, _)| authority);
    let named = authority
        .rsplit_once(':')
        .is_some_and(|(_, port)| port.parse::<u16>().is_ok());
    if !named && url.scheme() == "http" {
        // Fails only for an address without a host, which has failed already.
        let _ = url.set_port(Some(11434));
    }
    // On `0.0.0.0` Ollama listens on all addresses of its machine; clients connect to 127.0.0.1.
    if url.host_str() == Some("0.0.0.0") {
        let _ = url.set_host(Some("127.0.0.1"));
    }
    url.as_str().trim_end_matches('/').to_owned()
}

/// The decoded password of an address; without a password, its user, which is then a token.
fn password(base: &str) -> Option<String> {
    let url = reqwest::Url::parse(base).ok()?;
    let written = url
        .password()
        .or(Some(url.username()).filter(|user| !user.is_empty()))?;
    let mut bytes = Vec::new();
    let mut rest = written.as_bytes();
    while let Some((first, more)) = rest.split_first() {
        let digits = more.get(..2).and_then(|digits| std::str::from_utf8(digits).ok());
        match digits.and_then(|digits| u8::from_str_radix(digits, 16).ok()) {
            Some(byte) if *first == b'%' => {
                bytes.push(byte);
                rest = more.get(2..).unwrap_or_default();
            }
            _ => {
                bytes.push(*first);
                rest = more;
            }
        }
    }
    String::from_utf8(bytes).ok()
}

/// An address without user and password.
fn without_password(url: &str) -> String {
    match url.split_once("://") {
        Some((scheme, rest)) => {
            let end = rest.find('/').unwrap_or(rest.len());
            let (host, path) = rest.split_at(end);
            let host = host.rsplit_once('@').map_or(host, |(_, host)| host);
            format!("{scheme}://{host}{path}")
        }
        None => url.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_openais_own_host_is_openai() {
        assert!(is_openai("https://api.openai.com/v1"));
        for other in [
            "http://api.openai.com/v1",
            "https://api.openai.com.example.org/v1",
            "https://example.org/api.openai.com",
            "https://api.openai.com@example.org/v1",
            "nonsense",
        ] {
            assert!(!is_openai(other), "{other}");
        }
    }

    #[test]
    fn ollama_is_found_however_its_host_is_written() {
        for (written, address) in [
            ("localhost", "http://localhost:11434"),
            ("0.0.0.0", "http://127.0.0.1:11434"),
            ("box:8000", "http://box:8000"),
            ("http://box:8000/", "http://box:8000"),
            ("http://box", "http://box:11434"),
            ("http://box:8080/ollama", "http://box:8080/ollama"),
            ("box/ollama/", "http://box:11434/ollama"),
            ("https://ollama.example.org", "https://ollama.example.org"),
        ] {
            assert_eq!(ollama_address(written), address, "{written}");
        }
    }

    #[test]
    fn azure_is_found_in_each_form_that_its_portal_shows() {
        let old = "https://r.openai.azure.com/openai/deployments/d/chat/completions?api-version=";
        for (written, version, address) in [
            ("https://r.openai.azure.com/", None, format!("{old}{AZURE_VERSION}")),
            (
                "https://r.openai.azure.com",
                Some("2025-01-01"),
                format!("{old}2025-01-01"),
            ),
            (
                "https://r.openai.azure.com/openai/deployments/other/chat/completions?api-version=2024-08-01-preview",
                None,
                format!("{old}2024-08-01-preview"),
            ),
            (
                "https://r.openai.azure.com/openai/v1/",
                None,
                "https://r.openai.azure.com/openai/v1/chat/completions".to_owned(),
            ),
        ] {
            let variable = |name: &str| match name {
                "AZURE_OPENAI_ENDPOINT" => Some(written.to_owned()),
                "AZURE_OPENAI_API_KEY" => Some("key".to_owned()),
                "OPENAI_API_VERSION" => version.map(str::to_owned),
                _ => None,
            };
            let reference: ModelReference = "azure:d".parse().unwrap();
            let endpoint = Endpoint::of(&reference, &variable).unwrap().unwrap();
            assert_eq!(endpoint.chat_url(), address, "{written}");
        }
    }

    #[test]
    fn a_key_goes_to_its_own_host_alone() {
        let all = |name: &str| name.ends_with("_KEY").then(|| format!("secret of {name}"));
        let header = |text: &str| {
            let reference: ModelReference = text.parse().unwrap();
            let endpoint = Endpoint::of(&reference, &all).unwrap().unwrap();
            endpoint.key_header().map(|(_, value)| value)
        };
        assert_eq!(header("openai:m").unwrap(), "Bearer secret of OPENAI_API_KEY");
        assert_eq!(
            header("https://elsewhere.org/v1#m").unwrap(),
            "Bearer secret of LONGSTEP_API_KEY"
        );
        assert_eq!(header("ollama:m"), None);
        assert_eq!(header("anthropic:m").unwrap(), "Bearer secret of ANTHROPIC_API_KEY");
        assert_eq!(header("gemini:m").unwrap(), "Bearer secret of GEMINI_API_KEY");
        let openai_only = |name: &str| (name == "OPENAI_API_KEY").then(|| "key".to_owned());
        let elsewhere: ModelReference = "https://elsewhere.org/v1#m".parse().unwrap();
        let endpoint = Endpoint::of(&elsewhere, &openai_only).unwrap().unwrap();
        assert_eq!(endpoint.key_header(), None);
    }

    #[test]
    fn endpoint_error_names_the_missing_environment_variable() {
        for (reference, variable) in [
            ("openai:m", "OPENAI_API_KEY"),
            ("azure:d", "AZURE_OPENAI_ENDPOINT"),
            ("anthropic:m", "ANTHROPIC_API_KEY"),
            ("gemini:m", "GEMINI_API_KEY"),
        ] {
            let parsed: ModelReference = reference.parse().unwrap();
            let error = Endpoint::of(&parsed, &|_| None).unwrap().unwrap_err();
            assert!(error.hint().unwrap().contains(variable), "{error}");
        }
        let azure = |name: &str| (name == "AZURE_OPENAI_ENDPOINT").then(|| "https://a.example.org".to_owned());
        let parsed: ModelReference = "azure:d".parse().unwrap();
        let error = Endpoint::of(&parsed, &azure).unwrap().unwrap_err();
        assert!(error.hint().unwrap().contains("AZURE_OPENAI_API_KEY"), "{error}");
    }
}
