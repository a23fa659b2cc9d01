//! Drives the built program as a person would, without a model.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::{Path, PathBuf};
use std::process::Command;

use common::Page;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Runs `longstep` at the root of the repository; returns exit code, stdout and stderr.
fn longstep(arguments: &[&str]) -> (i32, String, String) {
    let cache = tempfile::tempdir().unwrap();
    let output = Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args(arguments)
        .current_dir(root())
        .env("LONGSTEP_CACHE", cache.path())
        .env_remove("LONGSTEP_MODEL")
        .env_remove("OPENAI_API_KEY")
        .output()
        .unwrap();
    let text = |bytes: Vec<u8>| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// The view of a person: exit code, stdout, stderr; times are masked.
fn seen(arguments: &[&str]) -> String {
    let (code, stdout, stderr) = longstep(arguments);
    let mut seen = format!("exit code {code}\n");
    for (name, text) in [("stdout", stdout), ("stderr", stderr)] {
        if !text.is_empty() {
            seen.push_str(&format!("--- {name}\n{text}"));
        }
    }
    seen
}

macro_rules! snapshot {
    ($name:literal, $text:expr) => {
        insta::with_settings!({filters => vec![(r"\d+\.\d+ m?s", "[time]"), (r"/tmp/[^\s,)]*", "[temporary]")]}, {
            insta::assert_snapshot!($name, $text);
        });
    };
}

const PANTRY: &str = "examples/environments/pantry.json";

#[test]
fn domains_are_listed_and_shown() {
    let mut page = Page::default();
    page.add("domain_list", seen(&["domain", "list"]));
    page.add("domain_show", seen(&["domain", "show", "virtualhome"]));
    page.add("domain_check", seen(&["domain", "check", "examples/greenhouse"]));
    snapshot!("domains", page.text());
}

#[test]
fn solve_writes_and_reads_pddl_problems() {
    let mut page = Page::default();
    let goal = "put(butter, shelf top)";
    page.add(
        "solve_as_pddl",
        seen(&["solve", "--goal", goal, "--env", PANTRY, "--pddl"]),
    );
    let (_, problem, _) = longstep(&["solve", "--goal", goal, "--env", PANTRY, "--pddl"]);
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("problem.pddl");
    std::fs::write(&path, problem).unwrap();
    let path = path.to_str().unwrap();
    let domain = "crates/longstep-model/domains/household/domain.pddl";
    page.add("solve_problem", seen(&["solve", "--problem", path, "--domain", domain]));
    let (code, stdout, _) = longstep(&["solve", "--problem", path, "--domain", domain, "--json"]);
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, answer["status"].as_str()), (0, Some("verified")));
    page.add(
        "problem_of_another_domain",
        seen(&["solve", "--problem", path, "--domain", "examples/greenhouse"]),
    );
    // A problem needs its domain, and is a goal and an environment already.
    for extra in [
        &[][..],
        &["--domain", domain, "--env", PANTRY],
        &["--domain", domain, "--goal", goal],
    ] {
        assert_eq!(longstep(&[&["solve", "--problem", path], extra].concat()).0, 2);
    }
    snapshot!("problems", page.text());
}

