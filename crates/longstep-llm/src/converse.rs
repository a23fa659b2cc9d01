//! Runs a goal dialogue with a model.

use longstep::dialogue::{DialogueError, GoalDialogue, Turn};
use longstep::domain::Domain;
use longstep::environment::World;
use longstep::goal::Understanding;

use crate::{ChatModel, ModelError, Watch};

/// Reason why an instruction was not understood.
#[derive(Debug, thiserror::Error)]
pub enum UnderstandError {
    /// The model failed.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The model's answer cannot be used.
    #[error(transparent)]
    Answer(#[from] DialogueError),
}

/// Sends requests to the model until the dialogue is done.
///
/// # Errors
///
/// When the model fails, or its answer cannot be used.
pub fn understand(
    model: &mut dyn ChatModel,
    domain: &Domain,
    world: &World,
    dialogue: &mut GoalDialogue,
    watch: &mut dyn Watch,
) -> Result<Understanding, UnderstandError> {
    loop {
        let reply = model.chat(&dialogue.request(domain, world), watch)?;
        if let Turn::Done(understanding) = dialogue.supply(domain, world, &reply)? {
            return Ok(understanding);
        }
    }
}
