//! `longstep serve` and `longstep mcp` as programs: the model that is lent, tools for agents, and their ends.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::time::Duration;

use common::{Answer, Ran, Server, goals, longstep, run};
use serde_json::{Value, json};

const PANTRY: &str = "examples/environments/pantry.json";

/// A program that runs until the test is over.
struct Running {
    child: Child,
    input: Option<ChildStdin>,
    output: BufReader<std::process::ChildStdout>,
    errors: BufReader<std::process::ChildStderr>,
}

impl Running {
    fn start(command: &mut Command) -> Self {
        let command = command
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        let mut child = command.spawn().unwrap();
        Self {
            input: child.stdin.take(),
            output: BufReader::new(child.stdout.take().unwrap()),
            errors: BufReader::new(child.stderr.take().unwrap()),
            child,
        }
    }

    /// Reads lines until one contains the text.
    fn line(reader: &mut impl BufRead, text: &str) -> String {
        let mut read = String::new();
        loop {
            let mut line = String::new();
            assert_ne!(reader.read_line(&mut line).unwrap(), 0, "it ended after {read}");
            if line.contains(text) {
                return line;
            }
            read += &line;
        }
    }

    fn ask(&mut self, message: &Value) -> Value {
        writeln!(self.input.as_mut().unwrap(), "{message}").unwrap();
        let mut line = String::new();
        self.output.read_line(&mut line).unwrap();
        serde_json::from_str(&line).unwrap_or_else(|error| panic!("{error}: {line}"))
    }

    fn call(&mut self, tool: &str, arguments: &Value) -> Value {
        let call = json!({"jsonrpc": "2.0", "id": 7, "method": "tools/call", "params": {"name": tool, "arguments": arguments}});
        self.ask(&call)["result"].take()
    }

    fn initialize(&mut self) -> Value {
        let reply = self.ask(&initialize());
        let ready = json!({"jsonrpc": "2.0", "method": "notifications/initialized"});
        writeln!(self.input.as_mut().unwrap(), "{ready}").unwrap();
        reply
    }

    /// Sends a signal, and returns the exit code.
    fn end(mut self, signal: &str) -> Option<i32> {
        let id = self.child.id().to_string();
        assert!(Command::new("kill").args([signal, &id]).status().unwrap().success());
        drop(self.input.take());
        let Self { child, .. } = self;
        common::ended(child, Duration::from_secs(30)).status.code()
    }
}

fn initialize() -> Value {
    json!({"jsonrpc": "2.0", "id": 1, "method": "initialize", "params": {
        "protocolVersion": "2025-11-25", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}})
}

/// Starts `longstep serve`; returns it with its address and its token.
fn serve(home: &Path, arguments: &[&str]) -> (Running, String, String) {
    let mut command = longstep(home);
    command.args(["serve", "--listen", "127.0.0.1:0"]).args(arguments);
    let mut running = Running::start(&mut command);
    let line = Running::line(&mut running.output, "http://");
    let link = line.split_whitespace().last().unwrap();
    let (address, token) = link.split_once("/?token=").unwrap();
    let (address, token) = (address.to_owned(), token.to_owned());
    (running, address, token)
}

fn plan(home: &Path, arguments: &[&str], variables: &[(&str, &str)]) -> Ran {
    let mut command = longstep(home);
    command
        .args(["plan", "Put the cereal on the counter", "--env", PANTRY, "--json"])
        .args(arguments)
        .envs(variables.iter().copied());
    run(&mut command, "")
}

/// The answer without what it took.
fn timeless(ran: &Ran) -> Value {
    let mut answer: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert!(answer.as_object_mut().unwrap().remove("timings_ms").is_some());
    answer
}

