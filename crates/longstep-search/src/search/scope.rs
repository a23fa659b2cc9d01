//! Scope of a search: the actions and entities that it considers.
//!
//! Grounding takes time and memory for every action with every combination of arguments, which is too much in a large
//! world such as a warehouse. Two measures limit it. First, actions without an effect on any required predicate are
//! left out; this loses no plan (see `relevance`, which repeats it for ground actions). Second, in a large world only
//! entities related to the goal are considered first: those that it mentions, their places, their parts, and those that
//! its conditions name by type. A plan that is found there is then simulated in the whole world.

use rustc_hash::{FxHashMap, FxHashSet};

use super::Wanted;
use longstep_model::effort;
use longstep_model::model::{
    Action, Atom, Bindings, Condition, Domain, EntityId, FunctionId, Moment, NumberTest, PredicateId, Slot, Term,
    TypeId, When, World, broken_bindings, ever_candidates,
};
use longstep_verify::verify::Milestone;

/// Maximum number of ground effects for which the whole world is grounded.
// About 120 entities in the domain `virtualhome`.
const BEARABLE: u64 = 300_000;

/// Maximum number of entities that an existential condition adds to the scope.
const MANY: usize = 50;

/// The actions and entities that a search considers.
#[derive(Debug, Clone)]
pub(crate) struct Scope {
    /// By action: true if it may be relevant.
    pub(super) actions: Vec<bool>,
    /// By type: the entities in scope, sorted.
    by_kind: Vec<Vec<EntityId>>,
    /// True if the scope has all entities of the world.
    pub(crate) whole: bool,
}

impl Scope {
    /// Returns the scope with all entities, and the actions that may be relevant to the required conditions and facts.
    pub(crate) fn whole(world: &World, requirements: &Requirements) -> Self {
        let domain = world.domain();
        let kinds = 0..domain.types.count();
        Self {
            actions: requirements.actions(domain),
            by_kind: kinds.map(|kind| world.of_kind(TypeId::new(kind)).to_vec()).collect(),
            whole: true,
        }
    }

    /// Returns the scope around the entities of the goal; if `far`, with the entities that share their places.
    pub(crate) fn around(&self, world: &World, requirements: &Requirements, about: &[EntityId], far: bool) -> Self {
        let mut things = requirements.by_kind(world, &self.actions);
        things.extend(about);
        let near = around(world, things, false);
        if far {
            self.only(&around(world, near, true))
        } else {
            self.only(&near)
        }
    }

    /// Returns true if grounding this scope stays within the limit.
    pub(crate) fn is_bearable(&self, world: &World) -> bool {
        self.effort(world) <= BEARABLE
    }

    /// Returns the number of entities.
    pub(crate) fn len(&self) -> usize {
        self.of_kind(TypeId::OBJECT).len()
    }

    fn only(&self, things: &FxHashSet<EntityId>) -> Self {
        let kept = |all: &Vec<EntityId>| all.iter().copied().filter(|thing| things.contains(thing)).collect();
        let by_kind: Vec<Vec<EntityId>> = self.by_kind.iter().map(kept).collect();
        Self {
            actions: self.actions.clone(),
            whole: by_kind == self.by_kind,
            by_kind,
        }
    }

    /// Returns the entities of a type, sorted.
    pub(super) fn of_kind(&self, kind: TypeId) -> &[EntityId] {
        &self.by_kind[kind.index()]
    }

    /// Returns true if the entity is in scope.
    pub(crate) fn contains(&self, thing: EntityId) -> bool {
        self.whole || self.of_kind(TypeId::OBJECT).binary_search(&thing).is_ok()
    }

    /// Returns an upper bound on the number of ground effects.
    fn effort(&self, world: &World) -> u64 {
        let actions = world.domain().actions.iter().zip(&self.actions);
        let actions = actions.filter(|(_, matters)| **matters);
        actions
            .map(|(action, _)| self.effort_of(world, action))
            .fold(0, u64::saturating_add)
    }

