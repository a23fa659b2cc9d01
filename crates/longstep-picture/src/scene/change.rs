//! The changes between two states, by box.

use std::collections::BTreeMap;

use longstep_core::model::{Fact, State, World};
use serde::Serialize;

use super::placement::{Body, Placement};
use super::schema::{Relation, SceneSchema};
use super::wording::{self, StateText, Words};
use super::{Scene, SceneBox, id_of};

/// Changes between two scenes.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize)]
#[non_exhaustive]
pub struct Changes {
    /// Boxes in another place.
    pub moved: Vec<Moved>,
    /// Boxes with other states.
    pub states: Vec<StateChange>,
    /// Identifiers of boxes that only the second scene has.
    pub appeared: Vec<String>,
    /// Identifiers of boxes that only the first scene has.
    pub gone: Vec<String>,
    /// Statements about no entity that began to hold.
    pub now: Vec<String>,
    /// Statements about no entity that no longer hold.
    pub no_longer: Vec<String>,
}

/// A box in another place.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Moved {
    /// Its identifier.
    pub id: String,
    /// Identifier of the box around it before; none for no place.
    pub from: Option<String>,
    /// Identifier of the box around it after; none for no place.
    pub to: Option<String>,
    /// Its relation to the box around it after.
    pub relation: Option<Relation>,
}

/// A box with other states.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct StateChange {
    /// Its identifier.
    pub id: String,
    /// States that began to hold.
    pub gained: Vec<String>,
    /// States that no longer hold.
    pub lost: Vec<String>,
    /// Events that happened.
    pub happened: Vec<String>,
}

impl Changes {
    /// Returns true if nothing differs.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }
}

/// Finds the changes between two scenes of one world.
pub(super) fn difference(before: &Scene, after: &Scene) -> Changes {
    let (first, second) = (by_body(before), by_body(after));
    let mut changes = Changes::default();
    for (body, new) in &second {
        let Some(old) = first.get(body).filter(|old| old.id == new.id) else {
            changes.appeared.push(new.id.clone());
            continue;
        };
        let [from, to] = [(before, old), (after, new)].map(|(scene, own)| holder(scene, own));
        if (&from, old.relation) != (&to, new.relation) {
            changes.moved.push(Moved {
                id: new.id.clone(),
                from,
                to,
                relation: new.relation,
            });
        }
        let words = |own: &SceneBox| Words {
            states: own.states.clone(),
            events: own.events.clone(),
            nested: own.nested.clone(),
        };
        changes.states.extend(state_change(&new.id, &words(old), &words(new)));
    }
    let is_gone = |(body, old): &(&Body, &&SceneBox)| second.get(body).is_none_or(|new| new.id != old.id);
    changes.gone = first.iter().filter(is_gone).map(|(_, old)| old.id.clone()).collect();
    changes.now = without(&after.statements, &before.statements);
    changes.no_longer = without(&before.statements, &after.statements);
    changes
}

fn by_body(scene: &Scene) -> BTreeMap<Body, &SceneBox> {
    scene.boxes.iter().map(|own| (own.body, own)).collect()
}

fn holder(scene: &Scene, own: &SceneBox) -> Option<String> {
    own.within.map(|index| scene.boxes[index].id.clone())
}

/// Returns the texts of one list that another one does not have.
fn without(list: &[String], other: &[String]) -> Vec<String> {
    list.iter().filter(|text| !other.contains(text)).cloned().collect()
}

fn state_change(id: &str, before: &Words, after: &Words) -> Option<StateChange> {
    // Most boxes do not change.
    if before == after {
        return None;
    }
    let texts = |states: &[StateText]| -> Vec<String> { states.iter().map(|state| state.text.clone()).collect() };
    let (old, new) = (texts(&before.states), texts(&after.states));
    let change = StateChange {
        id: id.to_owned(),
        gained: without(&without(&new, &old), &before.nested),
        lost: without(&without(&old, &new), &after.nested),
        happened: without(&after.events, &before.events),
    };
    let is_empty = change.gained.is_empty() && change.lost.is_empty() && change.happened.is_empty();
    (!is_empty).then_some(change)
}

/// A state with its placement, for the changes of one step after another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SceneMoment<'a> {
    pub(crate) state: &'a State,
    pub(crate) placement: &'a Placement,
}

/// Finds the changes between two states of a world from the facts and numbers that differ, without their scenes.
///
/// The result is that of [`Scene::difference`]; the work depends on the entities that change.
pub(crate) fn changes_between(
    schema: &SceneSchema,
    world: &World,
    before: SceneMoment<'_>,
    after: SceneMoment<'_>,
    changed: &longstep_core::model::Changes,
) -> Changes {
    let mut changes = Changes::default();
    let mut moved: Vec<Body> = before.placement.moved(after.placement).collect();
    moved.sort_unstable();
    for body in &moved {
        let holder = |moment: SceneMoment<'_>| moment.placement.spot(*body).copied();
        let id = |spot: super::Spot| id_of(world, spot.holder);
        changes.moved.push(Moved {
            id: id_of(world, *body),
            from: holder(before).map(id),
            to: holder(after).map(id),
            relation: holder(after).map(|spot| spot.relation),
        });
    }
    let facts = changed.facts.iter().map(|change| change.fact);
    let mut touched: Vec<Body> = facts.filter_map(|fact| wording::body_of(schema, fact)).collect();
    let fluents = changed.numbers.iter().map(|change| change.fluent);
    let with_entity = fluents.filter(|fluent| world.domain().arguments_of(*fluent).next().is_some());
    touched.extend(with_entity.map(|fluent| Body::Entity(fluent.argument(0))));
    // A place that no box around shows any more is shown as a state.
    if !moved.is_empty() {
        let is_in_moved = |placement: &Placement, body| placement.around(body).any(|around| moved.contains(&around));
        let bodies = after.placement.bodies();
        touched
            .extend(bodies.filter(|body| is_in_moved(before.placement, *body) || is_in_moved(after.placement, *body)));
        touched.extend(moved);
    }
    touched.sort_unstable();
    touched.dedup();
    for body in touched {
        let words = |moment: SceneMoment<'_>| wording::words_of(schema, world, moment.state, moment.placement, body);
        let change = state_change(&id_of(world, body), &words(before), &words(after));
        changes.states.extend(change);
    }
    let is_bare = |fact: Fact| wording::body_of(schema, fact).is_none();
    let facts_changed = changed.facts.iter().any(|change| is_bare(change.fact));
    let is_bare = |fluent| world.domain().arguments_of(fluent).next().is_none();
    if facts_changed || changed.numbers.iter().any(|change| is_bare(change.fluent)) {
        let [old, new] = [before, after].map(|moment| wording::statements(schema, world, moment.state));
        changes.now = without(&new, &old);
        changes.no_longer = without(&old, &new);
    }
    changes
}
