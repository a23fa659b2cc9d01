//! The program is killed in the middle of conversations, and loses no plan that it said it had accepted.
#![allow(clippy::disallowed_macros, clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::collections::BTreeMap;
use std::io::{Read, Write};
use std::path::Path;
use std::process::Stdio;
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex};
use std::thread;
use std::time::{Duration, Instant};

use common::{Answer, PANTRY, Server, edits, goals, longstep, run};
use longstep::Clock;
use longstep::domain;
use longstep::session::{Event, Log, Session};
use longstep_llm::SessionFolder;
use serde_json::Value;

const SESSIONS: u64 = 200;

const THINGS: [&str; 4] = ["cereal", "juice", "cloth", "butter"];
const PLACES: [&str; 4] = ["counter", "shelf top", "shelf bottom", "fridge"];

/// Marsaglia's xorshift: the same scripts in every run.
struct Random(u64);

impl Random {
    fn new(seed: u64) -> Self {
        Self(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1)
    }

    fn below(&mut self, bound: u64) -> u64 {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 11) % bound
    }

    fn one_of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[usize::try_from(self.below(all.len() as u64)).unwrap()]
    }
}

/// A server that understands `Put the THING on the PLACE` and takes its time over it.
fn server() -> Server {
    Server::answering(|_, body| {
        thread::sleep(Duration::from_millis(2));
        let messages = body["messages"].as_array().unwrap();
        let last = messages.last().unwrap()["content"].as_str().unwrap();
        if body["response_format"].to_string().contains("edits") {
            return edits(&["insert move_object() after 4"]);
        }
        let Some((_, instruction)) = last.rsplit_once("Instruction: Put the ") else {
            return Answer::HangUp;
        };
        let (thing, place) = instruction.trim().split_once(" on the ").unwrap();
        goals(&[&format!("put({thing}, {place})")])
    })
}

fn instruction(random: &mut Random) -> String {
    format!("Put the {} on the {}\n", random.one_of(&THINGS), random.one_of(&PLACES))
}

/// The words of a person, line by line.
fn script(random: &mut Random, yes: bool) -> String {
    let mut script = String::new();
    for _ in 0..3 + random.below(6) {
        script += &instruction(random);
        if !yes {
            if random.below(4) == 0 {
                script += "insert another move_object() after step 4\n";
            }
            script += if random.below(6) == 0 { "no\n" } else { "\n" };
        }
        if random.below(5) == 0 {
            script += "/undo\n";
        }
    }
    script
}

/// A plan was accepted (`true`) or undone.
type Step = (bool, usize);

/// The events that the program reported.
fn announced(text: &str) -> Vec<Step> {
    let number = |text: &str| text.trim().parse().unwrap();
    // The last line may be cut off anywhere.
    let whole = text.rsplit_once('\n').map_or("", |(whole, _)| whole);
    let step = |line: &str| {
        let taken_back = |line: &str| Some((false, number(line.strip_prefix("Plan ")?.strip_suffix(" is undone")?)));
        let accepted = line.strip_prefix("Accepted as plan ").map(|text| (true, number(text)));
        accepted.or_else(|| taken_back(line))
    };
    whole.lines().filter_map(step).collect()
}

fn logged(log: &Log) -> Vec<Step> {
    let step = |event: &Event| match event {
        Event::Accept { number, .. } => Some((true, *number)),
        Event::Undo { number } => Some((false, *number)),
        _ => None,
    };
    log.events().filter_map(step).collect()
}

/// The plans that stand at the end of a log, as JSON.
fn standing(log: &Log) -> Vec<Value> {
    let mut plans = Vec::new();
    for event in log.events() {
        match event {
            Event::Accept { plan, .. } => plans.push(serde_json::to_value(plan).unwrap()),
            Event::Undo { .. } => {
                plans.pop();
            }
            _ => {}
        }
    }
    plans
}

/// The plan files of a folder, in order.
fn files(folder: &Path) -> Vec<Value> {
    let read = |number: u32| std::fs::read(folder.join(format!("{number}.json"))).ok();
    let files: Vec<Value> = (0..)
        .map_while(read)
        .map(|text| {
            let mut file: Value = serde_json::from_slice(&text).unwrap();
            // The log names the domain at its beginning, and each file does.
            let domain = file.as_object_mut().unwrap().remove("domain").unwrap();
            assert_eq!(domain["name"], "household");
            file
        })
        .collect();
    let others = std::fs::read_dir(folder).unwrap().filter(|entry| {
        let name = entry.as_ref().unwrap().file_name();
        name.to_str().unwrap().ends_with(".json")
    });
    assert_eq!(others.count(), files.len(), "a plan file without those before it");
    files
}

/// When the program is killed.
#[derive(Debug, Clone, Copy)]
enum Moment {
    /// When it has written so many bytes.
    Bytes(usize),
    After(Duration),
    /// When its log has so many bytes.
    Logged(u64),
}

