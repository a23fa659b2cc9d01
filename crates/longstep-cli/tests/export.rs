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
