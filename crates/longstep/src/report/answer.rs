//! The JSON object that `plan`, `verify`, `repair` and `solve` print.
//!
//! These types define the wire format, so the other types of the library can change freely.

use longstep_core::model::{Number, entries_of, entry_of_number};
use serde::Serialize;

use crate::coverage::{self, Coverage, CoverageRole, Gap};
use crate::environment::{self, Claim, Environment, State, Voice, World};
use crate::goal::{Goal, GoalFact, Group};
use crate::plan::{self, ChoiceFile, OutlineLine, PlanFile, PurposeFile, Step, TaskCohesion};
use crate::reading::Reading;
use crate::repair::Edit;
use crate::schedule::Compacted;
use crate::usage::Usage;
use crate::verify::{Ending, Report, Violation};

/// Outcome of a request.
///
/// Exhaustive on purpose: code that does not know a new outcome would be wrong.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Status {
    /// A valid plan.
    Verified,
    /// An invalid plan.
    Invalid,
    /// A proof that no plan exists.
    Unsolvable,
    /// No plan within the limits.
    GaveUp,
    /// A question to the person.
    Question,
}

impl Status {
    /// Describes the status in a sentence.
    pub(crate) fn sentence(self) -> &'static str {
        match self {
            Self::Verified => "there is a plan",
            Self::Invalid => "the plan is not valid",
            Self::Unsolvable => "no plan can do this",
            Self::GaveUp => "no plan was found within the limits",
            Self::Question => "there is a question",
        }
    }
}

/// The answer to a request. Fields are serialized in this order.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Answer {
    /// The outcome.
    pub status: Status,
    /// The plan in the paper's format.
    pub plan: PlanFile,
    /// The steps with all arguments, including those that a call hides.
    pub steps: Vec<StepAnswer>,
    /// The goal of the plan, with identifiers of the environment.
    pub goal: Vec<String>,
    /// The groups in the goal as it was written.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub groups: Vec<GroupAnswer>,
    /// The goals that left a choice, with what the plan chose.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub choices: Vec<ChoiceAnswer>,
    /// The cost of the steps on the dearest path; absent in a domain without costs.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub cost: Option<f64>,
    /// The edits of a repair, in plan order.
    pub edits: Vec<EditAnswer>,
    /// The violations of the plan.
    pub violations: Vec<ViolationAnswer>,
    /// Comparison of the claimed environment with the simulated one.
    pub claims: Claims,
    /// The parts of the instruction with their roles, in the order of the text; empty without an instruction, and for
    /// the direct strategy.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub coverage: Vec<PartAnswer>,
    /// The parts of the instruction that the goal does not represent, so that the plan ignores them.
    pub not_represented: Vec<GapAnswer>,
    /// Assumptions behind the verdict, and goals that were left out.
    pub assumptions: Vec<String>,
    /// How the instruction was understood: the answers of the model that were weighed; empty without a model.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub readings: Vec<Reading>,
    /// The state of knowledge at the end of the search; none if the plan does not come from one.
    pub search: Option<SearchAnswer>,
    /// The tokens and the time of a request for a whole plan, as they were foreseen; absent for the goal strategy.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub forecast: Option<ForecastAnswer>,
    /// Token counts.
    pub usage: UsageAnswer,
    /// Durations.
    pub timings_ms: Timings,
    /// Remarks that do not affect the verdict: lenient parsing and unusual steps.
    pub notes: Vec<String>,
    /// The plan as text lines.
    #[serde(skip)]
    pub outline: Vec<OutlineLine>,
}

/// A group in a goal, and the entities that it stands for.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct GroupAnswer {
    /// The group in the goal language, with identifiers: `all plate where on_something(<table>)`.
    pub group: String,
    /// Identifiers of the members.
    pub members: Vec<String>,
    /// The group and its members for people.
    pub says: String,
}

impl GroupAnswer {
    fn of(world: &World, group: &Group) -> Self {
        let (voice, members) = (Voice::Person, group.members.iter());
        Self {
            group: group.exact(world),
            members: members.map(|id| world.entity(*id).identifier.clone()).collect(),
            says: format!(
                "{}: {}",
                group.sentence_in(voice, world),
                group.members_in(voice, world)
            ),
        }
    }
}

/// A goal that left a choice, and what the plan chose.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct ChoiceAnswer {
    /// The goal in the goal language, with identifiers: `put(any cup, <table>)`.
    pub goal: String,
    /// The goals that the plan achieves for it: `put(<cup_2>, <table>)`.
    pub chosen: Vec<String>,
    /// The chosen goals for people.
    pub says: Vec<String>,
}

impl From<&ChoiceAnswer> for ChoiceFile {
    fn from(choice: &ChoiceAnswer) -> Self {
        Self {
            goal: choice.goal.clone(),
            chosen: choice.chosen.clone(),
        }
    }
}

