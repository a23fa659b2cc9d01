//! Verification: simulates a plan and checks preconditions, rules, goals and claims.
//!
//! [`check`] returns all findings as data. Only a [`Report`] without violations can become a [`VerifiedPlan`], and
//! there is no other way to create one.

mod bind;
mod bind_tree;
mod candidate;
mod claims;
mod finding;
mod history;
mod lanes;
mod loop_states;
mod path;
mod reachability;
mod rules;
mod stage_tracker;
#[cfg(test)]
pub(crate) mod tests;
mod walk;

pub use bind::{bind, bind_as_far};
pub use bind_tree::bind_tree;
pub use candidate::{Candidate, candidates, claimed_places};
pub use reachability::{can_apply, can_be_brought_about, possibly};
use rules::wanted_at_end;
pub use rules::{Waiver, broken_at_end};
pub use stage_tracker::Progress;
pub use walk::STATES;

pub use crate::plan::{Assumption, StepClaim, Violation};
pub use longstep_model::model::{Change, Ending, Missing, Trace, apply, broken_bindings, unmet};

use std::borrow::Cow;

use crate::plan::{Plan, PlanFile, Step, resolve};
use longstep_model::domain::Problem;
use longstep_model::effort;
use longstep_model::environment::Claim;
use longstep_model::model::{
    ActionId, Domain, EntityId, Fact, Fluent, Moment, Number, Prohibition, State, Wanted, World, differences, holds,
    subject_of,
};
use path::ExecutionPath;
use walk::Walk;

/// A condition to achieve in a stage of a plan.
#[derive(Debug, Clone)]
pub struct Milestone {
    /// The condition.
    pub wanted: Wanted,
    /// True if it must not hold when its stage begins: plates that were put on the table before it was wiped are not put
    /// there after it.
    pub anew: bool,
}

/// Purpose of a plan, as far as it is known.
#[derive(Debug, Clone, Default)]
pub struct Purpose {
    /// Conditions that must hold in the final state.
    pub wanted: Vec<Wanted>,
    /// Conditions to achieve in order, stage by stage; empty if no order is required.
    ///
    /// The first stage begins in the initial state, each other one in the state in which all conditions of the stage
    /// before it are achieved. A condition is achieved in the first state of its stage in which it holds; if it must
    /// hold [anew](Milestone::anew), it counts only if it did not hold when its stage began. Events count from the
    /// beginning of their stage. Conditions need not last: those that must hold in the final state are in `wanted` too.
    pub stages: Vec<Vec<Milestone>>,
    /// Prohibitions that are in force for this plan, besides those of the world.
    pub prohibitions: Vec<Prohibition>,
    /// Rules that are suspended, each for an entity.
    pub waivers: Vec<Waiver>,
    /// True if the plan was made from a goal; then tidiness rules are mandatory.
    pub from_goal: bool,
    /// The final environment that the plan claims.
    pub claim: Option<Claim>,
    /// Facts that the steps claim to hold after them, sorted by step.
    pub step_claims: Vec<StepClaim>,
    /// Entities that the instruction mentions. If there are any, moving another object is a warning.
    pub mentioned: Vec<EntityId>,
}

impl From<&Problem> for Purpose {
    /// The goal of a problem.
    fn from(problem: &Problem) -> Self {
        Self {
            wanted: problem.wanted.clone(),
            ..Self::default()
        }
    }
}

impl Purpose {
    /// Returns all conditions on the final state: those of the purpose, then those of the domain's rules.
    pub fn at_end(&self, domain: &Domain) -> Vec<Wanted> {
        let mut wanted = self.wanted.clone();
        wanted.extend(wanted_at_end(domain, &self.waivers, self.from_goal));
        wanted
    }

    /// Returns the world with the prohibitions of this purpose in force.
    pub fn world<'w>(&self, world: &'w World) -> Cow<'w, World> {
        if self.prohibitions.is_empty() {
            Cow::Borrowed(world)
        } else {
            Cow::Owned(world.with_prohibitions(self.prohibitions.iter().cloned()))
        }
    }
}

