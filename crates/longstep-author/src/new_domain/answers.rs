//! An author's answers about a robot, in words.
//!
//! A sentence names kinds of things: "the box is on the shelf". Its other words are the name of a predicate, so two
//! sentences with the same words mean the same fact. "another box" is a second thing of the kind, "no box" and "any box"
//! speak of all of them, and "not" turns a sentence into its opposite.

use serde::Deserialize;

use longstep::domain::read_toml;
use longstep_core::diagnostic::Diagnostics;

/// Returns the JSON Schema of `answers.toml`.
///
/// ```
/// assert!(longstep_author::answers_schema()["properties"]["action"].is_object());
/// ```
#[cfg(feature = "schema")]
pub fn answers_schema() -> serde_json::Value {
    longstep_core::schema::of::<Answers>("Answers about a robot for Longstep: answers.toml")
}

/// An author's answers about a robot.
#[derive(Debug, Clone, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct Answers {
    /// The name of the domain.
    pub name: String,
    /// The robot's name in the sentences; "robot" if it is missing.
    #[serde(default)]
    pub robot: Option<String>,
    /// One sentence about the robot.
    #[serde(default)]
    pub about: Option<String>,
    /// The kinds of things.
    #[serde(default)]
    pub kind: Vec<KindAnswer>,
    /// The actions.
    #[serde(default)]
    pub action: Vec<ActionAnswer>,
    /// The facts in the example environment, with the things of [`KindAnswer::examples`].
    #[serde(default)]
    pub start: Vec<String>,
}

/// A kind of things.
#[derive(Debug, Clone, Default, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct KindAnswer {
    /// Its name: "box".
    pub name: String,
    /// True for places and furniture, which stay where they are.
    #[serde(default)]
    pub stays: bool,
    /// Things of this kind for the example environment: "red box".
    #[serde(default)]
    pub examples: Vec<String>,
}

/// An action.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(deny_unknown_fields)]
pub struct ActionAnswer {
    /// The action in words: "put a box on a shelf".
    pub words: String,
    /// The conditions before it.
    #[serde(default)]
    pub needs: Vec<String>,
    /// The facts after it.
    pub then: Vec<String>,
    /// The facts that hold no longer; a default ([`guess_removed`](super::guess_removed)) if it is missing, nothing if it is empty.
    #[serde(default)]
    pub no_longer: Option<Vec<String>>,
}

impl Answers {
    /// Reads answers from a TOML file; `file` is its name in diagnostics.
    ///
    /// # Errors
    ///
    /// Every place that is not TOML in this form.
    ///
    /// ```
    /// use longstep_author::{Answers, from_answers};
    /// let text = r#"
    /// name = "porter"
    /// kind = [{ name = "box" }, { name = "shelf", stays = true }]
    /// [[action]]
    /// words = "pick up a box"
    /// needs = ["the box is on a shelf", "the robot holds no box"]
    /// then = ["the robot holds the box"]
    /// [[action]]
    /// words = "put a box on a shelf"
    /// needs = ["the robot holds the box"]
    /// then = ["the box is on the shelf"]
    /// "#;
    /// let new = from_answers(&Answers::read("answers.toml", text)?)?;
    /// assert_eq!(new.domain.actions.len(), 2);
    /// # Ok::<(), longstep::Diagnostics>(())
    /// ```
    pub fn read(file: &str, text: &str) -> Result<Self, Diagnostics> {
        let mut findings = Vec::new();
        match read_toml(file, text, &mut findings) {
            Some(answers) => Ok(answers),
            None => Err(Diagnostics::sorted(findings)),
        }
    }

    /// The robot's name in the sentences, without an article.
    pub(super) fn robot(&self) -> String {
        let name = self.robot.as_deref().unwrap_or("robot").trim().to_lowercase();
        name.strip_prefix("the ").map(str::to_owned).unwrap_or(name)
    }
}
