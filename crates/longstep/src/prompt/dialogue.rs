//! The goal strategy as a conversation that somebody else carries out.
//!
//! The dialogue never calls a model. It says what to send ([`GoalDialogue::request`]) and is given the reply
//! ([`GoalDialogue::supply`]) until it understands.

use serde::Deserialize;

use super::example::{fixed_turns, scene_and_instruction};
use super::query::plain_line;
use super::{
    ChatRequest, Constraint, ConstraintKind, Finish, Message, PartCost, Reply, Role, TokenCounter, Usage, scene,
};
use crate::domain::Domain;
use crate::goal::{self, Goal, GoalError, GoalFact, Place, Spoken, Understanding, grammar, offers, schema, understand};
use crate::world::World;

/// Goals in one answer at most.
const GOAL_LIMIT: usize = 6;
/// Tokens for one goal or a question.
const STEP_TOKENS: u32 = 96;
/// Tokens for a whole answer of a server.
const ANSWER_TOKENS: u32 = 1024;

/// Why a reply cannot be used. It is never completed by guesswork.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DialogueError {
    /// The reply is cut off.
    #[error("the model's answer was cut off: `{0}`")]
    CutOff(String),
    /// The model or its server would not answer.
    #[error("the model refused to answer")]
    Refused,
    /// The reply is not in the form that was asked for.
    #[error("the model's answer cannot be read: {0}")]
    Unreadable(String),
    /// The reply names something that there is not.
    #[error("the model's answer is no goal here: {0}")]
    NoGoal(#[from] GoalError),
}

/// What to do next.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// Send [`GoalDialogue::request`] again: the answer goes on.
    GoOn,
    /// This is what was understood.
    Done(Understanding),
}

/// Asks a model what an instruction wants.
#[derive(Debug, Clone)]
pub struct GoalDialogue {
    instruction: String,
    /// What the instruction speaks of.
    spoken: Spoken,
    kind: ConstraintKind,
    messages: Vec<Message>,
    fixed: usize,
    answer: String,
    facts: Vec<GoalFact>,
    /// What the calls so far cost.
    pub usage: Usage,
}

impl GoalDialogue {
    /// Begins a conversation about `instruction` with a model of the given kind.
    pub fn new(domain: &Domain, world: &World, instruction: &str, kind: ConstraintKind) -> Self {
        let mut messages = fixed_turns(domain, kind);
        let fixed = messages.len();
        // When the instruction names a thing that is not here, nothing is taken to be meant for certain.
        let spoken = match goal::unknown_thing(domain, world, instruction) {
            Some(_) => Spoken::default(),
            None => Spoken::of(domain, world, instruction),
        };
        let scene = scene(domain, world, &offers(domain, world, &[], &Spoken::default()));
        messages.push(Message::new(
            Role::User,
            scene_and_instruction(&scene, &plain_line(instruction)),
        ));
        Self {
            instruction: instruction.to_owned(),
            spoken,
            kind,
            messages,
            fixed,
            answer: String::new(),
            facts: Vec::new(),
            usage: Usage::default(),
        }
    }

    /// What to send to the model now.
    pub fn request(&self, domain: &Domain, world: &World) -> ChatRequest {
        let offers = offers(domain, world, &self.facts, &self.spoken);
        let constraint = match self.kind {
            ConstraintKind::Grammar => {
                let more = self.facts.len() + 1 < GOAL_LIMIT;
                let place = if self.answer.is_empty() {
                    let question = !goal::is_plain(domain, &offers, &self.spoken);
                    Place::First { question }
                } else {
                    Place::Next
                };
                Constraint::Lark(grammar(domain, world, &offers, place, more))
            }
            ConstraintKind::JsonSchema => Constraint::JsonSchema(schema(domain, world, &offers)),
        };
        ChatRequest {
            messages: self.messages.clone(),
            fixed: self.fixed,
            answer_so_far: self.answer.clone(),
            constraint,
            max_tokens: match self.kind {
                ConstraintKind::Grammar => STEP_TOKENS,
                ConstraintKind::JsonSchema => ANSWER_TOKENS,
            },
        }
    }

