//! Progress, cancelled calls and silent servers.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::time::{Duration, Instant};

use super::*;

#[test]
fn chat_reports_progress_while_the_answer_streams() {
    let server = TestServer::new(vec![success()]);
    let mut reports = Vec::new();
    let reply = model(&server, Kind::OpenAi).chat(&request(), &mut |progress: Progress| reports.push(progress));
    assert!(reply.is_ok());
    assert_eq!(
        reports,
        [
            Progress::Waiting,
            Progress::Writing { tokens: 1 },
            Progress::Writing { tokens: 2 }
        ]
    );
}

/// Cancels the call after a while.
struct Impatient(Instant);

impl Watch for Impatient {
    fn tell(&mut self, _: Progress) {}

    fn stop(&self) -> bool {
        self.0.elapsed() > Duration::from_millis(150)
    }
}

/// A server that sends this and then nothing, and keeps the connection open.
fn stuck(beginning: &'static [u8]) -> TestServer {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let url = format!("http://{}", listener.local_addr().unwrap());
    std::thread::spawn(move || {
        let (mut stream, _) = listener.accept().unwrap();
        let mut buffer = [0; 4096];
        let _ = stream.read(&mut buffer).unwrap();
        stream.write_all(beginning).unwrap();
        // Until the client hangs up.
        while stream.read(&mut buffer).is_ok_and(|read| read > 0) {}
    });
    TestServer::at(url)
}

const HALF: &[u8] = b"HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\n\r\n\
    data: {\"choices\": [{\"delta\": {\"content\": \"{\"}}]}\n\n";

#[test]
fn chat_ends_when_the_caller_stops_it() {
    let busy = answer("503 Service Unavailable", &["retry-after: 30"], b"");
    for server in [stuck(b""), stuck(HALF), TestServer::new(vec![busy])] {
        let mut watch = Impatient(Instant::now());
        let error = model(&server, Kind::OpenAi).chat(&request(), &mut watch).unwrap_err();
        assert!(matches!(error, ModelError::Stopped), "{error}");
    }
}

#[test]
fn a_server_that_falls_silent_is_not_waited_for() {
    let options = OpenOptions {
        silence: Duration::from_millis(100),
        ..options()
    };
    for server in [stuck(b""), stuck(HALF)] {
        let error = model_with(&server, Kind::OpenAi, &options).chat(&request(), &mut quiet);
        let error = error.unwrap_err();
        assert!(matches!(error, ModelError::Silent { .. }), "{error}");
        assert!(error.to_string().ends_with("sent nothing for 0.1 s"), "{error}");
    }
}
