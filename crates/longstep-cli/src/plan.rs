//! `longstep plan`: from an instruction to a verified plan.

use std::time::Instant;

use anyhow::Result;
use longstep::answer::{Answer, Status};
use longstep::goal::Understanding;
use longstep::prompt::GoalDialogue;
use longstep::solution;
use longstep_llm::{ModelReference, OpenOptions, cache_directory, open, understand};

use crate::arguments::PlanArguments;
use crate::failure::{Failure, LIMIT};
use crate::inputs;
use crate::progress::Spinner;
use crate::solve::{self, milliseconds};

/// More than anybody says to a robot in one go.
const INSTRUCTION_LIMIT: usize = 2000;

pub(crate) fn run(arguments: &PlanArguments) -> Result<u8> {
    let started = Instant::now();
    let instruction = arguments.instruction.trim();
    if instruction.is_empty() {
        let failure = Failure::unreadable("the instruction is empty");
        return Err(failure
            .hint("say what you want, for example \"Put the juice on the table\"")
            .into());
    }
    let length = instruction.chars().count();
    if length > INSTRUCTION_LIMIT {
        let message = format!("the instruction has {length} characters, and {INSTRUCTION_LIMIT} are the most");
        return Err(Failure::new(message, LIMIT)
            .hint("say it in a sentence or two, one thing after the other")
            .into());
    }
    let reference: ModelReference = arguments.model.parse()?;
    let domain = inputs::domain(&arguments.world.domain)?;
    let world = inputs::world(&domain, &arguments.world.env)?;
    let asked = Instant::now();
    let spinner = Spinner::new();
    let mut options = OpenOptions::new(cache_directory()?);
    options.threads = arguments.threads.map(usize::from);
    let mut model = open(&reference, &options, &mut |progress| spinner.show(&progress))?;
    let mut dialogue = GoalDialogue::new(&domain, &world, instruction, model.constraint_kind());
    let understood = understand(model.as_mut(), &domain, &world, &mut dialogue, &mut |progress| {
        spinner.show(&progress)
    })?;
    drop(spinner);
    let model_time = milliseconds(asked);
    let (mut answer, goal) = match understood {
        Understanding::Question(question) => {
            let answer = Answer::without_plan(Status::Question, &world, instruction, &question);
            (answer, Vec::new())
        }
        Understanding::Goal(goal, left_out) => {
            let mut answer = solution::of_goal(&domain, &world, &goal, instruction, solve::stopwatch).answer;
            answer.tell_left_out(&domain, &world, &left_out);
            (answer, solve::goal_lines(&domain, &world, &goal))
        }
    };
    answer.usage = dialogue.usage.into();
    answer.timings_ms.model = model_time;
    answer.timings_ms.total = milliseconds(started);
    solve::finish(&answer, &goal, arguments.save.as_deref(), arguments.json)
}
