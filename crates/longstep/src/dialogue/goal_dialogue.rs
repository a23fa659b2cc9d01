//! The goal strategy as a dialogue with a model.

use serde::Deserialize;

use super::answer_grammar::{Form, QUESTION_TOKENS, question_in};
use super::ending::Endings;
use super::example::{fixed_turns, in_form, scene_and_instruction};
use super::goal_grammar::{Place, Ways, goal_grammar, goal_schema, listed_goals};
use super::query::plain_line;
use super::tries::Tries;
use super::{
    Candidate, ChatRequest, ConstraintKind, Dialogue, DialogueError, Doubt, PartCost, Reading, ReadingOf, Reply, Role,
    Round, Task, TokenCounter, Transcript, nats, object, scene,
};
use crate::coverage::{Gap, Mark};
use crate::effort;
use crate::environment::World;
use crate::goal::{
    self, Begun, Correction, Goal, GoalFact, Mentions, Next, Offer, Understanding, ended, guess, is_settled, offers,
    offers_on, settled_offers, understand_mentions,
};
use crate::model::Domain;
use crate::search;

/// Maximum number of goals in an answer.
const GOAL_LIMIT: usize = 6;
/// Token budget of one goal.
const STEP_TOKENS: u32 = 96;
/// Token budget of a whole answer of a server.
pub(super) const ANSWER_TOKENS: u32 = 1024;

/// Distance in thousandths of a nat to an answer that changes something, above which an answer that holds already is taken:
/// people mostly ask for what is not so yet.
const AHEAD: i64 = 1500;

/// Lets a model translate an instruction into goals.
#[derive(Debug, Clone)]
pub struct GoalDialogue {
    world: World,
    /// The names in the instruction and all later utterances.
    correction: Correction,
    condition: ConditionMark,
    transcript: Transcript,
    facts: Vec<GoalFact>,
    /// Goals that precede the next one in its branch.
    preceding: Vec<GoalFact>,
    /// Goals of the other branch of a condition, which this branch must not repeat.
    other_side: Vec<GoalFact>,
    next: Next,
    has_condition: bool,
    /// Where the answer may end.
    endings: Endings,
    /// The answers before this one, which were guesses.
    tries: Tries,
    /// The answers that begin with a goal which holds already, as far as they are known.
    settled: Settled,
    /// True if the answer is the first one to the instruction: an unlikely one is a question then.
    is_first: bool,
    /// Possible next goals.
    open: Vec<Offer>,
    /// The goals that the answer of a server may contain; none if they cannot be listed.
    listed: Option<Vec<String>>,
    /// The names in the words that ask for a further goal, where no other goal may be answered.
    further: Option<Mentions>,
    /// True if enumerating `open` or the scene exceeded the work budget.
    exhausted: bool,
    /// The parts of the instruction that the answer of a server quotes as not represented.
    left_out: Vec<(String, Gap)>,
    /// The answers so far.
    candidates: Vec<Candidate>,
    /// The reason why the chosen answer is a question.
    doubt: Option<Doubt>,
    /// The likelihood below which the chosen answer is a guess.
    limit: Option<i64>,
}

/// The condition mark of an instruction: if it has a condition, such as "if the milk is sour", as a [screening](super::ScreeningDialogue) marks
/// it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ConditionMark {
    /// Nothing is known: a goal may have a condition.
    #[default]
    Unknown,
    /// A goal must have a condition, if the domain can sense one.
    Present,
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
    /// The condition mark of the instruction.
    pub condition: ConditionMark,
    /// The kind of constraint that the model supports.
    pub kind: ConstraintKind,
}

impl<'a> GoalInput<'a> {
    /// The inputs of a first dialogue about an instruction, without marks or earlier rounds.
    pub fn new(domain: &'a Domain, world: &'a World, instruction: &'a str, kind: ConstraintKind) -> Self {
        Self {
            domain,
            world,
            instruction,
            rounds: &[],
            condition: ConditionMark::Unknown,
            kind,
        }
    }
}

impl GoalDialogue {
    /// Starts a dialogue about an instruction, or continues it after feedback on the answer or an answer to its question.
    ///
    /// Names come from the instruction and the later utterances, which take precedence. The goals of an earlier answer are
    /// no answer any more.
    pub fn new(input: GoalInput<'_>) -> Self {
        let mut dialogue = Self::before(input);
        dialogue.look();
        dialogue
    }

