//! Drives a session with a model.

use std::time::Instant;

use longstep::dialogue::PromptError;
use longstep::session::{OutOfTurn, Response, Session};

use crate::{ChatModel, FolderError, ModelError, Progress, SessionFolder, Watch};

/// Reason why a session stopped before it needed a person.
#[derive(Debug, thiserror::Error)]
#[non_exhaustive]
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
    /// Another instruction is under way.
    #[error(transparent)]
    OutOfTurn(#[from] OutOfTurn),
}

/// Sends requests to the model until it is the person's turn ([`Session::response`]), and saves the events if there is a folder for them.
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
) -> Result<(), AdvanceError> {
    loop {
        let request = session.next_request(&mut *model);
        if let Some(folder) = folder.as_deref_mut() {
            folder.keep(session)?;
        }
        let Some(prepared) = request? else {
            return Ok(());
        };
        if let Some(forecast) = prepared.forecast {
            watch.tell(Progress::Forecast(forecast));
        }
        let started = Instant::now();
        // The session waits for a model in both arms, so `supply`, `cancel` and `failed` are never out of turn.
        match model.chat(&prepared.request, watch) {
            Ok(reply) => {
                watch.tell(Progress::Answered);
                let milliseconds = started.elapsed().as_secs_f64() * 1000.0;
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

/// Gives a session an instruction, and calls the model until it is the person's turn.
///
/// ```no_run
/// use longstep::Planner;
/// use longstep::session::{Response, Settings};
/// # fn main() -> Result<(), Box<dyn std::error::Error>> {
/// let planner = Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let options = longstep_llm::OpenOptions::new(longstep_files::cache_directory()?);
/// let mut model = longstep_llm::open(&"qwen2.5-coder-0.5b".parse()?, &options, &mut |_| {})?;
/// let mut session = planner.session(world, Settings::default(), model.facts())?;
/// match longstep_llm::instruct(&mut session, &mut *model, "The pen belongs on the shelf")? {
///     Response::Plan(proposal) => println!("{} steps", proposal.plan.steps().len()),
///     other => println!("{other}"),
/// }
/// # Ok(())
/// # }
/// ```
///
/// # Errors
///
/// [`AdvanceError::OutOfTurn`] when another instruction is under way; otherwise as for [`advance`].
pub fn instruct<'s>(
    session: &'s mut Session,
    model: &mut dyn ChatModel,
    text: &str,
) -> Result<Response<'s>, AdvanceError> {
    session.instruct(text)?;
    advance(session, model, None, &mut |_: Progress| {})?;
    Ok(session.response())
}
