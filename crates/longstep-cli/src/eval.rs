//! `longstep eval`: suites, runs, reports.

mod inputs;
mod progress;
mod queue;

use std::path::{Path, PathBuf};
use std::sync::Arc;

use anyhow::Result;
use longstep::domain::{Domain, Files};
use longstep::session::{RepairPolicy, Settings, Strategy};
use longstep_eval::attempt::{Attempt, Key};
use longstep_eval::folder::{self, Plan, Results, RunFolder, VERSION};
use longstep_eval::run::Lines;
use longstep_eval::suite::{self, PLAIN, Suite};
use longstep_eval::{
    Alone, Campaign, Changes, Choice, Opened, Recorded, Source, Summary, compare, domain_sha256, lengths, report, units,
};
use longstep_files::overlay_prompt;
use longstep_llm::{AdvanceError, ModelError, ModelReference};

use crate::arguments::{EvalArguments, EvalCommand, ModelArguments};
use crate::failure::{Failure, MODEL};
use crate::output::{self, counted, print_line, remark};
use crate::{ask, exit_code};
use progress::Bar;
use queue::SharedQueue;

pub(crate) fn run(arguments: &EvalArguments) -> Result<u8> {
    match &arguments.command {
        Some(EvalCommand::List) => list(),
        Some(EvalCommand::Report { run }) => tell(&folder::read(run)?, run),
        Some(EvalCommand::Compare { before, after, html }) => compare_runs(before, after, html.as_deref()),
        None => evaluate(arguments),
    }
}

fn list() -> Result<u8> {
    for name in suite::shipped_names() {
        let files = inputs::suite_files(name)?;
        let domain = inputs::suite_domain_files(name, &files)?;
        let suite = suite::load(&files, &longstep::domain::load(&domain)?)?;
        let steps: usize = suite.cases.iter().map(|case| case.steps.len()).sum();
        print_line!("{name:<12} {steps:>4} instructions  {}", suite.about);
    }
    Ok(exit_code::DONE)
}

/// A run and its settings.
struct Task {
    suite: Suite,
    domain: Arc<Domain>,
    plan: Plan,
    /// The address of the model's server, if it has one.
    server: Option<String>,
    choice: Choice,
    /// The folder of the run.
    out: PathBuf,
    /// The address of the database that has the queue, if other programs share it.
    queue: Option<String>,
}

fn evaluate(arguments: &EvalArguments) -> Result<u8> {
    let name = arguments.suite.as_deref().unwrap_or_default();
    let out = arguments.out.clone().unwrap_or_else(|| inputs::default_folder(name));
    if arguments.recorded {
        return paper_tables(arguments, name, &out);
    }
    if arguments.check {
        let mut load = |files: Files| -> Result<Domain> { Ok(longstep::domain::load(&files)?) };
        let (suite, ..) = inputs::suite(arguments, name, &mut load)?;
        let given_up = check_goals(&suite)?;
        let cases = counted(suite.cases.len(), "case");
        if given_up == 0 {
            print_line!("{}: the expected goals of {cases} can be reached", suite.name);
            return Ok(exit_code::DONE);
        }
        print_line!(
            "{}: no expected goal of {cases} is known to be out of reach; the search gave up for {}",
            suite.name,
            counted(given_up, "instruction")
        );
        return Ok(exit_code::GAVE_UP);
    }
    let recorded = arguments.replies.as_deref().map(inputs::replies).transpose()?;
    let settings = arguments.strategy.settings();
    let mut task = task(arguments, name, settings, out, recorded.as_ref())?;
    let results = match recorded {
        Some((recorded, _)) => perform(&mut task, 1, &|| Box::new(recorded.clone()))?,
        None => {
            let reference: ModelReference = arguments.model.name().parse()?;
            let embedded = matches!(reference, ModelReference::Catalogue(_) | ModelReference::File(_));
            if embedded && arguments.jobs > 1 {
                return Err(Failure::unreadable("an embedded model answers one request at a time")
                    .hint("omit `--jobs`, which is for servers")
                    .into());
            }
            perform(&mut task, arguments.jobs.into(), &|| Box::new(opened(&arguments.model)))?
        }
    };
    if arguments.json {
        return print_json(&results);
    }
    tell(&results, &task.out)
}

