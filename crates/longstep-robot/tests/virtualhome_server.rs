//! The VirtualHome client against servers that no simulator is: silent, gone, wrong, endless.
#![allow(clippy::unwrap_used, clippy::panic)]

mod support;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use longstep_core::environment::World;
use longstep_core::testing;
use longstep_robot::virtualhome::{Simulator, VirtualHome, VirtualHomeOptions};
use longstep_robot::{Handle, Order, Progress, Robot, RobotError, Scope};
use serde_json::{Value, json};

/// The reaction of a server to a request.
enum Reaction {
    /// Answers with a body.
    Body(Vec<u8>),
    /// Writes these bytes in place of an HTTP answer, and closes.
    Raw(Vec<u8>),
    /// Says nothing and keeps the connection open.
    Silence,
    /// Sends a body without an end.
    Endless,
}

/// A server whose answers are those of a simulator, unless the test has another one for the action.
struct Server {
    url: String,
    requests: Arc<Mutex<Vec<Value>>>,
}

const ENVIRONMENT: &str = r#"{"assets": ["<kitchen_1>", "<table_2>"], "objects": ["<mug_3>"],
    "object_states": {"<mug_3>": "ON(<table_2>)"}}"#;

fn graph() -> String {
    json!({
        "nodes": [
            { "id": 1, "class_name": "kitchen", "category": "Rooms", "properties": [], "states": [] },
            { "id": 2, "class_name": "table", "category": "Furniture", "properties": ["SURFACES"], "states": [] },
            { "id": 3, "class_name": "mug", "category": "Props", "properties": ["GRABBABLE"], "states": [] },
            { "id": 9, "class_name": "character", "category": "Characters", "properties": [], "states": [] }
        ],
        "edges": [
            { "from_id": 3, "relation_type": "ON", "to_id": 2 },
            { "from_id": 2, "relation_type": "INSIDE", "to_id": 1 }
        ]
    })
    .to_string()
}

fn usual(action: &str) -> Value {
    let message = match action {
        "environment_graph" => graph(),
        "character_cameras" => r#"["PERSON_FRONT", "PERSON_FROM_BACK"]"#.to_owned(),
        _ => String::new(),
    };
    json!({ "id": "1", "success": true, "message": message, "value": 0, "message_list": [] })
}

impl Server {
    fn start(mut react: impl FnMut(&str) -> Option<Reaction> + Send + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let url = format!("http://{}", listener.local_addr().unwrap());
        let requests: Arc<Mutex<Vec<Value>>> = Arc::default();
        let seen = Arc::clone(&requests);
        thread::spawn(move || {
            // Connections that are silent are kept.
            let mut kept = Vec::new();
            for connection in listener.incoming() {
                let Ok(mut connection) = connection else { return };
                let Some(request) = read_request(&connection) else {
                    continue;
                };
                let action = request["action"].as_str().unwrap_or_default().to_owned();
                seen.lock().unwrap().push(request);
                let reaction = react(&action);
                let reaction = reaction.unwrap_or_else(|| Reaction::Body(usual(&action).to_string().into_bytes()));
                match reaction {
                    Reaction::Body(body) => {
                        let head = format!("HTTP/1.1 200 OK\r\nContent-Length: {}\r\n\r\n", body.len());
                        let _ = connection.write_all(&[head.into_bytes(), body].concat());
                    }
                    Reaction::Raw(bytes) => drop(connection.write_all(&bytes)),
                    Reaction::Silence => kept.push(connection),
                    Reaction::Endless => {
                        let _ = connection.write_all(b"HTTP/1.1 200 OK\r\nContent-Length: 99999999999\r\n\r\n");
                        while connection.write_all(&[b' '; 65_536]).is_ok() {}
                    }
                }
            }
        });
        Self { url, requests }
    }

    fn options(&self) -> VirtualHomeOptions {
        let mut options = VirtualHomeOptions::new(&self.url);
        options.timeout = Duration::from_secs(1);
        options
    }

    fn open(&self) -> Result<VirtualHome, RobotError> {
        VirtualHome::open(world(), &self.options())
    }

