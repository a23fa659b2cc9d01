//! Coverage of instructions, as tables.

use super::*;
use crate::goal::parse;
use crate::{Planner, World};
use longstep_core::testing;

const ROOM: &str = r#"{
    "assets": ["<desk>", "<shelf>", "<cupboard>", "<floor>"],
    "asset_states": {"<shelf>": "on_something(<floor>)"},
    "objects": ["<pen>", "<ruler>", "<jar1>", "<jar2>", "<cupboard_handle>", "<冷蔵庫>", "<vase>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "inside_something(<cupboard>)",
        "<jar1>": "on_something(<desk>)", "<jar2>": "on_something(<desk>)", "<cupboard_handle>": "closed()",
        "<vase>": "on_something(<floor>)"},
    "names": {"<jar1>": "jar 1", "<jar2>": "jar 2"}}"#;

fn room() -> World {
    Planner::shipped("household").unwrap().world(ROOM).unwrap()
}

fn coverage(instruction: &str, goal: &str, left_out: &[(&str, Gap)]) -> Coverage {
    let world = room();
    let goal = match goal {
        "" => Goal::default(),
        goal => parse(&world, goal).unwrap(),
    };
    let left_out = left_out.iter().map(|(text, kind)| LeftOut {
        text: (*text).to_owned(),
        kind: *kind,
    });
    Coverage::new(&world, instruction, &goal, &left_out.collect::<Vec<_>>(), true)
}

#[track_caller]
fn check(instruction: &str, goal: &str, expected: &[(&str, Gap)]) {
    let coverage = coverage(instruction, goal, &[]);
    assert_eq!(
        coverage.gaps().collect::<Vec<_>>(),
        expected,
        "{instruction}: {:?}",
        coverage.parts()
    );
}

#[test]
fn numbers_are_represented_by_names_and_counts() {
    check("Put the pen on the shelf", "put(pen, shelf)", &[]);
    check("Put jar 2 on the shelf", "put(jar 2, shelf)", &[]);
    check(
        "Put the 2 jars on the shelf",
        "put(jar 1, shelf) & put(jar 2, shelf)",
        &[],
    );
    check(
        "Put 3 jars on the shelf",
        "put(jar 1, shelf) & put(jar 2, shelf)",
        &[("3", Gap::Amount)],
    );
    check("Put 2 pens on the shelf", "put(pen, shelf)", &[("2", Gap::Amount)]);
    check(
        "Stell den Stift um 7:30 ins Regal",
        "put(pen, shelf)",
        &[("7:30", Gap::Amount)],
    );
    check(
        "Open it by 2.5 cm, then wait ٣ s",
        "opened(cupboard)",
        &[("2.5", Gap::Amount), ("٣", Gap::Amount)],
    );
}

/// Two towels, two rooms and the minibars of a hotel, with names in two languages.
fn hotel() -> World {
    const HOTEL: &str = r#"{
        "assets": ["<room_101>", "<room_102>", "<floor>", "<cart_7>"],
        "objects": ["<towel_1>", "<towel_2>", "<pen>", "<w1>"],
        "object_states": {"<towel_1>": "on_something(<floor>)", "<towel_2>": "on_something(<floor>)",
            "<pen>": "on_something(<floor>)", "<w1>": "on_something(<floor>)"}}"#;
    let mut files = longstep_core::domain::shipped_files("household").unwrap();
    let rooms = "[lexicon]\nroom = [\"room\", \"habitación\", \"guest room\"]\n";
    files.words = files.words.replace("[lexicon]\n", rooms);
    let domain = longstep_core::domain::load(&files).unwrap();
    testing::world_of(&domain, HOTEL)
}

#[test]
fn numbers_count_what_the_goal_has_and_label_its_places() {
    let world = hotel();
    let both = "put(towel 1, room 102) & put(towel 2, room 102)";
    let one = "put(towel 1, room 102)";
    for (instruction, goal, expected) in [
        ("Two towels to 102, please", both, &[][..]),
        ("Bring 2 towels to 102", both, &[]),
        ("Pon dos toallas en la habitación 102", both, &[]),
        ("Put w1 in guest room 102", "put(w1, room 102)", &[]),
        ("Put towel_1 in room_102", one, &[]),
        ("Put towel_3 in room_102", one, &["3"]),
        ("Push the pen to the cart in 7 s", "put(pen, cart)", &["7"]),
        ("Put the pen on cart 7", "put(pen, cart)", &[]),
    ] {
        let goal = parse(&world, goal).unwrap();
        let coverage = Coverage::new(&world, instruction, &goal, &[], true);
        let gaps: Vec<&str> = coverage.gaps().map(|(text, _)| text).collect();
        assert_eq!(gaps, expected, "{instruction}: {:?}", coverage.parts());
    }
}

