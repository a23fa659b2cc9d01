//! Assessment of a written plan, shared by `longstep verify`, `longstep repair` and the direct strategy.

use std::borrow::Cow;
use std::cell::OnceCell;

use super::feedback::feedback;
use super::solution::reasons;
use super::{Answer, Claims, EditAnswer, Status, compare_claims};
use crate::environment::{Claim, Voice, World};
use crate::goal::Goal;
use crate::instruction::Mentions;
use crate::plan::{self, PlanFile, Resolved, resolve};
use crate::repair::{Pins, RepairOutcome, Repaired, repair_pinned, why_unsolvable};
use crate::search::Wanted;
use crate::verify::{Assumption, Purpose, Report, VerifiedPlan, Violation, bind_tree, check};

/// Maximum number of edits that a hint lists; more are only counted.
const LISTED_EDITS: usize = 4;

/// A written plan in a world. Simulation and repair run on first use and at most once.
#[derive(Debug, Clone)]
pub struct Assessment<'a> {
    world: Cow<'a, World>,
    /// The plan as written.
    pub file: PlanFile,
    /// The plan resolved in domain and world.
    pub resolved: Resolved,
    /// The purpose that the plan states.
    pub purpose: Purpose,
    /// The goal for which the plan was made, if it is known.
    goal: Option<Goal>,
    /// Notes on lenient parsing and on ignored claims.
    notes: Vec<String>,
    /// Steps that a repair must keep.
    pins: Pins,
    simulation: OnceCell<Result<Simulation, Vec<Violation>>>,
    repair: OnceCell<RepairOutcome>,
}

/// A simulated plan, and the assumptions that bind its open arguments.
#[derive(Debug, Clone)]
pub(crate) struct Simulation {
    pub(crate) report: Report,
    open: Vec<Assumption>,
}

impl<'a> Assessment<'a> {
    /// Resolves a draft. `instruction` replaces the plan's own summary, if given.
    ///
    /// ```
    /// use longstep::domain;
    /// use longstep::report::{Assessment, Status};
    /// use longstep_core::{plan, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"objects": ["<pen>"], "assets": ["<desk>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let draft = plan::read(r#"{"task_cohesion": {"task_sequence": ["grasp_object()"], "object_name": "<pen>"}}"#);
    /// let assessment = Assessment::new(&world, draft.unwrap(), None);
    /// let answer = assessment.verdict();
    /// assert_eq!(answer.status, Status::Invalid);
    /// assert_eq!(answer.violations[0].message, "step 1: grasp_object() needs that the hand is at the pen");
    /// ```
    pub fn new(world: &'a World, draft: plan::Draft, instruction: Option<&str>) -> Self {
        let file = draft.file;
        let world = file.world_of(world);
        let mut notes: Vec<String> = draft.leniencies.iter().map(|leniency| leniency.message()).collect();
        let claim = file
            .environment_after
            .as_ref()
            .map(|environment| Claim::read(&world, environment));
        for ignored in claim.iter().flat_map(|claim| &claim.ignored) {
            notes.push(format!("`environment_after` was compared without {ignored}"));
        }
        let resolved = resolve(&world, &file.task_cohesion);
        let instruction = instruction.unwrap_or(&file.instruction_summary).trim();
        let mentioned = match instruction {
            "" => Vec::new(),
            instruction => Mentions::of(&world, instruction).entities.into_iter().collect(),
        };
        let ignored = resolved.ignored.iter();
        notes.extend(ignored.map(|claim| format!("the plan was checked without what it claims here: {claim}")));
        let purpose = Purpose {
            claim,
            step_claims: resolved.claims.clone(),
            mentioned,
            ..Purpose::default()
        };
        Self {
            world,
            file,
            resolved,
            purpose,
            goal: None,
            notes,
            pins: Pins::default(),
            simulation: OnceCell::new(),
            repair: OnceCell::new(),
        }
    }

    /// Sets the goal for which the plan was made: it has to achieve it, in its order, and to keep its constraints.
    #[must_use]
    pub fn for_goal(self, goal: Goal) -> Self {
        let purpose = goal.purpose(&self.world);
        Self {
            purpose: Purpose {
                claim: self.purpose.claim,
                step_claims: self.purpose.step_claims,
                mentioned: self.purpose.mentioned,
                ..purpose
            },
            goal: Some(goal),
            simulation: OnceCell::new(),
            repair: OnceCell::new(),
            ..self
        }
    }