/// Runs a conversation and kills it; returns what it had said and whether it was alive until then.
fn killed(server: &Server, folder: &Path, home: &Path, yes: bool, lines: &str, moment: Moment) -> (String, bool) {
    let (mut reader, writer) = std::io::pipe().unwrap();
    let mut command = longstep(home);
    command
        .args(["chat", "--env", PANTRY, "--model", &server.reference(), "--session"])
        .arg(folder);
    if yes {
        command.arg("--yes");
    }
    command
        .stdin(Stdio::piped())
        .stdout(writer.try_clone().unwrap())
        .stderr(writer);
    let mut child = command.spawn().unwrap();
    command.stdout(Stdio::null()).stderr(Stdio::null());
    let mut input = child.stdin.take().unwrap();
    let _ = input.write_all(lines.as_bytes());
    drop(input);
    let (said, ended) = (Arc::new(AtomicUsize::new(0)), Arc::new(AtomicBool::new(false)));
    let listener = thread::spawn({
        let (said, ended) = (said.clone(), ended.clone());
        move || {
            let (mut text, mut buffer) = (Vec::new(), [0; 256]);
            while let Ok(count @ 1..) = reader.read(&mut buffer) {
                text.extend_from_slice(&buffer[..count]);
                said.store(text.len(), Ordering::SeqCst);
            }
            ended.store(true, Ordering::SeqCst);
            text
        }
    });
    let began = Instant::now();
    let log = folder.join("session.jsonl");
    let due = || match moment {
        Moment::Bytes(bytes) => said.load(Ordering::SeqCst) >= bytes,
        Moment::After(time) => began.elapsed() >= time,
        Moment::Logged(bytes) => std::fs::metadata(&log).is_ok_and(|file| file.len() >= bytes),
    };
    while !due() && !ended.load(Ordering::SeqCst) {
        thread::sleep(Duration::from_micros(50));
    }
    // SIGKILL: nothing of the program runs any more.
    child.kill().unwrap();
    let alive = child.wait().unwrap().code().is_none();
    let text = listener.join().unwrap();
    (String::from_utf8_lossy(&text).into_owned(), alive)
}

/// One session: killed, looked at, and gone on with. Returns where it was.
fn session(seed: u64, server: &Server, longest: &AtomicU64) -> &'static str {
    let mut random = Random::new(seed);
    let yes = random.below(2) == 0;
    let lines = script(&mut random, yes);
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("session");
    // How long a conversation takes depends on the machine: the time is drawn from what the others took.
    let moment = match random.below(3) {
        0 => Moment::Bytes(usize::try_from(random.below(4000)).unwrap()),
        1 => Moment::After(Duration::from_micros(random.below(longest.load(Ordering::SeqCst)))),
        _ => Moment::Logged(random.below(60_000)),
    };
    let began = Instant::now();
    let (said, alive) = killed(server, &folder, home.path(), yes, &lines, moment);
    if !alive {
        longest.store(u64::try_from(began.elapsed().as_micros()).unwrap(), Ordering::SeqCst);
    }
    let announced = announced(&said);
    let told = || format!("seed {seed}, {moment:?}, yes {yes}\n{lines}\n{said}");

    let log = match SessionFolder::read(&folder) {
        Ok(log) => log,
        Err(error) => {
            // There is no line yet that it could have gone on from.
            assert!(announced.is_empty(), "{error}: {}", told());
            return "before the session had begun";
        }
    };
    let logged = logged(&log);
    assert!(logged.starts_with(&announced), "{announced:?} {logged:?} {}", told());
    assert!(
        logged.len() <= announced.len() + 1,
        "{announced:?} {logged:?} {}",
        told()
    );
    let behind = files(&folder) != standing(&log);
    let last = log.events().last().unwrap();
    let phase = match last {
        _ if !alive => "not before its end",
        _ if log.torn > 0 => "while a line was written",
        _ if behind => "between the log and a plan's file",
        _ if logged.len() > announced.len() => "between a plan's file and telling of it",
        _ if logged.is_empty() => "before the first acceptance",
        Event::Accept { .. } | Event::Undo { .. } | Event::Cancel => "between two instructions",
        _ => "while a later instruction was at hand",
    };

    let path = folder.to_str().unwrap();
    let shown = run(longstep(home.path()).args(["session", "show", path, "--json"]), "");
    assert_eq!(shown.code, 0, "{} {}", shown.stderr, told());
    let reference = server.reference();
    let resume: Vec<&str> = [
        &["chat", "--model", &reference, "--resume", path][..],
        &["--yes"][..usize::from(yes)],
    ]
    .concat();
    let resumed = run(longstep(home.path()).args(&resume), "");
    assert_eq!(resumed.code, 0, "{} {}", resumed.stderr, told());

    let log = SessionFolder::read(&folder).unwrap();
    assert_eq!(files(&folder), standing(&log), "{}", told());
    let count = standing(&log).len();
    let waiting = if resumed.stdout.contains("Waiting for a decision") {
        "no\n"
    } else {
        ""
    };
    let more = format!("{waiting}{}\n", instruction(&mut random));
    let gone_on = run(longstep(home.path()).args(&resume), &more);
    let expected = format!("Accepted as plan {count}\n");
    assert!(
        gone_on.stdout.contains(&expected),
        "{}{} {}",
        gone_on.stdout,
        gone_on.stderr,
        told()
    );

    let log = SessionFolder::read(&folder).unwrap();
    let files = files(&folder);
    assert_eq!(files, standing(&log), "{}", told());
    assert_eq!(files.len(), count + 1);
    // What each plan leads to is found out by the program that knows nothing of sessions.
    let begun = log.events().next().unwrap();
    let Event::Begin { environment, .. } = begun else {
        panic!()
    };
    let mut world = serde_json::to_value(environment).unwrap();
    for (number, plan) in files.iter().enumerate() {
        assert_eq!(plan["environment_before"], world, "plan {number}: {}", told());
        let file = folder.join(format!("{number}.json"));
        let verified = run(
            longstep(home.path()).args(["verify", file.to_str().unwrap(), "--json"]),
            "",
        );
        let answer: Value = serde_json::from_str(&verified.stdout).unwrap();
        assert_eq!(answer["status"], "verified", "{verified:?}");
        world = answer["plan"]["environment_after"].clone();
        assert_eq!(plan["environment_after"], world, "plan {number}: {}", told());
    }
    phase
}

