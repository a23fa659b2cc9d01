//! A world: its entities and its initial state.

use std::ops::Range;
use std::sync::Arc;

use indexmap::IndexMap;

use super::label::without_brackets;
use super::lexicon::is_mark;
use super::prohibition::ForbiddenSteps;
use super::value::VALUE_LIMIT;
use super::{Domain, EntityId, Environment, Fact, Prohibition, State, TypeId, Value, When};

/// The largest number of entities; ids have 16 bits in a [`Fact`].
pub const ENTITY_LIMIT: usize = 60_000;

/// An entity of a world.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Entity {
    /// The identifier as the environment writes it, for example `<plate_274>`.
    pub identifier: String,
    /// The type.
    pub kind: TypeId,
    /// The everyday name, unique in the world: "plate 2".
    pub name: String,
    /// All names that a text may use for it, synonyms included.
    pub names: Vec<String>,
    /// True for a value, which no environment lists: `22 degC`.
    pub is_value: bool,
}

/// The reason to assume a fact that the environment does not give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum AssumptionSource {
    /// The derivation of the domain with this index gives it.
    Derived {
        /// The index in the domain's derivations.
        derivation: usize,
    },
    /// The domain declares it as the default.
    Default,
    /// The environment gives neither the fact nor its negation, and the domain assumes it then.
    Unknown,
}

/// A world: its entities and the state in which an instruction is given.
///
/// `Debug` shows the sizes, because a report has its world: the content is in [`World::environment`].
#[derive(Clone)]
pub struct World {
    domain: Domain,
    // Shared with successor worlds: a session holds one world per instruction.
    pub(crate) entities: Arc<[Entity]>,
    pub(crate) by_identifier: Arc<IndexMap<String, EntityId>>,
    by_kind: Arc<[Vec<EntityId>]>,
    /// The initial state, assumptions included.
    pub state: State,
    /// The state in which the instruction was given, in a world that [continues](World::continued) another one.
    origin: Option<Arc<State>>,
    /// The assumed facts of the state, with their reasons.
    pub(crate) assumed: Arc<rustc_hash::FxHashMap<Fact, AssumptionSource>>,
    /// The environment from which the world was read.
    pub(crate) environment: Arc<Environment>,
    /// The prohibitions in force.
    prohibitions: Arc<[Prohibition]>,
    /// The steps that they forbid.
    forbidden: Arc<ForbiddenSteps>,
}

impl std::fmt::Debug for World {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let mut world = formatter.debug_struct("World");
        world.field("domain", &self.domain);
        world.field("entities", &self.entities.len());
        world.field("facts", &self.state.iter().count());
        world.finish_non_exhaustive()
    }
}

impl World {
    /// Creates a world with an empty state. Identifiers must be unique, and the domain's constants must come first.
    pub fn new(domain: &Domain, entities: Vec<Entity>, environment: Environment) -> Self {
        let identified = entities.iter().enumerate();
        let by_identifier = identified
            .map(|(index, entity)| (entity.identifier.clone(), EntityId::new(index)))
            .collect();
        let of_kind = |kind: usize| {
            let members = entities.iter().enumerate();
            members
                .filter(|(_, entity)| domain.types.is_a(entity.kind, TypeId::new(kind)))
                .map(|(index, _)| EntityId::new(index))
                .collect()
        };
        Self {
            domain: domain.clone(),
            by_kind: (0..domain.types.count()).map(of_kind).collect(),
            entities: entities.into(),
            by_identifier: Arc::new(by_identifier),
            state: State::default(),
            origin: None,
            assumed: Arc::default(),
            environment: Arc::new(environment),
            prohibitions: Arc::default(),
            forbidden: Arc::default(),
        }
    }

    /// Returns the world with another domain, which has the types and constants of its own.
    pub fn in_domain(&self, domain: Domain) -> Self {
        Self { domain, ..self.clone() }
    }

    /// The environment that the world was read from.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// The domain that the world was read with.
    pub fn domain(&self) -> &Domain {
        &self.domain
    }

    /// The prohibitions in force.
    pub fn prohibitions(&self) -> &[Prohibition] {
        &self.prohibitions
    }

    pub(super) fn forbidden_steps(&self) -> &ForbiddenSteps {
        &self.forbidden
    }

