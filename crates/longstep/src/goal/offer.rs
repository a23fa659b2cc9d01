//! Which goals make sense in the state at hand.

use super::GoalFact;
use crate::domain::{Domain, GoalWord, GoalWordId};
use crate::world::{Bindings, EntityId, Moment, World, holds};

/// The arguments that a goal word may be said with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The word.
    pub word: GoalWordId,
    /// Its arguments, in order.
    pub arguments: Vec<Vec<EntityId>>,
}

/// What can still be said after `said`: arguments of the right type for which the word is offered, nothing
/// that holds already unless something said disturbs it, one place for an object, nothing twice.
///
/// Where something fits that the instruction speaks of (`meant`), nothing else is offered in its place: who
/// says "table" does not mean the floor.
pub fn offers(domain: &Domain, world: &World, said: &[GoalFact], meant: &[EntityId]) -> Vec<Offer> {
    let mut offers = Vec::new();
    for (index, word) in domain.goal_words.iter().enumerate() {
        let mut arguments = Vec::new();
        let mut bindings = Vec::with_capacity(word.parameters.len());
        collect(domain, world, word, said, &mut bindings, &mut arguments);
        narrow(domain, world, meant, word.parameters.len(), &mut arguments);
        if !arguments.is_empty() {
            offers.push(Offer {
                word: GoalWordId::new(index),
                arguments,
            });
        }
    }
    // Two forms of one word are two readings of one wish; the one that fits what is spoken of wins.
    let fits = |offer: &Offer| {
        offer
            .arguments
            .iter()
            .any(|bindings| bindings.iter().all(|e| meant.contains(e)))
    };
    let fitting: Vec<&str> = offers
        .iter()
        .filter(|o| fits(o))
        .map(|o| domain.goal_word(o.word).word.as_str())
        .collect();
    offers
        .iter()
        .filter(|o| fits(o) || !fitting.contains(&domain.goal_word(o.word).word.as_str()))
        .cloned()
        .collect()
}

fn narrow(domain: &Domain, world: &World, meant: &[EntityId], parameters: usize, arguments: &mut Vec<Vec<EntityId>>) {
    let mut keep = |fits: &dyn Fn(&Vec<EntityId>) -> bool| {
        if arguments.iter().any(fits) {
            arguments.retain(fits);
        }
    };
    for parameter in 0..parameters {
        keep(&|bindings| meant.contains(&bindings[parameter]));
    }
    // "The pan on the stove" tells where the pan is: of the places that are spoken of, where a thing is
    // already is the last one that it should go to.
    let related = world.state.sorted();
    let related: Vec<_> = related
        .iter()
        .filter(|fact| {
            domain.words(fact.predicate()).fluent && domain.predicate(fact.predicate()).parameters.len() == 2
        })
        .map(|fact| (fact.argument(0), fact.argument(1)))
        .collect();
    if parameters == 2 && !meant.is_empty() {
        keep(&|b| !related.contains(&(b[0], b[1])) && !related.contains(&(b[1], b[0])));
    }
}

fn collect(
    domain: &Domain,
    world: &World,
    word: &GoalWord,
    said: &[GoalFact],
    bindings: &mut Bindings,
    arguments: &mut Vec<Vec<EntityId>>,
) {
    if let Some(parameter) = word.parameters.get(bindings.len()) {
        for entity in world.of_kind(parameter.kind) {
            bindings.push(*entity);
            collect(domain, world, word, said, bindings, arguments);
            bindings.pop();
        }
        return;
    }
    let moment = Moment {
        world,
        state: &world.state,
    };
    let distinct = (1..bindings.len()).all(|at| !bindings[..at].contains(&bindings[at]));
    let disturbed = |bindings: &Bindings| {
        bindings
            .iter()
            .any(|entity| said.iter().any(|fact| disturbs(domain, fact, *entity)))
    };
    if distinct
        && holds(moment, &word.offered, bindings)
        && !said.iter().any(|fact| excludes(domain, fact, word, bindings))
        && (!holds(moment, &word.condition, bindings) || disturbed(bindings))
    {
        arguments.push(bindings.clone());
    }
}

/// Whether achieving `fact` may move `entity`.
fn disturbs(domain: &Domain, fact: &GoalFact, entity: EntityId) -> bool {
    match fact {
        GoalFact::Word { word, arguments } => domain
            .goal_word(*word)
            .disturbs
            .iter()
            .any(|parameter| arguments[*parameter] == entity),
        GoalFact::Plain(_) => false,
    }
}

/// Whether `fact` leaves no room for another goal.
fn excludes(domain: &Domain, fact: &GoalFact, word: &GoalWord, bindings: &[EntityId]) -> bool {
    let GoalFact::Word { word: said, arguments } = fact else {
        return false;
    };
    let said = domain.goal_word(*said);
    let same_mark = said.exclusive.is_some() && said.exclusive == word.exclusive;
    (same_mark && arguments.first() == bindings.first())
        || (said.form == word.form && said.word == word.word && arguments == bindings)
}
