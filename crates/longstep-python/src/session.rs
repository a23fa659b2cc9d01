//! Sessions: instructions one after the other, in a world that changes with them.

use std::sync::{Arc, Mutex, MutexGuard};

use jiff::Timestamp;
use longstep::Planner;
use longstep::domain::Domain as LoadedDomain;
use longstep::report::{Answer as Report, Status};
use longstep::session::{
    Accepted, Entry, ObserveError, OutOfTurn, Proposal, Response, RuleError, Session as OwnSession, Settings, Strategy,
};
use longstep_llm::{AdvanceError, ChatModel, Progress, advance};
use pyo3::exceptions::PyValueError;
use pyo3::gc::{PyTraverseError, PyVisit};
use pyo3::prelude::*;

use crate::answer::Answer;
use crate::assess::{EffortArgument, clock};
use crate::callable::{Callable, CallableModel};
use crate::failure::Failure;
use crate::interpreter::{Call, detach};
use crate::observation::{self, Source};
use crate::plan::{Plan, quoted};
use crate::run::Run;
use crate::world::World;

/// Maximum length of an instruction, in characters.
const INSTRUCTION_LIMIT: usize = 2000;

/// A sequence of instructions, with a model that says what they mean. Every plan begins in the world that the accepted
/// ones before it leave.
///
/// The model is a callable: it takes a request (`messages`, `temperature`, `max_tokens`, `response_format`) and returns the
/// text of the reply. `context_tokens` is its limit for prompt and answer together. `strategy="direct"` asks it for whole
/// plans, which are corrected in at most `rounds`. `partial` proposes a plan that leaves words out like any other.
///
/// Raises what the model raises, and `LongstepError` for words that do not fit the `status`, for a reply that cannot be used,
/// and while another thread uses the session.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> model = lambda request: '{"goal": "put(pen, shelf)", "left_out": [], "question": ""}'
/// >>> session = longstep.Session(world, model)
/// >>> session.instruct("The pen belongs on the shelf").status, session.status
/// ('verified', 'plan')
/// >>> len(session.accept()), session.world.environment()["object_states"]
/// (6, {'<pen>': 'on_something(<shelf>)'})
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Session {
    domain: Arc<LoadedDomain>,
    /// The model, which may refer to this session.
    callable: Callable,
    state: Mutex<State>,
}

struct State {
    session: OwnSession,
    model: CallableModel,
    /// The lines of the log.
    log: Vec<String>,
}

/// The answer to the last words.
struct Outcome {
    report: Report,
    /// The plan that was asked for.
    plan: Option<Plan>,
    /// The plan that is offered with a question.
    offer: Option<Plan>,
}

/// Words of the person for the session.
enum Words {
    Instruction,
    Answer,
    Feedback,
}