fn post(address: &str, path: &str, token: Option<&str>, body: &Value) -> (u16, String) {
    let host = address.strip_prefix("http://").unwrap();
    let mut stream = TcpStream::connect(host).unwrap();
    let body = body.to_string();
    let authorization = token.map_or_else(String::new, |token| format!("Authorization: Bearer {token}\r\n"));
    write!(
        stream,
        "POST {path} HTTP/1.1\r\nHost: {host}\r\n{authorization}Content-Type: application/json\r\n\
         Accept: application/json, text/event-stream\r\nConnection: close\r\nContent-Length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    (answer[9..12].parse().unwrap(), answer)
}

#[test]
fn plan_with_a_lent_model_is_that_of_the_model() {
    let home = tempfile::tempdir().unwrap();
    let model = Server::answering(|_, _| goals(&["put(cereal, counter)"]));
    let (server, address, token) = serve(home.path(), &["--model", &model.reference()]);
    let own = plan(home.path(), &["--model", &model.reference()], &[]);
    assert_eq!(own.code, 0, "{own:?}");
    // The token of this user is in a file; another one is said.
    let lent = [
        plan(home.path(), &["--server", &address], &[]),
        plan(home.path(), &[], &[("LONGSTEP_SERVER", &address)]),
        plan(
            home.path(),
            &["--model", &format!("longstep:{address}")],
            &[("LONGSTEP_TOKEN", &token)],
        ),
    ];
    for lent in lent {
        assert_eq!((lent.code, timeless(&lent)), (0, timeless(&own)), "{}", lent.stderr);
    }
    let bodies = model.bodies();
    assert_eq!(bodies.len(), 4);
    assert!(bodies.iter().all(|body| body["messages"] == bodies[0]["messages"]));
    assert_eq!(server.end("-TERM"), Some(0));
}

#[test]
fn lent_model_that_cannot_be_had_is_an_error_that_says_why() {
    let home = tempfile::tempdir().unwrap();
    let model = Server::answering(|_, _| Answer::Status(400, json!({"error": {"message": "the disk is on fire"}})));
    let (with, address, token) = serve(home.path(), &["--model", &model.reference()]);
    let other = tempfile::tempdir().unwrap();
    let (without, bare, _) = serve(other.path(), &["--no-model"]);
    type Case<'a> = (&'a [&'a str], &'a [(&'a str, &'a str)], &'a str);
    let table: [Case<'_>; 6] = [
        (&["--server", &address], &[("LONGSTEP_TOKEN", "wrong")], "status 401"),
        (&["--server", &address, "--temperature", "1"], &[], "leave them out"),
        (&["--server", "http://127.0.0.1:1"], &[], "cannot be reached"),
        (&["--server", "127.0.0.1:1"], &[], "must be the address"),
        (&["--server", &address], &[], "the disk is on fire"),
        (&["--server", model.base()], &[], "this is no server of Longstep"),
    ];
    for (arguments, variables, expected) in table {
        let failed = plan(home.path(), arguments, variables);
        assert!(
            failed.code != 0 && failed.stderr.contains(expected),
            "{arguments:?}: {failed:?}"
        );
        assert!(!format!("{failed:?}").contains(&token));
    }
    let failed = plan(other.path(), &["--server", &bare], &[]);
    assert!(failed.stderr.contains("this server has no model"), "{failed:?}");
    assert_eq!((with.end("-TERM"), without.end("-INT")), (Some(0), Some(0)));
}

#[test]
fn agents_plan_and_leave_the_approval_to_a_person() {
    let home = tempfile::tempdir().unwrap();
    let model = Server::answering(|_, _| goals(&["put(cereal, counter)"]));
    let begin = |arguments: &[&str]| {
        let mut command = longstep(home.path());
        command
            .args(["mcp", "--env", PANTRY, "--model", &model.reference()])
            .args(arguments);
        Running::start(&mut command)
    };
    let mut agent = begin(&["--listen", "127.0.0.1:0"]);
    let link = Running::line(&mut agent.errors, "/?token=");
    let (address, token) = link.split_whitespace().last().unwrap().split_once("/?token=").unwrap();
    assert_eq!(agent.initialize()["result"]["serverInfo"]["name"], "longstep");
    // A second agent has approvals of its own.
    let mut second = begin(&[]);
    second.initialize();

    let planned = agent.call("plan", &json!({"instruction": "Put the cereal on the counter"}));
    let offer = &planned["structuredContent"];
    let (id, hash) = (offer["plan_id"].clone(), offer["hash"].clone());
    assert!(id.is_string() && hash.is_string(), "{planned}");
    let refused = agent.call("execute_plan", &json!({"plan_id": id, "hash": hash}));
    let text = refused["content"][0]["text"].as_str().unwrap();
    assert!(
        text.contains(&format!("{address}/sessions/")) && !text.contains(token),
        "{text}"
    );
    assert!(
        !home
            .path()
            .join("state/longstep/mcp/records")
            .read_dir()
            .unwrap()
            .any(|entry| { entry.unwrap().file_name().to_string_lossy().starts_with("use-") })
    );

    let alone = second.call("plan", &json!({"instruction": "Put the cereal on the counter"}));
    let offer = &alone["structuredContent"];
    let refused = second.call(
        "execute_plan",
        &json!({"plan_id": offer["plan_id"], "hash": offer["hash"]}),
    );
    let text = refused["content"][0]["text"].as_str().unwrap();
    assert!(text.contains("--listen"), "{text}");
    // One ends with a signal, the other with its client.
    assert_eq!(agent.end("-TERM"), Some(0));
    drop(second.input.take());
    assert_eq!(
        common::ended(second.child, Duration::from_secs(30)).status.code(),
        Some(0)
    );
}

#[test]
fn serve_has_the_tools_of_agents_behind_its_token() {
    let home = tempfile::tempdir().unwrap();
    let (server, address, token) = serve(home.path(), &["--no-model"]);
    let (status, answer) = post(&address, "/mcp", Some(&token), &initialize());
    assert!(status == 200 && answer.contains("\"serverInfo\""), "{answer}");
    for wrong in [None, Some("wrong")] {
        assert_eq!(post(&address, "/mcp", wrong, &initialize()).0, 401);
    }
    assert_eq!(server.end("-TERM"), Some(0));
}
