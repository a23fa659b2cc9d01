//! Screening: a short request before the goals. The model marks the parts of an instruction that goals do not say.
//!
//! A grammar of goals admits nothing but goals, so a small model answers "do not paint the fence" with a painted fence.
//! In a request of its own, without a scene and without goals, it recognises what is forbidden, how much and when. The
//! examples are in several languages, about objects that no domain of this library has.

use super::answer_grammar::quoted;
use super::{ChatRequest, ConstraintKind, Dialogue, DialogueError, Message, Reply, Role, Task, Transcript};
use crate::coverage::{Gap, Mark};

/// The task in the first paragraph; then examples, each with its answer in the last line.
const PROMPT: &str = include_str!("screening.txt");
/// The first part of an answer, unless the instruction only forbids something. Without it a small model decides between
/// a wish and a prohibition, and misses the second half of "hang up the lantern, but do not wake the dog".
const WISH: &str = "wish";
/// The separator of marks.
const JOINT: &str = " & ";
/// Maximum number of marks in an answer.
const MARKS: usize = 4;
/// Token budget of an answer. Every mark is a part of the instruction.
const TOKENS: u32 = 1024;
/// The labels of marks.
const LABELS: [(&str, Gap); 5] = [
    ("forbids: ", Gap::Prohibition),
    ("amount: ", Gap::Quantity),
    ("order: ", Gap::Order),
    ("if: ", Gap::Condition),
    ("says: ", Gap::Quotation),
];

/// Lets a model mark the parts of an instruction that goals do not say. One request, one reply.
///
/// ```
/// use longstep::dialogue::{Dialogue, Reply, ScreeningDialogue};
/// let mut dialogue = ScreeningDialogue::new("Water the roses, but not the ferns");
/// assert!(dialogue.request().messages.last().unwrap().text.contains("roses"));
/// let text = "wish & forbids: but not the ferns";
/// let marks = dialogue.supply(&Reply::complete(text))?;
/// assert_eq!(marks.unwrap()[0].range, 17..34);
/// # Ok::<(), longstep::dialogue::DialogueError>(())
/// ```
#[derive(Debug, Clone)]
pub struct ScreeningDialogue {
    instruction: String,
    transcript: Transcript,
}

impl ScreeningDialogue {
    /// Starts a dialogue about an instruction of one line.
    pub fn new(instruction: &str) -> Self {
        let turns = fixed_turns(PROMPT);
        let mut transcript = Transcript::new(ConstraintKind::Grammar, turns).for_task(Task::Screening);
        transcript.push(Role::User, instruction);
        Self {
            instruction: instruction.to_owned(),
            transcript,
        }
    }

    /// Returns the grammar of marks. A quotation is one lexeme: any part of the instruction.
    fn grammar(&self) -> String {
        let labels: Vec<String> = LABELS.iter().map(|(label, _)| quoted(label)).collect();
        format!(
            "start: {wish} more{{0,{MARKS}}} | mark more{{0,{}}}\nmore: {} mark\nmark: ({}) QUOTATION\n\
             QUOTATION: %regex {{\"substring_chars\": {}}}\n",
            MARKS - 1,
            quoted(JOINT),
            labels.join(" | "),
            quoted(&self.instruction),
            wish = quoted(WISH),
        )
    }
}

impl Dialogue for ScreeningDialogue {
    type Output = Vec<Mark>;

    fn request(&self) -> ChatRequest {
        self.transcript.under_grammar(self.grammar(), TOKENS)
    }

