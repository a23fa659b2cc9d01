//! The program is killed while a robot's program performs a step: no second one is started while the first one, or a process that
//! it left, still drives the robot.
#![cfg(target_os = "linux")]
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs;
use std::path::PathBuf;
use std::process::{Command, Output, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{ended, longstep};
use tempfile::TempDir;

/// The longest that anything may take.
const LIMIT: Duration = Duration::from_secs(60);

const DOMAIN: &str = r#"
(define (domain lamps) (:requirements :strips) (:types lamp)
  (:predicates (lit ?l - lamp))
  (:action switch-on :parameters (?l - lamp) :precondition (not (lit ?l)) :effect (lit ?l)))
"#;

const WORDS: &str = r#"
name = "lamps"
about = "A robot that switches lamps on."
[environment]
assets = "lamp"
objects = "lamp"
[[predicate]]
name = "lit"
says = "{l} is lit"
denies = "{l} is dark"
[[state]]
word = "on()"
fact = "(lit ?self)"
means = "It is lit."
[[action]]
name = "switch-on"
call = "switch_on(?l)"
says = "Switch {l} on."
means = "Switches a lamp on."
"#;

/// A robot whose first step in its first life takes long. FOLDER/lives has a line for each life, with the number of its process.
const ROBOT: &str = r#"
import json, os, subprocess, sys, time
folder, way = sys.argv[1], sys.argv[2]
lives = os.path.join(folder, "lives")
with open(lives, "a") as file:
    file.write(f"{os.getpid()}\n")
is_first = len(open(lives).readlines()) == 1
lit = os.path.join(folder, "lit")

def answer(id, result):
    print(json.dumps({"jsonrpc": "2.0", "id": id, "result": result}), flush=True)

for line in sys.stdin:
    message = json.loads(line)
    method = message["method"]
    if method == "initialize":
        answer(message["id"], {"protocol": 1, "name": "lamp robot", "timeouts": {"stop": STOP},
                               "capabilities": {"observe": True}})
    elif method == "observe":
        answer(message["id"], {"states": {"<lamp>": ["on()"] if os.path.exists(lit) else []}})
    elif method == "perform":
        if is_first:
            if way == "closes everything":
                os.closerange(3, 1000)
            if way == "leaves a daemon":
                daemon = subprocess.Popen(["sleep", "1000"], start_new_session=True, close_fds=False,
                                          stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                open(os.path.join(folder, "daemon.new"), "w").write(str(daemon.pid))
                os.rename(os.path.join(folder, "daemon.new"), os.path.join(folder, "daemon"))
            open(os.path.join(folder, "performing"), "w").close()
            if way == "dies":
                os._exit(9)
            if way not in ("stops at the end of its input", "leaves a daemon"):
                time.sleep(1000)
            continue
        open(lit, "w").close()
        answer(message["id"], {})
    elif method == "stop":
        answer(message["id"], {})
"#;

struct Bench {
    folder: TempDir,
    way: &'static str,
}

impl Bench {
    fn new(way: &'static str, stop: &str) -> Self {
        let bench = Self {
            folder: TempDir::new().unwrap(),
            way,
        };
        fs::create_dir_all(bench.path("domain/prompt")).unwrap();
        fs::write(bench.path("domain/prompt/goal.md"), "x").unwrap();
        fs::write(bench.path("domain/prompt/examples.toml"), "").unwrap();
        fs::write(bench.path("domain/domain.pddl"), DOMAIN).unwrap();
        fs::write(bench.path("domain/domain.toml"), WORDS).unwrap();
        fs::write(bench.path("env.json"), r#"{"assets": ["<lamp>"], "objects": []}"#).unwrap();
        fs::write(bench.path("robot.py"), ROBOT.replace("STOP", stop)).unwrap();
        let solved = longstep(bench.folder.path())
            .args(["solve", "--goal", "on(lamp)", "--env"])
            .arg(bench.path("env.json"))
            .arg("--domain")
            .arg(bench.path("domain"))
            .arg("--save")
            .arg(bench.path("plan.json"))
            .output()
            .unwrap();
        assert_eq!(solved.status.code(), Some(0), "{}", text(&solved.stderr));
        bench
    }

    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    fn robot(&self) -> String {
        let folder = self.folder.path().display();
        format!("process:python3 '{folder}/robot.py' '{folder}' '{}'", self.way)
    }

    fn run(&self, log: &str) -> Command {
        let mut command = longstep(self.folder.path());
        command.arg("run").arg(self.path("plan.json"));
        command.arg("--domain").arg(self.path("domain"));
        command.args(["--robot", &self.robot(), "--live", "--approve", "never", "--log"]);
        command.arg(self.path(log));
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        command
    }

    fn resume(&self) -> Output {
        let mut command = longstep(self.folder.path());
        command.args(["run", "--live", "--resume"]).arg(self.path("run.jsonl"));
        command
            .stdin(Stdio::null())
            .stdout(Stdio::piped())
            .stderr(Stdio::piped());
        ended(command.spawn().unwrap(), LIMIT)
    }

    /// Begins the run, and kills it while the robot performs a step.
    fn killed(&self) {
        let child = self.run("run.jsonl").spawn().unwrap();
        self.wait_for("performing");
        kill(child.id());
        ended(child, LIMIT);
    }

    fn wait_for(&self, name: &str) {
        let begun = Instant::now();
        while !self.path(name).exists() {
            assert!(begun.elapsed() < LIMIT, "no {name}");
            thread::sleep(Duration::from_millis(2));
        }
    }

    /// The processes of the robot's program, of all of its lives.
    fn lives(&self) -> Vec<u32> {
        let text = fs::read_to_string(self.path("lives")).unwrap();
        text.lines().map(|line| line.parse().unwrap()).collect()
    }

    /// Resumes until the robot is free.
    fn resume_when_free(&self) {
        let begun = Instant::now();
        loop {
            let output = self.resume();
            if output.status.code() != Some(55) {
                assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
                return;
            }
            assert!(begun.elapsed() < LIMIT, "{}", text(&output.stderr));
        }
    }

    /// The presence files of programs, which are beside the locks.
    fn presences(&self) -> usize {
        let mut folders = vec![self.folder.path().to_owned()];
        let mut count = 0;
        while let Some(folder) = folders.pop() {
            for entry in fs::read_dir(folder).unwrap() {
                let path = entry.unwrap().path();
                count += usize::from(path.extension().is_some_and(|own| own == "alive"));
                folders.extend(path.is_dir().then_some(path));
            }
        }
        count
    }
}

fn kill(process: u32) {
    let sent = Command::new("kill").args(["-KILL", &process.to_string()]).status();
    assert!(sent.unwrap().success());
}

fn is_running(process: u32) -> bool {
    let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
    stat.rsplit_once(')')
        .is_some_and(|(_, rest)| !rest.trim_start().starts_with('Z'))
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

#[track_caller]
fn check_refused(output: &Output, words: &[&str]) {
    let errors = text(&output.stderr);
    assert_eq!(output.status.code(), Some(55), "{errors}");
    for words in words {
        assert!(errors.contains(words), "no `{words}` in {errors}");
    }
}

/// The lock goes with the program, whatever the program does with what it inherited.
#[test]
fn a_robot_that_goes_on_after_a_kill_is_not_started_twice() {
    for way in ["hangs", "closes everything"] {
        let bench = Bench::new(way, "4");
        bench.killed();
        let first = bench.lives()[0];
        assert!(is_running(first));
        let named = format!("process {first} (python3 ");
        let words = [
            "the robot `process lamp robot` is still driven by the program of an earlier run",
            &named,
            "hint: ",
        ];
        check_refused(&bench.resume(), &words);
        check_refused(&ended(bench.run("second.jsonl").spawn().unwrap(), LIMIT), &words[..2]);
        assert_eq!(bench.lives(), [first], "{way}: nothing was started");
        assert!(!bench.path("second.jsonl").exists());
        // It is ended by force after its timeouts for stops, and the run goes on then.
        bench.resume_when_free();
        assert!(!is_running(first));
        assert_eq!(bench.lives().len(), 2, "{way}");
        assert!(bench.path("lit").exists());
        assert_eq!(bench.presences(), 0, "{way}");
    }
}

#[test]
fn resume_is_refused_while_a_child_of_the_robot_runs() {
    let bench = Bench::new("leaves a daemon", "1");
    bench.killed();
    let daemon: u32 = fs::read_to_string(bench.path("daemon")).unwrap().parse().unwrap();
    // The robot itself ends at the end of its input; the one that it started goes on.
    let begun = Instant::now();
    while is_running(bench.lives()[0]) {
        assert!(begun.elapsed() < LIMIT);
        thread::sleep(Duration::from_millis(10));
    }
    check_refused(&bench.resume(), &[&format!("process {daemon} (python3 ")]);
    assert_eq!(bench.lives().len(), 1);
    kill(daemon);
    bench.resume_when_free();
    assert_eq!(bench.lives().len(), 2);
}

#[test]
fn a_robot_that_stops_at_the_end_of_its_input_is_gone_on_with_at_once() {
    let bench = Bench::new("stops at the end of its input", "60");
    bench.killed();
    let output = bench.resume();
    assert_eq!(output.status.code(), Some(0), "{}", text(&output.stderr));
    assert_eq!(bench.lives().len(), 2);
    assert_eq!(bench.presences(), 0);
}

#[test]
fn the_death_of_a_robot_has_one_hint_to_resume() {
    let bench = Bench::new("dies", "1");
    let output = ended(bench.run("run.jsonl").spawn().unwrap(), LIMIT);
    let both = text(&output.stdout) + &text(&output.stderr);
    assert_eq!(output.status.code(), Some(52), "{both}");
    assert_eq!(both.matches("--resume").count(), 1, "{both}");
    assert!(
        both.contains("under way, and unknown until the world is observed: Switch the lamp on"),
        "{both}"
    );
    bench.resume_when_free();
}
