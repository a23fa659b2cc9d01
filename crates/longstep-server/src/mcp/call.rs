//! From the name and the arguments of a call to the function for it.

use rmcp::model::{CallToolRequestParams, CallToolResponse, ErrorData, JsonObject};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::Value;

use super::caller::Caller;
use super::consent::Input;
use super::face::Face;
use super::reply::{Reply, response};
use crate::problem::Problem;

/// The session that a call is about.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct InSession {
    pub(super) session: Option<String>,
}

/// A text for a session.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Words {
    #[serde(alias = "instruction", alias = "answer", alias = "feedback")]
    pub(super) text: String,
    pub(super) session: Option<String>,
}

/// A written plan.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Draft {
    pub(super) plan: Value,
    pub(super) goal: Option<String>,
    pub(super) session: Option<String>,
}

/// A plan to carry out.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Execute {
    pub(super) plan_id: String,
    pub(super) hash: String,
    pub(super) robot: Option<String>,
}

/// A run to look at.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct LookAt {
    pub(super) run: Option<String>,
    pub(super) wait_seconds: Option<f64>,
    pub(super) session: Option<String>,
}

/// A run to control.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OfRun {
    pub(super) run: String,
}

/// A run to stop, or all.
#[derive(Debug, Clone, Default, Deserialize)]
pub(super) struct StopRun {
    pub(super) run: Option<String>,
}

/// The question of a run.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Decide {
    pub(super) run: String,
    pub(super) question: String,
}

/// Calls a tool.
///
/// # Errors
///
/// There is no such tool. All other refusals are results.
pub(super) async fn call(
    face: &Face,
    caller: &Caller,
    request: CallToolRequestParams,
) -> Result<CallToolResponse, ErrorData> {
    let name = request.name.into_owned();
    let arguments = request.arguments.unwrap_or_default();
    let input = Input {
        state: request.request_state,
        responses: request.input_responses,
    };
    match reply(face, caller, &name, arguments, input).await.transpose() {
        Some(reply) => Ok(response(reply)),
        None => Err(ErrorData::invalid_params(format!("there is no tool `{name}`"), None)),
    }
}

/// Returns the reply of a tool; none if there is no such tool.
async fn reply(
    face: &Face,
    caller: &Caller,
    name: &str,
    arguments: JsonObject,
    input: Input,
) -> Result<Option<Reply>, Problem> {
    Ok(Some(match name {
        // A stop does not fail for its arguments.
        "stop" => face.stop(caller, &read(arguments).unwrap_or_default())?,
        "describe_world" => face.describe_world(read(arguments)?).await?,
        "plan" => face.plan(caller, read(arguments)?).await?,
        "answer" => face.answer(caller, read(arguments)?).await?,
        "revise" => face.revise(caller, read(arguments)?).await?,
        "discard" => face.discard(read(arguments)?).await?,
        "verify" => face.verify(read(arguments)?).await?,
        "repair" => face.repair(read(arguments)?).await?,
        "explain" => face.explain(read(arguments)?).await?,
        "execute_plan" => face.execute_plan(caller, read(arguments)?, input).await?,
        "decide" => face.decide(caller, read(arguments)?, input).await?,
        "run_status" => face.run_status(caller, read(arguments)?).await?,
        "pause" => face.pause(caller, read(arguments)?).await?,
        "resume" => face.resume(caller, read(arguments)?).await?,
        _ => return Ok(None),
    }))
}

fn read<T: DeserializeOwned>(arguments: JsonObject) -> Result<T, Problem> {
    let read = serde_json::from_value(Value::Object(arguments));
    read.map_err(|error| {
        Problem::unreadable(format!("the arguments cannot be read: {error}"))
            .hint("call the tool again with the arguments of its input schema")
    })
}
