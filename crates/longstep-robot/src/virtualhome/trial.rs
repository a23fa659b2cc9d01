//! Programs that are tried in the simulator, line by line, and the feedback about a line that fails.

use std::time::Duration;

use super::api::Simulator;
use super::script::Line;
use crate::error::RobotError;

/// The number of times that a line is tried before it counts as failed. A line may fail once because the character stands
/// in its own way.
const TRIES: usize = 2;

/// How far a program came.
///
/// This is how Wake et al. (2023) judge the plans of a model: the simulator itself is the judge, so the program need not be
/// verified. It belongs to evaluations, in a scene that is reset first; a robot never gets such a program.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trial {
    /// The number of lines that were performed.
    pub performed: usize,
    /// The simulator's reason why the next line failed; none if there was no next line.
    pub failure: Option<String>,
}

impl Simulator {
    /// Resets the scene, adds a character in the room, and performs a program up to the first line that fails twice.
    ///
    /// # Errors
    ///
    /// A refusal to reset or to add the character, and every failure of the connection.
    pub fn try_program(&self, program: &[Line], room: &str, limit: Duration) -> Result<Trial, RobotError> {
        self.reset(None)?;
        self.add_character("Chars/Male2", Some(room))?;
        for (performed, line) in program.iter().enumerate() {
            let mut result = Ok(());
            for _ in 0..TRIES {
                result = self.render(line, limit)?;
                if result.is_ok() {
                    break;
                }
            }
            if let Err(failure) = result {
                let failure = Some(failure);
                return Ok(Trial { performed, failure });
            }
        }
        Ok(Trial {
            performed: program.len(),
            failure: None,
        })
    }
}

/// Returns the feedback to a model about a line that failed: which call, the simulator's verb, and its reason.
///
/// ```
/// use longstep_robot::virtualhome::{Line, feedback};
/// let line = Line::new("open", &["<toaster_309>"])?;
/// let text = feedback("Open(<toaster_309>)", &line, "<toaster> (309) can not be opened");
/// assert!(text.starts_with("This step failed in the simulator: Open(<toaster_309>)\n"));
/// # Ok::<(), longstep_robot::virtualhome::LineError>(())
/// ```
pub fn feedback(call: &str, line: &Line, reason: &str) -> String {
    let verb = line.verb();
    format!(
        "This step failed in the simulator: {call}\nThe reason: {reason}\nEither the action {{{verb}}} does not fit these \
         objects, or a step before it is missing. Change the plan."
    )
}
