//! The place of every entity in a state: a forest without cycles.

use longstep_core::model::{EntityId, Fact, State, World};

use super::schema::{PlaceForm, Relation, SceneSchema};

/// A box of a scene: an entity, or the robot itself.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) enum Body {
    /// An entity of the world.
    Entity(EntityId),
    /// The robot, which no entity stands for.
    Robot,
}

/// The box around a body, with the fact that says so; none for a hand of the robot, which no fact attaches to it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Spot {
    pub(super) holder: Body,
    pub(super) relation: Relation,
    pub(super) fact: Option<Fact>,
}

/// The spots of all bodies, by index of the entity; the robot's is the last.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Placement {
    spots: Vec<Option<Spot>>,
}

impl Placement {
    /// Finds the spots in a state.
    ///
    /// An entity with several places is in the innermost one: on a table in a kitchen, it is on the table. Of a cycle, the
    /// first entity has no place.
    pub(crate) fn of(schema: &SceneSchema, world: &World, state: &State) -> Self {
        let mut candidates = Candidates::new(world.entities().count());
        for form in &schema.places {
            // Values have no boxes, whatever the types of a domain allow.
            let shown = |position: Option<usize>, fact: &Fact| {
                position.is_none_or(|position| !world.entity(fact.argument(position)).is_value)
            };
            let facts = state.of_predicate(form.predicate).iter();
            for fact in facts.filter(|fact| shown(Some(form.subject), fact) && shown(form.place, fact)) {
                candidates.add_fact(*form, *fact);
            }
        }
        for fact in schema.robot_places.iter().flat_map(|own| state.of_predicate(*own)) {
            let spot = Spot {
                holder: Body::Entity(fact.argument(0)),
                relation: Relation::At,
                fact: Some(*fact),
            };
            candidates.add(Body::Robot, spot);
        }
        if schema.has_robot() {
            candidates.add_hands(schema, world);
        }
        let mut placement = candidates.innermost();
        placement.cut_cycles();
        placement
    }

    /// Returns the spot of a body; none for one without a place.
    pub(super) fn spot(&self, body: Body) -> Option<&Spot> {
        self.spots[self.index(body)].as_ref()
    }

    /// Iterates over the bodies whose box is another one, or of another relation, in another placement of the same world.
    pub(super) fn moved<'p>(&'p self, other: &'p Self) -> impl Iterator<Item = Body> {
        let place = |spot: &Option<Spot>| spot.map(|spot| (spot.holder, spot.relation));
        let pairs = self.spots.iter().zip(&other.spots).enumerate();
        pairs
            .filter(move |(_, (own, other))| place(own) != place(other))
            .map(|(index, _)| self.body(index))
    }

    /// Iterates over the boxes around a body, from the inside out.
    pub(super) fn around(&self, body: Body) -> impl Iterator<Item = Body> {
        std::iter::successors(self.spot(body).map(|spot| spot.holder), |around| {
            self.spot(*around).map(|spot| spot.holder)
        })
    }

    /// Iterates over all bodies, the robot last.
    pub(super) fn bodies(&self) -> impl Iterator<Item = Body> {
        (0..self.spots.len()).map(|index| self.body(index))
    }

    fn robot(&self) -> usize {
        self.spots.len() - 1
    }

    fn index(&self, body: Body) -> usize {
        match body {
            Body::Entity(entity) => entity.index(),
            Body::Robot => self.robot(),
        }
    }

    fn body(&self, index: usize) -> Body {
        if index == self.robot() {
            Body::Robot
        } else {
            Body::Entity(EntityId::new(index))
        }
    }

    fn holder(&self, index: usize) -> Option<usize> {
        self.spots[index].map(|spot| self.index(spot.holder))
    }

    /// Takes the first body of every cycle out of it.
    fn cut_cycles(&mut self) {
        // The walk in which a body was first met; 0 for none yet.
        let mut met = vec![0_usize; self.spots.len()];
        for start in 0..self.spots.len() {
            let (walk, mut here) = (start + 1, Some(start));
            while let Some(index) = here.filter(|index| met[*index] == 0) {
                met[index] = walk;
                here = self.holder(index);
            }
            if let Some(entry) = here.filter(|index| met[*index] == walk) {
                let first = self.cycle(entry).min().unwrap_or(entry);
                self.spots[first] = None;
            }
        }
    }

    /// Iterates over the bodies of the cycle that a body is in.
    fn cycle(&self, entry: usize) -> impl Iterator<Item = usize> {
        let next = move |index: &usize| self.holder(*index).filter(|next| *next != entry);
        std::iter::successors(Some(entry), next)
    }
}

