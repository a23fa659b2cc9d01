//! Names as people see them: shared names, given names, labels, scripts, the speaker, and types of an environment.
#![allow(clippy::unwrap_used, clippy::panic, missing_docs)]

use longstep::dialogue::{ConstraintKind, Dialogue, Likelihood, Reply};
use longstep::goal::parse;
use longstep::understanding::{Understanding, UnderstandingInput};
use longstep_core::domain::{self, Domain, Files};
use longstep_core::environment::{self, Environment, Origin, World};
use longstep_core::pddl::{object_names, write_problem};
use longstep_core::testing;

fn files() -> Files {
    Files {
        folder: "yard/".to_owned(),
        pddl: include_str!("yard/domain.pddl").to_owned(),
        words: include_str!("yard/domain.toml").to_owned(),
        ..Files::default()
    }
}

fn yard() -> Domain {
    domain::load(&files()).unwrap()
}

fn world(environment: &str) -> World {
    testing::world_of(&yard(), environment)
}

/// Three pallets, two tubes and two docks.
const BUSY: &str = r#"{"assets": ["<bay_1>", "<bay_2>", "<dock>"],
    "objects": ["<pallet_2>", "<pallet_3>", "<pallet_4>", "<tube_A>", "<tube_B>", "<crate>"],
    "object_states": {"<pallet_2>": ["red()", "at(<bay_1>)"], "<pallet_3>": ["blue()", "at(<bay_1>)"],
        "<pallet_4>": ["blue()", "at(<bay_2>)"], "<tube_A>": "at(<bay_1>)", "<tube_B>": "at(<bay_2>)"}}"#;

#[track_caller]
fn check_goals(environment: &str, rows: &[(&str, &str)]) {
    let world = world(environment);
    for (text, expected) in rows {
        let found = match parse(&world, text) {
            Ok(goal) => goal.exact(&world).join(" & "),
            Err(error) => error.to_string(),
        };
        assert_eq!(found, *expected, "{text}");
    }
}

#[test]
fn name_error_suggests_longer_names_with_that_word() {
    let benches = r#"{"assets": ["<rear_bay>", "<side_bay>", "<dock>"], "objects": ["<crate>", "<blue_crate>"],
        "object_states": {"<crate>": "at(<dock>)", "<blue_crate>": "at(<dock>)"}}"#;
    check_goals(
        benches,
        &[
            (
                "bring(crate, bay)",
                "`bay` in `bring(crate, bay)` is nothing in the environment; did you mean `rear bay` or `side bay`?",
            ),
            ("bring(crate, dock)", "bring(<crate>, <dock>)"),
        ],
    );
}

#[test]
fn a_goal_with_a_shared_name_is_an_error_that_describes_each_candidate() {
    check_goals(
        BUSY,
        &[
            (
                "bring(pallet, dock)",
                "`pallet` in `bring(pallet, dock)` is the name of several entities: pallet 2 (red), \
                 pallet 3 (at bay 1, is blue), pallet 4 (at bay 2); write one of these names",
            ),
            (
                "discard(tube)",
                "`tube` in `discard(tube)` is the name of several entities: tube A (at bay 1), tube B (at bay 2); \
                 write one of these names",
            ),
            ("bring(pallet 3, dock)", "bring(<pallet_3>, <dock>)"),
            ("bring(Crate, DOCK)", "bring(<crate>, <dock>)"),
            ("bring(tube a, bay 2)", "bring(<tube_A>, <bay_2>)"),
            (
                "never bring(pallet, dock)",
                "`pallet` in `bring(pallet, dock)` is the name of several entities: pallet 2 (red), \
                 pallet 3 (at bay 1, is blue), pallet 4 (at bay 2); write one of these names",
            ),
            (
                "bring(pallet 5, dock)",
                "`pallet 5` in `bring(pallet 5, dock)` is nothing in the environment; did you mean `pallet 2`?",
            ),
        ],
    );
}

#[test]
fn an_identifier_without_brackets_names_its_entity() {
    check_goals(
        BUSY,
        &[
            ("bring(pallet_3, bay_2)", "bring(<pallet_3>, <bay_2>)"),
            ("discard(TUBE_a)", "discard(<tube_A>)"),
            (
                "bring(pallet_5, dock)",
                "`pallet_5` in `bring(pallet_5, dock)` is nothing in the environment; did you mean `pallet 2`?",
            ),
        ],
    );
    // Numbers of a graph are no labels; the words of an identifier may be the name of another entity.
    let graph = r#"{"assets": ["<bay_31>", "<dock_32>"], "objects": ["<pallet_2>", "<pallet_1>", "<crate_40>", "<tube_41>"],
        "names": {"<crate_40>": "tube_41"}}"#;
    check_goals(
        graph,
        &[
            ("bring(pallet_1, dock)", "bring(<pallet_1>, <dock_32>)"),
            ("bring(pallet 1, dock)", "bring(<pallet_2>, <dock_32>)"),
            (
                "bring(tube_41, dock)",
                "`tube_41` in `bring(tube_41, dock)` is the name of several entities: tube_41 (has no cap), tube (has a cap); write \
                 one of these names",
            ),
        ],
    );
    check_instructions(
        BUSY,
        &[
            (
                "Bring pallet_3 to bay_2",
                "bring(pallet 3, bay 2)",
                "bring(pallet 3, bay 2)",
            ),
            ("Discard TUBE_A.", "discard(tube A)", "discard(tube A)"),
        ],
    );
}

