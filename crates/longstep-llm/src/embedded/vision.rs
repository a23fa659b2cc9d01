//! Pictures for a model: llama.cpp's library for them, and the model's projector.

use std::ffi::CString;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};

use llama_cpp_2::model::LlamaModel;
use llama_cpp_2::mtmd::{
    MtmdBitmap, MtmdContext, MtmdContextParams, MtmdInputChunkType, MtmdInputChunks, MtmdInputText,
};
use longstep::dialogue::Picture;
use tracing::field::{Field, Visit};
use tracing::{Event, Level, Metadata, Subscriber, span};

use super::engine::{Engine, SEQUENCE};
use super::picture::decode;
use super::projector;
use crate::ModelError;

/// Stands for the picture in the text that the library tokenizes. That text is nothing but this, so a message cannot bring
/// in a picture or a control token.
const MARKER: &str = "<__media__>";
/// Maximum number of characters of the library's reason in an error.
const REASON: usize = 300;

/// A loaded projector.
pub(super) struct Vision {
    context: MtmdContext,
    /// True if the model attends in both directions within a picture, which it can do only if the picture is computed as a
    /// whole.
    is_whole: bool,
}

/// A picture, scaled and cut as the model needs it, with the tokens around its parts.
pub(super) struct PictureTokens {
    chunks: MtmdInputChunks,
    tokens: usize,
    together: usize,
}

impl Vision {
    /// Loads a projector, and checks that it belongs to the model.
    pub(super) fn load(path: &Path, model: &LlamaModel, threads: usize) -> Result<Self, ModelError> {
        let facts = projector::check(path).map_err(|reason| bad(path, reason))?;
        let takes = u64::try_from(model.n_embd()).unwrap_or_default();
        if let Some(width) = facts.width.filter(|width| *width != takes) {
            return Err(bad(
                path,
                format!("it makes embeddings of {width} numbers, and the model takes {takes}"),
            ));
        }
        let name = path.to_str().ok_or_else(|| bad(path, "its path is not UTF-8".into()))?;
        let marker = CString::new(MARKER).map_err(|error| bad(path, error.to_string()))?;
        let parameters = MtmdContextParams {
            use_gpu: false,
            print_timings: false,
            n_threads: i32::try_from(threads).unwrap_or(i32::MAX),
            media_marker: marker,
            ..MtmdContextParams::default()
        };
        let errors = Errors::default();
        let loaded =
            tracing::subscriber::with_default(errors.clone(), || MtmdContext::init_from_file(name, model, &parameters));
        let context = loaded.map_err(|error| bad(path, errors.first().unwrap_or_else(|| error.to_string())))?;
        if !context.support_vision() {
            return Err(bad(path, "it has no vision encoder".into()));
        }
        let is_whole = context.decode_use_non_causal();
        Ok(Self { context, is_whole })
    }

    /// Decodes a picture and prepares it for the model. Nothing is computed yet.
    pub(super) fn tokens(&self, picture: &Picture) -> Result<PictureTokens, String> {
        let pixels = decode(picture)?;
        let bitmap = MtmdBitmap::from_image_data(pixels.width, pixels.height, &pixels.bytes);
        let bitmap = bitmap.map_err(|error| error.to_string())?;
        let text = MtmdInputText {
            text: MARKER.to_owned(),
            add_special: false,
            parse_special: true,
        };
        let chunks = self.context.tokenize(text, &[&bitmap]);
        let chunks = chunks.map_err(|error| format!("the model cannot take it: {error}"))?;
        let sizes = (0..chunks.len()).filter_map(|index| chunks.get(index));
        let pictures = sizes.filter(|chunk| chunk.chunk_type() == MtmdInputChunkType::Image);
        let largest = pictures.map(|chunk| chunk.n_tokens()).max();
        let largest = largest.ok_or("the model makes no tokens of it")?;
        Ok(PictureTokens {
            tokens: chunks.total_tokens(),
            together: if self.is_whole { largest } else { 0 },
            chunks,
        })
    }

    /// Computes a picture behind the tokens that the engine holds.
    pub(super) fn see(&mut self, picture: &PictureTokens, engine: &mut Engine<'_>) -> Result<(), String> {
        engine.see(|context, position, batch| {
            let end = picture
                .chunks
                .eval_chunks(&mut self.context, context, position, SEQUENCE, batch, false);
            end.map_err(|error| format!("it cannot compute the picture: {error}"))
        })
    }
}

impl PictureTokens {
    /// Number of tokens.
    pub(super) fn tokens(&self) -> usize {
        self.tokens
    }

    /// Number of tokens that the engine has to compute together.
    pub(super) fn together(&self) -> usize {
        self.together
    }
}

fn bad(path: &Path, reason: String) -> ModelError {
    ModelError::BadProjector {
        path: path.to_path_buf(),
        reason,
    }
}

/// The errors in the library's log, which has the reason when a projector cannot be loaded.
#[derive(Clone, Default)]
struct Errors(Arc<Mutex<Vec<String>>>);

impl Errors {
    /// Returns the first error, in one line.
    fn first(&self) -> Option<String> {
        let errors = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let line = errors.first()?.lines().next()?;
        let line = line.strip_prefix("error: ").unwrap_or(line).trim();
        Some(line.chars().take(REASON).collect())
    }
}

impl Subscriber for Errors {
    fn enabled(&self, metadata: &Metadata<'_>) -> bool {
        *metadata.level() == Level::ERROR
    }

    fn new_span(&self, _: &span::Attributes<'_>) -> span::Id {
        span::Id::from_u64(1)
    }

    fn record(&self, _: &span::Id, _: &span::Record<'_>) {}

    fn record_follows_from(&self, _: &span::Id, _: &span::Id) {}

    fn event(&self, event: &Event<'_>) {
        event.record(&mut Messages(self));
    }

    fn enter(&self, _: &span::Id) {}

    fn exit(&self, _: &span::Id) {}
}

/// Keeps the messages of events.
struct Messages<'a>(&'a Errors);

impl Visit for Messages<'_> {
    fn record_str(&mut self, field: &Field, value: &str) {
        if field.name() == "message" {
            let mut errors = self.0.0.lock().unwrap_or_else(PoisonError::into_inner);
            errors.push(value.to_owned());
        }
    }

    fn record_debug(&mut self, _: &Field, _: &dyn std::fmt::Debug) {}
}
