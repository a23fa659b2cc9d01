//! A world of five thousand entities, and a context length of four thousand tokens.

use serde_json::{Map, Value, json};

use crate::dialogue::{
    ChatRequest, ConstraintKind, Dialogue, EstimatedTokens, Reply, TokenCounter, direct_request, focus,
};
use crate::domain::{Domain, shipped};
use crate::environment::{self, Claim, Words, World};
use crate::goal;
use crate::plan::{read, resolve};
use crate::understanding::{Understanding, UnderstandingInput};
use crate::verify::{Purpose, bind, check as verify};
use longstep_core::testing;

const ROOM: u64 = 4000;

/// A depot of 20 halls with 1,000 places and 3,980 objects.
fn depot(domain: &Domain) -> World {
    let kinds = ["bench", "locker", "rack", "chest", "trolley"];
    let things = ["gasket", "spanner", "flange", "rivet", "gauge", "funnel", "lantern"];
    let hall = |n: usize| format!("<hall_{}>", n % 20 + 1);
    let place = |n: usize| format!("<{}_{}>", kinds[n % 5], 1_000 + n);
    let thing = |n: usize| match n {
        1_234 => "<teapot_9999>".to_owned(),
        _ => format!("<{}_{}>", things[n % 7], 3_000 + n),
    };
    let opens = |n: usize| matches!(n % 5, 1 | 3);
    let assets: Vec<String> = (0..20).map(hall).chain((0..1_000).map(place)).collect();
    let asset_states: Map<String, Value> = (0..1_000)
        .map(|n| (place(n), json!([format!("INSIDE({})", hall(n))])))
        .collect();
    let asset_properties: Map<String, Value> = (0..1_000)
        .map(|n| (place(n), json!([if opens(n) { "IS_OPENABLE" } else { "NOT_OPENABLE" }])))
        .collect();
    let object_states: Map<String, Value> = (0..3_980)
        .map(|n| {
            let relation = if opens(n % 1_000) { "INSIDE" } else { "ON" };
            (thing(n), json!([format!("{relation}({})", place(n % 1_000))]))
        })
        .collect();
    let environment = json!({
        "assets": assets, "asset_states": asset_states, "asset_properties": asset_properties,
        "objects": (0..3_980).map(thing).collect::<Vec<_>>(), "object_states": object_states,
    });
    let world = testing::world_of(domain, &environment);
    assert_eq!(world.entities().count(), 5_000);
    world
}

#[track_caller]
fn check_fits(request: &ChatRequest) {
    let tokens = EstimatedTokens::default().tokens(&request.messages);
    assert!(tokens <= ROOM, "{tokens}");
}

/// Checks the dialogue about the depot: the expected reply `answer` leads to a valid plan in the whole depot.
#[track_caller]
fn check(domain: &Domain, depot: &World, instruction: &str, shown: &[&str], answer: &str) {
    let mut counter = EstimatedTokens::default();
    let input = UnderstandingInput::new(domain, depot, instruction, ConstraintKind::JsonSchema);
    let mut fitted = Understanding::fitted(input, Some(ROOM), &mut counter).unwrap();
    assert!(fitted.is_narrowed);
    let part = fitted.dialogue.world().clone();
    let request = fitted.dialogue.request();
    check_fits(&request);
    let turn = &request.messages.last().unwrap().text;
    for name in shown {
        assert!(turn.contains(&format!("- {name}")), "{name} is in {turn}");
    }
    let reply = Reply::complete(json!({"question": "", "goal": answer}).to_string());
    let Some(understood) = fitted.dialogue.supply(&reply).unwrap() else {
        panic!("the answer is whole");
    };
    let found = understood.carried(domain, &part, depot).unwrap().goal.unwrap();
    assert_eq!(found, goal::parse(depot, answer).unwrap());
    testing::plan_for(depot, answer);
}