    /// Reads the marks.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or it has another form.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Vec<Mark>>, DialogueError> {
        self.transcript.receive(reply)?;
        marks(&self.instruction, &reply.text).map(Some)
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

/// Reads an answer. A quotation may contain the separator, so an answer is split only before a label.
fn marks(instruction: &str, answer: &str) -> Result<Vec<Mark>, DialogueError> {
    let answer = answer.trim_start().trim_end_matches(['\n', '\r']);
    if answer == WISH {
        return Ok(Vec::new());
    }
    let mut marks: Vec<Mark> = Vec::new();
    let marked = answer.strip_prefix(WISH).and_then(|rest| rest.strip_prefix(JOINT));
    let mut rest = marked.unwrap_or(answer);
    loop {
        let unreadable = || DialogueError::Unreadable(format!("`{rest}` is no mark"));
        let (label, gap) = labelled(rest).ok_or_else(unreadable)?;
        let text = &rest[label.len()..];
        let ends = text.match_indices(JOINT).map(|(at, _)| at);
        let mut ends = ends.filter(|at| labelled(&text[at + JOINT.len()..]).is_some());
        let end = ends.next();
        let quotation = &text[..end.unwrap_or(text.len())];
        // A quotation of spaces marks nothing.
        if !quotation.trim().is_empty() {
            marks.push(Mark::of(instruction, quotation, gap).ok_or_else(unreadable)?);
        }
        match end {
            Some(end) => rest = &text[end + JOINT.len()..],
            None => return Ok(marks),
        }
    }
}

fn labelled(text: &str) -> Option<(&'static str, Gap)> {
    LABELS.into_iter().find(|(label, _)| text.starts_with(label))
}

/// Returns the task of a prompt, its first paragraph, and two messages for each example: a further paragraph, whose last
/// line is the answer.
pub(super) fn fixed_turns(prompt: &str) -> Vec<Message> {
    let mut paragraphs = prompt.trim().split("\n\n");
    let task = paragraphs.next().unwrap_or_default();
    turns_of(
        task,
        paragraphs.filter_map(|paragraph| paragraph.trim().rsplit_once('\n')),
    )
}

/// Returns a task and two messages for each example: what is said, and the answer.
pub(super) fn turns_of<'a>(task: &str, examples: impl Iterator<Item = (&'a str, &'a str)>) -> Vec<Message> {
    let mut turns = vec![Message::new(Role::System, task)];
    for (said, answer) in examples {
        turns.push(Message::new(Role::User, said));
        turns.push(Message::new(Role::Assistant, answer));
    }
    turns
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_example_has_a_readable_answer() {
        let turns = fixed_turns(PROMPT);
        assert_eq!(turns.len(), 1 + 2 * PROMPT.trim().split("\n\n").skip(1).count());
        for pair in turns[1..].chunks(2) {
            let read = marks(&pair[0].text, &pair[1].text);
            assert!(read.is_ok(), "{}: {read:?}", pair[0].text);
        }
    }

    #[track_caller]
    fn check(instruction: &str, answer: &str, expected: &[(&str, Gap)]) {
        let read = marks(instruction, answer).unwrap();
        let texts: Vec<(&str, Gap)> = read
            .iter()
            .map(|mark| (&instruction[mark.range.clone()], mark.gap))
            .collect();
        assert_eq!(texts, expected, "{answer}");
    }

    #[test]
    fn marks_are_parts_of_the_instruction() {
        check("Oil the hinge", "wish", &[]);
        check("Oil it twice", "wish & amount: twice", &[("twice", Gap::Quantity)]);
        check(
            "Tell the smith it squeaks",
            "wish & says: it squeaks",
            &[("it squeaks", Gap::Quotation)],
        );
        check(
            "Oil the hinge at 5 & twice",
            "amount: at 5 & twice",
            &[("at 5 & twice", Gap::Quantity)],
        );
        check(
            "First oil the hinge, but not the lock",
            "order: First & forbids: but not the lock",
            &[("First", Gap::Order), ("but not the lock", Gap::Prohibition)],
        );
        check("Oil", "if:   ", &[]);
        check("鍵をかけて", "wish & order: かけ", &[("かけ", Gap::Order)]);
        for answer in [
            "",
            "wish & ",
            "wish, forbids: oil",
            "forbids: the door",
            "never",
            "order: First & nothing",
        ] {
            let read = marks("First oil the hinge", answer);
            assert!(read.is_err(), "{answer}: {read:?}");
        }
    }
}
