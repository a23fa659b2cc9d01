//! Tests from drafts to edits, and a comparison with exhaustive search on random domains.

use std::cmp::Reverse;
use std::collections::{BinaryHeap, HashMap};

use proptest::prelude::*;

use super::*;
use crate::goal;
use crate::pddl::read_problem;
use crate::search::{self, Limits};
use crate::testing;
use longstep_model::domain::{self, Files};
use longstep_model::environment::{self, Claim};
use longstep_model::model::{ActionId, EntityId, Environment, Moment, State, holds};
use longstep_verify::plan::{Plan, PlanFile, TaskCohesion, resolve};
use longstep_verify::verify::{self, Report, apply, can_apply, unmet};

const KITCHEN: &str = r#"{
    "assets": ["<desk_1>", "<oven_2>", "<sink_3>", "<faucet_7>"],
    "objects": ["<pie_4>", "<mug_5>", "<plate_6>"],
    "object_states": {"<pie_4>": ["ON(<desk_1>)"], "<mug_5>": ["INSIDE(<oven_2>)"], "<plate_6>": ["ON(<desk_1>)"]},
    "asset_properties": {"<oven_2>": ["IS_OPENABLE"], "<desk_1>": ["NOT_OPENABLE"], "<sink_3>": ["NOT_OPENABLE"]}}"#;

fn written(calls: &[&str]) -> TaskCohesion {
    TaskCohesion {
        task_sequence: calls.iter().map(|call| (*call).to_owned()).collect(),
        ..TaskCohesion::default()
    }
}

/// Returns the claim with these changes to the world.
fn claim(world: &World, entries: &[(&str, &str)]) -> Option<Claim> {
    let mut environment = world.environment().clone();
    for (identifier, word) in entries {
        let states = if environment.assets.iter().any(|asset| asset == identifier) {
            &mut environment.asset_states
        } else {
            &mut environment.object_states
        };
        states.insert(
            (*identifier).to_owned(),
            environment::Words::Many(vec![(*word).to_owned()]),
        );
    }
    (!entries.is_empty()).then(|| Claim::read(world, &environment))
}

#[track_caller]
fn check(calls: &[&str], claimed: &[(&str, &str)], expected: &[&str]) {
    let world = testing::world("virtualhome", KITCHEN);
    let purpose = Purpose {
        claim: claim(&world, claimed),
        ..Purpose::default()
    };
    let draft = resolve(&world, &written(calls));
    let found: Vec<String> = match repair(&world, &draft, &purpose) {
        RepairOutcome::Valid(_) => vec!["valid".to_owned()],
        RepairOutcome::Repaired(repaired) => repaired
            .edits
            .iter()
            .map(|edit| edit.description(calls.len()))
            .collect(),
        other => vec![format!("{other:?}")],
    };
    assert_eq!(found, expected);
}

#[test]
fn repair_leaves_valid_plans_unchanged() {
    check(&[], &[], &["valid"]);
    let calls = [
        "Walktowards(<desk_1>)",
        "Grab(<pie_4>)",
        "Walktowards(<sink_3>)",
        "Put(<pie_4>, <sink_3>)",
    ];
    check(&calls, &[("<pie_4>", "ON(<sink_3>)")], &["valid"]);
}

#[test]
fn repair_inserts_steps_that_the_plan_lacks() {
    check(&["Grab(<pie_4>)"], &[], &["insert Walktowards(<pie_4>) before step 1"]);
    check(
        &["Walktowards(<oven_2>)", "Grab(<mug_5>)"],
        &[],
        &["insert Open(<oven_2>) before step 2", "add Close(<oven_2>) at the end"],
    );
    // Only the claim shows that more is to be done.
    check(
        &["Walktowards(<desk_1>)", "Grab(<pie_4>)"],
        &[("<pie_4>", "ON(<sink_3>)")],
        &[
            "add Walktowards(<sink_3>) at the end",
            "add Put(<pie_4>, <sink_3>) at the end",
        ],
    );
}

