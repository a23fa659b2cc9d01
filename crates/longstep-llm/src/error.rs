//! What can go wrong with a model.

use std::path::{Path, PathBuf};

/// What went wrong with a model, and where. `Display` is one line; [`ModelError::hint`] says
/// what to do about it.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// A text that names no model.
    #[error(
        "`{text}` is not a model: expected a name of the catalogue ({catalogue}), a path ending in .gguf, \
         openai:NAME, azure:DEPLOYMENT, ollama:NAME, anthropic:NAME, gemini:NAME, URL#NAME or replay:FILE"
    )]
    UnknownReference {
        /// What was given.
        text: String,
        /// The names of the catalogue, joined with commas.
        catalogue: String,
        /// The name of the catalogue that is spelt most alike, if one is.
        close: Option<&'static str>,
    },
    /// A model of the catalogue whose file is not in the cache.
    #[error("the model {name} is not in the cache ({})", cache.display())]
    NotPulled {
        /// Its name in the catalogue.
        name: &'static str,
        /// The cache that was looked into.
        cache: PathBuf,
    },
    /// A model file that is not the one of the catalogue.
    #[error("{place} is not the model {name}: expected SHA-256 {expected}, got {got}")]
    WrongHash {
        /// Its name in the catalogue.
        name: &'static str,
        /// The file or source that was checked.
        place: String,
        /// The hash in the catalogue.
        expected: &'static str,
        /// The hash of the file.
        got: String,
    },
    /// No folder for the cache is known.
    #[error("no cache folder: neither LONGSTEP_CACHE nor a home folder is set")]
    NoCacheDirectory,
    /// A file or folder that could not be read or written.
    #[error("{action} {}: {source}", path.display())]
    File {
        /// What was tried, such as `cannot write`.
        action: &'static str,
        /// On what.
        path: PathBuf,
        /// Why it failed.
        source: std::io::Error,
    },
    /// No source had the model.
    #[error("the model {name} could not be fetched: {}", reasons.join("; "))]
    NotFetched {
        /// Its name in the catalogue.
        name: &'static str,
        /// For each source, why it failed.
        reasons: Vec<String>,
    },
    /// A file that the engine cannot load.
    #[error("{} cannot be loaded: {reason}", path.display())]
    NotLoaded {
        /// The file.
        path: PathBuf,
        /// Why.
        reason: String,
    },
    /// An embedded model, and this build has no engine for it (the feature `embedded` is off).
    #[error("{model} cannot be opened: this build has no embedded engine")]
    NoEngine {
        /// The model, as it was named.
        model: String,
    },
    /// A request that the model cannot serve as it stands.
    #[error("{model} cannot serve this request: {reason}")]
    Unsupported {
        /// The model.
        model: String,
        /// Why.
        reason: String,
    },
    /// A grammar or schema that the engine cannot use.
    #[error("the grammar of the request cannot be used: {0}")]
    Grammar(String),
    /// A prompt that leaves no room for the answer.
    #[error("the request needs {tokens} tokens (prompt and answer), the model has room for {limit}")]
    TooLong {
        /// Tokens of the prompt plus the most tokens of the answer.
        tokens: usize,
        /// The size of the context in tokens.
        limit: usize,
    },
    /// Whoever waited for the answer called it off.
    #[error("stopped")]
    Stopped,
    /// The engine failed while it computed.
    #[error("the engine of {model} failed: {reason}")]
    Engine {
        /// The model.
        model: String,
        /// Why.
        reason: String,
    },
    /// A server that needs a key, and none is set.
    #[error("{server} needs a key, and {variable} is not set")]
    NoKey {
        /// The server.
        server: String,
        /// The environment variable.
        variable: &'static str,
    },
    /// A kind of server whose address is yours to say.
    #[error("the address of {server} is not set ({variable})")]
    NoAddress {
        /// The kind of server.
        server: &'static str,
        /// The environment variable.
        variable: &'static str,
    },
    /// A server that said nothing for too long.
    #[error("{server} said nothing for {seconds} s")]
    Silent {
        /// The server.
        server: String,
        /// How long it may.
        seconds: f64,
    },
    /// A call to a server that took longer than it may.
    #[error("{server} gave no whole answer within {seconds} s")]
    TimedOut {
        /// The server.
        server: String,
        /// The time for the call, with all its tries.
        seconds: f64,
    },
    /// An answer of a server that passed a limit on its size.
    #[error("the answer of {server} is too large: {limit}")]
    TooLarge {
        /// The server.
        server: String,
        /// The limit.
        limit: AnswerLimit,
    },
    /// A request that is not in the recording that is replayed.
    #[error("{} has no answer to this request: {difference}", path.display())]
    NotRecorded {
        /// The recording.
        path: PathBuf,
        /// What is different from the nearest recorded request.
        difference: String,
    },
    /// A recording that cannot be read.
    #[error("{} is no recording: line {line}: {reason}", path.display())]
    BadRecording {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// Why.
        reason: String,
    },
    /// A server that could not be reached or did not answer in time.
    #[error("{server} cannot be reached: {reason}")]
    Unreachable {
        /// The server.
        server: String,
        /// Why.
        reason: String,
    },
    /// A server that answered with an error.
    #[error("{server} answered with status {status}: {message}")]
    Status {
        /// The server.
        server: String,
        /// The HTTP status.
        status: u16,
        /// What the server said, on one line, shortened, without keys.
        message: String,
    },
    /// An answer of a server that cannot be read.
    #[error("the answer of {server} cannot be read: {reason}")]
    BadAnswer {
        /// The server.
        server: String,
        /// Why.
        reason: String,
    },
}

