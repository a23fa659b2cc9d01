//! Runs whose robots promise what does not happen, see a part of the world, or see nothing.

use super::tests::{fact, household, kitchen, reports};
use super::*;
use longstep_model::environment::EntityId;
use longstep_model::model::{Moment, apply, holds};
use longstep_search::goal;
use longstep_search::testing;

/// A real world with a robot that says that it performed every order.
struct Robot<'a> {
    state: State,
    /// The numbers of the orders without any effect.
    idle: &'a [u64],
    /// The entities that it sees; none for all.
    sees: Option<Vec<EntityId>>,
    /// The real states, one after each order.
    history: Vec<State>,
    looks: usize,
    log: Vec<Event>,
}

impl<'a> Robot<'a> {
    fn new(execution: &Execution, idle: &'a [u64], sees: Option<&[&str]>) -> Self {
        let world = execution.world();
        let entities = |names: &[&str]| names.iter().map(|name| world.find(name).unwrap()).collect();
        Self {
            state: world.state.clone(),
            idle,
            sees: sees.map(entities),
            history: vec![world.state.clone()],
            looks: 0,
            log: Vec::new(),
        }
    }

    fn observation(&self, execution: &Execution) -> Observation {
        let world = execution.world();
        let all = || world.entities().map(|(entity, _)| entity).collect();
        let entities: Vec<EntityId> = self.sees.clone().unwrap_or_else(all);
        let mut seen = ObservedFacts::statements(world, &self.state, &entities, &execution.settings.reports);
        if self.sees.is_some() {
            seen.facts = None;
        }
        seen
    }

    fn run(&mut self, execution: &mut Execution) -> Need {
        for _ in 0..500 {
            let need = execution.next_need();
            self.log.extend(execution.take_events());
            match need {
                Need::Perform(order) => {
                    let world = execution.world();
                    let action = world.domain().action(order.action);
                    let moment = Moment {
                        world,
                        state: &self.state,
                    };
                    let is_possible = holds(moment, &action.precondition, &mut order.arguments.clone());
                    if !is_possible && self.sees.is_none() {
                        execution.failed(order.number, "it is not possible").unwrap();
                        continue;
                    }
                    if !self.idle.contains(&order.number) {
                        apply(world, &mut self.state, action, &order.arguments);
                    }
                    self.history.push(self.state.clone());
                    execution.performed(order.number, None).unwrap();
                }
                Need::Observe => {
                    self.looks += 1;
                    execution.observed(&self.observation(execution)).unwrap();
                }
                Need::Approve(proposal) => execution.approve(&proposal.id).unwrap(),
                end => return end,
            }
        }
        panic!("no end")
    }
}

fn begin(world: &World, goal: &str, settings: Settings) -> Execution {
    let settings = settings.with_reports(reports(world));
    Execution::new(&testing::plan_for(world, goal), &Aim::Goal(goal.to_owned()), settings).unwrap()
}

fn trusting(approval: Approval, trust: Trust) -> Settings {
    Settings::default().with_approval(approval).with_trust(trust)
}

/// The domain of a robot that carries water, with numbers.
pub(super) fn tank() -> World {
    let text = r#"{"assets": ["<well>", "<north_tank>"], "asset_states": {
        "<well>": ["here()", "distance(<north_tank>, 40)"],
        "<north_tank>": ["level(0)", "capacity(20)", "distance(<well>, 40)"]},
        "facts": ["bucket(0)", "battery(80)"]}"#;
    testing::world("tank", text)
}

