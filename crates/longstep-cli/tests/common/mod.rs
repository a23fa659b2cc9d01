//! The shared parts of the tests of the program: a small server that speaks the dialects of OpenAI, Anthropic and Gemini and
//! says what it is told to, and the program with its input and output.
#![allow(dead_code, clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub)]

mod dialect;
pub mod drawer;
pub mod look;
#[cfg(unix)]
pub mod talk;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::sync::atomic::{AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use dialect::Dialect;
use serde_json::{Value, json};

pub const PANTRY: &str = "examples/environments/pantry.json";

/// The reaction of the server to a request for a reply.
#[derive(Debug, Clone)]
pub enum Answer {
    /// The model says this.
    Says(String),
    /// A message with this reason for its end.
    Ends(Value, String),
    /// The server has an error.
    Status(u16, Value),
    /// Nothing comes for so long.
    Silence(Duration),
    /// The connection is closed without a word.
    HangUp,
}

/// A model that wants only this.
pub fn goals(goals: &[&str]) -> Answer {
    Answer::Says(json!({"goal": goals.join(" & "), "left_out": [], "question": ""}).to_string())
}

/// A model that asks back.
pub fn question(question: &str) -> Answer {
    Answer::Says(json!({"goal": "", "left_out": [], "question": question}).to_string())
}

/// A model that changes the steps.
pub fn edits(edits: &[&str]) -> Answer {
    Answer::Says(json!({"question": "", "goal": false, "further": false, "edits": edits}).to_string())
}

/// A model that says that the words are about what is wanted.
pub fn another_goal() -> Answer {
    Answer::Says(json!({"question": "", "goal": true, "further": false, "edits": []}).to_string())
}

/// A server in this process, one thread for each connection.
#[derive(Debug)]
pub struct Server {
    address: String,
    bodies: Arc<Mutex<Vec<Value>>>,
    heads: Arc<Mutex<Vec<String>>>,
    texts: Arc<Mutex<Vec<String>>>,
    others: Arc<AtomicUsize>,
}

impl Server {
    /// Gives these answers one after the other, and is broken after the last.
    pub fn giving(answers: Vec<Answer>) -> Self {
        let broken = || Answer::Status(500, json!({"error": {"message": "nothing is left to say"}}));
        Self::answering(move |number, _| answers.get(number).cloned().unwrap_or_else(broken))
    }

    /// Answers what is asked: `answer` is given how many requests there were before, and the request.
    pub fn answering(answer: impl Fn(usize, &Value) -> Answer + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let server = Self {
            address: format!("http://{}/v1", listener.local_addr().unwrap()),
            bodies: Arc::default(),
            heads: Arc::default(),
            texts: Arc::default(),
            others: Arc::default(),
        };
        let (bodies, others, answer) = (server.bodies.clone(), server.others.clone(), Arc::new(answer));
        let (heads, texts) = (server.heads.clone(), server.texts.clone());
        // It ends with the test's process.
        thread::spawn(move || {
            for stream in listener.incoming() {
                let (bodies, others, answer) = (bodies.clone(), others.clone(), answer.clone());
                let (heads, texts) = (heads.clone(), texts.clone());
                // A client that was killed in the middle is no reason to stop.
                thread::spawn(move || {
                    stream.and_then(|stream| attend(stream, &bodies, &heads, &texts, &others, answer.as_ref()))
                });
            }
        });
        server
    }

    pub fn address(&self) -> &str {
        &self.address
    }

    /// The address without the version of the API, as other dialects have it.
    pub fn base(&self) -> &str {
        self.address.strip_suffix("/v1").unwrap()
    }

    /// The reference for `--model`.
    pub fn reference(&self) -> String {
        format!("{}#recorded", self.address)
    }

    /// The requests for replies so far.
    pub fn bodies(&self) -> Vec<Value> {
        self.bodies.lock().unwrap().clone()
    }

    /// The requests for replies so far, byte by byte.
    pub fn texts(&self) -> Vec<String> {
        self.texts.lock().unwrap().clone()
    }

