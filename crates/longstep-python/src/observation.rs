//! Observations from Python.

use longstep_core::environment::{Observation, World};
use pyo3::exceptions::{PyTypeError, PyValueError};
use pyo3::prelude::*;
use pyo3::types::PyMapping;

use crate::argument::class_of;
use crate::json;

/// Reads an observation in a world; `what` names its source in messages: "`observe`".
///
/// An entity that the world does not have is left to the world, which ignores it, because a robot may see more than a plan is
/// about. The name of an entity without its brackets is a mistake.
pub(crate) fn read(seen: &Bound<'_, PyAny>, what: &str, world: &World) -> PyResult<Observation> {
    const FORM: &str = "{\"states\": {\"<cup>\": [\"on_something(<desk>)\"]}}, as in an environment";
    let Ok(mapping) = seen.cast::<PyMapping>() else {
        let class = class_of(seen);
        return Err(PyTypeError::new_err(format!("{what} must return {FORM}, not {class}")));
    };
    if !mapping.contains("states")? {
        let message = format!("{what} must return {FORM}: `states` is missing");
        return Err(PyValueError::new_err(message));
    }
    let states = mapping.get_item("states")?;
    if states.cast::<PyMapping>().is_err() {
        let class = class_of(&states);
        let message = format!("{what} must return {FORM}: `states` must be a dict, not {class}");
        return Err(PyTypeError::new_err(message));
    }
    let read: Result<Observation, _> = serde_json::from_str(&json::text(seen)?);
    let read = read.map_err(|error| PyValueError::new_err(format!("{what} must return {FORM}: {error}")))?;
    check_names(&read, what, world)?;
    Ok(read)
}

/// Refuses names of entities without their brackets.
fn check_names(seen: &Observation, what: &str, world: &World) -> PyResult<()> {
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
    let message = format!(
        "{what} names what the world of the plan does not have: {}",
        bare.join(", ")
    );
    Err(PyValueError::new_err(message))
}
