//! The goal strategy as a dialogue with a model.
//!
//! The dialogue never calls the model. The caller sends [`GoalDialogue::request`] and passes the reply to
//! [`GoalDialogue::supply`] until the dialogue is done.

use serde::Deserialize;
use serde::de::DeserializeOwned;

use super::answer_grammar::question_in;
use super::example::{fixed_turns, in_form, scene_and_instruction};
use super::goal_grammar::{Place, Ways, goal_grammar, goal_schema};
use super::query::plain_line;
use super::{
    ChatRequest, Constraint, ConstraintKind, Finish, Message, PartCost, Reply, Role, Round, TokenCounter, Usage, scene,
};
use crate::effort;
use crate::environment::{EntityId, World};
use crate::goal::{
    self, Begun, Correction, Goal, GoalError, GoalFact, Next, Offer, Request, Spoken, Understanding, ended, offers,
    offers_on, understand_spoken,
};
use crate::model::{Domain, plain_words};
use crate::search;

/// Maximum number of goals in an answer.
const GOAL_LIMIT: usize = 6;
/// Token budget of one goal or a question.
const STEP_TOKENS: u32 = 96;
/// Token budget of a whole answer of a server.
pub(super) const ANSWER_TOKENS: u32 = 1024;

/// Reason why a reply is unusable. Replies are never completed by guesses.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DialogueError {
    /// The reply was cut off.
    #[error("the model's answer was cut off: `{0}`")]
    CutOff(String),
    /// The model or its server refused to answer.
    #[error("the model refused to answer")]
    Refused,
    /// The reply does not have the required form.
    #[error("the model's answer cannot be read: {0}")]
    Unreadable(String),
    /// The reply names an unknown goal or entity.
    #[error("the model's answer is no goal here: {0}")]
    NoGoal(#[from] GoalError),
    /// The reply is no change of the plan.
    #[error("the model's answer is no change of this plan: {0}")]
    NoWish(String),
    /// Enumerating the possible goals exceeds the work budget.
    #[error("{TOO_MUCH_WORK}")]
    TooMuchWork,
}

/// Error for a domain and world with too many goals to enumerate.
pub(super) const TOO_MUCH_WORK: &str =
    "there are too many goals in this domain and world, or their conditions take too much work";

/// Checks that a reply is complete.
///
/// # Errors
///
/// The reply was cut off or refused.
pub(crate) fn whole(reply: &Reply) -> Result<(), DialogueError> {
    match reply.finish {
        Finish::Stop => Ok(()),
        Finish::Length => Err(DialogueError::CutOff(shortened(&reply.text))),
        Finish::Refused => Err(DialogueError::Refused),
    }
}

/// Parses the JSON object of a server's answer.
///
/// # Errors
///
/// The text is no such object.
pub(crate) fn object<T: DeserializeOwned>(text: &str) -> Result<T, DialogueError> {
    // Servers that ignore the schema may add a code fence.
    let bare = text
        .trim()
        .trim_start_matches("```json")
        .trim_start_matches("```")
        .trim_end_matches("```");
    serde_json::from_str(bare.trim())
        .map_err(|error| DialogueError::Unreadable(format!("{error}: `{}`", shortened(text))))
}

/// The next step of a dialogue.
#[derive(Debug, Clone, PartialEq)]
pub enum Turn {
    /// Send [`GoalDialogue::request`] again to continue the answer.
    GoOn,
    /// The result.
    Done(Understanding),
}

/// Lets a model translate an instruction into goals.
#[derive(Debug, Clone)]
pub struct GoalDialogue {
    /// Mentions of the instruction and all later utterances.
    heard: Correction,
    /// These mentions, or none if they include an unknown object: no reference is certain then.
    spoken: Spoken,
    kind: ConstraintKind,
    messages: Vec<Message>,
    fixed: usize,
    answer: String,
    facts: Vec<GoalFact>,
    /// Goals that precede the next one in its branch.
    said: Vec<GoalFact>,
    /// Goals of the other branch of a condition, which this branch must not repeat.
    other_side: Vec<GoalFact>,
    next: Next,
    has_condition: bool,
    /// True if the instruction has a condition that no sensing action can decide.
    cannot_be_told: bool,
    /// True if the model denied that an existing object is here; it may not ask again.
    mistaken: bool,
    /// Possible next goals.
    open: Vec<Offer>,
    /// The words that ask for a further goal, where no other goal may be answered.
    further: Option<Request>,
    /// True if enumerating `open` or the scene exceeded the work budget.
    exhausted: bool,
    /// Token counts of the calls so far.
    pub usage: Usage,
}

