//! The request for the meaning of an instruction, and what becomes of the replies.

use serde::Deserialize;
use serde_json::{Value, json};

use super::answer::{self, ModelAnswer};
use super::interpretation::Interpretation;
use super::profile::Profile;
use super::question::{Question, which};
use super::request;
use crate::coverage::{Gap, LeftOut};
use crate::dialogue::answer_grammar::{Form, closed};
use crate::dialogue::{
    Candidate, ChatRequest, ConstraintKind, Decision, Dialogue, DialogueError, PartCost, Reading, Reply, Round, Task,
    TokenCounter, Transcript, object, plain_line,
};
use crate::effort;
use crate::environment::World;
use crate::goal::{self, GoalError};
use crate::instruction::Mentions;
use crate::model::Domain;

/// The token budget of an answer under a grammar.
const GRAMMAR_TOKENS: u32 = 384;
/// The token budget of the beginning of a prohibition. A whole one is no likelier, so that one which is unlikely here is not written.
const BEGINNING_TOKENS: u32 = 2;
/// The token budget of a server's answer.
pub(super) const ANSWER_TOKENS: u32 = 1024;

/// The words of a person, and where they were said.
#[derive(Debug, Clone, Copy)]
pub struct UnderstandingInput<'a> {
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
    /// The worked examples of the domain in the request.
    pub examples: Examples,
}

impl<'a> UnderstandingInput<'a> {
    /// The inputs for an instruction without earlier rounds.
    pub fn new(domain: &'a Domain, world: &'a World, instruction: &'a str, kind: ConstraintKind) -> Self {
        Self {
            domain,
            world,
            instruction,
            rounds: &[],
            kind,
            examples: Examples::of(kind),
        }
    }
}

/// Worked examples of a domain that a request has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Examples {
    /// All.
    All,
    /// [`Examples::FEW`] at most: first those that show a form of a goal, or a question, that none before them shows. An embedded model reads 70
    /// tokens for each, half a second on two cores.
    Few,
}

impl Examples {
    /// The largest number of a few examples.
    pub const FEW: usize = 16;

    /// Returns the examples for a kind of model. A server reads all of them in no time.
    pub fn of(kind: ConstraintKind) -> Self {
        match kind {
            ConstraintKind::Grammar => Self::Few,
            _ => Self::All,
        }
    }
}

/// Lets a model say what an instruction means. One request; a second one where a model under a grammar would ask: for the goal that it
/// takes to be meant, which decides whether to ask, and what. A model that was trained for the request is asked for two tokens more behind a
/// goal that forbids nothing: how likely it finds a prohibition there ([`Profile::prohibition`]).
///
/// ```
/// use longstep::dialogue::{ConstraintKind, Dialogue, Reply};
/// use longstep::understanding::{Understanding, UnderstandingInput};
/// let planner = longstep::Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let says = "Put the pen on the shelf by noon";
/// let input = UnderstandingInput::new(planner.domain(), &world, says, ConstraintKind::JsonSchema);
/// let mut understanding = Understanding::new(input);
/// let reply = r#"{"goal": "put(pen, shelf)", "left_out": [{"text": "by noon", "kind": "time"}], "question": ""}"#;
/// let meaning = understanding.supply(&Reply::complete(reply)).unwrap().unwrap();
/// assert_eq!(meaning.goal.unwrap().everyday(&world), ["put(pen, shelf)"]);
/// assert_eq!(meaning.left_out[0].text, "by noon");
/// assert_eq!(meaning.question, None);
/// # Ok::<(), longstep::Error>(())
/// ```
#[derive(Debug, Clone)]
pub struct Understanding {
    transcript: Transcript,
    world: World,
    /// The words of the person, the last ones last.
    words: String,
    /// The names in the words.
    mentions: Mentions,
    /// False once the model has asked: the next answer is a goal.
    asks: bool,
    candidates: Vec<Candidate>,
    /// The goal that will be acted on unless a prohibition behind it is likely.
    second_look: Option<SecondLook>,
    /// True if showing the scene, or the possible answers, takes too much work.
    is_exhausted: bool,
}