#[test]
fn a_plan_is_not_run_for_a_purpose_that_it_does_not_achieve() {
    let (kitchen, tank) = (kitchen(), tank());
    for (world, made_for, purpose, expected) in [
        (&kitchen, "put(cup, shelf)", "put(cup, shelf)", None),
        (&kitchen, "put(cup, shelf)", "put(pen, shelf)", Some("not reached")),
        (
            &kitchen,
            "put(cup, shelf)",
            "put(cup, shelf) & untouched(cup)",
            Some("untouched"),
        ),
        (
            &kitchen,
            "put(cup, shelf)",
            "put(cup, shelf) & never grasp_object()",
            Some("grasp_object()"),
        ),
        (
            &kitchen,
            "put(cup, shelf) & put(pen, shelf)",
            "put(pen, shelf) then put(cup, shelf)",
            Some("after"),
        ),
        (
            &kitchen,
            "put(pen, shelf) then put(cup, shelf)",
            "put(cup, shelf) then put(pen, shelf)",
            Some("after"),
        ),
        (&tank, "level(north tank) >= 5", "level(north tank) >= 5", None),
        (
            &tank,
            "level(north tank) >= 5",
            "level(north tank) >= 10",
            Some("not reached"),
        ),
        (
            &tank,
            "level(north tank) >= 5",
            "level(north tank) >= 5 & never Draw(_)",
            Some("Draw(_)"),
        ),
    ] {
        let plan = testing::plan_for(world, made_for);
        let aim = Aim::Goal(purpose.to_owned());
        let error = Execution::new(&plan, &aim, Settings::default())
            .err()
            .map(|error| error.to_string());
        match (&error, expected) {
            (None, None) => {}
            (Some(error), Some(expected)) => assert!(error.contains(expected), "{purpose}: {error}"),
            _ => panic!("{made_for} / {purpose}: {error:?}"),
        }
    }
}

/// Every order in turn has no effect, though the robot says so; the first stage has to happen in the real world.
#[test]
fn execution_counts_only_stages_that_really_happened() {
    let world = kitchen();
    let goal = "put(pen, shelf) then put(cup, shelf) then put(pen, table)";
    let there = fact(&world, "<pen> on_something(<shelf>)");
    let back = fact(&world, "<pen> on_something(<table>)");
    let mut reached = 0;
    for idle in 1..24 {
        for watch in [Watch::EachStep, Watch::OnFailure] {
            for trust in [Trust::Observed, Trust::Promised] {
                let mut execution = begin(&world, goal, trusting(Approval::Never, trust).with_watch(watch));
                let idle = [idle];
                let mut robot = Robot::new(&execution, &idle, None);
                let end = robot.run(&mut execution);
                assert!(matches!(end, Need::Done), "{idle:?} {watch:?} {trust:?}: {end:?}");
                reached += 1;
                let first = robot.history.iter().position(|state| state.holds(there));
                assert!(
                    first.is_some(),
                    "{idle:?} {watch:?} {trust:?}: the pen never was on the shelf"
                );
                assert!(robot.state.holds(back), "{idle:?} {watch:?} {trust:?}");
            }
        }
    }
    assert_eq!(reached, 92);
}

#[test]
fn execution_stops_if_the_goal_was_never_observed() {
    let world = kitchen();
    let goal = "put(cup, shelf)";
    let unseen = |end: &Need| match end {
        Need::Stopped(Stop::Unseen { unseen, .. }) => unseen.iter().map(Unseen::sentence).collect(),
        other => vec![format!("{other:?}")],
    };
    // The robot sees nothing at all, or not the cup; and the cup stays where it is.
    for (sees, idle) in [(&[][..], vec![]), (&["<pen>"][..], vec![]), (&[][..], (1..9).collect())] {
        let mut execution = begin(&world, goal, trusting(Approval::Never, Trust::Observed));
        let mut robot = Robot::new(&execution, &idle, Some(sees));
        let end = robot.run(&mut execution);
        assert_eq!(
            unseen(&end),
            [
                "promised by step 5, not seen since: the cup is on the shelf",
                "promised by step 6, not seen since: the hand does not hold the cup"
            ],
            "{sees:?}"
        );
        let mut trusting = begin(&world, goal, trusting(Approval::Never, Trust::Promised));
        let mut robot = Robot::new(&trusting, &idle, Some(sees));
        assert!(matches!(robot.run(&mut trusting), Need::Done));
        let Some(Event::Done { unseen, .. }) = robot.log.iter().chain(&trusting.take_events()).last().cloned() else {
            panic!("{:?}", robot.log.last())
        };
        assert_eq!(unseen.len(), 2);
        assert_eq!((unseen[0].basis, unseen[0].order), (Basis::Promised, Some(5)));
    }
    // What it sees counts.
    let mut execution = begin(&world, goal, trusting(Approval::Never, Trust::Observed));
    let mut robot = Robot::new(&execution, &[], Some(&["<cup>"]));
    assert!(matches!(robot.run(&mut execution), Need::Done));
}