    /// The request lines and headers of the requests for replies so far.
    pub fn heads(&self) -> Vec<String> {
        self.heads.lock().unwrap().clone()
    }

    /// How often it was asked for something else, as the size of the context.
    pub fn others(&self) -> usize {
        self.others.load(Ordering::SeqCst)
    }
}

fn attend(
    mut stream: TcpStream,
    bodies: &Mutex<Vec<Value>>,
    heads: &Mutex<Vec<String>>,
    texts: &Mutex<Vec<String>>,
    others: &AtomicUsize,
    answer: &(dyn Fn(usize, &Value) -> Answer + Send + Sync),
) -> std::io::Result<()> {
    let mut reader = BufReader::new(stream.try_clone()?);
    let mut method = String::new();
    reader.read_line(&mut method)?;
    let (mut length, mut head) = (0, method.clone());
    loop {
        let mut line = String::new();
        if reader.read_line(&mut line)? == 0 || line == "\r\n" {
            break;
        }
        if let Some(value) = line.to_lowercase().strip_prefix("content-length:") {
            length = value.trim().parse().unwrap();
        }
        head.push_str(&line);
    }
    // What else servers of this kind can be asked, this one does not know.
    let Some(dialect) = Dialect::of(&method) else {
        others.fetch_add(1, Ordering::SeqCst);
        return write!(
            stream,
            "HTTP/1.1 404 X\r\ncontent-length: 0\r\nconnection: close\r\n\r\n"
        );
    };
    let mut body = vec![0; length];
    reader.read_exact(&mut body)?;
    texts.lock().unwrap().push(String::from_utf8(body.clone()).unwrap());
    heads.lock().unwrap().push(head);
    let body: Value = serde_json::from_slice(&body)?;
    // Gemini has it in the path.
    let streams = body["stream"] == json!(true) || dialect == Dialect::Gemini;
    let number = {
        let mut bodies = bodies.lock().unwrap();
        bodies.push(body.clone());
        bodies.len() - 1
    };
    let (status, text) = match answer(number, &body) {
        Answer::Says(content) if streams => (200, dialect.streamed(&completion(&content))),
        Answer::Says(content) => (200, completion(&content).to_string()),
        Answer::Ends(message, finish) => {
            let mut answer = completion("");
            answer["choices"][0]["message"] = message;
            answer["choices"][0]["finish_reason"] = finish.into();
            (
                200,
                if streams {
                    dialect.streamed(&answer)
                } else {
                    answer.to_string()
                },
            )
        }
        Answer::Status(status, error) => (status, error.to_string()),
        Answer::Silence(time) => {
            thread::sleep(time);
            return Ok(());
        }
        Answer::HangUp => return Ok(()),
    };
    // An error may be asked about again at once: tests do not wait.
    write!(
        stream,
        "HTTP/1.1 {status} X\r\ncontent-type: application/json\r\nretry-after: 0\r\ncontent-length: {}\r\n\
         connection: close\r\n\r\n{text}",
        text.len()
    )
}

fn completion(content: &str) -> Value {
    json!({
        "id": "chatcmpl-1", "object": "chat.completion", "created": 0, "model": "recorded",
        "choices": [{"index": 0, "finish_reason": "stop", "message": {"role": "assistant", "content": content}}],
        "usage": {"prompt_tokens": 900, "completion_tokens": 12, "total_tokens": 912},
    })
}

/// An answer in three events and the mark at the end.
fn streamed(answer: &Value) -> String {
    let choice = &answer["choices"][0];
    let event = |choices: Value, usage: &Value| {
        json!({"id": answer["id"], "object": "chat.completion.chunk", "created": 0, "model": answer["model"],
               "choices": choices, "usage": usage})
    };
    let events = [
        event(
            json!([{"index": 0, "delta": choice["message"], "finish_reason": null}]),
            &Value::Null,
        ),
        event(
            json!([{"index": 0, "delta": {}, "finish_reason": choice["finish_reason"]}]),
            &Value::Null,
        ),
        event(json!([]), &answer["usage"]),
    ];
    let events: String = events.iter().map(|event| format!("data: {event}\n\n")).collect();
    events + "data: [DONE]\n\n"
}

pub fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The program at the root of the repository, with a cache and a data folder of its own.
pub fn longstep(home: &Path) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_longstep"));
    command
        .current_dir(root())
        .env("HOME", home)
        .env("XDG_DATA_HOME", home.join("data"))
        .env("XDG_STATE_HOME", home.join("state"))
        .env("LONGSTEP_CACHE", home.join("cache"))
        .env("NO_PROXY", "127.0.0.1")
        .env_remove("LONGSTEP_MODEL")
        .env_remove("LONGSTEP_SERVER")
        .env_remove("LONGSTEP_TOKEN")
        .env_remove("LONGSTEP_DOMAIN")
        .env_remove("LONGSTEP_SESSIONS")
        .env_remove("LONGSTEP_API_KEY")
        .env_remove("OPENAI_API_KEY");
    command
}

