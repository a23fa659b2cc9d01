//! Questions about references that several entities fit.

use super::mentions::said_length;
use super::{Mentions, reference_words};
use crate::environment::{Distinctions, EntityId, Fact, Moment, World, holds};
use crate::goal::{Constraint, Goal, GoalFact};
use crate::model::{TypeId, head, label, plain_words, singular};

/// Returns a question if the instruction refers to one entity by a name that several have: "the mug". Returns none if the
/// reference is clear, or if the entities differ in nothing that a person can name.
pub(crate) fn which(world: &World, mentions: &Mentions, goal: &Goal) -> Option<String> {
    let single = goal.facts.iter().filter(|fact| goal.grouped_part(fact).is_none());
    let of_goals = single.flat_map(GoalFact::parts);
    let mut of_goals = of_goals.map(|fact| of_fact(world, mentions, goal, fact));
    let is_single = |own: &&Constraint| !goal.groups.iter().any(|part| part.constraints.contains(own));
    let mut of_constraints = goal
        .constraints
        .iter()
        .filter(is_single)
        .flat_map(|constraint| concerned(world, constraint))
        .map(|(entity, kind)| {
            let others = Others {
                are_possible: &|other| world.is_of_kind(other, kind),
                are_wished: &|_| false,
            };
            question(world, mentions, entity, &others)
        });
    of_goals
        .find_map(|question| question)
        .or_else(|| of_constraints.find_map(|question| question))
}

/// Returns the question about the arguments of a goal.
fn of_fact(world: &World, mentions: &Mentions, goal: &Goal, fact: &GoalFact) -> Option<String> {
    let GoalFact::Word { word: id, arguments } = fact else {
        return None;
    };
    let word = world.domain().goal_word(*id);
    (0..arguments.len()).find_map(|parameter| {
        let instead = |other: EntityId| {
            let mut instead = arguments.clone();
            instead[parameter] = other;
            instead
        };
        let doubled = |other: EntityId| GoalFact::Word {
            word: *id,
            arguments: instead(other),
        };
        let has_role_of_its_own = |other: EntityId| {
            let doubled = doubled(other);
            let mut others = goal.facts.iter().filter(|fact| **fact != doubled);
            others.any(|fact| fact.subject(world.domain()) == Some(other)) || arguments.contains(&other)
        };
        let is_possible = |other: EntityId| {
            let moment = Moment {
                world,
                state: &world.state,
            };
            world.is_of_kind(other, word.parameters[parameter].kind)
                && !has_role_of_its_own(other)
                && holds(moment, &word.offered, &mut instead(other))
                && !holds(moment, &word.condition, &mut instead(other))
        };
        let others = Others {
            are_possible: &is_possible,
            are_wished: &|other| goal.facts.contains(&doubled(other)),
        };
        question(world, mentions, arguments[parameter], &others)
    })
}

/// Returns the entities that a constraint is about, each with the type that another one would need in its place.
fn concerned(world: &World, constraint: &Constraint) -> Vec<(EntityId, TypeId)> {
    let domain = world.domain();
    match constraint {
        Constraint::Untouched(entity) => vec![(*entity, TypeId::OBJECT)],
        Constraint::Until { constraint, .. } => concerned(world, constraint),
        Constraint::Step { action, arguments } => {
            let action = domain.action(*action);
            let kinds = action.explicit.iter().map(|index| action.parameters[*index].kind);
            let given = arguments.iter().zip(kinds);
            given.filter_map(|(entity, kind)| Some(((*entity)?, kind))).collect()
        }
        Constraint::State { fact, .. } => match fact {
            GoalFact::Word { word, arguments } => {
                let kinds = domain
                    .goal_word(*word)
                    .parameters
                    .iter()
                    .map(|parameter| parameter.kind);
                arguments.iter().copied().zip(kinds).collect()
            }
            GoalFact::Plain(_) | GoalFact::Number(_) | GoalFact::If(_) | GoalFact::Choice(_) => Vec::new(),
        },
    }
}

/// The entities that could be meant in place of one in a goal.
struct Others<'a> {
    /// True for an entity for which the goal makes sense.
    are_possible: &'a dyn Fn(EntityId) -> bool,
    /// True for an entity for which the goal is there, too.
    are_wished: &'a dyn Fn(EntityId) -> bool,
}

