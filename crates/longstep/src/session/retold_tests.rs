//! Instructions that are retold in plain English, and what they forbid, with fixed replies.

use super::coverage_tests::{check_log, play, question, session};
use super::tests::reply;
use super::{Response, Session, Settings};
use crate::dialogue::{Constraint, ConstraintKind, EstimatedTokens, Likelihood, ReadingOf, Reply};

const SAID: &str = "El boli, al estante.";
const DOUBT: &str = "question: I see no boli here, which pen do you mean?";
/// A guess: no try at an answer is likely.
const GUESS: [(&str, i64); 4] = [
    ("put(ruler, shelf)", -9000),
    ("opened(cupboard)", -9500),
    ("closed(cupboard)", -9600),
    ("put(pen, shelf)", -9500),
];
/// The three likeliest of them are weighed, and none is likely.
const WEIGHED_LOW: [(&str, i64); 3] = [
    ("put(ruler, shelf)", -6000),
    ("opened(cupboard)", -9000),
    ("put(pen, shelf)", -9000),
];
const RETOLD: &str = "Put the pen on the shelf.";

fn grammar(settings: Settings) -> Session {
    session(ConstraintKind::Grammar, settings)
}

/// A reply with its likelihood, of a model that was trained for the task or was not.
pub(super) fn likely(text: &str, likelihood: i64, is_trained: bool) -> Reply {
    let likelihood = Some(Likelihood {
        text: likelihood,
        is_trained,
        ..Likelihood::default()
    });
    Reply {
        likelihood,
        ..reply(text)
    }
}

/// Gives a reply with its likelihood; returns the last user message of its request.
fn give(session: &mut Session, (text, likelihood): (&str, i64)) -> String {
    let prepared = session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    session.supply(&likely(text, likelihood, false), 1.0).unwrap();
    prepared.request.messages.last().unwrap().text.clone()
}

/// Gives an instruction and the replies to it, each with its likelihood; returns the last user message of each request.
fn play_weighed(session: &mut Session, instruction: &str, replies: &[(&str, i64)]) -> Vec<String> {
    session.instruct(instruction).unwrap();
    let mut requests = Vec::new();
    for reply in replies {
        requests.push(give(session, *reply));
    }
    assert!(!session.wants_model(), "{instruction}: {requests:?}");
    requests
}

/// Returns what a session says in the end: its goals, its question, or that it is stuck.
pub(super) fn end(session: &Session) -> String {
    match session.response() {
        Response::Plan(proposal) => proposal.answer.goal.join(" & "),
        other => other.to_string(),
    }
}

