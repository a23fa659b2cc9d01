//! `longstep show`, and the nodes of `longstep domain nodes`.
#![allow(clippy::unwrap_used, clippy::panic)]

use std::process::Command;

const SCRIPT: &str = "crates/longstep-cli/tests/plans/sort_yoghurt.py";
const WORLD: [&str; 4] = [
    "--env",
    "crates/longstep-cli/tests/plans/yoghurt.json",
    "--domain",
    "household-checks",
];

/// Runs the program in a locale, and returns the exit code and what it prints.
fn longstep(arguments: &[&str], locale: &str) -> (i32, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_longstep"))
        .args(arguments)
        .env("LC_ALL", locale)
        .env("TERM", "xterm")
        .env_remove("NO_COLOR")
        .current_dir(concat!(env!("CARGO_MANIFEST_DIR"), "/../.."))
        .output()
        .unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    assert_eq!(String::from_utf8(output.stderr).unwrap(), "", "{text}");
    (output.status.code().unwrap(), text)
}

#[test]
fn valid_plan_is_a_tree_with_the_changes_of_its_steps() {
    let (code, text) = longstep(&[&["show", SCRIPT], &WORLD[..]].concat(), "C.UTF-8");
    assert_eq!(code, 0, "{text}");
    for part in [
        "├─ 1. move to the yoghurt",
        "│     -> the hand is at the yoghurt",
        "├─ if the yoghurt is ",
        "│  ├─ ",
        "Verified:",
    ] {
        assert!(text.contains(part), "`{part}` is not in\n{text}");
    }
    // Into a pipe.
    assert!(!text.contains('\u{1b}'), "{text}");
}

#[test]
fn tree_is_ascii_where_the_locale_is_not_one_of_utf_8() {
    for locale in ["C", "POSIX", "en_US.ISO-8859-1"] {
        let (code, text) = longstep(&[&["show", SCRIPT], &WORLD[..]].concat(), locale);
        assert_eq!(code, 0, "{text}");
        assert!(text.is_ascii() && text.contains("|- 1. move to the yoghurt"), "{text}");
    }
}

#[test]
fn violations_stand_at_their_steps_with_the_exit_code_of_verify() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("plan.py");
    std::fs::write(&path, "# objects: [\"<yoghurt>\"]\ngrasp_object()\nmove_hand()\n").unwrap();
    let path = path.to_str().unwrap();
    let (code, text) = longstep(&[&["show", path], &WORLD[..]].concat(), "C");
    let (verified, _) = longstep(&[&["verify", path], &WORLD[..]].concat(), "C");
    assert_eq!((code, verified), (10, 10), "{text}");
    let lines: Vec<&str> = text.lines().collect();
    let step = lines.iter().position(|line| line.starts_with("|- 1. ")).unwrap();
    let next = lines.iter().position(|line| line.contains("- 2. ")).unwrap();
    assert!(
        lines[step..next]
            .iter()
            .any(|line| line.contains("needs that the hand is at the yoghurt")),
        "{text}"
    );
    assert!(text.contains("Not valid:"), "{text}");
}

#[test]
fn nodes_are_written_for_both_languages() {
    for (language, begins, has) in [
        (
            "cpp",
            "#pragma once\n",
            "virtual Begun<Done> grasp_object(const std::string& item) = 0;",
        ),
        (
            "python",
            "\"\"\"Nodes",
            "def grasp_object(self, item: str) -> Task[Done]:",
        ),
    ] {
        let arguments = ["domain", "nodes", "household", "--language", language];
        let (code, text) = longstep(&arguments, "C");
        assert_eq!(code, 0, "{text}");
        assert!(text.starts_with(begins) && text.contains(has), "{text}");
        assert_eq!(longstep(&arguments, "C").1, text);
    }
}

#[test]
fn scene_is_drawn_before_and_after_each_ending() {
    let (code, text) = longstep(&[&["export", SCRIPT, "--format", "scene"], &WORLD[..]].concat(), "C");
    assert_eq!(code, 0, "{text}");
    assert!(text.starts_with("<svg ") && text.contains("Before the plan"), "{text}");
    // In the picture and in its description, for each of the two endings.
    assert_eq!(text.matches("After the plan, if").count(), 4, "{text}");
}
