//! A small evaluator of prohibitions over the states and steps of a plan, in words of the PDDL domain.

use std::collections::BTreeSet;

use longstep::{VerifiedPlan, World};
use longstep_core::model::Fact;
use serde::Deserialize;

/// A pattern to look for in a plan. Facts and calls are words with blanks between them: `in <tube_a> <rack_a>`.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "lowercase")]
pub(crate) enum Watch {
    /// The fact holds in no state.
    Never(String),
    /// The fact holds in every state.
    Always(String),
    /// No step is this action with these arguments; `_` stands for any.
    Call(String),
    /// No step has this entity as an argument, and no fact about it changes.
    Untouched(String),
}

impl Watch {
    /// The first step at which a plan breaks the prohibition, on any of its ways.
    pub(crate) fn broken_by(&self, world: &World, plan: &VerifiedPlan) -> Option<String> {
        let domain = world.domain();
        for ending in plan.endings() {
            let mut state: BTreeSet<String> = world.state.iter().map(|fact| words(world, fact)).collect();
            for (id, changes) in ending.trace.steps() {
                let step = plan.plan().step(id);
                let arguments = step
                    .arguments
                    .iter()
                    .map(|entity| world.entity(*entity).identifier.clone());
                let arguments: Vec<String> = arguments.collect();
                let call = format!("{} {}", domain.action(step.action).name, arguments.join(" "));
                let mut changed = Vec::new();
                for change in changes {
                    let fact = words(world, change.fact);
                    if change.holds {
                        state.insert(fact.clone())
                    } else {
                        state.remove(&fact)
                    };
                    changed.push(fact);
                }
                let broken = match self {
                    Self::Never(fact) => state.contains(fact),
                    Self::Always(fact) => !state.contains(fact),
                    Self::Call(pattern) => fits(pattern, &call),
                    Self::Untouched(entity) => {
                        arguments.contains(entity)
                            || changed
                                .iter()
                                .any(|fact| fact.split(' ').nth(1) == Some(entity.as_str()))
                    }
                };
                if broken {
                    return Some(call);
                }
            }
        }
        None
    }
}

fn words(world: &World, fact: Fact) -> String {
    let predicate = &world.domain().predicates[fact.predicate().index()];
    let arguments = (0..predicate.parameters.len()).map(|place| world.entity(fact.argument(place)).identifier.clone());
    [predicate.name.clone()]
        .into_iter()
        .chain(arguments)
        .collect::<Vec<_>>()
        .join(" ")
}

fn fits(pattern: &str, call: &str) -> bool {
    let (pattern, call): (Vec<&str>, Vec<&str>) = (pattern.split(' ').collect(), call.split(' ').collect());
    let same = |(own, other): (&&str, &&str)| *own == "_" || own == other;
    pattern.len() == call.len() && pattern.iter().zip(&call).all(same)
}
