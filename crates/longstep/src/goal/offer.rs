//! Goals that make sense in the current state.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Goal, GoalFact, Mentions};
use crate::effort;
use crate::environment::{Bindings, EntityId, Fact, Moment, State, World, holds};
use crate::model::{GoalWord, GoalWordId, TypeId};
use crate::search::{self, Limits, Outcome};
use crate::verify;
use longstep_core::model::Domain;

/// A goal word with the arguments that it is offered with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The goal word.
    pub word: GoalWordId,
    /// Argument lists, in the order of the word's parameters.
    pub arguments: Vec<Vec<EntityId>>,
}

/// Returns the goals that can follow `said`: with arguments of the right types, not true already (unless a goal of
/// `said` undoes them), one place for each object, and no repetition.
///
/// Names of entities narrow the offers. If an argument that the instruction names fits, the others are not offered:
/// "table" excludes the floor. If the goals of `said` are about named entities, so is the next one. No other word of the
/// instruction decides anything here: what it asks for is for a model to understand.
pub fn offers(world: &World, said: &[GoalFact], mentions: &Mentions) -> Vec<Offer> {
    offers_on(world, said, mentions, !said.is_empty())
}

/// Returns the offers for a first or a `further` goal. The first goal of an "otherwise" branch is not `further`,
/// although `said` is not empty.
pub(crate) fn offers_on(world: &World, said: &[GoalFact], mentions: &Mentions, further: bool) -> Vec<Offer> {
    let domain = world.domain();
    let known = world.known();
    let named = &mentions.entities;
    let names_subjects = further && names_subjects(domain, said, named);
    let mut offers = Vec::new();
    let mut passed: Option<Vec<State>> = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        let mut arguments = Vec::new();
        // Offers come from the known facts, and from the assumed ones only if that gives none.
        for state in [&known, &world.state] {
            if arguments.is_empty() {
                let mut bindings = Vec::with_capacity(word.parameters.len());
                let moment = Moment { world, state };
                collect(domain, moment, word, said, &mut bindings, &mut arguments);
            }
        }
        // "Take the milk out and close the fridge": the fridge is closed now, but not throughout the first goal. A domain whose
        // plans close it in any case is no reason to leave the wish no words.
        if further {
            let undone = settled(world, word, said, named).into_iter().filter(|bindings| {
                let passed = passed.get_or_insert_with(|| states_passed(world, said));
                let is_undone = |state: &State| {
                    let moment = Moment { world, state };
                    !holds(moment, &word.condition, &mut bindings.clone())
                };
                passed.iter().any(is_undone)
                    && !said.iter().any(|fact| excludes(domain, fact, word, bindings))
                    && !arguments.contains(bindings)
            });
            let undone: Vec<_> = undone.collect();
            arguments.extend(undone);
        }
        narrow(world, named, word, &mut arguments);
        if names_subjects {
            arguments.retain(|bindings| word.subject.is_none_or(|place| named.contains(&bindings[place])));
        }
        if !arguments.is_empty() {
            let word = GoalWordId::new(index);
            offers.push(Offer { word, arguments });
        }
    }
    without_other_forms(domain, named, &mut offers);
    offers
}

/// Returns every goal that an answer of several goals may contain, whatever holds now and whatever goals are before it; none
/// if there are more than `most`, or goals with values, which no list can hold.
pub(crate) fn possible_goals(world: &World, most: usize) -> Option<Vec<Offer>> {
    let domain = world.domain();
    let mut room = most;
    let mut offers = Vec::new();
    for (index, word) in domain.goal_words.iter().enumerate() {
        let takes_value = |kind: TypeId| domain.values.iter().any(|value| domain.types.is_a(value.kind, kind));
        if word.parameters.iter().any(|parameter| takes_value(parameter.kind)) {
            return None;
        }
        let mut arguments = Vec::new();
        let fits = add_possible(world, word, room, &mut Vec::new(), &mut arguments);
        room = room.checked_sub(arguments.len()).filter(|_| fits)?;
        if !arguments.is_empty() {
            let word = GoalWordId::new(index);
            offers.push(Offer { word, arguments });
        }
    }
    Some(offers)
}

/// Adds the argument lists that begin with `bindings` and for which the word makes sense in some state. Returns false if there
/// are more than `most`.
fn add_possible(
    world: &World,
    word: &GoalWord,
    most: usize,
    bindings: &mut Bindings,
    arguments: &mut Vec<Vec<EntityId>>,
) -> bool {
    let Some(parameter) = word.parameters.get(bindings.len()) else {
        if verify::possibly(world, &word.offered, bindings) {
            arguments.push(bindings.clone());
        }
        return arguments.len() <= most;
    };
    world.of_kind(parameter.kind).iter().all(|entity| {
        if bindings.contains(entity) {
            return true;
        }
        bindings.push(*entity);
        let fits = effort::spend(1) && add_possible(world, word, most, bindings, arguments);
        bindings.pop();
        fits
    })
}

