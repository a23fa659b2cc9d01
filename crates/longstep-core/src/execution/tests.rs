use super::*;
use longstep_model::domain;
use longstep_model::environment::{EntityId, fact_of};
use longstep_model::model::{Domain, Fact, Moment, PredicateId, apply, holds};
use longstep_search::testing;

const KITCHEN: &str = r#"{"assets": ["<table>", "<shelf>", "<fridge>", "<bin>"],
    "objects": ["<cup>", "<pen>", "<milk>", "<fridge_handle>"],
    "object_states": {"<cup>": "on_something(<table>)", "<pen>": "on_something(<table>)",
        "<milk>": "inside_something(<fridge>)", "<fridge_handle>": "closed()"}}"#;

pub(super) fn household() -> Domain {
    testing::domain("household")
}

pub(super) fn kitchen() -> World {
    testing::world("household", KITCHEN)
}

pub(super) fn fact(world: &World, text: &str) -> Fact {
    if let Some(item) = text.strip_prefix("lifted ") {
        let predicates = &world.domain().predicates;
        let lifted = predicates.iter().position(|own| own.name == "lifted").unwrap();
        return Fact::new(PredicateId::new(lifted), [world.find(item).unwrap()]);
    }
    let (subject, word) = text.split_once(' ').unwrap();
    fact_of(world, world.find(subject).unwrap(), word).unwrap()
}

/// The event at an order.
#[derive(Debug, Clone, Copy)]
pub(super) enum Mishap<'a> {
    /// The robot says that it cannot do the step.
    Fails,
    /// The robot says that it did the step, and nothing happened.
    NoEffect,
    /// These facts become true (`+`) and false (`-`) after the step.
    Then(&'a [&'a str]),
}

/// A real world with a robot.
pub(super) struct Real<'a> {
    pub(super) state: State,
    /// True if every step is observed, so that no order may be inapplicable.
    watched: bool,
    mishaps: &'a [(u64, Mishap<'a>)],
    pub(super) calls: Vec<String>,
    /// The values of the skill parameter `place` that came with orders of `move-hand`; null for none.
    places: Vec<serde_json::Value>,
    pub(super) log: Vec<Event>,
}