#[test]
fn plans_of_planners_are_verified_and_repaired() {
    let goal = "put(butter, shelf top)";
    let (_, problem, _) = longstep(&["solve", "--goal", goal, "--env", PANTRY, "--pddl"]);
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let problem = file("problem.pddl", &problem);
    let task = [
        "--problem",
        &problem,
        "--domain",
        "crates/longstep-model/domains/household/domain.pddl",
    ];
    let (_, plan, _) = longstep(&[&["solve"], &task[..]].concat());
    let steps: Vec<&str> = plan.lines().filter(|line| line.starts_with('(')).collect();
    let timed = |(place, step): (usize, &&str)| format!("{place}.001: {} [0.500]\n", step.to_uppercase());
    let called = |step: &&str| {
        let (name, arguments) = step.trim_matches(['(', ')']).split_once(' ').unwrap();
        format!("    {name}({})\n", arguments.replace(' ', ", "))
    };
    let timed: String = steps.iter().enumerate().map(timed).collect();
    let called: String = steps.iter().map(called).collect();
    let two = format!(
        "; Plan found with metric 9\n0: {} [1]\n; Plan found with metric 4\n{timed}",
        steps[0]
    );
    for (name, text, code, shown) in [
        ("solve.plan", plan.clone(), 0, ""),
        ("popf.plan", timed, 0, ""),
        ("up.txt", format!("SequentialPlan:\n{called}"), 0, ""),
        ("anytime.plan", two, 0, "the last one was taken"),
        ("short.plan", steps[1..].join("\n"), 10, "step 1"),
        (
            "typo.plan",
            format!("{}\n(fly butter)", steps[0]),
            30,
            "typo.plan:2:2: unknown action `fly`",
        ),
        (
            "words.txt",
            "Walk to the shelf and put the butter down.".to_owned(),
            30,
            "words.txt",
        ),
    ] {
        let path = file(name, &text);
        let (found, stdout, stderr) = longstep(&[&["verify", &path], &task[..]].concat());
        assert_eq!(found, code, "{name}: {stdout}{stderr}");
        assert!(format!("{stdout}{stderr}").contains(shown), "{name}: {stdout}{stderr}");
    }
    let short = folder.path().join("short.plan");
    let saved = folder.path().join("mended.json");
    let (short, saved) = (short.to_str().unwrap(), saved.to_str().unwrap());
    let (code, stdout, _) = longstep(&[&["repair", short, "--save", saved], &task[..]].concat());
    assert_eq!(code, 0, "{stdout}");
    // The goal of the problem is the purpose: a plan that does nothing is valid and does not reach it.
    let empty = file("empty.plan", "; cost = 0 (unit cost)\n");
    assert_eq!(longstep(&[&["verify", &empty], &task[..]].concat()).0, 10);
    // The plan fits the environment too, whose names the problem has in another notation.
    let solved = file("solve.plan", &plan);
    assert_eq!(longstep(&["verify", &solved, "--env", PANTRY]).0, 0);
}

