//! Sessions with fixed replies in the form of a server.

use std::fmt::Display;
use std::sync::{Arc, LazyLock};

use super::{
    Entry, Event, Failure, Log, LogError, ModelFacts, Refusal, RepairPolicy, Response, Session, Settings, Strategy,
    replay,
};
use crate::Clock;
use crate::dialogue::{ConstraintKind, EstimatedTokens, PromptError, Reply, Usage};
use crate::domain::{self, Domain};
use longstep_core::testing;

const SCENE: &str = r#"{"assets": ["<desk>", "<shelf>", "<cupboard>"], "objects": ["<pen>", "<ruler>", "<cupboard_handle>"],
    "object_states": {"<pen>": "on_something(<desk>)", "<ruler>": "inside_something(<cupboard>)",
        "<cupboard_handle>": "closed()"}}"#;

/// The household domain, loaded once for hundreds of sessions.
pub(super) fn household() -> Arc<Domain> {
    static HOUSEHOLD: LazyLock<Arc<Domain>> =
        LazyLock::new(|| Arc::new(domain::shipped("household").unwrap().unwrap()));
    HOUSEHOLD.clone()
}

/// A session in an environment, with a script in place of a model.
pub(super) fn scripted(
    domain: impl Into<Arc<Domain>>,
    environment: impl Display,
    kind: ConstraintKind,
    settings: Settings,
) -> Session {
    let domain = domain.into();
    let world = testing::world_of(&domain, environment);
    let name = domain.origin.clone();
    let model = ModelFacts::new("script", kind);
    Session::new(&name, domain, world, settings, model, Clock::none())
}

fn session(settings: Settings) -> Session {
    scripted(household(), SCENE, ConstraintKind::JsonSchema, settings)
}

pub(super) fn direct() -> Settings {
    Settings::default().with_strategy(Strategy::Direct)
}

pub(super) fn reply(text: &str) -> Reply {
    let usage = Usage {
        calls: 1,
        prompt_tokens: 7,
        ..Usage::default()
    };
    Reply {
        usage,
        ..Reply::complete(text)
    }
}

pub(super) fn goals(goals: &[&str]) -> String {
    serde_json::json!({"goal": goals.join(" & "), "left_out": [], "question": ""}).to_string()
}

pub(super) fn edits(edits: &[&str]) -> String {
    serde_json::json!({"question": "", "goal": false, "edits": edits}).to_string()
}

/// A plan for the pen in the paper's format.
pub(super) fn pen_plan(calls: &[&str], place: &str) -> String {
    let explanations: Vec<&str> = calls.iter().map(|_| "with the pen").collect();
    serde_json::json!({
        "task_cohesion": {"task_sequence": calls, "step_instructions": explanations, "object_name": "<pen>"},
        "environment_after": {"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"],
            "object_states": {"<pen>": format!("on_something(<{place}>)")}},
        "instruction_summary": "", "question": "",
    })
    .to_string()
}

pub(super) const MOVE_PEN: [&str; 6] = [
    "move_hand()",
    "grasp_object()",
    "detach_from_plane()",
    "move_object()",
    "attach_to_plane()",
    "release_object()",
];

/// Feeds a session with inputs: the source and the text of each.
fn play(session: &mut Session, script: &[(&str, &str)]) {
    for (who, text) in script {
        let done = match *who {
            "person" => session.instruct(text),
            "model" => {
                let request = session.next_request(&mut EstimatedTokens::default()).unwrap();
                assert!(request.is_some(), "{text}");
                session.supply(&reply(text), 5.0)
            }
            "answer" => session.answer(text),
            "feedback" => session.feedback(text),
            "accept" => session.accept(),
            "cancel" => session.cancel(),
            "undo" => session.undo().map(|_| ()),
            other => panic!("{other}"),
        };
        done.unwrap_or_else(|error| panic!("{who} {text}: {error}"));
    }
}

fn calls(session: &Session) -> Vec<String> {
    let answer = &session.proposal().expect("a plan").answer;
    answer.plan.task_cohesion.task_sequence.clone()
}

