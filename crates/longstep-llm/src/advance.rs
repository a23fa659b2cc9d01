//! Drives a session with a model.

use std::time::Instant;

use longstep::dialogue::PromptError;
use longstep::session::{Need, Session};

use crate::{ChatModel, FolderError, ModelError, SessionFolder, Watch};

/// Reason why a session stopped before it needed a person.
#[derive(Debug, thiserror::Error)]
pub enum AdvanceError {
    /// The model failed or was stopped.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// The request cannot be built, or does not fit into the model's context.
    #[error(transparent)]
    Prompt(#[from] PromptError),
    /// The session's events cannot be saved.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

/// Sends requests to the model until the session needs a person, and saves the events if there is a folder for them.
///
/// # Errors
///
/// When the model fails: a session that had a plan keeps it; otherwise it waits for a new instruction. A stopped call
/// is also cancelled in the session.
pub fn advance(
    session: &mut Session,
    model: &mut dyn ChatModel,
    mut folder: Option<&mut SessionFolder>,
    watch: &mut dyn Watch,
) -> Result<Need, AdvanceError> {
    loop {
        let need = session.need(&mut *model);
        if let Some(folder) = folder.as_deref_mut() {
            folder.keep(session)?;
        }
        let request = match need? {
            Need::Model(prepared) => prepared.request,
            need => return Ok(need),
        };
        let asked = Instant::now();
        // The session waits for a model in both arms, so `supply`, `cancel` and `failed` are never out of turn.
        match model.chat(&request, watch) {
            Ok(reply) => {
                let milliseconds = asked.elapsed().as_secs_f64() * 1000.0;
                let _ = session.supply(&reply, (milliseconds * 1000.0).round() / 1000.0);
            }
            Err(error) => {
                let _ = match error {
                    ModelError::Stopped => session.cancel(),
                    _ => session.failed(&error.to_string()),
                };
                if let Some(folder) = folder.as_deref_mut() {
                    folder.keep(session)?;
                }
                return Err(error.into());
            }
        }
    }
}
