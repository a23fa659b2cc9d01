use std::collections::BTreeSet;

use proptest::prelude::*;

use super::{Cursor, CursorError};
use crate::plan::{Plan, StepId};
use crate::verify::tests::bench::{Guard, Part, does, domain, fact, not, plan, world};
use crate::verify::tests::enumerated::{lane, parts};
use crate::verify::{Purpose, VerifiedPlan, check};
use longstep_model::model::{Fact, World, unmet};

fn verified(world: &World, plan: Plan) -> Option<VerifiedPlan> {
    check(world, plan, &Purpose::default()).into_verified().ok()
}

fn cursor(world: &World, parts: &[Part]) -> Cursor {
    let plan = plan(world, parts);
    Cursor::new(&verified(world, plan).expect("a valid plan"))
}

/// The numbers of the steps, from 1, that one run does; sensing always finds the outcome with this number.
fn run(mut cursor: Cursor, outcome: usize) -> Vec<usize> {
    let (mut done, mut seen) = (Vec::new(), None);
    while let Some(step) = cursor.next(seen).unwrap() {
        done.push(step.index() + 1);
        let known = cursor
            .outcomes(step)
            .into_iter()
            .find(|fact| cursor.state().holds(*fact));
        seen = known.or_else(|| cursor.outcomes(step).get(outcome).copied());
    }
    done
}

#[test]
fn the_steps_of_a_run_follow_what_is_observed() {
    let feel = || Guard::Feel(1);
    let is = |predicate| Guard::Is(predicate, 1);
    let branch = |guard| {
        vec![
            Part::If(guard, vec![does("cool 1")], vec![does("press left 2")]),
            does("link left 1 2"),
        ]
    };
    let cases: Vec<(Vec<Part>, [Vec<usize>; 2])> = vec![
        (
            vec![does("press left 1"), does("press left 2")],
            [vec![1, 2], vec![1, 2]],
        ),
        (branch(feel()), [vec![1, 2, 4], vec![1, 3, 4]]),
        (branch(not(not(feel()))), [vec![1, 2, 4], vec![1, 3, 4]]),
        (
            branch(Guard::All(vec![feel(), is("warm")])),
            [vec![1, 2, 4], vec![1, 3, 4]],
        ),
        (
            branch(Guard::Any(vec![feel(), is("lit")])),
            [vec![1, 2, 4], vec![1, 3, 4]],
        ),
        (
            vec![Part::Repeat(3, vec![does("press left 1"), does("unpress left 1")])],
            [vec![1, 2, 1, 2, 1, 2], vec![1, 2, 1, 2, 1, 2]],
        ),
        (vec![Part::Repeat(4_000_000_000, vec![])], [vec![], vec![]]),
        (
            vec![Part::Repeat(2, vec![Part::Repeat(2, vec![does("link left 1 2")])])],
            [vec![1; 4], vec![1; 4]],
        ),
        (
            vec![Part::While(feel(), vec![does("cool 1")])],
            [vec![1, 2, 1], vec![1]],
        ),
        (
            vec![Part::While(not(is("lit")), vec![does("press left 1")])],
            [vec![1], vec![1]],
        ),
    ];
    for (parts, expected) in cases {
        let domain = domain();
        let world = world(&domain, 2, &[]);
        for (outcome, expected) in expected.into_iter().enumerate() {
            assert_eq!(
                run(cursor(&world, &parts), outcome),
                expected,
                "{parts:?}, outcome {outcome}"
            );
        }
    }
}

#[test]
fn lanes_offer_a_step_each_and_wait_for_each_other() {
    let domain = domain();
    let world = world(&domain, 2, &[]);
    let lanes = vec![
        (
            "left",
            vec![
                "press left 1".to_owned(),
                "sync a".to_owned(),
                "unpress left 1".to_owned(),
            ],
        ),
        ("right", vec!["press right 2".to_owned(), "sync a".to_owned()]),
    ];
    let mut cursor = cursor(&world, &[Part::Lanes(lanes)]);
    let step = StepId::new;
    assert_eq!(cursor.ready(), [step(0), step(2)]);
    cursor.complete(step(2), None).unwrap();
    assert_eq!(cursor.ready(), [step(0)], "the right lane waits");
    assert_eq!(cursor.complete(step(1), None), Err(CursorError::NotReady(step(1))));
    cursor.complete(step(0), None).unwrap();
    assert_eq!(cursor.ready(), [step(1)]);
    cursor.complete(step(1), None).unwrap();
    assert!(cursor.is_finished());
    assert_eq!(cursor.state(), &cursor.plan().ending().after);
}

#[test]
fn an_observation_that_does_not_fit_leaves_the_cursor_where_it_was() {
    let domain = domain();
    let world = world(&domain, 2, &[]);
    let feel = |lamp| Part::If(Guard::Feel(lamp), vec![], vec![]);
    let mut cursor = cursor(&world, &[feel(1), feel(1)]);
    let (first, second) = (StepId::new(0), StepId::new(1));
    let (warm, cold) = (fact(&world, "warm", 1), fact(&world, "cold", 1));
    assert_eq!(cursor.complete(first, None), Err(CursorError::MissingOutcome(first)));
    let other = fact(&world, "warm", 2);
    assert_eq!(
        cursor.complete(first, Some(other)),
        Err(CursorError::UnknownOutcome(first))
    );
    assert_eq!(cursor.ready(), [first]);
    cursor.complete(first, Some(warm)).unwrap();
    assert_eq!(
        cursor.complete(second, Some(cold)),
        Err(CursorError::Contradiction(second))
    );
    cursor.complete(second, None).unwrap();
    assert!(cursor.is_finished());
}

