//! Runs that are paused from another thread, and robots that others use meanwhile.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::time::Duration;

use longstep_core::environment::World;
use longstep_core::execution::{Aim, Approval, Event, Execution, Proposal, Settings, StepOrder, Stop, Unseen};
use longstep_core::testing::{plan_for, world};
use longstep_robot::{Driven, RunControl, Sim, Watcher, drive, reports};

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "on_something(<desk>)"}}"#;

fn scene() -> World {
    world("household", SCENE)
}

fn begun(world: &World, text: &str, sim: &Sim, approval: Approval) -> Execution {
    let settings = Settings::default()
        .with_approval(approval)
        .with_reports(reports(sim, world).unwrap());
    Execution::new(&plan_for(world, text), &Aim::Goal(text.to_owned()), settings).unwrap()
}

/// A person at a page, who approves everything and asks for one pause.
struct Page {
    events: Vec<Event>,
    control: RunControl,
    /// The order during which the page asks for a pause; zero for the first question.
    pauses_at: Option<u64>,
    questions: u32,
}

impl Page {
    fn new(control: &RunControl, pauses_at: impl Into<Option<u64>>) -> Self {
        Self {
            events: Vec::new(),
            control: control.clone(),
            pauses_at: pauses_at.into(),
            questions: 0,
        }
    }
}

impl Watcher for Page {
    fn record(&mut self, _: &Execution, events: &[Event]) -> Result<(), String> {
        self.events.extend_from_slice(events);
        let ordered = |event: &Event| matches!(event, Event::Ordered { order, .. } if Some(*order) == self.pauses_at);
        if events.iter().any(ordered) {
            self.pauses_at = None;
            self.control.pause();
        }
        Ok(())
    }

    fn approve(&mut self, _: &Execution, _: &Proposal) -> Option<bool> {
        self.questions += 1;
        if self.pauses_at == Some(0) {
            self.pauses_at = None;
            self.control.pause();
            return None;
        }
        Some(true)
    }

    fn judge(&mut self, _: &Execution, _: &StepOrder) -> Option<bool> {
        None
    }

    fn confirm(&mut self, _: &Execution, _: &Unseen) -> Option<bool> {
        None
    }
}

/// The robot is carrying the pen when an urgent run needs it.
#[test]
fn urgent_run_uses_the_robot_of_a_paused_run() {
    let world = scene();
    for at in 1..=6 {
        let mut sim = Sim::new(world.clone(), &"seed=1,ticks=3,pace=1".parse().unwrap()).unwrap();
        let mut execution = begun(&world, "put(pen, shelf)", &sim, Approval::Never);
        let control = RunControl::of(&sim);
        let mut page = Page::new(&control, at);
        assert_eq!(drive(&mut execution, &mut sim, &mut page, &control), Driven::Paused);
        // The order under way has ended, and its effects were observed.
        let [.., Event::Paused, Event::Observed { .. }] = &page.events[..] else {
            panic!("{at}: {:?}", page.events)
        };
        assert!(execution.running().is_empty());
        // A paused run stays paused while the request stands.
        assert_eq!(drive(&mut execution, &mut sim, &mut page, &control), Driven::Paused);

        let here = execution.after();
        let mut urgent = begun(&here, "put(cup, shelf)", &sim, Approval::Never);
        let other = RunControl::of(&sim);
        let driven = drive(&mut urgent, &mut sim, &mut Page::new(&other, None), &other);
        assert_eq!(driven, Driven::Done, "{at}");

        control.resume();
        assert_eq!(
            drive(&mut execution, &mut sim, &mut page, &control),
            Driven::Done,
            "{at}"
        );
        let states = execution.after().environment().object_states.clone();
        assert_eq!(states["<pen>"].as_slice(), ["on_something(<shelf>)"]);
        assert_eq!(states["<cup>"].as_slice(), ["on_something(<shelf>)"]);
    }
}

#[test]
fn unanswered_question_is_asked_again_after_a_pause() {
    let world = scene();
    let mut sim = Sim::new(world.clone(), &"".parse().unwrap()).unwrap();
    let mut execution = begun(&world, "put(pen, shelf)", &sim, Approval::Changes);
    let control = RunControl::of(&sim);
    let mut page = Page::new(&control, 0);
    assert_eq!(drive(&mut execution, &mut sim, &mut page, &control), Driven::Paused);
    control.resume();
    assert_eq!(drive(&mut execution, &mut sim, &mut page, &control), Driven::Done);
    assert_eq!(page.questions, 2);
}

#[test]
fn stop_beats_a_pause() {
    let world = scene();
    for is_paused in [false, true] {
        let mut sim = Sim::new(world.clone(), &"ticks=3,pace=1".parse().unwrap()).unwrap();
        let mut execution = begun(&world, "put(pen, shelf)", &sim, Approval::Never);
        let control = RunControl::of(&sim);
        let mut page = Page::new(&control, 2);
        if is_paused {
            assert_eq!(drive(&mut execution, &mut sim, &mut page, &control), Driven::Paused);
        } else {
            control.pause();
        }
        control.stop();
        let driven = drive(&mut execution, &mut sim, &mut page, &control);
        assert!(matches!(driven, Driven::Stopped(Stop::Requested(_))), "{driven:?}");
    }
}

/// The request comes from another thread, at any moment.
#[test]
fn run_that_is_paused_again_and_again_reaches_its_goal() {
    let world = scene();
    let mut sim = Sim::new(world.clone(), &"seed=3,ticks=4,pace=2".parse().unwrap()).unwrap();
    let mut execution = begun(&world, "put(pen, shelf) & put(cup, shelf)", &sim, Approval::Never);
    let control = RunControl::of(&sim);
    let mut page = Page::new(&control, None);
    let remote = control.clone();
    std::thread::scope(|scope| {
        scope.spawn(move || {
            for _ in 0..5 {
                std::thread::sleep(Duration::from_millis(7));
                remote.pause();
            }
        });
        loop {
            match drive(&mut execution, &mut sim, &mut page, &control) {
                Driven::Paused => control.resume(),
                Driven::Done => break,
                Driven::Stopped(stop) => panic!("{stop:?}"),
            }
        }
    });
    assert!(matches!(page.events.last(), Some(Event::Done { .. })));
}
