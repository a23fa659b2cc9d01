//! The answers to requests of programs.

use std::sync::Arc;
use std::time::Duration;

use axum::extract::{Extension, Path, State};
use axum::http::{HeaderMap, HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use longstep_core::environment::Observation;
use longstep_llm::lent::{ChatCall, CountCall};
use serde::Deserialize;
use serde_json::{Value, json};

use super::Shared;
use super::access::Person;
use super::reply::{Asked, Reply};
use crate::approval::APPROVAL_LIFETIME;
use crate::hub::{Hub, NewSession};
use crate::id::{ApprovalId, RunId, SessionId};
use crate::lend::LentWork;
use crate::problem::{Problem, ProblemKind};
use crate::run::RunView;
use crate::talk::Said;
use crate::view::{SessionView, Snapshot};

/// The result of a request.
type Result<T = Response, E = Problem> = std::result::Result<T, E>;

/// The most lines of the audit log in an answer.
const AUDIT: usize = 1_000;

/// Does work that may wait for the disk or a search.
pub(super) async fn blocking<T: Send + 'static>(
    shared: Shared,
    work: impl FnOnce(&Arc<Hub>) -> Result<T> + Send + 'static,
) -> Result<T> {
    let done = tokio::task::spawn_blocking(move || work(&shared.hub)).await;
    done.map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?
}

pub(super) fn session_id(text: &str) -> Result<SessionId> {
    SessionId::parse(text).ok_or_else(|| Problem::missing("session", longstep_core::visible::line(text)))
}

pub(super) fn run_id(text: &str) -> Result<RunId> {
    RunId::parse(text).ok_or_else(|| Problem::missing("run", longstep_core::visible::line(text)))
}

fn session(snapshot: &Snapshot) -> Response {
    Reply::<&SessionView>(&snapshot.view).into_response()
}

fn run(view: &RunView) -> Response {
    Reply(view).into_response()
}

/// Where a session or a plan begins.
#[derive(Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Place {
    domain: Option<String>,
    environment: Option<Value>,
    scene: Option<String>,
    #[serde(default)]
    rules: Vec<String>,
}

impl From<Place> for NewSession {
    fn from(place: Place) -> Self {
        Self {
            domain: place.domain,
            environment: place.environment.map(|environment| environment.to_string()),
            scene: place.scene,
            rules: place.rules,
        }
    }
}

pub(super) async fn model(State(shared): State<Shared>) -> Result {
    lend(shared, LentWork::Describe).await
}

pub(super) async fn chat(State(shared): State<Shared>, Asked(call): Asked<ChatCall>) -> Result {
    lend(shared, LentWork::Chat(call)).await
}

pub(super) async fn count(State(shared): State<Shared>, Asked(call): Asked<CountCall>) -> Result {
    lend(shared, LentWork::Count(call)).await
}

async fn lend(shared: Shared, work: LentWork) -> Result {
    Ok(Reply(shared.hub.lend(work).await?).into_response())
}

/// A plan that was written elsewhere.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct WrittenPlan {
    #[serde(default)]
    place: Place,
    /// The plan: an object, or a text.
    plan: Value,
    goal: Option<String>,
}

