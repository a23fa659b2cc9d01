//! Sessions whose instructions say more than goals, with fixed replies.

use super::tests::{goals, household, reply, scripted, text_of};
use super::{Event, Log, Response, Session, Settings, replay};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::report::Status;

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>", "<cupboard>"], "objects": ["<pen>", "<ruler>", "<cupboard_handle>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<desk>)",
        "<cupboard_handle>": "closed()"}}"#;

pub(super) fn session(kind: ConstraintKind, settings: Settings) -> Session {
    scripted(household(), SCENE, kind, settings)
}

/// Gives an instruction and the replies to it; returns the last user message of each request.
pub(super) fn play(session: &mut Session, instruction: &str, replies: &[&str]) -> Vec<String> {
    session.instruct(instruction).unwrap();
    let mut requests = Vec::new();
    for text in replies {
        let request = session
            .next_request(&mut EstimatedTokens::default())
            .unwrap()
            .unwrap()
            .request;
        requests.push(request.messages.last().unwrap().text.clone());
        session.supply(&reply(text), 1.0).unwrap();
    }
    assert!(!session.wants_model(), "{instruction}");
    requests
}

pub(super) fn question(session: &Session) -> String {
    match session.response() {
        Response::Consent(proposal) => proposal.question.clone().unwrap(),
        other => panic!("{other:?}"),
    }
}

/// Checks that the log of a session restores its state and replays without a difference.
pub(super) fn check_log(session: &mut Session, events: &[Event]) {
    let log = Log::read(text_of(events.to_vec()).as_bytes()).unwrap();
    let resumed = Session::resume(household(), &log, Clock::none()).unwrap();
    assert_eq!(resumed.dropped, None);
    let (then, now) = (session.response().to_string(), resumed.session.response().to_string());
    assert_eq!(then, now);
    let written =
        |session: &Session| -> Vec<String> { session.rules().iter().map(|rule| rule.written.clone()).collect() };
    assert_eq!(written(&resumed.session), written(session));
    let replay = replay(household(), &log).unwrap();
    assert!(replay.differing.is_empty(), "{:?}", replay.differing);
}

const TIMED: &str = "The pen goes on the shelf for ten minutes";
const LEFT_OUT: &str = "put(pen, shelf) | left out amount: for ten minutes";

#[test]
fn session_asks_for_consent_if_an_omission_changes_the_plan() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    let requests = play(&mut session, TIMED, &[LEFT_OUT]);
    assert!(
        requests[0].ends_with(&format!("Instruction: {TIMED}")),
        "{}",
        requests[0]
    );
    assert_eq!(
        question(&session),
        "I cannot represent \"for ten minutes\"; the plan ignores it. Go on?"
    );
    let answer = &session.proposal().unwrap().answer;
    assert_eq!(answer.not_represented[0].kind, "amount");
    let asked = answer.as_question(session.world(), "?");
    assert!(asked.steps.is_empty() && asked.outline.is_empty() && asked.goal == ["put(<pen>, <shelf>)"]);
    assert_eq!((asked.status, asked.not_represented.len()), (Status::Question, 1));
    let mut events = session.take_events();
    check_log(&mut session, &events);
    session.accept().unwrap();
    events.extend(session.take_events());
    assert_eq!(session.accepted().len(), 1);
    check_log(&mut session, &events);
}

#[test]
fn session_asks_for_consent_if_words_of_an_answer_are_left_out() {
    let mut session = session(ConstraintKind::JsonSchema, Settings::default());
    let asks = r#"{"goal": "", "left_out": [], "question": "What should go there?"}"#;
    play(&mut session, "Put something on the shelf", &[asks]);
    assert!(
        matches!(session.response(), Response::Question(_)),
        "{:?}",
        session.response()
    );
    session.answer("the pen, for ten minutes").unwrap();
    session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    let answers =
        r#"{"goal": "put(pen, shelf)", "left_out": [{"text": "for ten minutes", "kind": "amount"}], "question": ""}"#;
    session.supply(&reply(answers), 1.0).unwrap();
    assert_eq!(
        question(&session),
        "I cannot represent \"for ten minutes\"; the plan ignores it. Go on?"
    );
    let events = session.take_events();
    check_log(&mut session, &events);
}

