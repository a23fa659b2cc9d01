//! Training data for descriptions of scenes.
//!
//! A text begins with its domain (`domain: household`). A paragraph is an answer, which has the sentences of the description in it: lines
//! with a sentence and its plain sentences (`SENTENCE => PLAIN. PLAIN.`), then a line with the names of the entities.

use std::error::Error;

use longstep::dialogue::{ConstraintKind, Dialogue};
use longstep::domain::Domain;
use longstep::perception::{SightDialogue, SightInput};
use serde_json::{Value, json};

use crate::request::{mistake, pairs, reply};

/// Prints the training data of a text.
pub(crate) fn print_text(name: &str, text: &str) -> Result<(), Box<dyn Error>> {
    let (domain, text) = text.split_once('\n').ok_or("there is nothing behind the domain")?;
    let domain = longstep_llm::load_domain(domain.trim())?;
    for paragraph in text.trim().split("\n\n") {
        let object = training_case(&domain, name, paragraph.trim());
        println!("{}", object.map_err(|error| mistake(name, paragraph, error))?);
    }
    Ok(())
}

/// Returns the training data of a paragraph, whose plain sentences and names must be read as they are counted.
fn training_case(domain: &Domain, suite: &str, paragraph: &str) -> Result<Value, Box<dyn Error>> {
    let (lines, names) = paragraph.rsplit_once('\n').ok_or("there are no names")?;
    let (description, statement_count) = description(lines)?;
    let input = SightInput {
        domain,
        words: &description,
        pictures: &[],
        kind: ConstraintKind::Grammar,
    };
    let mut dialogue = SightDialogue::new(&input);
    let request = dialogue.request();
    let sighting = match dialogue.supply(&reply(&format!("{lines}\n")))? {
        Some(sighting) => sighting,
        None => dialogue
            .supply(&reply(names))?
            .ok_or("a name is not in the description")?,
    };
    let read = sighting.statements.len() + sighting.left_out.len();
    if read != statement_count {
        return Err(format!("{read} of {statement_count} plain sentences can be read").into());
    }
    let listed = names.matches(',').count() + 1;
    let known = sighting.assets.len() + sighting.objects.len();
    if listed != known {
        return Err(format!("{listed} of {known} names are listed").into());
    }
    Ok(
        json!({"suite": suite, "fixed": pairs(&request.messages[..request.fixed]), "lead": "", "instruction": description,
        "answer": format!("{lines}\n{names}")}),
    )
}

/// Returns the description in the lines of an answer, and the count of their plain sentences that say more than that an entity exists.
fn description(lines: &str) -> Result<(String, usize), Box<dyn Error>> {
    let (mut text, mut count) = (String::new(), 0);
    for line in lines.lines() {
        let (sentence, plain) = line.split_once(" => ").ok_or("there is no arrow")?;
        // Japanese has no spaces between sentences.
        if text.ends_with(|last: char| last.is_ascii()) {
            text.push(' ');
        }
        text.push_str(sentence);
        let statements = plain.trim_end_matches('.').split(". ");
        count += statements
            .filter(|statement| !statement.starts_with("There is"))
            .count();
    }
    Ok((text, count))
}
