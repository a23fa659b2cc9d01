//! Restriction of a world to some of its entities.

use std::sync::Arc;

use indexmap::IndexMap;
use rustc_hash::FxHashSet;

use super::{Entity, EntityId, Environment, Fact, Words, World};
use crate::call::Call;
use crate::model::{Fluent, Number};

impl World {
    /// Returns the world restricted to these entities, for readers with limited space.
    ///
    /// Entities keep their identifiers, everyday names ("plate 17" stays 17) and order. The domain's constants and all
    /// values are included. Facts about removed entities are dropped, from the environment too. Ids change; results in the
    /// restricted world are mapped back by identifier ([`World::find`], `longstep_search::goal::Goal::carried`).
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup_1>", "<cup_2>"],
    ///     "object_states": {"<cup_1>": "on_something(<shelf>)", "<cup_2>": "on_something(<table>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let keep = ["<cup_2>", "<table>"].map(|identifier| world.find(identifier).unwrap());
    /// let part = world.narrowed(&keep);
    /// assert_eq!(part.environment().objects, ["<cup_2>"]);
    /// assert_eq!(part.entity(part.find("<cup_2>").unwrap()).name, "cup 2");
    /// ```
    #[must_use]
    pub fn narrowed(&self, keep: &[EntityId]) -> World {
        let domain = self.domain();
        let mut kept: Vec<EntityId> = (0..domain.constants.len()).map(EntityId::new).collect();
        kept.extend(keep);
        let values = self.entities().filter(|(_, entity)| entity.is_value);
        kept.extend(values.map(|(id, _)| id));
        kept.sort_unstable();
        kept.dedup();
        let mut renumbered: Vec<Option<EntityId>> = vec![None; self.entities.len()];
        for (index, id) in kept.iter().enumerate() {
            renumbered[id.index()] = Some(EntityId::new(index));
        }
        let entities: Vec<Entity> = kept.iter().map(|id| self.entity(*id).clone()).collect();
        let identifiers: FxHashSet<&str> = entities.iter().map(|entity| entity.identifier.as_str()).collect();
        let environment = self.environment.only(&identifiers);
        let carried = |fact: Fact| {
            let arguments: Option<Vec<EntityId>> = domain.arguments(fact).map(|id| renumbered[id.index()]).collect();
            Some(Fact::new(fact.predicate(), arguments?))
        };
        let mut part = World::new(domain, entities.clone(), environment);
        for fact in self.state.iter().filter_map(carried) {
            part.state.set(fact, true);
        }
        for (fluent, number) in self.state.numbers() {
            let arguments = domain.arguments_of(*fluent).map(|id| renumbered[id.index()]);
            if let Some(arguments) = arguments.collect::<Option<Vec<EntityId>>>() {
                part.state
                    .set_number(Fluent::new(fluent.function(), arguments), *number);
            }
        }
        let assumed = self.assumed.iter();
        let assumed = assumed.filter_map(|(fact, source)| Some((carried(*fact)?, *source)));
        part.assumed = Arc::new(assumed.collect());
        part
    }
}

