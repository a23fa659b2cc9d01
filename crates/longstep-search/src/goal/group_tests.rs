//! Groups: what they stand for, how they are written, and the plans for them.

use super::{Goal, parse, rules};
use crate::search::{Limits, Outcome, solve};
use crate::testing;
use longstep_model::model::World;
use longstep_verify::verify::check;

fn kitchen() -> World {
    let text = r#"{"assets": ["<table>", "<shelf>", "<sink>", "<fridge>"],
        "objects": ["<plate_1>", "<plate_2>", "<plate_3>", "<wine_glass>", "<glass>", "<vase>", "<fridge_handle>", "<all_purpose_cleaner>"],
        "object_states": {"<plate_1>": "on_something(<table>)", "<plate_2>": "on_something(<table>)",
            "<plate_3>": "on_something(<shelf>)", "<wine_glass>": "on_something(<table>)", "<glass>": "on_something(<shelf>)",
            "<vase>": "on_something(<table>)", "<all_purpose_cleaner>": "on_something(<shelf>)", "<fridge_handle>": "closed()"}}"#;
    testing::world("household", text)
}

#[test]
fn a_group_stands_for_its_members() {
    let world = kitchen();
    for (text, expected) in [
        (
            "put(all plate, sink)",
            "put(plate 1, sink) & put(plate 2, sink) & put(plate 3, sink)",
        ),
        (
            "put(each plates, sink)",
            "put(plate 1, sink) & put(plate 2, sink) & put(plate 3, sink)",
        ),
        (
            "put(all plate where on_something(table), sink)",
            "put(plate 1, sink) & put(plate 2, sink)",
        ),
        (
            "put(all plate where not on_something(<table>), sink)",
            "put(plate 3, sink)",
        ),
        (
            "put(all plate except plate 2, sink)",
            "put(plate 1, sink) & put(plate 3, sink)",
        ),
        ("put(all plate except plate 2, plate 3, sink)", "put(plate 1, sink)"),
        ("put(all plate except (plate 2, plate 3), sink)", "put(plate 1, sink)"),
        // A wine glass is a glass.
        ("put(all glass, sink)", "put(wine glass, sink) & put(glass, sink)"),
        ("put(all wine glass, sink)", "put(wine glass, sink)"),
        // Whatever can be put somewhere: no handle, no table, and nothing into itself.
        (
            "put(all thing where on_something(table) except plate, sink)",
            "put(wine glass, sink) & put(vase, sink)",
        ),
        (
            "put(all thing where on_something(shelf) & not on_something(table) except cleaner, plate 3, sink)",
            "put(glass, sink)",
        ),
        (
            "on_something(all plate, plate 3)",
            "on_something(plate 1, plate 3) & on_something(plate 2, plate 3)",
        ),
        // A name that begins like a group.
        ("put(all purpose cleaner, sink)", "put(all purpose cleaner, sink)"),
        (
            "put(vase, sink) then put(all glass, sink) & put(vase, shelf)",
            "put(vase, sink) & then put(wine glass, sink) & put(glass, sink) & put(vase, shelf)",
        ),
        ("put(any plate, sink)", "put(any plate, sink)"),
        ("put(2 of plate, sink)", "put(2 of plate, sink)"),
        (
            "put(exactly 2 of plate except (plate 1), sink)",
            "put(exactly 2 of plate except plate 1, sink)",
        ),
        (
            "put(all glass, any thing where not on_something(table) except glass, wine glass)",
            "put(wine glass, any thing where not on_something(table) except (wine glass, glass)) & \
             put(glass, any thing where not on_something(table) except (wine glass, glass))",
        ),
        ("untouched(all glass)", "untouched(wine glass) & untouched(glass)"),
        ("untouched(any glass)", "untouched(wine glass) & untouched(glass)"),
        (
            "never put(any glass, sink)",
            "never put(wine glass, sink) & never put(glass, sink)",
        ),
        ("never opened(all fridge)", "never opened(fridge)"),
        ("never put(2 of glass, sink)", "never put(2 of glass, sink)"),
        ("always put(any glass, shelf)", "always put(any glass, shelf)"),
        ("put(all but 1 of plate, sink)", "put(all but 1 of plate, sink)"),
        ("put(any of (vase, glass), sink)", "put(any of (glass, vase), sink)"),
        (
            "put(2 of (vase, plate 1, plate 2), any of (sink, shelf))",
            "put(2 of (plate 1, plate 2, vase), any of (shelf, sink))",
        ),
        ("put(all of (vase, glass), sink)", "put(glass, sink) & put(vase, sink)"),
        (
            "put(all plate where on_something(shelf) or on_something(sink), sink)",
            "put(plate 3, sink)",
        ),
        (
            "put(any thing where on_something(shelf) & not on_something(table) or on_something(sink), table)",
            "put(any thing where on_something(shelf) & not on_something(table) or on_something(sink), table)",
        ),
        (
            "never opened(fridge) until put(all glass, sink)",
            "never opened(fridge) until put(wine glass, sink) & never opened(fridge) until put(glass, sink)",
        ),
        (
            "put(vase, sink) & untouched(glass) until put(vase, sink)",
            "put(vase, sink) & untouched(glass) until put(vase, sink)",
        ),
        (
            "never put(glass, _)",
            "never put(glass, table) & never put(glass, shelf) & never put(glass, sink) & never put(glass, fridge) & \
             never put(glass, plate 1) & never put(glass, plate 2) & never put(glass, plate 3) & \
             never put(glass, wine glass) & never put(glass, vase) & never put(glass, fridge handle) & \
             never put(glass, all purpose cleaner)",
        ),
    ] {
        let goal = match parse(&world, text) {
            Ok(goal) => goal,
            Err(error) => panic!("{text}: {error}"),
        };
        assert_eq!(goal.everyday(&world).join(" & "), expected, "{text}");
        for again in [goal.everyday(&world), goal.exact(&world)] {
            let again = parse(&world, &again.join(" & ")).unwrap_or_else(|error| panic!("{again:?}: {error}"));
            assert_eq!(again.facts, goal.facts, "{text}");
            assert_eq!(again.stages, goal.stages, "{text}");
            assert_eq!(again.constraints, goal.constraints, "{text}");
        }
        assert_eq!(
            goal.carried(world.domain(), &world, &world).as_ref(),
            Some(&goal),
            "{text}"
        );
    }
}