/// The state of knowledge at the end of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct SearchAnswer {
    /// True if it is proven that no plan is shorter.
    pub shortest: bool,
    /// Proven lower bound on the steps of a plan, in the worst case; 0 if none is known.
    pub at_least: u32,
    /// Number of states that the search looked at.
    pub states: usize,
}

/// A part of an instruction.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct PartAnswer {
    /// Its text.
    pub text: String,
    /// Its first byte in the instruction, whose spaces and line breaks are single spaces.
    pub start: usize,
    /// `goal`, `constraint`, `background` or `not_represented`.
    pub role: &'static str,
    /// For `goal` and `constraint`, the indices in `goal` of what it asks for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub goals: Vec<usize>,
}

/// A part of an instruction that the goal does not represent.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct GapAnswer {
    /// Its text.
    pub text: String,
    /// `prohibition`, `quantity`, `condition`, `order`, `quotation`, `name` or `other`.
    pub kind: &'static str,
    /// True if it makes the answer a question.
    pub question: bool,
}

/// An edit of a repair.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct EditAnswer {
    /// `insert`, `drop`, `replace` or `move`.
    pub kind: &'static str,
    /// Index in the repaired plan, from 0: of the new step, or of the position of a dropped one.
    pub at: usize,
    /// The call before the edit; none for an insertion.
    pub before: Option<String>,
    /// The call after the edit; none for a dropped step.
    pub after: Option<String>,
    /// The reason, in one sentence.
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
#[non_exhaustive]
pub struct StepAnswer {
    /// Index, from 0.
    pub index: usize,
    /// Name of the call.
    pub action: String,
    /// Arguments that the call shows.
    pub arguments: Vec<String>,
    /// Arguments that the call hides, by parameter name.
    pub implicit: indexmap::IndexMap<String, String>,
    /// The actor (hand, arm or robot); none if the domain has only one or the step takes several.
    pub arm: Option<String>,
    /// Description of the step.
    pub explanation: String,
}

/// A violation of an [`Answer`].
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ViolationAnswer {
    /// Kind, for example `precondition`.
    pub kind: &'static str,
    /// Index of the step, from 0; none for the plan as a whole.
    pub step: Option<usize>,
    /// Call of that step.
    pub action: Option<String>,
    /// Missing facts, as sentences.
    pub missing: Vec<String>,
    /// Index of the step that removed them, from 0.
    pub undone_by: Option<usize>,
    /// Sensing outcomes of the branches with this violation, as sentences; empty if it occurs on every branch.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub when: Vec<String>,
    /// The violation as one sentence.
    pub message: String,
}

/// Comparison of the claimed and the simulated environment, by entity.
#[derive(Debug, Clone, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Claims {
    /// Number of entities with equal states.
    pub agreed: usize,
    /// Entities with different states.
    pub differing: Vec<Differing>,
}

/// An entity whose claimed state differs from the simulated one.
#[derive(Debug, Clone, PartialEq, Serialize)]
#[non_exhaustive]
pub struct Differing {
    /// The entity.
    pub entity: String,
    /// Its states as claimed.
    pub claimed: String,
    /// Its states as simulated.
    pub simulated: String,
}

/// Token counts of model calls.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct UsageAnswer {
    /// Number of calls.
    pub calls: u32,
    /// Number of feedback rounds.
    pub rounds: u32,
    /// Prompt tokens.
    pub prompt_tokens: u64,
    /// Prompt tokens that came from the prefix cache.
    pub cached_tokens: u64,
    /// Generated tokens.
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

/// The foreseen cost of a request for a whole plan.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
#[non_exhaustive]
pub struct ForecastAnswer {
    /// Tokens of the prompt.
    pub prompt_tokens: u64,
    /// Tokens of a usual answer.
    pub answer_tokens: u64,
    /// The model's context length, if known.
    pub context: Option<u64>,
    /// False if a round of correction may exceed the context.
    pub correction_fits: bool,
    /// Estimated seconds, from the model's measured speed; none if no speed is known.
    pub seconds: Option<f64>,
}

/// Durations in milliseconds.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize)]
#[non_exhaustive]
pub struct Timings {
    /// Loading and calling the model.
    pub model: f64,
    /// Verification.
    pub verify: f64,
    /// Search.
    pub search: f64,
    /// The whole command.
    pub total: f64,
}

impl Answer {
    /// Describes in one sentence why there is no verified plan: the violations, else the status.
    pub fn sentence(&self) -> String {
        let messages: Vec<&str> = self.violations.iter().map(|found| found.message.as_str()).collect();
        match messages.as_slice() {
            [] => self.status.sentence().to_owned(),
            messages => messages.join("; "),
        }
    }

