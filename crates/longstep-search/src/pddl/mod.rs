//! PDDL problems and plans, for exchange with other planners.
//!
//! [`read_problem`] reads a problem file for a domain. [`write_problem`] writes a world and a goal as a problem that
//! any planner reads together with the unchanged `domain.pddl`. [`GroundTask`] writes goals with an order and rules, which
//! PDDL cannot say, as a task of its own. [`SolvedTask`] writes a plan with the domain and the problem that it belongs to.
//! [`read_plan`] reads the plans of other planners in their notations, and
//! [`write_plan`] writes one `(action argument ...)` per line.
//!
//! ```
//! use longstep_search::search::{Limits, Outcome, solve};
//! use longstep_verify::verify::Purpose;
//! use longstep_model::domain;
//! use longstep_search::pddl;
//!
//! let lamps = "(define (domain lamps) (:predicates (lit ?lamp))
//!     (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) :effect (lit ?lamp)))";
//! let evening = "(define (problem evening) (:domain lamps) (:objects hall porch)
//!     (:init (lit hall)) (:goal (forall (?lamp) (lit ?lamp))))";
//! let domain = domain::from_pddl("lamps.pddl", lamps)?;
//! let problem = pddl::read_problem(&domain, "evening.pddl", evening)?;
//! let outcome = solve(&problem.world, &Purpose::from(&problem), &Limits::default());
//! let Outcome::Solved { plan, .. } = outcome else { panic!("{outcome:?}") };
//! assert_eq!(pddl::write_plan(&problem.world, plan.steps()), "(light porch)\n");
//! # Ok::<(), longstep_model::diagnostic::Diagnostics>(())
//! ```

mod domain;
#[cfg(test)]
mod domain_tests;
#[cfg(test)]
mod foreign_tests;
mod ground;
mod names;
mod plan;
mod plan_lines;
mod solved;
#[cfg(test)]
mod tests;
mod write;

pub use domain::write_domain;
pub use ground::GroundTask;
pub use longstep_model::domain::{Problem, read_problem, read_start};
pub use names::object_names;
pub use plan::{Author, ForeignPlan, author_of_plan, read_plan, write_plan};
pub use solved::SolvedTask;
pub use write::{WriteError, write_goal, write_problem};
