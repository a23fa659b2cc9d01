//! Tests that read environments and write them.

use super::*;
use crate::json::Path;
use crate::model::Domain;
use crate::testing;

fn household() -> Domain {
    testing::domain("household")
}

#[track_caller]
fn check_findings(text: &str, expected: &[&str]) {
    let environment = Environment::from_json(text).unwrap();
    let found = match read(&household(), &environment, "env.json", text, &Path::default()) {
        Ok(_) => Vec::new(),
        Err(findings) => findings.0.iter().map(ToString::to_string).collect(),
    };
    assert_eq!(found, expected);
}

#[test]
fn mistakes_are_told_with_their_place() {
    check_findings(
        "{\"assets\": [\"<table>\"],\n \"asset_states\": {\"<table>\": \"on_somthing(<floor>)\"}}",
        &["env.json:2:30: asset_states.<table>: unknown state `on_somthing`\n  hint: did you mean `on_something`?"],
    );
    check_findings(
        "{\"assets\": [\"<table>\"], \"objects\": [\"<cup>\"],\n \"object_states\": {\"<cup>\": [\"on_something(<tabel>)\"]}}",
        &[
            "env.json:2:30: object_states.<cup>[0]: `<tabel>` is listed neither in `assets` nor in `objects`\n  hint: did you mean `<table>`? Otherwise add it to `assets` or `objects`",
        ],
    );
    check_findings(
        "{\"objects\": [\"<cup>\", \"<cup>\"]}",
        &["env.json:1:23: objects[1]: `<cup>` is listed twice\n  hint: keep one of the two"],
    );
    check_findings(
        "{\"objects\": [\"<cup (blue)>\"]}",
        &[
            "env.json:1:14: objects[0]: `<cup (blue)>` has '(' in it, which separates the parts of steps and goals\n  hint: leave it out, or write `_`",
        ],
    );
    check_findings(
        "{\"assets\": [\"<a>\", \"<b>\"], \"objects\": [\"<cup>\"],\n \"object_states\": {\"<cup>\": [\"on_something(<a>)\", \"on_something(<b>)\"]}}",
        &["env.json:2:29: object_states.<cup>: contradictory facts: <cup> cannot be on <a> and on <b>"],
    );
    check_findings(
        "{\"objects\": [\"<knob>\"], \"object_properties\": {\"<knob>\": [\"ROTATES\", \"SLIDES\"]}}",
        &[
            "env.json:1:69: object_properties.<knob>[1]: `SLIDES` contradicts another property of `<knob>`\n  hint: keep one of the two",
        ],
    );
    check_findings(
        "{\"assets\": [\"<table>\"], \"names\": {\"<table>\": \"a\\nb\"}}",
        &[
            "env.json:1:46: names.<table>: a name is up to 60 letters, digits, blanks, hyphens, apostrophes, dots and underscores",
        ],
    );
}

#[track_caller]
fn check_names(identifiers: &[&str], expected: &[&str]) {
    let environment = Environment {
        objects: identifiers.iter().map(|name| (*name).to_owned()).collect(),
        ..Environment::default()
    };
    let domain = testing::domain("virtualhome");
    let world = read(&domain, &environment, "env.json", "", &Path::default()).unwrap();
    let names: Vec<_> = world.entities().map(|(_, entity)| entity.name.as_str()).collect();
    assert_eq!(names, expected);
}

#[test]
fn names_are_everyday_and_unique() {
    check_names(&["<mug_3>", "<pillow_4>"], &["mug", "pillow"]);
    check_names(&["<mug_3>", "<mug_4>"], &["mug 3", "mug 4"]);
    check_names(
        &["<kitchentable_1>", "<coffeetable_2>"],
        &["kitchen table", "coffee table"],
    );
    check_names(&["<strange_thing_7>", "<thing2>"], &["strange thing", "thing 2"]);
    check_names(
        &["<thing2>", "<thing_1>", "<thing_5>"],
        &["thing 2", "thing 1", "thing 5"],
    );
}
