//! Goals that depend on sensing: notation, parsing, grammar and interpretation.

use super::*;
use crate::dialogue::{ConditionMark, Constraint, ConstraintKind, Dialogue, GoalDialogue, GoalInput, Reply};
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

fn dialogue(instruction: &str, condition: ConditionMark, kind: ConstraintKind) -> GoalDialogue {
    let (domain, world) = kitchen();
    GoalDialogue::new(GoalInput {
        condition,
        ..GoalInput::new(&domain, &world, instruction, kind)
    })
}

/// Checks which texts the grammar after a partial answer contains, and which of `absent` it does not.
#[track_caller]
fn check_next(condition: ConditionMark, replies: &[&str], present: &[&str], absent: &[&str]) {
    let instruction = "If the milk is past its date, throw it away, otherwise put it in the fridge";
    let mut dialogue = dialogue(instruction, condition, ConstraintKind::Grammar);
    for text in replies {
        let reply = Reply::complete(*text);
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
            "{condition:?} {replies:?}: no {text} in {grammar}"
        );
    }
    for text in absent {
        assert!(
            !grammar.contains(text),
            "{condition:?} {replies:?}: {text} in {grammar}"
        );
    }
}

#[test]
fn a_condition_is_offered_where_the_instruction_may_have_one() {
    let put = r#""put(" ("milk" ", " ("#;
    let (fresh, expired) = (r#""if fresh(milk) then""#, r#""if expired(milk) then""#);
    let (question, end) = (r#""question: ""#, r#"(" &"){0,1}"#);
    check_next(
        ConditionMark::Present,
        &[],
        &[put, fresh, expired, question, r#"" &""#],
        &[end],
    );
    check_next(ConditionMark::Unknown, &[], &[put, fresh, expired, question, end], &[]);
    let joints = r#"(" else" | " and" | " &")){0,1}"#;
    let expired = ["if expired(milk) then"];
    check_next(ConditionMark::Present, &expired, &[put, joints], &[question, fresh]);
    let replies = ["if expired(milk) then", " put(milk, trash bin) else"];
    check_next(ConditionMark::Present, &replies, &[r#"" and""#], &[question]);
}

#[track_caller]
fn check_understood(instruction: &str, replies: &[&str], kind: ConstraintKind, expected: &str) {
    let mut dialogue = dialogue(instruction, ConditionMark::Unknown, kind);
    let (_, world) = kitchen();
    let mut understood = String::new();
    for text in replies {
        let reply = Reply::complete(*text);
        if let Some(done) = dialogue.supply(&reply).unwrap() {
            understood = match done {
                Understanding::Goal(goal) => goal.everyday(&world).join(" & "),
                Understanding::Question(question) | Understanding::Which(question) => question,
                Understanding::Doubtful(_) => unreachable!("it is asked"),
            };
        }
    }
    assert_eq!(understood, expected, "{instruction}");
}

#[test]
fn conditional_answers_are_understood() {
    let instruction = "If the milk is past its date, throw it away, otherwise put it in the fridge";
    let answer = "if expired(milk) then put(milk, trash bin) else put(milk, fridge)";
    let replies = [
        "if expired(milk) then",
        " put(milk, trash bin) else",
        " put(milk, fridge)",
    ];
    check_understood(instruction, &replies, ConstraintKind::Grammar, answer);
    let whole = format!(r#"{{"question": "", "goals": ["{answer}"]}}"#);
    check_understood(instruction, &[&whole], ConstraintKind::JsonSchema, answer);
    // A part about an entity that the instruction does not name is a question.
    check_understood(
        instruction,
        &[r#"{"question": "", "goals": ["if expired(milk) then put(milk, trash bin) else put(sponge, fridge)"]}"#],
        ConstraintKind::JsonSchema,
        "I am not sure what you want. Do you mean: if the milk is past its date, the milk is at the trash bin, and \
         otherwise the sponge is at the fridge?",
    );
}
