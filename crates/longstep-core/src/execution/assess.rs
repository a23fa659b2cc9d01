//! The effect of a difference on the rest of a plan, and what follows from it.

use rustc_hash::FxHashMap;

use super::need::{Effect, Stop};
use super::order::taught_step;
use super::{Event, Execution, Trust, ground};
use longstep_model::model::{Moment, Prohibition, State, StateVariable, StepPattern, World, apply, fired, holds};
use longstep_search::search::GroundAction;
use longstep_verify::cursor::Rest;
use longstep_verify::plan::{Plan, Step, StepId};
use longstep_verify::verify::{Purpose, VerifiedPlan, check};

/// Maximum number of rests that are verified to see how many steps have become needless.
const CANDIDATES: usize = 256;

/// The rest of a plan that is valid from the observed world.
struct Fitting {
    plan: VerifiedPlan,
    effect: Effect,
    /// The steps that become needless, or that are repeated, as calls.
    steps: Vec<String>,
}

/// Why a step is not repeated again that had its own effects, and after which something else is missing.
const IN_VAIN: &str = "what it was for did not come about";

impl Execution {
    /// Sorts a difference, and continues with the rest of the plan, or with a change of it.
    pub(super) fn assess(&mut self) {
        self.suspicious = false;
        let state = self.state().clone();
        let here = self.here(state);
        let purpose = self.rest_of_purpose();
        let fitting = self.fitting(&here, &purpose);
        if let Some(fitting) = &fitting
            && fitting.effect == Effect::Undone
        {
            let repeated: Vec<_> = fitting
                .plan
                .steps()
                .iter()
                .take(fitting.steps.len())
                .map(ground)
                .collect();
            if !std::mem::take(&mut self.meanwhile.is_blameless) {
                self.count_repeated(&repeated);
            }
            if repeated.iter().any(|step| self.is_forbidden(step)) {
                return self.assess();
            }
        }
        let effect = fitting.as_ref().map_or(Effect::Harmful, |fitting| fitting.effect);
        let because = std::mem::take(&mut self.differences);
        self.events.push(Event::assessed(
            &self.world,
            effect,
            &because,
            fitting.as_ref().map_or(&[], |fitting| &fitting.steps),
        ));
        match fitting {
            Some(fitting) if effect == Effect::Harmless => {
                drop(fitting);
                self.confirm();
            }
            Some(fitting) => {
                let taught = self.taught_before(&fitting.plan);
                if self.has_unfit(&fitting.plan, taught) {
                    return self.change(&here, &purpose, because);
                }
                let failures = self.failures.clone();
                self.install(&fitting.plan, taught);
                if effect == Effect::Undone {
                    self.failures = failures;
                }
            }
            None => self.change(&here, &purpose, because),
        }
    }

    /// Returns the number of steps of the plan of the beginning before those of a rest of the plan in force; none if the
    /// plan is no rest of it.
    fn taught_before(&self, plan: &VerifiedPlan) -> Option<usize> {
        let (before, rest) = (self.cursor.plan().steps(), plan.steps());
        let calls = |steps: &[Step]| steps.iter().map(ground).collect::<Vec<_>>();
        let first = before.len().checked_sub(rest.len())?;
        let is_rest = calls(&before[first..]) == calls(rest);
        is_rest.then_some(self.taught? + first)
    }

    /// Returns true if a plan has steps that nobody taught, or whose values are outside of the limits.
    fn has_unfit(&self, plan: &VerifiedPlan, taught: Option<usize>) -> bool {
        let mut steps = plan.steps().iter().enumerate();
        steps.any(|(index, step)| {
            let taught = taught_step(taught, StepId::new(index));
            self.unfit(taught, &ground(step)).is_some()
        })
    }

    /// Returns the world of the rest of the plan, in which steps that failed too often are forbidden.
    pub(super) fn here(&self, state: State) -> World {
        let here = self.world.continued(state);
        if self.forbidden.is_empty() {
            return here;
        }
        let failed = self.forbidden.iter().map(|(step, why)| {
            let call = super::written::written_step(&self.world, step.action, &step.arguments);
            let pattern = StepPattern {
                action: Some(step.action),
                arguments: step.arguments.iter().copied().map(Some).collect(),
                anywhere: None,
            };
            Prohibition::new(
                format!("never {call}"),
                format!("`{call}` cannot be done: {why}"),
                None,
                vec![pattern],
            )
        });
        here.with_prohibitions(failed)
    }

    /// Returns the purpose of the rest of the plan.
    pub(super) fn rest_of_purpose(&self) -> Purpose {
        let stages = if self.purpose.stages.is_empty() {
            Vec::new()
        } else {
            self.progress.remaining(&self.world, &self.purpose)
        };
        Purpose {
            stages,
            ..self.purpose.clone()
        }
    }

