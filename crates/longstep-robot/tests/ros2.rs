//! The client of a bridge, against a WebSocket server that does what no real bridge can be made to do.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use longstep_core::model::Domain;
use longstep_core::testing;
use longstep_robot::ros2::{Configuration, Ros2, check, trials};
use longstep_robot::{Order, Progress, Robot, RobotError, Scope};
use serde_json::{Value, json};
use tungstenite::{Message, WebSocket};

/// The reaction of the bridge to a message.
#[derive(Debug, Clone)]
enum Deed {
    Send(Value),
    Raw(String),
    Binary,
    /// The connection is closed in order.
    Close,
    /// The connection breaks.
    Drop,
    /// Nothing is read any more.
    Freeze,
}

/// A server that answers each message by a function, and keeps all messages.
struct Bridge {
    port: u16,
    received: Arc<Mutex<Vec<Value>>>,
}

impl Bridge {
    fn new(deeds: impl Fn(&Value) -> Vec<Deed> + Send + Sync + 'static) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let port = listener.local_addr().unwrap().port();
        let received: Arc<Mutex<Vec<Value>>> = Arc::default();
        let (kept, deeds) = (Arc::clone(&received), Arc::new(deeds));
        // It ends with the test's process.
        thread::spawn(move || {
            for stream in listener.incoming() {
                let (kept, deeds) = (Arc::clone(&kept), Arc::clone(&deeds));
                thread::spawn(move || {
                    if let Ok(socket) = tungstenite::accept(stream.unwrap()) {
                        attend(socket, &kept, deeds.as_ref());
                    }
                });
            }
        });
        Self { port, received }
    }

    /// A bridge with the servers and the service of the configuration, whose goals end by a function.
    fn with_goals(deeds: impl Fn(&Value) -> Vec<Deed> + Send + Sync + 'static) -> Self {
        Self::new(move |message| match message["op"].as_str().unwrap() {
            "send_action_goal" => deeds(message),
            "cancel_action_goal" => vec![ended(message, 5, json!({}))],
            _ => usual(message),
        })
    }

    fn connect(&self, more: &str) -> Result<Ros2, RobotError> {
        Ros2::connect(self.configuration(more), &household())
    }

    fn configuration(&self, more: &str) -> Configuration {
        let text = ROBOT.replace("PORT", &self.port.to_string()).replace("MORE", more);
        Configuration::parse("robot.toml", &text).unwrap()
    }

    fn received(&self, operation: &str) -> Vec<Value> {
        let received = self.received.lock().unwrap();
        received.iter().filter(|own| own["op"] == operation).cloned().collect()
    }
}

fn attend(mut socket: WebSocket<TcpStream>, kept: &Mutex<Vec<Value>>, deeds: &dyn Fn(&Value) -> Vec<Deed>) {
    while let Ok(message) = socket.read() {
        let Message::Text(text) = message else {
            continue;
        };
        let message: Value = serde_json::from_str(text.as_str()).unwrap();
        kept.lock().unwrap().push(message.clone());
        for deed in deeds(&message) {
            let sent = match deed {
                Deed::Send(value) => socket.send(Message::text(value.to_string())),
                Deed::Raw(text) => socket.send(Message::text(text)),
                Deed::Binary => socket.send(Message::Binary(vec![1, 2].into())),
                Deed::Close => socket.close(None).and_then(|()| socket.flush()),
                Deed::Drop => return,
                Deed::Freeze => loop {
                    thread::sleep(Duration::from_secs(3600));
                },
            };
            if sent.is_err() {
                break;
            }
        }
    }
}

const ROBOT: &str = r#"name = "arm"
url = "ws://127.0.0.1:PORT"
allow = ["grasp", "release", "wipe"]
parallel = 2
rate = 1000
MORE
[[action]]
name = "*"
server = "/execute_step"
type = "longstep_msgs/action/ExecuteStep"
goal = { step = "{step}", action = "{action}", arguments = "{arguments}" }
[[observation]]
service = "/observe"
type = "longstep_msgs/srv/Observe"
each = "states"
entity = "{entity}"
states = "statements"
"#;

/// Short times for what ends with one.
const SHORT: &str = "[timeouts]\nconnect = 0.3\naccept = 0.3\nperform = 0.6\nobserve = 0.3\nstop = 0.3\nsilence = 20";

fn household() -> Domain {
    testing::domain("household")
}

