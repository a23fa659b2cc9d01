//! Plans for goals with an order and with constraints, in a warehouse domain without shipped rules.

use super::{Goal, parse};
use crate::pddl::{read_problem, write_plan};
use crate::search::{Limits, Outcome, solve, why_not};
use crate::testing;
use longstep_model::domain::from_pddl;
use longstep_model::model::World;
use longstep_verify::verify::check;

const DOMAIN: &str = "(define (domain depot)
  (:requirements :strips :typing :negative-preconditions)
  (:types place thing - object)
  (:predicates (at ?p - place) (on ?t - thing ?p - place) (holding ?t - thing) (free) (shut ?p - place) (clean ?p - place) (rung))
  (:action go :parameters (?from ?to - place) :precondition (at ?from) :effect (and (not (at ?from)) (at ?to)))
  (:action take :parameters (?t - thing ?p - place) :precondition (and (at ?p) (on ?t ?p) (free) (not (shut ?p)))
    :effect (and (not (on ?t ?p)) (not (free)) (holding ?t)))
  (:action drop :parameters (?t - thing ?p - place) :precondition (and (at ?p) (holding ?t) (not (shut ?p)))
    :effect (and (on ?t ?p) (free) (not (holding ?t))))
  (:action unlock :parameters (?p - place) :precondition (and (at ?p) (shut ?p)) :effect (not (shut ?p)))
  (:action lock :parameters (?p - place) :precondition (and (at ?p) (not (shut ?p))) :effect (shut ?p))
  (:action sweep :parameters (?p - place) :precondition (and (at ?p) (free)) :effect (clean ?p))
  (:action ring :parameters () :precondition (at dock) :effect (rung)))";

fn depot() -> World {
    let domain = DOMAIN.replace("(:predicates", "(:constants dock - place) (:predicates");
    let domain = from_pddl("domain.pddl", &domain).unwrap();
    let problem = "(define (problem p) (:domain depot) (:objects hall store - place box vase - thing)
        (:init (at hall) (on box hall) (on vase hall) (free) (shut store)) (:goal (free)))";
    read_problem(&domain, "p.pddl", problem).unwrap().world
}

fn planned(world: &World, goal: &Goal) -> String {
    match solve(world, &goal.purpose(world), &Limits::default()) {
        Outcome::Solved { plan, shortest, .. } => {
            let report = check(world, plan.clone(), &goal.purpose(world));
            assert_eq!(report.violations, []);
            assert!(shortest);
            write_plan(world, plan.steps()).trim().replace('\n', " ")
        }
        Outcome::ProvenUnsolvable { .. } => "unsolvable".to_owned(),
        other @ Outcome::GaveUp { .. } => format!("{other:?}"),
    }
}

#[track_caller]
fn check_plans(rows: &[(&str, &str)]) {
    let world = depot();
    for (text, expected) in rows {
        let goal = parse(&world, text).unwrap_or_else(|error| panic!("{text}: {error}"));
        assert_eq!(planned(&world, &goal), *expected, "{text}");
        let written = goal.exact(&world).join(" & ");
        let again = parse(&world, &written).unwrap();
        assert_eq!(
            (again.facts, again.stages, again.constraints),
            (goal.facts, goal.stages, goal.constraints),
            "{written}"
        );
    }
}

#[test]
fn stages_are_achieved_in_order() {
    check_plans(&[
        ("at(dock)", "(go hall dock)"),
        // A place that a later stage excludes is left again; the last one stays.
        ("at(dock) then at(hall)", "(go hall dock) (go dock hall)"),
        (
            "at(dock) then at(store) then at(hall)",
            "(go hall dock) (go dock store) (go store hall)",
        ),
        ("at(hall) then at(dock)", "(go hall dock)"),
        // What an earlier stage achieved still holds at the end.
        (
            "clean(dock) then on(box, hall) & at(dock)",
            "(go hall dock) (sweep dock)",
        ),
        (
            "clean(dock) then on(box, dock)",
            "(go hall dock) (sweep dock) (go dock hall) (take box hall) (go hall dock) (drop box dock)",
        ),
        (
            "on(box, dock) then clean(dock)",
            "(take box hall) (go hall dock) (drop box dock) (sweep dock)",
        ),
        // A stage that holds from the beginning is complete at once, and the next one begins, unless a plan delays it.
        (
            "shut(hall) then shut(store) then shut(hall)",
            "(go hall store) (unlock store) (go store hall) (lock hall) (unlock hall) (go hall store) (lock store) \
             (go store hall) (lock hall)",
        ),
        // A goal of the same stage may come first or last.
        ("clean(hall) & clean(dock)", "(sweep hall) (go hall dock) (sweep dock)"),
        (
            "clean(dock) then clean(hall)",
            "(go hall dock) (sweep dock) (go dock hall) (sweep hall)",
        ),
    ]);
}

