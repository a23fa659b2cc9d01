//! Which goals make sense in the state at hand.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Goal, GoalFact, Spoken};
use crate::effort;
use crate::environment::{Bindings, EntityId, Fact, Moment, State, World, holds};
use crate::model::{Domain, GoalWord, GoalWordId, base_name};
use crate::search::{self, Limits, Outcome};
use crate::verify;

/// Words that lead to where something goes, and to where it comes from.
const TOWARDS: &str = "on onto in into inside to atop upon at under by beside";
const FROM: &str = "from off out";

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
/// What the instruction speaks of narrows this. Where something fits that it speaks of, nothing else is
/// offered in its place: who says "table" does not mean the floor. A further goal has to be about something
/// that it speaks of, and be asked for by one of its words where the domain says which words those are.
pub fn offers(domain: &Domain, world: &World, said: &[GoalFact], spoken: &Spoken) -> Vec<Offer> {
    offers_on(domain, world, said, spoken, !said.is_empty())
}

/// The same; a `further` goal need not come after `said`: what is wanted in the other case comes after nothing.
pub(crate) fn offers_on(
    domain: &Domain,
    world: &World,
    said: &[GoalFact],
    spoken: &Spoken,
    further: bool,
) -> Vec<Offer> {
    let known = world.known();
    let held = settled_words(domain, world, said, spoken);
    let mut offers = Vec::new();
    let mut left: Option<State> = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        if further && !spoken.entities.is_empty() && !word.cues.is_empty() && !spoken.has_any(&word.cues) {
            continue;
        }
        let mut arguments = Vec::new();
        // What is known to make sense; only if nothing is, what might.
        for state in [&known, &world.state] {
            if arguments.is_empty() {
                let mut bindings = Vec::with_capacity(word.parameters.len());
                collect(
                    domain,
                    Moment { world, state },
                    word,
                    said,
                    &mut bindings,
                    &mut arguments,
                );
            }
        }
        // "Take the milk out and close the fridge": it is closed, and will not be.
        if further && spoken.has_any(&word.cues) {
            let undone = settled(domain, world, word, said, spoken)
                .into_iter()
                .filter(|bindings| {
                    let after = left.get_or_insert_with(|| state_after(domain, world, said));
                    let moment = Moment { world, state: after };
                    !holds(moment, &word.condition, &mut bindings.clone())
                        && !said.iter().any(|fact| excludes(domain, fact, word, bindings))
                });
            arguments.extend(undone);
        }
        arguments.retain(|bindings| !doubles(world, spoken, bindings));
        if let Some(held) = held.iter().find(|held| held.word == word.word) {
            let spoken_of = |bindings: &Vec<EntityId>| bindings.iter().all(|e| spoken.entities.contains(e));
            arguments.retain(|bindings| spoken_of(bindings) && !held.arguments.contains(bindings));
        }
        if !spoken.entities.is_empty() {
            // A phrase decides between forms of a word; for a word with one form it only narrows.
            let only_form = domain.goal_words.iter().filter(|other| other.word == word.word).count() == 1;
            let phrases = Phrases::of(world, word, spoken);
            let phrased = |bindings: &Vec<EntityId>| phrases.fit(bindings);
            if !only_form || arguments.iter().any(phrased) {
                arguments.retain(phrased);
            }
        }
        narrow(domain, world, spoken, word.parameters.len(), &mut arguments);
        if further && !spoken.entities.is_empty() {
            arguments.retain(|bindings| may_follow(domain, world, word, said, spoken, bindings));
        }
        if !arguments.is_empty() {
            offers.push(Offer {
                word: GoalWordId::new(index),
                arguments,
            });
        }
    }
    let mut offers = likely(domain, spoken, offers);
    // Of what comes later, the word may have been for something else: "wipe it, and leave the sponge on the table".
    if !further {
        offers = named_for_the_same(domain, world, spoken, offers);
    }
    // Everything asked for holds already: nothing else is to be made of it.
    let asked = |offer: &Offer| spoken.has_any(&domain.goal_word(offer.word).destination_verbs) && fits(offer, spoken);
    if !held.is_empty() && !further && !is_plain(domain, &offers, spoken) && !offers.iter().any(asked) {
        return Vec::new();
    }
    offers
}