fn answer(message: &Value, values: Value) -> Deed {
    Deed::Send(
        json!({"op": "service_response", "service": message["service"], "id": message["id"], "result": true,
                      "values": values}),
    )
}

/// The reaction of a bridge with the right servers.
fn usual(message: &Value) -> Vec<Deed> {
    match (message["op"].as_str().unwrap(), message["service"].as_str()) {
        ("call_service", Some("/execute_step/_action/cancel_goal")) => {
            vec![answer(message, json!({"return_code": 2, "goals_canceling": []}))]
        }
        ("call_service", Some("/rosbridge_websocket/get_parameters")) => vec![Deed::Send(json!({
            "op": "service_response", "service": message["service"], "id": message["id"], "result": false,
            "values": "Service /rosbridge_websocket/get_parameters does not exist"
        }))],
        ("call_service", Some("/observe")) => {
            vec![answer(
                message,
                json!({"states": [{"entity": "<cup>", "statements": ["inside_hand()"]}]}),
            )]
        }
        ("subscribe", _) if message["type"] == "std_msgs/msg/Empty" => vec![Deed::Send(json!({
            "op": "status", "level": "error", "id": message["id"],
            "msg": "the graph has longstep_msgs/action/ExecuteStep_FeedbackMessage"
        }))],
        _ => Vec::new(),
    }
}

fn ended(message: &Value, status: i64, values: Value) -> Deed {
    Deed::Send(
        json!({"op": "action_result", "action": message["action"], "id": message["id"], "status": status,
                      "result": status == 4, "values": values}),
    )
}

fn feedback(message: &Value) -> Deed {
    Deed::Send(
        json!({"op": "action_feedback", "action": message["action"], "id": message["id"], "values": {"progress": 0.5}}),
    )
}

/// The goals of a server, as it lists them.
fn listed(goals: &[(u64, i64)]) -> Deed {
    let entry = |(number, status): &(u64, i64)| json!({"goal_info": {"goal_id": {"uuid": number.to_string()}}, "status": status});
    let list: Vec<Value> = goals.iter().map(entry).collect();
    Deed::Send(json!({"op": "publish", "topic": "/execute_step/_action/status", "msg": {"status_list": list}}))
}

fn performed(robot: &mut Ros2, order: &Order) -> Result<Progress, RobotError> {
    let handle = robot.start(order)?;
    loop {
        match robot.poll(handle)? {
            Progress::Running(_) => robot.wait(Duration::from_millis(20)),
            end => return Ok(end),
        }
    }
}

fn grasp(step: usize) -> Order {
    Order::new(step, "grasp", ["<cup>"])
}

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

#[test]
fn the_configurations_that_are_shown_can_be_used() {
    let page = std::fs::read_to_string(root().join("docs/guide/ros2.md")).unwrap();
    let (_, block) = page.split_once("```toml\n").unwrap();
    // Its table `joint` is left to the reader.
    let block = block
        .split_once("```")
        .unwrap()
        .0
        .replace("[table.pose]", "[table.joint]\n[table.pose]");
    assert_eq!(
        Configuration::parse("docs/guide/ros2.md", &block).unwrap().name(),
        "kitchen arm"
    );
    let example = std::fs::read_to_string(root().join("examples/robots/ros2/robot.toml")).unwrap();
    let checked = check(
        &Configuration::parse("robot.toml", &example).unwrap(),
        &household(),
        None,
    );
    assert_eq!(checked.mismatches, []);
}

