//! Observations from Python.

use longstep_core::environment::{EntityId, Observation, ObservedFacts, World};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::argument::class_of;
use crate::json;

/// The form of an observation, for messages.
const FORM: &str = "{\"states\": {\"<cup>\": [\"on_something(<desk>)\"]}}, as in an environment";

/// The source of an observation, for messages.
#[derive(Debug, Clone, Copy)]
pub(crate) enum Source {
    /// The method `observe` of a robot.
    Robot,
    /// An argument.
    Argument,
}

impl Source {
    /// Returns the beginning of a message about the form.
    fn must(self) -> &'static str {
        match self {
            Self::Robot => "`observe` must return",
            Self::Argument => "an observation must be",
        }
    }

    /// Returns the beginning of a message about names.
    fn names(self) -> &'static str {
        match self {
            Self::Robot => "`observe` names",
            Self::Argument => "the observation names",
        }
    }
}

/// Reads an observation in a world.
///
/// An entity that the world does not have is left to the world, which ignores it, because a robot may see more than a plan is
/// about. The name of an entity without its brackets is a mistake.
pub(crate) fn read(seen: &Bound<'_, PyAny>, source: Source, world: &World) -> PyResult<Observation> {
    let must = source.must();
    let Ok(mapping) = seen.cast::<PyMapping>() else {
        let class = class_of(seen);
        return Err(PyTypeError::new_err(format!("{must} {FORM}, not {class}")));
    };
    if !mapping.contains("states")? {
        return Err(PyValueError::new_err(format!("{must} {FORM}: `states` is missing")));
    }
    let states = mapping.get_item("states")?;
    if states.cast::<PyMapping>().is_err() {
        let class = class_of(&states);
        let message = format!("{must} {FORM}: `states` must be a dict, not {class}");
        return Err(PyTypeError::new_err(message));
    }
    let read: Result<Observation, _> = serde_json::from_str(&json::text(seen)?);
    let read = read.map_err(|error| PyValueError::new_err(format!("{must} {FORM}: {error}")))?;
    check_names(&read, source, world)?;
    Ok(read)
}

/// Returns the observation of a whole world.
pub(crate) fn of_world(world: &World) -> Observation {
    let entities = world.entities().filter(|(_, entity)| !entity.is_value);
    let entities: Vec<EntityId> = entities.map(|(entity, _)| entity).collect();
    ObservedFacts::statements(world, &world.state, &entities, &[])
}

/// Refuses names of entities without their brackets.
fn check_names(seen: &Observation, source: Source, world: &World) -> PyResult<()> {
    let unknown = seen.states.keys().filter(|name| world.find(name).is_none());
    let bare = unknown.filter_map(|name| {
        let meant = format!("<{name}>");
        world
            .find(&meant)
            .map(|_| format!("`{name}` (did you mean `{meant}`?)"))
    });
    let bare: Vec<String> = bare.collect();
    if bare.is_empty() {
        return Ok(());
    }
    let names = source.names();
    let message = format!("{names} what the world does not have: {}", bare.join(", "));
    Err(PyValueError::new_err(message))
}
