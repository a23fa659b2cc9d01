//! The few-shot examples of the direct strategy, `prompt/plans.toml`.
//!
//! An example with a goal is planned when it is rendered, so it always matches its domain. An example with a reply is
//! verified.

use longstep_core::spanned::Spanned;
use serde::Deserialize;

use super::query::{contained_json, query_text};
use super::reply::{AnswerText, StateLists};
use super::{Message, Role};
use crate::Clock;
use crate::diagnostic::{Diagnostic, Position};
use crate::environment::{self, Environment, World};
use crate::model::{Domain, Source};
use crate::plan::{self, Draft, PlanFile, TaskCohesion, script};
use crate::report::{self, Answer, Assessment, Solution, Status};
use crate::verify::VerifiedPlan;
use crate::{goal, json};

/// Returns the JSON Schema of `prompt/plans.toml`.
#[cfg(feature = "schema")]
pub(crate) fn schema() -> serde_json::Value {
    longstep_core::schema::of::<PlansFile>("Worked examples of whole plans for Longstep: prompt/plans.toml")
}

/// Worked examples of whole plans.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
struct PlansFile {
    /// The examples.
    #[serde(default)]
    example: Vec<WorkedExample>,
}

/// An example in the file: it has one of `goal`, `script`, `reply` and `question`.
#[derive(Debug, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
// Messages of the parser keep the name `Entry`.
#[serde(deny_unknown_fields, expecting = "struct Entry")]
struct WorkedExample {
    /// The instruction.
    instruction: Spanned<String>,
    /// The environment.
    environment: Environment,
    /// A goal, for which search finds a shortest plan.
    goal: Option<Spanned<String>>,
    /// A valid plan as a script.
    script: Option<Spanned<String>>,
    /// A valid plan in the paper's JSON.
    reply: Option<Spanned<String>>,
    /// A question to the person.
    question: Option<Spanned<String>>,
    /// Summary of the instruction; by default the instruction itself.
    summary: Option<String>,
}

/// Returns the examples as pairs of messages: query and answer.
pub(super) fn turns(domain: &Domain) -> Result<Vec<Message>, Vec<Diagnostic>> {
    let source = domain.prompts.parts.source("plans.toml");
    let file: PlansFile = toml::from_str(&source.text).map_err(|error| {
        let position = Position::of(&source.text, error.span().map_or(0, |span| span.start));
        let message = error.message().trim().replace('\n', "; ");
        vec![Diagnostic::at(&source.path, position, message)]
    })?;
    let mut turns = Vec::new();
    let mut findings = Vec::new();
    for entry in &file.example {
        let query = query_text(domain, &entry.environment, entry.instruction.get_ref());
        match (answer(domain, source, entry), query) {
            (Ok(answer), Ok(query)) => {
                turns.push(Message::new(Role::User, query));
                turns.push(Message::new(Role::Assistant, contained_json(&answer)));
            }
            (Err(finding), _) => findings.push(finding),
            // A query template that cannot be rendered is reported once, not for each example.
            (_, Err(finding)) => findings.push(finding),
        }
    }
    if findings.is_empty() { Ok(turns) } else { Err(findings) }
}

fn at<T>(source: &Source, place: &Spanned<T>, message: impl Into<String>) -> Diagnostic {
    Diagnostic::at(&source.path, Position::of(&source.text, place.span().start), message)
}

