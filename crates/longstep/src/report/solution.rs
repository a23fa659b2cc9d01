//! Planning for a goal: a verified plan, or the reason why there is none.

use super::{Answer, SearchAnswer, Status};
use crate::clock::Clock;
use crate::environment::{Voice, World};
use crate::goal::Goal;
use crate::search::{self, Limits, Outcome, WhyNot};
use crate::verify::{Purpose, VerifiedPlan, check};

/// Result of a search.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Solution {
    /// The plan, if one was found.
    pub plan: Option<VerifiedPlan>,
    /// The answer for people and programs.
    pub answer: Answer,
}

/// Searches for a plan for a goal and verifies it; `summary` describes the goal in words.
///
/// ```
/// use longstep::{Clock, domain, goal, report};
/// use longstep_core::environment;
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let goal = goal::parse(&world, "put(pen, shelf)").unwrap();
/// let solution = report::of_goal(&world, &goal, "the pen belongs on the shelf", &longstep::Limits::default(), &Clock::none());
/// assert_eq!(solution.plan.unwrap().steps().len(), 6);
/// ```
pub fn of_goal(world: &World, goal: &Goal, summary: &str, limits: &Limits, clock: &Clock) -> Solution {
    let purpose = goal.purpose(world);
    let mut solution = of_purpose(world, &purpose, Some(goal), summary, limits, clock);
    solution.answer.set_goal(world, goal);
    solution
}

/// Searches for a plan for a purpose and verifies it. `goal` serves only the wording of the answer.
pub fn of_purpose(
    world: &World,
    purpose: &Purpose,
    goal: Option<&Goal>,
    summary: &str,
    limits: &Limits,
    clock: &Clock,
) -> Solution {
    let started = clock.now();
    let found = search::solve(world, purpose, limits);
    let searched = clock.now();
    let mut plan = None;
    let mut answer = match found {
        Outcome::Solved {
            plan: steps,
            worst,
            shortest,
            at_least,
            expanded,
            ..
        } => {
            let report = check(world, steps, purpose);
            let verified = clock.now();
            let mut answer = Answer::of_report(world, &report, goal, summary);
            answer.timings_ms.verify = Clock::milliseconds(searched, verified);
            answer.search = Some(SearchAnswer {
                shortest,
                at_least,
                states: expanded,
            });
            if !shortest {
                let note = if world.domain().has_costs() {
                    "a cheaper plan may exist: the search for it was cut short".to_owned()
                } else {
                    not_proven(worst, at_least, expanded)
                };
                answer.notes.push(note);
            }
            plan = report.into_verified().ok();
            answer
        }
        Outcome::ProvenUnsolvable { when, .. } => {
            let mut answer = Answer::without_plan(Status::Unsolvable, world, summary, "");
            let facts = when.map(|fact| Voice::Person.fact(world, fact, true));
            let why = search::why_not(world, purpose, limits);
            answer.notes.extend(reasons(world, goal, &why));
            answer
                .notes
                .extend(facts.map(|fact| format!("there is no way if it turns out that {fact}")));
            answer
        }
        Outcome::GaveUp { why, .. } => {
            let mut answer = Answer::without_plan(Status::GaveUp, world, summary, "");
            answer.notes.push(why);
            answer
        }
    };
    answer.timings_ms.search = Clock::milliseconds(started, searched);
    Solution { plan, answer }
}

/// Writes what is known about plans shorter than the one that was found.
fn not_proven(steps: u32, at_least: u32, states: usize) -> String {
    let known = match at_least {
        0 => String::new(),
        // The bound of a search among all plans: the plan itself has more steps.
        at_least if at_least + 1 >= steps => format!(" of {at_least} steps"),
        at_least => format!(" of {at_least} to {} steps", steps.saturating_sub(1)),
    };
    format!("a shorter plan{known} may exist: none was found in {states} states")
}

/// Maximum number of rules that a sentence names.
const RULES: usize = 10;

/// Writes the reasons why there is no plan as sentences.
pub(super) fn reasons(world: &World, goal: Option<&Goal>, why: &WhyNot) -> Vec<String> {
    let mut reasons = Vec::new();
    match &why.prohibitions[..] {
        [] => {}
        [one] => reasons.push(format!("`{one}` prevents it: there is a plan without this rule")),
        several => {
            let named = several.iter().take(RULES).map(|rule| format!("`{rule}`"));
            let mut named: Vec<String> = named.collect();
            if several.len() > RULES {
                named.push(format!("and {} more", several.len() - RULES));
            }
            reasons.push(format!("these rules prevent it: {}", named.join(", ")));
        }
    }
    if why.order {
        reasons.push("all goals can be reached, but not in this order".to_owned());
    }
    if why.together {
        reasons.push("each goal can be reached, but not all of them together".to_owned());
    }
    let facts = why.goals.iter().filter_map(|index| goal?.facts.get(*index));
    reasons.extend(facts.map(|fact| format!("this cannot be reached, not even by itself: {}", fact.sentence(world))));
    reasons.extend(why.missing.as_ref().map(|missing| missing.sentence(world)));
    reasons
}