#[test]
fn quotations_are_represented_by_names_alone() {
    check("Put the \"pen\" on the shelf", "put(pen, shelf)", &[]);
    check(
        "Label the pen \u{201c}new\u{201d}",
        "put(pen, shelf)",
        &[("new", Gap::Message)],
    );
    check("Put the teacher's pen on the 'shelf'", "put(pen, shelf)", &[]);
    check("An \"open quotation", "put(pen, shelf)", &[]);
}

/// A name of which nothing is asked is no gap: a person, or where a thing is.
#[test]
fn coverage_reports_no_gap_for_names() {
    for text in [
        "Take the pen from the desk to the shelf",
        "The ruler says: pen, shelf",
        "冷蔵庫を開けて",
    ] {
        check(text, "put(pen, shelf)", &[]);
    }
}

#[test]
fn words_that_a_model_leaves_out_are_gaps() {
    let text = "Put the pen on the shelf quietly for ten minutes";
    for (left_out, expected) in [
        (&[][..], &[][..]),
        (&[("quietly", Gap::Manner)], &[("quietly", Gap::Manner)]),
        // Of parts that overlap the one with a question stays.
        (
            &[
                ("quietly for ten minutes", Gap::Manner),
                ("for ten minutes", Gap::Amount),
            ],
            &[("for ten minutes", Gap::Amount)],
        ),
        // What is not said stands for everything.
        (&[("in a minute", Gap::Time)], &[(text, Gap::Time)]),
        // A name in the goal is no message.
        (&[("the shelf", Gap::Message)], &[("the shelf", Gap::Message)]),
        (&[("shelf", Gap::Message)], &[]),
    ] {
        let coverage = coverage(text, "put(pen, shelf)", left_out);
        assert_eq!(coverage.gaps().collect::<Vec<_>>(), expected);
    }
}

/// After an answer, words that the instruction does not have are from there.
#[test]
fn coverage_after_an_answer_counts_only_omissions() {
    let world = room();
    let goal = parse(&world, "put(pen, shelf)").unwrap();
    let left_out = [LeftOut {
        text: "in a minute".to_owned(),
        kind: Gap::Amount,
    }];
    let coverage = Coverage::new(&world, "Put 3 pens on the shelf", &goal, &left_out, false);
    assert_eq!(coverage.gaps().count(), 0);
}

#[test]
fn coverage_assigns_every_character_to_one_part() {
    let text = "It is late. Put the pen on the shelf, and close the cupboard at 7.30, please!";
    let coverage = coverage(text, "put(pen, shelf) & closed(cupboard)", &[("at 7.30", Gap::Amount)]);
    let parts: Vec<(&str, &CoverageRole)> = coverage
        .parts()
        .iter()
        .map(|part| (coverage.text(part), &part.role))
        .collect();
    assert_eq!(
        parts,
        [
            ("It is late", &CoverageRole::Background),
            ("Put the pen on the shelf", &CoverageRole::Goals(vec![0])),
            ("and close the cupboard", &CoverageRole::Goals(vec![1])),
            ("at 7.30", &CoverageRole::NotRepresented(Gap::Amount)),
            ("please", &CoverageRole::Background),
        ]
    );
    let question = "I cannot represent \"at 7.30\"; the plan ignores it. Go on?";
    assert_eq!(coverage.question().as_deref(), Some(question));
    for text in [
        "",
        "...",
        "a",
        "7",
        "\"",
        "é«»",
        "冷",
        "pen pen pen 2 2 \"\"",
        "\u{301}1\u{301}",
    ] {
        let coverage = super::tests::coverage(text, "put(pen, shelf)", &[]);
        let mut at = 0;
        for part in coverage.parts() {
            let between = &text[at..part.range.start];
            assert!(!between.contains(char::is_alphanumeric), "{text}");
            at = part.range.end;
        }
        assert!(!text[at..].contains(char::is_alphanumeric), "{text}");
    }
}

#[test]
fn gap_kinds_convert_to_and_from_their_names() {
    for gap in Gap::ALL {
        let json = serde_json::to_value(gap).unwrap();
        assert_eq!(json, gap.name());
        assert_eq!(Gap::named(gap.name()), Some(gap));
    }
    // Saved plans of older programs.
    for (old, gap) in [
        ("quantity", Gap::Amount),
        ("quotation", Gap::Message),
        ("name", Gap::Wish),
        ("other", Gap::Reason),
    ] {
        assert_eq!(serde_json::from_value::<Gap>(old.into()).unwrap(), gap);
    }
}
