//! Is a plan possible, does it keep the rules, and what is the world afterwards?
//!
//! [`check`] simulates a plan and tells everything it finds as data. Only a [`Report`] without violations
//! turns into a [`VerifiedPlan`], and there is no other way to make one.

mod bind;
mod explain;
mod possible;
mod rules;
mod simulate;
#[cfg(test)]
mod tests;
mod trace;
mod violation;

pub use bind::bind;
pub(crate) use bind::{Candidate, candidates, claimed_places};
pub use explain::feedback;
pub(crate) use possible::{can_apply, can_be_brought_about};
pub use rules::{Waiver, broken_bindings};
pub(crate) use rules::{broken_at_end, wanted_at_end};
pub use simulate::{apply, unmet};
pub use trace::{Change, Trace};
pub use violation::{Assumption, Missing, Violation};

use crate::domain::{ActionId, Domain, RuleTime};
use crate::goal::Spoken;
use crate::plan::{Node, Plan, Step, StepId};
use crate::search::Wanted;
use crate::world::{Bindings, Claim, EntityId, Fact, Moment, State, World, differences, holds, subject_of};

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
    /// What was asked for, in a person's words.
    pub instruction: Option<String>,
}

/// What verification found.
#[derive(Debug, Clone)]
pub struct Report {
    /// The plan, all arguments bound.
    pub plan: Plan,
    /// How it can end, at least one: several where sensing decides, sorted by what it told.
    pub endings: Vec<Ending>,
    /// What is wrong; empty for a good plan.
    pub violations: Vec<Violation>,
    /// What is odd without being wrong.
    pub warnings: Vec<Violation>,
    /// What the verdict rests on that the environment does not say.
    pub assumptions: Vec<Assumption>,
}

/// One way in which a plan can end.
#[derive(Debug, Clone)]
pub struct Ending {
    /// What sensing told on the way, as far as it is still known; empty for a plan without sensing.
    pub when: Vec<Fact>,
    /// What each step changed, on one way that ends so.
    pub trace: Trace,
    /// The world after the last step.
    pub after: State,
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
/// else in which claim and simulation differ is for [`crate::answer::compare_claims`] to show.
pub fn check(domain: &Domain, world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let mut walk = Walk {
        domain,
        world,
        plan: &plan,
        violations: Vec::new(),
        warnings: Vec::new(),
        rested: Vec::new(),
        bindings: Vec::new(),
        fired: Vec::new(),
    };
    let mut path = Path {
        state: world.state.clone(),
        trace: Trace::default(),
        broken: Vec::new(),
    };
    walk.nodes(plan.body(), &mut path);
    walk.end(&path.state, purpose);
    let Walk {
        violations,
        mut warnings,
        mut rested,
        ..
    } = walk;
    if let Some(instruction) = &purpose.instruction {
        warnings.extend(moved_unasked(domain, world, &path.state, instruction));
    }
    rested.sort_unstable();
    rested.dedup();
    let assumption = |fact: Fact| {
        let ground = world.assumed(fact)?;
        Some(Assumption::Fact { fact, ground })
    };
    Report {
        endings: vec![Ending {
            when: Vec::new(),
            trace: path.trace,
            after: path.state,
        }],
        violations,
        warnings,
        assumptions: rested.into_iter().filter_map(assumption).collect(),
        plan,
    }
}

/// One way through a plan.
struct Path {
    state: State,
    trace: Trace,
    /// The rules that are broken in the state, so that each is told where it begins to be.
    broken: Vec<(usize, Bindings)>,
}

/// What is found on the way, and room to work in.
struct Walk<'a> {
    domain: &'a Domain,
    world: &'a World,
    plan: &'a Plan,
    violations: Vec<Violation>,
    warnings: Vec<Violation>,
    rested: Vec<Fact>,
    bindings: Bindings,
    fired: Vec<(Fact, bool)>,
}

