//! `longstep export`, and scripts as input.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::process::Command;

const SCRIPT: &str = "crates/longstep-cli/tests/plans/sort_yoghurt.py";
const WORLD: [&str; 4] = [
    "--env",
    "crates/longstep-cli/tests/plans/yoghurt.json",
    "--domain",
    "household-checks",
];

fn longstep(arguments: &[&str]) -> (i32, String, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args(arguments)
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .unwrap();
    let text = |bytes| String::from_utf8(bytes).unwrap();
    (output.status.code().unwrap(), text(output.stdout), text(output.stderr))
}

/// Exports a plan; returns where what was written is kept.
fn export(plan: &str, format: &str, folder: &tempfile::TempDir) -> String {
    let arguments = [&["export", plan, "--format", format], &WORLD[..]].concat();
    let (code, stdout, stderr) = longstep(&arguments);
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    let suffix = if format == "python" { "py" } else { "json" };
    let number = std::fs::read_dir(folder.path()).unwrap().count();
    let path = folder.path().join(format!("{number}.{suffix}"));
    std::fs::write(&path, stdout).unwrap();
    path.to_str().unwrap().to_owned()
}

#[test]
fn a_script_is_verified_and_exported_and_comes_back_the_same() {
    let (code, stdout, stderr) = longstep(&[&["verify", SCRIPT], &WORLD[..]].concat());
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    let folder = tempfile::tempdir().unwrap();
    let script = export(SCRIPT, "python", &folder);
    let json = export(&script, "json", &folder);
    let again = export(&json, "python", &folder);
    let read = |path: &str| std::fs::read_to_string(path).unwrap();
    assert_eq!(read(&script), read(&again));
    assert_eq!(read(&json), read(&export(&again, "json", &folder)));
    assert!(
        read(&script).contains("release_object(item=\"<yoghurt>\")"),
        "{}",
        read(&script)
    );
}

#[test]
fn only_verified_plans_are_exported() {
    let folder = tempfile::tempdir().unwrap();
    for (script, code, told) in [
        ("grasp_object()\n", 10, "Not exported, because the plan is not valid:\n"),
        (
            "milk = grasp_object()\n",
            30,
            "line 1, column 6: this is an assignment, which no plan has",
        ),
    ] {
        let path = folder.path().join("plan.py");
        std::fs::write(&path, script).unwrap();
        let arguments = [&["export", path.to_str().unwrap(), "--format", "json"], &WORLD[..]].concat();
        let (found, stdout, stderr) = longstep(&arguments);
        assert_eq!((found, stdout.as_str()), (code, ""));
        assert!(stderr.contains(told), "{stderr}");
    }
}

#[test]
fn a_behavior_tree_comes_back_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let json = export(SCRIPT, "json", &folder);
    let read = |path: &str| std::fs::read_to_string(path).unwrap();
    for guards in [&[][..], &["--guards"][..]] {
        let arguments = [&["export", SCRIPT, "--format", "bt"], guards, &WORLD[..]].concat();
        let (code, tree, stderr) = longstep(&arguments);
        assert_eq!((code, stderr.as_str()), (0, ""), "{tree}");
        assert_eq!(tree.contains("_guard"), !guards.is_empty());
        let path = folder.path().join("tree.xml");
        std::fs::write(&path, &tree).unwrap();
        let path = path.to_str().unwrap();
        let arguments = [&["export", path, "--format", "bt"], guards, &WORLD[..]].concat();
        assert_eq!(longstep(&arguments).1, tree);
        assert_eq!(
            read(&export(path, "json", &folder)).lines().count(),
            read(&json).lines().count()
        );
    }
    let (code, _, stderr) = longstep(&[&["export", SCRIPT, "--format", "dot", "--guards"], &WORLD[..]].concat());
    assert!(
        code == 30 && stderr.contains("`--guards` is for behavior trees"),
        "{stderr}"
    );
}

#[test]
fn a_plan_is_a_picture_a_flowchart_and_pddl() {
    for (format, begins, has) in [
        ("svg", "<svg ", "check whether the yoghurt is past its date"),
        ("mermaid", "flowchart TD\n", "1#46; move to the yoghurt"),
        ("dot", "digraph plan {\n", "shape=diamond"),
    ] {
        let (code, text, stderr) = longstep(&[&["export", SCRIPT, "--format", format], &WORLD[..]].concat());
        assert_eq!((code, stderr.as_str()), (0, ""), "{text}");
        assert!(text.starts_with(begins) && text.contains(has), "{text}");
    }
    let (code, _, stderr) = longstep(&[&["export", SCRIPT, "--format", "pddl"], &WORLD[..]].concat());
    assert!(code == 30 && stderr.contains("has no form in PDDL"), "{stderr}");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.py");
    std::fs::write(
        &path,
        "# objects: [\"<yoghurt>\"]\nmove_hand()\ngrasp_object()\nrelease_object()\n",
    )
    .unwrap();
    let arguments = [&["export", path.to_str().unwrap(), "--format", "pddl"], &WORLD[..]].concat();
    let (code, text, stderr) = longstep(&arguments);
    assert_eq!((code, stderr.as_str()), (0, ""), "{text}");
    assert!(text.starts_with("(move-hand yoghurt)\n"), "{text}");
}