#[test]
fn constraints_bind_every_state_and_step() {
    check_plans(&[
        (
            "on(box, store) & never at(dock)",
            "(take box hall) (go hall store) (unlock store) (drop box store)",
        ),
        ("rung() & never at(dock)", "unsolvable"),
        ("on(box, store) & always shut(store)", "unsolvable"),
        ("on(box, store) & never unlock(store)", "unsolvable"),
        ("on(box, store) & never unlock(_)", "unsolvable"),
        (
            "on(box, dock) & never go(hall, dock)",
            "(take box hall) (go hall store) (go store dock) (drop box dock)",
        ),
        ("at(dock) & untouched(vase)", "(go hall dock)"),
        ("on(vase, dock) & untouched(vase)", "unsolvable"),
        (
            "on(vase, dock) & never holding(box)",
            "(take vase hall) (go hall dock) (drop vase dock)",
        ),
        (
            "at(dock) then at(hall) & never at(store)",
            "(go hall dock) (go dock hall)",
        ),
    ]);
}

#[test]
fn search_finds_plans_for_goals_with_groups() {
    check_plans(&[
        ("clean(any place)", "(sweep hall)"),
        ("clean(2 of place)", "(sweep hall) (go hall dock) (sweep dock)"),
        ("clean(any place where shut)", "(go hall store) (sweep store)"),
        ("at(any place except hall, dock)", "(go hall store)"),
        (
            "on(any thing except box, dock)",
            "(take vase hall) (go hall dock) (drop vase dock)",
        ),
        ("on(all thing, any place where not shut)", "; no steps"),
        ("holding(any thing) & never take(box, _)", "(take vase hall)"),
        ("holding(any thing) & never take(any thing, _)", "unsolvable"),
        ("holding(any thing) & untouched(all thing)", "unsolvable"),
        ("clean(any place) & never clean(hall)", "(go hall dock) (sweep dock)"),
        ("clean(dock) & never at(2 of place)", "(go hall dock) (sweep dock)"),
        (
            "clean(any place) then clean(any place except hall)",
            "(sweep hall) (go hall dock) (sweep dock)",
        ),
        (
            "on(box, dock) & always on(any thing, hall)",
            "(take box hall) (go hall dock) (drop box dock)",
        ),
        ("on(2 of thing, dock) & always on(any thing, hall)", "unsolvable"),
        ("shut(exactly 2 of place)", "(lock hall)"),
        // A disjunction that no step may break.
        ("on(box, dock) & always on(box, any place where not shut)", "unsolvable"),
    ]);
    let world = depot();
    let error = parse(&world, "never take(2 of thing, _)").unwrap_err().to_string();
    assert!(error.contains("write `all` or `any`"), "{error}");
}

#[test]
fn an_unsolvable_goal_has_reasons() {
    let world = depot();
    for (text, expected) in [
        (
            "rung() & never at(dock) & untouched(vase)",
            "[\"never at(dock)\"] [] false",
        ),
        (
            "on(box, store) & never unlock(store) & always shut(store)",
            "[\"never unlock(store)\", \"always shut(store)\"] [] false",
        ),
        ("at(hall) & at(dock)", "[] [] true"),
    ] {
        let goal = parse(&world, text).unwrap();
        let why = why_not(&world, &goal.purpose(&world), &Limits::default());
        assert_eq!(
            format!("{:?} {:?} {}", why.prohibitions, why.goals, why.together),
            expected,
            "{text}"
        );
    }
}