#[test]
fn repair_replaces_a_wrong_action() {
    let calls = [
        "Walktowards(<desk_1>)",
        "Grab(<pie_4>)",
        "Walktowards(<sink_3>)",
        "PutIn(<pie_4>, <sink_3>)",
    ];
    let edit = ["in step 4, Put(<pie_4>, <sink_3>) instead of PutIn(<pie_4>, <sink_3>)"];
    check(&calls, &[], &edit);
    // An unachievable claim is fulfilled as closely as possible.
    check(&calls, &[("<pie_4>", "INSIDE(<sink_3>)")], &edit);
}

#[test]
fn repair_removes_impossible_steps_and_steps_without_effect() {
    check(
        &[
            "Walktowards(<desk_1>)",
            "Open(<desk_1>)",
            "Grab(<pie_4>)",
            "Close(<desk_1>)",
        ],
        &[],
        &["leave out step 2, Open(<desk_1>)", "leave out step 4, Close(<desk_1>)"],
    );
    check(
        &["Walktowards(<desk_1>)", "Grab(<pie_4>)", "Grab(<pie_4>)"],
        &[],
        &["leave out step 3, Grab(<pie_4>)"],
    );
    check(
        &["Walktowards(<desk_1>)", "Juggle(<pie_4>)", "Grab(<pie_4>)"],
        &[("<pie_4>", "HELD()")],
        &["leave out step 2, Juggle(<pie_4>)"],
    );
}

#[test]
fn repair_reports_unclear_steps_instead_of_guessing() {
    // Without a claim, the purpose of these steps is unknown.
    check(
        &["Walktowards(<desk_1>)", "Juggle(<pie_4>)"],
        &[],
        &[
            "Unclear { why: \"step 2: `Juggle` is no action of the domain `virtualhome`; and the plan does not claim what \
             the world is to be afterwards\" }",
        ],
    );
    let world = testing::world("household", r#"{"objects": ["<cup>"], "object_states": {}}"#);
    let draft = TaskCohesion {
        object_name: Some("<pear>".to_owned()),
        ..written(&["grasp_object()"])
    };
    let outcome = repair(&world, &resolve(&world, &draft), &Purpose::default());
    assert!(matches!(outcome, RepairOutcome::Unclear { .. }), "{outcome:?}");
}

#[test]
fn repair_moves_a_step_that_comes_too_early() {
    check(
        &["Grab(<pie_4>)", "Walktowards(<desk_1>)"],
        &[],
        &["do step 1, Grab(<pie_4>), later, as step 2"],
    );
}

#[test]
fn repair_keeps_steps_that_have_an_effect() {
    // Drinking changes no state that an environment expresses.
    check(
        &["Walktowards(<desk_1>)", "Open(<desk_1>)", "Drink(<mug_5>)"],
        &[],
        &[
            "leave out step 2, Open(<desk_1>)",
            "insert Walktowards(<oven_2>) before step 3",
            "insert Open(<oven_2>) before step 3",
            "insert Grab(<mug_5>) before step 3",
            "insert Close(<oven_2>) before step 3",
        ],
    );
}

#[test]
fn step_is_idle_only_if_its_conditional_effects_change_nothing_either() {
    let domain = domain::from_pddl(
        "kettle.pddl",
        "(define (domain kettle) (:requirements :adl) (:types kettle)
           (:predicates (plugged ?k - kettle) (on ?k - kettle) (full ?k - kettle) (cold ?k - kettle))
           (:action fill :parameters (?k - kettle) :precondition () :effect (full ?k))
           (:action plug :parameters (?k - kettle) :precondition () :effect (plugged ?k))
           (:action press :parameters (?k - kettle) :precondition (plugged ?k)
             :effect (and (on ?k) (when (full ?k) (not (cold ?k))))))",
    )
    .unwrap();
    for (facts, expected) in [
        ("(on kettle) (cold kettle)", ["leave out step 1, press(kettle)"]),
        (
            "(on kettle) (cold kettle) (full kettle)",
            ["insert plug(kettle) before step 1"],
        ),
        ("(on kettle) (full kettle)", ["leave out step 1, press(kettle)"]),
    ] {
        let problem =
            format!("(define (problem p) (:domain kettle) (:objects kettle - kettle) (:init {facts}) (:goal ()))");
        let world = read_problem(&domain, "problem.pddl", &problem).unwrap().world;
        let draft = resolve(&world, &written(&["press(kettle)"]));
        let RepairOutcome::Repaired(repaired) = repair(&world, &draft, &Purpose::default()) else {
            panic!("it can be repaired");
        };
        let edits: Vec<String> = repaired.edits.iter().map(|edit| edit.description(1)).collect();
        assert_eq!(edits, expected, "{facts}");
    }
}

