//! Sessions: a sequence of instructions in one world, as a state machine.
//!
//! A [`Session`] performs no I/O and never waits. [`Session::next_request`] returns the request for the model, whose
//! reply is its input ([`Session::supply`]). When there is none, [`Session::response`] shows the state to the person, whose
//! inputs are [`Session::instruct`], [`Session::answer`], [`Session::feedback`] and [`Session::accept`]. The program, a server, a notebook and an evaluation can therefore share one loop. Each
//! instruction starts in the simulated final world of the last accepted plan, or in the world that was observed since
//! ([`Session::observed`]).
//!
//! Every change is recorded as an [`Event`] ([`Session::take_events`]). A session is a function of its inputs, so
//! [`Session::resume`] can restore it from its events.
//!
//! ```
//! use longstep::Planner;
//! use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
//! use longstep::session::{ModelFacts, Settings};
//!
//! let planner = Planner::shipped("household")?;
//! let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
//!     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
//! let model = ModelFacts::new("mine", ConstraintKind::JsonSchema);
//! let mut session = planner.session(world, Settings::default(), model)?;
//!
//! session.instruct("The pen belongs on the shelf")?;
//! let prepared = session.next_request(&mut EstimatedTokens::default())?.unwrap();
//! assert!(prepared.request.messages.last().unwrap().text.contains("The pen belongs on the shelf"));
//! // The owner of the model sends the request; this is its reply.
//! let text = r#"{"goal": "put(pen, shelf)", "left_out": [], "question": ""}"#;
//! session.supply(&Reply::complete(text), 740.0)?;
//!
//! let proposal = session.proposal().unwrap();
//! assert_eq!(proposal.plan.steps().len(), 6);
//! session.accept()?;
//! assert_eq!(session.world().environment().object_states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod accepted;
mod asking;
#[cfg(test)]
mod branching_tests;
#[cfg(test)]
mod coverage_tests;
mod direct;
mod ended;
mod event;
#[cfg(test)]
mod injected;
mod input;
mod log;
mod meaning;
mod observed;
#[cfg(test)]
mod observed_tests;
mod pending;
mod refusal;
mod reread;
#[cfg(test)]
mod reread_tests;
mod resume;
mod rules;
#[cfg(test)]
mod rules_tests;
mod settings;
mod stage;
#[cfg(test)]
mod tests;
#[cfg(test)]
mod value_tests;
mod why;

pub use accepted::Accepted;
pub use ended::Ended;
pub use event::{Event, MessageRecord, StepRecord, UsageRecord, VERSION};
pub use log::{Entry, Log, LogError};
pub use observed::{ObserveError, Observed};
pub use refusal::{Failure, Refusal};
pub use resume::{Replay, ReplayDifference, ResumeError, Resumed, replay};
pub use rules::RuleError;
pub use settings::{ModelFacts, RepairPolicy, Settings, Strategy};
pub use stage::{OutOfTurn, Proposal, Response};
pub use why::{Why, why};

use std::sync::Arc;

use crate::clock::Clock;
use crate::dialogue::{Counting, Message, Prepared, PromptError, Reading, TokenCounter, Usage};
use crate::environment::World;
use crate::model::Domain;
use crate::plan::PlanFile;
use crate::report::{Answer, Status};
use crate::search::Limits;

use observed::{Pending, Taken};
use stage::{Stage, Turn};

