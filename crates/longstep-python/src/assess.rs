//! The functions `verify`, `repair` and `solve`.

use std::sync::Arc;
use std::time::Instant;

use longstep::domain::Domain as LoadedDomain;
use longstep::report::{self, Answer as Report, Assessment, Solution, milliseconds};
use longstep::{Clock, Limits};
use longstep_core::goal;
use longstep_core::repair::RepairOutcome;
use longstep_core::search::Effort;
use longstep_core::verify::{Purpose, VerifiedPlan};
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyBool, PyInt, PyString};

use crate::answer::Answer;
use crate::argument::{self, class_of};
use crate::draft::Draft;
use crate::failure::Failure;
use crate::interpreter::detach;
use crate::plan::Plan;
use crate::problem::Problem;
use crate::rule::with_rules;
use crate::source::{NamedText, Source};
use crate::world::World;

/// The place of a plan: a world, or a PDDL problem.
pub(crate) enum Place<'py> {
    World(Bound<'py, World>),
    Problem(Bound<'py, Problem>),
}

impl<'py> FromPyObject<'_, 'py> for Place<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        if let Ok(world) = object.cast::<World>() {
            return Ok(Self::World(world.to_owned()));
        }
        if let Ok(problem) = object.cast::<Problem>() {
            return Ok(Self::Problem(problem.to_owned()));
        }
        let class = class_of(&object);
        Err(PyTypeError::new_err(format!(
            "world must be a longstep.World or a longstep.Problem, not {class}"
        )))
    }
}

impl Place<'_> {
    fn domain(&self) -> Arc<LoadedDomain> {
        match self {
            Self::World(world) => Arc::clone(&world.get().domain),
            Self::Problem(problem) => Arc::clone(&problem.get().domain),
        }
    }
}

/// Reads a plan as a caller gives it: a `Plan`, a text, a dict, or a path.
fn plan_source(plan: &Bound<'_, PyAny>) -> PyResult<Source> {
    match plan.cast::<Plan>() {
        Ok(plan) => Ok(Source::Text(plan.get().json()?)),
        Err(_) => Source::of(plan, "plan"),
    }
}

/// The data of a place that work without the interpreter needs.
enum Ground<'a> {
    World(&'a World),
    Problem(&'a Problem),
}

impl<'a> From<&'a Place<'_>> for Ground<'a> {
    fn from(place: &'a Place<'_>) -> Self {
        match place {
            Place::World(world) => Self::World(world.get()),
            Place::Problem(problem) => Self::Problem(problem.get()),
        }
    }
}

impl Ground<'_> {
    fn draft(&self, text: &NamedText, goal: Option<&str>, rules: &[String]) -> Result<Draft, Failure> {
        match self {
            Self::World(world) => Draft::read(text, &world.world, goal, rules),
            Self::Problem(_) if goal.is_some() || !rules.is_empty() => {
                Err(Failure::unreadable("a PDDL problem has its goal, and takes no rules"))
            }
            Self::Problem(own) => Draft::for_problem(text, &own.problem.world, &own.problem.wanted, &own.notes),
        }
    }
}

/// Returns the plan of an assessment, with the goal of its draft.
fn plan_of(domain: &Arc<LoadedDomain>, draft: &Draft, plan: VerifiedPlan, report: &Report) -> Plan {
    let plan = Plan::new(domain, plan, report.plan.clone())
        .for_goal(draft.goal.as_ref())
        .leaving_out(draft.left_out());
    if draft.wanted.is_empty() {
        plan
    } else {
        plan.wanting(&draft.wanted)
    }
}

