//! Offered goals and understood goals for instructions, as tables.

use super::*;
use crate::domain;
use crate::domain::Domain;
use crate::environment::{self, Environment};
use crate::environment::{EntityId, World};
use crate::json::Path;

fn flat() -> (Domain, World) {
    let domain = domain::shipped("virtualhome").unwrap().unwrap();
    let text = r#"{
        "assets": ["<desk_1>", "<shelf_2>", "<sofa_3>", "<oven_4>", "<tablelamp_5>"],
        "asset_properties": {"<oven_4>": ["IS_OPENABLE", "HAS_SWITCH"], "<tablelamp_5>": ["HAS_SWITCH"]},
        "objects": ["<mug_6>", "<mug_7>", "<mug_8>", "<tray_9>", "<apple_10>", "<pillow_11>"],
        "object_states": {
            "<mug_6>": ["ON(<desk_1>)"], "<mug_7>": ["ON(<shelf_2>)"], "<mug_8>": ["ON(<shelf_2>)"],
            "<tray_9>": ["ON(<desk_1>)"], "<apple_10>": ["ON(<tray_9>)"], "<pillow_11>": ["ON(<sofa_3>)"]}}"#;
    let environment = Environment::from_json(text).unwrap();
    let world = environment::read(&domain, &environment, "flat", text, &Path::default()).unwrap();
    (domain, world)
}

/// Compares the arguments that `put` is offered with after the goals of `said`.
#[track_caller]
fn check_put(instruction: &str, said: &str, expected: &[&str]) {
    let (domain, world) = flat();
    let said = if said.is_empty() {
        Goal::default()
    } else {
        parse(&world, said).unwrap()
    };
    let offers = offers(&world, &said.facts, &Spoken::of(&world, instruction));
    let mut texts = Vec::new();
    for offer in offers.iter().filter(|offer| domain.goal_word(offer.word).word == "put") {
        for arguments in &offer.arguments {
            let fact = GoalFact::Word {
                word: offer.word,
                arguments: arguments.clone(),
            };
            texts.push(fact.everyday(&world));
        }
    }
    assert_eq!(texts, expected, "{instruction}");
}

#[test]
fn what_is_spoken_of_narrows_what_is_offered() {
    check_put("Put the pillow on the shelf", "", &["put(pillow, shelf)"]);
    check_put("Put the apple on the sofa", "", &["put(apple, sofa)"]);
    // The current place of an object only identifies it.
    check_put("Take the apple from the desk to the shelf", "", &["put(apple, shelf)"]);
    check_put("Put the pillow on the tray on the desk", "", &["put(pillow, tray)"]);
}

#[test]
fn what_is_carried_along_is_no_place_to_go() {
    let along = "I need the apple, the pillow and the tray from the desk, all on the sofa";
    check_put(along, "", &["put(tray, sofa)", "put(apple, sofa)"]);
    check_put(
        "Put on the big shelf: the pillow and the tray",
        "",
        &["put(tray, shelf)", "put(pillow, shelf)"],
    );
    check_put("Put the pillow on the old tray", "", &["put(pillow, tray)"]);
}

#[test]
fn a_thing_that_is_where_it_should_be_goes_nowhere_else() {
    check_put("Put the apple back on the tray", "", &[]);
    let (_, world) = flat();
    for (instruction, expected) in [
        ("Close the oven", "closed(oven)"),
        ("Put the mug back on the desk", "put(mug 1, desk)"),
    ] {
        let already = already(&world, &Spoken::of(&world, instruction));
        let texts: Vec<_> = already.iter().map(|fact| fact.everyday(&world)).collect();
        assert_eq!(texts, [expected]);
    }
}

#[test]
fn one_mug_is_not_two() {
    check_put("Put the mug on the sofa", "put(mug 1, sofa)", &[]);
    let (domain, world) = flat();
    let offers = offers(&world, &[], &Spoken::of(&world, "Reposition the mug"));
    let words: Vec<_> = offers
        .iter()
        .map(|offer| domain.goal_word(offer.word).word.as_str())
        .collect();
    assert!(words.contains(&"moved"), "{words:?}");
}

