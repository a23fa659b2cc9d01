//! The part of a domain that says where things are and how they are.
//!
//! A domain has no notion of a box in another one. [`SceneSchema`] finds the predicates that are places, by these rules:
//!
//! | rule | predicate | relation |
//! |---|---|---|
//! | geometry | of a `[[state]]` word with `geometry` `on`, `inside` or `held` | on, in, at (both), held |
//! | part | of a derivation that names an entity after another one: `{other}_handle` | part |
//! | name | binary, with a [word of place](PLACE_NAMES) in its name; only in a domain without `geometry` | by the word |
//! | exchange | what an entity has in place of its place while it is carried; only in a domain without `held` | held |
//! | robot | unary over places, true of one place at a time: `(robot-at ?place)` | at |

use longstep_core::model::{
    Action, Atom, Domain, Effect, FunctionId, PredicateId, SpatialRelation, StateWord, Term, TypeId, state_word,
};
use serde::Serialize;

/// Relation of a box to the box around it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Relation {
    /// It stands or lies on it.
    On,
    /// It is inside.
    In,
    /// It is there, on it or in it: the domain does not say which.
    At,
    /// It is a part of it, as a handle is of a door.
    Part,
    /// A hand or a robot holds or carries it.
    Held,
}

impl Relation {
    /// Returns the relation in a word, for a caption.
    pub fn word(self) -> &'static str {
        match self {
            Self::On => "on",
            Self::In => "in",
            Self::At => "at",
            Self::Part => "part of",
            Self::Held => "held by",
        }
    }
}

/// Parts of predicate names that say a place, in domains without `geometry`.
const PLACE_NAMES: [(&str, Relation); 7] = [
    ("on", Relation::On),
    ("in", Relation::In),
    ("inside", Relation::In),
    ("within", Relation::In),
    ("at", Relation::At),
    ("part", Relation::Part),
    ("belongs", Relation::Part),
];

/// A predicate that says the place of an entity.
#[derive(Debug, Clone, Copy)]
pub(super) struct PlaceForm {
    pub(super) predicate: PredicateId,
    /// The position of the entity among the arguments.
    pub(super) subject: usize,
    /// The position of its place; none for the robot itself.
    pub(super) place: Option<usize>,
    pub(super) relation: Relation,
}

/// A predicate whose facts are shown as states.
#[derive(Debug, Clone, Copy)]
pub(super) struct StateForm {
    pub(super) predicate: PredicateId,
    /// The position of the entity that the fact is shown at; none for a fact about no entity.
    pub(super) subject: Option<usize>,
    pub(super) event: bool,
}

/// The predicates of a domain that a scene shows, and how.
#[derive(Debug, Clone)]
pub(crate) struct SceneSchema {
    pub(super) places: Vec<PlaceForm>,
    /// Predicates that say at which one place the robot is.
    pub(super) robot_places: Vec<PredicateId>,
    /// Predicates that are true of one entity at a time and say where the robot is, if entities move: `(hand-at ?thing)`.
    pub(super) robot_states: Vec<PredicateId>,
    pub(super) states: Vec<StateForm>,
    /// Functions whose numbers are shown.
    pub(super) numbers: Vec<FunctionId>,
    /// Types of hands, arms and robots.
    pub(super) actors: Vec<TypeId>,
}

impl SceneSchema {
    pub(crate) fn of(domain: &Domain) -> Self {
        let mut places = from_geometry(domain);
        let has_geometry = places.iter().any(|form| form.relation != Relation::Held);
        if !has_geometry {
            add_new(&mut places, from_names(domain));
        }
        add_new(&mut places, from_patterns(domain));
        if places.iter().all(|form| form.relation != Relation::Held) {
            let carried = from_exchange(domain, &places);
            add_new(&mut places, carried);
        }
        places.retain(|form| has_entities(domain, *form));
        // The innermost relation first: an entity on a table in a kitchen is shown on the table.
        places.sort_by_key(|form| form.relation);
        let single = single_predicates(domain);
        let (robot_places, robot_states) = single
            .into_iter()
            .partition(|predicate| !can_hold_moving(domain, &places, *predicate));
        let mut actors: Vec<TypeId> = domain.actions.iter().filter_map(actor_type).collect();
        actors.sort_unstable();
        actors.dedup();
        Self {
            states: state_forms(domain),
            numbers: shown_functions(domain),
            places,
            robot_places,
            robot_states,
            actors,
        }
    }

