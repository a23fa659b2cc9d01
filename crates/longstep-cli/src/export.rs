//! `longstep export`: a verified plan in another notation.

use std::path::Path;

use anyhow::Result;
use longstep::report::{Answer, Status};
use longstep_core::pddl::{self, SolvedTask, WriteError};
use longstep_core::plan::behavior_tree::{self, Guards};
use longstep_core::plan::{Written, script};
use longstep_core::verify::VerifiedPlan;
use longstep_files::write_file_set;
use longstep_picture::SvgOptions;
use longstep_picture::plan::{Diagram, dot, exceeds_defaults_of_mermaid, mermaid, svg};
use longstep_picture::scene;

use crate::arguments::{ExportArguments, PlanFormat};
use crate::draft::Draft;
use crate::exit_code;
use crate::failure::Failure;
use crate::output::{self, print_line, remark};

/// Prints the plan to stdout if it is valid; otherwise its verdict to stderr, and nothing to stdout.
pub(crate) fn run(arguments: &ExportArguments) -> Result<u8> {
    if arguments.guards && arguments.format != PlanFormat::Bt {
        return Err(Failure::unreadable("`--guards` is for behavior trees")
            .hint("use it with `--format bt`")
            .into());
    }
    if arguments.folder.is_some() && arguments.format != PlanFormat::Pddl {
        return Err(
            Failure::unreadable("`--folder` is for PDDL, whose domain, problem and plan are three files")
                .hint("use it with `--format pddl`, or write the output to a file: `> FILE`")
                .into(),
        );
    }
    let mut draft = Draft::read(&arguments.draft)?;
    if let Some(goal) = &arguments.goal {
        draft.pursue(goal)?;
    }
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
    match &arguments.folder {
        Some(folder) => write_task(arguments, folder, &draft, &verified)?,
        None => write(arguments, &draft, &verified, &answer)?,
    }
    Ok(exit_code::of_status(answer.status))
}

/// Prints a plan in the format that is wanted.
fn write(arguments: &ExportArguments, draft: &Draft, verified: &VerifiedPlan, answer: &Answer) -> Result<()> {
    // Not that of the draft, which lacks the values and texts in the plan.
    let world = verified.world();
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
                Failure::unreadable(format!("no behavior tree can have this plan: {error}")).hint(error.hint())
            })?
        }
        PlanFormat::Pddl if !verified.plan().is_sequence() => return Err(no_task(&WriteError::Branches).into()),
        PlanFormat::Pddl => pddl::write_plan(world, verified.plan().steps()),
        PlanFormat::Mermaid => mermaid(&diagram()),
        PlanFormat::Dot => dot(&diagram()),
        PlanFormat::Svg => {
            let options = SvgOptions::new(f64::from(arguments.width)).with_title(&answer.plan.instruction_summary);
            svg(&diagram(), &options)
        }
        PlanFormat::Scene => {
            let options = SvgOptions::new(f64::from(arguments.width)).with_title(&answer.plan.instruction_summary);
            scene::before_and_after(verified, &options)
        }
    };
    if arguments.format == PlanFormat::Mermaid && exceeds_defaults_of_mermaid(&text) {
        remark!(
            "note: pages draw this chart once `maxEdges` and `maxTextSize` of Mermaid are raised; `--format svg` has no limit"
        );
    }
    output::document(&text);
    Ok(())
}

/// The first line of the files of a task, which only this program writes and replaces.
const MARK: &str =
    "; Written by longstep export: domain.pddl, problem.pddl and plan.pddl of this folder belong together.\n";

/// Writes a plan with its domain and problem in PDDL, and prints the paths.
fn write_task(arguments: &ExportArguments, folder: &Path, draft: &Draft, verified: &VerifiedPlan) -> Result<()> {
    let name = arguments.draft.plan.file_stem().unwrap_or_default().to_string_lossy();
    let task = SolvedTask::write(verified, &draft.purpose(), &name).map_err(|error| no_task(&error))?;
    let texts = task.files().map(|(name, text)| (name, format!("{MARK}{text}")));
    let files: Vec<(&str, &str)> = texts.iter().map(|(name, text)| (*name, text.as_str())).collect();
    let paths = write_file_set(folder, MARK, &files)
        .map_err(|error| Failure::unreadable(error.to_string()).hint(error.hint()))?;
    for path in paths {
        print_line!("{}", path.display());
    }
    Ok(())
}

/// Returns the failure for a plan or a task without a form in PDDL.
fn no_task(error: &WriteError) -> Failure {
    let failure = Failure::unreadable(error.to_string());
    match error {
        WriteError::Branches => failure.hint("use `--format bt`, `python` or `json`"),
        WriteError::Order | WriteError::Always { .. } => failure.hint(
            "`longstep solve --goal GOAL --pddl-task FOLDER` writes a domain and a problem that can; without `--folder`, the plan alone is written",
        ),
        _ => failure.hint("without `--folder`, the plan alone is written"),
    }
}