#[test]
fn repair_gives_a_reason_for_each_edit() {
    let world = testing::world("virtualhome", KITCHEN);
    let calls = [
        "Walktowards(<desk_1>)",
        "Open(<desk_1>)",
        "Grab(<pie_4>)",
        "Walktowards(<oven_2>)",
        "PutIn(<pie_4>, <oven_2>)",
    ];
    let draft = resolve(&world, &written(&calls));
    let RepairOutcome::Repaired(repaired) = repair(&world, &draft, &Purpose::default()) else {
        panic!("it can be repaired");
    };
    let whys: Vec<_> = repaired.edits.iter().map(|edit| edit.why.as_str()).collect();
    assert_eq!(
        whys,
        [
            "it can never be done here: it needs that the desk can be opened",
            "PutIn(<pie_4>, <oven_2>) needs that the oven is not closed",
            "SwitchOn(<oven_2>) needs that the oven is not open",
            "the oven must be closed and switched on, since the pie was put into it to be heated",
        ]
    );
}

#[test]
fn plans_with_hidden_arguments_are_repaired_too() {
    let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
        "object_states": {"<milk>": "on_something(<counter>)", "<fridge_handle>": "closed()"}}"#;
    let world = testing::world("household", text);
    let file: PlanFile = serde_json::from_str(
        r#"{"task_cohesion": {"task_sequence": ["move_hand()", "grasp_object()", "detach_from_plane()",
            "move_object()", "attach_to_plane()", "release_object()"],
            "step_instructions": ["move the hand to the milk", "grasp the milk", "pick up the milk",
            "move the milk to the fridge", "put the milk into the fridge", "release the milk"],
            "object_name": "<milk>"},
            "environment_after": {"assets": ["<counter>", "<fridge>"], "objects": ["<milk>", "<fridge_handle>"],
            "object_states": {"<milk>": "inside_something(<fridge>)", "<fridge_handle>": "closed()"}}}"#,
    )
    .unwrap();
    let draft = resolve(&world, &file.task_cohesion);
    let purpose = Purpose {
        claim: Some(Claim::read(&world, file.environment_after.as_ref().unwrap())),
        ..Purpose::default()
    };
    let RepairOutcome::Repaired(repaired) = repair(&world, &draft, &purpose) else {
        panic!("it can be repaired");
    };
    let inserted: Vec<_> = repaired.edits.iter().map(|edit| edit.description(6)).collect();
    assert_eq!(inserted.len(), 8, "{inserted:?}");
    let after = environment::write(&world, &repaired.plan.ending().after);
    assert_eq!(after.object_states["<milk>"].as_slice(), ["inside_something(<fridge>)"]);
    assert_eq!(after.object_states["<fridge_handle>"].as_slice(), ["closed()"]);
}

// --- comparison with exhaustive search --------------------------------------------------------------------------

