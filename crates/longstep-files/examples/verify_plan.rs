//! Verifies a plan for a shipped domain, or for the domain in a folder: three small crates, no model, no network.
//!
//!     cargo run -p longstep-files --example verify_plan -- household ENVIRONMENT.json PLAN.json

#![allow(clippy::print_stdout, missing_docs)]

use std::error::Error;
use std::path::Path;

use longstep_files::{domain_files, read_text};
use longstep_model::{domain, environment};
use longstep_verify::plan;
use longstep_verify::verify::check_file;

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, scene, file] = &arguments[..] else {
        return Err("usage: verify_plan DOMAIN ENVIRONMENT.json PLAN.json".into());
    };
    let domain = domain::load(&domain_files(folder)?)?;
    let world = environment::parse(&domain, scene, &read_text(Path::new(scene))?)?;
    let draft = plan::read(&read_text(Path::new(file))?)?;
    let world = draft.file.world_of(&world);
    match check_file(&world, &draft.file) {
        Ok(report) => {
            for violation in &report.violations {
                println!("{}", violation.message(&world, report.plan.steps(), None));
            }
            println!(
                "{}",
                if report.into_verified().is_ok() {
                    "verified"
                } else {
                    "not valid"
                }
            );
        }
        Err(violations) => {
            for violation in violations {
                println!("{}", violation.message(&world, &[], None));
            }
            println!("not valid");
        }
    }
    Ok(())
}
