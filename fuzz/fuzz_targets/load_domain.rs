//! Any two texts are a domain's PDDL and words, or findings.
#![no_main]

use libfuzzer_sys::fuzz_target;
use longstep::domain::{self, Files};

fuzz_target!(|files: (&str, &str)| {
    let files = Files {
        pddl: files.0.to_owned(),
        words: files.1.to_owned(),
        ..Files::default()
    };
    if let Err(findings) = domain::load(&files) {
        drop(findings.to_string());
    }
});
