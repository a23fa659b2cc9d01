//! Limits: ranges of skill parameters and of values, and forbidden places.

use serde_json::{Map, Value, json};

use super::{Refusal, RefusalKind};
use longstep_model::model::{
    self, ActionId, Domain, EntityId, Number, Prohibition, SkillType, StepPattern, TypeId, Voice, World,
};

/// A limit of a `[[limit]]` table.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub struct Limit {
    /// The subject.
    pub subject: LimitSubject,
    /// The words of the file about the limit.
    pub says: Option<String>,
}

/// The subject of a limit.
#[derive(Debug, Clone, PartialEq)]
#[non_exhaustive]
pub enum LimitSubject {
    /// A skill parameter of an action: a number, or the length of a vector.
    Skill {
        /// The action.
        action: ActionId,
        /// The name of the parameter.
        parameter: String,
        /// The smallest value, in the unit of the parameter.
        minimum: Option<Bound>,
        /// The largest value.
        maximum: Option<Bound>,
    },
    /// Values of a type, as arguments of an action or of all, and in goals.
    Value {
        /// The action; none for all actions and for goals.
        action: Option<ActionId>,
        /// The type.
        kind: TypeId,
        /// The smallest value, in the unit of the type.
        minimum: Option<Bound>,
        /// The largest value.
        maximum: Option<Bound>,
    },
    /// Places and objects that no step may have as an argument.
    Forbidden {
        /// The action; none for all actions.
        action: Option<ActionId>,
        /// Their names or identifiers.
        places: Vec<String>,
    },
}

/// The end of a range.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct Bound {
    /// The number in the unit of what is limited.
    pub number: Number,
    /// The number with its unit, as the file has it.
    pub written: String,
}

impl Limit {
    /// Returns the action that is limited; none for all actions.
    pub fn action(&self) -> Option<ActionId> {
        match &self.subject {
            LimitSubject::Skill { action, .. } => Some(*action),
            LimitSubject::Value { action, .. } | LimitSubject::Forbidden { action, .. } => *action,
        }
    }

    /// Iterates over the forbidden places.
    pub(super) fn places(&self) -> impl Iterator<Item = &str> {
        let places = match &self.subject {
            LimitSubject::Forbidden { places, .. } => &places[..],
            _ => &[],
        };
        places.iter().map(String::as_str)
    }

    fn refused(&self, kind: RefusalKind) -> Refusal {
        Refusal::new(kind, self.says.as_deref())
    }

    /// Returns the reason why the limit refuses a step; none if it does not.
    pub(super) fn refusal(
        &self,
        world: &World,
        step: ActionId,
        arguments: &[EntityId],
        skills: &Map<String, Value>,
    ) -> Option<Refusal> {
        if self.action().is_some_and(|own| own != step) {
            return None;
        }
        let domain = world.domain();
        match &self.subject {
            LimitSubject::Skill {
                parameter,
                minimum,
                maximum,
                ..
            } => {
                let declared = domain.action(step).skills.iter().find(|own| own.name == *parameter)?;
                let value = measure(declared.kind, skills.get(parameter)?)?;
                let is_below = minimum.as_ref().is_some_and(|own| value < own.number.approximate());
                let is_above = maximum.as_ref().is_some_and(|own| value > own.number.approximate());
                (is_below || is_above).then(|| {
                    self.refused(RefusalKind::Range {
                        name: parameter.clone(),
                        value: match &declared.unit {
                            Some(unit) => format!("{value} {unit}"),
                            None => value.to_string(),
                        },
                        range: range(minimum.as_ref(), maximum.as_ref()),
                    })
                })
            }
            LimitSubject::Value { .. } => arguments.iter().find_map(|argument| {
                let value = value_of(world, *argument)?;
                let refusal = self.refusal_of_value(&value)?;
                Some(refusal.named(domain, value.kind))
            }),
            LimitSubject::Forbidden { places, .. } => {
                let named = places.iter().flat_map(|place| world.named(place));
                let place = named.into_iter().find(|place| arguments.contains(place))?;
                let name = Voice::Person.name(world, place);
                Some(self.refused(RefusalKind::Place { name }))
            }
        }
    }

    /// Returns the reason why the limit refuses a value; none if it does not.
    pub(super) fn refusal_of_value(&self, value: &model::Value) -> Option<Refusal> {
        let LimitSubject::Value {
            kind, minimum, maximum, ..
        } = &self.subject
        else {
            return None;
        };
        let number = value.number.filter(|_| value.kind == *kind)?;
        let is_below = minimum.as_ref().is_some_and(|own| number < own.number);
        let is_above = maximum.as_ref().is_some_and(|own| number > own.number);
        (is_below || is_above).then(|| {
            self.refused(RefusalKind::Range {
                name: String::new(),
                value: value.written.clone(),
                range: range(minimum.as_ref(), maximum.as_ref()),
            })
        })
    }

