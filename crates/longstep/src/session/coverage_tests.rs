//! Sessions whose instructions say more than goals, with fixed replies.

use super::tests::{goals, household, reply, text_of};
use super::{Event, Log, ModelFacts, Response, Session, Settings, replay};
use crate::dialogue::{ConstraintKind, EstimatedTokens};
use crate::environment::{self, Environment};
use crate::json::Path;

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>", "<cupboard>"], "objects": ["<pen>", "<ruler>", "<cupboard_handle>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "on_something(<desk>)",
        "<cupboard_handle>": "closed()"}}"#;

pub(super) fn session(kind: ConstraintKind, settings: Settings) -> Session {
    let household = household();
    let environment = Environment::from_json(SCENE).unwrap();
    let world = environment::read(&household, &environment, "", "", &Path::default()).unwrap();
    let model = ModelFacts {
        name: "script".to_owned(),
        kind,
        context: None,
    };
    Session::new("household", household, world, settings, model, || 0.0)
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
    let resumed = Session::resume(household(), &log, || 0.0).unwrap();
    assert_eq!(resumed.dropped, None);
    let (then, now) = (session.response().to_string(), resumed.session.response().to_string());
    assert_eq!(then, now);
    let written =
        |session: &Session| -> Vec<String> { session.rules().iter().map(|rule| rule.written.clone()).collect() };
    assert_eq!(written(&resumed.session), written(session));
    let replay = replay(household(), &log, || 0.0).unwrap();
    assert!(replay.differing.is_empty(), "{:?}", replay.differing);
}

const MIXED: &str = "The pen goes on the shelf, but leave the ruler alone";
const MARKED: &str = "wish & forbids: but leave the ruler alone";

#[test]
fn a_prohibition_beside_a_wish_needs_consent() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    let requests = play(&mut session, MIXED, &[MARKED, "put(pen, shelf)"]);
    assert_eq!(requests[0], MIXED);
    assert!(
        requests[1].ends_with("Instruction: The pen goes on the shelf,"),
        "{}",
        requests[1]
    );
    assert_eq!(
        question(&session),
        "I cannot represent \"but leave the ruler alone\"; the plan ignores it. Go on?"
    );
    let answer = &session.proposal().unwrap().answer;
    assert_eq!(answer.not_represented[0].kind, "prohibition");
    let asked = answer.as_question(session.world(), "?");
    assert!(asked.steps.is_empty() && asked.outline.is_empty() && asked.goal == ["put(<pen>, <shelf>)"]);
    assert_eq!((asked.status.exit_code(), asked.not_represented.len()), (13, 1));
    let mut events = session.take_events();
    check_log(&mut session, &events);
    session.accept().unwrap();
    events.extend(session.take_events());
    assert_eq!(session.accepted().len(), 1);
    check_log(&mut session, &events);
}

#[test]
fn consent_is_given_by_a_setting_and_not_by_accepting_everything() {
    let accept = Settings {
        accept: true,
        ..Settings::default()
    };
    let mut asks = session(ConstraintKind::Grammar, accept);
    play(&mut asks, MIXED, &[MARKED, "put(pen, shelf)"]);
    assert!(matches!(asks.response(), Response::Consent(_)));
    let partial = Settings {
        partial: true,
        ..accept
    };
    let mut goes_on = session(ConstraintKind::Grammar, partial);
    play(&mut goes_on, MIXED, &[MARKED, "put(pen, shelf)"]);
    assert_eq!(goes_on.accepted().len(), 1);
    let unscreened = Settings {
        screening: false,
        ..Settings::default()
    };
    let mut silent = session(ConstraintKind::Grammar, unscreened);
    play(&mut silent, "The pen goes on the shelf, quietly", &["put(pen, shelf)"]);
    assert!(matches!(silent.response(), Response::Plan(_)));
}

#[test]
fn what_is_only_forbidden_becomes_a_rule() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    let text = "Please do not open the cupboard";
    play(
        &mut session,
        text,
        &["forbids: do not open the cupboard", "opened(cupboard)"],
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
    play(&mut session, "Open the cupboard", &["wish", "opened(cupboard)"]);
    assert!(matches!(session.response(), Response::NoPlan(_)));
    events.extend(session.take_events());
    check_log(&mut session, &events);
}

#[test]
fn a_prohibition_that_is_no_goal_is_a_question() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    play(
        &mut session,
        "Keep away from it",
        &["forbids: Keep away from it", "question: What do you mean?"],
    );
    let question = session.question().unwrap();
    assert!(question.starts_with("You forbid something"), "{question}");
    // The answer is about the prohibition, and no goal of it is pursued.
    session.answer("the cupboard").unwrap();
    session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    session.supply(&reply("opened(cupboard)"), 1.0).unwrap();
    assert!(session.proposal().unwrap().offers_rule());
}

#[test]
fn an_order_becomes_stages() {
    let mut session = session(ConstraintKind::Grammar, Settings::default());
    let text = "First put the ruler on the shelf, after that put the pen on the shelf";
    let replies = [
        "wish & order: First & order: after that",
        "put(ruler, shelf) &",
        " put(pen, shelf)",
    ];
    play(&mut session, text, &replies);
    let Response::Plan(proposal) = session.response() else {
        panic!("{:?}", session.response())
    };
    assert_eq!(
        proposal.answer.goal,
        ["put(<ruler>, <shelf>)", "then put(<pen>, <shelf>)"]
    );
    assert!(proposal.answer.not_represented.is_empty());
}

#[test]
fn a_server_names_what_it_leaves_out() {
    let mut session = session(ConstraintKind::JsonSchema, Settings::default());
    let answer = r#"{"question": "", "goals": ["put(pen, shelf)"], "never": ["opened(cupboard)"],
        "not_represented": [{"text": "quickly", "kind": "other"}, {"text": "by  noon", "kind": "quantity"}]}"#;
    play(
        &mut session,
        "Quickly put the pen on the shelf by noon, and leave the cupboard closed",
        &[answer],
    );
    let answer = &session.proposal().unwrap().answer;
    assert_eq!(answer.goal, ["put(<pen>, <shelf>)", "never opened(<cupboard>)"]);
    let gaps: Vec<(&str, &str)> = answer
        .not_represented
        .iter()
        .map(|gap| (gap.text.as_str(), gap.kind))
        .collect();
    // "quickly" is no quotation, so it marks everything, and yields to a gap that is a question.
    assert_eq!(gaps, [("by noon", "quantity")]);
    assert_eq!(
        question(&session),
        "I cannot represent \"by noon\"; the plan ignores it. Go on?"
    );
    session.cancel().unwrap();
    play(
        &mut session,
        "Put the pen on the shelf",
        &[&goals(&["put(pen, shelf)"])],
    );
    assert!(matches!(session.response(), Response::Plan(_)));
    session.cancel().unwrap();
    let answer = r#"{"question": "", "goals": [], "never": ["opened(cupboard)"]}"#;
    play(&mut session, "Never open the cupboard", &[answer]);
    assert!(session.proposal().unwrap().offers_rule());
}

#[test]
fn settings_of_older_logs_have_no_further_requests() {
    let settings: Settings = serde_json::from_str(r#"{"strategy": "goal", "rounds": 3}"#).unwrap();
    assert!(!settings.screening && !settings.partial && !settings.forbidding && !settings.retelling);
    let new = Settings::default();
    assert!(new.screening && new.forbidding && new.retelling);
}
