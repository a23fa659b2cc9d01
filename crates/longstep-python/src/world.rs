//! Worlds: environments read with a domain.

use std::sync::Arc;

use longstep::domain::{self, Domain as LoadedDomain};
use longstep_core::environment::{self, Environment, World as ReadWorld};
use longstep_core::json::Path;
use longstep_core::model::{Domain as DomainData, Fact};
use longstep_picture::SvgOptions;
use longstep_picture::scene::{self, Changes, Scene};
use pyo3::prelude::*;

use crate::argument;
use crate::domain::{Domain, DomainArgument};
use crate::failure::Failure;
use crate::interpreter::detach;
use crate::json;
use crate::picture;
use crate::rule::with_rules;
use crate::source::{NamedText, Source};

/// Form of an environment, for hints.
const FORM: &str =
    "an environment is JSON, or a Python literal, with `assets`, `asset_states`, `objects` and `object_states`";

/// An environment, read with the domain of a robot, and the rules in force. Immutable.
///
/// The environment is a dict, a text, or the `os.PathLike` of a file: `assets` are places, `objects` can be moved, and
/// `asset_states` and `object_states` are their states in the words of the domain. The domain is a `Domain`, the name of a
/// shipped one, or a folder; `household` without one. Raises `Unreadable` with every mistake and its line and column.
///
/// >>> world = longstep.World({"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
/// ...     "object_states": {"<pen>": "on_something(<desk>)"}})
/// >>> world.facts[0]
/// '(on <pen> <desk>)'
/// >>> world.with_rules(["untouched(pen)"]).rules
/// ['untouched(<pen>)']
#[pyclass(frozen, module = "longstep")]
pub(crate) struct World {
    pub(crate) world: ReadWorld,
    pub(crate) domain: Arc<LoadedDomain>,
}

#[pymethods]
impl World {
    /// Reads an environment: a text, a dict, or the file of a path.
    #[new]
    #[pyo3(signature = (environment, /, *, domain=None, rules=None))]
    fn new(
        py: Python<'_>,
        environment: &Bound<'_, PyAny>,
        domain: Option<DomainArgument<'_>>,
        rules: Option<&Bound<'_, PyAny>>,
    ) -> PyResult<Self> {
        let source = Source::of(environment, "environment")?;
        let rules = argument::rules(rules)?;
        let domain = match domain {
            Some(domain) => domain.domain(py)?,
            None => detach(py, || Domain::load("household"))?.domain,
        };
        Ok(detach(py, || Self::read(source.read("environment")?, domain, &rules))?)
    }

    /// The domain.
    #[getter]
    fn domain(&self) -> Domain {
        Domain {
            domain: Arc::clone(&self.domain),
        }
    }

    /// The identifiers of the entities, in order.
    #[getter]
    fn entities(&self) -> Vec<&str> {
        self.world
            .entities()
            .map(|(_, entity)| entity.identifier.as_str())
            .collect()
    }

    /// The facts that hold, as `(predicate argument ...)`, sorted.
    #[getter]
    fn facts(&self) -> Vec<String> {
        let mut facts: Vec<String> = self.world.state.iter().map(|fact| written(&self.world, fact)).collect();
        facts.sort_unstable();
        facts
    }

    /// The rules in force, in the goal language.
    #[getter]
    fn rules(&self) -> Vec<&str> {
        let rules = self.world.prohibitions().iter();
        rules.map(|rule| rule.written.as_str()).collect()
    }

    /// Returns the environment as a dict.
    fn environment<'py>(&self, py: Python<'py>) -> PyResult<Bound<'py, PyAny>> {
        json::object(py, self.world.environment())
    }

    /// Returns the environment as JSON, as a file has it.
    fn json(&self) -> PyResult<String> {
        Ok(json::pretty(self.world.environment())?)
    }

    /// Returns the world with further rules in force.
    fn with_rules(&self, py: Python<'_>, rules: &Bound<'_, PyAny>) -> PyResult<Self> {
        let rules = argument::rules(Some(rules))?;
        let world = detach(py, || with_rules(self.world.clone(), &rules))?;
        Ok(self.of(world))
    }

    /// Returns a picture of the entities and their places; the width is in pixels.
    #[pyo3(signature = (*, width=720.0))]
    fn svg(&self, width: f64) -> String {
        let scene = Scene::of(&self.world, &self.world.state);
        scene::svg(&scene, &Changes::default(), &SvgOptions::new(width))
    }

    fn _repr_svg_(&self) -> String {
        self.svg(picture::WIDTH)
    }

    fn __eq__(&self, other: &Bound<'_, PyAny>) -> bool {
        other.cast::<Self>().is_ok_and(|other| {
            let other = &other.get().world;
            self.world.domain().hash == other.domain().hash
                && self.world.environment() == other.environment()
                && self.world.state == other.state
                && self.rules() == other_rules(other)
        })
    }

    fn __hash__(&self) -> u64 {
        use std::hash::{DefaultHasher, Hash, Hasher};
        let mut hasher = DefaultHasher::new();
        self.domain.hash.hash(&mut hasher);
        self.facts().hash(&mut hasher);
        hasher.finish()
    }

    fn __repr__(&self) -> String {
        let count = self.world.entities().count();
        format!("<longstep.World {}: {count} entities>", self.domain.name)
    }
}

fn other_rules(world: &ReadWorld) -> Vec<&str> {
    world.prohibitions().iter().map(|rule| rule.written.as_str()).collect()
}

impl World {
    fn read(text: NamedText, domain: Arc<LoadedDomain>, rules: &[String]) -> Result<Self, Failure> {
        let (environment, is_wrapped) = Environment::parse(&text.text)
            .map_err(|error| Failure::unreadable(format!("{}: {error}", text.name)).hint(text.hint(FORM)))?;
        let inside = if is_wrapped {
            Path::key("environment")
        } else {
            Path::default()
        };
        let read = environment::read(&domain, &environment, &text.name, &text.text, &inside);
        let world = read.map_err(|findings| match fitting(&domain, &environment) {
            Some(other) => Failure::unreadable(format!(
                "{} is not an environment of the domain `{}`",
                text.name, domain.name
            ))
            .hint(format!("it fits the domain `{other}`: pass `domain=\"{other}\"`")),
            None => findings.into(),
        })?;
        Ok(Self {
            world: with_rules(world, rules)?,
            domain,
        })
    }

    /// Returns another world of the same domain.
    pub(crate) fn of(&self, world: ReadWorld) -> Self {
        Self {
            world,
            domain: Arc::clone(&self.domain),
        }
    }
}

/// Returns the first shipped domain besides this one that reads an environment.
fn fitting(domain: &DomainData, environment: &Environment) -> Option<&'static str> {
    let fits = |name: &&str| {
        let other = domain::shipped(name).and_then(Result::ok);
        other.is_some_and(|other| environment::read(&other, environment, "", "", &Path::default()).is_ok())
    };
    let mut others = domain::shipped_names().into_iter().filter(|name| *name != domain.name);
    others.find(fits)
}

/// Writes a fact with the identifiers of the world.
pub(crate) fn written(world: &ReadWorld, fact: Fact) -> String {
    let domain = world.domain();
    let name = domain.predicate(fact.predicate()).name.as_str();
    let arguments = domain.arguments(fact);
    let arguments = arguments.map(|entity| world.entity(entity).identifier.as_str());
    let words: Vec<&str> = std::iter::once(name).chain(arguments).collect();
    format!("({})", words.join(" "))
}
