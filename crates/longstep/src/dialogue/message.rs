//! Messages: whether somebody is to be told what a screening marks as a message.
//!
//! In a screening a small model takes "love", a reason or half a wish for a message. Asked about messages alone, it finds both
//! answers likely for such words, and the message much likelier where there is one. It is no better than the screening alone:
//! a message is what both of them find.

use super::answer_grammar::quoted;
use super::screening::fixed_turns;
use super::{
    Candidate, ChatRequest, ConstraintKind, Dialogue, DialogueError, Doubt, Reading, ReadingOf, Reply, Role,
    Transcript, plain_line,
};

/// The task in the first paragraph; then examples, each with its answer in the last line. The first one has no message.
const PROMPT: &str = include_str!("message.txt");
/// The answer to an instruction with a message begins with this.
const TELLS: &str = "tells: ";
/// Distance in thousandths of a nat by which the answer without a message has to be likelier, so that there is none
/// (docs/experiments.md has the measurement).
const AHEAD: i64 = 500;
/// Token budget of an answer.
const TOKENS: u32 = 1024;

/// Compares the likelihoods of two answers to an instruction: that somebody is to be told a part of it, and that nobody is. Two
/// requests, each with one possible answer, or one possible kind of it.
///
/// ```
/// use longstep::dialogue::{Dialogue, Likelihood, MessageDialogue, Reply};
/// let mut dialogue = MessageDialogue::new("Take the miller his sacks, love.");
/// let mut reply = |text: &str, likelihood: i64| {
///     let likelihood = Some(Likelihood { text: likelihood, ..Likelihood::default() });
///     dialogue.supply(&Reply { likelihood, ..Reply::complete(text) })
/// };
/// assert_eq!(reply("nobody is told anything", -380)?, None);
/// assert_eq!(reply("tells: love", -2100)?, Some(false));
/// # Ok::<(), longstep::dialogue::DialogueError>(())
/// ```
#[derive(Debug, Clone)]
pub struct MessageDialogue {
    instruction: String,
    /// The task, the first example with its answer, further examples.
    transcript: Transcript,
    /// The likelihood of the answer without a message, after the first reply.
    nobody: Option<i64>,
    /// The answers, as a reading.
    reading: Reading,
}

impl MessageDialogue {
    /// Starts a dialogue about an instruction.
    pub fn new(instruction: &str) -> Self {
        let instruction = plain_line(instruction);
        let mut transcript = Transcript::new(ConstraintKind::Grammar, fixed_turns(PROMPT));
        transcript.push(Role::User, instruction.clone());
        Self {
            transcript,
            nobody: None,
            reading: Reading {
                of: ReadingOf::Message,
                words: instruction.clone(),
                candidates: Vec::new(),
                least: None,
                doubt: None,
            },
            instruction,
        }
    }

    /// Returns both answers, with their likelihoods.
    pub fn reading(&self) -> &Reading {
        &self.reading
    }
}

impl Dialogue for MessageDialogue {
    /// True if somebody is to be told something, as far as is known.
    type Output = bool;

    fn request(&self) -> ChatRequest {
        let grammar = match self.nobody {
            None => format!("start: {}\n", quoted(&self.transcript.messages[2].text)),
            Some(_) => format!(
                "start: {} QUOTATION\nQUOTATION: %regex {{\"substring_chars\": {}}}\n",
                quoted(TELLS),
                quoted(&self.instruction)
            ),
        };
        self.transcript.under_grammar(grammar, TOKENS)
    }

    /// Counts an answer.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused.
    fn supply(&mut self, reply: &Reply) -> Result<Option<bool>, DialogueError> {
        self.transcript.receive(reply)?;
        self.transcript.answer.clear();
        // Without likelihoods there is nothing to compare.
        let Some(likelihood) = reply.likelihood.map(|likelihood| likelihood.text + likelihood.forced) else {
            return Ok(Some(true));
        };
        self.reading
            .candidates
            .push(Candidate::new(reply.text.clone(), Some(likelihood)));
        let Some(nobody) = self.nobody else {
            self.nobody = Some(likelihood);
            return Ok(None);
        };
        let is_told = nobody - likelihood < AHEAD;
        self.reading.candidates[usize::from(is_told)].chosen = true;
        self.reading.doubt = (!is_told).then_some(Doubt::Unlikely);
        Ok(Some(is_told))
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::dialogue::{Constraint, Likelihood};

    fn reply(text: &str, likelihood: Option<i64>) -> Reply {
        Reply {
            likelihood: likelihood.map(|text| Likelihood {
                text: text / 2,
                forced: text - text / 2,
                ..Likelihood::default()
            }),
            ..Reply::complete(text)
        }
    }

    #[test]
    fn the_likelier_answer_decides_and_a_message_in_doubt_is_kept() {
        for (nobody, tells, expected) in [(-400, -900, false), (-400, -899, true), (-3000, -200, true)] {
            let mut dialogue = MessageDialogue::new("Greet the\nmiller");
            let nobody = dialogue.supply(&reply("nobody is told anything", Some(nobody)));
            assert_eq!(nobody, Ok(None));
            assert_eq!(dialogue.supply(&reply("tells: the", Some(tells))), Ok(Some(expected)));
            let chosen = dialogue.reading().chosen().unwrap();
            assert_eq!(chosen.text.starts_with(TELLS), expected);
        }
        let mut dialogue = MessageDialogue::new("Greet the miller");
        assert_eq!(dialogue.supply(&reply("nobody is told anything", None)), Ok(Some(true)));
    }

    #[test]
    fn each_request_has_one_kind_of_answer_and_so_has_each_example() {
        let mut dialogue = MessageDialogue::new("Greet the miller");
        let grammar = |dialogue: &MessageDialogue| match dialogue.request().constraint {
            Constraint::Lark(grammar) => grammar,
            other => panic!("{other:?}"),
        };
        assert_eq!(grammar(&dialogue), "start: \"nobody is told anything\"\n");
        dialogue.supply(&reply("nobody is told anything", Some(-400))).unwrap();
        assert!(grammar(&dialogue).starts_with("start: \"tells: \" QUOTATION\n"));
        for pair in fixed_turns(PROMPT)[1..].chunks(2) {
            let (said, answer) = (&pair[0].text, &pair[1].text);
            match answer.strip_prefix(TELLS) {
                Some(message) => assert!(said.contains(message), "{said}"),
                None => assert_eq!(answer, "nobody is told anything"),
            }
        }
    }
}
