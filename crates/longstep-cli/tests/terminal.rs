//! `longstep chat` in a terminal: one that `script` makes, which every Linux has.
#![cfg(target_os = "linux")]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::io::{Read, Write};
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use common::{Answer, PANTRY, Server, goals, root};

/// Longer than anything here takes; a conversation that hangs is no reason for a test to.
const PATIENCE: Duration = Duration::from_secs(20);

/// A conversation in a terminal.
struct Terminal {
    child: Child,
    keys: ChildStdin,
    shown: Arc<Mutex<Vec<u8>>>,
    /// How much of it was looked at.
    read: usize,
}

impl Terminal {
    fn chat(server: &Server, home: &std::path::Path) -> Self {
        Self::open(
            home,
            &format!("chat --env {PANTRY} --model {}", server.reference()),
            "xterm",
        )
    }

    fn open(home: &std::path::Path, arguments: &str, terminal: &str) -> Self {
        let program = env!("CARGO_BIN_EXE_longstep");
        // A shell that stayed would get every Ctrl-C as well, and some then end by it whatever the program does.
        let line = format!("stty columns 80 rows 24; exec {program} {arguments}");
        let mut child = Command::new("script")
            .args(["--quiet", "--return", "--command", &line, "/dev/null"])
            .current_dir(root())
            .env("LONGSTEP_SESSIONS", home.join("sessions"))
            .env("LONGSTEP_CACHE", home.join("cache"))
            .env("TERM", terminal)
            .env_remove("LONGSTEP_DOMAIN")
            .env("NO_PROXY", "127.0.0.1")
            .env_remove("LONGSTEP_API_KEY")
            .env_remove("NO_COLOR")
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let shown = Arc::new(Mutex::new(Vec::new()));
        let mut screen = child.stdout.take().unwrap();
        let kept = shown.clone();
        thread::spawn(move || {
            let mut buffer = [0; 1024];
            while let Ok(count @ 1..) = screen.read(&mut buffer) {
                kept.lock().unwrap().extend_from_slice(&buffer[..count]);
            }
        });
        let keys = child.stdin.take().unwrap();
        Self {
            child,
            keys,
            shown,
            read: 0,
        }
    }

    fn press(&mut self, keys: &str) {
        self.keys.write_all(keys.as_bytes()).unwrap();
        self.keys.flush().unwrap();
    }

    /// Waits until this is shown, behind what was waited for before.
    fn expect(&mut self, text: &str) {
        let began = Instant::now();
        loop {
            let shown = self.shown.lock().unwrap().clone();
            let new = String::from_utf8_lossy(&shown[self.read..]).into_owned();
            if let Some(at) = new.find(text) {
                self.read += at + text.len();
                return;
            }
            assert!(began.elapsed() < PATIENCE, "no `{text}` in\n{new:?}");
            thread::sleep(Duration::from_millis(10));
        }
    }

    /// Waits for its end; returns the exit code and everything that was shown.
    fn end(mut self) -> (Option<i32>, String) {
        drop(self.keys);
        let began = Instant::now();
        let code = loop {
            if let Some(status) = self.child.try_wait().unwrap() {
                break status.code();
            }
            if began.elapsed() > PATIENCE {
                let _ = self.child.kill();
                let shown = self.shown.lock().unwrap();
                panic!("it does not end: {:?}", String::from_utf8_lossy(&shown));
            }
            thread::sleep(Duration::from_millis(10));
        };
        // What is left in the pipe comes at once.
        thread::sleep(Duration::from_millis(50));
        let shown = self.shown.lock().unwrap();
        (code, String::from_utf8_lossy(&shown).into_owned())
    }
}

/// Waits until the server was asked so often.
fn asked(server: &Server, times: usize) {
    let began = Instant::now();
    while server.bodies().len() < times {
        assert!(began.elapsed() < PATIENCE, "the server is not asked");
        thread::sleep(Duration::from_millis(10));
    }
}

#[test]
fn ctrl_c_calls_off_the_call_and_not_the_conversation() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::giving(vec![
        Answer::Silence(Duration::from_secs(60)),
        goals(&["put(cereal, counter)"]),
        Answer::Silence(Duration::from_secs(60)),
    ]);
    let mut terminal = Terminal::chat(&server, home.path());
    terminal.expect("> ");
    terminal.press("Put the cereal on the counter\r");
    asked(&server, 1);
    terminal.expect("Waiting for the server");
    terminal.press("\x03");
    terminal.expect("Stopped");
    terminal.expect("> ");
    terminal.press("Put the cereal on the counter\r");
    terminal.expect("Accept?");
    // The words about a plan are called off: the plan is there again.
    terminal.press("not there\r");
    asked(&server, 3);
    terminal.press("\x03");
    terminal.expect("the plan is unchanged");
    terminal.expect("Accept?");
    terminal.press("\r");
    terminal.expect("as plan 0");
    terminal.expect("> ");
    // Where nothing is under way, it takes the line back.
    terminal.press("Put the but\x03");
    terminal.expect("> ");
    terminal.press("\x04");
    let (code, shown) = terminal.end();
    assert_eq!(code, Some(0), "{shown}");
    assert!(
        shown.contains("Resume with: longstep chat --resume pantry-1"),
        "{shown}"
    );
    // There is colour, and nothing of the line that turns is left behind.
    assert!(shown.contains("\x1b[1m"), "{shown:?}");
    assert_eq!(server.bodies().len(), 3);
}

