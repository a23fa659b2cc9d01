//! Goals that make sense in the current state.

use rustc_hash::{FxHashMap, FxHashSet};

use super::{Goal, GoalFact, Spoken};
use crate::effort;
use crate::environment::{Bindings, EntityId, Fact, Moment, State, World, holds};
use crate::model::{GoalWord, GoalWordId, stem};
use crate::search::{self, Limits, Outcome};
use crate::verify;
use longstep_core::model::Domain;

/// Prepositions before a destination and before an origin.
const TOWARDS: &str = "on onto in into inside to atop upon at under by beside";
const FROM: &str = "from off out";

/// A goal word with the arguments that it is offered with.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Offer {
    /// The goal word.
    pub word: GoalWordId,
    /// Argument lists, in the order of the word's parameters.
    pub arguments: Vec<Vec<EntityId>>,
}

/// Returns the goals that can follow `said`: with arguments of the right types, not true already (unless a goal of
/// `said` may disturb them), one place for each object, and no repetition.
///
/// The instruction narrows the offers. If an argument that it mentions fits, the others are not offered: "table"
/// excludes the floor. A further goal must have a mentioned subject, and the instruction must contain one of its cues
/// if the domain lists any.
pub fn offers(world: &World, said: &[GoalFact], spoken: &Spoken) -> Vec<Offer> {
    offers_on(world, said, spoken, !said.is_empty())
}

/// Returns the offers for a first or a `further` goal. The first goal of an "otherwise" branch is not `further`,
/// although `said` is not empty.
pub(crate) fn offers_on(world: &World, said: &[GoalFact], spoken: &Spoken, further: bool) -> Vec<Offer> {
    let domain = world.domain();
    let known = world.known();
    let held = settled_words(world, said, spoken);
    let mut offers = Vec::new();
    let mut left: Option<State> = None;
    for (index, word) in domain.goal_words.iter().enumerate() {
        if further && !spoken.entities.is_empty() && !word.cues.is_empty() && !spoken.has_any(&word.cues) {
            continue;
        }
        let mut arguments = Vec::new();
        // Offers come from the known facts, and from the assumed ones only if that gives none.
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
        // "Take the milk out and close the fridge": the fridge is closed now, but not after the first goal.
        if further && spoken.has_any(&word.cues) {
            let undone = settled(world, word, said, spoken).into_iter().filter(|bindings| {
                let after = left.get_or_insert_with(|| state_after(world, said));
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
            // A phrase decides between the forms of a word; for a word with one form it only narrows.
            let only_form = domain.goal_words.iter().filter(|other| other.word == word.word).count() == 1;
            let phrases = Phrases::of(world, word, spoken);
            let phrased = |bindings: &Vec<EntityId>| phrases.fit(bindings);
            if !only_form || arguments.iter().any(phrased) {
                arguments.retain(phrased);
            }
        }
        narrow(world, spoken, word.parameters.len(), &mut arguments);
        if further && !spoken.entities.is_empty() {
            arguments.retain(|bindings| may_follow(world, word, said, spoken, bindings));
        }
        if !arguments.is_empty() {
            offers.push(Offer {
                word: GoalWordId::new(index),
                arguments,
            });
        }
    }
    let mut offers = likely(domain, spoken, offers);
    // For a further goal, the cue may belong to an earlier one: "wipe it, and leave the sponge on the table".
    if !further {
        offers = named_for_the_same(world, spoken, offers);
    }
    // Every requested goal holds already: offer no other reading.
    let asked = |offer: &Offer| spoken.has_any(&domain.goal_word(offer.word).destination_verbs) && fits(offer, spoken);
    if !held.is_empty() && !further && !is_plain(domain, &offers, spoken) && !offers.iter().any(asked) {
        return Vec::new();
    }
    offers
}

/// Returns the state after a plan for the goals, or the current state if search finds none or a goal depends on
/// sensing.
fn state_after(world: &World, said: &[GoalFact]) -> State {
    let domain = world.domain();
    let goal = Goal::from(said.to_vec());
    let mut state = world.state.clone();
    if goal.depends_on_sensing(domain) {
        return state;
    }
    if let Outcome::Solved { plan, .. } = search::solve(world, &goal.purpose(world), &Limits::default()) {
        for step in plan.steps() {
            verify::apply(world, &mut state, domain.action(step.action), &step.arguments);
        }
    }
    state
}

/// Returns true if the instruction contains a cue of an offered goal and mentions all of its arguments. No question is
/// needed then.
pub(crate) fn is_plain(domain: &Domain, offers: &[Offer], spoken: &Spoken) -> bool {
    offers
        .iter()
        .any(|offer| spoken.has_any(&domain.goal_word(offer.word).cues) && fits(offer, spoken))
}

/// Returns true if the instruction mentions all arguments of one of the offered goals.
fn fits(offer: &Offer, spoken: &Spoken) -> bool {
    let spoken_of = |bindings: &Vec<EntityId>| bindings.iter().all(|entity| spoken.entities.contains(entity));
    offer.arguments.iter().any(spoken_of)
}

/// Returns true if two arguments are of one kind and the instruction mentions only one of that kind: "the plate" is not
/// both the object to put and its destination.
fn doubles(world: &World, spoken: &Spoken, bindings: &[EntityId]) -> bool {
    let kind = |entity: EntityId| stem(&world.entity(entity).identifier);
    bindings.iter().enumerate().any(|(place, entity)| {
        spoken.entities.contains(entity)
            && bindings[..place].iter().any(|other| kind(*other) == kind(*entity))
            && !spoken.several(&world.entity(*entity).names)
    })
}

/// For each phrase of a word: the parameter, and the entities that the instruction names with that phrase.
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

    /// Returns true if the instruction uses one of the phrases with these arguments, or if the word has no phrases.
    fn fit(&self, bindings: &[EntityId]) -> bool {
        self.0.is_empty()
            || self
                .0
                .iter()
                .any(|(parameter, said)| said.contains(&bindings[*parameter]))
    }
}

/// A goal word with the requested arguments for which it holds already.
struct Settled<'a> {
    word: &'a str,
    id: GoalWordId,
    arguments: Vec<Vec<EntityId>>,
}