/// Removes the forms of a goal word that have an argument which the instruction does not name, if another form of the word
/// has none: "put the apple on the shelf" is not about the top of the oven.
fn without_other_forms(domain: &Domain, named: &[EntityId], offers: &mut Vec<Offer>) {
    let word = |offer: &Offer| domain.goal_word(offer.word).word.as_str();
    let is_named = |arguments: &Vec<EntityId>| arguments.iter().all(|entity| named.contains(entity));
    let is_whole = |offer: &&Offer| offer.arguments.iter().any(is_named);
    let whole: FxHashSet<String> = offers
        .iter()
        .filter(is_whole)
        .map(|offer| word(offer).to_owned())
        .collect();
    offers.retain(|offer| is_whole(&offer) || !whole.contains(word(offer)));
}

/// Returns true if all goals are about named entities. The names of the environment are those of the instruction then.
fn names_subjects(domain: &Domain, said: &[GoalFact], named: &[EntityId]) -> bool {
    let is_named = |fact: &GoalFact| fact.subject(domain).is_none_or(|subject| named.contains(&subject));
    !named.is_empty() && said.iter().all(is_named)
}

/// Returns the states that a plan for the goals passes through; none if search finds no plan or a goal depends on sensing.
fn states_passed(world: &World, said: &[GoalFact]) -> Vec<State> {
    let domain = world.domain();
    let goal = Goal::from(said.to_vec());
    let mut passed = Vec::new();
    if goal.depends_on_sensing(domain) {
        return passed;
    }
    if let Outcome::Solved { plan, .. } = search::solve(world, &goal.purpose(world), &Limits::default()) {
        let mut state = world.state.clone();
        for step in plan.steps() {
            verify::apply(world, &mut state, domain.action(step.action), &step.arguments);
            passed.push(state.clone());
        }
    }
    passed
}

/// Returns the goals that hold already and are about one thing that the instruction names. A person may want something to stay
/// as it is, or not know how it is. Of two things that are named, one is mostly the place where the other is.
pub(crate) fn settled_offers(world: &World, mentions: &Mentions) -> Vec<Offer> {
    let named = &mentions.entities;
    let words = world.domain().goal_words.iter().enumerate();
    let mut offers: Vec<Offer> = words
        .filter(|(_, word)| word.parameters.len() == 1)
        .map(|(index, word)| Offer {
            word: GoalWordId::new(index),
            arguments: settled(world, word, &[], named),
        })
        .collect();
    offers.retain(|offer| !offer.arguments.is_empty());
    offers
}

/// Returns true if a goal holds already. Only goals in goal words are offered, so no others do.
pub(crate) fn is_settled(world: &World, fact: &GoalFact) -> bool {
    let GoalFact::Word { word, arguments } = fact else {
        return false;
    };
    let moment = Moment {
        world,
        state: &world.state,
    };
    let condition = &world.domain().goal_word(*word).condition;
    holds(moment, condition, &mut arguments.to_vec())
}

