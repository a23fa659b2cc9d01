//! Files, pipes and devices that the program reads and writes, and what is left to others of them.
#![cfg(unix)]
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::fs::{File, Permissions};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::{FileTypeExt, PermissionsExt, symlink};
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread;
use std::time::{Duration, Instant};

use common::{Answer, PANTRY, Ran, Server, goals, longstep, root, run};
use serde_json::{Value, json};

const GOAL: [&str; 5] = ["solve", "--goal", "put(juice, counter)", "--env", PANTRY];
const DESK: &str =
    r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
const REPLIES: &str = r#"[{"case": "pen", "reply": {"goal": "put(pen, shelf)", "left_out": [], "question": ""}}]"#;

/// Longer than anything here takes.
const PATIENCE: Duration = Duration::from_secs(60);

fn mode(path: &Path) -> u32 {
    std::fs::metadata(path).unwrap().permissions().mode() & 0o777
}

/// A suite of one case, with replies for it.
fn suite(folder: &Path) {
    let write = |name: &str, text: &str| std::fs::write(folder.join(name), text).unwrap();
    std::fs::create_dir_all(folder.join("desk/scenes")).unwrap();
    write(
        "desk/suite.toml",
        "name = \"desk\"\nabout = \"A pen.\"\ndomain = \"household\"\n",
    );
    write(
        "desk/cases.toml",
        "[[case]]\nid = \"pen\"\nscene = \"desk\"\nsays = \"Shelve the pen.\"\ngoal = \"put(pen, shelf)\"\ntags = [\"x\"]\n",
    );
    write("desk/scenes/desk.json", DESK);
    write("replies.json", REPLIES);
}

/// The program under a shell's `ulimit` and `umask`.
fn limited(home: &Path, before: &str, arguments: &[&str]) -> Command {
    let like = longstep(home);
    let mut command = Command::new("sh");
    command
        .args(["-c", &format!("{before}; exec \"$@\""), "sh"])
        .arg(like.get_program())
        .args(arguments)
        .current_dir(root());
    for (name, value) in like.get_envs() {
        match value {
            Some(value) => command.env(name, value),
            None => command.env_remove(name),
        };
    }
    command
}

/// Commands that print, with the code that they end with when all is well.
fn printing(home: &Path) -> Vec<(Vec<String>, i32)> {
    suite(home);
    let path = |name: &str| home.join(name).to_str().unwrap().to_owned();
    let plan = "crates/longstep-cli/tests/plans/good.json";
    let lines: Vec<(Vec<&str>, i32)> = vec![
        (GOAL.to_vec(), 0),
        ([&GOAL[..], &["--json"]].concat(), 0),
        ([&GOAL[..], &["--pddl"]].concat(), 0),
        (vec!["verify", plan], 0),
        (vec!["verify", plan, "--json"], 0),
        (vec!["repair", plan], 0),
        (vec!["export", plan, "--format", "python"], 0),
        (vec!["export", plan, "--format", "json"], 0),
        (
            vec![
                "compose",
                "--script",
                "examples/stored/cream.py",
                "--plans",
                "examples/stored",
                "--env",
                "examples/environments/larder.json",
                "--domain",
                "household-checks",
            ],
            0,
        ),
        (vec!["domain", "list"], 0),
        (vec!["domain", "show", "household"], 0),
        (vec!["domain", "check", "household"], 0),
        (vec!["model", "list"], 0),
        (vec!["session", "list"], 0),
        (vec!["eval", "list"], 0),
        (vec!["--help"], 0),
        (vec!["--version"], 0),
    ];
    let mut all: Vec<(Vec<String>, i32)> = lines
        .into_iter()
        .map(|(words, code)| (words.into_iter().map(str::to_owned).collect(), code))
        .collect();
    let evaluate = [
        "eval",
        &path("desk"),
        "--replies",
        &path("replies.json"),
        "--out",
        &path("run"),
    ];
    all.push((evaluate.map(str::to_owned).to_vec(), 0));
    all.push((["eval", "report", &path("run")].map(str::to_owned).to_vec(), 0));
    all.push((
        ["eval", "compare", &path("run"), &path("run")]
            .map(str::to_owned)
            .to_vec(),
        0,
    ));
    all
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_stdout_is_an_error_and_no_panic() {
    let home = tempfile::tempdir().unwrap();
    for (arguments, _) in printing(home.path()) {
        let output = longstep(home.path())
            .args(&arguments)
            .stdin(Stdio::null())
            .stdout(File::options().write(true).open("/dev/full").unwrap())
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(60), "{arguments:?}\n{stderr}");
        let said = "error: cannot write to standard output: no space left on device\n";
        assert!(
            stderr.contains(said) && !stderr.contains("panicked"),
            "{arguments:?}\n{stderr}"
        );
    }
}

