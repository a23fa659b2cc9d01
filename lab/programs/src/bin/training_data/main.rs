//! Writes training data: one JSON object for each instruction of suites, or for each example of text files.
//!
//!     cargo run --manifest-path lab/programs/Cargo.toml --bin training_data -- lab/understanding/training/*
//!     cargo run --manifest-path lab/programs/Cargo.toml --bin training_data -- lab/adapter/descriptions/*.txt
//!     cargo run --manifest-path lab/programs/Cargo.toml --bin training_data -- lab/adapter/changes/*.txt
//!     cargo run --manifest-path lab/programs/Cargo.toml --bin training_data -- lab/adapter/compositions/*.txt
//!
//! An object has the suite, the fixed messages of the request (`fixed`, pairs of role and text), the last message up to the
//! instruction (`lead`), the instruction, and the expected answer, which is null for a question. The kind of a text file follows from
//! its first line: `domain: NAME` ([`descriptions`]), `suite: FOLDER` ([`changes`]), or neither ([`compositions`]). [`instructions`]
//! describes suites.
//!
//! `--plans SUITE...` prints the cases with their plans instead, for the authors of text files on changes. `--requests SUITE...` prints
//! the requests to a server, for a model whose replies are recorded elsewhere.
#![allow(clippy::print_stdout, clippy::print_stderr)]

mod changes;
mod compositions;
mod descriptions;
mod instructions;
mod request;
mod suites;

use std::error::Error;
use std::path::Path;

use longstep::domain::Domain;
use longstep_eval::suite::Suite;

const USAGE: &str = "usage: training_data SUITE|TEXT.txt... or training_data --plans|--requests SUITE...";

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match arguments.first().map(String::as_str) {
        None => Err(USAGE.into()),
        Some("--plans") => for_each_suite(&arguments[1..], changes::print_plans),
        Some("--requests") => for_each_suite(&arguments[1..], instructions::print_requests),
        Some(_) => arguments
            .iter()
            .try_for_each(|path| print_training_data(Path::new(path))),
    }
}

fn for_each_suite(folders: &[String], print: fn(&Domain, &Suite)) -> Result<(), Box<dyn Error>> {
    for folder in folders {
        let (domain, suite) = suites::read_suite(Path::new(folder))?;
        print(&domain, &suite);
    }
    Ok(())
}

/// Prints the training data of a suite or a text file.
fn print_training_data(path: &Path) -> Result<(), Box<dyn Error>> {
    if path.extension().is_none_or(|extension| extension != "txt") {
        let (domain, suite) = suites::read_suite(path)?;
        instructions::print_cases(&domain, &suite);
        return Ok(());
    }
    let (name, text) = (path.display().to_string(), std::fs::read_to_string(path)?);
    if let Some(text) = text.strip_prefix("domain: ") {
        descriptions::print_text(&name, text)
    } else if let Some(text) = text.strip_prefix("suite: ") {
        changes::print_text(&name, text)
    } else {
        compositions::print_text(&name, &text)
    }
}