#[test]
fn mismatches_with_a_domain_have_their_places() {
    let checks = testing::domain("household-checks");
    let env =
        r#"{"assets": ["<desk>"], "objects": ["<pen>", "<milk>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    let world = testing::world_of(&checks, env);
    let sensing = checks.actions.iter().find(|action| !action.senses.is_empty()).unwrap();
    let text = WRONG.replace("SENSING", &sensing.name);
    let checked = check(
        &Configuration::parse("robot.toml", &text).unwrap(),
        &checks,
        Some(&world),
    );
    let lines = |findings: &[longstep_core::diagnostic::Diagnostic]| -> Vec<String> {
        let short = |own: &longstep_core::diagnostic::Diagnostic| {
            let line = own.position.map_or(0, |position| position.line);
            format!("{line}: {}", own.message)
        };
        findings.iter().map(short).collect()
    };
    let found = lines(&checked.mismatches);
    for expected in [
        "3: unknown action `graps`",
        "11: `grasp` has no parameter `thing`;",
        "16: `release` has no skill parameters in domain.toml",
        "18: `SENSING` is a sensing action: add `outcome` or `outcomes`",
        "27: unknown state `open_wide`",
        "27: `on_something` has 1 arguments, not 2",
        "28: unknown statement without a subject `hand-at`",
        "4: unknown predicate `hand-on`",
    ] {
        let expected = expected.replace("SENSING", &sensing.name);
        assert!(
            found.iter().any(|own| own.starts_with(&expected)),
            "{expected}\n{found:#?}"
        );
    }
    assert_eq!(found.len(), 9, "{found:#?}");
    let remarks = lines(&checked.remarks);
    for expected in [
        "11: the table `pose` lacks `<milk>`",
        "3: plans with these actions are refused: ",
        "27: no observation states ",
    ] {
        assert!(
            remarks.iter().any(|own| own.starts_with(expected)),
            "{expected}\n{remarks:#?}"
        );
    }
}

const WRONG: &str = r#"name = "arm"
url = "ws://127.0.0.1"
allow = ["grasp", "release", "graps", "SENSING"]
reports = ["hand-on"]
[table.pose]
"<pen>" = 1
[[action]]
name = "grasp"
server = "/grasp"
type = "a/action/A"
goal = { pose = "{item|pose}", thing = "{thing}" }
[[action]]
name = "release"
server = "/release"
type = "a/action/B"
goal = { width = "{skill.width}" }
[[action]]
name = "SENSING"
server = "/look"
type = "a/action/C"
goal = {}
[[observation]]
topic = "/seen"
type = "a/msg/Seen"
entity = "{name}"
say = [
    { state = "on_something({on}, {under})" }, { state = "open_wide()" },
    { fact = "hand-at({name})" },
]
[[action]]
name = "graps"
server = "/grasp"
type = "a/action/A"
goal = {}
"#;

#[test]
fn orders_are_performed_and_observed() {
    let bridge = Bridge::with_goals(|goal| vec![feedback(goal), ended(goal, 4, json!({})), feedback(goal)]);
    let mut robot = bridge.connect("").unwrap();
    let handle = robot.start(&grasp(1)).unwrap();
    let mut seen = Vec::new();
    loop {
        match robot.poll(handle).unwrap() {
            Progress::Running(None) => robot.wait(Duration::from_millis(20)),
            Progress::Running(Some(feedback)) => seen.push(feedback.data.unwrap()),
            end => {
                assert_eq!(end, Progress::Done { outcome: None });
                break;
            }
        }
    }
    assert_eq!(seen, [json!({"progress": 0.5})]);
    assert_eq!(robot.poll(handle), Err(RobotError::UnknownHandle(handle)));
    assert_eq!(
        robot.observe(&Scope::All).unwrap().of_entity("<cup>"),
        Some(&["inside_hand()".to_owned()][..])
    );
    let action = "attach".to_owned();
    assert_eq!(
        robot.start(&Order::new(2, "attach", ["<cup>", "<desk>"])),
        Err(RobotError::Unsupported { action })
    );
    robot.stop().unwrap();
    assert_eq!(robot.start(&grasp(3)), Err(RobotError::Stopped));
    let goals = bridge.received("send_action_goal");
    assert_eq!(goals.len(), 1);
    assert_eq!(
        goals[0]["args"],
        json!({"step": 1, "action": "grasp", "arguments": ["<cup>"]})
    );
    assert!(
        bridge.received("cancel_action_goal").is_empty(),
        "nothing was under way"
    );
}

