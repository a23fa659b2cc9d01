//! The domains shipped with the library.

use include_dir::{Dir, include_dir};

use super::{Domain, Files, load};
use crate::diagnostic::Diagnostics;

static SHIPPED: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/domains");

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
    let files = Files::from_texts(format!("domains/{name}/"), texts);
    let base = match &files.skills {
        Some((path, text)) => Files::base_of(path, text).ok().flatten(),
        None => None,
    };
    match base {
        Some(base) if base != name => Some(Files {
            skills: files.skills,
            ..shipped_files(&base)?
        }),
        _ => Some(files),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn mistakes_in_skills_are_reported_in_their_file() {
        for (text, expected) in [
            (
                "[[action]]\nname = \"grsp\"",
                "kitchen/skills.toml:2:9: unknown action `grsp`",
            ),
            (
                "[[action]]\nname = \"wipe\"\n[[action]]\nname = \"wipe\"",
                "has a second entry",
            ),
            (
                "[[action]]\nname = \"wipe\"\nskill = [{ name = \"a\", type = \"lever\", from = \"robot\" }]",
                "kitchen/skills.toml:3:32: unknown type",
            ),
            ("base = \"household\"\ncolour = 1", "unknown field `colour`"),
        ] {
            let files = Files {
                skills: Some(("kitchen/skills.toml".to_owned(), text.to_owned())),
                ..shipped_files("household").unwrap()
            };
            let found = load(&files).unwrap_err().to_string();
            assert!(found.contains(expected), "{text}: {found}");
        }
        let nameless = Files::base_of("kitchen/skills.toml", "base = \"household\"").unwrap_err();
        assert!(nameless.to_string().contains("has a `name` of its own"), "{nameless}");
    }

    #[test]
    fn every_shipped_domain_loads() {
        for name in shipped_names() {
            let domain = shipped(name).unwrap().unwrap_or_else(|findings| panic!("{findings}"));
            assert_eq!(domain.name, name);
        }
        assert!(shipped("garage").is_none());
        let taught = shipped("household-taught").unwrap().unwrap();
        let base = shipped("household").unwrap().unwrap();
        assert!(taught.actions.iter().all(|action| !action.skills.is_empty()));
        assert!(base.actions.iter().all(|action| action.skills.is_empty()));
        assert!(shipped("household/prompt").is_none());
    }
}