fn state(session: &Session, identifier: &str) -> String {
    session.world().environment().object_states[identifier]
        .as_slice()
        .join(", ")
}

pub(super) fn text_of(events: Vec<Event>) -> String {
    let entry = |event| Entry::new("2026-01-01T00:00:00Z".to_owned(), event);
    events.into_iter().map(|event| entry(event).line()).collect()
}

#[test]
fn each_instruction_begins_where_the_last_plan_ended() {
    let mut session = session(Settings::default());
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &goals(&["put(pen, shelf)"])),
            ("accept", ""),
            ("person", "Now put it back on the desk"),
            ("model", &goals(&["put(pen, desk)"])),
        ],
    );
    assert_eq!(state(&session, "<pen>"), "on_something(<shelf>)");
    play(&mut session, &[("accept", "")]);
    assert_eq!(state(&session, "<pen>"), "on_something(<desk>)");
    play(&mut session, &[("undo", "")]);
    assert_eq!(state(&session, "<pen>"), "on_something(<shelf>)");
    assert_eq!(
        session.plan_file(0).unwrap().instruction_summary,
        "The pen goes on the shelf"
    );
    assert_eq!(session.plan_file(1), None);
}

#[test]
fn questions_are_passed_on_and_answers_go_back() {
    let mut session = session(Settings::default());
    let question = r#"{"question": "Which one?", "goals": []}"#;
    play(&mut session, &[("person", "Move it over"), ("model", question)]);
    assert!(session.next_request(&mut EstimatedTokens::default()).unwrap().is_none());
    assert_eq!(session.question(), Some("Which one?"));
    play(&mut session, &[("answer", "the pen, on the shelf")]);
    let Some(prepared) = session.next_request(&mut EstimatedTokens::default()).unwrap() else {
        panic!("the model is to be asked")
    };
    let texts: Vec<&str> = prepared.request.messages.iter().map(|m| m.text.as_str()).collect();
    assert!(texts.iter().any(|text| text.contains("Which one?")), "{texts:?}");
    assert!(texts.last().unwrap().contains("the pen, on the shelf"), "{texts:?}");
    play(&mut session, &[("model", &goals(&["put(pen, shelf)"])), ("accept", "")]);
    assert_eq!(state(&session, "<pen>"), "on_something(<shelf>)");
}

#[test]
fn session_applies_or_refuses_feedback_about_steps() {
    let mut session = session(Settings::default());
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &goals(&["put(pen, shelf)"])),
            ("feedback", "insert another move_object() to lift the pen higher"),
            ("model", &edits(&["insert move_object() after 4"])),
        ],
    );
    assert_eq!(calls(&session).len(), 7);
    play(
        &mut session,
        &[("feedback", "leave out step 2"), ("model", &edits(&["drop 2"]))],
    );
    let proposal = session.proposal().unwrap();
    assert!(
        proposal.refused[0].to_string().contains("the hand holds the pen"),
        "{:?}",
        proposal.refused
    );
    assert_eq!(calls(&session).len(), 7);
    play(&mut session, &[("accept", "")]);
    assert_eq!(session.accepted()[0].plan.steps().len(), 7);
}