impl WrittenPlan {
    fn text(&self) -> String {
        match &self.plan {
            Value::String(text) => text.clone(),
            object => object.to_string(),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Goal {
    #[serde(default)]
    place: Place,
    goal: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Instruction {
    #[serde(default)]
    place: Place,
    instruction: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Words {
    text: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Hash {
    plan: String,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Ending {
    ending: usize,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Approve {
    plan: String,
    robot: String,
    expires_s: Option<u64>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Start {
    approval: String,
    #[serde(default)]
    urgent: bool,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Decision {
    question: String,
    yes: bool,
}

pub(crate) async fn server(State(shared): State<Shared>) -> Response {
    let hub = &shared.hub;
    let model = hub
        .models()
        .map(|models| json!({"name": models.facts().name, "waiting": models.waiting()}));
    let robots = hub.robots().iter();
    let robots: Vec<Value> = robots
        .map(|robot| json!({"name": robot.name, "reference": robot.reference, "body": robot.body}))
        .collect();
    Reply(json!({
        "version": env!("CARGO_PKG_VERSION"),
        "model": model,
        "domains": hub.domains().names(),
        "scenes": hub.domains().scenes(),
        "robots": robots,
    }))
    .into_response()
}

pub(crate) async fn sessions(State(shared): State<Shared>) -> Result {
    let ids = blocking(shared, |hub| hub.sessions()).await?;
    Ok(Reply(json!({"sessions": ids})).into_response())
}

pub(crate) async fn create(State(shared): State<Shared>, Asked(place): Asked<Place>) -> Result {
    let created = blocking(shared, move |hub| hub.create(&place.into())).await?;
    Ok((StatusCode::CREATED, session(&created)).into_response())
}

pub(crate) async fn one_session(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = session_id(&id)?;
    Ok(session(&*blocking(shared, move |hub| hub.session(&id)).await?))
}

pub(crate) async fn world(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = session_id(&id)?;
    let snapshot = blocking(shared, move |hub| hub.session(&id)).await?;
    Ok(Reply(&snapshot.view.environment).into_response())
}

/// Tells a session something, and waits for the person's turn, unless the client prefers not to wait. A client that goes
/// away while it waits cancels the work.
async fn say(shared: Shared, id: String, headers: &HeaderMap, said: Said) -> Result {
    let id = session_id(&id)?;
    let waiting = blocking(shared, move |hub| hub.say(&id, &said)).await?;
    let prefers = headers.get("prefer").and_then(|value| value.to_str().ok());
    if prefers.is_some_and(|value| value.split(',').any(|part| part.trim() == "respond-async")) {
        return Ok((StatusCode::ACCEPTED, session(&waiting.leave())).into_response());
    }
    Ok(session(&*waiting.turn().await))
}

pub(crate) async fn instruct(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    headers: HeaderMap,
    Asked(words): Asked<Words>,
) -> Result {
    say(shared, id, &headers, Said::Instruction(words.text)).await
}

pub(crate) async fn answer(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    headers: HeaderMap,
    Asked(words): Asked<Words>,
) -> Result {
    say(shared, id, &headers, Said::Answer(words.text)).await
}

pub(crate) async fn feedback(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    headers: HeaderMap,
    Asked(words): Asked<Words>,
) -> Result {
    say(shared, id, &headers, Said::Feedback(words.text)).await
}

pub(crate) async fn cancel(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = session_id(&id)?;
    Ok(session(&*blocking(shared, move |hub| hub.cancel(&id)).await?))
}

pub(crate) async fn accept(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
    Asked(hash): Asked<Hash>,
) -> Result {
    let id = session_id(&id)?;
    let accepted = blocking(shared, move |hub| hub.accept(&id, &hash.plan, &person.name)).await?;
    Ok(session(&accepted))
}

pub(crate) async fn undo(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = session_id(&id)?;
    Ok(session(&*blocking(shared, move |hub| hub.undo(&id)).await?))
}

pub(crate) async fn ended(State(shared): State<Shared>, Path(id): Path<String>, Asked(own): Asked<Ending>) -> Result {
    let id = session_id(&id)?;
    Ok(session(
        &*blocking(shared, move |hub| hub.ended(&id, own.ending)).await?,
    ))
}

pub(crate) async fn observed(
    State(shared): State<Shared>,
    Path(id): Path<String>,
    Asked(statements): Asked<Observation>,
) -> Result {
    let id = session_id(&id)?;
    Ok(session(
        &*blocking(shared, move |hub| hub.observed(&id, &statements)).await?,
    ))
}

pub(crate) async fn approve(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
    Asked(own): Asked<Approve>,
) -> Result {
    let id = session_id(&id)?;
    let lifetime = own.expires_s.map_or(APPROVAL_LIFETIME, Duration::from_secs);
    let approved = move |hub: &Arc<Hub>| hub.approve(&id, &own.plan, &own.robot, &person.name, lifetime);
    let approval = blocking(shared, approved).await?;
    Ok((StatusCode::CREATED, Reply(approval)).into_response())
}

pub(crate) async fn verify(State(shared): State<Shared>, Asked(mut own): Asked<WrittenPlan>) -> Result {
    let place = NewSession::from(std::mem::take(&mut own.place));
    let verified = move |hub: &Arc<Hub>| hub.verify(&place, &own.text(), own.goal.as_deref());
    Ok(Reply(blocking(shared, verified).await?).into_response())
}

pub(crate) async fn repair(State(shared): State<Shared>, Asked(mut own): Asked<WrittenPlan>) -> Result {
    let place = NewSession::from(std::mem::take(&mut own.place));
    let repaired = move |hub: &Arc<Hub>| hub.repair(&place, &own.text(), own.goal.as_deref());
    Ok(Reply(blocking(shared, repaired).await?).into_response())
}

pub(crate) async fn solve(State(shared): State<Shared>, Asked(own): Asked<Goal>) -> Result {
    let solved = move |hub: &Arc<Hub>| hub.solve(&own.place.into(), &own.goal);
    Ok(Reply(blocking(shared, solved).await?).into_response())
}

pub(crate) async fn plan(State(shared): State<Shared>, Asked(own): Asked<Instruction>) -> Result {
    let planning = move |hub: &Arc<Hub>| hub.plan(&own.place.into(), &own.instruction);
    let planning = blocking(shared, planning).await?;
    Ok(Reply(planning.answer().await?).into_response())
}

pub(crate) async fn runs(State(shared): State<Shared>) -> Result {
    let runs = blocking(shared, |hub| Ok(hub.runs())).await?;
    let runs: Vec<Value> = runs
        .iter()
        .map(|run| json!({"id": run.record.id, "session": run.record.session, "state": run.state}))
        .collect();
    Ok(Reply(json!({"runs": runs})).into_response())
}

/// Returns a run as a file to download.
pub(crate) async fn recording(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = run_id(&id)?;
    let name = format!("attachment; filename=\"{id}.mcap\"");
    let bytes = blocking(shared, move |hub| hub.recording(&id)).await?;
    let name = HeaderValue::from_str(&name).map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?;
    let kind = HeaderValue::from_static("application/octet-stream");
    Ok((
        [(header::CONTENT_TYPE, kind), (header::CONTENT_DISPOSITION, name)],
        bytes,
    )
        .into_response())
}

pub(crate) async fn start(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Asked(own): Asked<Start>,
) -> Result {
    let approval = ApprovalId::parse(&own.approval);
    let approval = approval.ok_or_else(|| Problem::missing("approval", longstep_core::visible::line(&own.approval)))?;
    let started = move |hub: &Arc<Hub>| hub.start(&approval, own.urgent, &person.name);
    Ok((StatusCode::CREATED, run(&*blocking(shared, started).await?)).into_response())
}

pub(crate) async fn one_run(State(shared): State<Shared>, Path(id): Path<String>) -> Result {
    let id = run_id(&id)?;
    Ok(run(&*blocking(shared, move |hub| hub.run(&id)).await?))
}

pub(crate) async fn decide(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
    Asked(own): Asked<Decision>,
) -> Result {
    let id = run_id(&id)?;
    let decided = move |hub: &Arc<Hub>| hub.decide(&id, &own.question, own.yes, &person.name);
    Ok(run(&*blocking(shared, decided).await?))
}

/// Does something with a run that needs no more than its id.
async fn with_run(
    shared: Shared,
    id: &str,
    person: Person,
    work: impl FnOnce(&Arc<Hub>, &RunId, &str) -> Result<Arc<RunView>> + Send + 'static,
) -> Result {
    let id = run_id(id)?;
    Ok(run(&*blocking(shared, move |hub| work(hub, &id, &person.name)).await?))
}

pub(crate) async fn pause(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
) -> Result {
    with_run(shared, &id, person, |hub, id, by| hub.pause(id, by)).await
}

pub(crate) async fn go_on(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
) -> Result {
    with_run(shared, &id, person, |hub, id, by| hub.go_on(id, by)).await
}

pub(crate) async fn resume(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
) -> Result {
    with_run(shared, &id, person, |hub, id, by| hub.resume(id, by)).await
}

/// Stops a run. On a thread of its own, so that it never waits for other work.
pub(crate) async fn stop(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path(id): Path<String>,
) -> Result {
    let id = run_id(&id)?;
    let stopped = at_once(move || shared.hub.stop(&id, &person.name)).await?;
    Ok(run(&stopped))
}

/// Stops all robots.
pub(crate) async fn stop_all(State(shared): State<Shared>, Extension(person): Extension<Person>) -> Result {
    let stopped = at_once(move || shared.hub.stop_all(&person.name)).await?;
    Ok(Reply(json!({"stopped": stopped})).into_response())
}

/// Does work on a thread of its own: those for work that blocks may all be busy.
pub(super) async fn at_once<T: Send + 'static>(work: impl FnOnce() -> Result<T> + Send + 'static) -> Result<T> {
    let (done, result) = tokio::sync::oneshot::channel();
    std::thread::spawn(move || drop(done.send(work())));
    let lost = |_| Problem::new(ProblemKind::Internal, "the stop has no answer");
    result.await.map_err(lost)?
}

pub(crate) async fn audit(State(shared): State<Shared>) -> Result {
    let entries = blocking(shared, |hub| hub.audit().last(AUDIT)).await?;
    Ok(Reply(json!({"entries": entries})).into_response())
}
