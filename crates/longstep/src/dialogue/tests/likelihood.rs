//! Answers that a model finds likely, and those that are a guess.

use crate::dialogue::{ConstraintKind, Dialogue, GoalDialogue, GoalInput, Likelihood, Reply, Round};
use crate::domain::shipped;
use crate::environment::{self, Environment};
use crate::goal::Understanding;
use crate::json::Path;

/// Replies with the likelihoods of their text and of an end before their joint.
type Replies<'a> = &'a [(&'a str, i64, Option<i64>)];

/// Checks what is understood from replies under a grammar: the goals, or the question.
#[track_caller]
fn check(instruction: &str, rounds: &[Round], replies: Replies<'_>, expected: &str) {
    check_with(false, instruction, rounds, replies, expected);
}

/// Checks this for a model that was trained for the task, or was not.
#[track_caller]
fn check_with(is_trained: bool, instruction: &str, rounds: &[Round], replies: Replies<'_>, expected: &str) {
    check_in("household", is_trained, instruction, rounds, replies, expected);
}

/// Checks this in a domain.
#[track_caller]
fn check_in(domain: &str, is_trained: bool, instruction: &str, rounds: &[Round], replies: Replies<'_>, expected: &str) {
    let domain = shipped(domain).unwrap().unwrap();
    let text = r#"{"assets": ["<desk>", "<shelf>", "<cupboard>"], "objects": ["<pen>", "<ruler>", "<cupboard_handle>"],
        "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<desk>)",
            "<cupboard_handle>": "closed()"}}"#;
    let environment = Environment::from_json(text).unwrap();
    let world = environment::read(&domain, &environment, "", "", &Path::default()).unwrap();
    let mut dialogue = GoalDialogue::new(GoalInput {
        rounds,
        ..GoalInput::new(&domain, &world, instruction, ConstraintKind::Grammar)
    });
    let mut understood = None;
    for (text, likelihood, ended) in replies {
        assert_eq!(understood, None, "{instruction}: the answer ended before `{text}`");
        let reply = Reply {
            likelihood: Some(Likelihood {
                text: *likelihood,
                ended: *ended,
                is_trained,
                ..Likelihood::default()
            }),
            ..Reply::complete(*text)
        };
        understood = dialogue.supply(&reply).unwrap();
    }
    let found = match understood {
        Some(Understanding::Goal(goal)) => goal.everyday(&world).join(" & "),
        Some(Understanding::Doubtful(goal)) => format!("doubtful: {}", goal.everyday(&world).join(" & ")),
        Some(Understanding::Question(question) | Understanding::Which(question)) => question,
        None => "the answer goes on".to_owned(),
    };
    assert_eq!(found, expected, "{instruction}");
}

#[test]
fn an_unlikely_answer_is_a_question() {
    let put = "put(pen, shelf)";
    check("Put the pen on the shelf", &[], &[(put, -700, None)], put);
    check(
        "Put the pen on the shelf",
        &[],
        &[
            (put, -5000, None),
            ("opened(cupboard)", -9000, None),
            ("closed(cupboard)", -9500, None),
            ("put(ruler, shelf)", -8000, None),
        ],
        "I am not sure what you want. Do you mean: the pen is at the shelf?",
    );
    check(
        "Put the pen on the shelf",
        &[],
        &[("put(ruler, shelf)", -3000, None)],
        "doubtful: put(ruler, shelf)",
    );
    // After an answer to a question, the model's next answer is taken.
    let round = Round {
        reply: "question: I am not sure what you want. Do you mean: the pen is at the shelf?".to_owned(),
        message: "yes".to_owned(),
    };
    check("Put the pen on the shelf", &[round], &[(put, -9000, None)], put);
}

#[test]
fn a_trained_model_is_asked_back_sooner() {
    let (put, instruction) = ("put(pen, shelf)", "Put the pen on the shelf");
    let unsure: Replies<'_> = &[
        (put, -2000, None),
        // Without regard to names.
        (put, -2000, None),
        ("opened(cupboard)", -9000, None),
        ("closed(cupboard)", -9500, None),
        ("put(ruler, shelf)", -8000, None),
    ];
    check_with(false, instruction, &[], &unsure[..1], put);
    check_with(true, instruction, &[], &[(put, -1400, None)], put);
    let question = "I am not sure what you want. Do you mean: the pen is at the shelf?";
    check_with(true, instruction, &[], unsure, question);
}