    /// Creates the dialogue before the possible goals are enumerated.
    pub(super) fn before(input: GoalInput<'_>) -> Self {
        let GoalInput {
            domain,
            world,
            instruction,
            rounds,
            condition,
            kind,
        } = input;
        let mut transcript = Transcript::new(kind, fixed_turns(domain, kind)).for_task(Task::Goals);
        let mut correction = Correction::of(world, instruction);
        for round in rounds {
            correction.hear(world, &round.reply, &round.message);
        }
        let shown = effort::within(effort::OPERATION, || {
            scene(world, &offers(world, &[], &Mentions::default()))
        });
        let scene = shown.result;
        // The scene has everyday names alone.
        let said = plain_line(&world.with_everyday_names(instruction));
        transcript.push(Role::User, scene_and_instruction(&scene, &said));
        for round in rounds {
            transcript.push(Role::Assistant, in_form(&round.reply, kind));
            transcript.push(Role::User, plain_line(&world.with_everyday_names(&round.message)));
        }
        Self {
            world: world.clone(),
            correction,
            condition,
            transcript,
            facts: Vec::new(),
            preceding: Vec::new(),
            other_side: Vec::new(),
            next: Next::Goal,
            has_condition: false,
            endings: Endings::default(),
            tries: Tries::default(),
            settled: Settled::default(),
            is_first: rounds.is_empty(),
            open: Vec::new(),
            listed: None,
            further: None,
            exhausted: shown.exhausted,
            left_out: Vec::new(),
            candidates: Vec::new(),
            doubt: None,
            limit: None,
        }
    }

    /// Takes the words of the last round for a wish beside the goals that they were said about: the answer goes on from
    /// these goals, with goals about entities that the words name. Changes nothing if there is no such goal.
    pub(crate) fn further(&mut self, last: &Round) {
        let Ok(goals) = goal::parse(&self.world, &last.reply) else {
            return;
        };
        self.further = Some(Mentions::of(&self.world, &last.message));
        self.facts = goals.facts;
        self.preceding = self.facts.iter().flat_map(GoalFact::parts).cloned().collect();
        self.look();
        if self.open.is_empty() || self.exhausted {
            self.further = None;
            self.facts.clear();
            self.preceding.clear();
            self.look();
        } else if self.transcript.kind == ConstraintKind::Grammar {
            let texts: Vec<String> = self.facts.iter().map(|fact| fact.everyday(&self.world)).collect();
            self.transcript.answer = texts.join(" & ") + goal::JOINT;
        }
    }

    /// Returns true if the answer is to be a goal beside those of the last round ([`Self::further`]).
    pub(crate) fn is_further(&self) -> bool {
        self.further.is_some()
    }

    /// Returns the grammar of possible continuations.
    fn grammar(&self) -> String {
        let conditions = match self.next {
            Next::Goal => goal::conditions(&self.world, &self.correction.mentions),
            _ => Vec::new(),
        };
        let more = self.preceding.len() + 1 < GOAL_LIMIT;
        let mut joints = Vec::new();
        if more && self.next == Next::Then {
            joints.push(goal::ELSE);
        }
        if more && matches!(self.next, Next::Then | Next::Otherwise) {
            joints.push(goal::AND);
        }
        if more {
            joints.push(goal::JOINT);
        }
        let must_depend = more && self.must_depend() && !conditions.is_empty();
        let place = if self.transcript.answer.is_empty() {
            Place::First {
                question: !self.tries.has_begun(),
            }
        } else {
            Place::Next
        };
        let ways = Ways {
            offers: &self.open,
            conditions: &conditions,
            joints: &joints,
            may_end: !must_depend,
        };
        goal_grammar(&self.world, &ways, place)
    }

    /// Returns the request that tells how likely a whole answer is. The reply is the answer, or the answer and the joint of a
    /// further goal.
    pub(crate) fn weighing(&self, answer: &str) -> ChatRequest {
        let form = Form::Row(vec![Form::text(answer), Form::text(goal::JOINT).optional()]);
        let tokens = STEP_TOKENS * u32::try_from(GOAL_LIMIT).unwrap_or(u32::MAX);
        self.transcript.under_grammar(form.grammar(), tokens)
    }

    /// Returns true if a goal still has to have a condition.
    fn must_depend(&self) -> bool {
        self.condition == ConditionMark::Present && !self.has_condition
    }

