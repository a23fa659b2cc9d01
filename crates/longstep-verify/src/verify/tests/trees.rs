//! Tests of branches, loops and lanes.

use super::bench::{self, Guard, Part, does, domain, messages, not, plan, report, world};
use crate::verify::{Milestone, Purpose, Report, STATES, Violation, check as check_plan, simulated};
use longstep_model::effort;
use longstep_model::model::{Condition, Wanted, World};

/// Checks the messages for a plan with three lamps of which the first is lit.
fn check(parts: &[Part], expected: &[&str]) {
    let domain = domain();
    let world = world(&domain, 3, &[1]);
    let report = report(&world, parts);
    assert_eq!(messages(&world, &report), expected, "{parts:?}");
}

fn all(texts: &[&str]) -> Vec<Part> {
    texts.iter().map(|text| does(text)).collect()
}

#[test]
fn both_sides_of_a_branch_are_followed() {
    let branch = |then: &[&str], otherwise: &[&str]| Part::If(Guard::Feel(2), all(then), all(otherwise));
    check(&[branch(&["press left 2"], &["press left 3"])], &[]);
    check(
        &[branch(&["press left 1"], &[])],
        &[
            "step 2: press(left, <lamp_1>) needs that lamp 1 is not lit (when lamp 2 is warm)",
            "step 2: press(left, <lamp_1>) changes nothing (when lamp 2 is warm)",
        ],
    );
    // Steps after a branch must be applicable whichever side was taken.
    check(
        &[branch(&["press left 2"], &[]), does("unpress left 2")],
        &[
            "step 3: unpress(left, <lamp_2>) needs that lamp 2 is lit (when lamp 2 is cold)",
            "step 3: unpress(left, <lamp_2>) changes nothing (when lamp 2 is cold)",
        ],
    );
    // A finding on every path is unconditional.
    check(
        &[branch(&["press left 3"], &["press right 3"]), does("press left 3")],
        &[
            "step 4: press(left, <lamp_3>) needs that lamp 3 is not lit; since step 2 (press(left, <lamp_3>)), lamp 3 is lit (when lamp 2 is warm)",
            "step 4: press(left, <lamp_3>) needs that lamp 3 is not lit; since step 3 (press(right, <lamp_3>)), lamp 3 is lit (when lamp 2 is cold)",
            "step 4: press(left, <lamp_3>) changes nothing",
        ],
    );
    check(
        &[branch(&[], &[]), does("press left 1")],
        &[
            "step 2: press(left, <lamp_1>) needs that lamp 1 is not lit",
            "step 2: press(left, <lamp_1>) changes nothing",
        ],
    );
}

#[test]
fn verify_uses_sensed_facts_on_the_branch_that_follows() {
    check(&[Part::If(Guard::Feel(2), all(&["cool 2"]), vec![])], &[]);
    check(
        &[Part::If(not(Guard::Feel(2)), all(&["cool 2"]), vec![])],
        &[
            "step 2: cool(<lamp_2>) needs that lamp 2 is warm (when lamp 2 is cold)",
            "step 2: cool(<lamp_2>) changes nothing (when lamp 2 is cold)",
        ],
    );
    check(&all(&["cool 2"]), &["step 1: cool(<lamp_2>) needs that lamp 2 is warm"]);
    // Sensed by a separate step, used later.
    check(
        &[
            does("feel 2"),
            does("press left 2"),
            Part::If(Guard::Is("warm", 2), all(&["cool 2"]), vec![]),
        ],
        &[],
    );
    // Sensing a known fact adds nothing, and the other side is unreachable.
    check(
        &[Part::If(
            Guard::Feel(2),
            vec![Part::If(Guard::Is("cold", 2), all(&["press left 2"]), all(&["cool 2"]))],
            vec![],
        )],
        &["step 2: press(left, <lamp_2>) is never reached"],
    );
}

#[test]
fn verify_rejects_conditions_that_were_never_sensed() {
    check(
        &[Part::If(Guard::Is("warm", 2), all(&["press left 2"]), vec![])],
        &["step 1: a condition asks whether lamp 2 is warm, and nothing has sensed that"],
    );
    // Sensed on one side only.
    check(
        &[
            Part::If(Guard::Feel(3), all(&["feel 2"]), vec![]),
            Part::If(Guard::Is("warm", 2), all(&["press left 2"]), vec![]),
        ],
        &["step 3: a condition asks whether lamp 2 is warm, and nothing has sensed that (when lamp 3 is cold)"],
    );
    // Deleted after sensing.
    check(
        &[
            does("feel 2"),
            does("wait 2"),
            Part::If(Guard::Is("warm", 2), all(&["press left 2"]), vec![]),
        ],
        &["step 3: a condition asks whether lamp 2 is warm, and nothing has sensed that"],
    );
    // Short-circuit evaluation: the second part is evaluated only if the first holds.
    let both = Guard::All(vec![Guard::Feel(2), Guard::Is("warm", 2)]);
    check(&[Part::If(both, all(&["press left 2"]), vec![])], &[]);
    let either = Guard::Any(vec![Guard::Feel(2), Guard::Is("cold", 2)]);
    check(
        &[Part::If(either, all(&["press left 2"]), all(&["press left 3"]))],
        &["step 3: press(left, <lamp_3>) is never reached"],
    );
    // Facts that no action senses are known from the start.
    check(&[Part::If(Guard::Is("lit", 1), all(&["unpress left 1"]), vec![])], &[]);
}