#[test]
fn phrases_tell_forms_apart() {
    check_put("Put the apple into the oven", "", &["put(apple, oven)"]);
    check_put("Put the apple on top of the oven", "", &["put(apple, top of oven)"]);
    check_put("Set the apple on the oven", "", &["put(apple, top of oven)"]);
}

#[test]
fn a_further_goal_is_about_another_thing_that_is_spoken_of() {
    check_put("Put the pillow on the shelf", "put(pillow, shelf)", &[]);
    check_put(
        "Put the pillow and the apple on the shelf",
        "put(pillow, shelf)",
        &["put(apple, shelf)"],
    );
    // "The mug" is one mug, "mugs" are several.
    check_put("Put the mug on the sofa", "put(mug 1, sofa)", &[]);
    check_put(
        "Put two mugs on the sofa",
        "put(mug 1, sofa)",
        &["put(mug 2, sofa)", "put(mug 3, sofa)"],
    );
    // A destination keeps its place.
    check_put(
        "Put the apple on the desk and the pillow on the tray",
        "put(pillow, tray)",
        &["put(apple, desk)"],
    );
}

#[track_caller]
fn check_understood(instruction: &str, goal: &str, expected: &str) {
    let (_, world) = flat();
    let goal = parse(&world, goal).unwrap();
    let understood = match understand(&world, instruction, goal) {
        Understanding::Question(question) | Understanding::Which(question) => question,
        Understanding::Goal(goal, left_out) => {
            let kept: Vec<_> = goal.facts.iter().map(|fact| fact.everyday(&world)).collect();
            format!("{} (left out {})", kept.join(" & "), left_out.len())
        }
    };
    assert_eq!(understood, expected, "{instruction}");
}

#[test]
fn goals_that_nobody_asked_for_are_left_out() {
    check_understood(
        "Put the apple on the sofa",
        "put(apple, sofa)",
        "put(apple, sofa) (left out 0)",
    );
    check_understood(
        "Put the apple on the sofa",
        "put(apple, sofa) & put(pillow, desk)",
        "put(apple, sofa) (left out 1)",
    );
    // Without any mention, the first goal stays.
    check_understood(
        "It is dark in here",
        "on(lamp) & put(pillow, desk)",
        "on(lamp) (left out 1)",
    );
}

#[test]
fn groups_are_understood_as_a_whole() {
    let mugs = "put(mug 1, sofa) & put(mug 2, sofa) & put(mug 3, sofa) (left out 0)";
    check_understood("Put all the mugs on the sofa", "put(all mug, sofa)", mugs);
    check_understood(
        "Put any mug on the sofa",
        "put(any mug, sofa)",
        "put(any mug, sofa) (left out 0)",
    );
    // A type is no word of the instruction.
    check_understood(
        "Put everything on the desk on the sofa except the tray",
        "put(all thing where ON(desk) except tray, sofa)",
        "put(mug 1, sofa) (left out 0)",
    );
    check_understood(
        "Put the apple on the sofa",
        "put(all mug, sofa)",
        "I am not sure what you want. Do you mean: mug 1 is at the sofa; mug 2 is at the sofa; mug 3 is at the sofa?",
    );
}

#[test]
fn a_mere_guess_is_asked_about() {
    check_understood(
        "do the thing",
        "put(apple, sofa)",
        "I am not sure what you want. Do you mean that the apple is at the sofa?",
    );
}

#[test]
fn things_that_are_not_there_are_asked_about() {
    check_understood(
        "Fetch the banana",
        "held(apple)",
        "I see no banana here. What do you mean by it?",
    );
    check_understood(
        "Put the milk on the shelf",
        "put(apple, shelf)",
        "I see no milk here. What do you mean by it?",
    );
}