    /// Creates an answer without a plan; the environment is unchanged.
    pub fn without_plan(status: Status, world: &World, summary: &str, question: &str) -> Self {
        Self {
            status,
            plan: PlanFile {
                task_cohesion: TaskCohesion::default(),
                environment_before: Some(world.environment().clone()),
                environment_after: Some(world.environment().clone()),
                endings: Vec::new(),
                instruction_summary: summary.to_owned(),
                question: question.to_owned(),
                not_in_plan: Vec::new(),
                purpose: None,
                domain: None,
            },
            steps: Vec::new(),
            goal: Vec::new(),
            groups: Vec::new(),
            choices: Vec::new(),
            cost: None,
            edits: Vec::new(),
            violations: Vec::new(),
            claims: Claims::default(),
            coverage: Vec::new(),
            not_represented: Vec::new(),
            assumptions: Vec::new(),
            readings: Vec::new(),
            search: None,
            forecast: None,
            usage: UsageAnswer::default(),
            timings_ms: Timings::default(),
            notes: Vec::new(),
            outline: Vec::new(),
        }
    }

    /// Creates the answer for a simulated plan, valid or invalid.
    pub fn of_report(world: &World, report: &Report, goal: Option<&Goal>, summary: &str) -> Self {
        let good = report.violations.is_empty();
        let status = if good { Status::Verified } else { Status::Invalid };
        let mut answer = Self::without_plan(status, world, summary, "");
        answer.plan.task_cohesion = TaskCohesion::new(world, &report.plan);
        let environment = |ending: &Ending| environment::write(world, &ending.after);
        (answer.plan.environment_after, answer.plan.endings) = plan::endings(world, &report.endings, environment);
        answer.outline = plan::outline(world, &report.plan);
        answer.steps = report
            .plan
            .steps()
            .iter()
            .enumerate()
            .map(|(i, s)| StepAnswer::of(world, i, s))
            .collect();
        let calls: Vec<String> = report
            .plan
            .steps()
            .iter()
            .map(|step| step.call(world).to_string())
            .collect();
        let violations = report.violations.iter();
        answer.violations = violations
            .map(|v| ViolationAnswer::of(world, v, &calls, report.plan.steps(), goal))
            .collect();
        answer.cost = report.cost().map(Number::approximate);
        answer.assumptions = report.assumptions.iter().map(|a| a.message(world)).collect();
        let odd = report.warnings.iter();
        answer.notes = odd
            .map(|warning| warning.message(world, report.plan.steps(), goal.map(Goal::as_sentences)))
            .collect();
        answer
            .notes
            .extend(report.cost().map(|cost| format!("the plan costs {cost}")));
        if let Some(goal) = goal {
            answer.set_goal(world, goal);
            let choices = goal.choices().map(|choice| {
                let chosen = choice.achieved(report);
                ChoiceAnswer {
                    goal: GoalFact::Choice(choice.clone()).exact(world),
                    chosen: chosen.iter().map(|goal| goal.exact(world)).collect(),
                    says: chosen.iter().map(|goal| goal.sentence(world)).collect(),
                }
            });
            answer.choices = choices.collect();
        }
        answer.set_purpose(world);
        answer
    }

    /// Gives the plan file the purpose for which the plan was made.
    fn set_purpose(&mut self, world: &World) {
        self.plan.purpose = PurposeFile::new(world, &self.goal).map(|purpose| PurposeFile {
            choices: self.choices.iter().map(ChoiceFile::from).collect(),
            assumptions: self.assumptions.clone(),
            ..purpose
        });
    }

    /// Sets the goal and its groups.
    pub(super) fn set_goal(&mut self, world: &World, goal: &Goal) {
        self.goal = goal.exact(world);
        self.groups.clear();
        for group in goal.groups.iter().flat_map(|part| &part.groups) {
            let group = GroupAnswer::of(world, group);
            if !self.groups.contains(&group) {
                self.groups.push(group);
            }
        }
        self.set_purpose(world);
    }

    /// Creates the answer for a plan that cannot be simulated because its steps cannot be resolved. `calls` are the
    /// steps as written.
    pub fn of_unresolved(world: &World, written: &PlanFile, calls: &[String], issues: &[Violation]) -> Self {
        let mut answer = Self::without_plan(Status::Invalid, world, &written.instruction_summary, "");
        answer.plan.task_cohesion.clone_from(&written.task_cohesion);
        answer.violations = issues
            .iter()
            .map(|v| ViolationAnswer::of(world, v, calls, &[], None))
            .collect();
        answer
    }

