use super::*;
use crate::search::{Limits, Outcome, solve};
use crate::testing;
use longstep_model::domain;
use longstep_model::model::{Condition, When};
use longstep_verify::verify::{Purpose, VerifiedPlan, check};

/// A domain with everything that a reader rewrites: wide arguments, a derived predicate, numbers, costs, and effects of all forms.
const YARD: &str = "(define (domain yard) (:requirements :adl :fluents :derived-predicates)
  (:types crate truck - thing place) (:constants hub - place)
  (:predicates (at ?x - thing ?p - place) (full ?t - truck) (sealed ?c - crate) (loaded ?x - thing))
  (:functions (fuel ?t - truck) (total-cost))
  (:derived (ready ?t - truck) (and (not (full ?t)) (>= (fuel ?t) 1)))
  (:action drive :parameters (?t - truck ?from ?to - place)
    :precondition (and (at ?t ?from) (ready ?t) (not (= ?from ?to)))
    :effect (and (at ?t ?to) (not (at ?t ?from)) (decrease (fuel ?t) 0.5) (increase (total-cost) 3)
      (forall (?c - crate) (when (loaded ?c) (and (at ?c ?to) (not (at ?c ?from)))))))
  (:action seal :parameters (?x - thing)
    :precondition (and (imply (full ?x) (at ?x hub)) (exists (?p - place) (at ?x ?p)))
    :effect (and (sealed ?x) (increase (total-cost) 1))))";

const DAY: &str = "(define (problem day) (:domain yard) (:objects lorry - truck box - crate bay - place)
  (:init (at lorry hub) (at box hub) (loaded box) (= (fuel lorry) 1)) (:goal (and (at box bay) (sealed box))))";

const SHELF: &str = "(define (domain shelf) (:predicates (on ?x)) (:action put :parameters (?x) :effect (on ?x)))";

fn solved(domain: &str, problem: &str) -> (VerifiedPlan, Purpose) {
    let domain = domain::from_pddl("domain.pddl", domain).unwrap();
    let problem = read_problem(&domain, "problem.pddl", problem).unwrap();
    let purpose = Purpose::from(&problem);
    let Outcome::Solved { plan, .. } = solve(&problem.world, &purpose, &Limits::default()) else {
        panic!("{problem:?}")
    };
    (check(&problem.world, plan, &purpose).into_verified().unwrap(), purpose)
}

#[test]
fn a_domain_that_was_written_is_read_as_the_same_domain() {
    let shipped = domain::shipped_names()
        .into_iter()
        .map(|name| domain::shipped(name).unwrap().unwrap());
    // Its predicates have other numbers without the derived one.
    let derived = "(:derived (ready ?t - truck) (and (not (full ?t)) (>= (fuel ?t) 1)))";
    let yard = YARD.replace(derived, "").replace("(ready ?t)", "(>= (fuel ?t) 1)");
    let yard = domain::from_pddl("yard.pddl", &yard).unwrap();
    for domain in shipped.chain([yard]) {
        let text = write_domain(&domain).unwrap();
        let again = domain::from_pddl("domain.pddl", &text).unwrap();
        assert_eq!(write_domain(&again).unwrap(), text);
        assert_eq!(again.constants, domain.constants);
        for (own, again) in domain.actions.iter().zip(&again.actions) {
            assert_eq!(again.name, own.name);
            assert_eq!(again.parameters, own.parameters);
            let conjuncts = |own: &Condition| own.conjuncts().cloned().collect::<Vec<_>>();
            assert_eq!(
                conjuncts(&again.precondition),
                conjuncts(&own.precondition),
                "{}",
                own.name
            );
            assert_eq!(again.effects, own.effects, "{}", own.name);
            assert_eq!(again.numeric, own.numeric, "{}", own.name);
            assert_eq!(again.cost, own.cost, "{}", own.name);
        }
    }
}

