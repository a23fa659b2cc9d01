//! Offered goals and understood goals for instructions, as tables.

use super::*;
use crate::domain;
use crate::domain::Domain;
use crate::environment::{self, Environment};
use crate::environment::{EntityId, World};
use crate::json::Path;

fn world(domain: &Domain, text: &str) -> World {
    let environment = Environment::from_json(text).unwrap();
    environment::read(domain, &environment, "test", text, &Path::default()).unwrap()
}

fn flat() -> (Domain, World) {
    let domain = domain::shipped("virtualhome").unwrap().unwrap();
    let text = r#"{
        "assets": ["<desk_1>", "<shelf_2>", "<sofa_3>", "<oven_4>", "<tablelamp_5>"],
        "asset_properties": {"<oven_4>": ["IS_OPENABLE", "HAS_SWITCH"], "<tablelamp_5>": ["HAS_SWITCH"]},
        "objects": ["<mug_6>", "<mug_7>", "<mug_8>", "<tray_9>", "<apple_10>", "<pillow_11>"],
        "object_states": {
            "<mug_6>": ["ON(<desk_1>)"], "<mug_7>": ["ON(<shelf_2>)"], "<mug_8>": ["ON(<shelf_2>)"],
            "<tray_9>": ["ON(<desk_1>)"], "<apple_10>": ["ON(<tray_9>)"], "<pillow_11>": ["ON(<sofa_3>)"]}}"#;
    let world = world(&domain, text);
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
    let offers = offers(&world, &said.facts, &Mentions::of(&world, instruction));
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
fn names_narrow_what_is_offered() {
    check_put("Put the pillow on the shelf", "", &["put(pillow, shelf)"]);
    check_put("Put the apple on the sofa", "", &["put(apple, sofa)"]);
    // The current place of an object only identifies it.
    check_put("Take the apple from the desk to the shelf", "", &["put(apple, shelf)"]);
    check_put("Put the pillow on the tray on the desk", "", &["put(pillow, tray)"]);
    // Names are names in a sentence of any language.
    check_put("Stell den apple bitte aufs sofa", "", &["put(apple, sofa)"]);
}

#[test]
fn a_further_goal_is_about_another_named_entity() {
    check_put("Put the pillow on the shelf", "put(pillow, shelf)", &[]);
    check_put(
        "Put the pillow and the apple on the shelf",
        "put(pillow, shelf)",
        &["put(apple, shelf)"],
    );
    // If the first goal is about something that is not named, names decide nothing about the next one.
    let after = "put(tray, sofa)";
    check_put("Put the pillow on the shelf", after, &["put(pillow, shelf)"]);
}

/// Returns the goal that is understood, or the question.
fn understood(world: &World, instruction: &str, goal: &str) -> String {
    let goal = parse(world, goal).unwrap();
    match understand(world, instruction, goal) {
        Understanding::Question(question) | Understanding::Which(question) => question,
        Understanding::Doubtful(_) => unreachable!("it is asked"),
        Understanding::Goal(goal) => {
            let facts: Vec<_> = goal.facts.iter().map(|fact| fact.everyday(world)).collect();
            facts.join(" & ")
        }
    }
}

#[track_caller]
fn check_understood(instruction: &str, goal: &str, expected: &str) {
    let (_, world) = flat();
    assert_eq!(understood(&world, instruction, goal), expected, "{instruction}");
}

#[test]
fn a_goal_about_what_is_not_named_is_a_question() {
    let apple = "put(apple, sofa)";
    check_understood("Put the apple on the sofa", apple, apple);
    check_understood(
        "Put the apple on the sofa",
        "put(apple, sofa) & put(pillow, desk)",
        "I am not sure what you want. Do you mean: the apple is at the sofa; the pillow is at the desk?",
    );
    check_understood(
        "Put the milk on the shelf",
        "put(apple, shelf)",
        "I am not sure what you want. Do you mean: the apple is at the shelf?",
    );
    // Without any name nothing is known: the words may be in another language.
    check_understood("It is dark in here", "on(lamp)", "on(lamp)");
    check_understood("Il fait sombre ici", "on(lamp)", "on(lamp)");
}

#[test]
fn groups_are_understood_as_a_whole() {
    let mugs = "put(mug 1, sofa) & put(mug 2, sofa) & put(mug 3, sofa)";
    check_understood("Put all the mugs on the sofa", "put(all mug, sofa)", mugs);
    check_understood("Put any mug on the sofa", "put(any mug, sofa)", "put(any mug, sofa)");
    // A type is no name in an instruction.
    check_understood(
        "Put everything on the desk on the sofa except the tray",
        "put(all thing where ON(desk) except tray, sofa)",
        "put(mug 1, sofa)",
    );
    check_understood(
        "Put the apple on the sofa",
        "put(all mug, sofa)",
        "I am not sure what you want. Do you mean: mug 1 is at the sofa; mug 2 is at the sofa; mug 3 is at the sofa?",
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
        (
            "put(apple, top of ofen)",
            "`ofen` in `put(apple, top of ofen)` is nothing in the environment; did you mean `oven`?",
        ),
    ] {
        assert_eq!(parse(&world, text).unwrap_err().to_string(), error);
    }
}

