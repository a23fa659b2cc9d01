//! Repair: finds the cheapest change that makes a plan valid.
//!
//! Most invalid drafts contain a small error, such as a wrong action or a door that was not opened, while their final
//! environment is usually right. [`repair`] therefore searches for the cheapest way through the draft that reaches this
//! environment: a shortest path over draft position and world state (`compile`), with the search that also solves
//! goals. Keeping an applicable step is free. Other edits have costs from the domain ([`longstep_model::domain::RepairCosts`]).
//! The result is verified like any other plan, and every edit states its reason.

mod branches;
mod compile;
mod edit;
mod pins;
mod target;
#[cfg(test)]
mod tests;

pub use edit::{Edit, EditKind};
pub use pins::{Pins, Reach, Unwanted};

use compile::Move;
use edit::Script;
use target::Meant;

use crate::search::{Found, Limits, Requirements, Scope, WhyNot, cheapest, greedy, reduce, why_not};
use longstep_model::effort;
use longstep_model::model::{Domain, EntityId, Fact, World};
use longstep_verify::plan::{Plan, Resolved};
use longstep_verify::verify::{Purpose, VerifiedPlan, Violation, bind_as_far, check};

/// Maximum number of evaluated states for the cheapest repair, and again for any repair. Counting states makes the
/// result independent of the speed of the machine.
pub const LIMIT: usize = 6_000;

/// Maximum number of steps in a draft; longer drafts are not repaired.
const LONGEST: usize = 500;

/// Work units of one repair: binding, verification and search, on all paths of a branching plan.
const EFFORT: u64 = 50_000_000;

/// Work units of one part of the search: compilation and the search for the cheapest repair.
const SEARCH_EFFORT: u64 = 24_000_000;

/// Maximum number of states for a cheaper repair in the whole world, once a repair is known.
const PROOF: usize = 200;

/// Result of a repair.
///
/// Exhaustive on purpose: code that does not know a new outcome would be wrong.
#[derive(Debug, Clone)]
pub enum RepairOutcome {
    /// The draft is valid.
    Valid(VerifiedPlan),
    /// A valid plan with its edits.
    Repaired(Box<Repaired>),
    /// The draft does not determine what to achieve, so a repair would be a guess.
    Unclear {
        /// The reason, for the user.
        why: String,
    },
    /// No plan keeps the rules and achieves the goal.
    ProvenUnsolvable {
        /// States expanded.
        expanded: usize,
    },
    /// No repair was found; one may exist.
    GaveUp {
        /// The limit that was reached.
        why: String,
        /// States expanded.
        expanded: usize,
    },
}

/// A repaired plan.
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct Repaired {
    /// The plan.
    pub plan: VerifiedPlan,
    /// The edits, in plan order.
    pub edits: Vec<Edit>,
    /// Total cost of the edits.
    pub cost: u32,
    /// True if it is proven that no repair costs less.
    pub cheapest: bool,
    /// Claims of the draft that the plan does not fulfill.
    pub given_up: Vec<Fact>,
    /// States expanded.
    pub expanded: usize,
}

/// Repairs a resolved draft at the least cost. Returns [`RepairOutcome::Valid`] if it needs no repair.
///
/// The goals and rules of `purpose` are hard constraints. The claim is a soft constraint: repair gives up claimed facts
/// that no action can achieve or that cost too much, and lists them. Without a claim, the final state of the draft, as
/// if every step were applicable, takes its place.
///
/// The result is deterministic, also among equally cheap repairs.
///
/// ```
/// use longstep_verify::plan::{TaskCohesion, resolve};
/// use longstep_search::repair::{RepairOutcome, repair};
/// use longstep_model::{domain, environment};
/// use longstep_verify::verify;
/// let domain = domain::shipped("virtualhome").unwrap().unwrap();
/// let text = r#"{"assets": ["<desk_1>", "<fridge_2>"], "objects": ["<milk_3>"],
///     "object_states": {"<milk_3>": "ON(<desk_1>)"}, "asset_properties": {"<fridge_2>": ["IS_OPENABLE"]}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let calls = ["Walktowards(<desk_1>)", "Grab(<milk_3>)", "Walktowards(<fridge_2>)", "PutIn(<milk_3>, <fridge_2>)"];
/// let draft = TaskCohesion {
///     task_sequence: calls.map(str::to_owned).to_vec(),
///     ..TaskCohesion::default()
/// };
/// let outcome = repair(&world, &resolve(&world, &draft), &verify::Purpose::default());
/// let RepairOutcome::Repaired(repaired) = outcome else { panic!("{outcome:?}") };
/// let edits: Vec<_> = repaired.edits.iter().filter_map(|edit| edit.after.clone()).collect();
/// assert_eq!(edits, ["Open(<fridge_2>)", "Close(<fridge_2>)"]);
/// ```
pub fn repair(world: &World, draft: &Resolved, purpose: &Purpose) -> RepairOutcome {
    repair_pinned(world, draft, purpose, &Pins::default())
}

