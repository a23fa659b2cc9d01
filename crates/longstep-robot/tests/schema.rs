//! The published schema says what is really sent, and the example of the page is a robot.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic)]

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::time::Duration;

use boon::{Compiler, SchemaIndex, Schemas};
use longstep_core::environment::Environment;
use longstep_robot::process::{Command, Process};
use longstep_robot::{ArgumentValue, Order, Progress, Robot, RobotError, Scope};
use serde_json::{Value, json};

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../docs")
}

/// The schemas of the messages, compiled once.
struct Messages {
    schemas: Schemas,
    compiler: Compiler,
}

impl Messages {
    fn new() -> Self {
        let mut compiler = Compiler::new();
        for name in ["plan", "robot"] {
            let file = docs().join(format!("../schemas/{name}.schema.json"));
            let text = std::fs::read_to_string(file).unwrap();
            let location = format!("https://github.com/longstep/longstep/schemas/{name}.schema.json");
            compiler
                .add_resource(&location, serde_json::from_str(&text).unwrap())
                .unwrap();
        }
        let schemas = Schemas::new();
        Self { schemas, compiler }
    }

    fn index(&mut self, definition: &str) -> SchemaIndex {
        let location = format!("https://github.com/longstep/longstep/schemas/robot.schema.json#/$defs/{definition}");
        self.compiler.compile(&location, &mut self.schemas).unwrap()
    }

    #[track_caller]
    fn check(&mut self, definition: &str, value: &Value) {
        let index = self.index(definition);
        if let Err(error) = self.schemas.validate(value, index) {
            panic!("{value} is no {definition}: {error}");
        }
    }

    fn accepts(&mut self, definition: &str, value: &Value) -> bool {
        let index = self.index(definition);
        self.schemas.validate(value, index).is_ok()
    }
}

