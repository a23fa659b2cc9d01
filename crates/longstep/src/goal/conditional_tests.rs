//! Goals that depend on sensing: notation, parsing, grammar and interpretation.

use super::*;
use crate::dialogue::{Constraint, ConstraintKind, Dialogue, Finish, GoalDialogue, GoalInput, Reply, Usage};
use crate::domain;
use crate::domain::Domain;
use crate::environment::World;
use crate::environment::{self, Environment};
use crate::json::Path;

fn kitchen() -> (Domain, World) {
    let domain = domain::shipped("household-checks").unwrap().unwrap();
    let text = r#"{"assets": ["<table>", "<fridge>", "<trash_bin>"], "objects": ["<milk>", "<sponge>", "<fridge_handle>"],
        "object_states": {"<milk>": ["on_something(<table>)"], "<sponge>": ["on_something(<table>)"],
        "<fridge_handle>": ["closed()"]}}"#;
    let environment = Environment::from_json(text).unwrap();
    let world = environment::read(&domain, &environment, "", text, &Path::default()).unwrap();
    (domain, world)
}

/// Compares a parsed goal, written for the model and as a sentence, or the parse error.
#[track_caller]
fn check(text: &str, written: &str, sentence: &str) {
    let (_, world) = kitchen();
    match parse(&world, text) {
        Ok(goal) => {
            let everyday: Vec<String> = goal.facts.iter().map(|fact| fact.everyday(&world)).collect();
            let sentences: Vec<String> = goal.facts.iter().map(|fact| fact.sentence(&world)).collect();
            assert_eq!(
                (everyday.join(" & ").as_str(), sentences.join("; ").as_str()),
                (written, sentence),
                "{text}"
            );
            let exact: Vec<String> = goal.facts.iter().map(|fact| fact.exact(&world)).collect();
            assert_eq!(parse(&world, &exact.join(" & ")), Ok(goal), "{text}");
        }
        Err(error) => assert_eq!((written, error.to_string().as_str()), ("", sentence), "{text}"),
    }
}

#[test]
fn conditional_goals_are_read_and_written() {
    let both = "if expired(milk) then put(milk, trash bin) else put(milk, fridge)";
    check(
        both,
        both,
        "if the milk is past its date, the milk is at the trash bin, and otherwise the milk is at the fridge",
    );
    let beside =
        "closed(fridge) & if dirty(table) then wiped(table, sponge) and put(sponge, fridge) & put(milk, table)";
    check(
        beside,
        beside,
        "the fridge is closed; if the table is dirty, the table has been wiped with the sponge and the sponge is at the \
         fridge; the milk is at the table",
    );
    // With two outcomes, the negation of one is the other.
    check(
        "if not expired(<milk>) then put(milk, fridge)",
        "if fresh(milk) then put(milk, fridge)",
        "if the milk is not past its date, the milk is at the fridge",
    );
    check(
        "if not empty(milk) then put(milk, fridge)",
        "if not empty(milk) then put(milk, fridge)",
        "unless the milk is empty, the milk is at the fridge",
    );
    check(
        "if open(fridge) then put(milk, fridge)",
        "",
        "`open(fridge)` is nothing that sensing tells here, so no goal can depend on it; write `fresh(...)`, \
         `expired(...)`, `empty(...)`, `half_full(...)`, `full(...)`, `intact(...)`, `broken(...)`, `clean(...)`, \
         `dirty(...)`",
    );
    check(
        "if expired(milk) then",
        "",
        "`if expired(milk) then` is not a goal of this domain; write `put(ITEM, PLACE)`, `opened(THING)`, `closed(THING)`, `adjusted(THING)`, `wiped(PLACE, TOOL)`",
    );
    check(
        "if expired(milk) then  else put(milk, fridge)",
        "",
        "the goal has an empty part",
    );
}

fn reply(text: &str) -> Reply {
    Reply {
        text: text.to_owned(),
        finish: Finish::Stop,
        usage: Usage::default(),
        likelihood: None,
    }
}

/// Checks which texts the grammar after a partial answer contains, and which of `absent` it does not.
#[track_caller]
fn check_next(instruction: &str, replies: &[&str], present: &[&str], absent: &[&str]) {
    let (domain, world) = kitchen();
    let mut dialogue = GoalDialogue::new(GoalInput::new(&domain, &world, instruction, ConstraintKind::Grammar));
    for text in replies {
        let reply = reply(text);
        assert_eq!(dialogue.supply(&reply), Ok(None), "{text}");
    }
    let Constraint::Lark(grammar) = dialogue.request().constraint else {
        panic!("no grammar");
    };
    let grammar: Vec<&str> = grammar.split_whitespace().collect();
    let grammar = grammar.join(" ");
    for text in present {
        assert!(
            grammar.contains(text),
            "{instruction} {replies:?}: no {text} in {grammar}"
        );
    }
    for text in absent {
        assert!(
            !grammar.contains(text),
            "{instruction} {replies:?}: {text} in {grammar}"
        );
    }
}

