//! Finds suites, recordings, and their domains.

use std::path::{Path, PathBuf};

use anyhow::Result;
use longstep::domain::{self, Domain, Files as DomainFiles};
use longstep_core::diagnostic::nearest;
use longstep_eval::suite::{self, Files, Suite, paper};
use longstep_eval::{Recorded, sha256};
use longstep_files::{LOG_LIMIT, domain_files, plain_reason, read_bounded, read_text, read_texts, write_whole};
use longstep_llm::{AdapterChoice, ModelReference, server_address};

use crate::arguments::EvalArguments;
use crate::failure::Failure;

/// Largest adapter, in bytes.
const ADAPTER_LIMIT: u64 = 1 << 30;

/// The default folder of a run.
pub(super) fn default_folder(suite: &str) -> PathBuf {
    let name = Path::new(suite).file_name().unwrap_or_default();
    Path::new("eval").join(name)
}

/// Reads a suite, and loads its domain with `load`. Also returns the SHA-256 of the suite's files.
pub(super) fn suite(
    arguments: &EvalArguments,
    name: &str,
    load: &mut dyn FnMut(DomainFiles) -> Result<Domain>,
) -> Result<(Suite, String, Domain)> {
    if name == "paper" {
        let file = corpus(arguments)?.join("virtualhome14/scenarios.json");
        let text = read_text(&file)?;
        let domain = load(domain_files("virtualhome")?)?;
        let suite = paper::load(&domain, &file.display().to_string(), &text)?;
        let files = Files {
            suite: text,
            ..Files::default()
        };
        return Ok((suite, files.sha256(), domain));
    }
    let files = suite_files(name)?;
    let domain = load(suite_domain_files(name, &files)?)?;
    Ok((suite::load(&files, &domain)?, files.sha256(), domain))
}

/// The folder of the paper's recordings.
pub(super) fn corpus(arguments: &EvalArguments) -> Result<&Path> {
    arguments.corpus.as_deref().ok_or_else(|| {
        Failure::unreadable("the suite `paper` needs the paper's recordings, which are not part of longstep")
            .hint("pass their folder with `--corpus FOLDER`")
            .into()
    })
}

/// The files of a shipped suite by its name, or of any suite by its folder.
pub(super) fn suite_files(name: &str) -> Result<Files> {
    if let Some(shipped) = suite::shipped(name) {
        return Ok(shipped);
    }
    let folder = Path::new(name);
    if !folder.is_dir() {
        let mut known = suite::shipped_names();
        known.push("paper");
        let hint = match nearest(name, known.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => format!(
                "use a known suite ({}) or the path of a suite's folder",
                known.join(", ")
            ),
        };
        return Err(Failure::unreadable(format!("there is no suite `{name}`"))
            .hint(hint)
            .into());
    }
    let mut cases = read_texts(folder, |name| name.ends_with(".toml"))?;
    let suite = cases.remove("suite.toml").ok_or_else(|| {
        Failure::unreadable(format!("{} has no suite.toml", folder.display()))
            .hint("add one with `name`, `about` and `domain`")
    })?;
    let scenes = folder.join("scenes");
    if !scenes.is_dir() {
        return Err(
            Failure::unreadable(format!("{} has no folder `scenes`", folder.display()))
                .hint("add it with the environments as NAME.json")
                .into(),
        );
    }
    Ok(Files {
        folder: format!("{}/", name.trim_end_matches('/')),
        suite,
        cases,
        scenes: read_texts(&scenes, |name| name.ends_with(".json"))?
            .into_iter()
            .map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text))
            .collect(),
    })
}

/// The files of a suite's domain: a shipped one, or a folder relative to the suite or to the working directory.
pub(super) fn suite_domain_files(suite: &str, files: &Files) -> Result<DomainFiles> {
    let name = suite::domain_name(files)?;
    let beside = Path::new(suite).join(&name);
    if domain::shipped_files(&name).is_none() && beside.is_dir() {
        return Ok(domain_files(&beside.display().to_string())?);
    }
    Ok(domain_files(&name)?)
}

/// Reads recorded replies; also returns the SHA-256 of their file.
pub(super) fn replies(path: &Path) -> Result<(Recorded, String)> {
    let text = read_text(path)?;
    let recorded = Recorded::read(&text);
    let recorded = recorded.map_err(|error| Failure::unreadable(format!("{}: {error}", path.display())))?;
    Ok((recorded, sha256(text.as_bytes())))
}

/// Returns the identity of a model: SHA-256 of its file or recording, and the address of its server.
pub(super) fn origin(reference: &ModelReference) -> Result<(Option<String>, Option<String>)> {
    let hash = match reference {
        ModelReference::Catalogue(entry) => Some(entry.sha256.to_owned()),
        ModelReference::Replay(path) => {
            let bytes = read_bounded(path, LOG_LIMIT).map_err(|error| {
                Failure::unreadable(format!("cannot replay {}: {}", path.display(), plain_reason(&error)))
                    .hint("check the path")
            })?;
            Some(sha256(&bytes))
        }
        _ => None,
    };
    Ok((hash, server_address(reference)?))
}

/// Returns what tells the adapters of a run from others.
pub(super) fn adapters(choice: &AdapterChoice) -> Result<String> {
    let files = match choice {
        AdapterChoice::Catalogue => return Ok("catalogue".to_owned()),
        AdapterChoice::Off => return Ok("off".to_owned()),
        AdapterChoice::Files(files) => files,
    };
    let mut hashes = Vec::new();
    for path in files {
        let bytes = read_bounded(path, ADAPTER_LIMIT).map_err(|error| {
            Failure::unreadable(format!("cannot read {}: {}", path.display(), plain_reason(&error)))
                .hint("check the path")
        })?;
        hashes.push(sha256(bytes.as_slice()));
    }
    Ok(hashes.join(", "))
}

/// A model's reference without the address of a server, which may contain a password.
pub(super) fn without_address(reference: &str) -> String {
    match reference.rsplit_once('#') {
        Some((_, name)) if reference.contains("://") => format!("server#{name}"),
        _ => reference.to_owned(),
    }
}

/// Writes a file atomically.
pub(super) fn write(path: &Path, text: &str) -> Result<()> {
    write_whole(path, text.as_bytes()).map_err(|error| {
        Failure::unreadable(format!("cannot write {}: {}", path.display(), plain_reason(&error))).into()
    })
}