#[test]
fn a_condition_that_a_trained_model_finds_unlikely_is_a_question() {
    let check = |is_trained: bool, replies: Replies<'_>, expected: &str| {
        let instruction = "Put the pen on the shelf if it has expired";
        check_in("household-checks", is_trained, instruction, &[], replies, expected);
    };
    let goal = "if expired(pen) then put(pen, shelf)";
    check(true, &[(goal, -1100, None)], goal);
    check(false, &[(goal, -9000, None)], goal);
    let question = "I am not sure what you want. Do you mean: if the pen is past its date, the pen is at the shelf?";
    // Without regard to names; then without the first goal word, and in the end without the first goals.
    let (opened, closed) = (
        "if expired(pen) then opened(cupboard)",
        "if expired(pen) then closed(cupboard)",
    );
    let ruler = "if expired(pen) then put(ruler, shelf)";
    let begun = [(goal, -2100, None), (goal, -2100, None)];
    let unsure = [(opened, -3000, None), (closed, -3000, None), (ruler, -3000, None)];
    check(true, &[&begun[..], &unsure].concat(), question);
    check(
        true,
        &[&begun[..], &[(opened, -1100, None)]].concat(),
        &format!("doubtful: {opened}"),
    );
    // Without its condition, an answer is likelier, and does in every case what was asked for in one.
    let plain = [("put(ruler, shelf)", -1300, None)];
    check(true, &[&begun[..], &plain].concat(), question);
}

#[test]
fn a_guess_gives_way_to_a_likelier_answer() {
    let (guess, opened) = (("put(pen, shelf)", -5000, None), "opened(cupboard)");
    let ruler = "put(ruler, shelf)";
    check("Leg das weg", &[], &[guess, (opened, -1500, None)], opened);
    // The last answer may begin with the goal word of the first one again.
    let closed = ("closed(cupboard)", -6000, None);
    check(
        "Leg das weg",
        &[],
        &[guess, (opened, -4000, None), closed, (ruler, -1500, None)],
        ruler,
    );
    check(
        "Leg das weg",
        &[],
        &[guess, (opened, -4000, None), closed, (ruler, -4500, None)],
        "I am not sure what you want. Do you mean: the cupboard is open?",
    );
}

#[test]
fn what_is_so_already_is_said_only_if_it_is_much_likelier() {
    let (closed, opened) = (("closed(cupboard)", -100, None), "opened(cupboard)");
    check(
        "Shut the cupboard",
        &[],
        &[closed, (opened, -3300, None)],
        "closed(cupboard)",
    );
    let asks = ("question: I see no cupboard here.", -40_000, None);
    check("Shut the cupboard", &[], &[closed, asks], "closed(cupboard)");
    check(
        "Shut the cupboard",
        &[],
        &[("closed(cupboard)", -3000, None), (opened, -2900, None)],
        opened,
    );
}

#[test]
fn an_answer_ends_before_an_unlikely_goal() {
    let first = ("put(pen, shelf) &", -400, Some(-900));
    check(
        "Put the pen and the ruler on the shelf",
        &[],
        &[first, (" put(ruler, shelf)", -3000, None)],
        "put(pen, shelf)",
    );
    check(
        "Put the pen and the ruler on the shelf",
        &[],
        &[first, (" put(ruler, shelf)", -300, None)],
        "put(pen, shelf) & put(ruler, shelf)",
    );
}

/// Names are English here, so nothing in these texts names an entity.
#[test]
fn rules_about_english_words_do_not_judge_other_languages() {
    let put = "put(pen, shelf)";
    for instruction in [
        "Leg den Stift ins Regal",
        "Mets le stylo à la place de la règle",
        "Pon el bolígrafo en la estantería",
        "ペンを棚に置いて",
    ] {
        check(instruction, &[], &[(put, -900, None)], put);
    }
}
