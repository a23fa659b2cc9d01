//! A robot with a language model in front of it: an instruction becomes a verified plan with a branch, and a cursor
//! walks the plan as a robot would.
//!
//!     longstep model pull qwen2.5-coder-1.5b
//!     cargo run --release -p longstep-llm --example embed -- expired
//!
//! The argument is the outcome that the camera sees, `fresh` or `expired`; a second one names another model.

#![allow(clippy::print_stdout, reason = "the output of an example")]

use longstep::session::{Response, Settings};
use longstep::{Cursor, Fact, Planner, StepId};
use longstep_llm::OpenOptions;

const KITCHEN: &str = r#"{
    "assets": ["<table>", "<shelf>", "<trash_bin>"],
    "objects": ["<spam>"],
    "object_states": {"<spam>": "on_something(<table>)"}
}"#;

const INSTRUCTION: &str = "If the spam has expired, put it into the trash bin, otherwise put it on the shelf";

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut arguments = std::env::args().skip(1);
    let seen = arguments.next().unwrap_or_else(|| "expired".to_owned());
    let name = arguments.next().unwrap_or_else(|| "qwen2.5-coder-1.5b".to_owned());

    let planner = Planner::new(longstep_llm::load_domain("household-checks")?);
    let world = planner.world(KITCHEN)?;
    let options = OpenOptions::new(longstep_files::cache_directory()?);
    let mut model = longstep_llm::open(&name.parse()?, &options, &mut |_| {})?;
    let mut session = planner.session(world, Settings::default(), model.facts())?;

    println!("> {INSTRUCTION}");
    let proposal = match longstep_llm::instruct(&mut session, &mut *model, INSTRUCTION)? {
        Response::Plan(proposal) => proposal,
        other => return Err(other.to_string().into()),
    };
    let mut cursor = proposal.plan.cursor();
    let mut observed = None;
    while let Some(step) = cursor.next(observed)? {
        observed = perform(&cursor, step, &seen);
    }
    println!(
        "done: the world is as one of the plan's {} endings",
        proposal.plan.endings().len()
    );
    Ok(())
}

/// Stands for the robot: says what it does, and what it sees where the step looks for something.
fn perform(cursor: &Cursor, step: StepId, seen: &str) -> Option<Fact> {
    println!("{:2}. {}", step.index() + 1, cursor.step(step).explanation);
    let domain = cursor.plan().world().domain();
    let is_seen = |fact: &Fact| domain.predicate(fact.predicate()).name == seen;
    let outcome = cursor.outcomes(step).into_iter().find(is_seen)?;
    println!("    it is {seen}");
    Some(outcome)
}
