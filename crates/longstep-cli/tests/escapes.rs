//! Hostile names, replies, files, arguments and variables: nothing of them reaches a terminal but visible text.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use common::{Answer, Server, goals, longstep, question, root, run};
use longstep_core::visible;
use serde_json::{Value, json};

/// An escape sequence of each kind, control characters of C0 and C1, bidirectional controls, separators, characters
/// without width, and a line that is not ours.
const HOSTILE: &str = "ju\u{1b}]0;PWN\u{7}\u{1b}[31m\u{1b}[2J\u{9b}2Jc\u{202e}\u{2066}e\u{8}\u{7f}\u{200b}\u{2028}\u{61c}\
                       \u{e0041}\r\nVerified: 99 steps";

/// As part of a file's name.
const NAME: &str = "ju\u{1b}]0;PWN\u{7}\u{202e}ice\nVerified: 99 steps";

/// Our own styles, and those of usage and help.
const STYLES: [&str; 10] = ["0", "1", "2", "4", "22", "31", "32", "33", "36", "39"];

/// One run of the program.
struct Case {
    arguments: Vec<String>,
    input: String,
    variables: Vec<(&'static str, String)>,
}

fn case(arguments: &[&str]) -> Case {
    Case {
        arguments: arguments.iter().map(|argument| (*argument).to_owned()).collect(),
        input: String::new(),
        variables: Vec::new(),
    }
}

impl Case {
    fn input(mut self, input: &str) -> Self {
        self.input = input.to_owned();
        self
    }

    fn variable(mut self, name: &'static str, value: &str) -> Self {
        self.variables.push((name, value.to_owned()));
        self
    }
}

/// A folder with hostile files.
struct Files {
    folder: tempfile::TempDir,
}

impl Files {
    fn new() -> Self {
        let files = Self {
            folder: tempfile::tempdir().unwrap(),
        };
        let shelf = json!({"environment": {
            "assets": ["<shelf>", "<table>"], "asset_states": {},
            "objects": [format!("<{HOSTILE}>"), "<cup>"],
            "object_states": {format!("<{HOSTILE}>"): "on_something(<shelf>)", "<cup>": "on_something(<shelf>)"}}});
        files.write("env.json", &shelf.to_string());
        files.write(&format!("{NAME}.json"), &shelf.to_string());
        let steps = [
            "move_hand()",
            "grasp_object()",
            "detach_from_plane()",
            "move_object()",
            "attach_to_plane()",
            "release_object()",
        ];
        let plan = |object: &str, count: usize, after: Value| {
            json!({"task_cohesion": {"task_sequence": steps[..count],
                    "step_instructions": vec![HOSTILE; count], "object_name": format!("<{object}>")},
                   "environment_before": shelf["environment"], "environment_after": after,
                   "instruction_summary": HOSTILE, "question": ""})
            .to_string()
        };
        let mut after = shelf["environment"].clone();
        after["object_states"][format!("<{HOSTILE}>")] = json!("on_something(<table>)");
        files.write("good.json", &plan(HOSTILE, 6, after.clone()));
        files.write("short.json", &plan(HOSTILE, 3, after));
        files.write(
            "unknown.json",
            &plan(&format!("{HOSTILE}2"), 3, shelf["environment"].clone()),
        );
        files.write(
            "asks.json",
            &json!({"question": HOSTILE, "task_cohesion": {"task_sequence": []}}).to_string(),
        );
        files.write("broken.json", HOSTILE);
        files.write("broken.py", &format!("# {HOSTILE}\n{HOSTILE}(\"{HOSTILE}\")"));
        files.write(
            "lines.py",
            &format!("if expired({:?}):\n    pass", HOSTILE.replace(['\r', '\n'], "")),
        );
        for name in ["esc_plan.txt", "esc_question.txt", "esc_env.json"] {
            // As a reviewer found them.
            files.write(
                name,
                REVIEWED[usize::from(name == "esc_question.txt") + 2 * usize::from(name == "esc_env.json")],
            );
        }
        files.write(
            "demo.csv",
            &format!("t,hand,x,y,z,step\n0,right,0,0,0,1\n0.1,{HOSTILE},0,0,0,1\n"),
        );
        let rows: Vec<Value> = (0..20)
            .map(|row| json!({"t": row, "hand": "right", "x": 0, "y": 0, "z": 0}))
            .collect();
        files.write(&format!("{NAME}.csv"), "t,hand,x,y,z\n0,right,0,0,0\n");
        files.write(&format!("{NAME} demo.json"), &json!(rows).to_string());
        files.domain();
        files.suite();
        files
    }

