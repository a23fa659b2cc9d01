//! The plan of a run: from a file, or from an instruction.

use std::path::Path;

use anyhow::Result;
use longstep::Goal;
use longstep::report::{Answer, Status};
use longstep::session::{Response, Session};
use longstep_core::autonomy::Autonomy;
use longstep_core::environment::World;
use longstep_core::execution::{Aim, Approval, BeginError, Execution, Settings, Trust, Watch};
use longstep_core::skill::Skills;
use longstep_core::verify::VerifiedPlan;
use longstep_files::read_text;
use longstep_llm::advance;
use longstep_robot::{Opened, Robot, preflight, reports};

use super::robot::failure;
use crate::arguments::{DraftArguments, ExecutionArguments, RunArguments, domain_or_default};
use crate::ask::{self, Waiting};
use crate::clock::clock;
use crate::draft::Draft;
use crate::exit_code::NOT_VALID;
use crate::failure::Failure;
use crate::{inputs, plan, solve};

/// A plan and its purpose.
pub(super) struct Begun {
    pub(super) plan: VerifiedPlan,
    pub(super) aim: Aim,
    /// The words of the instruction that the plan does not say.
    pub(super) not_in_plan: Vec<String>,
}

/// Returns the plan to run, or the exit code where there is none.
pub(super) fn begin(arguments: &RunArguments, what: &str) -> Result<Result<Begun, u8>> {
    if Path::new(what).is_file() {
        of_file(arguments, Path::new(what))
    } else {
        of_instruction(arguments, what)
    }
}

fn of_file(arguments: &RunArguments, path: &Path) -> Result<Result<Begun, u8>> {
    let mut draft = Draft::read(&DraftArguments {
        plan: path.to_owned(),
        env: arguments.env.clone(),
        project_env: arguments.project_env.clone(),
        problem: None,
        domain: arguments.domain.clone(),
        rules: arguments.rules.clone(),
    })?;
    if let Some(goal) = &arguments.goal {
        draft.pursue(goal)?;
    }
    let aim = Aim::from(draft.goal());
    let not_in_plan = draft.not_in_plan().to_vec();
    Ok(draft.verified("run").map(|plan| Begun { plan, aim, not_in_plan }))
}

fn of_instruction(arguments: &RunArguments, instruction: &str) -> Result<Result<Begun, u8>> {
    let instruction = plan::checked_instruction(instruction)?;
    let Some(env) = arguments.env.as_ref().or(arguments.project_env.as_ref()) else {
        return Err(Failure::unreadable(format!(
            "there is no file `{instruction}`, and an instruction needs a world"
        ))
        .hint("pass the environment with `--env ENV.json`")
        .into());
    };
    let named = domain_or_default(arguments.domain.as_ref());
    let domain = inputs::domain_with_prompt(named, arguments.strategy.prompt.as_deref())?;
    let world = inputs::world(&domain, env, arguments.rules.as_deref())?;
    let mut model = ask::model(arguments.model.name(), &arguments.model)?;
    let settings = arguments.strategy.settings();
    let mut session = Session::new(named, domain, world, settings, model.facts(), clock());
    session.instruct(instruction)?;
    let mut waiting = Waiting::new(model.name());
    advance(&mut session, model.as_mut(), None, &mut waiting)?;
    drop(waiting);
    let answer = match session.response() {
        Response::Plan(proposal) => {
            let aim = aim_of(proposal.goal.as_ref(), session.world());
            let plan = proposal.plan.clone();
            let not_in_plan = proposal.answer.plan.not_in_plan.clone();
            return Ok(Ok(Begun { plan, aim, not_in_plan }));
        }
        Response::Consent(proposal) => {
            let question = proposal.question.as_deref().unwrap_or_default();
            proposal.answer.as_question(session.world(), question)
        }
        Response::NoPlan(failure) => plan::unhappy(failure)?,
        Response::Question(question) => Answer::without_plan(Status::Question, session.world(), instruction, question),
        _ => return Err(Failure::new("the session ended early", crate::exit_code::MODEL).into()),
    };
    let code = solve::finish(&answer, &[], &[], None, arguments.json)?;
    Ok(Err(code))
}