/// Everything that ends a run; after each of them nothing is sent but what stops the robot.
#[test]
fn after_a_failure_no_order_is_sent() {
    let long = "x".repeat(5 << 20);
    let table: Vec<(Vec<Deed>, &str)> = vec![
        (
            vec![Deed::Raw("hello".to_owned())],
            "the bridge sent what is not JSON: `hello`",
        ),
        (
            vec![Deed::Raw("{}".to_owned())],
            "the bridge sent a message that has no `op`: `{}`",
        ),
        (vec![Deed::Raw(long)], "it sent a message longer than 4 MiB"),
        (vec![Deed::Binary], "it sent a binary message"),
        (
            vec![Deed::Send(
                json!({"op": "action_result", "id": "other", "status": 4, "values": {}}),
            )],
            "the bridge sent a result for `other`, which is no goal under way",
        ),
        (
            vec![Deed::Send(
                json!({"op": "action_feedback", "id": "other", "values": {}}),
            )],
            "the bridge sent feedback for `other`, which is no goal of this run",
        ),
        (vec![Deed::Close], "the robot is gone: the bridge closed the connection"),
        (vec![Deed::Drop], "the robot is gone: "),
        (
            vec![],
            "the robot did not answer within 0.3 s: step 1: `/execute_step` gave no sign that it accepted the goal",
        ),
        (vec![listed(&[(1, 2)])], "the robot did not answer within 0.6 s: step 1"),
    ];
    for (deeds, expected) in table {
        let bridge = Bridge::with_goals(move |_| deeds.clone());
        let mut robot = bridge.connect(SHORT).unwrap();
        let error = performed(&mut robot, &grasp(1)).unwrap_err();
        assert!(
            error.is_final() && error.to_string().contains(expected),
            "{expected}: {error}"
        );
        assert_eq!(robot.start(&grasp(2)), Err(error.clone()));
        assert_eq!(robot.observe(&Scope::All), Err(error));
        // The stop is confirmed over this connection, or over a new one.
        assert_eq!(robot.stop(), Ok(()), "{expected}");
        assert_eq!(bridge.received("send_action_goal").len(), 1, "{expected}");
    }
}

#[test]
fn results_that_end_the_run_leave_nothing_to_cancel() {
    for (status, values, expected) in [
        (6, json!("goal rejected"), "the robot rejected step 1: goal rejected"),
        (
            5,
            json!({"a": 1}),
            "step 1 was cancelled by the robot: the result is {\"a\":1}",
        ),
        (
            2,
            json!({}),
            "the robot broke the protocol: the result of step 1 has the status Executing",
        ),
        (
            9,
            json!({}),
            "the robot broke the protocol: the result of step 1 has no status",
        ),
    ] {
        let bridge = Bridge::with_goals(move |goal| vec![ended(goal, status, values.clone())]);
        let mut robot = bridge.connect("").unwrap();
        let error = performed(&mut robot, &grasp(1)).unwrap_err();
        assert_eq!(error.to_string(), expected);
        assert_eq!(robot.stop(), Ok(()));
        assert!(bridge.received("cancel_action_goal").is_empty());
    }
    let bridge = Bridge::with_goals(|goal| vec![ended(goal, 6, json!({}))]);
    let mut robot = bridge.connect("").unwrap();
    let reason = "the result is {}".to_owned();
    assert_eq!(
        performed(&mut robot, &grasp(1)),
        Ok(Progress::Failed { reason }),
        "an abort is a failed step"
    );
    assert!(robot.start(&grasp(2)).is_ok());
}

#[test]
fn connect_reports_missing_servers_before_sending_a_goal() {
    let refused = |message: &Value| {
        vec![Deed::Send(
            json!({"op": "service_response", "id": message["id"], "result": false, "values": "no such service"}),
        )]
    };
    let other = |message: &Value| match message["op"].as_str().unwrap() {
        "subscribe" => vec![Deed::Send(json!({
            "op": "status", "level": "error", "id": message["id"], "msg": "it is a other_msgs/action/Walk_FeedbackMessage"
        }))],
        _ => usual(message),
    };
    let table: Vec<(Bridge, &str)> = vec![
        (
            Bridge::new(refused),
            "no action server `/execute_step` answers: no such service",
        ),
        (
            Bridge::new(|_| Vec::new()),
            "no action server `/execute_step` answers: no answer within 0.3 s",
        ),
        (
            Bridge::new(other),
            "`/execute_step` does not have the type `longstep_msgs/action/ExecuteStep`: it is a other_msgs",
        ),
        (Bridge::new(|_| vec![Deed::Drop]), "the robot is gone: "),
    ];
    for (bridge, expected) in table {
        let error = bridge.connect(SHORT).err().unwrap().to_string();
        assert!(error.contains(expected), "{expected}: {error}");
        assert!(bridge.received("send_action_goal").is_empty());
    }
    let busy = Bridge::new(|message| match message["topic"].as_str() {
        Some("/execute_step/_action/status") => vec![listed(&[(1, 4), (2, 2)])],
        _ => usual(message),
    });
    let error = busy.connect(SHORT).err().unwrap();
    assert!(matches!(error, RobotError::UnderWay { .. }), "{error}");
    assert!(
        error.to_string().starts_with("`/execute_step` has a goal under way: "),
        "{error}"
    );
    // A bridge that does not complain about types: the server is there, and more cannot be known.
    let quiet = Bridge::with_goals(|goal| vec![ended(goal, 4, json!({}))]);
    let silent = Bridge::new(|message| match message["op"].as_str().unwrap() {
        "subscribe" => Vec::new(),
        _ => usual(message),
    });
    for (bridge, expected) in [
        (&quiet, "answers, longstep_msgs"),
        (&silent, "answers; the bridge does not say"),
    ] {
        let found = trials(bridge.configuration(SHORT), &household(), None);
        let results: Vec<String> = found.iter().map(|own| own.result.clone().unwrap()).collect();
        assert!(results[1].starts_with(expected), "{results:?}");
        assert_eq!(results[2], "entities described: 1");
        assert!(bridge.received("send_action_goal").is_empty());
    }
}

