//! The HTTP interface, over real connections.

#![allow(clippy::panic, clippy::unwrap_used, missing_docs, unreachable_pub)]

mod support;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::LazyLock;
use std::time::Duration;

use longstep_robot::SimOptions;
use longstep_server::Body;
use longstep_server::http::{Access, ServeOptions, Token, document, serve};
use serde_json::{Value, json};
use support::{hub, simulated};
use tempfile::TempDir;
use tokio::sync::oneshot;

/// A server that ends with its test.
struct Served {
    address: SocketAddr,
    token: String,
    _ended: oneshot::Sender<()>,
    _folder: TempDir,
}

/// An answer.
struct Answered {
    status: u16,
    head: String,
    body: String,
}

impl Answered {
    fn json(&self) -> Value {
        serde_json::from_str(&self.body).unwrap_or_else(|error| panic!("{error}: {}{}", self.head, self.body))
    }
}

fn served(options: &str) -> Served {
    let folder = tempfile::tempdir().unwrap();
    let options: SimOptions = options.parse().unwrap();
    let hub = hub(&folder, vec![simulated("sim", options, Body::PerSession)]);
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap();
    let token = Token::of_file(&folder.path().join("token")).unwrap();
    let text = token.text().to_owned();
    let (ended, until) = oneshot::channel::<()>();
    let options = ServeOptions::new(Access::new(token, address, &[]));
    std::thread::spawn(move || serve(listener, hub, options, async { drop(until.await) }));
    Served {
        address,
        token: text,
        _ended: ended,
        _folder: folder,
    }
}

/// Compares an answer with the description of its path.
fn check_described(method: &str, path: &str, answered: &Answered) {
    static DOCUMENT: LazyLock<Value> = LazyLock::new(document);
    let own: Vec<&str> = path.split('/').collect();
    let fits = |known: &str| {
        let known: Vec<&str> = known.split('/').collect();
        known.len() == own.len()
            && known
                .iter()
                .zip(&own)
                .all(|(known, own)| *known == "{id}" || known == own)
    };
    let paths = DOCUMENT["paths"].as_object().unwrap();
    // `/api/sessions/{id}/plan` fits no other path, so one is found.
    let Some(operation) = paths
        .iter()
        .find(|(known, _)| fits(known))
        .map(|(_, all)| &all[method.to_lowercase()])
    else {
        return;
    };
    let responses = &operation["responses"];
    let response = responses
        .get(answered.status.to_string())
        .unwrap_or(&responses["default"]);
    let mut schema = response["content"]["application/json"]["schema"].clone();
    schema["components"] = DOCUMENT["components"].clone();
    let validator = jsonschema::validator_for(&schema).unwrap();
    let body = answered.json();
    let errors: Vec<String> = validator
        .iter_errors(&body)
        .map(|error| format!("{}: {error}", error.instance_path()))
        .collect();
    assert!(errors.is_empty(), "{method} {path} {}: {errors:#?}", answered.status);
}

