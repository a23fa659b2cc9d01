//! `longstep chat` and `longstep session` with a person's lines on the input and a small server in place of a model.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::io::Write;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::Duration;

use common::{Answer, PANTRY, Page, Ran, Server, another_goal, edits, goals, longstep, question, run, seen};
use serde_json::{Value, json};

macro_rules! snapshot {
    ($name:expr, $text:expr) => {
        insta::with_settings!({filters => vec![
            (r"\d+\.\d+ m?s\b", "[time]"),
            (r"\d+\.\ds\b", "[time]"),
            (r"/tmp/\.tmp[^/ ,)`]*", "[home]"),
            (r"http://127.0.0.1:\d+", "[server]"),
            (r"127.0.0.1:\d+", "[server]"),
            (r"\d{4}-\d\d-\d\d \d\d:\d\d", "[when]"),
        ]}, {
            insta::assert_snapshot!($name, $text);
        });
    };
}

/// A home for sessions, and a folder for one.
struct Home(tempfile::TempDir);

impl Home {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self) -> &Path {
        self.0.path()
    }

    fn session(&self) -> PathBuf {
        self.path().join("session")
    }

    fn log(&self) -> PathBuf {
        self.session().join("session.jsonl")
    }

    /// The program with these words behind its name.
    fn longstep(&self, arguments: &[&str]) -> Command {
        let mut command = longstep(self.path());
        command.args(arguments);
        command
    }

    /// `longstep chat` in the pantry.
    fn chat(&self, server: &Server, more: &[&str]) -> Command {
        let mut command = self.longstep(&["chat", "--env", PANTRY, "--model", &server.reference()]);
        command.arg("--session").arg(self.session()).args(more);
        command
    }

    fn resume(&self, server: &Server, more: &[&str]) -> Command {
        let mut command = self.longstep(&["chat", "--model", &server.reference(), "--resume"]);
        command.arg(self.session()).args(more);
        command
    }

    /// A session with these answers and lines, and what was said in it.
    fn after(&self, answers: Vec<Answer>, lines: &str) -> Ran {
        run(&mut self.chat(&Server::giving(answers), &[]), lines)
    }

    fn plan(&self, number: usize) -> Option<Value> {
        let text = std::fs::read(self.session().join(format!("{number}.json"))).ok()?;
        Some(serde_json::from_slice(&text).unwrap())
    }
}

fn cereal_on_counter() -> Answer {
    goals(&["put(cereal, counter)"])
}

/// The paper's JSON for moving a thing, as a model writes it.
fn paper_plan(calls: &[&str], object: &str, place: &str) -> Answer {
    let explanations: Vec<String> = calls.iter().map(|call| format!("{call} with {object}")).collect();
    let plan = json!({
        "task_cohesion": {"task_sequence": calls, "step_instructions": explanations, "object_name": object},
        "environment_after": {"assets": [place], "objects": [object],
            "object_states": {object: format!("on_something({place})")}},
        "instruction_summary": "", "question": "",
    });
    Answer::Says(format!("```json\n{plan}\n```"))
}

const MOVE: [&str; 6] = [
    "move_hand()",
    "grasp_object()",
    "detach_from_plane()",
    "move_object()",
    "attach_to_plane()",
    "release_object()",
];