/// The inputs of a goal dialogue.
#[derive(Debug, Clone, Copy)]
pub struct GoalInput<'a> {
    /// The domain with its prompts.
    pub domain: &'a Domain,
    /// The world shown to the model.
    pub world: &'a World,
    /// The instruction of the person.
    pub instruction: &'a str,
    /// The earlier answers of the model, each with the reply of the person.
    pub rounds: &'a [Round],
    /// The kind of constraint that the model supports.
    pub kind: ConstraintKind,
}

impl GoalDialogue {
    /// Starts a dialogue about `instruction`.
    pub fn new(domain: &Domain, world: &World, instruction: &str, kind: ConstraintKind) -> Self {
        Self::again(GoalInput {
            domain,
            world,
            instruction,
            rounds: &[],
            kind,
        })
    }

    /// Continues a dialogue after feedback on the answer or an answer to its question.
    ///
    /// Mentions come from the instruction and the later utterances, which take precedence: entities that they exclude
    /// ("not that plate") and answers that they reject are no longer offered.
    pub fn again(input: GoalInput<'_>) -> Self {
        let mut dialogue = Self::before(input);
        dialogue.begin(input.domain, input.world);
        dialogue
    }

    /// Creates the dialogue before the possible goals are enumerated.
    pub(super) fn before(input: GoalInput<'_>) -> Self {
        let GoalInput {
            domain,
            world,
            instruction,
            rounds,
            kind,
        } = input;
        let mut messages = fixed_turns(domain, kind);
        let fixed = messages.len();
        let mut heard = Correction::of(domain, world, instruction);
        for round in rounds {
            heard.hear(domain, world, &round.replied, &round.said);
        }
        let spoken = match &heard.unknown {
            Some(_) => Spoken::default(),
            None => heard.spoken.clone(),
        };
        let shown = effort::within(effort::OPERATION, || {
            scene(domain, world, &offers(domain, world, &[], &Spoken::default()))
        });
        let scene = shown.result;
        messages.push(Message::new(
            Role::User,
            scene_and_instruction(&scene, &plain_line(instruction)),
        ));
        for round in rounds {
            messages.push(Message::new(Role::Assistant, in_form(&round.replied, kind)));
            messages.push(Message::new(Role::User, plain_line(&round.said)));
        }
        Self {
            cannot_be_told: goal::cannot_be_told(domain, world, &heard.spoken),
            heard,
            spoken,
            kind,
            messages,
            fixed,
            answer: String::new(),
            facts: Vec::new(),
            said: Vec::new(),
            other_side: Vec::new(),
            next: Next::Goal,
            has_condition: false,
            mistaken: false,
            open: Vec::new(),
            further: None,
            exhausted: shown.exhausted,
            usage: Usage::default(),
        }
    }

    /// Enumerates the possible goals. If the last utterance only adds to the answer, the new answer continues the old
    /// one.
    pub(super) fn begin(&mut self, domain: &Domain, world: &World) {
        self.facts.clone_from(&self.heard.begun);
        self.said = self.facts.iter().flat_map(GoalFact::parts).cloned().collect();
        self.look(domain, world);
        if self.facts.is_empty() {
            return;
        }
        if self.open.is_empty() {
            self.facts.clear();
            self.said.clear();
            self.look(domain, world);
        } else if self.kind == ConstraintKind::Grammar {
            let said: Vec<String> = self.facts.iter().map(|fact| fact.everyday(domain, world)).collect();
            self.answer = said.join(" & ") + goal::JOINT;
        }
    }

