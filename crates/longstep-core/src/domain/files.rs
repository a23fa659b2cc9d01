//! The texts that a domain is read from.

use std::collections::BTreeMap;

use crate::diagnostic::{Diagnostic, Diagnostics, nearest};

/// The texts of a domain's folder, and the names to call them in findings.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Files {
    /// Put before the names of the files in findings, for example `domains/household/`.
    pub folder: String,
    /// `domain.pddl`
    pub pddl: String,
    /// `domain.toml`
    pub words: String,
    /// `prompt/goal.md`
    pub goal_prompt: String,
    /// `prompt/examples.toml`
    pub examples: String,
    /// `prompt/feedback.toml`; empty if there is none.
    pub feedback: String,
    /// The other files of `prompt/`, by name: [`Files::PARTS`] that the library's own are replaced by. What is not
    /// here is taken from the library.
    pub parts: BTreeMap<String, String>,
    /// The paths of files that lie elsewhere than in the folder, by their names within `prompt/`.
    pub elsewhere: BTreeMap<String, String>,
}

impl Files {
    /// The files of `prompt/` that the goal strategy needs. Every domain has its own, but for `feedback.toml`, which
    /// it may leave out.
    pub const GOAL: [&str; 3] = ["goal.md", "examples.toml", "feedback.toml"];

    /// The files of `prompt/` that the direct strategy needs. A domain may leave each of them out.
    pub const PARTS: [&str; 6] = [
        "role.md",
        "actions.md",
        "environment.md",
        "format.md",
        "plans.toml",
        "query.md",
    ];

    /// Replaces files of `prompt/` by those of another folder, which somebody keeps for a domain that is not theirs.
    ///
    /// `folder` is put before the names in findings; `texts` are names within it, and what the files say.
    ///
    /// ```
    /// use longstep_core::domain::shipped_files;
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
    /// Names that no file of `prompt/` has; then nothing is replaced.
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
            match name.as_str() {
                "goal.md" => self.goal_prompt = text,
                "examples.toml" => self.examples = text,
                "feedback.toml" => self.feedback = text,
                _ => {
                    self.parts.insert(name, text);
                }
            }
        }
        Ok(())
    }

    /// What findings call a file of `prompt/`.
    pub fn prompt_path(&self, name: &str) -> String {
        match self.elsewhere.get(name) {
            Some(path) => path.clone(),
            None => format!("{}prompt/{name}", self.folder),
        }
    }

    /// Files of `prompt/` that nothing reads.
    pub fn unknown_parts(&self) -> impl Iterator<Item = Diagnostic> + '_ {
        let names = self.parts.keys();
        names.filter_map(|name| unknown_name(&self.prompt_path(name), name))
    }
}

/// What to say of a file of `prompt/` that nothing reads; none if something does.
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
    fn names_that_nothing_reads_are_told_with_what_was_meant() {
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
    fn an_overlay_replaces_all_or_nothing() {
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
