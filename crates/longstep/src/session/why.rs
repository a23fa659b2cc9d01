//! Why is a step there?

use crate::domain::Domain;
use crate::goal::Goal;
use crate::plan::{Plan, Step};
use crate::verify::{Purpose, check};
use crate::world::{Voice, World};

/// What a step of a plan brings about, and what would be wrong without it, as sentences.
///
/// The second part is found by taking the step out and verifying what is left.
///
/// ```
/// use longstep::solution;
/// use longstep::{domain, goal, json, session, world};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let environment = world::Environment::from_json(text).unwrap();
/// let world = world::read(&household, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let goal = goal::parse(&household, &world, "put(pen, shelf)").unwrap();
/// let plan = solution::of_goal(&household, &world, &goal, "", || 0.0).plan.unwrap();
/// let why = session::why(&household, &world, plan.steps(), &goal.purpose(&household), Some(&goal), 1);
/// assert_eq!(why.brings_about, ["the hand holds the pen"]);
/// assert_eq!(why.without_it[0], "step 3: detach_from_plane() needs that the hand holds the pen");
/// ```
pub fn why(domain: &Domain, world: &World, steps: &[Step], purpose: &Purpose, goal: Option<&Goal>, step: usize) -> Why {
    let whole = check(domain, world, Plan::sequence(steps.to_vec()), purpose);
    let changed = whole.ending().trace.steps().find(|(id, _)| id.index() == step);
    let brings_about = changed
        .into_iter()
        .flat_map(|(_, changes)| changes)
        .map(|change| Voice::Person.fact(domain, world, change.fact, change.holds))
        .collect();
    let mut left = steps.to_vec();
    if step < left.len() {
        left.remove(step);
    }
    let report = check(domain, world, Plan::sequence(left), purpose);
    let mut told: Vec<String> = Vec::new();
    for mut violation in report.violations {
        // Steps are told by their numbers in the whole plan.
        violation.renumber(|number| if number >= step { number + 1 } else { number });
        told.push(violation.message(domain, world, steps, goal));
    }
    Why {
        brings_about,
        without_it: told,
    }
}

/// Why a step is there.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Why {
    /// What it makes true or false.
    pub brings_about: Vec<String>,
    /// What would be wrong without it; empty if nothing would.
    pub without_it: Vec<String>,
}