impl Environment {
    /// Returns the environment restricted to these entities.
    fn only(&self, identifiers: &FxHashSet<&str>) -> Self {
        let listed = |all: &[String]| -> Vec<String> {
            let kept = all
                .iter()
                .filter(|identifier| identifiers.contains(identifier.as_str()));
            kept.cloned().collect()
        };
        let about = |text: &String| match Call::parse(text) {
            Ok(call) => call
                .arguments
                .iter()
                .all(|argument| identifiers.contains(argument.as_str()) || Number::parse(argument).is_some()),
            Err(_) => true,
        };
        let states = |all: &IndexMap<String, Words>| -> IndexMap<String, Words> {
            let kept = all
                .iter()
                .filter(|(identifier, _)| identifiers.contains(identifier.as_str()));
            let words = kept.map(|(identifier, words)| {
                let words = match words {
                    Words::One(word) if about(word) => Words::One(word.clone()),
                    Words::One(_) => Words::Many(Vec::new()),
                    Words::Many(all) => Words::Many(all.iter().filter(|word| about(word)).cloned().collect()),
                };
                (identifier.clone(), words)
            });
            words.filter(|(_, words)| !words.as_slice().is_empty()).collect()
        };
        let texts = |all: &IndexMap<String, String>| -> IndexMap<String, String> {
            let kept = all
                .iter()
                .filter(|(identifier, _)| identifiers.contains(identifier.as_str()));
            kept.map(|(identifier, text)| (identifier.clone(), text.clone()))
                .collect()
        };
        let kept = |identifier: &String| identifiers.contains(identifier.as_str()).then(|| identifier.clone());
        Self {
            assets: listed(&self.assets),
            asset_states: states(&self.asset_states),
            objects: listed(&self.objects),
            object_states: states(&self.object_states),
            asset_properties: self.asset_properties.as_ref().map(states),
            object_properties: self.object_properties.as_ref().map(states),
            facts: self.facts.clone(),
            names: self.names.as_ref().map(texts),
            types: self.types.as_ref().map(texts),
            speaker: self.speaker.as_ref().and_then(kept),
            robot: self.robot.as_ref().and_then(kept),
            schema: self.schema,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::fact_text;
    use crate::testing;

    const TEXT: &str = r#"{"assets": ["<hut>", "<loft>"], "objects": ["<rope_1>", "<rope_2>", "<loft_handle>", "<axe>"],
        "object_states": {"<rope_1>": "on_something(<hut>)", "<rope_2>": ["inside_something(<loft>)"],
                          "<loft_handle>": "closed()", "<axe>": ["on_something(<hut>)", "next_to(<rope_1>)"]},
        "object_properties": {"<loft_handle>": "SLIDES"}, "names": {"<axe>": "hatchet", "<hut>": "cabin"}}"#;

    #[track_caller]
    fn check(keep: &[&str], environment: &str, facts: &[&str]) {
        let domain = testing::domain("household");
        let whole = testing::world_of(&domain, TEXT);
        let ids: Vec<EntityId> = keep.iter().map(|identifier| whole.find(identifier).unwrap()).collect();
        let part = whole.narrowed(&ids);
        assert_eq!(serde_json::to_string(part.environment()).unwrap(), environment);
        let relations = part.state.iter().filter(|fact| domain.is_relation(*fact));
        let texts: Vec<String> = relations.map(|fact| fact_text(&part, fact, true)).collect();
        assert_eq!(texts, facts);
        for (id, entity) in part.entities() {
            assert_eq!(part.find(&entity.identifier), Some(id));
            assert_eq!(whole.entity(whole.find(&entity.identifier).unwrap()), entity);
        }
        for fact in part.state.iter() {
            let arguments = domain
                .arguments(fact)
                .map(|id| whole.find(&part.entity(id).identifier).unwrap());
            let there = Fact::new(fact.predicate(), arguments);
            assert!(whole.state.holds(there));
            assert_eq!(whole.assumed(there), part.assumed(fact));
        }
    }

    #[test]
    fn subworld_contains_only_facts_about_its_entities() {
        check(
            &["<rope_2>", "<loft>", "<loft_handle>"],
            r#"{"assets":["<loft>"],"asset_states":{},"objects":["<rope_2>","<loft_handle>"],"object_states":{"<rope_2>":["inside_something(<loft>)"],"<loft_handle>":"closed()"},"object_properties":{"<loft_handle>":"SLIDES"},"names":{}}"#,
            &["the loft handle belongs to the loft", "rope 2 is in the loft"],
        );
        check(
            &["<axe>", "<hut>"],
            r#"{"assets":["<hut>"],"asset_states":{},"objects":["<axe>"],"object_states":{"<axe>":["on_something(<hut>)"]},"object_properties":{},"names":{"<axe>":"hatchet","<hut>":"cabin"}}"#,
            &["the hatchet is on the cabin"],
        );
        check(
            &["<rope_1>"],
            r#"{"assets":[],"asset_states":{},"objects":["<rope_1>"],"object_states":{},"object_properties":{},"names":{}}"#,
            &[],
        );
    }
}
