//! `longstep export`: a verified plan in another notation.

use anyhow::Result;
use longstep::report::{Answer, Status};
use longstep_core::environment::fact_text;
use longstep_core::pddl;
use longstep_core::plan::behavior_tree::{self, Guards};
use longstep_core::plan::{Written, script};
use longstep_core::verify::{Ending, VerifiedPlan};
use longstep_picture::SvgOptions;
use longstep_picture::plan::{Diagram, dot, mermaid, svg};
use longstep_picture::scene::{self, Scene};

use crate::arguments::{ExportArguments, PlanFormat};
use crate::draft::Draft;
use crate::exit_code;
use crate::failure::Failure;
use crate::output::{self, remark};

/// Prints the plan to stdout if it is valid; otherwise its verdict to stderr, and nothing to stdout.
pub(crate) fn run(arguments: &ExportArguments) -> Result<u8> {
    if arguments.guards && arguments.format != PlanFormat::Bt {
        return Err(Failure::unreadable("`--guards` is for behavior trees")
            .hint("use it with `--format bt`")
            .into());
    }
    let draft = Draft::read(&arguments.draft)?;
    let assessment = draft.assessment();
    let answer = assessment.verdict();
    let verified = assessment.verified();
    let (Status::Verified, Some(verified)) = (answer.status, verified) else {
        match answer.status {
            Status::Question => remark!("The plan is a clarifying question: {}", answer.plan.question),
            _ => remark!("Not exported, because the plan is not valid:"),
        }
        for violation in &answer.violations {
            remark!("  - {}", violation.message);
        }
        return Ok(exit_code::of_status(answer.status));
    };
    write(arguments, &draft, &verified, &answer)?;
    Ok(exit_code::of_status(answer.status))
}

/// Prints a plan in the format that is wanted.
fn write(arguments: &ExportArguments, draft: &Draft, verified: &VerifiedPlan, answer: &Answer) -> Result<()> {
    let world = &draft.world;
    let diagram = || Diagram::of(verified, &draft.annotations());
    let text = match arguments.format {
        PlanFormat::Json => return output::json(&answer.plan.clone().of_domain(world.domain())),
        PlanFormat::Python => script::write(&Written::of_plan(world, verified.plan())),
        PlanFormat::Bt => {
            let guards = if arguments.guards {
                Guards::Preconditions
            } else {
                Guards::None
            };
            behavior_tree::write(world, verified.plan(), guards).map_err(|error| {
                Failure::unreadable(format!("no behavior tree can have this plan: {error}"))
                    .hint("rename the entity, or leave out `--guards`")
            })?
        }
        PlanFormat::Pddl => {
            if !verified.plan().is_sequence() {
                return Err(
                    Failure::unreadable("a plan with branches, loops or lanes has no form in PDDL")
                        .hint("use `--format bt`, `python` or `json`")
                        .into(),
                );
            }
            pddl::write_plan(world, verified.plan().steps())
        }
        PlanFormat::Mermaid => mermaid(&diagram()),
        PlanFormat::Dot => dot(&diagram()),
        PlanFormat::Svg => {
            let options = SvgOptions::new(f64::from(arguments.width)).with_title(&answer.plan.instruction_summary);
            svg(&diagram(), &options)
        }
        PlanFormat::Scene => {
            let options = SvgOptions::new(f64::from(arguments.width)).with_title(&answer.plan.instruction_summary);
            before_and_after(verified, &options)
        }
    };
    output::document(&text);
    Ok(())
}

/// Draws the world before a plan beside each one that the plan can end in.
fn before_and_after(verified: &VerifiedPlan, options: &SvgOptions) -> String {
    let world = verified.world();
    let after = |ending: &Ending| {
        let outcomes: Vec<String> = ending.when.iter().map(|fact| fact_text(world, *fact, true)).collect();
        let heading = match outcomes.as_slice() {
            [] => "After the plan".to_owned(),
            outcomes => format!("After the plan, if {}", outcomes.join(" and ")),
        };
        (heading, Scene::of(world, &ending.after))
    };
    let afters: Vec<(String, Scene)> = verified.endings().iter().map(after).collect();
    let before = Scene::of(world, &world.state);
    scene::comparison(("Before the plan", &before), &afters, options)
}