#[test]
fn a_killed_session_loses_no_accepted_plan() {
    let server = server();
    let began = Instant::now();
    let longest = AtomicU64::new(150_000);
    let next = AtomicU64::new(0);
    let phases: Mutex<BTreeMap<&str, usize>> = Mutex::default();
    thread::scope(|scope| {
        for _ in 0..2 {
            scope.spawn(|| {
                loop {
                    let seed = next.fetch_add(1, Ordering::SeqCst);
                    if seed >= SESSIONS {
                        return;
                    }
                    let phase = session(seed + 1, &server, &longest);
                    *phases.lock().unwrap().entry(phase).or_default() += 1;
                }
            });
        }
    });
    let phases = phases.into_inner().unwrap();
    let counted: Vec<String> = phases
        .iter()
        .map(|(phase, count)| format!("{count:4} {phase}"))
        .collect();
    println!(
        "{SESSIONS} sessions in {:.1} s, killed\n{}",
        began.elapsed().as_secs_f64(),
        counted.join("\n")
    );
    assert_eq!(phases.values().sum::<usize>(), usize::try_from(SESSIONS).unwrap());
    let late = phases.get("not before its end").copied().unwrap_or_default();
    assert!(late < 100, "most were not killed at all");
    for phase in [
        "before the first acceptance",
        "between two instructions",
        "while a later instruction was at hand",
    ] {
        assert!(phases.contains_key(phase), "none was killed {phase}: {phases:?}");
    }
}

#[test]
fn session_resumes_from_a_log_cut_off_anywhere() {
    let server = server();
    let home = tempfile::tempdir().unwrap();
    let folder = home.path().join("session");
    let mut random = Random::new(7);
    let lines: String = (0..3).map(|_| script(&mut random, false)).collect();
    let mut command = longstep(home.path());
    command
        .args(["chat", "--env", PANTRY, "--model", &server.reference(), "--session"])
        .arg(&folder);
    let whole = run(&mut command, &lines);
    assert_eq!(whole.code, 0, "{}", whole.stderr);
    let log = std::fs::read(folder.join("session.jsonl")).unwrap();
    let cut_folder = home.path().join("cut");
    for _ in 0..200 {
        let cut = usize::try_from(random.below(log.len() as u64 + 1)).unwrap();
        std::fs::create_dir_all(&cut_folder).unwrap();
        std::fs::write(cut_folder.join("session.jsonl"), &log[..cut]).unwrap();
        match SessionFolder::open(&cut_folder) {
            Ok((folder, read)) => {
                let household = domain::shipped("household").unwrap().unwrap();
                let resumed = Session::resume(household, &read, Clock::none()).unwrap();
                folder.mend(&resumed.session).unwrap();
                assert_eq!(files(&cut_folder), standing(&read), "cut at {cut}");
                let whole = log[..cut]
                    .iter()
                    .rposition(|byte| *byte == b'\n')
                    .map_or(0, |at| at + 1);
                assert_eq!((read.whole, read.torn), (whole, cut - whole));
                assert_eq!(resumed.dropped, None, "cut at {cut}");
            }
            // Before the end of the first line there is no session.
            Err(error) => assert!(!log[..cut].contains(&b'\n'), "cut at {cut}: {error}"),
        }
        std::fs::remove_dir_all(&cut_folder).unwrap();
    }
}