    fn effort_of(&self, world: &World, action: &Action) -> u64 {
        let parameters = action.parameters.iter().enumerate();
        let choices = parameters.fold(1, |all: u64, (slot, parameter)| {
            let choices = most_choices(world, &action.precondition, slot).map_or(u64::MAX, |most| most as u64);
            all.saturating_mul(choices.min(self.count(parameter.kind)))
        });
        let effects = action.effects.iter().map(|effect| {
            // A variable that must equal another term adds no instances.
            let free = effect
                .forall
                .iter()
                .filter(|(slot, _)| !fixed(&effect.condition, *slot));
            self.instances(free)
        });
        let numeric = action.numeric.iter().map(|effect| self.instances(&effect.forall));
        choices.saturating_mul(effects.chain(numeric).fold(1, u64::saturating_add))
    }

    /// Returns the number of instances of a quantifier over these variables.
    fn instances<'v>(&self, variables: impl IntoIterator<Item = &'v (Slot, TypeId)>) -> u64 {
        let variables = variables.into_iter();
        variables.fold(1, |all: u64, (_, kind)| all.saturating_mul(self.count(*kind)))
    }

    fn count(&self, kind: TypeId) -> u64 {
        self.of_kind(kind).len() as u64
    }
}

/// Returns the largest number of entities for a slot that static facts allow once the slots before it are bound; none if
/// they allow any.
fn most_choices(world: &World, condition: &Condition, slot: usize) -> Option<usize> {
    let guards = condition.conjuncts().filter_map(|part| match part {
        Condition::Atom { atom, holds: true, at } if is_static(world, atom, *at) => Some((atom, *at)),
        _ => None,
    });
    let guards = guards.filter(|(atom, _)| atom.terms.contains(&Term::Variable(slot)));
    guards.map(|(atom, at)| largest_group(world, atom, at, slot)).min()
}

/// Returns the largest number of facts of an atom that agree in the terms before the slot. It bounds the choices without an
/// enumeration of the earlier slots.
fn largest_group(world: &World, atom: &Atom, at: When, slot: usize) -> usize {
    let is_bound = |term: &Term| !matches!(term, Term::Variable(variable) if *variable >= slot);
    let bound: Vec<usize> = (0..atom.terms.len())
        .filter(|place| is_bound(&atom.terms[*place]))
        .collect();
    let state = world.past(at).unwrap_or(&world.state);
    let facts = state.of_predicate(atom.predicate);
    effort::spend(1 + facts.len());
    let mut counts: FxHashMap<Vec<EntityId>, usize> = FxHashMap::default();
    for fact in facts {
        *counts
            .entry(bound.iter().map(|place| fact.argument(*place)).collect())
            .or_default() += 1;
    }
    counts.into_values().max().unwrap_or(0)
}

/// Returns true if the condition requires the slot to equal some term.
fn fixed(condition: &Condition, slot: usize) -> bool {
    let variable = Term::Variable(slot);
    condition.conjuncts().any(
        |part| matches!(part, Condition::Equal { left, right, holds: true } if *left == variable || *right == variable),
    )
}

/// Returns the literals of a condition by predicate.
fn literals(condition: &Condition) -> impl Iterator<Item = (PredicateId, bool)> {
    condition.atoms().map(|(atom, holds)| (atom.predicate, holds))
}

/// Returns the numeric functions in a condition.
fn functions(condition: &Condition) -> impl Iterator<Item = FunctionId> {
    condition.numbers().flat_map(NumberTest::functions)
}

/// The requirements of a goal: literals by predicate, and the conditions themselves.
#[derive(Debug, Clone, Default)]
pub(crate) struct Requirements {
    literals: FxHashSet<(PredicateId, bool)>,
    functions: FxHashSet<FunctionId>,
    conditions: Vec<(Condition, Vec<EntityId>)>,
}