/// Computes the least cost of a repair with Dijkstra's algorithm over draft position, postponed step and state.
fn least_cost(world: &World, draft: &Resolved, purpose: &Purpose, as_if: &State) -> Option<u32> {
    let domain = world.domain();
    let meant = target::meant(world, draft, purpose, as_if);
    let costs = domain.repair;
    let actions: Vec<(ActionId, Vec<EntityId>)> = all_actions(world);
    let applicable = |state: &State, (id, arguments): &(ActionId, Vec<EntityId>)| {
        unmet(world, state, &domain.action(*id).precondition, &mut arguments.clone()).is_empty()
    };
    let done = |state: &State, (id, arguments): &(ActionId, Vec<EntityId>)| {
        let mut next = state.clone();
        apply(world, &mut next, domain.action(*id), arguments);
        next
    };
    let steps: Vec<(ActionId, Vec<EntityId>)> = draft
        .steps
        .iter()
        .flatten()
        .map(|step| (step.action, step.arguments.iter().copied().flatten().collect()))
        .collect();
    // The unconditional effects of an action: these domains have no conditional effects.
    let brings = |(id, arguments): &(ActionId, Vec<EntityId>)| -> Vec<(Fact, bool)> {
        let effects = domain.action(*id).effects.iter();
        let all: Vec<_> = effects
            .map(|e| (longstep_model::model::ground(&e.atom, arguments), e.adds))
            .collect();
        let kept = |(fact, adds): &&(Fact, bool)| *adds || !all.contains(&(*fact, true));
        all.iter().filter(kept).copied().collect()
    };
    let replaces = |new: &(ActionId, Vec<EntityId>), old: &(ActionId, Vec<EntityId>)| {
        let same_things = new.1.iter().all(|entity| old.1.contains(entity));
        let brought = brings(old);
        new.0 != old.0
            && can_apply(world, new.0, &new.1)
            && same_things
            && brings(new).iter().any(|effect| brought.contains(effect))
    };
    let end_cost = |state: &State| {
        let moment = Moment { world, state };
        let reached = meant
            .required
            .iter()
            .all(|wanted| holds(moment, &wanted.condition, &mut wanted.bindings.clone()));
        let promises = meant.promises.iter().map(|promise| match state.holds(promise.fact) {
            true => 0,
            false if promise.related.iter().any(|fact| state.holds(*fact)) => costs.other_relation,
            false => costs.forgo,
        });
        let kept = meant
            .kept
            .iter()
            .map(|fact| if state.holds(*fact) { 0 } else { costs.unsettle });
        reached.then(|| promises.chain(kept).sum::<u32>())
    };
    type Key = (usize, Option<usize>, State);
    let mut open: BinaryHeap<Reverse<(u32, usize)>> = BinaryHeap::new();
    let mut keys: Vec<Key> = Vec::new();
    let mut known: HashMap<Key, u32> = HashMap::new();
    let start: Key = (0, None, world.state.clone());
    known.insert(start.clone(), 0);
    keys.push(start);
    open.push(Reverse((0, 0)));
    let mut best: Option<u32> = None;
    while let Some(Reverse((cost, number))) = open.pop() {
        let key = keys[number].clone();
        if known[&key] < cost || best.is_some_and(|best| best <= cost) {
            continue;
        }
        let (at, aside, state) = &key;
        if *at == steps.len()
            && aside.is_none()
            && let Some(end) = end_cost(state)
        {
            best = Some(best.map_or(cost + end, |best| best.min(cost + end)));
        }
        let mut next: Vec<(u32, Key)> = Vec::new();
        for action in actions.iter().filter(|action| applicable(state, action)) {
            next.push((costs.insert, (*at, *aside, done(state, action))));
        }
        if let Some(step) = steps.get(*at) {
            let possible = can_apply(world, step.0, &step.1);
            let substitutes: Vec<_> = actions.iter().filter(|action| replaces(action, step)).collect();
            if applicable(state, step) {
                next.push((0, (at + 1, *aside, done(state, step))));
            }
            for action in substitutes.iter().filter(|action| applicable(state, action)) {
                next.push((costs.replace, (at + 1, *aside, done(state, action))));
            }
            let idle = brings(step).iter().all(|(fact, adds)| state.holds(*fact) == *adds);
            let drop = match (possible || !substitutes.is_empty(), idle) {
                (false, _) => costs.drop_impossible,
                (true, true) => costs.drop_idle,
                (true, false) => costs.drop,
            };
            next.push((drop, (at + 1, *aside, state.clone())));
            if aside.is_none() && possible && steps.len() > 1 {
                next.push((costs.postpone, (at + 1, Some(*at), state.clone())));
            }
        }
        if let Some(step) = aside.map(|index| &steps[index])
            && applicable(state, step)
        {
            next.push((0, (*at, None, done(state, step))));
        }
        for (more, key) in next {
            let total = cost + more;
            if known.get(&key).is_none_or(|known| *known > total) {
                known.insert(key.clone(), total);
                keys.push(key);
                open.push(Reverse((total, keys.len() - 1)));
            }
        }
    }
    best
}

