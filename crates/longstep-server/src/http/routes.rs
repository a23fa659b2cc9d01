//! The paths of the server. One table, from which the router and the description are made.

use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::{MethodRouter, get, post};

use super::reply::Reply;
use super::{Shared, api, events, openapi, pages};
use crate::problem::{Problem, ProblemKind};

/// A path of the server.
pub(crate) struct Route {
    /// `get` or `post`.
    pub(crate) method: &'static str,
    pub(crate) path: &'static str,
    /// The name of the operation for generated clients.
    pub(crate) name: &'static str,
    pub(crate) summary: &'static str,
    /// The name of the schema of the body; none for a request without one.
    pub(crate) body: Option<&'static str>,
    /// The status, and the name of the schema, of the answer.
    pub(crate) answer: (u16, &'static str),
    handler: MethodRouter<Shared>,
}

macro_rules! routes {
    ($($method:ident $path:literal $name:ident ($body:expr) -> $status:literal $answer:literal : $summary:literal = $handler:expr;)*) => {
        vec![$(Route {
            method: stringify!($method),
            path: $path,
            name: stringify!($name),
            summary: $summary,
            body: $body,
            answer: ($status, $answer),
            handler: $method($handler),
        },)*]
    };
}

/// Returns the paths for programs.
pub(crate) fn routes() -> Vec<Route> {
    routes! {
        get "/api/server" server (None) -> 200 "Server": "The model, domains, scenes and robots" = api::server;
        get "/api/sessions" list_sessions (None) -> 200 "SessionList": "All sessions" = api::sessions;
        post "/api/sessions" create_session (Some("Place")) -> 201 "Session": "Begin a session in a world" = api::create;
        get "/api/sessions/{id}" get_session (None) -> 200 "Session": "A session as it is now" = api::one_session;
        get "/api/sessions/{id}/world" get_world (None) -> 200 "Environment": "The world before the next instruction" = api::world;
        post "/api/sessions/{id}/instruct" instruct (Some("Words")) -> 200 "Session": "Give an instruction; waits for the person's turn, unless `Prefer: respond-async` is sent" = api::instruct;
        post "/api/sessions/{id}/answer" answer (Some("Words")) -> 200 "Session": "Answer the question" = api::answer;
        post "/api/sessions/{id}/feedback" feedback (Some("Words")) -> 200 "Session": "Say what is to be different" = api::feedback;
        post "/api/sessions/{id}/cancel" cancel (None) -> 200 "Session": "Cancel the instruction, or the work of the model" = api::cancel;
        post "/api/sessions/{id}/accept" accept (Some("Hash")) -> 200 "Session": "Accept the plan with this hash; nothing moves" = api::accept;
        post "/api/sessions/{id}/undo" undo (None) -> 200 "Session": "Revert the last accepted plan" = api::undo;
        post "/api/sessions/{id}/ended" ended (Some("Ending")) -> 200 "Session": "Say which ending the last plan had" = api::ended;
        post "/api/sessions/{id}/observed" observed (Some("Observation")) -> 200 "Session": "Report what the world is like" = api::observed;
        post "/api/sessions/{id}/approve" approve (Some("Approve")) -> 201 "Approval": "Approve the next accepted plan for a robot, once" = api::approve;
        post "/api/plan" plan (Some("Instruction")) -> 200 "Answer": "A plan for one instruction, in a session that is not kept" = api::plan;
        post "/api/verify" verify (Some("WrittenPlan")) -> 200 "Answer": "Verify a plan" = api::verify;
        post "/api/repair" repair (Some("WrittenPlan")) -> 200 "Answer": "Repair a plan with the cheapest edits" = api::repair;
        post "/api/solve" solve (Some("GoalRequest")) -> 200 "Answer": "Find a plan for a goal" = api::solve;
        get "/api/runs" list_runs (None) -> 200 "RunList": "All runs" = api::runs;
        post "/api/runs" start_run (Some("Start")) -> 201 "Run": "Begin a run with an approval" = api::start;
        get "/api/runs/{id}" get_run (None) -> 200 "Run": "A run as it is now" = api::one_run;
        post "/api/runs/{id}/decide" decide (Some("Decision")) -> 200 "Run": "Answer the question of a run" = api::decide;
        post "/api/runs/{id}/pause" pause_run (None) -> 200 "Run": "Pause after the steps that are under way" = api::pause;
        post "/api/runs/{id}/continue" continue_run (None) -> 200 "Run": "Go on from the observed world" = api::go_on;
        post "/api/runs/{id}/resume" resume_run (None) -> 200 "Run": "Take up a run that was interrupted" = api::resume;
        post "/api/runs/{id}/stop" stop_run (None) -> 200 "Run": "Stop the robot, then the run" = api::stop;
        post "/api/stop" stop_all (None) -> 200 "Stopped": "Stop all robots" = api::stop_all;
        get "/api/audit" get_audit (None) -> 200 "Audit": "Who approved, started and stopped what, the newest first" = api::audit;
    }
}

/// Returns the router of the server.
pub(crate) fn router(shared: Shared) -> Router {
    let mut router = pages::mount(Router::new())
        .route("/api/events", get(events::events))
        .route("/openapi.json", get(openapi::description));
    for route in routes() {
        router = router.route(route.path, route.handler);
    }
    router
        .fallback(pages::missing)
        .method_not_allowed_fallback(async || {
            let problem = Problem::new(ProblemKind::Missing, "this path does not take this method");
            (axum::http::StatusCode::METHOD_NOT_ALLOWED, problem_body(&problem))
        })
        .layer(middleware::from_fn_with_state(shared.clone(), guarded))
        .with_state(shared)
}

fn problem_body(problem: &Problem) -> Reply<serde_json::Value> {
    Reply(serde_json::json!({"error": {"kind": problem.kind.name(), "message": problem.message, "hint": problem.hint}}))
}

/// The headers of every answer: nothing is loaded from elsewhere, nothing is kept, no other page may read it.
const HEADERS: [(HeaderName, &str); 6] = [
    (
        header::CONTENT_SECURITY_POLICY,
        "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; \
         form-action 'self'; frame-ancestors 'none'; base-uri 'none'",
    ),
    (header::X_CONTENT_TYPE_OPTIONS, "nosniff"),
    // With `no-referrer` a browser hides the origin of a form, which a change must say.
    (header::REFERRER_POLICY, "same-origin"),
    (header::CACHE_CONTROL, "no-store"),
    (HeaderName::from_static("cross-origin-opener-policy"), "same-origin"),
    (HeaderName::from_static("cross-origin-resource-policy"), "same-origin"),
];

/// Lets a request through that may be: of someone with the token, by a known name of the host, not too many at a time.
async fn guarded(State(shared): State<Shared>, request: Request, next: Next) -> Response {
    let wants_page = pages::wants_page(&request);
    let mut response = match admitted(&shared, request, next).await {
        Ok(response) => response,
        Err(problem) if wants_page => pages::failed(&problem),
        Err(problem) => problem.into_response(),
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn admitted(shared: &Shared, mut request: Request, next: Next) -> Result<Response, Problem> {
    shared.access.check_host(request.headers())?;
    if let Some(token) = token_of(&request).filter(|token| shared.access.is_token(token)) {
        // The link that the server printed: the browser keeps a cookie, and the address loses the token.
        drop(token);
        let cookie = HeaderValue::from_str(&shared.access.set_cookie())
            .map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?;
        let to = HeaderValue::from_static("/");
        let status = axum::http::StatusCode::SEE_OTHER;
        return Ok((status, [(header::SET_COOKIE, cookie), (header::LOCATION, to)]).into_response());
    }
    if !pages::is_asset(&request) {
        let person = shared.access.person(request.method(), request.headers())?;
        request.extensions_mut().insert(person);
    }
    let path = request.uri().path();
    // A stop is never held up, and a reader of events is counted apart.
    let is_free = path.ends_with("/stop") || path == "/api/events";
    if is_free {
        return Ok(next.run(request).await);
    }
    let _permit = shared.requests.try_acquire().map_err(|_| {
        Problem::new(ProblemKind::Busy, "too many requests at a time").hint("try again in some seconds")
    })?;
    Ok(next.run(request).await)
}

/// Returns the token in the address of a page.
fn token_of(request: &Request) -> Option<String> {
    if *request.method() != Method::GET || request.uri().path() != "/" {
        return None;
    }
    let query = request.uri().query()?;
    query
        .split('&')
        .find_map(|pair| pair.strip_prefix("token="))
        .map(str::to_owned)
}