    fn actions(&self) -> Vec<String> {
        let requests = self.requests.lock().unwrap();
        let action = |request: &Value| request["action"].as_str().unwrap_or_default().to_owned();
        requests.iter().map(action).collect()
    }
}

fn read_request(connection: &TcpStream) -> Option<Value> {
    connection.set_read_timeout(Some(Duration::from_secs(10))).ok()?;
    let mut reader = BufReader::new(connection);
    let mut length = 0;
    loop {
        let mut line = String::new();
        reader.read_line(&mut line).ok()?;
        let line = line.trim().to_lowercase();
        if line.is_empty() {
            break;
        }
        if let Some(own) = line.strip_prefix("content-length:") {
            length = own.trim().parse().ok()?;
        }
    }
    let mut body = vec![0; length];
    reader.read_exact(&mut body).ok()?;
    serde_json::from_slice(&body).ok()
}

fn world() -> World {
    testing::world("virtualhome", ENVIRONMENT)
}

fn grab() -> Order {
    Order::new(1, "grab", ["<mug_3>"])
}

/// Waits for the end of a step.
fn ended(robot: &mut VirtualHome, handle: Handle) -> Result<Progress, RobotError> {
    loop {
        match robot.poll(handle)? {
            Progress::Running(None) => robot.wait(Duration::from_millis(5)),
            progress => return Ok(progress),
        }
    }
}

fn only(action: &'static str, reaction: impl Fn() -> Reaction + Send + 'static) -> Server {
    Server::start(move |own| (own == action).then(&reaction))
}

fn body(value: &Value) -> Reaction {
    Reaction::Body(value.to_string().into_bytes())
}

#[test]
fn a_line_is_sent_as_the_simulator_s_own_client_sends_it() {
    let server = Server::start(|_| None);
    let mut robot = server.open().unwrap();
    let handle = robot.start(&grab()).unwrap();
    assert_eq!(robot.start(&grab()), Err(RobotError::Busy { limit: 1 }));
    assert_eq!(ended(&mut robot, handle), Ok(Progress::Done { outcome: None }));
    assert_eq!(robot.poll(handle), Err(RobotError::UnknownHandle(handle)));
    let seen = robot.observe(&Scope::All).unwrap();
    assert_eq!(seen.of_entity("<mug_3>"), Some(&["ON(<table_2>)".to_owned()][..]));
    let requests = server.requests.lock().unwrap().clone();
    let line = requests
        .iter()
        .find(|request| request["action"] == "render_script")
        .unwrap();
    assert_eq!(line["stringParams"][1], "<char0> [grab] <mug> (3)");
    let config: Value = serde_json::from_str(line["stringParams"][0].as_str().unwrap()).unwrap();
    assert_eq!(
        (&config["skip_execution"], &config["find_solution"]),
        (&json!(false), &json!(false))
    );
    // Nothing is reset, and the scene has its character.
    let actions = server.actions();
    assert_eq!(
        actions,
        ["idle", "environment_graph", "render_script", "environment_graph"]
    );
    robot.stop().unwrap();
    assert_eq!(robot.start(&grab()), Err(RobotError::Stopped));
    assert_eq!(server.actions(), actions);
}

#[test]
fn a_refused_line_is_a_failed_step_with_the_reason() {
    let reasons = [
        (json!("{\"0\": {\"message\": \"it is too far\"}}"), "it is too far"),
        (json!("no way"), "no way"),
        (json!(""), "the simulator gives no reason"),
        (json!({"odd": 1}), "{\"odd\":1}"),
    ];
    for (message, reason) in reasons {
        let answer = json!({ "success": false, "message": message });
        let server = only("render_script", move || body(&answer));
        let mut robot = server.open().unwrap();
        let handle = robot.start(&grab()).unwrap();
        let reason = reason.to_owned();
        assert_eq!(ended(&mut robot, handle), Ok(Progress::Failed { reason }));
        // The robot stays usable.
        robot.observe(&Scope::All).unwrap();
    }
}