#[test]
fn goals_are_read_and_written() {
    let (_, world) = flat();
    for text in [
        "put(apple, top of oven)",
        "heated(apple, oven)",
        "INSIDE(<apple_10>, <oven_4>)",
        "on(lamp)",
    ] {
        let goal = parse(&world, text).unwrap();
        let again = parse(&world, &goal.facts[0].exact(&world)).unwrap();
        assert_eq!(goal, again);
    }
    for (text, error) in [
        ("put(apple, sofa) & ", "the goal has an empty part"),
        (
            "put(aple, sofa)",
            "`aple` in `put(aple, sofa)` is nothing in the environment; did you mean `apple`?",
        ),
        ("put(sofa, desk)", "`sofa` in `put(sofa, desk)` is no item"),
    ] {
        assert_eq!(parse(&world, text).unwrap_err().to_string(), error);
    }
}

/// Compares the mentioned, excluded and rejected entities and goals after an utterance about an answer.
#[track_caller]
fn check_correction(instruction: &str, answer: &str, said: &str, expected: [&str; 3]) {
    let (_, world) = flat();
    let mut correction = Correction::of(&world, instruction);
    correction.hear(&world, answer, said);
    let names = |entities: &[EntityId]| {
        let names: Vec<_> = entities
            .iter()
            .map(|entity| world.entity(*entity).name.clone())
            .collect();
        names.join(", ")
    };
    let rejected: Vec<_> = correction.rejected.iter().map(|fact| fact.everyday(&world)).collect();
    let found = [
        names(&correction.spoken.entities),
        names(&correction.excluded),
        rejected.join(" & "),
    ];
    assert_eq!(found, expected, "{said}");
}

#[test]
fn later_words_win() {
    let (instruction, answer) = ("Put the mug on the sofa", "put(mug 1, sofa)");
    for (said, expected) in [
        ("Not that mug, mug 3", ["sofa, mug 3", "mug 1", "put(mug 1, sofa)"]),
        ("No, the other mug", ["sofa, mug 2, mug 3", "mug 1", "put(mug 1, sofa)"]),
        (
            "not the mug, the pillow",
            ["sofa, mug 2, mug 3, pillow", "mug 1", "put(mug 1, sofa)"],
        ),
        (
            "Put it on the desk instead",
            ["desk, sofa, mug 1, mug 2, mug 3", "", "put(mug 1, sofa)"],
        ),
        ("And close the oven too", ["sofa, oven, mug 1, mug 2, mug 3", "", ""]),
    ] {
        check_correction(instruction, answer, said, expected);
    }
    let said = "The one on the shelf";
    let expected = ["shelf, sofa, mug 1, mug 2, mug 3", "", ""];
    check_correction(instruction, "question: Which mug do you mean?", said, expected);
}

#[test]
fn who_throws_something_away_speaks_of_the_bins() {
    let domain = domain::shipped("household-dual").unwrap().unwrap();
    let text = r#"{"assets": ["<bench>", "<scrap_bin>", "<cabin>"], "objects": ["<rag>", "<left>", "<right>"]}"#;
    let environment = Environment::from_json(text).unwrap();
    let world = environment::read(&domain, &environment, "shed", text, &Path::default()).unwrap();
    let spoken = Spoken::of(&world, "Throw the rag away");
    let names: Vec<&str> = spoken
        .entities
        .iter()
        .map(|id| world.entity(*id).name.as_str())
        .collect();
    assert_eq!(names, ["scrap bin", "rag"]);
}

#[track_caller]
fn check_which(instruction: &str, goal: &str, expected: &str) {
    let (_, world) = flat();
    let goal = parse(&world, goal).unwrap();
    let came = match understand(&world, instruction, goal) {
        Understanding::Question(question) | Understanding::Which(question) => question,
        Understanding::Goal(goal, _) => {
            let facts = goal.facts.iter().map(|fact| fact.everyday(&world));
            facts.collect::<Vec<_>>().join(" & ")
        }
    };
    assert_eq!(came, expected, "{instruction}");
}