    /// Takes the words of the last round for a wish beside the goals that they were said about: the answer goes on from
    /// these goals, with what the words alone ask for. Changes nothing if they ask for no goal.
    ///
    /// A goal is offered only if the words have a cue of it (or a verb that leads to a place, for a goal word without
    /// cues) and name its subject, be it by a pronoun: a second reading of words must not be a guess.
    pub(crate) fn further(&mut self, domain: &Domain, world: &World, last: &Round) {
        let Ok(goals) = goal::parse(domain, world, &last.replied) else {
            return;
        };
        self.heard.begun = goals.facts;
        self.heard.rejected.clear();
        self.further = Some(Request::of(domain, world, &last.said));
        self.answer.clear();
        self.begin(domain, world);
        if self.facts.is_empty() || self.exhausted {
            self.further = None;
        }
    }

    /// Returns true if the answer is to be a goal beside those of the last round ([`Self::further`]).
    pub(crate) fn is_further(&self) -> bool {
        self.further.is_some()
    }

    /// Returns the next request to the model.
    pub fn request(&self, domain: &Domain, world: &World) -> ChatRequest {
        let constraint = match self.kind {
            ConstraintKind::Grammar => Constraint::Lark(self.grammar(domain, world)),
            ConstraintKind::JsonSchema => {
                let depends = !goal::conditions(domain, world, &self.heard.spoken).is_empty();
                Constraint::JsonSchema(goal_schema(domain, world, &self.open, depends))
            }
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

    /// Returns the grammar of possible continuations.
    fn grammar(&self, domain: &Domain, world: &World) -> String {
        let offers = &self.open;
        let spoken = &self.heard.spoken;
        let conditions = match self.next {
            Next::Goal => goal::conditions(domain, world, spoken),
            _ => Vec::new(),
        };
        let more = self.said.len() + 1 < GOAL_LIMIT;
        let mut joints = Vec::new();
        if self.next == Next::Then && goal::has_other_case(spoken) {
            joints.push(goal::ELSE);
        }
        let in_case = matches!(self.next, Next::Then | Next::Otherwise);
        if in_case {
            joints.push(goal::AND);
        }
        if !(in_case && goal::governs_all(spoken)) {
            joints.push(goal::JOINT);
        }
        if !more {
            joints.clear();
        }
        // After "if" in the instruction, some goal must have a condition.
        let must_depend = more && !conditions.is_empty() && !self.has_condition;
        let place = if self.answer.is_empty() {
            let question = !self.mistaken && !goal::is_plain(domain, offers, &self.spoken);
            Place::First { question }
        } else {
            Place::Next
        };
        let ways = Ways {
            offers: if self.cannot_be_told { &[] } else { offers },
            conditions: &conditions,
            joints: &joints,
            may_end: !must_depend,
        };
        goal_grammar(domain, world, &ways, place)
    }

    /// Returns the token counts by part: `task`, `examples`, `query`, and `frame` for the chat template around the
    /// messages.
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

    /// Enumerates the possible next goals, within a work budget.
    fn look(&mut self, domain: &Domain, world: &World) {
        // A goal that holds now may be undone by the goals before it; a search decides.
        let search = if self.said.is_empty() { 0 } else { search::EFFORT };
        let found = effort::within(effort::OPERATION + search, || self.offers(domain, world));
        self.exhausted |= found.exhausted;
        self.open = found.result;
    }

    /// Returns true if enumerating the possible goals exceeded the work budget. No reply is usable then.
    pub(super) fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Returns the possible next goals without those that the person rejected.
    fn offers(&self, domain: &Domain, world: &World) -> Vec<Offer> {
        let further = !self.said.is_empty() || self.next == Next::Otherwise;
        let mut offers = offers_on(domain, world, &self.said, &self.spoken, further);
        for offer in &mut offers {
            let rejected = |arguments: &Vec<EntityId>| {
                let same = |fact: &GoalFact| matches!(fact, GoalFact::Word { word, arguments: other } if *word == offer.word && other == arguments);
                let excluded = arguments.iter().any(|entity| self.heard.excluded.contains(entity));
                let unasked = |request: &Request| !request.asks_for(domain, offer.word, arguments);
                excluded
                    || self.further.as_ref().is_some_and(unasked)
                    || self.heard.rejected.iter().chain(&self.other_side).any(same)
            };
            offer.arguments.retain(|arguments| !rejected(arguments));
        }
        offers.retain(|offer| !offer.arguments.is_empty());
        offers
    }

    /// Returns the model's answer so far.
    pub fn answer(&self) -> &str {
        &self.answer
    }

    /// Interprets the reply to the last request.
    ///
    /// # Errors
    ///
    /// The reply is cut off, refused or invalid, or enumerating its continuations exceeds the work budget.
    pub fn supply(&mut self, domain: &Domain, world: &World, reply: &Reply) -> Result<Turn, DialogueError> {
        self.usage += reply.usage;
        self.answer.push_str(&reply.text);
        whole(reply)?;
        let turn = match self.kind {
            _ if self.exhausted => Err(DialogueError::TooMuchWork),
            ConstraintKind::Grammar => self.supply_part(domain, world),
            ConstraintKind::JsonSchema => self.supply_whole(domain, world, &reply.text),
        }?;
        if self.exhausted {
            return Err(DialogueError::TooMuchWork);
        }
        Ok(turn)
    }

    fn supply_part(&mut self, domain: &Domain, world: &World) -> Result<Turn, DialogueError> {
        if let Some(question) = question_in(&self.answer) {
            let question = question.to_owned();
            if !self.mistaken && self.denies_what_is_here(world, &question) && !self.open.is_empty() {
                self.mistaken = true;
                self.answer.clear();
                return Ok(Turn::GoOn);
            }
            return Ok(self.asked(domain, world, question));
        }
        let begun = Begun::read(domain, world, &self.answer)?;
        (self.said, self.next, self.has_condition) = (begun.said(), begun.next, begun.has_condition());
        (self.facts, self.other_side) = (begun.facts, begun.other_side);
        if self.next != Next::Nothing {
            self.look(domain, world);
            if !self.open.is_empty() {
                return Ok(Turn::GoOn);
            }
        }
        self.facts = ended(domain, world, &self.answer)?.facts;
        Ok(self.done(domain, world))
    }

    fn supply_whole(&mut self, domain: &Domain, world: &World, text: &str) -> Result<Turn, DialogueError> {
        #[derive(Deserialize)]
        struct Answer {
            #[serde(default)]
            question: String,
            #[serde(default)]
            goals: Vec<String>,
        }
        let answer: Answer = object(text)?;
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

    /// Returns true if the model denies an object that the instruction names and that exists. Small models do so if the
    /// instruction's name is longer: "the remote control" for a remote.
    fn denies_what_is_here(&self, world: &World, question: &str) -> bool {
        let lower = question.to_lowercase();
        let Some(rest) = lower.strip_prefix("i see no ") else {
            return false;
        };
        let thing = rest.split(" here").next().unwrap_or(rest);
        let words = plain_words(thing);
        let named = |name: &String| {
            let parts = plain_words(name);
            !parts.is_empty() && parts.iter().all(|part| words.contains(part))
        };
        let spoken = self.heard.spoken.entities.iter();
        self.heard.unknown.is_none()
            && spoken
                .into_iter()
                .any(|entity| world.entity(*entity).names.iter().any(named))
    }

    /// Handles a question of the model. If the requested goals hold already, they are the answer.
    fn asked(&self, domain: &Domain, world: &World, question: String) -> Turn {
        let facts = goal::already(domain, world, &self.spoken);
        Turn::Done(if facts.is_empty() {
            Understanding::Question(question)
        } else {
            Understanding::Goal(Goal { facts }, Vec::new())
        })
    }

    fn done(&mut self, domain: &Domain, world: &World) -> Turn {
        let depends = |fact: &GoalFact| matches!(fact, GoalFact::If(_));
        if self.cannot_be_told && !self.facts.iter().any(depends) {
            let question = "I cannot find out whether that is so. What should I do in any case?";
            return Turn::Done(Understanding::Question(question.to_owned()));
        }
        let goal = Goal {
            facts: std::mem::take(&mut self.facts),
        };
        let unknown = self.heard.unknown.clone();
        Turn::Done(understand_spoken(domain, world, &self.heard.spoken, unknown, goal))
    }
}

/// Returns a text as one line.
pub(crate) fn one_line(text: &str) -> String {
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn shortened(text: &str) -> String {
    let mut short: String = one_line(text).chars().take(120).collect();
    if short.len() < text.trim().len() {
        short.push('…');
    }
    short
}