/// After a failure of the connection, nothing is sent any more.
#[test]
fn every_failure_of_the_connection_is_typed_and_final() {
    type React = fn() -> Reaction;
    let cases: [(React, &str); 7] = [
        (|| Reaction::Silence, "did not answer within 1 s"),
        (|| Reaction::Raw(Vec::new()), "the robot is gone"),
        (
            || Reaction::Raw(b"HTTP/1.1 500 Oh\r\nContent-Length: 0\r\n\r\n".to_vec()),
            "HTTP status 500",
        ),
        (
            || Reaction::Raw(b"HTTP/1.1 302 Away\r\nLocation: http://127.0.0.1:1/\r\n\r\n".to_vec()),
            "HTTP status 302",
        ),
        (|| Reaction::Raw(b"hello\r\n\r\n".to_vec()), "the robot is gone"),
        (|| Reaction::Body(b"[1, 2".to_vec()), "cannot be read"),
        (|| Reaction::Endless, "more than 32 MiB"),
    ];
    for (react, message) in cases {
        let server = only("render_script", react);
        let mut robot = server.open().unwrap();
        robot.observe(&Scope::All).unwrap();
        let handle = robot.start(&grab()).unwrap();
        let error = ended(&mut robot, handle).unwrap_err();
        assert!(
            error.to_string().contains(message) && error.is_final(),
            "{message}: {error}"
        );
        let sent = server.actions();
        assert_eq!(robot.start(&grab()), Err(error.clone()), "{message}");
        assert_eq!(robot.observe(&Scope::All), Err(error.clone()), "{message}");
        robot.stop().unwrap();
        assert_eq!(server.actions(), sent, "{message}");
    }
}