#[test]
fn execution_asks_a_person_to_confirm_unobserved_goals() {
    let world = kitchen();
    for holds in [true, false] {
        let mut execution = begin(&world, "put(cup, shelf)", trusting(Approval::Changes, Trust::Observed));
        let mut robot = Robot::new(&execution, &[], Some(&["<pen>"]));
        let Need::Confirm(unseen) = robot.run(&mut execution) else {
            panic!("nothing was asked")
        };
        assert_eq!(
            (unseen.what.as_str(), unseen.order),
            ("the cup is on the shelf", Some(5))
        );
        execution.confirmed(holds).unwrap();
        assert!(execution.confirmed(holds).is_err(), "it was answered");
        let mut end = robot.run(&mut execution);
        if let Need::Confirm(unseen) = &end {
            assert_eq!(unseen.what, "the hand does not hold the cup");
            execution.confirmed(holds).unwrap();
            end = robot.run(&mut execution);
        }
        if holds {
            assert!(matches!(end, Need::Done), "{end:?}")
        } else {
            assert!(
                matches!(end, Need::Stopped(Stop::Unseen { denied: true, .. })),
                "{end:?}"
            )
        }
        let mut log = robot.log;
        log.extend(execution.take_events());
        let again = Execution::replay(&household(), &log).unwrap();
        assert_eq!(again.is_ended(), execution.is_ended());
    }
}

/// A robot that sees half of the world at a time is asked to look again.
#[test]
fn execution_observes_again_if_the_goal_is_partly_unseen() {
    let world = kitchen();
    let mut execution = begin(
        &world,
        "put(cup, shelf) & put(pen, shelf)",
        trusting(Approval::Never, Trust::Observed),
    );
    let halves = [["<cup>"], ["<pen>"]];
    let mut robot = Robot::new(&execution, &[], Some(&[]));
    let end = loop {
        let world = execution.world().clone();
        let half = halves[robot.looks % 2];
        robot.sees = Some(half.iter().map(|name| world.find(name).unwrap()).collect());
        match execution.next_need() {
            Need::Perform(order) => {
                let action = world.domain().action(order.action);
                apply(&world, &mut robot.state, action, &order.arguments);
                execution.performed(order.number, None).unwrap();
            }
            Need::Observe => {
                robot.looks += 1;
                execution.observed(&robot.observation(&execution)).unwrap();
            }
            end => break end,
        }
    };
    assert!(matches!(end, Need::Done), "{end:?}");
    let log = execution.take_events();
    let Some(Event::Done { unseen, .. }) = log.last() else {
        panic!()
    };
    assert_eq!(unseen, &[]);
    assert!(Execution::replay(&household(), &log).unwrap().is_ended());
}

#[test]
fn execution_of_a_plan_without_a_goal_checks_numbers() {
    let world = tank();
    let plan = testing::plan_for(&world, "level(north tank) >= 5");
    for idle in [&[][..], &[1], &[2], &[3]] {
        let settings = trusting(Approval::Never, Trust::Observed);
        let mut execution = Execution::new(&plan, &Aim::Endings, settings).unwrap();
        let mut robot = Robot::new(&execution, idle, None);
        let end = robot.run(&mut execution);
        let wanted = goal::parse(&world, "level(north tank) >= 5")
            .unwrap()
            .purpose(&world)
            .wanted;
        let moment = Moment {
            world: &world,
            state: &robot.state,
        };
        let reached = holds(moment, &wanted[0].condition, &mut wanted[0].bindings.clone());
        assert!(reached && matches!(end, Need::Done), "{idle:?}: {end:?}");
        assert!(
            idle.is_empty() || robot.log.iter().any(|event| matches!(event, Event::Assessed { .. })),
            "{idle:?}"
        );
    }
}

