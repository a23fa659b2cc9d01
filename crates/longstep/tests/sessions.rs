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

use chain::{Recomputation, SCENES, domain, is_as_recorded, mean, memory, read, slope, world_of};
use longstep::domain::Domain;
use longstep::prompt::{ConstraintKind, EstimatedTokens, Finish, Reply, Usage};
use longstep::session::{ModelFacts, Need, Session, Settings, Strategy};
use longstep::solution;
use longstep::world::World;
use serde_json::Value;

fn session(name: &str, domain: Domain, world: World) -> Session {
    let settings = Settings {
        strategy: Strategy::Direct,
        ..Settings::default()
    };
    let model = ModelFacts {
        name: "recorded".to_owned(),
        kind: ConstraintKind::JsonSchema,
        context: None,
    };
    Session::new(name, domain, world, settings, model, || 0.0)
}

#[track_caller]
fn supply(session: &mut Session, text: String) {
    let need = session.need(&mut EstimatedTokens::default()).unwrap();
    assert!(matches!(need, Need::Model(_)), "{need:?}");
    let reply = Reply {
        text,
        finish: Finish::Stop,
        usage: Usage::default(),
    };
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
                .unwrap_or_else(|| panic!("{instruction}: {:?}", session.stuck()));
            let edits = proposal.answer.edits.len();
            session.accept().unwrap();
            let recorded = &step["recorded"]["environment_after"];
            let good = edits == 0 && is_as_recorded(session.domain(), session.world(), recorded);
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
fn wished_changes_of_the_recorded_plan_come_through() {
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
        assert!(is_as_recorded(session.domain(), session.world(), recorded), "{says}");
    }
    println!("== 2 of 2 right");
}

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn a_reply_that_ignores_the_wish_is_not_taken_for_it() {
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

#[test]
#[ignore = "needs LONGSTEP_CORPUS"]
fn a_hundred_instructions_cost_what_three_do() {
    let kitchen = read("virtualhome14/kitchen.json");
    let mut draw = chain::draw();
    let first = world_of(&domain("virtualhome"), &kitchen);
    let mut recomputed = Recomputation::new(&first.environment);
    let mut session = session("virtualhome", domain("virtualhome"), first);
    let mut tokens = Vec::new();
    let mut resident = Vec::new();
    for number in 0..100 {
        let drawn = draw.instruction(session.domain(), session.world());
        session.instruct(&drawn.words).unwrap();
        let prepared = session.explain(&mut EstimatedTokens::default()).unwrap().unwrap();
        tokens.push(prepared.costs.iter().map(|cost| cost.tokens).sum::<u64>() as f64);
        let meant = solution::of_goal(session.domain(), session.world(), &drawn.goal, &drawn.words, || 0.0);
        supply(&mut session, serde_json::to_string(&meant.answer.plan).unwrap());
        let proposal = session
            .proposal()
            .unwrap_or_else(|| panic!("{}: {:?}", drawn.words, session.stuck()));
        assert!(proposal.answer.edits.is_empty(), "{}", drawn.words);
        session.accept().unwrap();
        recomputed.apply(session.domain(), &session.plan_file(number).unwrap(), session.world());
        // Whoever keeps a session writes its events down and does not hold them.
        session.take_events();
        println!("{:3} {:6} tokens  {}", number + 1, tokens[number], drawn.words);
        resident.push(memory());
    }
    let settled = &tokens[2..];
    println!(
        "== direct: mean {:.0} tokens; slope {:.2} over all, {:.2} from the third instruction",
        mean(&tokens),
        slope(&tokens),
        slope(settled)
    );
    if let (Some(early), Some(late)) = (resident[9], resident[99]) {
        println!(
            "== memory after 10 and 100 instructions: {:.1} and {:.1} MB resident, peak {:.1} and {:.1} MB",
            early.0, late.0, early.1, late.1
        );
        assert!(late.1 - early.1 <= 20.0);
    }
    assert!(slope(settled) < 1.0);
}
