//! `longstep plan`: from an instruction to a verified plan.

use std::time::Instant;

use anyhow::Result;
use longstep::dialogue::{self, Prepared};
use longstep::report::Answer;
use longstep::session::{Failure as NoPlan, Response, Session};
use longstep_llm::advance;

use crate::arguments::{PlanArguments, domain_or_default};
use crate::ask::{self, Waiting};
use crate::clock::{clock, milliseconds};
use crate::failure::{Failure, LIMIT, MODEL};
use crate::{exit_code, explain, inputs, lanes, output, solve};

/// Limit for the length of an instruction, in characters.
const INSTRUCTION_LIMIT: usize = 2000;

pub(crate) fn run(arguments: &PlanArguments) -> Result<u8> {
    let started = Instant::now();
    let instruction = checked_instruction(&arguments.instruction)?;
    let named = domain_or_default(arguments.world.domain.as_ref());
    let domain = inputs::domain_with_prompt(named, arguments.strategy.prompt.as_deref())?;
    let world = inputs::world(&domain, arguments.world.env()?, arguments.world.rules.as_deref())?;
    let opening = Instant::now();
    let mut model = ask::model(arguments.model.name(), &arguments.model)?;
    let opened = milliseconds(opening);
    let facts = model.facts();
    let settings = arguments.strategy.settings();
    let mut session = Session::new(named, domain, world, settings, facts, clock());
    // A new session waits for an instruction.
    session.instruct(instruction)?;
    if arguments.explain_prompt {
        if let Some(prepared) = session.explain(model.as_mut())? {
            let explanation = dialogue::explain(&prepared.costs, model.context_tokens(), model.counting());
            let Prepared {
                request,
                dropped,
                left_out,
                ..
            } = prepared;
            explain::show(&explanation, &request.messages, dropped, left_out);
        }
        return Ok(exit_code::DONE);
    }
    let mut waiting = Waiting::new(model.name());
    advance(&mut session, model.as_mut(), None, &mut waiting)?;
    let forecast = waiting.forecast();
    drop(waiting);
    let mut answer = match (session.report(), session.failure()) {
        (Some(answer), _) => answer,
        (None, Some(failure)) => unhappy(failure)?,
        // After an instruction no other response is possible.
        (None, None) => return Err(Failure::new("the session ended early", MODEL).into()),
    };
    let world = session.world();
    let goal = session.proposal().and_then(|proposal| proposal.goal.as_ref());
    let goal = goal.map(|goal| solve::goal_lines(world, goal)).unwrap_or_default();
    let mut shown = Vec::new();
    if let (true, Response::Plan(proposal)) = (arguments.parallel, session.response()) {
        shown = lanes::side_by_side(world, &proposal.plan, &proposal.purpose, &mut answer);
    }
    answer.forecast = forecast;
    answer.timings_ms.model += opened;
    answer.timings_ms.total = milliseconds(started);
    if arguments.explain && !arguments.json {
        explain::readings(&answer.readings);
        output::blank();
    }
    let domain = world.domain();
    let save = arguments.save.as_deref().map(|path| (path, &**domain));
    solve::finish(&answer, &goal, &shown, save, arguments.json)
}

/// Returns the trimmed instruction, if it is neither empty nor too long.
pub(crate) fn checked_instruction(text: &str) -> Result<&str> {
    let instruction = text.trim();
    if instruction.is_empty() {
        let failure = Failure::unreadable("the instruction is empty");
        return Err(failure
            .hint("write what the robot should do, for example \"Put the juice on the table\"")
            .into());
    }
    let length = instruction.chars().count();
    if length > INSTRUCTION_LIMIT {
        let message = format!("the instruction has {length} characters; the limit is {INSTRUCTION_LIMIT}");
        return Err(Failure::new(message, LIMIT)
            .hint("shorten it to one or two sentences")
            .into());
    }
    Ok(instruction)
}

/// The answer in place of a plan.
pub(crate) fn unhappy(failure: &NoPlan) -> Result<Answer> {
    if let Some(answer) = failure.answer() {
        return Ok(answer.clone());
    }
    let code = if failure.is_limit() { LIMIT } else { MODEL };
    let hint = "rephrase the instruction, or use another model with `--model`";
    Err(Failure::new(failure.to_string(), code).hint(hint).into())
}