/// In a domain with an action that is called like a goal word, too.
#[test]
fn a_prohibition_leaves_out_members_that_its_goal_does_not_take() {
    let text = r#"{"assets": ["<stove_5>"], "objects": ["<mug_6>", "<plate_7>"]}"#;
    let world = testing::world("virtualhome", text);
    let goal = parse(&world, "never put(<plate_7>, top of all thing)").unwrap();
    assert_eq!(goal.exact(&world), ["never put(<plate_7>, top of <stove_5>)"]);
}

#[test]
fn a_group_that_stands_for_nothing_is_an_error() {
    let world = kitchen();
    for (text, expected) in [
        (
            "put(all spoon, sink)",
            "`spoon` in `all spoon` is no type of the domain",
        ),
        ("put(all plat, sink)", "did you mean `plate`?"),
        (
            "put(all plate where on_something(sink), sink)",
            "plate 1 fails `on_something(sink)`, plate 2 fails",
        ),
        (
            "put(all plate where shiny, sink)",
            "`shiny` in `all plate where shiny` is no state",
        ),
        ("put(all plate where on_something(tabel), sink)", "`tabel` in"),
        (
            "put(all plate except plate 1, plate 2, plate 3, sink)",
            "plate 1 is excepted",
        ),
        ("put(all plate except spoon, sink)", "`spoon` in"),
        ("put(any of (vase, spoon), sink)", "`spoon` in"),
        ("put(all but 3 of plate, sink)", "requires 0 members"),
        ("put(4 of plate, sink)", "requires 4 members, and the group has 3"),
        ("put(0 of plate, sink)", "requires 0 members"),
        ("put(all table, sink)", "is no item"),
        // A list in parentheses is complete, so the goal has three arguments.
        ("put(all plate except (plate 2), plate 3, sink)", "`plate 3, sink` in"),
        ("put(all plate, spoon)", "`spoon` in"),
        ("untouched(2 of glass)", "write `all` or `any`"),
        ("putt(all plate, sink)", "is not a goal of this domain"),
        ("put(all plate, sink", "is not a goal of this domain"),
        ("put(all , sink)", "is no type"),
        (
            "put(99999999999999999999999 of plate, sink)",
            "nothing in the environment",
        ),
        ("put(all plate where , sink)", "is no type"),
    ] {
        let error = parse(&world, text).map(|goal| goal.everyday(&world)).expect_err(text);
        assert!(error.to_string().contains(expected), "{text}: {error}");
    }
    assert!(rules(&world, "put(all plate, sink)").is_err());
    assert_eq!(
        rules(&world, "untouched(all plate) & never opened(any fridge)")
            .unwrap()
            .len(),
        4
    );
}