#[test]
fn loops_end_or_are_refused() {
    check(&[Part::While(Guard::Feel(2), all(&["wait 2"]))], &[]);
    check(
        &[Part::While(
            not(Guard::Feel(2)),
            all(&["wait 2", "press left 2", "unpress left 2"]),
        )],
        &[],
    );
    check(&[Part::While(Guard::Is("lit", 1), all(&["unpress right 1"]))], &[]);
    // A sensed fact stays known.
    check(
        &[Part::While(Guard::Feel(2), all(&["press left 2", "unpress left 2"]))],
        &["step 1: the loop may never end: in some state no step in it changes its condition (when lamp 2 is warm)"],
    );
    check(
        &[Part::While(
            Guard::Is("lit", 1),
            all(&["press left 2", "unpress left 2"]),
        )],
        &["step 1: the loop may never end: in some state no step in it changes its condition"],
    );
    // On the second iteration the lamp is already lit.
    check(
        &[Part::While(Guard::Feel(2), all(&["press left 2", "wait 2"]))],
        &[
            "step 2: press(left, <lamp_2>) needs that lamp 2 is not lit; since step 2 (press(left, <lamp_2>)), lamp 2 is lit (when lamp 2 is warm)",
            "step 2: press(left, <lamp_2>) changes nothing (when lamp 2 is warm)",
        ],
    );
    check(&[Part::Repeat(3, all(&["press left 2", "unpress left 2"]))], &[]);
    check(
        &[Part::Repeat(4_000_000_000, all(&["press left 2", "unpress left 2"]))],
        &[],
    );
    check(
        &[Part::Repeat(2, all(&["press left 2"]))],
        &[
            "step 1: press(left, <lamp_2>) needs that lamp 2 is not lit; since step 1 (press(left, <lamp_2>)), lamp 2 is lit",
            "step 1: press(left, <lamp_2>) changes nothing",
        ],
    );
    check(
        &[Part::Repeat(0, all(&["press left 1"]))],
        &["step 1: press(left, <lamp_1>) is never reached"],
    );
}

fn lanes(left: &[&str], right: &[&str]) -> Part {
    let owned = |texts: &[&str]| texts.iter().map(|text| (*text).to_owned()).collect();
    Part::Lanes(vec![("left", owned(left)), ("right", owned(right))])
}

#[test]
fn lanes_do_not_get_in_each_others_way() {
    check(
        &[lanes(
            &["press left 2", "unpress left 2"],
            &["unpress right 1", "press right 1"],
        )],
        &[],
    );
    // Both lanes use the third lamp.
    check(
        &[lanes(&["press left 3"], &["link right 2 3"])],
        &[
            "step 1: press(left, <lamp_3>) may happen at the same time as step 2 (link(right, <lamp_2>, <lamp_3>)), and both handle lamp 3",
            "step 1: press(left, <lamp_3>) may happen at the same time as step 2 (link(right, <lamp_2>, <lamp_3>)), and which comes first decides whether lamp 2 is linked to lamp 3",
            "step 2: link(right, <lamp_2>, <lamp_3>) changes nothing",
        ],
    );
    check(
        &[lanes(&["press left 3", "sync lit"], &["sync lit", "link right 2 3"])],
        &[],
    );
    check(
        &[lanes(
            &["sync a", "press left 3", "sync b"],
            &["sync b", "link right 2 3", "sync a"],
        )],
        &[
            "the lanes wait for each other at `a` for ever",
            "step 1: press(left, <lamp_3>) is never reached",
        ],
    );
    check(
        &[lanes(&["press right 3"], &["feel 2"])],
        &[
            "step 1: press(right, <lamp_3>) stands in the lane of `left`, and is not its step alone",
            "step 2: feel(<lamp_2>) stands in the lane of `right`, and is not its step alone",
            "step 2: feel(<lamp_2>) senses while another lane goes on; sense before or after",
        ],
    );
    check(
        &[Part::Lanes(vec![
            ("left", vec!["press left 2".to_owned()]),
            ("left", vec![]),
        ])],
        &["there are two lanes of `left` side by side"],
    );
}

