//! Runs that are paused, while others use the robot.

use std::collections::BTreeSet;

use super::tests::{Mishap, Real, fact, household, kitchen, reports};
use super::*;
use longstep_model::environment::Observation;
use longstep_model::model::{Moment, PredicateId, holds};
use longstep_search::goal;
use longstep_search::search::{Limits, Outcome, solve};
use longstep_search::testing::{self, Draws};

const GOALS: [&str; 6] = [
    "put(cup, shelf)",
    "put(pen, shelf) & put(cup, bin)",
    "put(milk, table) then closed(fridge)",
    "put(cup, fridge) & closed(fridge)",
    "opened(fridge)",
    "put(pen, table) & put(milk, shelf)",
];

fn settings(reports: Vec<PredicateId>) -> Settings {
    Settings::default().with_approval(Approval::Never).with_reports(reports)
}

fn begun(world: &World, goal: &str, settings: Settings) -> Execution {
    Execution::new(&testing::plan_for(world, goal), &Aim::Goal(goal.to_owned()), settings).unwrap()
}

/// Runs until the execution is paused.
fn pause(execution: &mut Execution, real: &mut Real<'_>) {
    execution.pause();
    let end = real.run(execution);
    assert!(matches!(end, Need::Paused), "{end:?}");
    assert!(execution.is_paused() && execution.running().is_empty());
}

/// Plans for another goal in the world as it is, and carries that out on the same robot: an urgent run.
fn urgent(world: &World, real: &mut Real<'_>, goal: &str, settings: Settings) {
    // It knows how the robot holds things, which no environment says.
    let here = world.after_state(&real.state).continued(real.state.clone());
    let purpose = goal::parse(&here, goal).unwrap().purpose(&here);
    let Outcome::Solved { plan, .. } = solve(&here, &purpose, &Limits::default()) else {
        return;
    };
    let plan = check(&here, plan, &purpose).into_verified().unwrap();
    let mut other = Execution::new(&plan, &Aim::Goal(goal.to_owned()), settings).unwrap();
    let (log, calls) = (std::mem::take(&mut real.log), real.calls.len());
    let end = real.run(&mut other);
    assert!(matches!(end, Need::Done | Need::Stopped(_)), "{goal}: {end:?}");
    real.calls.truncate(calls);
    real.log = log;
}

/// Returns the first step that was ordered twice although no event between the two orders is a reason for it.
fn repeated_without_reason(log: &[Event]) -> Option<usize> {
    let (mut ordered, mut steps) = (BTreeSet::new(), Vec::new());
    for event in log {
        match event {
            Event::Ordered { order, step, .. } => {
                steps.push((*order, *step));
                if !ordered.insert(*step) {
                    return Some(*step);
                }
            }
            Event::Failed { order, .. } => {
                let (_, step) = steps.iter().find(|(own, _)| own == order).unwrap();
                ordered.remove(step);
            }
            Event::Changed { .. } => ordered.clear(),
            Event::Assessed { effect, .. } if *effect != Effect::Harmless => ordered.clear(),
            _ => {}
        }
    }
    None
}

fn is_reached(world: &World, state: &State, goal: &str) -> bool {
    let purpose = goal::parse(world, goal).unwrap().purpose(world);
    let world = world.continued(state.clone());
    let moment = Moment { world: &world, state };
    let wanted = purpose.at_end(world.domain());
    wanted
        .iter()
        .all(|own| holds(moment, &own.condition, &mut own.bindings.clone()))
}

