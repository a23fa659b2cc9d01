//! Runs as a face shows them.

use longstep_core::environment::Environment;
use longstep_core::execution::{BoardLine, BoardStep};
use serde::{Deserialize, Serialize};

use crate::id::{ApprovalId, RunId, SessionId};

/// The data of a run besides its log.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct RunRecord {
    /// The run.
    pub id: RunId,
    /// The session of its plan.
    pub session: SessionId,
    /// The number of its plan among the accepted ones.
    pub number: usize,
    /// The hash of its plan, which was approved.
    pub plan: String,
    /// The approval that began it.
    pub approval: ApprovalId,
    /// The robot.
    pub robot: String,
    /// Who began it.
    pub by: String,
    /// The instruction.
    pub instruction: String,
    /// True if it interrupts another run of the robot.
    #[serde(default)]
    pub urgent: bool,
}

/// The state of a run.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum RunState {
    /// It waits for its robot.
    Queued,
    /// Its robot is being opened.
    Opening,
    /// It goes on.
    Running,
    /// It waits for a person.
    Asking,
    /// It is paused.
    Paused,
    /// The goal is reached in the observed world.
    Done,
    /// It has stopped.
    Stopped,
    /// The server ended while it went on; it can be resumed.
    Interrupted,
}

impl RunState {
    /// Returns the name, as in a view.
    pub fn name(self) -> &'static str {
        match self {
            Self::Queued => "queued",
            Self::Opening => "opening",
            Self::Running => "running",
            Self::Asking => "asking",
            Self::Paused => "paused",
            Self::Done => "done",
            Self::Stopped => "stopped",
            Self::Interrupted => "interrupted",
        }
    }

    /// Returns true if the run will not go on by itself.
    pub fn is_ended(self) -> bool {
        matches!(self, Self::Done | Self::Stopped | Self::Interrupted)
    }
}

/// A question of a run to a person.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct QuestionView {
    /// The id that an answer names: the hash of the proposal, or the number of the question.
    pub id: String,
    /// `plan`, `change`, `step`, `judge` or `confirm`.
    pub kind: &'static str,
    /// The question.
    pub text: String,
    /// The steps of a plan or a change, as sentences.
    pub steps: Vec<String>,
    /// The edits of a change, with their reasons.
    pub edits: Vec<String>,
}

/// The end of a run.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct EndView {
    /// True if the goal is reached in the observed world.
    pub done: bool,
    /// The reason of a stop, or what rests on promises.
    pub text: String,
    /// True if the run can be resumed.
    pub resumable: bool,
}

/// A run as a program or a page sees it.
#[derive(Debug, Clone, Serialize)]
#[non_exhaustive]
pub struct RunView {
    /// The beginning: the plan, its approval and its robot.
    #[serde(flatten)]
    pub record: RunRecord,
    /// Its state.
    pub state: RunState,
    /// True if nothing moves.
    pub dry_run: bool,
    /// The steps with their states.
    pub steps: Vec<BoardStep>,
    /// The lines of the steps, which refer to them by number.
    pub lines: Vec<BoardLine>,
    /// The last feedback of the robot about a step under way.
    pub feedback: Option<String>,
    /// The question that waits for a person.
    pub question: Option<QuestionView>,
    /// Differences, changes and failures, in order.
    pub notices: Vec<String>,
    /// The number of events in its log.
    pub events: usize,
    /// The world as it is known.
    pub environment: Option<Environment>,
    /// The end.
    pub end: Option<EndView>,
}

impl RunView {
    pub(crate) fn new(record: RunRecord, state: RunState) -> Self {
        Self {
            record,
            state,
            dry_run: false,
            steps: Vec::new(),
            lines: Vec::new(),
            feedback: None,
            question: None,
            notices: Vec::new(),
            events: 0,
            environment: None,
            end: None,
        }
    }
}
