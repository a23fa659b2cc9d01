//! Observed facts are kept when the next step fails, when the program is killed, and when others act.

use super::evidence_tests::tank;
use super::tests::{fact, household, kitchen};
use super::*;
use longstep_model::domain::{Files, from_pddl, load};
use longstep_model::environment::Observation;
use longstep_model::model::World;
use longstep_search::pddl::read_problem;
use longstep_search::testing;

const DOMAIN: &str = "(define (domain lamps) (:requirements :adl) (:types lamp)
  (:predicates (lit ?x - lamp) (dusty ?x - lamp) (swept))
  (:action light :parameters (?x - lamp) :precondition () :effect (lit ?x))
  (:action sweep :parameters () :precondition () :effect (and (swept) (forall (?x - lamp) (not (dusty ?x))))))";

fn lamps(init: &str) -> World {
    let domain = from_pddl("lamps.pddl", DOMAIN).unwrap();
    let problem =
        format!("(define (problem p) (:domain lamps) (:objects north south - lamp) (:init {init}) (:goal ()))");
    read_problem(&domain, "p.pddl", &problem).unwrap().world
}

fn begin(world: &World, goal: &str, trust: Trust) -> Execution {
    let settings = Settings::default().with_approval(Approval::Never).with_trust(trust);
    Execution::new(&testing::plan_for(world, goal), &Aim::Goal(goal.to_owned()), settings).unwrap()
}

/// Takes the next order.
fn order(execution: &mut Execution) -> u64 {
    match execution.next_need() {
        Need::Perform(order) => order.number,
        other => panic!("{other:?}"),
    }
}

/// Returns an observation of the named lamps with their states.
fn statements(seen: &[(&str, &str)]) -> Observation {
    let states = seen.iter().map(|(lamp, states)| {
        let states: Vec<String> = states.split_whitespace().map(str::to_owned).collect();
        ((*lamp).to_owned(), longstep_model::environment::Words::Many(states))
    });
    Observation {
        states: states.collect(),
        facts: None,
    }
}

fn observe(execution: &mut Execution, seen: &[(&str, &str)]) {
    assert!(matches!(execution.next_need(), Need::Observe));
    execution.observed(&statements(seen)).unwrap();
}

/// The second stage is achieved by a step that says that it failed: the first one was seen before it.
#[test]
fn execution_keeps_observed_progress_when_the_next_step_fails() {
    let world = lamps("");
    let mut execution = begin(&world, "lit(north) then lit(south)", Trust::Observed);
    observe(&mut execution, &[("north", ""), ("south", "")]);
    let first = order(&mut execution);
    execution.performed(first, None).unwrap();
    observe(&mut execution, &[("north", "lit"), ("south", "")]);
    let second = order(&mut execution);
    execution.failed(second, "it jammed").unwrap();
    observe(&mut execution, &[("north", "lit"), ("south", "lit")]);
    assert!(matches!(execution.next_need(), Need::Done));
}

/// A thing that is to be left untouched stays protected after others have moved it.
#[test]
fn execution_protects_untouched_objects_after_external_changes() {
    let world = lamps("(dusty north)");
    let mut execution = begin(&world, "swept() & untouched(south)", Trust::Observed);
    // Somebody spills dust over the south lamp, which sweeping would take away.
    observe(&mut execution, &[("north", "dusty"), ("south", "dusty")]);
    let end = execution.next_need();
    assert!(matches!(end, Need::Stopped(Stop::NoPlan { .. })), "{end:?}");
}

/// The program is killed when a person was asked about an order; what the look before the question showed is still known.
#[test]
fn resume_uses_observations_made_before_an_interruption() {
    let world = kitchen();
    let mut execution = begin(&world, "put(cup, shelf)", Trust::Observed);
    let seen = [("<cup>", "on_something(<table>)"), ("<pen>", "on_something(<table>)")];
    observe(&mut execution, &seen);
    order(&mut execution);
    let mut log = execution.take_events();
    // Nothing shows where the hand is, so a person is asked. Somebody has moved the pen meanwhile.
    let mut again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
    let moved = [("<pen>", "on_something(<shelf>)")];
    observe(&mut again, &moved);
    assert!(matches!(again.next_need(), Need::Judge(_)));
    log.extend(again.take_events());
    let mut again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
    observe(&mut again, &[("<cup>", "on_something(<table>)")]);
    let Need::Judge(asked) = again.next_need() else {
        panic!()
    };
    again.judged(asked.number, false).unwrap();
    assert!(again.state().holds(fact(&world, "<pen> on_something(<shelf>)")));
    log.extend(again.take_events());
    let repeated = Execution::replay(&household(), &log).unwrap();
    assert_eq!(repeated.state(), again.state());
}

