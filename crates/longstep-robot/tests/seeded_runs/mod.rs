//! Seeded runs in the simulator over the scenes and goals of the shipped suites.

#[path = "../support/agreeing.rs"]
mod agreeing;

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use longstep_core::environment::{Moment, State, Words, World, holds};
use longstep_core::execution::{Aim, Approval, Effect, Event, Execution, Need, Settings, StepOrder as Wanted, Stop};
use longstep_core::json::Path as JsonPath;
use longstep_core::search::{Limits, Outcome, solve};
use longstep_core::skill::Skills;
use longstep_core::testing::Draws;
use longstep_core::verify::{Purpose, VerifiedPlan, check};
use longstep_core::{domain, environment, goal, schedule};
use longstep_robot::{Progress, Robot, RunControl, Scope, Sim, SimCounts, SimOptions, drive, order_of, reports};

use agreeing::Agreeing;

/// A goal of a suite in its scene, with a plan.
pub struct Case {
    pub name: String,
    pub goal: String,
    pub world: World,
    pub purpose: Purpose,
    pub plan: VerifiedPlan,
}

/// Reads the goals of the suites with these names that have a plan in the initial world of their scene.
pub fn cases(suites: &[&str]) -> Vec<Case> {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../longstep-eval/suites");
    suites
        .iter()
        .flat_map(|suite| of_suite(&root.join(suite), suite))
        .collect()
}

fn toml_at(path: &Path) -> toml::Table {
    fs::read_to_string(path).unwrap().parse().unwrap()
}

fn of_suite(folder: &Path, suite: &str) -> Vec<Case> {
    let settings = toml_at(&folder.join("suite.toml"));
    let domain = domain::shipped(settings["domain"].as_str().unwrap()).unwrap().unwrap();
    let mut files: Vec<PathBuf> = fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .collect();
    files.retain(|path| path.extension().is_some_and(|own| own == "toml") && !path.ends_with("suite.toml"));
    files.sort();
    let mut cases = Vec::new();
    for file in files {
        let table = toml_at(&file);
        for case in table.get("case").and_then(toml::Value::as_array).into_iter().flatten() {
            let (Some(id), Some(scene)) = (case["id"].as_str(), case["scene"].as_str()) else {
                continue;
            };
            let path = folder.join("scenes").join(format!("{scene}.json"));
            let text = fs::read_to_string(path).unwrap();
            let world = environment::parse(&domain, scene, &text).unwrap();
            let steps = case.get("steps").and_then(toml::Value::as_array);
            let goals = [case.clone()].into_iter().chain(steps.into_iter().flatten().cloned());
            let goals = goals.filter_map(|own| Some(own.get("goal")?.as_str()?.to_owned()));
            for (index, goal) in goals.enumerate() {
                cases.extend(solved(&world, &format!("{suite}/{id}/{}", index + 1), &goal));
            }
        }
    }
    cases
}

/// Returns the case if its goal has a plan with at least one step.
pub fn solved(world: &World, name: &str, text: &str) -> Option<Case> {
    let mut world = world.clone();
    world.add_values(text);
    let purpose = goal::parse(&world, text).ok()?.purpose(&world);
    let Outcome::Solved { plan, .. } = solve(&world, &purpose, &Limits::default()) else {
        return None;
    };
    let plan = check(&world, plan, &purpose).into_verified().ok()?;
    (!plan.steps().is_empty()).then(|| Case {
        name: name.to_owned(),
        goal: text.to_owned(),
        world,
        purpose,
        plan,
    })
}

/// The events of a run, with the steps that were ordered although nobody had approved them.
#[derive(Default)]
pub struct Approving {
    open: bool,
    pub unapproved: u32,
    pub changes: u32,
    pub skipped: u32,
    pub events: Vec<Event>,
}

impl Approving {
    fn record(&mut self, events: &[Event]) {
        for event in events {
            match event {
                Event::Began { .. } => self.open = true,
                Event::Changed { .. } => {
                    self.open = true;
                    self.changes += 1;
                }
                Event::Approved { .. } => self.open = false,
                Event::Ordered { .. } => self.unapproved += u32::from(self.open),
                Event::Assessed { effect, .. } => self.skipped += u32::from(*effect == Effect::Helpful),
                _ => {}
            }
        }
        self.events.extend_from_slice(events);
    }
}