    /// The state that conditions mean by `initially`: the one in which the instruction was given.
    pub fn initially(&self) -> &State {
        self.origin.as_deref().unwrap_or(&self.state)
    }

    /// Returns the state of the past in which something is looked at; none for [`When::Now`].
    pub fn past(&self, at: When) -> Option<&State> {
        match at {
            When::Now => None,
            When::Start => Some(&self.state),
            When::Initially => Some(self.initially()),
        }
    }

    /// Returns the world in a later state of the same instruction: a plan for it is the rest of a plan.
    ///
    /// Events of the steps so far are facts of the state, and `initially` still means the state in which the instruction
    /// was given. Assumed facts that no longer hold are forgotten.
    #[must_use]
    pub fn continued(&self, state: State) -> Self {
        let mut world = self.clone();
        let origin = world.origin.take();
        world.origin = Some(origin.unwrap_or_else(|| Arc::new(self.state.clone())));
        if self.assumed.keys().any(|fact| !state.holds(*fact)) {
            Arc::make_mut(&mut world.assumed).retain(|fact, _| state.holds(*fact));
        }
        world.state = state;
        world
    }

    /// Replaces the prohibitions in force.
    pub fn set_prohibitions(&mut self, prohibitions: impl IntoIterator<Item = Prohibition>) {
        self.prohibitions = prohibitions.into_iter().collect();
        self.forbidden = Arc::new(ForbiddenSteps::of(&self.prohibitions));
    }

    /// Adds the values in a text as entities, unless the world has them. The ids of other entities stay as they are.
    ///
    /// Quantities that are out of range for their type are not added: using one in a goal or a plan is an error.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// use longstep_search::goal;
    /// let files = domain::shipped_files("household").unwrap();
    /// # let mut files = files;
    /// # files.pddl = files.pddl.replacen("(:types", "(:types duration - object", 1);
    /// # files.words.push_str("\n[value.duration]\nunit = \"s\"\nunits = { min = 60 }\n");
    /// let domain = domain::load(&files).unwrap();
    /// let mut world = environment::parse(&domain, "env.json", r#"{"assets": ["<table>"]}"#).unwrap();
    /// world.add_values("wait for 3 min");
    /// assert!(world.find("180 s").is_some());
    /// assert_eq!(world.named("3 min"), [world.find("180 s").unwrap()]);
    /// ```
    pub fn add_values(&mut self, text: &str) {
        let mentions = self.domain.values_in(text);
        for mention in mentions.into_iter().take(VALUE_LIMIT) {
            if let Ok(value) = mention.value {
                self.add_value(&value, &text[mention.place]);
            }
        }
    }

    /// Adds the values of another world of the same domain.
    pub fn share_values(&mut self, other: &World) {
        for (_, entity) in other.entities().filter(|(_, entity)| entity.is_value) {
            if self.find(&entity.identifier).is_none()
                && let Some(Ok(value)) = self.domain.value(&entity.identifier)
            {
                self.add_value(&value, entity.names.last().unwrap_or(&entity.name));
            }
        }
    }

    /// Adds a value as an entity, which a text mentions in these words. None if the world has no room for it.
    pub fn add_value(&mut self, value: &Value, mentioned: &str) -> Option<EntityId> {
        let mentioned = mentioned
            .trim_matches(['"', '“', '”', '„', '«', '»', '「', '」'])
            .trim();
        if let Some(known) = self.find(&value.written) {
            if !self.entity(known).names.iter().any(|name| name == mentioned) {
                let mut entities = self.entities.to_vec();
                entities[known.index()].names.push(mentioned.to_owned());
                self.entities = entities.into();
            }
            return Some(known);
        }
        if self.entities.len() >= ENTITY_LIMIT {
            return None;
        }
        let id = EntityId::new(self.entities.len());
        let mut names = vec![value.written.clone()];
        if mentioned != value.written {
            names.push(mentioned.to_owned());
        }
        let mut entities = self.entities.to_vec();
        entities.push(Entity {
            identifier: value.written.clone(),
            kind: value.kind,
            name: value.written.clone(),
            names,
            is_value: true,
        });
        self.entities = entities.into();
        Arc::make_mut(&mut self.by_identifier).insert(value.written.clone(), id);
        let mut by_kind = self.by_kind.to_vec();
        for (kind, members) in by_kind.iter_mut().enumerate() {
            if self.domain.types.is_a(value.kind, TypeId::new(kind)) {
                members.push(id);
            }
        }
        self.by_kind = by_kind.into();
        Some(id)
    }

