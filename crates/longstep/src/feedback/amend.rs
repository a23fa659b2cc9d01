//! Amendment of a plan: from wishes to a verified plan or to the reasons against it.

use super::apply::{Applied, apply, completed, reopened};
use super::{Obstacle, StepWish};
use crate::environment::{State, World};
use crate::goal::GoalFact;
use crate::plan::{Plan, Resolved, Step};
use crate::repair::{Edit, RepairOutcome, repair_pinned};
use crate::search::Wanted;
use crate::verify::{Purpose, Report, VerifiedPlan, Violation, bind, check, unmet};

/// Number of other changes that each wish may cause without a question, plus one in total.
const OTHERS: usize = 2;

/// Result of an amendment.
#[derive(Debug, Clone)]
pub enum Amended {
    /// The amended plan.
    Done(Box<Amendment>),
    /// No valid plan fulfils the wishes.
    Impossible {
        /// The reasons.
        why: Vec<Obstacle>,
        /// The report on the plan with the wishes.
        report: Box<Report>,
    },
}

/// A verified plan that fulfils the wishes.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Amendment {
    /// The plan.
    pub plan: VerifiedPlan,
    /// Other necessary edits, in plan order. Their indices refer to the plan with the wishes.
    pub edits: Vec<Edit>,
}

/// Applies wishes to a plan and verifies the result for its purpose.
///
/// Open arguments of a wish are taken from neighbouring steps, or bound like the hidden arguments of a draft. If the
/// result is invalid, the other steps are repaired: inserted, replaced and moved steps stay, and removed steps do not
/// return. If no such repair exists, the result lists the reasons.
///
/// ```
/// use longstep::feedback::{Amended, StepWish, amend};
/// use longstep_core::search::{Limits, Outcome, solve};
/// use longstep::{domain, goal};
/// use longstep_core::{plan, environment};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>", "<shelf_2>"], "objects": ["<mug_3>"],
///     "object_states": {"<mug_3>": "ON(<desk_1>)"}, "asset_properties": {"<shelf_2>": ["NOT_OPENABLE"]}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(mug, shelf)").unwrap();
/// let outcome = solve(&world, &goal.purpose(&world), &Limits::default());
/// let Outcome::Solved { plan, .. } = outcome else { panic!("{outcome:?}") };
/// let amended = amend(&world, &plan, &[StepWish::Drop { step: 1 }], &goal.purpose(&world));
/// let Amended::Impossible { why, .. } = amended else { panic!("{amended:?}") };
/// assert_eq!(why[0].to_string(), "step 3: Put(<mug_3>, <shelf_2>) needs that the mug is in hand");
/// ```
pub fn amend(world: &World, plan: &Plan, wishes: &[StepWish], purpose: &Purpose) -> Amended {
    let length = plan.steps().len();
    let out_of_range = |wish: &StepWish| {
        let step = wish.step().filter(|step| *step >= length);
        step.or(wish.before().filter(|before| *before > length))
    };
    if let Some(step) = wishes.iter().find_map(out_of_range) {
        return Amended::Impossible {
            why: vec![Obstacle::NoSuchStep(step)],
            report: Box::new(check(world, plan.clone(), purpose)),
        };
    }
    let ways = ways(world, plan, wishes, purpose);
    if let Some(plan) = verified_way(world, &ways, purpose) {
        return done(plan, Vec::new());
    }
    let (mut gave_up, mut too_many, mut unchanged) = (None, None, false);
    for way in &ways {
        match repair_pinned(world, &way.draft, purpose, &way.pins) {
            RepairOutcome::Valid(plan) => return done(plan, Vec::new()),
            // So many changes would make a different plan.
            RepairOutcome::Repaired(repaired) if repaired.edits.len() > OTHERS * wishes.len() + 1 => {
                too_many = Some(repaired.edits.len());
            }
            // Repair gave up the step of the plan that does what the person's step does.
            RepairOutcome::Repaired(repaired) if does_as_before(plan, &repaired.plan) => unchanged = true,
            RepairOutcome::Repaired(repaired) => return done(repaired.plan, repaired.edits),
            RepairOutcome::GaveUp { why, .. } => gave_up = Some(why),
            RepairOutcome::Unclear { .. } | RepairOutcome::ProvenUnsolvable { .. } => {}
        }
    }
    let (mut why, report) = match verified(world, &ways[0].draft, purpose) {
        Ok(report) => (in_the_way(world, &report, purpose), report),
        Err(violation) => {
            let message = violation.message(world, &[], None);
            let why = Obstacle::Violation { violation, message };
            (vec![why], check(world, plan.clone(), purpose))
        }
    };
    if unchanged {
        why.push(Obstacle::Unchanged);
    }
    if let Some(changes) = too_many {
        why.push(Obstacle::TooManyChanges(changes));
    }
    if let Some(limit) = gave_up {
        why.push(Obstacle::GaveUp(limit));
    }
    Amended::Impossible {
        why,
        report: Box::new(report),
    }
}

