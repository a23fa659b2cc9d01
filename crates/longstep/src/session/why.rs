//! Explanations of single steps.

use rustc_hash::FxHashSet;

use crate::environment::{Voice, World};
use crate::goal::Goal;
use crate::plan::{Plan, StepId};
use crate::verify::{Purpose, check};

/// Explains a step of a plan: its effects, and the violations without it, as sentences.
///
/// The violations are found by verification of the plan without the step.
///
/// ```
/// use longstep_core::plan::StepId;
/// use longstep::report;
/// use longstep::{Clock, domain, goal, session};
/// use longstep_core::environment;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(pen, shelf)").unwrap();
/// let plan = report::of_goal(&world, &goal, "", &longstep::Limits::default(), &Clock::none()).plan.unwrap();
/// let why = session::why(&world, plan.plan(), &goal.purpose(&world), Some(&goal), StepId::new(1));
/// assert_eq!(why.brings_about, ["the hand holds the pen"]);
/// assert_eq!(why.without_it[0], "step 3: detach_from_plane() needs that the hand holds the pen");
/// ```
pub fn why(world: &World, plan: &Plan, purpose: &Purpose, goal: Option<&Goal>, step: StepId) -> Why {
    let whole = check(world, plan.clone(), purpose);
    let mut brings_about: Vec<String> = Vec::new();
    for ending in &whole.endings {
        for (_, changes) in ending.trace.steps().filter(|(id, _)| *id == step) {
            let facts = changes
                .iter()
                .map(|change| Voice::Person.fact(world, change.fact, change.holds));
            brings_about.extend(facts);
        }
    }
    let mut seen = FxHashSet::default();
    brings_about.retain(|fact| seen.insert(fact.clone()));
    if !world.domain().action(plan.step(step).action).senses.is_empty() && brings_about.len() > 1 {
        brings_about = vec![format!("it is known whether {}", brings_about.join(", or whether "))];
    }
    let Some(left) = plan.without(step) else {
        return Why {
            brings_about,
            without_it: vec!["nobody could tell which way the plan is to go".to_owned()],
        };
    };
    let mut violations: Vec<String> = Vec::new();
    for mut violation in check(world, left, purpose).violations {
        // Messages number the steps as in the whole plan.
        violation.renumber(|number| if number >= step.index() { number + 1 } else { number });
        violations.push(violation.message(world, plan.steps(), goal.map(Goal::as_sentences)));
    }
    Why {
        brings_about,
        without_it: violations,
    }
}

/// The explanation of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Why {
    /// Facts that the step makes true or false.
    pub brings_about: Vec<String>,
    /// Violations of the plan without the step; empty if it remains valid.
    pub without_it: Vec<String>,
}