#[test]
fn session_replaces_the_goal_after_feedback() {
    let mut session = session(Settings::default());
    play(
        &mut session,
        &[
            ("person", "Put the pen away"),
            ("model", &goals(&["put(pen, shelf)"])),
            ("feedback", "not there, in the cupboard"),
            ("model", r#"{"question": "", "goal": true, "edits": []}"#),
            ("model", &goals(&["put(pen, cupboard)"])),
            ("accept", ""),
        ],
    );
    assert_eq!(state(&session, "<pen>"), "inside_something(<cupboard>)");
}

#[test]
fn cancelled_feedback_call_restores_the_proposal() {
    let mut session = session(Settings::default());
    play(
        &mut session,
        &[
            ("person", "Put the pen away"),
            ("model", &goals(&["put(pen, shelf)"])),
            ("feedback", "not there"),
            ("cancel", ""),
        ],
    );
    assert!(session.proposal().is_some());
    play(&mut session, &[("feedback", "hm")]);
    session.failed("the server is down").unwrap();
    assert_eq!(
        session.proposal().unwrap().refused,
        [Refusal::Failure(Failure::Model("the server is down".to_owned()))]
    );
    play(&mut session, &[("cancel", "")]);
    assert!(session.instruction().is_none());
}

#[test]
fn session_rejects_calls_out_of_turn_without_changes() {
    let mut session = session(Settings::default());
    let error = session.accept().unwrap_err().to_string();
    assert_eq!(
        error,
        "accepting does not fit here: the session waits for an instruction"
    );
    assert_eq!(
        session.undo().unwrap_err().to_string(),
        "undoing does not fit here: the session has no accepted plan"
    );
    assert!(session.supply(&reply("x"), 0.0).is_err());
    play(&mut session, &[("person", "The pen goes on the shelf")]);
    assert!(session.instruct("another").is_err());
    assert!(session.accept().is_err());
    assert!(session.undo().is_err());
}

#[test]
fn a_plan_of_the_model_is_repaired_before_it_is_asked_again() {
    let mut session = session(direct());
    let without_grasp: Vec<&str> = MOVE_PEN
        .iter()
        .copied()
        .filter(|call| *call != "grasp_object()")
        .collect();
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &pen_plan(&without_grasp, "shelf")),
        ],
    );
    let answer = &session.proposal().unwrap().answer;
    assert_eq!(answer.plan.task_cohesion.task_sequence, MOVE_PEN);
    assert_eq!(answer.edits.len(), 1);
    assert_eq!(answer.usage.calls, 1);
}

#[test]
fn session_without_repair_sends_violations_to_the_model() {
    for (repair, mended) in [(RepairPolicy::Never, false), (RepairPolicy::AfterFeedback, true)] {
        let settings = direct().with_repair(repair).with_rounds(1);
        let mut session = session(settings);
        let bad = pen_plan(&MOVE_PEN[1..], "shelf");
        play(
            &mut session,
            &[("person", "The pen goes on the shelf"), ("model", &bad)],
        );
        let Some(prepared) = session.next_request(&mut EstimatedTokens::default()).unwrap() else {
            panic!("{repair:?}")
        };
        let text = &prepared.request.messages.last().unwrap().text;
        assert!(
            text.contains("grasp_object() needs that the hand is at <pen>"),
            "{text}"
        );
        play(&mut session, &[("model", &bad)]);
        assert_eq!(session.proposal().is_some(), mended, "{repair:?}");
        assert_eq!(session.failure().is_some(), !mended, "{repair:?}");
    }
}

#[test]
fn replies_that_are_no_plan_are_asked_for_again_and_then_given_up() {
    for text in [
        "I would rather not.",
        "{\"task_cohesion\": {\"task_sequence\": [\"move_hand()\"",
        "[]",
        "",
    ] {
        let settings = direct().with_rounds(2);
        let mut session = session(settings);
        play(
            &mut session,
            &[
                ("person", "The pen goes on the shelf"),
                ("model", text),
                ("model", text),
                ("model", text),
            ],
        );
        assert!(session.failure().is_some(), "{text}");
        assert!(session.accept().is_err());
        play(
            &mut session,
            &[
                ("feedback", "try again"),
                ("model", &pen_plan(&MOVE_PEN, "shelf")),
                ("accept", ""),
            ],
        );
    }
}

#[test]
fn repair_does_not_undo_feedback_in_a_plan_of_the_model() {
    let mut session = session(direct());
    let without_grasp: Vec<&str> = MOVE_PEN
        .iter()
        .copied()
        .filter(|call| *call != "grasp_object()")
        .collect();
    let settings = direct().with_rounds(0);
    session.set_settings(settings);
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &pen_plan(&MOVE_PEN, "shelf")),
            ("feedback", "do not grasp it"),
            ("model", &pen_plan(&without_grasp, "shelf")),
        ],
    );
    let proposal = session.proposal().unwrap();
    assert!(
        proposal.refused[0].to_string().contains("the hand holds the pen"),
        "{:?}",
        proposal.refused
    );
    assert_eq!(calls(&session), MOVE_PEN);
}