#[test]
fn plans_in_the_notations_of_others_are_verified_and_repaired() {
    const FLAT: [&str; 4] = ["--env", "examples/environments/flat.json", "--domain", "virtualhome"];
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| {
        let path = folder.path().join(name);
        std::fs::write(&path, text).unwrap();
        path.to_str().unwrap().to_owned()
    };
    let tool_call = r#"{"message": {"tool_calls": [{"function": {"name": "walktowards", "arguments": {"target": "cabinet_7"}}},
        {"function": {"name": "open", "arguments": "{\"target\": \"cabinet_7\"}"}}]}}"#;
    let put = r#"[{"action": "Walktowards", "to": "cabinet_7"}, {"action": "Open", "thing": "cabinet_7"},
        {"action": "Grab", "what": "cupcake_10"}, {"action": "Walktowards", "to": "coffeetable_3"},
        {"action": "Put", "KEYS"}]"#;
    for (name, text, code, shown) in [
        (
            "vh.txt",
            "Look inside\nOpen it.\n\n\n[WALK] <cabinet> (1.7)\n[OPEN] <cabinet> (1.7)\n",
            0,
            "the plan was read as a VirtualHome script",
        ),
        (
            "unity.txt",
            "<char0> [walk] <cabinet> (7)\n<char0> [open] <cabinet> (7)\n<char0> [grab] <cupcake> (10)\n\
             <char0> [walk] <coffeetable> (3)\n<char0> [putback] <cupcake> (10) <coffeetable> (3)\n",
            0,
            "the plan was read as a VirtualHome script",
        ),
        (
            "calls.json",
            tool_call,
            0,
            "the plan was read as objects of one step each",
        ),
        (
            "list.md",
            "1. `Walktowards(cabinet_7)`\n2. `Open(cabinet_7)`\n3. `Grab(cupcake_10)`\n",
            0,
            "the plan was read as a numbered list",
        ),
        (
            "short.md",
            "- Grab(<cupcake_10>)\n",
            10,
            "the plan was read as a list of calls",
        ),
        (
            "plan.yaml",
            "plan:\n  - action: Walktowards\n    to: cabinet_7\n  - Open: cabinet_7\n",
            0,
            "the plan was read as YAML",
        ),
        (
            "fork.json",
            r#"{"instructions": ["open it"], "program": ["WalkTowards(<cabinet_7>)", "Open(<cabinet_7>)"]}"#,
            0,
            "the plan was read as a list of steps",
        ),
        (
            "named.json",
            &put.replace("KEYS", "item\": \"cupcake_10\", \"place\": \"coffeetable_3"),
            0,
            "",
        ),
        (
            "swapped.json",
            &put.replace("KEYS", "onto\": \"coffeetable_3\", \"what\": \"cupcake_10"),
            0,
            "",
        ),
        (
            "tree.xml",
            "<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\"><Open thing=\"cabinet_7\"/></BehaviorTree></root>",
            10,
            "Open(<cabinet_7>) needs that the cabinet is within reach",
        ),
        (
            "prose.txt",
            "Walk to the cabinet.",
            30,
            "a plan is JSON, YAML, a script",
        ),
    ] {
        let path = file(name, text);
        let (found, stdout, stderr) = longstep(&[&["verify", &path], &FLAT[..]].concat());
        assert_eq!(found, code, "{name}: {stdout}{stderr}");
        let printed = format!("{stdout}{stderr}");
        let words: Vec<&str> = printed.split_whitespace().collect();
        assert!(words.join(" ").contains(shown), "{name}: {printed}");
    }
    let (short, saved) = (file("short.md", "- Grab(<cupcake_10>)\n"), file("mended.json", ""));
    let (code, stdout, _) = longstep(&[&["repair", &short, "--save", &saved], &FLAT[..]].concat());
    assert_eq!(code, 0, "{stdout}");
    assert_eq!(longstep(&[&["verify", &saved], &FLAT[..]].concat()).0, 0);
}

#[test]
fn environments_may_be_python_literals() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("env.py");
    let text = "# the office\n{'environment': {\n    'assets': ['<desk>', '<shelf>', '<floor>',],\n    \
        'asset_states': {'<shelf>': 'on_something(<floor>)'},\n    'objects': ('<pen>',),\n    \
        'object_states': {'<pen>': 'on_something(<desk>)'},  # dry?\n    'names': None,\n}}\n";
    std::fs::write(&path, text).unwrap();
    let path = path.to_str().unwrap();
    let (code, stdout, stderr) = longstep(&["solve", "--goal", "put(pen, shelf)", "--env", path]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    std::fs::write(path, text.replace("None", "Nothing")).unwrap();
    let (code, _, stderr) = longstep(&["solve", "--goal", "put(pen, shelf)", "--env", path]);
    assert_eq!(code, 30);
    assert!(
        stderr.contains("`Nothing` is not in quotes at line 7 column 14"),
        "{stderr}"
    );
}

#[test]
fn goals_are_solved() {
    let mut page = Page::default();
    page.add(
        "solve",
        seen(&["solve", "--goal", "put(butter, shelf top)", "--env", PANTRY]),
    );
    page.add(
        "solve_nothing",
        seen(&["solve", "--goal", "put(juice, shelf bottom)", "--env", PANTRY]),
    );
    page.add(
        "solve_greenhouse",
        seen(&[
            "solve",
            "--goal",
            "watered(basil) & aired(south bed)",
            "--env",
            "examples/greenhouse/environment.json",
            "--domain",
            "examples/greenhouse",
        ]),
    );
    page.add(
        "solve_unsolvable",
        seen(&[
            "solve",
            "--goal",
            "CLOSED(<oven_6>) & OPEN(<oven_6>)",
            "--env",
            "examples/environments/flat.json",
            "--domain",
            "virtualhome",
        ]),
    );
    snapshot!("solve", page.text());
}