fn answer(domain: &Domain, source: &Source, entry: &WorkedExample) -> Result<AnswerText, Diagnostic> {
    let place = &entry.instruction;
    let world = environment::read(domain, &entry.environment, "", "", &json::Path::default()).map_err(|findings| {
        let messages: Vec<&str> = findings.0.iter().map(|finding| finding.message.as_str()).collect();
        at(
            source,
            place,
            format!("the environment of this example: {}", messages.join("; ")),
        )
    })?;
    let summary = entry.summary.as_ref().unwrap_or(entry.instruction.get_ref());
    match (&entry.goal, &entry.script, &entry.reply, &entry.question) {
        (Some(goal), None, None, None) => {
            planned(domain, &world, goal.get_ref(), summary).map_err(|message| at(source, goal, message))
        }
        (None, Some(script), None, None) => {
            scripted(domain, &world, script.get_ref(), summary).map_err(|message| at(source, script, message))
        }
        (None, None, Some(reply), None) => {
            replied(domain, &world, reply.get_ref(), summary).map_err(|message| at(source, reply, message))
        }
        (None, None, None, Some(question)) => Ok(asking(domain, &world, summary, question.get_ref())),
        _ => Err(at(
            source,
            place,
            "an example has one of `goal`, `script`, `reply` and `question`",
        )),
    }
}

/// Returns the answer with a question.
fn asking(domain: &Domain, world: &World, summary: &str, question: &str) -> AnswerText {
    let before = StateLists::of(world.environment());
    AnswerText::new(domain, &TaskCohesion::default(), world, before, summary, question)
}

/// Finds a shortest plan for a goal; it senses if the goal depends on unknown facts.
fn planned(domain: &Domain, world: &World, text: &str, summary: &str) -> Result<AnswerText, String> {
    let mut world = world.clone();
    world.add_values(text);
    let world = &world;
    let goal = goal::parse(world, text).map_err(|error| error.to_string())?;
    let Solution { plan, answer } =
        report::of_goal(world, &goal, summary, &crate::search::Limits::default(), &Clock::none());
    match (plan, answer.status) {
        (Some(plan), _) if plan.steps().is_empty() => Err("the goal of this example holds already".to_owned()),
        (Some(plan), _) => Ok(shown(domain, world, &plan, summary)),
        (None, Status::Unsolvable) => Err("the goal of this example cannot be reached".to_owned()),
        (None, Status::Invalid) => Err(violation_line(&answer)),
        (None, _) => Err(format!(
            "no plan found for the goal of this example: {}",
            answer.notes.join("; ")
        )),
    }
}

/// Verifies the plan of a script.
fn scripted(domain: &Domain, world: &World, text: &str, summary: &str) -> Result<AnswerText, String> {
    let written = script::read(text).map_err(|error| format!("{error} ({})", error.hint))?;
    let file = PlanFile::from(TaskCohesion::from_written(written));
    verified(domain, world, file, summary)
}

/// Verifies the plan of a reply.
fn replied(domain: &Domain, world: &World, text: &str, summary: &str) -> Result<AnswerText, String> {
    let draft = plan::read(text).map_err(|error| error.to_string())?;
    match draft.file.question.trim() {
        "" => verified(domain, world, draft.file, summary),
        question => Ok(asking(domain, world, summary, question)),
    }
}

fn verified(domain: &Domain, world: &World, mut file: PlanFile, summary: &str) -> Result<AnswerText, String> {
    // The summary comes from the example.
    file.instruction_summary.clear();
    let draft = Draft {
        file,
        leniencies: Vec::new(),
    };
    let assessment = Assessment::new(world, draft, None);
    match assessment.verified() {
        Some(plan) => Ok(shown(domain, world, &plan, summary)),
        None => Err(violation_line(&assessment.verdict())),
    }
}

/// Returns the violations of a plan, in one line.
fn violation_line(answer: &Answer) -> String {
    let wrong = answer.violations.iter().map(|violation| violation.message.as_str());
    wrong.collect::<Vec<_>>().join("; ")
}

/// Returns the answer with a plan and the simulated final environment.
fn shown(domain: &Domain, world: &World, plan: &VerifiedPlan, summary: &str) -> AnswerText {
    let after = environment::write(world, &plan.ending().after);
    let cohesion = TaskCohesion::new(world, plan.plan());
    AnswerText::new(domain, &cohesion, world, StateLists::of(&after), summary, "")
}