    /// Sets conditions that have to hold at the end: the goal of a PDDL problem.
    #[must_use]
    pub fn wanting(mut self, wanted: Vec<Wanted>) -> Self {
        self.purpose.wanted.extend(wanted);
        self.simulation = OnceCell::new();
        self.repair = OnceCell::new();
        self
    }

    /// Adds notes for a person, which the answer has.
    #[must_use]
    pub fn noting(mut self, notes: impl IntoIterator<Item = String>) -> Self {
        self.notes.extend(notes);
        self
    }

    /// Sets the steps that a repair must keep.
    #[must_use]
    pub fn pinned(self, pins: Pins) -> Self {
        Self {
            pins,
            repair: OnceCell::new(),
            ..self
        }
    }

    /// Returns the question that replaces the plan, if any.
    pub fn question(&self) -> Option<&str> {
        let question = self.file.question.trim();
        (self.resolved.written.is_empty() && !question.is_empty()).then_some(question)
    }

    /// Simulates the plan.
    ///
    /// # Errors
    ///
    /// The issues that prevent simulation: unknown names, and arguments that no entity fits.
    pub(crate) fn simulation(&self) -> Result<&Simulation, &[Violation]> {
        let simulate = || {
            let claim = self.purpose.claim.as_ref();
            let (plan, open) = bind_tree(&self.world, &self.resolved, claim)?;
            let report = check(&self.world, plan, &self.purpose);
            Ok(Simulation { report, open })
        };
        self.simulation.get_or_init(simulate).as_ref().map_err(Vec::as_slice)
    }

    /// Returns the answer without repair.
    pub fn verdict(&self) -> Answer {
        let world = &*self.world;
        if let Some(question) = self.question() {
            return Answer::without_plan(Status::Question, world, &self.file.instruction_summary, question);
        }
        match self.simulation() {
            Ok(simulation) => self.answer(&simulation.report, &simulation.open),
            Err(issues) => {
                let mut answer = Answer::of_unresolved(world, &self.file, &self.resolved.written, issues);
                self.remark(&mut answer);
                answer
            }
        }
    }

    /// Creates the answer for a simulated plan.
    fn answer(&self, report: &Report, open: &[Assumption]) -> Answer {
        let world = &*self.world;
        let mut answer = Answer::of_report(world, report, self.goal.as_ref(), &self.file.instruction_summary);
        answer.assumptions.extend(open.iter().map(|a| a.message(world)));
        let claim = self.purpose.claim.as_ref();
        answer.claims = claim.map_or_else(Claims::default, |claim| {
            compare_claims(world, claim, &report.claimed_ending().after)
        });
        if let (Some(number), true) = (report.claimed, report.endings.len() > 1) {
            let when = report.endings[number].when.iter();
            let facts: Vec<String> = when.map(|fact| Voice::Person.fact(world, *fact, true)).collect();
            let ending = number + 1;
            answer.notes.push(match facts.as_slice() {
                [] => format!(
                    "the plan claims the world of ending {ending} of {}",
                    report.endings.len()
                ),
                facts => format!("the plan claims the world for the case that {}", facts.join(" and ")),
            });
        }
        self.remark(&mut answer);
        answer
    }

    fn remark(&self, answer: &mut Answer) {
        answer.plan.question.clone_from(&self.file.question);
        let readings = self.resolved.readings.iter();
        let messages = readings.map(|reading| reading.message(&self.world));
        answer.assumptions.splice(0..0, messages);
        answer.notes.splice(0..0, self.notes.iter().cloned());
    }

    /// Finds the cheapest repair that keeps the pinned steps.
    pub fn repair(&self) -> &RepairOutcome {
        let find = || repair_pinned(&self.world, &self.resolved, &self.purpose, &self.pins);
        self.repair.get_or_init(find)
    }

    /// Returns the plan without repair, if it is valid.
    pub fn verified(&self) -> Option<VerifiedPlan> {
        self.simulation().ok()?.report.clone().into_verified().ok()
    }

