//! PDDL problems with their domains.

use std::path::PathBuf;
use std::sync::Arc;

use longstep::domain::Domain as LoadedDomain;
use longstep_core::domain::read_foreign;
use longstep_core::pddl;
use longstep_files::read_text;
use pyo3::prelude::*;

use crate::domain::Domain;
use crate::failure::Failure;
use crate::interpreter::detach;
use crate::source::Source;
use crate::world::World;

/// A PDDL problem, read with its domain: a world and a goal. Immutable.
///
/// Raises `Unreadable` with every mistake and its line and column.
///
/// >>> lamps = """(define (domain lamps) (:predicates (lit ?lamp))
/// ...     (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) :effect (lit ?lamp)))"""
/// >>> evening = """(define (problem evening) (:domain lamps) (:objects hall porch)
/// ...     (:init (lit hall)) (:goal (lit porch)))"""
/// >>> longstep.solve(longstep.Problem(lamps, evening)).verified().pddl()
/// '(light porch)\n'
#[pyclass(frozen, module = "longstep")]
pub(crate) struct Problem {
    pub(crate) problem: pddl::Problem,
    pub(crate) domain: Arc<LoadedDomain>,
    /// Notes on the parts that were left out or read in another way than they are written.
    pub(crate) notes: Vec<String>,
    goal: Vec<String>,
}

#[pymethods]
impl Problem {
    /// Reads a problem and its domain, each a PDDL text or the path of a file; a domain may be the path of a folder with a
    /// `domain.pddl`.
    #[new]
    #[pyo3(signature = (domain, problem, /))]
    fn new(py: Python<'_>, domain: &Bound<'_, PyAny>, problem: &Bound<'_, PyAny>) -> PyResult<Self> {
        let domain = Source::of(domain, "domain")?;
        let problem = Source::of(problem, "problem")?;
        Ok(detach(py, || Self::read(domain, problem))?)
    }

    /// The name.
    #[getter]
    fn name(&self) -> &str {
        &self.problem.name
    }

    /// The domain.
    #[getter]
    fn domain(&self) -> Domain {
        Domain {
            domain: Arc::clone(&self.domain),
        }
    }

    /// The objects and the initial state.
    #[getter]
    fn world(&self) -> World {
        World {
            world: self.problem.world.clone(),
            domain: Arc::clone(&self.domain),
        }
    }

    /// The parts of the goal in PDDL.
    #[getter]
    fn goal(&self) -> Vec<String> {
        self.goal.clone()
    }

    /// Notes on the parts that were left out or read in another way than they are written.
    #[getter]
    fn notes(&self) -> Vec<String> {
        self.notes.clone()
    }

    fn __repr__(&self) -> String {
        format!("<longstep.Problem {} of {}>", self.problem.name, self.domain.name)
    }
}

impl Problem {
    pub(crate) fn goal_texts(&self) -> &[String] {
        &self.goal
    }

    fn read(domain: Source, problem: Source) -> Result<Self, Failure> {
        let (domain_name, domain_text) = match domain {
            Source::File(path) => {
                let path: PathBuf = if path.is_dir() { path.join("domain.pddl") } else { path };
                (path.display().to_string(), read_text(&path)?)
            }
            Source::Text(text) => ("domain.pddl".to_owned(), text),
        };
        let problem = problem.read("problem.pddl")?;
        let own = read_foreign(&domain_name, &domain_text, Some(&problem.text))?;
        let mut read = pddl::read_problem(&own.domain, &problem.name, &problem.text)?;
        read.notes.splice(0..0, own.notes);
        let goal = pddl::write_goal(&read.world, &read.wanted)
            .map_err(|error| Failure::unreadable(format!("{}: {error}", problem.name)))?;
        Ok(Self {
            notes: read.notes.iter().map(ToString::to_string).collect(),
            problem: read,
            domain: Arc::new(LoadedDomain::from(own.domain)),
            goal,
        })
    }
}