/// Returns the requested goals about a destination that hold already.
fn settled_words<'a>(world: &'a World, said: &[GoalFact], spoken: &Spoken) -> Vec<Settled<'a>> {
    let words = world.domain().goal_words.iter().enumerate();
    let asked = words.filter(|(_, word)| spoken.has_any(&word.destination_verbs));
    asked
        .map(|(index, word)| Settled {
            word: &word.word,
            id: GoalWordId::new(index),
            arguments: settled(world, word, said, spoken),
        })
        .filter(|settled| !settled.arguments.is_empty())
        .collect()
}

/// Returns the goals that the instruction requests with a cue or a destination verb, and that hold already.
pub(crate) fn already(world: &World, spoken: &Spoken) -> Vec<GoalFact> {
    let mut all = settled_words(world, &[], spoken);
    for (index, word) in world
        .domain()
        .goal_words
        .iter()
        .enumerate()
        .filter(|(_, word)| spoken.has_any(&word.cues))
    {
        all.push(Settled {
            word: &word.word,
            id: GoalWordId::new(index),
            arguments: settled(world, word, &[], spoken),
        });
    }
    let fact = |id: GoalWordId| move |arguments| GoalFact::Word { word: id, arguments };
    all.into_iter()
        .flat_map(|settled| settled.arguments.into_iter().map(fact(settled.id)))
        .collect()
}