/// The endings of all runs of at most `depth` steps, however sensing comes out and whichever lane goes first; none
/// where there are too many runs or one is longer, as in a loop that senses until it finds what it waits for.
fn endings(cursor: Cursor, depth: usize, left: &mut usize) -> Option<BTreeSet<Vec<Fact>>> {
    *left = left.checked_sub(1)?;
    let depth = depth.checked_sub(1)?;
    if cursor.is_finished() {
        return Some(BTreeSet::from([cursor.state().iter().collect()]));
    }
    let mut all = BTreeSet::new();
    for step in cursor.ready().to_vec() {
        let done = cursor.step(step);
        let world = cursor.plan().world();
        let action = world.domain().action(done.action);
        let missing = unmet(world, cursor.state(), &action.precondition, &mut done.arguments.clone());
        assert!(missing.is_empty(), "{step:?} is ready and not applicable");
        let outcomes = cursor.outcomes(step);
        let known = outcomes.is_empty() || outcomes.iter().any(|fact| cursor.state().holds(*fact));
        let seen = if known {
            vec![None]
        } else {
            outcomes.into_iter().map(Some).collect()
        };
        for seen in seen {
            let mut cursor = cursor.clone();
            cursor.complete(step, seen).unwrap();
            all.extend(endings(cursor, depth, left)?);
        }
    }
    Some(all)
}

fn ends_as_verified(world: &World, plan: Plan) -> Result<(), TestCaseError> {
    let plan = verified(world, plan);
    prop_assume!(plan.is_some());
    let plan = plan.unwrap();
    let found = endings(Cursor::new(&plan), 100, &mut 5_000);
    prop_assume!(found.is_some());
    let expected: BTreeSet<Vec<Fact>> = plan
        .endings()
        .iter()
        .map(|ending| ending.after.iter().collect())
        .collect();
    prop_assert_eq!(found.unwrap(), expected);
    Ok(())
}

/// Checks the rest of the plan at every position of a run: it is valid there, and ends as the run can end.
fn rests_are_valid(world: &World, plan: Plan, choices: &[usize]) -> Result<(), TestCaseError> {
    let plan = verified(world, plan);
    prop_assume!(plan.is_some());
    let mut cursor = Cursor::new(&plan.unwrap());
    for choice in choices {
        let rest = cursor.rest().expect("no test is nested so deep");
        let ready = cursor.ready().to_vec();
        prop_assert_eq!(rest.steps.is_empty(), ready.is_empty());
        let here = world.continued(cursor.state().clone());
        let report = check(&here, rest.plan.clone(), &Purpose::default());
        prop_assert!(report.violations.is_empty(), "{:?}: {:?}", rest, report.violations);
        let own = endings(Cursor::new(&report.into_verified().unwrap()), 100, &mut 2_000);
        let all = endings(cursor.clone(), 100, &mut 2_000);
        if let (Some(own), Some(all)) = (own, all) {
            prop_assert_eq!(own, all);
        }
        let Some(step) = ready.get(choice % ready.len().max(1)).copied() else {
            break;
        };
        let outcomes = cursor.outcomes(step);
        let known = outcomes.iter().find(|fact| cursor.state().holds(**fact)).copied();
        let seen = known.or_else(|| outcomes.get(choice % outcomes.len().max(1)).copied());
        cursor.complete(step, seen).unwrap();
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 300, max_global_rejects: 100_000, ..ProptestConfig::default() })]

    #[test]
    fn every_run_ends_as_the_verifier_says(parts in parts(), lit in prop::collection::vec(1..=2usize, 0..=2)) {
        let domain = domain();
        let world = world(&domain, 2, &lit);
        ends_as_verified(&world, plan(&world, &parts))?;
    }

    #[test]
    fn every_order_of_lanes_ends_as_the_verifier_says(
        left in lane("left"),
        right in lane("right"),
        lit in prop::collection::vec(1..=4usize, 0..=3),
    ) {
        let domain = domain();
        let world = world(&domain, 4, &lit);
        let lanes = Part::Lanes(vec![("left", left), ("right", right)]);
        ends_as_verified(&world, plan(&world, &[lanes]))?;
    }

    #[test]
    fn the_rest_of_a_plan_is_a_plan(
        parts in parts(),
        lit in prop::collection::vec(1..=2usize, 0..=2),
        choices in prop::collection::vec(0..6usize, 12),
    ) {
        let domain = domain();
        let world = world(&domain, 2, &lit);
        rests_are_valid(&world, plan(&world, &parts), &choices)?;
    }

    #[test]
    fn the_rest_of_lanes_is_a_plan(
        left in lane("left"),
        right in lane("right"),
        lit in prop::collection::vec(1..=4usize, 0..=3),
        choices in prop::collection::vec(0..6usize, 12),
    ) {
        let domain = domain();
        let world = world(&domain, 4, &lit);
        let lanes = Part::Lanes(vec![("left", left), ("right", right)]);
        rests_are_valid(&world, plan(&world, &[lanes]), &choices)?;
    }
}
