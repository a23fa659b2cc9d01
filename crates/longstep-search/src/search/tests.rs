//! Searches that need more than the first states, and what is known at their end.

use super::{Effort, Limits, Outcome, solve};
use crate::pddl::read_problem;
use longstep_model::domain;
use longstep_verify::verify::{self, Purpose};

/// A gripper between racks and centrifuges, which spin with their lids closed and with capped tubes.
const LAB: &str = include_str!("../../../../tools/peers/coverage/domains/lab.pddl");

/// Solves a goal about four uncapped tubes in the rack, and checks the plan.
fn lab(goal: &str, limits: &Limits) -> Outcome {
    let lab = domain::from_pddl("lab.pddl", LAB).unwrap();
    let problem = format!(
        "(define (problem tubes) (:domain lab) (:objects a b c d - tube rack - rack centrifuge - centrifuge)
           (:init (at rack) (hand-free) (in a rack) (in b rack) (in c rack) (in d rack) (filled a) (filled b))
           (:goal (and {goal})))"
    );
    let problem = read_problem(&lab, "tubes.pddl", &problem).unwrap();
    let outcome = solve(&problem.world, &Purpose::from(&problem), limits);
    if let Outcome::Solved { plan, .. } = &outcome {
        let report = verify::check(&problem.world, plan.clone(), &Purpose::from(&problem));
        assert_eq!(report.violations, vec![], "{goal}");
    }
    outcome
}

#[test]
fn search_plans_centrifuge_goals_within_a_step_limit() {
    for (goal, most) in [
        ("(spun a)", 9),
        ("(spun a) (in a rack) (not (lid-open centrifuge))", 15),
        ("(spun a) (spun b)", 14),
        ("(spun a) (spun b) (in a rack) (in b rack)", 23),
        ("(spun a) (spun b) (spun c) (spun d)", 25),
        (
            "(spun a) (spun b) (spun c) (spun d) (in a rack) (in b rack) (in c rack) (in d rack)",
            42,
        ),
    ] {
        let Outcome::Solved { plan, .. } = lab(goal, &Limits::default()) else {
            panic!("no plan for {goal}");
        };
        assert!(plan.steps().len() <= most, "{goal}: {} steps", plan.steps().len());
    }
}

#[test]
fn more_effort_finds_no_worse_plans_and_no_lower_bounds() {
    let goal = "(spun a) (spun b) (in a rack) (in b rack)";
    let mut before = None;
    for effort in [Effort::SMALL, Effort::NORMAL, Effort::try_from(200).unwrap()] {
        let Outcome::Solved {
            plan,
            shortest,
            at_least,
            ..
        } = lab(goal, &Limits::from(effort))
        else {
            panic!("no plan with effort {effort}");
        };
        let steps = plan.steps().len() as u32;
        assert!(
            at_least <= steps && shortest == (at_least == steps),
            "{effort}: {at_least} of {steps}"
        );
        if let Some((steps_before, at_least_before)) = before.replace((steps, at_least)) {
            assert!(steps <= steps_before && at_least >= at_least_before, "{effort}");
        }
    }
}

#[test]
fn a_search_without_states_gives_up_and_says_so() {
    let limits = Limits {
        direct: 0,
        proof: 0,
        shortest: 0,
        any: 0,
        effort: Effort::SMALL,
    };
    let Outcome::GaveUp { why, expanded: 0 } = lab("(spun a)", &limits) else {
        panic!("a plan without states");
    };
    assert_eq!(why, "no plan found in 0 states");
}

#[test]
fn lower_bound_on_steps_is_not_a_cost() {
    // Two detours lead to the lamp; that of more steps costs less.
    let lamp = "(define (domain lamp) (:requirements :adl :action-costs) (:types place)
      (:constants door hall stairs cellar lamp - place)
      (:predicates (at ?p - place)) COSTS
      (:action walk :parameters () :precondition (at door) :effect (and (at hall) (not (at door)) (increase (total-cost) 3)))
      (:action descend :parameters () :precondition (at hall) :effect (and (at cellar) (not (at hall)) (increase (total-cost) 2)))
      (:action cross :parameters () :precondition (at cellar) :effect (and (at lamp) (not (at cellar)) (increase (total-cost) 2)))
      (:action climb :parameters () :precondition (at hall) :effect (and (at lamp) (not (at hall)) (increase (total-cost) 9))))";
    let problem = "(define (problem p) (:domain lamp) (:init (at door)) (:goal (at lamp)))";
    let priced = lamp.replace("COSTS", "(:functions (total-cost) - number)");
    let plain = lamp.replace("COSTS", "").replace(" (increase (total-cost) 9)", "");
    let plain = [2, 3].iter().fold(plain, |text, cost| {
        text.replace(&format!(" (increase (total-cost) {cost})"), "")
    });
    for (text, expected) in [(&plain, (2, 2, None)), (&priced, (3, 0, Some("7".to_owned())))] {
        let domain = domain::from_pddl("lamp.pddl", text).unwrap();
        let problem = read_problem(&domain, "problem.pddl", problem).unwrap();
        let outcome = solve(&problem.world, &Purpose::from(&problem), &Limits::default());
        let Outcome::Solved {
            worst,
            shortest: true,
            at_least,
            cost,
            ..
        } = outcome
        else {
            panic!("{outcome:?}");
        };
        assert_eq!((worst, at_least, cost.map(|cost| cost.to_string())), expected);
    }
}