/// Repairs a draft as [`repair`] does, but respects the decisions of the user: no repair violates a pin.
pub fn repair_pinned(world: &World, draft: &Resolved, purpose: &Purpose, pins: &Pins) -> RepairOutcome {
    let world = &*purpose.world(world);
    let spent = effort::within(EFFORT, || repair_within(LIMIT, world, draft, purpose, pins));
    match spent.result {
        // A verified plan stands, even if the budget ended behind it.
        outcome @ (RepairOutcome::Valid(_) | RepairOutcome::Repaired(_)) => outcome,
        RepairOutcome::ProvenUnsolvable { expanded } if spent.exhausted => RepairOutcome::GaveUp {
            why: format!("no repair found in {expanded} states, which took all the work that a repair may take"),
            expanded,
        },
        outcome => outcome,
    }
}

/// Finds the reasons why no plan keeps the rules and achieves what the draft claims, after [`repair`] has proven it.
/// Empty for a draft with branches.
pub fn why_unsolvable(world: &World, draft: &Resolved, purpose: &Purpose) -> WhyNot {
    let world = &*purpose.world(world);
    if !draft.is_sequence() {
        return WhyNot::default();
    }
    let meant = effort::within(EFFORT, || {
        let steps: Vec<_> = draft.steps.iter().flatten().cloned().collect();
        let bound = bind_as_far(world, &steps, &draft.objects, purpose.claim.as_ref());
        let report = check(world, Plan::sequence(bound.steps), purpose);
        target::meant(world, draft, purpose, &report.ending().after)
    });
    if meant.exhausted {
        return WhyNot::default();
    }
    let purpose = Purpose {
        wanted: meant.result.required,
        prohibitions: Vec::new(),
        claim: None,
        ..purpose.clone()
    };
    why_not(world, &purpose, &Limits::default())
}

fn repair_within(limit: usize, world: &World, draft: &Resolved, purpose: &Purpose, pins: &Pins) -> RepairOutcome {
    let domain = world.domain();
    if !draft.is_sequence() {
        return branches::repair_branches(limit, world, draft, purpose, pins);
    }
    let steps: Vec<_> = draft.steps.iter().flatten().cloned().collect();
    let bound = bind_as_far(world, &steps, &draft.objects, purpose.claim.as_ref());
    let whole = draft.issues.is_empty() && bound.missing.is_none();
    // The final state of the draft as if every step were applicable.
    let as_if = match check(world, Plan::sequence(bound.steps), purpose).into_verified() {
        Ok(plan) if whole => return RepairOutcome::Valid(plan),
        Ok(plan) => plan.ending().after.clone(),
        // A draft that exceeds the work budget of verification cannot be repaired either.
        Err(report) if report.violations.contains(&Violation::TooMuchWork) => {
            return RepairOutcome::GaveUp {
                why: "checking the plan took all the work that a check may take".to_owned(),
                expanded: 0,
            };
        }
        Err(report) => report.ending().after.clone(),
    };
    if let Some(why) = unclear(world, draft, purpose) {
        return RepairOutcome::Unclear { why };
    }
    if draft.steps.len() > LONGEST {
        return RepairOutcome::GaveUp {
            why: format!(
                "the plan has {} steps, and repair looks at {LONGEST} at most",
                draft.steps.len()
            ),
            expanded: 0,
        };
    }
    let meant = target::meant(world, draft, purpose, &as_if);
    let (requirements, about) = compile::requirements(world, draft, &meant);
    let mut search = Search {
        domain,
        world,
        draft,
        purpose,
        pins,
        meant: &meant,
        expanded: 0,
        exhausted: false,
    };
    let best = search.best(limit, &requirements, &about);
    let (expanded, exhausted) = (search.expanded, search.exhausted);
    match best {
        Found::Path(best) => match follow(world, draft, purpose, &meant, best, expanded) {
            Some(repaired) => RepairOutcome::Repaired(Box::new(repaired)),
            None => RepairOutcome::GaveUp {
                why: "the repair that was found with what surrounds the plan does not work in the whole world"
                    .to_owned(),
                expanded,
            },
        },
        Found::Nothing => RepairOutcome::ProvenUnsolvable { expanded },
        Found::Limit => RepairOutcome::GaveUp {
            why: if exhausted {
                format!("no repair found in {expanded} states, which took all the work that a search may take")
            } else {
                format!("no repair found in {expanded} states")
            },
            expanded,
        },
    }
}

/// Returns the reason why a repair would be a guess: the handled object is unknown, a value is out of range, or steps
/// cannot be resolved and no claim shows their purpose.
fn unclear(world: &World, draft: &Resolved, purpose: &Purpose) -> Option<String> {
    let without_aim = purpose.claim.is_none() && purpose.wanted.is_empty();
    let issue = draft.issues.iter().find(|issue| match issue {
        Violation::UnknownEntity { step: None, .. } | Violation::OutOfRange { .. } => true,
        issue => without_aim && issue.step().is_some(),
    })?;
    let message = issue.message(world, &[], None);
    Some(match issue.step() {
        Some(_) => format!("{message}; and the plan does not claim what the world is to be afterwards"),
        None => message,
    })
}

