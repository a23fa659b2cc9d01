//! Is a plan possible, does it keep the rules, and what is the world afterwards?
//!
//! [`check`] simulates a plan and tells everything it finds as data. Only a [`Report`] without violations
//! turns into a [`VerifiedPlan`], and there is no other way to make one.

mod bind;
mod rules;
mod simulate;
#[cfg(test)]
mod tests;
mod violation;

pub use bind::bind;
pub(crate) use rules::wanted_at_end;
pub use rules::{Waiver, broken_bindings};
pub use simulate::{Change, apply, unmet};
pub use violation::{Assumption, Missing, Violation};

use crate::domain::{Domain, RuleTime};
use crate::plan::{Plan, Step};
use crate::search::Wanted;
use crate::world::{FactSet, Moment, State, World, holds};

/// What a plan is for, as far as it is known.
#[derive(Debug, Clone, Default)]
pub struct Purpose {
    /// What must hold at the end.
    pub wanted: Vec<Wanted>,
    /// Which rules are set aside, and for what.
    pub waivers: Vec<Waiver>,
    /// Whether the plan was made from a goal, so that tidy rules bind it.
    pub from_goal: bool,
}

/// What verification found.
#[derive(Debug, Clone)]
pub struct Report {
    /// The steps, all arguments bound.
    pub steps: Vec<Step>,
    /// What each step changed.
    pub trace: Vec<Vec<Change>>,
    /// What is wrong; empty for a good plan.
    pub violations: Vec<Violation>,
    /// What is odd without being wrong.
    pub warnings: Vec<Violation>,
    /// What the verdict rests on that the environment does not say.
    pub assumptions: Vec<Assumption>,
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
    /// The steps.
    pub fn steps(&self) -> &[Step] {
        &self.report.steps
    }

    /// The report behind it.
    pub fn report(&self) -> &Report {
        &self.report
    }

    /// The world after the last step.
    pub fn after(&self) -> &State {
        &self.report.after
    }
}

impl Report {
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
pub fn check(domain: &Domain, world: &World, plan: Plan, purpose: &Purpose) -> Report {
    let mut state = world.state.clone();
    let mut assumed: FactSet = world.assumptions();
    let mut report = Report {
        steps: Vec::new(),
        trace: Vec::with_capacity(plan.steps.len()),
        violations: Vec::new(),
        warnings: Vec::new(),
        assumptions: Vec::new(),
        after: State::default(),
    };
    let mut rested: FactSet = FactSet::default();
    // What held in the first state has been looked at when the environment was read.
    let mut broken_before = Vec::new();
    for (index, step) in plan.steps.iter().enumerate() {
        let action = domain.action(step.action);
        let missing = unmet(world, &state, &action.precondition, &mut step.arguments.clone());
        if missing.is_empty() {
            simulate::rests_on(world, &state, &assumed, action, &step.arguments, &mut rested);
        } else {
            report.violations.push(Violation::Precondition {
                step: index,
                missing: violation::with_culprits(missing, &report.trace),
            });
        }
        let changes = apply(world, &mut state, action, &step.arguments);
        for change in &changes {
            assumed.remove(&change.fact);
        }
        report.trace.push(changes);
        let mut broken_now = Vec::new();
        for (number, rule) in domain
            .rules
            .iter()
            .enumerate()
            .filter(|(_, r)| r.time == RuleTime::Always)
        {
            for bindings in broken_bindings(rule, world, &state) {
                if !broken_before.contains(&(number, bindings.clone())) {
                    report.violations.push(Violation::Rule {
                        step: Some(index),
                        rule: number,
                        bindings: bindings.clone(),
                    });
                }
                broken_now.push((number, bindings));
            }
        }
        broken_before = broken_now;
    }
    for (number, rule) in domain
        .rules
        .iter()
        .enumerate()
        .filter(|(_, r)| matches!(r.time, RuleTime::End | RuleTime::Tidy))
    {
        for bindings in broken_bindings(rule, world, &state) {
            if purpose.waivers.iter().any(|waiver| waiver.covers(number, &bindings)) {
                continue;
            }
            let binds = rule.time == RuleTime::End || purpose.from_goal;
            let list = if binds {
                &mut report.violations
            } else {
                &mut report.warnings
            };
            list.push(Violation::Rule {
                step: None,
                rule: number,
                bindings,
            });
        }
    }
    for (index, wanted) in purpose.wanted.iter().enumerate() {
        let moment = Moment { world, state: &state };
        if !holds(moment, &wanted.condition, &mut wanted.bindings.clone()) {
            report.violations.push(Violation::Goal { index });
        }
    }
    let mut rested: Vec<_> = rested.into_iter().collect();
    rested.sort_unstable();
    report.assumptions = rested
        .into_iter()
        .filter_map(|fact| {
            Some(Assumption::Fact {
                fact,
                ground: world.assumed(fact)?,
            })
        })
        .collect();
    report.steps = plan.steps;
    report.after = state;
    report
}
