//! Sensing calls that a composition can contain, and the conditions that follow them.

use crate::environment::{Entity, EntityId, Fact, World};
use crate::model::{Action, Term};
use crate::plan::WrittenStep;
use longstep_core::model::state_word;

/// Returns the parameters of a sensing call in a composition: the explicit ones of the action, then those that its
/// outcomes mention.
///
/// In a plan, the previous steps determine the parameters that a call hides. A composition has no such steps, so its
/// calls name them.
pub(super) fn sensing_parameters(action: &Action) -> Vec<usize> {
    let mut all = action.explicit.clone();
    for term in action.senses.iter().flat_map(|outcome| &outcome.terms) {
        if let Term::Variable(parameter) = term
            && !all.contains(parameter)
        {
            all.push(*parameter);
        }
    }
    all
}

/// Replaces everyday names by identifiers and attaches hidden parameters under their names.
pub(super) fn spelled_out(world: &World, step: &WrittenStep) -> WrittenStep {
    let mut step = step.clone();
    for argument in &mut step.call.arguments {
        if world.find(argument).is_none()
            && let Some(entity) = world.find_name(argument)
        {
            argument.clone_from(&world.entity(entity).identifier);
        }
    }
    let named = |action: &&Action| action.call == step.call.name && !action.senses.is_empty();
    let Some(action) = world.domain().actions.iter().find(named) else {
        return step;
    };
    let (parameters, shown) = (sensing_parameters(action), action.explicit.len());
    if step.call.arguments.len() == parameters.len() && parameters.len() > shown {
        let hidden = step
            .call
            .arguments
            .split_off(shown)
            .into_iter()
            .zip(&parameters[shown..]);
        let by_name = hidden.map(|(argument, parameter)| (action.parameters[*parameter].name.clone(), argument));
        step.implicit.extend(by_name);
    }
    step
}

/// A sensing call with its arguments, and the conditions that can be tested after it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Check {
    /// Name of the action's call.
    pub(super) call: String,
    /// Arguments, by the names that the model sees.
    pub(super) things: Vec<String>,
    /// For each outcome, the state word and its arguments. Empty if the environment has no word for one of the
    /// outcomes; the condition is then the call itself.
    pub(super) outcomes: Vec<(String, Vec<String>)>,
    /// For each outcome, its description.
    pub(super) says: Vec<String>,
}

/// Returns every sensing call with an outcome that satisfies `worth`, in the order of the domain and the world.
pub(super) fn checks(world: &World, worth: impl Fn(Fact) -> bool) -> Vec<Check> {
    let mut all = Vec::new();
    for action in world.domain().actions.iter().filter(|action| !action.senses.is_empty()) {
        let mut choices: Vec<Vec<(usize, EntityId)>> = vec![Vec::new()];
        for parameter in sensing_parameters(action) {
            let longer = |given: &Vec<(usize, EntityId)>| {
                let fitting = world.of_kind(action.parameters[parameter].kind).iter();
                fitting
                    .map(|entity| [&given[..], &[(parameter, *entity)]].concat())
                    .collect::<Vec<_>>()
            };
            choices = choices.iter().flat_map(longer).collect();
        }
        choices.retain(|given| {
            let mut outcomes = action.senses.iter();
            outcomes.any(|outcome| {
                let terms = outcome.terms.iter().map(|term| about(term, given));
                let entities = terms.collect::<Option<Vec<EntityId>>>();
                entities.is_some_and(|entities| worth(Fact::new(outcome.predicate, entities)))
            })
        });
        all.extend(choices.iter().map(|given| check(world, action, given)));
    }
    all
}

/// Resolves a term of an outcome to an entity, given the arguments of the call.
fn about(term: &Term, given: &[(usize, EntityId)]) -> Option<EntityId> {
    match term {
        Term::Variable(slot) => given
            .iter()
            .find(|(parameter, _)| parameter == slot)
            .map(|(_, entity)| *entity),
        Term::Constant(entity) => Some(*entity),
    }
}

fn check(world: &World, action: &Action, given: &[(usize, EntityId)]) -> Check {
    let domain = world.domain();
    let entity = |term: &Term| about(term, given);
    let outcomes = action.senses.iter().map(|outcome| {
        let word = state_word(domain, outcome.predicate)?;
        // The entity of the environment entry comes first.
        let things = word
            .places()
            .map(|place| Some(called(world.entity(entity(&outcome.terms[place?])?))));
        Some((word.word.clone(), things.collect::<Option<Vec<_>>>()?))
    });
    let says = action.senses.iter().map(|outcome| {
        let name = |place: usize| entity(&outcome.terms[place]).map_or(String::new(), |id| world.with_article(id));
        domain.words(outcome.predicate).says.fill(name)
    });
    Check {
        call: action.call.clone(),
        things: given.iter().map(|(_, id)| called(world.entity(*id))).collect(),
        outcomes: outcomes.collect::<Option<Vec<_>>>().unwrap_or_default(),
        says: says.collect(),
    }
}

/// Returns the name by which the model sees an entity: its everyday name if both notations can contain it, else its
/// identifier.
pub(super) fn called(entity: &Entity) -> String {
    let plain = |c: char| c.is_alphanumeric() || matches!(c, ' ' | '-' | '_' | '\'');
    if entity.name.chars().all(plain) {
        entity.name.clone()
    } else {
        entity.identifier.clone()
    }
}
