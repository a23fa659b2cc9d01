//! References to models.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::{ModelError, catalogue};

/// A reference to a model, as the user writes it.
///
/// | written | means |
/// |---|---|
/// | `qwen2.5-coder-1.5b` | a model of the [`catalogue`] |
/// | `models/mine.gguf` | a file |
/// | `openai:NAME` | a model of OpenAI, or of the server at `OPENAI_BASE_URL`, with `OPENAI_API_KEY` |
/// | `azure:DEPLOYMENT` | a deployment of Azure OpenAI at `AZURE_OPENAI_ENDPOINT`, with `AZURE_OPENAI_API_KEY` or `AZURE_OPENAI_AD_TOKEN`, and `OPENAI_API_VERSION` (2024-10-21) |
/// | `ollama:NAME` | a model of Ollama at `OLLAMA_HOST` (`http://localhost:11434`) |
/// | `anthropic:NAME` | a model of Anthropic, with `ANTHROPIC_API_KEY` |
/// | `gemini:NAME` | a model of Gemini, with `GEMINI_API_KEY` or `GOOGLE_API_KEY` |
/// | `http://localhost:8080/v1#NAME` | a model of another server with OpenAI's API, such as llama.cpp's or vLLM; a key from `LONGSTEP_API_KEY` |
/// | `longstep:http://127.0.0.1:8765` | the model of a running `longstep serve`, with `LONGSTEP_TOKEN` or, on this machine, the token of its file |
/// | `replay:FILE` | a recording, see [`OpenOptions::record`](crate::OpenOptions::record) |
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum ModelReference {
    /// A model of the catalogue.
    Catalogue(&'static catalogue::Entry),
    /// A GGUF file.
    File(PathBuf),
    /// A model of OpenAI.
    OpenAi {
        /// The model's name there.
        model: String,
    },
    /// A deployment of Azure OpenAI.
    Azure {
        /// The deployment's name, which may differ from the model's.
        deployment: String,
    },
    /// A model of Ollama.
    Ollama {
        /// The model's name there, such as `qwen2.5-coder:1.5b`.
        model: String,
    },
    /// A model of Anthropic.
    Anthropic {
        /// The model's name there.
        model: String,
    },
    /// A model of Gemini.
    Gemini {
        /// The model's name there.
        model: String,
    },
    /// A recording, which answers the requests in it.
    Replay(PathBuf),
    /// The model of a running Longstep server.
    Lent {
        /// The address of the server.
        url: String,
    },
    /// A model of another server with OpenAI's API.
    Server {
        /// The base address; requests go to `/chat/completions` below it.
        url: String,
        /// The model's name there.
        model: String,
    },
}

impl ModelReference {
    /// Returns true for a model that runs in this process.
    #[must_use]
    pub fn is_embedded(&self) -> bool {
        matches!(self, Self::Catalogue(_) | Self::File(_))
    }
}

impl FromStr for ModelReference {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let text = text.trim();
        if let Some(entry) = catalogue::find(text) {
            return Ok(Self::Catalogue(entry));
        }
        if let Some((kind, name)) = text.split_once(':').filter(|(_, name)| !name.is_empty()) {
            let model = name.to_owned();
            match kind {
                "openai" => return Ok(Self::OpenAi { model }),
                "azure" => return Ok(Self::Azure { deployment: model }),
                "ollama" => return Ok(Self::Ollama { model }),
                "anthropic" => return Ok(Self::Anthropic { model }),
                "gemini" => return Ok(Self::Gemini { model }),
                "longstep" if is_web_address(name) => {
                    let url = name.trim_end_matches('/').to_owned();
                    return Ok(Self::Lent { url });
                }
                "replay" => return Ok(Self::Replay(name.into())),
                _ => {}
            }
        }
        if is_web_address(text) {
            return match text.split_once('#') {
                Some((url, model)) if !model.is_empty() => Ok(Self::Server {
                    url: url.trim_end_matches('/').into(),
                    model: model.into(),
                }),
                _ => Err(unknown(text)),
            };
        }
        let extension = Path::new(text).extension();
        if extension.is_some_and(|extension| extension.eq_ignore_ascii_case("gguf")) {
            return Ok(Self::File(text.into()));
        }
        Err(unknown(text))
    }
}

