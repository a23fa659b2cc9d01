//! Which actions and which things a search looks at.
//!
//! Grounding takes time and memory for every action with every choice of things, which a flat bears and a warehouse
//! does not. Two things keep it small. Actions that change nothing that anything asks for are left out; that loses
//! nothing (see `relevance`, which does the same once more with the arguments known). And in a large world only what
//! surrounds the goal is looked at first: the things that it speaks of, what they are in or on, what belongs to them,
//! and what its conditions name by kind. A plan that is found there is then simulated in the whole world.

use rustc_hash::FxHashSet;

use super::Wanted;
use crate::effort;
use crate::model::{
    Action, Atom, Bindings, Condition, Domain, EntityId, Moment, PredicateId, RuleTime, TypeId, World, ever_candidates,
};

/// Grounding that makes more effects than this is not done for a whole world.
const BEARABLE: u64 = 300_000;

/// Of a kind that a condition names, more things than this are not taken in.
const MANY: usize = 50;

/// The actions and things that a search looks at.
#[derive(Debug, Clone)]
pub(crate) struct Scope {
    /// By action: whether it can matter.
    pub(super) actions: Vec<bool>,
    /// By type: the things, in order.
    by_kind: Vec<Vec<EntityId>>,
    /// Whether these are all the things there are.
    pub(crate) whole: bool,
}

impl Scope {
    /// Every thing, and the actions that can matter to the conditions and facts that are asked for.
    pub(crate) fn whole(domain: &Domain, world: &World, asked: &Asked) -> Self {
        let kinds = 0..domain.types.len();
        Self {
            actions: asked.actions(domain),
            by_kind: kinds.map(|kind| world.of_kind(TypeId::new(kind)).to_vec()).collect(),
            whole: true,
        }
    }

    /// What surrounds the things that are asked about; with those that share their places if it is `far`.
    pub(crate) fn around(&self, domain: &Domain, world: &World, asked: &Asked, about: &[EntityId], far: bool) -> Self {
        let mut things = asked.by_kind(domain, world, &self.actions);
        things.extend(about);
        let near = around(domain, world, things, false);
        if far {
            self.only(&around(domain, world, near, true))
        } else {
            self.only(&near)
        }
    }

    /// Whether grounding what is in scope takes a bearable time.
    pub(crate) fn is_bearable(&self, domain: &Domain) -> bool {
        self.effort(domain) <= BEARABLE
    }

    /// How many things there are.
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

    /// The things of a type, in order.
    pub(super) fn of_kind(&self, kind: TypeId) -> &[EntityId] {
        &self.by_kind[kind.index()]
    }

    /// Whether the thing is looked at.
    pub(crate) fn contains(&self, thing: EntityId) -> bool {
        self.whole || self.of_kind(TypeId::OBJECT).binary_search(&thing).is_ok()
    }

    /// How many effects grounding looks at, at most.
    fn effort(&self, domain: &Domain) -> u64 {
        let count = |kind: TypeId| self.of_kind(kind).len() as u64;
        let product =
            |kinds: &mut dyn Iterator<Item = TypeId>| kinds.fold(1, |all: u64, kind| all.saturating_mul(count(kind)));
        let effort = |action: &Action| {
            let choices = product(&mut action.parameters.iter().map(|parameter| parameter.kind));
            let effects = action.effects.iter().map(|effect| {
                // A variable that has to be one certain thing costs nothing.
                product(
                    &mut effect
                        .forall
                        .iter()
                        .filter(|(slot, _)| !fixed(&effect.condition, *slot))
                        .map(|(_, kind)| *kind),
                )
            });
            choices.saturating_mul(effects.fold(1, u64::saturating_add))
        };
        let actions = domain
            .actions
            .iter()
            .zip(&self.actions)
            .filter(|(_, matters)| **matters);
        actions.map(|(action, _)| effort(action)).fold(0, u64::saturating_add)
    }
}

/// Whether the condition makes the slot equal to something.
fn fixed(condition: &Condition, slot: usize) -> bool {
    use crate::model::Term::Variable;
    match condition {
        Condition::And(parts) => parts.iter().any(|part| fixed(part, slot)),
        Condition::Equal {
            left,
            right,
            holds: true,
        } => *left == Variable(slot) || *right == Variable(slot),
        _ => false,
    }
}

/// What is asked for: literals on the level of predicates, and the conditions themselves.
#[derive(Debug, Clone, Default)]
pub(crate) struct Asked {
    literals: FxHashSet<(PredicateId, bool)>,
    conditions: Vec<(Condition, Vec<EntityId>)>,
}

