//! `longstep domain new`: writes the folder of a new domain, all of it or nothing.

use std::collections::BTreeMap;
use std::io::IsTerminal;
use std::path::Path;

use anyhow::Result;
use longstep::domain;
use longstep_author::{Answers, NewDomain, SourceText};
use longstep_eval::suite;
use longstep_files::{plain_reason, read_text};

use super::kept_answers::KeptAnswers;
use super::questions;
use crate::arguments::NewDomainArguments;
use crate::failure::Failure;
use crate::output::{Style, print_line, shell_word};
use crate::{schema, show};

/// The files of a domain that name a schema, and its name.
const SCHEMAS: [(&str, &str); 5] = [
    ("domain.toml", "domain"),
    ("environment.json", "environment"),
    ("prompt/examples.toml", "examples"),
    ("prompt/feedback.toml", "feedback"),
    ("prompt/plans.toml", "plans"),
];

pub(super) fn run(arguments: &NewDomainArguments) -> Result<()> {
    let folder = arguments.folder.as_path();
    if folder.exists() {
        return Err(Failure::unreadable(format!("{} already exists", folder.display()))
            .hint("choose another name")
            .into());
    }
    let name = folder
        .file_name()
        .map_or_else(|| "robot".to_owned(), |name| name.to_string_lossy().into_owned());
    if let Some(path) = &arguments.pddl {
        let text = read_text(path)?;
        let file = path.display().to_string();
        let problem = match &arguments.problem {
            Some(path) => Some((path.display().to_string(), read_text(path)?)),
            None => None,
        };
        let problem = problem.as_ref().map(|(file, text)| SourceText { file, text });
        let new = longstep_author::from_any_pddl(
            &name,
            SourceText {
                file: &file,
                text: &text,
            },
            problem,
        )?;
        return finish(folder, new, Vec::new());
    }
    if let Some(path) = &arguments.from {
        let text = read_text(path)?;
        let answers = Answers::read(&path.display().to_string(), &text)?;
        let new = longstep_author::from_answers(&answers)?;
        return finish(folder, new, vec![("answers.toml".to_owned(), text)]);
    }
    let asks = arguments.ask || std::io::stdin().is_terminal();
    if asks && !arguments.starter {
        let answers = questions::answers(&name)?;
        let new = longstep_author::from_answers(&answers)?;
        let kept = vec![("answers.toml".to_owned(), questions::written(&answers))];
        finish(folder, new, kept)?;
        KeptAnswers::remove();
        return Ok(());
    }
    write_folder(folder, &with_schemas(domain::starter(&name))?)?;
    print_line!("Created the domain {}. Next steps:", folder.display());
    let (shown, environment) = (
        shell_word(folder.display()),
        shell_word(folder.join("environment.json").display()),
    );
    print_line!("  longstep domain check {shown}");
    print_line!("  longstep plan \"Bring the parcel to the desk\" --env {environment} --domain {shown}");
    Ok(())
}

/// Checks the suite of a new domain, writes its files, and says what to do next.
fn finish(folder: &Path, new: NewDomain, extra: Vec<(String, String)>) -> Result<()> {
    let files: BTreeMap<&str, &str> = new
        .files
        .iter()
        .map(|(path, text)| (path.as_str(), text.as_str()))
        .collect();
    let text = |path: &str| files.get(path).copied().unwrap_or_default().to_owned();
    if files.contains_key("suite/suite.toml") {
        let cases = suite::Files {
            folder: "suite/".to_owned(),
            suite: text("suite/suite.toml"),
            cases: [("instructions.toml".to_owned(), text("suite/instructions.toml"))].into(),
            scenes: [("example".to_owned(), text("suite/scenes/example.json"))].into(),
        };
        suite::load(&cases, &new.domain)?;
    }
    let all: Vec<(String, String)> = new.files.into_iter().chain(extra).collect();
    write_folder(folder, &with_schemas(all)?)?;
    for note in &new.notes {
        show::finding("note:".cyan().bold(), note);
    }
    for finding in &new.findings {
        show::finding("warning:".yellow().bold(), &finding.named());
    }
    let (shown, environment) = (
        shell_word(folder.display()),
        shell_word(folder.join("environment.json").display()),
    );
    print_line!(
        "Created the domain {} (actions: {}, goals: {}, examples: {}).",
        folder.display(),
        new.domain.actions.len(),
        new.domain.goal_words.len(),
        new.domain.prompts.examples.len()
    );
    if new.invented {
        print_line!("Its environment.json is made up: check that such a world can be, or write your own.");
    }
    print_line!("The sentences in domain.toml are what people and models read: improve them first. Next steps:");
    print_line!("  longstep domain check {shown} --env {environment}");
    print_line!("  longstep domain try {shown}");
    Ok(())
}

/// Adds the schemas that the files name, with which editors complete them.
fn with_schemas(mut files: Vec<(String, String)>) -> Result<Vec<(String, String)>> {
    for (path, name) in SCHEMAS {
        if files.iter().any(|(own, _)| own == path) {
            files.push(schema::beside(name)?);
        }
    }
    Ok(files)
}

/// Writes files into a new folder. They are written beside it first and then renamed, so that the folder is complete
/// or absent.
fn write_folder(folder: &Path, files: &[(String, String)]) -> Result<()> {
    let shown = folder.display();
    let failed = |error: std::io::Error| {
        Failure::unreadable(format!("cannot write {shown}: {}", plain_reason(&error)))
            .hint("check that the parent folder exists and is writable")
    };
    let parent = folder.parent().filter(|p| !p.as_os_str().is_empty());
    let draft = tempfile::Builder::new()
        .prefix(".longstep-")
        .tempdir_in(parent.unwrap_or(Path::new(".")))
        .map_err(failed)?;
    for (path, text) in files {
        let path = draft.path().join(path);
        if let Some(inside) = path.parent() {
            std::fs::create_dir_all(inside).map_err(failed)?;
        }
        std::fs::write(&path, text).map_err(failed)?;
    }
    std::fs::rename(draft.keep(), folder).map_err(failed)?;
    Ok(())
}
