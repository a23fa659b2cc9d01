//! Judges whether a plan does what was expected.

use std::cell::OnceCell;

use longstep::Clock;
use longstep::goal::Goal;
use longstep::report;
use longstep_core::domain::Domain;
use longstep_core::environment::{EntityId, World, differences, subject_of};
use longstep_core::plan::Plan;
use longstep_core::verify::{Ending, Purpose, VerifiedPlan, Violation, check};

/// The deviations of a plan from a goal, as sentences; empty if there are none.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Amiss {
    /// Parts of the goal that do not hold at the end.
    pub(crate) unreached: Vec<String>,
    /// Changes that the goal does not require.
    pub(crate) unexpected: Vec<String>,
}

impl Amiss {
    fn len(&self) -> usize {
        self.unreached.len() + self.unexpected.len()
    }

    pub(crate) fn sentences(&self) -> Vec<String> {
        [&self.unreached[..], &self.unexpected].concat()
    }
}

/// The goals that a plan may reach, each with the changes that it requires.
///
/// The required changes come from a plan that search finds for the goal. To put the milk into the fridge, its door is
/// opened and closed again: the door may change on the way, but not at the end.
#[derive(Debug)]
pub(crate) struct Standard<'a> {
    domain: &'a Domain,
    world: &'a World,
    goals: Vec<ExpectedPlan<'a>>,
}

/// A goal, and a plan that search finds for it. Searched at the first use, because search may dominate the time of a
/// suite.
#[derive(Debug)]
struct ExpectedPlan<'a> {
    goal: &'a Goal,
    reference: OnceCell<Option<VerifiedPlan>>,
}

impl<'a> Standard<'a> {
    pub(crate) fn new(world: &'a World, goals: &'a [Goal]) -> Self {
        let domain = world.domain();
        let expected = |goal: &'a Goal| ExpectedPlan {
            goal,
            reference: OnceCell::new(),
        };
        Self {
            domain,
            world,
            goals: goals.iter().map(expected).collect(),
        }
    }

    /// The plan that search finds for the first goal, if there is one.
    pub(crate) fn reference(&self) -> Option<&VerifiedPlan> {
        self.reference_for(self.goals.first()?)
    }

    fn reference_for<'s>(&self, expected: &'s ExpectedPlan<'a>) -> Option<&'s VerifiedPlan> {
        let search = || {
            report::of_goal(
                self.world,
                expected.goal,
                "",
                &longstep::Limits::default(),
                &Clock::none(),
            )
            .plan
        };
        expected.reference.get_or_init(search).as_ref()
    }

    /// The deviations of a plan from the goal to which it is closest.
    pub(crate) fn amiss(&self, plan: &Plan) -> Amiss {
        let each = self
            .goals
            .iter()
            .map(|expected| self.amiss_for(plan, expected.goal, self.reference_for(expected)));
        each.min_by_key(Amiss::len).unwrap_or_default()
    }

    fn amiss_for(&self, plan: &Plan, goal: &Goal, reference: Option<&VerifiedPlan>) -> Amiss {
        let (domain, world) = (self.domain, self.world);
        let own = goal.purpose(world);
        let purpose = Purpose {
            wanted: own.wanted,
            stages: own.stages,
            prohibitions: own.prohibitions,
            ..Purpose::default()
        };
        let report = check(world, plan.clone(), &purpose);
        let of_the_goal = |violation: &&Violation| matches!(violation.kind(), "goal" | "order" | "prohibited");
        let unreached = report.violations.iter().filter(of_the_goal);
        let unreached = unreached
            .map(|violation| violation.message(world, report.plan.steps(), Some(goal)))
            .collect();
        let mut concerned: Vec<EntityId> = goal.facts.iter().flat_map(|fact| fact.about(domain)).collect();
        concerned.extend(reference.iter().flat_map(|plan| self.changed(plan.endings())));
        let mut unexpected: Vec<EntityId> = self.changed(&report.endings);
        unexpected.retain(|entity| !concerned.contains(entity));
        let deviation = |entity: EntityId| {
            format!(
                "the plan changes {}, which the instruction does not mention",
                world.with_article(entity)
            )
        };
        Amiss {
            unreached,
            unexpected: unexpected.into_iter().map(deviation).collect(),
        }
    }

    /// The entities that differ at an end from the beginning. Sensed facts do not count as changes.
    fn changed(&self, endings: &[Ending]) -> Vec<EntityId> {
        let of = |ending: &Ending| differences(self.domain, &self.world.state, &ending.after);
        let mut changed: Vec<EntityId> = endings
            .iter()
            .flat_map(of)
            .filter(|difference| !self.domain.is_sensed(difference.fact.predicate()))
            .map(|difference| subject_of(self.domain, difference.fact))
            .collect();
        changed.sort_unstable();
        changed.dedup();
        changed
    }
}
