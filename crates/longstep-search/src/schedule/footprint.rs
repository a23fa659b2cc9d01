//! Footprints: the facts that a step reads and writes.

use rustc_hash::{FxHashMap, FxHashSet};

use crate::search::{Formula, GroundAction, Literal, Meaning, Operator, ground_step};
use longstep_model::model::{EntityId, Fact, Fluent, State, World, assigned};
use longstep_verify::plan::Step;

/// The facts that a step reads and writes when executed in a given state.
#[derive(Debug, Clone)]
pub(super) struct Footprint {
    /// The facts that decide its precondition and the conditions of its effects, with their values.
    reads: FxHashMap<Fact, bool>,
    writes: Writes,
    /// The numbers that it reads, and those that it changes.
    numbers: StepNumbers,
    /// The objects among its arguments.
    things: Vec<EntityId>,
}

/// The numbers that a step reads and changes.
#[derive(Debug, Clone, Default)]
struct StepNumbers {
    reads: FxHashSet<Fluent>,
    writes: FxHashSet<Fluent>,
}

impl StepNumbers {
    /// Returns the numbers of a step in a state.
    fn of(world: &World, state: &State, step: &Step) -> Self {
        let action = world.domain().action(step.action);
        let mut numbers = Self::default();
        for (fluent, _) in assigned(world, state, &action.numeric, &mut step.arguments.clone()) {
            numbers.writes.insert(fluent);
        }
        numbers
    }

    /// Returns true if one of the steps changes a number that the other reads or changes.
    fn interfere(&self, other: &Self) -> bool {
        let touches =
            |numbers: &Self, fluent: &Fluent| numbers.reads.contains(fluent) || numbers.writes.contains(fluent);
        self.writes.iter().any(|own| touches(other, own)) || other.writes.iter().any(|own| touches(self, own))
    }
}

/// The facts that a step writes, with their values.
type Writes = FxHashMap<Fact, Write>;

#[derive(Debug, Clone, Copy)]
struct Write {
    holds: bool,
    changed: bool,
}

/// Facts with a value that another actor makes true or false.
pub(super) type Contended = FxHashSet<(Fact, bool)>;

/// A ground step in the state before its execution.
pub(super) struct Grounded {
    operator: Operator,
    /// The meanings that its literals number, with their values.
    facts: Vec<(Meaning, bool)>,
    /// The numbers that its effects read and change.
    numbers: StepNumbers,
    things: Vec<EntityId>,
}

impl Grounded {
    pub(super) fn of(world: &World, state: &State, step: &Step) -> Self {
        let ground = GroundAction {
            action: step.action,
            arguments: step.arguments.clone(),
        };
        let (operator, facts) = ground_step(world, ground);
        let handled = |entity: &EntityId| world.is_of_kind(*entity, world.domain().environment.object);
        Self {
            numbers: StepNumbers::of(world, state, step),
            operator,
            facts: facts.into_iter().map(|own| (own.clone(), own.holds(state))).collect(),
            things: step.arguments.iter().copied().filter(handled).collect(),
        }
    }

    fn holds(&self, literal: Literal) -> bool {
        self.facts[literal.fact as usize].1 == literal.holds
    }

    fn writes(&self) -> Writes {
        let mut writes = Writes::default();
        for effect in &self.operator.effects {
            if effect.condition.holds(&|literal| self.holds(literal)) {
                let (Meaning::Fact(fact), held) = self.facts[effect.literal.fact as usize] else {
                    continue;
                };
                let before = writes.get(&fact).is_some_and(|write: &Write| write.holds);
                // A fact both added and deleted is added.
                let holds = effect.literal.holds || before;
                let changed = holds != held;
                writes.insert(fact, Write { holds, changed });
            }
        }
        writes
    }

    /// Returns the values that no other step can rely on: those that the step ends, and those that it newly makes.
    pub(super) fn contends(&self) -> impl Iterator<Item = (Fact, bool)> {
        let values = |(fact, write): (Fact, Write)| {
            let made = write.changed.then_some((fact, write.holds));
            [(fact, !write.holds)].into_iter().chain(made)
        };
        self.writes().into_iter().flat_map(values)
    }

