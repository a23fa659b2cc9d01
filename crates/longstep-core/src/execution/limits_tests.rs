//! Runs within the levels and limits of a robot.

use super::tests::{Mishap, Real, fact, household, kitchen, reports};
use super::*;
use crate::autonomy::{Autonomy, Level, RefusalKind};
use longstep_model::domain::{load, shipped_files};
use longstep_search::testing;
use longstep_verify::plan::StepId;
use longstep_verify::skill::Skills;

const GOAL: &str = "put(cup, shelf)";

fn autonomy(world: &World, text: &str) -> Autonomy {
    Autonomy::parse(world.domain(), Some(world), "autonomy.toml", text).unwrap()
}

fn settings(world: &World, text: &str) -> Settings {
    Settings::default()
        .with_approval(Approval::Never)
        .with_reports(reports(world))
        .with_autonomy(autonomy(world, text))
}

fn begun(world: &World, goal: &str, settings: Settings) -> Result<Execution, BeginError> {
    Execution::new(&testing::plan_for(world, goal), &Aim::Goal(goal.to_owned()), settings)
}

/// The household in which moving the hand has a speed, with values for it.
fn with_speed() -> World {
    let mut files = shipped_files("household").unwrap();
    let declared = r#"[[action]]
        name = "move-hand"
        skill = [{ name = "speed", type = "number", unit = "m/s", from = "robot" }]"#;
    files.skills = Some(("skills.toml".to_owned(), declared.to_owned()));
    let kitchen = kitchen();
    let text = serde_json::to_string(kitchen.environment()).unwrap();
    testing::world_of(&load(&files).unwrap(), &text)
}

fn speeds(world: &World, entries: &serde_json::Value) -> Skills {
    Skills::from_value(world.domain(), serde_json::json!({ "move-hand": entries })).unwrap()
}

#[test]
fn plan_outside_of_the_limits_does_not_begin() {
    let world = with_speed();
    let fast = speeds(
        &world,
        &serde_json::json!([{"arguments": ["<cup>"], "values": {"speed": 0.5}}]),
    );
    for (text, expected) in [
        (
            "[autonomy]\nattach = \"never\"",
            "step 5 `attach(<cup>, <shelf>)`: `attach` is never performed",
        ),
        (
            "[[limit]]\nforbidden = [\"shelf\"]\nsays = \"it is freshly painted\"\naction = \"attach\"",
            "step 5 `attach(<cup>, <shelf>)`: the shelf is forbidden (it is freshly painted)",
        ),
        (
            "[[limit]]\nparameter = \"speed\"\nmax = \"0.25 m/s\"",
            "step 1 `move-hand(<cup>)`: `speed` is 0.5 m/s, and the limit is at most 0.25 m/s",
        ),
    ] {
        let error = begun(&world, GOAL, settings(&world, text).with_skills(fast.clone())).unwrap_err();
        assert_eq!(error.to_string(), expected);
        let BeginError::Refused(parts) = error else { panic!() };
        assert!(parts.iter().all(|part| part.step.is_some()));
    }
    let within = "[[limit]]\nparameter = \"speed\"\nmax = \"0.5 m/s\"";
    assert!(begun(&world, GOAL, settings(&world, within).with_skills(fast)).is_ok());
}

#[test]
fn goal_value_outside_of_the_limits_does_not_begin() {
    let mut world = crate::autonomy::tests::ovens();
    let goal = "hot(big oven, 90 degC)";
    world.add_values(goal);
    let limit = |maximum: &str| format!("[[limit]]\nvalue = \"temperature\"\nmax = \"{maximum}\"");
    let plan = testing::plan_for(&world, goal);
    let begin = |maximum: &str| {
        let settings = Settings::default().with_autonomy(autonomy(&world, &limit(maximum)));
        Execution::new(&plan, &Aim::Goal(goal.to_owned()), settings)
    };
    let error = begin("80 degC").unwrap_err().to_string();
    assert_eq!(
        error,
        "the goal: `temperature` is 90 degC, and the limit is at most 80 degC; step 1 `heat(<big_oven>, 90 degC)`: \
         `temperature` is 90 degC, and the limit is at most 80 degC"
    );
    assert!(begin("90 degC").is_ok());
}

#[test]
fn forbidden_place_that_the_world_does_not_have_is_an_error() {
    let world = kitchen();
    // Places are not looked up without a world.
    let text = "[[limit]]\nforbidden = [\"stove\"]";
    let autonomy = Autonomy::parse(world.domain(), None, "robot.toml", text).unwrap();
    let error = begun(&world, GOAL, Settings::default().with_autonomy(autonomy)).unwrap_err();
    assert_eq!(error, BeginError::UnknownPlaces(vec!["stove".to_owned()]));
}

