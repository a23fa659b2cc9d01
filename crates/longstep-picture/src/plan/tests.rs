use std::collections::BTreeSet;
use std::time::Instant;

use longstep_core::goal;
use longstep_core::plan;
use longstep_core::repair;
use longstep_core::schedule;
use longstep_core::search::{self, Limits, Outcome};
use longstep_core::testing;
use longstep_core::verify::{check, check_file};
use proptest::prelude::*;

use super::*;
use crate::SvgOptions;
use crate::draw::inspect;
use crate::shipped;

const PANTRY: &str = "crates/longstep-eval/suites/branching/scenes/pantry.json";

/// Returns the diagram of a plan for a goal.
#[track_caller]
fn planned(world: &World, goal: &str) -> (VerifiedPlan, Diagram) {
    let goal = goal::parse(world, goal).unwrap_or_else(|error| panic!("{error}"));
    let purpose = goal.purpose(world);
    let Outcome::Solved { plan, .. } = search::solve(world, &purpose, &Limits::default()) else {
        panic!("no plan");
    };
    let plan = check(world, plan, &purpose).into_verified().unwrap();
    let diagram = Diagram::of(&plan, &Annotations::default().with_goal(world, &goal));
    (plan, diagram)
}

/// Checks that a diagram has every step once, and its pictures in several widths.
#[track_caller]
fn check_diagram(diagram: &Diagram, count: usize) {
    let mut numbers: Vec<usize> = diagram.steps().iter().map(|step| step.number).collect();
    numbers.sort_unstable();
    assert_eq!(numbers, (1..=count).collect::<Vec<_>>());
    for width in [120.0, 360.0, 800.0, 1200.0] {
        let picture = svg(diagram, &SvgOptions::new(width).with_prefix("d"));
        inspect::check(&picture, "d");
        let drawn: BTreeSet<&str> = picture
            .split("data-step=\"")
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .collect();
        assert_eq!(drawn.len(), count, "at {width}");
        assert_eq!(picture.matches("data-step=").count(), count, "at {width}");
    }
}

fn reasons(diagram: &Diagram) -> Vec<String> {
    let line = |step: &&StepNode| {
        format!(
            "{} {}: {}",
            step.number,
            step.text,
            step.reason.clone().unwrap_or_default()
        )
    };
    diagram.steps().iter().map(line).collect()
}

#[test]
fn reasons_follow_causal_links_to_the_goal() {
    let world = testing::world(
        "household",
        r#"{"assets": ["<desk>", "<fridge>"], "objects": ["<pen>", "<fridge_handle>"],
            "object_states": {"<pen>": "on_something(<desk>)", "<fridge_handle>": "closed()"}}"#,
    );
    let (plan, diagram) = planned(&world, "put(pen, fridge)");
    check_diagram(&diagram, plan.steps().len());
    insta::assert_snapshot!(reasons(&diagram).join("\n"));
}

#[test]
fn every_step_of_a_shortest_plan_has_a_reason() {
    let table = [
        (
            "household",
            "crates/longstep-eval/suites/long/scenes/cafe.json",
            "put(cheesecake, window table) & put(sugar, counter)",
        ),
        (
            "household-dual",
            "crates/longstep-eval/suites/two-arms/scenes/workshop.json",
            "put(vise, workbench)",
        ),
        (
            "household-checks",
            PANTRY,
            "put(ham, fridge) & if expired(milk) then put(milk, trash bin) else put(milk, pantry shelf)",
        ),
        (
            "virtualhome",
            "crates/longstep-eval/suites/kitchen/scenes/family.json",
            "put(plate 1, sink) & on(radio)",
        ),
        (
            "warehouse",
            "examples/warehouse/suite/scenes/cold_store.json",
            "brought(pallet 17, dock 3)",
        ),
        (
            "home",
            "examples/home/suite/scenes/house.json",
            "coloured(hall light, red)",
        ),
        (
            "home",
            "examples/home/suite/scenes/flat.json",
            "closed(balcony door) then armed(alarm)",
        ),
    ];
    for (domain, file, goal) in table {
        let (plan, diagram) = planned(&shipped::world(domain, file), goal);
        check_diagram(&diagram, plan.steps().len());
        for step in diagram.steps() {
            assert!(step.reason.is_some(), "{goal}: step {} {}", step.number, step.text);
            assert!(!step.changes.is_empty(), "{goal}: step {} {}", step.number, step.text);
            assert!(step.needed_by.iter().all(|later| *later > step.number), "{goal}");
        }
    }
}

