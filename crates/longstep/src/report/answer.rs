//! The one JSON object that `plan`, `verify`, `repair` and `solve` answer with, for programs.
//!
//! A wire format of its own: the other types of the library are free to change.

use serde::Serialize;

use crate::environment::{self, Claim, Environment, State, Voice, World};
use crate::goal::{Goal, LeftOut};
use crate::model::Domain;
use crate::plan::{self, OutlineLine, PlanFile, Step, TaskCohesion};
use crate::repair::Edit;
use crate::schedule::Compacted;
use crate::usage::Usage;
use crate::verify::{Ending, Report, Violation};

/// What came of a request.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// There is a plan, and it was checked.
    Verified,
    /// There is a plan, and something is wrong with it.
    Invalid,
    /// There is no plan.
    Unsolvable,
    /// No plan was found within the limits.
    GaveUp,
    /// The person must say more first.
    Question,
}

impl Status {
    /// The program's exit code for it.
    pub fn exit_code(self) -> u8 {
        match self {
            Self::Verified => 0,
            Self::Invalid => 10,
            Self::Unsolvable => 11,
            Self::GaveUp => 12,
            Self::Question => 13,
        }
    }
}

/// The answer, fields in the order in which they are written.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Answer {
    /// What came of it.
    pub status: Status,
    /// The plan as the paper writes it.
    pub plan: PlanFile,
    /// The steps with everything that the call syntax hides.
    pub steps: Vec<StepAnswer>,
    /// The goal that was planned for, with the environment's identifiers.
    pub goal: Vec<String>,
    /// What repair changed, in the order of the plan.
    pub edits: Vec<EditAnswer>,
    /// What is wrong with the plan.
    pub violations: Vec<ViolationAnswer>,
    /// How the environment that the plan claims compares with the simulated one.
    pub claims: Claims,
    /// What the verdict rests on beyond the environment, and what was left out of the goal.
    pub assumptions: Vec<String>,
    /// What the model cost.
    pub usage: UsageAnswer,
    /// How long things took.
    pub timings_ms: Timings,
    /// Remarks that change no verdict: what was read leniently, what is odd about the plan.
    pub notes: Vec<String>,
    /// The plan as lines for a person.
    #[serde(skip)]
    pub outline: Vec<OutlineLine>,
}

/// A change of an [`Answer`].
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct EditAnswer {
    /// `insert`, `drop`, `replace` or `move`.
    pub kind: &'static str,
    /// Where it shows in the plan, from 0: the place of the new step, or the place where a dropped one would stand.
    pub at: usize,
    /// The call before; none for an insertion.
    pub before: Option<String>,
    /// The call after; none for a dropped step.
    pub after: Option<String>,
    /// Why, in one sentence.
    pub why: String,
}

impl From<&Edit> for EditAnswer {
    fn from(edit: &Edit) -> Self {
        Self {
            kind: edit.kind.name(),
            at: edit.at,
            before: edit.before.clone(),
            after: edit.after.clone(),
            why: edit.why.clone(),
        }
    }
}

/// A step of an [`Answer`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct StepAnswer {
    /// From 0.
    pub index: usize,
    /// The word of the call.
    pub action: String,
    /// The arguments that the call shows.
    pub arguments: Vec<String>,
    /// The arguments that it hides, by parameter.
    pub implicit: indexmap::IndexMap<String, String>,
    /// Which hand, arm or robot does it; none if there is only one, or if it takes several.
    pub arm: Option<String>,
    /// What the step does.
    pub explanation: String,
}

/// A violation of an [`Answer`].
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ViolationAnswer {
    /// For example `precondition`.
    pub kind: &'static str,
    /// The step, from 0; none for the plan as a whole.
    pub step: Option<usize>,
    /// The call of that step.
    pub action: Option<String>,
    /// The facts that were missing, as sentences.
    pub missing: Vec<String>,
    /// The step that took them away, from 0.
    pub undone_by: Option<usize>,
    /// What sensing told where it is so, as sentences; empty if it is so in any case.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub when: Vec<String>,
    /// One sentence for a person.
    pub message: String,
}

/// Claimed and simulated environment, entity by entity.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
pub struct Claims {
    /// Entities of which the plan claims what was simulated.
    pub agreed: usize,
    /// The others.
    pub differing: Vec<Differing>,
}