    /// What the parts of the conversation cost: `task`, `examples`, `query`, and `frame` for what a model's template
    /// puts around the whole.
    pub fn costs(&self, counter: &mut dyn TokenCounter) -> Vec<PartCost> {
        let parts = [
            ("task", &self.messages[..1]),
            ("examples", &self.messages[1..self.fixed]),
            ("query", &self.messages[self.fixed..]),
        ];
        let mut costs = Vec::new();
        for (name, messages) in parts {
            let tokens = messages.iter().map(|message| counter.message_tokens(message)).sum();
            costs.push(PartCost { name, tokens });
        }
        costs.push(PartCost {
            name: "frame",
            tokens: counter.frame_tokens(),
        });
        costs
    }

    /// The model's answer as far as it has come.
    pub fn answer(&self) -> &str {
        &self.answer
    }

    /// Takes the model's reply to the last request.
    ///
    /// # Errors
    ///
    /// When the reply is cut off, refused, or not what was asked for.
    pub fn supply(&mut self, domain: &Domain, world: &World, reply: &Reply) -> Result<Turn, DialogueError> {
        self.usage += reply.usage;
        self.answer.push_str(&reply.text);
        match reply.finish {
            Finish::Stop => {}
            Finish::Length => return Err(DialogueError::CutOff(shortened(&self.answer))),
            Finish::Refused => return Err(DialogueError::Refused),
        }
        match self.kind {
            ConstraintKind::Grammar => self.supply_part(domain, world, &reply.text),
            ConstraintKind::JsonSchema => self.supply_whole(domain, world, &reply.text),
        }
    }

    fn supply_part(&mut self, domain: &Domain, world: &World, text: &str) -> Result<Turn, DialogueError> {
        if let Some(question) = self.answer.strip_prefix(goal::QUESTION) {
            let question = question.trim().to_owned();
            return Ok(self.asked(domain, world, question));
        }
        let text = text.trim();
        let (part, goes_on) = match text.strip_suffix(goal::JOINT.trim()) {
            Some(part) => (part.trim(), true),
            None => (text, false),
        };
        if !part.is_empty() {
            self.facts.extend(goal::parse(domain, world, part)?.facts);
        }
        let more = goes_on && !offers(domain, world, &self.facts, &self.spoken).is_empty();
        Ok(if more { Turn::GoOn } else { self.done(domain, world) })
    }

    fn supply_whole(&mut self, domain: &Domain, world: &World, text: &str) -> Result<Turn, DialogueError> {
        #[derive(Deserialize)]
        struct Answer {
            #[serde(default)]
            question: String,
            #[serde(default)]
            goals: Vec<String>,
        }
        // A server that ignores the schema may put a fence around the object.
        let bare = text
            .trim()
            .trim_start_matches("```json")
            .trim_start_matches("```")
            .trim_end_matches("```");
        let answer: Answer = serde_json::from_str(bare.trim())
            .map_err(|error| DialogueError::Unreadable(format!("{error}: `{}`", shortened(text))))?;
        if !answer.question.trim().is_empty() {
            return Ok(self.asked(domain, world, answer.question.trim().to_owned()));
        }
        for part in answer.goals.iter().take(GOAL_LIMIT) {
            for fact in goal::parse(domain, world, part)?.facts {
                if !self.facts.contains(&fact) {
                    self.facts.push(fact);
                }
            }
        }
        Ok(self.done(domain, world))
    }

    /// The model asks back. If what the instruction asks for holds already, that is what puzzles it.
    fn asked(&self, domain: &Domain, world: &World, question: String) -> Turn {
        let facts = goal::already(domain, world, &self.spoken);
        Turn::Done(if facts.is_empty() {
            Understanding::Question(question)
        } else {
            Understanding::Goal(Goal { facts }, Vec::new())
        })
    }

    fn done(&mut self, domain: &Domain, world: &World) -> Turn {
        let goal = Goal {
            facts: std::mem::take(&mut self.facts),
        };
        Turn::Done(understand(domain, world, &self.instruction, goal))
    }
}

fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn shortened(text: &str) -> String {
    let mut short: String = one_line(text).chars().take(120).collect();
    if short.len() < text.trim().len() {
        short.push('…');
    }
    short
}
