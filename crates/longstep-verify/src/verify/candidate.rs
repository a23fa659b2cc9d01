//! Candidates for the implicit arguments of a step, the most likely first.

use rustc_hash::FxHashSet;

use crate::plan::DraftStep;
use crate::plan::claims::split_claims;
use longstep_model::effort;
use longstep_model::environment::Claim;
use longstep_model::model::{Action, EntityId, TypeId, World, plain_words, singular};

/// Complete arguments of a step.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Candidate {
    /// One entity for each parameter.
    pub arguments: Vec<EntityId>,
    /// True if the step's explanation mentions a different entity for an implicit argument.
    pub mismatch: bool,
}

/// Returns all candidate arguments of a step, the most likely first: entities that the explanation mentions, then the
/// places where the plan claims the objects to be.
pub fn candidates(
    world: &World,
    step: &DraftStep,
    objects: &[EntityId],
    claimed_places: &FxHashSet<EntityId>,
) -> Vec<Candidate> {
    let action = world.domain().action(step.action);
    let evidence = Evidence {
        world,
        action,
        words: explanation_words(step),
        objects,
        claimed_places,
    };
    let mut all = vec![Candidate {
        arguments: Vec::new(),
        mismatch: false,
    }];
    for (index, parameter) in action.parameters.iter().enumerate() {
        let fitting = match step.arguments[index] {
            Some(entity) => vec![(entity, false)],
            None if action.object == Some(index) && !objects.is_empty() => evidence.handled(parameter.kind),
            None => evidence.others(parameter.kind),
        };
        let count = all.len().saturating_mul(fitting.len());
        // All candidates stay in memory until the plan is bound.
        if !effort::spend(2 * effort::KEPT * count) {
            return Vec::new();
        }
        let mut longer = Vec::with_capacity(count);
        for candidate in &all {
            longer.extend(fitting.iter().map(|(entity, mismatch)| Candidate {
                arguments: [&candidate.arguments[..], &[*entity]].concat(),
                mismatch: candidate.mismatch || *mismatch,
            }));
        }
        all = longer;
    }
    all
}

/// The signs by which the likely arguments of a step are told from the others.
struct Evidence<'a> {
    world: &'a World,
    action: &'a Action,
    /// The words of the step's explanation, in singular form.
    words: Vec<String>,
    /// The objects that the plan handles.
    objects: &'a [EntityId],
    /// The places where the plan claims the objects to be.
    claimed_places: &'a FxHashSet<EntityId>,
}

impl Evidence<'_> {
    /// Returns how often the explanation mentions an entity.
    fn mentions(&self, entity: EntityId) -> usize {
        self.world.entity(entity).words_in(&self.words)
    }

    /// Returns true for an object of the plan, which is not its own place.
    fn is_handled(&self, entity: EntityId) -> bool {
        self.action.object.is_some() && self.objects.contains(&entity)
    }

    /// Returns the objects of a type, each with true if the explanation mentions another one more often.
    fn handled(&self, kind: TypeId) -> Vec<(EntityId, bool)> {
        let objects = self.objects.iter().copied();
        let fits = objects.filter(|object| self.world.is_of_kind(*object, kind));
        let mut handled: Vec<(EntityId, usize)> = fits.map(|object| (object, self.mentions(object))).collect();
        effort::spend(handled.len() * (1 + self.words.len()));
        // The object that the explanation mentions most comes first; another one may only be part of a place name.
        handled.sort_by_key(|(_, mentions)| std::cmp::Reverse(*mentions));
        marked(handled)
    }

    /// Returns the entities of a type, each with true if the explanation mentions another one more often.
    fn others(&self, kind: TypeId) -> Vec<(EntityId, bool)> {
        let all = self.world.of_kind(kind);
        effort::spend(all.len() * (1 + self.words.len()));
        let mut ranked = Vec::with_capacity(all.len());
        for entity in all {
            // Explanations mention the handled object, whatever the place.
            let mentions = if self.is_handled(*entity) {
                0
            } else {
                self.mentions(*entity)
            };
            ranked.push((*entity, mentions));
        }
        ranked.sort_by_key(|(entity, mentions)| {
            (
                self.is_handled(*entity),
                std::cmp::Reverse(*mentions),
                !self.claimed_places.contains(entity),
                *entity,
            )
        });
        marked(ranked)
    }
}

/// Marks the entities that are mentioned less often than another one.
fn marked(ranked: Vec<(EntityId, usize)>) -> Vec<(EntityId, bool)> {
    let best = ranked.iter().map(|(_, mentions)| *mentions).max().unwrap_or(0);
    let marked = ranked.into_iter();
    marked.map(|(entity, mentions)| (entity, mentions < best)).collect()
}

/// Returns the entities in newly claimed facts about the objects.
pub fn claimed_places(world: &World, claim: Option<&Claim>, objects: &[EntityId]) -> FxHashSet<EntityId> {
    let domain = world.domain();
    let mut places = FxHashSet::default();
    for fact in claim.map_or_else(Vec::new, |claim| claim.promises(world)) {
        if domain.arguments(fact).any(|entity| objects.contains(&entity)) {
            places.extend(domain.arguments(fact));
        }
    }
    places
}

/// Returns the words of a step's explanation, in singular form.
pub(super) fn explanation_words(step: &DraftStep) -> Vec<String> {
    let sentence = split_claims(&step.explanation).sentence;
    plain_words(sentence).iter().map(|word| singular(word)).collect()
}