/// Returns the argument lists of named entities for which a word is offered and holds already.
fn settled(world: &World, word: &GoalWord, said: &[GoalFact], named: &[EntityId]) -> Vec<Vec<EntityId>> {
    let moment = Moment {
        world,
        state: &world.state,
    };
    let fits = |bindings: &Vec<EntityId>| {
        let bindings = &mut bindings.clone();
        let is_disturbed = bindings
            .iter()
            .any(|entity| said.iter().any(|fact| disturbs(world.domain(), fact, *entity)));
        !is_disturbed && holds(moment, &word.offered, bindings) && holds(moment, &word.condition, bindings)
    };
    let mut all: Vec<Vec<EntityId>> = vec![Vec::new()];
    for parameter in &word.parameters {
        let of_kind = world.of_kind(parameter.kind).iter().copied();
        let candidates: Vec<EntityId> = of_kind.filter(|entity| named.contains(entity)).collect();
        effort::spend(1 + all.len() * candidates.len());
        let longer = |bindings: &Vec<EntityId>| {
            let longer = candidates.iter().map(|entity| [&bindings[..], &[*entity]].concat());
            longer.collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.retain(fits);
    all
}

/// Keeps the arguments that the instruction names, for each parameter where there are any. Of named places, those where
/// an object is already are the last choice as its destination: "the pan on the stove by the door" says where it is.
/// A goal that moves a thing on the way ("wipe the counter with the cloth") does not say where it ends.
fn narrow(world: &World, named: &[EntityId], word: &GoalWord, arguments: &mut Vec<Vec<EntityId>>) {
    if named.is_empty() {
        return;
    }
    for parameter in 0..word.parameters.len() {
        keep(arguments, |bindings| named.contains(&bindings[parameter]));
    }
    if word.parameters.len() == 2 && word.disturbs.is_empty() {
        let at = Relations::of(world, arguments);
        keep(arguments, |b| !at.lead_to(b[0], b[1]) && !at.lead_to(b[1], b[0]));
        // "On the tray on the desk" means the tray.
        let mut places: FxHashMap<EntityId, Vec<EntityId>> = FxHashMap::default();
        for bindings in arguments.iter().filter(|bindings| named.contains(&bindings[1])) {
            places.entry(bindings[0]).or_default().push(bindings[1]);
        }
        arguments.retain(|b| {
            let nearer = places.get(&b[0]).into_iter().flatten();
            !nearer.into_iter().any(|place| at.lead_to(*place, b[1]))
        });
    }
}

/// Keeps the arguments that fit, if any do.
fn keep(arguments: &mut Vec<Vec<EntityId>>, fits: impl Fn(&Vec<EntityId>) -> bool) {
    if arguments.iter().any(&fits) {
        arguments.retain(fits);
    }
}

/// Transitive closure of the changing binary facts, by entity: its place, the place of that place, and so on.
struct Relations(FxHashMap<EntityId, FxHashSet<EntityId>>);

impl Relations {
    /// Computes the closure for the entities of the arguments.
    fn of(world: &World, arguments: &[Vec<EntityId>]) -> Self {
        let domain = world.domain();
        let binary = |fact: &Fact| {
            domain.words(fact.predicate()).fluent && domain.predicate(fact.predicate()).parameters.len() == 2
        };
        let mut next: FxHashMap<EntityId, Vec<EntityId>> = FxHashMap::default();
        for fact in world.state.iter().filter(binary) {
            next.entry(fact.argument(0)).or_default().push(fact.argument(1));
        }
        let mut reached: FxHashMap<EntityId, FxHashSet<EntityId>> = FxHashMap::default();
        for entity in arguments.iter().flatten() {
            reached.entry(*entity).or_insert_with(|| reachable(&next, *entity));
        }
        Self(reached)
    }

    fn lead_to(&self, from: EntityId, to: EntityId) -> bool {
        self.0.get(&from).is_some_and(|reached| reached.contains(&to))
    }
}

fn reachable(next: &FxHashMap<EntityId, Vec<EntityId>>, from: EntityId) -> FxHashSet<EntityId> {
    let mut found = FxHashSet::default();
    let mut open = vec![from];
    while let Some(entity) = open.pop() {
        let others = next.get(&entity).map_or(&[][..], Vec::as_slice);
        effort::spend(1 + others.len());
        open.extend(others.iter().copied().filter(|other| found.insert(*other)));
    }
    found
}

fn collect(
    domain: &Domain,
    moment: Moment<'_>,
    word: &GoalWord,
    said: &[GoalFact],
    bindings: &mut Bindings,
    arguments: &mut Vec<Vec<EntityId>>,
) {
    if let Some(parameter) = word.parameters.get(bindings.len()) {
        for entity in moment.world.of_kind(parameter.kind) {
            if !effort::spend(1) {
                return;
            }
            bindings.push(*entity);
            collect(domain, moment, word, said, bindings, arguments);
            bindings.pop();
        }
        return;
    }
    let disturbed = |bindings: &Bindings| {
        bindings
            .iter()
            .any(|entity| said.iter().any(|fact| disturbs(domain, fact, *entity)))
    };
    let distinct = (1..bindings.len()).all(|at| !bindings[..at].contains(&bindings[at]));
    if distinct
        && holds(moment, &word.offered, bindings)
        && !said.iter().any(|fact| excludes(domain, fact, word, bindings))
        && (!holds(moment, &word.condition, bindings) || disturbed(bindings))
    {
        arguments.push(bindings.clone());
    }
}

/// Returns true if achieving `fact` may move `entity`.
fn disturbs(domain: &Domain, fact: &GoalFact, entity: EntityId) -> bool {
    match fact {
        GoalFact::Word { word, arguments } => domain
            .goal_word(*word)
            .disturbs
            .iter()
            .any(|parameter| arguments[*parameter] == entity),
        GoalFact::Plain(_) | GoalFact::Number(_) => false,
        GoalFact::If(_) => fact.parts().into_iter().any(|part| disturbs(domain, part, entity)),
        GoalFact::Choice(choice) => choice.alternatives().any(|part| disturbs(domain, part, entity)),
    }
}

/// Returns true if `fact` excludes the goal: it is equal, or both are in one exclusive group with the same first
/// argument.
fn excludes(domain: &Domain, fact: &GoalFact, word: &GoalWord, bindings: &[EntityId]) -> bool {
    let GoalFact::Word { word: said, arguments } = fact else {
        return false;
    };
    let said = domain.goal_word(*said);
    let same_mark = said.exclusive.is_some() && said.exclusive == word.exclusive;
    (same_mark && arguments.first() == bindings.first())
        || (said.form == word.form && said.word == word.word && arguments == bindings)
}
