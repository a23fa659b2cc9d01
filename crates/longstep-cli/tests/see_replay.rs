//! Looks that are recorded and replayed: `tests/see/*.jsonl` were recorded with `--record` from the server of these tests.
//!
//! `LONGSTEP_RECORD_LOOKS=1 cargo test -p longstep-cli --test see_replay` records them again.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

mod common;

use std::path::Path;

use common::look::{SHELF, folder, reply};
use common::{Answer, Page, Server, longstep, root, seen};
use serde_json::Value;

/// A recorded look: its name, what a person answers, and the replies of the model after the first.
const LOOKS: [(&str, &str, &[&str]); 4] = [
    ("good", "yes\n", &[]),
    (
        "contradictory",
        "the juice is in the fridge\nthe fridge is open\nyes\n",
        &["The juice is in the fridge.", "The fridge is open."],
    ),
    ("cut_off", "", &[]),
    ("refusing", "", &[]),
];

/// Looks at the picture of the shelf; returns stdout, stderr and the exit code as one text.
fn look(home: &Path, model: &str, more: &[&str], input: &str) -> String {
    seen(longstep(home).args(["see", SHELF, "--model", model]).args(more), input)
}

fn replay(name: &str) -> String {
    format!("replay:{}", folder().join(format!("{name}.jsonl")).display())
}

#[test]
fn a_recorded_look_is_replayed_byte_for_byte() {
    let home = tempfile::tempdir().unwrap();
    let records = std::env::var_os("LONGSTEP_RECORD_LOOKS").is_some();
    let mut page = Page::default();
    for (name, input, more) in LOOKS {
        let mut replies = vec![reply(name)];
        replies.extend(more.iter().map(|text| Answer::Says((*text).to_owned())));
        let server = Server::giving(replies);
        let fresh = home.path().join(format!("{name}.jsonl"));
        let recorded = look(
            home.path(),
            &server.reference(),
            &["--record", fresh.to_str().unwrap()],
            input,
        );
        let (fresh, stored) = (
            std::fs::read_to_string(&fresh).unwrap(),
            folder().join(format!("{name}.jsonl")),
        );
        if records {
            std::fs::write(&stored, &fresh).unwrap();
        }
        assert_eq!(fresh, std::fs::read_to_string(&stored).unwrap(), "{name}");
        for _ in 0..2 {
            assert_eq!(look(home.path(), &replay(name), &[], input), recorded, "{name}");
        }
        page.add(name, recorded);
    }
    insta::assert_snapshot!("looks", page.text());
}

#[test]
fn a_recording_has_hashes_in_place_of_pictures() {
    for (name, _, more) in LOOKS {
        let text = std::fs::read_to_string(folder().join(format!("{name}.jsonl"))).unwrap();
        let turns: Vec<Value> = text.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
        let turns: Vec<&Value> = turns
            .iter()
            .map(|line| &line["turn"])
            .filter(|turn| turn.is_object())
            .collect();
        assert_eq!(turns.len(), more.len() + 1, "{name}");
        let pictures = &turns[0]["request"]["messages"].as_array().unwrap().last().unwrap()["pictures"];
        assert_eq!(pictures.as_array().unwrap().len(), 1, "{name}");
        assert_eq!(pictures[0]["media_type"], "image/png");
        assert_eq!(pictures[0]["sha256"].as_str().unwrap().len(), 64);
        let size = std::fs::metadata(root().join(SHELF)).unwrap().len();
        assert!((text.len() as u64) < size.max(40_000), "{name}: {} bytes", text.len());
        assert!(!text.contains("iVBOR"), "{name}");
    }
}

#[test]
fn a_recording_of_another_look_is_an_error_that_says_the_difference() {
    let home = tempfile::tempdir().unwrap();
    let file = home.path().join("shelf.jsonl");
    std::fs::copy(folder().join("good.jsonl"), &file).unwrap();
    let model = format!("replay:{}", file.display());
    let see = |words: &[&str]| {
        seen(
            longstep(home.path()).arg("see").args(words).args(["--model", &model]),
            "yes\n",
        )
    };
    for (words, expected) in [
        (
            &["examples/see/table.png"][..],
            "shelf.jsonl has no answer to this request: the most similar one is request 1, which differs in message 16: \
             picture 1: recorded image/png with the SHA-256 ",
        ),
        (
            &[SHELF, "examples/see/table.png"],
            "differs in message 16: the number of pictures: recorded 1, requested 2",
        ),
        (&[SHELF, "--words", "a table"], "differs in message 16: recorded \""),
        (&["--words", "a table"], "differs in message 16: recorded \""),
        (&[SHELF, "--domain", "examples/home"], "which differs in "),
    ] {
        let shown = see(words);
        assert!(shown.contains(expected), "{words:?}: {shown}");
        assert!(
            shown.contains("hint: record the request with the model") && shown.ends_with("--- exit code 40\n"),
            "{words:?}: {shown}"
        );
    }
    // A recording without its end.
    let text = std::fs::read_to_string(&file).unwrap();
    std::fs::write(&file, &text[..text.len() / 2]).unwrap();
    let shown = see(&[SHELF]);
    assert!(shown.contains("shelf.jsonl is not a recording: line "), "{shown}");
}
