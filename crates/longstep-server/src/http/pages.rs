//! The page over HTTP: sheets, fragments, and forms.

use std::sync::Arc;

use axum::Router;
use axum::extract::{Extension, Path, RawQuery, Request, State};
use axum::http::{HeaderMap, HeaderValue, Method, StatusCode, header};
use axum::response::{IntoResponse, Response};
use axum::routing::{get, post};

use super::Shared;
use super::access::Person;
use super::api::{at_once, blocking, run_id, session_id};
use super::reply::{form, status};
use crate::hub::Hub;
use crate::page::{self, Attempt, Fields, Look, Next, RunDeed, SessionDeed, Sheet};
use crate::problem::{Problem, ProblemKind};

/// Adds the paths of the page.
pub(super) fn mount(router: Router<Shared>) -> Router<Shared> {
    router
        .route("/", get(start))
        .route("/audit", get(audit))
        .route("/sessions", post(begin).get(async || see_other("/")))
        .route("/sessions/{id}", get(session))
        .route("/sessions/{id}/fragment", get(session_fragment))
        .route("/sessions/{id}/{deed}", post(session_deed).get(back_to_session))
        .route("/runs/{id}", get(run))
        .route("/runs/{id}/fragment", get(run_fragment))
        .route("/runs/{id}/stop", post(stop).get(back_to_run))
        .route("/runs/{id}/{deed}", post(run_deed).get(back_to_run))
        .route("/fragment", get(start_fragment))
        .route("/audit/fragment", get(audit_fragment))
        .route("/stop", post(stop_all).get(async || see_other("/")))
        .route("/page/page.js", get(async || asset("text/javascript", page::SCRIPT)))
        .route("/page/page.css", get(async || asset("text/css", page::style())))
        .route("/page/icon.svg", get(async || asset("image/svg+xml", page::ICON)))
}

/// Returns true if a request comes from someone who reads pages.
pub(super) fn wants_page(request: &Request) -> bool {
    let accepted = request.headers().get(header::ACCEPT);
    let accepts = accepted.is_some_and(|kinds| kinds.to_str().is_ok_and(|kinds| kinds.contains("text/html")));
    accepts && !request.uri().path().starts_with("/api/")
}

/// Returns true for the script, the style and the icon, which have no secrets: the page for strangers shows them.
pub(super) fn is_asset(request: &Request) -> bool {
    request.method() == Method::GET && request.uri().path().starts_with("/page/")
}

/// Writes a problem as a page.
pub(super) fn failed(problem: &Problem) -> Response {
    let html = match problem.kind {
        ProblemKind::Unknown => page::stranger(),
        _ => page::failed(problem).html(),
    };
    (status(problem.kind), document(html)).into_response()
}

fn document(html: String) -> Response {
    let kind = HeaderValue::from_static("text/html; charset=utf-8");
    ([(header::CONTENT_TYPE, kind)], html).into_response()
}

fn asset(kind: &'static str, text: impl Into<axum::body::Body>) -> Response {
    ([(header::CONTENT_TYPE, HeaderValue::from_static(kind))], text.into()).into_response()
}

fn see_other(path: &str) -> Response {
    match HeaderValue::from_str(path) {
        Ok(path) => (StatusCode::SEE_OTHER, [(header::LOCATION, path)]).into_response(),
        Err(error) => failed(&Problem::new(ProblemKind::Internal, error.to_string())),
    }
}

/// Makes a sheet where work may wait for the disk, and writes it with `write`.
async fn sheet(
    shared: Shared,
    write: fn(&Sheet) -> String,
    make: impl FnOnce(&Arc<Hub>) -> Result<Sheet, Problem> + Send + 'static,
) -> Response {
    match blocking(shared, move |hub| make(hub).map(|sheet| write(&sheet))).await {
        Ok(html) => document(html),
        Err(problem) => failed(&problem),
    }
}

async fn start(State(shared): State<Shared>) -> Response {
    sheet(shared, Sheet::html, |hub| page::start(hub, None)).await
}

async fn start_fragment(State(shared): State<Shared>) -> Response {
    sheet(shared, Sheet::fragment, |hub| page::start(hub, None)).await
}

async fn audit(State(shared): State<Shared>) -> Response {
    sheet(shared, Sheet::html, |hub| page::audit(hub)).await
}

async fn audit_fragment(State(shared): State<Shared>) -> Response {
    sheet(shared, Sheet::fragment, |hub| page::audit(hub)).await
}

async fn show_session(shared: Shared, id: String, query: Option<String>, write: fn(&Sheet) -> String) -> Response {
    let look = Look::read(&query.unwrap_or_default());
    sheet(shared, write, move |hub| {
        page::session(hub, &session_id(&id)?, &look, None)
    })
    .await
}

async fn session(State(shared): State<Shared>, Path(id): Path<String>, RawQuery(query): RawQuery) -> Response {
    show_session(shared, id, query, Sheet::html).await
}

async fn session_fragment(State(shared): State<Shared>, Path(id): Path<String>, RawQuery(query): RawQuery) -> Response {
    show_session(shared, id, query, Sheet::fragment).await
}

async fn show_run(shared: Shared, id: String, query: Option<String>, write: fn(&Sheet) -> String) -> Response {
    let stop_was_sent = query.is_some_and(|query| query == "stop=sent");
    sheet(shared, write, move |hub| {
        page::run(hub, &run_id(&id)?, stop_was_sent, None)
    })
    .await
}

