//! Training data for the meaning of instructions, from suites.
//!
//! Cases with one instruction count. Their tags say what the goal of a suite cannot: `left out KIND: WORDS`; `meaning: GOAL` for a case
//! that expects a question because nothing is to be done (a prohibition alone); `first: ANSWER` and `remark: WORDS` for an earlier
//! answer and the next message.

use longstep::dialogue::{ConstraintKind, Dialogue};
use longstep::domain::Domain;
use longstep::understanding::{Examples, Understanding, UnderstandingInput};
use longstep_core::goal;
use longstep_eval::suite::{Case, Expected, Suite};
use serde_json::{Value, json};

use crate::request::pairs;

/// Prints the training data of a suite.
pub(crate) fn print_cases(domain: &Domain, suite: &Suite) {
    let mut printed = 0;
    for case in &suite.cases {
        if let Some(object) = training_case(suite, domain, case) {
            println!("{object}");
            printed += 1;
        }
    }
    eprintln!("{}: {printed} of {} cases", suite.name, suite.cases.len());
}

/// Prints the requests to a server for the cases with one instruction.
pub(crate) fn print_requests(domain: &Domain, suite: &Suite) {
    for case in &suite.cases {
        let [step] = &case.steps[..] else { continue };
        let mut world = suite.world(case);
        world.add_values(&step.says);
        let input = UnderstandingInput::new(domain, &world, &step.says, ConstraintKind::JsonSchema);
        let request = Understanding::new(input).request();
        let texts: Vec<&str> = request.messages.iter().map(|message| message.text.as_str()).collect();
        println!("{}", json!({"suite": suite.name, "case": case.id, "messages": texts}));
    }
}

/// Returns the training data of a case; none if it is a chain, or expects neither a goal nor a question.
fn training_case(suite: &Suite, domain: &Domain, case: &Case) -> Option<Value> {
    let [step] = &case.steps[..] else { return None };
    let answer = match tags(case, "meaning:").next() {
        Some(meaning) => Some(normal_form(suite, case, meaning)),
        None => match &step.expected {
            Expected::Question => None,
            Expected::Plan(goals) => Some(goals.first()?.text(&suite.judged_world(case))),
            Expected::Refusal | Expected::Either | Expected::Nothing => return None,
        },
    };
    let left_out =
        |answer: String| tags(case, "left out ").fold(answer, |answer, words| answer + " | left out " + words);
    let rounds: Vec<[&str; 2]> = tags(case, "first:")
        .zip(tags(case, "remark:"))
        .map(<[&str; 2]>::from)
        .collect();
    let mut world = suite.world(case);
    world.add_values(&step.says);
    let dialogue = Understanding::new(UnderstandingInput {
        examples: Examples::All,
        ..UnderstandingInput::new(domain, &world, &step.says, ConstraintKind::Grammar)
    });
    let (query, fixed) = dialogue.transcript().messages().split_last()?;
    let (scene, instruction) = query.text.rsplit_once("Instruction: ")?;
    Some(json!({
        "suite": suite.name, "id": case.id, "fixed": pairs(fixed), "lead": format!("{scene}Instruction:"),
        "instruction": format!(" {instruction}"), "rounds": rounds, "answer": answer.map(left_out),
    }))
}

/// Returns what follows a prefix in the tags of a case.
fn tags<'a>(case: &'a Case, prefix: &'static str) -> impl Iterator<Item = &'a str> {
    case.tags
        .iter()
        .filter_map(move |tag| tag.strip_prefix(prefix))
        .map(str::trim)
}

/// Returns a goal as the program writes it; as it is, if the goal language has no words for it yet.
fn normal_form(suite: &Suite, case: &Case, meaning: &str) -> String {
    let world = suite.judged_world(case);
    match goal::parse(&world, meaning) {
        Ok(goal) => goal.text(&world),
        Err(_) => meaning.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    #![allow(clippy::unwrap_used)]

    use std::path::Path;

    use super::*;
    use crate::suites::read_suite;

    /// The training sees what a session sends: `crates/longstep/tests/learned_request.rs` compares the request with the same text.
    #[test]
    fn a_case_is_the_request_of_a_session() {
        let lab = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
        let (domain, suite) = read_suite(&lab.join("understanding/training/avstore")).unwrap();
        let case = training_case(&suite, &domain, &suite.cases[0]).unwrap();
        let text = |value: &Value| value.as_str().unwrap().to_owned();
        let mut request = String::new();
        for message in case["fixed"].as_array().unwrap() {
            request += &format!("== {}\n{}\n", text(&message[0]), text(&message[1]));
        }
        request += &format!("== user\n{}{}\n", text(&case["lead"]), text(&case["instruction"]));
        let learned = std::fs::read_to_string(lab.join("adapter/learned-request.txt")).unwrap();
        assert_eq!(request, learned);
        assert_eq!(
            case["answer"],
            "if scratched(wide lens) then put(wide lens, returns box)"
        );
    }
}