#[test]
fn chat_conversations_match_their_snapshots() {
    let mut page = Page::default();
    let table: Vec<(&str, &[&str], Vec<Answer>, &str)> = vec![
        (
            "one_after_the_other",
            &[],
            vec![cereal_on_counter(), goals(&["put(cereal, shelf top)"])],
            "Put the cereal on the counter\n\nNow put it back where it was\nyes\n",
        ),
        (
            "question_and_answer",
            &[],
            vec![question("Which thing?"), cereal_on_counter()],
            "Clear up\nthe cereal, it goes on the counter\n\n",
        ),
        (
            "other_goal",
            &[],
            vec![cereal_on_counter(), another_goal(), goals(&["put(cereal, fridge)"])],
            "Put the cereal away\nnot there, into the fridge\n\n",
        ),
        (
            "step_inserted",
            &[],
            vec![cereal_on_counter(), edits(&["insert move_object() after 4"])],
            "Put the cereal on the counter\ninsert another move_object() after step 4\n\n",
        ),
        (
            "wish_refused",
            &[],
            vec![cereal_on_counter(), edits(&["drop 2"])],
            "Put the cereal on the counter\nleave out step 2\n/plan\n\n",
        ),
        (
            "given_up",
            &[],
            vec![cereal_on_counter(), goals(&["put(juice, counter)"])],
            "Put the cereal on the counter\nno\nPut the juice on the counter\n/undo\n/undo\n",
        ),
        (
            "taken_back",
            &[],
            vec![cereal_on_counter(), goals(&["put(juice, counter)"])],
            "Put the cereal on the counter\n\nPut the juice on the counter\n\n/undo\n/undo\n/undo\n/env\n",
        ),
        (
            "commands",
            &[],
            vec![cereal_on_counter()],
            "/plan\n/why 1\n/env\n/help\n/plann\n/xyzzy\n/save\n/strategy\n/strategy both\n/model nonsense:1\n\
             Put the cereal on the counter\n/plan\n/why 2\n/why 99\n/why\n\n/plan\n/why 2\n/quit\nnot heard\n",
        ),
        (
            "direct_with_repair",
            &["--strategy", "direct"],
            vec![paper_plan(&MOVE[1..], "<cereal>", "<counter>")],
            "Put the cereal on the counter\n\n",
        ),
        (
            "strategy_changed",
            &[],
            vec![cereal_on_counter(), paper_plan(&MOVE, "<juice>", "<counter>")],
            "Put the cereal on the counter\n\n/strategy direct\nPut the juice on the counter\n\n",
        ),
        (
            "accepted_without_asking",
            &["--yes"],
            vec![
                cereal_on_counter(),
                goals(&["put(counter, shelf top)"]),
                // A wrong answer is asked for once more.
                goals(&["put(counter, shelf top)"]),
                goals(&["put(cereal, shelf top)"]),
            ],
            "Put the cereal on the counter\nPut the counter on the shelf\nPut the cereal back\n",
        ),
        (
            "nothing_to_do",
            &[],
            vec![goals(&["put(juice, shelf bottom)"])],
            "Put the juice on the lower shelf\n\n/why 1\n",
        ),
        (
            "end_of_input_with_a_plan_at_hand",
            &[],
            vec![cereal_on_counter()],
            "Put the cereal on the counter\n",
        ),
        (
            "observed",
            &[],
            vec![goals(&["put(cereal, shelf top)"])],
            concat!(
                "/observe\n/observe nowhere.json\n/observe ",
                env!("CARGO_MANIFEST_DIR"),
                "/tests/observations/cereal.json\nPut the cereal on the upper shelf\n/observe nowhere.json\n\n/env\n"
            ),
        ),
        ("end_of_input_at_once", &[], vec![], ""),
        (
            "nonsense_from_the_model",
            &[],
            vec![
                Answer::Says("Sure!".to_owned()),
                Answer::Says("Sure!".to_owned()),
                cereal_on_counter(),
            ],
            "Put the cereal on the counter\nthe cereal, on the counter\n\n",
        ),
        (
            "server_fails",
            &[],
            vec![
                Answer::Status(400, json!({"error": {"message": "no such model"}})),
                cereal_on_counter(),
                Answer::Status(400, json!({"error": {"message": "out of memory"}})),
            ],
            "Put the cereal on the counter\nPut the cereal on the counter\nnot there\n\n",
        ),
        (
            "too_long",
            &[],
            vec![],
            // One character more than may be said.
            Box::leak(format!("{}\n", "a".repeat(2001)).into_boxed_str()),
        ),
    ];
    for (name, arguments, answers, lines) in table {
        let home = Home::new();
        let server = Server::giving(answers);
        page.add(name, seen(&mut home.chat(&server, arguments), lines));
    }
    snapshot!("conversations", page.text());
}

