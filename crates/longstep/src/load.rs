//! Loading of domains with their prompts.

use indexmap::IndexMap;
use longstep_core::spanned::Spanned;
use serde::Deserialize;

use crate::diagnostic::{Diagnostic, Diagnostics, Position};
use crate::dialogue::{check_example, render_goal_prompt};
use crate::feedback::check_feedback_example;
use crate::model::{
    Domain, Example, FeedbackExample, Files, PartTexts, Prompts, content_position, read_toml, shipped_files,
};

/// Loads a domain from the contents of its files.
///
/// ```
/// use longstep::domain;
/// let mut files = domain::shipped_files("household").unwrap();
/// assert_eq!(domain::load(&files).unwrap().name, "household");
/// files.words = files.words.replace("[lexicon]", "[lexikon]");
/// assert!(domain::load(&files).unwrap_err().to_string().contains("lexikon"));
/// ```
///
/// # Errors
///
/// All errors in the files and all contradictions between them, each with file, line and column. A syntax error in PDDL
/// or TOML hides errors in the rest of that file.
pub fn load(files: &Files) -> Result<Domain, Diagnostics> {
    let (domain, mut findings) = longstep_core::domain::load_with_findings(files);
    let domain = domain.map(Domain::from);
    let prompts = prompts_of(domain.as_ref(), files, &mut findings);
    match (domain, prompts) {
        (Some(domain), Some(prompts)) if findings.is_empty() => Ok(Domain { prompts, ..domain }),
        _ => Err(Diagnostics::sorted(findings)),
    }
}

/// Loads the shipped domain of that name. Returns none if there is no such domain.
///
/// ```
/// use longstep::domain;
/// assert_eq!(domain::shipped("household").unwrap().unwrap().origin, "household");
/// assert!(domain::shipped("garage").is_none());
/// ```
///
/// # Errors
///
/// None in practice: the tests load every shipped domain.
pub fn shipped(name: &str) -> Option<Result<Domain, Diagnostics>> {
    Some(load(&shipped_files(name)?))
}

/// Loads a `domain.pddl` without a `domain.toml`, as [`longstep_core::domain::from_pddl`] does, with the default
/// prompts of this library.
///
/// ```
/// use longstep::{Planner, domain};
/// let pddl = "(define (domain lamp) (:predicates (lit)) (:action press :effect (lit)))";
/// let domain = domain::from_pddl("lamp.pddl", pddl).unwrap();
/// assert_eq!(domain.actions[0].name, "press");
/// ```
///
/// # Errors
///
/// All errors in the file, each with its position.
pub fn from_pddl(file: &str, text: &str) -> Result<Domain, Diagnostics> {
    Ok(longstep_core::domain::from_pddl(file, text)?.into())
}

/// Reads `prompt/`, checks it against the domain, and appends to `findings`. Returns none if the folder or the domain
/// cannot be read.
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

/// Returns the JSON Schema of `prompt/feedback.toml`.
#[cfg(feature = "schema")]
pub(crate) fn feedback_schema() -> serde_json::Value {
    longstep_core::schema::of::<FeedbackFile>("Worked examples of feedback for Longstep: prompt/feedback.toml")
}

/// Returns the JSON Schema of `prompt/examples.toml`.
#[cfg(feature = "schema")]
pub(crate) fn examples_schema() -> serde_json::Value {
    longstep_core::schema::of::<ExamplesFile>("Worked examples of goals for Longstep: prompt/examples.toml")
}

/// Worked examples of feedback.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct FeedbackFile {
    /// The examples.
    #[serde(default)]
    example: Vec<FeedbackEntry>,
}

/// A worked example of feedback.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct FeedbackEntry {
    /// The instruction.
    instruction: String,
    /// The lines of the plan.
    plan: Vec<String>,
    /// The words of the person about it.
    says: String,
    /// The answer of the model.
    answer: Spanned<String>,
}

/// Worked examples of goals.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct ExamplesFile {
    /// The examples.
    #[serde(default)]
    example: Vec<ExampleEntry>,
}

/// A worked example of a goal.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct ExampleEntry {
    /// Objects with their states.
    objects: IndexMap<String, String>,
    /// Places with their states.
    places: IndexMap<String, String>,
    /// The instruction.
    instruction: String,
    /// The answer of the model.
    answer: Spanned<String>,
}