    /// Replaces the plan by its parallel form and adds a note about the saved time.
    pub fn side_by_side(&mut self, world: &World, compacted: &Compacted) {
        let now = Self::of_report(world, compacted.plan.report(), None, "");
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

    /// Adds the roles of the instruction's parts. Constraints follow the goals in `goal`.
    pub fn set_coverage(&mut self, goal: &Goal, coverage: &Coverage) {
        let part = |part: &coverage::InstructionPart| {
            let (role, goals) = match &part.role {
                CoverageRole::Goals(goals) => ("goal", goals.clone()),
                CoverageRole::Constraints(constraints) => {
                    let place = |index: &usize| goal.facts.len() + index;
                    ("constraint", constraints.iter().map(place).collect())
                }
                CoverageRole::Background => ("background", Vec::new()),
                CoverageRole::NotRepresented(_) => ("not_represented", Vec::new()),
            };
            PartAnswer {
                text: coverage.text(part).to_owned(),
                start: part.range.start,
                role,
                goals,
            }
        };
        let gap = |(text, gap): (&str, Gap)| GapAnswer {
            text: text.to_owned(),
            kind: gap.name(),
            question: gap.is_question(),
        };
        self.coverage = coverage.parts().iter().map(part).collect();
        self.not_represented = coverage.gaps().map(gap).collect();
        self.plan.not_in_plan = self.not_represented.iter().map(|gap| gap.text.clone()).collect();
    }

    /// Returns the question in place of the plan that it is about: the goal and the coverage stay, the steps do not.
    #[must_use]
    pub fn as_question(&self, world: &World, question: &str) -> Self {
        let summary = &self.plan.instruction_summary;
        Self {
            goal: self.goal.clone(),
            coverage: self.coverage.clone(),
            not_represented: self.not_represented.clone(),
            assumptions: self.assumptions.clone(),
            readings: self.readings.clone(),
            usage: self.usage,
            timings_ms: self.timings_ms,
            ..Self::without_plan(Status::Question, world, summary, question)
        }
    }
}

impl ViolationAnswer {
    fn of(world: &World, violation: &Violation, calls: &[String], steps: &[Step], goal: Option<&Goal>) -> Self {
        Self {
            kind: violation.kind(),
            step: violation.step(),
            action: violation.step().and_then(|step| calls.get(step).cloned()),
            missing: violation.missing(world),
            undone_by: violation.undone_by(),
            when: violation
                .outcomes()
                .iter()
                .map(|fact| Voice::Person.fact(world, *fact, true))
                .collect(),
            message: violation.message(world, steps, goal.map(Goal::as_sentences)),
        }
    }
}

impl StepAnswer {
    fn of(world: &World, index: usize, step: &Step) -> Self {
        let domain = world.domain();
        let action = domain.action(step.action);
        let call = step.call(world);
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

/// Compares the claimed final state of a plan with the simulated one.
pub fn compare_claims(world: &World, claim: &Claim, simulated: &State) -> Claims {
    let words = |state: &State| words_by_entity(world, state);
    let (claimed, simulated) = (words(&claim.state), words(simulated));
    let mut claims = Claims::default();
    for (id, entity) in world.entities().filter(|(id, _)| claim.mentions(*id)) {
        let (claimed, simulated) = (&claimed[id.index()], &simulated[id.index()]);
        if claimed == simulated {
            claims.agreed += 1;
        } else {
            claims.differing.push(Differing {
                entity: entity.identifier.clone(),
                claimed: claimed.join(", "),
                simulated: simulated.join(", "),
            });
        }
    }
    claims
}

/// Returns the state words of each entity, sorted.
fn words_by_entity(world: &World, state: &State) -> Vec<Vec<String>> {
    let mut all = vec![Vec::new(); world.entities().count()];
    for fact in state.iter() {
        for (subject, text) in entries_of(world, fact) {
            all[subject.index()].push(text);
        }
    }
    for (fluent, number) in state.numbers() {
        if let (Some(subject), text) = entry_of_number(world, *fluent, *number) {
            all[subject.index()].push(text);
        }
    }
    all.iter_mut().for_each(|words| words.sort());
    all
}

/// Returns the statements without a subject that differ.
fn facts(before: &Environment, after: &Environment) -> Changed {
    let given = |environment: &Environment| environment.facts.clone().unwrap_or_default();
    let only = |these: &[String], others: &[String]| -> String {
        let own: Vec<String> = these.iter().filter(|own| !others.contains(own)).cloned().collect();
        own.join(", ")
    };
    let (was, is) = (given(before), given(after));
    ("facts".to_owned(), only(&was, &is), only(&is, &was))
}

/// A changed entity: its identifier, and its states before and after.
pub type Changed = (String, String, String);

/// Returns the entities whose states differ between two environments: objects first, in the order of `before`.
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
        .chain([facts(before, after)])
        .filter(|(_, was, is)| was != is)
        .collect()
}