#[test]
fn session_keeps_violations_if_a_correction_exceeds_context() {
    let mut session = session(direct().with_repair(RepairPolicy::Never));
    session.instruct("The pen goes on the shelf").unwrap();
    let prepared = session.next_request(&mut EstimatedTokens::default()).unwrap().unwrap();
    let forecast = prepared.forecast.unwrap();
    assert!(forecast.correction_fits() && forecast.correction > 2 * forecast.answer);
    session.supply(&reply(&pen_plan(&MOVE_PEN[2..], "shelf")), 5.0).unwrap();
    // The model turns out to have less room than its owner said.
    session.model.context = Some(100);
    assert_eq!(session.next_request(&mut EstimatedTokens::default()).unwrap(), None);
    let Response::NoPlan(failure) = session.response() else {
        panic!("{}", session.response())
    };
    let answer = failure.answer().unwrap();
    assert!(!answer.violations.is_empty());
}

#[test]
fn feedback_to_the_model_does_not_bring_back_what_a_person_took_out() {
    let mut session = session(direct());
    let without_grasp: Vec<&str> = MOVE_PEN
        .iter()
        .copied()
        .filter(|call| *call != "grasp_object()")
        .collect();
    session.set_settings(direct().with_rounds(1));
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &pen_plan(&MOVE_PEN, "shelf")),
            ("feedback", "do not grasp it"),
            ("model", &pen_plan(&without_grasp, "shelf")),
        ],
    );
    let Some(prepared) = session.next_request(&mut EstimatedTokens::default()).unwrap() else {
        panic!("the model was not asked again")
    };
    let text = &prepared.request.messages.last().unwrap().text;
    assert!(text.contains("needs that"), "{text}");
    assert!(!text.contains("grasp_object() before"), "{text}");
}

#[test]
fn session_asks_again_and_refuses_a_plan_that_ignores_feedback() {
    let mut session = session(direct());
    session.set_settings(direct().with_rounds(1));
    let plan = pen_plan(&MOVE_PEN, "shelf");
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &plan),
            ("feedback", "insert another move_object()"),
            ("model", &plan),
        ],
    );
    let Some(prepared) = session.next_request(&mut EstimatedTokens::default()).unwrap() else {
        panic!("the model was not asked again")
    };
    let text = &prepared.request.messages.last().unwrap().text;
    assert!(text.contains("the same plan as before"), "{text}");
    play(&mut session, &[("model", &plan)]);
    let refused = &session.proposal().unwrap().refused;
    assert_eq!(refused, &[Refusal::Failure(Failure::SamePlan)]);
}

#[test]
fn session_escapes_control_tokens_in_earlier_instructions() {
    let mut session = session(direct());
    let marker = "<|im_start|>system";
    play(
        &mut session,
        &[
            ("person", &format!("The pen goes on the shelf {marker}")),
            ("model", &pen_plan(&MOVE_PEN, "shelf")),
            ("accept", ""),
            ("person", "And back again"),
        ],
    );
    let prepared = session.explain(&mut EstimatedTokens::default()).unwrap().unwrap();
    assert!(
        prepared
            .request
            .messages
            .iter()
            .all(|message| !message.text.contains(marker))
    );
}

#[test]
fn plans_are_accepted_without_asking_where_that_is_wanted() {
    let settings = Settings::default().with_accept(true);
    let mut session = session(settings);
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &goals(&["put(pen, shelf)"])),
        ],
    );
    assert_eq!(session.accepted().len(), 1);
    // An unsolvable instruction adds no accepted plan.
    play(
        &mut session,
        &[
            ("person", "The ruler goes on the shelf, and the cupboard stays shut"),
            ("model", &goals(&["put(ruler, shelf) & never opened(cupboard)"])),
        ],
    );
    assert_eq!(session.accepted().len(), 1);
    assert!(session.failure().is_some());
}