/// A goal without a prohibition, whose instruction may have one: the model goes on behind its answer with a prohibition, and what counts is
/// how likely it finds that.
#[derive(Debug, Clone)]
struct SecondLook {
    read: ModelAnswer,
    profile: Profile,
    decision: Decision,
    /// The form of the prohibitions.
    form: Form,
    /// False while only the beginning is asked for.
    is_whole: bool,
}

impl SecondLook {
    fn is_likely(&self, reply: &Reply) -> bool {
        let likelihood = reply.likelihood.map(|own| own.text);
        matches!((self.profile.prohibition, likelihood), (Some(limit), Some(own)) if own >= limit)
    }
}

/// The answer of a server. Models without an enforced schema also write a list of goals, and null for nothing.
#[derive(Debug, Default, Deserialize)]
#[serde(default)]
struct Written {
    #[serde(alias = "goals")]
    goal: Texts,
    left_out: Option<Vec<WrittenPart>>,
    question: Texts,
}

/// A text, the parts of one, or nothing.
#[derive(Debug, Default, Deserialize)]
#[serde(untagged)]
enum Texts {
    #[default]
    None,
    One(String),
    Several(Vec<String>),
}

impl Texts {
    fn joined(self) -> String {
        match self {
            Self::None => String::new(),
            Self::One(text) => text.trim().to_owned(),
            Self::Several(texts) => texts.join(" & "),
        }
    }
}

#[derive(Debug, Deserialize)]
#[serde(untagged)]
enum WrittenPart {
    Kind { text: String, kind: String },
    Text(String),
}

impl From<WrittenPart> for LeftOut {
    /// A kind that is none of ours may be anything.
    fn from(part: WrittenPart) -> Self {
        let (text, kind) = match part {
            WrittenPart::Kind { text, kind } => (text, Gap::named(kind.trim())),
            WrittenPart::Text(text) => (text, None),
        };
        Self {
            text,
            kind: kind.unwrap_or(Gap::Wish),
        }
    }
}

impl Understanding {
    /// Starts the request.
    pub fn new(input: UnderstandingInput<'_>) -> Self {
        let UnderstandingInput {
            domain,
            world,
            instruction,
            rounds,
            kind,
            examples,
        } = input;
        let messages = || request::messages(domain, world, instruction, rounds, kind, examples);
        let shown = effort::within(effort::OPERATION, messages);
        let (mut fixed, count) = shown.result;
        let own = fixed.split_off(count);
        let mut transcript = Transcript::new(kind, fixed).for_task(Task::Goals);
        for message in own {
            transcript.push(message.role, message.text);
        }
        let mut mentions = Mentions::of(world, instruction);
        let mut words = plain_line(instruction);
        for round in rounds {
            mentions.add(world, Mentions::of(world, &round.message));
            words = format!("{words} {}", plain_line(&round.message));
        }
        Self {
            transcript,
            world: world.clone(),
            words,
            mentions,
            asks: true,
            candidates: Vec::new(),
            second_look: None,
            is_exhausted: shown.exhausted,
        }
    }

    /// Returns the part of the world that the model is shown.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns true if showing the scene took too much work. No reply is usable then.
    pub(super) fn is_exhausted(&self) -> bool {
        self.is_exhausted
    }