#[test]
fn lines_that_are_typed_while_the_model_works_answer_nothing_by_themselves() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::answering(|number, _| {
        // Long enough to type in, also on a machine that is busy.
        thread::sleep(Duration::from_secs(2));
        goals(&[if number == 0 {
            "put(cereal, counter)"
        } else {
            "put(cereal, floor)"
        }])
    });
    let mut terminal = Terminal::chat(&server, home.path());
    terminal.expect("> ");
    terminal.press("Put the cereal on the counter\r");
    asked(&server, 1);
    terminal.expect("Waiting for the server");
    // An empty line would accept the plan, and the other one would be words about it.
    terminal.press("\rNow put it on the floor\r");
    terminal.expect("Enter sends it");
    terminal.expect("Accept?");
    terminal.expect("Now put it on the floor");
    thread::sleep(Duration::from_millis(300));
    assert_eq!(server.bodies().len(), 1);
    // Cleared, it waits for the next prompt.
    terminal.press("\x15\r");
    terminal.expect("as plan 0");
    terminal.expect("> ");
    terminal.expect("Now put it on the floor");
    terminal.press("\r");
    asked(&server, 2);
    terminal.expect("Accept?");
    // It is used once.
    terminal.press("\r");
    terminal.expect("as plan 1");
    terminal.expect("> ");
    terminal.press("\x04");
    let (code, shown) = terminal.end();
    assert_eq!(code, Some(0), "{shown}");
}

#[test]
fn a_command_that_was_typed_early_is_used_once() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::answering(|_, _| {
        thread::sleep(Duration::from_secs(2));
        goals(&["put(cereal, counter)"])
    });
    let mut terminal = Terminal::chat(&server, home.path());
    terminal.expect("> ");
    terminal.press("Put the cereal on the counter\r");
    asked(&server, 1);
    terminal.press("/rules\r");
    terminal.expect("Enter sends it");
    terminal.expect("/rules");
    terminal.press("\r");
    terminal.expect("No rules");
    // The prompt is empty now: Enter accepts the plan.
    terminal.expect("Accept?");
    terminal.press("\r");
    terminal.expect("as plan 0");
    terminal.expect("> ");
    terminal.press("\x04");
    let (code, shown) = terminal.end();
    assert_eq!(code, Some(0), "{shown}");
    assert_eq!(shown.matches("Enter sends it").count(), 1, "{shown}");
    // Nothing of the wait stands before the result.
    let (before, _) = shown.split_once("Goal").unwrap();
    let line = before.rsplit('\n').next().unwrap();
    assert!(line.contains("\x1b[2K") && !line.ends_with("server"), "{line:?}");
}

/// The plan of a run in `plan.json` of the home folder.
fn planned(home: &std::path::Path) -> String {
    let plan = home.join("plan.json");
    let solved = common::longstep(home)
        .args(["solve", "--goal", "put(butter, counter)", "--env", PANTRY, "--save"])
        .arg(&plan)
        .output()
        .unwrap();
    assert!(solved.status.success());
    plan.display().to_string()
}

#[test]
fn a_run_shows_its_plan_with_the_state_of_each_step() {
    let home = tempfile::tempdir().unwrap();
    let arguments = format!("run {} --robot sim:pace=40,ticks=1", planned(home.path()));
    let mut terminal = Terminal::open(home.path(), &arguments, "xterm");
    // Typed too early, it accepts nothing.
    terminal.press("\r");
    terminal.expect("Run this plan? [Enter, or `no`]");
    thread::sleep(Duration::from_millis(300));
    terminal.press("\r");
    terminal.expect("now");
    terminal.expect("grasp the butter");
    terminal.expect("14 of 14 steps done, ");
    terminal.expect("the goal is reached");
    let (code, shown) = terminal.end();
    assert_eq!(code, Some(0), "{shown}");

    let mut listed = common::longstep(home.path());
    let listed = common::run(
        listed
            .env("LONGSTEP_SESSIONS", home.path().join("sessions"))
            .args(["run", "--list"]),
        "",
    );
    assert!(listed.stdout.starts_with("plan-1  "), "{}", listed.stdout);
    assert!(listed.stdout.contains("14 steps, done"), "{}", listed.stdout);
}

#[test]
fn a_run_in_a_dumb_terminal_is_lines_without_escapes() {
    let home = tempfile::tempdir().unwrap();
    let arguments = format!("run {} --robot sim --approve never", planned(home.path()));
    let mut terminal = Terminal::open(home.path(), &arguments, "dumb");
    terminal.expect("  14  ");
    terminal.expect("the goal is reached");
    let (code, shown) = terminal.end();
    assert_eq!(code, Some(0), "{shown}");
    assert!(
        !shown.contains("\x1b[2K") && !shown.contains('\r'.to_string().repeat(2).as_str()),
        "{shown:?}"
    );
}
