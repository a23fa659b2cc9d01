//! Reading feedback as a conversation that somebody else carries out.

use serde::Deserialize;

use super::StepWish;
use super::example::{fixed_turns, plan_and_words};
use super::grammar::{GOAL, MOST, grammar, schema};
use super::heard::{Heard, what_for};
use super::language::{everyday, parse};
use super::offer::{Offers, offers};
use crate::dialogue::{
    ChatRequest, Constraint, ConstraintKind, DialogueError, Message, Reply, Role, Usage, object, one_line, whole,
};
use crate::environment::World;
use crate::goal::QUESTION;
use crate::model::{Domain, plain_words};
use crate::plan::{Plan, Step};

/// Tokens for the answer of a model under a grammar, and of a server.
const GRAMMAR_TOKENS: u32 = 128;
const ANSWER_TOKENS: u32 = 512;

/// What a person's words about a plan ask for.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Wish {
    /// They are about what is wanted: the goal has to be asked for anew, with these words.
    Goal,
    /// They are about the steps.
    Steps(Vec<StepWish>),
    /// The person must say more first.
    Question(String),
}

/// Asks a model what a person's words about a plan mean. One request, one reply.
#[derive(Debug, Clone)]
pub struct FeedbackDialogue {
    words: String,
    length: usize,
    offers: Offers,
    kind: ConstraintKind,
    messages: Vec<Message>,
    fixed: usize,
    answer: String,
    /// What the call cost.
    pub usage: Usage,
}

impl FeedbackDialogue {
    /// Begins a conversation about what a person said of a plan for an instruction, with a model of the given kind.
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

    /// What to send to the model.
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

    /// The model's answer, as it came.
    pub fn answer(&self) -> &str {
        &self.answer
    }

    /// Takes the model's reply.
    ///
    /// # Errors
    ///
    /// When the reply is cut off, refused, or no change of this plan.
    pub fn supply(&mut self, domain: &Domain, world: &World, reply: &Reply) -> Result<Wish, DialogueError> {
        self.usage += reply.usage;
        self.answer.clone_from(&reply.text);
        whole(reply)?;
        let text = match self.kind {
            ConstraintKind::Grammar => reply.text.trim().to_owned(),
            ConstraintKind::JsonSchema => self.unwrapped(&reply.text)?,
        };
        if let Some(question) = text.strip_prefix(QUESTION) {
            return Ok(Wish::Question(question.trim().to_owned()));
        }
        if text == GOAL {
            return Ok(Wish::Goal);
        }
        let mut wishes =
            parse(domain, world, &text, self.length).map_err(|error| DialogueError::NoWish(error.to_string()))?;
        self.explain(world, &mut wishes);
        Ok(Wish::Steps(wishes))
    }

    /// The answer of a server, as a model under a grammar would have written it.
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

    /// A step that comes in takes its sentence from the person's words, if they say what it is for.
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

/// Whether the words can ask for several changes.
fn says_several(words: &str) -> bool {
    let several = ["and", "both", "two", "three", "all", "then", "every", "each", "steps"];
    words.contains([',', ';']) || plain_words(words).iter().any(|word| several.contains(&word.as_str()))
}
