//! The model dialogue that interprets feedback.

use serde::Deserialize;

use super::StepWish;
use super::example::{fixed_turns, plan_and_words};
use super::grammar::{GOAL, MOST, grammar, schema};
use super::heard::{Heard, what_for};
use super::language::{everyday, parse};
use super::offer::{Offers, offers};
use crate::dialogue::answer_grammar::question_in;
use crate::dialogue::{
    ChatRequest, Constraint, ConstraintKind, DialogueError, Message, Reply, Role, Usage, object, one_line, whole,
};
use crate::environment::World;
use crate::goal::QUESTION;
use crate::model::{Domain, plain_words};
use crate::plan::{Plan, Step};

/// Token budget of an answer under a grammar, and of a server.
const GRAMMAR_TOKENS: u32 = 128;
const ANSWER_TOKENS: u32 = 512;

/// Interpretation of an utterance about a plan.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// It concerns the goal, which must be determined again with this utterance.
    Goal,
    /// It concerns the steps.
    Steps(Vec<StepWish>),
    /// A question to the person.
    Question(String),
}

/// Lets a model interpret an utterance about a plan. One request, one reply.
#[derive(Debug, Clone)]
pub struct FeedbackDialogue {
    words: String,
    length: usize,
    offers: Offers,
    kind: ConstraintKind,
    messages: Vec<Message>,
    fixed: usize,
    answer: String,
    /// Token counts of the call.
    pub usage: Usage,
}

impl FeedbackDialogue {
    /// Starts a dialogue about `feedback` on the plan for an instruction.
    pub fn new(
        domain: &Domain,
        world: &World,
        plan: &Plan,
        instruction: &str,
        feedback: &str,
        kind: ConstraintKind,
    ) -> Self {
        let mut messages = fixed_turns(domain, kind);
        let fixed = messages.len();
        let words = one_line(feedback);
        let line = |step: &Step| {
            let arguments: Vec<_> = step.arguments.iter().copied().map(Some).collect();
            let call = everyday(domain, world, step.action, &arguments);
            format!("{call}: {}", one_line(&step.explanation))
        };
        let lines: Vec<String> = plan.steps().iter().map(line).collect();
        messages.push(Message::new(
            Role::User,
            plan_and_words(&one_line(instruction), &lines, &words),
        ));
        let heard = Heard::of(domain, world, plan, &words);
        let several = heard.steps.len() > 1 || says_several(&words);
        Self {
            offers: offers(domain, world, plan, &heard, several),
            words,
            length: plan.steps().len(),
            kind,
            messages,
            fixed,
            answer: String::new(),
            usage: Usage::default(),
        }
    }

    /// Returns the request to the model.
    pub fn request(&self, domain: &Domain, world: &World) -> ChatRequest {
        let (constraint, max_tokens) = match self.kind {
            ConstraintKind::Grammar => (
                Constraint::Lark(grammar(domain, world, &self.offers, self.length)),
                GRAMMAR_TOKENS,
            ),
            ConstraintKind::JsonSchema => (
                Constraint::JsonSchema(schema(domain, world, &self.offers, self.length)),
                ANSWER_TOKENS,
            ),
        };
        ChatRequest {
            messages: self.messages.clone(),
            fixed: self.fixed,
            answer_so_far: String::new(),
            constraint,
            max_tokens,
        }
    }

    /// Returns true if the words can be about what is wanted: they name no step and no call.
    pub(crate) fn may_be_goal(&self) -> bool {
        self.offers.goal
    }

    /// Returns the model's answer, unchanged.
    pub fn answer(&self) -> &str {
        &self.answer
    }

    /// Interprets the model's reply.
    ///
    /// # Errors
    ///
    /// The reply is cut off, refused, or no change of this plan.
    pub fn supply(&mut self, domain: &Domain, world: &World, reply: &Reply) -> Result<Wish, DialogueError> {
        self.usage += reply.usage;
        self.answer.clone_from(&reply.text);
        whole(reply)?;
        let text = match self.kind {
            ConstraintKind::Grammar => reply.text.trim().to_owned(),
            ConstraintKind::JsonSchema => self.unwrapped(&reply.text)?,
        };
        if let Some(question) = question_in(&text) {
            return Ok(Wish::Question(question.to_owned()));
        }
        if text == GOAL {
            return Ok(Wish::Goal);
        }
        let mut wishes =
            parse(domain, world, &text, self.length).map_err(|error| DialogueError::NoWish(error.to_string()))?;
        self.explain(world, &mut wishes);
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
            edits: Vec<String>,
        }
        let answer: Answer = object(text)?;
        Ok(match answer {
            Answer { question, .. } if !question.trim().is_empty() => format!("{QUESTION}{}", question.trim()),
            Answer { goal: true, .. } => GOAL.to_owned(),
            Answer { edits, .. } if edits.is_empty() => format!("{QUESTION}What should be different about the plan?"),
            Answer { edits, .. } => edits[..edits.len().min(MOST)].join(" & "),
        })
    }

    /// Takes the explanation of a single new step from the utterance, if it states a purpose.
    fn explain(&self, world: &World, wishes: &mut [StepWish]) {
        let mut explanations = wishes.iter_mut().filter_map(|wish| match wish {
            StepWish::Insert { explanation, .. } | StepWish::Replace { explanation, .. } => Some(explanation),
            StepWish::Drop { .. } | StepWish::Move { .. } => None,
        });
        if let (Some(explanation), None) = (explanations.next(), explanations.next())
            && let Some(clause) = what_for(world, &self.words)
        {
            *explanation = clause;
        }
    }
}

/// Returns true if the utterance can ask for several changes.
fn says_several(words: &str) -> bool {
    let several = ["and", "both", "two", "three", "all", "then", "every", "each", "steps"];
    words.contains([',', ';']) || plain_words(words).iter().any(|word| several.contains(&word.as_str()))
}