#[test]
fn a_question_is_asked_only_if_the_retold_instruction_leaves_one() {
    const ASKED: &str = "I see no boli here, which pen do you mean?";
    let plan = "put(<pen>, <shelf>)";
    // The replies to the instruction and its retelling, and what the person sees in the end.
    type Case<'a> = (&'a [(&'a str, i64)], &'a str);
    let cases: [Case<'_>; 10] = [
        (
            &[
                ("wish", -1),
                (DOUBT, -9),
                (RETOLD, -2000),
                ("wish", -1),
                ("put(pen, shelf)", -500),
            ],
            plan,
        ),
        // A guess, too, is a question.
        (
            &[
                &[("wish", -1)],
                &GUESS[..],
                &[(RETOLD, -2000), ("wish", -1), ("put(pen, shelf)", -500)],
            ]
            .concat(),
            plan,
        ),
        (&[("wish", -1), (DOUBT, -9), (RETOLD, -11_000)], ASKED),
        (&[("wish", -1), (DOUBT, -9), ("El boli... al estante", -10)], ASKED),
        (
            &[
                &[("wish", -1), (DOUBT, -9), (RETOLD, -2000), ("wish", -1)],
                &GUESS[..],
                &WEIGHED_LOW,
                &WEIGHED_LOW,
            ]
            .concat(),
            ASKED,
        ),
        (&[("wish", -1), (DOUBT, -9), (RETOLD, -2000), ("no mark", -1)], ASKED),
        // The retelling forgets what the instruction forbids.
        (
            &[
                ("wish & forbids: al estante", -1),
                ("do: Put the pen on the shelf.", -3000),
                ("put(pen, shelf)", -500),
                (RETOLD, -2000),
                ("wish", -1),
                ("put(pen, shelf)", -500),
            ],
            "I cannot represent \"al estante\"; the plan ignores it. Go on?",
        ),
        // The retelling loses a part that was told from the rest of the wish.
        (
            &[
                ("wish & says: al estante", -1),
                ("nobody is told anything", -900),
                ("tells: al estante", -1399),
                ("put(pen, shelf)", -500),
                (RETOLD, -2000),
                ("wish", -1),
                ("put(pen, shelf)", -500),
            ],
            "I cannot represent \"al estante\"; the plan ignores it. Go on?",
        ),
        // Asked about messages alone, the model finds none.
        (
            &[
                ("wish & says: al estante", -1),
                ("nobody is told anything", -900),
                ("tells: al estante", -1400),
                ("put(pen, shelf)", -500),
            ],
            plan,
        ),
        // An order that nothing keeps is told, and no reason to ask.
        (&[("wish & order: al estante", -1), ("put(pen, shelf)", -500)], plan),
    ];
    for (replies, expected) in cases {
        let mut session = grammar(Settings::default());
        let requests = play_weighed(&mut session, SAID, replies);
        assert_eq!(end(&session), expected, "{replies:?}");
        let mut retold = requests.iter().filter(|request| request.starts_with("Things: "));
        assert!(retold.all(|request| request.ends_with(SAID)), "{requests:?}");
        let events = session.take_events();
        check_log(&mut session, &events);
    }
}

#[test]
fn an_answer_is_taken_that_is_likely_for_both_wordings_and_ahead_of_the_others() {
    const RULER: &str = "I am not sure what you want. Do you mean: the ruler is at the shelf?";
    // The question is about the likeliest answer.
    const PEN: &str = "I am not sure what you want. Do you mean: the pen is at the shelf?";
    // The likelihoods of the retelling and its goal; those of the answers for the instruction and the retelling; and what the
    // person sees in the end.
    type Case<'a> = (i64, i64, [i64; 4], [i64; 4], &'a str);
    let cases: [Case<'_>; 7] = [
        // Only a retelling that the model is not sure of leads to the answer.
        (
            -6000,
            -500,
            [-9000, -9000, -9000, -3000],
            [-9000, -9000, -9000, -1001],
            PEN,
        ),
        (
            -6000,
            -500,
            [-9000, -9000, -9000, -3000],
            [-9000, -9000, -9000, -1000],
            "put(<pen>, <shelf>)",
        ),
        (
            -6000,
            -500,
            [-9000, -9000, -9000, -3000],
            [-9000, -9000, -9000, -5500],
            PEN,
        ),
        (
            -6000,
            -500,
            [-3000, -9000, -9000, -3500],
            [-2000, -9000, -9000, -1000],
            PEN,
        ),
        // The retelling may have made up what it names.
        (
            -2000,
            -3000,
            [-9000, -9000, -9000, -3000],
            [-9000, -9000, -9000, -1000],
            "put(<pen>, <shelf>)",
        ),
        // The retelling names the pen, and no part of the goal is about it.
        (
            -2000,
            -3000,
            [-3000, -9000, -9000, -9000],
            [-2000, -9000, -9000, -3000],
            RULER,
        ),
        (
            -2000,
            -3000,
            [-3000, -9000, -9000, -9000],
            [-7000, -9000, -9000, -1000],
            RULER,
        ),
    ];
    for (sure, goal, said, retold, expected) in cases {
        let weighed = |likelihoods: [i64; 4]| {
            let texts = [
                "put(ruler, shelf)",
                "opened(cupboard)",
                "closed(cupboard)",
                "put(pen, shelf)",
            ];
            texts.into_iter().zip(likelihoods).collect::<Vec<_>>()
        };
        let replies = [
            &[("wish", -1)],
            &GUESS[..3],
            &[
                ("opened(cupboard)", -9600),
                (RETOLD, sure),
                ("wish", -1),
                ("put(pen, shelf)", goal),
            ],
            &weighed(said),
            &weighed(retold),
        ];
        let mut session = grammar(Settings::default());
        play_weighed(&mut session, SAID, &replies.concat());
        assert_eq!(end(&session), expected, "{replies:?}");
        let last = session
            .readings()
            .iter()
            .rev()
            .find(|own| own.of == ReadingOf::Weighing);
        assert!(last.unwrap().lines()[0].contains(RETOLD), "{last:?}");
        let events = session.take_events();
        check_log(&mut session, &events);
    }
}

#[test]
fn a_retelling_that_is_not_sure_can_choose_among_the_answers_to_the_instruction() {
    let replies = [
        ("wish", -1),
        ("put(ruler, shelf)", -9000),
        ("put(pen, shelf)", -9100),
        ("closed(cupboard)", -9600),
        ("opened(cupboard)", -9700),
        (RETOLD, -6000),
        ("wish", -1),
        ("put(pen, shelf)", -500),
        ("put(ruler, shelf)", -9000),
        ("put(pen, shelf)", -3000),
        ("closed(cupboard)", -9000),
        ("put(ruler, shelf)", -9000),
        ("put(pen, shelf)", -1000),
        ("closed(cupboard)", -9000),
    ];
    let mut session = grammar(Settings::default());
    play_weighed(&mut session, SAID, &replies);
    assert_eq!(end(&session), "put(<pen>, <shelf>)");
}