#[test]
fn plans_are_verified() {
    let mut page = Page::default();
    page.add(
        "verify_good",
        seen(&["verify", "crates/longstep-cli/tests/plans/good.json"]),
    );
    page.add(
        "verify_closed_fridge",
        seen(&["verify", "crates/longstep-cli/tests/plans/closed_fridge.json"]),
    );
    page.add(
        "verify_unknown",
        seen(&[
            "verify",
            "crates/longstep-cli/tests/plans/unknown.json",
            "--domain",
            "virtualhome",
        ]),
    );
    snapshot!("verify", page.text());
}

const FLAT: &str = "examples/environments/flat.json";

/// A plan of the tests.
macro_rules! plan {
    ($file:literal) => {
        concat!("crates/longstep-cli/tests/plans/", $file)
    };
}

/// `longstep COMMAND PLAN` in the flat.
fn in_flat<'a>(command: &'a str, plan: &'a str, more: &[&'a str]) -> Vec<&'a str> {
    [&[command, plan, "--env", FLAT, "--domain", "virtualhome"], more].concat()
}

#[test]
fn a_plan_is_measured_by_what_it_claims() {
    let mut page = Page::default();
    let odd = plan!("odd_claim.json");
    page.add("verify_odd_claim", seen(&in_flat("verify", odd, &[])));
    page.add("repair_odd_claim", seen(&in_flat("repair", odd, &[])));
    page.add(
        "repair_stale_claim",
        seen(&in_flat("repair", plan!("stale_claim.json"), &[])),
    );
    snapshot!("claims", page.text());
}

#[test]
fn plans_are_repaired() {
    let mut page = Page::default();
    page.add(
        "repair_another_verb",
        seen(&in_flat("repair", "examples/plans/warm_cupcake.json", &[])),
    );
    page.add(
        "repair_leaves_out",
        seen(&in_flat("repair", plan!("light_and_pillow.json"), &[])),
    );
    page.add(
        "repair_does_later",
        seen(&in_flat("repair", plan!("put_too_soon.json"), &[])),
    );
    page.add(
        "repair_hidden_arguments",
        seen(&["repair", plan!("closed_fridge.json")]),
    );
    page.add(
        "repair_nothing",
        seen(&in_flat("repair", plan!("mug_on_nightstand.json"), &[])),
    );
    page.add("repair_unsolvable", seen(&["repair", plan!("nowhere_to_put.json")]));
    snapshot!("repair", page.text());
}

#[test]
fn replies_are_read_as_plans() {
    let mut page = Page::default();
    let reply = "examples/plans/tidy_magazine.txt";
    page.add("verify_reply", seen(&in_flat("verify", reply, &[])));
    page.add("repair_reply", seen(&in_flat("repair", reply, &[])));
    let near = plan!("near_names.json");
    page.add("verify_near_names", seen(&in_flat("verify", near, &[])));
    page.add("repair_near_names", seen(&in_flat("repair", near, &[])));
    snapshot!("replies", page.text());
}

#[test]
fn commands_report_one_error_for_a_reply_without_a_plan() {
    let mut page = Page::default();
    page.add("reply_cut_off", seen(&in_flat("verify", plan!("cut_off.txt"), &[])));
    page.add("reply_refusal", seen(&in_flat("repair", plan!("refusal.txt"), &[])));
    page.add("reply_two_plans", seen(&in_flat("verify", plan!("two_plans.txt"), &[])));
    page.add("reply_malformed", seen(&in_flat("verify", plan!("malformed.txt"), &[])));
    page.add(
        "plan_without_environment",
        seen(&["repair", plan!("mug_on_nightstand.json"), "--domain", "virtualhome"]),
    );
    snapshot!("no_plan", page.text());
}

#[test]
fn a_question_in_a_reply_is_passed_on() {
    let question = plan!("question.txt");
    snapshot!("reply_question", seen(&in_flat("verify", question, &[])));
    for (command, more) in [("verify", "--feedback"), ("verify", "--json"), ("repair", "--json")] {
        let (code, stdout, _) = longstep(&in_flat(command, question, &[more]));
        assert!(
            code == 13 && stdout.contains("the mug or the magazine?"),
            "{code} {stdout}"
        );
    }
    let (code, stdout, _) = longstep(&in_flat("repair", question, &[]));
    assert!(code == 13 && stdout.starts_with("Question:"), "{code} {stdout}");
}