#[test]
fn chat_continues_after_a_server_error_on_stderr() {
    let down = || Answer::Status(503, json!({"error": {"message": "busy"}}));
    for trouble in [down as fn() -> Answer, || Answer::HangUp] {
        let home = Home::new();
        // A request is tried three times.
        let server = Server::giving(vec![trouble(), trouble(), trouble(), cereal_on_counter()]);
        let lines = "Put the cereal on the counter\nPut the cereal on the counter\n\n";
        let ran = run(&mut home.chat(&server, &[]), lines);
        assert_eq!(ran.code, 0, "{}", ran.stderr);
        assert!(
            ran.stderr.contains("error: ") && ran.stderr.contains("hint: "),
            "{}",
            ran.stderr
        );
        assert!(!ran.stdout.contains("error:"), "{}", ran.stdout);
        assert!(ran.stdout.contains("Accepted as plan 0"), "{}", ran.stdout);
        assert_eq!(server.bodies().len(), 4);
    }
}

#[test]
fn save_command_copies_the_plans_of_the_session() {
    let home = Home::new();
    let target = home.path().join("elsewhere/plans");
    let lines = format!(
        "Put the cereal on the counter\n\nPut the juice on the counter\n\n/save {}\n",
        target.display()
    );
    let ran = home.after(vec![cereal_on_counter(), goals(&["put(juice, counter)"])], &lines);
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    for number in 0..2 {
        let name = format!("{number}.json");
        let saved = std::fs::read(target.join(&name)).unwrap();
        assert_eq!(saved, std::fs::read(home.session().join(&name)).unwrap());
    }
    let (first, second) = (home.plan(0).unwrap(), home.plan(1).unwrap());
    assert_eq!(first["environment_after"], second["environment_before"]);
    // Each is a plan like any other.
    let path = home.session().join("1.json");
    let verified = run(&mut home.longstep(&["verify", path.to_str().unwrap(), "--json"]), "");
    assert_eq!(verified.code, 0, "{}", verified.stdout);
}

#[test]
fn model_command_keeps_the_old_model_after_an_error() {
    let home = Home::new();
    let lines = "/model nonsense:1\n/model\nPut the cereal on the counter\n\n";
    let ran = home.after(vec![cereal_on_counter()], lines);
    assert!(ran.stderr.contains("`nonsense:1` is not a model"), "{}", ran.stderr);
    assert!(ran.stdout.contains("#recorded"), "{}", ran.stdout);
    assert!(ran.stdout.contains("Accepted as plan 0"), "{}", ran.stdout);
}

#[test]
fn model_command_switches_the_model_of_the_chat() {
    let home = Home::new();
    let other = Server::giving(vec![goals(&["put(juice, counter)"])]);
    let lines = format!(
        "Put the cereal on the counter\n\n/model {}\nPut the juice on the counter\n\n",
        other.reference()
    );
    let ran = home.after(vec![cereal_on_counter()], &lines);
    assert!(
        ran.stdout.contains("Accepted as plan 1"),
        "{}{}",
        ran.stdout,
        ran.stderr
    );
    assert_eq!(other.bodies().len(), 1);
}

/// A name; answers and lines before the session is taken up again, and after.
type Resumption<'a> = (&'a str, Vec<Answer>, String, Vec<Answer>, &'a str);

#[test]
fn resumed_session_continues_where_it_ended() {
    let plan = "Put the cereal on the counter\n";
    let accepted = "Put the cereal on the counter\n\n";
    let juice = || goals(&["put(juice, counter)"]);
    let table: Vec<Resumption<'_>> = vec![
        (
            "at_rest",
            vec![cereal_on_counter()],
            accepted.to_owned(),
            vec![juice()],
            "Put the juice there too\n\n",
        ),
        ("with_a_plan", vec![cereal_on_counter()], plan.to_owned(), vec![], "\n"),
        (
            "with_a_question",
            vec![question("Which one?")],
            "Put it on the counter\n".to_owned(),
            vec![cereal_on_counter()],
            "the cereal\n\n",
        ),
        (
            "after_a_plan_was_taken_back",
            vec![cereal_on_counter(), juice()],
            format!("{accepted}Put the juice there too\n\n/undo\n"),
            vec![juice()],
            "Put the juice there too\n\n",
        ),
        (
            "with_trouble",
            vec![goals(&["put(counter, shelf top)"]); 2],
            "Put the counter on the shelf\n".to_owned(),
            vec![cereal_on_counter()],
            "Put the cereal on the counter\n\n",
        ),
    ];
    let mut page = Page::default();
    for (name, before, lines, after, more) in table {
        let home = Home::new();
        home.after(before, &lines);
        let server = Server::giving(after);
        page.add(name, seen(&mut home.resume(&server, &[]), more));
    }
    snapshot!("resumed", page.text());
}

