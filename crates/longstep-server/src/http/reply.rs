//! Replies, errors and bodies as JSON.

use std::time::Duration;

use axum::body::{Body, HttpBody, to_bytes};
use axum::extract::{FromRequest, Request};
use axum::http::{HeaderValue, StatusCode, header};
use axum::response::{IntoResponse, Response};
use serde::Serialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use crate::problem::{Problem, ProblemKind};

/// The most bytes of a body.
const LARGEST: usize = 4 << 20;

/// The most bytes of a form: a text of 4,000 characters, each of which may take 12 bytes, and some names.
const LARGEST_FORM: usize = 64 << 10;

/// The time in which a body arrives.
const SLOWEST: Duration = Duration::from_secs(30);

/// A reply as JSON.
pub(crate) struct Reply<T>(pub(crate) T);

impl<T: Serialize> IntoResponse for Reply<T> {
    fn into_response(self) -> Response {
        match serde_json::to_vec(&self.0) {
            Ok(bytes) => {
                let kind = (header::CONTENT_TYPE, HeaderValue::from_static("application/json"));
                ([kind], bytes).into_response()
            }
            Err(error) => Problem::new(ProblemKind::Internal, error.to_string()).into_response(),
        }
    }
}

/// Returns the status of a kind of problem.
pub(crate) fn status(kind: ProblemKind) -> StatusCode {
    match kind {
        ProblemKind::Unreadable => StatusCode::BAD_REQUEST,
        ProblemKind::Unknown => StatusCode::UNAUTHORIZED,
        ProblemKind::Forbidden => StatusCode::FORBIDDEN,
        ProblemKind::Missing => StatusCode::NOT_FOUND,
        ProblemKind::Conflict => StatusCode::CONFLICT,
        ProblemKind::TooLarge => StatusCode::PAYLOAD_TOO_LARGE,
        ProblemKind::Busy => StatusCode::SERVICE_UNAVAILABLE,
        ProblemKind::Failed => StatusCode::BAD_GATEWAY,
        ProblemKind::Internal => StatusCode::INTERNAL_SERVER_ERROR,
    }
}

/// Returns a problem as JSON.
pub(crate) fn body_of(problem: &Problem) -> Reply<Value> {
    Reply(json!({"error": problem.to_json()}))
}

impl IntoResponse for Problem {
    fn into_response(self) -> Response {
        let mut response = (status(self.kind), body_of(&self)).into_response();
        if self.kind == ProblemKind::Busy {
            response
                .headers_mut()
                .insert(header::RETRY_AFTER, HeaderValue::from_static("2"));
        }
        response
    }
}

/// A body as JSON. An empty body is an empty object.
pub(crate) struct Asked<T>(pub(crate) T);

impl<S: Sync, T: DeserializeOwned> FromRequest<S> for Asked<T> {
    type Rejection = Problem;

    async fn from_request(request: Request, _: &S) -> Result<Self, Problem> {
        let kind = request
            .headers()
            .get(header::CONTENT_TYPE)
            .and_then(|kind| kind.to_str().ok());
        let is_json = kind.is_some_and(|kind| kind.split(';').next().unwrap_or_default().trim() == "application/json");
        let bytes = body(request.into_body(), LARGEST).await?;
        if bytes.is_empty() {
            return read(b"{}").map(Self);
        }
        if !is_json {
            return Err(Problem::unreadable("the body is not JSON").hint("send `Content-Type: application/json`"));
        }
        read(&bytes).map(Self)
    }
}

/// Returns the body of a form.
///
/// # Errors
///
/// It is of another type, too large, or too slow.
pub(crate) async fn form(request: Request) -> Result<Vec<u8>, Problem> {
    let kind = request.headers().get(header::CONTENT_TYPE);
    let kind = kind.and_then(|kind| kind.to_str().ok()).unwrap_or_default();
    if kind.split(';').next().unwrap_or_default().trim() != "application/x-www-form-urlencoded" {
        return Err(Problem::unreadable("the body is no form").hint("programs use the paths under `/api`"));
    }
    body(request.into_body(), LARGEST_FORM).await
}

async fn body(body: Body, limit: usize) -> Result<Vec<u8>, Problem> {
    let too_large = || {
        Problem::new(ProblemKind::TooLarge, format!("a body may have {} KiB", limit >> 10))
            .hint("send a smaller environment, plan or text")
    };
    if usize::try_from(body.size_hint().lower()).is_ok_and(|length| length > limit) {
        return Err(too_large());
    }
    match tokio::time::timeout(SLOWEST, to_bytes(body, limit)).await {
        Ok(Ok(bytes)) => Ok(bytes.to_vec()),
        Ok(Err(_)) => Err(too_large()),
        Err(_) => Err(Problem::unreadable("the body did not arrive in 30 seconds")),
    }
}

fn read<T: DeserializeOwned>(bytes: &[u8]) -> Result<T, Problem> {
    serde_json::from_slice(bytes).map_err(|error| {
        Problem::unreadable(format!("the body cannot be read: {error}")).hint("`/openapi.json` describes the requests")
    })
}
