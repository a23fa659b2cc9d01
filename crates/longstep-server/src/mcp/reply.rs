//! The results of tools: a short text for models, and the program's own JSON.

use rmcp::model::{CallToolResponse, CallToolResult, ContentBlock, InputRequiredResult};
use serde::Serialize;
use serde_json::{Value, json};

use crate::problem::Problem;

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
        let data = data.map_err(|error| Problem::new(crate::ProblemKind::Internal, error.to_string()))?;
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
    let hint = problem.hint.as_deref();
    let next = hint.map_or(String::new(), |hint| format!("\nNext step: {hint}"));
    let mut result = CallToolResult::error(vec![ContentBlock::text(format!("{}{next}", problem.message))]);
    let error = json!({"kind": problem.kind.name(), "message": problem.message, "hint": problem.hint});
    result.structured_content = Some(json!({ "error": error }));
    result
}

/// Returns a heading with its lines below it, or nothing without lines.
pub(super) fn section<T: AsRef<str>>(heading: &str, lines: impl IntoIterator<Item = T>) -> String {
    let lines: String = lines.into_iter().map(|line| format!("\n- {}", line.as_ref())).collect();
    if lines.is_empty() {
        return lines;
    }
    format!("\n{heading}:{lines}")
}
