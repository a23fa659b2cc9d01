//! The Python module `longstep._longstep`: plans verified, repaired, found and carried out, from Python.
//!
//! Every class is frozen and holds data of the library. Searches, verification and waits release the interpreter. The
//! package around it, in `python/longstep`, has the exceptions, the types, and the client of a server; `_longstep.pyi`
//! describes this module to type checkers, and `scripts/python.sh` compares the two.

#![forbid(unsafe_code)]

mod active;
mod answer;
mod argument;
mod assess;
mod beside;
mod callable;
mod control;
mod domain;
mod draft;
mod failure;
mod finding;
mod interpreter;
mod json;
mod notation;
mod observation;
mod picture;
mod plan;
mod problem;
mod robot;
mod rule;
mod run;
mod session;
mod sim;
mod source;
mod step;
mod stopping;
mod world;

#[pyo3::pymodule]
mod _longstep {
    #[pymodule_export]
    use crate::answer::Answer;
    #[pymodule_export]
    use crate::assess::{repair, solve, verify};
    #[pymodule_export]
    use crate::control::Control;
    #[pymodule_export]
    use crate::domain::Domain;
    #[pymodule_export]
    use crate::finding::{Edit, Violation};
    #[pymodule_export]
    use crate::plan::Plan;
    #[pymodule_export]
    use crate::problem::Problem;
    #[pymodule_export]
    use crate::run::{Run, run};
    #[pymodule_export]
    use crate::session::Session;
    #[pymodule_export]
    use crate::sim::Sim;
    #[pymodule_export]
    use crate::step::Step;
    #[pymodule_export]
    use crate::world::World;

    use pyo3::prelude::*;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