#[pymethods]
impl Session {
    /// Begins a session in a world. `model` takes a request and returns the text of the reply.
    #[new]
    #[pyo3(signature = (
        world, model, /, *, name="python", context_tokens=None, temperature=0.0, strategy="goal", partial=false, rounds=3,
        effort=None
    ))]
    #[allow(clippy::too_many_arguments, reason = "keyword-only options of Python")]
    fn new(
        world: &Bound<'_, World>,
        model: &Bound<'_, PyAny>,
        name: &str,
        context_tokens: Option<u64>,
        temperature: f64,
        strategy: &str,
        partial: bool,
        rounds: u32,
        effort: Option<EffortArgument>,
    ) -> PyResult<Self> {
        let strategy = match strategy {
            "goal" => Strategy::Goal,
            "direct" => Strategy::Direct,
            other => {
                return Err(PyValueError::new_err(format!(
                    "strategy must be \"goal\" or \"direct\", not {other:?}"
                )));
            }
        };
        if !(temperature.is_finite() && temperature >= 0.0) {
            return Err(PyValueError::new_err(format!(
                "temperature must be a number from 0 on, not {temperature}"
            )));
        }
        let effort = effort.map(EffortArgument::effort).transpose()?;
        let settings = Settings::default()
            .with_strategy(strategy)
            .with_partial(partial)
            .with_rounds(rounds)
            .with_effort(effort);
        let world = world.get();
        let callable = Callable::new(model, "the model")?;
        let model = CallableModel::new(callable.clone(), name.to_owned(), context_tokens, temperature);
        let planner = Planner::new(Arc::clone(&world.domain)).with_clock(clock());
        let session = planner.session(world.world.clone(), settings, model.facts());
        Ok(Self {
            domain: Arc::clone(&world.domain),
            callable,
            state: Mutex::new(State {
                session: session.map_err(|error| Failure::failed(error.to_string()))?,
                model,
                log: Vec::new(),
            }),
        })
    }

    /// Gives an instruction, and returns its answer: a verified plan, a question, or the reasons why there is none.
    fn instruct(&self, py: Python<'_>, text: &str) -> PyResult<Answer> {
        self.say(py, &Words::Instruction, text)
    }

    /// Answers the question of the last answer.
    fn answer(&self, py: Python<'_>, text: &str) -> PyResult<Answer> {
        self.say(py, &Words::Answer, text)
    }

    /// Asks for a change of the plan that waits for a decision.
    fn feedback(&self, py: Python<'_>, text: &str) -> PyResult<Answer> {
        self.say(py, &Words::Feedback, text)
    }

    /// Accepts the plan that waits for a decision, and returns it. The session goes on in the world after it.
    ///
    /// A plan that is offered with a question (status `consent`) needs `consent=True`, which answers the question with yes: the
    /// person has seen the question and the plan (`Answer.offer`).
    #[pyo3(signature = (*, consent=false))]
    fn accept(&self, consent: bool) -> PyResult<Plan> {
        let mut state = self.state()?;
        if !consent {
            check_consent(&state.session)?;
        }
        // An accepted rule is no plan.
        let before = state.session.accepted().len();
        let proposed = state.session.proposal().map(|proposal| self.proposed(proposal));
        state.session.accept().map_err(out_of_turn)?;
        let last = state.session.accepted().get(before);
        let plan = last
            .map(|accepted| self.plan_of(&state.session, before, accepted))
            .or(proposed);
        Ok(plan.ok_or_else(|| Failure::failed("no plan waits for a decision"))?)
    }

    /// Takes the last accepted plan back, and returns the number of those that remain.
    fn undo(&self) -> PyResult<usize> {
        Ok(self.state()?.session.undo().map_err(out_of_turn)?)
    }

    /// Gives up the instruction, the question or the plan in progress.
    fn cancel(&self) -> PyResult<()> {
        Ok(self.state()?.session.cancel().map_err(out_of_turn)?)
    }

    /// Chooses the way in which the last accepted plan ended, by its place in `endings`.
    fn ended(&self, ending: usize) -> PyResult<()> {
        Ok(self.state()?.session.ended(ending).map_err(out_of_turn)?)
    }

    /// Takes what was seen since the last plan, and returns the differences from what the session expected, as sentences. The
    /// next instruction begins in the world that was seen.
    ///
    /// `seen` is an observation, as a robot's `observe` returns it, or a whole `World`. What it does not list stays as it was
    /// expected. Raises `LongstepError` while an instruction is in progress.
    fn observed(&self, seen: &Bound<'_, PyAny>) -> PyResult<Vec<String>> {
        let mut state = self.state()?;
        let statements = match seen.cast::<World>() {
            Ok(world) if world.get().domain.hash == self.domain.hash => observation::of_world(&world.get().world),
            Ok(world) => return Err(other_domain(&world.get().domain, &self.domain).into()),
            Err(_) => observation::read(seen, Source::Argument, state.session.world())?,
        };
        let observed = state.session.observed(&statements).map_err(not_observed)?;
        Ok(observed.changes)
    }

    /// Records that a robot carried out the first accepted plan that waits for one, and returns the differences of the world
    /// after the run from what the session expected, as sentences. The next instruction begins in that world.
    ///
    /// A plan whose run stopped before its goal still waits. Raises `LongstepError` for the run of another plan.
    fn carried_out(&self, run: &Bound<'_, Run>) -> PyResult<Vec<String>> {
        let run = run.get();
        let mut state = self.state()?;
        let number = state.session.pending().next();
        let waits = number.and_then(|number| Some((number, state.session.accepted().get(number)?)));
        let Some((number, accepted)) = waits else {
            return Err(Failure::failed("no accepted plan waits for a robot")
                .hint("`Session.observed` takes what was seen".to_owned())
                .into());
        };
        if self.plan_of(&state.session, number, accepted).hash() != run.plan {
            return Err(
                Failure::failed("the run carried out another plan than the accepted one that comes next")
                    .hint("`Session.observed(run.world)` takes the world after it".to_owned())
                    .into(),
            );
        }
        let observed = state.session.carried_out(number, run.is_done(), &run.statements);
        Ok(observed.map_err(not_observed)?.changes)
    }

    /// Puts a rule in force for all later plans: `never GOAL`, `always GOAL` or `untouched(NAME)`.
    fn add_rule(&self, text: &str) -> PyResult<()> {
        Ok(self.state()?.session.add_rule(text).map_err(rule_failure)?)
    }

    /// Lifts the rule with this place in `rules`, and returns its text.
    fn lift_rule(&self, number: usize) -> PyResult<String> {
        Ok(self.state()?.session.lift_rule(number).map_err(rule_failure)?)
    }

    /// The rules in force, in the goal language.
    #[getter]
    fn rules(&self) -> PyResult<Vec<String>> {
        let state = self.state()?;
        let rules = state.session.rules().iter();
        Ok(rules.map(|rule| rule.written.clone()).collect())
    }

    /// The world in which the next instruction begins.
    ///
    /// With the status `endings` it is still the world before the accepted plan, because nobody knows yet which of its endings
    /// occurred: `Plan.endings` has those worlds, and `ended` chooses one.
    #[getter]
    fn world(&self) -> PyResult<World> {
        Ok(World {
            world: self.state()?.session.world().clone(),
            domain: Arc::clone(&self.domain),
        })
    }

    /// The state: `ready`, `question`, `plan`, `consent`, `no_plan` or `endings`.
    ///
    /// `consent`: a plan is offered with a question (`Answer.offer`, `Answer.question`), because it leaves out a part of the
    /// instruction, or because the model asks about it. `accept(consent=True)` answers yes; `feedback` and `cancel` are the
    /// other ways on.
    #[getter]
    fn status(&self) -> PyResult<&'static str> {
        Ok(match self.state()?.session.response() {
            Response::Plan(_) => "plan",
            Response::Consent(_) => "consent",
            Response::Question(_) => "question",
            Response::NoPlan(_) => "no_plan",
            Response::Endings(_) => "endings",
            // No call ends while the model is awaited.
            _ => "ready",
        })
    }

    /// The accepted plans, in order.
    #[getter]
    fn accepted(&self) -> PyResult<Vec<Plan>> {
        let state = self.state()?;
        let accepted = state.session.accepted().iter().enumerate();
        Ok(accepted
            .map(|(number, own)| self.plan_of(&state.session, number, own))
            .collect())
    }

    /// The ways in which the last accepted plan can have ended, each as the outcomes of sensing; empty if only one is left.
    #[getter]
    fn endings(&self) -> PyResult<Vec<Vec<String>>> {
        let endings = self.state()?.session.endings();
        Ok(endings.into_iter().map(|ending| ending.when).collect())
    }

    /// The reasons why the last feedback changed nothing, or not all that was asked for.
    #[getter]
    fn refused(&self) -> PyResult<Vec<String>> {
        let state = self.state()?;
        let refused = state.session.proposal().map(|proposal| &proposal.refused[..]);
        Ok(refused.unwrap_or_default().iter().map(ToString::to_string).collect())
    }

    /// Returns the log of the session so far, a JSON object a line, as `longstep session show` reads it.
    fn log(&self) -> PyResult<String> {
        let mut state = self.state()?;
        let now = Timestamp::now().to_string();
        let events = state.session.take_events();
        let lines = events.into_iter().map(|event| Entry::new(now.clone(), event).line());
        state.log.extend(lines);
        Ok(state.log.concat())
    }

    fn __traverse__(&self, visit: PyVisit<'_>) -> Result<(), PyTraverseError> {
        self.callable.traverse(&visit)
    }

    fn __clear__(&self) {
        self.callable.clear();
    }

    fn __repr__(&self) -> String {
        match self.state() {
            Ok(state) => format!(
                "<longstep.Session {}: {} accepted>",
                self.domain.name,
                state.session.accepted().len()
            ),
            Err(_) => format!("<longstep.Session {}: at work>", self.domain.name),
        }
    }
}