/// A sequence of instructions in a changing world.
///
/// Inputs of the person are [`instruct`](Self::instruct), [`answer`](Self::answer), [`feedback`](Self::feedback),
/// [`accept`](Self::accept), [`cancel`](Self::cancel) and [`undo`](Self::undo); those of the model are
/// [`supply`](Self::supply) and [`failed`](Self::failed). An input that does not fit the state is an error and changes
/// nothing.
///
/// # Example
///
/// A script takes the place of the model.
///
/// ```
/// use longstep::Planner;
/// use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
/// use longstep::session::{ModelFacts, Response, Settings};
/// let planner = Planner::shipped("household")?;
/// let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
///     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
/// let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
/// let mut session = planner.session(world, Settings::default(), script)?;
///
/// session.instruct("Put it on the shelf")?;
/// assert!(session.next_request(&mut EstimatedTokens::default())?.is_some());
/// session.supply(&Reply::complete(r#"{"question": "Which one?", "goal": "", "left_out": []}"#), 700.0)?;
/// assert_eq!(session.question(), Some("Which one?"));
///
/// session.answer("the pen")?;
/// assert!(session.wants_model() && matches!(session.response(), Response::Waiting));
/// session.next_request(&mut EstimatedTokens::default())?;
/// session.supply(&Reply::complete(r#"{"question": "", "goal": "put(pen, shelf)", "left_out": []}"#), 740.0)?;
/// let Response::Plan(proposal) = session.response() else { panic!() };
/// assert_eq!((proposal.plan.steps().len(), session.cost().1), (6, 1440.0));
///
/// session.accept()?;
/// assert_eq!(session.accepted()[0].instruction, "Put it on the shelf");
/// assert!(session.plan_file(0).is_some() && session.instruction().is_none());
/// assert_eq!(session.undo()?, 0);
/// assert!(session.accepted().is_empty() && session.accept().is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Debug, Clone)]
pub struct Session {
    domain: Arc<Domain>,
    settings: Settings,
    model: ModelFacts,
    world: World,
    accepted: Vec<Accepted>,
    pending: Pending,
    /// The observations so far, in order.
    observations: Vec<Taken>,
    stage: Stage,
    /// Distinct fixed prompt parts of the requests so far.
    prompts: Vec<Vec<Message>>,
    events: Vec<Event>,
    limits: Limits,
    clock: Clock,
}

impl Session {
    /// Starts a session. `domain_name` identifies the domain in the log: its name or folder. [`Planner::session`] does it
    /// with the limits and the clock of a planner.
    ///
    /// [`Planner::session`]: crate::Planner::session
    pub fn new(
        domain_name: &str,
        domain: impl Into<Arc<Domain>>,
        world: World,
        settings: Settings,
        model: ModelFacts,
        clock: Clock,
    ) -> Self {
        let begin = Event::Begin {
            version: VERSION,
            domain: domain_name.to_owned(),
            environment: Box::new(world.environment().clone()),
            settings,
        };
        let mut session = Self {
            domain: domain.into(),
            settings,
            model: model.clone(),
            world,
            accepted: Vec::new(),
            pending: Pending::default(),
            observations: Vec::new(),
            stage: Stage::Idle,
            prompts: Vec::new(),
            events: vec![begin],
            limits: Limits::default(),
            clock,
        };
        session.set_model(model);
        let rules = session.world.prohibitions().iter();
        let rules: Vec<Event> = rules
            .map(|rule| Event::Rule {
                text: rule.written.clone(),
            })
            .collect();
        session.events.extend(rules);
        session
    }

    /// Sets the limits of searches.
    pub(crate) fn limited(self, limits: Limits) -> Self {
        Self { limits, ..self }
    }

    /// Returns the next request for the model; none when it is the person's turn, see [`Session::response`]. `counter`
    /// counts tokens as the model does; it is used only if the context length is known. See the
    /// [example](Self#example).
    ///
    /// # Errors
    ///
    /// The prompt exceeds the context length even after shortening, or the domain's prompt cannot be rendered. The
    /// instruction then has no plan.
    pub fn next_request(&mut self, counter: &mut dyn TokenCounter) -> Result<Option<Box<Prepared>>, PromptError> {
        match std::mem::replace(&mut self.stage, Stage::Idle) {
            Stage::Asking(turn, asking) => {
                let counter = match self.model.context {
                    Some(_) => counter,
                    None => &mut Uncounted,
                };
                self.request(turn, asking, counter)
            }
            other => {
                self.stage = other;
                Ok(None)
            }
        }
    }

