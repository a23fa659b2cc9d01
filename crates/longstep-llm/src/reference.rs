//! Which model is meant.

use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use crate::{ModelError, catalogue};

/// Which model is meant, as a person writes it.
///
/// | written | means |
/// |---|---|
/// | `qwen2.5-coder-1.5b` | a model of the [`catalogue`] |
/// | `models/mine.gguf` | a file |
/// | `openai:NAME` | a model of OpenAI, or of `OPENAI_BASE_URL` |
/// | `http://localhost:8080/v1#NAME` | a model of another server with OpenAI's dialect |
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
    /// A model of another server with OpenAI's dialect.
    Server {
        /// The base address, to which `/chat/completions` is added.
        url: String,
        /// The model's name there.
        model: String,
    },
}

impl FromStr for ModelReference {
    type Err = ModelError;

    fn from_str(text: &str) -> Result<Self, ModelError> {
        let text = text.trim();
        if let Some(entry) = catalogue::find(text) {
            return Ok(Self::Catalogue(entry));
        }
        if let Some(model) = text.strip_prefix("openai:").filter(|model| !model.is_empty()) {
            return Ok(Self::OpenAi { model: model.into() });
        }
        if text.starts_with("http://") || text.starts_with("https://") {
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
            Self::Server { url, model } => write!(formatter, "{url}#{model}"),
        }
    }
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
    fn what_names_no_model_is_told_with_what_would() {
        for text in [
            "",
            "openai:",
            "http://host/v1",
            "https://host/v1#",
            "model.bin",
            "azure:x",
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
    fn a_misspelt_name_brings_the_right_one() {
        let error = "qwen2.5-coder-1.5".parse::<ModelReference>().unwrap_err();
        assert_eq!(error.hint().as_deref(), Some("did you mean `qwen2.5-coder-1.5b`?"));
        let error = "smolm2".parse::<ModelReference>().unwrap_err();
        assert_eq!(error.hint().as_deref(), Some("did you mean `smollm2-135m`?"));
        assert_eq!("gpt-5".parse::<ModelReference>().unwrap_err().hint(), None);
    }
}