impl Requirements {
    /// Collects the requirements of the wanted conditions, of the stages and of the `always` rules.
    ///
    /// A plan may have to delay a stage, or to keep a rule broken that is broken at first or by a sensing outcome. So both
    /// polarities of their literals are required (see `relevance`).
    pub(crate) fn of<'w>(
        world: &World,
        wanted: impl IntoIterator<Item = &'w Wanted>,
        stages: &[Vec<Milestone>],
    ) -> Self {
        let domain = world.domain();
        let mut requirements = Self::default();
        for wanted in wanted {
            requirements.condition(&wanted.condition, &wanted.bindings);
        }
        for Milestone { wanted, .. } in stages.iter().flatten() {
            requirements.condition(&wanted.condition, &wanted.bindings);
            if stages.len() > 1 {
                requirements.both(&wanted.condition);
            }
        }
        for (_, rule) in world.always_rules() {
            requirements.condition(&rule.everywhere(), &[]);
            let mut atoms = rule.condition.atoms();
            let is_revealed = atoms.any(|(atom, _)| domain.is_sensed(atom.predicate));
            if is_revealed || !broken_bindings(rule, world, &world.state).is_empty() {
                requirements.both(&rule.condition);
            }
        }
        requirements
    }

    /// Adds both polarities of the literals of a condition.
    fn both(&mut self, condition: &Condition) {
        let predicates = condition.atoms().map(|(atom, _)| atom.predicate);
        self.literals
            .extend(predicates.flat_map(|predicate| [(predicate, true), (predicate, false)]));
    }

    /// Adds a condition whose first slots are bound.
    fn condition(&mut self, condition: &Condition, bindings: &[EntityId]) {
        let atoms = condition.atoms().count();
        if !effort::spend(1 + (atoms + condition.numbers().count()) / 4) {
            return;
        }
        self.literals.extend(literals(condition));
        self.functions.extend(functions(condition));
        // What only compares numbers describes no entity.
        if atoms == 0 {
            return;
        }
        self.conditions.push((condition.clone(), bindings.to_vec()));
    }

    /// Adds a literal of a predicate.
    pub(crate) fn literal(&mut self, predicate: PredicateId, holds: bool) {
        self.literals.insert((predicate, holds));
    }

    /// Adds a numeric function.
    pub(crate) fn function(&mut self, function: FunctionId) {
        self.functions.insert(function);
    }

    /// By action: true if it changes or senses a required literal, directly or for another relevant action.
    fn actions(&self, domain: &Domain) -> Vec<bool> {
        let mut required = self.literals.clone();
        let mut numbers = self.functions.clone();
        let mut matters = vec![false; domain.actions.len()];
        loop {
            let before = required.len() + numbers.len();
            for (action, matters) in domain.actions.iter().zip(&mut matters) {
                for effect in &action.numeric {
                    if !numbers.contains(&effect.fluent.function) {
                        continue;
                    }
                    numbers.extend(effect.value.functions());
                    // A change may be wanted or not, so both values of its condition matter.
                    required.extend(literals(&effect.condition).flat_map(|(own, _)| [(own, true), (own, false)]));
                    numbers.extend(functions(&effect.condition));
                    if !std::mem::replace(matters, true) {
                        required.extend(literals(&action.precondition));
                    }
                }
                for effect in &action.effects {
                    if !required.contains(&(effect.atom.predicate, effect.adds)) {
                        continue;
                    }
                    required.extend(literals(&effect.condition));
                    if !std::mem::replace(matters, true) {
                        required.extend(literals(&action.precondition));
                    }
                }
                let senses = action
                    .senses
                    .iter()
                    .any(|atom| required.contains(&(atom.predicate, true)));
                if senses && !std::mem::replace(matters, true) {
                    required.extend(literals(&action.precondition));
                    // Sensing is applicable only while none of its outcomes is known.
                    required.extend(action.senses.iter().map(|atom| (atom.predicate, false)));
                }
                if *matters {
                    numbers.extend(functions(&action.precondition));
                    numbers.extend(action.effects.iter().flat_map(|effect| functions(&effect.condition)));
                }
                // The conditions under which an effect deletes a required literal are relevant too.
                for effect in action.effects.iter().filter(|_| *matters) {
                    if required.contains(&(effect.atom.predicate, !effect.adds)) {
                        required.extend(literals(&effect.condition).map(|(predicate, holds)| (predicate, !holds)));
                    }
                }
            }
            if required.len() + numbers.len() == before {
                return matters;
            }
        }
    }

    /// Returns the few entities that conditions describe by static facts, such as some tap or some bin.
    fn by_kind(&self, world: &World, actions: &[bool]) -> FxHashSet<EntityId> {
        let mut found = FxHashSet::default();
        for (condition, bindings) in &self.conditions {
            named(world, condition, 0, &mut bindings.clone(), &mut found);
        }
        for (action, _) in world
            .domain()
            .actions
            .iter()
            .zip(actions)
            .filter(|(_, matters)| **matters)
        {
            let first = world.of_kind(TypeId::OBJECT).first().copied();
            // Any entity stands in for the parameters, so that quantified variables have their own slots.
            let mut bindings: Bindings = first.iter().copied().cycle().take(action.parameters.len()).collect();
            if bindings.len() == action.parameters.len() {
                named(
                    world,
                    &action.precondition,
                    action.parameters.len(),
                    &mut bindings,
                    &mut found,
                );
            }
        }
        found
    }
}

