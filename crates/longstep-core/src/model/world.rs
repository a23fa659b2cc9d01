//! A world: its entities, and what holds at the start.

use std::sync::Arc;

use indexmap::IndexMap;

use super::{EntityId, Environment, Fact, State, TypeId, Types};

/// More entities than this do not fit into a fact.
pub(crate) const ENTITY_LIMIT: usize = 60_000;

/// An entity of a world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entity {
    /// The identifier as the environment writes it, for example `<plate_274>`.
    pub identifier: String,
    /// Its type.
    pub kind: TypeId,
    /// Its everyday name, which no other entity of the world has: "plate 2".
    pub name: String,
    /// Every name it may be called by, synonyms included.
    pub names: Vec<String>,
}

/// Why something is taken to hold that the environment does not say.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AssumptionSource {
    /// Its name says so.
    Derived,
    /// It is usual.
    Default,
    /// Nothing speaks against it.
    Unknown,
}

/// A world: its entities and what holds at the start of an instruction.
#[derive(Debug, Clone)]
pub struct World {
    // Shared with the worlds that follow: a session holds one for each instruction.
    pub(crate) entities: Arc<[Entity]>,
    pub(crate) by_identifier: Arc<IndexMap<String, EntityId>>,
    by_kind: Arc<[Vec<EntityId>]>,
    /// What holds, assumptions included.
    pub state: State,
    /// What of it is assumed, and why.
    pub(crate) assumed: rustc_hash::FxHashMap<Fact, AssumptionSource>,
    /// The environment that it was read from.
    pub environment: Environment,
}

impl World {
    /// A world in which nothing holds yet. Identifiers must be unique; constants of the domain come first.
    pub(crate) fn new(types: &Types, entities: Vec<Entity>, environment: Environment) -> Self {
        let identified = entities.iter().enumerate();
        let by_identifier = identified
            .map(|(index, entity)| (entity.identifier.clone(), EntityId::new(index)))
            .collect();
        let of_kind = |kind: usize| {
            let members = entities.iter().enumerate();
            members
                .filter(|(_, entity)| types.is_a(entity.kind, TypeId::new(kind)))
                .map(|(index, _)| EntityId::new(index))
                .collect()
        };
        Self {
            by_kind: (0..types.len()).map(of_kind).collect(),
            entities: entities.into(),
            by_identifier: Arc::new(by_identifier),
            state: State::default(),
            assumed: rustc_hash::FxHashMap::default(),
            environment,
        }
    }

    /// Every entity with its id: constants of the domain, assets, objects.
    pub fn entities(&self) -> impl Iterator<Item = (EntityId, &Entity)> {
        self.entities
            .iter()
            .enumerate()
            .map(|(index, entity)| (EntityId::new(index), entity))
    }

    /// The entity with this id.
    pub fn entity(&self, id: EntityId) -> &Entity {
        &self.entities[id.index()]
    }

    /// The entity with this identifier.
    pub fn find(&self, identifier: &str) -> Option<EntityId> {
        self.by_identifier.get(identifier).copied()
    }

    /// The entity with this everyday name.
    pub fn find_name(&self, name: &str) -> Option<EntityId> {
        self.entities()
            .find(|(_, entity)| entity.name == name)
            .map(|(id, _)| id)
    }

    /// The entities of a type, in order.
    pub fn of_kind(&self, kind: TypeId) -> &[EntityId] {
        &self.by_kind[kind.index()]
    }

    /// Whether the entity is of the type.
    pub fn is_of_kind(&self, entity: EntityId, kind: TypeId) -> bool {
        let all = self.of_kind(kind);
        // The lists are in order, and the one of everything needs no look.
        all.len() == self.entities.len() || all.binary_search(&entity).is_ok()
    }

    /// Why the fact is assumed at the start, if it is.
    pub fn assumed(&self, fact: Fact) -> Option<AssumptionSource> {
        self.assumed.get(&fact).copied()
    }

    /// What holds at the start without what is only taken for granted because nobody says otherwise.
    pub fn known(&self) -> State {
        let mut known = self.state.clone();
        for (fact, ground) in &self.assumed {
            if *ground == AssumptionSource::Unknown {
                known.set(*fact, false);
            }
        }
        known
    }
}
