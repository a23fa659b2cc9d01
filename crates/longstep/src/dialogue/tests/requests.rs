//! Requests of the direct strategy, shortened to fit.

use serde_json::Value;

use crate::dialogue::{
    ChatRequest, Constraint, EstimatedTokens, Exchange, PromptError, Role, Round, TokenCounter, direct_request,
    direct_schema,
};
use crate::domain::{Domain, shipped};
use crate::environment::World;
use longstep_core::testing;

fn attic(domain: &Domain, trunks: usize) -> World {
    let trunk = |n: usize| format!("<trunk_{n}>");
    let hat = |n: usize| format!("<hat_{n}>");
    let states: serde_json::Map<String, Value> = (1..=trunks)
        .map(|n| (hat(n), format!("inside_something({})", trunk(n)).into()))
        .collect();
    let environment = serde_json::json!({
        "assets": (1..=trunks).map(trunk).collect::<Vec<_>>(),
        "objects": (1..=trunks).map(hat).collect::<Vec<_>>(),
        "object_states": states,
    });
    testing::world_of(domain, &environment)
}

fn history(count: usize) -> Vec<Exchange> {
    let pair = |n: usize| Exchange {
        message: format!("instruction {n} {}", "x".repeat(350)),
        reply: format!("reply {n}"),
    };
    (0..count).map(pair).collect()
}

fn total(request: &ChatRequest) -> u64 {
    EstimatedTokens::default().tokens(&request.messages)
}

/// Compares the dropped exchanges and omitted entities, for 40 trunks with a hat each and 10 earlier exchanges, when
/// the budget is smaller than the whole by this many tokens.
#[track_caller]
fn check(less: u64, expected: Option<(usize, usize)>) {
    let domain = shipped("household").unwrap().unwrap();
    let world = attic(&domain, 40);
    let mut counter = EstimatedTokens::default();
    let mut request = |room| {
        direct_request(
            &domain,
            &world,
            "Put hat 7 into trunk 9",
            &history(10),
            &[],
            room,
            &mut counter,
        )
    };
    let all = request(None).unwrap().request;
    let room = total(&all).saturating_sub(less);
    let found = match request(Some(room + u64::from(all.max_tokens))) {
        Ok(prepared) => {
            assert!(
                total(&prepared.request) + u64::from(prepared.request.max_tokens) <= room + u64::from(all.max_tokens)
            );
            assert_eq!(
                total(&prepared.request),
                prepared.costs.iter().map(|cost| cost.tokens).sum::<u64>()
            );
            let last = &prepared.request.messages.last().unwrap().text;
            for named in ["<hat_7>", "<trunk_7>", "<trunk_9>"] {
                assert!(last.contains(named), "{named} is in {last}");
            }
            Some((prepared.dropped, prepared.left_out))
        }
        Err(PromptError::OverBudget(over)) => {
            assert!(over.by() > 0);
            None
        }
        Err(other) => panic!("{other}"),
    };
    assert_eq!(found, expected);
}

#[test]
fn request_drops_history_before_less_relevant_entities() {
    check(0, Some((0, 0)));
    check(1, Some((1, 0)));
    check(500, Some((5, 0)));
    check(1100, Some((10, 0)));
    check(1300, Some((10, 5)));
    check(1_000_000, None);
}

#[test]
fn request_keeps_all_rounds_after_the_query() {
    let domain = shipped("household").unwrap().unwrap();
    let world = attic(&domain, 2);
    let mut counter = EstimatedTokens::default();
    let round = |n: usize| Round {
        reply: format!("attempt {n}"),
        message: format!("not so {n}"),
    };
    let rounds = [round(1), round(2)];
    let mut request = |room| direct_request(&domain, &world, "Swap them", &history(3), &rounds, room, &mut counter);
    let all = request(None).unwrap().request;
    let texts: Vec<&str> = all.messages[all.fixed..]
        .iter()
        .map(|message| message.text.as_str())
        .collect();
    assert_eq!(texts.len(), 6 + 5);
    assert!(texts[6].contains("Swap them"));
    assert_eq!(texts[7..], ["attempt 1", "not so 1", "attempt 2", "not so 2"]);
    assert_eq!(all.messages.last().unwrap().role, Role::User);
    let cut = request(Some(total(&all) + u64::from(all.max_tokens) - 250)).unwrap();
    assert_eq!(cut.dropped, 3);
    assert_eq!(cut.request.messages[cut.request.fixed..], all.messages[all.fixed + 6..]);
}