/// Verifies a plan; it is neither repaired nor completed.
///
/// The plan is a `Plan`, a text, a dict, or the path of a file: JSON, a script, a model's reply, or the output of a planner. A
/// goal takes the place of the one in the plan. The answer is `verified`, `invalid` or `question`; raises `Unreadable` for a
/// plan, a goal or a rule that cannot be read.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> draft = {"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}
/// >>> longstep.verify(draft, world).violations[0].message
/// 'step 1: grasp_object() needs that the hand is at the pen'
#[pyfunction]
#[pyo3(signature = (plan, world, /, *, goal=None, rules=None))]
pub(crate) fn verify(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    world: Place<'_>,
    goal: Option<&str>,
    rules: Option<&Bound<'_, PyAny>>,
) -> PyResult<Answer> {
    assessed(py, plan, &world, goal, rules, |assessment, plan_of| {
        let verifying = Instant::now();
        let mut report = assessment.verdict();
        report.timings_ms.verify = milliseconds(verifying.elapsed());
        let plan = verified(assessment).map(|plan| plan_of(plan, &report));
        (report, plan)
    })
}

/// Reads a plan in its place, and answers with what `judge` finds; the interpreter is free meanwhile. `judge` also gets what
/// makes a plan with the goal of the draft.
fn assessed(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    place: &Place<'_>,
    goal: Option<&str>,
    rules: Option<&Bound<'_, PyAny>>,
    judge: impl FnOnce(&Assessment<'_>, &dyn Fn(VerifiedPlan, &Report) -> Plan) -> Solved + Send,
) -> PyResult<Answer> {
    let (source, domain, ground) = (plan_source(plan)?, place.domain(), Ground::from(place));
    let rules = argument::rules(rules)?;
    let (report, plan) = detach(py, || -> Result<_, Failure> {
        let started = Instant::now();
        let draft = ground.draft(&source.read("plan")?, goal, &rules)?;
        let (mut report, plan) = judge(&draft.assessment(), &|plan, report| {
            plan_of(&domain, &draft, plan, report)
        });
        report.timings_ms.total = milliseconds(started.elapsed());
        Ok((report, plan))
    })?;
    Answer::new(py, report, plan)
}

/// Returns the plan of an assessment as it was written, if it is valid and no question.
fn verified(assessment: &Assessment<'_>) -> Option<VerifiedPlan> {
    match assessment.question() {
        Some(_) => None,
        None => assessment.verified(),
    }
}

/// Repairs a plan with the cheapest edits, and gives a reason for each. A valid plan stays as it is.
///
/// Takes what `verify` takes. The answer is `verified`, `invalid` if a repair would be a guess, `unsolvable`, `gave_up` or
/// `question`.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> draft = {"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}
/// >>> [str(step) for step in longstep.repair(draft, world).verified().steps]
/// ['move_hand()', 'grasp_object()', 'release_object()']
#[pyfunction]
#[pyo3(signature = (plan, world, /, *, goal=None, rules=None))]
pub(crate) fn repair(
    py: Python<'_>,
    plan: &Bound<'_, PyAny>,
    world: Place<'_>,
    goal: Option<&str>,
    rules: Option<&Bound<'_, PyAny>>,
) -> PyResult<Answer> {
    assessed(py, plan, &world, goal, rules, |assessment, plan_of| {
        if assessment.question().is_some() {
            return (assessment.verdict(), None);
        }
        let searching = Instant::now();
        let outcome = assessment.repair();
        let search = milliseconds(searching.elapsed());
        let verifying = Instant::now();
        let mut report = assessment.repaired();
        report.timings_ms.verify = milliseconds(verifying.elapsed());
        report.timings_ms.search = search;
        let plan = match outcome {
            RepairOutcome::Valid(plan) => Some(plan_of(plan.clone(), &report)),
            RepairOutcome::Repaired(repaired) => {
                Some(plan_of(repaired.plan.clone(), &report).with_edits(&repaired.edits))
            }
            _ => None,
        };
        (report, plan)
    })
}

/// The work of a search: `small`, `normal`, `large`, or millions of units.
pub(crate) enum EffortArgument {
    Named(String),
    Millions(u32),
}

impl FromPyObject<'_, '_> for EffortArgument {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, '_, PyAny>) -> PyResult<Self> {
        if let Ok(name) = object.cast::<PyString>() {
            return Ok(Self::Named(name.to_str()?.to_owned()));
        }
        if !object.is_instance_of::<PyInt>() || object.is_instance_of::<PyBool>() {
            let class = class_of(&object);
            return Err(PyTypeError::new_err(format!(
                "effort must be \"small\", \"normal\", \"large\" or an int, not {class}"
            )));
        }
        // A number that is too large for the type is too large for the search, which says its limits.
        Ok(Self::Millions(object.extract().unwrap_or(u32::MAX)))
    }
}

