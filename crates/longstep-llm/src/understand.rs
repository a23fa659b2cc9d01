//! Carries out a goal dialogue with a model.

use longstep::goal::Understanding;
use longstep::prompt::{DialogueError, GoalDialogue, Turn};

use crate::{ChatModel, ModelError, Progress};

/// Why an instruction was not understood.
#[derive(Debug, thiserror::Error)]
pub enum UnderstandError {
    /// The model failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The model answered, and the answer cannot be used.
    #[error(transparent)]
    Answer(#[from] DialogueError),
}

/// Asks the model until the dialogue is done.
///
/// # Errors
///
/// When the model fails, or answers something that cannot be used.
pub fn understand(
    model: &mut dyn ChatModel,
    dialogue: &mut GoalDialogue<'_>,
    progress: &mut dyn FnMut(Progress),
) -> Result<Understanding, UnderstandError> {
    loop {
        let reply = model.chat(&dialogue.request(), progress)?;
        if let Turn::Done(understanding) = dialogue.supply(&reply)? {
            return Ok(understanding);
        }
    }
}