    /// Returns true if a scene has a box for the robot: the domain says where it is, or that it carries something.
    pub(super) fn has_robot(&self) -> bool {
        let carries = self.places.iter().any(|form| form.place.is_none());
        carries || !self.robot_places.is_empty() || !self.robot_states.is_empty()
    }
}

/// Adds the forms of predicates that have none yet.
fn add_new(forms: &mut Vec<PlaceForm>, new: Vec<PlaceForm>) {
    for form in new {
        if forms.iter().all(|known| known.predicate != form.predicate) {
            forms.push(form);
        }
    }
}

fn from_geometry(domain: &Domain) -> Vec<PlaceForm> {
    let mut forms = Vec::new();
    for word in &domain.states {
        let says = |relation| word.relations.contains(&relation);
        let relation = match (says(SpatialRelation::On), says(SpatialRelation::Inside)) {
            (true, true) => Relation::At,
            (true, false) => Relation::On,
            (false, true) => Relation::In,
            (false, false) if says(SpatialRelation::Held) => Relation::Held,
            (false, false) => continue,
        };
        add_new(&mut forms, form_of_word(word, relation).into_iter().collect());
    }
    forms
}

/// Returns the form of a state word; none for a word about one entity alone, unless it says that the robot holds it.
fn form_of_word(word: &StateWord, relation: Relation) -> Option<PlaceForm> {
    let mut positions = word.places();
    let subject = positions.next()??;
    let place = positions.next().flatten();
    (place.is_some() || relation == Relation::Held).then_some(PlaceForm {
        predicate: word.atom.predicate,
        subject,
        place,
        relation,
    })
}

/// Returns the predicates that a derivation gives to entities that are named after another one.
fn from_patterns(domain: &Domain) -> Vec<PlaceForm> {
    let named = domain.derivations.iter().filter(|own| own.pattern.is_some());
    let literals = named.flat_map(|own| own.literals.iter().filter(|literal| literal.holds));
    let part = |atom: &Atom| {
        let position = |slot| atom.terms.iter().position(|term| *term == Term::Variable(slot));
        (atom.terms.len() == 2).then_some(PlaceForm {
            predicate: atom.predicate,
            subject: position(0)?,
            place: Some(position(1)?),
            relation: Relation::Part,
        })
    };
    literals.filter_map(|literal| part(&literal.atom)).collect()
}

fn from_names(domain: &Domain) -> Vec<PlaceForm> {
    let named = |(index, predicate): (usize, &longstep_core::model::Predicate)| {
        let id = PredicateId::new(index);
        if predicate.parameters.len() != 2 || domain.words(id).event {
            return None;
        }
        let mut parts = predicate.name.split(['-', '_']);
        let relation = parts
            .find_map(|part| PLACE_NAMES.iter().find(|(name, _)| *name == part))?
            .1;
        let form = PlaceForm {
            predicate: id,
            subject: 0,
            place: Some(1),
            relation,
        };
        Some(match state_word(domain, id) {
            Some(word) => form_of_word(word, relation).unwrap_or(form),
            None => form,
        })
    };
    domain.predicates.iter().enumerate().filter_map(named).collect()
}

/// Returns the predicates that an action gives to an entity whose place it takes away, and another action takes away when
/// it gives the entity a place again.
fn from_exchange(domain: &Domain, places: &[PlaceForm]) -> Vec<PlaceForm> {
    let mut forms = Vec::new();
    for (index, predicate) in domain.predicates.iter().enumerate() {
        let id = PredicateId::new(index);
        let arity = predicate.parameters.len();
        if !(1..=2).contains(&arity) || domain.words(id).event || places.iter().any(|form| form.predicate == id) {
            continue;
        }
        let exchanges = |gives: bool| {
            let mut actions = domain.actions.iter();
            actions.any(|action| changes_against_place(action, places, id, gives))
        };
        if exchanges(true) && exchanges(false) {
            forms.push(PlaceForm {
                predicate: id,
                subject: 0,
                place: (arity == 2).then_some(1),
                relation: Relation::Held,
            });
        }
    }
    forms
}