/// Runs, pauses at drawn moments, and lets an urgent run use the robot in each pause. Robots that do not say where their
/// hand is are among them: no order may have a precondition that the urgent run made false, which [`Real`] checks.
#[test]
fn paused_run_ends_in_its_goal_after_any_urgent_run() {
    let world = kitchen();
    let mut pauses = 0;
    for seed in 0..120 {
        let draws = &mut Draws::new(seed);
        let goal = draws.of(&GOALS);
        // Where nothing shows the hand, nobody can know that it did not move.
        let (reports, mishap) = match seed % 2 {
            0 => (reports(&world), draws.of(&[Mishap::Fails, Mishap::NoEffect])),
            _ => (Vec::new(), Mishap::Fails),
        };
        let approval = draws.of(&[Approval::Never, Approval::Changes, Approval::EachStep]);
        let own_settings = settings(reports.clone()).with_approval(approval).with_changes(50);
        let mut execution = begun(&world, goal, own_settings);
        let mishaps = [(draws.below(12) as u64, mishap)];
        let mut real = Real::of(&execution, &mishaps);
        let mut left = 3;
        let end = loop {
            if left > 0 && draws.below(8) == 0 {
                left -= 1;
                pauses += 1;
                pause(&mut execution, &mut real);
                urgent(&world, &mut real, draws.of(&GOALS), settings(reports.clone()));
                execution.go_on();
            }
            if let Some(end) = real.turn(&mut execution) {
                break end;
            }
        };
        let case = format!("{seed}: {goal}: {:?} {:?}", real.calls, real.log.last());
        assert!(matches!(end, Need::Done), "{case}");
        assert!(is_reached(&world, &real.state, goal), "{case}");
        assert_eq!(repeated_without_reason(&real.log), None, "{case}");
        let replayed = Execution::replay(&household(), &real.log).unwrap();
        assert_eq!(replayed.state(), execution.state(), "{case}");
    }
    assert!(pauses > 150, "{pauses}");
}

/// The program ends at every event of a run that was paused twice, while others used the robot.
#[test]
fn paused_run_is_resumed_from_every_prefix_of_its_log() {
    let world = kitchen();
    let mut execution = begun(&world, GOALS[2], settings(Vec::new()));
    let mut real = Real::of(&execution, &[]);
    for other in [GOALS[0], GOALS[3]] {
        for _ in 0..9 {
            assert!(real.turn(&mut execution).is_none());
        }
        pause(&mut execution, &mut real);
        urgent(&world, &mut real, other, settings(Vec::new()));
        execution.go_on();
    }
    let end = real.run(&mut execution);
    assert!(matches!(end, Need::Done), "{end:?}");
    let text: Vec<String> = real.log.iter().map(|own| serde_json::to_string(own).unwrap()).collect();
    for length in 1..real.log.len() {
        let log: Vec<Event> = text[..length]
            .iter()
            .map(|own| serde_json::from_str(own).unwrap())
            .collect();
        let replayed = Execution::replay(&household(), &log).unwrap();
        let under_way = replayed.running().len();
        let mut again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
        assert!(!again.is_paused());
        if under_way == 0 {
            let mut robot = Real::of(&again, &[]);
            // Somebody used the robot while the program was gone, if it was paused.
            if replayed.is_paused() {
                urgent(&world, &mut robot, GOALS[1], settings(Vec::new()));
            }
            let end = robot.run(&mut again);
            assert!(matches!(end, Need::Done), "{length}: {end:?} {:?}", robot.log);
        }
    }
}

#[test]
fn paused_execution_orders_nothing_until_it_looked_again() {
    let world = kitchen();
    let mut execution = begun(&world, GOALS[0], settings(reports(&world)));
    // A pause before the first step looks at nothing.
    execution.pause();
    assert!(matches!(execution.next_need(), Need::Paused));
    execution.pause();
    assert!(matches!(execution.next_need(), Need::Paused));
    execution.go_on();
    execution.go_on();
    assert_eq!(execution.take_events()[1..], [Event::Paused, Event::Continued]);
    assert!(matches!(execution.next_need(), Need::Observe));
    // A pause that is over before the order under way has ended is none.
    let mut real = Real::of(&execution, &[]);
    assert!(real.turn(&mut execution).is_none());
    let Need::Perform(order) = execution.next_need() else {
        panic!()
    };
    execution.pause();
    assert!(matches!(execution.next_need(), Need::Wait) && !execution.is_paused());
    execution.go_on();
    execution.performed(order.number, None).unwrap();
    assert!(!execution.take_events().contains(&Event::Paused));
}

#[test]
fn stop_ends_a_paused_execution() {
    let world = kitchen();
    let mut execution = begun(&world, GOALS[0], settings(reports(&world)));
    let mut real = Real::of(&execution, &[]);
    pause(&mut execution, &mut real);
    execution.stop("stopped at a request");
    assert!(!execution.is_paused());
    assert!(matches!(execution.next_need(), Need::Stopped(Stop::Requested(_))));
    execution.go_on();
    execution.pause();
    assert!(matches!(execution.next_need(), Need::Stopped(Stop::Requested(_))));
    real.log.extend(execution.take_events());
    let mut again = Execution::resume(&household(), &real.log, Resumed::default()).unwrap();
    assert!(matches!(again.next_need(), Need::Observe));
}

