//! Judgements of replies, in the flat of the examples.

use std::sync::Arc;

use longstep::domain;
use longstep::session::{RepairPolicy, Settings, Strategy};
use serde_json::{Value, json};

use crate::attempt::Attempt;
use crate::run::{Unit, run};
use crate::suite::{self, Files, PLAIN};
use crate::{Recorded, Source};

const FLAT: &str = include_str!("../../../examples/environments/flat.json");

/// The attempt for a model's reply to an instruction with this expectation.
fn attempt(strategy: Strategy, says: &str, expected: &str, reply: &Value) -> Attempt {
    let domain = Arc::new(domain::shipped("virtualhome").unwrap().unwrap());
    let files = Files {
        suite: "name = 'flat'\nabout = 'A flat.'\ndomain = 'virtualhome'".to_owned(),
        cases: [(
            "cases.toml".to_owned(),
            format!("[[case]]\nid = 'one'\nscene = 'flat'\nsays = \"{says}\"\n{expected}"),
        )]
        .into(),
        scenes: [("flat".to_owned(), FLAT.to_owned())].into(),
        ..Files::default()
    };
    let suite = suite::load(&files, &domain).unwrap_or_else(|faults| panic!("{faults}"));
    let replies = json!([{"case": "one", "reply": reply}]).to_string();
    let mut recorded = Recorded::read(&replies).unwrap();
    let settings = Settings::default()
        .with_strategy(strategy)
        .with_repair(RepairPolicy::First)
        .with_rounds(0);
    let unit = Unit {
        case: &suite.cases[0],
        wording: PLAIN,
        trial: 1,
    };
    let model = recorded.model("one", 1).unwrap();
    let mut lines = run(
        &suite,
        &domain,
        unit,
        settings,
        model,
        &mut |_: longstep_llm::Progress| {},
    )
    .unwrap();
    lines.remove(0).0
}

fn kinds(attempt: &Attempt) -> Vec<&'static str> {
    attempt.failures.iter().map(|failure| failure.name()).collect()
}

/// Checks the judgement of a plan for "put the mug on the sofa".
#[track_caller]
fn check_plan(calls: &[&str], correct: bool, failures: &[&str], why: &[&str]) {
    let reply = json!({"task_cohesion": {"task_sequence": calls, "step_instructions": vec![""; calls.len()]}});
    let attempt = attempt(
        Strategy::Direct,
        "Put the mug on the sofa.",
        "goal = 'put(mug, sofa)'",
        &reply,
    );
    assert_eq!(
        (attempt.correct, kinds(&attempt)),
        (correct, failures.to_vec()),
        "{attempt:#?}"
    );
    assert_eq!(attempt.why, why);
}

const WALK: &str = "Walktowards(<coffeetable_3>)";
const GRAB: &str = "Grab(<mug_8>)";
const GO: &str = "Walktowards(<sofa_2>)";
const PUT: &str = "Put(<mug_8>, <sofa_2>)";

#[test]
fn plans_are_compared_with_their_repair() {
    check_plan(&[WALK, GRAB, GO, PUT], true, &[], &[]);
    check_plan(
        &[WALK, GRAB, GO, "PutIn(<mug_8>, <sofa_2>)"],
        true,
        &["wrong verb"],
        &[],
    );
    check_plan(&[WALK, GRAB, PUT], true, &["left-out step"], &[]);
    check_plan(
        &[WALK, GRAB, GO, "Put(<mug_9>, <sofa_2>)"],
        false,
        &["unknown name"],
        &["the plan is not valid"],
    );
    // Without a claim the purpose of the extra steps is unknown, so only the comparison with the goal shows them.
    check_plan(
        &[WALK, "Grab(<magazine_11>)", GO, "Put(<magazine_11>, <sofa_2>)"],
        false,
        &["missing goal", "extra goal"],
        &[
            "at the end, this is not reached: the mug is at the sofa",
            "the plan changes the magazine, which the instruction does not mention",
        ],
    );
    check_plan(
        &[
            WALK,
            GRAB,
            GO,
            PUT,
            "Walktowards(<tablelamp_4>)",
            "SwitchOn(<tablelamp_4>)",
        ],
        false,
        &["extra goal"],
        &["the plan changes the lamp, which the instruction does not mention"],
    );
}

/// Checks the judgement of a model's goals.
#[track_caller]
fn check_goals(says: &str, expected: &str, goals: &[&str], correct: bool, failures: &[&str]) {
    let reply = json!({"goal": goals.join(" & "), "left_out": [], "question": ""});
    let attempt = attempt(Strategy::Goal, says, expected, &reply);
    assert_eq!(
        (attempt.correct, kinds(&attempt)),
        (correct, failures.to_vec()),
        "{attempt:#?}"
    );
}