    /// Iterates over all entities with their ids: constants of the domain, assets, objects, values.
    pub fn entities(&self) -> impl Iterator<Item = (EntityId, &Entity)> {
        self.entities
            .iter()
            .enumerate()
            .map(|(index, entity)| (EntityId::new(index), entity))
    }

    /// Returns the entity with this id.
    pub fn entity(&self, id: EntityId) -> &Entity {
        &self.entities[id.index()]
    }

    /// Returns the entity with this identifier.
    pub fn find(&self, identifier: &str) -> Option<EntityId> {
        self.by_identifier.get(identifier).copied()
    }

    /// Returns the entity with this everyday name.
    pub fn find_name(&self, name: &str) -> Option<EntityId> {
        self.entities()
            .find(|(_, entity)| entity.name == name)
            .map(|(id, _)| id)
    }

    /// Returns the entities that a name can mean: the one with this identifier, else the one with this everyday name or
    /// this value in any of its units, else all that have it among their names, in any case. Names that nothing has are
    /// looked up without the domain's article: "the juice" is what is shown for `juice`.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let world = environment::parse(&household, "env.json", r#"{"objects": ["<pallet_2>", "<pallet_3>"]}"#).unwrap();
    /// assert_eq!(world.named("pallet 3"), [world.find("<pallet_3>").unwrap()]);
    /// assert_eq!(world.named("Pallet").len(), 2);
    /// assert_eq!(world.named("the pallet 3"), world.named("pallet 3"));
    /// ```
    pub fn named(&self, name: &str) -> Vec<EntityId> {
        let named = self.with_name(name);
        match name.split_once(' ') {
            Some((first, rest)) if named.is_empty() && first.eq_ignore_ascii_case(&self.domain.article) => {
                self.with_name(rest)
            }
            _ => named,
        }
    }

    /// Returns the entities that exactly this name can mean, as [`Self::named`] says.
    fn with_name(&self, name: &str) -> Vec<EntityId> {
        if let Some(exact) = self.find(name) {
            return vec![exact];
        }
        // An identifier without brackets may be the name of another entity; then both are meant.
        let shown = self.find_name(name);
        let folded = name.to_lowercase();
        let is_named =
            |entity: &Entity| !entity.is_value && without_brackets(&entity.identifier).to_lowercase() == folded;
        let identified = self.entities().filter(|(_, entity)| is_named(entity));
        let bare = identified.filter(|_| is_bare_identifier(name)).map(|(id, _)| id);
        let mut exact: Vec<EntityId> = shown.into_iter().chain(bare).collect();
        exact.sort_unstable();
        exact.dedup();
        if !exact.is_empty() {
            return exact;
        }
        if let Some(value) = self.domain.value(name) {
            let known = value.ok().and_then(|value| self.find(&value.written));
            return known.into_iter().collect();
        }
        let with = |fits: &dyn Fn(&Entity) -> bool| -> Vec<EntityId> {
            let all = self.entities().filter(|(_, entity)| fits(entity));
            all.map(|(id, _)| id).collect()
        };
        match with(&|entity| entity.name.to_lowercase() == folded) {
            shown if !shown.is_empty() => shown,
            _ => with(&|entity| entity.called().any(|name| name.to_lowercase() == folded)),
        }
    }

