//! Goal requests of servers, and replies to them.

use super::requests::check_strict;
use crate::dialogue::{Constraint, ConstraintKind, Dialogue, Finish, GoalDialogue, GoalInput, Reply};
use crate::domain::{Domain, shipped};
use crate::environment::{self, World};

fn kitchen() -> (Domain, World) {
    let domain = shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<butter>", "<fridge_handle>"],
        "object_states": {"<butter>": "inside_something(<fridge>)", "<fridge_handle>": "closed()"}}"#;
    let world = environment::parse(&domain, "kitchen.json", text).unwrap();
    (domain, world)
}

fn asked(domain: &Domain, world: &World, instruction: &str) -> GoalDialogue {
    GoalDialogue::new(GoalInput::new(domain, world, instruction, ConstraintKind::JsonSchema))
}

#[test]
fn the_schema_has_the_goals_that_are_open_only_after_others() {
    let (domain, world) = kitchen();
    let dialogue = asked(&domain, &world, "Put the butter on the counter and close the fridge");
    let Constraint::JsonSchema(schema) = dialogue.request().constraint else {
        panic!("a schema")
    };
    check_strict(&schema);
    for list in ["goals", "never"] {
        let goals = schema["properties"][list]["items"]["enum"].as_array().unwrap();
        for goal in ["put(butter, counter)", "closed(fridge)", "opened(fridge)"] {
            assert!(goals.iter().any(|own| own == goal), "{list}: {goal} in {goals:?}");
        }
        assert!(!goals.iter().any(|own| own == "closed(counter)"), "{goals:?}");
    }
}

#[test]
fn a_reply_that_cannot_be_read_is_asked_for_once_more() {
    let (domain, world) = kitchen();
    let right = r#"{"question": "", "goals": ["put(butter, counter)"]}"#;
    for (wrong, reason) in [
        ("Sure, I will do that!", "Sure, I will do that!"),
        (r#"{"goals": ["put(butter, moon)"]}"#, "`moon`"),
        (r#"{"goals": "put(butter, counter)"}"#, "invalid type"),
        ("{}", "neither `goals` nor a `question`"),
        ("", "EOF"),
    ] {
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        let before = dialogue.request();
        assert_eq!(dialogue.supply(&Reply::complete(wrong)), Ok(None), "{wrong}");
        let request = dialogue.request();
        assert_eq!(
            (request.messages.len(), request.answer_so_far.as_str()),
            (before.messages.len() + 2, "")
        );
        let last = &request.messages[request.messages.len() - 1].text;
        assert!(
            last.starts_with("This answer cannot be used: ") && last.contains(reason),
            "{last}"
        );
        assert!(request.messages.iter().all(|message| !message.text.is_empty()));
        assert!(
            matches!(dialogue.supply(&Reply::complete(right)), Ok(Some(_))),
            "{wrong}"
        );
        // The second reply is the last.
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        dialogue.supply(&Reply::complete(wrong)).unwrap();
        assert!(dialogue.supply(&Reply::complete(wrong)).is_err(), "{wrong}");
    }
    for finish in [Finish::Refused, Finish::Length] {
        let mut dialogue = asked(&domain, &world, "Put the butter on the counter");
        let reply = Reply {
            finish,
            ..Reply::complete("I will not.")
        };
        assert!(dialogue.supply(&reply).is_err());
    }
}