#[test]
fn groups_are_described_as_sentences() {
    let world = kitchen();
    for (text, sentences, groups) in [
        (
            "put(any plate where on_something(table), sink)",
            "any plate (it is on the table) is at the sink",
            "any plate (it is on the table): plate 1, plate 2",
        ),
        (
            "put(all glass, sink)",
            "the wine glass is at the sink; the glass is at the sink",
            "each glass: the wine glass, the glass",
        ),
        (
            "put(2 of plate, sink)",
            "for at least 2 of (plate 1, plate 2, plate 3): it is at the sink",
            "2 of plate: plate 1, plate 2, plate 3",
        ),
        (
            "never put(2 of glass, sink)",
            "at no time: for at least 2 of (the wine glass, the glass): it is at the sink",
            "2 of glass: the wine glass, the glass",
        ),
    ] {
        let goal = parse(&world, text).unwrap();
        assert_eq!(goal.sentences(&world).join("; "), sentences);
        let voice = longstep_model::model::Voice::Person;
        let shown = goal.groups.iter().flat_map(|part| &part.groups);
        let shown = shown.map(|group| {
            format!(
                "{}: {}",
                group.sentence_in(voice, &world),
                group.members_in(voice, &world)
            )
        });
        assert_eq!(shown.collect::<Vec<_>>().join("; "), groups);
    }
}

fn length(world: &World, goal: &Goal) -> Option<usize> {
    match solve(world, &goal.purpose(world), &Limits::default()) {
        Outcome::Solved { plan, shortest, .. } => {
            assert!(shortest);
            let length = plan.steps().len();
            assert_eq!(check(world, plan, &goal.purpose(world)).violations, []);
            Some(length)
        }
        Outcome::ProvenUnsolvable { .. } => None,
        other @ Outcome::GaveUp { .. } => panic!("{other:?}"),
    }
}

#[test]
fn choice_is_planned_with_its_shortest_member() {
    let world = kitchen();
    for (text, same) in [
        ("put(any plate, shelf)", "put(plate 3, shelf)"),
        ("put(2 of plate, shelf)", "put(plate 1, shelf)"),
        ("put(3 of plate, shelf)", "put(all plate, shelf)"),
        ("put(any plate where on_something(table), sink)", "put(plate 2, sink)"),
        ("put(exactly 2 of plate, table)", "put(plate 1, table)"),
        ("put(exactly 1 of plate, table)", "put(plate 1, shelf)"),
        ("put(2 of glass, any thing)", "put(glass, shelf)"),
        (
            "put(any plate where on_something(table), shelf) & never put(plate 1, shelf)",
            "put(plate 2, shelf)",
        ),
        (
            "put(all glass, sink) & untouched(any plate)",
            "put(glass, sink) & put(wine glass, sink)",
        ),
        (
            "put(any plate, sink) & untouched(all plate)",
            "put(plate 1, sink) & untouched(plate 1)",
        ),
        // A goal that a later stage excludes for some members holds for another one.
        (
            "put(any plate, sink) then put(2 of plate, shelf)",
            "put(plate 1, sink) then put(plate 2, shelf)",
        ),
        (
            "put(any glass, sink) then put(all glass, shelf)",
            "put(wine glass, sink) then put(wine glass, shelf)",
        ),
    ] {
        let [goal, same] = [text, same].map(|text| parse(&world, text).unwrap());
        assert_eq!(length(&world, &goal), length(&world, &same), "{text}");
    }
}