#[test]
fn servers_that_are_no_bridge_are_unreachable() {
    let mute = TcpListener::bind("127.0.0.1:0").unwrap();
    let web = TcpListener::bind("127.0.0.1:0").unwrap();
    let (mute_port, web_port) = (mute.local_addr().unwrap().port(), web.local_addr().unwrap().port());
    thread::spawn(move || {
        for stream in web.incoming() {
            let _ = std::io::Write::write_all(&mut stream.unwrap(), b"HTTP/1.1 200 OK\r\ncontent-length: 0\r\n\r\n");
        }
    });
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    for (port, expected) in [
        (mute_port, "it does not answer"),
        (web_port, "it is no bridge: "),
        (closed, "refused"),
    ] {
        let received = Arc::default();
        let bridge = Bridge { port, received };
        let error = bridge.connect(SHORT).err().unwrap();
        assert!(matches!(error, RobotError::Unreachable { .. }));
        assert!(error.to_string().contains(expected), "{expected}: {error}");
    }
}

#[test]
fn a_stop_cancels_every_goal_and_waits_for_its_end() {
    let bridge = Bridge::with_goals(|goal| vec![feedback(goal)]);
    let mut robot = bridge.connect("").unwrap();
    let handles = [robot.start(&grasp(1)).unwrap(), robot.start(&grasp(2)).unwrap()];
    assert_eq!(robot.start(&grasp(3)), Err(RobotError::Busy { limit: 2 }));
    let switch = robot.stop_switch();
    thread::spawn(move || switch.press()).join().unwrap();
    assert_eq!(robot.poll(handles[0]), Err(RobotError::Stopped));
    assert_eq!(robot.stop(), Ok(()));
    let sent: Vec<Value> = bridge
        .received("send_action_goal")
        .iter()
        .map(|own| own["id"].clone())
        .collect();
    let mut cancelled: Vec<Value> = bridge
        .received("cancel_action_goal")
        .iter()
        .map(|own| own["id"].clone())
        .collect();
    cancelled.dedup();
    assert_eq!(cancelled, sent);
}

#[test]
fn a_stop_that_nobody_confirms_is_an_error() {
    let bridge = Bridge::new(|message| match message["op"].as_str().unwrap() {
        "send_action_goal" => vec![feedback(message)],
        "cancel_action_goal" => Vec::new(),
        _ => usual(message),
    });
    let mut robot = bridge.connect(SHORT).unwrap();
    robot.start(&grasp(1)).unwrap();
    let limit = Duration::from_millis(300);
    let what = "stop".to_owned();
    assert_eq!(robot.stop(), Err(RobotError::TimedOut { what, limit }));
    let all = bridge.received("call_service");
    let all = all
        .iter()
        .filter(|own| own["args"]["goal_info"]["goal_id"]["uuid"] == json!(vec![0; 16]));
    assert!(
        all.count() > 0,
        "after the goal itself, all goals of the server are cancelled"
    );
}

#[test]
fn a_bridge_that_comes_back_is_told_to_cancel() {
    let bridge = Bridge::with_goals(|_| vec![Deed::Drop]);
    let mut robot = bridge.connect("").unwrap();
    let error = performed(&mut robot, &grasp(1)).unwrap_err();
    assert!(matches!(error, RobotError::Gone { .. }), "{error}");
    assert_eq!(robot.stop(), Ok(()));
    assert!(
        bridge.received("cancel_action_goal").is_empty(),
        "the new connection does not know the goal"
    );
    let last = bridge.received("call_service").pop().unwrap();
    assert_eq!(last["service"], "/execute_step/_action/cancel_goal");
    assert_eq!(last["args"]["goal_info"]["goal_id"]["uuid"], json!(vec![0; 16]));
}