#[test]
fn a_goal_that_the_words_do_not_show_is_taken_if_nothing_else_is_found() {
    const HALF: &str = "El boli, al shelf";
    let first = [("wish", -1), ("put(pen, shelf)", -3000)];
    let plan = "put(<pen>, <shelf>)";
    let other = "put(<ruler>, <shelf>)";
    // The replies after the first reading, and what the person sees in the end.
    type Case<'a> = (&'a [(&'a str, i64)], &'a str);
    let cases: [Case<'_>; 2] = [
        (
            &[
                (RETOLD, -2000),
                ("wish", -1),
                (DOUBT, -9),
                ("put(pen, shelf)", -9000),
                ("put(pen, shelf)", -9000),
            ],
            plan,
        ),
        (
            &[
                ("Put the ruler on the shelf.", -2000),
                ("wish", -1),
                ("put(ruler, shelf)", -500),
            ],
            other,
        ),
    ];
    for (replies, expected) in cases {
        let mut session = grammar(Settings::default());
        play_weighed(&mut session, HALF, &[&first, replies].concat());
        assert_eq!(end(&session), expected, "{replies:?}");
        let last = session.readings().last().map(|reading| reading.doubt);
        assert_eq!(last, Some(None), "{:?}", session.readings());
        let events = session.take_events();
        check_log(&mut session, &events);
    }
    // The retelling is the instruction itself, or worthless: no other words speak for the goal.
    for retelling in [(HALF, -10), (RETOLD, -11_000)] {
        let mut session = grammar(Settings::default());
        play_weighed(&mut session, HALF, &[&first[..], &[retelling]].concat());
        assert!(
            matches!(session.response(), Response::Question(_)),
            "{:?}",
            session.response()
        );
    }
    // Without a second look the person is asked.
    let off = Settings {
        retelling: false,
        ..Settings::default()
    };
    let mut off = grammar(off);
    play_weighed(&mut off, HALF, &first);
    assert!(matches!(off.response(), Response::Question(_)), "{:?}", off.response());
}

#[test]
fn the_plan_names_the_retold_instruction_and_later_words_are_about_it() {
    let mut session = grammar(Settings::default());
    let replies = [(DOUBT, -9), (RETOLD, -2000), ("wish", -1), ("put(pen, shelf)", -500)];
    play_weighed(&mut session, SAID, &[&[("wish", -1)], &replies[..]].concat());
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response())
    };
    let note = format!("\"{SAID}\" was taken for \"{RETOLD}\"");
    assert!(
        proposal.answer.assumptions.contains(&note),
        "{:?}",
        proposal.answer.assumptions
    );
    session.accept().unwrap();
    assert_eq!(session.accepted()[0].instruction, SAID);
}

#[test]
fn nothing_is_retold_without_likelihoods_or_against_the_settings() {
    let mut unweighed = grammar(Settings::default());
    play(&mut unweighed, SAID, &["wish", DOUBT]);
    assert!(matches!(unweighed.response(), Response::Question(_)));
    let off = Settings {
        retelling: false,
        ..Settings::default()
    };
    let mut off = grammar(off);
    play_weighed(&mut off, SAID, &[("wish", -1), (DOUBT, -9)]);
    assert!(matches!(off.response(), Response::Question(_)));
    // An answer is not retold.
    off.answer("the pen on the shelf").unwrap();
    off.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    off.supply(&reply(DOUBT), 1.0).unwrap();
    assert!(matches!(off.response(), Response::Question(_)));
}

#[test]
fn a_retelling_that_loses_what_comes_first_is_a_question() {
    let screened = Settings {
        screening: true,
        retelling: true,
        ..Settings::default()
    };
    let mut session = grammar(screened);
    let said = "Saca primero la regla, y luego el boli al estante.";
    let mut replies = vec![("wish & order: luego", -10)];
    replies.extend(GUESS);
    replies.extend([(RETOLD, -1000), ("wish", -10), ("put(pen, shelf)", -10)]);
    play_weighed(&mut session, said, &replies);
    assert!(end(&session).contains("Do you mean"), "{}", end(&session));
}

