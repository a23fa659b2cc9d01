//! The project file, `longstep.toml`: what the options of all commands in a folder are when they are not given.

use std::collections::HashMap;
use std::path::{Path, PathBuf};

use longstep::domain;
use longstep_core::diagnostic::{Diagnostic, Diagnostics, Position, nearest};
use longstep_files::read_text;
use toml::{Spanned, Value};

/// The name of the file.
pub(crate) const FILE: &str = "longstep.toml";

const KEYS: [&str; 6] = ["domain", "environment", "robot", "autonomy", "rules", "model"];

/// Returns the JSON Schema of the file.
pub(crate) fn schema() -> serde_json::Value {
    let about = [
        "The domain: the name of a shipped one, or a folder.",
        "The environment.",
        "The robot: sim, process:COMMAND, ros2:ROBOT.toml or virtualhome:URL.",
        "The file of levels and limits.",
        "The file of rules that bind every plan.",
        "The model.",
    ];
    let key = |(key, about): (&str, &str)| {
        let schema = serde_json::json!({"description": about, "type": "string", "pattern": "\\S"});
        (key.to_owned(), schema)
    };
    serde_json::json!({
        "$schema": "http://json-schema.org/draft-07/schema#",
        "title": "The options of a Longstep project: longstep.toml",
        "type": "object",
        "properties": KEYS.into_iter().zip(about).map(key).collect::<serde_json::Map<_, _>>(),
        "additionalProperties": false,
    })
}

/// The content of a project file, with its paths as seen from the working folder.
#[derive(Debug, Default, PartialEq, Eq)]
pub(crate) struct Project {
    /// The file as it is named to a person.
    pub(crate) shown: String,
    pub(crate) domain: Option<String>,
    pub(crate) environment: Option<PathBuf>,
    pub(crate) robot: Option<String>,
    pub(crate) autonomy: Option<PathBuf>,
    pub(crate) rules: Option<PathBuf>,
    pub(crate) model: Option<String>,
}

impl Project {
    /// Reads the project file of the working folder: the one in it, or in the nearest folder above it, up to the home folder or
    /// the root of a repository. None if there is no file.
    ///
    /// # Errors
    ///
    /// A file that cannot be read, and keys or values that mean nothing in it.
    pub(crate) fn find() -> anyhow::Result<Option<Self>> {
        let Ok(working) = std::env::current_dir() else {
            return Ok(None);
        };
        let home = std::env::home_dir();
        let found = folders(&working, home.as_deref())
            .into_iter()
            .find(|folder| folder.join(FILE).is_file());
        let Some(folder) = found else { return Ok(None) };
        let folder = if folder == working { Path::new("") } else { folder };
        let file = folder.join(FILE);
        let is_folder = |name: &str| Path::new(name).is_dir();
        Ok(Some(Self::parse(&file, &read_text(&file)?, &is_folder)?))
    }

    /// Reads the text of the file; `is_folder` tells whether a path as seen from the working folder is a folder.
    fn parse(file: &Path, text: &str, is_folder: &dyn Fn(&str) -> bool) -> Result<Self, Diagnostics> {
        let shown = file.display().to_string();
        let at = |offset: usize, message: String| Diagnostic::at(&shown, Position::of(text, offset), message);
        let entries: HashMap<Spanned<String>, Spanned<Value>> = toml::from_str(text).map_err(|error| {
            let message = error.message().trim().replace('\n', "; ");
            Diagnostics(vec![at(error.span().map_or(0, |span| span.start), message)])
        })?;
        let mut project = Self {
            shown: shown.clone(),
            ..Self::default()
        };
        let folder = file.parent().unwrap_or(Path::new(""));
        let mut findings = Vec::new();
        for (key, value) in &entries {
            let Some(name) = KEYS.iter().find(|known| *known == key.get_ref()) else {
                findings.push(unknown_key(
                    at(key.span().start, format!("unknown key `{}`", key.get_ref())),
                    key.get_ref(),
                ));
                continue;
            };
            match value.get_ref().as_str().filter(|text| !text.trim().is_empty()) {
                Some(text) => {
                    project.set(name, folder, text.trim());
                    let domain = project.domain.as_deref().filter(|_| *name == "domain");
                    let missing = domain.filter(|own| !domain::shipped_names().contains(own) && !is_folder(own));
                    findings.extend(missing.map(|path| {
                        at(value.span().start, format!("there is no domain folder `{path}`")).hint(domain_hint(text))
                    }));
                }
                None => findings.push(
                    at(value.span().start, format!("`{name}` has to be a text"))
                        .hint(format!("write it in quotes: {name} = \"...\"")),
                ),
            }
        }
        if findings.is_empty() {
            Ok(project)
        } else {
            Err(Diagnostics::sorted(findings))
        }
    }

    fn set(&mut self, key: &str, folder: &Path, text: &str) {
        match key {
            "domain" => self.domain = Some(domain_in(folder, text)),
            "environment" => self.environment = Some(folder.join(text)),
            "robot" => self.robot = Some(robot_in(folder, text)),
            "autonomy" => self.autonomy = Some(folder.join(text)),
            "rules" => self.rules = Some(folder.join(text)),
            _ => self.model = Some(model_in(folder, text)),
        }
    }
}