/// An entity of which a plan claims something else than was simulated.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Differing {
    /// The entity.
    pub entity: String,
    /// What the plan claims.
    pub claimed: String,
    /// What was simulated.
    pub simulated: String,
}

/// Tokens and calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
pub struct UsageAnswer {
    /// Model calls.
    pub calls: u32,
    /// Rounds of feedback.
    pub rounds: u32,
    /// Tokens of the prompts.
    pub prompt_tokens: u64,
    /// Those of them that needed no computation.
    pub cached_tokens: u64,
    /// Tokens of the answers.
    pub completion_tokens: u64,
}

impl From<Usage> for UsageAnswer {
    fn from(usage: Usage) -> Self {
        Self {
            calls: usage.calls,
            rounds: 0,
            prompt_tokens: usage.prompt_tokens,
            cached_tokens: usage.cached_tokens,
            completion_tokens: usage.completion_tokens,
        }
    }
}

/// Milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
pub struct Timings {
    /// Opening the model and its calls.
    pub model: f64,
    /// Verification.
    pub verify: f64,
    /// Search.
    pub search: f64,
    /// From the beginning of the command to its answer.
    pub total: f64,
}

impl Answer {
    /// An answer without a plan: the environment stays as it is.
    pub fn without_plan(status: Status, world: &World, summary: &str, question: &str) -> Self {
        Self {
            status,
            plan: PlanFile {
                task_cohesion: TaskCohesion::default(),
                environment_before: Some(world.environment.clone()),
                environment_after: Some(world.environment.clone()),
                endings: Vec::new(),
                instruction_summary: summary.to_owned(),
                question: question.to_owned(),
            },
            steps: Vec::new(),
            goal: Vec::new(),
            edits: Vec::new(),
            violations: Vec::new(),
            claims: Claims::default(),
            assumptions: Vec::new(),
            usage: UsageAnswer::default(),
            timings_ms: Timings::default(),
            notes: Vec::new(),
            outline: Vec::new(),
        }
    }

    /// The answer to a plan that was looked at, good or bad.
    pub fn of_report(domain: &Domain, world: &World, report: &Report, goal: Option<&Goal>, summary: &str) -> Self {
        let good = report.violations.is_empty();
        let status = if good { Status::Verified } else { Status::Invalid };
        let mut answer = Self::without_plan(status, world, summary, "");
        answer.plan.task_cohesion = TaskCohesion::new(domain, world, &report.plan);
        let environment = |ending: &Ending| environment::write(domain, world, &ending.after);
        (answer.plan.environment_after, answer.plan.endings) =
            plan::endings(domain, world, &report.endings, environment);
        answer.outline = plan::outline(domain, world, &report.plan);
        answer.steps = report
            .plan
            .steps()
            .iter()
            .enumerate()
            .map(|(i, s)| StepAnswer::of(domain, world, i, s))
            .collect();
        let calls: Vec<String> = report
            .plan
            .steps()
            .iter()
            .map(|step| step.call(domain, world).to_string())
            .collect();
        let told = report.violations.iter();
        answer.violations = told
            .map(|v| ViolationAnswer::of(domain, world, v, &calls, report.plan.steps(), goal))
            .collect();
        answer.assumptions = report.assumptions.iter().map(|a| a.message(domain, world)).collect();
        let odd = report.warnings.iter();
        answer.notes = odd
            .map(|warning| warning.message(domain, world, report.plan.steps(), goal))
            .collect();
        if let Some(goal) = goal {
            answer.goal = goal.facts.iter().map(|fact| fact.exact(domain, world)).collect();
        }
        answer
    }

    /// The answer to a plan that was not simulated, since its steps name what there is not or nothing fits them. `calls`
    /// are its steps as they were written.
    pub fn of_unresolved(
        domain: &Domain,
        world: &World,
        written: &PlanFile,
        calls: &[String],
        issues: &[Violation],
    ) -> Self {
        let mut answer = Self::without_plan(Status::Invalid, world, &written.instruction_summary, "");
        answer.plan.task_cohesion.clone_from(&written.task_cohesion);
        answer.violations = issues
            .iter()
            .map(|v| ViolationAnswer::of(domain, world, v, calls, &[], None))
            .collect();
        answer
    }

