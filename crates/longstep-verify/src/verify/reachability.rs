//! Reachability according to the static facts of a world.
//!
//! The tests are one-sided: false is certain, true means that no static fact contradicts.

use longstep_model::effort;
use longstep_model::model::{
    ActionId, Bindings, Condition, Domain, Effect, EntityId, Fact, TypeId, World, static_value, unify,
};

/// Returns true if the condition can hold in some state of this world; fluent facts may have any value.
pub fn possibly(world: &World, condition: &Condition, bindings: &mut Bindings) -> bool {
    // Without budget this is not certain, but then no result is used.
    if !effort::spend(1) {
        return false;
    }
    match condition {
        Condition::And(parts) => parts.iter().all(|part| possibly(world, part, bindings)),
        Condition::Or(parts) => parts.iter().any(|part| possibly(world, part, bindings)),
        Condition::Forall(_, kind, inner) => {
            let mut all = world.of_kind(*kind).iter();
            all.all(|entity| possibly_for(world, inner, *entity, bindings))
        }
        Condition::Exists(_, kind, inner) => {
            let mut all = world.of_kind(*kind).iter();
            all.any(|entity| possibly_for(world, inner, *entity, bindings))
        }
        // Parts are judged one by one, so the answer may be true although no state satisfies all of them.
        literal => static_value(world, literal, bindings).unwrap_or(true),
    }
}

/// Returns true if a condition can hold with the entity in its next slot.
fn possibly_for(world: &World, condition: &Condition, entity: EntityId, bindings: &mut Bindings) -> bool {
    bindings.push(entity);
    let possible = possibly(world, condition, bindings);
    bindings.pop();
    possible
}

/// Returns true if the action with these arguments may be applicable in some state of this world.
pub fn can_apply(world: &World, action: ActionId, arguments: &[EntityId]) -> bool {
    let precondition = &world.domain().action(action).precondition;
    possibly(world, precondition, &mut arguments.to_vec())
}

/// Returns true if some action may add the fact in this world: no static fact contradicts the action's precondition or
/// the effect's condition, and no prohibition forbids the step.
pub fn can_be_brought_about(world: &World, fact: Fact) -> bool {
    let domain = world.domain();
    domain.action_ids().any(|(id, action)| {
        let adding = action
            .effects
            .iter()
            .filter(|effect| effect.adds && effect.atom.predicate == fact.predicate());
        adding.into_iter().any(|effect| {
            let kinds = action.parameters.iter().map(|parameter| parameter.kind);
            let own = effect.forall.iter().map(|(_, kind)| *kind);
            let kinds: Vec<TypeId> = kinds.chain(own).collect();
            let mut bound = vec![None; kinds.len()];
            let fits = unify(&effect.atom, fact, &mut bound);
            let maker = Maker {
                domain,
                world,
                action: id,
                effect,
                slots: kinds.into_iter().zip(bound).collect(),
            };
            fits && maker.some_arguments(&mut Vec::new())
        })
    })
}

/// An effect that adds the fact.
struct Maker<'a> {
    domain: &'a Domain,
    world: &'a World,
    action: ActionId,
    effect: &'a Effect,
    /// Types of the action's parameters and the effect's own variables, with the entities that the fact binds them to.
    slots: Vec<(TypeId, Option<EntityId>)>,
}

impl Maker<'_> {
    /// Returns true if the open arguments can be chosen so that the action is applicable and the effect fires.
    fn some_arguments(&self, arguments: &mut Vec<EntityId>) -> bool {
        let (domain, world) = (self.domain, self.world);
        let parameters = domain.action(self.action).parameters.len();
        let is_forbidden = |arguments: &[EntityId]| world.forbids(self.action, arguments).is_some();
        if arguments.len() == parameters && (is_forbidden(arguments) || !can_apply(world, self.action, arguments)) {
            return false;
        }
        let Some((kind, fixed)) = self.slots.get(arguments.len()) else {
            return possibly(world, &self.effect.condition, arguments);
        };
        let candidates = fixed.as_ref().map_or(world.of_kind(*kind), std::slice::from_ref);
        candidates
            .iter()
            .filter(|entity| world.is_of_kind(**entity, *kind))
            .take_while(|_| effort::spend(1))
            .any(|entity| {
                arguments.push(*entity);
                let possible = self.some_arguments(arguments);
                arguments.pop();
                possible
            })
    }
}