#[test]
fn a_condition_is_offered_where_the_instruction_has_one() {
    let instruction = "If the milk is past its date, throw it away, otherwise put it in the fridge";
    let put = r#""put(" ("milk" ", " (("fridge" | "trash bin") ")"))"#;
    let (fresh, expired) = (r#""if fresh(milk) then""#, r#""if expired(milk) then""#);
    let question = r#""question: ""#;
    check_next(
        instruction,
        &[],
        &[put, fresh, expired, question, r#"" &""#],
        &[r#"(" &"){0,1}"#],
    );
    let joints = r#"(" else" | " and")){0,1}"#;
    check_next(
        instruction,
        &["if expired(milk) then"],
        &[put, joints],
        &[question, fresh],
    );
    let otherwise = r#""put(" ("milk" ", " ("fridge" ")"))"#;
    let replies = ["if expired(milk) then", " put(milk, trash bin) else"];
    check_next(instruction, &replies, &[otherwise, r#"" and""#], &[question]);
    // Without "if", no goal depends on a condition.
    let plain = "Put the milk into the fridge";
    check_next(plain, &[], &[otherwise, question, r#"(" &"){0,1}"#], &[fresh, expired]);
    // No sensing action decides this condition, so only a question is possible.
    check_next(
        "If the milk is cold, put it into the fridge",
        &[],
        &[question],
        &["put("],
    );
}

#[track_caller]
fn check_understood(instruction: &str, replies: &[&str], kind: ConstraintKind, expected: &str) {
    let (domain, world) = kitchen();
    let mut dialogue = GoalDialogue::new(GoalInput::new(&domain, &world, instruction, kind));
    let mut understood = String::new();
    for text in replies {
        let reply = reply(text);
        if let Some(done) = dialogue.supply(&reply).unwrap() {
            understood = match done {
                Understanding::Goal(goal, left_out) => {
                    let all = goal.facts.iter().chain(left_out.iter().map(|left| &left.fact));
                    let texts: Vec<String> = all.map(|fact| fact.everyday(&world)).collect();
                    format!("{} ({} left out)", texts.join(" & "), left_out.len())
                }
                Understanding::Question(question) | Understanding::Which(question) => question,
            };
        }
    }
    assert_eq!(understood, expected, "{instruction}");
}

#[test]
fn conditional_answers_are_understood() {
    let instruction = "If the milk is past its date, throw it away, otherwise put it in the fridge";
    let answer = "if expired(milk) then put(milk, trash bin) else put(milk, fridge)";
    check_understood(
        instruction,
        &[
            "if expired(milk) then",
            " put(milk, trash bin) else",
            " put(milk, fridge)",
        ],
        ConstraintKind::Grammar,
        &format!("{answer} (0 left out)"),
    );
    check_understood(
        instruction,
        &[&format!(r#"{{"question": "", "goals": ["{answer}"]}}"#)],
        ConstraintKind::JsonSchema,
        &format!("{answer} (0 left out)"),
    );
    // An unmentioned goal is dropped, the others stay.
    check_understood(
        instruction,
        &[r#"{"question": "", "goals": ["if expired(milk) then put(milk, trash bin) else put(sponge, fridge)"]}"#],
        ConstraintKind::JsonSchema,
        "if expired(milk) then put(milk, trash bin) & put(sponge, fridge) (1 left out)",
    );
    check_understood(
        "If the milk is cold, put it into the fridge",
        &[r#"{"question": "", "goals": ["put(milk, fridge)"]}"#],
        ConstraintKind::JsonSchema,
        "I cannot find out whether that is so. What should I do in any case?",
    );
}

#[test]
fn a_model_that_does_not_see_what_is_there_is_asked_again() {
    let (domain, world) = kitchen();
    let said = |instruction: &str, question: &str| {
        let mut dialogue = GoalDialogue::new(GoalInput::new(&domain, &world, instruction, ConstraintKind::Grammar));
        let reply = reply(&format!("question: {question}"));
        match dialogue.supply(&reply).unwrap() {
            None => match dialogue.request().constraint {
                Constraint::Lark(grammar) if !grammar.contains("question") => "a goal".to_owned(),
                other => format!("{other:?}"),
            },
            Some(Understanding::Question(question) | Understanding::Which(question)) => question,
            Some(other) => format!("{other:?}"),
        }
    };
    let carton = "I see no milk carton here, which thing do you mean?";
    assert_eq!(said("Would you pass me the milk carton?", carton), "a goal");
    let banana = "I see no banana here. What do you mean by it?";
    assert_eq!(said("Put the banana on the table", banana), banana);
    let other = "What should I do with the milk?";
    assert_eq!(said("The milk carton!", other), other);
}