#[test]
fn later_words_name_other_entities() {
    let (_, world) = flat();
    for (answer, words, named, rejected) in [
        ("put(mug 1, sofa)", "Not that one, mug 3", "sofa, mug 3", 1),
        (
            "put(mug 1, sofa)",
            "Lieber aufs desk",
            "desk, sofa, mug 1, mug 2, mug 3",
            1,
        ),
        (
            "question: Which mug do you mean?",
            "The one on the shelf",
            "shelf, sofa, mug 1, mug 2, mug 3",
            0,
        ),
        // What a question names is what "yes" is about.
        (
            "question: Do you mean the apple?",
            "Oui",
            "sofa, mug 1, mug 2, mug 3, apple",
            0,
        ),
    ] {
        let mut correction = Correction::of(&world, "Put the mug on the sofa");
        correction.hear(&world, answer, words);
        let entities = correction.mentions.entities.iter();
        let names: Vec<_> = entities.map(|entity| world.entity(*entity).name.clone()).collect();
        assert_eq!(
            (names.join(", ").as_str(), correction.rejected.len()),
            (named, rejected),
            "{words}"
        );
    }
}

#[test]
fn which_of_two_is_asked_where_it_makes_a_difference() {
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
fn one_thing_is_not_taken_for_all_with_its_name() {
    let household = domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<red_bowl>", "<blue_bowl>"],
        "object_states": {"<red_bowl>": "on_something(<table>)", "<blue_bowl>": "on_something(<table>)"}}"#;
    let world = world(&household, text);
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
    let household = domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<fridge>", "<shelf_from_sink_to_stove>", "<shelf_from_fridge_to_stove>"], "objects": ["<pen>"],
        "object_states": {"<pen>": "on_something(<fridge>)"}}"#;
    let world = world(&household, text);
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

/// Returns all offers after the goals of `said` in a small household kitchen.
fn offered_in_kitchen(domain: &Domain, instruction: &str, said: &str) -> Vec<String> {
    let text = r#"{"assets": ["<table>", "<fridge>", "<dusty_shelf>"],
        "objects": ["<milk>", "<brush>", "<fridge_handle>"],
        "object_states": {"<milk>": "inside_something(<fridge>)", "<brush>": "on_something(<table>)",
            "<fridge_handle>": "closed()"}}"#;
    let world = world(domain, text);
    let said = match said {
        "" => Goal::default(),
        said => parse(&world, said).unwrap(),
    };
    let offers = offers(&world, &said.facts, &Mentions::of(&world, instruction));
    let texts = offers.iter().flat_map(|offer| {
        let fact = |arguments: &Vec<EntityId>| {
            let (word, arguments) = (offer.word, arguments.clone());
            GoalFact::Word { word, arguments }.everyday(&world)
        };
        offer.arguments.iter().map(fact).collect::<Vec<_>>()
    });
    texts.collect()
}

#[test]
fn a_tool_may_lie_where_it_is_used() {
    let household = domain::shipped("household").unwrap().unwrap();
    let text = r#"{"assets": ["<table>", "<shelf>", "<bin>"], "objects": ["<cereal>", "<cloth>"],
        "object_states": {"<cereal>": "on_something(<shelf>)", "<cloth>": "on_something(<table>)"}}"#;
    let world = world(&household, text);
    let mentions = Mentions::of(&world, "Put the cereal in the bin and wipe the table with the cloth");
    let said = parse(&world, "put(cereal, bin)").unwrap();
    let wiped = parse(&world, "wiped(table, cloth)").unwrap();
    let GoalFact::Word { word, arguments } = &wiped.facts[0] else {
        panic!()
    };
    let offers = offers(&world, &said.facts, &mentions);
    let offer = offers.iter().find(|offer| offer.word == *word).unwrap();
    assert!(offer.arguments.contains(arguments), "{offer:?}");
}

#[test]
fn what_a_plan_would_undo_can_be_asked_for_again() {
    let instruction = "Take the milk out, put it on the table and close the fridge again";
    let mut files = domain::shipped_files("household").unwrap();
    files.words = files.words.replace("holds = \"tidy\"", "holds = \"start\"");
    let untidy = domain::load(&files).unwrap();
    let offered = |domain: &Domain, instruction, said| offered_in_kitchen(domain, instruction, said).join(" ");
    let closed = "closed(fridge)";
    assert!(offered(&untidy, instruction, "put(milk, table)").contains(closed));
    // Plans of the shipped domain close it in any case, and it can still be said.
    let household = domain::shipped("household").unwrap().unwrap();
    assert!(offered(&household, instruction, "put(milk, table)").contains(closed));
    // No action opens it.
    let brush = "Put the brush on the shelf and leave the fridge closed";
    assert!(!offered(&household, brush, "put(brush, dusty shelf)").contains(closed));
}

#[test]
fn no_list_of_words_decides_what_a_goal_may_be() {
    let root = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let mut sources: Vec<_> = ["goal", "dialogue"]
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