#[test]
fn a_fact_that_nothing_brings_about_is_named() {
    let text = r#"{"assets": ["<table>", "<window>", "<box>"], "objects": ["<cup>", "<box_lid>", "<pot>", "<pot_lid>"],
        "object_states": {"<cup>": "on_something(<table>)", "<box_lid>": "closed()", "<pot>": "on_something(<table>)",
            "<pot_lid>": "closed()"}}"#;
    let world = testing::world("household", text);
    for (text, expected) in [
        ("opened(table)", "the table is open"),
        ("on_something(cup, cup) & put(pot, box)", "the cup"),
    ] {
        let goal = parse(&world, text).unwrap();
        let why = why_not(&world, &goal.purpose(&world), &Limits::default());
        assert_eq!(why.goals, [0], "{text}: {why:?}");
        let message = why.missing.expect(text).sentence(&world);
        assert!(message.contains(expected), "{text}: {message}");
    }
}

/// A goal is kept and read again with identifiers, which environments choose.
#[test]
fn blanks_beside_a_comma_do_not_matter() {
    let household = longstep_model::domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    let world = longstep_model::environment::parse(&household, "env.json", text).unwrap();
    for text in [
        "put(pen, shelf)",
        "put(pen,shelf)",
        "put( <pen> ,  <shelf> )",
        "put(pen ,shelf)",
    ] {
        assert_eq!(
            parse(&world, text).unwrap().exact(&world),
            ["put(<pen>, <shelf>)"],
            "{text}"
        );
    }
}

/// Without a subject, a goal is about all its arguments: what was inspected may be moved for it.
#[test]
fn goal_without_a_subject_may_move_what_was_inspected() {
    let shipped = longstep_model::domain::shipped_files("household-checks").unwrap();
    let text = r#"{"assets": ["<counter>", "<rack>", "<bin>"], "objects": ["<yoghurt>"],
        "object_states": {"<yoghurt>": "on_something(<counter>)"}}"#;
    let goal = "if expired(yoghurt) then put(yoghurt, bin) else put(yoghurt, rack)";
    let plans = [true, false].map(|has_subject| {
        let mut files = shipped.clone();
        if !has_subject {
            let (before, after) = files.words.split_once("form = \"put(").unwrap();
            files.words = format!(
                "{before}form = \"put({}",
                after.replacen("subject = \"?item\"\n", "", 1)
            );
            assert_ne!(files.words, shipped.words);
        }
        let domain = longstep_model::domain::load(&files).unwrap();
        let world = longstep_model::environment::parse(&domain, "env.json", text).unwrap();
        planned(&world, &parse(&world, goal).unwrap())
    });
    assert!(plans[0].contains("check"), "{}", plans[0]);
    assert_eq!(plans[0], plans[1]);
}

#[test]
fn goals_with_any_identifier_are_read_again() {
    for identifier in [
        "<all cups>",
        "all cups",
        "<any cup where dirty>",
        "two of cups except the red one",
        "<then cup>",
        "then cup",
        "never cup",
        "<if x then y>",
        "if x then y",
        "<a >= b>",
        "a = b",
        "x <= 3",
        "<3 min>",
        "3 min",
        "<a | b; c>",
        "not <a>",
        "the <a",
        "<a>b>",
        "question: a",
        "<a\nb>",
        "a\tb\u{202e}",
        "< >",
        "-",
        "me",
    ] {
        let text = serde_json::json!({"assets": ["<table>"], "objects": [identifier]}).to_string();
        let world = testing::world("household", &text);
        let object = world.find(identifier).unwrap();
        let name = world.entity(object).name.clone();
        let goal = parse(&world, &format!("put({name}, table)"))
            .unwrap_or_else(|error| panic!("{identifier} as {name}: {error}"));
        let written = goal.exact(&world).join(" & ");
        let again = parse(&world, &written).unwrap_or_else(|error| panic!("{identifier}, {written}: {error}"));
        assert_eq!(again.facts, goal.facts, "{written}");
    }
}

/// Random goals against every sequence of steps up to a length.
mod enumerated {
    use proptest::prelude::*;