/// Checks the rules of OpenAI's strict mode: all keys required, no others.
#[track_caller]
pub(super) fn check_strict(schema: &Value) {
    match schema {
        Value::Object(fields) => {
            if schema["type"] == "object" {
                assert_eq!(schema["additionalProperties"], false);
                let keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
                let required: Vec<&str> = schema["required"]
                    .as_array()
                    .unwrap()
                    .iter()
                    .filter_map(Value::as_str)
                    .collect();
                assert_eq!(keys, required);
            }
            fields.values().for_each(check_strict);
        }
        Value::Array(items) => items.iter().for_each(check_strict),
        _ => {}
    }
}

#[test]
fn direct_schema_is_strict_and_lists_calls_and_entities() {
    let domain = shipped("household").unwrap().unwrap();
    let world = attic(&domain, 3);
    let schema = direct_schema(&world);
    check_strict(&schema);
    let keys: Vec<&String> = schema["properties"].as_object().unwrap().keys().collect();
    let expected = [
        "task_cohesion",
        "environment_before",
        "environment_after",
        "instruction_summary",
        "question",
    ];
    assert_eq!(keys, expected);
    let calls = &schema["properties"]["task_cohesion"]["properties"]["task_sequence"]["items"]["enum"];
    assert_eq!(calls.as_array().unwrap().len(), 13);
    let after = &schema["properties"]["environment_after"]["properties"];
    assert!(after["object_states"]["properties"]["<hat_2>"].is_object());
    assert!(after["asset_states"]["properties"]["<trunk_3>"].is_object());
}

#[test]
fn calls_with_arguments_are_listed_while_they_are_few() {
    let text =
        r#"{"assets": ["<den_1>"], "objects": ["<kite_2>"], "object_states": {"<kite_2>": ["INSIDE(<den_1>)"]}}"#;
    let few = testing::world("virtualhome", text);
    let schema = direct_schema(&few);
    let calls = &schema["properties"]["task_cohesion"]["properties"]["task_sequence"]["items"]["enum"];
    assert!(
        calls
            .as_array()
            .unwrap()
            .contains(&Value::from("Put(<kite_2>, <den_1>)"))
    );
    assert!(!calls.as_array().unwrap().contains(&Value::from("Grab(<den_1>)")));
}

#[test]
fn a_schema_that_would_be_too_large_is_looser() {
    let domain = shipped("household").unwrap().unwrap();
    let schema = direct_schema(&attic(&domain, 100));
    assert!(schema.to_string().len() < 4000);
    let states = &schema["properties"]["environment_after"]["properties"]["object_states"];
    assert_eq!(states["additionalProperties"]["type"], "array");
}

#[test]
fn request_constraint_contains_only_shown_entities() {
    let domain = shipped("household").unwrap().unwrap();
    let world = attic(&domain, 200);
    let mut counter = EstimatedTokens::default();
    let prepared = direct_request(
        &domain,
        &world,
        "Put hat 7 into trunk 9",
        &[],
        &[],
        Some(7500),
        &mut counter,
    )
    .unwrap();
    assert!(prepared.left_out > 200);
    let Constraint::JsonSchema(schema) = &prepared.request.constraint else {
        panic!("a schema");
    };
    check_strict(schema);
    assert!(schema.to_string().contains("<hat_7>"));
}
