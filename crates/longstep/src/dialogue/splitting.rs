//! Splitting: what an instruction wants done and what it forbids, each in plain English.
//!
//! Under a grammar of goals a model reads "but do not wake the dog" as a dog that is awake or as nothing at all. Said as a
//! command without "not" ("wake the dog"), what is forbidden is read like any wish, and may never come true.

use super::retelling::{SURE, question_of};
use super::screening::turns_of;
use super::{ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Transcript, plain_line};
use crate::environment::World;

/// The task in the first paragraph; then examples, each in a paragraph, and its answer in the next one.
const PROMPT: &str = include_str!("splitting.txt");
/// Likelihood below which the answer that nothing is forbidden is not used, in thousandths of a nat.
const CERTAIN: i64 = -2500;
/// Token budget of an answer.
const TOKENS: u32 = 256;
/// Maximum number of lines of an answer.
const LINES: usize = 6;
/// Maximum number of characters of a line, without its label.
const LENGTH: usize = 160;

const DO: &str = "do: ";
const THEN: &str = "then: ";
const NOT: &str = "not: ";

/// The parts of an instruction, in plain English: wishes and prohibitions.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Split {
    /// The wishes, in sentences; empty if the instruction only forbids something.
    pub wish: String,
    /// The acts that are forbidden, each as a command.
    pub forbidden: Vec<String>,
}

/// Lets a model split an instruction. One request, one reply.
///
/// ```
/// use longstep::dialogue::{Dialogue, Likelihood, Reply, SplittingDialogue};
/// let planner = longstep::Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>", "<cupboard>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let mut dialogue = SplittingDialogue::new(&world, "Der Stift ins Regal, aber lass den Schrank zu.");
/// let likelihood = Some(Likelihood { text: -2100, ..Likelihood::default() });
/// let text = "do: Put the pen on the shelf.\nnot: Open the cupboard.";
/// let split = dialogue.supply(&Reply { likelihood, ..Reply::complete(text) })?;
/// assert_eq!(split.flatten().unwrap().forbidden, ["Open the cupboard."]);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct SplittingDialogue {
    transcript: Transcript,
}

impl SplittingDialogue {
    /// Starts a dialogue about an instruction in a world.
    pub fn new(world: &World, instruction: &str) -> Self {
        let mut transcript = Transcript::new(ConstraintKind::Grammar, fixed_turns());
        transcript.push(Role::User, question_of(world, &plain_line(instruction)));
        Self { transcript }
    }
}

impl Dialogue for SplittingDialogue {
    /// The parts; none if the model is not sure of them.
    type Output = Option<Split>;

    fn request(&self) -> ChatRequest {
        let more = LINES - 1;
        let grammar =
            format!("start: LINE (\"\\n\" LINE){{0,{more}}}\nLINE: /({DO}|{THEN}|{NOT})[^\\n]{{1,{LENGTH}}}/\n");
        self.transcript.under_grammar(grammar, TOKENS)
    }

    /// Reads the parts.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or it has another form.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Option<Split>>, DialogueError> {
        self.transcript.receive(reply)?;
        let split = parts(&reply.text)?;
        let least = if split.forbidden.is_empty() { CERTAIN } else { SURE };
        let is_sure = reply.likelihood.is_some_and(|likelihood| likelihood.text >= least);
        Ok(Some(is_sure.then_some(split)))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

fn parts(answer: &str) -> Result<Split, DialogueError> {
    let mut split = Split::default();
    for line in answer.trim().lines() {
        if let Some(command) = line.strip_prefix(DO) {
            add(&mut split.wish, "", command);
        } else if let Some(command) = line.strip_prefix(THEN) {
            add(&mut split.wish, "Then ", command);
        } else if let Some(command) = line.strip_prefix(NOT) {
            split.forbidden.push(plain_line(command));
        } else {
            return Err(DialogueError::Unreadable(format!(
                "`{line}` is no part of an instruction"
            )));
        }
    }
    Ok(split)
}

/// Adds a command as a sentence.
fn add(wish: &mut String, before: &str, command: &str) {
    let command = plain_line(command);
    let mut letters = command.chars();
    let first = letters.next().map_or_else(String::new, |letter| match before {
        "" => letter.to_string(),
        _ => letter.to_lowercase().to_string(),
    });
    if !wish.is_empty() {
        wish.push(' ');
    }
    wish.push_str(before);
    wish.push_str(&first);
    wish.push_str(letters.as_str());
    if !wish.ends_with('.') {
        wish.push('.');
    }
}

fn fixed_turns() -> Vec<Message> {
    let mut paragraphs = PROMPT.trim().split("\n\n");
    let task = paragraphs.next().unwrap_or_default();
    let said: Vec<&str> = paragraphs.collect();
    turns_of(task, said.chunks_exact(2).map(|pair| (pair[0], pair[1])))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialogue::Likelihood;

    #[test]
    fn every_example_has_a_readable_answer() {
        let turns = fixed_turns();
        assert_eq!(turns.len(), 25);
        for pair in turns[1..].chunks(2) {
            let read = parts(&pair[1].text);
            assert!(pair[0].text.starts_with("Things: ") && read.is_ok(), "{read:?}");
        }
    }

    #[test]
    fn an_answer_counts_if_it_is_likely() {
        let world = crate::Planner::shipped("household").unwrap();
        let world = world.world(r#"{"assets": ["<desk>"], "objects": ["<pen>"]}"#).unwrap();
        let split = |wish: &str, forbidden: &[&str]| Split {
            wish: wish.to_owned(),
            forbidden: forbidden.iter().map(|act| (*act).to_owned()).collect(),
        };
        let replies = [
            (
                "do: Oil it.\nnot: Lock it.",
                Some(-4400),
                Some(split("Oil it.", &["Lock it."])),
            ),
            ("do: Oil it.\nnot: Lock it.", Some(-4600), None),
            ("do: Oil it.\nnot: Lock it.", None, None),
            (
                "not: Lock it.\nnot: Oil it.",
                Some(-4400),
                Some(split("", &["Lock it.", "Oil it."])),
            ),
            (
                "do: Oil it.\nthen: Lock it",
                Some(-2400),
                Some(split("Oil it. Then lock it.", &[])),
            ),
            // That nothing is forbidden, although a part is marked as forbidden, has to be more certain.
            ("do: Oil it.", Some(-2600), None),
        ];
        for (text, likelihood, expected) in replies {
            let mut dialogue = SplittingDialogue::new(&world, "Oil the hinge");
            let reply = Reply {
                likelihood: likelihood.map(|text| Likelihood {
                    text,
                    ..Likelihood::default()
                }),
                ..Reply::complete(text)
            };
            assert_eq!(dialogue.supply(&reply).unwrap().unwrap(), expected, "{text}");
        }
        assert!(parts("oil it").is_err());
    }
}