struct Search<'a> {
    domain: &'a Domain,
    world: &'a World,
    draft: &'a Resolved,
    purpose: &'a Purpose,
    pins: &'a Pins,
    meant: &'a Meant,
    expanded: usize,
    /// True if a part of the search exhausted its budget.
    exhausted: bool,
}

impl Search<'_> {
    /// Finds a cheap repair with entities near the plan, then uses the whole world to prove that none is cheaper or to
    /// find a cheaper one.
    fn best(&mut self, limit: usize, requirements: &Requirements, about: &[EntityId]) -> Found<RepairMoves> {
        let whole = Scope::whole(self.world, requirements);
        let near = whole.around(self.world, requirements, about, false);
        // In a small world, the first search would save nothing.
        let small = 2 * near.len() >= whole.len();
        let mut best = if small {
            Found::Limit
        } else {
            self.within(&near, limit, None)
        };
        if !whole.is_bearable(self.world) {
            if !matches!(best, Found::Path(_)) {
                let far = whole.around(self.world, requirements, about, true);
                if far.is_bearable(self.world) {
                    best = self.within(&far, limit, None);
                }
            }
            // A search limited to some entities proves nothing about the others.
            return match best {
                Found::Nothing => Found::Limit,
                best => best,
            };
        }
        let (limit, below) = match &best {
            // In a large world this proof takes most of the time of a repair.
            Found::Path(best) => (limit.min(PROOF), Some(best.cost)),
            Found::Nothing | Found::Limit => (limit, None),
        };
        match (self.within(&whole, limit, below), &mut best) {
            (Found::Nothing, Found::Path(best)) => best.cheapest = true,
            (Found::Limit, Found::Path(_)) => {}
            (found, best) => *best = found,
        }
        best
    }

    /// Finds the cheapest repair in scope, or any repair if the limit is reached first.
    fn within(&mut self, scope: &Scope, limit: usize, below: Option<u32>) -> Found<RepairMoves> {
        let spent = effort::within(SEARCH_EFFORT, || self.best_within(scope, limit, below));
        self.exhausted |= spent.exhausted;
        if spent.exhausted { Found::Limit } else { spent.result }
    }

    fn best_within(&mut self, scope: &Scope, limit: usize, below: Option<u32>) -> Found<RepairMoves> {
        let compiled = compile::compile(self.world, scope, self.draft, self.purpose, self.pins);
        let (task, moves) = compiled.task(self.domain, self.meant);
        let task = reduce(task);
        let (mut found, looked_at) = cheapest(&task, limit, below);
        self.expanded += looked_at;
        let proven = found != Found::Limit;
        // With a bound, a repair is known already.
        if !proven && below.is_none() {
            let (any, looked_at) = greedy(&task, limit);
            self.expanded += looked_at;
            found = any;
        }
        match found {
            Found::Path(path) => {
                let operators = || path.iter().map(|number| &task.operators[*number as usize]);
                Found::Path(RepairMoves {
                    moves: operators()
                        .map(|operator| moves[operator.tag as usize].clone())
                        .collect(),
                    cost: operators().map(|operator| operator.cost).sum(),
                    cheapest: proven && scope.whole,
                })
            }
            Found::Nothing => Found::Nothing,
            Found::Limit => Found::Limit,
        }
    }
}

/// The moves of a repair.
#[derive(Debug, Clone)]
struct RepairMoves {
    moves: Vec<Move>,
    cost: u32,
    /// True if it is proven that no repair costs less.
    cheapest: bool,
}

/// Returns the repaired plan if it is valid in the whole world.
fn follow(
    world: &World,
    draft: &Resolved,
    purpose: &Purpose,
    meant: &Meant,
    best: RepairMoves,
    expanded: usize,
) -> Option<Repaired> {
    let mut given_up = meant.impossible.clone();
    given_up.extend(best.moves.iter().filter_map(|next| match next {
        Move::Forgo(fact) => Some(*fact),
        _ => None,
    }));
    given_up.sort_unstable();
    let script = Script::of(world, draft, &best.moves);
    let mut purpose = purpose.clone();
    // A repair pursues claimed facts, and leaves numbers to the steps that bring them about.
    purpose.claim = purpose.claim.map(|claim| claim.without(&given_up).without_numbers());
    let report = check(world, script.plan(), &purpose);
    let edits = script.edits(world, draft, &purpose, meant, &report);
    Some(Repaired {
        plan: report.into_verified().ok()?,
        edits,
        cost: best.cost,
        cheapest: best.cheapest,
        given_up,
        expanded,
    })
}
