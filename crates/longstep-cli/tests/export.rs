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