/// Returns the conditions that the rules of the domain impose on the final state of a plan with this purpose.
pub fn rules_at_end(domain: &Domain, purpose: &Purpose) -> Vec<Wanted> {
    wanted_at_end(domain, &purpose.waivers, purpose.from_goal)
}

/// Result of verification.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Report {
    /// The world in which the plan was simulated.
    pub world: World,
    /// The plan with all arguments bound.
    pub plan: Plan,
    /// The possible endings, at least one; with sensing there can be several, sorted by sensing outcomes.
    pub endings: Vec<Ending>,
    /// Index of the first ending that fulfills the claim; none if no ending does, or if there is no claim.
    pub claimed: Option<usize>,
    /// Errors; empty for a valid plan.
    pub violations: Vec<Violation>,
    /// Warnings: unusual, but not wrong.
    pub warnings: Vec<Violation>,
    /// Assumptions that the verdict depends on.
    pub assumptions: Vec<Assumption>,
}

/// A plan that was simulated completely without a violation.
///
/// Only [`Report::into_verified`] creates one. Exporters and executors accept nothing else.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_verify::{plan, verify::check_file};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["move_hand()", "grasp_object()", "release_object()"], "object_name": "<pen>"}"#).unwrap();
/// let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
/// assert_eq!((plan.steps().len(), plan.endings().len()), (3, 1));
/// let after = world.after(plan.ending());
/// assert_eq!(after.environment().object_states["<pen>"].as_slice(), ["on_something(<desk>)"]);
/// ```
#[derive(Debug, Clone)]
pub struct VerifiedPlan {
    report: Box<Report>,
}

impl VerifiedPlan {
    /// The world that the plan begins in.
    pub fn world(&self) -> &World {
        &self.report.world
    }

    /// The plan.
    pub fn plan(&self) -> &Plan {
        &self.report.plan
    }

    /// The steps, in reading order.
    pub fn steps(&self) -> &[Step] {
        self.report.plan.steps()
    }

    /// The verification report.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The possible endings, at least one.
    pub fn endings(&self) -> &[Ending] {
        &self.report.endings
    }

    /// The first ending: the only one of a plan without sensing.
    pub fn ending(&self) -> &Ending {
        self.report.ending()
    }
}

impl Report {
    /// The first ending: the only one of a plan without sensing.
    pub fn ending(&self) -> &Ending {
        &self.endings[0]
    }

    /// The ending that fulfills the claim, or the first one if none does.
    pub fn claimed_ending(&self) -> &Ending {
        &self.endings[self.claimed.unwrap_or(0)]
    }

    /// Returns the cost of the steps on the dearest path; none in a domain without costs, or if the cost is not known, as in a loop whose
    /// iterations depend on sensing.
    pub fn cost(&self) -> Option<Number> {
        let costs = self.endings.iter().map(|ending| ending.cost);
        costs.collect::<Option<Vec<Number>>>()?.into_iter().max()
    }

    /// Converts the report to a verified plan if there are no violations.
    ///
    /// # Errors
    ///
    /// The report itself, if it has violations.
    pub fn into_verified(self) -> Result<VerifiedPlan, Box<Report>> {
        if self.violations.is_empty() {
            Ok(VerifiedPlan { report: Box::new(self) })
        } else {
            Err(Box::new(self))
        }
    }
}

