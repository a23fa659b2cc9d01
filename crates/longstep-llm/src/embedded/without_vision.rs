//! A build without the feature `vision`: no projector can be opened, so no value of these types exists.

use std::path::Path;

use llama_cpp_2::model::LlamaModel;
use longstep::dialogue::Picture;

use super::engine::Engine;
use crate::ModelError;

/// The model's eyes, which this build does not have.
pub(super) enum Vision {}

/// The tokens of a picture, which this build cannot make.
pub(super) enum PictureTokens {}

impl Vision {
    /// Refuses every projector.
    pub(super) fn load(path: &Path, _: &LlamaModel, _: usize) -> Result<Self, ModelError> {
        Err(ModelError::NoVisionEngine {
            place: path.display().to_string(),
        })
    }

    pub(super) fn tokens(&self, _: &Picture) -> Result<PictureTokens, String> {
        match *self {}
    }

    pub(super) fn see(&mut self, _: &PictureTokens, _: &mut Engine<'_>) -> Result<(), String> {
        match *self {}
    }
}

impl PictureTokens {
    pub(super) fn tokens(&self) -> usize {
        match *self {}
    }

    pub(super) fn together(&self) -> usize {
        match *self {}
    }
}