impl EffortArgument {
    pub(crate) fn effort(self) -> Result<Effort, Failure> {
        let effort = match self {
            Self::Named(name) => name.parse(),
            Self::Millions(millions) => Effort::try_from(millions),
        };
        effort.map_err(|error| Failure::unreadable(error.to_string()))
    }
}

/// Finds a plan for a goal, and verifies it; a shortest one if the effort allows for the proof.
///
/// The effort is `small` (tenths of a second), `normal` (at most one or two seconds), `large` (at most ten or twenty), or
/// millions of units of work, from 1 to 10,000. It is a limit of work: the answer is the same on every machine. The answer
/// is `verified`, `unsolvable` (proven) or `gave_up`; raises `Unreadable` for a goal or a rule that cannot be read.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> print(longstep.solve(world, "put(pen, shelf)").verified().steps[3].explanation)
/// move the pen to the shelf
/// >>> longstep.solve(world, "put(pen, shelf) & untouched(pen)").status
/// 'unsolvable'
#[pyfunction]
#[pyo3(signature = (world, goal=None, /, *, rules=None, effort=None))]
pub(crate) fn solve(
    py: Python<'_>,
    world: Place<'_>,
    goal: Option<&str>,
    rules: Option<&Bound<'_, PyAny>>,
    effort: Option<EffortArgument>,
) -> PyResult<Answer> {
    let rules = argument::rules(rules)?;
    let effort = effort.map(EffortArgument::effort).transpose()?.unwrap_or_default();
    let (limits, domain) = (Limits::from(effort), world.domain());
    let (report, plan) = match (Ground::from(&world), goal) {
        (Ground::World(world), Some(goal)) => detach(py, || for_goal(world, goal, &rules, &limits, &domain))?,
        (Ground::Problem(problem), None) if rules.is_empty() => detach(py, || for_problem(problem, &limits, &domain))?,
        (Ground::World(_), None) => return Err(PyTypeError::new_err("solve() needs a goal for a world")),
        (Ground::Problem(_), _) => {
            return Err(PyTypeError::new_err(
                "solve() takes neither a goal nor rules beside a problem",
            ));
        }
    };
    Answer::new(py, report, plan)
}

type Solved = (Report, Option<Plan>);

fn for_goal(
    world: &World,
    text: &str,
    rules: &[String],
    limits: &Limits,
    domain: &Arc<LoadedDomain>,
) -> Result<Solved, Failure> {
    let started = Instant::now();
    let mut world = with_rules(world.world.clone(), rules)?;
    goal::add_values(&mut world, text);
    let goal = goal::parse(&world, text)?;
    let Solution { plan, mut answer, .. } = report::of_goal(&world, &goal, text, limits, &clock());
    answer.timings_ms.total = milliseconds(started.elapsed());
    let plan = plan.map(|plan| Plan::new(domain, plan, answer.plan.clone()).for_goal(Some(&goal)));
    Ok((answer, plan))
}

fn for_problem(own: &Problem, limits: &Limits, domain: &Arc<LoadedDomain>) -> Result<Solved, Failure> {
    let started = Instant::now();
    let problem = &own.problem;
    let purpose = Purpose::from(problem);
    let solution = report::of_purpose(&problem.world, &purpose, None, &problem.name, limits, &clock());
    let (plan, mut answer) = (solution.plan, solution.answer);
    answer.notes.extend(own.notes.iter().cloned());
    answer.goal = own.goal_texts().to_vec();
    answer.timings_ms.total = milliseconds(started.elapsed());
    let plan = plan.map(|plan| Plan::new(domain, plan, answer.plan.clone()).wanting(&problem.wanted));
    Ok((answer, plan))
}

/// Returns a clock that begins now.
pub(crate) fn clock() -> Clock {
    let began = Instant::now();
    Clock::new(move || began.elapsed())
}