#[cfg(target_os = "linux")]
#[test]
fn a_full_disk_under_stderr_changes_nothing() {
    let home = tempfile::tempdir().unwrap();
    let mut all = printing(home.path());
    all.push((vec!["verify".to_owned(), "missing".to_owned()], 30));
    all.push((vec!["--nonsense".to_owned()], 2));
    for (arguments, code) in all {
        let status = longstep(home.path())
            .args(&arguments)
            .stdin(Stdio::null())
            .stdout(Stdio::null())
            .stderr(File::options().write(true).open("/dev/full").unwrap())
            .status()
            .unwrap();
        assert_eq!(status.code(), Some(code), "{arguments:?}");
    }
}

#[test]
fn a_reader_that_goes_away_ends_the_program_quietly() {
    let home = tempfile::tempdir().unwrap();
    for (arguments, _) in printing(home.path()) {
        let (reader, writer) = std::io::pipe().unwrap();
        drop(reader);
        let output = longstep(home.path())
            .args(&arguments)
            .stdin(Stdio::null())
            .stdout(writer)
            .output()
            .unwrap();
        let stderr = String::from_utf8(output.stderr).unwrap();
        assert_eq!(output.status.code(), Some(60), "{arguments:?}\n{stderr}");
        let ours = stderr
            .lines()
            .filter(|line| !line.starts_with("Report: ") && !line.starts_with("Resuming after"));
        assert_eq!(ours.collect::<Vec<_>>(), Vec::<&str>::new(), "{arguments:?}");
    }
}

#[cfg(target_os = "linux")]
#[test]
fn chat_accepts_no_plan_that_it_could_not_show() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::giving(vec![goals(&["put(cereal, counter)"]); 3]);
    let mut child = longstep(home.path())
        .args(["chat", "--env", PANTRY, "--model", &server.reference()])
        .stdin(Stdio::piped())
        .stdout(File::options().write(true).open("/dev/full").unwrap())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let _ = child
        .stdin
        .take()
        .unwrap()
        .write_all(b"Put the cereal on the counter\n\nPut the cereal on the counter\n\n");
    assert_eq!(child.wait().unwrap().code(), Some(60));
    let log = std::fs::read_to_string(home.path().join("state/longstep/sessions/pantry-1/session.jsonl")).unwrap();
    assert!(
        log.contains("\"instruction\"") && !log.contains("\"accept\",\"number\""),
        "{log}"
    );
    assert!(!home.path().join("state/longstep/sessions/pantry-1/0.json").exists());
}

#[test]
fn save_writes_through_links_pipes_and_devices() {
    let home = tempfile::tempdir().unwrap();
    let path = |name: &str| home.path().join(name);
    let save = |to: &Path| {
        let ran = run(longstep(home.path()).args(GOAL).arg("--save").arg(to), "");
        assert_eq!(ran.code, 0, "{}", ran.stderr);
    };
    let is_plan = |text: &[u8]| {
        let plan: Value = serde_json::from_slice(text).unwrap();
        assert!(plan["task_cohesion"].is_object());
    };
    // New, there, behind a link, behind a link to nothing.
    save(&path("new.json"));
    assert_eq!(mode(&path("new.json")), 0o600);
    std::fs::write(path("old.json"), "old").unwrap();
    std::fs::set_permissions(path("old.json"), Permissions::from_mode(0o664)).unwrap();
    symlink("old.json", path("link.json")).unwrap();
    symlink("made.json", path("dangling.json")).unwrap();
    for link in ["link.json", "dangling.json"] {
        save(&path(link));
        assert!(path(link).is_symlink());
    }
    assert_eq!(mode(&path("old.json")), 0o664);
    for file in ["new.json", "old.json", "made.json"] {
        is_plan(&std::fs::read(path(file)).unwrap());
    }
    // A pipe and a device.
    assert!(Command::new("mkfifo").arg(path("pipe")).status().unwrap().success());
    let pipe = path("pipe");
    let reader = thread::spawn(move || std::fs::read(pipe).unwrap());
    save(&path("pipe"));
    is_plan(&reader.join().unwrap());
    assert!(std::fs::metadata(path("pipe")).unwrap().file_type().is_fifo());
    symlink("/dev/null", path("null")).unwrap();
    save(&path("null"));
    assert!(path("null").is_symlink());
    assert!(std::fs::metadata("/dev/null").unwrap().file_type().is_char_device());
}

