//! One trial of one case: a session with a model, and the results of its instructions.

use std::sync::Arc;
use std::time::Instant;

use longstep::Clock;
use longstep::domain::Domain;
use longstep::goal::Goal;
use longstep::session::{Event, Proposal, Session, Settings, Strategy};
use longstep_core::environment::{Voice, World};
use longstep_core::verify::VerifiedPlan;
use longstep_llm::{AdvanceError, ChatModel, Watch, advance};

use crate::attempt::{Attempt, Edit, Key, Outcome, PlanLine, Timing, Wanted};
use crate::failure::{self, Failure};
use crate::judge::{Amiss, Standard};
use crate::suite::{Case, Expected, Step, Suite};

/// A trial of a case in one wording: the unit of running and saving.
#[derive(Debug, Clone, Copy)]
pub struct Unit<'a> {
    /// The case.
    pub case: &'a Case,
    /// The wording.
    pub wording: &'a str,
    /// The trial, from 1.
    pub trial: u32,
}

/// The attempts of a unit, step by step.
pub type Lines = Vec<(Attempt, Timing)>;

/// Runs a unit.
///
/// Each step begins in the world after the step before. After an incorrect step, the next one begins, in a new session,
/// in the world after a plan that search finds for the expected goal. So each step is measured on its own.
///
/// # Errors
///
/// When the model fails or is stopped. A prompt that does not fit is a failed attempt, not an error.
pub fn run(
    suite: &Suite,
    domain: &Arc<Domain>,
    unit: Unit<'_>,
    settings: Settings,
    model: &mut dyn ChatModel,
    watch: &mut dyn Watch,
) -> Result<Lines, AdvanceError> {
    let facts = model.facts();
    let begin = |world: World| {
        Session::new(
            &suite.domain,
            Arc::clone(domain),
            world,
            settings,
            facts.clone(),
            Clock::none(),
        )
    };
    let mut session = begin(suite.world(unit.case));
    let judged = &suite.judged[&unit.case.scene];
    let mut lines = Lines::new();
    for (number, step) in unit.case.steps.iter().enumerate() {
        let says = step.in_words(unit.wording).unwrap_or(&step.says);
        let key = Key {
            case: unit.case.id.clone(),
            step: number,
            wording: unit.wording.to_owned(),
            trial: unit.trial,
        };
        session.take_events();
        let started = Instant::now();
        // The session waits for an instruction: it has executed the step before, or given it up.
        let advanced = match session.instruct(says) {
            Ok(()) => advance(&mut session, model, None, watch),
            Err(_) => Ok(()),
        };
        let fits = match advanced {
            Ok(()) => true,
            Err(AdvanceError::Prompt(_)) => false,
            Err(error) => return Err(error),
        };
        let total_ms = started.elapsed().as_secs_f64() * 1000.0;
        let (_, model_ms) = session.cost();
        let mut world = session.world().clone();
        world.share_values(judged);
        let goals = step.expected.goals().iter();
        let goals: Option<Vec<Goal>> = goals.map(|goal| goal.carried(domain, judged, &world)).collect();
        // Both worlds have the entities of the scene and these values.
        let goals = goals.unwrap_or_else(|| step.expected.goals().to_vec());
        let standard = Standard::new(&world, &goals);
        let events = session.take_events();
        let attempt = Observed {
            domain,
            world: &world,
            session: &session,
            events: &events,
            standard: &standard,
            goals: &goals,
            fits,
        }
        .attempt(key.clone(), unit.case, step, says);
        let right = attempt.correct;
        let cached_tokens = session.cost().0.cached_tokens;
        lines.push((
            attempt,
            Timing {
                key,
                cached_tokens,
                model_ms,
                total_ms,
            },
        ));
        match (right, &step.expected) {
            (true, Expected::Plan(_)) => {
                // There is a plan; any of its ends will do.
                let _ = session.accept();
                let _ = session.ended(0);
            }
            (true, _) => {
                let _ = session.cancel();
            }
            // After the last step no further world is needed.
            (false, _) if number + 1 == unit.case.steps.len() => {}
            (false, _) => {
                let next = standard
                    .reference()
                    .map_or_else(|| world.clone(), |plan| world.after(plan.ending()));
                session = begin(next);
            }
        }
    }
    Ok(lines)
}