#[test]
fn a_failed_retelling_asks_the_question() {
    let mut session = grammar(Settings::default());
    session.instruct(SAID).unwrap();
    for text in ["wish", DOUBT] {
        give(&mut session, (text, -1));
    }
    session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    session.failed("the model is gone").unwrap();
    assert!(
        matches!(session.response(), Response::Question(_)),
        "{:?}",
        session.response()
    );
    let events = session.take_events();
    check_log(&mut session, &events);
}

const MIXED: &str = "The pen goes on the shelf, but not the ruler and without the cupboard";
const MARKED: &str = "wish & forbids: but not the ruler & forbids: without the cupboard";
const SPLIT: &str = "do: Put the pen on the shelf.\nnot: Put the ruler on the shelf.\nnot: Open the cupboard.";

#[test]
fn what_is_forbidden_beside_a_wish_becomes_a_constraint() {
    const ASKED: &str =
        "I cannot represent \"but not the ruler\" and \"without the cupboard\"; the plan ignores it. Go on?";
    let constrained = "put(<pen>, <shelf>) & never put(<ruler>, <shelf>) & untouched(<ruler>) & never opened(<cupboard>) & untouched(<cupboard>)";
    let wish = [(MARKED, -1), (SPLIT, -2000), ("wish", -1), ("put(pen, shelf)", -500)];
    // The replies after these four, and what the person sees in the end.
    type Case<'a> = (&'a [(&'a str, i64)], &'a str);
    let cases: [Case<'_>; 2] = [
        (&[("put(ruler, shelf)", -500), ("opened(cupboard)", -500)], constrained),
        // An act that is no goal, or a guess, is about what it names.
        (
            &[&GUESS[..], &[("question: What?", -1)]].concat(),
            "put(<pen>, <shelf>) & untouched(<ruler>) & untouched(<cupboard>)",
        ),
    ];
    for (replies, expected) in cases {
        let mut session = grammar(Settings::default());
        let requests = play_weighed(&mut session, MIXED, &[&wish, replies].concat());
        match session.response() {
            Response::Consent(_) => assert_eq!(question(&session), expected),
            _ => assert_eq!(end(&session), expected),
        }
        assert_eq!(requests[2], "Put the pen on the shelf.");
        assert!(
            requests[4].ends_with("Instruction: Put the ruler on the shelf."),
            "{}",
            requests[4]
        );
        let events = session.take_events();
        check_log(&mut session, &events);
    }
    // One act names nothing, so none counts; the retelling does not help.
    let split = "do: Put the pen on the shelf.\nnot: Open the cupboard.\nnot: Hurry.";
    let replies = [
        (MARKED, -1),
        (split, -2000),
        ("wish", -1),
        ("put(pen, shelf)", -500),
        ("opened(cupboard)", -500),
        ("question: What?", -1),
        (RETOLD, -11_000),
    ];
    let mut unread = grammar(Settings::default());
    play_weighed(&mut unread, MIXED, &replies);
    assert_eq!(question(&unread), ASKED);
    let ignored = Settings {
        forbidding: false,
        retelling: false,
        ..Settings::default()
    };
    let mut ignored = grammar(ignored);
    play_weighed(&mut ignored, MIXED, &[(MARKED, -1), ("put(pen, shelf)", -500)]);
    assert_eq!(question(&ignored), ASKED);
}

#[test]
fn what_is_only_forbidden_is_read_as_a_rule() {
    let mut session = grammar(Settings::default());
    let replies = [
        ("forbids: Hands off the cupboard", -1),
        ("not: Open the cupboard.", -2000),
        ("opened(cupboard)", -500),
    ];
    play_weighed(&mut session, "Hands off the cupboard", &replies);
    assert_eq!(
        question(&session),
        "There is nothing to do. Should `never opened(cupboard)` hold from now on?"
    );
    let events = session.take_events();
    check_log(&mut session, &events);
}

#[test]
fn what_stays_as_it_is_is_read_as_a_rule() {
    const SAID: &str = "The cupboard stays shut";
    let mut session = grammar(Settings::default());
    let replies = [
        ("forbids: The cupboard stays shut", -1),
        ("do: Shut the cupboard.", -2600),
        ("closed(cupboard)", -300),
        ("opened(cupboard)", -3900),
        ("Shut the cupboard.", -11_000),
    ];
    play_weighed(&mut session, SAID, &replies);
    assert_eq!(
        question(&session),
        "There is nothing to do. Should `always closed(cupboard)` hold from now on?"
    );
    let events = session.take_events();
    check_log(&mut session, &events);
}

#[test]
fn a_model_that_is_certain_overrules_its_screening() {
    let split = "do: Put the pen on the shelf.";
    for again in ["wish", "forbids: Put the pen on the shelf"] {
        let mut session = grammar(Settings::default());
        let replies = [
            ("forbids: El boli, al estante", -1),
            (split, -900),
            (again, -1),
            ("put(pen, shelf)", -500),
        ];
        play_weighed(&mut session, SAID, &replies);
        assert_eq!(end(&session), "put(<pen>, <shelf>)", "{again}");
    }
}

#[test]
fn a_part_that_is_forbidden_in_the_wish_of_a_split_is_asked_about() {
    let mut session = grammar(Settings::default());
    let replies = [
        ("forbids: El boli, al estante", -1),
        ("do: Put the pen on the shelf, not the ruler.", -900),
        ("wish & forbids: not the ruler", -1),
        ("put(pen, shelf)", -500),
        (RETOLD, -11_000),
    ];
    play_weighed(&mut session, SAID, &replies);
    let asked = question(&session);
    assert!(asked.contains("\"not the ruler\""), "{asked}");
}

#[test]
fn parts_without_the_prohibition_beside_a_wish_do_not_count() {
    let split = "do: Put the pen on the shelf.";
    let mut session = grammar(Settings::default());
    let replies = [
        (MARKED, -1),
        (split, -1),
        ("put(pen, shelf)", -500),
        (RETOLD, -2000),
        ("wish", -1),
        ("put(pen, shelf)", -500),
    ];
    play_weighed(&mut session, MIXED, &replies);
    assert_eq!(
        question(&session),
        "I cannot represent \"but not the ruler\" and \"without the cupboard\"; the plan ignores it. Go on?"
    );
}

#[test]
fn an_answer_to_a_question_keeps_what_is_forbidden() {
    let mut session = grammar(Settings::default());
    let replies = [
        (MARKED, -1),
        ("do: Put it on the shelf.\nnot: Open the cupboard.", -2000),
        ("wish", -1),
        ("question: Put what on the shelf?", -9),
        (RETOLD, -11_000),
    ];
    play_weighed(&mut session, MIXED, &replies);
    session.answer("the pen").unwrap();
    let mut requests = Vec::new();
    for text in ["put(pen, shelf)", "opened(cupboard)"] {
        let prepared = session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
        requests.push(prepared.request.messages);
        session.supply(&reply(text), 1.0).unwrap();
    }
    assert_eq!(
        end(&session),
        "put(<pen>, <shelf>) & never opened(<cupboard>) & untouched(<cupboard>)"
    );
    // The answer is about the wish.
    assert_eq!(requests[0].last().unwrap().text, "the pen");
    assert!(
        requests[1]
            .last()
            .unwrap()
            .text
            .ends_with("Instruction: Open the cupboard.")
    );
    let events = session.take_events();
    check_log(&mut session, &events);
}

#[test]
fn feedback_on_the_goals_keeps_what_is_forbidden() {
    let mut session = grammar(Settings::default());
    let replies = [
        (MARKED, -1),
        ("do: Put the pen on the shelf.\nnot: Open the cupboard.", -2000),
        ("wish", -1),
        ("put(pen, shelf)", -500),
        ("opened(cupboard)", -500),
    ];
    play_weighed(&mut session, MIXED, &replies);
    session.feedback("the ruler as well").unwrap();
    for text in ["goal", "put(pen, shelf) &", " put(ruler, shelf)"] {
        if session.next_request(&mut EstimatedTokens::default()).unwrap().is_some() {
            session.supply(&reply(text), 1.0).unwrap();
        }
    }
    assert_eq!(
        end(&session),
        "put(<pen>, <shelf>) & put(<ruler>, <shelf>) & never opened(<cupboard>) & untouched(<cupboard>)"
    );
}

#[test]
fn a_trained_model_tries_an_answer_without_regard_to_names() {
    let mut session = grammar(Settings {
        screening: false,
        retelling: false,
        ..Settings::default()
    });
    // The pen is named, and the straight thing is not.
    session
        .instruct("Not the pen, the straight thing, to the shelf.")
        .unwrap();
    let mut answer = |text: &str, likelihood: i64| {
        let prepared = session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
        let Constraint::Lark(grammar) = &prepared.request.constraint else {
            panic!("a grammar")
        };
        let grammar = grammar.clone();
        session.supply(&likely(text, likelihood, true), 1.0).unwrap();
        grammar
    };
    assert!(!answer("put(pen, shelf)", -3000).contains("ruler"));
    assert!(answer("put(ruler, shelf)", -200).contains("ruler"));
    let likeliest = "I am not sure what you want. Do you mean: the ruler is at the shelf?";
    assert_eq!(
        session.question(),
        Some(likeliest),
        "its subject has no name in the words"
    );
}
