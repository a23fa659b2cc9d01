//! A look at a picture: the picture, and replies about it (`tests/see/*.json`).

use std::path::{Path, PathBuf};

use serde_json::Value;

use super::Answer;

/// A picture of a table with a shelf on it.
pub const SHELF: &str = "examples/see/shelf.png";

/// The folder of the replies and of their recordings.
pub fn folder() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/see")
}

/// Returns the reply with this name.
pub fn reply(name: &str) -> Answer {
    let text = std::fs::read_to_string(folder().join(format!("{name}.json"))).unwrap();
    let mut reply: Value = serde_json::from_str(&text).unwrap();
    let finish = reply["finish"].as_str().unwrap().to_owned();
    Answer::Ends(reply["message"].take(), finish)
}