/// Returns the argument lists of mentioned entities for which a word is offered and holds already.
fn settled(world: &World, word: &GoalWord, said: &[GoalFact], spoken: &Spoken) -> Vec<Vec<EntityId>> {
    let moment = Moment {
        world,
        state: &world.state,
    };
    let phrases = Phrases::of(world, word, spoken);
    let fits = |bindings: &Vec<EntityId>| {
        let bindings = &mut bindings.clone();
        let disturbed = bindings
            .iter()
            .any(|e| said.iter().any(|fact| disturbs(world.domain(), fact, *e)));
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

/// Removes offers without cues that have the arguments of an offer whose cue the instruction contains: "give the bench
/// a scrub with the brush" does not put the brush on it. A cue inside the name of an object does not count: "the frying
/// pan".
fn named_for_the_same(world: &World, spoken: &Spoken, mut offers: Vec<Offer>) -> Vec<Offer> {
    let domain = world.domain();
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

/// Removes readings that another offer supersedes.
fn likely(domain: &Domain, spoken: &Spoken, mut offers: Vec<Offer>) -> Vec<Offer> {
    let word = |offer: &Offer| domain.goal_word(offer.word);
    // Two forms of a word are two readings of one goal. A form with a phrase from the instruction supersedes one with
    // the same or fewer arguments; so does a form whose arguments the instruction all mentions.
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
    // A word with `yields_to` gives way to those words, and, without a cue of its own, to any word with a cue.
    let yields = |offer: &Offer| {
        let weak = !word(offer).yields_to.is_empty() && !spoken.has_any(&word(offer).cues);
        let names = |id: &GoalWordId| word(offer).yields_to.contains(&domain.goal_word(*id).word);
        let said = |id: &GoalWordId| *id != offer.word && spoken.has_any(&domain.goal_word(*id).cues);
        fitting.iter().any(|id| names(id) || (weak && said(id)))
    };
    offers.retain(|offer| !yields(offer));
    // A goal whose cue and arguments are in the instruction ("wipe the desk with the cloth") supersedes goals with
    // unmentioned arguments.
    let named = |offer: &Offer| fitting.contains(&offer.word) && spoken.has_any(&word(offer).cues);
    if offers.iter().any(named) {
        offers.retain(|offer| fitting.contains(&offer.word));
    }
    offers
}

/// Returns true if a goal may follow the goals of `said`.
fn may_follow(world: &World, word: &GoalWord, said: &[GoalFact], spoken: &Spoken, bindings: &[EntityId]) -> bool {
    let Some(subject) = word.subject.map(|parameter| bindings[parameter]) else {
        return true;
    };
    let kind = |entity: EntityId| stem(&world.entity(entity).identifier);
    said.iter().all(|fact| {
        let GoalFact::Word { word: said, arguments } = fact else {
            return true;
        };
        let said = world.domain().goal_word(*said);
        // Goals of different exclusive groups are independent: a filled dishwasher may also be switched on.
        let apart = said.exclusive.is_some() && word.exclusive.is_some() && said.exclusive != word.exclusive;
        arguments.iter().enumerate().all(|(parameter, entity)| {
            let same_role = apart || said.subject == Some(parameter) || said.disturbs.contains(&parameter);
            // "The plate" means one plate, and a destination keeps its place.
            let another =
                *entity != subject && kind(*entity) == kind(subject) && !spoken.several(&world.entity(subject).names);
            !another && (*entity != subject || same_role)
        })
    }) && spoken.entities.contains(&subject)
}

fn narrow(world: &World, spoken: &Spoken, parameters: usize, arguments: &mut Vec<Vec<EntityId>>) {
    let meant = &spoken.entities;
    // After "on the table", other portable objects and origins ("from the counter") are no destinations.
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
        let portable = |entity: EntityId| world.is_of_kind(entity, world.domain().environment.object);
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
    // "The pan on the stove by the door" says where the pan is: mentioned places where an object is already are the
    // last choice as its destination.
    if parameters == 2 && !meant.is_empty() {
        let at = Relations::of(world, arguments);
        let mut keep = |fits: &dyn Fn(&Vec<EntityId>) -> bool| {
            if arguments.iter().any(fits) {
                arguments.retain(fits);
            }
        };
        keep(&|b| !at.lead_to(b[0], b[1]) && !at.lead_to(b[1], b[0]));
        // "On the tray on the desk" means the tray.
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