/// A plan in a world whose names are keywords of PDDL, names of predicates, not ASCII, long, or differ in case only.
fn odd_names(folder: &std::path::Path) -> (String, String) {
    let long = format!("<{}>", "n".repeat(198));
    let environment = serde_json::json!({
        "assets": ["<bin>", "<and>", long, "<Table>", "<table>"],
        "objects": ["<o'brien [x]>", "<\u{676f}\u{5b50}>"],
        "object_states": {"<o'brien [x]>": "on_something(<and>)", "<\u{676f}\u{5b50}>": "on_something(<bin>)"},
    });
    let env = folder.join("odd.json");
    std::fs::write(&env, environment.to_string()).unwrap();
    let plan = folder.join("a plan \"(x\".json");
    let (env, plan) = (env.to_str().unwrap().to_owned(), plan.to_str().unwrap().to_owned());
    let goal = format!("put(<o'brien [x]>, <bin>) & put(<\u{676f}\u{5b50}>, {long})");
    let (code, stdout, stderr) = longstep(&["solve", "--goal", &goal, "--env", &env, "--save", &plan]);
    assert_eq!(code, 0, "{stdout}{stderr}");
    (env, plan)
}

/// Exports a plan into a folder and returns the texts of the domain, the problem and the plan, after our verifier read them.
fn exported(plan: &str, more: &[&str], folder: &std::path::Path) -> [String; 3] {
    let folder = folder.to_str().unwrap();
    let arguments = [&["export", plan, "--format", "pddl", "--folder", folder], more].concat();
    let (code, stdout, stderr) = longstep(&arguments);
    let paths = ["domain", "problem", "plan"].map(|name| format!("{folder}/{name}.pddl"));
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    assert_eq!(stdout.lines().collect::<Vec<_>>(), paths);
    let [domain, problem, plan] = &paths;
    let (code, stdout, stderr) = longstep(&["verify", plan, "--domain", domain, "--problem", problem]);
    assert_eq!((code, stderr.as_str()), (0, ""), "{stdout}");
    paths.map(|path| std::fs::read_to_string(path).unwrap())
}

#[test]
fn a_plan_its_domain_and_its_problem_go_into_a_folder_and_belong_together() {
    let there = tempfile::tempdir().unwrap();
    let script = there.path().join("plan.py");
    let text = "# objects: [\"<yoghurt>\"]\nmove_hand()\ngrasp_object()\nrelease_object()\n";
    std::fs::write(&script, text).unwrap();
    let script = script.to_str().unwrap();
    let folder = there.path().join("made/task");
    let [domain, problem, plan] = exported(script, &WORLD, &folder);
    for text in [&domain, &problem, &plan] {
        assert!(text.starts_with("; Written by longstep export"), "{text}");
    }
    assert!(domain.contains("(define (domain household-checks)"), "{domain}");
    assert!(problem.contains("; The plan was made without a goal"), "{problem}");
    // The same again changes nothing, and neither does a goal that the plan misses.
    assert_eq!(exported(script, &WORLD, &folder), [domain, problem, plan.clone()]);
    let goal = [&["--goal", "put(yoghurt, trash_bin)"][..], &WORLD[..]].concat();
    let arguments = [
        &[
            "export",
            script,
            "--format",
            "pddl",
            "--folder",
            folder.to_str().unwrap(),
        ][..],
        &goal[..],
    ]
    .concat();
    assert_eq!(longstep(&arguments).0, 10);
    assert_eq!(std::fs::read_to_string(folder.join("plan.pddl")).unwrap(), plan);
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 3);
}

#[test]
fn files_of_others_are_not_replaced_by_an_export() {
    let there = tempfile::tempdir().unwrap();
    let (_, plan) = odd_names(there.path());
    let folder = there.path().join("task");
    std::fs::create_dir(&folder).unwrap();
    std::fs::write(folder.join("domain.pddl"), "(define (domain mine))").unwrap();
    let arguments = [
        "export",
        &plan,
        "--format",
        "pddl",
        "--folder",
        folder.to_str().unwrap(),
    ];
    let (code, stdout, stderr) = longstep(&arguments);
    assert_eq!((code, stdout.as_str()), (30, ""));
    assert!(
        stderr.contains("domain.pddl exists, and another program or a person wrote it"),
        "{stderr}"
    );
    assert!(stderr.contains("hint: name another folder"), "{stderr}");
    assert_eq!(std::fs::read_dir(&folder).unwrap().count(), 1);
    let (code, _, stderr) = longstep(&["export", &plan, "--format", "bt", "--folder", "x"]);
    assert!(code == 30 && stderr.contains("`--folder` is for PDDL"), "{stderr}");
}

#[test]
fn any_names_have_a_form_in_pddl() {
    let there = tempfile::tempdir().unwrap();
    let (_, plan) = odd_names(there.path());
    let [_, problem, plan] = exported(&plan, &[], &there.path().join("task"));
    // The purpose in the plan file is the goal.
    assert!(!problem.contains("made without a goal"), "{problem}");
    assert!(problem.contains("(define (problem a_plan___x_)"), "{problem}");
    assert!(
        problem.contains("bin-2 - asset ; <bin>") && problem.contains("and-2 - asset ; <and>"),
        "{problem}"
    );
    let legal = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "-_() \n".contains(c);
    let steps = plan.split_once('\n').unwrap().1;
    assert!(
        steps.chars().all(legal) && steps.contains("(move-object o_brien__x_ bin-2)"),
        "{steps}"
    );
}
