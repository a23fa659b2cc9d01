//! The files of a domain.

use std::collections::BTreeMap;

use super::read_toml;
use super::words::SkillsFile;
use crate::diagnostic::{Diagnostic, Diagnostics, nearest};

/// The texts of a domain's files, with their names for diagnostics.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// The prefix of file names in diagnostics, for example `domains/household/`.
    pub folder: String,
    /// `domain.pddl`
    pub pddl: String,
    /// `domain.toml`
    pub words: String,
    /// The path and the text of `skills.toml`; none if there is none.
    pub skills: Option<(String, String)>,
    /// `prompt/goal.md`
    pub goal_prompt: String,
    /// `prompt/examples.toml`
    pub examples: String,
    /// `prompt/feedback.toml`; empty if there is none.
    pub feedback: String,
    /// The other files of `prompt/`, by name. Each replaces the library's default for one of [`Files::PARTS`].
    pub parts: BTreeMap<String, String>,
    /// The paths of files outside the folder, by their names within `prompt/`.
    pub elsewhere: BTreeMap<String, String>,
}

impl Files {
    /// The files of `prompt/` that the goal strategy needs. Only `feedback.toml` is optional.
    pub const GOAL: [&str; 3] = ["goal.md", "examples.toml", "feedback.toml"];

    /// The files of `prompt/` that the direct strategy needs, all optional.
    pub const PARTS: [&str; 6] = [
        "role.md",
        "actions.md",
        "environment.md",
        "format.md",
        "plans.toml",
        "query.md",
    ];

    /// Collects the texts of a domain's folder, given by their paths within it: `domain.pddl`, `domain.toml`,
    /// `skills.toml` and the files of `prompt/`. Other files belong to no domain and are left out; a file that is missing is an empty text.
    ///
    /// ```
    /// use longstep_model::domain::{Files, load, starter};
    /// let files = Files::from_texts("porter/", starter("porter"));
    /// assert_eq!(load(&files).unwrap().name, "porter");
    /// ```
    pub fn from_texts(folder: impl Into<String>, texts: impl IntoIterator<Item = (String, String)>) -> Self {
        let mut files = Self {
            folder: folder.into(),
            ..Self::default()
        };
        for (path, text) in texts {
            match path.strip_prefix("prompt/") {
                Some(name) => files.set_prompt(name, text),
                None if path == "domain.pddl" => files.pddl = text,
                None if path == "domain.toml" => files.words = text,
                None if path == "skills.toml" => files.skills = Some((format!("{}{path}", files.folder), text)),
                None => {}
            }
        }
        files
    }

    /// Returns the domain that a `skills.toml` extends, by its name; none if it belongs to the domain of its own folder.
    ///
    /// ```
    /// use longstep_model::domain::Files;
    /// let text = "name = \"kitchen\"\nbase = \"household\"";
    /// assert_eq!(Files::base_of("kitchen/skills.toml", text).unwrap().as_deref(), Some("household"));
    /// ```
    ///
    /// # Errors
    ///
    /// A text that is no `skills.toml`, and a base without a name for the new domain.
    pub fn base_of(path: &str, text: &str) -> Result<Option<String>, Diagnostics> {
        let mut findings = Vec::new();
        let file: Option<SkillsFile> = read_toml(path, text, &mut findings);
        match file {
            Some(file) if file.base.is_some() && file.name.is_none() => {
                let message = "a `skills.toml` with a `base` has a `name` of its own";
                Err(Diagnostics(vec![Diagnostic::whole(path, message.to_owned())]))
            }
            Some(file) => Ok(file.base),
            None => Err(Diagnostics::sorted(findings)),
        }
    }

    /// Sets the text of a file of `prompt/`.
    fn set_prompt(&mut self, name: &str, text: String) {
        match name {
            "goal.md" => self.goal_prompt = text,
            "examples.toml" => self.examples = text,
            "feedback.toml" => self.feedback = text,
            _ => {
                self.parts.insert(name.to_owned(), text);
            }
        }
    }