/// Refuses a suite with an expected goal that no plan reaches, and warns about goals for which the search gave up or that hold
/// already. Returns the number of instructions for which it gave up.
fn check_goals(suite: &Suite) -> Result<usize> {
    let found = suite.goal_findings(&longstep::Limits::default());
    let given_up: Vec<_> = found.unreached.iter().filter(|one| !one.proven).collect();
    for open in &given_up {
        remark!("warning: {open}");
    }
    for settled in &found.settled {
        remark!("warning: {settled}");
    }
    let proven: Vec<_> = found.unreached.iter().filter(|one| one.proven).collect();
    for unreachable in &proven {
        remark!("{unreachable}");
    }
    if proven.is_empty() {
        return Ok(given_up.len());
    }
    let goals = counted(proven.len(), "expected goal");
    Err(
        Failure::unreadable(format!("{goals} of {} cannot be reached", suite.name))
            .hint("correct the goal or the scene, or expect a refusal; `longstep solve` shows more")
            .into(),
    )
}

/// A model that is opened for each trial, with a new seed.
fn opened(arguments: &ModelArguments) -> Opened {
    let mut arguments = arguments.clone();
    let first = arguments.seed.unwrap_or_default();
    Opened::new(Box::new(move |trial| {
        arguments.seed = Some(first + u64::from(trial - 1));
        ask::open_quietly(&arguments)
    }))
}

/// Runs the two tables of the paper with the paper's recorded replies.
fn paper_tables(arguments: &EvalArguments, name: &str, out: &Path) -> Result<u8> {
    if name != "paper" {
        return Err(Failure::unreadable("`--recorded` works only with the suite `paper`")
            .hint("use `--replies FILE` for your own recorded replies")
            .into());
    }
    // The paper's plans are judged without repair, and its model had at most three rounds of feedback.
    for (table, file, rounds) in [
        ("trials", "recorded_trials.json", 0),
        ("feedback", "recorded_feedback.json", 3),
    ] {
        let settings = Settings::default()
            .with_strategy(Strategy::Direct)
            .with_repair(RepairPolicy::Never)
            .with_rounds(rounds);
        let recorded = inputs::replies(&inputs::corpus(arguments)?.join("virtualhome14").join(file))?;
        let mut task = task(arguments, name, settings, out.join(table), Some(&recorded))?;
        let results = perform(&mut task, 1, &|| Box::new(recorded.0.clone()))?;
        tell(&results, &task.out)?;
    }
    Ok(exit_code::DONE)
}

fn task(
    arguments: &EvalArguments,
    name: &str,
    settings: Settings,
    out: PathBuf,
    recorded: Option<&(Recorded, String)>,
) -> Result<Task> {
    let mut files = Files::default();
    let mut applied = Vec::new();
    let changes = Changes {
        renamed: arguments.renamed.clone(),
        examples: arguments.examples,
    };
    let mut load = |domain_files: Files| -> Result<Domain> {
        files = domain_files;
        if let Some(prompt) = &arguments.strategy.prompt {
            overlay_prompt(&mut files, prompt)?;
        }
        applied = changes.apply(&mut files).map_err(|error| {
            Failure::unreadable(error.to_string()).hint("`longstep domain show DOMAIN` lists the actions")
        })?;
        Ok(longstep::domain::load(&files)?)
    };
    let (suite, suite_sha256, domain) = inputs::suite(arguments, name, &mut load)?;
    check_goals(&suite)?;
    let trials = match recorded {
        Some((recorded, _)) => recorded.keys().map(|(_, trial)| trial).max().unwrap_or(1),
        None => arguments.trials,
    };
    let choice = Choice {
        tags: arguments.tags.clone(),
        cases: arguments.cases.clone(),
        wordings: match recorded {
            Some(_) => vec![PLAIN.to_owned()],
            None => arguments.wordings.clone(),
        },
        trials,
    };
    let model = &arguments.model;
    let (model_sha256, server) = match recorded {
        Some((_, sha256)) => (Some(sha256.clone()), None),
        None => inputs::origin(&model.name().parse()?)?,
    };
    let plan = Plan {
        version: VERSION,
        longstep: env!("CARGO_PKG_VERSION").to_owned(),
        suite: suite.name.clone(),
        suite_sha256,
        domain: suite.domain.clone(),
        domain_sha256: domain_sha256(&files),
        model: match recorded {
            Some(_) => "recorded replies".to_owned(),
            None => inputs::without_address(model.name()),
        },
        model_sha256,
        adapters: inputs::adapters(&model.adapters())?,
        server: None,
        settings,
        temperature: model.temperature,
        top_p: model.top_p,
        seed: model.seed.unwrap_or_default(),
        trials,
        tags: choice.tags.clone(),
        cases: choice.cases.clone(),
        wordings: choice.wordings.clone(),
        changes: applied,
    };
    Ok(Task {
        suite,
        domain: Arc::new(domain),
        plan,
        server,
        choice,
        out,
        queue: arguments.queue.clone(),
    })
}

