//! JSON between Python and the library: texts, which Python's own module reads and writes.

use longstep_core::visible;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyCFunction, PyDict, PyMapping, PySequence, PyTuple};
use serde::Serialize;

use crate::argument::class_of;
use crate::failure::Failure;

/// Returns a value as indented JSON, with foreign text escaped as the program prints it.
pub(crate) fn pretty(value: &impl Serialize) -> Result<String, Failure> {
    let text = serde_json::to_string_pretty(value).map_err(|error| Failure::failed(error.to_string()))?;
    Ok(visible::json(&text).into_owned())
}

/// Returns the Python object of a value.
pub(crate) fn object<'py>(py: Python<'py>, value: &impl Serialize) -> PyResult<Bound<'py, PyAny>> {
    let text = serde_json::to_string(value).map_err(|error| Failure::failed(error.to_string()))?;
    parse(py, &text)
}

/// Returns the Python object of a JSON text.
pub(crate) fn parse<'py>(py: Python<'py>, text: &str) -> PyResult<Bound<'py, PyAny>> {
    py.import("json")?.call_method1("loads", (text,))
}

/// Returns the JSON text of a Python object.
pub(crate) fn text(object: &Bound<'_, PyAny>) -> PyResult<String> {
    let py = object.py();
    let options = PyDict::new(py);
    options.set_item("ensure_ascii", false)?;
    options.set_item("allow_nan", false)?;
    let default = |arguments: &Bound<'_, PyTuple>, _: Option<&Bound<'_, PyDict>>| plain(&arguments.get_item(0)?);
    options.set_item("default", PyCFunction::new_closure(py, None, None, default)?)?;
    py.import("json")?
        .call_method("dumps", (object,), Some(&options))?
        .extract()
}

/// Returns a mapping as a dict and a sequence as a list, which Python's own module cannot write.
fn plain(object: &Bound<'_, PyAny>) -> PyResult<Py<PyAny>> {
    let builtins = object.py().import("builtins")?;
    if object.cast::<PyMapping>().is_ok() {
        return Ok(builtins.getattr("dict")?.call1((object,))?.unbind());
    }
    // Bytes are a sequence of numbers, which are never meant.
    if object.cast::<PySequence>().is_ok() && !object.is_instance_of::<pyo3::types::PyBytes>() {
        return Ok(builtins.getattr("list")?.call1((object,))?.unbind());
    }
    let class = class_of(object);
    Err(PyTypeError::new_err(format!("{class} is no data for JSON")))
}
