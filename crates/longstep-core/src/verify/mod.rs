//! Is a plan possible, does it keep the rules, and what is the world afterwards?
//!
//! [`check`] simulates a plan and tells everything it finds as data. Only a [`Report`] without violations
//! turns into a [`VerifiedPlan`], and there is no other way to make one.

mod bind;
mod bind_tree;
mod claims;
mod history;
mod lanes;
mod reachability;
mod rules;
#[cfg(test)]
mod tests;
mod walk;

pub use bind::bind;
pub use bind::{Candidate, candidates};
pub(crate) use bind::{bind_as_far, claimed_places};
pub use bind_tree::bind_tree;
pub use reachability::{can_apply, can_be_brought_about};
pub use rules::Waiver;
pub(crate) use rules::{broken_at_end, wanted_at_end};
pub use walk::STATES;

pub use crate::model::{Change, Ending, Missing, Trace, apply, broken_bindings, unmet};
pub use crate::plan::{Assumption, StepClaim, Violation};

use crate::effort;
use crate::environment::Claim;
use crate::model::{ActionId, Domain, EntityId, Fact, Moment, State, Wanted, World, differences, holds, subject_of};
use crate::plan::{Plan, Step};
use walk::{Walk, Way};

/// What a plan is for, as far as it is known.
#[derive(Debug, Clone, Default)]
pub struct Purpose {
    /// What must hold at the end.
    pub wanted: Vec<Wanted>,
    /// Which rules are set aside, and for what.
    pub waivers: Vec<Waiver>,
    /// Whether the plan was made from a goal, so that tidy rules bind it.
    pub from_goal: bool,
    /// What the plan claims the world to be afterwards.
    pub claim: Option<Claim>,
    /// What its steps claim to hold after them, in the order of the steps.
    pub step_claims: Vec<StepClaim>,
    /// Entities that the instruction speaks of. If there are any, moving another object is remarked on.
    pub spoken: Vec<EntityId>,
}

/// What verification found.
#[derive(Debug, Clone)]
pub struct Report {
    /// The plan, all arguments bound.
    pub plan: Plan,
    /// How it can end, at least one: several where sensing decides, sorted by what it told.
    pub endings: Vec<Ending>,
    /// The first ending that is as the plan claims; none if no ending is, or if the plan claims nothing.
    pub claimed: Option<usize>,
    /// What is wrong; empty for a good plan.
    pub violations: Vec<Violation>,
    /// What is odd without being wrong.
    pub warnings: Vec<Violation>,
    /// What the verdict rests on that the environment does not say.
    pub assumptions: Vec<Assumption>,
}

/// A plan that was simulated from first to last step without a violation.
///
/// Only [`Report::into_verified`] makes one. Exporters and executors take nothing else.
#[derive(Debug, Clone)]
pub struct VerifiedPlan {
    report: Report,
}

impl VerifiedPlan {
    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.report.plan
    }

    /// Its steps, in reading order.
    pub fn steps(&self) -> &[Step] {
        self.report.plan.steps()
    }

    /// The report behind it.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// How it can end, at least one.
    pub fn endings(&self) -> &[Ending] {
        &self.report.endings
    }

    /// Its first ending: the only one of a plan without sensing.
    pub fn ending(&self) -> &Ending {
        self.report.ending()
    }
}

impl Report {
    /// The first ending: the only one of a plan without sensing.
    pub fn ending(&self) -> &Ending {
        &self.endings[0]
    }

    /// The ending that the plan's claim is about: the one that is as claimed, else the first.
    pub fn claimed_ending(&self) -> &Ending {
        &self.endings[self.claimed.unwrap_or(0)]
    }

    /// The plan, if nothing speaks against it.
    ///
    /// # Errors
    ///
    /// The report itself, when it has violations.
    pub fn into_verified(self) -> Result<VerifiedPlan, Box<Report>> {
        if self.violations.is_empty() {
            Ok(VerifiedPlan { report: self })
        } else {
            Err(Box::new(self))
        }
    }
}

/// Simulates a plan from the world's state.
///
/// A step that is not applicable is reported with the facts that were missing and the step that took each
/// away; the simulation then goes on as if it had worked, so that later mistakes are told as well.
///
/// When the plan claims an environment afterwards, what it promises must come true: a fact that is claimed, did not
/// hold before, does not hold in the end, and that some action could have brought about is a violation. Everything
/// else in which claim and simulation differ is for the caller to show.
///
/// Every way through the plan is followed: both sides of a branch, each outcome of sensing, a loop until no new state
/// comes up, lanes in every order. What is so only on some of them is told with what sensing told there.
///
/// A claim is one environment, and a plan may end in several. The plan is as claimed if one ending keeps everything
/// that is claimed; [`Report::claimed`] says which. Otherwise each ending's broken promises are violations.
///
/// The check has a budget of [`effort::OPERATION`] units. A plan that takes more is refused with
/// [`Violation::TooMuchWork`] alone.
pub fn check(domain: &Domain, world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let spent = effort::within(effort::OPERATION, || simulated(domain, world, plan, purpose));
    let mut report = spent.result;
    if spent.exhausted {
        // What was found under a spent budget means nothing.
        report.violations = vec![Violation::TooMuchWork];
        report.warnings.clear();
        report.assumptions.clear();
        report.claimed = None;
    }
    report
}