#[test]
fn reason_is_lost_without_the_step_that_needs_it() {
    // The hand goes to the shelf for nothing.
    let world = testing::world("household", r#"{"assets": ["<shelf>"], "objects": ["<pen>"]}"#);
    let steps_of = |names: &[&[&str]]| {
        let step = |own: &&[&str]| shipped::step(&world, own[0], &own[1..]);
        let plan = Plan::sequence(names.iter().map(step).collect());
        Diagram::of(&shipped::verified(&world, plan), &Annotations::default())
    };
    let wasted = steps_of(&[
        &["move-hand", "<shelf>"],
        &["move-hand", "<pen>"],
        &["grasp", "<pen>"],
        &["release", "<pen>"],
    ]);
    assert_eq!(wasted.steps()[0].reason, None);
    assert_eq!(
        wasted.steps()[1].reason.as_deref(),
        Some("needed for step 3: the hand is at the pen")
    );
    assert_eq!(wasted.steps()[1].brief_reason.as_deref(), Some("needed for step 3"));
}

#[test]
fn diagram_of_a_branch_with_assumptions() {
    let world = testing::world(
        "household-checks",
        r#"{"assets": ["<table>", "<bin>"], "objects": ["<milk>"], "object_states": {"<milk>": "on_something(<table>)"}}"#,
    );
    let script = "# objects: [\"<milk>\"]\nmove_hand()\ngrasp_object()\ndetach_from_plane()\nif check_best_by_date():\n    # It is still good.\n    move_object(to=\"<table>\")\n    attach_to_plane()\n    release_object()\nelse:\n    move_object(to=\"<bin>\")\n    release_object()\n";
    let draft = plan::read(script).unwrap();
    let plan = check_file(&world, &draft.file).unwrap().into_verified().unwrap();
    let ask = Assumption::Argument {
        step: 4,
        parameter: "to".to_owned(),
        entity: world.find("<table>").unwrap(),
    };
    let general = Assumption::Reading {
        step: None,
        written: "<milc>".to_owned(),
        meant: "<milk>".to_owned(),
    };
    let annotations = Annotations::default().with_assumptions(&[ask, general]);
    let diagram = Diagram::of(&plan, &annotations);
    check_diagram(&diagram, plan.steps().len());
    insta::assert_snapshot!(serde_json::to_string_pretty(&diagram).unwrap());
}

#[test]
fn edits_of_a_repair_are_at_their_steps() {
    let world = testing::world(
        "household",
        r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>"], "object_states": {"<pen>": "on_something(<desk>)"}}"#,
    );
    let script = "# objects: [\"<pen>\"]\ngrasp_object()\ndetach_from_plane()\nmove_object(to=\"<shelf>\")\nattach_to_plane()\nrelease_object()\nopen_by_slide()\n";
    let draft = plan::read(script).unwrap();
    let resolved = plan::resolve(&world, &draft.file.task_cohesion);
    let purpose = goal::parse(&world, "put(pen, shelf)").unwrap().purpose(&world);
    let outcome = repair::repair(&world, &resolved, &purpose);
    let repair::RepairOutcome::Repaired(repaired) = outcome else {
        panic!("{outcome:?}");
    };
    let annotations = Annotations::default().with_purpose(purpose).with_edits(&repaired.edits);
    let diagram = Diagram::of(&repaired.plan, &annotations);
    check_diagram(&diagram, repaired.plan.steps().len());
    let edited = diagram
        .steps()
        .into_iter()
        .filter_map(|step| Some((step.number, step.edited.clone()?)));
    let edited: Vec<(usize, String)> = edited.collect();
    assert_eq!((edited.len(), edited[0].0), (1, 1));
    assert!(edited[0].1.starts_with("added: "), "{edited:?}");
    assert_eq!(diagram.left_out.len(), 1);
    assert!(
        diagram.left_out[0].starts_with("open_by_slide(): "),
        "{:?}",
        diagram.left_out
    );
    let picture = svg(&diagram, &SvgOptions::new(400.0));
    assert!(picture.contains("ls-changed") && picture.contains("left out: open_by_slide()"));
}

#[test]
fn lanes_have_a_row_for_each_unit_of_time() {
    let world = shipped::world(
        "household-dual",
        "crates/longstep-eval/suites/two-arms/scenes/workshop.json",
    );
    let goal = goal::parse(
        &world,
        "put(drill, high shelf, right hand) & put(rag, scrap bin, left hand)",
    )
    .unwrap();
    let purpose = goal.purpose(&world);
    let plan = testing::plan_for(
        &world,
        "put(drill, high shelf, right hand) & put(rag, scrap bin, left hand)",
    );
    let shared = schedule::share(&world, &plan, &purpose).unwrap().plan;
    let diagram = Diagram::of(&shared, &Annotations::default().with_goal(&world, &goal));
    check_diagram(&diagram, shared.steps().len());
    let DiagramNode::Lanes { lanes, rows } = &diagram.nodes[0] else {
        panic!("{:?}", diagram.nodes[0]);
    };
    assert_eq!(lanes, &["right hand", "left hand"]);
    let LaneRow::Unit { cells } = &rows[0] else { panic!() };
    assert!(cells.iter().all(Option::is_some));
}

#[test]
fn remarks_and_meetings_of_lanes_stay_in_order() {
    let world = testing::world(
        "household-dual",
        r#"{"assets": ["<desk>", "<shelf>"], "objects": ["<pen>", "<cup>"]}"#,
    );
    let world_steps = [["right", "<desk>"], ["left", "<shelf>"]];
    let steps_of = world_steps.map(|own| shipped::step(&world, "move-hand", &own));
    let lane = |actor: &str, items: Vec<LaneItem>| Lane {
        actor: world.find(actor).unwrap(),
        items,
    };
    let step = |number| LaneItem::Step(StepId::new(number));
    let sync = || LaneItem::Sync("ready".to_owned());
    let remark = |text: &str| LaneItem::Remark(text.to_owned());
    let lanes = vec![
        lane("right", vec![remark("first"), step(0), sync()]),
        lane("left", vec![sync(), step(1), remark("done")]),
    ];
    let plan = Plan::tree(steps_of.to_vec(), vec![Node::Parallel { lanes }]).unwrap();
    let diagram = Diagram::of(&shipped::verified(&world, plan), &Annotations::default());
    check_diagram(&diagram, 2);
    let DiagramNode::Lanes { rows, .. } = &diagram.nodes[0] else {
        panic!()
    };
    let kinds: Vec<String> = rows
        .iter()
        .map(|row| match row {
            LaneRow::Unit { cells } => {
                format!("{:?}", cells.iter().flatten().map(|own| own.number).collect::<Vec<_>>())
            }
            LaneRow::Sync { name, lanes } => format!("{name} {lanes:?}"),
            LaneRow::Remark { lane, text } => format!("{lane} {text}"),
        })
        .collect();
    assert_eq!(kinds, ["0 first", "[1]", "ready [0, 1]", "[2]", "1 done"]);
}

#[test]
fn negated_conditions_name_the_other_outcomes() {
    let world = shipped::world("household-checks", PANTRY);
    let (_, diagram) = planned(&world, "if empty(cereal) then put(cereal, trash bin)");
    let branches: Vec<(&String, &String)> = diagram
        .nodes
        .iter()
        .filter_map(|node| match node {
            DiagramNode::Branch {
                condition, otherwise, ..
            } => Some((condition, otherwise)),
            _ => None,
        })
        .collect();
    assert_eq!(branches.len(), 1);
    assert_eq!(branches[0].0, "the cereal is empty");
    assert_eq!(branches[0].1, "the cereal is full or the cereal is partly full");
}

#[test]
fn picture_of_a_branch() {
    let world = shipped::world("household-checks", PANTRY);
    let (_, diagram) = planned(
        &world,
        "if expired(milk) then put(milk, trash bin) else put(milk, pantry shelf)",
    );
    let options = SvgOptions::new(800.0)
        .with_prefix("d1")
        .with_title("Milk")
        .without_style();
    insta::assert_snapshot!(svg(&diagram, &options).replace("><", ">\n<"));
}

#[test]
fn plan_of_a_thousand_steps_has_reasons() {
    let assets: Vec<String> = (0..50).map(|number| format!("<shelf_{number}>")).collect();
    let objects: Vec<String> = (0..450).map(|number| format!("<item_{number}>")).collect();
    let world = testing::world("household", serde_json::json!({"assets": assets, "objects": objects}));
    let mut all = Vec::new();
    for item in objects.iter().take(334) {
        all.push(shipped::step(&world, "move-hand", &[item]));
        all.push(shipped::step(&world, "grasp", &[item]));
        all.push(shipped::step(&world, "release", &[item]));
    }
    let plan = shipped::verified(&world, Plan::sequence(all));
    let begin = Instant::now();
    let diagram = Diagram::of(&plan, &Annotations::default());
    let taken = begin.elapsed();
    assert!(diagram.has_reasons);
    check_diagram(&diagram, 1002);
    assert!(taken.as_secs() < 3, "{taken:?}");
}

/// Returns a diagram of random shape; steps are numbered afterwards.
fn any_node() -> impl Strategy<Value = DiagramNode> {
    let text = prop_oneof![
        Just("put the cup on the shelf".to_owned()),
        Just("x".to_owned()),
        Just("非常に長い名前の青いマグカップを棚に置く".to_owned()),
        Just("Donaudampfschifffahrtsgesellschaftskapitänsmützenabzeichen".to_owned()),
        "[ a-z<&\u{5d0}-\u{5ea}]{0,120}",
    ];
    let step = (text.clone(), 0..9_usize, any::<bool>()).prop_map(|(text, count, senses)| StepNode {
        number: 0,
        text: text.clone(),
        call: text.clone(),
        lane: senses.then(|| text.clone()),
        reason: (count > 2).then(|| text.clone()),
        brief_reason: (count > 2).then(|| text.clone()),
        needed_by: Vec::new(),
        changes: vec![text.clone(); count],
        senses,
        edited: (count % 3 == 0).then(|| text.clone()),
        left_out: if count == 5 { vec![text.clone()] } else { Vec::new() },
        assumed: if count == 4 { vec![text] } else { Vec::new() },
        unreached: count == 7,
    });
    let cell = proptest::option::of(step.clone());
    let row = prop_oneof![
        4 => proptest::collection::vec(cell, 3).prop_map(|cells| LaneRow::Unit { cells }),
        1 => text.clone().prop_map(|name| LaneRow::Sync { name, lanes: vec![0, 2] }),
        1 => (0..3_usize, text.clone()).prop_map(|(lane, text)| LaneRow::Remark { lane, text }),
    ];
    let lanes = proptest::collection::vec(row, 0..5).prop_map(|rows| DiagramNode::Lanes {
        lanes: ["right hand", "left hand", "tool"].map(str::to_owned).to_vec(),
        rows,
    });
    let leaf = prop_oneof![
        6 => step.clone().prop_map(DiagramNode::Step),
        1 => text.clone().prop_map(|text| DiagramNode::Remark { text }),
        1 => lanes,
    ];
    leaf.prop_recursive(7, 40, 4, move |inner| {
        let nodes = proptest::collection::vec(inner, 0..4);
        let sensing = proptest::collection::vec(step.clone(), 0..2);
        let parts = (text.clone(), sensing, nodes.clone(), nodes.clone());
        prop_oneof![
            2 => parts.clone().prop_map(|(text, sensing, then, other)| DiagramNode::Branch {
                condition: text.clone(), otherwise: text, sensing, then, other,
            }),
            1 => parts.prop_map(|(condition, sensing, body, _)| DiagramNode::Loop { condition, sensing, body }),
            1 => nodes.prop_map(|body| DiagramNode::Repeat { times: 3, body }),
        ]
    })
}

fn number(nodes: &mut [DiagramNode], next: &mut usize) {
    let one = |step: &mut StepNode, next: &mut usize| {
        *next += 1;
        step.number = *next;
    };
    for node in nodes {
        match node {
            DiagramNode::Step(step) => one(step, next),
            DiagramNode::Branch {
                sensing, then, other, ..
            } => {
                sensing.iter_mut().for_each(|step| one(step, next));
                number(then, next);
                number(other, next);
            }
            DiagramNode::Loop { sensing, body, .. } => {
                sensing.iter_mut().for_each(|step| one(step, next));
                number(body, next);
            }
            DiagramNode::Repeat { body, .. } => number(body, next),
            DiagramNode::Lanes { rows, .. } => {
                for row in rows {
                    if let LaneRow::Unit { cells } = row {
                        cells.iter_mut().flatten().for_each(|step| one(step, next));
                    }
                }
            }
            DiagramNode::Remark { .. } => {}
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(200))]

    #[test]
    fn random_diagrams_are_drawn_without_overlaps(nodes in proptest::collection::vec(any_node(), 0..6)) {
        let mut diagram = Diagram {
            nodes,
            assumptions: vec!["the fridge is closed".to_owned()],
            left_out: Vec::new(),
            has_reasons: true,
        };
        let mut count = 0;
        number(&mut diagram.nodes, &mut count);
        check_diagram(&diagram, count);
    }
}

#[test]
fn deepest_tree_is_drawn() {
    let mut nodes = vec![DiagramNode::Remark {
        text: "here".to_owned(),
    }];
    for _ in 0..plan::tree::DEEPEST {
        nodes = vec![DiagramNode::Branch {
            condition: "the milk is good".to_owned(),
            otherwise: "the milk is not good".to_owned(),
            sensing: Vec::new(),
            then: Vec::new(),
            other: nodes,
        }];
    }
    let diagram = Diagram {
        nodes,
        assumptions: Vec::new(),
        left_out: Vec::new(),
        has_reasons: true,
    };
    check_diagram(&diagram, 0);
}
