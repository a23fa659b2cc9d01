//! Kinds of failures.
//!
//! This is the complete definition. Failures are found in the model's first reply, so corrected ones count as well.
//!
//! A plan of the model (direct strategy) is compared with its cheapest repair:
//!
//! - [`Failure::UnknownName`]: a call, an object or a parameter that does not exist, or of the wrong kind or number.
//! - [`Failure::WrongVerb`]: repair replaces a step by another action on the same objects (the paper's first pattern).
//! - [`Failure::LeftOutStep`]: repair inserts a step (the paper's second pattern).
//! - [`Failure::WrongOrder`]: repair moves a step.
//! - [`Failure::WrongObject`]: repair replaces a step by one on other objects.
//! - [`Failure::NeedlessStep`]: repair drops a step.
//! - [`Failure::UnmetPrecondition`]: the plan is not valid, and repair finds no valid plan, or none within
//!   [`effort::OPERATION`] units of work.
//! - [`Failure::WrongClaim`]: the environment that the model claims is not the simulated one.
//!
//! The goals of the model (goal strategy) are compared with the nearest of the expected goals, part by part:
//!
//! - [`Failure::WrongObject`]: a part with an expected goal word, but another object or place.
//! - [`Failure::WrongGoalWord`]: a part with an expected object, but another goal word.
//! - [`Failure::ExtraGoal`]: an unexpected part. With the direct strategy: a change that the instruction does not
//!   require.
//! - [`Failure::MissingGoal`]: a missing part. With the direct strategy: a goal that is not reached.
//!
//! For either strategy:
//!
//! - [`Failure::AskedNeedlessly`]: a question although a plan was expected.
//! - [`Failure::DidNotAsk`]: a plan although a question, or no plan, was expected; or no plan although a question was.
//! - [`Failure::NoPlan`]: a plan was expected, and none was found for the goals.
//! - [`Failure::Unusable`]: a reply that cannot be read, or a prompt that does not fit.

use longstep::domain::Domain;
use longstep::goal::{Goal, GoalFact};
use longstep::report::Assessment;
use longstep_core::call::Call;
use longstep_core::effort;
use longstep_core::environment::World;
use longstep_core::plan;
use longstep_core::repair::{Edit, EditKind, RepairOutcome};
use serde::{Deserialize, Serialize};

/// A kind of failure.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[allow(missing_docs, reason = "the module says what each of them is")]
pub enum Failure {
    WrongVerb,
    LeftOutStep,
    WrongOrder,
    WrongObject,
    NeedlessStep,
    UnmetPrecondition,
    UnknownName,
    WrongGoalWord,
    MissingGoal,
    ExtraGoal,
    WrongClaim,
    AskedNeedlessly,
    DidNotAsk,
    NoPlan,
    Unusable,
}

impl Failure {
    /// All kinds, in the order of reports.
    pub const ALL: [Self; 15] = [
        Self::WrongVerb,
        Self::LeftOutStep,
        Self::WrongOrder,
        Self::WrongObject,
        Self::NeedlessStep,
        Self::UnmetPrecondition,
        Self::UnknownName,
        Self::WrongGoalWord,
        Self::MissingGoal,
        Self::ExtraGoal,
        Self::WrongClaim,
        Self::AskedNeedlessly,
        Self::DidNotAsk,
        Self::NoPlan,
        Self::Unusable,
    ];

    /// The name in reports.
    pub fn name(self) -> &'static str {
        match self {
            Self::WrongVerb => "wrong verb",
            Self::LeftOutStep => "left-out step",
            Self::WrongOrder => "wrong order",
            Self::WrongObject => "wrong object",
            Self::NeedlessStep => "needless step",
            Self::UnmetPrecondition => "unmet precondition",
            Self::UnknownName => "unknown name",
            Self::WrongGoalWord => "wrong goal word",
            Self::MissingGoal => "missing goal",
            Self::ExtraGoal => "extra goal",
            Self::WrongClaim => "wrong claim",
            Self::AskedNeedlessly => "asked needlessly",
            Self::DidNotAsk => "did not ask",
            Self::NoPlan => "no plan",
            Self::Unusable => "unusable reply",
        }
    }
}

/// Failures in a plan as the model wrote it; none if the reply contains no plan.
pub(crate) fn of_draft(world: &World, reply: &str, instruction: &str) -> Vec<Failure> {
    let Ok(draft) = plan::read(reply) else {
        return Vec::new();
    };
    let assessment = Assessment::new(world, draft, Some(instruction));
    let mut found = Vec::new();
    if !assessment.resolved.issues.is_empty() {
        found.push(Failure::UnknownName);
    }
    let repair = effort::within(effort::OPERATION, || assessment.repair());
    match repair.result {
        RepairOutcome::Valid(_) if !repair.exhausted => {}
        RepairOutcome::Repaired(repaired) if !repair.exhausted => found.extend(repaired.edits.iter().map(of_edit)),
        _ if found.is_empty() => found.push(Failure::UnmetPrecondition),
        _ => {}
    }
    if !assessment.verdict().claims.differing.is_empty() {
        found.push(Failure::WrongClaim);
    }
    found
}

fn of_edit(edit: &Edit) -> Failure {
    let things = |call: &Option<String>| {
        call.as_deref()
            .and_then(|text| Call::parse(text).ok())
            .map(|call| call.arguments)
    };
    match edit.kind {
        EditKind::Insert => Failure::LeftOutStep,
        EditKind::Drop => Failure::NeedlessStep,
        EditKind::Move => Failure::WrongOrder,
        EditKind::Replace if things(&edit.before) == things(&edit.after) => Failure::WrongVerb,
        EditKind::Replace => Failure::WrongObject,
    }
}

/// Differences between the model's goal and the nearest of the expected goals.
pub(crate) fn of_goal(domain: &Domain, understood: &Goal, goals: &[Goal]) -> Vec<Failure> {
    let each = goals
        .iter()
        .map(|goal| difference(domain, &understood.facts, &goal.facts));
    each.min_by_key(Vec::len).unwrap_or_default()
}

fn difference(domain: &Domain, understood: &[GoalFact], expected: &[GoalFact]) -> Vec<Failure> {
    let mut extra: Vec<&GoalFact> = understood.iter().filter(|fact| !expected.contains(fact)).collect();
    let mut found = Vec::new();
    for missing in expected.iter().filter(|fact| !understood.contains(fact)) {
        let alike = |fact: &&&GoalFact| word(fact) == word(missing);
        let same_thing = |fact: &&&GoalFact| fact.subject(domain) == missing.subject(domain);
        let near = extra
            .iter()
            .position(|fact| alike(&fact) && same_thing(&fact))
            .or_else(|| extra.iter().position(|fact| alike(&fact)))
            .or_else(|| extra.iter().position(|fact| same_thing(&fact)));
        match near {
            Some(place) => {
                let fact = extra.remove(place);
                found.push(if word(fact) == word(missing) {
                    Failure::WrongObject
                } else {
                    Failure::WrongGoalWord
                });
            }
            None => found.push(Failure::MissingGoal),
        }
    }
    found.extend(extra.iter().map(|_| Failure::ExtraGoal));
    found
}

/// The kind and the word of a goal.
fn word(fact: &GoalFact) -> (u8, usize) {
    match fact {
        GoalFact::Word { word, .. } => (0, word.index()),
        GoalFact::Plain(fact) => (1, fact.predicate().index()),
        GoalFact::If(_) => (2, 0),
        GoalFact::Number(number) => (3, number.fluent.function().index()),
        GoalFact::Choice(_) => (4, 0),
    }
}