#[test]
fn a_bridge_that_gives_no_sign_of_life_is_gone() {
    let bridge = Bridge::with_goals(|_| vec![listed(&[(1, 2)]), Deed::Freeze]);
    let mut robot = bridge.connect("[timeouts]\nsilence = 0.4\nstop = 0.3").unwrap();
    let error = performed(&mut robot, &grasp(1)).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the robot is gone: the bridge gave no sign of life for 0.4 s"
    );
    drop(robot.stop());
    assert_eq!(bridge.received("send_action_goal").len(), 1);
}

/// The behaviour of a server with a goal that an earlier run left.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Leftover {
    /// The goal ends a moment after its cancellation was accepted; a second cancellation finds nothing to cancel.
    Ends,
    /// There is none, and the server never had one.
    Nothing,
    /// Its end is listed before anything is cancelled.
    EndedBefore,
    /// The server accepts no cancellation.
    Refuses,
    /// The server accepts no cancellation and answers as `rclpy` does: there is nothing to cancel.
    HasNothing,
    /// The cancellation is accepted, and the goal goes on.
    GoesOn,
    /// The cancellation is accepted, the goal goes on, and the bridge lists no goals.
    GoesOnUnlisted,
    /// The bridge does not answer a cancellation.
    Silent,
}

/// A bridge whose server is asked to cancel all of its goals.
fn bridge_with(leftover: Leftover) -> Bridge {
    let cancelled = std::sync::atomic::AtomicUsize::new(0);
    let list = |status| {
        Deed::Send(
            json!({"op": "publish", "topic": "/execute_step/_action/status", "msg": {"status_list": [
        {"goal_info": {"goal_id": {"uuid": vec![7; 16]}}, "status": status}]}}),
        )
    };
    Bridge::new(move |message| {
        let is_cancel = message["service"] == "/execute_step/_action/cancel_goal";
        let is_all = is_cancel && message["args"]["goal_info"]["goal_id"]["uuid"] == json!(vec![0; 16]);
        let is_status = message["op"] == "subscribe" && message["topic"] == "/execute_step/_action/status";
        match (leftover, is_all, is_status) {
            (Leftover::Nothing, _, true) => Vec::new(),
            (Leftover::EndedBefore, _, true) => vec![list(5)],
            (Leftover::GoesOnUnlisted, _, true) => vec![Deed::Send(
                json!({"op": "status", "level": "error", "id": message["id"], "msg": "no such type"}),
            )],
            (_, _, true) => vec![list(2)],
            (Leftover::Silent, true, _) => Vec::new(),
            (Leftover::HasNothing, true, _) => vec![answer(message, json!({"return_code": 0, "goals_canceling": []}))],
            (Leftover::Refuses, true, _) => vec![answer(message, json!({"return_code": 1, "goals_canceling": []}))],
            (Leftover::Ends | Leftover::GoesOn | Leftover::GoesOnUnlisted, true, _) => {
                let count = cancelled.fetch_add(1, std::sync::atomic::Ordering::SeqCst);
                let goals = if count == 0 {
                    json!([{"goal_id": {"uuid": vec![7; 16]}}])
                } else {
                    json!([])
                };
                let mut deeds = vec![answer(message, json!({"return_code": 0, "goals_canceling": goals}))];
                if leftover == Leftover::Ends {
                    deeds.push(list(if count == 0 { 3 } else { 5 }));
                }
                deeds
            }
            _ => usual(message),
        }
    })
}