#[test]
fn a_written_domain_is_strictly_typed_and_has_no_axioms() {
    let domain = domain::from_pddl("yard.pddl", YARD).unwrap();
    let text = write_domain(&domain).unwrap();
    for part in [
        "(:types\n    crate truck - thing\n    thing place - object)",
        "(:constants\n    hub - place)",
        // `seal` asks them of things.
        "(full ?t - thing)\n    (sealed ?c - thing)\n    (loaded ?x - thing))",
        "(:functions\n    (fuel ?t - truck) - number\n    (total-cost) - number)",
        ":precondition (and (at ?t ?from) (not (full ?t)) (>= (fuel ?t) 1) (not (= ?from ?to)))",
        "(forall (?x1 - crate) (when (loaded ?x1) (and (at ?x1 ?to) (not (at ?x1 ?from)))))",
        "(decrease (fuel ?t) 0.5)\n      (increase (total-cost) 3))",
    ] {
        assert!(text.contains(part), "{part}\n{text}");
    }
    assert!(!text.contains("ready"), "{text}");
}

#[test]
fn a_solved_task_is_solved_after_it_was_read_back() {
    let (plan, purpose) = solved(YARD, DAY);
    for purpose in [purpose, Purpose::default()] {
        let task = SolvedTask::write(&plan, &purpose, "day").unwrap();
        let domain = domain::from_pddl("domain.pddl", &task.domain).unwrap();
        let problem = read_problem(&domain, "problem.pddl", &task.problem).unwrap();
        let steps = read_plan(&problem.world, "plan.pddl", &task.plan).unwrap().steps;
        assert_eq!(steps.len(), 2);
        let step = |own: crate::search::GroundAction| {
            longstep_verify::plan::Step::explained(&problem.world, own.action, own.arguments)
        };
        let report = check(
            &problem.world,
            steps.into_iter().map(step).collect(),
            &Purpose::from(&problem),
        );
        assert_eq!(report.violations, vec![]);
    }
    let task = SolvedTask::write(&plan, &Purpose::default(), "day").unwrap();
    let goal = "  ; The plan was made without a goal: this one is what it changes.\n  (:goal (and\n    ";
    assert!(task.problem.contains(goal), "{}", task.problem);
    for part in [
        "(at box bay)",
        "(not (at box hub))",
        "(sealed box)",
        "(= (fuel lorry) 0.5)",
    ] {
        let (_, goal) = task.problem.split_once(goal).unwrap();
        assert!(goal.contains(part), "{part}\n{}", task.problem);
    }
}

#[test]
fn a_domain_that_looks_back_has_no_form_in_pddl() {
    let text = "(define (domain lamp) (:predicates (lit)) (:action act :parameters () :effect (lit)))";
    let domain = domain::from_pddl("lamp.pddl", text).unwrap().edited(|data| {
        data.actions[0].precondition = Condition::Atom {
            atom: data.actions[0].effects[0].atom.clone(),
            holds: false,
            at: When::Initially,
        };
    });
    let error = write_domain(&domain).unwrap_err();
    assert_eq!(
        error.to_string(),
        "the action `act` depends on the state before the plan, which a PDDL domain cannot say"
    );
}

#[test]
fn an_object_has_no_name_that_another_parser_refuses() {
    let household = domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<bin>", "<and>"], "objects": ["<Name>", "at", "<o'b [x]>", "<purée 7>"]}"#;
    let names = object_names(&testing::world_of(&household, text));
    assert_eq!(names, ["bin-2", "and-2", "name-2", "at-2", "o_b__x_", "pur_e_7"]);
    // A plan for a problem of others has the names of that problem.
    let domain = domain::from_pddl("domain.pddl", SHELF).unwrap();
    let problem = "(define (problem p) (:domain shelf) (:objects name on) (:init) (:goal (on name)))";
    let world = read_problem(&domain, "problem.pddl", problem).unwrap().world;
    assert_eq!(object_names(&world), ["name", "on"]);
}