/// The end of a run.
pub struct Run {
    pub stop: Option<Stop>,
    /// True if the goal holds in the simulated world.
    pub reached: bool,
    pub counts: SimCounts,
    pub watcher: Approving,
}

/// Runs a case with this number of mishaps.
pub fn monitored(case: &Case, seed: u64, faults: u32) -> Run {
    let mut sim = sim(case, seed, faults, "");
    let settings = Settings::default()
        .with_approval(Approval::Changes)
        .with_reports(reports(&sim, &case.world).unwrap());
    let mut execution = Execution::new(&case.plan, &Aim::Goal(case.goal.clone()), settings).unwrap();
    let mut watcher = Approving::default();
    let control = RunControl::of(&sim);
    let mut agreeing = Agreeing(|_: &Execution, events: &[Event]| watcher.record(events));
    let stop = drive(&mut execution, &mut sim, &mut agreeing, &control).into_stop();
    Run {
        stop,
        reached: is_reached(case, sim.state()),
        counts: sim.counts(),
        watcher,
    }
}

/// Runs a case step by step without looking: each step of the plan is ordered once, until one fails.
pub fn plain(case: &Case, seed: u64, faults: u32) -> bool {
    let mut sim = sim(case, seed, faults, "");
    let (mut cursor, mut seen) = (case.plan.cursor(), None);
    let mut number = 0;
    while let Ok(Some(step)) = cursor.next(seen) {
        number += 1;
        let mut wanted = Wanted::of_step(&case.plan, step, &Skills::default());
        wanted.number = number;
        let handle = sim.start(&order_of(&case.world, &wanted)).unwrap();
        let end = loop {
            match sim.poll(handle).unwrap() {
                Progress::Running(_) => {}
                end => break end,
            }
        };
        match end {
            Progress::Done { outcome } => seen = outcome.map(|index| wanted.outcomes[index]),
            _ => return false,
        }
    }
    is_reached(case, sim.state())
}

fn sim(case: &Case, seed: u64, faults: u32, more: &str) -> Sim {
    let horizon = case.plan.steps().len();
    let options: SimOptions = format!("seed={seed},faults={faults},horizon={horizon}{more}")
        .parse()
        .unwrap();
    Sim::new(case.world.clone(), &options).unwrap()
}

/// Returns true if the goal and the rules hold in a state of the case's world.
pub fn is_reached(case: &Case, state: &State) -> bool {
    let world = case.world.continued(state.clone());
    let moment = Moment { world: &world, state };
    let wanted = case.purpose.at_end(world.domain());
    wanted
        .iter()
        .all(|own| holds(moment, &own.condition, &mut own.bindings.clone()))
}

/// Returns different plans with lanes: drawn scenes of the suite `two-arms` in which objects have exchanged their places,
/// and two to four drawn goals of the scene at once. At most this many.
pub fn lanes(count: usize) -> Vec<Case> {
    let single = cases(&["two-arms"]);
    let mut draws = Draws::new(0);
    let (mut found, mut known) = (Vec::new(), BTreeSet::new());
    for _ in 0..40 * count {
        if found.len() == count {
            break;
        }
        let first = &single[draws.below(single.len())];
        let scene = first.world.environment();
        let here: Vec<&Case> = single.iter().filter(|own| own.world.environment() == scene).collect();
        let mut goals = BTreeSet::new();
        for _ in 0..2 + draws.below(3) {
            goals.insert(here[draws.below(here.len())].goal.as_str());
        }
        let world = with_places_exchanged(&first.world, &mut draws);
        let text = goals.iter().copied().collect::<Vec<_>>().join(" & ");
        let Some(mut case) = solved(&world, &first.name, &text) else {
            continue;
        };
        let Some(shared) = schedule::share(&case.world, &case.plan, &case.purpose) else {
            continue;
        };
        // The same plan for other words is no other plan.
        if known.insert(format!("{:?} {:?}", world.environment(), shared.plan.plan())) {
            case.plan = shared.plan;
            found.push(case);
        }
    }
    found
}

