//! What a step reads and changes.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::domain::Domain;
use crate::plan::Step;
use crate::search::{Formula, GroundAction, Literal, Operator, ground_step};
use crate::world::{EntityId, Fact, State, World};

/// What a step depends on and what it changes, done in a certain state.
#[derive(Debug, Clone)]
pub(super) struct Footprint {
    /// Facts that let it be done, and that let its effects happen or not.
    reads: FxHashSet<Fact>,
    /// What it makes true or false.
    writes: FxHashMap<Fact, bool>,
    /// The things that it handles.
    things: Vec<EntityId>,
}

/// A step with its arguments, about to be done in a certain state.
pub(super) struct Grounded {
    operator: Operator,
    /// The facts that its literals number, and whether each holds.
    facts: Vec<(Fact, bool)>,
    things: Vec<EntityId>,
}

impl Grounded {
    pub(super) fn of(domain: &Domain, world: &World, state: &State, step: &Step) -> Self {
        let ground = GroundAction {
            action: step.action,
            arguments: step.arguments.clone(),
        };
        let (operator, facts) = ground_step(domain, world, ground);
        let handled = |entity: &EntityId| world.is_of_kind(*entity, domain.environment.object);
        Self {
            operator,
            facts: facts.into_iter().map(|fact| (fact, state.holds(fact))).collect(),
            things: step.arguments.iter().copied().filter(handled).collect(),
        }
    }

    fn fact(&self, literal: Literal) -> Fact {
        self.facts[literal.fact as usize].0
    }

    fn holds(&self, literal: Literal) -> bool {
        self.facts[literal.fact as usize].1 == literal.holds
    }

    /// What it makes true or false.
    pub(super) fn writes(&self) -> FxHashMap<Fact, bool> {
        let mut writes = FxHashMap::default();
        for effect in &self.operator.effects {
            if effect.condition.holds(&|literal| self.holds(literal)) {
                // What is both taken away and given stays.
                let written = writes.entry(self.fact(effect.literal)).or_insert(false);
                *written |= effect.literal.holds;
            }
        }
        writes
    }

    /// The same with what it depends on: of several reasons why a condition holds or not, one that nobody else can
    /// change, if there is one.
    pub(super) fn footprint(&self, contended: &FxHashSet<Fact>) -> Footprint {
        let effects = self.operator.effects.iter().map(|effect| &effect.condition);
        let conditions = std::iter::once(&self.operator.precondition).chain(effects);
        let reasons = conditions.flat_map(|condition| self.because(condition, contended).1);
        Footprint {
            reads: reasons.map(|literal| self.fact(literal)).collect(),
            writes: self.writes(),
            things: self.things.clone(),
        }
    }

    /// Whether a formula holds, and literals that alone make it so.
    fn because(&self, formula: &Formula, contended: &FxHashSet<Fact>) -> (bool, Vec<Literal>) {
        let (parts, decisive) = match formula {
            Formula::Literal(literal) => return (self.holds(*literal), vec![*literal]),
            // One part that fails decides a conjunction, one that holds a disjunction; else all of them do.
            Formula::And(parts) => (parts, false),
            Formula::Or(parts) => (parts, true),
        };
        let reasons: Vec<(bool, Vec<Literal>)> = parts.iter().map(|part| self.because(part, contended)).collect();
        let deciding = reasons.iter().filter(|(value, _)| *value == decisive);
        let weight = |why: &[Literal]| {
            let open = why.iter().filter(|literal| contended.contains(&self.fact(**literal)));
            (open.count(), why.len())
        };
        match deciding.min_by_key(|(_, why)| weight(why)) {
            Some((_, why)) => (decisive, why.clone()),
            None => (!decisive, reasons.into_iter().flat_map(|(_, why)| why).collect()),
        }
    }
}

impl Footprint {
    /// Whether the order of the two does not matter, and they may overlap.
    pub(super) fn is_independent_of(&self, other: &Self) -> bool {
        let disturbs = |one: &Self, other: &Self| {
            one.writes.iter().any(|(fact, holds)| {
                other.reads.contains(fact) || other.writes.get(fact).is_some_and(|written| written != holds)
            })
        };
        let shared = self.things.iter().any(|thing| other.things.contains(thing));
        !shared && !disturbs(self, other) && !disturbs(other, self)
    }
}

/// Whether two steps, both about to be done in this state, can be done in either order or overlap: they handle
/// nothing together, and neither changes what lets the other be done or what that changes.
///
/// Two steps that both make the same fact true, or both false, do not disturb each other by that.
///
/// ```
/// use longstep::{arms, domain, json, plan::Step, world};
/// let domain = domain::shipped("household-dual").unwrap().unwrap();
/// let text = r#"{"assets": ["<bench>", "<rack>"], "objects": ["<jar>"], "object_states": {"<jar>": "on_something(<bench>)"}}"#;
/// let environment = world::Environment::from_json(text).unwrap();
/// let world = world::read(&domain, &environment, "env.json", text, &json::Path::default()).unwrap();
/// let (move_hand, _) = domain.action_ids().find(|(_, action)| action.name == "move-hand").unwrap();
/// let to = |hand: &str, place: &str| {
///     let arguments = [hand, place].map(|name| world.find(name).unwrap()).to_vec();
///     Step::explained(&domain, &world, move_hand, arguments)
/// };
/// let both = |one, other| arms::independent(&domain, &world, &world.state, &one, &other);
/// assert!(both(to("right", "<jar>"), to("left", "<rack>")));
/// assert!(!both(to("right", "<jar>"), to("right", "<rack>")));
/// assert!(!both(to("right", "<jar>"), to("left", "<jar>")), "both reach for one thing");
/// ```
pub fn independent(domain: &Domain, world: &World, state: &State, one: &Step, other: &Step) -> bool {
    let (one, other) = (Grounded::of(domain, world, state, one), Grounded::of(domain, world, state, other));
    let written = |by: &Grounded| by.writes().into_keys().collect();
    one.footprint(&written(&other)).is_independent_of(&other.footprint(&written(&one)))
}