/// Simulates a written plan: resolves its names, binds the arguments that its notation hides, and follows every path.
///
/// The world must have the values that the plan mentions ([`PlanFile::world_of`]). Its claims are checked; a goal is not
/// ([`check`] takes a purpose).
///
/// # Errors
///
/// The violations that prevent simulation: unknown names, and arguments that no entity fits.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_verify::plan;
/// use longstep_verify::verify::check_file;
///
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "table.json", text).unwrap();
/// let draft = plan::read(r#"{"task_sequence": ["grasp_object()"], "object_name": "<cup>"}"#).unwrap();
/// let report = check_file(&world, &draft.file).unwrap();
/// let message = report.violations[0].message(&world, report.plan.steps(), None);
/// assert_eq!(message, "step 1: grasp_object() needs that the hand is at the cup");
/// assert!(report.into_verified().is_err());
/// ```
pub fn check_file(world: &World, file: &PlanFile) -> Result<Report, Vec<Violation>> {
    let claim = file.environment_after.as_ref();
    let claim = claim.map(|environment| Claim::read(world, environment));
    let resolved = resolve(world, &file.task_cohesion);
    let (plan, _) = bind_tree(world, &resolved, claim.as_ref())?;
    let purpose = Purpose {
        claim,
        step_claims: resolved.claims,
        ..Purpose::default()
    };
    Ok(check(world, plan, &purpose))
}

/// Simulates a plan from the world's state.
///
/// A step that is not applicable is reported with its missing preconditions and the step that deleted each of them. The
/// simulation then applies its effects anyway, so that later errors are reported too.
///
/// If the plan claims a final environment, its promises are checked: a claimed fact that did not hold before, does not
/// hold in the final state, and that some action could achieve is a violation. Other differences between claim and
/// simulation are not violations.
///
/// Every execution path is followed: both sides of a branch, each sensing outcome, a loop until no new state occurs,
/// lanes in every order. A violation that occurs only on some paths lists the sensing outcomes that lead to it.
///
/// A claim is one environment, but a plan may have several endings. The claim is fulfilled if one ending keeps every
/// claimed fact; [`Report::claimed`] is its index. Otherwise the broken promises of each ending are violations.
///
/// The check has a budget of [`effort::OPERATION`] units. A plan that exceeds it gets the single violation
/// [`Violation::TooMuchWork`].
pub fn check(world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let spent = effort::within(effort::OPERATION, || simulated(world, plan, purpose));
    let mut report = spent.result;
    if spent.exhausted {
        // Findings after the budget is exhausted are not reliable.
        report.violations = vec![Violation::TooMuchWork];
        report.warnings.clear();
        report.assumptions.clear();
        report.claimed = None;
    }
    report
}

fn simulated(world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let world = &*purpose.world(world);
    let mut walk = Walk::new(world, &plan, purpose);
    let ends = walk.run();
    let claimed = purpose.claim.as_ref();
    let binding = claimed.map_or_else(Vec::new, |claim| binding_claims(world, &plan, claim));
    let numbers = claimed.map_or_else(Vec::new, |claim| claim.promised_numbers(world));
    let differs = |path: &ExecutionPath, (fluent, number): (Fluent, Number)| path.state.number(fluent) != Some(number);
    let keeps_facts = |path: &ExecutionPath| binding.iter().all(|fact| path.state.holds(*fact));
    let keeps_numbers = |path: &ExecutionPath| !numbers.iter().any(|number| differs(path, *number));
    // One ending keeps all claims. To take each claim from another ending would be unsound.
    let as_claimed = claimed.and_then(|_| ends.iter().position(|path| keeps_facts(path) && keeps_numbers(path)));
    let endings = walk.each(ends, |walk, mut path| {
        end(walk, &path, purpose);
        walk.forget_progress(&mut path);
        let when = walk.when(&path);
        if as_claimed.is_none() {
            for fact in binding.iter().filter(|fact| !path.state.holds(**fact)) {
                walk.wrong(Violation::Claim { fact: *fact }, when.clone());
            }
            for (fluent, claimed) in numbers.iter().filter(|number| differs(&path, **number)) {
                let violation = Violation::NumberClaim {
                    fluent: *fluent,
                    claimed: *claimed,
                    simulated: path.state.number(*fluent),
                };
                walk.wrong(violation, when.clone());
            }
        }
        vec![Ending {
            when,
            trace: walk.history.trace(path.here),
            after: path.state,
            cost: path.cost,
        }]
    });
    let mut rested: Vec<Fact> = std::mem::take(&mut walk.rested).into_iter().collect();
    rested.sort_unstable();
    let assumed = rested.into_iter().filter_map(|fact| Some((fact, world.assumed(fact)?)));
    let assumptions = assumed.map(|(fact, ground)| Assumption::Fact { fact, ground });
    let (violations, warnings) = walk.findings();
    Report {
        world: world.clone(),
        endings,
        claimed: as_claimed,
        violations,
        warnings,
        assumptions: assumptions.collect(),
        plan,
    }
}