/// A session after an instruction.
struct Observed<'a> {
    domain: &'a Domain,
    world: &'a World,
    session: &'a Session,
    events: &'a [Event],
    standard: &'a Standard<'a>,
    /// The expected goals.
    goals: &'a [Goal],
    /// True if the prompt fitted into the model's context.
    fits: bool,
}

impl Observed<'_> {
    fn attempt(&self, key: Key, case: &Case, step: &Step, says: &str) -> Attempt {
        let world = self.world;
        let proposal = self.proposal();
        let answer = match (proposal, self.session.failure()) {
            (Some(proposal), _) => Some(&proposal.answer),
            (None, Some(failure)) => failure.answer(),
            (None, None) => None,
        };
        let outcome = self.outcome();
        let plan = proposal.map(|proposal| &proposal.plan);
        let amiss = plan.map(|plan| self.standard.amiss(plan.plan())).unwrap_or_default();
        let why = self.why(step, outcome, plan, &amiss);
        let (usage, _) = self.session.cost();
        let goal = proposal.and_then(|proposal| proposal.goal.as_ref());
        let understood = goal.iter().flat_map(|goal| goal.everyday(world));
        let mut attempt = Attempt {
            key,
            scene: case.scene.clone(),
            tags: case.tags.clone(),
            says: says.to_owned(),
            expected: self.wanted(&step.expected),
            outcome,
            executable: outcome == Outcome::Verified,
            correct: why.is_empty(),
            why,
            failures: Vec::new(),
            rounds: answer.map_or(0, |answer| answer.usage.rounds),
            edits: answer.iter().flat_map(|answer| &answer.edits).map(Edit::from).collect(),
            claim_right: None,
            understood: understood.collect(),
            question: self.question().unwrap_or_default().to_owned(),
            readings: self.session.readings().to_vec(),
            replies: Vec::new(),
            corrections: Vec::new(),
            plan: self.lines(plan),
            violations: Vec::new(),
            calls: usage.calls,
            prompt_tokens: usage.prompt_tokens,
            completion_tokens: usage.completion_tokens,
        };
        if let Some(answer) = answer {
            attempt.violations = answer
                .violations
                .iter()
                .map(|violation| violation.message.clone())
                .collect();
            let claims = &answer.claims;
            attempt.claim_right =
                (claims.agreed > 0 || !claims.differing.is_empty()).then_some(claims.differing.is_empty());
        }
        for event in self.events {
            match event {
                Event::Reply { text, .. } => attempt.replies.push(text.clone()),
                Event::Correction { text } => attempt.corrections.push(text.clone()),
                _ => {}
            }
        }
        attempt.failures = self.failures(&attempt, &amiss);
        attempt
    }

    /// The plan that was proposed without a question.
    fn proposal(&self) -> Option<&Proposal> {
        self.session.proposal().filter(|proposal| proposal.question.is_none())
    }

    /// The question of the model, or the one about a plan that leaves out a part of the instruction.
    fn question(&self) -> Option<&str> {
        let of_plan = || self.session.proposal()?.question.as_deref();
        self.session.question().or_else(of_plan)
    }

    fn outcome(&self) -> Outcome {
        if !self.fits {
            return Outcome::Limit;
        }
        if self.question().is_some() {
            return Outcome::Question;
        }
        match (self.proposal(), self.session.failure()) {
            (Some(_), _) => Outcome::Verified,
            (None, Some(failure)) => match failure.answer() {
                Some(answer) => answer.status.into(),
                None if failure.is_limit() => Outcome::Limit,
                None => Outcome::Unusable,
            },
            (None, None) => Outcome::Unusable,
        }
    }

    /// The reasons why the result is not the expected one; empty if it is.
    fn why(&self, step: &Step, outcome: Outcome, plan: Option<&VerifiedPlan>, amiss: &Amiss) -> Vec<String> {
        let one = |text: &str| vec![text.to_owned()];
        let proven = outcome == Outcome::Unsolvable;
        match (&step.expected, plan) {
            (Expected::Plan(_), Some(_)) => amiss.sentences(),
            (Expected::Plan(_), None) => match outcome {
                Outcome::Question => one("a question, although the instruction was complete"),
                Outcome::Invalid => one("the plan is not valid"),
                _ => one("there is no plan"),
            },
            (Expected::Nothing, Some(plan)) if plan.steps().is_empty() => Vec::new(),
            (Expected::Nothing, Some(_)) => one("it did something, and there was nothing to do"),
            (_, Some(_)) => one("it planned, and there was nothing to plan"),
            (Expected::Question | Expected::Either | Expected::Nothing, None) if outcome == Outcome::Question => {
                Vec::new()
            }
            (Expected::Refusal | Expected::Either, None) if proven => Vec::new(),
            // Giving up without a proof is accepted here.
            (Expected::Either, None) if outcome == Outcome::GaveUp => Vec::new(),
            (Expected::Question, None) => one("it did not ask back"),
            (Expected::Refusal, None) => one("it did not find out that there is no plan"),
            (Expected::Nothing, None) => one("it neither asked back nor said that there is nothing to do"),
            (Expected::Either, None) => one("it neither asked back nor said that it has no plan"),
        }
    }

    fn wanted(&self, expected: &Expected) -> Wanted {
        match expected {
            Expected::Plan(_) => Wanted::Plan(
                self.goals
                    .iter()
                    .map(|goal| goal.everyday(self.world).join(" & "))
                    .collect(),
            ),
            Expected::Question => Wanted::Question,
            Expected::Refusal => Wanted::Refusal,
            Expected::Either => Wanted::Either,
            Expected::Nothing => Wanted::Nothing,
        }
    }

    fn lines(&self, plan: Option<&VerifiedPlan>) -> Vec<PlanLine> {
        let Some(plan) = plan else { return Vec::new() };
        let world = self.world;
        let mut changes: Vec<Vec<String>> = vec![Vec::new(); plan.steps().len()];
        for (step, changed) in plan.ending().trace.steps() {
            changes[step.index()] = changed
                .iter()
                .map(|change| Voice::Person.fact(world, change.fact, change.holds))
                .collect();
        }
        let outline = longstep_core::plan::outline(world, plan.plan());
        let line = |line: longstep_core::plan::OutlineLine| PlanLine {
            changes: line.step.map(|step| changes[step].clone()).unwrap_or_default(),
            step: line.step,
            depth: line.depth,
            text: line.text,
            explanation: line.explanation,
        };
        outline.into_iter().map(line).collect()
    }

    fn failures(&self, attempt: &Attempt, amiss: &Amiss) -> Vec<Failure> {
        let mut found = Vec::new();
        let wants_plan = attempt.wants_plan();
        match attempt.outcome {
            Outcome::Unusable | Outcome::Limit => found.push(Failure::Unusable),
            Outcome::Question if wants_plan => found.push(Failure::AskedNeedlessly),
            Outcome::Unsolvable | Outcome::GaveUp if wants_plan => found.push(Failure::NoPlan),
            _ if !wants_plan && !attempt.correct => found.push(Failure::DidNotAsk),
            _ => {}
        }
        let direct = self.session.settings().strategy == Strategy::Direct;
        if wants_plan && direct {
            if let Some(reply) = attempt.replies.first() {
                found.extend(failure::of_draft(self.world, reply, &attempt.says));
            }
            if attempt.outcome == Outcome::Verified && !attempt.correct {
                found.extend((!amiss.unexpected.is_empty()).then_some(Failure::ExtraGoal));
                found.extend((!amiss.unreached.is_empty()).then_some(Failure::MissingGoal));
            }
        }
        let goal = self.proposal().and_then(|proposal| proposal.goal.as_ref());
        if let Some(goal) = goal.filter(|_| wants_plan && !attempt.correct) {
            found.extend(failure::of_goal(self.domain, goal, self.goals));
        }
        found.sort_unstable();
        found.dedup();
        found
    }
}