    fn path(&self, name: &str) -> String {
        self.folder.path().join(name).to_str().unwrap().to_owned()
    }

    fn write(&self, name: &str, text: &str) {
        let path = self.folder.path().join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, text).unwrap();
    }

    /// `household` with hostile words, once as a domain that loads and once as one that does not.
    fn domain(&self) {
        let shipped = root().join("crates/longstep-model/domains/household");
        let escaped = "\\u001b]0;PWN\\u0007\\u202ex\\nVerified: 99 steps ";
        let copy = |from: PathBuf, name: &str| {
            let text = std::fs::read_to_string(from).unwrap();
            let text = if name.ends_with("domain.toml") {
                [
                    "means = \"",
                    "about = \"",
                    "explanation = \"",
                    "says = \"",
                    "short = \"",
                ]
                .iter()
                .fold(text, |text, key| text.replace(key, &format!("{key}{escaped}")))
            } else {
                text
            };
            self.write(&format!("domain/{name}"), &text);
            self.write(&format!("wrong/{name}"), &text.replace("asset", HOSTILE));
        };
        for name in ["domain.pddl", "domain.toml"] {
            copy(shipped.join(name), name);
        }
        for entry in std::fs::read_dir(shipped.join("prompt")).unwrap() {
            let path = entry.unwrap().path();
            let name = format!("prompt/{}", path.file_name().unwrap().to_str().unwrap());
            copy(path, &name);
        }
    }

    fn suite(&self) {
        let text = |text: &str| json!(text).to_string().replace('\u{7f}', "\\u007f");
        let hostile = text(&visible::json(HOSTILE).replace("\\u", "u"));
        self.write(
            "suite/suite.toml",
            &format!("name = \"desk\"\nabout = {hostile}\ndomain = \"household\"\n"),
        );
        let case = |id: &str| {
            format!(
                "[[case]]\nid = \"{id}\"\nscene = \"desk\"\nsays = \"Shelve the \\u001b[31mpen\\u202e\\nVerified: 99 steps\"\n\
                 goal = \"put(pen, shelf)\"\ntags = [\"x\\u001b[31m\\u202e\"]\n"
            )
        };
        self.write("suite/cases.toml", &case("pen"));
        self.write(
            "wrong_suite/suite.toml",
            "name = \"desk\"\nabout = \"x\"\ndomain = \"household\"\n",
        );
        self.write("wrong_suite/cases.toml", &case("p\\u001b[31m\\u202en"));
        for suite in ["suite", "wrong_suite"] {
            self.write(
                &format!("{suite}/scenes/desk.json"),
                r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#,
            );
        }
        let replies = |replies: Value| json!([{"case": "pen", "reply": replies}]).to_string();
        self.write(
            "asks_back.json",
            &replies(json!({"goal": "", "left_out": [], "question": HOSTILE})),
        );
        self.write("nonsense.json", &replies(json!(HOSTILE)));
        self.write(
            "no_replies.json",
            &json!([{"case": HOSTILE, "round": 3, "reply": HOSTILE}]).to_string(),
        );
    }
}

const REVIEWED: [&str; 3] = [
    r#"{"task_cohesion": {"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "step_instructions": ["move \u001b[31mred", "grasp\u001b]0;PWN\u0007", "rel"], "object_name": "<\u001b]0;PWN\u0007\u001b[31mju\u202eice\u001b[2J>"}, "instruction_summary": "\u001b[31msum"}"#,
    r#"{"question": "Which \u001b[31mRED\u001b]0;PWN\u0007?", "task_cohesion": {"task_sequence": []}}"#,
    r#"{"environment": {"assets": ["<shelf>", "<table>"], "asset_states": {}, "objects": ["<\u001b]0;PWN\u0007\u001b[31mju\u202eice\u001b[2J>", "<cup>"], "object_states": {"<\u001b]0;PWN\u0007\u001b[31mju\u202eice\u001b[2J>": "on_something(<shelf>)"}}}"#,
];

