//! The writer of ground PDDL tasks, for goals with an order and for rules that hold in every state.
//!
//! A PDDL problem constrains only the last state. A ground task has an action for every step and for every record of
//! progress, so that a planner without such constraints finds the plans that keep them.

use std::fmt::Write;

use rustc_hash::FxHashSet;

use super::names::plain;
use super::object_names;
use super::write::{WriteError, affordable};
use crate::search::{Formula, GroundAction, GroundEffect, Literal, Operator, Task, ground_task};
use longstep_model::model::{EntityId, Fact, World};
use longstep_verify::verify::Purpose;

/// A planning task without variables: a domain, its only problem, and the step for each of its actions.
#[derive(Debug, Clone, PartialEq, Eq)]
#[non_exhaustive]
pub struct GroundTask {
    /// The PDDL domain.
    pub domain: String,
    /// The PDDL problem.
    pub problem: String,
    /// The actions that are steps, with their names. All others record progress and cost nothing.
    pub steps: Vec<(String, GroundAction)>,
}

impl GroundTask {
    /// Writes a task with the order of the purpose and with all rules and prohibitions.
    ///
    /// Each action is one step, named after the action and its arguments; it costs 1. Actions named `progress-1`,
    /// `progress-2` and so on record that a stage is complete or that a rule is in force. Every step requires that
    /// nothing is left to record, so a stage is complete in the first state that completes it. The task needs
    /// `:conditional-effects`, `:derived-predicates` and `:action-costs`.
    ///
    /// ```
    /// use longstep_model::{domain, environment};
    /// use longstep_search::{goal, pddl};
    /// let household = domain::shipped("household").unwrap().unwrap();
    /// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
    /// let world = environment::parse(&household, "env.json", text).unwrap();
    /// let goal = goal::parse(&world, "put(cup, shelf) then put(cup, table)").unwrap();
    /// let task = pddl::GroundTask::write(&world, &goal.purpose(&world), "there-and-back").unwrap();
    /// assert!(task.domain.contains("(:action progress-1") && task.steps.len() > 5);
    /// ```
    ///
    /// # Errors
    ///
    /// [`WriteError::Sensing`] if a goal depends on sensing; [`WriteError::TooLarge`] if the task has too many actions.
    pub fn write(world: &World, purpose: &Purpose, name: &str) -> Result<Self, WriteError> {
        let domain = world.domain();
        let goals = purpose.at_end(domain);
        let stages = purpose.stages.iter().flatten().map(|milestone| &milestone.wanted);
        let mut atoms = goals.iter().chain(stages).flat_map(|wanted| wanted.condition.atoms());
        if atoms.any(|(atom, _)| domain.is_sensed(atom.predicate)) {
            return Err(WriteError::Sensing);
        }
        affordable(|| {
            let world = &*purpose.world(world);
            let (task, facts) = ground_task(world, purpose);
            Writer::new(world, &task, &facts).task(name)
        })
    }

    /// Returns the steps of a plan for the task, which has one action in parentheses on each line. Records of progress
    /// and comments are skipped; none if a line is no action of the task.
    pub fn read_plan(&self, text: &str) -> Option<Vec<GroundAction>> {
        let lines = text.lines().map(str::trim);
        let lines = lines.filter(|line| !line.is_empty() && !line.starts_with(';'));
        let names = lines.map(|line| line.trim_matches(['(', ')']).trim().to_lowercase());
        let steps = names.filter(|name| !name.starts_with(PROGRESS));
        let step = |name: String| {
            let mut known = self.steps.iter();
            known.find(|(own, _)| *own == name).map(|(_, step)| step.clone())
        };
        steps.map(step).collect()
    }
}

/// The beginning of the names of actions that record progress.
const PROGRESS: &str = "progress-";

struct Writer<'a> {
    world: &'a World,
    task: &'a Task,
    /// The name of each fact of the task, in order.
    facts: Vec<String>,
    objects: Vec<String>,
    taken: FxHashSet<String>,
}

/// An action in PDDL.
struct WrittenAction {
    name: String,
    precondition: String,
    effects: String,
}

impl<'a> Writer<'a> {
    fn new(world: &'a World, task: &'a Task, facts: &[Option<Fact>]) -> Self {
        let mut writer = Self {
            world,
            task,
            facts: Vec::with_capacity(facts.len()),
            objects: object_names(world),
            taken: FxHashSet::default(),
        };
        for fact in facts {
            let name = match fact {
                Some(fact) => {
                    let domain = world.domain();
                    let predicate = &domain.predicate(fact.predicate()).name;
                    writer.unique(predicate, domain.arguments(*fact))
                }
                None => writer.unique("recorded", std::iter::empty()),
            };
            writer.facts.push(name);
        }
        writer
    }

    /// Returns a name that no other fact or action has.
    fn unique(&mut self, word: &str, arguments: impl Iterator<Item = EntityId>) -> String {
        let mut name = word.to_owned();
        for argument in arguments {
            name.push_str("__");
            name.push_str(&self.objects[argument.index()]);
        }
        let mut free = name.clone();
        let mut number = 2;
        while !self.taken.insert(free.clone()) {
            free = format!("{name}-{number}");
            number += 1;
        }
        free
    }