/// Runs the units that are not in the folder yet.
fn perform(task: &mut Task, jobs: usize, source: &(dyn Fn() -> Box<dyn Source> + Sync)) -> Result<Results> {
    let all = units(&task.suite, &task.choice);
    if all.is_empty() {
        return Err(
            Failure::unreadable("no case of the suite matches the given tags, ids and wordings")
                .hint("`longstep eval list` lists the suites; the tags are in their .toml files")
                .into(),
        );
    }
    let lengths = lengths(&all);
    let (mut folder, mut results) = RunFolder::open(&task.out, &task.plan, task.server.as_deref(), &lengths)?;
    let rest = &all[folder.units_done()..];
    ask::watch_for_interrupts();
    let stop = ask::interrupted().atomic();
    let queue = task.queue.as_deref().map(|address| {
        let done = lines_by_unit(&results, &lengths[..folder.units_done()]);
        SharedQueue::open(address, &task.plan, &lengths, stop)?.with_done(done)
    });
    let queue = queue.transpose()?;
    let bar = Bar::new(all.len(), folder.units_done(), &results.attempts);
    let campaign = Campaign {
        suite: &task.suite,
        domain: Arc::clone(&task.domain),
        settings: task.plan.settings,
        jobs,
    };
    let tell = |progress| bar.tell(&progress);
    let done = |lines: Lines| {
        folder.add(&lines)?;
        bar.done(&lines);
        for (attempt, timing) in lines {
            results.timings.insert(timing.key.clone(), timing);
            results.attempts.push(attempt);
        }
        anyhow::Ok(())
    };
    let outcome = match &queue {
        Some(queue) => campaign.run(rest, queue, source, stop, &tell, done),
        None => campaign.run(rest, &Alone, source, stop, &tell, done),
    };
    drop(bar);
    let done = results.attempts.len();
    outcome.map_err(|error| match error.downcast_ref::<AdvanceError>() {
        Some(AdvanceError::Model(ModelError::Stopped)) => {
            let message = format!(
                "stopped after {done} instructions; the results are in {}",
                task.out.display()
            );
            Failure::new(message, MODEL)
                .hint("run the same command again to resume")
                .into()
        }
        _ => error,
    })?;
    Ok(results)
}

/// The lines of the complete units of a folder.
fn lines_by_unit(results: &Results, units: &[(Key, usize)]) -> Vec<Lines> {
    let mut attempts = results.attempts.iter();
    let line = |attempt: &Attempt| Some((attempt.clone(), results.timings.get(&attempt.key)?.clone()));
    let unit = |(_, steps): &(Key, usize)| attempts.by_ref().take(*steps).filter_map(line).collect();
    units.iter().map(unit).collect()
}

fn print_json(results: &Results) -> Result<u8> {
    let summary = Summary::of(&results.attempts, &results.timings);
    output::json_line(&serde_json::json!({"run": results.plan, "summary": summary}))?;
    Ok(exit_code::DONE)
}

/// Writes the reports of a run into its folder, and prints the summary.
fn tell(results: &Results, folder: &Path) -> Result<u8> {
    let page = folder.join("report.html");
    inputs::write(&page, &report::html(results))?;
    inputs::write(&folder.join("report.md"), &report::markdown(results))?;
    output::document(&report::text(results));
    remark!("Report: {}", page.display());
    Ok(exit_code::DONE)
}

fn compare_runs(before: &Path, after: &Path, html: Option<&Path>) -> Result<u8> {
    let (before, after) = (folder::read(before)?, folder::read(after)?);
    if let Some(page) = html {
        inputs::write(page, &compare::html(&before, &after))?;
    }
    output::document(&compare::text(&before, &after));
    Ok(exit_code::DONE)
}
