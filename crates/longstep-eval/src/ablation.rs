//! Ablations: a domain with changed texts, to measure the effect of the change.
//!
//! The paper attributes two of its failure patterns to the prompt: `Put` and `PutIn` have similar names, and a single
//! example does not show the granularity of steps. Both changes are made in a domain's texts before it is loaded, so
//! that prompt, grammar and parser change together.

use longstep::domain::Files;
use sha2::{Digest, Sha256};

/// Changes of a domain's texts.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Changes {
    /// Names of calls, and their new names.
    pub renamed: Vec<(String, String)>,
    /// Number of worked examples to keep.
    pub examples: Option<usize>,
}

/// Reason why a change is not possible.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum AblationError {
    /// No action has this name.
    #[error("no action of the domain is called `{0}`")]
    NoSuchCall(String),
    /// The new name is not an identifier.
    #[error("`{0}` is not a name for an action: use letters, digits and `_`, and no digit first")]
    NoWord(String),
    /// The examples cannot be read.
    #[error("{file} cannot be read: {reason}")]
    Examples {
        /// The file.
        file: &'static str,
        /// The reason.
        reason: String,
    },
}

impl Changes {
    /// Changes the texts of a domain; returns a description of each change.
    ///
    /// ```
    /// use longstep::domain::shipped_files;
    /// use longstep_eval::Changes;
    /// let mut files = shipped_files("virtualhome").unwrap();
    /// let changes = Changes { renamed: vec![("PutIn".to_owned(), "PutInside".to_owned())], examples: Some(1) };
    /// assert_eq!(changes.apply(&mut files)?, ["PutIn is called PutInside", "1 example at most"]);
    /// assert!(files.words.contains("PutInside(?item, ?container)"));
    /// # Ok::<(), longstep_eval::AblationError>(())
    /// ```
    ///
    /// # Errors
    ///
    /// When there is no such call, or when the examples are not TOML.
    pub fn apply(&self, files: &mut Files) -> Result<Vec<String>, AblationError> {
        let mut changes = Vec::new();
        for (from, to) in &self.renamed {
            if !is_word(to) {
                return Err(AblationError::NoWord(to.clone()));
            }
            if !is_word(from) || !files.words.contains(&format!("\"{from}(")) {
                return Err(AblationError::NoSuchCall(from.clone()));
            }
            for text in [&mut files.words, &mut files.feedback]
                .into_iter()
                .chain(files.parts.values_mut())
            {
                *text = renamed(text, from, to);
            }
            changes.push(format!("{from} is called {to}"));
        }
        if let Some(most) = self.examples {
            files.examples = first_examples("prompt/examples.toml", &files.examples, most)?;
            if let Some(plans) = files.parts.get_mut("plans.toml") {
                *plans = first_examples("prompt/plans.toml", plans, most)?;
            }
            let examples = if most == 1 { "example" } else { "examples" };
            changes.push(format!("{most} {examples} at most"));
        }
        Ok(changes)
    }
}

fn is_word(text: &str) -> bool {
    let first = text.chars().next();
    first.is_some_and(|first| first.is_ascii_alphabetic() || first == '_')
        && text.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Renames every call of `from`. The bare word may be English ("Put the cup ...") and stays.
fn renamed(text: &str, from: &str, to: &str) -> String {
    let call = format!("{from}(");
    let mut out = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(at) = rest.find(&call) {
        let before = rest[..at].chars().next_back();
        out.push_str(&rest[..at]);
        let inside = before.is_some_and(|c| c.is_alphanumeric() || c == '_');
        out.push_str(if inside { from } else { to });
        out.push('(');
        rest = &rest[at + call.len()..];
    }
    out.push_str(rest);
    out
}

fn first_examples(file: &'static str, text: &str, most: usize) -> Result<String, AblationError> {
    let unreadable = |reason: String| AblationError::Examples { file, reason };
    let mut table: toml::Table = text
        .parse()
        .map_err(|error: toml::de::Error| unreadable(error.message().to_owned()))?;
    if let Some(toml::Value::Array(examples)) = table.get_mut("example") {
        examples.truncate(most);
    }
    toml::to_string(&table).map_err(|error| unreadable(error.to_string()))
}

/// SHA-256 of texts with their names, in hexadecimal digits.
pub(crate) fn digest<'a>(texts: impl IntoIterator<Item = (&'a str, &'a str)>) -> String {
    let mut hash = Sha256::new();
    for (name, text) in texts {
        hash.update(format!("{name}\n{}\n", text.len()));
        hash.update(text);
    }
    hash.finalize().iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a file, in hexadecimal digits.
pub fn sha256(bytes: &[u8]) -> String {
    Sha256::digest(bytes).iter().map(|byte| format!("{byte:02x}")).collect()
}

/// SHA-256 of a domain's files.
pub fn domain_sha256(files: &Files) -> String {
    let own = [
        ("domain.pddl", files.pddl.as_str()),
        ("domain.toml", &files.words),
        ("goal.md", &files.goal_prompt),
        ("examples.toml", &files.examples),
        ("feedback.toml", &files.feedback),
    ];
    let parts = files.parts.iter().map(|(name, text)| (name.as_str(), text.as_str()));
    digest(own.into_iter().chain(parts))
}
