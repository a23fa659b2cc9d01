//! Any text is a file of cases, or findings; the same text is a list of recorded replies, or an error.
//!
//! The text after a line `----` is the scene of the cases, in place of a fixed one.
#![no_main]

use std::collections::BTreeSet;
use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use longstep::domain::{self, Domain};
use longstep_core::effort;
use longstep_eval::Recorded;
use longstep_eval::suite::{Files, load};

static CHECKS: LazyLock<Domain> =
    LazyLock::new(|| domain::shipped("household-checks").expect("shipped").expect("valid"));

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>", "<bin>"], "objects": ["<pen>", "<ink>", "<cupboard_handle>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ink>": "on_something(<shelf>)", "<cupboard_handle>": "closed()"}}"#;

fuzz_target!(|text: &str| {
    let (cases, scene) = text.split_once("\n----\n").unwrap_or((text, SCENE));
    let files = Files {
        suite: "name = 's'\nabout = 'A suite.'\ndomain = 'household-checks'\n".to_owned(),
        cases: [("cases.toml".to_owned(), cases.to_owned())].into(),
        scenes: [("s".to_owned(), scene.to_owned())].into(),
        ..Files::default()
    };
    match effort::within(effort::OPERATION / 10, || load(&files, &CHECKS)).result {
        Ok(suite) => {
            let ids: BTreeSet<&str> = suite.cases.iter().map(|case| case.id.as_str()).collect();
            assert_eq!(ids.len(), suite.cases.len(), "no id comes twice");
            for case in &suite.cases {
                assert!(suite.scenes.contains_key(&case.scene) && !case.steps.is_empty());
            }
        }
        Err(findings) => {
            assert!(!findings.0.is_empty());
            drop(findings.to_string());
        }
    }
    if let Err(error) = Recorded::read(text) {
        drop(error.to_string());
    }
});