#[track_caller]
fn check_instructions(environment: &str, rows: &[(&str, &str, &str)]) {
    let world = world(environment);
    for (instruction, goal, expected) in rows {
        let domain = yard().into();
        let input = UnderstandingInput::new(&domain, &world, instruction, ConstraintKind::Grammar);
        let sure = Likelihood {
            text: -10,
            ..Likelihood::default()
        };
        let reply = Reply {
            likelihood: Some(sure),
            ..Reply::complete(*goal)
        };
        let meant = Understanding::new(input).supply(&reply).unwrap().unwrap();
        let found = meant.question.unwrap_or_else(|| meant.goal.unwrap().text(&world));
        assert_eq!(found, *expected, "{instruction}");
    }
}

#[test]
fn an_instruction_with_a_shared_name_is_a_question() {
    let pallets = "Which pallet do you mean: pallet 2 (red), or pallet 3 (at bay 1, is blue), or pallet 4 (at bay 2)?";
    let tubes = "Which tube do you mean: tube A (at bay 1), or tube B (at bay 2)?";
    check_instructions(
        BUSY,
        &[
            ("Bring the pallet to the dock", "bring(pallet 2, dock)", pallets),
            ("Bring pallet to dock", "bring(pallet 3, dock)", pallets),
            ("Throw the tube away", "discard(tube A) & discard(tube B)", tubes),
            ("Throw the tube away", "discard(tube B)", tubes),
            (
                "Bring the pallet to the dock and the crate then to the bay",
                "bring(pallet 2, dock) then bring(crate, bay 1)",
                pallets,
            ),
            (
                "Bring the crate to the bay",
                "bring(crate, bay 1)",
                "Which bay do you mean: bay 1, or bay 2?",
            ),
            // The reference is clear, or permits any or all of them.
            (
                "Bring pallet 3 to the dock",
                "bring(pallet 3, dock)",
                "bring(pallet 3, dock)",
            ),
            (
                "Bring the red pallet to the dock",
                "bring(pallet 2, dock)",
                "bring(pallet 2, dock)",
            ),
            (
                "Bring the pallet from bay 2 to the dock",
                "bring(pallet 4, dock)",
                "bring(pallet 4, dock)",
            ),
            (
                "Bring the pallet from bay 1 to the dock",
                "bring(pallet 3, dock)",
                "Which pallet do you mean: pallet 2 (red), or pallet 3 (is blue)?",
            ),
            (
                "Bring a pallet to the dock",
                "bring(pallet 4, dock)",
                "bring(pallet 4, dock)",
            ),
            ("Throw tube B away", "discard(tube B)", "discard(tube B)"),
            (
                "Throw the tubes away",
                "discard(tube A) & discard(tube B)",
                "discard(tube A) & discard(tube B)",
            ),
            ("Throw both tubes away", "discard(tube A)", "discard(tube A)"),
        ],
    );
}

#[test]
fn given_names_mean_the_entities_that_carry_them() {
    let text = r#"{"assets": ["<dock>"], "objects": ["<x>", "<y>", "<pallet_7>", "<z>"],
        "object_states": {"<x>": "red()", "<y>": "blue()"},
        "names": {"<x>": "pallet", "<y>": "pallet", "<z>": "Maria"}}"#;
    check_goals(
        text,
        &[
            (
                "bring(pallet, dock)",
                "`pallet` in `bring(pallet, dock)` is the name of several entities: pallet 1 (red), \
                 pallet 2 (is blue); write one of these names",
            ),
            ("bring(pallet 7, dock)", "bring(<pallet_7>, <dock>)"),
            ("bring(maria, dock)", "bring(<z>, <dock>)"),
        ],
    );
    let question = "Which pallet do you mean: pallet 1 (red), or pallet 2 (is blue)?";
    check_instructions(
        text,
        &[("Bring the pallet to the dock", "bring(pallet 2, dock)", question)],
    );
}