#[test]
fn goals_are_compared_with_the_nearest_that_is_expected() {
    let both = "Put the mug and the magazine on the sofa.";
    let expected = "goal = 'put(mug, sofa) & put(magazine, sofa)'";
    check_goals(both, expected, &["put(mug, sofa)", "put(magazine, sofa)"], true, &[]);
    check_goals(both, expected, &["put(mug, sofa)"], false, &["missing goal"]);
    check_goals(
        both,
        expected,
        &["put(mug, sofa)", "put(magazine, nightstand)"],
        false,
        &["wrong object"],
    );
    check_goals(
        both,
        expected,
        &["put(mug, sofa)", "held(magazine)"],
        false,
        &["wrong goal word"],
    );
    let one_of = "goal = ['put(mug, sofa)', 'put(mug, nightstand)']";
    check_goals("Put the mug away.", one_of, &["put(mug, nightstand)"], true, &[]);
    // To heat the cupcake, the cabinet is opened and closed again: the goal includes that.
    check_goals(
        "Warm up the cupcake in the oven.",
        "goal = 'heated(cupcake, oven)'",
        &["heated(cupcake, oven)"],
        true,
        &[],
    );
}

#[test]
fn questions_are_correct_only_where_they_are_expected() {
    let asks = json!({"goal": "", "left_out": [], "question": "Which one?"});
    let questioned = attempt(
        Strategy::Goal,
        "Put the mug on the sofa.",
        "goal = 'put(mug, sofa)'",
        &asks,
    );
    assert_eq!(
        (questioned.correct, kinds(&questioned)),
        (false, vec!["asked needlessly"])
    );
    let questioned = attempt(
        Strategy::Goal,
        "Put the vase on the sofa.",
        "expect = 'question'",
        &asks,
    );
    assert_eq!(
        (questioned.correct, questioned.question.as_str(), kinds(&questioned)),
        (true, "Which one?", vec![])
    );
    let refused = attempt(Strategy::Goal, "Put the vase on the sofa.", "expect = 'refusal'", &asks);
    assert_eq!((refused.correct, kinds(&refused)), (false, vec!["did not ask"]));
    let planned = attempt(
        Strategy::Goal,
        "Put the mug on the sofa.",
        "expect = 'either'",
        &json!({"goal": "put(mug, sofa)", "left_out": [], "question": ""}),
    );
    assert_eq!((planned.correct, kinds(&planned)), (false, vec!["did not ask"]));
    let nonsense = attempt(
        Strategy::Goal,
        "Put the mug on the sofa.",
        "goal = 'put(mug, sofa)'",
        &json!("no"),
    );
    assert_eq!((nonsense.correct, kinds(&nonsense)), (false, vec!["unusable reply"]));
}

#[test]
fn inaction_is_correct_where_nothing_is_expected() {
    let attempt = |goals: &[&str], question: &str| {
        let reply = json!({"goal": goals.join(" & "), "left_out": [], "question": question});
        attempt(Strategy::Goal, "The tablelamp stays off.", "expect = 'nothing'", &reply)
    };
    for (goals, question, why) in [
        (&["off(tablelamp)"][..], "", None),
        (&[], "Which lamp?", None),
        (
            &["on(tablelamp)"],
            "",
            Some("it did something, and there was nothing to do"),
        ),
    ] {
        let judged = attempt(goals, question);
        assert_eq!(
            (judged.correct, judged.why.first().map(String::as_str)),
            (why.is_none(), why),
            "{goals:?}"
        );
    }
}

#[test]
fn an_expected_order_and_an_expected_prohibition_are_judged() {
    let mug = [WALK, GRAB, GO, PUT];
    let magazine = [WALK, "Grab(<magazine_11>)", GO, "Put(<magazine_11>, <sofa_2>)"];
    for (goal, steps, why) in [
        ("put(mug, sofa) then put(magazine, sofa)", [mug, magazine], None),
        (
            "put(mug, sofa) then put(magazine, sofa)",
            [magazine, mug],
            Some("the plan does not achieve this after what comes before it: the magazine is at the sofa"),
        ),
        (
            "put(mug, sofa) & put(magazine, sofa) & never Grab(magazine)",
            [mug, magazine],
            Some("is forbidden by `never Grab(<magazine_11>)`"),
        ),
    ] {
        let calls = steps.concat();
        let reply = json!({"task_cohesion": {"task_sequence": calls, "step_instructions": vec![""; calls.len()]}});
        let attempt = attempt(
            Strategy::Direct,
            "Put the mug and the magazine on the sofa.",
            &format!("goal = '{goal}'"),
            &reply,
        );
        assert_eq!(attempt.correct, why.is_none(), "{goal}: {:?}", attempt.why);
        let found = attempt.why.join("; ");
        assert!(found.contains(why.unwrap_or_default()), "{goal}: {found}");
    }
}