    /// Returns the state for the person. See the [example](Self#example).
    pub fn response(&self) -> Response<'_> {
        match &self.stage {
            Stage::Idle => Response::Ready,
            Stage::Asking(..) => Response::Waiting,
            Stage::Question(_, _, question) => Response::Question(question),
            Stage::Proposed(turn) => match turn.proposal.as_deref() {
                Some(proposal) if proposal.question.is_some() => Response::Consent(proposal),
                Some(proposal) => Response::Plan(proposal),
                None => Response::Ready,
            },
            Stage::Stuck(_, failure) => Response::NoPlan(failure),
            Stage::Ending(_) => Response::Endings(self.endings()),
        }
    }

    /// Returns what came of the instruction as an answer, as the program prints it: a plan, a question, or the reasons why
    /// there is no plan. None between instructions, while a model works, and for a [failure](Session::failure) that says
    /// nothing about plans.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Settings};
    /// use longstep::report::Status;
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"]}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put it on the shelf")?;
    /// assert!(session.report().is_none());
    /// # session.next_request(&mut EstimatedTokens::default())?;
    /// session.supply(&Reply::complete(r#"{"question": "Which one?", "goal": "", "left_out": []}"#), 700.0)?;
    /// let answer = session.report().unwrap();
    /// assert_eq!((answer.status, answer.plan.question.as_str()), (Status::Question, "Which one?"));
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn report(&self) -> Option<Answer> {
        match self.response() {
            Response::Plan(proposal) => Some(proposal.answer.clone()),
            Response::Consent(proposal) => {
                let question = proposal.question.as_deref().unwrap_or_default();
                Some(proposal.answer.as_question(&self.world, question))
            }
            Response::Question(question) => {
                let instruction = self.instruction().unwrap_or_default();
                let mut answer = Answer::without_plan(Status::Question, &self.world, instruction, question);
                let (usage, milliseconds) = self.cost();
                answer.usage = usage.into();
                answer.readings = self.readings().to_vec();
                answer.timings_ms.model = milliseconds;
                Some(answer)
            }
            Response::NoPlan(failure) => failure.answer().cloned(),
            Response::Ready | Response::Waiting | Response::Endings(_) => None,
        }
    }

    /// Returns the next request with its token counts by part, or none if no model reply is pending.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put the pen on the shelf")?;
    /// let prepared = session.explain(&mut EstimatedTokens::default())?.unwrap();
    /// assert!(!prepared.costs.is_empty() && session.wants_model());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    ///
    /// # Errors
    ///
    /// As for [`Session::next_request`].
    pub fn explain(&mut self, counter: &mut dyn TokenCounter) -> Result<Option<Prepared>, PromptError> {
        match std::mem::replace(&mut self.stage, Stage::Idle) {
            Stage::Asking(turn, asking) => self
                .request(turn, asking, counter)
                .map(|prepared| prepared.map(|prepared| *prepared)),
            other => {
                self.stage = other;
                Ok(None)
            }
        }
    }

    /// Returns the events since the last call. [`Planner::resume`](crate::Planner::resume) restores the session from all
    /// of them.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// assert_eq!(session.take_events().len(), 2); // the beginning, and the model
    /// session.instruct("Put the pen on the shelf")?;
    /// session.cancel()?;
    /// assert_eq!(session.take_events().len(), 2);
    /// assert!(session.take_events().is_empty());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn take_events(&mut self) -> Vec<Event> {
        std::mem::take(&mut self.events)
    }

    /// Returns the domain.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// Returns the world before the current instruction.
    pub fn world(&self) -> &World {
        &self.world
    }

    /// Returns the settings.
    pub fn settings(&self) -> Settings {
        self.settings
    }

    /// Returns the accepted plans, in order. See the [example](Self#example).
    pub fn accepted(&self) -> &[Accepted] {
        &self.accepted
    }

    /// Returns the plan that waits for a decision. See the [example](Self#example).
    pub fn proposal(&self) -> Option<&Proposal> {
        match &self.stage {
            Stage::Proposed(turn) => turn.proposal.as_deref(),
            _ => None,
        }
    }

    /// Returns the reason why the instruction failed, if it did. Another instruction or feedback may follow.
    ///
    /// ```
    /// # use longstep::Planner;
    /// # use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
    /// # use longstep::session::{ModelFacts, Response, Settings};
    /// # let planner = Planner::shipped("household")?;
    /// # let world = planner.world(r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
    /// #     "object_states": {"<pen>": "on_something(<desk>)"}}"#)?;
    /// # let script = ModelFacts::new("script", ConstraintKind::JsonSchema);
    /// # let mut session = planner.session(world, Settings::default(), script)?;
    /// session.instruct("Put the pen on the shelf")?;
    /// session.failed("the server is down")?;
    /// assert_eq!(session.failure().unwrap().to_string(), "the server is down");
    /// assert!(matches!(session.response(), Response::NoPlan(_)));
    /// session.instruct("Put the pen on the shelf")?;
    /// assert!(session.failure().is_none());
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn failure(&self) -> Option<&Failure> {
        match &self.stage {
            Stage::Stuck(_, failure) => Some(failure),
            _ => None,
        }
    }

    /// Returns the question that waits for the person's answer. See the [example](Self#example).
    pub fn question(&self) -> Option<&str> {
        match &self.stage {
            Stage::Question(_, _, question) => Some(question),
            _ => None,
        }
    }

    /// Returns true if the session waits for a model's reply. See the [example](Self#example).
    pub fn wants_model(&self) -> bool {
        matches!(self.stage, Stage::Asking(..))
    }

    /// Returns the current model.
    pub fn model(&self) -> &ModelFacts {
        &self.model
    }

    /// Returns the current instruction. See the [example](Self#example).
    pub fn instruction(&self) -> Option<&str> {
        self.turn().map(|turn| turn.instruction.as_str())
    }

    /// Returns how the last words of the person were understood: the answers of the model, and the row of the table that
    /// decided. Empty between instructions.
    pub fn readings(&self) -> &[Reading] {
        self.turn().map_or(&[], |turn| &turn.readings)
    }

    fn turn(&self) -> Option<&Turn> {
        match &self.stage {
            Stage::Idle | Stage::Ending(_) => None,
            Stage::Asking(turn, _) | Stage::Question(turn, ..) | Stage::Proposed(turn) | Stage::Stuck(turn, _) => {
                Some(turn)
            }
        }
    }

    /// Returns the token counts of the current instruction so far, and the time of its model calls in milliseconds. See
    /// the [example](Self#example).
    pub fn cost(&self) -> (Usage, f64) {
        self.turn()
            .map_or_else(Default::default, |turn| (turn.usage, turn.model_milliseconds))
    }

    /// Returns the accepted plan with this number, from 0, in its saved form, with its domain. See the
    /// [example](Self#example).
    pub fn plan_file(&self, number: usize) -> Option<PlanFile> {
        Some(self.accepted.get(number)?.file().of_domain(self.domain()))
    }

    fn out_of_turn(&self, what: &'static str) -> OutOfTurn {
        let state = match &self.stage {
            Stage::Idle => "waits for an instruction",
            Stage::Asking(..) => "waits for a model's reply",
            Stage::Question(..) => "waits for an answer",
            Stage::Proposed(_) => "waits for a decision on a plan",
            Stage::Stuck(..) => "waits for other words",
            Stage::Ending(_) => "waits to be told how the last plan ended",
        };
        OutOfTurn { what, state }
    }

    fn propose(&mut self, mut turn: Turn, proposal: Proposal) {
        self.verdict(&proposal.answer);
        self.world.share_values(proposal.plan.world());
        turn.proposal = Some(Box::new(proposal));
        // The round stays: it is part of how this goal came about.
        turn.rereading = None;
        let asks = turn
            .proposal
            .as_ref()
            .is_some_and(|proposal| proposal.question.is_some());
        self.stage = Stage::Proposed(turn);
        if self.settings.accept && !asks {
            // The line above proposes a plan, so this cannot fail.
            let _ = self.accept();
        }
    }

    fn ask_person(&mut self, turn: Turn, reply: String, question: String) {
        self.events.push(Event::Question {
            text: question.clone(),
            readings: turn.readings.clone(),
        });
        self.stage = Stage::Question(turn, reply, question);
    }

    /// Ends an instruction without a plan, or refuses feedback and keeps the proposed plan.
    fn give_up(&mut self, turn: Turn, failure: Failure) {
        if let Some(answer) = failure.answer() {
            self.verdict(answer);
        }
        if turn.rereading.is_some() {
            self.end_rereading(turn, Refusal::FurtherGoal(failure));
        } else if turn.proposal.is_some() {
            self.refuse(turn, vec![Refusal::Failure(failure)]);
        } else {
            self.events.push(Event::Stuck {
                why: failure.to_string(),
            });
            self.stage = Stage::Stuck(turn, failure);
        }
    }

    fn verdict(&mut self, answer: &Answer) {
        // Serialization cannot fail: an answer is plain data with string keys.
        let answer = serde_json::to_value(answer).unwrap_or_default();
        self.events.push(Event::Verdict { answer });
    }
}

/// A token counter for models without a known context length. It always returns zero.
struct Uncounted;

impl TokenCounter for Uncounted {
    fn message_tokens(&mut self, _: &Message) -> u64 {
        0
    }

    fn frame_tokens(&mut self) -> u64 {
        0
    }

    fn counting(&self) -> Counting {
        Counting::Estimate("nothing is counted".to_owned())
    }
}