/// Returns a sequence of branches, each on its own lamp if `apart`.
fn branches(count: usize, apart: bool) -> Vec<Part> {
    let branch = |number: usize| {
        let lamp = if apart { number + 1 } else { 1 };
        let again = |text: &str| all(&[text, &format!("wait {}", if apart { 1_000 } else { 1 })]);
        Part::If(Guard::Feel(lamp), again("link left 2 3"), again("link right 2 3"))
    };
    (0..count).map(branch).collect()
}

#[test]
fn a_thousand_branches_that_come_together_are_followed() {
    let domain = domain();
    let world = world(&domain, 1_000, &[1]);
    let merging = report(&world, &branches(1_000, false));
    assert_eq!((merging.violations.len(), merging.endings.len()), (0, 1));

    let apart = report(&world, &branches(1_000, true));
    let [Violation::TooManyStates { step, states }] = apart.violations.as_slice() else {
        panic!("{:?}", apart.violations);
    };
    assert_eq!((*step, *states), (Some(12 * 5), 2 * STATES));
}

/// Returns the milestone that the first lamp is lit while the second one is not.
fn lit_before(world: &World, first: usize, second: usize) -> Milestone {
    let lit = Wanted::of_fact(world.domain(), bench::fact(world, "lit", first));
    let other_is_dark = lit.condition.clone().with_slots(&|_| 1).complement();
    Milestone {
        wanted: Wanted {
            condition: Condition::And(vec![lit.condition, other_is_dark]),
            bindings: vec![bench::lamp(world, first), bench::lamp(world, second)],
        },
        anew: false,
    }
}

#[test]
fn lanes_with_more_paths_than_the_limit_are_refused() {
    // Each order of the steps of the two lanes makes a progress of its own, and 16 steps have 12,870 orders.
    let domain = domain();
    let none: &[&str] = &[];
    for (count, expected, within_budget) in [
        (6, none, none),
        (7, none, &["too_much_work"]),
        (8, &["too_many_states", "order"], &["too_much_work"]),
    ] {
        let world = world(&domain, 2 * count, &[]);
        let (left, right) = (1..=count, count + 1..=2 * count);
        let lanes = vec![
            ("left", left.clone().map(|lamp| format!("press left {lamp}")).collect()),
            (
                "right",
                right.clone().map(|lamp| format!("press right {lamp}")).collect(),
            ),
        ];
        // At the end, all lamps of the one lane are lit and those of the other are not, whatever the order was.
        let mut parts = vec![Part::Lanes(lanes)];
        parts.extend(right.clone().map(|lamp| does(&format!("unpress right {lamp}"))));
        let pairs = left.flat_map(|first| right.clone().map(move |second| (first, second)));
        let purpose = Purpose {
            stages: vec![pairs.map(|(first, second)| lit_before(&world, first, second)).collect()],
            ..Purpose::default()
        };
        let kinds = |report: &Report| report.violations.iter().map(Violation::kind).collect::<Vec<_>>();
        let report = simulated(&world, plan(&world, &parts), &purpose);
        assert_eq!(kinds(&report), expected, "{count} lamps in each lane");
        let report = check_plan(&world, plan(&world, &parts), &purpose);
        assert_eq!(kinds(&report), within_budget, "{count} lamps in each lane");
    }
}

#[test]
fn violation_in_both_lane_orders_keeps_its_branch_condition() {
    check(
        &[
            Part::If(Guard::Feel(2), all(&["press left 2"]), vec![]),
            lanes(&["press left 2"], &["press right 3"]),
        ],
        &[
            "step 3: press(left, <lamp_2>) needs that lamp 2 is not lit; since step 2 (press(left, <lamp_2>)), lamp 2 is lit (when lamp 2 is warm)",
            "step 3: press(left, <lamp_2>) changes nothing (when lamp 2 is warm)",
        ],
    );
}

/// Returns the work units of the check and the kinds of its violations.
fn effort_of(parts: &[Part]) -> (u64, Vec<&'static str>) {
    let domain = domain();
    let world = world(&domain, 4, &[1]);
    let plan = plan(&world, parts);
    let spent = effort::within(u64::MAX, || check_plan(&world, plan, &Purpose::default()));
    let kinds = spent.result.violations.iter().map(Violation::kind).collect();
    (spent.units, kinds)
}