fn simulated(domain: &Domain, world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let mut walk = Walk::new(domain, world, &plan, &purpose.step_claims);
    let ends = walk.run();
    let claimed = purpose.claim.as_ref();
    let binding = claimed.map_or_else(Vec::new, |claim| binding_claims(domain, world, &plan, claim));
    let kept = |way: &Way| binding.iter().all(|fact| way.state.holds(*fact));
    let as_claimed = claimed.and_then(|_| ends.iter().position(kept));
    let endings = walk.each(ends, |walk, way| {
        end(walk, &way, purpose);
        let when = walk.when(&way);
        if as_claimed.is_none() {
            for fact in binding.iter().filter(|fact| !way.state.holds(**fact)) {
                walk.wrong(Violation::Claim { fact: *fact }, when.clone());
            }
        }
        vec![Ending {
            when,
            trace: walk.history.trace(way.here),
            after: way.state,
        }]
    });
    let mut rested: Vec<Fact> = std::mem::take(&mut walk.rested).into_iter().collect();
    rested.sort_unstable();
    let assumption = |fact: Fact| {
        let ground = world.assumed(fact)?;
        Some(Assumption::Fact { fact, ground })
    };
    let (violations, warnings) = walk.findings();
    Report {
        endings,
        claimed: as_claimed,
        violations,
        warnings,
        assumptions: rested.into_iter().filter_map(assumption).collect(),
        plan,
    }
}

/// The claimed facts that an ending must have to be as claimed: what has to come about and could, and where things are
/// that are handled by calls which do not say where.
pub(crate) fn binding_claims(domain: &Domain, world: &World, plan: &Plan, claim: &Claim) -> Vec<Fact> {
    let mut binding = claim.promises(domain, world);
    binding.retain(|fact| can_be_brought_about(domain, world, *fact));
    let led = plan.steps().iter().filter(|step| hides_places(domain, step.action));
    let handled: Vec<EntityId> = led.filter_map(|step| step.object(domain)).collect();
    binding.extend(places_claimed(domain, world, claim, &handled));
    binding
}

/// What is wrong with the state in which a way ends.
fn end(walk: &mut Walk<'_>, way: &Way, purpose: &Purpose) {
    let (domain, world, state) = (walk.domain, walk.world, &way.state);
    let (mut wrong, mut odd) = (Vec::new(), Vec::new());
    let promises = purpose.claim.as_ref().map(|claim| claim.promises(domain, world));
    let meant: Vec<EntityId> = promises
        .iter()
        .flatten()
        .map(|fact| subject_of(domain, *fact))
        .collect();
    for broken in broken_at_end(domain, world, state, purpose) {
        // What the plan says it changes is not untidy.
        if !broken.binds && broken.bindings.iter().any(|entity| meant.contains(entity)) {
            continue;
        }
        let list = if broken.binds { &mut wrong } else { &mut odd };
        list.push(Violation::Rule {
            step: None,
            rule: broken.rule,
            bindings: broken.bindings,
        });
    }
    let moment = Moment { world, state };
    for (index, wanted) in purpose.wanted.iter().enumerate() {
        if !holds(moment, &wanted.condition, &mut wanted.bindings.clone()) {
            wrong.push(Violation::Goal { index });
        }
    }
    odd.extend(moved_unasked(domain, world, state, &purpose.spoken));
    let when = walk.when(way);
    wrong
        .into_iter()
        .for_each(|violation| walk.wrong(violation, when.clone()));
    odd.into_iter().for_each(|violation| walk.odd(violation, when.clone()));
}

/// Whether the call of an action hides more than the thing that is handled: where it goes.
pub(crate) fn hides_places(domain: &Domain, action: ActionId) -> bool {
    let action = domain.action(action);
    action.implicit().any(|parameter| action.object != Some(parameter))
}

/// Places that the claim gives for objects that are handled by calls which do not name one: then the claim alone does,
/// even if it says that they are back where they were. A constant of the domain, such as a hand, is no place.
pub(crate) fn places_claimed(domain: &Domain, world: &World, claim: &Claim, handled: &[EntityId]) -> Vec<Fact> {
    let mut places = claim.kept(domain, world);
    let is_constant = |entity: EntityId| entity.index() < domain.constants.len();
    places.retain(|fact| {
        domain.is_relation(*fact)
            && !domain.arguments(*fact).any(is_constant)
            && domain.words(fact.predicate()).fluent
            && handled.contains(&subject_of(domain, *fact))
    });
    places
}

/// Objects that end elsewhere and that the instruction does not speak of.
fn moved_unasked(domain: &Domain, world: &World, after: &State, spoken: &[EntityId]) -> Vec<Violation> {
    // An instruction that names nothing at all says nothing about what may be moved.
    if spoken.is_empty() {
        return Vec::new();
    }
    let mut moved: Vec<EntityId> = differences(domain, &world.state, after)
        .into_iter()
        .filter(|difference| domain.is_relation(difference.fact))
        .map(|difference| difference.fact.argument(0))
        .filter(|entity| world.is_of_kind(*entity, domain.environment.object) && !spoken.contains(entity))
        .collect();
    moved.sort_unstable();
    moved.dedup();
    moved.into_iter().map(|entity| Violation::Unasked { entity }).collect()
}
