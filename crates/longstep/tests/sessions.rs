//! Sessions over the recorded scenes, and over a long chain in the recorded kitchen, without a model: replies are the
//! recorded ones, or written by search. Ignored without `LONGSTEP_CORPUS`, as the tests of `corpus.rs` are.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    clippy::print_stdout,
    missing_docs
)]

mod chain;

use chain::{Drawn, Recomputation, SCENES, domain, is_as_recorded, mean, memory, read, slope, world_of};
use longstep::Clock;
use longstep::dialogue::{ConstraintKind, EstimatedTokens, Reply};
use longstep::domain::Domain;
use longstep::report;
use longstep::session::{ModelFacts, Session, Settings, Strategy};
use longstep_core::environment::World;
use serde_json::Value;

fn session(name: &str, domain: Domain, world: World) -> Session {
    let settings = Settings::default().with_strategy(Strategy::Direct);
    let model = ModelFacts::new("recorded", ConstraintKind::JsonSchema);
    Session::new(name, domain, world, settings, model, Clock::none())
}

#[track_caller]
fn supply(session: &mut Session, text: String) {
    let request = session.next_request(&mut EstimatedTokens::default()).unwrap();
    assert!(request.is_some(), "{:?}", session.response());
    let reply = Reply::complete(text);
    session.supply(&reply, 0.0).unwrap();
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn recorded_scenes_are_replayed_as_chains() {
    let (mut right, mut all) = (0, 0);
    for scene in SCENES {
        let read = read(&format!("household/{scene}.json"));
        let steps = read["steps"].as_array().unwrap();
        let domain = domain("household");
        let world = world_of(&domain, &steps[0]["recorded"]["environment_before"]);
        let mut session = session("household", domain, world);
        for step in steps {
            let instruction = step["instruction"].as_str().unwrap();
            session.instruct(instruction).unwrap();
            supply(&mut session, step["recorded"].to_string());
            let proposal = session
                .proposal()
                .unwrap_or_else(|| panic!("{instruction}: {:?}", session.failure()));
            let edits = proposal.answer.edits.len();
            session.accept().unwrap();
            let recorded = &step["recorded"]["environment_after"];
            let good = edits == 0 && is_as_recorded(session.world(), recorded);
            all += 1;
            right += usize::from(good);
            println!(
                "{} {scene}: {instruction} ({edits} edits)",
                if good { "ok   " } else { "WRONG" }
            );
        }
    }
    println!("== {right} of {all} right");
    assert_eq!((right, all), (15, 15));
}

/// The recorded plan for the juice, whole or without the middle one of its three `move_object()`.
fn juice(recorded: &Value, moves: usize) -> String {
    let mut plan = recorded.clone();
    if moves == 2 {
        for list in ["task_sequence", "step_instructions"] {
            plan["task_cohesion"][list].as_array_mut().unwrap().remove(4);
        }
    }
    plan.to_string()
}

fn moves(session: &Session) -> usize {
    let calls = &session.proposal().unwrap().answer.plan.task_cohesion.task_sequence;
    calls.iter().filter(|call| *call == "move_object()").count()
}

/// The two wishes of the paper's figure, with the number of `move_object()` before and after.
const WISHES: [(&str, usize, usize); 2] = [
    ("Insert another move_object() to move the juice upward.", 2, 3),
    ("In this case, you can omit one move_object().", 3, 2),
];

fn juice_session(recorded: &Value, instruction: &str) -> Session {
    let domain = domain("household");
    let world = world_of(&domain, &recorded["environment_before"]);
    let mut session = session("household", domain, world);
    session.instruct(instruction).unwrap();
    session
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn session_applies_wished_changes_of_recorded_plans() {
    let scene = read("household/shelf.json");
    let step = &scene["steps"][0];
    for (says, before, after) in WISHES {
        let mut session = juice_session(&step["recorded"], step["instruction"].as_str().unwrap());
        supply(&mut session, juice(&step["recorded"], before));
        assert_eq!(moves(&session), before);
        session.feedback(says).unwrap();
        supply(&mut session, juice(&step["recorded"], after));
        let proposal = session.proposal().unwrap();
        assert_eq!((moves(&session), proposal.answer.edits.len()), (after, 0), "{says}");
        assert!(proposal.refused.is_empty(), "{:?}", proposal.refused);
        session.accept().unwrap();
        let recorded = &step["recorded"]["environment_after"];
        assert!(is_as_recorded(session.world(), recorded), "{says}");
    }
    println!("== 2 of 2 right");
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn session_refuses_replies_that_ignore_the_wish() {
    let scene = read("household/shelf.json");
    let step = &scene["steps"][0];
    for (says, before, _) in WISHES {
        let mut session = juice_session(&step["recorded"], step["instruction"].as_str().unwrap());
        supply(&mut session, juice(&step["recorded"], before));
        session.feedback(says).unwrap();
        while session.wants_model() {
            supply(&mut session, juice(&step["recorded"], before));
        }
        let proposal = session.proposal().unwrap();
        println!("{says}  ->  {} moves, told: {:?}", moves(&session), proposal.refused);
        assert!(!proposal.refused.is_empty(), "{says}");
    }
}

/// The reply of a model that understands everything.
fn understood(session: &Session, drawn: &Drawn) -> String {
    let world = session.world();
    match session.settings().strategy {
        Strategy::Goal => {
            let goals = drawn.goal.everyday(world);
            serde_json::json!({"question": "", "goals": goals}).to_string()
        }
        Strategy::Direct => {
            let meant = report::of_goal(
                world,
                &drawn.goal,
                &drawn.words,
                &longstep::Limits::default(),
                &Clock::none(),
            );
            serde_json::to_string(&meant.answer.plan).unwrap()
        }
    }
}

/// How many instructions the chains have: of a hundred alone, the slope depends on which are drawn last.
const LENGTH: usize = 500;

/// Carries a chain of drawn instructions through, and returns the tokens of each prompt.
fn chain_of_instructions(strategy: Strategy) -> Vec<f64> {
    let kitchen = read("virtualhome14/kitchen.json");
    let mut draw = chain::draw();
    let first = world_of(&domain("virtualhome"), &kitchen);
    let mut recomputed = Recomputation::new(first.environment());
    let mut session = session("virtualhome", domain("virtualhome"), first);
    session.set_settings(Settings::default().with_strategy(strategy));
    let mut tokens = Vec::new();
    let mut resident = Vec::new();
    let mut sayable = 0;
    for _ in 0..LENGTH {
        let drawn = draw.instruction(session.world());
        let can_be_said = drawn.can_be_said(session.world());
        sayable += usize::from(can_be_said);
        session.instruct(&drawn.words).unwrap();
        let prepared = session.explain(&mut EstimatedTokens::default()).unwrap().unwrap();
        tokens.push(prepared.costs.iter().map(|cost| cost.tokens).sum::<u64>() as f64);
        let reply = understood(&session, &drawn);
        supply(&mut session, reply);
        if session.proposal().is_some() {
            session.accept().unwrap();
            let last = session.accepted().len() - 1;
            recomputed.apply(session.domain(), &session.plan_file(last).unwrap(), session.world());
        } else {
            println!("no plan: {}  (meant {})", drawn.words, drawn.told(session.world()));
            session.cancel().unwrap();
        }
        if !can_be_said {
            println!("not offered: {}  (meant {})", drawn.words, drawn.told(session.world()));
        }
        // Whoever keeps a session writes its events down and does not hold them.
        session.take_events();
        resident.push(memory());
    }
    println!(
        "== {strategy:?}: {} of {LENGTH} accepted and computed once more, {sayable} can be said by a model",
        session.accepted().len()
    );
    println!(
        "== {strategy:?}: mean {:.0} tokens; slope over 100 {:.2}, from the third on {:.2}, over {LENGTH} from the third on {:.3}",
        mean(&tokens[..100]),
        slope(&tokens[..100]),
        slope(&tokens[2..100]),
        slope(&tokens[2..])
    );
    if let (Some(early), Some(late), Some(last)) = (resident[9], resident[99], resident[LENGTH - 1]) {
        println!(
            "== {strategy:?}: peak memory after 10, 100 and {LENGTH} instructions: {:.1}, {:.1} and {:.1} MB",
            early.1, late.1, last.1
        );
        assert!(late.1 - early.1 <= 20.0);
    }
    tokens
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn later_instructions_cost_no_more_than_the_third() {
    for strategy in [Strategy::Goal, Strategy::Direct] {
        let tokens = chain_of_instructions(strategy);
        assert!(slope(&tokens[2..]) < 1.0, "{strategy:?}");
    }
}
