//! The results of tools: a short text for models, and the program's own JSON.

use rmcp::model::{CallToolResponse, CallToolResult, ContentBlock, InputRequiredResult, MetaObject};
use serde::Serialize;
use serde_json::{Value, json};

use crate::problem::{Problem, ProblemKind};

/// The key of a refusal as data, in the metadata of a result.
const ERROR: &str = "io.github.longstep/error";

/// The result of a tool.
#[derive(Debug)]
pub(super) enum Reply {
    /// A result: text and data.
    Done {
        /// For a model.
        text: String,
        /// The program's own JSON.
        data: Value,
    },
    /// A question to the person, which the client answers with another call.
    Asked(Box<InputRequiredResult>),
}

impl Reply {
    pub(super) fn new(text: impl Into<String>, data: &impl Serialize) -> Result<Self, Problem> {
        let data = serde_json::to_value(data);
        let data = data.map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?;
        Ok(Self::Done {
            text: text.into(),
            data,
        })
    }
}

/// Returns the response to a call. A refusal is a result too, so that a model sees its reason and the next step.
pub(super) fn response(result: Result<Reply, Problem>) -> CallToolResponse {
    match result {
        Ok(Reply::Asked(asked)) => (*asked).into(),
        Ok(Reply::Done { text, data }) => {
            let mut result = CallToolResult::success(vec![ContentBlock::text(text)]);
            result.structured_content = Some(data);
            result.into()
        }
        Err(problem) => refusal(&problem).into(),
    }
}

fn refusal(problem: &Problem) -> CallToolResult {
    let hint = problem.hint.as_deref().unwrap_or_else(|| usual_hint(problem.kind));
    let text = format!("{}\nNext step: {hint}", problem.message);
    let mut result = CallToolResult::error(vec![ContentBlock::text(text)]);
    // Some clients compare the data of a refusal with the schema of results, so it is beside them.
    let error = json!({"kind": problem.kind.name(), "message": problem.message, "hint": hint});
    result.meta = Some(MetaObject([(ERROR.to_owned(), error)].into_iter().collect()));
    result
}

/// Returns the next step after a problem that names none.
fn usual_hint(kind: ProblemKind) -> &'static str {
    match kind {
        ProblemKind::Unreadable | ProblemKind::TooLarge => "correct the arguments, and call the tool again",
        ProblemKind::Unknown | ProblemKind::Forbidden => "ask the person",
        ProblemKind::Missing => "use an id that a tool of this server returned",
        ProblemKind::Conflict => "call `explain` for the plan, or `run_status` for the run, to see its state",
        ProblemKind::Busy => "wait some seconds, and call the tool again",
        ProblemKind::Failed | ProblemKind::Internal => "tell the person; the same call may work later",
    }
}

/// Returns a heading with its lines below it, or nothing without lines.
pub(super) fn section<T: AsRef<str>>(heading: &str, lines: impl IntoIterator<Item = T>) -> String {
    let lines: String = lines.into_iter().map(|line| format!("\n- {}", line.as_ref())).collect();
    if lines.is_empty() {
        return lines;
    }
    format!("\n{heading}:{lines}")
}
