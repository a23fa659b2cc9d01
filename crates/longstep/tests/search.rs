//! Search against brute force: on small random worlds both find plans of the same length, or both none.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use std::collections::{HashMap, VecDeque};

use longstep::domain::{self, Domain, Files, RuleTime};
use longstep::goal;
use longstep_core::environment::{EntityId, Moment, State, World, holds};
use longstep_core::search::{self, Effort, Limits, Outcome, Wanted};
use longstep_core::testing;
use longstep_core::verify::{apply, broken_bindings, check, unmet};
use proptest::prelude::*;

/// Every action with every choice of arguments.
fn all_actions(world: &World) -> Vec<(domain::ActionId, Vec<EntityId>)> {
    let domain = world.domain();
    let mut all = Vec::new();
    for (id, action) in domain.action_ids() {
        let mut choices: Vec<Vec<EntityId>> = vec![Vec::new()];
        for parameter in &action.parameters {
            let longer = |choice: Vec<EntityId>| {
                world
                    .of_kind(parameter.kind)
                    .iter()
                    .map(move |e| [&choice[..], &[*e]].concat())
                    .collect::<Vec<_>>()
            };
            choices = choices.into_iter().flat_map(longer).collect();
        }
        all.extend(choices.into_iter().map(|arguments| (id, arguments)));
    }
    all
}

/// Returns whether a rule for every state is broken after a step and not before it.
fn breaks_a_rule(world: &World, before: &State, after: &State) -> bool {
    let domain = world.domain();
    let mut rules = domain.rules.iter().filter(|rule| rule.time == RuleTime::Always);
    rules.any(|rule| {
        let known = broken_bindings(rule, world, before);
        broken_bindings(rule, world, after)
            .iter()
            .any(|broken| !known.contains(broken))
    })
}

/// The number of steps of a shortest plan, by trying everything in order of length.
fn brute_force(world: &World, wanted: &[Wanted]) -> Option<usize> {
    let domain = world.domain();
    let reached = |state: &State| {
        wanted
            .iter()
            .all(|w| holds(Moment { world, state }, &w.condition, &mut w.bindings.clone()))
    };
    let actions = all_actions(world);
    let mut depth: HashMap<State, usize> = HashMap::from([(world.state.clone(), 0)]);
    let mut queue = VecDeque::from([world.state.clone()]);
    while let Some(state) = queue.pop_front() {
        let steps = depth[&state.clone()];
        if reached(&state) {
            return Some(steps);
        }
        for (id, arguments) in &actions {
            let action = domain.action(*id);
            if unmet(world, &state, &action.precondition, &mut arguments.clone()).is_empty() {
                let mut next = state.clone();
                apply(world, &mut next, action, arguments);
                if breaks_a_rule(world, &state, &next) {
                    continue;
                }
                if let std::collections::hash_map::Entry::Vacant(entry) = depth.entry(next.clone()) {
                    entry.insert(steps + 1);
                    queue.push_back(next);
                }
            }
        }
    }
    None
}

fn compare(domain_name: &str, environment: &str, goal: &str) -> Result<(), TestCaseError> {
    let domain = domain::shipped(domain_name).unwrap().unwrap();
    compare_in(&domain, environment, goal)
}

/// The robot of the starter, with one more rule.
fn parcels(condition: &str) -> Domain {
    let mut files = Files::from_texts("starter/", domain::starter("starter"));
    let rule = format!(
        "\n[[rule]]\nname = \"extra\"\nholds = \"always\"\ncondition = \"{condition}\"\nsays = \"not like this\"\n"
    );
    files.words = files.words.replacen("\n[[rule]]", &format!("{rule}\n[[rule]]"), 1);
    let domain = domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"));
    assert!(domain.rules.iter().any(|rule| rule.time == RuleTime::Always));
    domain
}