impl Asked {
    /// Asks for everything that is wanted, and for the rules that hold in every state.
    pub(crate) fn of(domain: &Domain, wanted: &[Wanted]) -> Self {
        let mut asked = Self::default();
        for wanted in wanted {
            asked.condition(&wanted.condition, &wanted.bindings);
        }
        for rule in domain.rules.iter().filter(|rule| rule.time == RuleTime::Always) {
            asked.condition(&rule.everywhere(), &[]);
        }
        asked
    }

    /// Asks for a condition, with its first slots bound.
    fn condition(&mut self, condition: &Condition, bindings: &[EntityId]) {
        condition.for_each_atom(&mut |atom, holds| {
            self.literals.insert((atom.predicate, holds));
        });
        self.conditions.push((condition.clone(), bindings.to_vec()));
    }

    /// Asks for whatever a fact or its opposite can say.
    pub(crate) fn literal(&mut self, predicate: PredicateId, holds: bool) {
        self.literals.insert((predicate, holds));
    }

    /// By action: whether it changes or tells anything that is asked for, by the goal or by another one that does.
    fn actions(&self, domain: &Domain) -> Vec<bool> {
        let mut asked = self.literals.clone();
        let mut matters = vec![false; domain.actions.len()];
        loop {
            let before = asked.len();
            for (action, matters) in domain.actions.iter().zip(&mut matters) {
                for effect in &action.effects {
                    if !asked.contains(&(effect.atom.predicate, effect.adds)) {
                        continue;
                    }
                    effect.condition.for_each_atom(&mut |atom, holds| {
                        asked.insert((atom.predicate, holds));
                    });
                    if !std::mem::replace(matters, true) {
                        action.precondition.for_each_atom(&mut |atom, holds| {
                            asked.insert((atom.predicate, holds));
                        });
                    }
                }
                let told = action.senses.iter().any(|atom| asked.contains(&(atom.predicate, true)));
                if told && !std::mem::replace(matters, true) {
                    action.precondition.for_each_atom(&mut |atom, holds| {
                        asked.insert((atom.predicate, holds));
                    });
                    // It tells something only while nothing is known.
                    asked.extend(action.senses.iter().map(|atom| (atom.predicate, false)));
                }
                // Whether an effect that does harm happens matters as well.
                for effect in action.effects.iter().filter(|_| *matters) {
                    if asked.contains(&(effect.atom.predicate, !effect.adds)) {
                        effect.condition.for_each_atom(&mut |atom, holds| {
                            asked.insert((atom.predicate, !holds));
                        });
                    }
                }
            }
            if asked.len() == before {
                return matters;
            }
        }
    }

    /// The few things that the conditions name by what never changes about them: some tap, some bin.
    fn by_kind(&self, domain: &Domain, world: &World, actions: &[bool]) -> FxHashSet<EntityId> {
        let mut found = FxHashSet::default();
        for (condition, bindings) in &self.conditions {
            named(domain, world, condition, &mut bindings.clone(), &mut found);
        }
        // Of a parameter nothing is known yet, so only conditions without any are looked at.
        for (action, _) in domain.actions.iter().zip(actions).filter(|(_, matters)| **matters) {
            let first = world.of_kind(TypeId::OBJECT).first().copied();
            let mut bindings: Bindings = first.iter().copied().cycle().take(action.parameters.len()).collect();
            if bindings.len() == action.parameters.len() {
                named(domain, world, &action.precondition, &mut bindings, &mut found);
            }
        }
        found
    }
}

/// Adds the things that an existential condition can be about, if they are few.
fn named(
    domain: &Domain,
    world: &World,
    condition: &Condition,
    bindings: &mut Bindings,
    found: &mut FxHashSet<EntityId>,
) {
    let unchanging = |atom: &Atom, initially: bool| initially || !domain.words(atom.predicate).fluent;
    match condition {
        Condition::And(parts) | Condition::Or(parts) => {
            parts
                .iter()
                .for_each(|part| named(domain, world, part, bindings, found));
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
                named(domain, world, inner, bindings, found);
                bindings.pop();
            }
        }
        Condition::Forall(..) | Condition::Atom { .. } | Condition::Equal { .. } => {}
    }
}

/// The things with what they are related to: what they are on or in, what belongs to them, what is in hand. Far
/// scopes also take in what shares their places.
fn around(domain: &Domain, world: &World, things: FxHashSet<EntityId>, far: bool) -> FxHashSet<EntityId> {
    let mut found = things;
    for index in 0..domain.predicates.len() {
        let facts = world.state.of_predicate(PredicateId::new(index));
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
                let others: Vec<EntityId> = of.map(|fact| fact.argument(0)).take(MANY + 1).collect();
                if others.len() <= MANY {
                    // What shares a place is taken in; what shares a place with that is not.
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