/// Returns true if the action gives (or takes away) a fact of the predicate and does the opposite to the place of the same
/// entity.
fn changes_against_place(action: &Action, places: &[PlaceForm], predicate: PredicateId, gives: bool) -> bool {
    let of_predicate = |effect: &&Effect| effect.atom.predicate == predicate && effect.adds == gives;
    let mut own = action.effects.iter().filter(of_predicate);
    own.any(|effect| {
        let entity = effect.atom.terms[0];
        let is_parameter = matches!(entity, Term::Variable(slot) if slot < action.parameters.len());
        let opposite = |other: &Effect, form: &PlaceForm| {
            other.adds != gives
                && other.atom.predicate == form.predicate
                && form.place.is_some()
                && other.atom.terms[form.subject] == entity
        };
        let moves = |other: &Effect| places.iter().any(|form| opposite(other, form));
        is_parameter && action.effects.iter().any(moves)
    })
}

/// Returns true if both arguments are entities that a scene shows, no values.
fn has_entities(domain: &Domain, form: PlaceForm) -> bool {
    let parameters = &domain.predicate(form.predicate).parameters;
    let is_value = |kind: TypeId| domain.values.iter().any(|value| domain.types.is_a(kind, value.kind));
    let positions = [Some(form.subject), form.place];
    !positions
        .into_iter()
        .flatten()
        .any(|position| is_value(parameters[position].kind))
}

/// Returns the unary predicates that are true of one entity at a time: each action that makes one true makes it false
/// elsewhere.
fn single_predicates(domain: &Domain) -> Vec<PredicateId> {
    let ids = (0..domain.predicates.len()).map(PredicateId::new);
    let is_single = |id: &PredicateId| {
        let words = domain.words(*id);
        if domain.predicate(*id).parameters.len() != 1 || words.event || domain.is_sensed(*id) {
            return false;
        }
        let adds = |action: &&Action| {
            let mut effects = action.effects.iter();
            effects.any(|effect| effect.adds && effect.atom.predicate == *id)
        };
        let mut adding = domain.actions.iter().filter(adds).peekable();
        adding.peek().is_some() && adding.all(|action| moves_fact(action, *id))
    };
    ids.filter(is_single).collect()
}

/// Returns true if the action makes one fact of the predicate true, and a fact about another entity false.
fn moves_fact(action: &Action, predicate: PredicateId) -> bool {
    let own = || {
        action
            .effects
            .iter()
            .filter(|effect| effect.atom.predicate == predicate)
    };
    let mut added = own().filter(|effect| effect.adds);
    let (Some(first), None) = (added.next(), added.next()) else {
        return false;
    };
    let is_bound = |term: Term| !matches!(term, Term::Variable(slot) if slot >= action.parameters.len());
    is_bound(first.atom.terms[0]) && own().any(|effect| !effect.adds && effect.atom.terms != first.atom.terms)
}

/// Returns true if an entity that moves can be what the predicate is true of.
fn can_hold_moving(domain: &Domain, places: &[PlaceForm], predicate: PredicateId) -> bool {
    let kind = domain.predicate(predicate).parameters[0].kind;
    let moving = places.iter().filter(|form| domain.words(form.predicate).fluent);
    let overlaps = |form: &PlaceForm| {
        let moved = domain.predicate(form.predicate).parameters[form.subject].kind;
        domain.types.is_a(moved, kind) || domain.types.is_a(kind, moved)
    };
    moving.into_iter().any(overlaps)
}

fn actor_type(action: &Action) -> Option<TypeId> {
    action.actor.map(|parameter| action.parameters[parameter].kind)
}

/// Returns the predicates that a scene shows as states: those that can change, and those that an environment says.
fn state_forms(domain: &Domain) -> Vec<StateForm> {
    let shown = |id: &PredicateId| domain.words(*id).fluent || state_word(domain, *id).is_some();
    let form = |id: PredicateId| {
        let word = state_word(domain, id).and_then(|word| word.places().next()?);
        let arity = domain.predicate(id).parameters.len();
        StateForm {
            predicate: id,
            subject: (arity > 0).then(|| word.unwrap_or(0)),
            event: domain.words(id).event,
        }
    };
    let ids = (0..domain.predicates.len()).map(PredicateId::new);
    ids.filter(shown).map(form).collect()
}

/// Returns the functions that a scene shows: those that can change, and those about one entity.
fn shown_functions(domain: &Domain) -> Vec<FunctionId> {
    let ids = (0..domain.functions.len()).map(FunctionId::new);
    let is_shown = |id: &FunctionId| {
        let function = domain.function(*id);
        function.changes || function.parameters.len() == 1
    };
    ids.filter(is_shown).collect()
}
