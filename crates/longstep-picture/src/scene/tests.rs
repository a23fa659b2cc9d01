use std::collections::BTreeSet;

use longstep_core::model::{Domain, EntityId, Fact, PredicateId, State, World};
use longstep_core::testing;
use proptest::prelude::*;

use super::*;
use crate::SvgOptions;
use crate::draw::inspect;
use crate::shipped;

/// Checks that every entity has one box, and that boxes come after the ones around them.
#[track_caller]
fn check_scene(world: &World, scene: &Scene, label: &str) {
    let ids: Vec<&str> = scene.boxes.iter().map(|own| own.id.as_str()).collect();
    let distinct: BTreeSet<&str> = ids.iter().copied().collect();
    assert_eq!(ids.len(), distinct.len(), "{label}: a box occurs twice");
    let entities = world.entities().filter(|(_, entity)| !entity.is_value);
    let mut expected: BTreeSet<&str> = entities.map(|(_, entity)| entity.identifier.as_str()).collect();
    let robot = scene.boxes.iter().find(|own| own.role == Role::Robot);
    expected.extend(robot.map(|own| own.id.as_str()));
    assert_eq!(distinct, expected, "{label}");
    for (index, own) in scene.boxes.iter().enumerate() {
        assert!(own.within.is_none_or(|around| around < index), "{label}: {}", own.id);
        assert_eq!(own.within.is_some(), own.relation.is_some());
    }
}

/// Checks the pictures of a scene in several widths: every box once, or counted in one around it.
#[track_caller]
fn check_pictures(scene: &Scene, changes: &Changes) {
    for width in [120.0, 360.0, 1200.0] {
        let options = SvgOptions::new(width).with_prefix("p7");
        let svg = svg(scene, changes, &options);
        let drawn = inspect::check(&svg, "p7");
        let distinct: BTreeSet<&String> = drawn.iter().collect();
        assert_eq!(distinct.len(), drawn.len(), "a box is drawn twice at {width}");
        let whole = layout::Layout::new(scene, changes, width).whole();
        let is_shown = |own: &&SceneBox| own.role != Role::Constant || distinct.contains(&own.id);
        let expected = scene.boxes.iter().filter(is_shown).count();
        assert_eq!(drawn.len() + left_out(&whole), expected, "at {width}");
    }
}

fn left_out(block: &layout::Block) -> usize {
    block.left_out + block.children.iter().map(left_out).sum::<usize>()
}

fn places(world: &World) -> Vec<String> {
    let scene = Scene::of(world, &world.state);
    let place = |own: &SceneBox| {
        let around = own.within.map(|index| scene.boxes[index].id.clone());
        let states: Vec<&str> = own.states.iter().map(|state| state.text.as_str()).collect();
        format!("{} in {}: {}", own.id, around.unwrap_or_default(), states.join(", "))
    };
    scene.boxes.iter().map(place).collect()
}

#[test]
fn shipped_environments_have_one_box_for_each_entity() {
    for (label, world) in shipped::worlds() {
        let scene = Scene::of(&world, &world.state);
        check_scene(&world, &scene, &label);
        check_pictures(&scene, &Changes::default());
        // Objects of these environments are somewhere, so most of them have a box around them.
        let objects = || scene.boxes.iter().filter(|own| own.role == Role::Object);
        let placed = objects().filter(|own| own.within.is_some()).count();
        assert!(
            2 * placed >= objects().count(),
            "{label}: {placed} objects have a place"
        );
    }
}

#[test]
fn entity_on_a_table_in_a_kitchen_is_on_the_table() {
    let world = testing::world(
        "virtualhome",
        r#"{"assets": ["<kitchen_1>", "<table_2>"], "objects": ["<cup_3>", "<tray_4>"],
            "asset_states": {"<table_2>": "INSIDE(<kitchen_1>)"},
            "object_states": {"<cup_3>": ["INSIDE(<kitchen_1>)", "ON(<tray_4>)"],
                              "<tray_4>": ["INSIDE(<kitchen_1>)", "ON(<table_2>)"]}}"#,
    );
    assert_eq!(
        places(&world),
        [
            "(robot) in : ",
            "<kitchen_1> in : ",
            "<table_2> in <kitchen_1>: ",
            "<tray_4> in <table_2>: ",
            "<cup_3> in <tray_4>: ",
        ]
    );
}

