//! The suites that are included in the library.

use std::collections::BTreeMap;

use include_dir::{Dir, include_dir};

use longstep::domain::{self, Domain};
use longstep_core::diagnostic::Diagnostics;

use super::{Files, Suite, domain_name, load};

static SHIPPED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/suites");

/// The names of the shipped suites, sorted.
pub fn shipped_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = SHIPPED.dirs().filter_map(|dir| dir.path().to_str()).collect();
    names.sort_unstable();
    names
}

/// Loads the shipped suite with this name and its domain; none if there is no such suite.
///
/// ```
/// use longstep_eval::suite;
/// let (domain, suite) = suite::load_shipped("two-arms").unwrap().unwrap();
/// assert_eq!((domain.name.as_str(), suite.name.as_str()), ("household-dual", "two-arms"));
/// assert!(suite::load_shipped("three-arms").is_none());
/// ```
///
/// # Errors
///
/// None in practice: the tests load every shipped suite.
pub fn load_shipped(name: &str) -> Option<Result<(Domain, Suite), Diagnostics>> {
    let files = shipped(name)?;
    let domain = match domain_name(&files) {
        Ok(domain) => domain::shipped(&domain)?,
        Err(findings) => Err(findings),
    };
    Some(domain.and_then(|domain| {
        let suite = load(&files, &domain)?;
        Ok((domain, suite))
    }))
}

/// The files of the shipped suite with this name.
pub fn shipped(name: &str) -> Option<Files> {
    let folder = SHIPPED
        .get_dir(name)
        .filter(|dir| dir.path().components().count() == 1)?;
    let texts = |dir: &'static Dir<'static>, ending: &str| -> BTreeMap<String, String> {
        let named = dir.files().filter_map(|file| {
            let name = file.path().file_name()?.to_str()?;
            Some((name.strip_suffix(ending)?.to_owned(), file.contents_utf8()?.to_owned()))
        });
        named.collect()
    };
    let mut cases = texts(folder, ".toml");
    let suite = cases.remove("suite").unwrap_or_default();
    let scenes = SHIPPED.get_dir(folder.path().join("scenes"));
    Some(Files {
        folder: format!("suites/{name}/"),
        suite,
        cases: cases
            .into_iter()
            .map(|(name, text)| (format!("{name}.toml"), text))
            .collect(),
        scenes: scenes.map(|dir| texts(dir, ".json")).unwrap_or_default(),
    })
}