#[test]
fn session_notes_an_omission_that_does_not_change_the_plan() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    let answer = "put(pen, shelf) | left out manner: quietly | left out time: by noon";
    play(&mut session, "The pen goes quietly on the shelf by noon", &[answer]);
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response())
    };
    let gaps = &proposal.answer.not_represented;
    let gaps: Vec<(&str, &str, bool)> = gaps.iter().map(|own| (&*own.text, own.kind, own.question)).collect();
    assert_eq!(gaps, [("quietly", "manner", false), ("by noon", "time", false)]);
}

#[test]
fn consent_needs_its_own_setting_besides_accept() {
    let accept = Settings::default().with_accept(true);
    let mut asks = session(ConstraintKind::Grammar, accept);
    play(&mut asks, TIMED, &[LEFT_OUT]);
    assert!(matches!(asks.response(), Response::Consent(_)));
    let partial = accept.with_partial(true);
    let mut goes_on = session(ConstraintKind::Grammar, partial);
    play(&mut goes_on, TIMED, &[LEFT_OUT]);
    assert_eq!(goes_on.accepted().len(), 1);
}

#[test]
fn session_turns_a_sole_prohibition_into_a_rule() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    play(
        &mut session,
        "Please do not open the cupboard",
        &["never opened(cupboard)"],
    );
    assert_eq!(
        question(&session),
        "There is nothing to do. Should `never opened(cupboard)` hold from now on?"
    );
    assert!(session.proposal().unwrap().plan.steps().is_empty());
    let mut events = session.take_events();
    check_log(&mut session, &events);
    session.accept().unwrap();
    assert!(session.accepted().is_empty());
    assert_eq!(session.rules()[0].written, "never opened(<cupboard>)");
    play(&mut session, "Open the cupboard", &["opened(cupboard)"]);
    assert!(matches!(session.response(), Response::NoPlan(_)));
    events.extend(session.take_events());
    check_log(&mut session, &events);
}

/// A model that asks is asked for the goal that it takes to be meant; the reply without a likelihood is believed to ask.
#[test]
fn session_asks_an_undecided_model_for_its_best_goal() {
    let mut asks = session(ConstraintKind::Grammar, Settings::default());
    play(&mut asks, "That should be tidier", &["question:", "put(pen, shelf)"]);
    assert_eq!(question(&asks), "Should I put the pen at the shelf?");
    let mut events = asks.take_events();
    check_log(&mut asks, &events);
    asks.accept().unwrap();
    assert_eq!(asks.accepted().len(), 1);
    events.extend(asks.take_events());
    check_log(&mut asks, &events);
    // Other words than yes are understood together with the question.
    play(&mut asks, "And that too", &["question:", "put(ruler, desk)"]);
    asks.feedback("the ruler, on the shelf").unwrap();
    assert!(asks.wants_model());
}

#[test]
fn server_reply_states_order_and_prohibitions() {
    let mut session = session(ConstraintKind::JsonSchema, Settings::default());
    let goal = "put(ruler, shelf) then put(pen, shelf) & never opened(cupboard)";
    let answer = serde_json::json!({"goal": goal, "question": "", "left_out": [{"text": "by  noon", "kind": "time"}, {"text": "thrice", "kind": "amount"}]});
    play(
        &mut session,
        "First the ruler, then the pen onto the shelf thrice, and leave the cupboard closed",
        &[&answer.to_string()],
    );
    let answer = &session.proposal().unwrap().answer;
    assert_eq!(
        answer.goal,
        [
            "put(<ruler>, <shelf>)",
            "then put(<pen>, <shelf>)",
            "never opened(<cupboard>)"
        ]
    );
    let gaps: Vec<(&str, &str)> = answer
        .not_represented
        .iter()
        .map(|gap| (gap.text.as_str(), gap.kind))
        .collect();
    // What is no quotation stands for everything, and yields to a gap that is a question.
    assert_eq!(gaps, [("thrice", "amount")]);
    session.cancel().unwrap();
    play(
        &mut session,
        "Put the pen on the shelf",
        &[&goals(&["put(pen, shelf)"])],
    );
    assert!(matches!(session.response(), Response::Plan(_)));
}
