//! Tests of the binding of implicit arguments: arguments that only later steps, claims or conditions decide.

use super::bench;
use crate::plan::{DraftStep, Node, Resolved, StepId, Test};
use crate::verify::{Assumption, Purpose, StepClaim, bind_tree, check};
use longstep_model::model::World;

/// Returns a step such as `pass left 1 ?`, in which `?` is an implicit argument and a number is a lamp.
fn draft_step(world: &World, text: &str) -> DraftStep {
    let mut words = text.split_whitespace();
    let name = words.next().unwrap();
    let mut actions = world.domain().action_ids();
    let (action, _) = actions.find(|(_, action)| action.name == name).unwrap();
    let arguments = words.map(|word| match word.parse() {
        Ok(number) => Some(bench::lamp(world, number)),
        Err(_) => world.find(word),
    });
    DraftStep {
        action,
        arguments: arguments.collect(),
        explanation: String::new(),
    }
}

fn draft(world: &World, steps: &[&str], body: Vec<Node>, claims: Vec<StepClaim>) -> Resolved {
    Resolved {
        steps: steps.iter().map(|text| Some(draft_step(world, text))).collect(),
        body,
        claims,
        ..Resolved::default()
    }
}

/// Returns the calls of the bound steps, and the number of ambiguous arguments. The plan must be valid.
#[track_caller]
fn bound(world: &World, draft: &Resolved) -> (Vec<String>, usize) {
    let (plan, assumptions) = bind_tree(world, draft, None).unwrap();
    let calls = plan.steps().iter().map(|step| step.call(world).to_string()).collect();
    assert_eq!(check(world, plan, &Purpose::default()).violations, [], "{calls:?}");
    let ambiguous = |assumption: &&Assumption| matches!(assumption, Assumption::Argument { .. });
    (calls, assumptions.iter().filter(ambiguous).count())
}

fn steps(numbers: impl IntoIterator<Item = usize>) -> Vec<Node> {
    let numbers = numbers.into_iter();
    numbers.map(|number| Node::Step(StepId::new(number))).collect()
}

#[test]
fn binding_keeps_a_claim_whose_trace_a_later_step_removes() {
    let domain = bench::domain();
    let world = bench::world(&domain, 3, &[1]);
    for lamp in [2, 3] {
        // After the last step the state is the same, whichever lamp was lit in between.
        let claim = StepClaim {
            step: 1,
            fact: bench::fact(&world, "lit", lamp),
        };
        let texts = ["pass left 1 ?", "wait 1", "pass left ? 1"];
        let (calls, ambiguous) = bound(&world, &draft(&world, &texts, steps(0..3), vec![claim]));
        assert_eq!(calls[0], format!("pass_on(left, <lamp_1>, <lamp_{lamp}>)"));
        assert_eq!(ambiguous, 0, "{lamp}");
    }
}

#[test]
fn binding_senses_what_a_step_of_the_branch_needs() {
    let domain = bench::domain();
    let world = bench::world(&domain, 4, &[]);
    for lamp in [1, 3, 4] {
        // The outcomes of both sensing steps are known only after the second one.
        let sense = |number: usize| Test::Sense(StepId::new(number));
        let branch = Node::If {
            condition: Test::All(vec![sense(0), sense(1)]),
            then: steps([2]),
            otherwise: Vec::new(),
        };
        let texts = ["feel ?", "feel 2", &format!("cool {lamp}")];
        let (calls, ambiguous) = bound(&world, &draft(&world, &texts, vec![branch], Vec::new()));
        assert_eq!((&*calls[0], ambiguous), (&*format!("feel(<lamp_{lamp}>)"), 0));
    }
}

#[test]
fn binding_senses_what_a_condition_asks_several_steps_later() {
    let domain = bench::domain();
    let world = bench::world(&domain, 4, &[]);
    for lamp in [2, 3, 4] {
        let branch = Node::If {
            condition: Test::Holds(bench::fact(&world, "warm", lamp)),
            then: steps([2]),
            otherwise: Vec::new(),
        };
        let body = [steps(0..2), vec![branch]].concat();
        let texts = ["feel ?", "wait 1", "press left 1"];
        let (calls, ambiguous) = bound(&world, &draft(&world, &texts, body, Vec::new()));
        assert_eq!((&*calls[0], ambiguous), (&*format!("feel(<lamp_{lamp}>)"), 0));
    }
}
