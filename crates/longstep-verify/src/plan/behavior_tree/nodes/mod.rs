//! Nodes to fill in: a C++ header or a Python module with a function for each leaf that a behavior tree of a domain can have.
//!
//! A person derives a class from `Robot`, and registers it. The text is a function of the domain: the same domain gives the same
//! bytes. A function keeps its name when others are added to the domain.
//!
//! ```
//! use longstep_model::domain;
//! use longstep_verify::plan::behavior_tree::nodes::{self, Language};
//! let household = domain::shipped("household").unwrap()?;
//! let header = nodes::write(&household, Language::Cpp);
//! assert!(header.contains("virtual Begun<Done> grasp_object(const std::string& item) = 0;"));
//! let module = nodes::write(&household, Language::Python);
//! assert!(module.contains("def grasp_object(self, item: str) -> Task[Done]:"));
//! # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
//! ```

mod comment;
mod cpp;
mod function;
mod identifier;
mod python;
#[cfg(test)]
mod tests;

use function::Functions;
use longstep_model::model::Domain;

/// A programming language with nodes for behavior trees.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub enum Language {
    /// A header in C++17, for BehaviorTree.CPP 4.
    Cpp,
    /// A module for Python 3.9 and later, for `behaviortreepy`, which binds BehaviorTree.CPP 4.
    Python,
}

/// Writes the functions of a domain's leaves, to be filled in, and their registration.
pub fn write(domain: &Domain, language: Language) -> String {
    let functions = Functions::of(domain);
    match language {
        Language::Cpp => cpp::write(&functions),
        Language::Python => python::write(&functions),
    }
}