#[cfg(target_os = "linux")]
#[test]
fn commands_stop_reading_endless_files_at_the_size_limit() {
    let home = tempfile::tempdir().unwrap();
    suite(home.path());
    let path = |name: &str| home.path().join(name).to_str().unwrap().to_owned();
    let zero = |name: &str| {
        let path = home.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap().join("prompt")).unwrap();
        let _ = std::fs::remove_file(&path);
        symlink("/dev/zero", path).unwrap();
    };
    for name in [
        "domain/domain.pddl",
        "domain/domain.toml",
        "session/session.jsonl",
        "run/run.json",
    ] {
        zero(name);
    }
    let plan = "crates/longstep-cli/tests/plans/good.json";
    let at = |more: &[&str]| more.iter().map(|word| (*word).to_owned()).collect::<Vec<String>>();
    for arguments in [
        at(&["verify", "/dev/zero"]),
        at(&["verify", plan, "--env", "/dev/zero"]),
        at(&["verify", plan, "--domain", &path("domain")]),
        at(&["repair", "/dev/zero"]),
        at(&["export", "/dev/zero", "--format", "json"]),
        at(&["solve", "--goal", "x", "--env", "/dev/zero"]),
        at(&["solve", "--problem", "/dev/zero", "--domain", "/dev/zero"]),
        at(&["plan", "x", "--env", "/dev/zero"]),
        at(&["plan", "x", "--env", PANTRY, "--model", "replay:/dev/zero"]),
        at(&["chat", "--env", "/dev/zero"]),
        at(&["chat", "--resume", &path("session")]),
        at(&["session", "show", &path("session")]),
        at(&["session", "show", "/dev/zero"]),
        at(&["compose", "--script", "/dev/zero", "--plans", plan, "--env", PANTRY]),
        at(&["compose", "--script", plan, "--plans", "/dev/zero", "--env", PANTRY]),
        at(&["domain", "check", &path("domain")]),
        at(&["eval", &path("desk"), "--replies", "/dev/zero"]),
        at(&["eval", &path("desk"), "--model", "replay:/dev/zero"]),
        at(&["eval", "report", &path("run")]),
    ] {
        let words: Vec<&str> = arguments.iter().map(String::as_str).collect();
        // Twice the largest limit, and what the program needs itself.
        let ran = run(&mut limited(home.path(), "ulimit -v 1500000; ulimit -t 60", &words), "");
        assert_eq!(ran.code, 30, "{arguments:?}\n{}", ran.stderr);
        let told = ran.stderr.contains("larger than 64 MiB")
            || ran.stderr.contains("larger than 256 MiB")
            || ran.stderr.contains("not a regular file");
        assert!(told, "{arguments:?}\n{}", ran.stderr);
    }
    // A line of a pipe without an end.
    let server = Server::giving(Vec::new());
    let mut chat = limited(
        home.path(),
        "ulimit -v 1500000; ulimit -t 60; exec </dev/zero",
        &["chat", "--env", PANTRY, "--model", &server.reference()],
    );
    let output = chat.stdin(Stdio::null()).output().unwrap();
    let stderr = String::from_utf8(output.stderr).unwrap();
    assert_eq!(output.status.code(), Some(20), "{stderr}");
    assert!(stderr.contains("a line of the input is longer than 64 KiB"), "{stderr}");
}