impl Served {
    /// Sends bytes, and reads the answer to its end.
    fn raw(&self, bytes: &[u8]) -> Answered {
        let mut stream = TcpStream::connect(self.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
        // A server that refuses does not read to the end.
        let _ = stream.write_all(bytes);
        let mut text = Vec::new();
        let _ = stream.read_to_end(&mut text);
        let text = String::from_utf8_lossy(&text).into_owned();
        let (head, body) = text.split_once("\r\n\r\n").unwrap_or((&text, ""));
        let status = head
            .split(' ')
            .nth(1)
            .and_then(|status| status.parse().ok())
            .unwrap_or(0);
        Answered {
            status,
            head: head.to_owned(),
            body: body.to_owned(),
        }
    }

    fn request(&self, method: &str, path: &str, headers: &str, body: &str) -> Answered {
        let (address, length) = (self.address, body.len());
        self.raw(
            format!(
                "{method} {path} HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n\
                 Content-Length: {length}\r\n{headers}\r\n{body}"
            )
            .as_bytes(),
        )
    }

    fn bearer(&self) -> String {
        format!("Authorization: Bearer {}\r\n", self.token)
    }

    fn get(&self, path: &str) -> Value {
        let answered = self.request("GET", path, &self.bearer(), "");
        assert_eq!(answered.status, 200, "{path}: {}", answered.body);
        check_described("GET", path, &answered);
        answered.json()
    }

    fn post(&self, path: &str, body: &Value) -> (u16, Value) {
        let body = if body.is_null() {
            String::new()
        } else {
            body.to_string()
        };
        let answered = self.request("POST", path, &self.bearer(), &body);
        check_described("POST", path, &answered);
        (answered.status, answered.json())
    }

    /// Makes a plan in a new session; returns the session's path and the plan's hash.
    fn planned(&self) -> (String, String) {
        let (status, session) = self.post("/api/sessions", &json!({"scene": "desk"}));
        assert_eq!(status, 201);
        let path = format!("/api/sessions/{}", session["id"].as_str().unwrap());
        let (status, session) = self.post(
            &format!("{path}/instruct"),
            &json!({"text": "Put the pen on the shelf"}),
        );
        assert_eq!((status, &session["state"]), (200, &json!("plan")), "{session}");
        (path, session["proposal"]["plan"].as_str().unwrap().to_owned())
    }

    fn started(&self) -> (String, String) {
        let (path, plan) = self.planned();
        assert_eq!(self.post(&format!("{path}/accept"), &json!({"plan": plan})).0, 200);
        let (status, approval) = self.post(&format!("{path}/approve"), &json!({"plan": plan, "robot": "sim"}));
        assert_eq!(status, 201, "{approval}");
        let (status, run) = self.post("/api/runs", &json!({"approval": approval["id"]}));
        assert_eq!(status, 201, "{run}");
        let run = format!("/api/runs/{}", run["id"].as_str().unwrap());
        (path, run)
    }

    fn until(&self, run: &str, is_there: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..3_000 {
            let view = self.get(run);
            if is_there(&view) {
                return view;
            }
            std::thread::sleep(Duration::from_millis(10));
        }
        panic!("{run} does not come there: {}", self.get(run))
    }
}

fn is_ended(run: &Value) -> bool {
    ["done", "stopped"].contains(&run["state"].as_str().unwrap())
}

#[test]
fn a_plan_is_made_approved_and_carried_out() {
    let served = served("");
    let (session, run) = served.started();
    let done = served.until(&run, is_ended);
    assert_eq!(
        (&done["state"], &done["end"]["done"]),
        (&json!("done"), &json!(true)),
        "{done}"
    );
    let world = served.get(&format!("{session}/world"));
    assert_eq!(world["object_states"]["<pen>"], "on_something(<shelf>)", "{world}");
    assert_eq!(served.get("/api/runs")["runs"][0]["state"], "done");
    let deeds = served.get("/api/audit");
    let deeds: Vec<&str> = deeds["entries"]
        .as_array()
        .unwrap()
        .iter()
        .filter_map(|own| own["deed"].as_str())
        .collect();
    assert_eq!(deeds, ["ended", "started", "approved", "accepted"]);
    let recording = served.request("GET", &format!("{run}/mcap"), &served.bearer(), "");
    assert_eq!(recording.status, 200, "{}", recording.head);
    for header in ["application/octet-stream", "attachment; filename=\"", ".mcap\""] {
        assert!(recording.head.contains(header), "{}", recording.head);
    }
    assert!(recording.body.contains("MCAP0"));
    let missing = served.request("GET", "/api/runs/nothing/mcap", &served.bearer(), "");
    assert_eq!(
        (missing.status, &missing.json()["error"]["kind"]),
        (404, &json!("missing"))
    );
    assert_eq!(served.request("GET", &format!("{run}/mcap"), "", "").status, 401);
    let (status, undone) = served.post(&format!("{session}/undo"), &Value::Null);
    assert_eq!((status, undone["accepted"].as_array().unwrap().len()), (200, 0));
}

#[test]
fn a_hanging_run_is_stopped_paused_and_continued() {
    let served = served("ticks=3,pace=300");
    let (_, run) = served.started();
    served.until(&run, |run| run["state"] == "running");
    assert_eq!(served.post(&format!("{run}/pause"), &Value::Null).0, 200);
    served.until(&run, |run| run["state"] == "paused");
    assert_eq!(served.post(&format!("{run}/continue"), &Value::Null).0, 200);
    served.until(&run, |run| run["state"] == "running");
    assert_eq!(served.post("/api/stop", &Value::Null), (200, json!({"stopped": 1})));
    let stopped = served.until(&run, is_ended);
    assert_eq!(
        (&stopped["state"], &stopped["end"]["resumable"]),
        (&json!("stopped"), &json!(true)),
        "{stopped}"
    );
    assert_eq!(served.post(&format!("{run}/pause"), &Value::Null).0, 409);
    let (status, resumed) = served.post(&format!("{run}/resume"), &Value::Null);
    assert_eq!(status, 200, "{resumed}");
    // The step under way at the stop is unknown: the simulation began anew, so a person may be asked.
    let view = served.until(&run, |run| is_ended(run) || run["state"] == "asking");
    assert!(
        view["end"]["done"] == json!(true) || view["question"]["id"].is_string(),
        "{view}"
    );
}

#[test]
fn plans_are_made_verified_repaired_and_found_without_a_session() {
    let served = served("");
    let place = json!({"scene": "desk"});
    let (_, planned) = served.post(
        "/api/plan",
        &json!({"place": place, "instruction": "Put the pen on the shelf"}),
    );
    assert_eq!(
        (&planned["status"], planned["steps"].as_array().unwrap().len()),
        (&json!("verified"), 6)
    );
    let (_, verified) = served.post("/api/verify", &json!({"place": place, "plan": planned["plan"]}));
    assert_eq!(verified["status"], "verified");
    let short = r#"{"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}"#;
    let (_, invalid) = served.post("/api/verify", &json!({"place": place, "plan": short}));
    assert_eq!(invalid["status"], "invalid");
    let (_, repaired) = served.post(
        "/api/repair",
        &json!({"place": place, "plan": short, "goal": "put(pen, shelf)"}),
    );
    assert!(
        repaired["status"] == "verified" && !repaired["edits"].as_array().unwrap().is_empty(),
        "{repaired}"
    );
    let (_, solved) = served.post("/api/solve", &json!({"place": place, "goal": "put(cup, table)"}));
    assert_eq!(solved["status"], "verified");
    let (status, error) = served.post("/api/solve", &json!({"place": place, "goal": "put(cup, moon)"}));
    assert_eq!(status, 400, "{error}");
    let (status, asked) = served.post(
        "/api/plan",
        &json!({"place": place, "instruction": "Put something away"}),
    );
    assert_eq!((status, &asked["status"]), (200, &json!("question")));
    assert_eq!(served.get("/api/server")["model"]["name"], "scripted");
    assert!(served.get("/api/sessions")["sessions"].as_array().unwrap().is_empty());
}

#[test]
fn nothing_is_done_for_those_who_may_not() {
    let served = served("");
    let (session, plan) = served.planned();
    let accept = format!("{session}/accept");
    let body = json!({"plan": plan}).to_string();
    let (bearer, address) = (served.bearer(), served.address);
    for (headers, status) in [
        (String::new(), 401),
        ("Authorization: Bearer wrong\r\n".to_owned(), 401),
        (format!("{bearer}Origin: http://evil.example\r\n"), 403),
    ] {
        assert_eq!(
            served.request("POST", &accept, &headers, &body).status,
            status,
            "{headers}"
        );
    }
    let foreign = format!("GET /api/server HTTP/1.1\r\nHost: evil.example\r\nConnection: close\r\n{bearer}\r\n");
    assert_eq!(served.raw(foreign.as_bytes()).status, 403);
    assert_eq!(served.request("GET", &accept, &bearer, "").status, 405);
    assert_eq!(served.request("POST", &accept, &bearer, "{").status, 400);
    assert_eq!(
        served
            .request("POST", &accept, &bearer, r#"{"plan": "x", "more": 1}"#)
            .status,
        400
    );
    assert_eq!(
        served.request("GET", "/api/sessions/..%2f..%2fetc", &bearer, "").status,
        404
    );
    assert_eq!(
        served
            .request("POST", &accept, &bearer, r#"{"plan": "another"}"#)
            .status,
        409
    );
    // A body beyond the bound, and one that never comes whole.
    let large = format!(
        "POST /api/verify HTTP/1.1\r\nHost: {address}\r\nConnection: close\r\nContent-Type: application/json\r\n{bearer}Content-Length: 100000000\r\n\r\n"
    );
    let large = [large.as_bytes(), &vec![b' '; 6 << 20]].concat();
    assert_eq!(served.raw(&large).status, 413);
    // The link of the page becomes a cookie, with which the page of this origin may change something.
    let login = served.request("GET", &format!("/?token={}", served.token), "", "");
    assert_eq!(login.status, 303);
    let cookie = login
        .head
        .lines()
        .find_map(|line| line.strip_prefix("set-cookie: "))
        .unwrap();
    assert!(cookie.contains("HttpOnly; SameSite=Strict") && !cookie.contains(&served.token));
    let cookie = cookie.split(';').next().unwrap();
    let own = format!("Cookie: {cookie}\r\nOrigin: http://{address}\r\n");
    assert_eq!(
        served
            .request("POST", &accept, &format!("Cookie: {cookie}\r\n"), &body)
            .status,
        403
    );
    assert_eq!(served.request("POST", &accept, &own, &body).status, 200);
    let headers = served.request("GET", "/api/server", &bearer, "").head;
    for header in [
        "content-security-policy: default-src 'none'",
        "x-content-type-options: nosniff",
    ] {
        assert!(headers.contains(header), "{headers}");
    }
}

#[test]
fn idle_connections_keep_nobody_out() {
    let served = served("");
    // With the first answer, the server has raised the limit of open files, which is that of the test too.
    served.get("/api/server");
    let idle: Vec<_> = (0..1_100)
        .map(|_| TcpStream::connect(served.address).unwrap())
        .collect();
    // A request arrives after them, and is answered.
    assert_eq!(served.get("/api/server")["version"], env!("CARGO_PKG_VERSION"));
    let mut first = idle.into_iter().next().unwrap();
    first.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let mut text = String::new();
    first.read_to_string(&mut text).unwrap();
    assert!(text.contains("503") && text.contains("too many connections"), "{text}");
    // A connection without the token ends with its answer.
    let stranger = format!("GET /api/server HTTP/1.1\r\nHost: {}\r\n\r\n", served.address);
    assert_eq!(served.raw(stranger.as_bytes()).status, 401);
}

#[test]
fn events_are_resumed_from_an_id() {
    let served = served("");
    let request = |after: &str| {
        format!(
            "GET /api/events HTTP/1.1\r\nHost: {}\r\n{}{after}\r\n",
            served.address,
            served.bearer()
        )
    };
    let mut stream = TcpStream::connect(served.address).unwrap();
    stream.write_all(request("").as_bytes()).unwrap();
    stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
    let mut lines = BufReader::new(stream).lines();
    assert!(lines.by_ref().map_while(Result::ok).any(|line| line.is_empty()));
    let (_, run) = served.started();
    served.until(&run, is_ended);
    let mut ids = Vec::new();
    for line in lines.map_while(Result::ok) {
        ids.extend(line.strip_prefix("id: ").map(str::to_owned));
        if line.starts_with("data: ") && line.contains(r#""state":"done""#) {
            break;
        }
    }
    let numbers: Vec<u64> = ids
        .iter()
        .map(|id| id.rsplit('-').next().unwrap().parse().unwrap())
        .collect();
    assert!(numbers.windows(2).all(|pair| pair[0] + 1 == pair[1]), "{numbers:?}");

    for (after, kind) in [(ids[2].as_str(), "happened"), ("other-1", "reset")] {
        let mut stream = TcpStream::connect(served.address).unwrap();
        stream.set_read_timeout(Some(Duration::from_secs(30))).unwrap();
        stream
            .write_all(request(&format!("Last-Event-ID: {after}\r\n")).as_bytes())
            .unwrap();
        let mut lines = BufReader::new(stream).lines().map_while(Result::ok);
        let event = lines.by_ref().find(|line| line.starts_with("event: ")).unwrap();
        assert_eq!(event, format!("event: {kind}"));
        if kind == "happened" {
            let id = lines
                .find_map(|line| line.strip_prefix("id: ").map(str::to_owned))
                .unwrap();
            assert_eq!(id, ids[3]);
        }
    }
}