#[test]
fn verify_feedback_prints_a_message_for_the_model() {
    let mut page = Page::default();
    page.add(
        "feedback",
        seen(&in_flat("verify", plan!("light_and_pillow.json"), &["--feedback"])),
    );
    page.add(
        "feedback_unknown",
        seen(&in_flat("verify", plan!("near_names.json"), &["--feedback"])),
    );
    let good = longstep(&in_flat("verify", plan!("mug_on_nightstand.json"), &["--feedback"]));
    assert_eq!(good, (0, String::new(), String::new()));
    assert_eq!(longstep(&["verify", plan!("good.json"), "--feedback", "--json"]).0, 2);
    snapshot!("feedback", page.text());
}

#[test]
fn a_repaired_plan_verifies_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    std::fs::write(&path, "something longer that was there before ".repeat(1000)).unwrap();
    let saved = path.to_str().unwrap();
    let flat = |plan| in_flat("repair", plan, &["--save", saved]);
    for (repair, domain) in [
        (flat("examples/plans/warm_cupcake.json"), "virtualhome"),
        (flat("examples/plans/tidy_magazine.txt"), "virtualhome"),
        (flat(plan!("odd_claim.json")), "virtualhome"),
        (
            vec!["repair", plan!("closed_fridge.json"), "--save", saved],
            "household",
        ),
    ] {
        let (code, stdout, stderr) = longstep(&repair);
        assert_eq!(code, 0, "{stdout}{stderr}");
        assert!(stderr.contains("Saved to"), "{stderr}");
        let (code, stdout, stderr) = longstep(&["verify", saved, "--domain", domain, "--json"]);
        assert_eq!(code, 0, "{stdout}{stderr}");
        let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        assert_eq!(answer["claims"]["differing"], serde_json::json!([]), "{repair:?}");
        assert_eq!(
            answer["notes"]
                .as_array()
                .unwrap()
                .iter()
                .find(|note| note.to_string().contains("line ")),
            None
        );
    }
    // The file was written elsewhere first and moved; nothing else is left there.
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1);
}

#[test]
fn a_plan_that_cannot_be_repaired_is_not_saved() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let (code, ..) = longstep(&["repair", plan!("nowhere_to_put.json"), "--save", path.to_str().unwrap()]);
    assert_eq!((code, path.exists()), (11, false));
    let (code, stdout, stderr) = longstep(&["repair", plan!("good.json"), "--save", "/nowhere/plan.json"]);
    assert_eq!((code, stdout.as_str()), (30, ""));
    assert!(stderr.contains("cannot write /nowhere/plan.json"), "{stderr}");
}

#[test]
fn bad_input_is_one_clear_error() {
    let mut page = Page::default();
    page.add(
        "missing_environment",
        seen(&["solve", "--goal", "put(a, b)", "--env", "nowhere.json"]),
    );
    page.add(
        "broken_environment",
        seen(&["solve", "--goal", "put(a, b)", "--env", "README.md"]),
    );
    page.add(
        "folder_as_environment",
        seen(&["solve", "--goal", "put(a, b)", "--env", "docs"]),
    );
    page.add("unknown_domain", seen(&["domain", "show", "houshold"]));
    page.add(
        "other_domain",
        seen(&[
            "solve",
            "--goal",
            "on(lamp)",
            "--env",
            "examples/environments/flat.json",
        ]),
    );
    page.add(
        "unknown_name",
        seen(&["solve", "--goal", "put(jucie, shelf top)", "--env", PANTRY]),
    );
    page.add(
        "unknown_goal",
        seen(&["solve", "--goal", "sing(juice)", "--env", PANTRY]),
    );
    page.add("empty_instruction", seen(&["plan", "  ", "--env", PANTRY]));
    page.add(
        "long_instruction",
        seen(&["plan", &"put the juice ".repeat(7200), "--env", PANTRY]),
    );
    page.add(
        "unknown_model",
        seen(&[
            "plan",
            "Put the juice on the counter",
            "--env",
            PANTRY,
            "--model",
            "qwen",
        ]),
    );
    page.add(
        "model_not_here",
        seen(&["plan", "Put the juice on the counter", "--env", PANTRY]),
    );
    page.add(
        "contradictions",
        seen(&[
            "solve",
            "--goal",
            "put(a, b)",
            "--env",
            "crates/longstep-cli/tests/plans/contradiction.json",
        ]),
    );
    snapshot!("bad_input", page.text());
}