/// Returns the world in which the objects that only lie somewhere have exchanged their places.
fn with_places_exchanged(world: &World, draws: &mut Draws) -> World {
    let mut scene = world.environment().clone();
    let lying: Vec<String> = scene
        .object_states
        .iter()
        .filter(|(_, words)| matches!(words.as_slice(), [word] if word.contains("_something(")))
        .map(|(object, _)| object.clone())
        .collect();
    for end in (1..lying.len()).rev() {
        let other = draws.below(end + 1);
        let [own, another] = [&lying[end], &lying[other]].map(|object| scene.object_states[object].clone());
        scene.object_states.insert(lying[end].clone(), another);
        scene.object_states.insert(lying[other].clone(), own);
    }
    let read = environment::read(world.domain(), &scene, "exchanged", "", &JsonPath::default());
    read.unwrap_or_else(|_| world.clone())
}

/// Returns the cases of the largest kitchen of the suites, with so many jars that it has this number of entities.
pub fn kitchen_of(count: usize) -> Vec<Case> {
    let all = cases(&["kitchen"]);
    let size = |case: &Case| case.world.entities().count();
    let Some(largest) = all.iter().map(size).max() else {
        return all;
    };
    let mut found = Vec::new();
    for case in all.iter().filter(|case| size(case) == largest) {
        let mut kitchen = case.world.environment().clone();
        // A jar stands beside an object that only stands somewhere.
        let stands = |words: &&Words| matches!(words.as_slice(), [word] if word.starts_with("ON("));
        let Some(place) = kitchen.object_states.values().find(stands).cloned() else {
            continue;
        };
        for number in 1..=count.saturating_sub(largest) {
            let jar = format!("<jar_{number}>");
            kitchen.object_states.insert(jar.clone(), place.clone());
            kitchen.objects.push(jar);
        }
        let domain = case.world.domain();
        let world = environment::read(domain, &kitchen, &case.name, "", &JsonPath::default()).unwrap();
        found.extend(solved(&world, &case.name, &case.goal));
    }
    found
}

/// The end of a run of lanes.
pub struct LaneRun {
    pub as_promised: bool,
    pub counts: SimCounts,
    /// The largest number of orders under way at the same time.
    pub together: usize,
    pub stop: Option<Stop>,
}

/// Runs a plan with lanes, with steps of random lengths.
pub fn in_lanes(case: &Case, seed: u64, faults: u32) -> LaneRun {
    let mut sim = sim(case, seed, faults, ",ticks=20");
    let settings = Settings::default().with_reports(reports(&sim, &case.world).unwrap());
    let mut execution = Execution::new(&case.plan, &Aim::Goal(case.goal.clone()), settings).unwrap();
    let (mut together, control) = (0, RunControl::of(&sim));
    let mut watcher = Agreeing(|execution: &Execution, _: &[Event]| together = together.max(execution.running().len()));
    let stop = drive(&mut execution, &mut sim, &mut watcher, &control).into_stop();
    LaneRun {
        as_promised: case.plan.endings().iter().any(|ending| ending.after == *sim.state()),
        counts: sim.counts(),
        together,
        stop,
    }
}

/// Returns the time that the execution itself takes for each step of a run without mishaps.
pub fn costs(case: &Case) -> Vec<Duration> {
    let mut sim = sim(case, 0, 0, "");
    let settings = Settings::default()
        .with_approval(Approval::Never)
        .with_reports(reports(&sim, &case.world).unwrap());
    let mut execution = Execution::new(&case.plan, &Aim::Goal(case.goal.clone()), settings).unwrap();
    let (mut costs, mut spent) = (Vec::new(), Duration::ZERO);
    loop {
        let begun = Instant::now();
        let need = execution.next_need();
        let events = execution.take_events();
        spent += begun.elapsed();
        drop(events);
        match need {
            Need::Perform(order) | Need::Sense(order) => {
                let handle = sim.start(&order_of(&case.world, &order)).unwrap();
                let outcome = loop {
                    match sim.poll(handle).unwrap() {
                        Progress::Running(_) => {}
                        Progress::Done { outcome } => break outcome.map(|index| order.outcomes[index]),
                        Progress::Failed { reason } => panic!("{reason}"),
                    }
                };
                costs.push(spent);
                let begun = Instant::now();
                execution.performed(order.number, outcome).unwrap();
                spent = begun.elapsed();
            }
            Need::Observe => {
                let seen = sim.observe(&Scope::All).unwrap();
                let begun = Instant::now();
                execution.observed(&seen).unwrap();
                spent += begun.elapsed();
            }
            Need::Done => return costs,
            other => panic!("{other:?}"),
        }
    }
}
