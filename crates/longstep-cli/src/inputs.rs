//! Reads domains, environments and plans; writes files atomically.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::path::Path;

use anyhow::Result;
use longstep::diagnostic::nearest;
use longstep::domain::{self, Domain, Files};
use longstep::environment::{self, Environment, World};
use longstep::json;
use longstep::plan::{self, PlanFile, TaskCohesion};
use longstep_llm::{read_bounded, write_whole};

use crate::failure::Failure;
use crate::output;

/// Larger files are not environments or plans; the read stops here.
const SIZE_LIMIT: u64 = 64 << 20;

/// Reads a text file; errors contain its path and the reason.
pub(crate) fn text(path: &Path) -> Result<String> {
    let shown = path.display();
    let metadata = std::fs::metadata(path).map_err(|error| {
        Failure::unreadable(format!("cannot read {shown}: {}", output::plain(&error))).hint("check the path")
    })?;
    if metadata.is_dir() {
        return Err(Failure::unreadable(format!("{shown} is a folder, not a file")).into());
    }
    let bytes = read_bounded(path, SIZE_LIMIT).map_err(|error| match error.kind() {
        ErrorKind::FileTooLarge => Failure::unreadable(format!("{shown} is larger than {} MiB", SIZE_LIMIT >> 20))
            .hint("check the path: no environment, plan or domain is as large as that"),
        _ => Failure::unreadable(format!("cannot read {shown}: {}", output::plain(&error))).hint("check the path"),
    })?;
    String::from_utf8(bytes).map_err(|_| {
        Failure::unreadable(format!("{shown} is not a text file (not UTF-8)"))
            .hint("save it as UTF-8")
            .into()
    })
}

/// Loads a shipped domain by its name, or any domain by its folder.
pub(crate) fn domain(name: &str) -> Result<Domain> {
    Ok(domain::load(&domain_files(name)?)?)
}

/// Loads a domain; files in the folder `prompt` replace its prompt files.
pub(crate) fn domain_with_prompt(name: &str, prompt: Option<&Path>) -> Result<Domain> {
    let mut files = domain_files(name)?;
    if let Some(folder) = prompt {
        overlay(&mut files, folder)?;
    }
    Ok(domain::load(&files)?)
}

/// Replaces a domain's prompt files by those of a folder.
pub(crate) fn overlay(files: &mut Files, folder: &Path) -> Result<()> {
    let shown = format!("{}/", folder.display().to_string().trim_end_matches('/'));
    Ok(files.overlay(&shown, prompt_files(folder)?)?)
}

/// The files of a shipped domain by its name, or of any domain by its folder.
pub(crate) fn domain_files(name: &str) -> Result<Files> {
    if let Some(shipped) = domain::shipped_files(name) {
        return Ok(shipped);
    }
    let folder = Path::new(name);
    if !folder.is_dir() {
        let shipped = domain::shipped_names();
        let hint = match nearest(name, shipped.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "shipped domains are {}; or give the path of a domain's folder",
                shipped.join(", ")
            ),
        };
        return Err(Failure::unreadable(format!("there is no domain `{name}`"))
            .hint(hint)
            .into());
    }
    let prefix = format!("{}/", name.trim_end_matches('/'));
    let mut parts = prompt_files(&folder.join("prompt"))?;
    let feedback = parts.remove("feedback.toml").unwrap_or_default();
    parts.retain(|name, _| !Files::GOAL.contains(&name.as_str()));
    Ok(Files {
        parts,
        elsewhere: BTreeMap::new(),
        pddl: text(&folder.join("domain.pddl"))?,
        words: text(&folder.join("domain.toml"))?,
        goal_prompt: text(&folder.join("prompt/goal.md"))?,
        examples: text(&folder.join("prompt/examples.toml"))?,
        feedback,
        folder: prefix,
    })
}

/// The prompt files of a folder, by file name: a domain's `prompt/`, or a folder for [`Files::overlay`]. Hidden and
/// backup files of editors are skipped.
pub(crate) fn prompt_files(folder: &Path) -> Result<BTreeMap<String, String>> {
    let failed = |error: std::io::Error| {
        Failure::unreadable(format!("cannot read {}: {}", folder.display(), output::plain(&error)))
            .hint("check the path")
    };
    let mut files = BTreeMap::new();
    for entry in std::fs::read_dir(folder).map_err(failed)? {
        let path = entry.map_err(failed)?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else {
            continue;
        };
        if path.is_file() && !name.starts_with('.') && !name.ends_with('~') {
            files.insert(name.to_owned(), text(&path)?);
        }
    }
    Ok(files)
}

/// Reads an environment file as a world of the domain.
pub(crate) fn world(domain: &Domain, path: &Path) -> Result<World> {
    let text = text(path)?;
    let shown = path.display().to_string();
    let environment = Environment::from_json(&text).map_err(|error| {
        Failure::unreadable(format!("{shown}: {error}"))
            .hint("an environment is JSON with `assets`, `asset_states`, `objects` and `object_states`")
    })?;
    let wrapped = text_has_key(&text, "environment");
    let inside = if wrapped {
        json::Path::key("environment")
    } else {
        json::Path::default()
    };
    read_world(domain, &environment, &shown, &text, &inside)
}

fn text_has_key(text: &str, key: &str) -> bool {
    serde_json::from_str::<serde_json::Value>(text).is_ok_and(|value| value.get(key).is_some())
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
                let message = format!("{shown} is no environment of the domain `{}`", domain.name);
                Failure::unreadable(message)
                    .hint(format!("it fits the domain `{other}`: add --domain {other}"))
                    .into()
            }
            None => findings.into(),
        }
    })
}

/// Reads a plan, a script, or a model's reply that contains a plan; also returns the text, for positions in errors.
pub(crate) fn plan(path: &Path) -> Result<(plan::Draft, String)> {
    let text = text(path)?;
    if path.extension().is_some_and(|extension| extension == "py") {
        let written = plan::script::read(&text)
            .map_err(|error| Failure::unreadable(format!("{}: {error}", path.display())).hint(error.hint))?;
        let draft = plan::Draft {
            file: PlanFile::from(TaskCohesion::from_written(written)),
            leniencies: Vec::new(),
        };
        return Ok((draft, text));
    }
    let draft = plan::read(&text)
        .map_err(|error| Failure::unreadable(format!("{}: {error}", path.display())).hint(error.hint()))?;
    Ok((draft, text))
}

/// Writes a plan's file atomically.
pub(crate) fn save(path: &Path, plan: &PlanFile) -> Result<()> {
    let mut json = serde_json::to_string_pretty(plan)?;
    json.push('\n');
    write_whole(path, json.as_bytes()).map_err(|error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), output::plain(&error)))
            .hint("check that the folder exists and may be written to")
    })?;
    Ok(())
}
