//! Any text is an environment of the household domain, or a finding.
#![no_main]

use std::sync::LazyLock;

use libfuzzer_sys::fuzz_target;
use longstep::domain::{self, Domain};
use longstep_core::environment::{self, Environment};
use longstep_core::json::Path;

static HOUSEHOLD: LazyLock<Domain> = LazyLock::new(|| domain::shipped("household").expect("shipped").expect("valid"));

fuzz_target!(|text: &str| {
    if let Ok(environment) = Environment::from_json(text)
        && let Err(findings) = environment::read(&HOUSEHOLD, &environment, "environment", text, &Path::default())
    {
        drop(findings.to_string());
    }
});