/// A program between Longstep and a robot, which writes down the lines of both.
const TAP: &str = r#"
import subprocess, sys, threading
robot = subprocess.Popen(["python3", sys.argv[1]], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
log = open(sys.argv[2], "w", buffering=1)
def copy(mark, source, target):
    for line in source:
        log.write(mark + line)
        target.write(line)
        target.flush()
    target.close()
threading.Thread(target=copy, args=("<", robot.stdout, sys.stdout), daemon=True).start()
copy(">", sys.stdin, robot.stdin)
robot.wait()
"#;

/// Starts the example of docs/guide/robots.md behind the tap.
fn example(folder: &Path) -> (Process, PathBuf) {
    let page = std::fs::read_to_string(docs().join("guide/robots.md")).unwrap();
    let block = page.split("```python\n").nth(1).unwrap().split("```").next().unwrap();
    let lines = block.lines().count();
    assert!(lines <= 35, "the example has {lines} lines");
    for (name, text) in [("robot.py", block), ("tap.py", TAP)] {
        std::fs::write(folder.join(name), text).unwrap();
    }
    let scene =
        r#"{"assets": ["<wall>"], "objects": ["<lamp>"], "object_states": {"<lamp>": ["on_something(<wall>)"]}}"#;
    let command = Command::parse("python3 tap.py robot.py log").unwrap();
    let command = command
        .folder(folder)
        .scene("home", Environment::from_json(scene).unwrap());
    (command.open().unwrap(), folder.join("log"))
}

#[test]
fn example_robot_of_the_guide_obeys_the_protocol() {
    let folder = tempfile::tempdir().unwrap();
    let (mut robot, log) = example(folder.path());
    let description = robot.describe().clone();
    assert_eq!(
        (description.name.as_str(), description.parallel, description.observes),
        ("lamp", 1, true)
    );
    assert!(description.can_perform("switch-on") && !description.can_perform("grasp"));
    let unsupported = robot.start(&Order::new(1, "grasp", ["<lamp>"]));
    assert_eq!(
        unsupported,
        Err(RobotError::Unsupported {
            action: "grasp".to_owned()
        })
    );

    let mut order = Order::new(1, "switch-on", ["<lamp>", "5 s", "\"hi\""]);
    order.lane = Some("left".to_owned());
    order.values = vec![
        ArgumentValue {
            argument: 1,
            number: Some(5.0),
            unit: Some("s".to_owned()),
            text: None,
        },
        ArgumentValue {
            argument: 2,
            number: None,
            unit: None,
            text: Some("hi".to_owned()),
        },
    ];
    order.skills.insert("force".to_owned(), json!(1.5));
    let handle = robot.start(&order).unwrap();
    let mut fractions = Vec::new();
    let progress = loop {
        match robot.poll(handle).unwrap() {
            Progress::Running(feedback) => fractions.extend(feedback.and_then(|feedback| feedback.fraction)),
            progress => break progress,
        }
        robot.wait(Duration::from_millis(50));
    };
    assert_eq!(progress, Progress::Done { outcome: None });
    assert_eq!(fractions.len(), 10);
    let seen = robot.observe(&Scope::Entities(vec!["<lamp>".to_owned()])).unwrap();
    assert_eq!(seen.of_entity("<lamp>"), Some(&["on()".to_owned()][..]));

    // A stop in the middle of a step: the lamp stays on.
    robot.start(&Order::new(2, "switch-off", ["<lamp>"])).unwrap();
    robot.stop().unwrap();
    drop(robot);
    check_log(&log);
}

/// Checks every line of the log against its schema.
fn check_log(log: &Path) {
    let mut messages = Messages::new();
    let mut methods = BTreeMap::new();
    let mut kinds = Vec::new();
    for line in std::fs::read_to_string(log).unwrap().lines() {
        let (mark, text) = line.split_at(1);
        let value: Value = serde_json::from_str(text).unwrap();
        if mark == ">" {
            let method = value["method"].as_str().unwrap().to_owned();
            messages.check("request", &value);
            messages.check(&method, &value);
            methods.insert(value["id"].as_u64().unwrap(), method.clone());
            kinds.push(method);
        } else if let Some(id) = value.get("id") {
            messages.check("answer", &value);
            let definition = format!("{}_result", methods[&id.as_u64().unwrap()]);
            messages.check(&definition, &value["result"]);
            kinds.push(definition);
        } else {
            messages.check("feedback", &value);
        }
    }
    let expected = [
        "initialize",
        "initialize_result",
        "perform",
        "perform_result",
        "observe",
        "observe_result",
        "perform",
        "stop",
        "stop_result",
        "shutdown",
    ];
    assert_eq!(kinds, expected);
}

/// Answers that the reader accepts and the schema too, or neither.
#[test]
fn the_schema_is_as_strict_as_the_reader() {
    let mut messages = Messages::new();
    let table = [
        (r#"{"protocol": 1, "name": "r"}"#, true),
        (
            r#"{"protocol": 1, "name": "r", "timeouts": {"actions": {"wipe": 3}}, "capabilities": {"parallel": 2}}"#,
            true,
        ),
        (r#"{"protocol": 1, "name": "r", "simulated": true}"#, true),
        (r#"{"protocol": 1, "name": "r", "simulated": "yes"}"#, false),
        (
            r#"{"protocol": 1, "name": "r", "capabilities": {"observe": true, "reports": ["hand-at"]}}"#,
            true,
        ),
        (
            r#"{"protocol": 1, "name": "r", "capabilities": {"reports": "hand-at"}}"#,
            false,
        ),
        (r#"{"protocol": 1}"#, false),
        (r#"{"protocol": 2, "name": "r"}"#, false),
        (r#"{"protocol": 1, "name": 3}"#, false),
        (r#"{"protocol": 1, "name": "r", "timeouts": {"perform": 0}}"#, false),
        (r#"{"protocol": 1, "name": "r", "timeouts": {"perform": 86401}}"#, false),
        (r#"{"protocol": 1, "name": "r", "timeouts": {"shutdown": 3}}"#, false),
        (
            r#"{"protocol": 1, "name": "r", "capabilities": {"parallel": 65}}"#,
            false,
        ),
        (
            r#"{"protocol": 1, "name": "r", "capabilities": {"actions": "grasp"}}"#,
            false,
        ),
        (r#"{"protocol": 1, "name": "r", "more": 1}"#, false),
    ];
    for (answer, fits) in table {
        assert_eq!(
            messages.accepts("initialize_result", &serde_json::from_str(answer).unwrap()),
            fits,
            "{answer}"
        );
        // A robot that gives this answer to `initialize`, and ends with the next request.
        let line = answer.replace('{', r"\173").replace('}', r"\175");
        let program = format!(r#"read line; printf '\173"jsonrpc":"2.0","id":1,"result":{line}\175\n'; read line"#);
        let opened = Command::new(["sh", "-c", &program]).open();
        assert_eq!(opened.is_ok(), fits, "{answer}: {opened:?}");
    }
}