    /// Returns the token counts by part: `task`, `examples`, `query`, and `frame` for the chat template around the
    /// messages.
    pub fn costs(&self, counter: &mut dyn TokenCounter) -> Vec<PartCost> {
        let parts = [
            ("task", &self.transcript.messages[..1]),
            ("examples", &self.transcript.messages[1..self.transcript.fixed]),
            ("query", &self.transcript.messages[self.transcript.fixed..]),
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
    pub(super) fn look(&mut self) {
        // A goal that holds now may be undone by the goals before it; a search decides.
        let search = if self.preceding.is_empty() { 0 } else { search::EFFORT };
        let found = effort::within(effort::OPERATION + search, || self.offers());
        self.exhausted |= found.exhausted;
        self.open = found.result;
        if self.transcript.kind == ConstraintKind::JsonSchema {
            self.listed = listed_goals(&self.world, |offers| self.keep_wanted(offers));
        }
    }

    /// The part of the world that the model is shown.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the parts of an instruction of one line that the answer of a server does not represent. A text that is no
    /// quotation marks the whole instruction, so that nothing is dropped.
    ///
    /// A model under a grammar is asked for them in a [`ScreeningDialogue`](super::ScreeningDialogue).
    pub fn marks(&self, instruction: &str) -> Vec<Mark> {
        let mark = |(text, gap): &(String, Gap)| {
            Mark::of(instruction, text, *gap).unwrap_or_else(|| Mark::whole(instruction, *gap))
        };
        self.left_out.iter().map(mark).collect()
    }

    /// Returns true if enumerating the possible goals exceeded the work budget. No reply is usable then.
    pub(super) fn is_exhausted(&self) -> bool {
        self.exhausted
    }

    /// Returns the possible next goals. Where a further goal is asked for, its subject is named by the words that do so; a
    /// further try begins with another goal.
    fn offers(&self) -> Vec<Offer> {
        let further = !self.preceding.is_empty() || self.next == Next::Otherwise;
        let none = Mentions::default();
        let mentions = if self.tries.is_free() {
            &none
        } else {
            &self.correction.mentions
        };
        let mut offers = offers_on(&self.world, &self.preceding, mentions, further);
        self.keep_wanted(&mut offers);
        if !further {
            self.tries.keep(&mut offers, &self.correction.mentions.entities);
            if self.may_settle() {
                for offer in settled_offers(&self.world, &self.correction.mentions) {
                    match offers.iter_mut().find(|own| own.word == offer.word) {
                        Some(own) => own.arguments.extend(offer.arguments),
                        None => offers.push(offer),
                    }
                }
            }
        }
        offers
    }

    /// Keeps the goals about an entity that the words for a further goal name, without those of the other branch.
    fn keep_wanted(&self, offers: &mut Vec<Offer>) {
        for offer in offers.iter_mut() {
            let subject = self.world.domain().goal_word(offer.word).subject;
            offer.arguments.retain(|arguments| {
                let is_named = |words: &Mentions, place: usize| words.entities.contains(&arguments[place]);
                let is_wanted =
                    |words: &Mentions| words.entities.is_empty() || subject.is_some_and(|place| is_named(words, place));
                self.further.as_ref().is_none_or(is_wanted)
                    && !self.other_side.iter().any(|fact| fact.is_word(offer.word, arguments))
            });
        }
        offers.retain(|offer| !offer.arguments.is_empty());
    }

    /// Returns true if the answer may begin with a goal that holds already: the first answer of a model under a grammar. A
    /// server gives no likelihoods to compare.
    fn may_settle(&self) -> bool {
        let is_first = matches!(self.settled, Settled::Open) && !self.tries.has_begun();
        is_first && self.transcript.kind == ConstraintKind::Grammar
    }

    /// Puts an answer aside that begins with a goal which holds already, and returns true if it did. The next answer may not:
    /// people mostly ask for what is not so yet, and a place that they name may be where a thing is.
    fn set_aside(&mut self, goal: &Goal) -> bool {
        let is_settled = |begin: &GoalFact| is_settled(&self.world, begin);
        if !self.may_settle() || !goal.facts.first().is_some_and(is_settled) {
            return false;
        }
        self.settled = match self.is_guess(goal) || self.correction.rejected.contains(&goal.facts) {
            true => Settled::Closed,
            false => Settled::Aside(self.endings.clone(), goal.clone()),
        };
        true
    }

    /// Takes back the answer that was put aside, if it is much likelier than another one.
    fn take_back(&mut self, other: Option<i64>) -> Option<Goal> {
        match std::mem::replace(&mut self.settled, Settled::Closed) {
            Settled::Aside(endings, goal)
                if other.is_none_or(|other| endings.likelihood().saturating_sub(other) >= AHEAD) =>
            {
                self.endings = endings;
                Some(goal)
            }
            _ => None,
        }
    }

    fn supply_part(&mut self, reply: &Reply) -> Result<Option<Understanding>, DialogueError> {
        if let Some(question) = question_in(&self.transcript.answer) {
            let question = question.to_owned();
            if let Some(goal) = self.take_back(None) {
                self.candidates
                    .push(Candidate::new(question, reply.likelihood.map(|reply| reply.text)));
                return Ok(Some(self.understood(goal)));
            }
            return Ok(Some(self.asks(question, reply.likelihood.map(|reply| reply.text))));
        }
        let before = self.transcript.answer.len() - reply.text.len();
        let likelihood = reply.likelihood;
        let end = likelihood.and_then(|likelihood| self.endings.count(before, &reply.text, likelihood));
        if let Some(end) = end {
            self.transcript.answer.truncate(end);
            self.facts = ended(&self.world, &self.transcript.answer)?.facts;
            return Ok(self.done());
        }
        let begun = Begun::read(&self.world, &self.transcript.answer)?;
        (self.preceding, self.next, self.has_condition) = (begun.preceding(), begun.next, begun.has_condition());
        (self.facts, self.other_side) = (begun.facts, begun.other_side);
        if self.next != Next::Nothing {
            self.look();
            if !self.open.is_empty() {
                return Ok(None);
            }
        }
        self.facts = ended(&self.world, &self.transcript.answer)?.facts;
        Ok(self.done())
    }

    fn supply_whole(&mut self, text: &str) -> Result<Understanding, DialogueError> {
        #[derive(Deserialize)]
        struct Answer {
            question: Option<String>,
            goals: Option<Vec<String>>,
            #[serde(default)]
            never: Vec<String>,
            #[serde(default)]
            not_represented: Vec<Part>,
        }
        #[derive(Deserialize)]
        struct Part {
            text: String,
            kind: Gap,
        }
        let answer: Answer = object(text)?;
        if answer.question.is_none() && answer.goals.is_none() && answer.never.is_empty() {
            return Err(DialogueError::Unreadable(
                "it has neither `goals` nor a `question`".to_owned(),
            ));
        }
        let question = answer.question.unwrap_or_default();
        if !question.trim().is_empty() {
            return Ok(self.asks(question.trim().to_owned(), None));
        }
        let left_out = answer.not_represented.into_iter().take(GOAL_LIMIT);
        self.left_out = left_out.map(|part| (plain_line(&part.text), part.kind)).collect();
        let known = self.facts.iter().map(|fact| fact.everyday(&self.world));
        let goals = answer.goals.into_iter().flatten().take(GOAL_LIMIT);
        let never = answer.never.into_iter().take(GOAL_LIMIT);
        let never = never.map(|goal| format!("{}{goal}", goal::NEVER));
        let parts: Vec<String> = known.chain(goals).chain(never).collect();
        for part in &parts {
            self.world.add_values(part);
        }
        let goal = match parts.is_empty() {
            true => Goal::default(),
            false => goal::parse(&self.world, &parts.join(" & "))?,
        };
        self.weigh(&goal);
        Ok(self.understood(goal))
    }

    /// Ends an answer. A guess is followed by another try, and so is an answer that the person has rejected.
    fn done(&mut self) -> Option<Understanding> {
        let goal = Goal::from(std::mem::take(&mut self.facts));
        self.weigh(&goal);
        let again = match self.correction.rejected.contains(&goal.facts) {
            _ if self.set_aside(&goal) => true,
            true => self.tries.refuse(&goal),
            false => self.is_guess(&goal) && self.tries.again(&self.endings, &goal),
        };
        if again {
            self.transcript.answer.clear();
            self.preceding.clear();
            self.other_side.clear();
            self.next = Next::Goal;
            self.has_condition = false;
            self.look();
            if !self.open.is_empty() {
                self.endings = Endings::default();
                return None;
            }
        }
        let (endings, goal) = self.tries.likeliest(std::mem::take(&mut self.endings), goal);
        self.endings = endings;
        let aside = self.take_back(Some(self.endings.likelihood()));
        Some(self.understood(aside.unwrap_or(goal)))
    }

    /// Returns true if the model finds its first answer, or a further goal, unlikely.
    fn is_guess(&self, goal: &Goal) -> bool {
        let least = self.least(goal.depends());
        least.is_some_and(|least| self.endings.likelihood() < least)
    }

    /// Returns the likelihood below which an answer is a guess; none if no answer is.
    fn least(&self, depends: bool) -> Option<i64> {
        let names_entities = !self.correction.mentions.entities.is_empty();
        let may_guess = self.is_first || self.is_further();
        may_guess.then(|| self.endings.least(names_entities, depends)).flatten()
    }

    fn understood(&mut self, goal: Goal) -> Understanding {
        let text = goal.everyday(&self.world).join(" & ");
        if let Some(candidate) = self.candidates.iter_mut().find(|candidate| candidate.text == text) {
            candidate.chosen = true;
        }
        let (is_guess, is_empty) = (self.is_guess(&goal), goal.is_empty());
        self.limit = self.least(goal.depends());
        let may_doubt = self.is_first && self.endings.weighed().is_some();
        let understanding = match understand_mentions(&self.world, &self.correction.mentions, goal) {
            Understanding::Goal(goal) | Understanding::Doubtful(goal) if is_guess => {
                self.doubt = Some(Doubt::Unlikely);
                return Understanding::Question(guess(&self.world, &goal));
            }
            understanding if may_doubt => understanding,
            understanding => understanding.asked(&self.world),
        };
        self.doubt = match &understanding {
            Understanding::Goal(_) => None,
            Understanding::Which(_) => Some(Doubt::Several),
            Understanding::Question(_) if is_empty => Some(Doubt::NoGoal),
            Understanding::Question(_) | Understanding::Doubtful(_) => Some(Doubt::Unnamed),
        };
        understanding
    }

    /// Ends an answer that is a question of the model.
    fn asks(&mut self, question: String, likelihood: Option<i64>) -> Understanding {
        let mut candidate = Candidate::new(question.clone(), likelihood);
        candidate.chosen = true;
        self.candidates.push(candidate);
        self.limit = self.least(false);
        self.doubt = Some(Doubt::Asks);
        Understanding::Question(question)
    }

    /// Notes an answer.
    fn weigh(&mut self, goal: &Goal) {
        let text = goal.everyday(&self.world).join(" & ");
        self.candidates.push(Candidate::new(text, self.endings.weighed()));
    }

    /// Returns the answers that were weighed, for words that were read.
    pub fn reading(&self, of: ReadingOf, words: &str) -> Reading {
        let is_weighed = self.candidates.iter().any(|candidate| candidate.likelihood.is_some());
        Reading {
            of,
            words: words.to_owned(),
            candidates: self.candidates.clone(),
            least: self.limit.filter(|_| is_weighed).map(nats),
            doubt: self.doubt,
        }
    }
}

/// The answer that begins with a goal which holds already.
#[derive(Debug, Clone, Default)]
enum Settled {
    /// The model may still write one.
    #[default]
    Open,
    /// It wrote this one, and is writing another answer to compare it with.
    Aside(Endings, Goal),
    /// There is none any more.
    Closed,
}

impl Dialogue for GoalDialogue {
    type Output = Understanding;

    fn request(&self) -> ChatRequest {
        match self.transcript.kind {
            ConstraintKind::Grammar => self.transcript.under_grammar(self.grammar(), QUESTION_TOKENS),
            ConstraintKind::JsonSchema => {
                let depends = !goal::conditions(&self.world, &self.correction.mentions).is_empty();
                self.transcript
                    .under_schema(goal_schema(self.listed.as_deref(), depends), ANSWER_TOKENS)
            }
        }
    }

    /// Interprets the reply to the last request.
    ///
    /// # Errors
    ///
    /// The reply is cut off, refused or invalid, or enumerating its continuations exceeds the work budget.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Understanding>, DialogueError> {
        self.transcript.receive(reply)?;
        let understood = match self.transcript.kind {
            _ if self.exhausted => return Err(DialogueError::TooMuchWork),
            ConstraintKind::Grammar => self.supply_part(reply),
            ConstraintKind::JsonSchema => {
                let read = self.supply_whole(&reply.text);
                self.transcript.read_or_repeat(reply, read)
            }
        }?;
        match self.exhausted {
            true => Err(DialogueError::TooMuchWork),
            false => Ok(understood),
        }
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