/// All subcommands that need no model, with everything hostile that they take.
fn without_a_model(files: &Files) -> Vec<Case> {
    let path = |name: &str| files.path(name);
    let (env, named, folder) = (path("env.json"), path(&format!("{NAME}.json")), path("domain"));
    let mut cases = Vec::new();
    for plan in [
        "good.json",
        "short.json",
        "unknown.json",
        "asks.json",
        "broken.json",
        "broken.py",
        "lines.py",
        "missing",
    ] {
        let plan = path(plan);
        for command in ["verify", "repair"] {
            cases.push(case(&[command, &plan, "--env", &env]));
            cases.push(case(&[command, &plan, "--env", &env, "--domain", &folder]));
            cases.push(case(&[command, &plan, "--env", &env, "--json"]));
        }
        cases.push(case(&["verify", &plan, "--env", &env, "--feedback"]));
        for demo in [
            "demo.csv",
            &format!("{NAME}.csv"),
            &format!("{NAME} demo.json"),
            HOSTILE,
        ] {
            let (demo, output) = (path(demo), path("skills.json"));
            cases.push(case(&["teach", &plan, "--env", &env, "--demo", &demo, "-o", &output]));
            cases.push(case(&[
                "teach",
                &plan,
                "--env",
                &env,
                "--demo",
                &demo,
                "--segments",
                "1:0-9",
                "-o",
                &output,
            ]));
            cases.push(case(&[
                "teach",
                &plan,
                "--env",
                &env,
                "--demo",
                &demo,
                "--segments",
                HOSTILE,
                "-o",
                &output,
            ]));
        }
        for format in ["python", "json", HOSTILE] {
            cases.push(case(&["export", &plan, "--env", &env, "--format", format]));
        }
        cases.push(case(&[
            "compose",
            "--script",
            &plan,
            "--plans",
            &path("good.json"),
            "--env",
            &env,
        ]));
    }
    for plan in ["esc_plan.txt", "esc_question.txt"] {
        cases.push(case(&["verify", &path(plan), "--env", &path("esc_env.json")]));
        cases.push(case(&["repair", &path(plan), "--env", &path("esc_env.json")]));
    }
    let goal = format!("put({HOSTILE}, table)");
    for goal in [goal.as_str(), "put(cup, table)", HOSTILE, "put(cup, shelf) & "] {
        for domain in ["household", "household-dual", &folder, HOSTILE] {
            cases.push(case(&["solve", "--goal", goal, "--env", &env, "--domain", domain]));
        }
        cases.push(case(&["solve", "--goal", goal, "--env", &env, "--pddl"]));
        cases.push(case(&["solve", "--goal", goal, "--env", &env, "--json"]));
        cases.push(case(&[
            "solve",
            "--goal",
            goal,
            "--env",
            &env,
            "--parallel",
            "--domain",
            "household-dual",
        ]));
        cases.push(case(&[
            "solve",
            "--goal",
            goal,
            "--env",
            &named,
            "--save",
            &path(&format!("{NAME} saved")),
        ]));
    }
    cases.push(case(&[
        "solve",
        "--problem",
        &path("broken.json"),
        "--domain",
        &path("domain/domain.pddl"),
    ]));
    cases.push(case(&[
        "solve",
        "--problem",
        &path("broken.json"),
        "--domain",
        &path("broken.json"),
    ]));
    for domain in [folder.as_str(), &path("wrong"), &path(NAME), HOSTILE] {
        for command in ["show", "check"] {
            cases.push(case(&["domain", command, domain]));
        }
        cases.push(case(&["domain", "check", domain, "--json", "--strict"]));
    }
    cases.push(case(&["domain", "list"]));
    // On a terminal, it asks questions without `--starter`.
    for _ in 0..2 {
        cases.push(case(&["domain", "new", &path(&format!("{NAME} new")), "--starter"]));
    }
    for command in ["pull", "path"] {
        cases.push(case(&["model", command, HOSTILE]));
    }
    cases.push(case(&["model", "list"]).variable("LONGSTEP_CACHE", &path(NAME)));
    cases.push(case(&["session", "list"]).variable("LONGSTEP_SESSIONS", &path(NAME)));
    for command in ["show", "replay"] {
        cases.push(case(&["session", command, HOSTILE]));
        cases.push(case(&["session", command, &path("broken.json")]));
    }
    cases.push(case(&["chat", "--resume", HOSTILE]));
    cases.push(case(&["chat", "--env", &path("broken.json")]));
    for suite in ["suite", "wrong_suite", NAME, "domain"] {
        for replies in ["asks_back.json", "nonsense.json", "no_replies.json"] {
            let out = path(&format!("{NAME} {suite} {replies}"));
            cases.push(case(&[
                "eval",
                &path(suite),
                "--replies",
                &path(replies),
                "--out",
                &out,
            ]));
            cases.push(case(&[
                "eval",
                &path(suite),
                "--replies",
                &path(replies),
                "--out",
                &out,
                "--json",
            ]));
            cases.push(case(&["eval", "report", &out]));
        }
    }
    let runs = ["asks_back.json", "nonsense.json"].map(|replies| path(&format!("{NAME} suite {replies}")));
    cases.push(case(&[
        "eval",
        "compare",
        &runs[0],
        &runs[1],
        "--html",
        &path("compared.html"),
    ]));
    cases.push(case(&["eval", &path("suite"), "--rename", HOSTILE]));
    cases.push(case(&[
        "eval",
        &path("suite"),
        "--rename",
        &format!("{HOSTILE}={HOSTILE}"),
    ]));
    cases.push(case(&["eval", "list"]));
    // What the parser of arguments repeats, and help.
    for argument in [HOSTILE, "--\u{1b}[31m\u{202e}x", "-\u{1b}", "\u{1b}[31mverify"] {
        cases.push(case(&[argument]));
        cases.push(case(&["verify", argument, argument, argument]));
        cases.push(case(&["plan", "x", "--env", argument, "--threads", argument]));
        cases.push(case(&["plan", "x", "--env", "x", "--strategy", argument]));
        cases.push(case(&["plan", "x", "--env", "x", "--temperature", argument]));
        cases.push(case(&["chat", "--env", "x", "--resume", argument]));
    }
    for name in ["LONGSTEP_MODEL", "LONGSTEP_THREADS", "LONGSTEP_CORPUS"] {
        cases.push(case(&["plan", "--help"]).variable(name, HOSTILE));
        cases.push(case(&["eval", "--help"]).variable(name, HOSTILE));
        cases.push(case(&["plan", "x", "--env", &env]).variable(name, HOSTILE));
    }
    cases
}