/// Identifiers with dots, hyphens, blanks, capitals and in several scripts.
const SCRIPTS: &str = r#"{"assets": ["<Bay.3-A>", "<Bay.3-B>", "<İstanbul>", "<dock-one>"],
    "objects": ["<杯子_1>", "<杯子_2>", "<Чашка>", "<कुर्सी>", "<red box>", "<Tube>"],
    "object_states": {"<杯子_1>": "at(<Bay.3-A>)", "<杯子_2>": "at(<İstanbul>)", "<Чашка>": ["at(<Bay.3-B>)", "red()"],
        "<red box>": "at(<dock-one>)", "<कुर्सी>": "at(<dock-one>)"}}"#;

#[test]
fn identifiers_of_any_script_work_everywhere() {
    check_goals(
        SCRIPTS,
        &[
            ("bring(чашка, bay 3 A)", "bring(<Чашка>, <Bay.3-A>)"),
            ("bring(<杯子_2>, <İstanbul>)", "bring(<杯子_2>, <İstanbul>)"),
            ("bring(杯子 1, dock one)", "bring(<杯子_1>, <dock-one>)"),
            ("bring(कुर्सी, Bay 3 B)", "bring(<कुर्सी>, <Bay.3-B>)"),
            ("bring(red box, <Bay.3-B>)", "bring(<red box>, <Bay.3-B>)"),
            (
                "bring(杯子, dock one)",
                "`杯子` in `bring(杯子, dock one)` is the name of several entities: 杯子 1 (at bay 3 A), \
                 杯子 2 (at the i\u{307}stanbul); write one of these names",
            ),
        ],
    );
    let world = world(SCRIPTS);
    let text = "bring(<Чашка>, <İstanbul>) & bring(<red box>, <Bay.3-A>)";
    let (goal, plan) = (parse(&world, text).unwrap(), testing::plan_for(&world, text));
    let calls: Vec<String> = plan.steps().iter().map(|step| step.call(&world).to_string()).collect();
    assert_eq!(calls, ["bring(<Чашка>, <İstanbul>)", "bring(<red box>, <Bay.3-A>)"]);
    let explained: Vec<String> = plan.steps().iter().map(|step| step.explanation.clone()).collect();
    assert_eq!(
        explained,
        ["bring чашка to the i\u{307}stanbul", "bring the red box to bay 3 A"]
    );
    let names = object_names(&world);
    let unique: std::collections::BTreeSet<&String> = names.iter().collect();
    assert_eq!(unique.len(), names.len());
    assert!(names.iter().all(|name| name.is_ascii()), "{names:?}");
    let problem = write_problem(&world, &goal.purpose(&world), "names").unwrap();
    assert_eq!(problem, write_problem(&world, &goal.purpose(&world), "names").unwrap());
    assert!(problem.contains("; <杯子_2>"), "{problem}");
    let written = serde_json::to_string(world.environment()).unwrap();
    assert_eq!(Environment::from_json(&written).unwrap(), *world.environment());
}

#[test]
fn articles_stand_only_where_a_name_takes_one() {
    let text = r#"{"assets": ["<dock>", "<bay_1>", "<bay_2>"], "objects": ["<crate>", "<tube_A>", "<чашка>", "<p>", "<q>"],
        "names": {"<p>": "Maria", "<q>": "old box"}}"#;
    let check = |domain: &Domain, expected: &[&str]| {
        let world = testing::world_of(domain, text);
        let names: Vec<String> = world.entities().map(|(id, _)| world.with_article(id)).collect();
        assert_eq!(names, expected);
    };
    check(
        &yard(),
        &[
            "the dock",
            "bay 1",
            "bay 2",
            "the crate",
            "tube A",
            "чашка",
            "Maria",
            "the old box",
        ],
    );
    let without = yard().edited(|data| data.article = String::new());
    check(
        &without,
        &["dock", "bay 1", "bay 2", "crate", "tube A", "чашка", "Maria", "old box"],
    );
}

#[test]
fn the_speaker_and_the_robot_are_entities_that_the_environment_names() {
    let text = r#"{"assets": ["<dock>"], "objects": ["<pills>", "<anna>", "<ben>"], SPEAKER
        "object_states": {"<pills>": "at(<dock>)"}, "types": {"<anna>": "person", "<ben>": "person"}}"#;
    let rows = [
        ("give(pills, me)", "give(<pills>, <anna>)"),
        ("give(pills, Anna)", "give(<pills>, <anna>)"),
        (
            "bring(you, dock)",
            "`you` in `bring(you, dock)` is the robot, and the environment does not say which entity that is; \
             add `\"robot\": \"<identifier>\"` to it",
        ),
    ];
    let with = text.replace("SPEAKER", "\"speaker\": \"<anna>\",");
    check_goals(&with, &rows);
    check_instructions(
        &with,
        &[("Give me the pills", "give(pills, anna)", "give(pills, anna)")],
    );
    let nobody = [(
        "give(pills, me)",
        "`me` in `give(pills, me)` is the speaker, and the environment does not say which entity that is; \
         add `\"speaker\": \"<identifier>\"` to it",
    )];
    check_goals(&text.replace("SPEAKER", ""), &nobody);
    let written = serde_json::to_value(world(&with).environment()).unwrap();
    assert_eq!(
        (&written["speaker"], &written["types"]["<ben>"]),
        (&"<anna>".into(), &"person".into())
    );
}