impl Real<'_> {
    pub(super) fn of<'a>(execution: &Execution, mishaps: &'a [(u64, Mishap<'a>)]) -> Real<'a> {
        Real {
            state: execution.state().clone(),
            watched: execution.settings.watch == Watch::EachStep,
            mishaps,
            calls: Vec::new(),
            places: Vec::new(),
            log: Vec::new(),
        }
    }

    pub(super) fn observation(&self, world: &World, reports: &[PredicateId]) -> Observation {
        let everything: Vec<EntityId> = world.entities().map(|(entity, _)| entity).collect();
        ObservedFacts::statements(world, &self.state, &everything, reports)
    }

    /// Performs an order; returns false if it fails.
    fn perform(&mut self, world: &World, order: &StepOrder) -> bool {
        let action = world.domain().action(order.action);
        let moment = Moment {
            world,
            state: &self.state,
        };
        if !holds(moment, &action.precondition, &mut order.arguments.clone()) {
            assert!(!self.watched, "{} is not applicable", order.written(world));
            return false;
        }
        self.calls.push(order.written(world));
        if action.name == "move-hand" {
            self.places.push(order.skills.get("place").cloned().unwrap_or_default());
        }
        let mishap = self.mishaps.iter().find(|(number, _)| *number == order.number);
        match mishap.map(|(_, mishap)| *mishap) {
            Some(Mishap::Fails) => return false,
            Some(Mishap::NoEffect) => {}
            Some(Mishap::Then(facts)) => {
                apply(world, &mut self.state, action, &order.arguments);
                for text in facts {
                    self.state.set(fact(world, &text[1..]), text.starts_with('+'));
                }
            }
            None => {
                apply(world, &mut self.state, action, &order.arguments);
            }
        }
        true
    }

    /// Runs to the end, or to a pause.
    pub(super) fn run(&mut self, execution: &mut Execution) -> Need {
        for _ in 0..500 {
            if let Some(end) = self.turn(execution) {
                return end;
            }
        }
        panic!("no end: {:?}", self.calls)
    }

    /// Meets the next need; returns it if it is none of the robot's, and no approval.
    pub(super) fn turn(&mut self, execution: &mut Execution) -> Option<Need> {
        let need = execution.next_need();
        self.log.extend(execution.take_events());
        let world = execution.world().clone();
        match need {
            Need::Perform(order) => {
                if self.perform(&world, &order) {
                    execution.performed(order.number, None).unwrap();
                } else {
                    execution.failed(order.number, "slipped").unwrap();
                }
            }
            Need::Observe => {
                let seen = self.observation(&world, &execution.settings.reports);
                execution.observed(&seen).unwrap();
            }
            Need::Approve(proposal) => execution.approve(&proposal.id).unwrap(),
            end => {
                self.log.extend(execution.take_events());
                return Some(end);
            }
        }
        None
    }
}

pub(super) fn reports(world: &World) -> Vec<PredicateId> {
    let predicates = world.domain().predicates.iter().enumerate();
    let hidden = predicates.filter(|(_, own)| ["hand-at", "lifted"].contains(&own.name.as_str()));
    hidden.map(|(index, _)| PredicateId::new(index)).collect()
}

fn execution(world: &World, goal: &str, watch: Watch) -> Execution {
    let settings = Settings::default()
        .with_approval(Approval::Never)
        .with_watch(watch)
        .with_reports(reports(world));
    Execution::new(&testing::plan_for(world, goal), &Aim::Goal(goal.to_owned()), settings).unwrap()
}

/// The effects of the differences, and the changes, of a log.
fn assessments(log: &[Event]) -> Vec<String> {
    let told = log.iter().filter_map(|event| match event {
        Event::Assessed { effect, .. } => Some(format!("{effect:?}")),
        Event::Changed { kind, .. } => Some(format!("{kind:?}")),
        _ => None,
    });
    told.collect()
}

#[test]
fn execution_classifies_and_repairs_differences() {
    let world = kitchen();
    // The plan for the cup: move-hand, grasp, detach, move-object, attach, release.
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let there = ["-<cup> on_something(<table>)", "+<cup> on_something(<shelf>)"];
    let fell = ["-<cup> inside_hand()", "-lifted <cup>", "+<cup> on_something(<table>)"];
    let moved = ["-<pen> on_something(<table>)", "+<pen> on_something(<shelf>)"];
    for (mishaps, expected, steps) in [
        (vec![], vec![], 6),
        (vec![(2, Mishap::Then(&moved[..]))], vec!["Harmless"], 6),
        (vec![(3, Mishap::Fails)], vec!["Harmless"], 7),
        (vec![(2, Mishap::NoEffect)], vec!["Undone"], 7),
        (vec![(5, Mishap::NoEffect)], vec!["Undone"], 7),
        (vec![(1, Mishap::Then(&there[..]))], vec!["Helpful"], 1),
        (vec![(4, Mishap::Then(&fell[..]))], vec!["Harmful", "Repaired"], 10),
        (vec![(1, Mishap::Then(&away[..]))], vec!["Harmful", "Repaired"], 15),
    ] {
        for watch in [Watch::EachStep, Watch::OnFailure] {
            let mut execution = execution(&world, "put(cup, shelf)", watch);
            let mut real = Real::of(&execution, &mishaps);
            let end = real.run(&mut execution);
            assert!(
                matches!(end, Need::Done),
                "{mishaps:?} {watch:?}: {end:?} {:?}",
                real.calls
            );
            assert!(
                real.state.holds(fact(&world, "<cup> on_something(<shelf>)")),
                "{mishaps:?}"
            );
            if watch == Watch::EachStep {
                let calls = &real.calls;
                assert_eq!(assessments(&real.log), expected, "{mishaps:?}: {calls:?}");
                assert_eq!(calls.len(), steps, "{mishaps:?}: {calls:?}");
            }
        }
    }
}

#[test]
fn a_step_that_keeps_failing_is_given_up_with_a_reason() {
    let world = kitchen();
    let mishaps: Vec<(u64, Mishap<'_>)> = (2..20).map(|order| (order, Mishap::Fails)).collect();
    let mut execution = execution(&world, "put(cup, shelf)", Watch::EachStep);
    let mut real = Real::of(&execution, &mishaps);
    let Need::Stopped(stop) = real.run(&mut execution) else {
        panic!("{:?}", real.calls)
    };
    assert!(stop.is_proven());
    let sentence = stop.sentence(&world);
    assert!(
        sentence.contains("`grasp(<cup>)` cannot be done (slipped)"),
        "{sentence}"
    );
    assert_eq!(
        real.calls,
        ["move-hand(<cup>)", "grasp(<cup>)", "grasp(<cup>)", "grasp(<cup>)"]
    );
}

#[test]
fn execution_applies_constraints_to_the_changed_plan() {
    // The cup ends up in the fridge, which may not be opened.
    let world = kitchen();
    let goal = "put(cup, shelf) & never opened(fridge)";
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let mishaps = [(1, Mishap::Then(&away))];
    let mut own = execution(&world, goal, Watch::EachStep);
    let mut real = Real::of(&own, &mishaps);
    let Need::Stopped(stop) = real.run(&mut own) else {
        panic!("{:?}", real.calls)
    };
    let sentence = stop.sentence(&world);
    assert!(stop.is_proven() && sentence.contains("never open"), "{sentence}");
    assert_eq!(real.calls.len(), 1);
    // Somebody else opens it.
    let opened = ["-<fridge_handle> closed()", "+<fridge_handle> open()"];
    let mishaps = [(1, Mishap::Then(&opened))];
    let mut own = execution(&world, goal, Watch::EachStep);
    let end = Real::of(&own, &mishaps).run(&mut own);
    assert!(matches!(end, Need::Stopped(Stop::Broken { .. })), "{end:?}");
}

#[test]
fn nothing_that_was_not_approved_is_performed() {
    let world = kitchen();
    let settings = |approval| {
        Settings::default()
            .with_approval(approval)
            .with_reports(reports(&world))
    };
    let aim = Aim::Goal("put(cup, shelf)".to_owned());
    let plan = testing::plan_for(&world, "put(cup, shelf)");
    let begin = |approval| Execution::new(&plan, &aim, settings(approval)).unwrap();
    let mut refused = begin(Approval::Changes);
    assert!(matches!(subject(&mut refused), Subject::Plan));
    refused.refuse().unwrap();
    assert!(matches!(refused.next_need(), Need::Stopped(Stop::Refused)));
    // A change is refused.
    let mut own = begin(Approval::Changes);
    approve(&mut own);
    let away = ["-<cup> on_something(<table>)", "+<cup> inside_something(<fridge>)"];
    let mishaps = [(1, Mishap::Then(&away))];
    let mut real = Real::of(&own, &mishaps);
    loop {
        match own.next_need() {
            Need::Perform(order) => {
                real.perform(&world, &order);
                own.performed(order.number, None).unwrap();
            }
            Need::Observe => own.observed(&real.observation(&world, &reports(&world))).unwrap(),
            Need::Approve(Proposal {
                subject: Subject::Change(change),
                ..
            }) => {
                assert!(!change.edits.is_empty());
                break;
            }
            other => panic!("{other:?}"),
        }
    }
    assert_eq!(real.calls.len(), 1);
    assert!(matches!(subject(&mut own), Subject::Change(_)), "it is asked again");
    own.refuse().unwrap();
    assert!(matches!(own.next_need(), Need::Stopped(Stop::Refused)));
    // Every step is asked about.
    let mut own = begin(Approval::EachStep);
    let (mut steps, mut real) = (0, Real::of(&own, &[]));
    loop {
        match own.next_need() {
            Need::Approve(proposal) => {
                steps += u32::from(matches!(proposal.subject, Subject::Step(_)));
                own.approve(&proposal.id).unwrap();
            }
            Need::Perform(order) => {
                real.perform(&world, &order);
                own.performed(order.number, None).unwrap();
            }
            Need::Observe => own.observed(&real.observation(&world, &reports(&world))).unwrap(),
            Need::Done => break,
            other => panic!("{other:?}"),
        }
    }
    assert_eq!((steps, real.calls.len()), (6, 6));
}

/// Returns the subject of the proposal that waits.
fn subject(execution: &mut Execution) -> Subject {
    match execution.next_need() {
        Need::Approve(proposal) => proposal.subject,
        other => panic!("{other:?}"),
    }
}

/// Approves what waits; returns its id.
fn approve(execution: &mut Execution) -> ProposalId {
    let Need::Approve(proposal) = execution.next_need() else {
        panic!("nothing is proposed")
    };
    execution.approve(&proposal.id).unwrap();
    proposal.id
}

/// A change is proposed; before the person answers, the world changes again, and so does the change.
#[test]
fn approval_of_one_change_does_not_approve_another() {
    let world = kitchen();
    let settings = Settings::default().with_reports(reports(&world));
    let aim = Aim::Goal("put(cup, shelf)".to_owned());
    let mut own = Execution::new(&testing::plan_for(&world, "put(cup, shelf)"), &aim, settings).unwrap();
    let of_plan = approve(&mut own);
    let mut real = Real::of(&own, &[]);
    let mut in_the = |place: &str, own: &mut Execution| {
        for other in [
            "on_something(<table>)",
            "inside_something(<fridge>)",
            "inside_something(<bin>)",
        ] {
            let holds = other == place;
            real.state.set(fact(&world, &format!("<cup> {other}")), holds);
        }
        own.observed(&real.observation(&world, &reports(&world))).unwrap();
    };
    assert!(matches!(own.next_need(), Need::Observe));
    in_the("inside_something(<fridge>)", &mut own);
    let Need::Approve(first) = own.next_need() else {
        panic!()
    };
    assert_eq!(own.approve(&of_plan), Err(ExecutionError::AnotherProposal));
    in_the("inside_something(<bin>)", &mut own);
    let Need::Approve(second) = own.next_need() else {
        panic!()
    };
    assert_ne!(first.id, second.id);
    assert_eq!(own.approve(&first.id), Err(ExecutionError::AnotherProposal));
    assert!(matches!(subject(&mut own), Subject::Change(_)), "it still waits");
    // The cup is back on its table: the change is withdrawn, and the plan that was approved goes on.
    in_the("on_something(<table>)", &mut own);
    assert_eq!(own.approve(&second.id), Err(ExecutionError::NothingProposed));
    let Need::Perform(order) = own.next_need() else {
        panic!()
    };
    assert_eq!(order.written(&world), "move-hand(<cup>)");
    // The log repeats all of this.
    let log = own.take_events();
    let again = Execution::replay(&household(), &log).unwrap();
    assert_eq!(again.running(), [order]);
}

#[test]
fn nothing_is_ordered_after_a_stop() {
    let world = kitchen();
    let mut own = execution(&world, "put(cup, shelf)", Watch::EachStep);
    own.next_need();
    own.observed(&Real::of(&own, &[]).observation(&world, &reports(&world)))
        .unwrap();
    let Need::Perform(order) = own.next_need() else {
        panic!()
    };
    own.take_events();
    own.stop("Ctrl-C");
    assert!(matches!(own.next_need(), Need::Stopped(Stop::Requested(_))));
    assert_eq!(own.performed(order.number, None), Err(ExecutionError::Ended));
    let events = own.take_events();
    assert!(matches!(&events[..], [Event::Stopped { under_way, .. }] if *under_way == [1]));
}

/// Crashes after every event of a run, and takes it up again.
#[test]
fn after_a_crash_an_unknown_step_is_observed_or_asked_about() {
    let world = kitchen();
    let household = household();
    let fell = ["-<cup> inside_hand()", "-lifted <cup>", "+<cup> on_something(<table>)"];
    let mishaps = [(4, Mishap::Then(&fell[..]))];
    let mut whole = execution(&world, "put(cup, shelf)", Watch::EachStep);
    let mut real = Real::of(&whole, &mishaps);
    real.run(&mut whole);
    let log = real.log;
    assert!(log.len() > 20, "{}", log.len());
    // Through its JSON, as a file has it.
    let lines: Vec<String> = log.iter().map(|event| serde_json::to_string(event).unwrap()).collect();
    let log: Vec<Event> = lines.iter().map(|line| serde_json::from_str(line).unwrap()).collect();
    for length in 1..log.len() {
        // The state of the real world at that moment, with and without the step under way.
        for was_done in [false, true] {
            let before = Execution::replay(&household, &log[..length]).unwrap();
            let mut state = before.state().clone();
            if let (true, [order]) = (was_done, before.running()) {
                apply(&world, &mut state, household.action(order.action), &order.arguments);
            }
            let mut again = Execution::resume(&household, &log[..length], Resumed::default()).unwrap();
            assert!(matches!(again.next_need(), Need::Observe), "{length}");
            let mut real = Real::of(&again, &[]);
            real.state = state;
            let end = real.run(&mut again);
            assert!(
                matches!(end, Need::Done),
                "{length} {was_done}: {end:?} {:?}",
                real.calls
            );
            assert!(real.state.holds(fact(&world, "<cup> on_something(<shelf>)")));
        }
    }
    assert_eq!(
        Execution::resume(&household, &log, Resumed::default()).err(),
        Some(ResumeError::Ended)
    );
    let mut damaged = log.clone();
    damaged.remove(3);
    assert!(matches!(
        Execution::resume(&household, &damaged, Resumed::default()),
        Err(ResumeError::Event(_))
    ));
}

/// The robot fails after every event of a run, and the run is taken up again.
#[test]
fn after_a_robot_failed_an_unknown_step_is_observed_or_asked_about() {
    let (world, household) = (kitchen(), household());
    let mut whole = execution(&world, "put(cup, shelf)", Watch::EachStep);
    let mut real = Real::of(&whole, &[]);
    real.run(&mut whole);
    for length in 1..real.log.len() {
        for was_done in [false, true] {
            let mut log = real.log[..length].to_vec();
            let mut failed = Execution::replay(&household, &log).unwrap();
            let mut state = failed.state().clone();
            let under_way: Vec<u64> = failed.running().iter().map(|order| order.number).collect();
            if let (true, [order]) = (was_done, failed.running()) {
                apply(&world, &mut state, household.action(order.action), &order.arguments);
            }
            failed.robot_failed("the bridge is gone");
            assert!(matches!(failed.next_need(), Need::Stopped(Stop::Robot(_))), "{length}");
            log.extend(failed.take_events());
            assert!(matches!(log.last(), Some(Event::Stopped { under_way: own, .. }) if *own == under_way));
            let mut again = Execution::resume(&household, &log, Resumed::default()).unwrap();
            log.extend(again.take_events());
            assert!(matches!(again.next_need(), Need::Observe), "{length}");
            // A second failure before anything was observed changes nothing.
            again.robot_failed("the bridge is gone again");
            log.extend(again.take_events());
            let mut again = Execution::resume(&household, &log, Resumed::default()).unwrap();
            let mut robot = Real::of(&again, &[]);
            robot.state = state;
            assert!(matches!(robot.run(&mut again), Need::Done), "{length} {was_done}");
            log.extend(robot.log);
            assert!(Execution::replay(&household, &log).unwrap().is_ended());
        }
    }
}

#[test]
fn resume_after_a_robot_failure_still_asks_for_approval() {
    let world = kitchen();
    let aim = Aim::Goal("put(cup, shelf)".to_owned());
    let mut own = Execution::new(&testing::plan_for(&world, "put(cup, shelf)"), &aim, Settings::default()).unwrap();
    own.robot_failed("the bridge is gone");
    let log = own.take_events();
    let mut again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
    assert!(matches!(
        again.next_need(),
        Need::Approve(Proposal {
            subject: Subject::Plan,
            ..
        })
    ));
    let mut refused = Execution::resume(&household(), &log, Resumed::default()).unwrap();
    refused.refuse().unwrap();
    let log: Vec<Event> = log.into_iter().chain(refused.take_events()).collect();
    assert_eq!(
        Execution::resume(&household(), &log, Resumed::default()).err(),
        Some(ResumeError::Ended)
    );
}

#[test]
fn execution_asks_about_a_step_that_observations_cannot_show() {
    let world = kitchen();
    let settings = Settings::default().with_approval(Approval::Never);
    let aim = Aim::Goal("put(cup, shelf)".to_owned());
    let mut own = Execution::new(&testing::plan_for(&world, "put(cup, shelf)"), &aim, settings).unwrap();
    let real = Real::of(&own, &[]);
    let seen = real.observation(&world, &[]);
    own.next_need();
    own.observed(&seen).unwrap();
    let Need::Perform(order) = own.next_need() else {
        panic!()
    };
    assert_eq!(order.written(&world), "move-hand(<cup>)");
    let crashed = own.take_events();
    let mut failed = own.clone();
    failed.robot_failed("it is gone");
    own.stop("stopped at a request");
    let [failed, stopped] = [failed.take_events(), own.take_events()].map(|more| [&crashed[..], &more[..]].concat());
    let ends = [
        (&crashed, true),
        (&failed, true),
        (&stopped, true),
        (&crashed, false),
        (&failed, false),
        (&stopped, false),
    ];
    for (log, done) in ends {
        let next = if done { "grasp(<cup>)" } else { "move-hand(<cup>)" };
        let mut again = Execution::resume(&household(), log, Resumed::default()).unwrap();
        // The same again: what was resumed and then stopped can be resumed.
        again.robot_failed("it is gone again");
        let log = [&log[..], &again.take_events()[..]].concat();
        let mut again = Execution::resume(&household(), &log, Resumed::default()).unwrap();
        assert_eq!(
            again.take_events(),
            [Event::Interrupted {
                approval: None,
                trust: None,
                under_way: vec![order.number]
            }]
        );
        assert!(matches!(again.next_need(), Need::Observe));
        again.observed(&seen).unwrap();
        let Need::Judge(order) = again.next_need() else {
            panic!()
        };
        again.judged(order.number, done).unwrap();
        let need = match again.next_need() {
            Need::Observe => {
                again.observed(&seen).unwrap();
                again.next_need()
            }
            need => need,
        };
        let Need::Perform(order) = need else { panic!("{need:?}") };
        assert_eq!((order.written(&world).as_str(), order.number), (next, 2));
    }
}

/// The handle is reached twice, and the hand has to go elsewhere the second time.
#[test]
fn execution_sends_skill_values_only_with_their_own_step() {
    let mut files = domain::shipped_files("household").unwrap();
    let declared = r#"[[action]]
        name = "move-hand"
        skill = [{ name = "place", type = "point", unit = "m", from = "demonstration" }]"#;
    files.skills = Some(("skills.toml".to_owned(), declared.to_owned()));
    let world = testing::world_of(&domain::load(&files).unwrap(), KITCHEN);
    let goal = "put(milk, table) then closed(fridge)";
    let plan = testing::plan_for(&world, goal);
    let calls: Vec<String> = plan.steps().iter().map(|step| step.call(&world).to_string()).collect();
    let moves: Vec<usize> = (0..calls.len())
        .filter(|index| calls[*index].starts_with("move_hand"))
        .collect();
    let handle = world.find("<fridge_handle>").unwrap();
    let to_handle: Vec<usize> = moves
        .iter()
        .copied()
        .filter(|index| plan.steps()[*index].arguments == [handle])
        .collect();
    let [open, close] = to_handle[..] else {
        panic!("{calls:?}")
    };
    let skills = serde_json::json!({"move-hand": [
        {"arguments": ["<milk>"], "values": {"place": [3, 0, 0]}},
        {"arguments": ["<fridge_handle>"], "step": open + 1, "values": {"place": [1, 0, 0]}},
        {"arguments": ["<fridge_handle>"], "step": close + 1, "values": {"place": [2, 0, 0]}},
    ]});
    let skills = longstep_verify::skill::Skills::from_value(world.domain(), skills).unwrap();
    let grasp = open as u64 + 2;
    let opened = ["-<fridge_handle> closed()", "+<fridge_handle> open()"];
    let stolen = ["-<milk> inside_something(<fridge>)", "+<milk> on_something(<shelf>)"];
    for (mishaps, expected) in [
        (vec![], Some(vec![1, 3, 2])),
        (vec![(grasp, Mishap::NoEffect)], Some(vec![1, 3, 2])),
        (vec![(grasp, Mishap::Fails)], Some(vec![1, 3, 2])),
        (vec![(grasp, Mishap::Then(&opened[..]))], Some(vec![1, 3, 2])),
        // The plan is changed, or there is none: nothing moves to the handle without its value.
        (vec![(open as u64 + 5, Mishap::Then(&stolen[..]))], None),
    ] {
        let settings = Settings::default()
            .with_reports(reports(&world))
            .with_skills(skills.clone());
        let settings = settings.with_approval(Approval::Never).with_watch(Watch::EachStep);
        let mut execution = Execution::new(&plan, &Aim::Goal(goal.to_owned()), settings).unwrap();
        let mut real = Real::of(&execution, &mishaps);
        let end = real.run(&mut execution);
        assert!(
            real.places.iter().all(|place| !place.is_null()),
            "{mishaps:?}: {:?}",
            real.calls
        );
        if let Some(expected) = expected {
            assert!(matches!(end, Need::Done), "{mishaps:?}: {end:?}");
            let first: Vec<i64> = real.places.iter().map(|place| place[0].as_i64().unwrap()).collect();
            assert_eq!(first, expected, "{mishaps:?}: {:?}", real.calls);
        }
    }
}
