//! The domains shipped with the library.

use include_dir::{Dir, include_dir};

use super::{Domain, Files, load};
use crate::diagnostic::Diagnostics;

static SHIPPED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/../../domains");

/// Returns the names of the shipped domains, sorted.
pub fn shipped_names() -> Vec<&'static str> {
    let mut names: Vec<&str> = SHIPPED.dirs().filter_map(|dir| dir.path().to_str()).collect();
    names.sort_unstable();
    names
}

/// Loads the shipped domain of that name; none if there is none.
///
/// # Errors
///
/// None for unmodified domains; the tests load each of them.
pub fn shipped(name: &str) -> Option<Result<Domain, Diagnostics>> {
    Some(load(&shipped_files(name)?))
}

/// Returns the files of the shipped domain of that name; none if there is none.
pub fn shipped_files(name: &str) -> Option<Files> {
    let folder = SHIPPED
        .get_dir(name)
        .filter(|dir| dir.path().components().count() == 1)?;
    let files = std::iter::once(folder).chain(folder.dirs()).flat_map(Dir::files);
    let texts = files.filter_map(|file| {
        let path = file.path().strip_prefix(name).ok()?.to_str()?;
        Some((path.to_owned(), file.contents_utf8()?.to_owned()))
    });
    Some(Files::from_texts(format!("domains/{name}/"), texts))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shipped_domain_loads() {
        for name in shipped_names() {
            let domain = shipped(name).unwrap().unwrap_or_else(|findings| panic!("{findings}"));
            assert_eq!(domain.name, name);
        }
        assert!(shipped("garage").is_none());
        assert!(shipped("household/prompt").is_none());
    }
}
