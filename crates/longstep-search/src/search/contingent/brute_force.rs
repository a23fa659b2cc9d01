//! Comparison of the contingent search with an exhaustive search of the state space.

use std::collections::HashMap;

use proptest::prelude::*;

use super::*;
use crate::goal::{self, Goal};
use crate::search::Effort;
use crate::testing;
use longstep_model::model::{ActionId, Moment, State, Wanted, ground, holds};
use longstep_verify::plan::Node;
use longstep_verify::verify::{apply, check as verify};

/// Maximum number of states; larger worlds are skipped.
const STATES: usize = 6_000;

/// The state space: for each state and action, the numbers of the possible successor states.
struct Space {
    ways: Vec<Vec<Vec<usize>>>,
    is_goal: Vec<bool>,
}

/// Returns all reachable states, with the actions that `matters` allows.
fn space(world: &World, wanted: &[Wanted], matters: &dyn Fn(ActionId, &[EntityId]) -> bool) -> Option<Space> {
    let domain = world.domain();
    let mut actions: Vec<(ActionId, Vec<EntityId>)> = Vec::new();
    for (id, action) in domain.action_ids() {
        let mut all: Vec<Vec<EntityId>> = vec![Vec::new()];
        for parameter in &action.parameters {
            let longer = |bound: &Vec<EntityId>| {
                let kinds = world.of_kind(parameter.kind).iter();
                kinds
                    .map(|entity| [&bound[..], &[*entity]].concat())
                    .collect::<Vec<_>>()
            };
            all = all.iter().flat_map(longer).collect();
        }
        actions.extend(
            all.into_iter()
                .filter(|bound| matters(id, bound))
                .map(|bound| (id, bound)),
        );
    }
    let mut numbers: HashMap<State, usize> = HashMap::new();
    let mut states = vec![world.state.clone()];
    numbers.insert(world.state.clone(), 0);
    let mut space = Space {
        ways: Vec::new(),
        is_goal: Vec::new(),
    };
    while let Some(state) = states.get(space.ways.len()).cloned() {
        let moment = Moment { world, state: &state };
        let all = wanted
            .iter()
            .all(|w| holds(moment, &w.condition, &mut w.bindings.clone()));
        space.is_goal.push(all);
        let mut ways = Vec::new();
        for (id, bound) in &actions {
            let action = domain.action(*id);
            if !holds(moment, &action.precondition, &mut bound.clone()) {
                continue;
            }
            let outcomes: Vec<Fact> = action.senses.iter().map(|atom| ground(atom, bound)).collect();
            let mut after = Vec::new();
            if outcomes.is_empty() {
                let mut next = state.clone();
                apply(world, &mut next, action, bound);
                after.push(next);
            } else if !outcomes.iter().any(|fact| state.holds(*fact)) {
                for fact in &outcomes {
                    let mut next = state.clone();
                    next.set(*fact, true);
                    after.push(next);
                }
            }
            let mut number = |next: State| {
                *numbers.entry(next.clone()).or_insert_with(|| {
                    states.push(next);
                    states.len() - 1
                })
            };
            if !after.is_empty() {
                ways.push(after.into_iter().map(&mut number).collect());
            }
        }
        space.ways.push(ways);
        if states.len() > STATES {
            return None;
        }
    }
    Some(space)
}

/// Returns the fewest steps to the goal in the worst case; none if no policy reaches it surely.
fn worst_case(space: &Space) -> Option<u32> {
    let mut cost: Vec<Option<u32>> = space.is_goal.iter().map(|goal| goal.then_some(0)).collect();
    // Each round assigns costs to the states that are one step further away.
    for round in 1..=space.ways.len() as u32 {
        let known = |way: &Vec<usize>| way.iter().all(|next| cost[*next].is_some_and(|cost| cost < round));
        let reached: Vec<usize> = (0..cost.len())
            .filter(|state| cost[*state].is_none() && space.ways[*state].iter().any(known))
            .collect();
        if reached.is_empty() {
            break;
        }
        reached.into_iter().for_each(|state| cost[state] = Some(round));
    }
    cost[0]
}

/// Returns the worst-case number of steps of a plan.
fn longest(nodes: &[Node]) -> u32 {
    let of = |node: &Node| match node {
        Node::Step(_) => 1,
        Node::If {
            condition,
            then,
            otherwise,
        } => condition.steps().count() as u32 + longest(then).max(longest(otherwise)),
        Node::While { condition, body } => condition.steps().count() as u32 + longest(body),
        _ => 0,
    };
    nodes.iter().map(of).sum()
}

