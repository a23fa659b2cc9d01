//! Readings: how words were understood, for people who want to see it.

use serde::{Deserialize, Serialize};

/// A reading of words by a model, with the answers that were weighed.
///
/// ```
/// use longstep::dialogue::{Candidate, Doubt, Reading, ReadingOf};
/// let reading = Reading {
///     of: ReadingOf::Wish,
///     words: "tidy the pen".to_owned(),
///     candidates: vec![Candidate { text: "put(pen, desk)".to_owned(), likelihood: Some(-5.5), chosen: true }],
///     least: Some(-3.7),
///     doubt: Some(Doubt::Unlikely),
/// };
/// assert_eq!(reading.lines(), [
///     "the wish \"tidy the pen\"",
///     "  -5.5  put(pen, desk)  chosen",
///     "  a question: it is less likely than -3.7",
/// ]);
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Reading {
    /// The purpose of the words.
    pub of: ReadingOf,
    /// The words: the instruction, a part of it, or what it was retold as.
    pub words: String,
    /// The answers of the model, in the order in which they were made.
    pub candidates: Vec<Candidate>,
    /// Natural logarithm of the probability below which an answer is doubted; none if likelihoods decide nothing here.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub least: Option<f64>,
    /// The reason why the chosen answer was not acted on, if there is one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<Doubt>,
}

/// The purpose of words that were read.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum ReadingOf {
    /// They ask for goals.
    Wish,
    /// They say what must not be done.
    Prohibition,
    /// They are retold in plain English.
    Retelling,
    /// They may have a message to somebody.
    Message,
    /// Answers to them are weighed, in each of their wordings.
    Weighing,
}

/// An answer of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Candidate {
    /// The goals in the goal language, the question, or the plain English.
    pub text: String,
    /// Natural logarithm of its probability, to thousandths; none if the model does not give it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub likelihood: Option<f64>,
    /// True for the answer that was chosen.
    pub chosen: bool,
}

/// A reason not to act on an answer.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Doubt {
    /// The model finds it unlikely.
    Unlikely,
    /// The model finds another answer nearly as likely.
    Close,
    /// A goal is about an entity that the words do not name, although they name others.
    Unnamed,
    /// Several entities fit the words.
    Several,
    /// The answer has no goal.
    NoGoal,
    /// The model asks back.
    Asks,
    /// A part of the instruction is not represented.
    NotRepresented,
    /// The instruction forbids something, and the answer does not.
    ForgetsProhibition,
    /// Only a retelling that the model is not sure of leads to it.
    OnlyRetold,
    /// There is no plan for it, or none was found.
    NoPlan,
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

    /// Returns the reading as lines for people: the words, each answer with its likelihood, and the doubt.
    pub fn lines(&self) -> Vec<String> {
        let of = match self.of {
            ReadingOf::Wish => "the wish",
            ReadingOf::Prohibition => "what is forbidden:",
            ReadingOf::Retelling => "in plain English:",
            ReadingOf::Message => "is somebody told something in",
            ReadingOf::Weighing => "weighed for",
        };
        let mut lines = vec![format!("{of} \"{}\"", self.words)];
        for candidate in &self.candidates {
            let likelihood = candidate
                .likelihood
                .map_or("   ?".to_owned(), |value| format!("{value:>4.1}"));
            let chosen = if candidate.chosen { "  chosen" } else { "" };
            lines.push(format!("  {likelihood}  {}{chosen}", candidate.text));
        }
        lines.extend(self.doubt.map(|doubt| format!("  {}", self.because(doubt))));
        lines
    }

    fn because(&self, doubt: Doubt) -> String {
        let least = self.least.map_or(String::new(), |least| format!(" than {least:.1}"));
        match (doubt, self.of) {
            (Doubt::Unlikely, ReadingOf::Retelling) => format!("not used: it is less likely{least}"),
            (Doubt::Unlikely, ReadingOf::Message) => "no message: that nobody is told anything is likelier".to_owned(),
            (Doubt::Unlikely, _) => format!("a question: it is less likely{least}"),
            (Doubt::Close, _) => "a question: another answer is nearly as likely".to_owned(),
            (Doubt::Unnamed, _) => "a question: a goal is about something that the words do not name".to_owned(),
            (Doubt::Several, _) => "a question: several things fit the words".to_owned(),
            (Doubt::NoGoal, _) => "a question: there is no goal".to_owned(),
            (Doubt::Asks, _) => "the model asks back".to_owned(),
            (Doubt::NotRepresented, _) => "a question: a part of the words is not in the goal".to_owned(),
            (Doubt::ForgetsProhibition, _) => "not used: it lacks what the instruction forbids".to_owned(),
            (Doubt::OnlyRetold, _) => "a question: the model is not sure of the words that show it".to_owned(),
            (Doubt::NoPlan, _) => "there is no plan".to_owned(),
        }
    }
}

/// Converts thousandths of a nat to nats.
#[expect(clippy::cast_precision_loss, reason = "a likelihood is far from the bounds")]
pub(crate) fn nats(thousandths: i64) -> f64 {
    thousandths as f64 / 1000.0
}
