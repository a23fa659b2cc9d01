//! Goals about things whose state becomes unknown again when something is done to them, in the pet shop of `scripts`: filling a
//! bowl hides how full it was.

use super::*;
use crate::goal;
use crate::testing;
use longstep_model::domain::{self, Files};
use longstep_verify::verify::check as verify;

fn world() -> World {
    let folder = concat!(env!("CARGO_MANIFEST_DIR"), "/../../lab/understanding/test/petshop");
    let read = |file: &str| std::fs::read_to_string(format!("{folder}/{file}")).unwrap();
    let files = Files {
        pddl: read("domain/domain.pddl"),
        words: read("domain/domain.toml"),
        ..Files::default()
    };
    let domain = domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    let scene: serde_json::Value = serde_json::from_str(&read("scenes/boarding.json")).unwrap();
    let text = scene["environment"].to_string();
    testing::world_of(&domain, &text)
}

#[test]
fn search_solves_two_conditional_fill_goals() {
    let world = world();
    for text in [
        "if half_full(water bowl) then filled(water bowl, water jug)",
        "if half_full(water bowl) then filled(water bowl, water jug) & if empty(cat bowl) then filled(cat bowl, cat food)",
        "if not full(water bowl) then filled(water bowl, water jug) & if empty(cat bowl) then filled(cat bowl, cat food)",
    ] {
        let goal = goal::parse(&world, text).unwrap();
        let purpose = goal.purpose(&world);
        match solve(&world, &Target::of(world.domain(), &purpose), &Limits::default()) {
            Outcome::Solved { plan, .. } => assert_eq!(verify(&world, plan, &purpose).violations, [], "{text}"),
            outcome => panic!("{text}: {outcome:?}"),
        }
    }
}