/// The subcommands that ask a model, and what it answers.
fn with_a_model(files: &Files) -> Vec<(Case, Vec<Answer>)> {
    let env = files.path("env.json");
    let hostile_goal = goals(&[&format!("put({HOSTILE}, table)")]);
    let answers = [
        question(HOSTILE),
        hostile_goal.clone(),
        goals(&[HOSTILE]),
        Answer::Says(HOSTILE.to_owned()),
        Answer::Says(std::fs::read_to_string(files.path("good.json")).unwrap()),
        Answer::Says(std::fs::read_to_string(files.path("short.json")).unwrap()),
        Answer::Status(400, json!({"error": {"message": HOSTILE}})),
        Answer::Status(404, json!(HOSTILE)),
    ];
    let mut cases = Vec::new();
    for answer in answers {
        let said = vec![answer; 6];
        let instruction = format!("Put the {HOSTILE} on the table");
        for more in [
            &["--json"][..],
            &[],
            &["--strategy", "direct"],
            &["--strategy", "direct", "--no-repair"],
        ] {
            let arguments = [&["plan", &instruction, "--env", &env], more].concat();
            cases.push((case(&arguments), said.clone()));
        }
        cases.push((
            case(&[
                "compose",
                &instruction,
                "--plans",
                &files.path("good.json"),
                "--env",
                &env,
            ]),
            said.clone(),
        ));
        let input = format!("Put it \u{1b}[31m\u{202e} there\n{}\nyes\n", HOSTILE.replace('\n', " "));
        cases.push((case(&["chat", "--env", &env]).input(&input), said));
    }
    for strategy in ["goal", "direct"] {
        let explain = [
            "plan",
            HOSTILE,
            "--env",
            &env,
            "--explain-prompt",
            "--strategy",
            strategy,
        ];
        cases.push((case(&explain), Vec::new()));
        let folder = files.path("domain");
        cases.push((case(&[&explain[..], &["--domain", &folder]].concat()), Vec::new()));
    }
    let line = HOSTILE.replace(['\r', '\n'], " ");
    let commands = ["plan", "why", "env", "undo", "strategy", "help", "model", &line];
    let mut lines: String = commands.iter().map(|command| format!("/{command} {line}\n")).collect();
    // A relative path would be a folder in the folder of the tests.
    lines += &format!("/save {}\n", files.path(&line));
    let input = format!("Put the {line} on the table\n/plan\n/why 1\n\n/plan\n/env\n{lines}");
    cases.push((case(&["chat", "--env", &env]).input(&input), vec![hostile_goal; 3]));
    cases
}