/// The change that a person is asked about no longer fits after the pause: another one is proposed.
#[test]
fn question_before_a_pause_is_asked_again_about_the_observed_world() {
    let world = kitchen();
    let settings = settings(reports(&world)).with_approval(Approval::Changes);
    let mut execution = begun(&world, GOALS[0], settings);
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let mishaps = [(1, Mishap::Then(&away[..]))];
    let mut real = Real::of(&execution, &mishaps);
    let asked = |execution: &mut Execution, real: &Real<'_>| loop {
        match execution.next_need() {
            Need::Observe => {
                let seen = real.observation(execution.world(), &execution.settings.reports);
                execution.observed(&seen).unwrap();
            }
            Need::Approve(proposal) => return proposal,
            other => panic!("{other:?}"),
        }
    };
    let of_plan = asked(&mut execution, &real);
    execution.approve(&of_plan.id).unwrap();
    real.turn(&mut execution);
    real.turn(&mut execution);
    let first = asked(&mut execution, &real);
    assert!(matches!(first.subject, Subject::Change(_)));
    // Nothing happens in the first pause.
    pause(&mut execution, &mut real);
    execution.go_on();
    assert!(matches!(execution.next_need(), Need::Observe));
    assert_eq!(asked(&mut execution, &real).id, first.id);
    pause(&mut execution, &mut real);
    real.state.set(fact(&world, "<cup> inside_something(<fridge>)"), false);
    real.state.set(fact(&world, "<cup> inside_something(<bin>)"), true);
    execution.go_on();
    assert_ne!(asked(&mut execution, &real).id, first.id);
}

/// A look before a pause is no evidence after it: others may have changed the world.
#[test]
fn pause_takes_the_evidence_of_earlier_observations() {
    let world = kitchen();
    let mut execution = begun(&world, GOALS[0], settings(reports(&world)));
    let mut real = Real::of(&execution, &[]);
    while !execution.cursor().is_finished() {
        assert!(real.turn(&mut execution).is_none());
    }
    assert!(real.turn(&mut execution).is_none(), "the last observation");
    pause(&mut execution, &mut real);
    execution.go_on();
    let end = loop {
        match execution.next_need() {
            // The camera is covered.
            Need::Observe => execution.observed(&Observation::default()).unwrap(),
            end => break end,
        }
    };
    let Need::Stopped(Stop::Unseen { unseen, .. }) = end else {
        panic!("{end:?}")
    };
    assert!(
        unseen
            .iter()
            .all(|own| own.basis == Basis::BeforePause && own.is_open())
    );
    assert_eq!(
        unseen[0].sentence(),
        "last seen after step 6, and a pause since: the cup is on the shelf"
    );
}

const BELLS: &str = "(define (domain bells) (:types tower bell)
  (:predicates (rung ?x - bell))
  (:action ring :parameters (?x - bell) :precondition () :effect (rung ?x)))";

const BELLS_WORDS: &str = r#"name = "bells"
about = "A robot that rings bells."

[environment]
assets = "tower"
objects = "bell"

[[predicate]]
name = "rung"
says = "{x} was rung"
denies = "{x} was not rung"
event = true

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

/// A robot that counts events begins to count anew for the urgent run. The bell that this run rang stays rung.
#[test]
fn events_of_a_run_are_kept_through_a_pause() {
    let files = longstep_model::domain::Files {
        pddl: BELLS.to_owned(),
        words: BELLS_WORDS.to_owned(),
        ..longstep_model::domain::Files::default()
    };
    let domain = longstep_model::domain::load(&files).unwrap();
    let world = testing::world_of(&domain, r#"{"objects": ["<north>", "<south>"]}"#);
    let rung = vec![PredicateId::new(0)];
    let mut execution = begun(&world, "rung(north) & rung(south)", settings(rung));
    let mut real = Real::of(&execution, &[]);
    for _ in 0..3 {
        assert!(real.turn(&mut execution).is_none());
    }
    assert_eq!(real.calls.len(), 1);
    pause(&mut execution, &mut real);
    real.state = world.state.clone();
    execution.go_on();
    let end = real.run(&mut execution);
    assert!(matches!(end, Need::Done), "{end:?}");
    assert_eq!(real.calls.len(), 2, "{:?}", real.calls);
}
