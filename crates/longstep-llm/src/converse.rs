//! Carries out a dialogue with a model.

use longstep::dialogue::{Dialogue, DialogueError};

use crate::{ChatModel, ModelError, Watch};

/// Error of a dialogue with a model.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
pub enum ConverseError {
    /// The model failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The model's reply cannot be used.
    #[error(transparent)]
    Answer(#[from] DialogueError),
}

/// Sends the requests of a dialogue to a model until the dialogue has a result.
///
/// # Errors
///
/// The model fails, or a reply cannot be used.
pub fn converse<D: Dialogue>(
    model: &mut dyn ChatModel,
    dialogue: &mut D,
    watch: &mut dyn Watch,
) -> Result<D::Output, ConverseError> {
    loop {
        let reply = model.chat(&dialogue.request(), watch)?;
        if let Some(output) = dialogue.supply(&reply)? {
            return Ok(output);
        }
    }
}
