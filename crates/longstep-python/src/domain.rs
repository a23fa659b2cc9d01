//! Domains of robots.

use std::collections::BTreeMap;
use std::hash::{Hash, Hasher};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use longstep::domain;
use longstep_core::model::GoalWord;
use longstep_llm::load_domain;
use pyo3::exceptions::PyTypeError;
use pyo3::prelude::*;

use crate::argument::class_of;
use crate::failure::Failure;
use crate::interpreter::detach;

/// A robot: its actions, and the words for them. Immutable; shared by worlds and threads.
///
/// A name is that of a shipped domain, anything else the path of a folder. Raises `Unreadable` with every mistake in its files.
///
/// >>> longstep.Domain("household").actions[:2]
/// ['move-object', 'move-hand']
#[pyclass(frozen, eq, hash, module = "longstep")]
pub(crate) struct Domain {
    pub(crate) domain: Arc<domain::Domain>,
}

/// Domains with the same files are equal.
impl PartialEq for Domain {
    fn eq(&self, other: &Self) -> bool {
        self.domain.hash == other.domain.hash
    }
}

impl Hash for Domain {
    fn hash<H: Hasher>(&self, hasher: &mut H) {
        self.domain.hash.hash(hasher);
    }
}

#[pymethods]
impl Domain {
    /// Loads a shipped domain by its name, or any domain from its folder.
    #[new]
    #[pyo3(signature = (name=PathBuf::from("household"), /), text_signature = "(name=\"household\", /)")]
    fn new(py: Python<'_>, name: PathBuf) -> PyResult<Self> {
        Ok(detach(py, || Self::load(&name.to_string_lossy()))?)
    }

    /// Reads a `domain.pddl` without a vocabulary; actions and states have PDDL's own names.
    #[staticmethod]
    fn from_pddl(py: Python<'_>, text: &str) -> PyResult<Self> {
        let read = detach(py, || domain::from_pddl("domain.pddl", text).map_err(Failure::from));
        Ok(Self::from(read?))
    }

    /// Returns the names of the shipped domains.
    #[staticmethod]
    fn shipped() -> Vec<&'static str> {
        domain::shipped_names()
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        &self.domain.name
    }

    /// The hash of the files, in hexadecimal digits: plans name it.
    #[getter]
    fn hash(&self) -> &str {
        &self.domain.hash
    }

    /// The names of the actions, as robots receive them.
    #[getter]
    fn actions(&self) -> Vec<&str> {
        self.domain.actions.iter().map(|action| action.name.as_str()).collect()
    }

    /// The notations of the goal words: `put(ITEM, PLACE)`.
    #[getter]
    fn goals(&self) -> Vec<String> {
        let mut goals: Vec<String> = self.domain.goal_words.iter().map(GoalWord::shown).collect();
        goals.dedup();
        goals
    }

    fn __repr__(&self) -> String {
        format!("<longstep.Domain {}>", self.domain.name)
    }
}

type Shipped = BTreeMap<String, Arc<domain::Domain>>;

/// Returns the shipped domains that were loaded so far. They never change.
fn shipped() -> MutexGuard<'static, Shipped> {
    static SHIPPED: Mutex<Shipped> = Mutex::new(Shipped::new());
    SHIPPED.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Domain {
    /// Loads a domain by name or folder.
    ///
    /// Shipped domains are loaded once, and shared.
    pub(crate) fn load(name: &str) -> Result<Self, Failure> {
        if !domain::shipped_names().contains(&name) {
            return Ok(Self::from(load_domain(name)?));
        }
        if let Some(domain) = shipped().get(name) {
            return Ok(Self {
                domain: Arc::clone(domain),
            });
        }
        let loaded = Self::from(load_domain(name)?);
        shipped().insert(name.to_owned(), Arc::clone(&loaded.domain));
        Ok(loaded)
    }
}

impl From<domain::Domain> for Domain {
    fn from(domain: domain::Domain) -> Self {
        Self {
            domain: Arc::new(domain),
        }
    }
}

/// A domain as a caller gives it.
pub(crate) enum DomainArgument<'py> {
    Loaded(Bound<'py, Domain>),
    Named(PathBuf),
}

impl<'py> FromPyObject<'_, 'py> for DomainArgument<'py> {
    type Error = PyErr;

    fn extract(object: Borrowed<'_, 'py, PyAny>) -> PyResult<Self> {
        match object.cast::<Domain>() {
            Ok(domain) => Ok(Self::Loaded(domain.to_owned())),
            Err(_) => object.extract().map(Self::Named).map_err(|_| {
                let class = class_of(&object);
                PyTypeError::new_err(format!(
                    "domain must be a longstep.Domain, a str or an os.PathLike, not {class}"
                ))
            }),
        }
    }
}

impl DomainArgument<'_> {
    /// Returns the domain, loaded if it is given by its name or folder.
    pub(crate) fn domain(&self, py: Python<'_>) -> PyResult<Arc<domain::Domain>> {
        match self {
            Self::Loaded(domain) => Ok(Arc::clone(&domain.get().domain)),
            Self::Named(name) => {
                let name = name.to_string_lossy();
                Ok(detach(py, || Domain::load(&name))?.domain)
            }
        }
    }
}
