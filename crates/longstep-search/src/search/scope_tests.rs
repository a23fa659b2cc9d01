//! Plans for a part of a large world, which the whole world has to accept.

use std::fmt::Write;

use super::{Limits, Outcome, Requirements, Scope, solve};
use crate::goal;
use crate::pddl::{read_problem, write_plan};
use longstep_model::domain::from_pddl;
use longstep_verify::verify::check;

/// A crane that drops a crate breaks all others at the place, unless the place is padded.
const DEPOT: &str = "(define (domain depot) (:requirements :adl) (:types crate place)
  (:predicates (at ?c - crate ?p - place) (padded ?p - place) (broken ?c - crate))
  (:action pad :parameters (?p - place) :precondition () :effect (padded ?p))
  (:action drop :parameters (?c - crate ?from - place ?to - place) :precondition (at ?c ?from)
    :effect (and (not (at ?c ?from)) (at ?c ?to)
      (forall (?other - crate) (when (and (at ?other ?to) (not (= ?other ?c)) (not (padded ?to))) (broken ?other))))))";

#[test]
fn plan_that_breaks_a_rule_outside_its_scope_leads_to_the_wider_scope() {
    let depot = from_pddl("depot.pddl", DEPOT).unwrap();
    let (mut objects, mut places) = (String::new(), String::new());
    for number in 0..80 {
        write!(objects, "c{number} ").unwrap();
        write!(places, "p{number} ").unwrap();
    }
    let at: String = (0..80).map(|number| format!("(at c{number} p{number}) ")).collect();
    let problem = format!(
        "(define (problem full) (:domain depot) (:objects {objects}- crate {places}- place) (:init {at}) (:goal (at c0 p1)))"
    );
    let problem = read_problem(&depot, "full.pddl", &problem).unwrap();
    let world = &problem.world;
    for (text, expected) in [
        ("at(c0, p1)", "(drop c0 p0 p1)"),
        // The crate at the place to go to comes into view with the wider scope.
        ("at(c0, p1) & never broken(any crate)", "(pad p1) (drop c0 p0 p1)"),
    ] {
        let purpose = goal::parse(world, text).unwrap().purpose(world);
        let restricted = purpose.world(world);
        let whole = Scope::whole(
            &restricted,
            &Requirements::of(&restricted, &purpose.wanted, &purpose.stages),
        );
        assert!(!whole.is_bearable(&restricted));
        let Outcome::Solved {
            plan, shortest: false, ..
        } = solve(world, &purpose, &Limits::default())
        else {
            panic!("no plan for {text}");
        };
        assert_eq!(write_plan(world, plan.steps()).trim().replace('\n', " "), expected);
        assert_eq!(check(world, plan, &purpose).violations, []);
    }
}