fn compare_in(domain: &Domain, environment: &str, goal: &str) -> Result<(), TestCaseError> {
    let world = testing::world_of(domain, environment);
    let goal = goal::parse(&world, goal).unwrap();
    let purpose = goal.purpose(&world);
    let expected = brute_force(&world, &purpose.at_end(domain));
    let limits = Limits::default()
        .with_direct(100_000)
        .with_proof(100_000)
        .with_shortest(100_000)
        .with_any(0)
        .with_effort(Effort::default());
    match search::solve(&world, &purpose, &limits) {
        Outcome::Solved { plan, shortest, .. } => {
            prop_assert!(shortest);
            prop_assert_eq!(Some(plan.steps().len()), expected);
            let report = check(&world, plan, &purpose);
            prop_assert_eq!(report.violations, vec![]);
        }
        Outcome::ProvenUnsolvable { .. } => prop_assert_eq!(expected, None),
        Outcome::GaveUp { why, .. } => prop_assert!(false, "gave up: {}", why),
    }
    // Greedy search alone finds a plan as well, or proves that there is none.
    let limits = Limits::default()
        .with_direct(0)
        .with_proof(0)
        .with_shortest(0)
        .with_any(100_000)
        .with_effort(Effort::default());
    match search::solve(&world, &purpose, &limits) {
        Outcome::Solved {
            plan,
            shortest,
            at_least,
            ..
        } => {
            let (found, expected) = (plan.steps().len(), expected.unwrap_or(usize::MAX));
            prop_assert!(found >= expected && (!shortest || found == expected));
            prop_assert!(at_least as usize <= expected);
            prop_assert_eq!(check(&world, plan, &purpose).violations, vec![]);
        }
        Outcome::ProvenUnsolvable { .. } => prop_assert_eq!(expected, None),
        Outcome::GaveUp { why, .. } => prop_assert!(false, "gave up: {}", why),
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn household(place in prop::sample::select(vec!["counter", "shelf", "fridge", "trash bin"]),
                 cup in prop::sample::select(vec!["on_something(<counter>)", "on_something(<shelf>)", "inside_something(<fridge>)"]),
                 door in prop::sample::select(vec!["open()", "closed()"]),
                 more in prop::sample::select(vec!["", " & closed(fridge)", " & opened(fridge)", " & wiped(shelf, cup)"])) {
        let environment = format!(
            r#"{{"assets": ["<counter>", "<shelf>", "<fridge>", "<trash_bin>"], "objects": ["<cup>", "<fridge_handle>"],
                "object_states": {{"<cup>": "{cup}", "<fridge_handle>": "{door}"}}}}"#);
        compare("household", &environment, &format!("put(cup, {place}){more}"))?;
    }

    #[test]
    fn virtualhome(goal in prop::sample::select(vec![
                       "put(mug, sink)", "heated(pie, stove)", "drunk(mug)", "wet(pie)", "moved(pie)", "held(mug)",
                       "put(mug, sink) & put(pie, sink)", "put(mug, stove) & off(stove)", "drunk(mug) & put(mug, desk)"]),
                   mug in prop::sample::select(vec!["ON(<desk_1>)", "INSIDE(<stove_2>)", "ON(<sink_3>)"]),
                   stove in prop::sample::select(vec!["OPEN()", "CLOSED()", "SWITCHED_ON()"])) {
        let environment = format!(
            r#"{{"assets": ["<desk_1>", "<stove_2>", "<sink_3>", "<faucet_4>"], "asset_states": {{"<stove_2>": ["{stove}"]}},
                "objects": ["<mug_5>", "<pie_6>"], "object_states": {{"<mug_5>": ["{mug}"], "<pie_6>": ["ON(<desk_1>)"]}},
                "asset_properties": {{"<stove_2>": ["IS_OPENABLE", "HAS_SWITCH"], "<faucet_4>": ["HAS_SWITCH"]}}}}"#);
        compare("virtualhome", &environment, goal)?;
    }

    #[test]
    fn search_agrees_with_enumeration_under_rules_for_every_state(
        places in prop::collection::vec(prop::sample::select(vec!["at(<gate>)", "at(<kiosk>)", "at(<desk>)"]), 3),
        carried in any::<bool>(),
        rule in prop::sample::select(vec![
            "(forall (?a - parcel ?b - parcel ?s - station) (not (and (at ?a ?s) (at ?b ?s) (not (= ?a ?b)))))",
            "(forall (?p - parcel) (not (carrying ?p)))",
            "(forall (?p - parcel ?s - station) (imply (robot-at ?s) (or (carrying ?p) (exists (?q - parcel) (at ?q ?s)))))",
        ]),
        goal in prop::sample::select(vec!["bring(box, kiosk)", "bring(box, desk) & bring(sack, gate)", "bring(crate, desk)"]),
    ) {
        let first = if carried { "carried()" } else { places[0] };
        let environment = format!(
            r#"{{"assets": ["<gate>", "<kiosk>", "<desk>"], "asset_states": {{"<gate>": "robot_here()"}},
                "objects": ["<box>", "<sack>", "<crate>"],
                "object_states": {{"<box>": "{first}", "<sack>": "{}", "<crate>": "{}"}}}}"#, places[1], places[2]);
        compare_in(&parcels(rule), &environment, goal)?;
    }
}

#[test]
fn a_rule_that_is_broken_at_the_start_does_not_forbid_every_plan() {
    let domain = parcels("(forall (?p - parcel) (not (carrying ?p)))");
    let environment = r#"{"assets": ["<desk>", "<gate>"], "asset_states": {"<desk>": "robot_here()"},
        "objects": ["<box>"], "object_states": {"<box>": "carried()"}}"#;
    compare_in(&domain, environment, "bring(box, desk)").unwrap();
    let world = testing::world_of(&domain, environment);
    let goal = goal::parse(&world, "bring(box, desk)").unwrap();
    let outcome = search::solve(&world, &goal.purpose(&world), &Limits::default());
    assert!(
        matches!(&outcome, Outcome::Solved { plan, .. } if plan.steps().len() == 1),
        "{outcome:?}"
    );
}