#[test]
fn a_file_that_is_no_model_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    for (name, bytes) in [("text.gguf", &b"hello"[..]), ("cut.gguf", &b"GGUF\x03\0\0\0"[..])] {
        let path = folder.path().join(name);
        std::fs::write(&path, bytes).unwrap();
        let model = path.to_str().unwrap();
        let (code, stdout, stderr) = longstep(&[
            "plan",
            "Put the juice on the counter",
            "--env",
            PANTRY,
            "--model",
            model,
        ]);
        assert_eq!((code, stdout.as_str()), (40, ""), "{stderr}");
        assert!(stderr.contains(name) && stderr.contains("hint:"), "{stderr}");
    }
}

#[test]
fn an_adapter_is_refused_with_a_server() {
    for model in ["http://127.0.0.1:9/v1#none", "ollama:none"] {
        let (code, stdout, stderr) = longstep(&[
            "plan",
            "Put the juice on the counter",
            "--env",
            PANTRY,
            "--model",
            model,
            "--adapter",
            "own.gguf",
        ]);
        assert_eq!((code, stdout.as_str()), (40, ""), "{stderr}");
        assert!(stderr.contains("leave out `--adapter`"), "{stderr}");
    }
}

/// The fields of an answer, in their order.
const FIELDS: [&str; 13] = [
    "status",
    "plan",
    "steps",
    "goal",
    "edits",
    "violations",
    "claims",
    "not_represented",
    "assumptions",
    "search",
    "usage",
    "timings_ms",
    "notes",
];

#[test]
fn json_is_one_object_with_the_published_fields() {
    let answer = |arguments: &[&str]| {
        let (code, stdout, _) = longstep(arguments);
        let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
        // A field of the whole answer stands two blanks in; a parsed object would have lost the order.
        let own = stdout
            .lines()
            .filter_map(|line| line.strip_prefix("  \"")?.split_once("\": "));
        assert_eq!(own.map(|(key, _)| key).collect::<Vec<_>>(), FIELDS, "{arguments:?}");
        (code, answer)
    };
    let (code, solved) = answer(&["solve", "--goal", "opened(fridge)", "--env", PANTRY, "--json"]);
    assert_eq!((code, &solved["status"]), (0, &"verified".into()));
    assert_eq!(solved["goal"][0], "opened(<fridge>)");
    assert_eq!(solved["steps"][1]["implicit"]["object"], "<fridge_handle>");
    let (code, invalid) = answer(&in_flat("verify", plan!("odd_claim.json"), &["--json"]));
    assert_eq!((code, &invalid["status"]), (10, &"invalid".into()));
    assert_eq!(invalid["violations"][0]["kind"], "claim");
    let (code, repaired) = answer(&in_flat("repair", plan!("light_and_pillow.json"), &["--json"]));
    assert_eq!((code, &repaired["status"]), (0, &"verified".into()));
    assert_eq!(
        (&repaired["violations"], &repaired["goal"]),
        (&serde_json::json!([]), &serde_json::json!([]))
    );
    insta::assert_snapshot!(
        "repair_edits_json",
        serde_json::to_string_pretty(&repaired["edits"]).unwrap()
    );
    let (code, unsolvable) = answer(&["repair", plan!("nowhere_to_put.json"), "--json"]);
    assert_eq!((code, &unsolvable["status"]), (11, &"unsolvable".into()));
}

