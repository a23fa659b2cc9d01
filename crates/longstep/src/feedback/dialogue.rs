//! The model dialogue that interprets feedback.

use serde::Deserialize;

use super::StepWish;
use super::example::{fixed_turns, plan_and_words};
use super::grammar::{FURTHER, GOAL, MOST, grammar, schema};
use super::language::{everyday, parse};
use super::offer::{Offers, offers};
use super::reference::References;
use crate::dialogue::answer_grammar::{QUESTION_TOKENS, question_in};
use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, DialogueError, Reply, Role, Task, Transcript, object, one_line,
};
use crate::environment::World;
use crate::goal::QUESTION;
use crate::model::Domain;
use crate::plan::{Plan, Step};

/// Token budget of the answer of a server.
const ANSWER_TOKENS: u32 = 512;

/// Interpretation of an utterance about a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// It concerns the goal, which must be determined again with this utterance.
    Goal,
    /// It asks for something beside the goal.
    Further,
    /// It concerns the steps.
    Steps(Vec<StepWish>),
    /// A question to the person.
    Question(String),
}

/// Lets a model interpret an utterance about a plan. One request, one reply.
#[derive(Debug, Clone)]
pub struct FeedbackDialogue {
    world: World,
    words: String,
    length: usize,
    offers: Offers,
    transcript: Transcript,
}

/// The inputs of a feedback dialogue.
#[derive(Debug, Clone, Copy)]
pub struct FeedbackInput<'a> {
    /// The domain with its prompts.
    pub domain: &'a Domain,
    /// The world of the plan.
    pub world: &'a World,
    /// The plan.
    pub plan: &'a Plan,
    /// The instruction that the plan is for.
    pub instruction: &'a str,
    /// The utterance about the plan.
    pub feedback: &'a str,
    /// The kind of constraint that the model supports.
    pub kind: ConstraintKind,
}

impl FeedbackDialogue {
    /// Starts a dialogue about feedback on a plan.
    pub fn new(input: FeedbackInput<'_>) -> Self {
        let FeedbackInput {
            domain, world, plan, ..
        } = input;
        let words = one_line(input.feedback);
        let lines: Vec<String> = plan.steps().iter().map(|step| line(world, step)).collect();
        let mut transcript = Transcript::new(input.kind, fixed_turns(domain, input.kind)).for_task(Task::Plans);
        transcript.push(Role::User, plan_and_words(&one_line(input.instruction), &lines, &words));
        Self {
            offers: offers(world, plan, &References::of(world, &words)),
            world: world.clone(),
            words,
            length: plan.steps().len(),
            transcript,
        }
    }

    /// Returns true if the words can be about what is wanted: they contain no call, and no number that these wishes have.
    pub(crate) fn may_be_goal(&self, wishes: &[StepWish]) -> bool {
        let steps = wishes.iter().flat_map(|wish| [wish.step(), wish.before()]);
        let numbers: Vec<usize> = steps.flatten().flat_map(|step| [step, step + 1]).collect();
        let said = self.words.split(|sign: char| !sign.is_ascii_digit());
        self.offers.goal
            && !said
                .filter_map(|digits| digits.parse().ok())
                .any(|said| numbers.contains(&said))
    }

    /// Reads a wish from a whole answer.
    fn wish(&self, text: &str) -> Result<Wish, DialogueError> {
        let text = match self.transcript.kind {
            ConstraintKind::Grammar => text.trim().to_owned(),
            ConstraintKind::JsonSchema => self.unwrapped(text)?,
        };
        if let Some(question) = question_in(&text) {
            return Ok(Wish::Question(question.to_owned()));
        }
        if text == GOAL {
            return Ok(Wish::Goal);
        }
        if text == FURTHER {
            return Ok(Wish::Further);
        }
        let wishes = parse(&self.world, &text, self.length);
        let wishes = wishes.map_err(|error| DialogueError::NoWish(error.to_string()))?;
        Ok(Wish::Steps(wishes))
    }

    /// Converts the JSON answer of a server to the notation of the grammar.
    fn unwrapped(&self, text: &str) -> Result<String, DialogueError> {
        #[derive(Deserialize)]
        struct Answer {
            #[serde(default)]
            question: String,
            #[serde(default)]
            goal: bool,
            #[serde(default)]
            further: bool,
            #[serde(default)]
            edits: Vec<String>,
        }
        let answer: Answer = object(text)?;
        Ok(match answer {
            Answer { question, .. } if !question.trim().is_empty() => format!("{QUESTION}{}", question.trim()),
            Answer { goal: true, .. } => GOAL.to_owned(),
            Answer { further: true, .. } => FURTHER.to_owned(),
            Answer { edits, .. } if edits.is_empty() => format!("{QUESTION}What should be different about the plan?"),
            Answer { edits, .. } => edits[..edits.len().min(MOST)].join(" & "),
        })
    }
}

impl Dialogue for FeedbackDialogue {
    type Output = Wish;

    fn request(&self) -> ChatRequest {
        let world = &self.world;
        match self.transcript.kind {
            ConstraintKind::Grammar => self
                .transcript
                .under_grammar(grammar(world, &self.offers, self.length), QUESTION_TOKENS),
            ConstraintKind::JsonSchema => self
                .transcript
                .under_schema(schema(world, &self.offers, self.length), ANSWER_TOKENS),
        }
    }

    /// Interprets the model's reply. Only the reply of a server that cannot be read leads to a second request.
    ///
    /// # Errors
    ///
    /// The reply is cut off, refused, or no change of this plan.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Wish>, DialogueError> {
        self.transcript.receive(reply)?;
        let wish = self.wish(&reply.text);
        self.transcript.read_or_repeat(reply, wish)
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}

/// Returns a step as the model sees it: its call and its explanation.
fn line(world: &World, step: &Step) -> String {
    let arguments: Vec<_> = step.arguments.iter().copied().map(Some).collect();
    let call = everyday(world, step.action, &arguments);
    format!("{call}: {}", one_line(&step.explanation))
}