/// The state that a plan for the goals leaves; the present one if none is found, or if it depends on sensing.
fn state_after(domain: &Domain, world: &World, said: &[GoalFact]) -> State {
    let goal = Goal { facts: said.to_vec() };
    let mut state = world.state.clone();
    if goal.depends_on_sensing(domain) {
        return state;
    }
    if let Outcome::Solved { plan, .. } = search::solve(domain, world, &goal.wanted(domain), &Limits::default()) {
        for step in plan.steps() {
            verify::apply(world, &mut state, domain.action(step.action), &step.arguments);
        }
    }
    state
}

/// Whether the instruction asks, with a word that the domain knows for it, for something whose things it all
/// names: then there is nothing to ask back.
pub(crate) fn is_plain(domain: &Domain, offers: &[Offer], spoken: &Spoken) -> bool {
    offers
        .iter()
        .any(|offer| spoken.has_any(&domain.goal_word(offer.word).cues) && fits(offer, spoken))
}

/// Whether the instruction speaks of everything that one of the offered goals needs.
fn fits(offer: &Offer, spoken: &Spoken) -> bool {
    let spoken_of = |bindings: &Vec<EntityId>| bindings.iter().all(|entity| spoken.entities.contains(entity));
    offer.arguments.iter().any(spoken_of)
}

/// Whether two of the arguments are of one kind, of which the instruction mentions one: "the plate" is not both
/// what is put and what it is put on.
fn doubles(world: &World, spoken: &Spoken, bindings: &[EntityId]) -> bool {
    let kind = |entity: EntityId| base_name(&world.entity(entity).identifier);
    bindings.iter().enumerate().any(|(place, entity)| {
        spoken.entities.contains(entity)
            && bindings[..place].iter().any(|other| kind(*other) == kind(*entity))
            && !spoken.several(&world.entity(*entity).names)
    })
}

/// The entities that the instruction names with one of a word's phrases, by parameter.
struct Phrases(Vec<(usize, FxHashSet<EntityId>)>);

impl Phrases {
    fn of(world: &World, word: &GoalWord, spoken: &Spoken) -> Self {
        let said = |(before, parameter): &(String, usize)| {
            let all = world.of_kind(word.parameters[*parameter].kind).iter().copied();
            (
                *parameter,
                all.filter(|entity| spoken.has_phrase(world, before, *entity)).collect(),
            )
        };
        Self(word.phrases.iter().map(said).collect())
    }

    /// Returns whether the instruction uses one of the phrases with these arguments, if there are any.
    fn fit(&self, bindings: &[EntityId]) -> bool {
        self.0.is_empty()
            || self
                .0
                .iter()
                .any(|(parameter, said)| said.contains(&bindings[*parameter]))
    }
}

/// A word and what it holds of already, as the instruction asks.
struct Settled<'a> {
    word: &'a str,
    id: GoalWordId,
    arguments: Vec<Vec<EntityId>>,
}

/// The words that say where something should end, where it is there already.
fn settled_words<'a>(domain: &'a Domain, world: &World, said: &[GoalFact], spoken: &Spoken) -> Vec<Settled<'a>> {
    let words = domain.goal_words.iter().enumerate();
    let asked = words.filter(|(_, word)| spoken.has_any(&word.destination_verbs));
    asked
        .map(|(index, word)| Settled {
            word: &word.word,
            id: GoalWordId::new(index),
            arguments: settled(domain, world, word, said, spoken),
        })
        .filter(|settled| !settled.arguments.is_empty())
        .collect()
}

/// What the instruction asks for, with words that the domain knows for it, and what holds already.
pub(crate) fn already(domain: &Domain, world: &World, spoken: &Spoken) -> Vec<GoalFact> {
    let mut all = settled_words(domain, world, &[], spoken);
    for (index, word) in domain
        .goal_words
        .iter()
        .enumerate()
        .filter(|(_, word)| spoken.has_any(&word.cues))
    {
        all.push(Settled {
            word: &word.word,
            id: GoalWordId::new(index),
            arguments: settled(domain, world, word, &[], spoken),
        });
    }
    let fact = |id: GoalWordId| move |arguments| GoalFact::Word { word: id, arguments };
    all.into_iter()
        .flat_map(|settled| settled.arguments.into_iter().map(fact(settled.id)))
        .collect()
}