    /// Returns the token counts by part: `task`, `examples`, `query`, and `frame` for the chat template around the messages.
    pub fn costs(&self, counter: &mut dyn TokenCounter) -> Vec<PartCost> {
        let messages = self.transcript.messages();
        let fixed = self.transcript.fixed();
        let parts = [
            ("task", &messages[..1]),
            ("examples", &messages[1..fixed]),
            ("query", &messages[fixed..]),
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

    /// Reads the reply of a model under a grammar; none for one that asks, whose best goal is asked for next.
    fn read_under_grammar(&mut self, reply: &Reply) -> Result<Option<Interpretation>, DialogueError> {
        let text = self.transcript.answer().trim().to_owned();
        let likelihood = reply.likelihood.map(|own| own.text);
        self.candidates.push(Candidate::new(text.clone(), likelihood));
        goal::add_values(&mut self.world, &text);
        let read = match answer::read(&self.world, &text) {
            Ok(read) => read,
            // A group without a member, or what can never hold: the grammar does not look that far.
            Err(DialogueError::NoGoal(error)) => return Ok(Some(self.impossible(&error))),
            Err(error) => return Err(error),
        };
        let has_asked = !self.asks;
        if read.goal.is_none() && self.asks && answer::can_say_goals(&self.world) {
            self.asks = false;
            self.transcript.clear_answer();
            return Ok(None);
        }
        let profile = match reply.likelihood {
            None => Profile::BELIEVED,
            Some(own) if own.is_trained => Profile::TRAINED,
            Some(_) => Profile::UNTRAINED,
        };
        let ahead = reply.likelihood.and_then(|own| own.ahead);
        let likelihood = likelihood.filter(|_| read.goal.is_some());
        let decision = profile.decide(has_asked || read.goal.is_none(), likelihood, ahead);
        if let Some(form) = self.form_of_second_look(&read, &profile, decision) {
            let (goal, _) = answer::split(&text);
            self.transcript.begin_answer(goal.trim());
            self.second_look = Some(SecondLook {
                read,
                profile,
                decision,
                form,
                is_whole: false,
            });
            return Ok(None);
        }
        Ok(Some(self.interpreted(read, profile, decision, String::new())))
    }

    /// Returns the form of the prohibitions that may be missing in an answer; none if the model need not be asked for them.
    fn form_of_second_look(&self, read: &ModelAnswer, profile: &Profile, decision: Decision) -> Option<Form> {
        profile.prohibition?;
        let goal = read.goal.as_ref()?;
        let says_one = read.left_out.iter().any(|part| part.kind == Gap::Prohibition);
        if !decision.acts() || says_one || !goal.constraints.is_empty() {
            return None;
        }
        answer::more_constraints(&self.world)
    }

    /// Reads what the model would forbid, and how likely it finds that. Asks about a prohibition that is not unlikely.
    fn looked_again(&mut self, mut look: SecondLook, reply: &Reply) -> Result<Option<Interpretation>, DialogueError> {
        let is_likely = look.is_likely(reply);
        if is_likely && !look.is_whole {
            self.transcript.receive_beginning(reply);
            look.is_whole = true;
            self.second_look = Some(look);
            return Ok(None);
        }
        let likelihood = reply.likelihood.map(|own| own.text);
        let place = self.candidates.len().saturating_sub(1);
        let forbidden = Candidate::new(reply.text.trim().to_owned(), likelihood);
        if !is_likely {
            self.transcript.receive_beginning(reply);
            self.candidates.insert(place, forbidden);
            return Ok(Some(self.interpreted(
                look.read,
                look.profile,
                look.decision,
                String::new(),
            )));
        }
        self.transcript.receive(reply)?;
        self.candidates.push(forbidden);
        let with = answer::read(&self.world, self.transcript.answer())?;
        let read = ModelAnswer {
            left_out: look.read.left_out,
            ..with
        };
        let decision = Decision::AskForProhibition;
        Ok(Some(self.interpreted(read, look.profile, decision, String::new())))
    }

    /// Asks about an answer that is no goal in this world.
    fn impossible(&mut self, error: &GoalError) -> Interpretation {
        let asked = format!("I cannot do it like that: {error}. What should I do?");
        self.interpreted(ModelAnswer::default(), Profile::BELIEVED, Decision::Ask, asked)
    }

    /// Reads the reply of a server.
    fn read_object(&mut self, text: &str) -> Result<Interpretation, DialogueError> {
        let written: Written = object(text)?;
        let (goal, asked) = (written.goal.joined(), written.question.joined());
        if goal.is_empty() {
            if asked.is_empty() {
                return Err(DialogueError::Unreadable(
                    "it has neither a goal nor a question".to_owned(),
                ));
            }
            self.candidates.push(Candidate::new(asked.clone(), None));
            return Ok(self.interpreted(ModelAnswer::default(), Profile::BELIEVED, Decision::Ask, asked));
        }
        goal::add_values(&mut self.world, &goal);
        let mut read = answer::read(&self.world, &goal)?;
        let left_out = written.left_out.into_iter().flatten();
        read.left_out.extend(left_out.map(LeftOut::from));
        self.candidates.push(Candidate::new(goal, None));
        let decision = Profile::BELIEVED.decide(!asked.is_empty(), None, None);
        Ok(self.interpreted(read, Profile::BELIEVED, decision, asked))
    }

    fn interpreted(
        &mut self,
        read: ModelAnswer,
        profile: Profile,
        decision: Decision,
        asked: String,
    ) -> Interpretation {
        if let Some(last) = self.candidates.last_mut() {
            last.chosen = true;
        }
        let ModelAnswer { goal, left_out } = read;
        let which = match &goal {
            Some(goal) if profile.asks_which && decision.acts() => which(&self.world, &self.mentions, goal),
            _ => None,
        };
        let decision = if which.is_some() { Decision::AskWhich } else { decision };
        let (goal, question) = match decision {
            Decision::AskWhich => (None, which),
            Decision::Act | Decision::ActOnOnly | Decision::ActInsteadOfAsking => (goal, None),
            Decision::Ask if !asked.is_empty() => (goal, Some(asked)),
            Decision::Ask | Decision::AskForUnlikely | Decision::AskForProhibition => {
                let question = Question::about(&self.world, &self.mentions, goal);
                (question.goal, Some(question.text))
            }
        };
        Interpretation {
            goal,
            left_out,
            question,
            reading: Reading {
                words: self.words.clone(),
                candidates: std::mem::take(&mut self.candidates),
                profile: profile.name.to_owned(),
                decision,
                least: profile.limit(decision),
            },
        }
    }

    fn schema() -> Value {
        let text = || json!({"type": "string"});
        let kinds = json!({"type": "string", "enum": Gap::ALL.map(Gap::name)});
        let part = closed(&[("text", text()), ("kind", kinds)]);
        closed(&[
            ("goal", text()),
            ("left_out", json!({"type": "array", "items": part})),
            ("question", text()),
        ])
    }
}

impl Dialogue for Understanding {
    type Output = Interpretation;

    fn request(&self) -> ChatRequest {
        match self.transcript.kind {
            ConstraintKind::Grammar => {
                let (form, tokens) = match &self.second_look {
                    Some(look) if look.is_whole => (look.form.clone(), GRAMMAR_TOKENS),
                    Some(look) => (look.form.clone(), BEGINNING_TOKENS),
                    None => (answer::form(&self.world, &self.words, self.asks), GRAMMAR_TOKENS),
                };
                self.transcript.under_grammar(form.grammar(), tokens)
            }
            ConstraintKind::JsonSchema => self.transcript.under_schema(Self::schema(), ANSWER_TOKENS),
        }
    }

    /// Interprets the reply to the last request.
    ///
    /// # Errors
    ///
    /// The reply is cut off or refused, or no goal in this world.
    fn supply(&mut self, reply: &Reply) -> Result<Option<Interpretation>, DialogueError> {
        if self.is_exhausted {
            return Err(DialogueError::TooMuchWork);
        }
        if let Some(look) = self.second_look.take() {
            return self.looked_again(look, reply);
        }
        self.transcript.receive(reply)?;
        match self.transcript.kind {
            ConstraintKind::Grammar => self.read_under_grammar(reply),
            ConstraintKind::JsonSchema => {
                let read = self.read_object(&reply.text);
                match self.transcript.read_or_repeat(reply, read) {
                    // It was told what is wrong, and says it again: an amount that is out of range, say.
                    Err(DialogueError::NoGoal(error)) => Ok(Some(self.impossible(&error))),
                    read => read,
                }
            }
        }
    }

    fn transcript(&self) -> &Transcript {
        &self.transcript
    }
}
