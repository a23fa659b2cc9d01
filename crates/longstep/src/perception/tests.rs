use super::*;
use crate::Planner;
use crate::call::Call;
use crate::dialogue::{Constraint, ConstraintKind, Dialogue, DialogueError, Finish, Reply, Role};
use crate::domain::Domain;

const DOMAINS: [&str; 4] = ["household", "household-checks", "household-dual", "virtualhome"];

fn reply(text: &str, finish: Finish) -> Reply {
    Reply {
        finish,
        ..Reply::complete(text)
    }
}

fn dialogue<'a>(domain: &'a Domain, words: &'a str, kind: ConstraintKind) -> SightDialogue<'a> {
    SightDialogue::new(&SightInput {
        domain,
        words,
        pictures: &[],
        kind,
    })
}

fn sighting(assets: &[&str], objects: &[&str], statements: &[(&str, &str)]) -> Sighting {
    let own = |names: &[&str]| names.iter().map(|name| (*name).to_owned()).collect();
    let statements = statements.iter().map(|(subject, state)| Statement {
        subject: (*subject).to_owned(),
        state: Call::parse(state).unwrap(),
    });
    Sighting {
        assets: own(assets),
        objects: own(objects),
        statements: statements.collect(),
        ..Sighting::default()
    }
}

/// The worked examples are what the dialogue itself accepts, in every domain.
#[test]
fn every_example_is_readable_and_a_world_of_its_domain() {
    for name in DOMAINS {
        let planner = Planner::shipped(name).unwrap();
        let domain = planner.domain();
        let first = dialogue(domain, "a table", ConstraintKind::Grammar);
        let messages = first.request().messages;
        let answers: Vec<&str> = messages
            .iter()
            .filter(|own| own.role == Role::Assistant)
            .map(|own| own.text.as_str())
            .collect();
        assert!(answers.len() >= 6, "{name}: {answers:#?}");
        for answer in answers {
            let (lines, names) = answer.rsplit_once('\n').unwrap();
            let mut again = dialogue(domain, "", ConstraintKind::Grammar);
            let found = again.supply(&reply(lines, Finish::Stop)).unwrap();
            let found = found.unwrap_or_else(|| again.supply(&reply(names, Finish::Stop)).unwrap().unwrap());
            assert!(
                found
                    .left_out
                    .iter()
                    .all(|text| text.contains("under") || text.contains("behind")),
                "{name}: {answer}"
            );
            let view = View::of(domain, &found);
            assert!(view.world.is_ok(), "{name}: {answer}: {:?}", view.world.err());
            let odd: Vec<_> = view
                .leniencies
                .iter()
                .filter(|own| !matches!(own, Leniency::Narrowed(..)))
                .collect();
            assert!(odd.is_empty(), "{name}: {answer}: {odd:?}");
        }
    }
}

#[test]
fn sentences_become_statements_and_a_second_request_asks_about_the_names_they_leave_open() {
    let planner = Planner::shipped("household").unwrap();
    let mut dialogue = dialogue(planner.domain(), "milk in a fridge, and a cup", ConstraintKind::Grammar);
    let Constraint::Lark(grammar) = dialogue.request().constraint else {
        panic!()
    };
    for part in ["\" is on \"", "\"The hand holds \"", "\"Other: \"", "\"There is a \""] {
        assert!(grammar.contains(part), "{part}: {grammar}");
    }
    let text = "milk in a fridge, and a cup => The milk_1 is in the fridge. The fridge is open. The hand holds the cup. There is a milk_2. \
        Other: the cat sleeps under the table. The milk_1 sings.\n";
    assert!(dialogue.supply(&reply(text, Finish::Stop)).unwrap().is_none());
    let request = dialogue.request();
    assert_eq!(request.answer_so_far, text);
    let Constraint::Lark(grammar) = request.constraint else {
        panic!()
    };
    for part in ["\"milk_2\"", "\" asset\""] {
        assert!(grammar.contains(part), "{part}: {grammar}");
    }
    for part in ["milk_1", "fridge", "cup"] {
        assert!(!grammar.contains(part), "{part}: {grammar}");
    }
    let names = "names: milk_2 object";
    let found = dialogue.supply(&reply(names, Finish::Stop)).unwrap().unwrap();
    let statements = [
        ("milk_1", "inside_something(fridge)"),
        ("fridge", "open()"),
        ("cup", "inside_hand()"),
    ];
    let left_out = ["the cat sleeps under the table", "The milk_1 sings"].map(str::to_owned);
    let expected = Sighting {
        left_out: left_out.to_vec(),
        ..sighting(&["fridge"], &["milk_1", "cup", "milk_2"], &statements)
    };
    assert_eq!(found, expected);
    let view = View::of(planner.domain(), &found);
    assert_eq!(
        view.sentences(planner.domain()),
        [
            "milk 1 is in the fridge",
            "the fridge is open",
            "the hand holds the cup"
        ]
    );
    assert_eq!(view.unsaid, ["nothing says where the milk 2 is"]);
}