#[test]
fn a_condition_takes_effort_that_grows_with_its_length() {
    let pair = || Guard::All(vec![Guard::Is("warm", 2), Guard::Is("cold", 3)]);
    let condition = |pairs: usize| Guard::Any((0..pairs).map(|_| pair()).collect());
    let effort = |pairs| effort_of(&[Part::If(condition(pairs), vec![], vec![])]);
    let (short, kinds) = effort(10);
    assert_eq!(kinds, ["unsensed", "unsensed"]);
    let (long, _) = effort(40);
    assert!(long < 8 * short, "{long} units for four times the {short} of a quarter");
    // With a sensing step in every part, the number of states exceeds the limit before memory does.
    let lamps = |at: usize| Guard::Any(vec![Guard::Feel(1 + at % 4), not(Guard::Is("warm", 1 + at % 4))]);
    let (units, kinds) = effort_of(&[Part::While(Guard::All((0..60).map(lamps).collect()), all(&["wait 1"]))]);
    assert!(units < effort::OPERATION, "{units} units, {kinds:?}");
}

#[test]
fn a_counted_loop_follows_one_period_of_its_states() {
    let swing = |times| {
        let toggle = Part::If(Guard::Is("lit", 1), all(&["unpress left 1"]), all(&["press left 1"]));
        vec![Part::Repeat(times, vec![toggle])]
    };
    let (few, kinds) = effort_of(&swing(4));
    assert_eq!(kinds, Vec::<&str>::new());
    assert_eq!(effort_of(&swing(1_000_000_000)).0, few);
    // The state after the last iteration is that of the remainder: lamp 1 is lit at first.
    let domain = domain();
    let world = world(&domain, 4, &[1]);
    for (times, lit) in [(1, false), (2, true), (999_999_999, false), (1_000_000_000, true)] {
        let report = report(&world, &swing(times));
        let fact = bench::fact(&world, "lit", 1);
        assert_eq!(report.ending().after.holds(fact), lit, "{times}");
    }
}

#[test]
fn a_plan_that_takes_too_much_work_is_refused() {
    // A nested binary counter of four lamps: each level multiplies the iterations of the inner one.
    let count = |body: Vec<Part>| {
        let carry = |lamp: usize, rest: Vec<Part>| {
            let on = format!("press left {lamp}");
            let off = format!("unpress left {lamp}");
            let mut carried = all(&[off.as_str()]);
            carried.extend(rest);
            Part::If(Guard::Is("lit", lamp), carried, all(&[on.as_str()]))
        };
        let mut rounds = vec![carry(1, vec![carry(2, vec![carry(3, vec![carry(4, vec![])])])])];
        rounds.extend(body);
        vec![Part::Repeat(13, rounds)]
    };
    let deep = (0..8).fold(Vec::new(), |body, _| count(body));
    let (units, kinds) = effort_of(&deep);
    assert_eq!(kinds, ["too_much_work"]);
    assert!(units < effort::OPERATION + effort::OPERATION / 4, "{units}");
}

#[test]
fn a_rule_that_is_broken_at_the_start_binds_from_where_it_is_kept() {
    let rule = "[[rule]]\nname = \"dark\"\nholds = \"always\"\ncondition = \"(forall (?lamp - lamp) (not (lit ?lamp)))\"\nsays = \"{lamp} must be dark\"\n";
    let domain = bench::domain_with(rule);
    let world = world(&domain, 3, &[1]);
    let check = |texts: &[&str], expected: &[&str]| {
        let report = report(&world, &all(texts));
        assert_eq!(messages(&world, &report), expected, "{texts:?}");
    };
    check(&["unpress left 1"], &[]);
    check(&["feel 2", "unpress left 1"], &[]);
    check(&["press left 2"], &["after step 1: lamp 2 must be dark"]);
    check(
        &["unpress left 1", "press left 1"],
        &["after step 2: lamp 1 must be dark"],
    );
}

#[test]
fn cost_counts_every_iteration_and_the_dearest_branch() {
    let domain = bench::domain_with_costs();
    let world = world(&domain, 3, &[]);
    let blink = || all(&["press left 1", "unpress left 1"]);
    let detour = vec![
        Part::If(
            Guard::Feel(2),
            all(&["press left 3"]),
            all(&["press left 3", "unpress left 3", "press left 3"]),
        ),
        // After this, the state no longer shows which branch was taken.
        does("wait 2"),
    ];
    for (parts, expected) in [
        (blink(), Some("5")),
        (vec![Part::Repeat(1_000, blink())], Some("5000")),
        (vec![Part::Repeat(7, vec![Part::Repeat(3, blink())])], Some("105")),
        (vec![Part::Repeat(3, all(&["press left 1"]))], Some("6")),
        (detour, Some("7")),
        (
            vec![Part::While(Guard::Feel(2), [blink(), all(&["wait 2"])].concat())],
            None,
        ),
    ] {
        let cost = report(&world, &parts).cost().map(|cost| cost.to_string());
        assert_eq!(cost.as_deref(), expected, "{parts:?}");
    }
}
