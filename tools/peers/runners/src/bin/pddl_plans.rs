//! Our side of `tools/peers/pddl_plans.py`: the plans of all shipped suites in PDDL, and verdicts on changed ones.
//!
//! `pddl_plans FOLDER EVERY` writes every EVERYth sequential plan with its domain and problem into a folder of its own, and one JSON
//! object to a line for each. A line `{"done": ...}` follows, with the number of plans that have no such form. Then each line of the
//! input, `NUMBER PLAN` with a tab between, gets a verdict on the plan in that file for the task of that number: in the world from
//! which the task was written, and in the one that is read back from its files.
#![allow(clippy::print_stdout)]

use std::collections::BTreeMap;
use std::error::Error;
use std::path::{Path, PathBuf};

use longstep_core::domain;
use longstep_core::environment::{self, World};
use longstep_core::goal;
use longstep_core::model::{State, changed_facts};
use longstep_core::pddl::{self, SolvedTask};
use longstep_core::plan::{Plan, Step};
use longstep_core::search::{GroundAction, Limits, Outcome, solve};
use longstep_core::verify::{Purpose, Report, VerifiedPlan, check};
use longstep_eval::suite;
use serde_json::{Value, json};

type Anyhow<T> = Result<T, Box<dyn Error>>;

/// Every so many plans are written without their goal, so that the problem has what the plan changes.
const WITHOUT_GOAL: usize = 4;

/// A plan, and the task that it solves.
struct Solved {
    plan: VerifiedPlan,
    purpose: Purpose,
    /// False if the task has what the plan changes as its goal.
    has_goal: bool,
    folder: PathBuf,
}

fn main() -> Anyhow<()> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let [folder, every] = &arguments[..] else {
        return Err("usage: pddl_plans FOLDER EVERY".into());
    };
    let tasks = write_all(Path::new(folder), every.parse::<usize>()?.max(1))?;
    for line in std::io::stdin().lines() {
        let line = line?;
        let (number, file) = line.split_once('\t').ok_or("not a number and a file")?;
        let task = tasks.get(number.parse::<usize>()?).ok_or("no such task")?;
        println!("{}", verdict(task, &std::fs::read_to_string(file)?)?);
    }
    Ok(())
}

/// The tasks that were written, and the numbers of plans that were not.
#[derive(Default)]
struct Written {
    tasks: Vec<Solved>,
    plans: usize,
    branching: usize,
    unwritable: BTreeMap<String, usize>,
}

fn write_all(folder: &Path, every: usize) -> Anyhow<Vec<Solved>> {
    let mut written = Written::default();
    for name in suite::shipped_names() {
        let (_, suite) = suite::load_shipped(name).ok_or("no such suite")??;
        let plans = suite.plans().map_err(|report| format!("{:?}", report.violations))?;
        for (plan, purpose) in plans {
            written.plans += 1;
            if !plan.plan().is_sequence() {
                written.branching += 1;
            } else if (written.plans - 1).is_multiple_of(every) {
                written.write(folder, name, plan, purpose)?;
            }
        }
    }
    let (plan, purpose) = plan_with_odd_names()?;
    written.write(folder, "odd-names", plan, purpose)?;
    let (plan, purpose) = plan_with_numbers()?;
    written.write(folder, "numbers", plan, purpose)?;
    let Written {
        tasks,
        plans,
        branching,
        unwritable,
    } = written;
    println!(
        "{}",
        json!({"done": tasks.len(), "plans": plans, "branching": branching, "unwritable": unwritable})
    );
    Ok(tasks)
}

impl Written {
    fn write(&mut self, folder: &Path, suite: &str, plan: VerifiedPlan, purpose: Purpose) -> Anyhow<()> {
        let number = self.tasks.len();
        let has_goal = number % WITHOUT_GOAL != WITHOUT_GOAL - 1;
        let folder = folder.join(format!("{number:04}"));
        let none = Purpose::default();
        let goal = if has_goal { &purpose } else { &none };
        match SolvedTask::write(&plan, goal, &format!("{suite}-{number}")) {
            Ok(task) => {
                std::fs::create_dir_all(&folder)?;
                for (name, text) in task.files() {
                    std::fs::write(folder.join(name), text)?;
                }
                let domain = &plan.world().domain().name;
                println!("{}", json!({"number": number, "domain": domain, "folder": folder}));
                self.tasks.push(Solved {
                    plan,
                    purpose,
                    has_goal,
                    folder,
                });
            }
            Err(error) => *self.unwritable.entry(error.to_string()).or_default() += 1,
        }
        Ok(())
    }
}

/// Returns a plan over entities whose names are keywords, names of predicates, not ASCII, very long, or differ in case only.
fn plan_with_odd_names() -> Anyhow<(VerifiedPlan, Purpose)> {
    let domain = longstep::domain::shipped("household").ok_or("no such domain")??;
    let long = format!("<{}>", "n".repeat(198));
    let text = json!({
        "assets": ["<bin>", "<and>", "<table>", "<Table>", long],
        "objects": ["<o'brien [x]>", "<杯子>", "<number>", "<7>", "<define>"],
        "object_states": {
            "<o'brien [x]>": "on_something(<and>)", "<杯子>": "on_something(<bin>)", "<number>": format!("on_something({long})"),
            "<7>": "on_something(<Table>)", "<define>": "on_something(<table>)",
        },
    });
    let world = environment::parse(&domain, "odd-names.json", &text.to_string())?;
    let places = ["<bin>", "<Table>", "<table>", "<and>", long.as_str()];
    let objects = ["<o'brien [x]>", "<杯子>", "<number>", "<7>", "<define>"];
    let facts = objects
        .iter()
        .zip(places)
        .map(|(object, place)| format!("put({object}, {place})"));
    let purpose = goal::parse(&world, &facts.collect::<Vec<_>>().join(" & "))?.purpose(&world);
    Ok((solved(&world, &purpose)?, purpose))
}