#[test]
fn cycle_of_places_is_cut_at_its_first_entity() {
    let world = testing::world("household", r#"{"objects": ["<box_a>", "<box_b>", "<cup>"]}"#);
    let inside = PredicateId::new(
        world
            .domain()
            .predicates
            .iter()
            .position(|own| own.name == "inside")
            .unwrap(),
    );
    let id = |name| world.find(name).unwrap();
    let mut state = world.state.clone();
    for (inner, outer) in [("<box_a>", "<box_b>"), ("<box_b>", "<box_a>"), ("<cup>", "<box_b>")] {
        state.set(Fact::new(inside, [id(inner), id(outer)]), true);
    }
    state.set(Fact::new(inside, [id("<cup>"), id("<cup>")]), true);
    let scene = Scene::of(&world, &state);
    check_scene(&world, &scene, "cycle");
    let around = |name| {
        scene
            .find(name)
            .unwrap()
            .within
            .map(|index| scene.boxes[index].id.as_str())
    };
    assert_eq!(
        [around("<box_a>"), around("<box_b>"), around("<cup>")],
        [None, Some("<box_a>"), Some("<box_b>")]
    );
    assert_eq!(scene.find("<box_a>").unwrap().states[0].text, "in box b");
}

#[test]
fn robot_is_where_the_domain_says_and_holds_what_it_carries() {
    let domain = shipped::domain("warehouse");
    let world = testing::world_of(
        &domain,
        r#"{"assets": ["<dock>", "<hall>"], "objects": ["<pallet_1>"],
            "asset_states": {"<hall>": "robot_here()"}, "object_states": {"<pallet_1>": "carried()"}}"#,
    );
    assert_eq!(
        places(&world),
        [
            "<dock> in : ",
            "<hall> in : ",
            "(robot) in <hall>: ",
            "<pallet_1> in (robot): "
        ]
    );
}

#[test]
fn hands_hold_what_has_no_other_place() {
    let world = testing::world(
        "household-dual",
        r#"{"assets": ["<bench>"], "objects": ["<jar>", "<lid>"], "object_states":
            {"<jar>": "inside_hand(right)", "<lid>": ["on_something(<bench>)", "inside_hand(left)"]}}"#,
    );
    let lines = places(&world);
    assert!(
        lines.contains(&"<jar> in right: lifted".to_owned()) || lines.contains(&"<jar> in right: ".to_owned()),
        "{lines:?}"
    );
    assert!(
        lines.contains(&"<lid> in <bench>: in the left hand".to_owned()),
        "{lines:?}"
    );
}

#[test]
fn domain_without_words_has_places_by_name_and_exchange() {
    let text = "(define (domain gripper) (:requirements :typing) (:types room ball gripper)
        (:predicates (at-robby ?r - room) (at ?b - ball ?r - room) (free ?g - gripper) (carry ?o - ball ?g - gripper))
        (:action move :parameters (?from ?to - room) :precondition (at-robby ?from)
            :effect (and (at-robby ?to) (not (at-robby ?from))))
        (:action pick :parameters (?o - ball ?r - room ?g - gripper) :precondition (and (at ?o ?r) (at-robby ?r) (free ?g))
            :effect (and (carry ?o ?g) (not (at ?o ?r)) (not (free ?g))))
        (:action drop :parameters (?o - ball ?r - room ?g - gripper) :precondition (and (carry ?o ?g) (at-robby ?r))
            :effect (and (at ?o ?r) (free ?g) (not (carry ?o ?g)))))";
    let domain = longstep_core::domain::from_pddl("gripper.pddl", text).unwrap();
    let problem = "(define (problem p) (:domain gripper) (:objects a b - room one two - ball left - gripper)
        (:init (at-robby a) (at one b) (carry two left)) (:goal (at one a)))";
    let world = longstep_core::pddl::read_problem(&domain, "p.pddl", problem)
        .unwrap()
        .world;
    assert_eq!(
        places(&world),
        [
            "a in : ",
            "(robot) in a: ",
            "b in : ",
            "one in b: ",
            "left in : ",
            "two in left: "
        ]
    );
}

