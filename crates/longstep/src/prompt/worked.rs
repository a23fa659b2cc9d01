//! The worked examples of the direct strategy, `prompt/plans.toml`.
//!
//! An example that names a goal is planned for when it is shown, so that it cannot fall behind its domain; one that
//! brings a reply along has it verified.

use serde::Deserialize;
use toml::Spanned;

use super::parts::Source;
use super::query::{contained_json, query_text};
use super::reply::{AnswerText, StateLists};
use super::{Message, Role};
use crate::diagnostic::{Diagnostic, Position};
use crate::domain::Domain;
use crate::plan::{self, PlanFile, Step, TaskCohesion};
use crate::search::{Limits, Outcome, solve};
use crate::verify::{Purpose, bind, check};
use crate::world::{self, Claim, Environment, World};
use crate::{goal, json};

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct PlansFile {
    #[serde(default)]
    example: Vec<Entry>,
}

/// An example as it is written: one of `goal`, `reply` and `question`.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct Entry {
    instruction: Spanned<String>,
    environment: Environment,
    /// A goal, for which a shortest plan is found.
    goal: Option<Spanned<String>>,
    /// A plan in the paper's JSON, which has to be valid.
    reply: Option<Spanned<String>>,
    /// What is asked back.
    question: Option<Spanned<String>>,
    /// What was asked for, in short; else the instruction.
    summary: Option<String>,
}

/// The examples as pairs of turns: the query, and the answer to it.
pub(super) fn turns(domain: &Domain) -> Result<Vec<Message>, Vec<Diagnostic>> {
    let source = domain.parts.source("plans.toml");
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
            // That the query cannot be rendered is told once, not for each example.
            (_, Err(finding)) => findings.push(finding),
        }
    }
    if findings.is_empty() { Ok(turns) } else { Err(findings) }
}

fn at<T>(source: &Source, place: &Spanned<T>, message: impl Into<String>) -> Diagnostic {
    Diagnostic::at(&source.path, Position::of(&source.text, place.span().start), message)
}

fn answer(domain: &Domain, source: &Source, entry: &Entry) -> Result<AnswerText, Diagnostic> {
    let place = &entry.instruction;
    let world = world::read(domain, &entry.environment, "", "", &json::Path::default()).map_err(|findings| {
        let told: Vec<&str> = findings.0.iter().map(|finding| finding.message.as_str()).collect();
        at(
            source,
            place,
            format!("the environment of this example: {}", told.join("; ")),
        )
    })?;
    let summary = entry.summary.as_ref().unwrap_or(entry.instruction.get_ref());
    match (&entry.goal, &entry.reply, &entry.question) {
        (Some(goal), None, None) => {
            planned(domain, &world, goal.get_ref(), summary).map_err(|message| at(source, goal, message))
        }
        (None, Some(reply), None) => {
            verified(domain, &world, reply.get_ref(), summary).map_err(|message| at(source, reply, message))
        }
        (None, None, Some(question)) => Ok(AnswerText::new(
            TaskCohesion::default(),
            &world,
            StateLists::of(&world.environment),
            summary,
            question.get_ref(),
        )),
        _ => Err(at(
            source,
            place,
            "an example has one of `goal`, `reply` and `question`",
        )),
    }
}

/// The shortest plan for a goal.
fn planned(domain: &Domain, world: &World, text: &str, summary: &str) -> Result<AnswerText, String> {
    let goal = goal::parse(domain, world, text).map_err(|error| error.to_string())?;
    let steps = match solve(domain, world, &goal.wanted(domain), &Limits::default()) {
        Outcome::Solved { steps, .. } if !steps.is_empty() => steps,
        Outcome::Solved { .. } => return Err("the goal of this example holds already".to_owned()),
        Outcome::ProvenUnsolvable { .. } => return Err("the goal of this example cannot be reached".to_owned()),
        Outcome::GaveUp { why, .. } => return Err(format!("no plan found for the goal of this example: {why}")),
    };
    let plan = steps
        .into_iter()
        .map(|step| Step::explained(domain, world, step.action, step.arguments))
        .collect();
    shown(domain, world, plan, &goal.purpose(domain), summary)
}

/// The plan of a reply, if it keeps what it promises.
fn verified(domain: &Domain, world: &World, text: &str, summary: &str) -> Result<AnswerText, String> {
    let draft = plan::read(text).map_err(|error| error.to_string())?;
    let PlanFile {
        task_cohesion,
        environment_after,
        question,
        ..
    } = draft.file;
    if !question.is_empty() {
        let lists = StateLists::of(&world.environment);
        return Ok(AnswerText::new(
            TaskCohesion::default(),
            world,
            lists,
            summary,
            &question,
        ));
    }
    let resolved = plan::resolve(domain, world, &task_cohesion);
    let issue = |issues: &[crate::verify::Violation]| {
        let told = issues.iter().map(|issue| issue.message(domain, world, &[], None));
        told.collect::<Vec<_>>().join("; ")
    };
    let steps = resolved.complete().map_err(issue)?;
    let claim = environment_after.map(|after| Claim::read(domain, world, &after));
    let (plan, _) = bind(domain, world, &steps, &resolved.objects, claim.as_ref());
    let purpose = Purpose {
        claim,
        ..Purpose::default()
    };
    shown(domain, world, plan, &purpose, summary)
}

/// The answer that shows a plan, if it is a good one. The environment afterwards is the simulated one.
fn shown(
    domain: &Domain,
    world: &World,
    plan: plan::Plan,
    purpose: &Purpose,
    summary: &str,
) -> Result<AnswerText, String> {
    let verified = check(domain, world, plan, purpose).into_verified().map_err(|report| {
        let steps = report.plan.steps();
        let told = report
            .violations
            .iter()
            .map(|violation| violation.message(domain, world, steps, None));
        told.collect::<Vec<_>>().join("; ")
    })?;
    let after = world::write(domain, world, &verified.ending().after);
    let cohesion = TaskCohesion::new(domain, world, verified.plan());
    Ok(AnswerText::new(cohesion, world, StateLists::of(&after), summary, ""))
}
