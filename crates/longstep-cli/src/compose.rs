//! `longstep compose`: combines stored plans into one plan.

use std::path::{Path, PathBuf};
use std::time::Instant;

use anyhow::Result;
use longstep::compose::{self, Composed, CompositionAnswer, CompositionDialogue, CompositionInput, Stored};
use longstep::dialogue::{Dialogue, Usage};
use longstep::report::{Answer, Status};
use longstep_core::environment::World;
use longstep_files::{TextFileError, read_text};
use longstep_llm::{converse, load_domain};

use crate::arguments::{ComposeArguments, domain_or_default};
use crate::ask::{self, Waiting};
use crate::clock::milliseconds;
use crate::failure::{Failure, UNREADABLE};
use crate::plan::checked_instruction;
use crate::solve::finish;
use crate::{inputs, output, show};

pub(crate) fn run(arguments: &ComposeArguments) -> Result<u8> {
    let started = Instant::now();
    let domain = load_domain(domain_or_default(arguments.world.domain.as_ref()))?;
    let world = inputs::world(&domain, arguments.world.env()?, arguments.world.rules.as_deref())?;
    let stored = stored(&arguments.plans)?;
    compose::check_names(&domain, &stored).map_err(|clash| {
        Failure::unreadable(clash.to_string()).hint("the file name is the name of a plan: rename one of the files")
    })?;
    let wish = arguments.instruction.as_deref().map(checked_instruction).transpose()?;
    let composition = match &arguments.script {
        Some(path) => written(path)?,
        None => request_composition(arguments, &world, &stored, wish.unwrap_or_default())?,
    };
    let model = milliseconds(started);
    let received = Instant::now();
    let summary = match wish {
        Some(wish) => wish.to_owned(),
        None => summary(&composition, &stored),
    };
    let mut answer = match composition.answer {
        CompositionAnswer::Question(question) => Answer::without_plan(Status::Question, &world, &summary, &question),
        CompositionAnswer::Composition(written) => match compose::inline(&world, &written, &stored) {
            Ok(inlined) => {
                let composed = Composed::new(&world, inlined, &summary);
                if arguments.no_repair {
                    composed.verdict()
                } else {
                    composed.mended()
                }
            }
            Err(misfits) => compose::refused(&world, &summary, &misfits),
        },
    };
    answer.usage = composition.usage.into();
    answer.timings_ms.verify = milliseconds(received);
    if arguments.script.is_none() {
        answer.timings_ms.model = model;
    }
    answer.timings_ms.total = milliseconds(started);
    if !arguments.json && answer.status != Status::Question {
        show::heading("Composition");
        output::quotation(composition.text.trim());
        output::blank();
    }
    let save = arguments.save.as_deref().map(|path| (path, &**world.domain()));
    finish(&answer, &[], &[], save, arguments.json)
}

/// The text of a composition, its parsed form, and what the model needed for it.
struct Composition {
    text: String,
    answer: CompositionAnswer,
    usage: Usage,
}

/// Reads a composition from a file.
fn written(path: &Path) -> Result<Composition> {
    let text = read_text(path)?;
    let answer = compose::read(&text)
        .map_err(|error| Failure::unreadable(format!("{}: {error}", path.display())).hint(error.hint()))?;
    Ok(Composition {
        text,
        answer,
        usage: Usage::default(),
    })
}

/// Requests a composition from a model.
fn request_composition(
    arguments: &ComposeArguments,
    world: &World,
    stored: &[Stored],
    wish: &str,
) -> Result<Composition> {
    let mut model = ask::model(arguments.model.name(), &arguments.model)?;
    let mut dialogue = CompositionDialogue::new(CompositionInput {
        world,
        stored,
        instruction: wish,
        rounds: &[],
        kind: model.constraint_kind(),
    });
    let name = model.name().to_owned();
    let answer = converse(model.as_mut(), &mut dialogue, &mut Waiting::new(&name))?;
    let transcript = dialogue.transcript();
    Ok(Composition {
        text: transcript.answer().to_owned(),
        answer,
        usage: transcript.usage(),
    })
}

/// The summary of a composition without an instruction: the summaries of its plans.
fn summary(composition: &Composition, stored: &[Stored]) -> String {
    let CompositionAnswer::Composition(written) = &composition.answer else {
        return String::new();
    };
    let plans = written
        .steps
        .iter()
        .filter_map(|step| stored.iter().find(|plan| plan.name == step.call.name));
    let mut summaries: Vec<&str> = Vec::new();
    for plan in plans.filter(|plan| !plan.summary.is_empty()) {
        if !summaries.contains(&plan.summary.as_str()) {
            summaries.push(&plan.summary);
        }
    }
    summaries.join("; ")
}

/// The plans of files, and of the plan files in folders, sorted by path.
fn stored(paths: &[PathBuf]) -> Result<Vec<Stored>> {
    let mut files = Vec::new();
    for path in paths {
        if path.is_dir() {
            files.extend(plan_files(path)?)
        } else {
            files.push(path.clone())
        }
    }
    // A file that is named twice, or together with its folder, counts once.
    files.sort();
    files.dedup();
    let mut stored = Vec::with_capacity(files.len());
    for file in files {
        let (draft, _) = inputs::plan(&file)?;
        let stem = file.file_stem().unwrap_or_default().to_string_lossy();
        stored.push(Stored::new(&stem, draft.file));
    }
    if stored.is_empty() {
        let failure = Failure::new("there are no stored plans to combine", UNREADABLE);
        return Err(failure.hint("store one with `longstep plan --save PLAN.json`").into());
    }
    Ok(stored)
}

/// The plan files of a folder. A session's log in the folder has another extension.
fn plan_files(folder: &Path) -> Result<Vec<PathBuf>> {
    let failed = |error: std::io::Error| TextFileError::new(folder, error);
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        if path.is_file() && path.extension().is_some_and(|ending| ending == "json") {
            files.push(path);
        }
    }
    Ok(files)
}