/// Returns the aim of a plan that was made for a goal, or without one.
pub(crate) fn aim_of(goal: Option<&Goal>, world: &World) -> Aim {
    Aim::from(goal.map(|goal| goal.exact(world).join(" & ")))
}

/// Refuses a robot that does not observe.
pub(crate) fn observing(robot: &dyn Robot) -> Result<()> {
    if robot.describe().observes {
        Ok(())
    } else {
        Err(
            Failure::unreadable("this robot does not observe, so its plan cannot be monitored")
                .hint("let the robot's program declare the capability `observe` and answer `observe`")
                .into(),
        )
    }
}

/// Begins the execution of a plan on a robot that understands every step. `teach` says what to do about missing values of
/// skill parameters.
pub(crate) fn execution(
    arguments: &ExecutionArguments,
    opened: &Opened,
    plan: &VerifiedPlan,
    aim: &Aim,
    teach: &str,
) -> Result<Execution> {
    let settings = settings(arguments, opened, plan.world())?;
    preflight(opened.robot.as_ref(), plan, &settings.skills).map_err(|error| failure(&error))?;
    Execution::new(plan, aim, settings).map_err(|error| refused(error, teach))
}

/// Returns the failure for a plan that is not carried out.
fn refused(error: BeginError, teach: &str) -> anyhow::Error {
    match error {
        BeginError::Goal(error) => error.into(),
        BeginError::Purpose(_) => Failure::new(error.to_string(), NOT_VALID)
            .hint("nothing has moved; `longstep repair PLAN.json --save FILE` may mend the plan")
            .into(),
        BeginError::Refused(parts) => {
            let parts = parts.iter().map(ToString::to_string);
            Failure::several_of(parts.collect(), NOT_VALID)
                .hint("nothing has moved; plan without this, or change the levels and limits of the robot")
                .into()
        }
        BeginError::UnknownPlaces(_) => Failure::unreadable(error.to_string())
            .hint("correct the names in `forbidden`, or list the places in the environment")
            .into(),
        BeginError::Untaught(missing) => {
            let missing = missing.iter().map(ToString::to_string);
            Failure::several(missing.collect()).hint(teach).into()
        }
        _ => Failure::unreadable(error.to_string()).into(),
    }
}

/// Returns the settings of an execution on a robot. Nobody approves a dry run.
fn settings(arguments: &ExecutionArguments, opened: &Opened, world: &World) -> Result<Settings> {
    let (robot, domain) = (opened.robot.as_ref(), world.domain());
    let skills = match &arguments.skills {
        Some(path) => Skills::parse(domain, &path.display().to_string(), &read_text(path)?)?,
        None => Skills::default(),
    };
    observing(robot)?;
    let autonomy = autonomy(arguments, opened, world)?;
    Ok(Settings::default()
        .with_approval(if opened.is_dry {
            Approval::Never
        } else {
            arguments.approve.map_or_else(Approval::default, Approval::from)
        })
        .with_trust(if opened.is_dry {
            // Nothing is observed in a dry run.
            Trust::Promised
        } else {
            arguments.trust.map_or_else(Trust::default, Trust::from)
        })
        .with_watch(arguments.observe.map_or_else(Watch::default, Watch::from))
        .with_changes(arguments.changes.unwrap_or(Settings::default().changes))
        .with_reports(reports(robot, world).map_err(|error| Failure::unreadable(error.to_string()))?)
        .with_skills(skills)
        .with_autonomy(if opened.is_dry {
            autonomy.without_people()
        } else {
            autonomy
        }))
}

/// Returns the levels and limits of a robot, with those of `--autonomy`.
pub(super) fn autonomy(arguments: &ExecutionArguments, opened: &Opened, world: &World) -> Result<Autonomy> {
    let Some(path) = &arguments.autonomy else {
        return Ok(opened.autonomy.clone());
    };
    let file = path.display().to_string();
    let own = Autonomy::parse(world.domain(), Some(world), &file, &read_text(path)?)?;
    Ok(opened.autonomy.and(&own))
}
