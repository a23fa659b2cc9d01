//! Retelling: what a person said, in plain English with the names of the environment.
//!
//! The prompts and names of a domain are mostly English, and people speak other languages, dialects and half sentences.
//! A small model translates better than it understands goals in a strange language, and the likelihood of its translation
//! tells whether it knew what it was doing.

use super::screening::fixed_turns;
use super::{
    Candidate, ChatRequest, ConstraintKind, Dialogue, DialogueError, Doubt, Reading, ReadingOf, Reply, Role, Task,
    Transcript, nats, plain_line,
};
use crate::environment::World;

/// The task in the first paragraph; then examples, each with its answer in the last line.
const PROMPT: &str = include_str!("retelling.txt");
/// Likelihood below which what a model says in plain English is not used, in thousandths of a nat (docs/experiments.md has the measurement).
pub(super) const SURE: i64 = -4500;
/// Likelihood below which it is not even compared with the instruction.
const WORTHLESS: i64 = -10_000;
/// Token budget of an answer.
const TOKENS: u32 = 128;
/// Maximum number of characters of an answer.
const LENGTH: usize = 300;

/// Lets a model retell an instruction. One request, one reply.
///
/// ```
/// use longstep::dialogue::{Dialogue, Likelihood, Reply, RetellingDialogue};
/// let planner = longstep::Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let mut dialogue = RetellingDialogue::new(&world, "Der Stift gehört ins Regal.");
/// let likelihood = Some(Likelihood { text: -2100, ..Likelihood::default() });
/// let text = "Put the pen on the shelf.";
/// let retold = dialogue.supply(&Reply { likelihood, ..Reply::complete(text) })?;
/// assert_eq!(retold.flatten().unwrap().text, "Put the pen on the shelf.");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct RetellingDialogue {
    instruction: String,
    transcript: Transcript,
    /// The plain English, as a reading.
    reading: Reading,
}

/// An instruction in plain English.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Retelling {
    /// The plain English.
    pub text: String,
    /// True if the model is sure of it; otherwise it counts only where the instruction itself agrees.
    pub is_sure: bool,
}

impl RetellingDialogue {
    /// Starts a dialogue about an instruction in a world.
    pub fn new(world: &World, instruction: &str) -> Self {
        let instruction = plain_line(instruction);
        let mut transcript = Transcript::new(ConstraintKind::Grammar, fixed_turns(PROMPT)).for_task(Task::Retelling);
        transcript.push(Role::User, question_of(world, &instruction));
        let reading = Reading {
            of: ReadingOf::Retelling,
            words: instruction.clone(),
            candidates: Vec::new(),
            least: Some(nats(SURE)),
            doubt: None,
        };
        Self {
            instruction,
            transcript,
            reading,
        }
    }

    /// Returns what the model said, with its likelihood.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }
}

impl Dialogue for RetellingDialogue {
    /// The retold instruction; none if it is worthless, or if it is what the person said.
    type Output = Option<Retelling>;

    fn request(&self) -> ChatRequest {
        let grammar = format!("start: LINE\nLINE: /[^\\n]{{1,{LENGTH}}}/\n");
        self.transcript.under_grammar(grammar, TOKENS)
    }

    /// Reads the retold instruction.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Option<Retelling>>, DialogueError> {
        self.transcript.receive(reply)?;
        let text = plain_line(&reply.text);
        let likelihood = reply.likelihood.map_or(i64::MIN, |likelihood| likelihood.text);
        let (is_sure, is_usable) = (likelihood >= SURE, likelihood >= WORTHLESS);
        let is_new = !letters(&text).is_empty() && letters(&text) != letters(&self.instruction);
        let mut candidate = Candidate::new(text.clone(), reply.likelihood.map(|likelihood| likelihood.text));
        candidate.chosen = is_sure && is_new;
        self.reading.doubt = (!is_sure).then_some(Doubt::Unlikely);
        self.reading.candidates.push(candidate);
        Ok(Some((is_usable && is_new).then_some(Retelling { text, is_sure })))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

/// Returns the names of a world and an instruction of one line, as a message.
pub(super) fn question_of(world: &World, instruction: &str) -> String {
    let mut names: Vec<&str> = Vec::new();
    for (_, entity) in world.entities() {
        if !names.contains(&entity.name.as_str()) {
            names.push(&entity.name);
        }
    }
    format!("Things: {}\n{instruction}", names.join(", "))
}

/// Returns the letters and digits of a text in lower case.
fn letters(text: &str) -> String {
    let letters = text.chars().filter(|character| character.is_alphanumeric());
    letters.flat_map(char::to_lowercase).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialogue::Likelihood;

    #[test]
    fn a_retelling_counts_if_it_is_likely_and_new() {
        let world = crate::Planner::shipped("household").unwrap();
        let world = world
            .world(r#"{"assets": ["<desk>"], "objects": ["<pen>", "<pen_2>"]}"#)
            .unwrap();
        let said = "take the PEN";
        let replies = [
            ("Take the pen from the desk.", Some(-4400), Some(true)),
            ("Take the pen from the desk.", Some(-4600), Some(false)),
            ("Take the pen from the desk.", Some(-10_001), None),
            ("Take the pen from the desk.", None, None),
            ("Take the pen.", Some(-10), None),
            (" .", Some(-10), None),
        ];
        for (text, likelihood, expected) in replies {
            let mut dialogue = RetellingDialogue::new(&world, said);
            let asked = dialogue.request().messages.last().unwrap().text.clone();
            assert!(
                asked.starts_with("Things: desk, pen") && asked.ends_with("\ntake the PEN"),
                "{asked}"
            );
            let reply = Reply {
                likelihood: likelihood.map(|text| Likelihood {
                    text,
                    ..Likelihood::default()
                }),
                ..Reply::complete(text)
            };
            let retold = dialogue.supply(&reply).unwrap().unwrap();
            assert_eq!(retold.map(|own| own.is_sure), expected, "{text}");
        }
    }
}
