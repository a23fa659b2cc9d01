//! Coverage of instructions, as tables.

use super::*;
use crate::goal::parse;
use crate::{Planner, World};

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

fn coverage(instruction: &str, goal: &str, marks: &[(&str, Gap)]) -> Coverage {
    let world = room();
    let goal = match goal {
        "" => Goal::default(),
        goal => parse(&world, goal).unwrap(),
    };
    let marks = marks
        .iter()
        .map(|(text, gap)| Mark::of(instruction, text, *gap).unwrap());
    Coverage::new(&world, instruction, &goal, &marks.collect::<Vec<_>>(), None)
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
    check("Put jar 2 on the shelf", "put(jar 1, shelf)", &[("jar 2", Gap::Name)]);
    check(
        "Put the 2 jars on the shelf",
        "put(jar 1, shelf) & put(jar 2, shelf)",
        &[],
    );
    check(
        "Put 3 jars on the shelf",
        "put(jar 1, shelf) & put(jar 2, shelf)",
        &[("3", Gap::Quantity)],
    );
    check("Put 2 pens on the shelf", "put(pen, shelf)", &[("2", Gap::Quantity)]);
    check(
        "Stell den Stift um 7:30 ins Regal",
        "put(pen, shelf)",
        &[("7:30", Gap::Quantity)],
    );
    check(
        "Open it by 2.5 cm, then wait ٣ s",
        "opened(cupboard)",
        &[("2.5", Gap::Quantity), ("٣", Gap::Quantity)],
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
    crate::environment::parse(&domain, "env.json", HOTEL).unwrap()
}

#[test]
fn numbers_count_what_the_goal_has_and_label_its_places() {
    let world = hotel();
    let both = "put(towel 1, room 102) & put(towel 2, room 102)";
    let one = "put(towel 1, room 102)";
    for (instruction, goal, marks, expected) in [
        ("Bring two towels to room 102", both, &["two towels"][..], &[][..]),
        ("Bring two fresh towels to room 102", both, &["two"], &[]),
        ("Put both towels in room 102", both, &["both towels"], &[]),
        ("Put one towel in room 102", one, &["one towel"], &[]),
        ("Two towels to 102, please", both, &["Two towels", "102"], &[]),
        ("Bring 2 towels to 102", both, &[], &[]),
        ("Pon dos towels en la habitación 102", both, &["dos towels"], &[]),
        (
            "Bring three towels to room 102",
            both,
            &["three towels"],
            &["three towels"],
        ),
        ("Bring two towels to room 102", one, &["two towels"], &["two towels"]),
        (
            "Bring the towels to room 102 in two minutes",
            both,
            &["two minutes"],
            &["two minutes"],
        ),
        ("Bring the towels to room 102 for two", both, &["for two"], &["for two"]),
        ("Bring the towels to room 101", both, &[], &["room 101"]),
        ("Lleva la toalla a la habitación 101", one, &[], &["habitación 101"]),
        ("Put w1 in guest room 102", "put(w1, room 102)", &[], &[]),
        ("Put towel_1 in room_102", one, &[], &[]),
        ("Put towel_2 in room_102", one, &[], &["towel_2"]),
        ("Put towel_3 in room_102", one, &[], &["3"]),
        ("Push the pen to the cart in 7 s", "put(pen, cart)", &[], &["7"]),
        ("Put the pen on cart 7", "put(pen, cart)", &[], &[]),
    ] {
        let goal = parse(&world, goal).unwrap();
        let marks = marks
            .iter()
            .map(|text| Mark::of(instruction, text, Gap::Quantity).unwrap());
        let coverage = Coverage::new(&world, instruction, &goal, &marks.collect::<Vec<_>>(), None);
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
        &[("new", Gap::Quotation)],
    );
    check("Put the teacher's pen on the 'shelf'", "put(pen, shelf)", &[]);
    check("An \"open quotation", "put(pen, shelf)", &[]);
}

#[test]
fn a_name_may_describe_and_must_not_be_forgotten() {
    // Where the pen is, and where the shelf stands.
    check(
        "Take the pen from the desk to the shelf on the floor",
        "put(pen, shelf)",
        &[],
    );
    check(
        "Put the pen and the ruler on the shelf",
        "put(pen, shelf)",
        &[("ruler", Gap::Name)],
    );
    // A screening marks the prohibition; a "not" is a word like any other here.
    check(
        "Put the pen on the shelf, not the ruler",
        "put(pen, shelf)",
        &[("ruler", Gap::Name)],
    );
    check("冷蔵庫を開けて", "put(pen, shelf)", &[("冷蔵庫", Gap::Name)]);
    check("Open the cupboard handle", "opened(cupboard)", &[]);
}

#[test]
fn marks_are_gaps_unless_the_goal_says_them() {
    let gaps = |instruction, goal, marks: &[(&str, Gap)]| {
        let coverage = coverage(instruction, goal, marks);
        coverage
            .gaps()
            .map(|(text, gap)| (text.to_owned(), gap))
            .collect::<Vec<_>>()
    };
    let one = |text: &str, gap| vec![(text.to_owned(), gap)];
    let text = "Put the pen on the shelf, but leave the cupboard shut for ten minutes";
    let forbidden = ("but leave the cupboard shut", Gap::Prohibition);
    assert_eq!(
        gaps(text, "put(pen, shelf)", &[forbidden]),
        one("but leave the cupboard shut", Gap::Prohibition)
    );
    assert_eq!(gaps(text, "put(pen, shelf) & never opened(cupboard)", &[forbidden]), []);
    let ten = ("for ten minutes", Gap::Quantity);
    assert_eq!(
        gaps(text, "put(pen, shelf) & never opened(cupboard)", &[forbidden, ten]),
        one("for ten minutes", Gap::Quantity)
    );
    let order = ("Put", Gap::Order);
    assert_eq!(
        gaps(text, "put(pen, shelf) & opened(cupboard)", &[order]),
        one("Put", Gap::Order)
    );
    assert_eq!(gaps(text, "put(pen, shelf) then opened(cupboard)", &[order]), []);
}

#[test]
fn every_letter_belongs_to_one_part() {
    let text = "It is late. Put the pen on the shelf, and close the cupboard at 7.30, please!";
    let coverage = coverage(
        text,
        "put(pen, shelf) & closed(cupboard)",
        &[("at 7.30", Gap::Quantity)],
    );
    let parts: Vec<(&str, &Role)> = coverage
        .parts()
        .iter()
        .map(|part| (coverage.text(part), &part.role))
        .collect();
    assert_eq!(
        parts,
        [
            ("It is late", &Role::Background),
            ("Put the pen on the shelf", &Role::Goals(vec![0])),
            ("and close the cupboard", &Role::Goals(vec![1])),
            ("at 7.30", &Role::NotRepresented(Gap::Quantity)),
            ("please", &Role::Background),
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
fn an_order_is_reported_and_no_question() {
    for gap in Gap::ALL {
        let json = serde_json::to_value(gap).unwrap();
        assert_eq!(json, gap.name());
        assert_eq!(gap.is_question(), !matches!(gap, Gap::Order | Gap::Other));
    }
}

#[test]
fn what_is_forbidden_is_cut_out() {
    let text = "Oil the hinge but not the lock, and do not knock";
    let marks: Vec<Mark> = ["but not the lock", "and do not knock", "not the lock"]
        .iter()
        .map(|part| Mark::of(text, part, Gap::Prohibition).unwrap())
        .collect();
    let (forbidden, rest) = without_prohibitions(text, &marks);
    assert_eq!(forbidden, "but not the lock not the lock and do not knock");
    assert_eq!(rest, "Oil the hinge ,");
    assert_eq!(without_prohibitions(text, &[]), (String::new(), text.to_owned()));
}

#[test]
fn a_name_may_stand_for_several_entities() {
    let text = r#"{"assets": ["<desk>"], "objects": ["<pen>", "<jar_1>", "<jar_2>"]}"#;
    let world = Planner::shipped("household").unwrap().world(text).unwrap();
    for (text, expected) in [("Put the pen on the jar", &[2][..]), ("Put the pen on jar 2", &[])] {
        let sizes: Vec<usize> = shared_names(&world, text).iter().map(Vec::len).collect();
        assert_eq!(sizes, expected, "{text}");
    }
}
