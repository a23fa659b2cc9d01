//! From wishes to a verified plan, or to what stands in the way.

use super::StepWish;
use super::apply::{Applied, apply, completed, reopened};
use crate::environment::{State, World, fact_text};
use crate::goal::GoalFact;
use crate::model::Domain;
use crate::plan::{Plan, Resolved};
use crate::repair::{Edit, Outcome, repair_pinned};
use crate::search::Wanted;
use crate::verify::{Purpose, Report, VerifiedPlan, Violation, bind, check, unmet};

/// So many changes besides each wish are made without asking, and one more.
const OTHERS: usize = 2;

/// What came of wishes about a plan.
#[derive(Debug, Clone)]
pub enum Amended {
    /// The plan as the person wants it.
    Done(Box<Amendment>),
    /// It cannot be had.
    Impossible {
        /// What stands in the way, for a person: one sentence for each finding.
        why: Vec<String>,
        /// The report on the plan as the person wanted it.
        report: Box<Report>,
    },
}

/// A plan that does what a person asked for.
#[derive(Debug, Clone)]
pub struct Amendment {
    /// The plan.
    pub plan: VerifiedPlan,
    /// What had to change besides, in the order of the plan. Their steps are those of the plan with the wishes in it.
    pub edits: Vec<Edit>,
}

/// Changes a plan as a person wishes, and verifies it for its purpose.
///
/// What the wishes leave open is taken from the steps around, or bound like the hidden arguments of any draft. If the
/// plan does not verify then, the rest of it is repaired; what was inserted, replaced or moved stays, and what was
/// dropped does not come back. Where no repair can do that, the person is told why.
///
/// ```
/// use longstep::feedback::{Amended, StepWish, amend};
/// use longstep::search::{Limits, Outcome, solve};
/// use longstep::{domain, goal, json, plan, environment};
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>", "<shelf_2>"], "objects": ["<mug_3>"],
///     "object_states": {"<mug_3>": "ON(<desk_1>)"}, "asset_properties": {"<shelf_2>": ["NOT_OPENABLE"]}}"#;
/// let environment = environment::Environment::from_json(text).unwrap();
/// let world = environment::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let goal = goal::parse(&domain, &world, "put(mug, shelf)").unwrap();
/// let outcome = solve(&domain, &world, &goal.wanted(&domain), &Limits::default());
/// let Outcome::Solved { plan, .. } = outcome else { panic!("{outcome:?}") };
/// let amended = amend(&domain, &world, &plan, &[StepWish::Drop { step: 1 }], &goal.purpose(&domain));
/// let Amended::Impossible { why, .. } = amended else { panic!("{amended:?}") };
/// assert_eq!(why, ["step 3: Put(<mug_3>, <shelf_2>) needs that the mug is in hand"]);
/// ```
pub fn amend(domain: &Domain, world: &World, plan: &Plan, wishes: &[StepWish], purpose: &Purpose) -> Amended {
    let length = plan.steps().len();
    let out_of_range = |wish: &StepWish| {
        let step = wish.step().filter(|step| *step >= length);
        step.or(wish.before().filter(|before| *before > length))
    };
    if let Some(step) = wishes.iter().find_map(out_of_range) {
        return Amended::Impossible {
            why: vec![format!("the plan has no step {}", step + 1)],
            report: Box::new(check(domain, world, plan.clone(), purpose)),
        };
    }
    let full = apply(domain, world, plan, &completed(domain, world, plan, wishes));
    let open = apply(domain, world, plan, wishes);
    let mut ways: Vec<&Applied> = vec![&full];
    if open.draft != full.draft {
        ways.push(&open);
    }
    // Only what is to come out tells whether another reading of the hidden places is as good.
    let says_what_for = purpose.claim.is_some() || !purpose.wanted.is_empty();
    let freer = says_what_for.then(|| reopened(domain, world, &open.draft)).flatten();
    let freer = freer.map(|draft| Applied {
        draft,
        pins: open.pins.clone(),
    });
    ways.extend(&freer);
    for way in &ways {
        let plan = verified(domain, world, &way.draft, purpose).ok();
        if let Some(Ok(plan)) = plan.map(Report::into_verified) {
            return done(plan, Vec::new());
        }
    }
    let (mut gave_up, mut too_many) = (None, None);
    for way in &ways {
        match repair_pinned(domain, world, &way.draft, purpose, &way.pins) {
            Outcome::Valid(plan) => return done(plan, Vec::new()),
            // Room for a wish is not made by another plan.
            Outcome::Repaired(repaired) if repaired.edits.len() > OTHERS * wishes.len() + 1 => {
                too_many = Some(repaired.edits.len());
            }
            Outcome::Repaired(repaired) => return done(repaired.plan, repaired.edits),
            Outcome::GaveUp { why, .. } => gave_up = Some(why),
            Outcome::Unclear { .. } | Outcome::ProvenUnsolvable { .. } => {}
        }
    }
    let (mut why, report) = match verified(domain, world, &full.draft, purpose) {
        Ok(report) => (in_the_way(domain, world, &report, purpose), report),
        Err(violation) => {
            let why = violation.message(domain, world, &[], None);
            (vec![why], check(domain, world, plan.clone(), purpose))
        }
    };
    if let Some(changes) = too_many {
        why.push(format!("it would take {changes} other changes of the plan"));
    }
    if let Some(limit) = gave_up {
        why.push(format!("there may be a way around this that was not found: {limit}"));
    }
    Amended::Impossible {
        why,
        report: Box::new(report),
    }
}

fn done(plan: VerifiedPlan, edits: Vec<Edit>) -> Amended {
    Amended::Done(Box::new(Amendment { plan, edits }))
}

/// The report on a draft; its assumptions include the arguments that could be others.
fn verified(domain: &Domain, world: &World, draft: &Resolved, purpose: &Purpose) -> Result<Report, Violation> {
    let steps: Vec<_> = draft.steps.iter().flatten().cloned().collect();
    let (plan, assumptions) = bind(domain, world, &steps, &draft.objects, purpose.claim.as_ref())?;
    let mut report = check(domain, world, plan, purpose);
    report.assumptions.extend(assumptions);
    Ok(report)
}

/// The findings as sentences for a person.
fn in_the_way(domain: &Domain, world: &World, report: &Report, purpose: &Purpose) -> Vec<String> {
    let sentence = |violation: &Violation| match violation {
        Violation::Goal { index } => match purpose.wanted.get(*index) {
            Some(wanted) => format!(
                "at the end, this is not reached: {}",
                wanted_text(domain, world, wanted, &report.ending().after)
            ),
            None => violation.message(domain, world, report.plan.steps(), None),
        },
        other => other.message(domain, world, report.plan.steps(), None),
    };
    report.violations.iter().map(sentence).collect()
}

/// What is wanted as a sentence: the goal word's, or the facts that are missing.
fn wanted_text(domain: &Domain, world: &World, wanted: &Wanted, state: &State) -> String {
    let mut words = domain.goal_words.iter();
    let same = |word: &crate::model::GoalWord| {
        word.condition == wanted.condition && word.parameters.len() == wanted.bindings.len()
    };
    if let Some(index) = words.position(same) {
        let fact = GoalFact::Word {
            word: crate::model::GoalWordId::new(index),
            arguments: wanted.bindings.clone(),
        };
        return fact.sentence(domain, world);
    }
    let missing = unmet(world, state, &wanted.condition, &mut wanted.bindings.clone());
    let facts: Vec<String> = missing
        .iter()
        .filter_map(|missing| Some(fact_text(domain, world, missing.fact?, missing.holds)))
        .collect();
    facts.join(", and ")
}