#[test]
fn states_are_short_words_with_numbers_and_assumptions() {
    let tank = testing::world(
        "tank",
        r#"{"assets": ["<tank_1>"], "asset_states": {"<tank_1>": ["here()", "level(3)"]}}"#,
    );
    let lines = places(&tank);
    assert!(lines.iter().any(|line| line.contains("level 3")), "{lines:?}");
    let flat = testing::world(
        "virtualhome",
        r#"{"assets": ["<fridge_1>"], "asset_properties": {"<fridge_1>": "IS_OPENABLE"}}"#,
    );
    let scene = Scene::of(&flat, &flat.state);
    let fridge = scene.find("<fridge_1>").unwrap();
    assert_eq!(
        (fridge.states[0].text.as_str(), fridge.states[0].assumed),
        ("closed", true)
    );
}

#[test]
fn long_and_foreign_names_stay_inside_their_boxes() {
    let long = "a very long name of a thing ".repeat(8);
    let names = [
        ("<a>", long.as_str()),
        ("<b>", "קומקום כחול גדול מאוד על השולחן במטבח הישן"),
        ("<c>", "非常に長い名前の青いマグカップと白い皿とフォーク"),
        ("<d>", "إبريق الشاي الأزرق الكبير"),
        ("<e>", "x\u{1}\u{202e}<&\"'>\u{fffe}]]>"),
        ("<f>", "🤖🤖🤖👩‍🔬 robot"),
        ("<g>", "Donaudampfschifffahrtsgesellschaftskapitänsmützenabzeichen"),
    ];
    let objects = names.map(|(id, _)| id);
    let world = testing::world(
        "household",
        serde_json::json!({"assets": ["<table>"], "objects": objects, "object_states":
            {"<b>": "on_something(<table>)", "<c>": "on_something(<b>)", "<d>": "on_something(<c>)"}}),
    );
    let mut scene = Scene::of(&world, &world.state);
    // Environments limit names to 60 characters of a few kinds; pictures do not rely on it.
    for own in &mut scene.boxes {
        if let Some((_, name)) = names.iter().find(|(id, _)| *id == own.id) {
            own.name = (*name).to_owned();
            own.states = vec![StateText {
                text: format!("set to {name}"),
                assumed: true,
            }];
        }
    }
    check_pictures(&scene, &Changes::default());
    let svg = svg(&scene, &Changes::default(), &SvgOptions::new(360.0));
    assert!(svg.contains(long.trim_end()), "the title has the whole name");
}

#[test]
fn deep_nesting_is_counted_where_there_is_no_room() {
    let objects: Vec<String> = (0..200).map(|number| format!("<box_{number}>")).collect();
    let states: serde_json::Map<_, _> = (1..200)
        .map(|number| {
            (
                objects[number].clone(),
                format!("inside_something({})", objects[number - 1]).into(),
            )
        })
        .collect();
    let world = testing::world(
        "household",
        serde_json::json!({"objects": objects, "object_states": states}),
    );
    let scene = Scene::of(&world, &world.state);
    check_scene(&world, &scene, "chain");
    check_pictures(&scene, &Changes::default());
}

