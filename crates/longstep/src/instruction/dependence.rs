//! Conditions on which goals may depend: the outcomes of sensing actions.

use longstep_core::model::state_word;

use crate::effort;
use crate::environment::{Fact, World};

/// A condition on which a goal may depend.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Dependence {
    /// The fact.
    pub(crate) fact: Fact,
    /// True if the goal depends on the absence of the fact.
    pub(crate) negated: bool,
}

/// Returns the conditions on which a goal can depend: the outcomes of sensing actions, and that they are not so.
pub(crate) fn conditions(world: &World) -> Vec<Dependence> {
    let domain = world.domain();
    let mut found = Vec::new();
    for action in &domain.actions {
        for atom in &action.senses {
            let [parameter] = &domain.predicate(atom.predicate).parameters[..] else {
                continue;
            };
            if state_word(domain, atom.predicate).is_none() {
                continue;
            }
            for entity in world.of_kind(parameter.kind) {
                if !effort::spend(1) {
                    return found;
                }
                let fact = Fact::new(atom.predicate, [*entity]);
                found.extend([false, true].map(|negated| Dependence { fact, negated }));
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::domain;

    use longstep_core::testing;

    #[test]
    fn goals_depend_on_what_can_be_sensed() {
        for (domain, expected) in [
            (
                "household-checks",
                "fresh(milk) not fresh(milk) expired(milk) not expired(milk) full(milk) not full(milk) half_full(milk) not half_full(milk) empty(milk) not empty(milk) intact(milk) not intact(milk) broken(milk) not broken(milk) clean(fridge) not clean(fridge) clean(milk) not clean(milk) dirty(fridge) not dirty(fridge) dirty(milk) not dirty(milk)",
            ),
            ("household", ""),
        ] {
            let domain = domain::shipped(domain).unwrap().unwrap();
            let text = r#"{"assets": ["<fridge>"], "objects": ["<milk>"]}"#;
            let world = testing::world_of(&domain, text);
            let found = conditions(&world);
            let shown = found.iter().map(|depends| {
                let text = crate::goal::GoalFact::Plain(depends.fact).everyday(&world);
                if depends.negated { format!("not {text}") } else { text }
            });
            assert_eq!(shown.collect::<Vec<_>>().join(" "), expected, "{}", domain.name);
        }
    }
}