/// A limit on the size of a server's answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AnswerLimit {
    /// Bytes of the whole answer.
    #[error("it has more than {0} bytes")]
    Bytes(u64),
    /// Bytes of one line.
    #[error("a line of it has more than {0} bytes")]
    LineBytes(u64),
    /// Bytes of one event.
    #[error("an event of it has more than {0} bytes")]
    EventBytes(u64),
    /// Lines of the whole answer.
    #[error("it has more than {0} lines")]
    Lines(u64),
    /// Headers: about 400 kB, or 100 of them.
    #[error("its headers have no end")]
    Headers,
}

impl ModelError {
    /// What to do about it, where something can be said.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::UnknownReference { close: Some(close), .. } => Some(format!("did you mean `{close}`?")),
            Self::NotPulled { name, .. } | Self::WrongHash { name, .. } => {
                Some(format!("run `longstep model pull {name}`"))
            }
            Self::NoCacheDirectory => Some("set LONGSTEP_CACHE to a folder".into()),
            Self::File { source, .. } => file_hint(source.kind()),
            Self::NotFetched { name, .. } => Some(format!(
                "run it again to go on where it stopped, or take a file from elsewhere with \
                 `longstep model pull {name} --from FILE`"
            )),
            Self::NotLoaded { .. } => {
                Some("use a model of the catalogue (`longstep model list`), or fetch the file again".into())
            }
            Self::NoEngine { .. } => {
                Some("build with the feature `embedded`, or use a model on a server or replay:FILE".into())
            }
            Self::TooLong { .. } => Some("shorten the environment, or open the model with a larger context".into()),
            Self::NoKey { variable, .. } => Some(format!("set {variable}")),
            Self::NoAddress { variable, .. } => {
                Some(format!("set {variable}, for example https://NAME.openai.azure.com"))
            }
            Self::Silent { .. } => Some(
                "the server may be busy or the model large: try again, or wait longer with --silence SECONDS".into(),
            ),
            Self::TimedOut { .. } => Some(
                "the server may be busy or the model large: try again, or allow more time with --timeout SECONDS"
                    .into(),
            ),
            Self::TooLarge { .. } => Some(
                "no model writes this much: check that the address is that of a server with OpenAI's chat completions"
                    .into(),
            ),
            Self::NotRecorded { .. } => {
                Some("record it again with the model, or ask exactly what was asked then".into())
            }
            Self::BadRecording { .. } => Some("a recording is made by opening a model with a file to record to".into()),
            Self::Unreachable { .. } => {
                Some("check the address and that the server is running, or use an embedded model".into())
            }
            Self::Status { status, .. } => status_hint(*status),
            Self::BadAnswer { .. } => {
                Some("check that the address is that of a server with OpenAI's chat completions, and try again".into())
            }
            Self::UnknownReference { .. }
            | Self::Unsupported { .. }
            | Self::Grammar(_)
            | Self::Stopped
            | Self::Engine { .. } => None,
        }
    }

    /// For `map_err` on file operations: `action` on `path` failed.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { action, path, source }
    }
}

fn file_hint(kind: std::io::ErrorKind) -> Option<String> {
    use std::io::ErrorKind;
    let hint = match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "free some space, or set LONGSTEP_CACHE to a folder on another disk"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "check the permissions, or set LONGSTEP_CACHE to a folder of yours"
        }
        ErrorKind::NotFound => "check the path",
        _ => return None,
    };
    Some(hint.into())
}

fn status_hint(status: u16) -> Option<String> {
    let hint = match status {
        401 => {
            "check the key (OPENAI_API_KEY, AZURE_OPENAI_API_KEY, ANTHROPIC_API_KEY, GEMINI_API_KEY, or LONGSTEP_API_KEY \
             for another server)"
        }
        403 => "the key may not use this model; ask the server's owner",
        404 => "check the name of the model and the base address (it usually ends in /v1)",
        429 => "too many requests or no credit left: wait a little, or check the account",
        500.. => "the server is in trouble: try again later",
        _ => return None,
    };
    Some(hint.into())
}