    /// Returns the entities whose identifiers stand in a text without their brackets, in any case, with their places. An identifier of
    /// letters alone is a word like others, and none of these. Where the same words are the name of another entity, both are returned.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let world = environment::parse(&household, "env.json", r#"{"objects": ["<plate_274>", "<can>"]}"#).unwrap();
    /// let plate = world.find("<plate_274>").unwrap();
    /// assert_eq!(world.identifiers_in("The can on Plate_274."), [(11..20, plate)]);
    /// ```
    pub fn identifiers_in(&self, text: &str) -> Vec<(Range<usize>, EntityId)> {
        let places: Vec<Range<usize>> = identifier_like(text).collect();
        if places.is_empty() {
            return Vec::new();
        }
        let words: Vec<String> = places.iter().map(|place| text[place.clone()].to_lowercase()).collect();
        let mut found = Vec::new();
        for (id, entity) in self.entities().filter(|(_, entity)| !entity.is_value) {
            let bare = without_brackets(&entity.identifier).to_lowercase();
            for (word, place) in words.iter().zip(&places).filter(|(word, _)| **word == bare) {
                found.push((place.clone(), id));
                let named = self.entities().filter(|(_, other)| other.name.to_lowercase() == *word);
                found.extend(named.map(|(other, _)| (place.clone(), other)));
            }
        }
        found.sort_unstable_by_key(|(place, id)| (place.start, *id));
        found.dedup();
        found
    }

    /// Returns a text with the everyday names of entities in place of their identifiers, with or without brackets. Identifiers that may
    /// mean several entities stay.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"objects": ["<plate_274>", "<plate_278>", "<can_1>", "<pan_2>", "<lid_3>"]}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// assert_eq!(world.with_everyday_names("Wash plate_278 and <can_1>"), "Wash plate 2 and can");
    /// ```
    pub fn with_everyday_names(&self, text: &str) -> String {
        let identified = self.identifiers_in(text);
        let (mut written, mut at) = (String::new(), 0);
        for (place, id) in &identified {
            let is_shared = identified.iter().any(|(other, with)| other == place && with != id);
            if is_shared {
                continue;
            }
            let before = &text[at..place.start];
            let behind = &text[place.end..];
            let brackets = before.strip_suffix('<').zip(behind.strip_prefix('>'));
            written.push_str(brackets.map_or(before, |(before, _)| before));
            written.push_str(&self.entity(*id).name);
            at = place.end + usize::from(brackets.is_some());
        }
        written.push_str(&text[at..]);
        written
    }

    /// Returns the entity with this identifier or this value in any of its units.
    pub fn exactly(&self, text: &str) -> Option<EntityId> {
        let value = || self.find(&self.domain.value(text)?.ok()?.written);
        self.find(text).or_else(value)
    }

    /// Returns the entities of a type, in order.
    pub fn of_kind(&self, kind: TypeId) -> &[EntityId] {
        &self.by_kind[kind.index()]
    }

    /// Returns true if the entity is of the type or of a subtype.
    pub fn is_of_kind(&self, entity: EntityId, kind: TypeId) -> bool {
        let all = self.of_kind(kind);
        // The lists are sorted, and a list of all entities needs no lookup.
        all.len() == self.entities.len() || all.binary_search(&entity).is_ok()
    }

    /// Returns the reason why the fact is assumed in the initial state; none if it is not.
    pub fn assumed(&self, fact: Fact) -> Option<AssumptionSource> {
        self.assumed.get(&fact).copied()
    }

    /// Returns the initial state without the facts assumed only because the environment does not give them.
    pub fn known(&self) -> State {
        let mut known = self.state.clone();
        for (fact, ground) in self.assumed.iter() {
            if *ground == AssumptionSource::Unknown {
                known.set(*fact, false);
            }
        }
        known
    }
}

/// Returns true for a text with the form of an identifier that is no word: with letters, and with digits or underscores.
fn is_bare_identifier(text: &str) -> bool {
    let is_part = |c: char| c.is_alphanumeric() || is_mark(c) || matches!(c, '_' | '-' | '.');
    text.contains(char::is_alphabetic)
        && text.contains(|c: char| c == '_' || c.is_numeric())
        && text.chars().all(is_part)
}

/// Iterates over the places of a text that have the form of an identifier.
fn identifier_like(text: &str) -> impl Iterator<Item = Range<usize>> {
    let is_part = |c: char| c.is_alphanumeric() || is_mark(c) || matches!(c, '_' | '-' | '.');
    text.split(move |c| !is_part(c)).filter_map(move |word| {
        // A full stop ends a sentence.
        let trimmed = word.trim_matches(['.', '-']);
        let start = trimmed.as_ptr() as usize - text.as_ptr() as usize;
        is_bare_identifier(trimmed).then_some(start..start + trimmed.len())
    })
}