    use super::super::parse;
    use super::depot;
    use crate::search::{GroundAction, Limits, Outcome, solve};
    use longstep_model::model::{EntityId, Moment, State, Wanted, World, apply, holds};
    use longstep_verify::plan::{Plan, Step};
    use longstep_verify::verify::{Purpose, check};

    /// Maximum number of steps of an enumerated plan.
    const LONGEST: usize = 4;

    const FACTS: [&str; 20] = [
        "at(hall)",
        "at(dock)",
        "at(store)",
        "on(box, hall)",
        "on(box, dock)",
        "on(vase, dock)",
        "clean(hall)",
        "clean(dock)",
        "shut(store)",
        "shut(hall)",
        "holding(box)",
        "rung()",
        "on(any thing, dock)",
        "on(all thing, any place except store)",
        "holding(any thing except vase)",
        "clean(2 of place)",
        "clean(any place where not shut)",
        "at(any place except hall, dock)",
        "shut(exactly 2 of place)",
        "shut(all place where shut)",
    ];
    const CONSTRAINTS: [&str; 16] = [
        "never at(dock)",
        "never at(store)",
        "always on(vase, hall)",
        "never holding(box)",
        "untouched(vase)",
        "untouched(hall)",
        "never take(box, _)",
        "never go(hall, dock)",
        "always shut(store)",
        "never clean(hall)",
        "never holding(any thing)",
        "never clean(2 of place)",
        "never shut(all place except store)",
        "always on(any thing, hall)",
        "always shut(exactly 1 of place)",
        "never take(all thing except box, any place)",
    ];

    fn goal() -> impl Strategy<Value = String> {
        let stage = prop::collection::vec(prop::sample::select(&FACTS[..]), 1..3);
        let stages = prop::collection::vec(stage, 1..4);
        let constraints = prop::collection::vec(prop::sample::select(&CONSTRAINTS[..]), 0..3);
        (stages, constraints).prop_map(|(stages, constraints)| {
            let stages: Vec<String> = stages.iter().map(|facts| facts.join(" & ")).collect();
            let goal = [stages.join(" then ")]
                .into_iter()
                .chain(constraints.into_iter().map(str::to_owned));
            goal.collect::<Vec<_>>().join(" & ")
        })
    }

    fn is_so(world: &World, state: &State, wanted: &Wanted) -> bool {
        holds(Moment { world, state }, &wanted.condition, &mut wanted.bindings.clone())
    }

    /// Evaluates a purpose on the states of a plan, the initial one first.
    fn fulfils(world: &World, purpose: &Purpose, states: &[State], steps: &[GroundAction]) -> bool {
        let mut begin = 0;
        for stage in &purpose.stages {
            let mut end = begin;
            for milestone in stage {
                let mut open = (begin..states.len()).filter(|at| is_so(world, &states[*at], &milestone.wanted));
                match open.next() {
                    Some(at) if !(milestone.anew && at == begin) => end = end.max(at),
                    _ => return false,
                }
            }
            begin = end;
        }
        let last = &states[states.len() - 1];
        purpose.wanted.iter().all(|wanted| is_so(world, last, wanted)) && allowed(world, purpose, states, steps)
    }

    fn allowed(world: &World, purpose: &Purpose, states: &[State], steps: &[GroundAction]) -> bool {
        purpose.prohibitions.iter().all(|own| {
            let forbidden = |step: &GroundAction| own.steps.iter().any(|one| one.fits(step.action, &step.arguments));
            let is_kept = |state: &State| match &own.always {
                Some(rule) => holds(Moment { world, state }, &rule.condition, &mut Vec::new()),
                None => true,
            };
            !steps.iter().any(forbidden) && states.windows(2).all(|pair| is_kept(&pair[1]) || !is_kept(&pair[0]))
        })
    }