/// The log lacks the end that trusts a promise, and the run is taken up again without trust.
#[test]
fn resume_without_trust_reopens_an_end_based_on_promises() {
    let world = tank();
    let mut execution = begin(
        &world,
        "level(north tank) >= 5 then level(north tank) >= 10",
        Trust::Promised,
    );
    let mut log = Vec::new();
    loop {
        match execution.next_need() {
            Need::Perform(order) => execution.performed(order.number, None).unwrap(),
            Need::Observe => execution.observed(&Observation::default()).unwrap(),
            Need::Done => break,
            other => panic!("{other:?}"),
        }
    }
    log.extend(execution.take_events());
    assert!(execution.rests_on_promises());
    assert!(matches!(log.pop(), Some(Event::Done { .. })));
    let resumed = |trust| Resumed {
        trust,
        ..Resumed::default()
    };
    let mut trusting = Execution::resume(world.domain(), &log, resumed(None)).unwrap();
    assert!(matches!(trusting.next_need(), Need::Done));
    let mut strict = Execution::resume(world.domain(), &log, resumed(Some(Trust::Observed))).unwrap();
    let end = loop {
        match strict.next_need() {
            Need::Observe => strict.observed(&Observation::default()).unwrap(),
            end => break end,
        }
    };
    assert!(matches!(end, Need::Stopped(Stop::Unseen { .. })), "{end:?}");
    log.extend(strict.take_events());
    let repeated = Execution::replay(world.domain(), &log).unwrap();
    assert!(repeated.is_ended() && repeated.settings().trust == Trust::Observed);
}

const BELLS: &str = "(define (domain bells) (:types tower bell)
  (:predicates (swings ?x - bell) (rung ?x - bell))
  (:action ring :parameters (?x - bell) :precondition () :effect (and (swings ?x) (rung ?x))))";

const BELLS_WORDS: &str = r#"name = "bells"
about = "A robot that rings bells."

[environment]
assets = "tower"
objects = "bell"

[[predicate]]
name = "swings"
says = "{x} swings"
denies = "{x} does not swing"

[[predicate]]
name = "rung"
says = "{x} was rung"
denies = "{x} was not rung"
event = true

[[state]]
word = "swings()"
fact = "(swings ?self)"
means = "the bell swings"

[[action]]
name = "ring"
call = "ring(?x)"
says = "ring {x}"
means = "rings a bell"

[[goal]]
form = "rung({x})"
parameters = "?x - bell"
condition = "(rung ?x)"
subject = "x"
says = "{x} was rung"
means = "a bell was rung"
"#;

/// One look shows that a step did what it promised; the next one that somebody has undone it. The bell was rung.
#[test]
fn execution_counts_a_step_as_done_once_its_effect_was_observed() {
    let files = Files {
        pddl: BELLS.to_owned(),
        words: BELLS_WORDS.to_owned(),
        ..Files::default()
    };
    let text = r#"{"objects": ["<north>", "<south>"]}"#;
    let world = testing::world_of(&load(&files).unwrap(), text);
    let mut execution = begin(&world, "rung(north) then rung(south)", Trust::Observed);
    observe(&mut execution, &[("<north>", ""), ("<south>", "")]);
    let first = order(&mut execution);
    execution.performed(first, None).unwrap();
    observe(&mut execution, &[("<north>", "swings()"), ("<south>", "")]);
    execution
        .observed(&statements(&[("<north>", ""), ("<south>", "")]))
        .unwrap();
    let second = order(&mut execution);
    execution.performed(second, None).unwrap();
    observe(&mut execution, &[("<north>", ""), ("<south>", "swings()")]);
    let end = execution.next_need();
    assert!(matches!(end, Need::Done), "{end:?}");
}

/// The first of two steps had no effect, so both are repeated. The second one has not failed.
#[test]
fn execution_does_not_count_a_repeated_later_step_as_failed() {
    let world = lamps("");
    let mut execution = begin(&world, "lit(north) & lit(south)", Trust::Promised);
    execution.settings.watch = Watch::OnFailure;
    observe(&mut execution, &[("north", ""), ("south", "")]);
    let mut steps = Vec::new();
    for _ in 0..2 {
        let Need::Perform(order) = execution.next_need() else {
            panic!()
        };
        execution.performed(order.number, None).unwrap();
        steps.push(order.arguments);
    }
    let name = |index: usize| world.entity(steps[index][0]).name.clone();
    let (first, second) = (name(0), name(1));
    observe(&mut execution, &[(&first, ""), (&second, "lit")]);
    let failed: Vec<_> = execution.failures.keys().map(|step| step.arguments.clone()).collect();
    assert_eq!(failed, [steps[0].clone()]);
}

/// Somebody undoes what a step was for each time. That the step is left out at last proves nothing.
#[test]
fn execution_claims_no_proof_after_omitting_an_undone_step() {
    let world = lamps("");
    let mut execution = begin(&world, "lit(north)", Trust::Promised);
    let step = GroundAction {
        action: world.domain().action_ids().next().unwrap().0,
        arguments: Vec::new(),
    };
    assert!(!execution.leaves_out_what_worked());
    // Nothing was performed since, so no effect of the step is missing.
    for _ in 0..=world.domain().action(step.action).retries {
        execution.count_repeated(std::slice::from_ref(&step));
    }
    assert!(execution.leaves_out_what_worked());
}