/// Possible spots: the first one of each body, and the further ones of those that have several.
struct Candidates {
    first: Vec<Option<Spot>>,
    further: Vec<(usize, Spot)>,
}

impl Candidates {
    fn new(entities: usize) -> Self {
        Self {
            first: vec![None; entities + 1],
            further: Vec::new(),
        }
    }

    fn index(&self, body: Body) -> usize {
        match body {
            Body::Entity(entity) => entity.index(),
            Body::Robot => self.first.len() - 1,
        }
    }

    fn add_fact(&mut self, form: PlaceForm, fact: Fact) {
        let spot = Spot {
            holder: form
                .place
                .map_or(Body::Robot, |place| Body::Entity(fact.argument(place))),
            relation: form.relation,
            fact: Some(fact),
        };
        self.add(Body::Entity(fact.argument(form.subject)), spot);
    }

    fn add(&mut self, body: Body, spot: Spot) {
        // No entity is around itself.
        if spot.holder == body {
            return;
        }
        let index = self.index(body);
        match &mut self.first[index] {
            first @ None => *first = Some(spot),
            Some(_) => self.further.push((index, spot)),
        }
    }

    /// Attaches hands and arms that are constants of the domain, and have no place, to the robot.
    fn add_hands(&mut self, schema: &SceneSchema, world: &World) {
        for (id, entity) in world.entities().take(world.domain().constants.len()) {
            let is_actor = schema
                .actors
                .iter()
                .any(|kind| world.domain().types.is_a(entity.kind, *kind));
            if is_actor && self.first[id.index()].is_none() {
                self.first[id.index()] = Some(Spot {
                    holder: Body::Robot,
                    relation: Relation::Part,
                    fact: None,
                });
            }
        }
    }

    /// Chooses one spot for each body.
    fn innermost(mut self) -> Placement {
        self.further.sort_by_key(|(index, _)| *index);
        let mut chosen = self.first.clone();
        for group in self.further.chunk_by(|(one, _), (other, _)| one == other) {
            let index = group[0].0;
            let all: Vec<Spot> = self.of(index).collect();
            let is_outer = |spot: &Spot| {
                let mut others = all.iter().filter(|other| other.holder != spot.holder);
                others.any(|other| self.is_around(spot.holder, other.holder))
            };
            let inner = all.iter().find(|spot| !is_outer(spot));
            chosen[index] = inner.or(all.first()).copied();
        }
        Placement { spots: chosen }
    }

    /// Iterates over the possible spots of a body.
    fn of(&self, index: usize) -> impl Iterator<Item = Spot> {
        let from = self.further.partition_point(|(other, _)| *other < index);
        let further = self.further[from..]
            .iter()
            .take_while(move |(other, _)| *other == index);
        self.first[index].into_iter().chain(further.map(|(_, spot)| *spot))
    }

    /// Returns true if one body is around another one, over any of the possible spots.
    fn is_around(&self, outer: Body, inner: Body) -> bool {
        let (outer, inner) = (self.index(outer), self.index(inner));
        let (mut seen, mut open) = (vec![inner], vec![inner]);
        while let Some(index) = open.pop() {
            for holder in self.of(index).map(|spot| self.index(spot.holder)) {
                if holder == outer {
                    return true;
                }
                if !seen.contains(&holder) {
                    seen.push(holder);
                    open.push(holder);
                }
            }
        }
        false
    }
}