/// The cup is in the fridge, and the only way to it is one that is never taken.
#[test]
fn changed_plan_avoids_actions_that_are_never_performed() {
    let world = kitchen();
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let mishaps = [(1, Mishap::Then(&away[..]))];
    let text = "[autonomy]\nopen-by-rotate = \"never\"\nopen-by-slide = \"never\"";
    let mut execution = begun(&world, GOAL, settings(&world, text)).unwrap();
    let mut real = Real::of(&execution, &mishaps);
    let Need::Stopped(stop) = real.run(&mut execution) else {
        panic!("{:?}", real.calls)
    };
    assert!(stop.is_proven() && !stop.is_resumable());
    let sentence = stop.sentence(&world);
    assert!(sentence.contains("`autonomy: never open-by-"), "{sentence}");
    assert_eq!(real.calls.len(), 1);
    // Without the levels the fridge is opened.
    let mut execution = begun(&world, GOAL, settings(&world, "")).unwrap();
    let mut real = Real::of(&execution, &mishaps);
    assert!(matches!(real.run(&mut execution), Need::Done));
    assert!(real.calls.iter().any(|call| call.starts_with("open-by-")));
}

/// The changed plan has to move the hand to the handle, where the only value is one that is too fast.
#[test]
fn changed_plan_has_no_step_with_a_value_outside_of_its_limits() {
    let world = with_speed();
    let speeds = speeds(
        &world,
        &serde_json::json!([{"arguments": ["_"], "values": {"speed": 0.1}},
            {"arguments": ["<fridge_handle>"], "values": {"speed": 0.9}}]),
    );
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let mishaps = [(1, Mishap::Then(&away[..]))];
    let limited = settings(&world, "[[limit]]\nparameter = \"speed\"\nmax = \"0.25 m/s\"").with_skills(speeds);
    let mut execution = begun(&world, GOAL, limited).unwrap();
    let mut real = Real::of(&execution, &mishaps);
    let Need::Stopped(stop) = real.run(&mut execution) else {
        panic!("{:?}", real.calls)
    };
    let sentence = stop.sentence(&world);
    let expected =
        "`move-hand(<fridge_handle>)` cannot be done (`speed` is 0.9 m/s, and the limit is at most 0.25 m/s)";
    assert!(sentence.contains(expected), "{sentence}");
    assert_eq!(real.calls.len(), 1);
}

#[test]
fn order_outside_of_the_limits_is_a_stop() {
    let world = kitchen();
    let mut execution = begun(&world, GOAL, settings(&world, "")).unwrap();
    let mut real = Real::of(&execution, &[]);
    assert!(real.turn(&mut execution).is_none());
    // As if a plan had come into force without the limits.
    execution.settings.autonomy = autonomy(&world, "[[limit]]\nforbidden = [\"cup\"]\nsays = \"it is hot\"");
    let Need::Stopped(stop) = execution.next_need() else {
        panic!()
    };
    let Stop::OutOfLimits { refusal, .. } = &stop else {
        panic!("{stop:?}")
    };
    assert!(matches!(refusal.kind, RefusalKind::Place { .. }));
    assert_eq!(
        stop.sentence(&world),
        "`move-hand(<cup>)` is outside of the limits of the robot: the cup is forbidden (it is hot)"
    );
    assert!(execution.running().is_empty());
}

/// A person is asked about each step of the level `approve`, although nobody approves plans.
#[test]
fn steps_are_approved_by_their_level() {
    let world = kitchen();
    for (text, expected) in [
        (
            "[autonomy]\ngrasp = \"approve\"\nattach = \"approve\"",
            vec!["grasp", "attach"],
        ),
        (
            "[autonomy]\ndefault = \"approve\"\ngrasp = \"free\"\nmove-hand = \"free\"",
            vec!["detach", "move-object", "attach", "release"],
        ),
        ("", vec![]),
    ] {
        let mut execution = begun(&world, GOAL, settings(&world, text)).unwrap();
        let mut real = Real::of(&execution, &[]);
        let end = real.run(&mut execution);
        assert!(matches!(end, Need::Done), "{end:?}");
        let asked = real.log.windows(2).filter_map(|pair| match pair {
            [Event::Approved { .. }, Event::Ordered { call, .. }] => call.split('(').next(),
            _ => None,
        });
        assert_eq!(asked.collect::<Vec<_>>(), expected, "{text}");
        assert!(Execution::replay(&household(), &real.log).is_ok());
    }
    let mut refused = begun(&world, GOAL, settings(&world, "[autonomy]\ndefault = \"approve\"")).unwrap();
    let mut real = Real::of(&refused, &[]);
    assert!(real.turn(&mut refused).is_none());
    refused.next_need();
    refused.refuse().unwrap();
    assert!(matches!(refused.next_need(), Need::Stopped(Stop::Refused)));
}