#[test]
fn a_simulator_that_cannot_be_used_is_refused_before_anything_moves() {
    let answer = |message: &'static str| move || body(&json!({ "success": true, "message": message }));
    let unreachable = VirtualHome::open(world(), &VirtualHomeOptions::new("http://127.0.0.1:1")).unwrap_err();
    assert!(matches!(unreachable, RobotError::Unreachable { .. }), "{unreachable}");
    let twice = r#"{"nodes": [{"id": 1, "class_name": "a"}, {"id": 1, "class_name": "b"}], "edges": []}"#;
    let cases: [(Server, &str); 6] = [
        (only("environment_graph", answer("what?")), "no graph of a scene"),
        (only("environment_graph", answer(twice)), "two nodes have the number 1"),
        (
            only("environment_graph", || body(&json!({ "success": true, "message": 7 }))),
            "no text",
        ),
        (
            only("environment_graph", || {
                body(&json!({ "success": false, "message": "busy" }))
            }),
            "busy",
        ),
        (
            only("environment_graph", answer(r#"{"nodes": [], "edges": []}"#)),
            "its scene has no <kitchen_1>",
        ),
        (only("idle", || Reaction::Raw(Vec::new())), "cannot start the robot"),
    ];
    for (server, message) in cases {
        let error = server.open().unwrap_err().to_string();
        assert!(error.contains(message), "{message}: {error}");
        assert!(!server.actions().contains(&"render_script".to_owned()));
    }
}

#[test]
fn a_stop_sends_nothing_more_and_is_confirmed_by_the_end_of_the_line() {
    // A line that never ends is not confirmed to have stopped.
    let server = only("render_script", || Reaction::Silence);
    let mut options = server.options();
    options.timeout = Duration::from_secs(60);
    let mut robot = VirtualHome::open(world(), &options).unwrap();
    let handle = robot.start(&grab()).unwrap();
    while !server.actions().contains(&"render_script".to_owned()) {
        thread::sleep(Duration::from_millis(2));
    }
    let switch = robot.stop_switch();
    thread::spawn(move || switch.press());
    assert_eq!(ended(&mut robot, handle), Err(RobotError::Stopped));
    assert!(matches!(robot.stop(), Err(RobotError::TimedOut { .. })));
    // One that has ended is.
    let server = Server::start(|_| None);
    let mut robot = server.open().unwrap();
    robot.start(&grab()).unwrap();
    robot.stop().unwrap();
    robot.stop().unwrap();
}

#[test]
fn a_stop_ends_the_wait_for_an_observation() {
    let count = Arc::new(Mutex::new(0));
    let server = Server::start(move |action| {
        let mut count = count.lock().unwrap();
        *count += u32::from(action == "environment_graph");
        (*count > 1).then_some(Reaction::Silence)
    });
    let mut robot = server.open().unwrap();
    let switch = robot.stop_switch();
    let begun = Instant::now();
    thread::spawn(move || {
        thread::sleep(Duration::from_millis(50));
        switch.press();
    });
    assert_eq!(robot.observe(&Scope::All), Err(RobotError::Stopped));
    // The timeout of an observation is 30 s.
    assert!(begun.elapsed() < Duration::from_secs(15));
}

#[test]
fn a_missing_picture_does_not_fail_a_step() {
    let folder = tempfile::tempdir().unwrap();
    let picture = |answer: Value| {
        let server = Server::start(move |action| match action {
            "camera_count" => Some(body(&json!({ "success": true, "message": "", "value": 8 }))),
            "camera_image" => Some(body(&answer)),
            _ => None,
        });
        let mut options = server.options();
        options.pictures = Some(folder.path().to_owned());
        let mut robot = VirtualHome::open(world(), &options).unwrap();
        let handle = robot.start(&grab()).unwrap();
        let first = ended(&mut robot, handle).unwrap();
        let feedback = match first {
            Progress::Running(Some(feedback)) => {
                assert_eq!(ended(&mut robot, handle), Ok(Progress::Done { outcome: None }));
                feedback.text
            }
            _ => None,
        };
        let camera = server.requests.lock().unwrap().last().unwrap()["intParams"][0].clone();
        (feedback, camera)
    };
    let file = folder.path().join("step-001.png");
    let (feedback, camera) = picture(json!({ "success": true, "message_list": ["aGVsbG8="] }));
    assert_eq!((feedback, camera), (None, json!(7)));
    assert_eq!(std::fs::read(&file).unwrap(), b"hello");
    for answer in [
        json!({ "success": true, "message_list": ["%%%"] }),
        json!({ "success": true }),
        json!({ "success": false, "message": "no light" }),
    ] {
        let (feedback, _) = picture(answer);
        assert!(feedback.unwrap().starts_with("no picture: "));
    }
}

#[test]
fn try_program_stops_at_a_line_that_fails_twice() {
    use longstep_robot::virtualhome::{Line, Trial};
    let server = only("render_script", || {
        body(&json!({ "success": false, "message": "too far" }))
    });
    let simulator = Simulator::new(&server.url).unwrap();
    let lines = [
        Line::new("grab", &["<mug_3>"]).unwrap(),
        Line::new("drink", &["<mug_3>"]).unwrap(),
    ];
    let trial = simulator
        .try_program(&lines, "kitchen", Duration::from_secs(5))
        .unwrap();
    let failure = Some("too far".to_owned());
    assert_eq!(trial, Trial { performed: 0, failure });
    let actions = server.actions();
    assert_eq!(
        actions,
        [
            "clear",
            "environment",
            "add_character",
            "render_script",
            "render_script"
        ]
    );
}

#[test]
fn virtualhome_lock_is_independent_of_the_address_form() {
    let drives = |url: &str| VirtualHomeOptions::new(url).drives();
    let expected = ["virtualhome localhost:8080".to_owned()];
    for url in [
        "http://127.0.0.1:8080",
        "http://localhost:8080/",
        "http://[::1]:8080",
        "http://me:hunter2@127.0.0.1:8080/x",
    ] {
        assert_eq!(drives(url), expected, "{url}");
    }
    assert_eq!(drives("http://arm"), ["virtualhome arm:80"]);
}

/// A line that a killed run left: the simulator answers nothing else before its end.
#[test]
fn a_run_begins_when_the_simulator_answers() {
    let busy = Duration::from_millis(1500);
    let server = Server::start(move |action| {
        if action == "idle" {
            thread::sleep(busy);
        }
        None
    });
    let begun = Instant::now();
    // The timeout of a line is shorter here.
    assert!(server.open().is_ok());
    assert!(begun.elapsed() >= busy);
    assert_eq!(server.actions()[..2], ["idle", "environment_graph"]);
}
