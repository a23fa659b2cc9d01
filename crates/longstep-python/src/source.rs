//! Inputs that a caller gives as a text, as data, or as the path of a file.

use std::path::{Path, PathBuf};

use longstep_files::read_text;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;
use pyo3::types::{PyDict, PyString};

use crate::failure::Failure;
use crate::json;

/// An input before it is read. A string is a text and never a path: texts and paths cannot be told apart for certain.
pub(crate) enum Source {
    /// A text, or data as JSON.
    Text(String),
    /// A file.
    File(PathBuf),
}

/// A text with its name in messages.
pub(crate) struct NamedText {
    pub(crate) name: String,
    pub(crate) text: String,
    /// The file, if the text comes from one.
    pub(crate) path: Option<PathBuf>,
}

impl Source {
    /// Takes a `str`, a `dict` or an `os.PathLike`.
    pub(crate) fn of(object: &Bound<'_, PyAny>, what: &str) -> PyResult<Self> {
        if let Ok(text) = object.cast::<PyString>() {
            return Ok(Self::Text(text.to_str()?.to_owned()));
        }
        if object.is_instance_of::<PyDict>() {
            return Ok(Self::Text(json::text(object)?));
        }
        if object.hasattr("__fspath__")? {
            return Ok(Self::File(object.extract()?));
        }
        let class = object.get_type().name()?;
        Err(PyTypeError::new_err(format!(
            "{what} must be a str, a dict or an os.PathLike, not {class}"
        )))
    }

    /// Reads a file; `name` is the name of another text.
    pub(crate) fn read(self, name: &str) -> Result<NamedText, Failure> {
        Ok(match self {
            Self::Text(text) => NamedText {
                name: name.to_owned(),
                text,
                path: None,
            },
            Self::File(path) => NamedText {
                name: path.display().to_string(),
                text: read_text(&path)?,
                path: Some(path),
            },
        })
    }
}

impl NamedText {
    /// Returns the hint for a text that cannot be read: it is the path of a file, or the form that it should have.
    pub(crate) fn hint(&self, form: &str) -> String {
        let is_file = self.path.is_none() && self.text.len() < 1_000 && Path::new(&self.text).is_file();
        if is_file {
            "pass `pathlib.Path(...)` for a file; a string is read as the text itself".to_owned()
        } else {
            form.to_owned()
        }
    }
}