#[test]
fn a_saved_plan_verifies_again() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.json");
    let path = path.to_str().unwrap();
    let goal = "put(butter, counter) & put(juice, trash bin) & wiped(counter, cloth)";
    let (code, _, stderr) = longstep(&["solve", "--goal", goal, "--env", PANTRY, "--save", path]);
    assert_eq!(code, 0, "{stderr}");
    let (code, stdout, _) = longstep(&["verify", path, "--json"]);
    let answer: serde_json::Value = serde_json::from_str(&stdout).unwrap();
    assert_eq!((code, &answer["violations"]), (0, &serde_json::json!([])));
    assert_eq!(answer["claims"]["differing"], serde_json::json!([]));
}

#[test]
fn solve_reports_a_plan_file_that_cannot_be_written() {
    let (code, stdout, stderr) = longstep(&[
        "solve",
        "--goal",
        "opened(fridge)",
        "--env",
        PANTRY,
        "--save",
        "/nowhere/plan.json",
    ]);
    assert_eq!((code, stdout.as_str()), (30, ""));
    assert!(stderr.contains("cannot write /nowhere/plan.json"), "{stderr}");
}

#[test]
fn a_new_domain_passes_its_check() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("My Porter 3");
    let path = path.to_str().unwrap();
    assert_eq!(longstep(&["domain", "new", path]).0, 0);
    let (code, _, stderr) = longstep(&["domain", "check", path]);
    assert_eq!(code, 0, "{stderr}");
    let environment = format!("{path}/environment.json");
    let (code, stdout, stderr) = longstep(&[
        "solve",
        "--goal",
        "bring(parcel, desk)",
        "--env",
        &environment,
        "--domain",
        path,
    ]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    assert_eq!(longstep(&["domain", "new", path]).0, 30);
}

#[test]
fn a_doubtful_domain_is_warned_of() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("porter");
    let porter = path.to_str().unwrap();
    assert_eq!(longstep(&["domain", "new", porter]).0, 0);
    let file = path.join("domain.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    let doubtful = text
        .replace("call = \"pick(", "call = \"drop_off(")
        .replace("\"Drive to another station.\"", "\"Drive.\"");
    std::fs::write(&file, doubtful).unwrap();
    let file = path.join("prompt/feedback.toml");
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, text.replace("pick(", "drop_off(")).unwrap();
    let mut page = Page::default();
    page.add("text", seen(&["domain", "check", porter]));
    page.add("json", seen(&["domain", "check", porter, "--json"]));
    snapshot!("domain_check", page.text());
    assert_eq!(longstep(&["domain", "check", porter, "--strict"]).0, 10);
    assert_eq!(longstep(&["domain", "check", "virtualhome", "--strict"]).0, 0);
}

#[test]
fn domain_check_reports_all_errors_at_once() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("porter");
    assert_eq!(longstep(&["domain", "new", path.to_str().unwrap()]).0, 0);
    let change = |file: &str, from: &str, to: &str| {
        let file = path.join(file);
        let text = std::fs::read_to_string(&file).unwrap();
        assert!(text.contains(from));
        std::fs::write(&file, text.replacen(from, to, 1)).unwrap();
    };
    change("domain.pddl", "(robot-at ?from) (at", "(robot-att ?from) (at");
    change("domain.toml", "name = \"drop\"", "name = \"dropp\"");
    change("domain.toml", "{parcel} is at {station}", "{parcel} is at {statoin}");
    change(
        "prompt/examples.toml",
        "bring(red box, hangar)",
        "bring(red box, cellar)",
    );
    change("prompt/goal.md", "goal.form", "goal.from");
    let (code, stdout, stderr) = longstep(&["domain", "check", path.to_str().unwrap()]);
    assert_eq!((code, stdout.as_str()), (30, ""));
    let places = [
        "domain.pddl:25:25:",
        "domain.pddl:29:12:",
        "domain.toml:14:9:",
        "domain.toml:59:9:",
        "prompt/examples.toml:8:11:",
        "prompt/goal.md:5:1:",
    ];
    for place in places {
        assert!(stderr.contains(place), "{place} is missing in\n{stderr}");
    }
}