#[test]
fn many_states_are_counted_and_long_ones_broken() {
    let world = testing::world("household", r#"{"objects": ["<cup>"]}"#);
    let mut scene = Scene::of(&world, &world.state);
    let state = |text: &str| StateText {
        text: text.to_owned(),
        assumed: false,
    };
    let lists: [Vec<StateText>; 4] = [
        vec![state("has been wiped with the sponge in the right hand"), state("open")],
        vec![state("has been wiped with the sponge in the right hand of the robot, twice"); 3],
        (0..40).map(|number| state(&"ab ".repeat(number % 7))).collect(),
        vec![state("ab"); 90],
    ];
    for states in lists {
        for length in [3, 9, 30] {
            let cup = scene.boxes.iter_mut().find(|own| own.id == "<cup>").unwrap();
            cup.name = "c".repeat(length);
            cup.states.clone_from(&states);
            check_pictures(&scene, &Changes::default());
        }
    }
    let svg = svg(&scene, &Changes::default(), &SvgOptions::new(360.0));
    assert!(
        svg.contains(">+"),
        "the last line has the number of states that are left out"
    );
}

#[test]
fn difference_lists_moves_states_and_entities() {
    let world = |text| testing::world("household", text);
    let before = world(
        r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"],
            "object_states": {"<pen>": "on_something(<desk>)", "<cup>": "inside_hand()"}}"#,
    );
    let after = world(
        r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<jar>"],
            "object_states": {"<pen>": ["on_something(<shelf>)", "inside_hand()"]}}"#,
    );
    let scenes = [&before, &after].map(|world| Scene::of(world, &world.state));
    let changes = Scene::difference(&scenes[0], &scenes[1]);
    insta::assert_snapshot!(serde_json::to_string_pretty(&changes).unwrap());
    assert!(Scene::difference(&scenes[0], &scenes[0]).is_empty());
    check_pictures(&scenes[1], &changes);
}

#[test]
fn forty_objects_in_ten_places() {
    let places: Vec<String> = (0..10).map(|number| format!("<place_{number}>")).collect();
    let objects: Vec<String> = (0..40).map(|number| format!("<object_{number}>")).collect();
    let on =
        |(number, object): (usize, &String)| (object.clone(), format!("on_something({})", places[number % 10]).into());
    let states: serde_json::Map<_, _> = objects.iter().enumerate().map(on).collect();
    let world = testing::world(
        "household",
        serde_json::json!({"assets": places, "objects": objects, "object_states": states}),
    );
    let scene = Scene::of(&world, &world.state);
    check_pictures(&scene, &Changes::default());
    let height = |width| {
        layout::Layout::new(&scene, &Changes::default(), width)
            .whole()
            .area
            .height
    };
    assert!(height(360.0) < 1600.0, "{}", height(360.0));
    assert!(height(1200.0) < 600.0, "{}", height(1200.0));
}

#[test]
fn picture_of_a_scene() {
    let world = testing::world(
        "household",
        r#"{"assets": ["<desk>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#,
    );
    let plan = testing::plan_for(&world, "put(pen, desk)");
    assert!(plan.steps().is_empty());
    let scene = Scene::of(&world, &world.state);
    let options = SvgOptions::new(360.0)
        .with_prefix("s1")
        .with_title("Desk")
        .without_style();
    insta::assert_snapshot!(svg(&scene, &Changes::default(), &options).replace("><", ">\n<"));
}

/// Both scenes say what is on and what is in a box if one needs to, and a mark has a reason that can be read.
#[test]
fn scenes_side_by_side_say_the_same_of_places_and_why_boxes_are_marked() {
    let text = r#"{"assets": ["<counter>", "<fridge>"], "objects": ["<butter>", "<fridge_handle>"],
        "object_states": {"<butter>": "inside_something(<fridge>)", "<fridge_handle>": ["on_something(<fridge>)", "closed()"]}}"#;
    let world = testing::world("household", text);
    let plan = testing::plan_for(&world, "put(butter, counter) & closed(fridge)");
    let (before, after) = (Scene::of(&world, &world.state), Scene::of(&world, &plan.ending().after));
    let svg = comparison(
        ("Before", &before),
        &[("After".to_owned(), after)],
        &SvgOptions::new(900.0),
    );
    assert_eq!(svg.matches(">on it<").count(), 3, "{svg}");
    let handle = svg.rsplit("data-id=\"&lt;fridge_handle&gt;\"").next().unwrap();
    let handle = handle.split("data-id").next().unwrap();
    assert!(
        !handle.contains("ls-mark") || handle.matches("<text").count() > 2,
        "{handle}"
    );
}

