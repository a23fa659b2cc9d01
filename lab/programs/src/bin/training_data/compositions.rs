//! Training data for compositions of stored plans.
//!
//! A text has paragraphs as the model sees them (`Plans:`, `Checks:`, `Wish:`), `=>`, and the program that puts the plans together.

use std::error::Error;

use longstep::compose::{self, CompositionAnswer, CompositionDialogue, CompositionInput};
use longstep::dialogue::{ConstraintKind, Dialogue};
use longstep_core::environment;
use serde_json::json;

use crate::request::{learned_answer, mistake, pairs};

/// Prints the training data of a text.
pub(crate) fn print_text(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let domain = longstep_llm::load_domain("household")?;
    let world = environment::parse(&domain, "environment", r#"{"assets": [], "objects": []}"#)?;
    let request = CompositionDialogue::new(CompositionInput {
        world: &world,
        stored: &[],
        instruction: "",
        rounds: &[],
        kind: ConstraintKind::Grammar,
    })
    .request();
    let fixed = pairs(&request.messages[..request.fixed]);
    let paragraphs = text.trim().split("\n\n");
    let count = paragraphs.clone().count();
    for paragraph in paragraphs {
        let mistake = |reason: &str| mistake(name, paragraph, reason);
        let (query, answer) = paragraph
            .trim()
            .split_once("\n=>\n")
            .ok_or_else(|| mistake("there is no arrow"))?;
        let (lead, wish) = query
            .rsplit_once("\nWish:")
            .ok_or_else(|| mistake("there is no wish"))?;
        let answer = learned_answer(answer);
        if let Some(answer) = answer {
            check_composition(answer, lead).map_err(|reason| mistake(&reason))?;
        }
        println!(
            "{}",
            json!({"suite": "compositions", "fixed": fixed, "lead": "", "instruction": format!("{lead}\nWish:{wish}"),
                "answer": answer})
        );
    }
    eprintln!("{name}: {count}");
    Ok(())
}

/// Checks that an answer is a composition of the plans that are listed.
fn check_composition(answer: &str, lists: &str) -> Result<(), String> {
    let CompositionAnswer::Composition(written) = compose::read(answer).map_err(|error| error.to_string())? else {
        return Err("this is no composition".to_owned());
    };
    match written
        .steps
        .iter()
        .find(|step| !lists.contains(&format!("\n- {}(", step.call.name)))
    {
        Some(step) => Err(format!("`{}` is not listed", step.call)),
        None => Ok(()),
    }
}