    /// Returns the prohibitions of the limit in a world.
    pub(super) fn prohibitions(&self, world: &World) -> Vec<Prohibition> {
        let anywhere = |entity: EntityId, refusal: &Refusal| {
            let pattern = StepPattern {
                action: self.action(),
                arguments: Vec::new(),
                anywhere: Some(entity),
            };
            let action = self.action().map_or("_", |action| &world.domain().action(action).name);
            let written = format!("autonomy: never {action} with {}", world.entity(entity).identifier);
            Prohibition::new(written, refusal.to_string(), None, vec![pattern])
        };
        match &self.subject {
            LimitSubject::Skill { .. } => Vec::new(),
            LimitSubject::Value { .. } => {
                let values = world.entities().filter(|(_, entity)| entity.is_value);
                let refused = values.filter_map(|(id, _)| {
                    let value = value_of(world, id)?;
                    Some((id, self.refusal_of_value(&value)?.named(world.domain(), value.kind)))
                });
                refused.map(|(id, refusal)| anywhere(id, &refusal)).collect()
            }
            LimitSubject::Forbidden { places, .. } => {
                let places = places.iter().flat_map(|place| world.named(place));
                let refused = |place: EntityId| {
                    let name = Voice::Person.name(world, place);
                    anywhere(place, &self.refused(RefusalKind::Place { name }))
                };
                places.map(refused).collect()
            }
        }
    }

    pub(super) fn to_value(&self, domain: &Domain) -> Value {
        let mut object = Map::new();
        let mut set = |key: &str, value: Value| object.insert(key.to_owned(), value);
        let (minimum, maximum) = match &self.subject {
            LimitSubject::Skill {
                parameter,
                minimum,
                maximum,
                ..
            } => {
                set("parameter", json!(parameter));
                (minimum.as_ref(), maximum.as_ref())
            }
            LimitSubject::Value {
                kind, minimum, maximum, ..
            } => {
                set("value", json!(domain.types.name(*kind)));
                (minimum.as_ref(), maximum.as_ref())
            }
            LimitSubject::Forbidden { places, .. } => {
                set("forbidden", json!(places));
                (None, None)
            }
        };
        if let Some(action) = self.action() {
            set("action", json!(domain.action(action).name));
        }
        for (key, bound) in [("min", minimum), ("max", maximum)] {
            if let Some(bound) = bound {
                set(key, json!(bound.written));
            }
        }
        if let Some(says) = &self.says {
            set("says", json!(says));
        }
        Value::Object(object)
    }
}

impl Refusal {
    /// Returns the refusal of a value with the name of its type.
    pub(super) fn named(mut self, domain: &Domain, value: TypeId) -> Self {
        if let RefusalKind::Range { name, .. } = &mut self.kind {
            domain.types.name(value).clone_into(name);
        }
        self
    }
}

/// Returns the value that an entity is; none for an entity that is no value.
fn value_of(world: &World, entity: EntityId) -> Option<model::Value> {
    let entity = world.entity(entity);
    if !entity.is_value {
        return None;
    }
    world.domain().value(&entity.identifier)?.ok()
}

/// Returns the number of a skill value that a limit compares; none for a type that has none.
fn measure(kind: SkillType, value: &Value) -> Option<f64> {
    match kind {
        SkillType::Angle | SkillType::Force | SkillType::Number => value.as_f64(),
        SkillType::Vector => {
            let parts = value.as_array()?.iter().map(Value::as_f64);
            let parts: Option<Vec<f64>> = parts.collect();
            Some(parts?.iter().map(|part| part * part).sum::<f64>().sqrt())
        }
        _ => None,
    }
}

/// Returns true if values of the type have a number that a limit compares.
pub(super) fn is_measurable(kind: SkillType) -> bool {
    matches!(
        kind,
        SkillType::Angle | SkillType::Force | SkillType::Number | SkillType::Vector
    )
}

fn range(minimum: Option<&Bound>, maximum: Option<&Bound>) -> String {
    match (minimum, maximum) {
        (Some(minimum), Some(maximum)) => format!("{} to {}", minimum.written, maximum.written),
        (Some(minimum), None) => format!("at least {}", minimum.written),
        (None, Some(maximum)) => format!("at most {}", maximum.written),
        (None, None) => "none".to_owned(),
    }
}
