//! The parser of goals.

use super::conditional::{IF, THEN, split_once};
use super::error::STAGES;
use super::expansion::{self, Expansion};
use super::fact::state;
use super::{Conditional, Goal, GoalError, GoalFact, Group, WrittenConditional};
use longstep_model::call::unquoted;
use longstep_model::model::{Fact, Prohibition, World};

/// The prefix of a question in a model's answer.
pub const QUESTION: &str = "question: ";

/// The word before the first goal of a stage.
pub const STAGE: &str = "then ";

/// The separator after a goal, without the blank before the next one. Models write a blank and the following word as
/// one token, so the grammar must not split them.
pub const JOINT: &str = " &";

/// Parses a goal: parts joined by `&`. A part is a goal word, or a state word with the subject as first argument:
/// `INSIDE(<pie>, <oven>)`. Entities are given by everyday name or identifier.
///
/// A part may depend on a sensed fact, in the form
/// `if expired(milk) then put(milk, bin) and closed(fridge) else put(milk, fridge)`. The word "and" joins the goals of
/// a branch, and the `else` branch is optional.
///
/// Goals after "then" are achieved after those before it: `wiped(table, cloth) then put(plate, table) & put(cup, table)`
/// ([`Purpose::stages`](longstep_verify::verify::Purpose::stages)). A goal of an earlier stage holds at the end too, unless a
/// later one excludes it: `at(robot, dock) then at(robot, office)`.
///
/// Constraints hold for the whole plan: `never opened(fridge)`, `always closed(door)`, `never grasp(cup, _)` for the calls
/// of an action, `untouched(vase)` for everything that concerns an entity.
///
/// A group stands for its members wherever a name can stand: `put(all cup where dirty & on_something(table) except mug, sink)`,
/// `put(any cup, table)`, `put(2 of plate, any shelf)`, `untouched(all glass)`. Its members are those in the given world.
///
/// # Errors
///
/// The error in the first unreadable part.
pub fn parse(world: &World, text: &str) -> Result<Goal, GoalError> {
    let mut goal = Goal::default();
    for part in parts_of(text) {
        let (begins, part) = match part.strip_prefix(STAGE) {
            Some(part) => (true, part.trim()),
            None => (false, part),
        };
        for (index, piece) in stages_of(part).into_iter().enumerate() {
            if piece.is_empty() {
                return Err(GoalError::Empty);
            }
            if begins || index > 0 {
                goal.begin_stage();
            }
            if goal.stages.len() >= STAGES {
                return Err(GoalError::TooManyStages);
            }
            goal.add(piece, self::part(world, piece)?);
        }
    }
    goal.end_stages();
    Ok(goal)
}

/// Splits a goal at each `&` outside of parentheses; within them it joins the conditions of a group.
fn parts_of(text: &str) -> Vec<&str> {
    let (mut depth, mut start) = (0_usize, 0);
    let mut parts = Vec::new();
    for (at, letter) in unquoted(text) {
        match letter {
            '(' => depth += 1,
            ')' => depth = depth.saturating_sub(1),
            '&' if depth == 0 => {
                parts.push(text[start..at].trim());
                start = at + 1;
            }
            _ => {}
        }
    }
    parts.push(text[start..].trim());
    parts
}

/// Parses rules that bind every plan until they are lifted: constraints of the goal language, joined by `&`.
///
/// ```
/// use longstep_model::{domain, environment};
/// use longstep_search::{goal, search, search::Limits};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let rules = goal::rules(&world, "untouched(cup)").unwrap();
/// let world = world.with_prohibitions(rules);
/// let goal = goal::parse(&world, "put(cup, shelf)").unwrap();
/// let outcome = search::solve(&world, &goal.purpose(&world), &Limits::default());
/// assert!(matches!(outcome, search::Outcome::ProvenUnsolvable { .. }));
/// ```
///
/// # Errors
///
/// [`GoalError::NotARule`] for a goal; else the error in the first unreadable part.
pub fn rules(world: &World, text: &str) -> Result<Vec<Prohibition>, GoalError> {
    let goal = parse(world, text)?;
    if let Some(fact) = goal.facts.first() {
        return Err(GoalError::NotARule {
            part: fact.everyday(world),
        });
    }
    let rules = goal.constraints.iter();
    Ok(rules
        .map(|constraint| constraint.prohibition(world).standing())
        .collect())
}

/// Splits a part of a goal at each "then" that begins a stage; the "then" of a conditional goal does not.
fn stages_of(part: &str) -> Vec<&str> {
    let mut pieces = Vec::new();
    let mut rest = part;
    loop {
        // The first `then` behind `if` belongs to the condition.
        let of_conditional = match rest.strip_prefix(IF) {
            Some(_) => split_once(rest, THEN).map_or(0, |(condition, _)| condition.len() + THEN.len()),
            None => 0,
        };
        let Some((piece, after)) = split_once(&rest[of_conditional..], THEN) else {
            pieces.push(rest.trim());
            return pieces;
        };
        pieces.push(rest[..of_conditional + piece.len()].trim());
        rest = after.trim_start();
    }
}

/// Reads a part of a goal.
pub(super) fn part(world: &World, text: &str) -> Result<Expansion, GoalError> {
    match WrittenConditional::read(text) {
        Some(written) => conditional(world, &written),
        None => expansion::part(world, text),
    }
}

/// Reads a conditional goal; its branches cannot contain conditions.
fn conditional(world: &World, written: &WrittenConditional<'_>) -> Result<Expansion, GoalError> {
    let domain = world.domain();
    let condition = match state(world, written.condition)? {
        Some(fact) if domain.is_sensed(fact.predicate()) => fact,
        _ => {
            let sensed = domain
                .states
                .iter()
                .filter(|word| domain.is_sensed(word.atom.predicate));
            let forms: Vec<String> = sensed.map(|word| format!("`{}(...)`", word.word)).collect();
            return Err(GoalError::NotSensed {
                condition: written.condition.to_owned(),
                forms: forms.join(", "),
            });
        }
    };
    let mut groups: Vec<Group> = Vec::new();
    let then = branch(world, &written.then, &mut groups)?;
    let otherwise = branch(world, &written.otherwise, &mut groups)?;
    let others: Vec<Fact> = domain
        .outcomes(condition)
        .into_iter()
        .filter(|o| *o != condition)
        .collect();
    let conditional = match (written.negated, &others[..]) {
        (false, _) => Conditional {
            condition,
            then,
            otherwise,
        },
        (true, [other]) => Conditional {
            condition: *other,
            then,
            otherwise,
        },
        // No single outcome is the negation, so the branches change places.
        (true, _) => Conditional {
            condition,
            then: otherwise,
            otherwise: then,
        },
    };
    Ok(Expansion {
        groups,
        ..GoalFact::If(conditional).into()
    })
}

/// Reads the goals of a branch, and adds their groups.
fn branch(world: &World, parts: &[&str], groups: &mut Vec<Group>) -> Result<Vec<GoalFact>, GoalError> {
    let mut facts: Vec<GoalFact> = Vec::new();
    for text in parts {
        if text.is_empty() {
            return Err(GoalError::Empty);
        }
        let part = expansion::goals(world, text)?;
        groups.extend(part.groups);
        for fact in part.facts {
            if !facts.contains(&fact) {
                facts.push(fact);
            }
        }
    }
    Ok(facts)
}
