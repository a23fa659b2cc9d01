//! Errors of servers, and further attempts.

use super::*;

#[test]
fn a_key_is_never_shown() {
    let (outcome, _, _) = ask(vec![rejected(
        "401 Unauthorized",
        &format!("Incorrect API key\nprovided: {KEY}."),
    )]);
    let error = outcome.unwrap_err();
    let shown = format!("{error} {error:?} {:?}", error.hint());
    assert!(!shown.contains(KEY) && shown.contains("[key]"), "{shown}");
    assert!(!error.to_string().contains('\n') && error.hint().unwrap().contains("OPENAI_API_KEY"));
    let server = TestServer::new(vec![]);
    let model = model(&server, Kind::OpenAi);
    assert!(!format!("{model:?}").contains(KEY));
}

#[test]
fn errors_are_short_and_have_hints() {
    let html = answer(
        "403 Forbidden",
        &[],
        format!("<html>\n{}", "x ".repeat(5000)).as_bytes(),
    );
    let error = ask(vec![html]).0.unwrap_err();
    assert!(error.to_string().len() < 420, "{error}");
    assert!(error.hint().unwrap().contains("may not"));
    let error = ask(vec![rejected("404 Not Found", "The model `m` does not exist")])
        .0
        .unwrap_err();
    assert!(
        error.to_string().ends_with("status 404: The model `m` does not exist"),
        "{error}"
    );
    assert!(error.hint().unwrap().contains("/v1"));
    // A 400 about something that cannot be omitted.
    let error = ask(vec![rejected("400 Bad Request", "context length exceeded")])
        .0
        .unwrap_err();
    assert!(matches!(error, ModelError::Status { status: 400, .. }), "{error}");
}

#[test]
fn a_busy_server_is_asked_again_when_it_says() {
    let busy = answer("429 Too Many Requests", &["retry-after: 0.05"], b"{}");
    let (outcome, warnings, requests) = ask(vec![busy.clone(), success()]);
    assert!(outcome.is_ok());
    assert_eq!(requests.len(), 2);
    assert!(
        warnings[0].contains("429") && warnings[0].contains("again"),
        "{warnings:?}"
    );
    // Three attempts are the limit.
    let (outcome, _, requests) = ask(vec![busy.clone(), busy.clone(), busy, success()]);
    assert!(matches!(outcome, Err(ModelError::Status { status: 429, .. })));
    assert_eq!(requests.len(), 3);
    // A wait of an hour is too long.
    let (outcome, _, requests) = ask(vec![answer("429 Too Many Requests", &["retry-after: 3600"], b"{}")]);
    assert!(outcome.unwrap_err().hint().unwrap().contains("wait"));
    assert_eq!(requests.len(), 1);
    // A server error, and a connection that is closed without a response.
    let trouble = answer("502 Bad Gateway", &["retry-after: 0"], b"oops");
    assert!(ask(vec![trouble, success()]).0.is_ok());
    assert!(ask(vec![vec![], success()]).0.is_ok());
}

#[test]
fn a_server_that_is_not_there_is_an_error() {
    let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    drop(listener);
    let endpoint = Endpoint::new(Kind::Other, &format!("http://user:word@{address}/v1"), "m", None);
    let mut model = ServerModel::new(endpoint, &options()).unwrap();
    let mut warnings = 0;
    let error = model
        .chat(&request(), &mut |progress: Progress| {
            warnings += usize::from(matches!(progress, Progress::Warning(_)))
        })
        .unwrap_err();
    assert!(matches!(error, ModelError::Unreachable { .. }), "{error:?}");
    assert!(
        error
            .to_string()
            .starts_with(&format!("http://{address}/v1 cannot be reached")),
        "{error}"
    );
    assert_eq!(warnings, 2);
    assert!(!error.to_string().contains("word"), "{error}");
}

#[test]
fn a_redirect_does_not_take_the_key_along() {
    let other = TestServer::new(vec![success()]);
    let redirect = answer(
        "307 Temporary Redirect",
        &[&format!("location: {}/v1/chat/completions", other.url)],
        b"",
    );
    let error = ask(vec![redirect]).0.unwrap_err();
    assert!(matches!(error, ModelError::Status { status: 307, .. }), "{error}");
    assert!(other.requests().is_empty());
}
