//! Goals, and references that several things fit, as tables.

use super::*;
use crate::domain::{self, Domain};
use crate::environment::World;
use crate::goal::*;
use longstep_core::testing;

fn flat() -> (Domain, World) {
    let domain = domain::shipped("virtualhome").unwrap().unwrap();
    let text = r#"{
        "assets": ["<desk_1>", "<shelf_2>", "<sofa_3>", "<oven_4>", "<tablelamp_5>"],
        "asset_properties": {"<oven_4>": ["IS_OPENABLE", "HAS_SWITCH"], "<tablelamp_5>": ["HAS_SWITCH"]},
        "objects": ["<mug_6>", "<mug_7>", "<mug_8>", "<tray_9>", "<apple_10>", "<pillow_11>"],
        "object_states": {
            "<mug_6>": ["ON(<desk_1>)"], "<mug_7>": ["ON(<shelf_2>)"], "<mug_8>": ["ON(<shelf_2>)"],
            "<tray_9>": ["ON(<desk_1>)"], "<apple_10>": ["ON(<tray_9>)"], "<pillow_11>": ["ON(<sofa_3>)"]}}"#;
    let world = testing::world_of(&domain, text);
    (domain, world)
}

/// Returns the question which one is meant, or the goal.
fn understood(world: &World, instruction: &str, goal: &str) -> String {
    let goal = parse(world, goal).unwrap();
    which(world, &Mentions::of(world, instruction), &goal).unwrap_or_else(|| goal.everyday(world).join(" & "))
}

#[track_caller]
fn check_understood(instruction: &str, goal: &str, expected: &str) {
    let (_, world) = flat();
    assert_eq!(understood(&world, instruction, goal), expected, "{instruction}");
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
        (
            "put(apple, top of ofen)",
            "`ofen` in `put(apple, top of ofen)` is nothing in the environment; did you mean `oven`?",
        ),
    ] {
        assert_eq!(parse(&world, text).unwrap_err().to_string(), error);
    }
}

#[test]
fn goal_asks_which_entity_if_the_choice_matters() {
    let question = "Which mug do you mean: mug 1 (on the desk), or mug 2 (on the shelf), or mug 3 (on the shelf)?";
    check_understood("Put the mug on the sofa", "put(mug 1, sofa)", question);
    check_understood(
        "Put my old mug on the sofa",
        "put(mug 3, sofa)",
        "Which mug do you mean: mug 1 (on the desk), or mug 3 (on the shelf)?",
    );
    // No question: any mug fits, all are meant, or the instruction identifies one.
    check_understood("Put a mug on the sofa", "put(mug 1, sofa)", "put(mug 1, sofa)");
    check_understood("Put the mugs on the sofa", "put(mug 1, sofa)", "put(mug 1, sofa)");
    check_understood(
        "Put the mug from the desk on the sofa",
        "put(mug 1, sofa)",
        "put(mug 1, sofa)",
    );
    check_understood("Put mug 2 on the sofa", "put(mug 2, sofa)", "put(mug 2, sofa)");
    // No question: the other mugs are there already.
    check_understood("Put the mug on the shelf", "put(mug 1, shelf)", "put(mug 1, shelf)");
    check_understood("Put the apple on the sofa", "put(apple, sofa)", "put(apple, sofa)");
}

#[test]
fn goal_for_one_object_does_not_take_all_of_its_name() {
    let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<red_bowl>", "<blue_bowl>"],
        "object_states": {"<red_bowl>": "on_something(<table>)", "<blue_bowl>": "on_something(<table>)"}}"#;
    let world = testing::world("household", text);
    let both = "put(red bowl, shelf) & put(blue bowl, shelf)";
    let which = "Which bowl do you mean: red bowl, or blue bowl?";
    for (instruction, goal, expected) in [
        ("Put the bowl on the shelf", both, which),
        ("Put the bowl on the shelf", "put(blue bowl, shelf)", which),
        ("Put a bowl on the shelf, any of them", both, which),
        (
            "Put a bowl on the shelf",
            "put(blue bowl, shelf)",
            "put(blue bowl, shelf)",
        ),
        ("Put the bowls on the shelf", both, both),
        ("Put both of them on the shelf, bowl by bowl", both, both),
        ("Put the red bowl and the blue bowl on the shelf", both, both),
        (
            "Put the blue bowl on the shelf",
            "put(blue bowl, shelf)",
            "put(blue bowl, shelf)",
        ),
    ] {
        assert_eq!(understood(&world, instruction, goal), expected, "{instruction}");
    }
}

#[test]
fn a_long_name_may_be_said_with_articles() {
    let text = r#"{"assets": ["<fridge>", "<shelf_from_sink_to_stove>", "<shelf_from_fridge_to_stove>"], "objects": ["<pen>"],
        "object_states": {"<pen>": "on_something(<fridge>)"}}"#;
    let world = testing::world("household", text);
    let (goal, which) = (
        "put(pen, shelf from sink to stove)",
        "Which stove do you mean: shelf from sink to stove, or shelf from fridge to stove?",
    );
    for (instruction, expected) in [
        (
            "Take the pen off the fridge and put it on the shelf from the sink to the stove",
            goal,
        ),
        (
            "Take the pen off the fridge and put it on the shelf from sink to stove",
            goal,
        ),
        (
            "Take the pen off the fridge and put it on the shelf to the stove, not from the sink",
            which,
        ),
    ] {
        assert_eq!(understood(&world, instruction, goal), expected, "{instruction}");
    }
}

#[test]
fn goal_and_dialogue_sources_contain_no_word_lists() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut sources: Vec<_> = ["instruction", "dialogue"]
        .into_iter()
        .flat_map(|folder| std::fs::read_dir(root.join(folder)).unwrap())
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "rs"))
        .filter(|path| !path.ends_with("tests.rs") && !path.ends_with("query.rs"))
        .collect();
    sources.sort();
    assert!(sources.len() > 20);
    for source in sources {
        let text = std::fs::read_to_string(&source).unwrap();
        let code = text.split("#[cfg(test)]").next().unwrap();
        assert_eq!(word_list(code), None, "{}", source.display());
    }
    for (code, list) in [
        ("const A: &str = \"a an any\";", Some("a an any")),
        (
            "const B: [&str; 2] = [\"it\", \"them\", \"these\"];",
            Some("it them these"),
        ),
        ("const WISH: &str = \"wish\";", None),
    ] {
        assert_eq!(word_list(code).as_deref(), list, "{code}");
    }
}

/// Returns the words of the first constant that is a list of three or more lower-case words.
fn word_list(code: &str) -> Option<String> {
    code.split("const ").skip(1).find_map(|constant| {
        let (_, value) = constant.split_once(" = ")?;
        let value = value.split(";\n").next().unwrap_or_default();
        let quoted: Vec<&str> = value.split('"').skip(1).step_by(2).collect();
        let words: Vec<&str> = quoted.iter().flat_map(|text| text.split_whitespace()).collect();
        let is_word = |word: &&str| word.chars().all(|letter| letter.is_ascii_lowercase());
        (words.len() > 2 && words.iter().all(is_word)).then(|| words.join(" "))
    })
}