fn all_actions(world: &World) -> Vec<(ActionId, Vec<EntityId>)> {
    let mut all = Vec::new();
    for (id, action) in world.domain().action_ids() {
        let mut choices: Vec<Vec<EntityId>> = vec![Vec::new()];
        for parameter in &action.parameters {
            let of_kind = world.of_kind(parameter.kind);
            let longer = |choice: Vec<EntityId>| of_kind.iter().map(move |e| [&choice[..], &[*e]].concat());
            choices = choices.into_iter().flat_map(longer).collect();
        }
        all.extend(choices.into_iter().map(|arguments| (id, arguments)));
    }
    all
}

/// Preconditions and effects of an action, as literal numbers with truth values.
type RandomAction = (Vec<(u8, bool)>, Vec<(u8, bool)>);

/// Returns a domain with three properties, a relation and the given actions.
fn random_domain(actions: &[RandomAction]) -> Domain {
    let atom = |which: u8| ["(a ?x)", "(b ?x)", "(c ?x)", "(r ?x ?y)", "(a ?y)", "(s ?x)"][usize::from(which) % 6];
    let literal = |(which, holds): &(u8, bool)| match holds {
        true => atom(*which).to_owned(),
        false => format!("(not {})", atom(*which)),
    };
    let conjunction = |literals: &[(u8, bool)]| literals.iter().map(literal).collect::<Vec<_>>().join(" ");
    let mut pddl = String::from(
        "(define (domain random) (:requirements :typing :negative-preconditions) (:types asset item - thing)
         (:predicates (a ?x - thing) (b ?x - thing) (c ?x - thing) (s ?x - thing) (r ?x - thing ?y - thing))\n",
    );
    let mut words =
        String::from("name = \"random\"\nabout = \"x\"\n[environment]\nassets = \"asset\"\nobjects = \"item\"\n");
    for name in ["a", "b", "c", "s"] {
        let upper = name.to_uppercase();
        words.push_str(&format!(
            "[[predicate]]\nname = \"{name}\"\nsays = \"{{x}} {name}\"\ndenies = \"{{x}} not {name}\"\n\
             [[state]]\nword = \"{upper}()\"\nfact = \"({name} ?self)\"\nmeans = \"{name}\"\n"
        ));
    }
    words.push_str(
        "[[predicate]]\nname = \"r\"\nsays = \"{x} r {y}\"\ndenies = \"{x} not r {y}\"\n\
         [[state]]\nword = \"R(<y>)\"\nfact = \"(r ?self ?y)\"\nmeans = \"r\"\n",
    );
    for (index, (needs, gives)) in actions.iter().enumerate() {
        // Static predicates cannot be effects.
        let gives: Vec<(u8, bool)> = gives.iter().map(|(which, holds)| (which % 5, *holds)).collect();
        pddl.push_str(&format!(
            "(:action act{index} :parameters (?x - thing ?y - thing) :precondition (and {}) :effect (and {}))\n",
            conjunction(needs),
            conjunction(&gives)
        ));
        words.push_str(&format!(
            "[[action]]\nname = \"act{index}\"\ncall = \"Act{index}(?x, ?y)\"\nsays = \"{{x}} {{y}}\"\nmeans = \"x\"\n"
        ));
    }
    pddl.push(')');
    let files = Files {
        pddl,
        words,
        ..Files::default()
    };
    domain::load(&files).unwrap_or_else(|e| panic!("{e}"))
}

fn literals(most: usize) -> impl Strategy<Value = Vec<(u8, bool)>> {
    prop::collection::vec((0u8..6, any::<bool>()), 0..=most)
}

const ENTITIES: [&str; 2] = ["<one>", "<two>"];