    /// Returns the answer after repair.
    pub fn repaired(&self) -> Answer {
        let world = &*self.world;
        let outcome = self.repair();
        let mut answer = match outcome {
            RepairOutcome::Repaired(repaired) => self.answer(repaired.plan.report(), &[]),
            _ => self.verdict(),
        };
        match outcome {
            RepairOutcome::Valid(_) => {}
            RepairOutcome::Repaired(repaired) => {
                answer.edits = repaired.edits.iter().map(EditAnswer::from).collect();
                if !repaired.cheapest {
                    let note = "a smaller change may exist: the search for it was cut short";
                    answer.notes.push(note.to_owned());
                }
                // Edits show the issues of single steps; issues of the whole plan become notes.
                let whole = self.resolved.issues.iter().filter(|issue| issue.step().is_none());
                let messages = whole.map(|issue| issue.message(world, &[], None));
                answer.notes.extend(messages);
                let given_up = given_up(world, repaired).into_iter();
                let notes = given_up.map(|fact| format!("claimed and given up: {fact}"));
                answer.notes.extend(notes);
            }
            RepairOutcome::Unclear { why } => {
                let note = format!("not repaired, since that would be guessing: {why}");
                answer.notes.push(note);
            }
            RepairOutcome::ProvenUnsolvable { .. } => {
                answer.status = Status::Unsolvable;
                let why = why_unsolvable(world, &self.resolved, &self.purpose);
                answer.notes.extend(reasons(world, self.goal.as_ref(), &why));
            }
            RepairOutcome::GaveUp { why, .. } => {
                answer.status = Status::GaveUp;
                answer.notes.push(why.clone());
            }
        }
        answer
    }

    /// Returns a hint with the edits of a repair, if one exists.
    pub fn advice(&self) -> Option<String> {
        let RepairOutcome::Repaired(repaired) = self.repair() else {
            return None;
        };
        let length = self.resolved.written.len();
        let mut changes: Vec<String> = match repaired.edits.len() {
            0..=LISTED_EDITS => repaired.edits.iter().map(|edit| edit.description(length)).collect(),
            many => vec![format!("{many} changes")],
        };
        let given_up = given_up(&self.world, repaired).into_iter();
        changes.extend(given_up.map(|fact| format!("give up that {fact}")));
        if changes.is_empty() {
            changes.push("its steps stay as they are".to_owned());
        }
        Some(format!("`longstep repair` makes it valid: {}", changes.join("; ")))
    }

    /// Returns the feedback for a model, with the edits of the cheapest repair if one exists.
    ///
    /// ```
    /// use longstep::{domain, report::Assessment};
    /// use longstep_core::{plan, environment};
    /// let domain = domain::shipped("virtualhome").unwrap().unwrap();
    /// let text = r#"{"assets": ["<desk_1>"], "objects": ["<mug_2>"], "object_states": {"<mug_2>": "ON(<desk_1>)"}}"#;
    /// let world = environment::parse(&domain, "env.json", text).unwrap();
    /// let draft = plan::read(r#"{"task_cohesion": {"task_sequence": ["Grab(<mug_2>)"]}}"#).unwrap();
    /// let feedback = Assessment::new(&world, draft, None).feedback();
    /// assert!(feedback.contains("step 1: Grab(<mug_2>) needs that <mug_2> is within reach"));
    /// ```
    pub fn feedback(&self) -> String {
        let (violations, steps) = match self.simulation() {
            Ok(simulation) => (&*simulation.report.violations, simulation.report.plan.steps()),
            Err(issues) => (issues, &[][..]),
        };
        let edits = match self.repair() {
            RepairOutcome::Repaired(repaired) => &*repaired.edits,
            _ => &[],
        };
        let length = self.resolved.written.len();
        feedback(&self.world, violations, steps, length, edits)
    }
}

/// Returns the claims that a repaired plan violates, as sentences.
fn given_up(world: &World, repaired: &Repaired) -> Vec<String> {
    let sentence = |fact: &_| Voice::Person.fact(world, *fact, true);
    repaired.given_up.iter().map(sentence).collect()
}
