//! Readings: how words were understood, for people who want to see it.

use serde::{Deserialize, Serialize};

/// A reading of words by a model, with the answers that were looked at.
///
/// ```
/// use longstep::dialogue::{Candidate, Decision, Reading};
/// let reading = Reading {
///     words: "tidy the pen".to_owned(),
///     candidates: vec![Candidate { text: "put(pen, desk)".to_owned(), likelihood: Some(-5.5), chosen: true }],
///     profile: "trained".to_owned(),
///     decision: Decision::AskForUnlikely,
///     least: Some(-0.7),
/// };
/// assert_eq!(reading.lines(), [
///     "\"tidy the pen\"",
///     "  -5.5  put(pen, desk)  chosen",
///     "  a question: it is less likely than -0.7 (trained)",
/// ]);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The words.
    pub words: String,
    /// The answers of the model, in the order in which they were made.
    pub candidates: Vec<Candidate>,
    /// The name of the profile that decided.
    #[serde(default)]
    pub profile: String,
    /// Its row that decided.
    #[serde(default)]
    pub decision: Decision,
    /// The limit in that row: the natural logarithm of a probability; none if likelihoods decide nothing there.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
}

/// The row of the table that decided.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Decision {
    /// The goal is likely enough, or the model is believed.
    #[default]
    Act,
    /// The goal is not likely, and no other one is nearly as likely.
    ActOnOnly,
    /// The model would ask, and its best goal is likely enough.
    ActInsteadOfAsking,
    /// The goal is not likely enough.
    AskForUnlikely,
    /// The model asks.
    Ask,
    /// Several things fit the words.
    AskWhich,
    /// The goal forbids nothing, and a prohibition behind it is not unlikely.
    AskForProhibition,
}

impl Decision {
    /// Returns true if the goal is acted on.
    pub fn acts(self) -> bool {
        matches!(self, Self::Act | Self::ActOnOnly | Self::ActInsteadOfAsking)
    }
}

/// An answer of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The goal in the goal language, with the words left out, or a question.
    pub text: String,
    /// Natural logarithm of its probability, to thousandths; none if the model does not give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub likelihood: Option<f64>,
    /// True for the answer that was chosen.
    pub chosen: bool,
}

impl Candidate {
    /// Creates an answer that was not chosen; its likelihood is in thousandths.
    pub(crate) fn new(text: String, thousandths: Option<i64>) -> Self {
        Self {
            text,
            likelihood: thousandths.map(nats),
            chosen: false,
        }
    }
}

impl Reading {
    /// Returns the answer that was chosen, if one was.
    pub fn chosen(&self) -> Option<&Candidate> {
        self.candidates.iter().find(|candidate| candidate.chosen)
    }

    /// Returns the reading as lines for people: the words, each answer with its likelihood, and the row that decided.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!("\"{}\"", self.words)];
        for candidate in &self.candidates {
            let likelihood = candidate
                .likelihood
                .map_or("   ?".to_owned(), |value| format!("{value:>4.1}"));
            let chosen = if candidate.chosen { "  chosen" } else { "" };
            lines.push(format!("  {likelihood}  {}{chosen}", candidate.text));
        }
        let than = self.least.map_or(String::new(), |least| format!(" than {least:.1}"));
        let why = match self.decision {
            Decision::Act if self.least.is_none() => "acted on: the model is believed".to_owned(),
            Decision::Act => format!("acted on: it is not less likely{than}"),
            Decision::ActOnOnly => {
                format!("acted on: no other answer is nearly as likely, and it is not less likely{than}")
            }
            Decision::ActInsteadOfAsking => format!("acted on, although the model asks: it is not less likely{than}"),
            Decision::AskForUnlikely => format!("a question: it is less likely{than}"),
            Decision::Ask => "a question: the model asks".to_owned(),
            Decision::AskWhich => "a question: several things fit the words".to_owned(),
            Decision::AskForProhibition => {
                format!("a question: a prohibition that the answer lacks is not less likely{than}")
            }
        };
        lines.push(format!("  {why} ({})", self.profile));
        lines
    }
}

/// Converts thousandths of a nat to nats.
#[expect(clippy::cast_precision_loss, reason = "a likelihood is far from the bounds")]
pub(crate) fn nats(thousandths: i64) -> f64 {
    thousandths as f64 / 1000.0
}
