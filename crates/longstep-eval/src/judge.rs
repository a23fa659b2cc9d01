//! Was that right?

use std::cell::OnceCell;

use longstep::domain::Domain;
use longstep::environment::{EntityId, World, differences, subject_of};
use longstep::goal::Goal;
use longstep::plan::Plan;
use longstep::report;
use longstep::verify::{Ending, Purpose, VerifiedPlan, check};

/// Why a plan is not what was wanted, in sentences; nothing if it is.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Amiss {
    /// What was wanted and is not so.
    pub(crate) unreached: Vec<String>,
    /// What changed and nobody asked for.
    pub(crate) unasked: Vec<String>,
}

impl Amiss {
    fn len(&self) -> usize {
        self.unreached.len() + self.unasked.len()
    }

    pub(crate) fn sentences(&self) -> Vec<String> {
        [&self.unreached[..], &self.unasked].concat()
    }
}

/// Goals that a plan may reach, each with what a plan for it has to change.
///
/// What has to change is taken from the plan that search finds for the goal: to put the milk into the fridge, its door
/// is opened and closed again, so the door may change on the way and must not in the end.
#[derive(Debug)]
pub(crate) struct Standard<'a> {
    domain: &'a Domain,
    world: &'a World,
    goals: Vec<Expected<'a>>,
}

/// A goal, and the plan that search finds for it once somebody asks: most of a suite's time may go there.
#[derive(Debug)]
struct Expected<'a> {
    goal: &'a Goal,
    reference: OnceCell<Option<VerifiedPlan>>,
}

impl<'a> Standard<'a> {
    pub(crate) fn new(domain: &'a Domain, world: &'a World, goals: &'a [Goal]) -> Self {
        let expected = |goal: &'a Goal| Expected {
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

    fn reference_for<'s>(&self, expected: &'s Expected<'a>) -> Option<&'s VerifiedPlan> {
        let search = || report::of_goal(self.domain, self.world, expected.goal, "", || 0.0).plan;
        expected.reference.get_or_init(search).as_ref()
    }

    /// Why the plan is not what was wanted, for the goal that it comes closest to.
    pub(crate) fn amiss(&self, plan: &Plan) -> Amiss {
        let each = self
            .goals
            .iter()
            .map(|expected| self.amiss_for(plan, expected.goal, self.reference_for(expected)));
        each.min_by_key(Amiss::len).unwrap_or_default()
    }

    fn amiss_for(&self, plan: &Plan, goal: &Goal, reference: Option<&VerifiedPlan>) -> Amiss {
        let (domain, world) = (self.domain, self.world);
        let purpose = Purpose {
            wanted: goal.purpose(domain).wanted,
            ..Purpose::default()
        };
        let report = check(domain, world, plan.clone(), &purpose);
        let unreached = report.violations.iter().filter(|violation| violation.kind() == "goal");
        let unreached = unreached
            .map(|violation| violation.message(domain, world, report.plan.steps(), Some(goal)))
            .collect();
        let mut asked: Vec<EntityId> = goal.facts.iter().flat_map(|fact| fact.about(domain)).collect();
        asked.extend(reference.iter().flat_map(|plan| self.changed(plan.endings())));
        let mut unasked: Vec<EntityId> = self.changed(&report.endings);
        unasked.retain(|entity| !asked.contains(entity));
        let told = |entity: EntityId| format!("{} ends as nobody asked for", world.entity(entity).with_article());
        Amiss {
            unreached,
            unasked: unasked.into_iter().map(told).collect(),
        }
    }

    /// The things of which an environment says something else at an end. What was only found out is no change.
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