/// The robot dies in a step that changes numbers only: they say whether it was done.
#[test]
fn resume_infers_an_interrupted_order_from_numbers() {
    let world = tank();
    let goal = "level(north tank) >= 5";
    for was_done in [false, true] {
        let mut execution = Execution::new(
            &testing::plan_for(&world, goal),
            &Aim::Goal(goal.to_owned()),
            trusting(Approval::Never, Trust::Observed),
        )
        .unwrap();
        let mut robot = Robot::new(&execution, &[], None);
        let Need::Observe = execution.next_need() else { panic!() };
        execution.observed(&robot.observation(&execution)).unwrap();
        let Need::Perform(order) = execution.next_need() else {
            panic!()
        };
        assert_eq!(order.written(&world), "draw(<well>)");
        if was_done {
            apply(
                &world,
                &mut robot.state,
                world.domain().action(order.action),
                &order.arguments,
            );
        }
        let log = execution.take_events();
        let mut again = Execution::resume(world.domain(), &log, Resumed::default()).unwrap();
        let end = robot.run(&mut again);
        assert!(matches!(end, Need::Done), "{was_done}: {end:?}");
        let found = robot.log.iter().any(|event| matches!(event, Event::Found { order: 1 }));
        assert_eq!(found, was_done);
    }
}

#[test]
fn a_resumed_run_has_the_stricter_approval() {
    let world = kitchen();
    let begun = |approval| {
        let mut execution = begin(&world, "put(cup, shelf)", trusting(approval, Trust::Promised));
        let robot = Robot::new(&execution, &[], None);
        while let Need::Approve(proposal) = execution.next_need() {
            execution.approve(&proposal.id).unwrap();
        }
        execution.observed(&robot.observation(&execution)).unwrap();
        execution.take_events()
    };
    for (of_log, given, subjects) in [
        (Approval::Never, None, vec![]),
        (Approval::Never, Some(Approval::Never), vec![]),
        (Approval::Never, Some(Approval::Changes), vec!["plan"]),
        (Approval::Never, Some(Approval::EachStep), vec!["plan", "step"]),
        (Approval::Changes, Some(Approval::Never), vec![]),
        (Approval::Changes, Some(Approval::EachStep), vec!["step"]),
        (Approval::EachStep, Some(Approval::Never), vec!["step"]),
    ] {
        let resumed = Resumed {
            approval: given,
            trust: Some(Trust::Observed),
        };
        let mut log = begun(of_log);
        let mut again = Execution::resume(&household(), &log, resumed).unwrap();
        assert_eq!(again.settings().trust, Trust::Observed);
        let robot = Robot::new(&again, &[], None);
        let mut found = Vec::new();
        let order = loop {
            match again.next_need() {
                Need::Observe => again.observed(&robot.observation(&again)).unwrap(),
                Need::Approve(proposal) => {
                    found.push(match proposal.subject {
                        Subject::Plan => "plan",
                        Subject::Step(_) => "step",
                        Subject::Change(_) => "change",
                    });
                    again.approve(&proposal.id).unwrap();
                }
                Need::Perform(order) => break order,
                other => panic!("{other:?}"),
            }
        };
        assert_eq!(found, subjects, "{of_log:?} {given:?}");
        log.extend(again.take_events());
        let repeated = Execution::replay(&household(), &log).unwrap();
        assert_eq!(
            (repeated.running(), repeated.settings()),
            (&[order][..], again.settings())
        );
    }
}

/// The event of a step that had no effect did not happen.
#[test]
fn execution_discards_events_of_steps_without_effect() {
    let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<sponge>"],
        "object_states": {"<sponge>": "on_something(<shelf>)"}}"#;
    let world = testing::world("household", text);
    let goal = "wiped(table, sponge) & put(sponge, shelf)";
    for idle in 1..10 {
        let mut execution = begin(&world, goal, trusting(Approval::Never, Trust::Observed));
        let idle = [idle];
        let mut robot = Robot::new(&execution, &idle, None);
        let end = robot.run(&mut execution);
        assert!(matches!(end, Need::Done), "{idle:?}: {end:?}");
        let log: Vec<Event> = robot.log.iter().cloned().chain(execution.take_events()).collect();
        let word = log.iter().any(|event| match event {
            Event::Done { unseen, .. } => unseen.iter().any(|own| own.basis == Basis::Word),
            _ => false,
        });
        assert!(word, "nothing shows that the table was wiped: {:?}", log.last());
    }
}