#[test]
fn goals_in_a_world_of_five_thousand_things() {
    let domain = shipped("virtualhome").unwrap().unwrap();
    let depot = depot(&domain);
    // There are one teapot and 200 places of each kind.
    let teapot = depot.entity(depot.find("<teapot_9999>").unwrap());
    assert_eq!(teapot.name, "teapot");
    check(
        &domain,
        &depot,
        "Put the teapot on bench 12",
        &["teapot: on trolley 47", "bench 12\n"],
        "put(teapot, bench 12)",
    );
    check(
        &domain,
        &depot,
        "Stow gauge 17 away in chest 150",
        &["gauge 17", "chest 150"],
        "put(gauge 17, chest 150)",
    );
    check(&domain, &depot, "Open locker 88", &["locker 88"], "opened(locker 88)");
}

#[test]
fn plans_in_a_world_of_five_thousand_things() {
    let domain = shipped("virtualhome").unwrap().unwrap();
    let depot = depot(&domain);
    let mut counter = EstimatedTokens::default();
    let room = ROOM + 2_000;
    let prepared = direct_request(
        &domain,
        &depot,
        "Put the teapot on bench 12",
        &[],
        &[],
        Some(room),
        &mut counter,
    )
    .unwrap();
    assert!(EstimatedTokens::default().tokens(&prepared.request.messages) <= room);
    let turn = &prepared.request.messages.last().unwrap().text;
    let bench = &depot.entity(depot.find_name("bench 12").unwrap()).identifier;
    for named in ["\"<teapot_9999>\":[\"ON(<trolley_1234>)\"]", bench] {
        assert!(turn.contains(named), "{named} is in {turn}");
    }
}

#[test]
fn a_reply_about_a_part_leaves_the_rest_of_the_world_as_it_was() {
    let domain = shipped("virtualhome").unwrap().unwrap();
    let depot = depot(&domain);
    let bench = depot.entity(depot.find_name("bench 12").unwrap()).identifier.clone();
    let mut counter = EstimatedTokens::default();
    let instruction = "Put the teapot on bench 12";
    let prepared = direct_request(&domain, &depot, instruction, &[], &[], Some(2 * ROOM), &mut counter).unwrap();
    let turn = &prepared.request.messages.last().unwrap().text;
    let shown: Value = serde_json::from_str(turn.split("```").nth(1).unwrap().trim_start_matches("json")).unwrap();
    // The claim of a model that was shown only this part.
    let mut after = shown["environment"].clone();
    after["object_states"]["<teapot_9999>"] = json!([format!("ON({bench})")]);
    let reply = json!({
        "task_cohesion": {
            "task_sequence": [
                "Walktowards(<teapot_9999>)", "Grab(<teapot_9999>)",
                format!("Walktowards({bench})"), format!("Put(<teapot_9999>, {bench})"),
            ],
            "step_instructions": [], "object_name": null, "object_names": [],
        },
        "environment_before": shown["environment"], "environment_after": after,
        "instruction_summary": "", "question": "",
    });
    let draft = read(&reply.to_string()).unwrap();
    let resolved = resolve(&depot, &draft.file.task_cohesion);
    let claim = Claim::read(&depot, &draft.file.environment_after.unwrap());
    assert_eq!(claim.ignored, Vec::<String>::new());
    let (plan, _) = bind(&depot, &resolved.complete().unwrap(), &resolved.objects, Some(&claim)).unwrap();
    let purpose = Purpose {
        claim: Some(claim),
        ..Purpose::default()
    };
    let report = verify(&depot, plan, &purpose);
    assert!(report.violations.is_empty());
    let carried = environment::write(&depot, &report.ending().after);
    let mut expected = depot.environment().clone();
    expected.object_states["<teapot_9999>"] = Words::Many(vec![format!("ON({bench})")]);
    assert_eq!(carried, expected);
}

#[test]
fn the_ranking_is_complete_and_always_the_same() {
    let domain = shipped("virtualhome").unwrap().unwrap();
    let depot = depot(&domain);
    for (instruction, needed) in [("Put the teapot on bench 12", 4), ("", 0), ("Do something", 0)] {
        let found = focus(&depot, instruction);
        let mut sorted = found.ranked.clone();
        sorted.sort_unstable();
        sorted.dedup();
        assert_eq!(sorted.len(), 5_000);
        assert_eq!(found, focus(&depot, instruction));
        assert!(
            (needed..=needed + 2).contains(&found.needed),
            "{instruction}: {}",
            found.needed
        );
    }
}
