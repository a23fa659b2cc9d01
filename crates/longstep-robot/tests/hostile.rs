//! Hostile robots: each session has one hostile line at a random place. The connection must neither panic nor hang, and
//! no step may follow a failure, which the robot itself counts.
//!
//! `cargo test -p longstep-robot --test hostile` runs a sample; `-- --lines 10000 --seed 7` after it runs more.
//! This program is its own robot (`--robot`), so that a session takes milliseconds.
#![allow(clippy::unwrap_used, clippy::panic, clippy::print_stdout, missing_docs)]

#[cfg(unix)]
fn main() {
    let arguments: Vec<String> = std::env::args().collect();
    let value = |name: &str| {
        let place = arguments.iter().position(|argument| argument == name)?;
        arguments.get(place + 1).cloned()
    };
    match value("--robot") {
        Some(seed) => robot::run(seed.parse().unwrap(), &value("--log").unwrap()),
        None => {
            let number = |name: &str, default: u64| value(name).map_or(default, |text| text.parse().unwrap());
            sessions::run(number("--lines", 150), number("--seed", 1));
        }
    }
}

#[cfg(not(unix))]
fn main() {}

/// SplitMix64: the same lines for the same seed.
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        mixed ^ (mixed >> 31)
    }

    fn below(&mut self, limit: usize) -> usize {
        (self.next() % limit.max(1) as u64) as usize
    }

    fn pick<'a>(&mut self, from: &[&'a str]) -> &'a str {
        from[self.below(from.len())]
    }
}

/// The hostile robot.
#[cfg(unix)]
mod robot {
    use std::io::{BufRead, Write};

    use serde_json::{Value, json};

    use super::Random;

    /// The requests at which the hostile line is written.
    const PLACES: [&str; 6] = ["initialize", "perform", "perform", "perform", "observe", "stop"];

    const TEXTS: [&str; 24] = [
        "",
        " ",
        "\r",
        "null",
        "true",
        "[]",
        "{}",
        "\"stop\"",
        "{\"jsonrpc\":\"2.0\"}",
        "{\"jsonrpc\":\"2.0\",\"id\":null,\"error\":{\"code\":-32700,\"message\":\"parse error\"}}",
        "{\"jsonrpc\":\"2.0\",\"method\":\"feedback\"}",
        "{\"jsonrpc\":\"2.0\",\"method\":\"feedback\",\"params\":[2]}",
        "{\"jsonrpc\":\"2.0\",\"method\":\"stop\",\"params\":{}}",
        "{\"jsonrpc\":\"2.0\",\"id\":18446744073709551615,\"result\":{}}",
        "{\"jsonrpc\":\"2.0\",\"id\":99999999999999999999999,\"result\":{}}",
        "{\"jsonrpc\":\"2.0\",\"id\":2.0,\"result\":{}}",
        "{\"jsonrpc\":\"2.0\",\"id\":0,\"result\":{}}",
        "{\"jsonrpc\":\"2.0\",\"id\":2,\"id\":2,\"result\":{}}",
        "1e400",
        "NaN",
        "\u{feff}{\"jsonrpc\":\"2.0\",\"id\":2,\"result\":{}}",
        "Content-Length: 38",
        "Traceback (most recent call last):",
        "\u{1b}]0;owned\u{7}",
    ];

    /// The answer that a good robot gives.
    fn answer(request: &Value) -> Value {
        let result = match request["method"].as_str() {
            Some("initialize") => json!({
                "protocol": 1, "name": "hostile", "capabilities": {"observe": true, "actions": ["grasp"]},
                "timeouts": {"perform": 0.1, "observe": 0.1, "stop": 0.1},
            }),
            Some("observe") => json!({"states": {"<cup>": ["on_something(<table>)"]}, "facts": []}),
            _ => json!({}),
        };
        json!({"jsonrpc": "2.0", "id": request["id"], "result": result})
    }

    /// Changes bytes of a good line.
    fn mutated(line: &str, random: &mut Random) -> Vec<u8> {
        let mut bytes = line.as_bytes().to_vec();
        for _ in 0..=random.below(3) {
            let place = random.below(bytes.len());
            match random.below(5) {
                0 => bytes[place] ^= 1 << random.below(8),
                1 => drop(bytes.remove(place)),
                2 => bytes.insert(place, random.next() as u8),
                3 => bytes.truncate(place.max(1)),
                _ => {
                    let piece = bytes[place..].to_vec();
                    bytes.extend(piece);
                }
            }
            if bytes.is_empty() {
                break;
            }
        }
        bytes
    }