/// Returns the claimed facts that an ending must have to fulfill the claim: achievable changes, and places of objects
/// that are handled by calls which do not name the place.
pub fn binding_claims(world: &World, plan: &Plan, claim: &Claim) -> Vec<Fact> {
    let domain = world.domain();
    let mut binding = claim.promises(world);
    // A promise that no action can keep is a careless copy rather than the purpose of the plan.
    binding.retain(|fact| can_be_brought_about(world, *fact));
    let led = plan.steps().iter().filter(|step| hides_places(domain, step.action));
    let handled: Vec<EntityId> = led.filter_map(|step| step.object(domain)).collect();
    binding.extend(places_claimed(world, claim, &handled));
    binding
}

/// Records the violations and warnings of a final state.
fn end(walk: &mut Walk<'_>, path: &ExecutionPath, purpose: &Purpose) {
    let (domain, world, state) = (walk.domain, walk.world, &path.state);
    let (mut wrong, mut odd) = (Vec::new(), Vec::new());
    let promises = purpose.claim.as_ref().map(|claim| claim.promises(world));
    let meant: Vec<EntityId> = promises
        .iter()
        .flatten()
        .map(|fact| subject_of(domain, *fact))
        .collect();
    for broken in broken_at_end(world, state, purpose) {
        // A change that the plan announces is not untidy.
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
    // A goal that does not hold in the final state is reported already.
    let unordered = walk.unordered(path);
    let unordered = unordered.filter(|(index, _)| !wrong.contains(&Violation::Goal { index: *index }));
    wrong.extend(unordered.map(|(index, first)| Violation::Order { index, first }));
    odd.extend(moved_unmentioned(world, state, &purpose.mentioned));
    let when = walk.when(path);
    wrong
        .into_iter()
        .for_each(|violation| walk.wrong(violation, when.clone()));
    odd.into_iter().for_each(|violation| walk.odd(violation, when.clone()));
}

/// Returns true if the call of an action omits an argument other than the handled object, such as its destination.
pub fn hides_places(domain: &Domain, action: ActionId) -> bool {
    let action = domain.action(action);
    action.implicit().any(|parameter| action.object != Some(parameter))
}

/// Returns the claimed places of objects that are handled by calls which name no place. For them the claim is the only
/// source, even if it keeps the old place. A constant of the domain, such as a hand, is no place.
pub fn places_claimed(world: &World, claim: &Claim, handled: &[EntityId]) -> Vec<Fact> {
    let domain = world.domain();
    let mut places = claim.kept(world);
    let is_constant = |entity: EntityId| entity.index() < domain.constants.len();
    places.retain(|fact| {
        domain.is_relation(*fact)
            && !domain.arguments(*fact).any(is_constant)
            && domain.words(fact.predicate()).fluent
            && handled.contains(&subject_of(domain, *fact))
    });
    places
}

/// Returns the objects that the plan moves and the instruction does not mention.
fn moved_unmentioned(world: &World, after: &State, mentioned: &[EntityId]) -> Vec<Violation> {
    let domain = world.domain();
    // An instruction without any entity does not restrict what may be moved.
    if mentioned.is_empty() {
        return Vec::new();
    }
    let mut moved: Vec<EntityId> = differences(domain, &world.state, after)
        .into_iter()
        .filter(|difference| domain.is_relation(difference.fact))
        .map(|difference| difference.fact.argument(0))
        .filter(|entity| world.is_of_kind(*entity, domain.environment.object) && !mentioned.contains(entity))
        .collect();
    moved.sort_unstable();
    moved.dedup();
    moved.into_iter().map(|entity| Violation::Unasked { entity }).collect()
}
