//! Domains with their prompts, from files.

use indexmap::IndexMap;
use serde::Deserialize;
use toml::Spanned;

use crate::diagnostic::{Diagnostic, Diagnostics, Position};
use crate::dialogue::{check_example, render_goal_prompt};
use crate::feedback::check_feedback_example;
use crate::model::{
    Domain, Example, FeedbackExample, Files, PartTexts, Prompts, content_position, read_toml, shipped_files,
};

/// Reads a domain.
///
/// # Errors
///
/// Everything that is wrong with the files or on which they disagree, at once, each with file, line and
/// column. (A file that is not even PDDL or TOML hides what the rest of it would have shown.)
pub fn load(files: &Files) -> Result<Domain, Diagnostics> {
    let (domain, mut findings) = longstep_core::domain::load_with_findings(files);
    let domain = domain.map(|domain| Domain {
        domain,
        prompts: Prompts::default(),
    });
    // The prompts are checked against the domain that they are for.
    let prompts = prompts_of(domain.as_ref(), files, &mut findings);
    match (domain, prompts) {
        (Some(domain), Some(prompts)) if findings.is_empty() => Ok(Domain { prompts, ..domain }),
        _ => Err(Diagnostics::sorted(findings)),
    }
}

/// The shipped domain of that name, or none if there is no such domain.
///
/// # Errors
///
/// None for the domains as they are shipped; the tests load each of them.
pub fn shipped(name: &str) -> Option<Result<Domain, Diagnostics>> {
    Some(load(&shipped_files(name)?))
}

/// Reads a `domain.pddl` that has no `domain.toml` beside it, as [`longstep_core::domain::from_pddl`] does; its prompts
/// are the library's own.
///
/// # Errors
///
/// Everything that cannot be read, at once, with its place.
pub fn from_pddl(file: &str, text: &str) -> Result<Domain, Diagnostics> {
    let domain = longstep_core::domain::from_pddl(file, text)?;
    Ok(Domain {
        domain,
        prompts: Prompts::default(),
    })
}

/// Reads `prompt/` and checks it against the domain; findings are added to those that there are. None if it, or the
/// domain, cannot be read.
fn prompts_of(domain: Option<&Domain>, files: &Files, findings: &mut Vec<Diagnostic>) -> Option<Prompts> {
    findings.extend(files.unknown_parts());
    let examples_file = files.prompt_path("examples.toml");
    let examples: Option<ExamplesFile> = read_toml(&examples_file, &files.examples, findings);
    let (domain, examples) = (domain?, examples?);
    let mut prompts = Prompts::default();
    for entry in examples.example {
        let position = content_position(&files.examples, &entry.answer);
        let example = Example {
            objects: entry.objects.into_iter().collect(),
            places: entry.places.into_iter().collect(),
            instruction: entry.instruction,
            answer: entry.answer.into_inner(),
        };
        if let Err(message) = check_example(domain, &example) {
            findings.push(Diagnostic::at(&examples_file, position, message));
        }
        prompts.examples.push(example);
    }
    prompts.parts = PartTexts::of(files);
    prompts.feedback_examples = feedback_examples(domain, files, findings);
    match render_goal_prompt(domain, &files.goal_prompt) {
        Ok(text) => prompts.goal = text,
        Err((line, message)) => {
            let position = Position { line, column: 1 };
            findings.push(Diagnostic::at(&files.prompt_path("goal.md"), position, message));
        }
    }
    Some(prompts)
}

/// Reads `prompt/feedback.toml`.
fn feedback_examples(domain: &Domain, files: &Files, findings: &mut Vec<Diagnostic>) -> Vec<FeedbackExample> {
    let file = format!("{}prompt/feedback.toml", files.folder);
    let read: Option<FeedbackFile> = read_toml(&file, &files.feedback, findings);
    let mut examples = Vec::new();
    for entry in read.map(|file| file.example).unwrap_or_default() {
        let position = content_position(&files.feedback, &entry.answer);
        let example = FeedbackExample {
            instruction: entry.instruction,
            plan: entry.plan,
            says: entry.says,
            answer: entry.answer.into_inner(),
        };
        if let Err(message) = check_feedback_example(domain, &example) {
            findings.push(Diagnostic::at(&file, position, message));
        }
        examples.push(example);
    }
    examples
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FeedbackFile {
    #[serde(default)]
    example: Vec<FeedbackEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct FeedbackEntry {
    instruction: String,
    plan: Vec<String>,
    says: String,
    answer: Spanned<String>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExamplesFile {
    #[serde(default)]
    example: Vec<ExampleEntry>,
}

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ExampleEntry {
    objects: IndexMap<String, String>,
    places: IndexMap<String, String>,
    instruction: String,
    answer: Spanned<String>,
}