const PARTS: [&str; 7] = [
    "put(spam, bin)",
    "put(spam, table)",
    "put(sponge, table)",
    "put(sponge, floor)",
    "wiped(table, sponge)",
    "put(spam, sponge)",
    "wiped(table, spam)",
];
const CONDITIONS: [&str; 7] = [
    "expired(spam)",
    "fresh(spam)",
    "dirty(table)",
    "clean(table)",
    "empty(spam)",
    "not full(spam)",
    "broken(sponge)",
];

fn part() -> impl Strategy<Value = String> {
    let side = || proptest::sample::subsequence(PARTS.to_vec(), 1..=2);
    let otherwise = proptest::option::of(side());
    let conditional =
        (proptest::sample::select(CONDITIONS.to_vec()), side(), otherwise).prop_map(|(test, then, otherwise)| {
            let otherwise = otherwise.map_or(String::new(), |parts| format!(" else {}", parts.join(" and ")));
            format!("if {test} then {}{otherwise}", then.join(" and "))
        });
    let plain = proptest::sample::select(PARTS.to_vec()).prop_map(str::to_owned);
    let known = proptest::sample::select(vec!["clean(table)", "fresh(spam)"]).prop_map(str::to_owned);
    prop_oneof![6 => conditional, 2 => plain, 1 => known]
}

fn scene() -> impl Strategy<Value = String> {
    let place = || proptest::sample::select(vec!["table", "floor"]);
    let known = proptest::option::weighted(0.2, proptest::sample::select(vec!["expired()", "fresh()", "empty()"]));
    let dirty = proptest::option::weighted(0.2, proptest::sample::select(vec!["dirty()", "clean()"]));
    (place(), place(), known, dirty).prop_map(|(spam, sponge, known, dirty)| {
        let known = known.map_or(String::new(), |word| format!(r#", "{word}""#));
        let dirty = dirty.map_or(String::new(), |word| format!(r#""<table>": ["{word}"]"#));
        format!(
            r#"{{"assets": ["<table>", "<bin>", "<floor>"], "objects": ["<spam>", "<sponge>"],
            "asset_states": {{{dirty}}}, "object_states": {{"<spam>": ["on_something(<{spam}>)"{known}],
            "<sponge>": ["on_something(<{sponge}>)"]}}}}"#
        )
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 60, ..ProptestConfig::default() })]

    #[test]
    fn contingent_plan_has_an_optimal_worst_case(text in scene(), parts in proptest::collection::vec(part(), 1..=2)) {
        let domain = testing::domain("household-checks");
        let world = testing::world_of(&domain, &text);
        let goal: Goal = goal::parse(&world, &parts.join(" & ")).unwrap();
        let purpose = goal.purpose(&world);
        // Sensing that the goal does not mention is skipped, since every outcome doubles the number of states.
        let mentioned: Vec<String> = goal.facts.iter().map(|fact| fact.exact(&world)).collect();
        let mentioned = mentioned.join(" & ");
        let matters = |id: ActionId, bound: &[EntityId]| {
            let action = domain.action(id);
            let names = |atom: &longstep_model::model::Atom| {
                let fact = ground(atom, bound);
                let text = goal::GoalFact::Plain(fact).exact(&world);
                mentioned.contains(&text)
            };
            let wiping = action.call != "wipe_on_plane" || mentioned.contains("wiped") || mentioned.contains("clean") || mentioned.contains("dirty");
            (action.senses.is_empty() || action.senses.iter().any(names)) && wiping && !action.call.contains("_by_rotate") && !action.call.contains("_by_slide")
        };
        let Some(space) = space(&world, &purpose.at_end(&domain), &matters) else {
            return Ok(());
        };
        let expected = worst_case(&space);
        let limits = Limits { direct: 20_000, proof: 20_000, shortest: 20_000, any: 20_000, effort: Effort::default() };
        match solve(&world, &Target::of(&domain, &purpose), &limits) {
            Outcome::Solved { plan, worst, shortest, .. } => {
                let report = verify(&world, plan.clone(), &goal.purpose(&world));
                prop_assert_eq!(&report.violations, &[]);
                prop_assert_eq!(longest(plan.body()), worst);
                match expected {
                    Some(expected) => prop_assert!(shortest && worst == expected, "{worst} rather than {expected}"),
                    None => prop_assert!(has_loop(plan.body())),
                }
            }
            Outcome::ProvenUnsolvable { .. } => prop_assert_eq!(expected, None),
            Outcome::GaveUp { why, .. } => prop_assert!(expected.is_none(), "{why}"),
        }
    }
}

fn has_loop(nodes: &[Node]) -> bool {
    nodes.iter().any(|node| match node {
        Node::While { .. } => true,
        Node::If { then, otherwise, .. } => has_loop(then) || has_loop(otherwise),
        _ => false,
    })
}