/// The arguments, all spoken of, for which a word makes sense and holds already.
fn settled(domain: &Domain, world: &World, word: &GoalWord, said: &[GoalFact], spoken: &Spoken) -> Vec<Vec<EntityId>> {
    let moment = Moment {
        world,
        state: &world.state,
    };
    let phrases = Phrases::of(world, word, spoken);
    let fits = |bindings: &Vec<EntityId>| {
        let bindings = &mut bindings.clone();
        let disturbed = bindings
            .iter()
            .any(|e| said.iter().any(|fact| disturbs(domain, fact, *e)));
        !disturbed
            && phrases.fit(bindings)
            && holds(moment, &word.offered, bindings)
            && holds(moment, &word.condition, bindings)
    };
    let mut all: Vec<Vec<EntityId>> = vec![Vec::new()];
    for parameter in &word.parameters {
        let of_kind = world.of_kind(parameter.kind);
        let candidates: Vec<EntityId> = of_kind
            .iter()
            .copied()
            .filter(|e| spoken.entities.contains(e))
            .collect();
        let longer = |bindings: &Vec<EntityId>| {
            candidates
                .iter()
                .map(|entity| [&bindings[..], &[*entity]].concat())
                .collect::<Vec<_>>()
        };
        all = all.iter().flat_map(longer).collect();
    }
    all.retain(fits);
    all
}

/// Of two wishes about the same things, the one that the instruction has a word for: "give the bench a scrub with the
/// brush" does not put the brush on it. A word that is a part of a thing's name is none: "the frying pan".
fn named_for_the_same(domain: &Domain, world: &World, spoken: &Spoken, mut offers: Vec<Offer>) -> Vec<Offer> {
    let sorted = |bindings: &Vec<EntityId>| {
        let mut things = bindings.clone();
        things.sort_unstable();
        things
    };
    let says = |offer: &&Offer| spoken.says(world, &domain.goal_word(offer.word).cues);
    let named: FxHashSet<Vec<EntityId>> = offers
        .iter()
        .filter(says)
        .flat_map(|offer| offer.arguments.iter().map(sorted))
        .filter(|things| things.len() > 1)
        .collect();
    for offer in offers
        .iter_mut()
        .filter(|offer| domain.goal_word(offer.word).cues.is_empty())
    {
        offer.arguments.retain(|bindings| !named.contains(&sorted(bindings)));
    }
    offers.retain(|offer| !offer.arguments.is_empty());
    offers
}

/// Leaves out readings that others beat.
fn likely(domain: &Domain, spoken: &Spoken, mut offers: Vec<Offer>) -> Vec<Offer> {
    let word = |offer: &Offer| domain.goal_word(offer.word);
    // Two forms of one word are two readings of one wish. One that the instruction uses a phrase of wins for
    // the same things, also if it says more of them, and so does one of which everything is spoken of.
    if !spoken.entities.is_empty() {
        let phrased: Vec<Offer> = offers
            .iter()
            .filter(|offer| !word(offer).phrases.is_empty())
            .cloned()
            .collect();
        for offer in offers.iter_mut().filter(|offer| word(offer).phrases.is_empty()) {
            let same = phrased
                .iter()
                .filter(|other| word(other).word == domain.goal_word(offer.word).word);
            let more = same.flat_map(|other| &other.arguments);
            let beginnings: FxHashSet<&[EntityId]> = more
                .flat_map(|more| (0..=more.len()).map(|length| &more[..length]))
                .collect();
            offer
                .arguments
                .retain(|bindings| !beginnings.contains(bindings.as_slice()));
        }
        offers.retain(|offer| !offer.arguments.is_empty());
    }
    let fitting: Vec<GoalWordId> = offers
        .iter()
        .filter(|offer| fits(offer, spoken))
        .map(|o| o.word)
        .collect();
    let same_word = |offer: &Offer| fitting.iter().any(|id| domain.goal_word(*id).word == word(offer).word);
    offers.retain(|offer| fitting.contains(&offer.word) || !same_word(offer));
    // What is only meant where nothing else is: it yields to what it names, and to whatever the instruction has a word for.
    let yields = |offer: &Offer| {
        let weak = !word(offer).yields_to.is_empty() && !spoken.has_any(&word(offer).cues);
        let names = |id: &GoalWordId| word(offer).yields_to.contains(&domain.goal_word(*id).word);
        let said = |id: &GoalWordId| *id != offer.word && spoken.has_any(&domain.goal_word(*id).cues);
        fitting.iter().any(|id| names(id) || (weak && said(id)))
    };
    offers.retain(|offer| !yields(offer));
    // A wish that the instruction names with its things ("wipe the desk with the cloth") comes before those
    // of which it leaves a part open.
    let named = |offer: &Offer| fitting.contains(&offer.word) && spoken.has_any(&word(offer).cues);
    if offers.iter().any(named) {
        offers.retain(|offer| fitting.contains(&offer.word));
    }
    offers
}

