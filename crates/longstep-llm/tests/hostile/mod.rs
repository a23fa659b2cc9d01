//! A hostile server: one table of ways to answer, each with the outcome that a call and the program must come to.
//!
//! It listens on the loopback, and every connection ends when the other side hangs up or after two minutes.
#![allow(dead_code, clippy::unwrap_used, clippy::panic, missing_docs, unreachable_pub)]

use std::io::{Read, Result, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

/// The longest life of a connection. No test waits for it: it is there so that nothing is left behind.
const LIFE: Duration = Duration::from_secs(120);

/// The request that is answered with hostility. All others are answered as a small server would.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Place {
    Chat,
    Context,
    Tokens,
}

/// The limit that is made short for a mode, so that it is reached soon. The others are as they are for everybody.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Short {
    Nothing,
    /// `--timeout 1`
    Timeout,
    /// `--silence 0.5`
    Silence,
}

/// The outcome of a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Outcome {
    /// The reply is good, or not: then the program says so.
    Reply,
    /// The reply is cut off at our own limit of its length.
    CutOff,
    Silent,
    TimedOut,
    TooLarge,
    Bad,
    Unreachable,
    Status(u16),
}

/// One way to be hostile.
pub struct Mode {
    pub name: &'static str,
    pub place: Place,
    pub short: Short,
    pub outcome: Outcome,
    /// The exit code of `longstep plan`.
    pub code: i32,
    play: fn(&mut TcpStream) -> Result<()>,
}

const GOOD: &str = r#"{"question": "", "goals": ["put(cereal, counter)"]}"#;

const STREAM: &str = "HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\nconnection: close\r\n\r\n";
const CHUNKED: &str = "HTTP/1.1 200 OK\r\ncontent-type: text/event-stream\r\ntransfer-encoding: chunked\r\n\r\n";
const JSON: &str = "HTTP/1.1 200 OK\r\ncontent-type: application/json\r\nconnection: close\r\n\r\n";

/// Writes the beginning once and the rest for ever.
fn endless(stream: &mut TcpStream, begin: &str, rest: &str) -> Result<()> {
    stream.write_all(begin.as_bytes())?;
    let block = rest.repeat((64 << 10) / rest.len() + 1);
    let began = Instant::now();
    while began.elapsed() < LIFE {
        stream.write_all(block.as_bytes())?;
    }
    Ok(())
}

/// Writes the beginning, and a little more every 20 ms.
fn dripping(stream: &mut TcpStream, begin: &str, drop: &str) -> Result<()> {
    stream.write_all(begin.as_bytes())?;
    let began = Instant::now();
    while began.elapsed() < LIFE {
        stream.write_all(drop.as_bytes())?;
        thread::sleep(Duration::from_millis(20));
    }
    Ok(())
}

/// Writes this and then nothing, and keeps the line.
fn stuck(stream: &mut TcpStream, begin: &str) -> Result<()> {
    stream.write_all(begin.as_bytes())?;
    stream.set_read_timeout(Some(LIFE))?;
    // Until the other side hangs up.
    let mut buffer = [0; 1024];
    while stream.read(&mut buffer)? > 0 {}
    Ok(())
}

fn all(stream: &mut TcpStream, text: &str) -> Result<()> {
    stream.write_all(text.as_bytes())
}

fn event(delta: &str) -> String {
    format!("data: {{\"choices\": [{{\"index\": 0, \"delta\": {delta}, \"finish_reason\": null}}]}}\n\n")
}

fn says(text: &str) -> String {
    event(&format!("{{\"content\": {}}}", serde_json::Value::from(text)))
}

/// A good answer, with this as its usage.
fn good(usage: &str) -> String {
    format!(
        "{STREAM}{}data: {{\"choices\": [{{\"delta\": {{}}, \"finish_reason\": \"stop\"}}]}}\n\n\
         data: {{\"choices\": [], \"usage\": {usage}}}\n\ndata: [DONE]\n\n",
        says(GOOD)
    )
}

fn chat(name: &'static str, outcome: Outcome, code: i32, play: fn(&mut TcpStream) -> Result<()>) -> Mode {
    let short = match outcome {
        Outcome::TimedOut => Short::Timeout,
        Outcome::Silent => Short::Silence,
        _ => Short::Nothing,
    };
    Mode {
        name,
        place: Place::Chat,
        short,
        outcome,
        code,
        play,
    }
}

/// A mode in which only a question beside the chat is answered badly: the chat goes on without that answer.
fn beside(name: &'static str, place: Place, play: fn(&mut TcpStream) -> Result<()>) -> Mode {
    Mode {
        name,
        place,
        short: Short::Nothing,
        outcome: Outcome::Reply,
        code: 0,
        play,
    }
}

