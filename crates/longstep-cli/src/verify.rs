//! `longstep verify`: is a plan possible, and does it end where it claims?

use std::time::Instant;

use anyhow::Result;
use longstep::answer::{Answer, Claims, compare_claims};
use longstep::json::Path;
use longstep::plan::resolve;
use longstep::verify::{Purpose, bind, check};

use crate::arguments::VerifyArguments;
use crate::failure::Failure;
use crate::solve::milliseconds;
use crate::{inputs, show};

pub(crate) fn run(arguments: &VerifyArguments) -> Result<u8> {
    let started = Instant::now();
    let domain = inputs::domain(&arguments.domain)?;
    let (file, text) = inputs::plan(&arguments.plan)?;
    let shown = arguments.plan.display().to_string();
    let world = match (&arguments.env, &file.environment_before) {
        (Some(path), _) => inputs::world(&domain, path)?,
        (None, Some(environment)) => {
            inputs::read_world(&domain, environment, &shown, &text, &Path::key("environment_before"))?
        }
        (None, None) => {
            let failure = Failure::unreadable(format!("{shown} has no `environment_before`"));
            return Err(failure
                .hint("name the world before the plan with --env ENV.json")
                .into());
        }
    };
    let mut notes = Vec::new();
    // A claim that cannot be read is no reason not to look at the steps.
    let claimed = file.environment_after.as_ref().and_then(|environment| {
        let read = inputs::read_world(&domain, environment, &shown, &text, &Path::key("environment_after"));
        read.map_err(|error| notes.push(format!("`environment_after` was not compared: {error:#}")))
            .ok()
    });
    // Entities have the same numbers only if both environments list the same things.
    let comparable = claimed.filter(|claimed| {
        let same = claimed
            .entities()
            .map(|(_, e)| &e.identifier)
            .eq(world.entities().map(|(_, e)| &e.identifier));
        if !same {
            notes.push("`environment_after` was not compared: it lists other entities".to_owned());
        }
        same
    });
    let verifying = Instant::now();
    let mut answer = match resolve(&domain, &world, &file.task_cohesion) {
        Ok((steps, objects)) => {
            let state = comparable.as_ref().map(|claimed| &claimed.state);
            let (plan, open) = bind(&domain, &world, &steps, &objects, state);
            let report = check(&domain, &world, plan, &Purpose::default());
            let mut answer = Answer::of_report(&domain, &world, &report, None, &file.instruction_summary);
            answer.timings_ms.verify = milliseconds(verifying);
            answer
                .assumptions
                .extend(open.iter().map(|assumption| assumption.message(&domain, &world)));
            answer.claims = state.map_or_else(Claims::default, |state| {
                compare_claims(&domain, &world, state, &report.after)
            });
            notes.extend(
                report
                    .warnings
                    .iter()
                    .map(|w| w.message(&domain, &world, &report.steps, None)),
            );
            answer
        }
        Err(violations) => Answer::of_unresolved(&domain, &world, &file, &violations),
    };
    answer.plan.question.clone_from(&file.question);
    answer.timings_ms.total = milliseconds(started);
    if arguments.json {
        show::json(&answer)?;
    } else {
        show::answer(&answer, &notes);
    }
    Ok(answer.status.exit_code())
}