#[test]
fn which_of_two_is_asked_where_it_makes_a_difference() {
    let question = "Which mug do you mean: mug 1 (on the desk), or mug 2 (on the shelf), or mug 3 (on the shelf)?";
    check_which("Put the mug on the sofa", "put(mug 1, sofa)", question);
    check_which(
        "Put my old mug on the sofa",
        "put(mug 3, sofa)",
        "Which mug do you mean: mug 1 (on the desk), or mug 3 (on the shelf)?",
    );
    // No question: any mug fits, all are meant, or the instruction identifies one.
    check_which("Put a mug on the sofa", "put(mug 1, sofa)", "put(mug 1, sofa)");
    check_which("Put the mugs on the sofa", "put(mug 1, sofa)", "put(mug 1, sofa)");
    check_which(
        "Put the mug from the desk on the sofa",
        "put(mug 1, sofa)",
        "put(mug 1, sofa)",
    );
    check_which("Put mug 2 on the sofa", "put(mug 2, sofa)", "put(mug 2, sofa)");
    // No question: the other mugs are there already.
    check_which("Put the mug on the shelf", "put(mug 1, shelf)", "put(mug 1, shelf)");
    check_which("Put the apple on the sofa", "put(apple, sofa)", "put(apple, sofa)");
}

/// Compares all offers after the goals of `said` in a small household kitchen.
#[track_caller]
fn check_kitchen(instruction: &str, said: &str, expected: &[&str]) {
    let domain = domain::shipped("household").unwrap().unwrap();
    check_kitchen_in(&domain, instruction, said, expected);
}

#[track_caller]
fn check_kitchen_in(domain: &Domain, instruction: &str, said: &str, expected: &[&str]) {
    let text = r#"{"assets": ["<table>", "<fridge>", "<dusty_shelf>"],
        "objects": ["<milk>", "<brush>", "<fridge_handle>"],
        "object_states": {"<milk>": "inside_something(<fridge>)", "<brush>": "on_something(<table>)",
            "<fridge_handle>": "closed()"}}"#;
    let environment = Environment::from_json(text).unwrap();
    let world = environment::read(domain, &environment, "kitchen", text, &Path::default()).unwrap();
    let said = match said {
        "" => Goal::default(),
        said => parse(&world, said).unwrap(),
    };
    let offers = offers(&world, &said.facts, &Spoken::of(&world, instruction));
    let texts = offers.iter().flat_map(|offer| {
        let fact = |arguments: &Vec<EntityId>| {
            let (word, arguments) = (offer.word, arguments.clone());
            GoalFact::Word { word, arguments }.everyday(&world)
        };
        offer.arguments.iter().map(fact).collect::<Vec<_>>()
    });
    assert_eq!(texts.collect::<Vec<_>>(), expected, "{instruction}");
}

#[test]
fn what_a_plan_would_undo_can_be_asked_for_again() {
    let instruction = "Take the milk out, put it on the table and close the fridge again";
    let mut files = domain::shipped_files("household").unwrap();
    files.words = files.words.replace("holds = \"tidy\"", "holds = \"start\"");
    let untidy = domain::load(&files).unwrap();
    check_kitchen_in(&untidy, instruction, "put(milk, table)", &["closed(fridge)"]);
    // Plans of the shipped domain close it in any case.
    check_kitchen(instruction, "put(milk, table)", &[]);
    // No action opens it.
    check_kitchen(
        "Put the brush on the shelf and leave the fridge closed",
        "put(brush, dusty shelf)",
        &[],
    );
}

#[test]
fn a_wish_that_is_said_wins_over_one_about_the_same_things() {
    check_kitchen("Give the table a scrub with the brush", "", &["wiped(table, brush)"]);
    let after = "Scrub the shelf with the brush and put the brush in the fridge";
    check_kitchen(
        after,
        "wiped(dusty shelf, brush)",
        &["put(brush, fridge)", "put(brush, dusty shelf)"],
    );
    // A word inside a name is no cue, so both readings remain.
    let both = ["put(brush, dusty shelf)", "wiped(dusty shelf, brush)"];
    check_kitchen("Put the brush on the dusty shelf", "", &both);
}
