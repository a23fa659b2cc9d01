//! The facts and numbers that the truth of a condition rests on.

use super::condition::Slot;
use super::{Bindings, Condition, Fact, Fluent, Moment, State, Term, Voice, When, World, ground, holds};
use crate::effort;

/// A fact or a number of a state.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub enum StateVariable {
    /// A fact, which holds or does not hold.
    Fact(Fact),
    /// A number.
    Number(Fluent),
}

impl StateVariable {
    /// Writes the value of the variable in a state as a sentence for a person.
    pub fn sentence(self, world: &World, state: &State) -> String {
        match self {
            Self::Fact(fact) => Voice::Person.fact(world, fact, state.holds(fact)),
            Self::Number(fluent) => {
                let name = Voice::Person.fluent(world, fluent);
                match state.number(fluent) {
                    Some(number) => format!("{name} is {}", Voice::Person.number(world, fluent, number)),
                    None => format!("{name} is not known"),
                }
            }
        }
    }
}

/// The weight of a variable as a foundation of a condition: 0 for one that is certain.
type Weight<'a> = &'a dyn Fn(StateVariable) -> u32;

/// The uncertain variables on which the truth of a condition rests, with their weight.
#[derive(Debug, Default)]
struct Support {
    variables: Vec<StateVariable>,
    weight: u32,
}

impl Support {
    fn add(&mut self, other: Self) {
        self.variables.extend(other.variables);
        self.weight = self.weight.saturating_add(other.weight);
    }

    fn rest_on(&mut self, variable: StateVariable, weight: Weight<'_>) {
        let own = weight(variable);
        if own > 0 {
            self.variables.push(variable);
            self.weight = self.weight.saturating_add(own);
        }
    }
}

/// Returns the uncertain variables on which the truth of a condition rests, sorted: those of every part of a
/// conjunction, and those of the alternative with the least weight of a disjunction. None if the condition does not hold.
///
/// If no variable in the list had another value, the condition would hold whatever the other uncertain ones are. The work
/// is bounded by the budget of the caller; the list is incomplete where that is exhausted.
pub fn support(
    moment: Moment<'_>,
    condition: &Condition,
    bindings: &mut Bindings,
    weight: Weight<'_>,
) -> Option<Vec<StateVariable>> {
    let mut variables = found(moment, condition, bindings, weight)?.variables;
    variables.sort_unstable();
    variables.dedup();
    Some(variables)
}

fn found(moment: Moment<'_>, condition: &Condition, bindings: &mut Bindings, weight: Weight<'_>) -> Option<Support> {
    let mut support = Support::default();
    match condition {
        Condition::And(parts) => {
            for part in parts.iter().filter(|_| effort::spend(1)) {
                support.add(found(moment, part, bindings, weight)?);
            }
        }
        Condition::Or(parts) => {
            let alternatives = parts.iter().filter(|_| effort::spend(1));
            return lightest(alternatives.map(|part| found(moment, part, bindings, weight)));
        }
        Condition::Forall(slot, _, inner) if is_certain_without(moment, inner, *slot, bindings, weight) => {}
        Condition::Forall(_, kind, inner) => {
            for entity in moment.world.of_kind(*kind).iter().filter(|_| effort::spend(1)) {
                bindings.push(*entity);
                let own = found(moment, inner, bindings, weight);
                bindings.pop();
                support.add(own?);
            }
        }
        Condition::Exists(_, kind, inner) => {
            let entities = moment.world.of_kind(*kind).iter().filter(|_| effort::spend(1));
            return lightest(entities.map(|entity| {
                bindings.push(*entity);
                let own = found(moment, inner, bindings, weight);
                bindings.pop();
                own
            }));
        }
        Condition::Atom { atom, at, .. } => {
            if !holds(moment, condition, bindings) {
                return None;
            }
            if *at == When::Now {
                support.rest_on(StateVariable::Fact(ground(atom, bindings)), weight);
            }
        }
        Condition::Equal { .. } => return holds(moment, condition, bindings).then_some(support),
        Condition::Number(test) => {
            if !holds(moment, condition, bindings) {
                return None;
            }
            test.for_each(&mut |application| {
                if application.at == When::Now {
                    support.rest_on(StateVariable::Number(application.ground(bindings)), weight);
                }
            });
        }
    }
    Some(support)
}

/// Returns true if a disjunction, within any quantifiers, has an alternative that holds with certainty whatever the entity in
/// the slot and in later ones: "nothing in the fridge is ..." needs no look at the entities if it is about no fridge.
fn is_certain_without(
    moment: Moment<'_>,
    condition: &Condition,
    slot: Slot,
    bindings: &mut Bindings,
    weight: Weight<'_>,
) -> bool {
    match condition {
        Condition::Forall(_, _, inner) => is_certain_without(moment, inner, slot, bindings, weight),
        Condition::Or(parts) => parts
            .iter()
            .any(|part| is_certain_without(moment, part, slot, bindings, weight)),
        Condition::Atom { atom, at, .. } => {
            let is_bound = |term: &Term| !matches!(term, Term::Variable(own) if *own >= slot);
            effort::spend(1)
                && atom.terms.iter().all(is_bound)
                && holds(moment, condition, bindings)
                && (*at != When::Now || weight(StateVariable::Fact(ground(atom, bindings))) == 0)
        }
        _ => false,
    }
}

/// Returns the first of the lightest alternatives that hold.
fn lightest(alternatives: impl Iterator<Item = Option<Support>>) -> Option<Support> {
    let mut best: Option<Support> = None;
    for own in alternatives.flatten() {
        let certain = own.weight == 0;
        if best.as_ref().is_none_or(|best| own.weight < best.weight) {
            best = Some(own);
        }
        if certain {
            break;
        }
    }
    best
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    #[test]
    fn quantifiers_are_not_enumerated_where_the_rest_is_certain() {
        let handles: Vec<String> = (0..200).map(|number| format!("<box_{number}_handle>")).collect();
        let assets: Vec<String> = (0..200).map(|number| format!("<box_{number}>")).collect();
        let objects = [handles, vec!["<cup>".to_owned()]].concat();
        let environment = serde_json::json!({"assets": assets, "objects": objects,
            "object_states": {"<cup>": "inside_something(<box_3>)", "<box_3_handle>": "open()"}});
        let world = testing::world("household", environment);
        let grasp = world
            .domain()
            .actions
            .iter()
            .find(|action| action.name == "grasp")
            .unwrap();
        let predicate = |name: &str| {
            let index = world.domain().predicates.iter().position(|own| own.name == name);
            crate::model::PredicateId::new(index.unwrap())
        };
        let id = |name: &str| world.find(name).unwrap();
        let closed = StateVariable::Fact(Fact::new(predicate("closed"), [id("<box_3_handle>")]));
        let mut state = world.state.clone();
        state.set(Fact::new(predicate("hand-at"), [id("<cup>")]), true);
        let moment = Moment {
            world: &world,
            state: &state,
        };
        let mut bindings = vec![id("<cup>")];
        // Only the handle of the box around the cup counts, however many boxes there are.
        let spent = effort::within(u64::MAX, || {
            support(moment, &grasp.precondition, &mut bindings, &|variable| {
                u32::from(variable == closed)
            })
        });
        assert_eq!(spent.result, Some(vec![closed]));
        assert!(spent.units < 20_000, "{}", spent.units);
    }
}