    /// Returns every applicable step in a state.
    fn applicable(world: &World, state: &State) -> Vec<GroundAction> {
        let mut found = Vec::new();
        for (id, action) in world.domain().action_ids() {
            let mut choices: Vec<Vec<EntityId>> = vec![Vec::new()];
            for parameter in &action.parameters {
                let entities = world.of_kind(parameter.kind);
                let with = |choice: &Vec<EntityId>| {
                    let longer = |entity: &EntityId| choice.iter().copied().chain([*entity]).collect::<Vec<_>>();
                    entities.iter().map(longer).collect::<Vec<_>>()
                };
                choices = choices.iter().flat_map(with).collect();
            }
            choices.retain(|choice| holds(Moment { world, state }, &action.precondition, &mut choice.clone()));
            let step = |arguments| GroundAction { action: id, arguments };
            found.extend(choices.into_iter().map(step));
        }
        found
    }

    /// Calls `visit` with the states and the steps of every plan, shorter ones first; stops when it returns true.
    fn first(world: &World, visit: &mut dyn FnMut(&[State], &[GroundAction]) -> bool) -> Option<usize> {
        let mut plans = vec![(vec![world.state.clone()], Vec::new())];
        for length in 0..=LONGEST {
            if plans.iter().any(|(states, steps)| visit(states, steps)) {
                return Some(length);
            }
            let mut longer = Vec::new();
            for (states, steps) in plans {
                let now = &states[states.len() - 1];
                for step in applicable(world, now) {
                    let mut next = now.clone();
                    apply(world, &mut next, world.domain().action(step.action), &step.arguments);
                    if next != *now {
                        longer.push((
                            [states.clone(), vec![next]].concat(),
                            [steps.clone(), vec![step]].concat(),
                        ));
                    }
                }
            }
            plans = longer;
        }
        None
    }

    proptest! {
        #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

        #[test]
        fn search_and_verification_agree_with_enumeration(text in goal(), sample in 0_usize..50) {
            let world = depot();
            let goal = parse(&world, &text).unwrap();
            let purpose = goal.purpose(&world);
            let mut number = 0;
            let shortest = first(&world, &mut |states, steps| {
                let expected = fulfils(&world, &purpose, states, steps);
                number += 1;
                if expected || number % 50 == sample {
                    let step = |step: &GroundAction| Step::explained(&world, step.action, step.arguments.clone());
                    let plan: Plan = steps.iter().map(step).collect();
                    let report = check(&world, plan, &purpose);
                    assert_eq!(report.violations.is_empty(), expected, "{text}: {steps:?} {:?}", report.violations);
                }
                expected
            });
            match solve(&world, &purpose, &Limits::default()) {
                Outcome::Solved { plan, shortest: proven, .. } => {
                    let length = plan.steps().len();
                    let report = check(&world, plan, &purpose);
                    prop_assert_eq!(&report.violations, &vec![], "{}", text);
                    match shortest {
                        Some(shortest) => prop_assert!(!proven || length == shortest, "{text}: {length} and not {shortest}"),
                        None => prop_assert!(length > LONGEST, "{text}: {length}"),
                    }
                }
                Outcome::ProvenUnsolvable { .. } => prop_assert_eq!(shortest, None, "{}", text),
                Outcome::GaveUp { why, .. } => prop_assert!(false, "{}: {}", text, why),
            }
        }
    }
}

#[test]
fn every_word_of_the_language_is_a_keyword() {
    let words = [
        super::constraint::NEVER,
        super::constraint::ALWAYS,
        super::conditional::IF,
        super::conditional::NOT,
        super::conditional::THEN,
        super::conditional::AND,
        super::conditional::ELSE,
        super::language::STAGE,
        "untouched",
        "where",
        "except",
        "all",
        "each",
        "any",
        "exactly",
        "of",
    ];
    for word in words {
        assert!(longstep_model::call::is_goal_keyword(word.trim()), "{word}");
    }
}

#[test]
fn goal_that_no_search_has_decided_is_not_called_impossible() {
    let household = longstep_model::domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#;
    let world = longstep_model::environment::parse(&household, "scene", text).unwrap();
    let limits = Limits {
        direct: 0,
        proof: 0,
        shortest: 0,
        any: 0,
        ..Limits::default()
    };
    let goal = parse(&world, "put(pen, shelf)").unwrap();
    assert!(matches!(
        solve(&world, &goal.purpose(&world), &limits),
        Outcome::GaveUp { .. }
    ));
    assert!(why_not(&world, &goal.purpose(&world), &limits).goals.is_empty());
}