    /// Returns the rest of the plan that achieves the purpose from here: as much of it as possible is needless, as
    /// little of it as possible is repeated.
    fn fitting(&self, here: &World, purpose: &Purpose) -> Option<Fitting> {
        let rest = self.cursor.rest()?;
        let length = rest.plan.body().len();
        let mut left = CANDIDATES;
        for needless in (0..=length).rev() {
            let Some(candidate) = rest.without_first(needless) else {
                continue;
            };
            let skipped = rest.plan.steps().len() - candidate.plan.steps().len();
            if self.rests_on_promise(here, &rest.plan.steps()[..skipped]) {
                continue;
            }
            if let Some(plan) = valid(here, candidate, purpose, &mut left) {
                return Some(Fitting {
                    steps: calls(here, &rest.plan, 0..skipped),
                    effect: match needless {
                        0 => Effect::Harmless,
                        _ => Effect::Helpful,
                    },
                    plan,
                });
            }
        }
        if self.since.is_empty() {
            return None;
        }
        let before = self.checkpoint.rest()?;
        let kept = if before.plan.is_sequence() {
            self.since.len().min(before.plan.steps().len())
        } else {
            1
        };
        (0..kept).rev().find_map(|from| {
            let plan = valid(here, before.without_first(from)?, purpose, &mut left)?;
            Some(Fitting {
                steps: calls(here, &before.plan, from..kept),
                effect: Effect::Undone,
                plan,
            })
        })
    }

    /// Returns true if only a promise says that an effect of these steps is there already.
    fn rests_on_promise(&self, here: &World, steps: &[Step]) -> bool {
        let mut state = here.state.clone();
        let mut facts = Vec::new();
        self.settings.trust == Trust::Observed
            && steps.iter().any(|step| {
                let action = here.domain().action(step.action);
                fired(here, &state, action, &mut step.arguments.clone(), &mut facts);
                let promised = facts.iter().any(|(fact, holds)| {
                    here.state.holds(*fact) == *holds && self.is_unproven(StateVariable::Fact(*fact))
                });
                apply(here, &mut state, action, &step.arguments);
                promised
            })
    }

    /// Counts a failure of each step that is repeated because an effect of it is missing; it may be one too many. What is
    /// repeated because it follows such a step has not failed.
    pub(super) fn count_repeated(&mut self, repeated: &[GroundAction]) {
        let first = self.since.len().saturating_sub(repeated.len());
        let missing = self.without_effect();
        let of_repeated = missing.into_iter().filter(|index| *index >= first);
        let failed: Vec<GroundAction> = of_repeated.map(|index| self.since[index].clone()).collect();
        let (failed, why) = if failed.is_empty() {
            // What is missing is no effect of theirs, and comes about if they are repeated.
            (repeated.to_vec(), IN_VAIN)
        } else {
            (failed, "it had no effect")
        };
        for step in failed {
            self.count_failure(step, why);
        }
    }

    /// Returns which steps since the last confirmed state have an effect that is missing, unless a later one of them
    /// changes the same.
    fn without_effect(&self) -> Vec<usize> {
        let mut state = self.checkpoint.state().clone();
        let mut last = FxHashMap::default();
        for (index, step) in self.since.iter().enumerate() {
            let action = self.world.domain().action(step.action);
            let changes = apply(&self.world, &mut state, action, &step.arguments);
            let facts = changes.facts.iter().map(|own| StateVariable::Fact(own.fact));
            let numbers = changes.numbers.iter().map(|own| StateVariable::Number(own.fluent));
            last.extend(facts.chain(numbers).map(|variable| (variable, index)));
        }
        let seen = self.state();
        let is_missing = |variable: &StateVariable| match *variable {
            StateVariable::Fact(fact) => seen.holds(fact) != state.holds(fact),
            StateVariable::Number(fluent) => seen.number(fluent) != state.number(fluent),
        };
        let mut missing: Vec<usize> = last
            .iter()
            .filter(|(own, _)| is_missing(own))
            .map(|(_, index)| *index)
            .collect();
        missing.sort_unstable();
        missing.dedup();
        missing
    }

    /// Returns the rest of the plan as the draft of a change: with the last steps if their effects are missing.
    pub(super) fn draft(&self) -> Plan {
        let (now, before) = (self.cursor.rest(), self.checkpoint.rest());
        let missing = !self.without_effect().is_empty();
        let rest = if missing { before.or(now) } else { now };
        rest.map(|rest| rest.plan).unwrap_or_default()
    }

    /// Returns true if a step is left out that had its own effects: that nothing else leads to the goal proves no more than a limit
    /// does.
    pub(super) fn leaves_out_what_worked(&self) -> bool {
        self.forbidden.iter().any(|(_, why)| why == IN_VAIN)
    }

    /// Stops because no plan was found, with the steps that the robot cannot do.
    pub(super) fn no_plan(&mut self, stop: impl FnOnce(Vec<String>) -> Stop) {
        let failed = self.forbidden.iter().map(|(step, why)| {
            let call = super::written::written_step(&self.world, step.action, &step.arguments);
            format!("`{call}` cannot be done ({why})")
        });
        let stop = stop(failed.collect());
        self.end(stop);
    }
}

/// Returns the rest as a verified plan if it is one.
fn valid(here: &World, rest: Rest, purpose: &Purpose, left: &mut usize) -> Option<VerifiedPlan> {
    // Most rests fail at their first step, which is cheap to see.
    if rest.plan.is_sequence()
        && let Some(step) = rest.plan.steps().first()
    {
        let moment = Moment {
            world: here,
            state: &here.state,
        };
        let action = here.domain().action(step.action);
        if !holds(moment, &action.precondition, &mut step.arguments.clone()) {
            return None;
        }
    }
    *left = left.checked_sub(1)?;
    check(here, rest.plan, purpose).into_verified().ok()
}

fn calls(world: &World, plan: &Plan, steps: std::ops::Range<usize>) -> Vec<String> {
    let steps = plan.steps()[steps].iter();
    steps
        .map(|step| super::written::written_step(world, step.action, &step.arguments))
        .collect()
}
