//! `longstep domain try`: five instructions from the domain's own sentences, and what a model understands.

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep::domain::Domain;
use longstep::goal::Goal;
use longstep::session::{Response, Session, Settings};
use longstep_author::{Sample, samples};
use longstep_core::environment::World;
use longstep_core::verify::{VerifiedPlan, check};
use longstep_llm::{AdvanceError, ChatModel, ModelError, advance, load_domain};
use serde::Serialize;

use crate::arguments::TryArguments;
use crate::ask::{self, Waiting};
use crate::clock::clock;
use crate::failure::Failure;
use crate::inputs;
use crate::output::{self, Style, counted, print_line, remark};

/// Number of instructions.
const COUNT: usize = 5;

#[derive(Serialize)]
struct Trial {
    domain: String,
    environment: String,
    model: String,
    right: usize,
    of: usize,
    instructions: Vec<Tried>,
}

#[derive(Serialize)]
struct Tried {
    instruction: String,
    /// The goal that the instruction was made from, and the steps of a plan for it.
    goal: Vec<String>,
    steps: usize,
    #[serde(flatten)]
    understood: Understood,
    right: bool,
}

#[derive(Serialize, Default)]
struct Understood {
    /// `verified`, `question` or `no_plan`.
    status: &'static str,
    understood_goal: Vec<String>,
    understood_steps: Option<usize>,
    question: Option<String>,
}

pub(super) fn run(arguments: &TryArguments) -> Result<u8> {
    let domain = load_domain(&arguments.domain)?;
    let env = environment(arguments)?;
    let world = inputs::world(&domain, &env, None)?;
    let samples = samples(&world, COUNT, arguments.model.seed.unwrap_or(0));
    if samples.is_empty() {
        let failure = Failure::unreadable(format!("no goal of the domain can be reached in {}", env.display()));
        return Err(failure
            .hint("give an environment with `--env` in which something is left to do")
            .into());
    }
    let mut model = match ask::model(arguments.model.name(), &arguments.model) {
        Ok(model) => model,
        Err(error) => {
            // The instructions and their goals are worth seeing without a model, too.
            if !arguments.json {
                print_line!("There is no model to try; these are the instructions and their goals.");
                samples
                    .iter()
                    .enumerate()
                    .for_each(|(index, sample)| show_sample(&world, index, sample));
            }
            return Err(error.into());
        }
    };
    remark!(
        "{} for {}; the first takes longest, because the model reads the domain once",
        counted(samples.len(), "instruction"),
        model.name()
    );
    let mut tried = Vec::new();
    for (index, sample) in samples.iter().enumerate() {
        if arguments.json {
            remark!("{} of {}: {}", index + 1, samples.len(), sample.instruction)
        } else {
            show_sample(&world, index, sample)
        }
        let (understood, right) = understand(arguments, &domain, &world, sample, model.as_mut())?;
        if !arguments.json {
            show_understood(&understood, right);
        }
        tried.push(Tried {
            instruction: sample.instruction.clone(),
            goal: sample.goal.exact(&world),
            steps: sample.plan.steps().len(),
            understood,
            right,
        });
    }
    let trial = Trial {
        domain: arguments.domain.clone(),
        environment: env.display().to_string(),
        model: model.name().to_owned(),
        right: tried.iter().filter(|one| one.right).count(),
        of: tried.len(),
        instructions: tried,
    };
    if arguments.json {
        output::json(&trial)?;
    } else {
        output::blank();
        print_line!("{} of {} right with {}", trial.right, trial.of, trial.model);
    }
    Ok(0)
}

/// Returns the environment of the trial.
fn environment(arguments: &TryArguments) -> Result<PathBuf> {
    if let Some(env) = &arguments.env {
        return Ok(env.clone());
    }
    let own = Path::new(&arguments.domain).join("environment.json");
    if own.is_file() {
        return Ok(own);
    }
    let failure = Failure::unreadable(format!("the domain {} has no environment.json", arguments.domain));
    Err(failure.hint("give an environment with `--env ENV.json`").into())
}

/// Gives the instruction to a new session with the model.
fn understand(
    arguments: &TryArguments,
    domain: &Domain,
    world: &World,
    sample: &Sample,
    model: &mut dyn ChatModel,
) -> Result<(Understood, bool)> {
    let settings = Settings::default();
    let facts = model.facts();
    let mut session = Session::new(
        &arguments.domain,
        domain.clone(),
        world.clone(),
        settings,
        facts,
        clock(),
    );
    session.instruct(&sample.instruction)?;
    let mut waiting = Waiting::new(model.name());
    let advanced = advance(&mut session, model, None, &mut waiting);
    drop(waiting);
    match advanced {
        Ok(()) => {}
        Err(AdvanceError::Model(error @ (ModelError::Stopped | ModelError::NotPulled { .. }))) => {
            return Err(AdvanceError::Model(error).into());
        }
        Err(error) => return Err(error.into()),
    }
    Ok(match session.response() {
        Response::Plan(proposal) => {
            let goal = proposal.goal.as_ref();
            let understood = Understood {
                status: "verified",
                understood_goal: goal.map(|goal| goal.exact(session.world())).unwrap_or_default(),
                understood_steps: Some(proposal.plan.steps().len()),
                question: None,
            };
            (understood, is_right(world, sample, goal, &proposal.plan))
        }
        Response::Consent(proposal) => {
            let goal = proposal.goal.as_ref();
            let understood = Understood {
                status: "question",
                understood_goal: goal.map(|goal| goal.exact(session.world())).unwrap_or_default(),
                understood_steps: Some(proposal.plan.steps().len()),
                question: proposal.question.clone(),
            };
            (understood, false)
        }
        Response::Question(question) => {
            let understood = Understood {
                status: "question",
                question: Some(question.to_owned()),
                ..Understood::default()
            };
            (understood, false)
        }
        other => {
            let understood = Understood {
                status: "no_plan",
                question: Some(other.to_string()),
                ..Understood::default()
            };
            (understood, false)
        }
    })
}

/// Returns true for the goal that the instruction was made from, and for another one whose plan is as long and reaches
/// that goal.
fn is_right(world: &World, sample: &Sample, goal: Option<&Goal>, plan: &VerifiedPlan) -> bool {
    let sorted = |goal: &Goal| {
        let mut parts = goal.exact(world);
        parts.sort();
        parts
    };
    if goal.is_some_and(|goal| sorted(goal) == sorted(&sample.goal)) {
        return true;
    }
    let report = check(world, plan.plan().clone(), &sample.goal.purpose(world));
    report.violations.is_empty() && plan.steps().len() == sample.plan.steps().len()
}

fn show_sample(world: &World, index: usize, sample: &Sample) {
    output::blank();
    print_line!(
        "{} {}",
        format!("{}.", index + 1).bold(),
        sample.instruction.as_str().bold()
    );
    print_line!(
        "   meant       {} (steps: {})",
        sample.goal.exact(world).join(" & "),
        sample.plan.steps().len()
    );
}

fn show_understood(understood: &Understood, right: bool) {
    let verdict = if right { "right".green() } else { "wrong".red() };
    match (&understood.question, understood.understood_steps) {
        (Some(question), _) => print_line!("   {}    {} ({verdict})", understood.status.replace('_', " "), question),
        (None, steps) => print_line!(
            "   understood  {} (steps: {}) ({verdict})",
            understood.understood_goal.join(" & "),
            steps.unwrap_or_default()
        ),
    }
}