/// Returns the question which entity is meant where the goal has `entity`.
fn question(world: &World, mentions: &Mentions, entity: EntityId, others: &Others<'_>) -> Option<String> {
    let names = &world.entity(entity).names;
    if !mentions.entities.contains(&entity) || mentions.several(names) {
        return None;
    }
    let reference = Reference::to(world, mentions, entity);
    let alike = mentions.entities.iter().copied().filter(|other| *other != entity);
    let mut all: Vec<EntityId> = alike
        .filter(|other| reference.fits(world, *other) && (others.are_possible)(*other))
        .collect();
    // Any mug will do for "a mug", but not all of them.
    if !means_one(world, mentions, entity) && !all.iter().any(|other| (others.are_wished)(*other)) {
        return None;
    }
    let distinctions = Distinctions::of(world);
    let is_labelled = has_label(world, entity);
    let described = described_as(world, entity);
    all.retain(|other| {
        distinctions.differ(entity, *other)
            || (is_labelled && has_label(world, *other))
            || described != described_as(world, *other)
    });
    if all.is_empty() {
        return None;
    }
    all.push(entity);
    all.sort_unstable();
    let described: Vec<EntityId> = all
        .iter()
        .copied()
        .filter(|one| is_described(world, mentions, *one, &all))
        .collect();
    let candidates = if described.contains(&entity) { described } else { all };
    if candidates.len() == 1 {
        return None;
    }
    let name = head(&world.entity(entity).name);
    let mut described = distinctions.describe(&candidates);
    if described.len() < candidates.len() {
        described.push(format!("one of {} others", candidates.len() - described.len()));
    }
    Some(format!("Which {name} do you mean: {}?", described.join(", or ")))
}

/// The names by which the instruction refers to an entity, as singular words.
struct Reference {
    /// Names that the instruction contains as a whole.
    names: Vec<Vec<String>>,
    /// Head nouns, for a reference such as "the glass" to the water glass.
    heads: Vec<String>,
}

impl Reference {
    fn to(world: &World, mentions: &Mentions, entity: EntityId) -> Self {
        let words: Vec<String> = mentions.words().iter().map(|word| singular(word)).collect();
        let begins = |name: &[String], start| said_length(name, &words[start..]).is_some();
        let is_said = |name: &Vec<String>| !name.is_empty() && (0..words.len()).any(|start| begins(name, start));
        let names = world.entity(entity).names.iter().map(|name| parts(name));
        Self {
            names: names.filter(is_said).collect(),
            heads: said_heads(world, mentions, entity),
        }
    }

    /// Returns true if it can mean another entity, too.
    fn fits(&self, world: &World, other: EntityId) -> bool {
        let others = &world.entity(other).names;
        if self.names.is_empty() {
            others.iter().any(|name| self.heads.contains(&head(name)))
        } else {
            others.iter().any(|name| self.names.contains(&parts(name)))
        }
    }
}

fn parts(name: &str) -> Vec<String> {
    plain_words(name).iter().map(|word| singular(word)).collect()
}

/// Returns the words of the name that the entity is shown with, without numbers, which may be nobody's but the program's.
fn described_as(world: &World, entity: EntityId) -> Vec<String> {
    let mut words = plain_words(&world.entity(entity).name);
    words.retain(|word| !word.contains(char::is_numeric));
    words
}

/// Returns the head nouns of an entity's names that the instruction contains.
fn said_heads(world: &World, mentions: &Mentions, entity: EntityId) -> Vec<String> {
    let heads = world.entity(entity).names.iter().map(|name| head(name));
    let said = |head: &String| mentions.words().iter().any(|word| singular(word) == *head);
    heads.filter(said).collect()
}

/// Returns true if the name that the entity is shown with has the label of its identifier.
fn has_label(world: &World, entity: EntityId) -> bool {
    let entity = world.entity(entity);
    let label = label(&entity.identifier);
    !label.is_empty() && entity.name.ends_with(&format!(" {label}"))
}

/// Returns true if a reference to the entity means one certain entity: "the mug", "my mug", "mug", but not "a mug".
fn means_one(world: &World, mentions: &Mentions, entity: EntityId) -> bool {
    let heads = said_heads(world, mentions, entity);
    let words = mentions.words();
    let places = words
        .iter()
        .enumerate()
        .filter(|(_, word)| heads.contains(&singular(word)));
    // Up to two words of description may follow the determiner: "the big red mug".
    places.into_iter().any(|(place, _)| {
        let mut before = words[place.saturating_sub(3)..place].iter().rev();
        let determiner = before.find(|word| reference_words::mark_any(word) || reference_words::mark_certain(word));
        determiner.is_none_or(|word| !reference_words::mark_any(word))
    })
}

/// Returns true if the instruction describes the entity by its place or by a property that not all of them have.
fn is_described(world: &World, mentions: &Mentions, entity: EntityId, all: &[EntityId]) -> bool {
    let domain = world.domain();
    let about = |fact: &Fact| domain.arguments(*fact).next() == Some(entity);
    let is_said = |fact: Fact| {
        let words = domain.words(fact.predicate());
        if domain.is_relation(fact) {
            let mut places = domain.arguments(fact).skip(1);
            return words.fluent && places.any(|place| mentions.entities.contains(&place) && !all.contains(&place));
        }
        let is_common = all
            .iter()
            .all(|other| world.state.holds(Fact::new(fact.predicate(), [*other])));
        let name = domain.predicate(fact.predicate()).name.clone();
        let short = words.short.as_ref().map(|short| short.fill(|_| String::new()));
        let mut forms = short.into_iter().chain([name]).map(|form| plain_words(&form));
        let has = |form: Vec<String>| !form.is_empty() && form.iter().all(|word| mentions.words().contains(word));
        !is_common && forms.any(has)
    };
    world.state.iter().filter(about).any(is_said)
}
