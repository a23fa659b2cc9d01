//! Suites from folders, with their domains.

use std::error::Error;
use std::path::Path;

use longstep::domain::Domain;
use longstep_eval::suite::{self, Case, Files, Suite};
use longstep_files::read_texts;

/// Reads a suite and its domain, which is shipped or in a folder beside the cases.
pub(crate) fn read_suite(folder: &Path) -> Result<(Domain, Suite), Box<dyn Error>> {
    let mut cases = read_texts(folder, |name| name.ends_with(".toml"))?;
    let scenes = read_texts(&folder.join("scenes"), |name| name.ends_with(".json"))?;
    let files = Files {
        folder: format!("{}/", folder.display()),
        suite: cases.remove("suite.toml").ok_or("there is no suite.toml")?,
        cases,
        scenes: scenes
            .into_iter()
            .map(|(name, text)| (name.trim_end_matches(".json").to_owned(), text))
            .collect(),
    };
    let name = suite::domain_name(&files)?;
    let beside = folder.join(&name);
    let domain = if beside.is_dir() {
        longstep_llm::load_domain(&beside.display().to_string())?
    } else {
        longstep_llm::load_domain(&name)?
    };
    let suite = suite::load(&files, &domain)?;
    Ok((domain, suite))
}

/// Returns the case with an id.
pub(crate) fn find_case<'a>(suite: &'a Suite, id: &str) -> Option<&'a Case> {
    suite.cases.iter().find(|case| case.id == id.trim())
}