#[test]
fn goals_that_an_interrupted_run_left_are_ended_before_anything_else() {
    let limits = "[timeouts]\nstop = 0.5";
    for (leftover, expected) in [
        (Leftover::Ends, Ok(1)),
        (Leftover::Nothing, Ok(0)),
        (Leftover::EndedBefore, Ok(0)),
        (Leftover::Refuses, Err("the server does not accept its cancellation")),
        (Leftover::HasNothing, Err("the server does not accept its cancellation")),
        (
            Leftover::GoesOn,
            Err("it did not end within 0.5 s after its cancellation"),
        ),
        (
            Leftover::GoesOnUnlisted,
            Err("it did not end within 0.5 s after its cancellation"),
        ),
        (
            Leftover::Silent,
            Err("the server did not answer its cancellation within 0.5 s"),
        ),
    ] {
        let bridge = bridge_with(leftover);
        let begun = Instant::now();
        let robot = Ros2::reconnect(bridge.configuration(limits), &household());
        assert!(begun.elapsed() < Duration::from_secs(5));
        match (robot, expected) {
            (Ok(robot), Ok(count)) => assert_eq!(robot.cancelled(), count, "{leftover:?}"),
            (Err(error), Err(reason)) => {
                assert!(matches!(error, RobotError::UnderWay { .. }), "{leftover:?}: {error}");
                assert!(error.to_string().contains(reason), "{leftover:?}: {error}");
            }
            (found, _) => panic!("{leftover:?}: {:?}", found.err()),
        }
        assert!(bridge.received("send_action_goal").is_empty());
        let calls = bridge.received("call_service");
        assert!(calls.iter().all(|call| call["service"] != "/observe"), "{leftover:?}");
    }
}

#[test]
fn orders_keep_to_the_rate_and_heartbeats_are_sent() {
    let bridge = Bridge::with_goals(|goal| vec![ended(goal, 4, json!({}))]);
    let text = "[heartbeat]\ntopic = \"/heartbeat\"\nperiod = 0.01";
    let configuration = ROBOT
        .replace("PORT", &bridge.port.to_string())
        .replace("rate = 1000", "rate = 10");
    let configuration = Configuration::parse("robot.toml", &configuration.replace("MORE", text)).unwrap();
    let mut robot = Ros2::connect(configuration, &household()).unwrap();
    let begun = Instant::now();
    for step in 1..=3 {
        assert_eq!(
            performed(&mut robot, &grasp(step)),
            Ok(Progress::Done { outcome: None })
        );
    }
    assert!(begun.elapsed() >= Duration::from_millis(200), "two pauses of 100 ms");
    drop(robot);
    assert_eq!(bridge.received("advertise")[0]["type"], "std_msgs/msg/UInt64");
    let beats: Vec<u64> = bridge
        .received("publish")
        .iter()
        .map(|own| own["msg"]["data"].as_u64().unwrap())
        .collect();
    let expected: Vec<u64> = (1..=beats.len() as u64).collect();
    assert!(beats.len() > 3, "{beats:?}");
    assert_eq!(beats, expected);
}

/// A bridge that keeps what it is sent until a goal has ended, as rosbridge_suite does without threads for goals. The goal is
/// answered behind four heartbeats; `returns` says if they come back.
fn blocked_bridge(returns: bool, end: impl Fn(&Value) -> Deed + Send + Sync + 'static) -> Bridge {
    let goal: Mutex<Option<(Value, usize)>> = Mutex::new(None);
    Bridge::new(move |message| {
        let mut goal = goal.lock().unwrap();
        match message["op"].as_str().unwrap() {
            "send_action_goal" => {
                *goal = Some((message.clone(), 0));
                vec![feedback(message)]
            }
            "cancel_action_goal" => vec![ended(message, 5, json!({}))],
            "publish" => {
                let back = Deed::Send(json!({"op": "publish", "topic": message["topic"], "msg": message["msg"]}));
                let Some((own, beats)) = goal.as_mut() else {
                    return vec![back];
                };
                *beats += 1;
                match (*beats, returns) {
                    (4, _) => vec![end(own)],
                    (_, true) => vec![back],
                    (_, false) => Vec::new(),
                }
            }
            _ => usual(message),
        }
    })
}

#[test]
fn failed_steps_are_uncertain_if_the_bridge_withholds_heartbeats() {
    let aborted = |goal: &Value| ended(goal, 6, json!({"message": "no heartbeat"}));
    let blocked = "the bridge passes nothing on while a goal is under way: step 1 ended without success, and ";
    for (returns, bridge, expected) in [
        (false, blocked_bridge(false, aborted), Err(blocked)),
        (true, blocked_bridge(true, aborted), Ok("the result is")),
        (
            false,
            blocked_bridge(false, |goal| ended(goal, 4, json!({}))),
            Ok("Done"),
        ),
    ] {
        let mut robot = bridge
            .connect("[heartbeat]\ntopic = \"/heartbeat\"\nperiod = 0.02")
            .unwrap();
        // The first heartbeat has come back before a goal is sent.
        let begun = Instant::now();
        while bridge.received("publish").len() < 3 && begun.elapsed() < Duration::from_secs(20) {
            robot.wait(Duration::from_millis(10));
        }
        match (performed(&mut robot, &grasp(1)), expected) {
            (Ok(end), Ok(expected)) => assert!(format!("{end:?}").contains(expected), "{returns}: {end:?}"),
            (Err(error), Err(expected)) => {
                assert!(error.to_string().starts_with(expected), "{error}");
                assert!(error.hint().unwrap().contains("send_action_goals_in_new_thread:=true"));
            }
            (other, _) => panic!("{returns}: {other:?}"),
        }
    }
}