    fn task(mut self, name: &str) -> GroundTask {
        let task = self.task;
        let none = std::iter::empty;
        let (due, violated) = (self.unique("due", none()), self.unique("violated", none()));
        let mut names = vec![due.clone(), violated.clone()];
        let mut derived: Vec<(String, String)> = Vec::new();
        let mut records: Vec<WrittenAction> = Vec::new();
        for mark in task.marks() {
            let precondition = self.formula(&mark.precondition, true);
            derived.push((due.clone(), precondition.clone()));
            records.push(WrittenAction {
                name: format!("{PROGRESS}{}", records.len() + 1),
                precondition,
                effects: self.effects(mark),
            });
        }
        // A rule binds from the first state that keeps it. Planners expand a condition into its alternatives, of which
        // the negation of a rule has few and the rule itself may have very many: hence a predicate for the negation.
        for rule in task.always.iter() {
            let (broken, in_force) = (self.unique("broken", none()), self.unique("in-force", none()));
            derived.push((broken.clone(), self.formula(rule, false)));
            derived.push((violated.clone(), format!("(and ({in_force}) ({broken}))")));
            let begins = format!("(and (not ({in_force})) (not ({broken})))");
            derived.push((due.clone(), begins.clone()));
            records.push(WrittenAction {
                name: format!("{PROGRESS}{}", records.len() + 1),
                precondition: begins,
                effects: format!("({in_force})"),
            });
            names.extend([broken, in_force]);
        }
        let mut steps = Vec::new();
        let mut actions = Vec::new();
        for (_, operator) in task.steps() {
            let action = self.world.domain().action(operator.step.action);
            let name = self.unique(&action.name, operator.step.arguments.iter().copied());
            let own = self.formula(&operator.precondition, true);
            actions.push(WrittenAction {
                name: name.clone(),
                precondition: format!("(and (not ({due})) (not ({violated})) {own})"),
                effects: format!("{} (increase (total-cost) 1)", self.effects(operator)),
            });
            steps.push((name, operator.step.clone()));
        }
        actions.extend(records);
        let predicates = self.facts.iter().chain(&names);
        let mut domain = format!(
            "(define (domain {name})\n  (:requirements :strips :negative-preconditions :disjunctive-preconditions \
             :conditional-effects :derived-predicates :action-costs)\n  (:predicates",
            name = plain(name)
        );
        for predicate in predicates {
            // Writing to a `String` cannot fail.
            let _ = write!(domain, "\n    ({predicate})");
        }
        domain.push_str("\n  )\n  (:functions (total-cost) - number)\n");
        for (name, condition) in &derived {
            let _ = writeln!(domain, "  (:derived ({name}) {condition})");
        }
        for action in &actions {
            let _ = write!(
                domain,
                "  (:action {}\n    :parameters ()\n    :precondition {}\n    :effect (and {}))\n",
                action.name, action.precondition, action.effects
            );
        }
        domain.push_str(")\n");
        let mut problem = format!(
            "(define (problem {name})\n  (:domain {name})\n  (:init",
            name = plain(name)
        );
        let initial = self.facts.iter().zip(&task.initial).filter(|(_, holds)| **holds);
        for (fact, _) in initial {
            let _ = write!(problem, "\n    ({fact})");
        }
        let _ = write!(
            problem,
            "\n    (= (total-cost) 0))\n  (:goal (and (not ({violated})) {}))\n  (:metric minimize (total-cost)))\n",
            self.formula(&task.goal, true)
        );
        GroundTask { domain, problem, steps }
    }

    /// Writes a formula, or its negation.
    fn formula(&self, formula: &Formula, holds: bool) -> String {
        let list = |word: &str, parts: &[Formula]| {
            let parts: Vec<String> = parts.iter().map(|part| self.formula(part, holds)).collect();
            format!("({word} {})", parts.join(" "))
        };
        match formula {
            Formula::And(parts) => list(if holds { "and" } else { "or" }, parts),
            Formula::Or(parts) => list(if holds { "or" } else { "and" }, parts),
            Formula::Literal(literal) => self.literal(Literal {
                holds: literal.holds == holds,
                ..*literal
            }),
        }
    }

    fn literal(&self, literal: Literal) -> String {
        let name = &self.facts[literal.fact as usize];
        if literal.holds {
            format!("({name})")
        } else {
            format!("(not ({name}))")
        }
    }

    fn effects(&self, operator: &Operator) -> String {
        let effect = |effect: &GroundEffect| {
            if effect.condition.is_true() {
                self.literal(effect.literal)
            } else {
                format!(
                    "(when {} {})",
                    self.formula(&effect.condition, true),
                    self.literal(effect.literal)
                )
            }
        };
        let effects: Vec<String> = operator.effects.iter().map(effect).collect();
        effects.join(" ")
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::goal;
    use crate::testing;

    #[test]
    fn a_goal_with_sensing_is_refused_and_others_name_each_step_once() {
        let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<milk>"],
            "object_states": {"<milk>": "on_something(<table>)"}}"#;
        let world = testing::world("household-checks", text);
        let write = |text: &str| {
            let goal = goal::parse(&world, text).unwrap();
            GroundTask::write(&world, &goal.purpose(&world), "task")
        };
        let sensing = write("if expired(milk) then put(milk, shelf)");
        assert_eq!(sensing, Err(WriteError::Sensing));
        let task = write("put(milk, shelf) then put(milk, table) & untouched(shelf)").unwrap();
        let names: FxHashSet<&str> = task.steps.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names.len(), task.steps.len());
        assert_eq!(task.read_plan("; cost = 1\n(progress-1)\n"), Some(Vec::new()));
        assert_eq!(task.read_plan("(fly)"), None);
    }
}
