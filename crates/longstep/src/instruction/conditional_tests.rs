//! Goals that depend on sensing: notation, parsing, grammar and interpretation.

use crate::domain::{self, Domain};
use crate::environment::World;
use crate::goal::*;
use longstep_core::testing;

fn kitchen() -> (Domain, World) {
    let domain = domain::shipped("household-checks").unwrap().unwrap();
    let text = r#"{"assets": ["<table>", "<fridge>", "<trash_bin>"], "objects": ["<milk>", "<sponge>", "<fridge_handle>"],
        "object_states": {"<milk>": ["on_something(<table>)"], "<sponge>": ["on_something(<table>)"],
        "<fridge_handle>": ["closed()"]}}"#;
    let world = testing::world_of(&domain, text);
    (domain, world)
}

/// Compares a parsed goal, written for the model and as a sentence, or the parse error.
#[track_caller]
fn check(text: &str, written: &str, sentence: &str) {
    let (_, world) = kitchen();
    match parse(&world, text) {
        Ok(goal) => {
            let everyday: Vec<String> = goal.facts.iter().map(|fact| fact.everyday(&world)).collect();
            let sentences: Vec<String> = goal.facts.iter().map(|fact| fact.sentence(&world)).collect();
            assert_eq!(
                (everyday.join(" & ").as_str(), sentences.join("; ").as_str()),
                (written, sentence),
                "{text}"
            );
            let exact: Vec<String> = goal.facts.iter().map(|fact| fact.exact(&world)).collect();
            assert_eq!(parse(&world, &exact.join(" & ")), Ok(goal), "{text}");
        }
        Err(error) => assert_eq!((written, error.to_string().as_str()), ("", sentence), "{text}"),
    }
}

#[test]
fn conditional_goals_are_read_and_written() {
    let both = "if expired(milk) then put(milk, trash bin) else put(milk, fridge)";
    check(
        both,
        both,
        "if the milk is past its date, the milk is at the trash bin, and otherwise the milk is at the fridge",
    );
    let beside =
        "closed(fridge) & if dirty(table) then wiped(table, sponge) and put(sponge, fridge) & put(milk, table)";
    check(
        beside,
        beside,
        "the fridge is closed; if the table is dirty, the table has been wiped with the sponge and the sponge is at the \
         fridge; the milk is at the table",
    );
    // With two outcomes, the negation of one is the other.
    check(
        "if not expired(<milk>) then put(milk, fridge)",
        "if fresh(milk) then put(milk, fridge)",
        "if the milk is not past its date, the milk is at the fridge",
    );
    check(
        "if not empty(milk) then put(milk, fridge)",
        "if not empty(milk) then put(milk, fridge)",
        "unless the milk is empty, the milk is at the fridge",
    );
    check(
        "if open(fridge) then put(milk, fridge)",
        "",
        "`open(fridge)` is nothing that sensing tells here, so no goal can depend on it; write `fresh(...)`, \
         `expired(...)`, `empty(...)`, `half_full(...)`, `full(...)`, `intact(...)`, `broken(...)`, `clean(...)`, \
         `dirty(...)`",
    );
    check(
        "if expired(milk) then",
        "",
        "`if expired(milk) then` is not a goal of this domain; write `put(ITEM, PLACE)`, `opened(THING)`, `closed(THING)`, `adjusted(THING)`, `wiped(PLACE, TOOL)`",
    );
    check(
        "if expired(milk) then  else put(milk, fridge)",
        "",
        "the goal has an empty part",
    );
}