/// Changes a plan as a person wishes, if it verifies without any further change.
pub(super) fn unrepaired(world: &World, plan: &Plan, wishes: &[StepWish], purpose: &Purpose) -> Option<Amendment> {
    let ways = ways(world, plan, wishes, purpose);
    let plan = verified_way(world, &ways, purpose)?;
    Some(Amendment {
        plan,
        edits: Vec::new(),
    })
}

/// The plan after the wishes, with hidden arguments as those of the steps around, as the wishes say, and unbound: at
/// least one way, the likeliest first.
fn ways(world: &World, plan: &Plan, wishes: &[StepWish], purpose: &Purpose) -> Vec<Applied> {
    let mut ways = vec![apply(world, plan, &completed(world, plan, wishes))];
    let open = apply(world, plan, wishes);
    // Without a claim or a goal, nothing shows that another binding is equally good.
    let says_what_for = purpose.claim.is_some() || !purpose.wanted.is_empty();
    let freer = says_what_for.then(|| reopened(world, &open.draft)).flatten();
    let freer = freer.map(|draft| Applied {
        draft,
        pins: open.pins.clone(),
    });
    if open.draft != ways[0].draft {
        ways.push(open);
    }
    ways.extend(freer);
    ways
}

fn verified_way(world: &World, ways: &[Applied], purpose: &Purpose) -> Option<VerifiedPlan> {
    let mut reports = ways.iter().filter_map(|way| verified(world, &way.draft, purpose).ok());
    reports.find_map(|report| report.into_verified().ok())
}

fn does_as_before(before: &Plan, after: &VerifiedPlan) -> bool {
    let same = |one: &Step, other: &Step| one.action == other.action && one.arguments == other.arguments;
    let (before, after) = (before.steps(), after.steps());
    before.len() == after.len() && before.iter().zip(after).all(|(one, other)| same(one, other))
}

fn done(plan: VerifiedPlan, edits: Vec<Edit>) -> Amended {
    Amended::Done(Box::new(Amendment { plan, edits }))
}

/// Returns the report on a draft. Its assumptions include the ambiguous bindings.
fn verified(world: &World, draft: &Resolved, purpose: &Purpose) -> Result<Report, Violation> {
    let steps: Vec<_> = draft.steps.iter().flatten().cloned().collect();
    let (plan, assumptions) = bind(world, &steps, &draft.objects, purpose.claim.as_ref())?;
    let mut report = check(world, plan, purpose);
    report.assumptions.extend(assumptions);
    Ok(report)
}

/// Returns the violations with sentences for a person.
fn in_the_way(world: &World, report: &Report, purpose: &Purpose) -> Vec<Obstacle> {
    let sentence = |violation: &Violation| match violation {
        Violation::Goal { index } => match purpose.wanted.get(*index) {
            Some(wanted) => format!(
                "at the end, this is not reached: {}",
                wanted_text(world, wanted, &report.ending().after)
            ),
            None => violation.message(world, report.plan.steps(), None),
        },
        other => other.message(world, report.plan.steps(), None),
    };
    let violations = report.violations.iter().map(|violation| Obstacle::Violation {
        message: sentence(violation),
        violation: violation.clone(),
    });
    violations.collect()
}

/// Returns the sentence of the goal word, or else the missing facts.
fn wanted_text(world: &World, wanted: &Wanted, state: &State) -> String {
    let mut words = world.domain().goal_words.iter();
    let same = |word: &crate::model::GoalWord| {
        word.condition == wanted.condition && word.parameters.len() == wanted.bindings.len()
    };
    if let Some(index) = words.position(same) {
        let fact = GoalFact::Word {
            word: crate::model::GoalWordId::new(index),
            arguments: wanted.bindings.clone(),
        };
        return fact.sentence(world);
    }
    let missing = unmet(world, state, &wanted.condition, &mut wanted.bindings.clone());
    let facts: Vec<String> = missing.iter().filter_map(|missing| missing.text(world)).collect();
    facts.join(", and ")
}