#[test]
fn types_of_an_environment_are_checked_and_exported() {
    let check = |entries: &str, expected: &str| {
        let text = format!(r#"{{"assets": ["<dock_1>"], "objects": ["<crate>"], {entries}}}"#);
        let findings = environment::parse(&yard(), "env.json", &text).unwrap_err().to_string();
        assert_eq!(findings.split_once(": ").unwrap().1, expected, "{entries}");
    };
    check(
        r#""types": {"<dock_1>": "dok"}"#,
        "types.<dock_1>: the domain has no type `dok`\n  hint: did you mean `dock`?",
    );
    check(
        r#""types": {"<dock_1>": "person"}"#,
        "types.<dock_1>: `<dock_1>` is listed as `place`, and `person` is no such type\n  hint: types of this list are place, dock, bay",
    );
    check(
        r#""types": {"<dock_2>": "dock"}"#,
        "types.<dock_2>: `<dock_2>` is listed neither in `assets` nor in `objects`\n  hint: did you mean `<dock_1>`? Otherwise add it to `assets` or `objects`",
    );
    check(
        r#""speaker": "<anna>""#,
        "speaker: `<anna>` is listed neither in `assets` nor in `objects`\n  hint: add it to `assets` or `objects`",
    );
    let world = world(
        r#"{"assets": ["<dock_1>"], "objects": ["<crate>"], "object_states": {"<crate>": "at(<dock_1>)"},
        "types": {"<dock_1>": "dock"}}"#,
    );
    let goal = parse(&world, "bring(crate, dock)").unwrap();
    let problem = write_problem(&world, &goal.purpose(&world), "types").unwrap();
    assert!(problem.contains("dock_1 - dock ;"), "{problem}");
    let part = world.narrowed(&[world.find("<crate>").unwrap()]);
    assert_eq!(part.environment().types, Some(Default::default()));
}

/// The facts of an entity as sentences, each with its origin.
fn facts(world: &World, identifier: &str) -> Vec<String> {
    let facts = world.facts_about(world.find(identifier).unwrap()).into_iter();
    let shown = facts.map(|fact| {
        format!(
            "{}: {}",
            environment::fact_text(world, fact, true),
            Origin::of(world, fact)
        )
    });
    shown.collect()
}

#[test]
fn derivations_by_name_ignore_case_and_labels_and_bind_one_entity() {
    let text = r#"{"objects": ["<tube>", "<Tube>", "<tube_A>", "<tube.1>", "<sample-TUBE-B2>", "<tube_rack>", "<vial>"],
        "object_properties": {"<vial>": "CAPPED", "<tube.1>": "OPEN_TUBE"}}"#;
    let world = world(text);
    let capped: Vec<&str> = world
        .entities()
        .filter(|(id, _)| !facts(&world, &world.entity(*id).identifier).is_empty())
        .map(|(_, entity)| entity.identifier.as_str())
        .collect();
    assert_eq!(capped, ["<tube>", "<Tube>", "<tube_A>", "<sample-TUBE-B2>", "<vial>"]);
    let line = yard().derivations[0].line;
    assert_eq!(
        facts(&world, "<tube_A>"),
        [format!(
            "tube A has a cap: derived, domain.toml:{line}: `<tube_A>` matches the name `tube`"
        )]
    );
    assert_eq!(facts(&world, "<vial>"), ["the vial has a cap: given"]);
    // A domain can declare that environments list a property completely.
    let complete = yard().edited(|data| {
        data.predicate_words.iter_mut().for_each(|words| words.complete = true);
    });
    let world = testing::world_of(&complete, text);
    assert_eq!(world.state.iter().count(), 1);
}

#[test]
fn a_negated_default_is_an_error() {
    let mut files = files();
    files
        .words
        .push_str("\n[[default]]\nfact = \"(not (red ?self))\"\nwhen = \"(blue ?self)\"\n");
    let errors = domain::load(&files).unwrap_err().to_string();
    assert!(
        errors.contains("a default is a fact that usually holds, not the lack of one"),
        "{errors}"
    );
}
