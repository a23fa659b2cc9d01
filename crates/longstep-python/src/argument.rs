//! Arguments of callers, with messages that name them.

use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyMapping, PyString};

/// Returns the name of an object's class.
pub(crate) fn class_of(object: &Bound<'_, PyAny>) -> String {
    let name = object.get_type().name();
    name.map_or_else(|_| "?".to_owned(), |name| name.to_string())
}

/// Returns a callable, or none for None.
pub(crate) fn callable(py: Python<'_>, object: Option<Py<PyAny>>, what: &str) -> PyResult<Option<Py<PyAny>>> {
    match object {
        Some(object) if !object.bind(py).is_callable() => {
            let class = class_of(object.bind(py));
            Err(PyTypeError::new_err(format!("{what} must be callable, not {class}")))
        }
        other => Ok(other),
    }
}

/// Returns the rules of a caller; none for None.
pub(crate) fn rules(object: Option<&Bound<'_, PyAny>>) -> PyResult<Vec<String>> {
    object.map_or_else(|| Ok(Vec::new()), |rules| strings(rules, "rules"))
}

/// Returns the strings of a sequence. A string is none: its characters are never meant.
pub(crate) fn strings(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Vec<String>> {
    let wrong = |class: String| PyTypeError::new_err(format!("{what} must be a list of str, not {class}"));
    if object.is_instance_of::<PyString>() || object.cast::<PyMapping>().is_ok() {
        return Err(wrong(class_of(object)));
    }
    let items = object.try_iter().map_err(|_| wrong(class_of(object)))?;
    let text = |item: PyResult<Bound<'_, PyAny>>| {
        let item = item?;
        let text = item.cast::<PyString>();
        let text = text.map_err(|_| wrong(format!("one with {}", class_of(&item))))?;
        Ok(text.to_str()?.to_owned())
    };
    items.map(text).collect()
}