#[test]
fn session_and_evaluation_files_are_private_to_their_owner() {
    let home = tempfile::tempdir().unwrap();
    suite(home.path());
    let path = |name: &str| home.path().join(name);
    let text = |name: &str| path(name).to_str().unwrap().to_owned();
    let server = Server::giving(vec![goals(&["put(cereal, counter)"])]);
    let chat = [
        "chat",
        "--env",
        PANTRY,
        "--model",
        &server.reference(),
        "--record",
        &text("recording"),
    ];
    let ran = run(
        &mut limited(home.path(), "umask 000", &chat),
        &format!("Put the cereal on the counter\n\n/save {}\n", text("saved/inside")),
    );
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let evaluate = [
        "eval",
        &text("desk"),
        "--replies",
        &text("replies.json"),
        "--out",
        &text("runs/one"),
    ];
    let ran = run(&mut limited(home.path(), "umask 000", &evaluate), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let session = "state/longstep/sessions/pantry-1";
    for folder in [
        "state",
        "state/longstep",
        "state/longstep/sessions",
        session,
        "saved",
        "saved/inside",
        "runs",
        "runs/one",
    ] {
        assert_eq!(mode(&path(folder)), 0o700, "{folder}");
    }
    let session_file = |name: &str| format!("{session}/{name}");
    for file in [
        &session_file("session.jsonl"),
        &session_file("0.json"),
        "recording",
        "saved/inside/0.json",
        "runs/one/run.json",
        "runs/one/results.jsonl",
        "runs/one/timings.jsonl",
        "runs/one/report.html",
        "runs/one/report.md",
    ] {
        assert_eq!(mode(&path(file)), 0o600, "{file}");
    }
    // Folders of an older version lose their broader modes; a folder with something else in it keeps its own.
    for (folder, file, command) in [
        (session, "session.jsonl", &["chat", "--resume", "pantry-1"][..]),
        ("runs/one", "results.jsonl", &evaluate),
    ] {
        for (also, expected) in [(None, 0o700), (Some("notes.txt"), 0o755)] {
            if let Some(name) = also {
                std::fs::write(path(folder).join(name), "mine").unwrap();
            }
            std::fs::set_permissions(path(folder), Permissions::from_mode(0o755)).unwrap();
            std::fs::set_permissions(path(folder).join(file), Permissions::from_mode(0o644)).unwrap();
            assert_eq!(run(longstep(home.path()).args(command), "").code, 0);
            assert_eq!(
                (mode(&path(folder)), mode(&path(folder).join(file))),
                (expected, 0o600),
                "{folder}"
            );
        }
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

fn interrupt(child: &Child) {
    let status = Command::new("kill")
        .args(["-INT", &child.id().to_string()])
        .status()
        .unwrap();
    assert!(status.success());
}

/// Reads until a line has this. Lines end with the program, so that nothing here waits for ever.
#[track_caller]
fn wait(lines: &mut impl Iterator<Item = std::io::Result<String>>, text: &str) {
    assert!(lines.any(|line| line.unwrap().contains(text)), "no `{text}`");
}

#[test]
fn chat_loses_no_input_after_ctrl_c_on_a_pipe() {
    let home = tempfile::tempdir().unwrap();
    let server = Server::giving(vec![
        goals(&["put(cereal, counter)"]),
        Answer::Silence(Duration::from_secs(60)),
        goals(&["put(juice, counter)"]),
    ]);
    let mut child = longstep(home.path())
        .args(["chat", "--env", PANTRY, "--model", &server.reference()])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut stdin = child.stdin.take().unwrap();
    let mut shown = BufReader::new(child.stdout.take().unwrap()).lines();
    let mut remarks = BufReader::new(child.stderr.take().unwrap()).lines();
    stdin.write_all(b"Put the cereal on the counter\n\n").unwrap();
    wait(&mut shown, "Accepted as plan 0");
    // In the middle of a request, it calls off the request.
    stdin.write_all(b"Put the juice on the counter\n").unwrap();
    asked(&server, 2);
    interrupt(&child);
    wait(&mut remarks, "Stopped");
    stdin.write_all(b"Put the juice on the counter\n").unwrap();
    wait(&mut shown, "Waiting for a decision");
    // Between two lines, it ends the conversation.
    interrupt(&child);
    wait(&mut remarks, "Resume with: longstep chat --resume pantry-1");
    assert_eq!(child.wait().unwrap().code(), Some(130));
    drop(stdin);
    // The plan that waited is there again.
    let ran = run(longstep(home.path()).args(["chat", "--resume", "pantry-1"]), "\n");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    assert!(ran.stdout.contains("Accepted as plan 1"), "{}", ran.stdout);
}

/// Runs a suite against a server.
fn evaluate(home: &Path, server: &str) -> Ran {
    let path = |name: &str| home.join(name).to_str().unwrap().to_owned();
    let model = format!("{server}#m");
    run(
        longstep(home).args(["eval", &path("desk"), "--out", &path("run"), "--model", &model]),
        "",
    )
}

#[test]
fn eval_resumes_a_run_only_with_its_own_server() {
    let home = tempfile::tempdir().unwrap();
    suite(home.path());
    let path = |name: &str| home.path().join(name).to_str().unwrap().to_owned();
    let [one, other] = [1, 2].map(|_| Server::answering(|_, _| goals(&["put(pen, shelf)"])));
    let with_password = one.address().replace("http://", "http://user:hunter2secret@");
    let ran = evaluate(home.path(), &with_password);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let known = std::fs::read_to_string(home.path().join("run/run.json")).unwrap();
    let host = one.address().trim_start_matches("http://").trim_end_matches("/v1");
    for secret in ["hunter2secret", host, "127.0.0.1"] {
        assert!(!known.contains(secret), "{known}");
    }
    // The same server, written in another way.
    let ran = evaluate(home.path(), &format!("{}/", one.address()));
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let ran = evaluate(home.path(), other.address());
    assert_eq!(ran.code, 30, "{}", ran.stderr);
    assert!(
        ran.stderr
            .contains("contains another run: the model's server is different\n"),
        "{}",
        ran.stderr
    );
    assert_eq!(
        std::fs::read_to_string(home.path().join("run/run.json")).unwrap(),
        known
    );
    assert_eq!(other.bodies().len(), 0);
    // Recorded replies are told apart by what is in them.
    let replies = [
        "eval",
        &path("desk"),
        "--out",
        &path("replied"),
        "--replies",
        &path("replies.json"),
    ];
    assert_eq!(run(longstep(home.path()).args(replies), "").code, 0);
    assert_eq!(run(longstep(home.path()).args(replies), "").code, 0);
    std::fs::write(
        path("replies.json"),
        REPLIES.replace("put(pen, shelf)", "put(pen, desk)"),
    )
    .unwrap();
    let ran = run(longstep(home.path()).args(replies), "");
    assert_eq!(ran.code, 30, "{}", ran.stderr);
    assert!(ran.stderr.contains("model_sha256 was"), "{}", ran.stderr);
}

#[test]
fn a_key_that_a_server_repeats_is_shown_and_kept_nowhere() {
    const KEY: &str = "sk-secret/0123456789+abc";
    let home = tempfile::tempdir().unwrap();
    let forms = [
        KEY.to_owned(),
        "sk-secret%2F0123456789%2Babc".to_owned(),
        r"sk-secret\/0123456789\u002babc".to_owned(),
        "c2stc2VjcmV0LzAxMjM0NTY3ODkrYWJj".to_owned(),
        "dXNlcjpodW50ZXIyc2VjcmV0".to_owned(),
    ];
    for form in &forms {
        for answer in [
            Answer::Status(401, json!({"error": {"message": format!("the key {form} is wrong")}})),
            Answer::Status(302, json!(format!("go to https://example.org/?key={form}"))),
            common::question(&format!("Is {form} your key?")),
            Answer::Says(format!("no JSON {form}")),
        ] {
            let server = Server::giving(vec![answer; 8]);
            let _ = std::fs::remove_dir_all(home.path().join("state"));
            let model = server.reference().replace("http://", "http://user:hunter2secret@");
            let record = home.path().join("recording");
            let ran = run(
                longstep(home.path())
                    .args(["chat", "--env", PANTRY, "--model", &model, "--record"])
                    .arg(&record)
                    .env("LONGSTEP_API_KEY", KEY),
                "Put the cereal on the counter\n",
            );
            let log =
                std::fs::read_to_string(home.path().join("state/longstep/sessions/pantry-1/session.jsonl")).unwrap();
            let recorded = std::fs::read_to_string(&record).unwrap_or_default();
            assert!(!server.bodies().is_empty());
            for (what, text) in [
                ("stdout", &ran.stdout),
                ("stderr", &ran.stderr),
                ("log", &log),
                ("recording", &recorded),
            ] {
                for secret in forms.iter().map(String::as_str).chain(["sk-secret", "hunter2secret"]) {
                    assert!(!text.contains(secret), "{secret} in {what}: {text}");
                    let escaped = json!(secret).to_string();
                    assert!(!text.contains(escaped.trim_matches('"')), "{secret} in {what}: {text}");
                }
            }
        }
    }
}