#[test]
fn session_commands_find_a_session_by_its_name() {
    let mut page = Page::default();
    let home = Home::new();
    let server = Server::giving(vec![cereal_on_counter(), goals(&["put(juice, counter)"])]);
    let reference = server.reference();
    let chat = |more: &[&str]| home.longstep(&[&["chat", "--model", &reference], more].concat());
    run(&mut chat(&["--env", PANTRY]), "Put the cereal on the counter\n\n");
    run(&mut chat(&["--env", PANTRY]), "");
    let ran = run(&mut chat(&["--resume", "pantry-1"]), "Put the juice there too\n\n");
    assert!(
        ran.stdout.contains("Accepted as plan 1"),
        "{}{}",
        ran.stdout,
        ran.stderr
    );
    page.add("session_list", seen(&mut home.longstep(&["session", "list"]), ""));
    page.add(
        "session_show",
        seen(&mut home.longstep(&["session", "show", "pantry-1"]), ""),
    );
    page.add(
        "session_unknown",
        seen(&mut home.longstep(&["session", "show", "pantri-1"]), ""),
    );
    let ran = run(&mut home.longstep(&["session", "show", "pantry-1", "--json"]), "");
    let events: Vec<Value> = serde_json::from_str(&ran.stdout).unwrap();
    let kinds: Vec<&str> = events.iter().map(|event| event["event"].as_str().unwrap()).collect();
    assert_eq!(kinds[..4], ["begin", "model", "instruction", "prompt"]);
    assert_eq!(kinds.iter().filter(|kind| **kind == "accept").count(), 2);
    snapshot!("sessions", page.text());
}

#[test]
fn session_list_without_sessions_shows_their_folder() {
    let home = Home::new();
    snapshot!("session_list_empty", seen(&mut home.longstep(&["session", "list"]), ""));
}

#[test]
fn session_replay_reports_identical_or_differing_runs() {
    let mut page = Page::default();
    let home = Home::new();
    let answers = vec![
        cereal_on_counter(),
        edits(&["insert move_object() after 4"]),
        goals(&["put(juice, counter)"]),
    ];
    let lines = "Put the cereal on the counter\ninsert another move_object() after step 4\n\n\
                 Put the juice on the counter\n\n/undo\n";
    home.after(answers, lines);
    let session = home.session();
    let replay = ["session", "replay", session.to_str().unwrap()];
    page.add("replay_same", seen(&mut home.longstep(&replay), ""));
    let text = std::fs::read_to_string(home.log()).unwrap();
    let forged = text.replacen("put(juice, counter)", "put(juice, fridge)", 1);
    assert_ne!(text, forged);
    std::fs::write(home.log(), forged).unwrap();
    let ran = run(&mut home.longstep(&replay), "");
    assert_eq!(ran.code, 10, "{}", ran.stderr);
    page.add("replay_differs", ran.stdout);
    snapshot!("replays", page.text());
}