fn unknown_key(finding: Diagnostic, key: &str) -> Diagnostic {
    finding.hint(match nearest(key, KEYS) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("the keys are {}", KEYS.join(", ")),
    })
}

/// Returns the hint for a domain that is not there.
fn domain_hint(text: &str) -> String {
    let shipped = domain::shipped_names();
    match nearest(text, shipped.iter().copied()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("it is a folder beside this file, or one of {}", shipped.join(", ")),
    }
}

/// The folders in which a project file counts: the working folder, and those above it up to the home folder or the root of a
/// repository. Outside of both only the working folder counts, because others may write to the folders above it.
fn folders<'a>(working: &'a Path, home: Option<&Path>) -> Vec<&'a Path> {
    let all: Vec<&Path> = working.ancestors().collect();
    let is_end = |folder: &&Path| home == Some(*folder) || folder.join(".git").exists();
    match all.iter().position(is_end) {
        Some(end) => all[..=end].to_vec(),
        None => vec![working],
    }
}

/// A shipped domain keeps its name; any other one is a folder beside the file.
fn domain_in(folder: &Path, text: &str) -> String {
    if domain::shipped_names().contains(&text) {
        text.to_owned()
    } else {
        folder.join(text).display().to_string()
    }
}

/// A `robot.toml` is a file beside the project file. A command is run as it is written.
fn robot_in(folder: &Path, text: &str) -> String {
    match text.strip_prefix("ros2:") {
        Some(file) => format!("ros2:{}", folder.join(file).display()),
        None => text.to_owned(),
    }
}

/// The file of a model, or of recorded replies, is a file beside the project file.
fn model_in(folder: &Path, text: &str) -> String {
    match text.strip_prefix("replay:") {
        Some(file) => format!("replay:{}", folder.join(file).display()),
        None if text.ends_with(".gguf") => folder.join(text).display().to_string(),
        None => text.to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn parsed(text: &str) -> Result<Project, String> {
        Project::parse(Path::new("up/longstep.toml"), text, &|own| own != "up/hosehold")
            .map_err(|findings| findings.to_string())
    }

    #[test]
    fn paths_are_relative_to_the_file() {
        let text = "domain = \"porter\"\nenvironment = \"kitchen.json\"\nrobot = \"ros2:robot.toml\"\n\
                    autonomy = \"autonomy.toml\"\nrules = \"rules.txt\"\nmodel = \"replay:said.json\"\n";
        let expected = Project {
            shown: "up/longstep.toml".to_owned(),
            domain: Some("up/porter".to_owned()),
            environment: Some("up/kitchen.json".into()),
            robot: Some("ros2:up/robot.toml".to_owned()),
            autonomy: Some("up/autonomy.toml".into()),
            rules: Some("up/rules.txt".into()),
            model: Some("replay:up/said.json".to_owned()),
        };
        assert_eq!(parsed(text).unwrap(), expected);
        let names = parsed("domain = \"household\"\nrobot = \"process:python3 r.py\"\nmodel = \"openai:x\"").unwrap();
        assert_eq!(names.domain.as_deref(), Some("household"));
        assert_eq!(names.robot.as_deref(), Some("process:python3 r.py"));
        assert_eq!(names.model.as_deref(), Some("openai:x"));
    }

    #[test]
    fn project_file_rejects_unknown_keys_and_wrong_types_with_position() {
        for (text, expected) in [
            (
                "domain = \"porter\"\nenviroment = \"a.json\"",
                "up/longstep.toml:2:1: unknown key `enviroment`\n  hint: did you mean `environment`?",
            ),
            (
                "colour = \"red\"",
                "up/longstep.toml:1:1: unknown key `colour`\n  hint: the keys are domain, environment, robot, autonomy, rules, model",
            ),
            (
                "\nrules = [\"a\"]",
                "up/longstep.toml:2:9: `rules` has to be a text\n  hint: write it in quotes: rules = \"...\"",
            ),
            (
                "model = \" \"",
                "up/longstep.toml:1:9: `model` has to be a text\n  hint: write it in quotes: model = \"...\"",
            ),
        ] {
            assert_eq!(parsed(text).unwrap_err(), expected);
        }
        for text in ["domain", "domain = 1\ndomain = 2", "[domain", "\u{0}"] {
            assert!(parsed(text).unwrap_err().starts_with("up/longstep.toml:"), "{text}");
        }
    }

    #[test]
    fn project_file_search_ends_at_home_or_repository() {
        let root = tempfile::tempdir().unwrap();
        let deep = root.path().join("home/repository/part");
        std::fs::create_dir_all(&deep).unwrap();
        let home = root.path().join("home");
        let repository = home.join("repository");
        assert_eq!(folders(&deep, Some(&home)), [&*deep, &*repository, &*home]);
        assert_eq!(folders(&deep, None), [&*deep]);
        std::fs::create_dir(repository.join(".git")).unwrap();
        assert_eq!(folders(&deep, Some(&home)), [&*deep, &*repository]);
    }
}