impl fmt::Display for ModelReference {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Catalogue(entry) => formatter.write_str(entry.name),
            Self::File(path) => write!(formatter, "{}", path.display()),
            Self::OpenAi { model } => write!(formatter, "openai:{model}"),
            Self::Azure { deployment } => write!(formatter, "azure:{deployment}"),
            Self::Ollama { model } => write!(formatter, "ollama:{model}"),
            Self::Anthropic { model } => write!(formatter, "anthropic:{model}"),
            Self::Gemini { model } => write!(formatter, "gemini:{model}"),
            Self::Replay(path) => write!(formatter, "replay:{}", path.display()),
            Self::Lent { url } => write!(formatter, "longstep:{url}"),
            Self::Server { url, model } => write!(formatter, "{url}#{model}"),
        }
    }
}

fn is_web_address(text: &str) -> bool {
    text.starts_with("http://") || text.starts_with("https://")
}

fn unknown(text: &str) -> ModelError {
    let names: Vec<&str> = catalogue::ENTRIES.iter().map(|entry| entry.name).collect();
    let close = names
        .iter()
        .map(|name| (strsim::jaro_winkler(text, name), *name))
        .filter(|(likeness, _)| *likeness > 0.8)
        .max_by(|left, right| left.0.total_cmp(&right.0))
        .map(|(_, name)| name);
    ModelError::UnknownReference {
        text: text.into(),
        catalogue: names.join(", "),
        close,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_form_is_read_and_written_back() {
        let server = |url: &str, model: &str| ModelReference::Server {
            url: url.into(),
            model: model.into(),
        };
        let table = [
            ("smollm2-135m", ModelReference::Catalogue(&catalogue::ENTRIES[2])),
            ("models/mine.gguf", ModelReference::File("models/mine.gguf".into())),
            (
                "C:\\models\\MINE.GGUF",
                ModelReference::File("C:\\models\\MINE.GGUF".into()),
            ),
            ("openai:gpt-5", ModelReference::OpenAi { model: "gpt-5".into() }),
            (
                "azure:house-gpt",
                ModelReference::Azure {
                    deployment: "house-gpt".into(),
                },
            ),
            (
                "ollama:qwen2.5-coder:1.5b",
                ModelReference::Ollama {
                    model: "qwen2.5-coder:1.5b".into(),
                },
            ),
            (
                "longstep:http://127.0.0.1:8765",
                ModelReference::Lent {
                    url: "http://127.0.0.1:8765".into(),
                },
            ),
            ("anthropic:m", ModelReference::Anthropic { model: "m".into() }),
            ("gemini:m", ModelReference::Gemini { model: "m".into() }),
            (
                "replay:talks/one.jsonl",
                ModelReference::Replay("talks/one.jsonl".into()),
            ),
            (
                "http://localhost:8080/v1#tiny",
                server("http://localhost:8080/v1", "tiny"),
            ),
            ("https://host/v1#a/b#c", server("https://host/v1", "a/b#c")),
        ];
        for (text, expected) in table {
            let read: ModelReference = text.parse().unwrap();
            assert_eq!(read, expected, "{text}");
            assert_eq!(read.to_string(), text);
        }
        let slash: ModelReference = "http://host/v1/#m".parse().unwrap();
        assert_eq!(slash, server("http://host/v1", "m"));
    }

    #[test]
    fn model_reference_error_lists_the_accepted_forms() {
        for text in [
            "",
            "openai:",
            "http://host/v1",
            "https://host/v1#",
            "model.bin",
            "azure:",
            "replay:",
            "other:x",
        ] {
            let error = text.parse::<ModelReference>().unwrap_err();
            let line = error.to_string();
            assert!(
                line.contains("qwen2.5-coder-0.5b") && line.contains("openai:NAME"),
                "{line}"
            );
            assert!(!line.contains('\n'));
        }
    }

    #[test]
    fn model_reference_error_suggests_the_nearest_name() {
        let error = "qwen2.5-coder-1.5".parse::<ModelReference>().unwrap_err();
        assert_eq!(error.hint().as_deref(), Some("did you mean `qwen2.5-coder-1.5b`?"));
        let error = "smolm2".parse::<ModelReference>().unwrap_err();
        assert_eq!(error.hint().as_deref(), Some("did you mean `smollm2-135m`?"));
        assert_eq!("gpt-5".parse::<ModelReference>().unwrap_err().hint(), None);
    }
}