#[test]
fn damaged_logs_are_mended_or_refused_and_never_made_worse() {
    let mut page = Page::default();
    let home = Home::new();
    home.after(
        vec![cereal_on_counter(), goals(&["put(juice, counter)"])],
        "Put the cereal on the counter\n\nPut the juice on the counter\n",
    );
    let whole = std::fs::read_to_string(home.log()).unwrap();
    let first = whole.lines().next().unwrap();
    let lines: Vec<&str> = whole.lines().collect();
    let mut damaged = lines.clone();
    // Not by length: times have more or fewer digits.
    let cut = &lines[3][..lines[3].find(r#""event""#).unwrap()];
    damaged[3] = cut;
    let table = [
        ("torn", whole[..whole.len() - 10].to_owned(), true),
        ("first_line_only", format!("{first}\n"), true),
        ("empty", String::new(), false),
        ("half_a_line", first[..40].to_owned(), false),
        ("damaged", format!("{}\n", damaged.join("\n")), false),
        ("newer", whole.replacen(r#""version":5"#, r#""version":99"#, 1), false),
        ("no_log", "hello\n".to_owned(), false),
    ];
    for (name, log, goes_on) in table {
        std::fs::write(home.log(), &log).unwrap();
        let server = Server::giving(vec![goals(&["put(butter, counter)"])]);
        let text = seen(
            &mut home.resume(&server, &[]),
            "/undo\nPut the butter on the counter\n\n",
        );
        page.add(name, text);
        let now = std::fs::read_to_string(home.log()).unwrap();
        if goes_on {
            assert!(now.contains("put(<butter>, <counter>)"), "{name}");
            assert!(
                now.lines().all(|line| serde_json::from_str::<Value>(line).is_ok()),
                "{name}"
            );
        } else {
            assert_eq!(now, log, "{name}");
        }
    }
    std::fs::remove_file(home.log()).unwrap();
    page.add("log_missing", seen(&mut home.resume(&Server::giving(vec![]), &[]), ""));
    snapshot!("logs", page.text());
}

#[test]
fn resume_leaves_a_session_that_another_process_has_open() {
    let home = Home::new();
    home.after(vec![cereal_on_counter()], "Put the cereal on the counter\n\n");
    let server = Server::giving(vec![goals(&["put(juice, counter)"])]);
    let mut command = home.resume(&server, &[]);
    let command = command
        .stdin(Stdio::piped())
        .stdout(Stdio::null())
        .stderr(Stdio::null());
    let mut first = command.spawn().unwrap();
    let mut input = first.stdin.take().unwrap();
    input.write_all(b"Put the juice there too\n").unwrap();
    // It has the session open when it asks.
    while server.bodies().is_empty() {
        std::thread::sleep(Duration::from_millis(5));
    }
    let before = std::fs::read(home.session().join("0.json")).unwrap();
    snapshot!("session_busy", seen(&mut home.resume(&server, &[]), "/undo\n"));
    // Looking at it is no harm.
    let session = home.session();
    let show = run(&mut home.longstep(&["session", "show", session.to_str().unwrap()]), "");
    assert_eq!(show.code, 0, "{}", show.stderr);
    drop(input);
    first.wait().unwrap();
    assert_eq!(std::fs::read(home.session().join("0.json")).unwrap(), before);
}

#[test]
fn resume_reports_a_plan_that_a_changed_domain_invalidates() {
    let home = Home::new();
    let domain = home.path().join("greenhouse");
    copy(&common::root().join("examples/greenhouse"), &domain);
    let server = Server::giving(vec![goals(&["watered(basil)"])]);
    let session = home.session();
    let arguments = [
        "chat",
        "--env",
        "examples/greenhouse/environment.json",
        "--domain",
        domain.to_str().unwrap(),
        "--model",
        &server.reference(),
        "--session",
        session.to_str().unwrap(),
    ];
    let ran = run(&mut home.longstep(&arguments), "Water the basil\n\n");
    assert!(
        ran.stdout.contains("Accepted as plan 0"),
        "{}{}",
        ran.stdout,
        ran.stderr
    );
    let before = (std::fs::read(home.log()).unwrap(), home.plan(0));
    let pddl = std::fs::read_to_string(domain.join("domain.pddl")).unwrap();
    let at = pddl.find(":action").unwrap();
    let (head, tail) = pddl.split_at(at);
    // The first action has another name from now on.
    let name = tail.split_whitespace().nth(1).unwrap();
    std::fs::write(
        domain.join("domain.pddl"),
        format!("{head}{}", tail.replacen(name, "renamed", 1)),
    )
    .unwrap();
    let words = std::fs::read_to_string(domain.join("domain.toml")).unwrap();
    let renamed = words.replacen(&format!("name = \"{name}\""), "name = \"renamed\"", 1);
    assert_ne!(words, renamed);
    std::fs::write(domain.join("domain.toml"), renamed).unwrap();
    snapshot!(
        "domain_changed",
        seen(&mut home.resume(&server, &[]), "Water the basil\n")
    );
    assert_eq!((std::fs::read(home.log()).unwrap(), home.plan(0)), before);
    // What was said is not lost: it can be looked at.
    let show = run(&mut home.longstep(&["session", "show", session.to_str().unwrap()]), "");
    assert!(
        show.stdout.contains("Water the basil"),
        "{}{}",
        show.stdout,
        show.stderr
    );
}

fn copy(from: &Path, to: &Path) {
    std::fs::create_dir_all(to).unwrap();
    for entry in std::fs::read_dir(from).unwrap() {
        let path = entry.unwrap().path();
        let target = to.join(path.file_name().unwrap());
        if path.is_dir() {
            copy(&path, &target)
        } else {
            std::fs::copy(&path, &target).map(|_| ()).unwrap()
        }
    }
}

#[test]
fn a_folder_that_cannot_be_written_ends_the_conversation() {
    let mut page = Page::default();
    let home = Home::new();
    let server = Server::giving(vec![cereal_on_counter()]);
    // Permissions do not hold for root: a file stands where the folder should be.
    std::fs::write(home.path().join("file"), "").unwrap();
    let blocked = home.path().join("file/session");
    let arguments = [
        "chat",
        "--env",
        PANTRY,
        "--model",
        &server.reference(),
        "--session",
        blocked.to_str().unwrap(),
    ];
    page.add(
        "folder_cannot_be_made",
        seen(&mut home.longstep(&arguments), "Put the cereal on the counter\n"),
    );
    // A folder stands where the first plan should be.
    std::fs::create_dir_all(home.session().join("0.json/in the way")).unwrap();
    let text = seen(&mut home.chat(&server, &[]), "Put the cereal on the counter\n\n/env\n");
    page.add("plan_cannot_be_written", text);
    let left: Vec<_> = std::fs::read_dir(home.session())
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    assert_eq!(left.len(), 2, "{left:?}");
    page.add("folder_is_taken", seen(&mut home.chat(&server, &[]), ""));
    snapshot!("folders", page.text());
}

#[test]
fn chat_rejects_invalid_arguments_and_creates_no_session() {
    let mut page = Page::default();
    let home = Home::new();
    let server = Server::giving(vec![]);
    let reference = server.reference();
    let table: [(&str, &[&str]); 4] = [
        ("neither", &["chat", "--model", &reference]),
        (
            "no_env",
            &[
                "chat",
                "--env",
                "examples/environments/pantri.json",
                "--model",
                &reference,
            ],
        ),
        ("both", &["chat", "--env", PANTRY, "--resume", "pantry-1"]),
        ("unknown", &["chat", "--resume", "pantry-1"]),
    ];
    for (name, arguments) in table {
        page.add(name, seen(&mut home.longstep(arguments), ""));
    }
    // No session is begun by what cannot begin.
    assert!(!home.path().join("state/longstep/sessions").exists());
    snapshot!("arguments", page.text());
}

#[test]
fn a_password_in_a_server_s_address_is_in_no_file_and_no_message() {
    let home = Home::new();
    let server = Server::giving(vec![cereal_on_counter()]);
    let reference = server.reference().replace("http://", "http://robot:hunter2@");
    let mut command = home.longstep(&["chat", "--env", PANTRY, "--model", &reference, "--yes"]);
    command.arg("--session").arg(home.session());
    let said = seen(&mut command, "The cereal goes on the counter\n");
    assert!(said.contains("Accepted as plan 0"), "{said}");
    assert!(!said.contains("hunter2"), "{said}");
    assert!(!std::fs::read_to_string(home.log()).unwrap().contains("hunter2"));
}
