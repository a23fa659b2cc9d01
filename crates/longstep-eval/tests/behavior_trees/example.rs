//! The robots of docs/guide/exports.md, compiled and run.

use std::path::{Path, PathBuf};
use std::process::Command;

use longstep_core::domain;
use longstep_core::environment;
use longstep_core::plan::behavior_tree::nodes::{self, Language};
use longstep_core::plan::behavior_tree::{Guards, write};
use longstep_core::plan::read;
use longstep_core::verify::check_file;

/// The page with the examples.
const PAGE: &str = include_str!("../../../../docs/guide/exports.md");

/// Returns the block of a language in the page.
fn block(language: &str) -> &'static str {
    let (_, rest) = PAGE.split_once(&format!("```{language}\n")).unwrap();
    rest.split_once("\n```").unwrap().0
}

fn porter() -> longstep_core::model::Domain {
    domain::load(&domain::Files::from_texts("porter/", domain::starter("porter"))).unwrap()
}

/// Writes the tree that the examples load.
fn write_plan(folder: &Path) {
    let files = domain::starter("porter");
    let (_, environment) = files.iter().find(|(path, _)| path == "environment.json").unwrap();
    let world = environment::parse(&porter(), "environment.json", environment).unwrap();
    let draft = read(PLAN).unwrap();
    let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    let xml = write(&world, plan.plan(), Guards::Preconditions).unwrap();
    std::fs::write(folder.join("plan.xml"), xml).unwrap();
}

const PLAN: &str = r#"{"task_sequence": ["drive(<store_room>)", "pick(<parcel>, <store_room>)", "drive(<desk>)", "drop(<parcel>, <desk>)"]}"#;

/// Writes the header of the example, and returns its text without a main function of its own.
pub(crate) fn program(folder: &Path) -> String {
    write_plan(folder);
    std::fs::write(folder.join("porter.hpp"), nodes::write(&porter(), Language::Cpp)).unwrap();
    let example = block("cpp");
    assert!(example.contains("int main()"));
    example.replace("int main()", "int example_main()") + "\n"
}

/// Returns the start of a main function that runs the example on demand.
pub(crate) fn main_of_all(start: &str) -> String {
    format!("{start}\n    if (std::string(words[1]) == \"example\") return example_main();")
}

/// Writes the module and the example.
pub(crate) fn module(folder: &Path) -> Vec<PathBuf> {
    write_plan(folder);
    let texts = [
        ("porter.py", nodes::write(&porter(), Language::Python)),
        ("robot.py", block("python").to_owned()),
    ];
    let write = |(name, text): (&str, String)| {
        let path = folder.join(name);
        std::fs::write(&path, text).unwrap();
        path
    };
    texts.map(write).to_vec()
}

/// Runs the example, which has to print the steps and to succeed.
pub(crate) fn assert_runs(folder: &Path, words: &[&str]) {
    let output = Command::new(words[0])
        .args(&words[1..])
        .current_dir(folder)
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    let errors = String::from_utf8_lossy(&output.stderr);
    assert!(output.status.success(), "{text}{errors}");
    assert_eq!(text, PRINTED, "{errors}");
}

const PRINTED: &str = "drive to <store_room>\npick up <parcel>\ndrive to <desk>\nset down <parcel>\nSUCCESS\n";