    /// Changes one value of a good message.
    fn twisted(mut message: Value, random: &mut Random) -> Vec<u8> {
        let wrong = [
            json!(null),
            json!(-1),
            json!(0.5),
            json!(1e300),
            json!([]),
            json!({}),
            json!("x"),
            json!(true),
            json!({"states": null}),
            json!({"outcome": 3}),
            json!({"outcome": "(lost <cup>)"}),
            json!(7),
            json!({"protocol": 1, "name": "h", "timeouts": {"stop": 1e-320}}),
            json!({"protocol": 1, "name": "h", "timeouts": {"perform": -0.0}}),
            json!({"protocol": 1e0, "name": "\u{202e}\u{0}"}),
        ];
        let value = wrong[random.below(wrong.len())].clone();
        match random.below(6) {
            0 => message["jsonrpc"] = value,
            1 => message["id"] = value,
            2 => message["result"] = value,
            3 => message["error"] = value,
            4 => message["method"] = value,
            _ => {
                let code = [-32768, -32601, -32000, 0, 1][random.below(5)];
                message = json!({"jsonrpc": "2.0", "id": message["id"], "error": {"code": code, "message": value}});
            }
        }
        message.to_string().into_bytes()
    }

    /// Returns a hostile line in place of the answer.
    fn hostile(request: &Value, random: &mut Random) -> Vec<u8> {
        let good = answer(request).to_string();
        match random.below(64) {
            0 => vec![b'x'; (1 << 20) + random.below(1 << 20)],
            1 => "[".repeat(1 + random.below(1 << 19)).into_bytes(),
            2 => format!("{{\"jsonrpc\":\"2.0\",\"id\":{},\"result\":{}1{}}}", request["id"], "[".repeat(100), "]".repeat(100)).into_bytes(),
            3 => (0..random.below(300)).map(|_| random.next() as u8).collect(),
            4..=15 => random.pick(&TEXTS).as_bytes().to_vec(),
            16..=39 => mutated(&good, random),
            40..=55 => twisted(answer(request), random),
            56 | 57 => format!("{good}\n{good}").into_bytes(),
            58 => good.replace("\"id\":", "\"id\":1").into_bytes(),
            59 => json!({"jsonrpc": "2.0", "method": "feedback", "params": {"id": random.below(6), "fraction": random.below(3)}})
                .to_string()
                .into_bytes(),
            60 => json!({"jsonrpc": "2.0", "method": "feedback", "params": {"id": request["id"], "data": "x".repeat(random.below(40_000))}})
                .to_string()
                .into_bytes(),
            61 => format!("[{good}]").into_bytes(),
            62 => format!("{good}{good}").into_bytes(),
            _ => good.replace(',', ",\n").into_bytes(),
        }
    }

    /// Answers requests, one of them with a hostile line, and logs what it receives. What it cannot write any more, it
    /// gives up: a robot that lost its connection ends.
    pub(super) fn run(seed: u64, log: &str) {
        let mut random = Random(seed);
        let place = random.pick(&PLACES);
        let turn = random.below(2);
        let (with_answer, without_end) = (random.below(2) == 0, random.below(40) == 0);
        let mut log = std::fs::File::create(log).unwrap();
        let mut output = std::io::stdout();
        let mut seen = 0;
        for line in std::io::stdin().lock().lines() {
            let Ok(request) = serde_json::from_str::<Value>(&line.unwrap_or_default()) else {
                continue;
            };
            let method = request["method"].as_str().unwrap_or_default();
            writeln!(log, "{method}").unwrap();
            let mut bytes = Vec::new();
            let is_here = method == place && seen == turn.min(usize::from(place == "perform"));
            seen += usize::from(method == place);
            if is_here {
                bytes = hostile(&request, &mut random);
                if !without_end {
                    bytes.push(b'\n');
                }
            }
            if !is_here || with_answer {
                bytes.extend(answer(&request).to_string().into_bytes());
                bytes.push(b'\n');
            }
            if output.write_all(&bytes).and_then(|()| output.flush()).is_err() || method == "shutdown" {
                return;
            }
        }
    }
}

/// The other side: sessions with hostile robots.
#[cfg(unix)]
mod sessions {
    use std::collections::BTreeMap;
    use std::path::Path;
    use std::sync::atomic::{AtomicU64, Ordering};
    use std::time::{Duration, Instant};

    use longstep_robot::process::{Command, Process};
    use longstep_robot::{Order, Progress, Robot, RobotError, Scope};

    use super::Random;

    /// The steps that a session tries.
    const STEPS: usize = 4;

    /// The time after which a session counts as hanging. The timeouts of a session add up to about a second.
    const HANG: Duration = Duration::from_secs(60);