impl Session {
    /// Returns the state. A call during another one is an error, so that a model that uses its own session does not wait
    /// for itself.
    fn state(&self) -> Result<MutexGuard<'_, State>, Failure> {
        self.state.try_lock().map_err(|_| {
            Failure::failed("the session is at work: another call has not returned yet")
                .hint("call it again after that; a model cannot use the session that calls it".to_owned())
        })
    }

    /// Gives words to the session, and lets the model work until it is the person's turn.
    fn say(&self, py: Python<'_>, words: &Words, text: &str) -> PyResult<Answer> {
        let text = checked(text)?;
        let _call = Call::begin(py);
        let Outcome { report, plan, offer } = detach(py, || {
            let mut state = self.state()?;
            let State { session, model, .. } = &mut *state;
            let taken = match words {
                Words::Instruction => session.instruct(text),
                Words::Answer => session.answer(text),
                Words::Feedback => session.feedback(text),
            };
            taken.map_err(out_of_turn)?;
            let ended = advance(session, model, None, &mut |_: Progress| {});
            if let Some(raised) = model.take_raised() {
                return Err(raised);
            }
            ended.map_err(advance_failure)?;
            Ok::<_, PyErr>(self.outcome(session)?)
        })?;
        Answer::new(py, report, plan)?.offering(py, offer)
    }

    /// Returns the answer to the last words, with the plan that waits for a decision.
    fn outcome(&self, session: &OwnSession) -> Result<Outcome, Failure> {
        let report = session.report().ok_or_else(|| match session.failure() {
            Some(failure) => {
                Failure::failed(failure.to_string()).hint("rephrase the instruction, or use another model".to_owned())
            }
            None => Failure::failed("the session ended early"),
        })?;
        let proposed = session.proposal().map(|proposal| self.proposed(proposal));
        // A plan that is offered with a question is no answer to what was asked for until the person agrees.
        let (plan, offer) = match report.status {
            Status::Verified => (proposed, None),
            _ => (None, proposed),
        };
        Ok(Outcome { report, plan, offer })
    }

    /// Returns the plan of a proposal.
    fn proposed(&self, proposal: &Proposal) -> Plan {
        let plan = Plan::new(&self.domain, proposal.plan.clone(), proposal.answer.plan.clone());
        plan.for_goal(proposal.goal.as_ref())
    }

    fn plan_of(&self, session: &OwnSession, number: usize, accepted: &Accepted) -> Plan {
        let file = session.plan_file(number);
        let file = file.unwrap_or_else(|| Report::of_report(&accepted.before, accepted.plan.report(), None, "").plan);
        Plan::new(&self.domain, accepted.plan.clone(), file).for_goal(accepted.goal.as_ref())
    }
}

