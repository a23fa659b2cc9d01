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
