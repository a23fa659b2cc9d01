//! The template of a new domain.

use include_dir::{Dir, include_dir};

static STARTER: Dir<'_> = include_dir!("$CARGO_MANIFEST_DIR/src/domain/starter");

/// Returns the files of a new domain called `name`, as pairs of a path within its folder and a text.
///
/// ```
/// let files = longstep_model::domain::starter("porter");
/// assert!(files.iter().any(|(path, text)| path == "domain.toml" && text.contains("name = \"porter\"")));
/// ```
pub fn starter(name: &str) -> Vec<(String, String)> {
    let name = plain_name(name);
    let mut files = Vec::new();
    collect(&STARTER, &name, &mut files);
    files
}

fn collect(folder: &Dir<'_>, name: &str, files: &mut Vec<(String, String)>) {
    for file in folder.files() {
        if let (Some(path), Some(text)) = (file.path().to_str(), file.contents_utf8()) {
            files.push((path.to_owned(), text.replace("NAME", name)));
        }
    }
    for inner in folder.dirs() {
        collect(inner, name, files);
    }
}

/// Returns a name that is valid in both PDDL and TOML: lower-case letters, digits and hyphens.
pub fn plain_name(name: &str) -> String {
    let word = |c: char| {
        if c.is_ascii_alphanumeric() || c == '-' {
            c.to_ascii_lowercase()
        } else {
            '-'
        }
    };
    let mut name: String = name.chars().map(word).collect();
    if !name.starts_with(|c: char| c.is_ascii_lowercase()) {
        name.insert_str(0, "robot-");
    }
    name
}