/// Returns the words without spaces around them, if they are neither empty nor too long.
fn checked(text: &str) -> Result<&str, Failure> {
    let words = text.trim();
    let length = words.chars().count();
    if words.is_empty() {
        return Err(Failure::unreadable("the text is empty")
            .hint("write what the robot should do, for example \"Put the juice on the table\"".to_owned()));
    }
    if length > INSTRUCTION_LIMIT {
        let message = format!("the text has {length} characters; the limit is {INSTRUCTION_LIMIT}");
        return Err(Failure::unreadable(message).hint("shorten it to one or two sentences".to_owned()));
    }
    Ok(words)
}

/// Refuses a plan whose question nobody has answered.
fn check_consent(session: &OwnSession) -> Result<(), Failure> {
    let Response::Consent(proposal) = session.response() else {
        return Ok(());
    };
    let question = proposal.question.as_deref().unwrap_or_default();
    let unsaid = proposal.answer.plan.not_in_plan.iter();
    let unsaid: Vec<String> = unsaid.filter(|words| !question.contains(*words)).cloned().collect();
    let left_out = match &unsaid[..] {
        [] => String::new(),
        words => format!(" The plan leaves out {}.", quoted(words)),
    };
    Err(Failure::failed(format!(
        "the plan waits for an answer to its question: {question}{left_out}"
    ))
    .hint("show the person `answer.offer` and the question, then call `accept(consent=True)`".to_owned()))
}

fn out_of_turn(error: OutOfTurn) -> Failure {
    Failure::failed(error.to_string()).hint("`Session.status` says what fits".to_owned())
}

fn not_observed(error: ObserveError) -> Failure {
    match error {
        ObserveError::OutOfTurn(error) => out_of_turn(error),
        error => Failure::unreadable(error.to_string()),
    }
}

/// Returns the failure for a world of another domain.
fn other_domain(other: &LoadedDomain, own: &LoadedDomain) -> Failure {
    Failure::unreadable(format!(
        "this world is of the domain `{}`, and the session of the domain `{}`",
        other.name, own.name
    ))
}

fn rule_failure(error: RuleError) -> Failure {
    match error {
        RuleError::Rule(error) => error.into(),
        RuleError::OutOfTurn(error) => out_of_turn(error),
        error => Failure::failed(error.to_string()),
    }
}

fn advance_failure(error: AdvanceError) -> Failure {
    let hint = match &error {
        AdvanceError::Model(error) => error.hint(),
        AdvanceError::Prompt(_) => Some("use a smaller environment, or a larger `context_tokens`".to_owned()),
        _ => None,
    };
    Failure::failed(error.to_string()).hint(hint)
}