/// Meets every need but announcements; returns the announced order, or the end.
fn until_announced(execution: &mut Execution, real: &mut Real<'_>) -> Need {
    loop {
        if let Some(need) = real.turn(execution) {
            return need;
        }
    }
}

#[test]
fn announced_step_is_ordered_when_its_time_is_over() {
    let world = kitchen();
    let text = "[autonomy]\nannounce_s = 2\ngrasp = \"announce\"";
    let mut execution = begun(&world, GOAL, settings(&world, text)).unwrap();
    let mut real = Real::of(&execution, &[]);
    let Need::Announce(order) = until_announced(&mut execution, &mut real) else {
        panic!()
    };
    assert_eq!(order.written(&world), "grasp(<cup>)");
    // The same announcement waits, and is one event.
    assert!(matches!(execution.next_need(), Need::Announce(again) if again == order));
    let announced = |log: &[Event]| log.iter().filter(|own| matches!(own, Event::Announced { .. })).count();
    real.log.extend(execution.take_events());
    assert_eq!(announced(&real.log), 1);
    // Another number is none of it.
    assert_eq!(
        execution.announced(order.number + 1),
        Err(ExecutionError::UnknownOrder(order.number + 1))
    );
    // The program ends here: the step is announced again.
    let mut again = Execution::resume(&household(), &real.log, Resumed::default()).unwrap();
    let mut other = Real::of(&again, &[]);
    other.state = real.state.clone();
    assert!(matches!(until_announced(&mut again, &mut other), Need::Announce(_)));
    assert_eq!(announced(&other.log), 1);

    execution.announced(order.number).unwrap();
    assert!(matches!(real.run(&mut execution), Need::Done));
    assert_eq!(announced(&real.log), 1);
    let replayed = Execution::replay(&household(), &real.log).unwrap();
    assert!(replayed.is_ended() && replayed.settings().autonomy == execution.settings().autonomy);
}

#[test]
fn announced_step_is_withdrawn_with_its_world_and_by_a_pause() {
    let world = kitchen();
    let text = "[autonomy]\ngrasp = \"announce\"";
    let mut execution = begun(&world, GOAL, settings(&world, text)).unwrap();
    let mut real = Real::of(&execution, &[]);
    let Need::Announce(order) = until_announced(&mut execution, &mut real) else {
        panic!()
    };
    execution.pause();
    assert!(matches!(execution.next_need(), Need::Paused));
    execution.go_on();
    assert!(matches!(until_announced(&mut execution, &mut real), Need::Announce(again) if again == order));
    // Somebody takes the cup away before the time is over.
    real.state.set(fact(&world, "<cup> on_something(<table>)"), false);
    real.state.set(fact(&world, "<cup> on_something(<shelf>)"), true);
    let seen = real.observation(&world, &reports(&world));
    execution.observed(&seen).unwrap();
    assert_eq!(
        execution.announced(order.number),
        Err(ExecutionError::UnknownOrder(order.number))
    );
    assert!(matches!(until_announced(&mut execution, &mut real), Need::Done));
    assert!(!real.calls.iter().any(|call| call.starts_with("grasp")));
}

/// The limits of a run are in its log: it is resumed within them.
#[test]
fn resumed_run_keeps_its_limits() {
    let world = kitchen();
    let text = "[autonomy]\nopen-by-rotate = \"never\"\nopen-by-slide = \"never\"\n[[limit]]\nforbidden = [\"bin\"]";
    let mut execution = begun(&world, GOAL, settings(&world, text)).unwrap();
    let log = execution.take_events();
    let written: Vec<String> = log.iter().map(|own| serde_json::to_string(own).unwrap()).collect();
    let log: Vec<Event> = written.iter().map(|own| serde_json::from_str(own).unwrap()).collect();
    let again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
    assert_eq!(again.settings().autonomy, autonomy(&world, text));
    let open = world
        .domain()
        .action_ids()
        .find(|(_, own)| own.name == "open-by-rotate")
        .unwrap()
        .0;
    assert_eq!(again.settings().autonomy.level(open), Level::Never);
    let handle = world.find("<fridge_handle>").unwrap();
    assert!(again.world().forbids(open, &[handle]).is_some());
    let (cup, bin) = (world.find("<cup>").unwrap(), world.find("<bin>").unwrap());
    let attach = world
        .domain()
        .action_ids()
        .find(|(_, own)| own.name == "attach")
        .unwrap()
        .0;
    assert!(again.world().forbids(attach, &[cup, bin]).is_some());
    // What comes after the run is not limited by it.
    assert!(again.after().forbids(open, &[handle]).is_none());
    assert_eq!(again.plan().plan().step(StepId::new(0)).arguments, [cup]);
}
