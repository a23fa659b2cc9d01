//! The right answer of a server to every instruction of the shipped suites is read as the goal that is meant, and fits the schema of
//! its request.
#![allow(clippy::unwrap_used, clippy::panic)]

use longstep::dialogue::{Constraint, ConstraintKind, Dialogue, Reply};
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_eval::suite::{load_shipped, shipped_names};
use serde_json::json;

#[test]
fn the_right_answers_of_all_suites_are_read() {
    let mut answers = 0;
    for name in shipped_names() {
        let (domain, suite) = load_shipped(name).unwrap().unwrap();
        for case in &suite.cases {
            let world = suite.judged_world(case);
            for step in &case.steps {
                for goal in step.expected.goals() {
                    let input = UnderstandingInput::new(&domain, &world, &step.says, ConstraintKind::JsonSchema);
                    let mut understanding = Understanding::new(input);
                    let Constraint::JsonSchema(schema) = understanding.request().constraint else {
                        panic!("the request of a server has a schema")
                    };
                    let answer = json!({"goal": goal.text(&world), "left_out": [], "question": ""});
                    jsonschema::validator_for(&schema).unwrap().validate(&answer).unwrap();
                    let meant = understanding
                        .supply(&Reply::complete(answer.to_string()))
                        .unwrap()
                        .unwrap();
                    assert_eq!(meant.goal.as_ref(), Some(goal), "{name}, {}: {answer}", case.id);
                    assert_eq!(meant.question, None);
                    answers += 1;
                }
            }
        }
    }
    assert!(answers > 350, "{answers}");
}
