//! The router of the server, and the guard before all its paths.

use axum::Router;
use axum::extract::{Request, State};
use axum::http::{HeaderName, HeaderValue, Method, StatusCode, header};
use axum::middleware::{self, Next};
use axum::response::{IntoResponse, Response};
use axum::routing::get;

use super::reply::body_of;
use super::{Shared, api, events, openapi, pages, routes};
use crate::problem::{Problem, ProblemKind};

/// Returns the paths of the server, for [`guard`].
pub(crate) fn routes() -> Router<Shared> {
    let mut router = pages::mount(Router::new())
        .route("/api/events", get(events::events))
        .route("/api/runs/{id}/mcap", get(api::recording))
        .route("/openapi.json", get(openapi::description));
    for route in routes::routes() {
        router = router.route(route.path, route.handler);
    }
    router.fallback(pages::missing).method_not_allowed_fallback(async || {
        let problem = Problem::new(ProblemKind::Missing, "this path does not take this method");
        (StatusCode::METHOD_NOT_ALLOWED, body_of(&problem))
    })
}

/// Puts the guard before all paths.
pub(crate) fn guard(routes: Router<Shared>, shared: Shared) -> Router {
    routes
        .layer(middleware::from_fn_with_state(shared.clone(), guarded))
        .with_state(shared)
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
        Err(problem) => {
            let is_stranger = matches!(problem.kind, ProblemKind::Unknown | ProblemKind::Forbidden);
            let mut response = if wants_page {
                pages::failed(&problem)
            } else {
                problem.into_response()
            };
            if is_stranger {
                // Nobody without the token holds a connection.
                let close = HeaderValue::from_static("close");
                response.headers_mut().insert(header::CONNECTION, close);
            }
            response
        }
    };
    for (name, value) in HEADERS {
        response.headers_mut().insert(name, HeaderValue::from_static(value));
    }
    response
}

async fn admitted(shared: &Shared, mut request: Request, next: Next) -> Result<Response, Problem> {
    shared.access.check_host(request.headers())?;
    if token_of(&request).is_some_and(|token| shared.access.is_token(token)) {
        // The link that the server printed: the browser keeps a cookie, and the address loses the token.
        let cookie = HeaderValue::from_str(&shared.access.set_cookie())
            .map_err(|error| Problem::new(ProblemKind::Internal, error.to_string()))?;
        let to = HeaderValue::from_static("/");
        return Ok((
            StatusCode::SEE_OTHER,
            [(header::SET_COOKIE, cookie), (header::LOCATION, to)],
        )
            .into_response());
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
fn token_of(request: &Request) -> Option<&str> {
    if *request.method() != Method::GET || request.uri().path() != "/" {
        return None;
    }
    let query = request.uri().query()?;
    query.split('&').find_map(|pair| pair.strip_prefix("token="))
}