    /// Replaces files of `prompt/` by those of another folder, for users who adapt the prompts of a shipped domain.
    ///
    /// `folder` is the prefix of the file names in diagnostics; `texts` are pairs of a name within it and its text.
    ///
    /// ```
    /// use longstep_model::domain::shipped_files;
    /// let mut files = shipped_files("household").unwrap();
    /// let role = ("role.md".to_owned(), "You plan for a robot in a bakery.".to_owned());
    /// files.overlay("bakery/", [role]).unwrap();
    /// assert_eq!(files.prompt_path("role.md"), "bakery/role.md");
    ///
    /// let findings = files.overlay("bakery/", [("rolle.md".to_owned(), String::new())]).unwrap_err();
    /// assert!(findings.to_string().ends_with("hint: did you mean `role.md`?"));
    /// ```
    ///
    /// # Errors
    ///
    /// Names that are not files of `prompt/`; in that case no file is replaced.
    pub fn overlay(
        &mut self,
        folder: &str,
        texts: impl IntoIterator<Item = (String, String)>,
    ) -> Result<(), Diagnostics> {
        let texts: Vec<(String, String)> = texts.into_iter().collect();
        let unknown: Vec<Diagnostic> = texts
            .iter()
            .filter_map(|(name, _)| unknown_name(&format!("{folder}{name}"), name))
            .collect();
        if !unknown.is_empty() {
            return Err(Diagnostics::sorted(unknown));
        }
        for (name, text) in texts {
            self.elsewhere.insert(name.clone(), format!("{folder}{name}"));
            self.set_prompt(&name, text);
        }
        Ok(())
    }

    /// Returns the path of a file of `prompt/` for diagnostics.
    pub fn prompt_path(&self, name: &str) -> String {
        match self.elsewhere.get(name) {
            Some(path) => path.clone(),
            None => format!("{}prompt/{name}", self.folder),
        }
    }

    /// Reports files of `prompt/` with unknown names.
    pub fn unknown_parts(&self) -> impl Iterator<Item = Diagnostic> + '_ {
        let names = self.parts.keys();
        names.filter_map(|name| unknown_name(&self.prompt_path(name), name))
    }
}

/// Returns the diagnostic for a file of `prompt/` with an unknown name; none for a known one.
fn unknown_name(path: &str, name: &str) -> Option<Diagnostic> {
    let known = || Files::PARTS.into_iter().chain(Files::GOAL);
    if known().any(|other| other == name) {
        return None;
    }
    let hint = match nearest(name, known()) {
        Some(near) => format!("did you mean `{near}`?"),
        None => format!("known are {}", known().collect::<Vec<_>>().join(", ")),
    };
    Some(Diagnostic::whole(path, format!("nothing reads a file `{name}`")).hint(hint))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn check(name: &str, expected: &str) {
        let found = unknown_name("mine/x", name).map(|finding| finding.hint.unwrap_or_default());
        assert_eq!(found.as_deref().unwrap_or("known"), expected);
    }

    #[test]
    fn prompt_file_names_are_checked_with_suggestions() {
        check("role.md", "known");
        check("goal.md", "known");
        check("Role.md", "did you mean `role.md`?");
        check("querry.md", "did you mean `query.md`?");
        check("plan.toml", "did you mean `plans.toml`?");
        check(
            "notes.txt",
            "known are role.md, actions.md, environment.md, format.md, plans.toml, query.md, goal.md, examples.toml, \
             feedback.toml",
        );
    }

    #[test]
    fn overlay_replaces_all_prompt_files_or_none() {
        let text = |name: &str| (name.to_owned(), format!("the new {name}"));
        let mut files = Files {
            folder: "domains/x/".to_owned(),
            ..Files::default()
        };
        assert!(files.overlay("mine/", [text("role.md"), text("rule.txt")]).is_err());
        assert!(files.parts.is_empty());
        files.overlay("mine/", [text("role.md"), text("goal.md")]).unwrap();
        assert_eq!(files.parts["role.md"], "the new role.md");
        assert_eq!(files.goal_prompt, "the new goal.md");
        assert_eq!(files.prompt_path("goal.md"), "mine/goal.md");
        assert_eq!(files.prompt_path("query.md"), "domains/x/prompt/query.md");
    }
}