async fn run(State(shared): State<Shared>, Path(id): Path<String>, RawQuery(query): RawQuery) -> Response {
    show_run(shared, id, query, Sheet::html).await
}

async fn run_fragment(State(shared): State<Shared>, Path(id): Path<String>, RawQuery(query): RawQuery) -> Response {
    show_run(shared, id, query, Sheet::fragment).await
}

/// A form that was sent is loaded again: the page of its object.
async fn back_to_session(Path((id, _)): Path<(String, String)>) -> Response {
    match session_id(&id) {
        Ok(id) => see_other(&format!("/sessions/{id}")),
        Err(problem) => failed(&problem),
    }
}

async fn back_to_run(Path(parameters): Path<Vec<(String, String)>>) -> Response {
    match run_id(parameters.first().map_or("", |(_, id)| id)) {
        Ok(id) => see_other(&format!("/runs/{id}")),
        Err(problem) => failed(&problem),
    }
}

/// The result of a form: where to go, or the page again with the reason.
type Done = Result<Next, (Problem, Sheet)>;

async fn done(shared: Shared, work: impl FnOnce(&Arc<Hub>) -> Result<Done, Problem> + Send + 'static) -> Response {
    match blocking(shared, work).await {
        Ok(Ok(next)) => see_other(&next.path()),
        Ok(Err((problem, sheet))) => (status(problem.kind), document(sheet.html())).into_response(),
        Err(problem) => failed(&problem),
    }
}

async fn begin(State(shared): State<Shared>, request: Request) -> Response {
    let fields = match fields(request).await {
        Ok(fields) => fields,
        Err(problem) => return failed(&problem),
    };
    done(shared, move |hub| {
        let begun = page::begin_session(hub, &fields);
        again(begun, "begin", &fields, |attempt| page::start(hub, Some(attempt)))
    })
    .await
}

/// Makes the page for a form that failed: with the text that the person wrote, and the reason beside the form.
fn again(
    done: Result<Next, Problem>,
    form: &'static str,
    fields: &Fields,
    show: impl FnOnce(&Attempt) -> Result<Sheet, Problem>,
) -> Result<Done, Problem> {
    let problem = match done {
        Ok(next) => return Ok(Ok(next)),
        Err(problem) => problem,
    };
    let attempt = Attempt::new(form, fields, problem.clone());
    // A page that cannot be shown either has the first reason.
    match show(&attempt) {
        Ok(sheet) => Ok(Err((problem, sheet))),
        Err(_) => Err(problem),
    }
}

async fn fields(request: Request) -> Result<Fields, Problem> {
    Ok(Fields::read(&form(request).await?))
}

async fn session_deed(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path((id, deed)): Path<(String, String)>,
    RawQuery(query): RawQuery,
    request: Request,
) -> Response {
    let named = SessionDeed::named(&deed).ok_or_else(|| Problem::missing("form", longstep_core::visible::line(&deed)));
    let (id, deed, fields) = match (session_id(&id), named, fields(request).await) {
        (Ok(id), Ok(deed), Ok(fields)) => (id, deed, fields),
        (Err(problem), ..) | (_, Err(problem), _) | (.., Err(problem)) => return failed(&problem),
    };
    let look = Look::read(&query.unwrap_or_default());
    done(shared, move |hub| {
        let acted = page::act_on_session(hub, &id, deed, &fields, &person.name);
        again(acted, deed.name(), &fields, |attempt| {
            page::session(hub, &id, &look, Some(attempt))
        })
    })
    .await
}

async fn run_deed(
    State(shared): State<Shared>,
    Extension(person): Extension<Person>,
    Path((id, deed)): Path<(String, String)>,
    request: Request,
) -> Response {
    let named = RunDeed::named(&deed).ok_or_else(|| Problem::missing("form", longstep_core::visible::line(&deed)));
    let (id, deed, fields) = match (run_id(&id), named, fields(request).await) {
        (Ok(id), Ok(deed), Ok(fields)) => (id, deed, fields),
        (Err(problem), ..) | (_, Err(problem), _) | (.., Err(problem)) => return failed(&problem),
    };
    done(shared, move |hub| {
        let acted = page::act_on_run(hub, &id, deed, &fields, &person.name);
        again(acted, deed.name(), &fields, |attempt| {
            page::run(hub, &id, false, Some(attempt))
        })
    })
    .await
}

/// Stops a run, for a browser without the script. The body is not read: nothing is waited for.
async fn stop(State(shared): State<Shared>, Extension(person): Extension<Person>, Path(id): Path<String>) -> Response {
    let stopped = match run_id(&id) {
        Ok(id) => at_once(move || shared.hub.stop(&id, &person.name)).await,
        Err(problem) => Err(problem),
    };
    match stopped {
        Ok(run) => see_other(&format!("/runs/{}?stop=sent", run.record.id)),
        Err(problem) => failed(&problem),
    }
}

async fn stop_all(State(shared): State<Shared>, Extension(person): Extension<Person>) -> Response {
    match at_once(move || shared.hub.stop_all(&person.name)).await {
        Ok(_) => see_other("/"),
        Err(problem) => failed(&problem),
    }
}

/// Answers a path that there is not.
pub(super) async fn missing(headers: HeaderMap) -> Response {
    let problem = Problem::new(ProblemKind::Missing, "there is nothing at this path");
    let accepts = headers.get(header::ACCEPT).and_then(|kinds| kinds.to_str().ok());
    if accepts.is_some_and(|kinds| kinds.contains("text/html")) {
        failed(&problem)
    } else {
        problem.into_response()
    }
}