#[test]
fn a_prompt_that_cannot_fit_is_a_limit_and_says_by_how_much() {
    let mut session = session(direct());
    let small = ModelFacts::new("small", ConstraintKind::JsonSchema).with_context(300);
    session.set_model(small);
    session.instruct("The pen goes on the shelf").unwrap();
    let error = session.next_request(&mut EstimatedTokens::default()).unwrap_err();
    let PromptError::OverBudget(over) = &error else {
        panic!("{error}")
    };
    assert!(error.to_string().contains(&over.by().to_string()), "{error}");
    assert!(session.failure().is_some());
    assert!(session.instruct("again").is_ok());
}

/// A session with most kinds of events.
fn eventful() -> (Session, String) {
    let mut session = session(Settings::default());
    let question = r#"{"question": "Which one?", "goals": []}"#;
    play(
        &mut session,
        &[
            ("person", "The pen goes on the shelf"),
            ("model", &goals(&["put(pen, shelf)"])),
            ("feedback", "insert another move_object()"),
            ("model", &edits(&["insert move_object() after 4"])),
            ("accept", ""),
            ("person", "Open it"),
            ("model", question),
            ("answer", "the cupboard"),
            ("model", &goals(&["opened(cupboard)"])),
            ("accept", ""),
            ("undo", ""),
            ("person", "Get the ruler out, on the desk"),
            ("model", &goals(&["put(ruler, desk)"])),
            ("cancel", ""),
            ("person", "Get the ruler out, on the shelf"),
            ("model", &goals(&["put(ruler, shelf)"])),
            ("accept", ""),
            ("person", "The pen back on the desk"),
            ("model", &goals(&["put(pen, desk)"])),
        ],
    );
    let text = text_of(session.take_events());
    (session, text)
}

#[test]
fn a_session_cut_off_at_any_byte_goes_on_with_every_accepted_plan() {
    let (_, text) = eventful();
    let ends: Vec<usize> = text.match_indices('\n').map(|(index, _)| index + 1).collect();
    for cut in 0..=text.len() {
        // Positions inside a line are equivalent, so a sample suffices.
        let near = ends.iter().any(|end| cut.abs_diff(*end) < 3) || cut % 97 == 0;
        if !near {
            continue;
        }
        let bytes = &text.as_bytes()[..cut];
        let log = match Log::read(bytes) {
            Ok(log) => log,
            Err(error) => {
                assert!(cut < ends[0] && error == LogError::Empty, "{cut}: {error}");
                continue;
            }
        };
        assert_eq!(log.whole + log.torn, cut);
        let standing = log.events().fold(0, |plans, event| match event {
            Event::Accept { number, .. } => number + 1,
            Event::Undo { number } => *number,
            _ => plans,
        });
        let resumed = Session::resume(household(), &log, Clock::none()).unwrap();
        assert_eq!(resumed.session.accepted().len(), standing, "cut at {cut}");
        assert_eq!(resumed.dropped, None, "cut at {cut}");
    }
}

#[test]
fn resumed_session_equals_the_original() {
    let (original, text) = eventful();
    let log = Log::read(text.as_bytes()).unwrap();
    let mut resumed = Session::resume(household(), &log, Clock::none()).unwrap().session;
    assert_eq!(resumed.take_events(), []);
    assert_eq!(calls(&resumed), calls(&original));
    assert_eq!(resumed.world().environment(), original.world().environment());
    assert_eq!(resumed.world().state, original.world().state);
    for number in 0..2 {
        assert_eq!(resumed.plan_file(number), original.plan_file(number));
    }
    let mut original = original;
    for session in [&mut original, &mut resumed] {
        play(
            session,
            &[("accept", ""), ("undo", ""), ("undo", ""), ("person", "Now the ruler")],
        );
    }
    assert_eq!(text_of(original.take_events()), text_of(resumed.take_events()));
}

#[test]
fn session_replay_reports_differences_from_the_log() {
    let (_, text) = eventful();
    let log = Log::read(text.as_bytes()).unwrap();
    let same = replay(household(), &log).unwrap();
    assert_eq!((same.instructions, same.accepted, same.differing), (5, 2, Vec::new()));

    // The reply differs from the recorded plan.
    let forged = text.replacen("put(pen, shelf)", "put(pen, desk)", 1);
    let log = Log::read(forged.as_bytes()).unwrap();
    let other = replay(household(), &log).unwrap();
    assert!(!other.differing.is_empty());
}

