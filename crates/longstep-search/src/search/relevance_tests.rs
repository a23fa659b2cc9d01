//! Operators that look needless and are not.

use super::{Limits, Outcome, solve};
use crate::goal;
use crate::pddl::{read_problem, write_plan};
use longstep_model::domain::from_pddl;
use longstep_verify::verify::{Purpose, check};

/// Returns a cheapest plan that the verifier accepts, with its cost; a goal in words takes the place of the problem's.
fn planned(domain: &str, problem: &str, goal: Option<&str>) -> String {
    let domain = from_pddl("domain.pddl", domain).unwrap_or_else(|error| panic!("{error}"));
    let problem = read_problem(&domain, "problem.pddl", problem).unwrap_or_else(|error| panic!("{error}"));
    let world = &problem.world;
    let purpose = match goal {
        Some(text) => goal::parse(world, text).unwrap().purpose(world),
        None => Purpose::from(&problem),
    };
    let Outcome::Solved {
        plan, cost, shortest, ..
    } = solve(world, &purpose, &Limits::default())
    else {
        return "no plan".to_owned();
    };
    assert_eq!(check(world, plan.clone(), &purpose).violations, []);
    assert!(shortest);
    let cost = cost.map(|cost| format!(" ({cost})")).unwrap_or_default();
    write_plan(world, plan.steps()).trim().replace('\n', " ") + &cost
}

#[test]
fn conditions_of_conditional_effects_are_simulated_however_far_they_are_from_the_goal() {
    // A barge takes one load at a time: loading moves its room from `empty` to `full`, and `has-room` follows the room.
    let domain = "(define (domain barge) (:requirements :adl :action-costs)
      (:types boat pier amount space - object)
      (:constants full empty - space a0 a1 a2 - amount)
      (:predicates (at ?b - boat ?p - pier) (room ?b - boat ?l - space) (has-room ?b - boat) (fewer ?a ?b - amount)
        (narrower ?a ?b - space) (cargo ?b - boat ?l - amount) (some ?b - boat) (two-at ?p - pier) (pile ?p - pier ?l - amount))
      (:functions (total-cost) - number)
      (:action launch :parameters (?p - pier ?b - boat) :precondition (and)
        :effect (and (at ?b ?p) (room ?b empty) (has-room ?b) (increase (total-cost) 5)))
      (:action load :parameters (?b - boat ?p - pier) :precondition (and (at ?b ?p) (has-room ?b)) :effect (and
        (forall (?o ?n - amount) (when (and (pile ?p ?o) (fewer ?n ?o)) (and (pile ?p ?n) (not (pile ?p ?o)))))
        (forall (?o ?n - amount) (when (and (cargo ?b ?o) (fewer ?o ?n)) (and (not (cargo ?b ?o)) (cargo ?b ?n))))
        (forall (?o - amount) (when (and (cargo ?b ?o) (fewer ?o a1)) (some ?b)))
        (forall (?o ?n - space) (when (and (room ?b ?o) (narrower ?n ?o)) (and (not (room ?b ?o)) (room ?b ?n))))
        (forall (?o - space) (when (and (room ?b ?o) (= ?o empty)) (not (has-room ?b))))))
      (:action unload :parameters (?b - boat ?p - pier) :precondition (and (at ?b ?p) (some ?b)) :effect (and
        (forall (?o ?n - amount) (when (and (pile ?p ?o) (fewer ?o ?n)) (and (not (pile ?p ?o)) (pile ?p ?n))))
        (forall (?o - amount) (when (and (pile ?p ?o) (fewer a0 ?o)) (two-at ?p)))
        (forall (?o ?n - amount) (when (and (cargo ?b ?o) (fewer ?n ?o)) (and (not (cargo ?b ?o)) (cargo ?b ?n))))
        (forall (?o - amount) (when (and (cargo ?b ?o) (= ?o a1)) (not (some ?b))))
        UNLOADED (has-room ?b))))";
    let problem = "(define (problem p) (:domain barge) (:objects tug - boat east - pier)
      (:init (narrower full empty) (fewer a0 a1) (fewer a1 a2) (cargo tug a0) (pile east a0))
      (:goal (two-at east)) (:metric minimize (total-cost)))";
    for (unloaded, expected) in [
        // The boat is full once, and then has room for ever.
        (
            "",
            "(launch east tug) (load tug east) (unload tug east) (load tug east) (load tug east) (unload tug east) (unload tug east) (5)",
        ),
        // Unloading makes room, so that the next load takes it again.
        (
            "(forall (?o ?n - space) (when (and (room ?b ?o) (narrower ?o ?n)) (and (not (room ?b ?o)) (room ?b ?n))))",
            "(launch east tug) (load tug east) (launch east tug) (load tug east) (unload tug east) (unload tug east) (10)",
        ),
    ] {
        let domain = domain.replace("UNLOADED", unloaded);
        assert_eq!(planned(&domain, problem, None), expected, "{unloaded}");
    }
}

#[test]
fn a_number_is_set_before_it_is_increased() {
    let domain = "(define (domain pump) (:requirements :adl :numeric-fluents)
      (:predicates (primed) (unused)) (:functions (level))
      (:action prime :parameters () :precondition (primed) :effect (assign (level) 2))
      (:action boost :parameters () :precondition (unused) :effect (and (not (unused)) (increase (level) 3)))
      (:action leak :parameters () :precondition () :effect (decrease (level) 1)))";
    let problem = "(define (problem p) (:domain pump) (:init (primed) (unused) (= (level) 0)) (:goal (>= (level) 5)))";
    assert_eq!(planned(domain, problem, None), "(prime) (boost)");
    // From 9, setting it makes it less, and leaking still less.
    let problem = "(define (problem p) (:domain pump) (:init (primed) (= (level) 9)) (:goal (< (level) 2)))";
    assert_eq!(planned(domain, problem, None), "(prime) (leak)");
}

#[test]
fn a_rule_that_is_broken_at_first_is_kept_broken_while_it_would_be_in_the_way() {
    let domain = "(define (domain vats) (:requirements :adl) (:types vat) (:constants v0 v1 - vat)
      (:predicates (full ?x - vat) (done))
      (:action clear :parameters (?x - vat) :precondition () :effect (not (full ?x)))
      (:action fill :parameters () :precondition () :effect (full v0))
      (:action finish :parameters () :precondition (full v0) :effect (and (done) (not (full v1)))))";
    let problem = "(define (problem p) (:domain vats) (:init (full v1)) (:goal ()))";
    assert_eq!(
        planned(domain, problem, Some("done() & always full(2 of vat)")),
        "(clear v1) (fill) (finish)"
    );
}

#[test]
fn a_stage_is_delayed_until_the_next_one_can_begin() {
    let domain = "(define (domain vats) (:requirements :adl) (:types vat) (:constants v0 v1 - vat)
      (:predicates (full ?x - vat) (mixed) (warm))
      (:action clear :parameters () :precondition () :effect (not (full v0)))
      (:action fill :parameters () :precondition () :effect (full v0))
      (:action mix :parameters () :precondition (full v0) :effect (mixed))
      (:action heat :parameters () :precondition (mixed) :effect (and (full v1) (warm)))
      (:action cool :parameters () :precondition () :effect (not (warm))))";
    let problem = "(define (problem p) (:domain vats) (:init) (:goal ()))";
    assert_eq!(
        planned(domain, problem, Some("full(2 of vat) then warm()")),
        "(fill) (mix) (clear) (heat) (cool) (fill) (heat)"
    );
}