fn environment(facts: &[(usize, u8)]) -> String {
    let states = |entity: usize| -> Vec<&str> {
        let of = facts.iter().filter(|(other, _)| *other == entity);
        let mut words: Vec<&str> = of
            .map(|(_, which)| ["A()", "B()", "C()", "S()", "R(<one>)", "R(<two>)"][usize::from(which % 6)])
            .collect();
        words.sort_unstable();
        words.dedup();
        words
    };
    serde_json::json!({"assets": [ENTITIES[0]], "objects": [ENTITIES[1]],
        "asset_states": {ENTITIES[0]: states(0)}, "object_states": {ENTITIES[1]: states(1)}})
    .to_string()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, ..ProptestConfig::default() })]

    #[test]
    fn repair_finds_the_cheapest_edits(
        actions in prop::collection::vec((literals(2), prop::collection::vec((0u8..5, any::<bool>()), 1..=2)), 2..=4),
        calls in prop::collection::vec((0usize..4, 0usize..2, 0usize..2), 1..=3),
        before in prop::collection::vec((0usize..2, 0u8..6), 0..4),
        claimed in prop::option::of(prop::collection::vec((0usize..2, 0u8..6), 0..4)),
    ) {
        let domain = random_domain(&actions);
        let world = testing::world_of(&domain, environment(&before));
        let calls: Vec<String> = calls
            .iter()
            .map(|(action, x, y)| format!("Act{}({}, {})", action % actions.len(), ENTITIES[*x], ENTITIES[*y]))
            .collect();
        let calls: Vec<&str> = calls.iter().map(String::as_str).collect();
        let draft = resolve(&world, &written(&calls));
        let purpose = Purpose {
            claim: claimed.map(|facts| {
                Claim::read(&world, &Environment::from_json(&environment(&facts)).unwrap())
            }),
            ..Purpose::default()
        };
        let steps = draft.complete().unwrap();
        let (plan, _) = longstep_verify::verify::bind(&world, &steps, &[], None).unwrap();
        let report: Report = verify::check(&world, plan.clone(), &purpose);
        match repair_within(1_000_000, &world, &draft, &purpose, &Pins::default()) {
            RepairOutcome::Valid(valid) => {
                prop_assert_eq!(valid.plan(), &plan);
                prop_assert!(report.violations.is_empty());
            }
            RepairOutcome::Repaired(repaired) => {
                prop_assert!(!report.violations.is_empty());
                let least = least_cost(&world, &draft, &purpose, &report.ending().after);
                prop_assert_eq!(Some(repaired.cost), least, "{:?}", repaired.edits);
            }
            RepairOutcome::ProvenUnsolvable { .. } => {
                prop_assert_eq!(least_cost(&world, &draft, &purpose, &report.ending().after), None);
            }
            RepairOutcome::GaveUp { why, .. } | RepairOutcome::Unclear { why } => prop_assert!(false, "{}", why),
        }
    }

    #[test]
    fn repair_does_not_change_plans_found_by_search(
        goal in prop::sample::select(vec!["put(milk, shelf)", "put(milk, fridge)", "opened(fridge)", "wiped(shelf, cup)",
            "put(milk, fridge) & closed(fridge)", "put(cup, fridge) & put(milk, shelf)"]),
        milk in prop::sample::select(vec!["on_something(<counter>)", "inside_something(<fridge>)"]),
        door in prop::sample::select(vec!["open()", "closed()"]),
    ) {
        let text = format!(r#"{{"assets": ["<counter>", "<fridge>", "<shelf>"],
            "objects": ["<milk>", "<cup>", "<fridge_handle>"], "object_states": {{"<milk>": "{milk}",
            "<cup>": "on_something(<counter>)", "<fridge_handle>": "{door}"}}}}"#);
        let world = testing::world("household", &text);
        let goal = goal::parse(&world, goal).unwrap();
        let found = search::solve(&world, &goal.purpose(&world), &Limits::default());
        let search::Outcome::Solved { plan, .. } = found else { panic!("{found:?}") };
        let after = verify::check(&world, plan.clone(), &Purpose::default()).ending().after.clone();
        let purpose = Purpose {
            claim: Some(Claim::read(&world, &environment::write(&world, &after))),
            ..Purpose::default()
        };
        let draft = resolve(&world, &TaskCohesion::new(&world, &plan));
        let outcome = repair(&world, &draft, &purpose);
        let RepairOutcome::Valid(valid) = outcome else { panic!("{outcome:?}") };
        prop_assert_eq!(&valid.ending().after, &after);
        let calls = |plan: &Plan| -> Vec<String> {
            plan.steps().iter().map(|step| step.call(&world).to_string()).collect()
        };
        prop_assert_eq!(calls(valid.plan()), calls(&plan));
    }
}