    /// Puts a plan whose actors work side by side in place of the one that does the same step by step, and tells how
    /// much time that saves.
    pub fn side_by_side(&mut self, domain: &Domain, world: &World, compacted: &Compacted) {
        let now = Self::of_report(domain, world, compacted.plan.report(), None, "");
        self.plan.task_cohesion = now.plan.task_cohesion;
        self.plan.environment_after = now.plan.environment_after;
        self.steps = now.steps;
        self.outline = now.outline;
        let (count, before) = (self.steps.len(), compacted.before.units());
        self.notes.push(format!(
            "{count} steps, {} of time instead of {before}",
            compacted.after
        ));
    }

    /// Adds to the assumptions what was left out of the goal.
    pub fn tell_left_out(&mut self, domain: &Domain, world: &World, left_out: &[LeftOut]) {
        let sentence = |left: &LeftOut| format!("left out {}: {}", left.fact.everyday(domain, world), left.why);
        self.assumptions.extend(left_out.iter().map(sentence));
    }
}

impl ViolationAnswer {
    fn of(
        domain: &Domain,
        world: &World,
        violation: &Violation,
        calls: &[String],
        steps: &[Step],
        goal: Option<&Goal>,
    ) -> Self {
        Self {
            kind: violation.kind(),
            step: violation.step(),
            action: violation.step().and_then(|step| calls.get(step).cloned()),
            missing: violation.missing(domain, world),
            undone_by: violation.undone_by(),
            when: violation
                .told()
                .iter()
                .map(|fact| Voice::Person.fact(domain, world, *fact, true))
                .collect(),
            message: violation.message(domain, world, steps, goal),
        }
    }
}

impl StepAnswer {
    fn of(domain: &Domain, world: &World, index: usize, step: &Step) -> Self {
        let action = domain.action(step.action);
        let call = step.call(domain, world);
        let implicit = action.implicit().map(|parameter| {
            let name = if action.object == Some(parameter) {
                "object"
            } else {
                &action.parameters[parameter].name
            };
            (
                name.to_owned(),
                world.entity(step.arguments[parameter]).identifier.clone(),
            )
        });
        Self {
            index,
            action: call.name,
            arguments: call.arguments,
            implicit: implicit.collect(),
            arm: step.actor(domain).map(|actor| world.entity(actor).identifier.clone()),
            explanation: step.explanation.clone(),
        }
    }
}

/// Compares what a plan claims of the world afterwards with what was simulated.
pub fn compare_claims(domain: &Domain, world: &World, claim: &Claim, simulated: &State) -> Claims {
    let words = |state: &State| words_by_entity(domain, world, state);
    let (claimed, simulated) = (words(&claim.state), words(simulated));
    let mut claims = Claims::default();
    for (id, entity) in world.entities().filter(|(id, _)| claim.speaks_of(*id)) {
        let (said, is) = (&claimed[id.index()], &simulated[id.index()]);
        if said == is {
            claims.agreed += 1;
        } else {
            claims.differing.push(Differing {
                entity: entity.identifier.clone(),
                claimed: said.join(", "),
                simulated: is.join(", "),
            });
        }
    }
    claims
}

/// What an environment would say of each entity, sorted.
fn words_by_entity(domain: &Domain, world: &World, state: &State) -> Vec<Vec<String>> {
    let mut all = vec![Vec::new(); world.entities().count()];
    for fact in state.iter() {
        for word in domain
            .states
            .iter()
            .filter(|word| word.atom.predicate == fact.predicate())
        {
            let (subject, text) = environment::word_for(word, world, fact);
            all[subject.index()].push(text);
        }
    }
    all.iter_mut().for_each(|words| words.sort());
    all
}

/// An entity whose entry differs between two environments: its identifier, what was said, what is said now.
pub type Changed = (String, String, String);

/// What differs between two environments, in the order of the first.
pub fn changes(before: &Environment, after: &Environment) -> Vec<Changed> {
    let entry = |environment: &Environment, identifier: &String| {
        let states = environment
            .asset_states
            .get(identifier)
            .or_else(|| environment.object_states.get(identifier));
        states.map_or_else(String::new, |words| words.as_slice().join(", "))
    };
    let all = before.objects.iter().chain(&before.assets);
    all.map(|identifier| (identifier.clone(), entry(before, identifier), entry(after, identifier)))
        .filter(|(_, was, is)| was != is)
        .collect()
}