/// All modes.
pub fn modes() -> Vec<Mode> {
    use Outcome::{Bad, CutOff, Reply, Silent, Status, TimedOut, TooLarge, Unreachable};
    vec![
        // Bodies of errors.
        chat("error without end", Status(400), 40, |s| {
            endless(s, "HTTP/1.1 400 Bad\r\nconnection: close\r\n\r\n", "no ")
        }),
        chat("busy, and an error without end", Status(503), 40, |s| {
            endless(s, "HTTP/1.1 503 Busy\r\nretry-after: 0\r\n\r\n", "no ")
        }),
        Mode {
            short: Short::Timeout,
            ..chat("error that drips", Status(400), 40, |s| {
                dripping(s, "HTTP/1.1 400 Bad\r\nconnection: close\r\n\r\n", "x")
            })
        },
        chat("error nested a million deep", Status(400), 40, |s| {
            let body = "[".repeat(1_000_000);
            all(s, &format!("HTTP/1.1 400 Bad\r\ncontent-length: 1000000\r\n\r\n{body}"))
        }),
        // Answers without an end.
        chat("text without end", CutOff, 20, |s| endless(s, STREAM, &says("word "))),
        chat("blanks without end", CutOff, 20, |s| {
            endless(s, STREAM, &says("          "))
        }),
        chat("a text far beyond the limit at once", CutOff, 20, |s| {
            all(s, &format!("{STREAM}{}", says(&"x".repeat(900_000))))
        }),
        chat("reasoning without end", CutOff, 20, |s| {
            endless(s, STREAM, &event(r#"{"reasoning_content": "and then "}"#))
        }),
        chat("calls to tools without end", CutOff, 20, |s| {
            endless(
                s,
                STREAM,
                &event(r#"{"tool_calls": [{"index": 0, "function": {"arguments": "xxxxxxxx"}}]}"#),
            )
        }),
        chat("a line without end", TooLarge, 20, |s| endless(s, STREAM, "data: ")),
        chat("JSON with blanks without end", TooLarge, 20, |s| {
            endless(s, &format!("{STREAM}data: {{\"choices\": "), "        ")
        }),
        chat("an event without end", TooLarge, 20, |s| {
            endless(s, STREAM, "data: xxxxxxxx\n")
        }),
        chat("comments without end", TooLarge, 20, |s| {
            endless(s, STREAM, ": keep-alive\n\n")
        }),
        chat("empty lines without end", TooLarge, 20, |s| endless(s, STREAM, "\n")),
        chat("tiny events without end", TooLarge, 20, |s| {
            endless(s, STREAM, "data: {}\n\n")
        }),
        chat("large events without end", TooLarge, 20, |s| {
            endless(s, STREAM, &format!("data: {{\"x\": \"{}\"}}\n\n", "y".repeat(100_000)))
        }),
        chat("events of numbers without end", TooLarge, 20, |s| {
            endless(s, STREAM, &format!("data: [{}0]\n\n", "0,".repeat(400_000)))
        }),
        // Answers that drip.
        chat("a piece every 20 ms for ever", TimedOut, 20, |s| {
            dripping(s, STREAM, &says("x"))
        }),
        chat("reasoning that drips", TimedOut, 20, |s| {
            dripping(s, STREAM, &event(r#"{"reasoning_content": "x"}"#))
        }),
        chat("keep-alives for ever", TimedOut, 20, |s| {
            dripping(s, STREAM, ": keep-alive\n\n")
        }),
        chat("a byte every 20 ms for ever", TimedOut, 20, |s| {
            dripping(s, STREAM, "x")
        }),
        // Heads.
        chat("headers without end", TooLarge, 20, |s| {
            endless(s, "HTTP/1.1 200 OK\r\n", "x-header: xxxxxxxxxxxxxxxxxxxxxxxx\r\n")
        }),
        chat("a header without end", TooLarge, 20, |s| {
            endless(s, "HTTP/1.1 200 OK\r\nx-header: ", "xxxxxxxx")
        }),
        chat("headers that drip", TimedOut, 20, |s| {
            dripping(s, "HTTP/1.1 200 OK\r\n", "x")
        }),
        chat("1xx for ever", TimedOut, 20, |s| {
            endless(s, "", "HTTP/1.1 100 Continue\r\n\r\n")
        }),
        // Connections.
        chat("no answer", Silent, 40, |s| stuck(s, "")),
        chat("half an answer", Silent, 40, |s| {
            stuck(s, &format!("{STREAM}{}", says("{")))
        }),
        chat("no reason for the end", Silent, 40, |s| {
            stuck(s, &format!("{STREAM}{}", says(GOOD)))
        }),
        chat("closed at once", Unreachable, 40, |_| Ok(())),
        chat("closed in the middle", Bad, 40, |s| {
            all(s, &format!("{STREAM}{}", says("{\"goals\"")))
        }),
        chat("a length that is too long", Bad, 40, |s| {
            all(
                s,
                &format!("HTTP/1.1 200 OK\r\ncontent-length: 999999\r\n\r\n{}", says("{")),
            )
        }),
        chat("a length that is too long, and silence", Silent, 40, |s| {
            stuck(
                s,
                &format!("HTTP/1.1 200 OK\r\ncontent-length: 999999\r\n\r\n{}", says("{")),
            )
        }),
        chat("a length that is too short", Bad, 40, |s| {
            all(
                s,
                &format!("HTTP/1.1 200 OK\r\ncontent-length: 20\r\n\r\n{}", says(GOOD)),
            )
        }),
        chat("a length that is no number", Bad, 40, |s| {
            all(s, "HTTP/1.1 200 OK\r\ncontent-length: -1\r\n\r\ndata: {}\n\n")
        }),
        chat("a chunk of a wrong size", Bad, 40, |s| {
            all(s, &format!("{CHUNKED}xyz\r\ndata: {{}}\n\n\r\n"))
        }),
        chat("a chunk that is too large", Bad, 40, |s| {
            endless(s, &format!("{CHUNKED}fffffffffffffffff\r\n"), "x")
        }),
        chat("chunks with extensions without end", Bad, 40, |s| {
            endless(s, &format!("{CHUNKED}5;"), "x=yyyyyyyy;")
        }),
        chat("trailers without end", Bad, 40, |s| {
            endless(s, &format!("{CHUNKED}0\r\n"), "x-trailer: yyyyyyyy\r\n")
        }),
        // Statuses.
        chat("redirects in a circle", Status(307), 40, |s| {
            all(
                s,
                "HTTP/1.1 307 There\r\nlocation: /v1/chat/completions\r\ncontent-length: 0\r\n\r\n",
            )
        }),
        chat("come back in a million seconds", Status(429), 40, |s| {
            all(
                s,
                "HTTP/1.1 429 Many\r\nretry-after: 1000000\r\ncontent-length: 0\r\n\r\n",
            )
        }),
        chat("come back in 2090", Status(503), 40, |s| {
            let date = "Sun, 01 Jan 2090 00:00:00 GMT";
            all(
                s,
                &format!("HTTP/1.1 503 Busy\r\nretry-after: {date}\r\ncontent-length: 0\r\n\r\n"),
            )
        }),
        chat("come back in no time, always", Status(503), 40, |s| {
            all(s, "HTTP/1.1 503 Busy\r\nretry-after: 0\r\ncontent-length: 0\r\n\r\n")
        }),
        // Contents.
        chat("a gzip bomb", Bad, 40, |s| {
            s.write_all(b"HTTP/1.1 200 OK\r\ncontent-encoding: gzip\r\nconnection: close\r\n\r\n")?;
            s.write_all(&[0x1f, 0x8b, 8, 0, 0, 0, 0, 0, 0, 3, b'\n'])?;
            endless(s, "", "\u{fffd}")
        }),
        chat("no HTTP", Bad, 40, |s| all(s, "SSH-2.0-OpenSSH_9.6\r\n")),
        chat("no HTTP, without end", Bad, 40, |s| endless(s, "", "\u{0}\u{1}\u{2}")),
        chat("HTTP/0.9", Bad, 40, |s| all(s, "<html>hello</html>\n")),
        chat("HTTP/2", Bad, 40, |s| stuck(s, "PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n")),
        chat("no UTF-8", Bad, 40, |s| {
            s.write_all(format!("{STREAM}data: ").as_bytes())?;
            s.write_all(b"\xff\xfe\n\n")
        }),
        chat("an event nested 100,000 deep", Bad, 40, |s| {
            all(s, &format!("{STREAM}data: {}\n\n", "[".repeat(100_000)))
        }),
        chat("an answer nested 5,000 deep", Reply, 40, |s| {
            all(s, &format!("{STREAM}{}data: [DONE]\n\n", says(&"[".repeat(5000))))
        }),
        chat("calls to tools and no text", Bad, 40, |s| {
            let call = event(r#"{"tool_calls": [{"index": 4294967295, "function": {"name": "f", "arguments": ""}}]}"#);
            all(s, &format!("{STREAM}{call}data: [DONE]\n\n"))
        }),
        chat("negative usage", Reply, 0, |s| {
            all(
                s,
                &good(r#"{"prompt_tokens": -5, "completion_tokens": -9223372036854775808}"#),
            )
        }),
        chat("huge usage", Reply, 0, |s| {
            all(
                s,
                &good(r#"{"prompt_tokens": 18446744073709551615, "completion_tokens": 1e300}"#),
            )
        }),
        // Questions beside the chat.
        beside("context: an answer without end", Place::Context, |s| {
            endless(s, JSON, " ")
        }),
        beside("context: an answer that drips", Place::Context, |s| {
            dripping(s, JSON, " ")
        }),
        beside("context: no answer", Place::Context, |s| stuck(s, "")),
        beside("context: headers without end", Place::Context, |s| {
            endless(s, "HTTP/1.1 200 OK\r\n", "x: y\r\n")
        }),
        beside("context: nested a million deep", Place::Context, |s| {
            all(s, &format!("{JSON}{{\"x\": {}", "[".repeat(1_000_000)))
        }),
        beside("context: a number too large", Place::Context, |s| {
            all(
                s,
                &format!("{JSON}{{\"default_generation_settings\": {{\"n_ctx\": 18446744073709551615}}}}"),
            )
        }),
        beside("context: no room at all", Place::Context, |s| {
            all(
                s,
                &format!("{JSON}{{\"default_generation_settings\": {{\"n_ctx\": 0}}}}"),
            )
        }),
        beside("tokens: an answer without end", Place::Tokens, |s| {
            endless(s, &format!("{JSON}{{\"tokens\": ["), "0,")
        }),
        beside("tokens: an answer that drips", Place::Tokens, |s| {
            dripping(s, JSON, " ")
        }),
        beside("tokens: four million of them", Place::Tokens, |s| {
            all(s, &format!("{JSON}{{\"tokens\": [{}0]}}", "0,".repeat(2_000_000)))
        }),
        beside("tokens: a number too large", Place::Tokens, |s| {
            all(s, &format!("{JSON}{{\"count\": 18446744073709551615}}"))
        }),
        beside("tokens: redirects in a circle", Place::Tokens, |s| {
            all(
                s,
                "HTTP/1.1 307 There\r\nlocation: /tokenize\r\ncontent-length: 0\r\n\r\n",
            )
        }),
    ]
}

/// The server of one mode. It stops when it is dropped.
pub struct Hostile {
    address: SocketAddr,
    stop: Arc<AtomicBool>,
    /// Receives a message when the mode's request has come.
    reached: Mutex<Receiver<()>>,
}

impl Hostile {
    pub fn new(mode: &Mode) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap();
        let stop = Arc::new(AtomicBool::new(false));
        let (stopped, place, play) = (Arc::clone(&stop), mode.place, mode.play);
        let (sender, reached) = channel();
        thread::spawn(move || {
            for stream in listener.incoming() {
                if stopped.load(Ordering::Relaxed) {
                    return;
                }
                // Whoever hangs up has seen enough.
                let sender = sender.clone();
                thread::spawn(move || stream.and_then(|stream| attend(stream, place, play, &sender)));
            }
        });
        Self {
            address,
            stop,
            reached: Mutex::new(reached),
        }
    }

    /// Waits until the mode's request has come.
    pub fn wait(&self) {
        self.reached.lock().unwrap().recv_timeout(LIFE).unwrap();
    }

    /// The reference of its model.
    pub fn reference(&self) -> String {
        format!("http://{}/v1#m", self.address)
    }
}

impl Drop for Hostile {
    fn drop(&mut self) {
        self.stop.store(true, Ordering::Relaxed);
        // Wakes the thread that listens.
        let _ = TcpStream::connect(self.address);
    }
}

fn attend(
    mut stream: TcpStream,
    place: Place,
    play: fn(&mut TcpStream) -> Result<()>,
    reached: &Sender<()>,
) -> Result<()> {
    stream.set_read_timeout(Some(LIFE))?;
    stream.set_write_timeout(Some(LIFE))?;
    let head = request(&mut stream)?;
    let asked = if head.starts_with("POST /v1/chat/completions") {
        Place::Chat
    } else if head.contains("tokenize") {
        Place::Tokens
    } else {
        Place::Context
    };
    if asked == place {
        let _ = reached.send(());
        return play(&mut stream);
    }
    match asked {
        Place::Chat => all(&mut stream, &good("{}")),
        Place::Context | Place::Tokens => all(&mut stream, "HTTP/1.1 404 None\r\ncontent-length: 0\r\n\r\n"),
    }
}

/// Reads a request and returns its head.
fn request(stream: &mut TcpStream) -> Result<String> {
    let mut text = Vec::new();
    let mut buffer = [0; 4096];
    loop {
        let so_far = String::from_utf8_lossy(&text).into_owned();
        if let Some((head, body)) = so_far.split_once("\r\n\r\n") {
            let length = head.to_lowercase();
            let length = length
                .split("content-length: ")
                .nth(1)
                .and_then(|rest| rest.lines().next());
            if body.len() >= length.map_or(0, |length| length.parse().unwrap()) {
                return Ok(head.to_owned());
            }
        }
        let read = stream.read(&mut buffer)?;
        if read == 0 {
            return Ok(so_far);
        }
        text.extend_from_slice(&buffer[..read]);
    }
}