/// Everything that is no visible text and none of our own styles.
fn hidden(text: &str) -> Option<String> {
    let mut rest = text.to_owned();
    for style in STYLES {
        rest = rest.replace(&format!("\u{1b}[{style}m"), "");
    }
    let at = rest.find(|character| character != '\n' && visible::is_hidden(character))?;
    let from = rest[..at].char_indices().rev().nth(60).map_or(0, |(at, _)| at);
    Some(rest[from..].chars().take(120).collect())
}

/// Describes a hidden character or a forged line in printed text.
fn wrong(case: &Case, what: &str, text: &str) -> Option<String> {
    let arguments = &case.arguments;
    if let Some(hidden) = hidden(text) {
        return Some(format!("{what} of {arguments:?}: {hidden:?}"));
    }
    let forged = text.lines().any(|line| line.starts_with("Verified: 99 steps"));
    forged.then(|| format!("{what} of {arguments:?} has a forged line:\n{text}"))
}

#[track_caller]
fn check(all: Vec<Option<String>>) {
    let wrong: Vec<String> = all.into_iter().flatten().collect();
    assert!(wrong.is_empty(), "{} wrong\n{}", wrong.len(), wrong.join("\n"));
}

fn command(case: &Case, files: &Files, more: &[String]) -> Command {
    let mut command = longstep(files.folder.path());
    command.args(&case.arguments).args(more);
    for (name, value) in &case.variables {
        command.env(name, value);
    }
    command
}

fn server_for(answers: &[Answer]) -> (Server, Vec<String>) {
    let server = Server::giving(answers.to_vec());
    let model = vec!["--model".to_owned(), server.reference()];
    (server, model)
}