/// The result of a run.
#[derive(Debug)]
pub struct Ran {
    pub code: i32,
    pub stdout: String,
    pub stderr: String,
}

/// Runs it with this on its input.
pub fn run(command: &mut Command, input: &str) -> Ran {
    let command = command
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    // It may end without having read everything.
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    let output = child.wait_with_output().unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    Ran {
        code: output.status.code().unwrap_or(-1),
        stdout: text(output.stdout),
        stderr: text(output.stderr),
    }
}

/// A snapshot of several outputs, each below its name.
#[derive(Default)]
pub struct Page(String);

impl Page {
    pub fn add(&mut self, name: &str, text: impl AsRef<str>) {
        self.0 += &format!("== {name}\n\n{}\n\n", text.as_ref().trim_matches('\n'));
    }

    pub fn text(&self) -> &str {
        &self.0
    }
}

/// Runs it with this on its input; stdout and stderr come as one text, as a person sees them.
pub fn seen(command: &mut Command, input: &str) -> String {
    let (mut reader, writer) = std::io::pipe().unwrap();
    command
        .stdin(Stdio::piped())
        .stdout(writer.try_clone().unwrap())
        .stderr(writer);
    let mut child = command.spawn().unwrap();
    let _ = child.stdin.take().unwrap().write_all(input.as_bytes());
    // The ends that are written to would keep the reader waiting.
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut text = String::new();
    reader.read_to_string(&mut text).unwrap();
    let code = child.wait().unwrap().code().unwrap_or(-1);
    format!("{text}--- exit code {code}\n")
}

/// Waits for the end of a program. One that does not end within the limit is killed, and the test fails.
pub fn ended(child: Child, limit: Duration) -> Output {
    let id = child.id();
    let watch = thread::spawn(move || child.wait_with_output().unwrap());
    let begun = Instant::now();
    while !watch.is_finished() {
        if begun.elapsed() > limit {
            let _ = Command::new("kill").args(["-KILL", &id.to_string()]).status();
            panic!("the program did not end");
        }
        thread::sleep(Duration::from_millis(2));
    }
    watch.join().unwrap()
}

/// Checks the log of a run: orders count up from 1 without a gap, and between two orders of the same step at a time when the
/// first is unknown there is an observation or a decision of a person.
pub fn check_log(events: &[Value]) {
    let (mut orders, mut unknown): (u64, Option<String>) = (0, None);
    let mut running: Option<String> = None;
    for event in events {
        match event["event"].as_str().unwrap() {
            "ordered" => {
                orders += 1;
                assert_eq!(event["order"], orders);
                let call = event["call"].as_str().unwrap().to_owned();
                assert_ne!(unknown.as_ref(), Some(&call), "{call} twice without a look");
                running = Some(call);
            }
            "performed" | "failed" => running = None,
            "interrupted" => unknown = running.take(),
            "observed" | "judged" => unknown = None,
            _ => {}
        }
    }
}