#[test]
fn carried_goal_expands_groups_in_the_larger_world() {
    let world = kitchen();
    let kept = ["<plate_1>", "<sink>", "<table>"].map(|identifier| world.find(identifier).unwrap());
    let part = world.narrowed(&kept);
    let goal = parse(
        &part,
        "put(plate 1, sink) then put(all plate, any thing where not on_something(table) except glass) & untouched(all plate)",
    );
    let goal = goal.map(|goal| goal.carried(world.domain(), &part, &world));
    // The narrowed world has no glass.
    assert!(goal.is_err());
    let goal = parse(
        &part,
        "put(plate 1, sink) then put(all plate, sink) & untouched(all plate)",
    )
    .unwrap();
    let whole = goal.carried(world.domain(), &part, &world).unwrap();
    assert_eq!(
        whole.everyday(&world).join(" & "),
        "put(plate 1, sink) & then put(plate 1, sink) & put(plate 2, sink) & put(plate 3, sink) & \
         untouched(plate 1) & untouched(plate 2) & untouched(plate 3)"
    );
}

#[test]
fn choice_reports_the_member_that_the_plan_achieved() {
    let world = kitchen();
    for (text, expected) in [
        ("put(any plate, shelf)", "put(plate 3, shelf)"),
        ("put(all glass, any thing where not on_something(table))", "any"),
        // The first place is left again.
        ("put(any vase, sink) then put(vase, shelf)", "put(vase, sink)"),
    ] {
        let goal = parse(&world, text).unwrap();
        let purpose = goal.purpose(&world);
        let Outcome::Solved { plan, .. } = solve(&world, &purpose, &Limits::default()) else {
            panic!("{text}")
        };
        let report = check(&world, plan, &purpose);
        let choices = goal.choices();
        let chosen: Vec<String> = choices
            .flat_map(|choice| choice.achieved(&report))
            .map(|goal| goal.everyday(&world))
            .collect();
        match expected {
            "any" => assert_eq!(chosen.len(), 2, "{chosen:?}"),
            expected => assert_eq!(chosen.join(" & "), expected),
        }
    }
}

#[test]
fn a_choice_is_exported_as_a_disjunction() {
    let world = kitchen();
    let goal = parse(&world, "put(any glass, sink)").unwrap();
    let problem = crate::pddl::write_problem(&world, &goal.purpose(&world), "any").unwrap();
    for fact in ["(on wine_glass sink)", "(on glass sink)", "(inside glass sink)"] {
        assert!(problem.contains("(or") && problem.contains(fact), "{problem}");
    }
}

#[test]
fn until_ends_a_constraint_when_a_goal_is_achieved() {
    let world = kitchen();
    for (text, same) in [
        (
            "put(vase, shelf) & put(glass, sink) & never put(vase, shelf) until put(glass, sink)",
            "put(glass, sink) then put(vase, shelf)",
        ),
        (
            "put(vase, shelf) & put(glass, sink) & untouched(vase) until put(glass, sink)",
            "put(glass, sink) then put(vase, shelf)",
        ),
        (
            "put(vase, sink) & never put(vase, sink) until put(vase, sink)",
            "put(vase, sink)",
        ),
    ] {
        let [goal, same] = [text, same].map(|text| parse(&world, text).unwrap());
        assert_eq!(length(&world, &goal), length(&world, &same), "{text}");
    }
    // The goal that ends it is only a means.
    let goal = parse(&world, "put(vase, sink) & untouched(vase) until put(glass, table)").unwrap();
    let Outcome::Solved { plan, .. } = solve(&world, &goal.purpose(&world), &Limits::default()) else {
        panic!("no plan")
    };
    assert_eq!(check(&world, plan, &goal.purpose(&world)).violations, []);
    let error = parse(&world, "never grasp() until put(glass, sink)").unwrap_err();
    assert!(error.to_string().contains("write a goal in place"), "{error}");
}