#[test]
fn no_command_prints_what_a_terminal_obeys() {
    let files = Files::new();
    let plain: Vec<(Case, Vec<Answer>)> = without_a_model(&files)
        .into_iter()
        .map(|case| (case, Vec::new()))
        .collect();
    let asking = with_a_model(&files);
    let first = plain.len();
    let mut all = Vec::new();
    for (number, (case, answers)) in plain.into_iter().chain(asking).enumerate() {
        let (server, model) = server_for(&answers);
        let model = if number >= first { model } else { Vec::new() };
        let ran = run(&mut command(&case, &files, &model), &case.input);
        drop(server);
        assert_ne!(ran.code, 101, "{:?}\n{}", case.arguments, ran.stderr);
        all.push(wrong(&case, "stdout", &ran.stdout));
        all.push(wrong(&case, "stderr", &ran.stderr));
        if case.arguments.iter().any(|argument| argument == "--json") && !ran.stdout.is_empty() {
            serde_json::from_str::<Value>(&ran.stdout).unwrap();
        }
    }
    // What was said is on the disk now, and shown again.
    let sessions = files.folder.path().join("state/longstep/sessions");
    let mut shown = 0;
    for entry in std::fs::read_dir(sessions).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        for arguments in [
            &["session", "show", &name][..],
            &["session", "show", &name, "--json"],
            &["session", "replay", &name],
            &["session", "list"],
            &["chat", "--resume", &name],
        ] {
            let case = case(arguments);
            let ran = run(&mut command(&case, &files, &[]), "");
            all.push(wrong(&case, "stdout", &ran.stdout));
            all.push(wrong(&case, "stderr", &ran.stderr));
            shown += 1;
        }
    }
    assert!(shown >= 40, "{shown}");
    check(all);
}

#[test]
fn json_keeps_the_value_of_what_it_escapes() {
    let files = Files::new();
    let case = case(&["verify", &files.path("good.json"), "--json"]);
    let ran = run(&mut command(&case, &files, &[]), "");
    assert_eq!(ran.code, 0, "{}", ran.stderr);
    let answer: Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!(
        answer["plan"]["environment_before"]["objects"][0],
        json!(format!("<{HOSTILE}>"))
    );
    // A script says the same, too.
    let case = self::case(&["export", &files.path("good.json"), "--format", "python"]);
    let ran = run(&mut command(&case, &files, &[]), "");
    files.write("exported.py", &ran.stdout);
    let case = self::case(&[
        "verify",
        &files.path("exported.py"),
        "--env",
        &files.path("env.json"),
        "--json",
    ]);
    let again = run(&mut command(&case, &files, &[]), "");
    assert_eq!(again.code, 0, "{}\n{}", ran.stdout, again.stderr);
    let again: Value = serde_json::from_str(&again.stdout).unwrap();
    assert_eq!(again["steps"], answer["steps"]);
}

#[cfg(target_os = "linux")]
#[test]
fn a_terminal_gets_our_own_styles_and_nothing_else() {
    let files = Files::new();
    let mut coloured = 0;
    let mut all = Vec::new();
    for case in without_a_model(&files) {
        // A bar on a terminal moves the cursor; it is drawn by indicatif and holds no text from outside.
        let draws = matches!(case.arguments[0].as_str(), "eval" | "model" | "plan" | "chat");
        let screen = on_a_terminal(&case, &files, draws);
        all.push(wrong(&case, "the screen", &screen.replace("\r\n", "\n")));
        coloured += usize::from(screen.contains("\u{1b}["));
    }
    assert!(coloured > 50, "{coloured}");
    check(all);
}

/// Runs a case in a terminal that `script` makes.
fn on_a_terminal(case: &Case, files: &Files, without_stderr: bool) -> String {
    let quoted = |text: &str| format!("'{}'", text.replace('\'', "'\\''"));
    let words: Vec<String> = case.arguments.iter().map(|argument| quoted(argument)).collect();
    let rest = if without_stderr { " 2>/dev/null" } else { "" };
    let line = format!(
        "exec {} {}{rest}",
        quoted(env!("CARGO_BIN_EXE_longstep")),
        words.join(" ")
    );
    let like = longstep(files.folder.path());
    let mut script = Command::new("script");
    script.args(["--quiet", "--return", "--command", &line, "/dev/null"]);
    for (name, value) in like.get_envs() {
        match value {
            Some(value) => script.env(name, value),
            None => script.env_remove(name),
        };
    }
    for (name, value) in &case.variables {
        script.env(name, value);
    }
    let mut child = script
        .current_dir(like.get_current_dir().unwrap_or(Path::new(".")))
        .env("TERM", "xterm")
        .env_remove("NO_COLOR")
        // Its end would be echoed.
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::null())
        .spawn()
        .unwrap();
    let keys = child.stdin.take();
    let output = child.wait_with_output().unwrap();
    drop(keys);
    String::from_utf8(output.stdout).unwrap()
}
