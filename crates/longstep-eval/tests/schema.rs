//! A server that enforces the schema of a goal request can give the right answer to every instruction of the shipped
//! suites.
#![allow(clippy::unwrap_used, clippy::panic)]

use longstep::dialogue::{Constraint, ConstraintKind, Dialogue, GoalDialogue, GoalInput};
use longstep::domain::{self, Domain};
use longstep::goal::{Goal, NEVER};
use longstep_core::environment::World;
use longstep_eval::suite::{domain_name, load, shipped, shipped_names};
use serde_json::{Value, json};

/// The schema of the request for an instruction.
fn schema(domain: &Domain, world: &World, says: &str) -> Value {
    let input = GoalInput::new(domain, world, says, ConstraintKind::JsonSchema);
    match GoalDialogue::new(input).request().constraint {
        Constraint::JsonSchema(schema) => schema,
        other => panic!("the request of a server has a schema: {other:?}"),
    }
}

/// The answer of a server with these goals.
fn answer(world: &World, goal: &Goal) -> Value {
    let (never, goals): (Vec<String>, Vec<String>) = goal
        .everyday(world)
        .into_iter()
        .partition(|part| part.starts_with(NEVER));
    let never: Vec<&str> = never.iter().map(|part| &part[NEVER.len()..]).collect();
    json!({"question": "", "goals": goals, "never": never, "not_represented": []})
}

/// Figures of the enforced schemas.
#[derive(Debug, Default, PartialEq)]
struct Counts {
    /// Right answers that were checked.
    answers: usize,
    /// Those whose goals the schema lists.
    listed: usize,
}

#[test]
fn the_right_answers_of_all_suites_are_in_their_schemas() {
    let mut counts = Counts::default();
    for name in shipped_names() {
        let files = shipped(name).unwrap();
        let domain = domain::shipped(&domain_name(&files).unwrap()).unwrap().unwrap();
        let suite = load(&files, &domain).unwrap();
        for case in &suite.cases {
            let world = suite.judged_world(case);
            for step in &case.steps {
                let schema = schema(&domain, &world, &step.says);
                let validator = jsonschema::validator_for(&schema).unwrap();
                for goal in step.expected.goals() {
                    let answer = answer(&world, goal);
                    if let Err(error) = validator.validate(&answer) {
                        panic!("{name}, {}: {} -> {answer}: {error}", case.id, step.says);
                    }
                    counts.answers += 1;
                    counts.listed += usize::from(schema.pointer("/properties/goals/items/enum").is_some());
                }
            }
        }
    }
    // Goals with conditions are not listed.
    assert!(
        counts.answers > 350 && counts.listed * 10 > counts.answers * 9,
        "{counts:?}"
    );
}