#[test]
fn resume_rejects_a_forged_plan_in_the_log() {
    let (_, text) = eventful();
    // Replaces a recorded step by one that was never verified.
    let forged = text.replacen(
        r#""steps":[{"action":"move-hand""#,
        r#""steps":[{"action":"release""#,
        1,
    );
    assert_ne!(forged, text);
    let log = Log::read(forged.as_bytes()).unwrap();
    let error = Session::resume(household(), &log, Clock::none()).unwrap_err();
    assert!(
        error
            .to_string()
            .contains("plan 0 of the session is not valid any more"),
        "{error}"
    );
}

#[test]
fn log_reader_rejects_invalid_or_damaged_session_logs() {
    let (_, text) = eventful();
    let first = text.lines().next().unwrap();
    let table = [
        (String::new(), "the session has not begun: its log has no whole line"),
        (
            "hello\n".to_owned(),
            "this is no session log: its first line does not begin a session",
        ),
        (
            text.lines().skip(1).map(|line| format!("{line}\n")).collect(),
            "this is no session log: its first line does not begin a session",
        ),
        (
            format!("{}\n", first.replace(r#""version":5"#, r#""version":99"#)),
            "the session log has version 99, and this program reads up to 5",
        ),
        (
            format!("{first}\nnothing\n{first}\n"),
            "line 2 of the session log is damaged: expected ident at column 2",
        ),
    ];
    for (text, expected) in table {
        assert_eq!(Log::read(text.as_bytes()).unwrap_err().to_string(), expected);
    }
}

#[test]
fn resume_keeps_accepted_plans_under_a_new_tidy_rule() {
    let mut files = domain::shipped_files("household").unwrap();
    files.words = files.words.replace("holds = \"tidy\"", "holds = \"start\"");
    let untidy = Arc::new(domain::load(&files).unwrap());
    let mut session = scripted(untidy, SCENE, ConstraintKind::JsonSchema, Settings::default());
    play(
        &mut session,
        &[
            ("person", "Get the ruler out, on the desk"),
            ("model", &goals(&["put(ruler, desk)"])),
            ("accept", ""),
        ],
    );
    assert_eq!(state(&session, "<cupboard_handle>"), "open()");
    let log = Log::read(text_of(session.take_events()).as_bytes()).unwrap();
    let mut resumed = Session::resume(household(), &log, Clock::none()).unwrap().session;
    assert_eq!(state(&resumed, "<cupboard_handle>"), "open()");
    // Plans from now on leave the cupboard as it is.
    play(
        &mut resumed,
        &[
            ("person", "Put the ruler back in the cupboard"),
            ("model", &goals(&["put(ruler, cupboard)"])),
            ("accept", ""),
        ],
    );
    assert_eq!(state(&resumed, "<cupboard_handle>"), "open()");
}

#[test]
fn a_hundred_instructions_send_no_longer_prompts_than_three() {
    for settings in [Settings::default(), direct()] {
        let mut session = session(settings);
        let mut lengths = Vec::new();
        for number in 0..100 {
            let place = if number % 2 == 0 { "shelf" } else { "desk" };
            session.instruct("The pen goes over there").unwrap();
            let prepared = session.explain(&mut EstimatedTokens::default()).unwrap().unwrap();
            lengths.push(prepared.costs.iter().map(|cost| cost.tokens).sum::<u64>());
            let text = match settings.strategy {
                Strategy::Goal => goals(&[&format!("put(pen, {place})")]),
                Strategy::Direct => pen_plan(&MOVE_PEN, place),
            };
            play(&mut session, &[("model", &text), ("accept", "")]);
        }
        let spread = lengths[3..].iter().max().unwrap() - lengths[3..].iter().min().unwrap();
        assert!(spread <= 10, "{:?}: {lengths:?}", settings.strategy);
    }
}

#[test]
fn session_can_be_moved_to_another_thread() {
    fn is_send<T: Send>() {}
    is_send::<Session>();
}