impl Walk<'_> {
    fn nodes(&mut self, nodes: &[Node], path: &mut Path) {
        for node in nodes {
            match node {
                Node::Step(id) => self.step(*id, path),
                _ => {}
            }
        }
    }

    fn step(&mut self, id: StepId, path: &mut Path) {
        let step = self.plan.step(id);
        let action = self.domain.action(step.action);
        self.bindings.clear();
        self.bindings.extend_from_slice(&step.arguments);
        let moment = Moment {
            world: self.world,
            state: &path.state,
        };
        if holds(moment, &action.precondition, &mut self.bindings) {
            simulate::rests_on(
                moment,
                &action.precondition,
                &mut self.bindings,
                path.trace.changes(),
                &mut self.rested,
            );
        } else {
            let missing = unmet(self.world, &path.state, &action.precondition, &mut self.bindings);
            self.violations.push(Violation::Precondition {
                step: id.index(),
                missing: violation::with_culprits(missing, &path.trace),
            });
        }
        let changes = path.trace.begin(id);
        simulate::apply_onto(
            self.world,
            &mut path.state,
            action,
            &mut self.bindings,
            &mut self.fired,
            changes,
        );
        if path.trace.last().is_empty() && !action.effects.is_empty() {
            self.warnings.push(Violation::NoEffect { step: id.index() });
        }
        self.always(id, path);
    }

    /// Rules that hold in every state: told after the step that breaks them.
    fn always(&mut self, id: StepId, path: &mut Path) {
        let rules = self.domain.rules.iter().enumerate();
        let mut now = Vec::new();
        for (number, rule) in rules.filter(|(_, rule)| rule.time == RuleTime::Always) {
            for bindings in broken_bindings(rule, self.world, &path.state) {
                // What held in the first state has been looked at when the environment was read.
                let broken = (number, bindings);
                if !path.broken.contains(&broken) {
                    self.violations.push(Violation::Rule {
                        step: Some(id.index()),
                        rule: number,
                        bindings: broken.1.clone(),
                    });
                }
                now.push(broken);
            }
        }
        path.broken = now;
    }

    fn end(&mut self, state: &State, purpose: &Purpose) {
        let promises = purpose
            .claim
            .as_ref()
            .map(|claim| claim.promises(self.domain, self.world));
        let meant: Vec<EntityId> = promises
            .iter()
            .flatten()
            .map(|fact| subject_of(self.domain, *fact))
            .collect();
        for broken in broken_at_end(self.domain, self.world, state, purpose) {
            // What the plan says it changes is not untidy.
            if !broken.binds && broken.bindings.iter().any(|entity| meant.contains(entity)) {
                continue;
            }
            let list = if broken.binds {
                &mut self.violations
            } else {
                &mut self.warnings
            };
            list.push(Violation::Rule {
                step: None,
                rule: broken.rule,
                bindings: broken.bindings,
            });
        }
        let moment = Moment {
            world: self.world,
            state,
        };
        for (index, wanted) in purpose.wanted.iter().enumerate() {
            if !holds(moment, &wanted.condition, &mut wanted.bindings.clone()) {
                self.violations.push(Violation::Goal { index });
            }
        }
        if let Some(claim) = &purpose.claim {
            let mut broken = broken_promises(self.domain, self.world, claim, state);
            let steps = self.plan.steps().iter();
            let led = steps.filter(|step| hides_places(self.domain, step.action));
            let handled: Vec<EntityId> = led.filter_map(|step| step.object(self.domain)).collect();
            let mut placed = places_claimed(self.domain, self.world, claim, &handled);
            placed.retain(|fact| !state.holds(*fact));
            broken.extend(placed);
            self.violations
                .extend(broken.into_iter().map(|fact| Violation::Claim { fact }));
        }
    }
}

/// What is claimed to have come about, has not, and could have.
pub(crate) fn broken_promises(domain: &Domain, world: &World, claim: &Claim, state: &State) -> Vec<Fact> {
    let mut promises = claim.promises(domain, world);
    promises.retain(|fact| !state.holds(*fact) && can_be_brought_about(domain, world, *fact));
    promises
}

/// Whether the call of an action hides more than the thing that is handled: where it goes.
pub(crate) fn hides_places(domain: &Domain, action: ActionId) -> bool {
    let action = domain.action(action);
    action.implicit().any(|parameter| action.object != Some(parameter))
}

/// Where the claim says that things are which are handled by calls that do not say where: then the claim alone does,
/// even if it says that they are back where they were.
pub(crate) fn places_claimed(domain: &Domain, world: &World, claim: &Claim, handled: &[EntityId]) -> Vec<Fact> {
    let mut places = claim.kept(domain, world);
    places.retain(|fact| {
        domain.is_relation(*fact)
            && domain.words(fact.predicate()).fluent
            && handled.contains(&subject_of(domain, *fact))
    });
    places
}

/// Objects that end elsewhere and that the instruction does not speak of.
fn moved_unasked(domain: &Domain, world: &World, after: &State, instruction: &str) -> Vec<Violation> {
    let spoken = Spoken::of(domain, world, instruction);
    let mut moved: Vec<EntityId> = differences(domain, &world.state, after)
        .into_iter()
        .filter(|difference| domain.is_relation(difference.fact))
        .map(|difference| difference.fact.argument(0))
        .filter(|entity| world.is_of_kind(*entity, domain.environment.object) && !spoken.entities.contains(entity))
        .collect();
    moved.sort_unstable();
    moved.dedup();
    // An instruction that names nothing at all says nothing about what may be moved.
    if spoken.entities.is_empty() {
        moved.clear();
    }
    moved.into_iter().map(|entity| Violation::Unasked { entity }).collect()
}
