//! Errors of models.

use longstep_files::NoHomeFolder;
use std::path::{Path, PathBuf};

/// An error of a model: what failed, and where. `Display` is one line; [`ModelError::hint`] is the next step for the
/// user.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ModelError {
    /// The text does not name a model.
    #[error(
        "`{text}` is not a model: expected a name of the catalogue ({catalogue}), a path ending in .gguf, \
         openai:NAME, azure:DEPLOYMENT, ollama:NAME, anthropic:NAME, gemini:NAME, URL#NAME, \
         longstep:URL or replay:FILE"
    )]
    UnknownReference {
        /// The given text.
        text: String,
        /// The names of the catalogue, joined with commas.
        catalogue: String,
        /// The name in the catalogue with the most similar spelling, if there is one.
        close: Option<&'static str>,
    },
    /// The file of a model of the catalogue is not in the cache.
    #[error("the model `{name}` is not in the cache ({})", cache.display())]
    NotPulled {
        /// Its name in the catalogue.
        name: &'static str,
        /// The folder of the cache.
        cache: PathBuf,
    },
    /// The hash of a model file differs from the one in the catalogue.
    #[error("{place} is not the model `{name}`: expected SHA-256 {expected}, got {got}")]
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
    /// No cache folder is configured, and there is no home folder.
    #[error(transparent)]
    NoHomeFolder(#[from] NoHomeFolder),
    /// A file or folder cannot be read or written.
    #[error("{action} {}: {source}", path.display())]
    File {
        /// The action that failed, such as `cannot write`.
        action: &'static str,
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: std::io::Error,
    },
    /// No source had the model.
    #[error("the model `{name}` could not be downloaded: {}", reasons.join("; "))]
    NotFetched {
        /// Its name in the catalogue.
        name: &'static str,
        /// The reason of the failure for each source.
        reasons: Vec<String>,
    },
    /// The engine cannot load the file.
    #[error("{} cannot be loaded: {reason}", path.display())]
    NotLoaded {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// An embedded model, but this build has no engine for it (the feature `embedded` is off).
    #[error("{model} cannot be opened: this build has no embedded engine")]
    NoEngine {
        /// The model, as the user wrote it.
        model: String,
    },
    /// An embedded model with pictures or a projector, but this build has no embedded vision (the feature `vision` is off).
    #[error("{place} cannot be used for pictures: this build has no embedded vision")]
    NoVisionEngine {
        /// The model, or the file of the projector.
        place: String,
    },
    /// Pictures for an embedded model that was opened without its projector.
    #[error("{model} does not see pictures without its projector")]
    NoProjector {
        /// The model.
        model: String,
    },
    /// The file is no projector, or none of this model.
    #[error("{} is no projector for the model: {reason}", path.display())]
    BadProjector {
        /// The file.
        path: PathBuf,
        /// The reason.
        reason: String,
    },
    /// A picture cannot be read.
    #[error("picture {number} of {total} cannot be read: {reason}")]
    BadPicture {
        /// The number of the picture in the request, from 1.
        number: usize,
        /// The number of pictures in the request.
        total: usize,
        /// The reason.
        reason: String,
    },
    /// The model cannot serve a request of this form.
    #[error("{model} cannot serve this request: {reason}")]
    Unsupported {
        /// The model.
        model: String,
        /// The reason.
        reason: String,
    },
    /// The engine cannot use the grammar or schema.
    #[error("the engine cannot use the grammar of the request: {0}")]
    Grammar(String),
    /// The prompt leaves no room for the answer.
    #[error("the request needs {tokens} tokens (prompt and answer); the model's context has {limit}")]
    TooLong {
        /// Tokens of the prompt, plus the limit for the answer.
        tokens: usize,
        /// The size of the context in tokens.
        limit: usize,
    },
    /// The caller cancelled the request.
    #[error("stopped")]
    Stopped,
    /// The engine failed during the computation.
    #[error("the engine of {model} failed: {reason}")]
    Engine {
        /// The model.
        model: String,
        /// The reason.
        reason: String,
    },
    /// The server needs a key, and none is set.
    #[error("{server} needs a key, but `{variable}` is not set")]
    NoKey {
        /// The server.
        server: String,
        /// The environment variable.
        variable: &'static str,
    },
    /// The server has no default address, and none is set.
    #[error("the address of {server} is not set (`{variable}`)")]
    NoAddress {
        /// The kind of server.
        server: &'static str,
        /// The environment variable.
        variable: &'static str,
    },
    /// The server sent nothing for too long.
    #[error("{server} sent nothing for {seconds} s")]
    Silent {
        /// The server.
        server: String,
        /// The limit in seconds.
        seconds: f64,
    },
    /// The call took longer than its limit.
    #[error("{server} did not complete its answer within {seconds} s")]
    TimedOut {
        /// The server.
        server: String,
        /// The limit for the call in seconds, including all retries.
        seconds: f64,
    },
    /// The answer exceeds a limit on its size.
    #[error("the answer of {server} is too large: {limit}")]
    TooLarge {
        /// The server.
        server: String,
        /// The limit.
        limit: AnswerLimit,
    },
    /// The replayed recording does not contain the request.
    #[error("{} has no answer to this request: {difference}", path.display())]
    NotRecorded {
        /// The recording.
        path: PathBuf,
        /// The difference from the nearest recorded request.
        difference: String,
    },
    /// The recording cannot be read.
    #[error("{} is not a recording: line {line}: {reason}", path.display())]
    BadRecording {
        /// The file.
        path: PathBuf,
        /// The line, from 1.
        line: usize,
        /// The reason.
        reason: String,
    },
    /// The server cannot be reached.
    #[error("{server} cannot be reached: {reason}")]
    Unreachable {
        /// The server.
        server: String,
        /// The reason.
        reason: String,
    },
    /// The server answered with an error status.
    #[error("{server} answered with status {status}: {message}")]
    Status {
        /// The server.
        server: String,
        /// The HTTP status.
        status: u16,
        /// The server's error message: one line, shortened, without keys.
        message: String,
    },
    /// The model reasoned and gave no answer.
    #[error("the model on {server} gave no answer: {reason}")]
    ReasonedOnly {
        /// The server.
        server: String,
        /// The reason.
        reason: String,
    },
    /// The server's answer cannot be read.
    #[error("the answer of {server} cannot be read: {reason}")]
    BadAnswer {
        /// The server.
        server: String,
        /// The reason.
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
    #[error("one of its lines has more than {0} bytes")]
    LineBytes(u64),
    /// Bytes of one event.
    #[error("one of its events has more than {0} bytes")]
    EventBytes(u64),
    /// Lines of the whole answer.
    #[error("it has more than {0} lines")]
    Lines(u64),
    /// Headers: about 400 kB, or 100 of them.
    #[error("its headers are too large")]
    Headers,
}

impl ModelError {
    /// The next step for the user, if there is one.
    #[must_use]
    pub fn hint(&self) -> Option<String> {
        match self {
            Self::UnknownReference { close: Some(close), .. } => Some(format!("did you mean `{close}`?")),
            Self::NotPulled { name, .. } | Self::WrongHash { name, .. } => {
                Some(format!("run `longstep model pull {name}`"))
            }
            Self::NoHomeFolder(error) => Some(error.hint().into()),
            Self::File { source, .. } => file_hint(source.kind()),
            Self::NotFetched { name, .. } => Some(format!(
                "run the command again to resume the download, or use a local file with \
                 `longstep model pull {name} --from FILE`"
            )),
            Self::NotLoaded { .. } => {
                Some("use a model of the catalogue (`longstep model list`), or download the file again".into())
            }
            Self::NoEngine { .. } => {
                Some("build with the feature `embedded`, or use a model on a server or `replay:FILE`".into())
            }
            Self::NoVisionEngine { .. } => Some(
                "build with the feature `vision` (`cargo build -p longstep-cli --features vision`), or use a model that \
                 sees on a server"
                    .into(),
            ),
            Self::NoProjector { .. } => Some(
                "name its projector (mmproj) file with `--vision FILE`, or use a model that sees on a server; see \
                 docs/guide/seeing.md"
                    .into(),
            ),
            Self::BadProjector { .. } => {
                Some("use the projector (mmproj) file that was published with the model; see docs/guide/seeing.md".into())
            }
            Self::BadPicture { .. } => Some("save it again as PNG or JPEG, and not larger than a screen".into()),
            Self::TooLong { .. } => Some(
                "shorten the environment, give fewer or smaller pictures, or open the model with a larger context".into(),
            ),
            Self::NoKey { variable, .. } => Some(format!("set `{variable}`")),
            Self::NoAddress { variable, .. } => Some(format!(
                "set `{variable}`, for example to `https://NAME.openai.azure.com`"
            )),
            Self::Silent { .. } => Some(
                "the server may be busy, or the model large: try again, or wait longer with `--silence SECONDS`".into(),
            ),
            Self::TimedOut { .. } => Some(
                "the server may be busy, or the model large: try again, or allow more time with `--timeout SECONDS`"
                    .into(),
            ),
            Self::TooLarge { .. } => {
                Some("models do not write this much: check that the server has OpenAI's chat completions API".into())
            }
            Self::NotRecorded { .. } => {
                Some("record the request with the model, or repeat a recorded request exactly".into())
            }
            Self::BadRecording { .. } => Some("make a recording with `--record FILE`".into()),
            Self::Unreachable { .. } => {
                Some("check the address and that the server is running, or use an embedded model".into())
            }
            Self::Status { status, .. } => status_hint(*status),
            Self::ReasonedOnly { .. } => Some(
                "limit its reasoning with `--reasoning low` (or `off`), or allow it more tokens with `--reasoning 8000`"
                    .into(),
            ),
            Self::BadAnswer { .. } => {
                Some("check that the server has OpenAI's chat completions API, and try again".into())
            }
            Self::UnknownReference { .. }
            | Self::Unsupported { .. }
            | Self::Grammar(_)
            | Self::Stopped
            | Self::Engine { .. } => None,
        }
    }

    /// An error for pictures that an embedded model cannot see.
    #[must_use]
    pub fn no_vision(model: &str) -> Self {
        if cfg!(feature = "vision") {
            Self::NoProjector {
                model: model.to_owned(),
            }
        } else {
            Self::NoVisionEngine {
                place: model.to_owned(),
            }
        }
    }

    /// An error constructor for `map_err` on file operations: `action` on `path` failed.
    pub(crate) fn file(action: &'static str, path: &Path) -> impl FnOnce(std::io::Error) -> Self {
        let path = path.to_path_buf();
        move |source| Self::File { action, path, source }
    }
}

fn file_hint(kind: std::io::ErrorKind) -> Option<String> {
    use std::io::ErrorKind;
    let hint = match kind {
        ErrorKind::StorageFull | ErrorKind::QuotaExceeded => {
            "free some space, or set `LONGSTEP_CACHE` to a folder on another disk"
        }
        ErrorKind::PermissionDenied | ErrorKind::ReadOnlyFilesystem => {
            "check the permissions, or set `LONGSTEP_CACHE` to a writable folder"
        }
        ErrorKind::NotFound => "check the path",
        _ => return None,
    };
    Some(hint.into())
}

fn status_hint(status: u16) -> Option<String> {
    let hint = match status {
        401 => {
            "check the key (OPENAI_API_KEY, AZURE_OPENAI_API_KEY, ANTHROPIC_API_KEY, GEMINI_API_KEY, LONGSTEP_API_KEY for \
             another server, or LONGSTEP_TOKEN for a server of Longstep)"
        }
        403 => "the key may not use this model; ask the server's owner",
        404 => "check the name of the model and the base address (it usually ends in /v1)",
        429 => "too many requests, or no credit left: wait a little, or check the account",
        500.. => "the server failed: try again later",
        _ => return None,
    };
    Some(hint.into())
}