/// Returns true if no action changes the facts of an atom.
fn is_static(world: &World, atom: &Atom, at: When) -> bool {
    at != When::Now || !world.domain().words(atom.predicate).fluent
}

fn has_slot_below(atom: &Atom, limit: usize) -> bool {
    let mut terms = atom.terms.iter();
    terms.any(|term| matches!(term, Term::Variable(slot) if *slot < limit))
}

/// Adds the entities that an existential condition may be about, up to [`MANY`]. Nothing is known about the first `unbound`
/// variables.
fn named(
    world: &World,
    condition: &Condition,
    unbound: usize,
    bindings: &mut Bindings,
    found: &mut FxHashSet<EntityId>,
) {
    let unchanging = |atom: &Atom, at: When| is_static(world, atom, at) && !has_slot_below(atom, unbound);
    match condition {
        Condition::And(parts) | Condition::Or(parts) => {
            parts
                .iter()
                .for_each(|part| named(world, part, unbound, bindings, found));
        }
        Condition::Exists(slot, kind, inner) => {
            let moment = Moment {
                world,
                state: &world.state,
            };
            let things = ever_candidates(moment, (*slot, *kind), inner, true, bindings, &unchanging);
            for thing in things.into_iter().flatten().take(MANY) {
                if !effort::spend(1) {
                    return;
                }
                found.insert(thing);
                bindings.push(thing);
                named(world, inner, unbound, bindings, found);
                bindings.pop();
            }
        }
        Condition::Forall(..) | Condition::Atom { .. } | Condition::Equal { .. } | Condition::Number(_) => {}
    }
}

/// Extends the entities with those they are related to: their places, their parts, and held objects. If `far`, also
/// entities that share their places.
fn around(world: &World, things: FxHashSet<EntityId>, far: bool) -> FxHashSet<EntityId> {
    let domain = world.domain();
    let mut found = things;
    for index in 0..domain.predicates.len() {
        let facts = world.state.of_predicate(PredicateId::new(index));
        // So few facts of a fluent predicate are mostly about the robot, such as what it holds.
        if facts.len() <= 3 && domain.predicate_words[index].fluent {
            found.extend(facts.iter().flat_map(|fact| domain.arguments(*fact)));
        }
    }
    let mut queue: Vec<EntityId> = found.iter().copied().collect();
    queue.sort_unstable();
    while let Some(thing) = queue.pop() {
        for (index, predicate) in domain
            .predicates
            .iter()
            .enumerate()
            .filter(|(_, p)| p.parameters.len() > 1)
        {
            let id = PredicateId::new(index);
            let facts = world.state.of_first(id, thing);
            effort::spend(1 + facts.len());
            for fact in facts {
                queue.extend(domain.arguments(*fact).filter(|other| found.insert(*other)));
            }
            let backwards = far || !domain.words(id).fluent;
            if backwards && predicate.parameters.len() == 2 {
                if !effort::spend(world.state.of_predicate(id).len() / 8) {
                    return found;
                }
                let of = world
                    .state
                    .of_predicate(id)
                    .iter()
                    .filter(|fact| fact.argument(1) == thing);
                // An entity to which more facts refer, such as a floor, would bring most of the world into scope.
                let others: Vec<EntityId> = of.map(|fact| fact.argument(0)).take(MANY + 1).collect();
                if others.len() <= MANY {
                    // Includes entities that share a place, but not those that share a place with them.
                    for other in others {
                        if found.insert(other) && !domain.words(id).fluent {
                            queue.push(other);
                        }
                    }
                }
            }
        }
    }
    found
}