    /// Performs a step; `started` counts those that were sent.
    fn step(robot: &mut Process, number: usize, started: &mut usize) -> Result<(), RobotError> {
        let handle = robot.start(&Order::new(number, "grasp", ["<cup>"]))?;
        *started += 1;
        loop {
            match robot.poll(handle)? {
                Progress::Running(_) => robot.wait(Duration::from_millis(20)),
                Progress::Done { .. } | Progress::Failed { .. } => return Ok(()),
            }
        }
    }

    /// Performs steps and observes after each; returns the first failure. A robot that mangled its list of actions gets no
    /// steps.
    fn session(robot: &mut Process, started: &mut usize) -> Option<RobotError> {
        for number in 1..=STEPS {
            if let Err(error) = step(robot, number, started) {
                return error.is_final().then_some(error);
            }
            match robot.observe(&Scope::All) {
                Err(error) if error.is_final() => return Some(error),
                _ => {}
            }
        }
        None
    }

    /// Returns the name of a failure.
    fn kind(error: &RobotError) -> &'static str {
        match error {
            RobotError::Protocol { .. } => "broken protocol",
            RobotError::TimedOut { .. } => "timeout",
            RobotError::Incompatible { .. } => "other version",
            RobotError::Gone { .. } => "gone",
            RobotError::Refused { .. } => "refused",
            _ => "another error",
        }
    }

    pub(super) fn run(lines: u64, seed: u64) {
        let folder = tempfile::tempdir().unwrap();
        let program = std::env::current_exe().unwrap();
        let mut random = Random(seed);
        let mut kinds: BTreeMap<&str, u64> = BTreeMap::new();
        let (mut longest, begin) = (Duration::ZERO, Instant::now());
        let finished = std::sync::Arc::new(AtomicU64::new(0));
        watch(&finished, lines);
        for number in 0..lines {
            let log = folder.path().join(number.to_string());
            let session_seed = random.next();
            let began = Instant::now();
            let kind = one(&program, session_seed, &log);
            *kinds.entry(kind).or_default() += 1;
            longest = longest.max(began.elapsed());
            std::fs::remove_file(&log).unwrap();
            finished.fetch_add(1, Ordering::SeqCst);
        }
        println!(
            "{lines} hostile lines in {:.1} s, 0 panics, 0 hangs, 0 steps after a failure",
            begin.elapsed().as_secs_f64()
        );
        println!("longest session {:.2} s; ended with: {kinds:?}", longest.as_secs_f64());
    }

    /// Ends this program if no session ends for long: a hang is a failure, not a test without an end.
    fn watch(finished: &std::sync::Arc<AtomicU64>, lines: u64) {
        let finished = std::sync::Arc::clone(finished);
        std::thread::spawn(move || {
            let mut last = 0;
            while last < lines {
                std::thread::sleep(HANG);
                let now = finished.load(Ordering::SeqCst);
                if now == last && now < lines {
                    println!("session {now} hangs");
                    std::process::exit(1);
                }
                last = now;
            }
        });
    }

    /// Runs one session and checks that no step followed a failure.
    fn one(program: &Path, seed: u64, log: &Path) -> &'static str {
        let words = [
            program.to_str().unwrap(),
            "--robot",
            &seed.to_string(),
            "--log",
            log.to_str().unwrap(),
        ]
        .map(str::to_owned);
        let mut started = 0;
        let kind = match Command::new(words).startup(Duration::from_millis(300)).open() {
            Err(error) => {
                assert!(
                    error.is_final() || matches!(error, RobotError::Refused { .. }),
                    "seed {seed}: {error}"
                );
                kind(&error)
            }
            Ok(mut robot) => {
                let failure = session(&mut robot, &mut started);
                if let Some(error) = &failure {
                    let again = robot.start(&Order::new(9, "grasp", ["<cup>"]));
                    assert_eq!(again.as_ref(), Err(error), "seed {seed}");
                    assert_eq!(robot.observe(&Scope::All).as_ref(), Err(error), "seed {seed}");
                }
                let stopped = robot.stop();
                assert_eq!(robot.stop(), stopped, "seed {seed}");
                match (&failure, stopped) {
                    (Some(error), _) => kind(error),
                    (None, Ok(())) => "no failure",
                    (None, Err(_)) => "stop not confirmed",
                }
            }
        };
        let received = std::fs::read_to_string(log).unwrap_or_default();
        let orders = received.lines().filter(|method| *method == "perform").count();
        assert_eq!(orders, started, "seed {seed}: orders that the robot received");
        kind
    }
}