/// Answers of rosbridge_suite for its parameter.
#[test]
fn a_bridge_without_threads_for_goals_is_found_before_anything_is_sent() {
    let asked = |kind: u64, value: bool| {
        Bridge::new(move |message| match message["service"].as_str() {
            Some("/rosbridge_websocket/get_parameters") => {
                assert_eq!(message["args"]["names"], json!(["send_action_goals_in_new_thread"]));
                vec![answer(
                    message,
                    json!({"values": [{"type": kind, "bool_value": value, "integer_value": 0}]}),
                )]
            }
            _ => usual(message),
        })
    };
    let expected = "the bridge passes nothing on while a goal is under way: its parameter `send_action_goals_in_new_thread` is false";
    let blocked = asked(1, false);
    assert_eq!(blocked.connect(SHORT).err().unwrap().to_string(), expected);
    let found = trials(blocked.configuration(SHORT), &household(), None);
    assert_eq!(found.len(), 1);
    assert_eq!(found[0].result.clone().unwrap_err().to_string(), expected);
    assert!(blocked.received("send_action_goal").is_empty());
    // A bridge with the parameter, and one that does not have it (`PARAMETER_NOT_SET`).
    for (bridge, expected) in [
        (asked(1, true), "connected; goals have threads of their own"),
        (
            asked(0, false),
            "connected; the bridge does not say if goals have threads of their own",
        ),
    ] {
        let found = trials(bridge.configuration(SHORT), &household(), None);
        assert_eq!(found[0].result, Ok(expected.to_owned()));
    }
}

#[test]
fn topics_are_observed_when_they_are_new() {
    let bridge = Bridge::new(|message| match message["topic"].as_str() {
        Some("/seen") => vec![Deed::Send(
            json!({"op": "publish", "topic": "/seen", "msg": {"name": "<cup>", "on": "<desk>"}}),
        )],
        Some("/door") => vec![Deed::Send(
            json!({"op": "publish", "topic": "/door", "msg": {"data": true}}),
        )],
        _ => usual(message),
    });
    let topics = |latched: bool| {
        let text = ROBOT.replace("PORT", &bridge.port.to_string()).replace("MORE", SHORT);
        let observations = format!(
            "[[observation]]\ntopic = \"/seen\"\nlatched = {latched}\ntype = \"a_msgs/msg/Seen\"\nentity = \"{{name}}\"\n\
             say = [{{ state = \"on_something({{on}})\" }}]\n\
             [[observation]]\ntopic = \"/door\"\nlatched = true\ntype = \"std_msgs/msg/Bool\"\nentity = \"<fridge_handle>\"\n\
             say = [{{ state = \"open()\", when = {{ data = true }} }}, {{ state = \"closed()\", when = {{ data = false }} }}]\n"
        );
        let (actions, _) = text.split_once("[[observation]]").unwrap();
        Configuration::parse("robot.toml", &format!("{actions}{observations}")).unwrap()
    };
    let mut robot = Ros2::connect(topics(true), &household()).unwrap();
    let seen = robot.observe(&Scope::All).unwrap();
    let expected = r#"{"states":{"<cup>":["on_something(<desk>)"],"<fridge_handle>":["open()"]}}"#;
    assert_eq!(serde_json::to_string(&seen).unwrap(), expected);
    let mut robot = Ros2::connect(topics(false), &household()).unwrap();
    thread::sleep(Duration::from_millis(50));
    let (what, limit) = ("observe (`/seen`)".to_owned(), Duration::from_millis(300));
    assert_eq!(
        robot.observe(&Scope::All),
        Err(RobotError::TimedOut { what, limit }),
        "the message is an old one"
    );
}
