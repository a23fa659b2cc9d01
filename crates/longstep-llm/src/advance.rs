//! Carries a session on with a model.

use std::time::Instant;

use longstep::dialogue::PromptError;
use longstep::session::{Need, Session};

use crate::{ChatModel, FolderError, ModelError, SessionFolder, Watch};

/// Why a session did not go on.
#[derive(Debug, thiserror::Error)]
pub enum AdvanceError {
    /// The model failed, or was stopped.
    #[error(transparent)]
    Model(#[from] ModelError),
    /// What must be said cannot be said, or does not fit into the model.
    #[error(transparent)]
    Prompt(#[from] PromptError),
    /// What happened cannot be written down.
    #[error(transparent)]
    Folder(#[from] FolderError),
}

/// Asks the model until the session needs a person, and writes down what happens where there is a folder for it.
///
/// # Errors
///
/// When the model fails: the session then has its plan back if the call was about one, and is stuck otherwise. When
/// the call was stopped, it is cancelled in the session too.
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
        // The session waits for a model in both arms, so that neither is out of turn.
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