    /// Returns the footprint of the step. If a condition holds or fails for several reasons, one without contended
    /// facts is preferred.
    pub(super) fn footprint(&self, contended: &Contended) -> Footprint {
        let effects = self.operator.effects.iter().map(|effect| &effect.condition);
        let numeric = self.operator.numeric.iter().map(|effect| &effect.condition);
        let conditions = std::iter::once(&self.operator.precondition)
            .chain(effects)
            .chain(numeric);
        let mut numbers = self.numbers.clone();
        let mut reads = FxHashMap::default();
        for literal in conditions.flat_map(|condition| self.because(condition, contended).1) {
            match &self.facts[literal.fact as usize] {
                (Meaning::Fact(fact), holds) => {
                    reads.insert(*fact, *holds);
                }
                (Meaning::Test(test), _) => test.for_each(&mut |fluent| {
                    numbers.reads.insert(*fluent);
                }),
            }
        }
        Footprint {
            reads,
            numbers,
            writes: self.writes(),
            things: self.things.clone(),
        }
    }

    /// Evaluates a formula; returns its value and literals that suffice for it.
    fn because(&self, formula: &Formula, contended: &Contended) -> (bool, Vec<Literal>) {
        let (parts, decisive) = match formula {
            Formula::Literal(literal) => return (self.holds(*literal), vec![*literal]),
            // One false part decides a conjunction and one true part a disjunction; otherwise all parts do.
            Formula::And(parts) => (parts, false),
            Formula::Or(parts) => (parts, true),
        };
        let reasons: Vec<(bool, Vec<Literal>)> = parts.iter().map(|part| self.because(part, contended)).collect();
        let deciding = reasons.iter().filter(|(value, _)| *value == decisive);
        let weight = |why: &[Literal]| {
            let open = why.iter().filter(|literal| match &self.facts[literal.fact as usize] {
                (Meaning::Fact(fact), holds) => contended.contains(&(*fact, *holds)),
                // Contended values are kept for facts only, so each test counts as one.
                (Meaning::Test(_), _) => true,
            });
            (open.count(), why.len())
        };
        match deciding.min_by_key(|(_, why)| weight(why)) {
            Some((_, why)) => (decisive, why.clone()),
            None => (!decisive, reasons.into_iter().flat_map(|(_, why)| why).collect()),
        }
    }
}

impl Footprint {
    /// Returns true if this step must stay before `later`: both handle an object, or one of them changes a fact or
    /// a number that the other reads or writes.
    pub(super) fn is_needed_before(&self, later: &Self) -> bool {
        let write = |by: &Self, fact: &Fact| by.writes.get(fact).copied();
        let enables =
            |(fact, held): (&Fact, &bool)| write(self, fact).is_some_and(|write| write.changed || write.holds != *held);
        let disturbs = |(fact, held): (&Fact, &bool)| write(later, fact).is_some_and(|write| write.holds != *held);
        let differ = |(fact, own): (&Fact, &Write)| write(later, fact).is_some_and(|other| other.holds != own.holds);
        self.things.iter().any(|thing| later.things.contains(thing))
            || later.reads.iter().any(enables)
            || self.reads.iter().any(disturbs)
            || self.writes.iter().any(differ)
            || self.numbers.interfere(&later.numbers)
    }
}

/// Returns true if two steps, both applicable in this state, can be executed in either order or overlap: they share no
/// object, and neither changes a fact that the other reads or writes.
///
/// Two steps that give a fact the same value do not conflict, and neither does a step that writes the current value of
/// a fact.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::schedule;
/// use longstep_verify::plan::Step;
/// let domain = domain::shipped("household-dual").unwrap().unwrap();
/// let text = r#"{"assets": ["<bench>", "<rack>"], "objects": ["<jar>"], "object_states": {"<jar>": "on_something(<bench>)"}}"#;
/// let world = environment::parse(&domain, "env.json", text).unwrap();
/// let (move_hand, _) = domain.action_ids().find(|(_, action)| action.name == "move-hand").unwrap();
/// let to = |hand: &str, place: &str| {
///     let arguments = [hand, place].map(|name| world.find(name).unwrap()).to_vec();
///     Step::explained(&world, move_hand, arguments)
/// };
/// let both = |one, other| schedule::independent(&world, &world.state, &one, &other);
/// assert!(both(to("right", "<jar>"), to("left", "<rack>")));
/// assert!(!both(to("right", "<jar>"), to("right", "<rack>")));
/// assert!(!both(to("right", "<jar>"), to("left", "<jar>")), "both reach for one thing");
/// ```
pub fn independent(world: &World, state: &State, one: &Step, other: &Step) -> bool {
    let (one, other) = (Grounded::of(world, state, one), Grounded::of(world, state, other));
    let (first, second) = (
        one.footprint(&other.contends().collect()),
        other.footprint(&one.contends().collect()),
    );
    !first.is_needed_before(&second) && !second.is_needed_before(&first)
}
