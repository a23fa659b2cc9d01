//! The request for the meaning of an instruction is the one that the adapter for `goals` was trained on.
//!
//! A model understands another request worse, without any error. Whoever changes the request trains the adapter again, measures, and then
//! replaces the text (`LONGSTEP_LEARNED=write`). The domain is one of the training: its files never change.
#![allow(clippy::unwrap_used, missing_docs)]

use std::fs;
use std::path::Path;

use longstep::dialogue::{ConstraintKind, Dialogue, Role};
use longstep::understanding::{Examples, Understanding, UnderstandingInput};
use longstep_core::environment;

const INSTRUCTION: &str = "If the wide lens is scratched, stick it in the returns box.";

#[test]
fn the_request_is_the_one_that_the_adapter_has_learned() {
    let lab = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../lab");
    let suite = lab.join("understanding/training/avstore");
    let domain = longstep_llm::load_domain(suite.join("domain").to_str().unwrap()).unwrap();
    let scene = fs::read_to_string(suite.join("scenes/counter.json")).unwrap();
    let world = environment::parse(&domain, "counter.json", &scene).unwrap();
    let input = UnderstandingInput {
        examples: Examples::All,
        ..UnderstandingInput::new(&domain, &world, INSTRUCTION, ConstraintKind::Grammar)
    };
    let mut text = String::new();
    for message in Understanding::new(input).request().messages {
        let role = match message.role {
            Role::System => "system",
            Role::User => "user",
            Role::Assistant => "assistant",
        };
        text.push_str(&format!("== {role}\n{}\n", message.text));
    }
    let learned = lab.join("adapter/learned-request.txt");
    if std::env::var("LONGSTEP_LEARNED").is_ok_and(|own| own == "write") {
        fs::write(&learned, &text).unwrap();
    }
    assert_eq!(text, fs::read_to_string(&learned).unwrap());
}