/// Whether an answer that has goals already may go on with this one.
fn may_follow(
    domain: &Domain,
    world: &World,
    word: &GoalWord,
    said: &[GoalFact],
    spoken: &Spoken,
    bindings: &[EntityId],
) -> bool {
    let Some(subject) = word.subject.map(|parameter| bindings[parameter]) else {
        return true;
    };
    let kind = |entity: EntityId| base_name(&world.entity(entity).identifier);
    said.iter().all(|fact| {
        let GoalFact::Word { word: said, arguments } = fact else {
            return true;
        };
        let said = domain.goal_word(*said);
        // Who fills the dishwasher may well want it to run: that is about something else than where things are.
        let apart = said.exclusive.is_some() && word.exclusive.is_some() && said.exclusive != word.exclusive;
        arguments.iter().enumerate().all(|(parameter, entity)| {
            let same_role = apart || said.subject == Some(parameter) || said.disturbs.contains(&parameter);
            // "The plate" is one plate; and what a thing was put on stays where it is.
            let another =
                *entity != subject && kind(*entity) == kind(subject) && !spoken.several(&world.entity(subject).names);
            !another && (*entity != subject || same_role)
        })
    }) && spoken.entities.contains(&subject)
}

fn narrow(domain: &Domain, world: &World, spoken: &Spoken, parameters: usize, arguments: &mut Vec<Vec<EntityId>>) {
    let meant = &spoken.entities;
    // Where it says "on the table", a plate beside it is something to carry, and "from the counter" is no place to go.
    if parameters == 2 && !meant.is_empty() {
        let second: FxHashSet<EntityId> = arguments.iter().map(|bindings| bindings[1]).collect();
        let led_to = |before: &str| -> FxHashSet<EntityId> {
            let all = second.iter().copied();
            all.filter(|entity| spoken.comes_after(world, *entity, before))
                .collect()
        };
        let (towards, from) = (led_to(TOWARDS), led_to(FROM));
        let towards = |entity: EntityId| towards.contains(&entity);
        let from = |entity: EntityId| from.contains(&entity);
        let portable = |entity: EntityId| world.is_of_kind(entity, domain.environment.object);
        if arguments.iter().any(|bindings| towards(bindings[1])) {
            arguments.retain(|bindings| towards(bindings[1]) || !(portable(bindings[1]) || from(bindings[1])));
        }
    }
    let mut keep = |fits: &dyn Fn(&Vec<EntityId>) -> bool| {
        if arguments.iter().any(fits) {
            arguments.retain(fits);
        }
    };
    for parameter in 0..parameters {
        keep(&|bindings| meant.contains(&bindings[parameter]));
    }
    // "The pan on the stove by the door" tells where the pan is: of the places that are spoken of, those that
    // a thing is at already are the last ones that it should go to.
    if parameters == 2 && !meant.is_empty() {
        let at = Relations::of(domain, world, arguments);
        let mut keep = |fits: &dyn Fn(&Vec<EntityId>) -> bool| {
            if arguments.iter().any(fits) {
                arguments.retain(fits);
            }
        };
        keep(&|b| !at.lead_to(b[0], b[1]) && !at.lead_to(b[1], b[0]));
        // "On the tray on the desk" is on the tray.
        let mut places: FxHashMap<EntityId, Vec<EntityId>> = FxHashMap::default();
        for bindings in arguments.iter().filter(|bindings| meant.contains(&bindings[1])) {
            places.entry(bindings[0]).or_default().push(bindings[1]);
        }
        arguments.retain(|b| {
            !places
                .get(&b[0])
                .is_some_and(|nearer| nearer.iter().any(|place| at.lead_to(*place, b[1])))
        });
    }
}

/// The entities to which changing facts lead from others, over any number of steps: where something is, and where that
/// is in turn.
struct Relations(FxHashMap<EntityId, FxHashSet<EntityId>>);

impl Relations {
    /// Finds where facts lead from the entities of the arguments.
    fn of(domain: &Domain, world: &World, arguments: &[Vec<EntityId>]) -> Self {
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

/// Whether achieving `fact` may move `entity`.
fn disturbs(domain: &Domain, fact: &GoalFact, entity: EntityId) -> bool {
    match fact {
        GoalFact::Word { word, arguments } => domain
            .goal_word(*word)
            .disturbs
            .iter()
            .any(|parameter| arguments[*parameter] == entity),
        GoalFact::Plain(_) => false,
        GoalFact::If(_) => fact.parts().into_iter().any(|part| disturbs(domain, part, entity)),
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