#[test]
fn replies_without_the_form_are_errors() {
    let planner = Planner::shipped("household").unwrap();
    for (text, finish, expected) in [
        (
            "milk => The mil",
            Finish::Length,
            "the model's answer was cut off: `milk => The mil`",
        ),
        ("", Finish::Refused, "the model refused to answer"),
        (
            "milk",
            Finish::Stop,
            "the model's answer cannot be read: it has no sentences",
        ),
    ] {
        let mut dialogue = dialogue(planner.domain(), "milk", ConstraintKind::Grammar);
        let error = dialogue.supply(&reply(text, finish)).unwrap_err();
        assert_eq!(error.to_string(), expected);
    }
    let mut dialogue = dialogue(planner.domain(), "milk", ConstraintKind::JsonSchema);
    assert_eq!(dialogue.supply(&reply("[]", Finish::Stop)), Ok(None));
    let error = dialogue.supply(&reply("[]", Finish::Stop)).unwrap_err();
    assert!(matches!(error, DialogueError::Unreadable(_)));
}

#[test]
fn correction_replaces_only_contradicted_statements() {
    let planner = Planner::shipped("household").unwrap();
    let domain = planner.domain();
    let before = sighting(
        &["fridge", "shelf", "table"],
        &["juice", "cup"],
        &[
            ("juice", "inside_something(fridge)"),
            ("juice", "next_to(cup)"),
            ("cup", "on_something(table)"),
            ("fridge", "open()"),
        ],
    );
    let view = View::of(domain, &before);
    assert!(view.world.is_ok());
    for (change, expected) in [
        (
            sighting(&[], &[], &[("juice", "on_something(shelf)")]),
            vec![
                "the cup is on the table",
                "the fridge is open",
                "the juice is on the shelf",
                "the juice is next to the cup",
            ],
        ),
        (
            sighting(&[], &[], &[("fridge", "closed()")]),
            vec![
                "the juice is in the fridge",
                "the juice is next to the cup",
                "the cup is on the table",
                "the fridge is closed",
            ],
        ),
        (
            Sighting {
                absent: vec!["cup".to_owned(), "spoon".to_owned()],
                ..sighting(&[], &["knife"], &[("knife", "on_something(shelf)")])
            },
            vec![
                "the juice is in the fridge",
                "the fridge is open",
                "the knife is on the shelf",
            ],
        ),
    ] {
        let after = view.corrected(domain, &change);
        assert_eq!(after.sentences(domain), expected);
        assert!(after.world.is_ok());
        let gone = change.absent.iter().any(|name| name == "spoon");
        assert_eq!(after.leniencies.contains(&Leniency::NotThere("spoon".to_owned())), gone);
    }
}