/// Sets facts of a world at random, whatever they mean.
fn random_state(world: &World, picks: &[(usize, usize, usize)]) -> State {
    let domain: &Domain = world.domain();
    let mut state = world.state.clone();
    for (predicate, first, second) in picks {
        let id = PredicateId::new(predicate % domain.predicates.len());
        let mut choices = [*first, *second].into_iter().cycle();
        let argument = |kind| -> Option<EntityId> {
            let all = world.of_kind(kind);
            Some(*all.get(choices.next()? % all.len().max(1))?)
        };
        let parameters = domain.predicate(id).parameters.iter();
        if let Some(arguments) = parameters.map(|own| own.kind).map(argument).collect::<Option<Vec<_>>>() {
            let fact = Fact::new(id, arguments);
            let holds = state.holds(fact);
            state.set(fact, !holds);
        }
    }
    state
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(120))]

    #[test]
    fn random_states_have_one_box_for_each_entity(
        number in 0_usize..1_000,
        picks in proptest::collection::vec((0_usize..200, 0_usize..200, 0_usize..200), 0..60),
        more in proptest::collection::vec((0_usize..200, 0_usize..200, 0_usize..200), 0..5),
    ) {
        let worlds = WORLDS.get_or_init(shipped::worlds);
        let (label, world) = &worlds[number % worlds.len()];
        let before = random_state(world, &picks);
        let picks: Vec<_> = picks.into_iter().chain(more).collect();
        let after = random_state(world, &picks);
        let scenes = [&before, &after].map(|state| Scene::of(world, state));
        check_scene(world, &scenes[1], label);
        let changes = Scene::difference(&scenes[0], &scenes[1]);
        check_pictures(&scenes[1], &changes);
        prop_assert_eq!(step_changes(world, &before, &after), changes);
    }
}

static WORLDS: std::sync::OnceLock<Vec<(String, World)>> = std::sync::OnceLock::new();

/// Finds the changes between two states as frames do, from the facts that differ.
fn step_changes(world: &World, before: &State, after: &State) -> Changes {
    let schema = SceneSchema::of(world.domain());
    let differences = longstep_core::model::changed_facts(before, after).into_iter();
    let facts = differences.map(|own| longstep_core::model::Change {
        fact: own.fact,
        holds: own.now_holds,
    });
    let changed = longstep_core::model::Changes {
        facts: facts.collect(),
        numbers: Vec::new(),
    };
    let placements = [before, after].map(|state| Placement::of(&schema, world, state));
    let moment = |state, index: usize| SceneMoment {
        state,
        placement: &placements[index],
    };
    changes_between(&schema, world, moment(before, 0), moment(after, 1), &changed)
}

#[test]
fn comparison_has_every_scene_inside_its_frame() {
    for (label, world) in shipped::worlds() {
        let mut state = world.state.clone();
        for (id, _) in world.entities() {
            if let Some(fact) = world.facts_about(id).into_iter().next() {
                state.set(fact, false);
            }
        }
        let before = Scene::of(&world, &world.state);
        let afters =
            ["After <the> \"plan\"", "If & only if"].map(|heading| (heading.to_owned(), Scene::of(&world, &state)));
        for width in [120.0, 500.0, 1200.0] {
            let options = SvgOptions::new(width).with_prefix("p9");
            let drawn = inspect::check(&comparison(("Before", &before), &afters, &options), "p9");
            let distinct: BTreeSet<&String> = drawn.iter().collect();
            assert!(drawn.len() > distinct.len(), "{label}: one scene is missing at {width}");
        }
    }
}