/// A domain with what no shipped one has: numbers, costs, a derived predicate, and an argument of a supertype.
const YARD: &str = "(define (domain yard) (:requirements :adl :fluents :derived-predicates)
  (:types crate truck - thing place) (:constants hub - place)
  (:predicates (at ?x - thing ?p - place) (full ?t - truck) (sealed ?c - crate) (loaded ?x - thing))
  (:functions (fuel ?t - truck) (total-cost))
  (:derived (ready ?t - truck) (and (not (full ?t)) (>= (fuel ?t) 1)))
  (:action drive :parameters (?t - truck ?from ?to - place)
    :precondition (and (at ?t ?from) (ready ?t) (not (= ?from ?to)))
    :effect (and (at ?t ?to) (not (at ?t ?from)) (decrease (fuel ?t) 0.5) (increase (total-cost) 3)
      (forall (?c - crate) (when (loaded ?c) (and (at ?c ?to) (not (at ?c ?from)))))))
  (:action fill :parameters (?t - truck)
    :precondition (and (at ?t hub) (< (fuel ?t) 1)) :effect (and (assign (fuel ?t) 2) (increase (total-cost) 1)))
  (:action load :parameters (?c - crate ?t - truck ?p - place)
    :precondition (and (at ?c ?p) (at ?t ?p)) :effect (and (loaded ?c) (increase (total-cost) 1)))
  (:action seal :parameters (?x - thing)
    :precondition (and (imply (full ?x) (at ?x hub)) (exists (?p - place) (at ?x ?p)))
    :effect (and (sealed ?x) (increase (total-cost) 1))))";

const DAY: &str = "(define (problem day) (:domain yard) (:objects lorry - truck box chest - crate bay dock - place)
  (:init (at lorry hub) (at box hub) (at chest bay) (= (fuel lorry) 0.5))
  (:goal (and (at box dock) (at chest dock) (sealed box))))";

fn plan_with_numbers() -> Anyhow<(VerifiedPlan, Purpose)> {
    let domain = domain::from_pddl("yard.pddl", YARD)?;
    let problem = pddl::read_problem(&domain, "day.pddl", DAY)?;
    let purpose = Purpose::from(&problem);
    Ok((solved(&problem.world, &purpose)?, purpose))
}

fn solved(world: &World, purpose: &Purpose) -> Anyhow<VerifiedPlan> {
    let Outcome::Solved { plan, .. } = solve(world, purpose, &Limits::default()) else {
        return Err("this task has no plan".into());
    };
    let plan = check(world, plan, purpose).into_verified();
    Ok(plan.map_err(|report| format!("{:?}", report.violations))?)
}

/// Returns whether a plan is executable and reaches the goal, in the world of the task and in the one of its files.
fn verdict(task: &Solved, text: &str) -> Anyhow<Value> {
    let none = Purpose::default();
    let purpose = if task.has_goal { &task.purpose } else { &none };
    let own = match simulated(task.plan.world(), text, purpose) {
        Ok(report) => {
            let misses_changes = !task.has_goal && misses(task, &report.ending().after);
            let mut reasons = messages(&report);
            reasons.extend(misses_changes.then(|| "the plan misses what the first one changed".to_owned()));
            reasons
        }
        Err(reason) => vec![reason],
    };
    let read = |name: &str| std::fs::read_to_string(task.folder.join(name));
    let domain = domain::from_pddl("domain.pddl", &read("domain.pddl")?)?;
    let problem = pddl::read_problem(&domain, "problem.pddl", &read("problem.pddl")?)?;
    let back = match simulated(&problem.world, text, &Purpose::from(&problem)) {
        Ok(report) => messages(&report),
        Err(reason) => vec![reason],
    };
    Ok(json!({"valid": own.is_empty(), "valid_read_back": back.is_empty(), "reasons": own, "reasons_read_back": back}))
}

fn simulated(world: &World, text: &str, purpose: &Purpose) -> Result<Report, String> {
    let steps = pddl::read_plan(world, "plan.pddl", text)
        .map_err(|findings| findings.to_string())?
        .steps;
    let step = |own: GroundAction| Step::explained(world, own.action, own.arguments);
    Ok(check(world, steps.into_iter().map(step).collect::<Plan>(), purpose))
}

fn messages(report: &Report) -> Vec<String> {
    let violations = report.violations.iter();
    violations
        .map(|own| own.message(&report.world, report.plan.steps(), None))
        .collect()
}

/// Returns true if a final state lacks a change of the task's own plan.
fn misses(task: &Solved, after: &State) -> bool {
    let ending = &task.plan.ending().after;
    let start = &task.plan.world().state;
    let facts = changed_facts(start, ending);
    facts.iter().any(|change| after.holds(change.fact) != change.now_holds)
        || ending
            .numbers()
            .iter()
            .any(|(own, number)| start.number(*own) != Some(*number) && after.number(*own) != Some(*number))
}