#[test]
fn look_observation_keeps_facts_it_cannot_decide() {
    let planner = Planner::shipped("household").unwrap();
    let world = planner
        .world(
            r#"{"assets": ["<fridge>", "<table>"], "objects": ["<milk>", "<fridge_handle>"], "object_states":
               {"<milk>": "inside_something(<fridge>)", "<fridge_handle>": "open()"}}"#,
        )
        .unwrap();
    let look = |text: &str| serde_json::from_str(text).unwrap();
    let empty = look(r#"{"assets": ["<fridge>"], "objects": ["<milk>", "<fridge_handle>"]}"#);
    let moved =
        look(r#"{"assets": ["<table>"], "objects": ["<milk>"], "object_states": {"<milk>": "on_something(<table>)"}}"#);
    for (look, source, milk, handle) in [
        (&empty, LookSource::Poses, vec![], Some(vec!["open()"])),
        (
            &empty,
            LookSource::Stated,
            vec!["inside_something(<fridge>)"],
            Some(vec!["open()"]),
        ),
        (&moved, LookSource::Stated, vec!["on_something(<table>)"], None),
    ] {
        let statements = observation(&world, look, source);
        let own = |name: &str| statements.states.get(name).map(|words| words.as_slice().to_vec());
        assert_eq!(own("<milk>").unwrap(), milk);
        assert_eq!(
            own("<fridge_handle>"),
            handle.map(|own| own.into_iter().map(str::to_owned).collect())
        );
    }
}

/// A sentence about a name that the description does not have is left out. If that would lose a thing, the model is asked
/// again, with the words of the description alone.
#[test]
fn names_are_words_of_the_description() {
    let planner = Planner::shipped("household").unwrap();
    for (words, first, expected) in [
        (
            "Milk in a fridge",
            "The milk is in the fridge. The fridge is in the kitchen.",
            "the fridge is in the kitchen",
        ),
        (
            "Two mugs, a fork",
            "The mug_1 is on the tray. There is a mug_1. There is a mug_2.",
            "the mug 1 is on the tray",
        ),
        (
            "Two mugs on the tray",
            "The mug_1 is on the tray. The mug_2 is on the spoon.",
            "again",
        ),
        ("A remote on the sofa", "The remote_control is on the sofa.", ""),
        ("Lait dans le frigo", "The milk is in the fridge.", ""),
        ("牛乳が冷蔵庫にあります", "The milk is in the fridge.", ""),
    ] {
        let mut dialogue = dialogue(planner.domain(), words, ConstraintKind::Grammar);
        let answer = format!("{words} => {first}\n");
        let found = dialogue.supply(&reply(&answer, Finish::Stop)).unwrap();
        let request = dialogue.request();
        if expected == "again" {
            assert_eq!((found.is_none(), request.answer_so_far.as_str()), (true, ""), "{words}");
            let Constraint::Lark(grammar) = request.constraint else {
                panic!()
            };
            assert!(!grammar.contains("spoon"), "{grammar}");
            // The second answer counts, whatever its names are.
            assert!(dialogue.supply(&reply(&answer, Finish::Stop)).unwrap().is_some());
            continue;
        }
        let found = found.unwrap_or_else(|| {
            let names = "names: mug_1 object, mug_2 object";
            dialogue.supply(&reply(names, Finish::Stop)).unwrap().unwrap()
        });
        assert_eq!(found.left_out.join(", "), expected, "{words}");
        assert!(
            !found.assets.iter().any(|name| name == "kitchen" || name == "tray"),
            "{words}"
        );
    }
}

/// A picture is described in JSON by every model. An engine that masks tokens gets the same prompt, and bounds in the schema.
#[test]
fn a_picture_gives_one_request_with_bounds_or_without() {
    let planner = Planner::shipped("household").unwrap();
    let picture = crate::dialogue::Picture::new(b"\x89PNG\r\n\x1a\n".to_vec()).unwrap();
    let request = |kind: ConstraintKind| {
        let input = SightInput {
            domain: planner.domain(),
            words: "",
            pictures: std::slice::from_ref(&picture),
            kind,
        };
        SightDialogue::new(&input).request()
    };
    let (engine, server) = (request(ConstraintKind::Grammar), request(ConstraintKind::JsonSchema));
    assert_eq!(engine.messages, server.messages);
    let [engine, server] = [engine, server].map(|request| match request.constraint {
        Constraint::JsonSchema(schema) => schema.to_string(),
        other => panic!("{other:?}"),
    });
    for bound in ["maxItems", "pattern", "x-guidance"] {
        assert!(engine.contains(bound) && !server.contains(bound), "{bound}");
    }
    assert!(engine.contains("on_something"), "{engine}");
    let input = SightInput {
        domain: planner.domain(),
        words: "",
        pictures: std::slice::from_ref(&picture),
        kind: ConstraintKind::Grammar,
    };
    let text = r#"{"assets":["table"],"objects":["cup"],"states":[{"entity":"cup","state":"on_something","arguments":["table"]}],"unsure":[]}"#;
    let found = SightDialogue::new(&input).supply(&reply(text, Finish::Stop)).unwrap();
    assert_eq!(
        found,
        Some(sighting(&["table"], &["cup"], &[("cup", "on_something(table)")]))
    );
}
