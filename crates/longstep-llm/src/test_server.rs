//! A server for tests: it sends prepared responses, one a connection, and records the requests.

use std::io::{Read, Write};
use std::net::TcpListener;
use std::sync::{Arc, Mutex};

/// A server on a port of its own.
pub(crate) struct TestServer {
    /// `http://127.0.0.1:PORT`
    pub(crate) url: String,
    requests: Arc<Mutex<Vec<String>>>,
}

impl TestServer {
    /// Sends these raw HTTP responses in order; refuses further connections.
    pub(crate) fn new(answers: Vec<Vec<u8>>) -> Self {
        Self::answering(answers.len(), move |number, _| answers[number].clone())
    }

    /// Sends `count` responses, made from the number (from 0) and the text of each request.
    pub(crate) fn answering(count: usize, answer: impl Fn(usize, &str) -> Vec<u8> + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let requests = Arc::new(Mutex::new(Vec::new()));
        let noted = Arc::clone(&requests);
        std::thread::spawn(move || {
            for number in 0..count {
                let (mut stream, _) = listener.accept().unwrap();
                let mut text = Vec::new();
                let mut buffer = [0; 4096];
                while !whole(&text) {
                    let read = stream.read(&mut buffer).unwrap();
                    assert!(read > 0, "the request ended early");
                    text.extend_from_slice(&buffer[..read]);
                }
                let text = String::from_utf8(text).unwrap();
                let answer = answer(number, &text);
                noted.lock().unwrap().push(text);
                // The client may have hung up already.
                let _ = stream.write_all(&answer);
            }
        });
        Self { url, requests }
    }

    /// A server that runs elsewhere.
    pub(crate) fn at(url: String) -> Self {
        Self {
            url,
            requests: Arc::default(),
        }
    }

    /// The requests so far: head and body of each.
    pub(crate) fn requests(&self) -> Vec<String> {
        self.requests.lock().unwrap().clone()
    }
}

fn whole(request: &[u8]) -> bool {
    let text = String::from_utf8_lossy(request);
    let Some((head, body)) = text.split_once("\r\n\r\n") else {
        return false;
    };
    let head = head.to_lowercase();
    let length = head
        .split("content-length: ")
        .nth(1)
        .and_then(|rest| rest.lines().next());
    body.len() >= length.map_or(0, |length| length.parse().unwrap())
}

/// A response with this status line, additional header lines and body.
pub(crate) fn answer(status: &str, headers: &[&str], body: &[u8]) -> Vec<u8> {
    announced(status, headers, body.len(), body)
}

/// A response that announces `length` bytes, whatever the length of its body.
pub(crate) fn announced(status: &str, headers: &[&str], length: usize, body: &[u8]) -> Vec<u8> {
    let mut head = format!("HTTP/1.1 {status}\r\nconnection: close\r\ncontent-length: {length}\r\n");
    for header in headers {
        head += header;
        head += "\r\n";
    }
    head += "\r\n";
    [head.as_bytes(), body].concat()
}
