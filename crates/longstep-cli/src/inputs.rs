//! Reads environments and plans; writes files atomically.

use std::path::Path;

use anyhow::Result;
use longstep::domain::{self, Domain};
use longstep::draft_text::{self, DraftText, DraftTextError, Notation};
use longstep_core::environment::{self, Environment, World};
use longstep_core::goal;
use longstep_core::json;
use longstep_core::model::DomainData;
use longstep_core::plan::{Draft, PlanFile};
use longstep_files::{plain_reason, read_text, write_whole};
use longstep_llm::{load_domain, load_domain_with_prompt};

use crate::failure::Failure;

/// Loads a domain; files in the folder `prompt` replace its prompt files.
pub(crate) fn domain_with_prompt(name: &str, prompt: Option<&Path>) -> Result<Domain> {
    Ok(match prompt {
        Some(folder) => load_domain_with_prompt(name, folder)?,
        None => load_domain(name)?,
    })
}

/// Reads an environment file as a world of the domain, with the rules of a file in force.
pub(crate) fn world(domain: &Domain, path: &Path, rules: Option<&Path>) -> Result<World> {
    with_rules(bare_world(domain, path)?, rules)
}

/// Puts the rules of a file in force: one rule a line, with empty lines and comments after `#`.
pub(crate) fn with_rules(mut world: World, path: Option<&Path>) -> Result<World> {
    let Some(path) = path else { return Ok(world) };
    let text = read_text(path)?;
    let mut rules = Vec::new();
    for (index, line) in text.lines().enumerate() {
        let line = line.split_once('#').map_or(line, |(rule, _)| rule).trim();
        if !line.is_empty() {
            world.add_values(line);
            let found = goal::rules(&world, line).map_err(|error| {
                let place = format!("{}:{}", path.display(), index + 1);
                Failure::unreadable(format!("{place}: {error}"))
                    .hint("a rule is `never GOAL`, `always GOAL` or `untouched(NAME)`")
            })?;
            rules.extend(found);
        }
    }
    Ok(world.with_prohibitions(rules))
}

fn bare_world(domain: &Domain, path: &Path) -> Result<World> {
    Ok(world_and_text(domain, path)?.0)
}

/// Reads an environment file as a world of the domain, and returns the text of the file too.
pub(crate) fn world_and_text(domain: &Domain, path: &Path) -> Result<(World, String)> {
    let text = read_text(path)?;
    let shown = path.display().to_string();
    let (environment, wrapped) = Environment::parse(&text).map_err(|error| {
        Failure::unreadable(format!("{shown}: {error}")).hint(
            "an environment is JSON, or a Python literal, with `assets`, `asset_states`, `objects` and `object_states`",
        )
    })?;
    let inside = if wrapped {
        json::Path::key("environment")
    } else {
        json::Path::default()
    };
    let world = read_world(domain, &environment, &shown, &text, &inside)?;
    Ok((world, text))
}

/// Reads an environment at the path `inside` of `text`. If it fits another shipped domain, the hint names that domain.
pub(crate) fn read_world(
    domain: &Domain,
    environment: &Environment,
    shown: &str,
    text: &str,
    inside: &json::Path,
) -> Result<World> {
    environment::read(domain, environment, shown, text, inside).map_err(|findings| {
        let fits = |name: &&str| {
            let other = domain::shipped(name).and_then(Result::ok);
            other.is_some_and(|other| environment::read(&other, environment, "", "", inside).is_ok())
        };
        match domain::shipped_names()
            .into_iter()
            .filter(|name| *name != domain.name)
            .find(fits)
        {
            Some(other) => {
                let message = format!("{shown} is not an environment of the domain `{}`", domain.name);
                Failure::unreadable(message)
                    .hint(format!("it fits the domain `{other}`: add `--domain {other}`"))
                    .into()
            }
            None => findings.into(),
        }
    })
}

/// Reads a plan, a script, or a model's reply that contains a plan; also returns the text, for positions in errors.
pub(crate) fn plan(path: &Path) -> Result<(Draft, String)> {
    let text = read_text(path)?;
    let draft = draft_text::draft(&path.display().to_string(), &text, Notation::of_file(path)).map_err(no_draft)?;
    Ok((draft, text))
}

/// Reads the text of a plan file, which may also be what a planner printed. `-` is the standard input.
pub(crate) fn plan_text(path: &Path, domain: &longstep_core::domain::Domain) -> Result<DraftText> {
    let path = if path.as_os_str() == "-" {
        Path::new("/dev/stdin")
    } else {
        path
    };
    let text = read_text(path)?;
    DraftText::read(&path.display().to_string(), &text, Notation::of_file(path), domain).map_err(no_draft)
}

/// Returns the error for a text without a plan.
pub(crate) fn no_draft(error: DraftTextError) -> anyhow::Error {
    match error {
        // Each finding has its place and its hint.
        DraftTextError::Printed(findings) => findings.into(),
        error => {
            let failure = Failure::unreadable(error.to_string());
            match error.hint() {
                Some(hint) => failure.hint(hint).into(),
                None => failure.into(),
            }
        }
    }
}

/// Writes a plan's file atomically, with the domain for which the plan was made.
pub(crate) fn save(path: &Path, plan: &PlanFile, domain: &DomainData) -> Result<()> {
    let mut json = serde_json::to_string_pretty(&plan.clone().of_domain(domain))?;
    json.push('\n');
    write_whole(path, json.as_bytes()).map_err(|error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(&error)))
            .hint("check that the folder exists and is writable")
    })?;
    Ok(())
}

/// Writes files into a folder, which is made if there is none.
pub(crate) fn write_files(folder: &Path, files: &[(&str, &str)]) -> Result<()> {
    let failed = |path: &Path, error: &std::io::Error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(error)))
            .hint("check that the folder is writable")
    };
    std::fs::create_dir_all(folder).map_err(|error| failed(folder, &error))?;
    for (name, text) in files {
        let path = folder.join(name);
        write_whole(&path, text.as_bytes()).map_err(|error| failed(&path, &error))?;
    }
    Ok(())
}
