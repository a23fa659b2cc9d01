use proptest::prelude::*;
use proptest::strategy::ValueTree;

use super::{Guards, WriteError, write};
use crate::plan::{Node, Plan, Test, Unreadable, read, resolve};
use crate::tree_peer::{End, Peer, Trouble};
use crate::verify::tests::bench::{Guard, Part, does, domain, not, plan, world};
use crate::verify::tests::enumerated::{lane, parts};
use crate::verify::{Purpose, VerifiedPlan, bind_tree, check};
use longstep_model::model::World;

/// Joins conjunctions of conjunctions, and disjunctions of disjunctions: a tree does not tell them apart.
fn flat(test: &Test) -> Test {
    let parts = |parts: &[Test], inner: fn(&Test) -> Option<&[Test]>| {
        let flat: Vec<Test> = parts.iter().map(flat).collect();
        flat.iter()
            .flat_map(|part| inner(part).map_or_else(|| vec![part.clone()], <[Test]>::to_vec))
            .collect()
    };
    match test {
        Test::All(parts) | Test::Any(parts) if parts.len() == 1 => flat(&parts[0]),
        Test::Not(inner) => Test::Not(Box::new(flat(inner))),
        Test::All(all) => Test::All(parts(all, |test| match test {
            Test::All(inner) if !inner.is_empty() => Some(inner),
            _ => None,
        })),
        Test::Any(any) => Test::Any(parts(any, |test| match test {
            Test::Any(inner) if !inner.is_empty() => Some(inner),
            _ => None,
        })),
        other => other.clone(),
    }
}

fn flat_nodes(nodes: &[Node]) -> Vec<Node> {
    let node = |node: &Node| match node {
        Node::If {
            condition,
            then,
            otherwise,
        } => Node::If {
            condition: flat(condition),
            then: flat_nodes(then),
            otherwise: flat_nodes(otherwise),
        },
        Node::While { condition, body } => Node::While {
            condition: flat(condition),
            body: flat_nodes(body),
        },
        Node::Repeat { times, body } => Node::Repeat {
            times: *times,
            body: flat_nodes(body),
        },
        other => other.clone(),
    };
    nodes.iter().map(node).collect()
}

/// Reads a tree as a plan of the world.
fn read_back(world: &World, xml: &str) -> Plan {
    let draft = read(xml).unwrap_or_else(|error| panic!("{error}\n{xml}"));
    let resolved = resolve(world, &draft.file.task_cohesion);
    assert!(resolved.issues.is_empty(), "{:?}\n{xml}", resolved.issues);
    bind_tree(world, &resolved, None)
        .unwrap_or_else(|issues| panic!("{issues:?}\n{xml}"))
        .0
}

fn comes_back(world: &World, plan: &Plan) -> Result<(), TestCaseError> {
    for guards in [Guards::None, Guards::Preconditions] {
        let xml = write(world, plan, guards).unwrap();
        let again = read_back(world, &xml);
        prop_assert_eq!(again.steps(), plan.steps(), "{}", xml);
        prop_assert_eq!(flat_nodes(again.body()), flat_nodes(plan.body()), "{}", xml);
        prop_assert_eq!(write(world, &again, guards).unwrap(), xml);
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 1_000, ..ProptestConfig::default() })]

    #[test]
    fn a_plan_comes_back_from_its_tree(parts in parts(), lit in prop::collection::vec(1..=2usize, 0..=2)) {
        let domain = domain();
        let world = world(&domain, 2, &lit);
        comes_back(&world, &plan(&world, &parts))?;
    }

    #[test]
    fn lanes_come_back_from_their_tree(left in lane("left"), right in lane("right")) {
        let domain = domain();
        let world = world(&domain, 4, &[]);
        comes_back(&world, &plan(&world, &[Part::Lanes(vec![("left", left), ("right", right)])]))?;
    }

    #[test]
    fn no_tree_panics(pieces in prop::collection::vec(prop::sample::select(vec![
        "<root BTCPP_format=\"4\">", "</root>", "<BehaviorTree ID=\"Main\">", "</BehaviorTree>", "<Sequence>", "</Sequence>",
        "<IfThenElse>", "</IfThenElse>", "<press hand=\"left\" lamp=\"&lt;lamp_1&gt;\"/>", "<feel lamp=\"&lt;lamp_1&gt;\" outcome=\"{a}\"/>",
        "<ScriptCondition code=\"a=='warm'\"/>", "<Script code=\"b:=(a=='warm')\"/>", "<Script code=\"b:=!b\"/>",
        "<ScriptCondition code=\"b\"/>", "<AlwaysSuccess/>", "<Parallel>", "</Parallel>", "<SubTree ID=\"Main\"/>", "<!-- x -->",
        "<Repeat num_cycles=\"3\">", "</Repeat>", "<ForceSuccess>", "</ForceSuccess>", "<KeepRunningUntilFailure>",
        "</KeepRunningUntilFailure>", "&amp;", "&", "<!DOCTYPE x>", "<lit lamp=\"x\"/>", "<Inverter>", "</Inverter>",
    ]), 0..25)) {
        let text = pieces.concat();
        let _ = read(&text);
        let _ = read(&format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">{text}</BehaviorTree></root>"));
    }
}

#[test]
fn tree_has_the_form_that_the_format_demands() {
    let domain = domain();
    let world = world(&domain, 2, &[]);
    let parts = [
        does("press left 1"),
        Part::If(Guard::Feel(1), vec![does("cool 1")], vec![]),
        Part::While(not(Guard::Is("lit", 2)), vec![does("press right 2")]),
        Part::If(
            Guard::All(vec![Guard::Feel(2), Guard::Is("lit", 2)]),
            vec![does("wait 2")],
            vec![does("wait 1")],
        ),
        Part::Lanes(vec![
            (
                "left",
                vec![
                    "unpress left 1".to_owned(),
                    "sync a".to_owned(),
                    "press left 1".to_owned(),
                ],
            ),
            ("right", vec!["sync a".to_owned(), "unpress right 2".to_owned()]),
        ]),
    ];
    let xml = write(&world, &plan(&world, &parts), Guards::None).unwrap();
    let expected = include_str!("expected.xml");
    assert!(xml == expected, "{xml}");
}

#[test]
fn what_people_write_is_read() {
    let domain = domain();
    let world = world(&domain, 2, &[]);
    let cases: [(&str, Vec<Part>); 5] = [
        (
            // Leaves with all ports, in a subtree with a port, checks before a step.
            "<BehaviorTree ID='Light'><Sequence><Inverter><Condition ID='lit' lamp='{which}'/></Inverter>
             <Action ID='press' hand='left' lamp='{which}'/></Sequence></BehaviorTree>
             <BehaviorTree ID='Main'><Sequence><SubTree ID='Light' which='&lt;lamp_1&gt;'/><SubTree ID='Light' which='lamp 2'/>
             </Sequence></BehaviorTree>",
            vec![does("press left 1"), does("press left 2")],
        ),
        (
            // A sensing action as a condition.
            "<BehaviorTree ID='Main'><IfThenElse><feel lamp='lamp_1'/><cool lamp='lamp_1'/></IfThenElse></BehaviorTree>",
            vec![Part::If(Guard::Feel(1), vec![does("cool 1")], vec![])],
        ),
        (
            // The other outcome.
            "<BehaviorTree ID='Main'><Sequence><feel lamp='lamp_1' outcome='{o}'/><IfThenElse>
             <ScriptCondition code=\" o == 'cold' \"/><wait lamp='lamp_1'/><cool lamp='lamp_1'/></IfThenElse></Sequence></BehaviorTree>",
            vec![Part::If(not(Guard::Feel(1)), vec![does("wait 1")], vec![does("cool 1")])],
        ),
        (
            // The outcome is not asked.
            "<BehaviorTree ID='Main'><SequenceWithMemory><feel lamp='lamp_1' outcome='{o}'/><Repeat num_cycles='2'>
             <wait lamp='lamp_1'/></Repeat></SequenceWithMemory></BehaviorTree>",
            vec![does("feel 1"), Part::Repeat(2, vec![does("wait 1")])],
        ),
        (
            "<BehaviorTree ID='Only'><Parallel><Sequence _actor='left'><press hand='left' lamp='lamp_1'/></Sequence>
             <Sequence _actor='right'><press hand='right' lamp='lamp_2'/></Sequence></Parallel></BehaviorTree>",
            vec![Part::Lanes(vec![
                ("left", vec!["press left 1".to_owned()]),
                ("right", vec!["press right 2".to_owned()]),
            ])],
        ),
    ];
    for (tree, parts) in cases {
        let reply = format!("Here it is:\n```xml\n<root BTCPP_format=\"4\">{tree}</root>\n```\nTick it.");
        let bare = |plan: &Plan| {
            plan.steps()
                .iter()
                .map(|step| (step.action, step.arguments.clone()))
                .collect::<Vec<_>>()
        };
        let (found, expected) = (read_back(&world, &reply), plan(&world, &parts));
        assert_eq!(
            (bare(&found), found.body()),
            (bare(&expected), expected.body()),
            "{tree}"
        );
    }
}

#[test]
fn what_no_plan_has_is_refused_with_its_place() {
    let cases = [
        (
            "<Fallback><press/></Fallback>",
            "line 2, column 1: no plan has the node `Fallback` here",
        ),
        (
            "<Sequence>\n<Sleep msec='5'/></Sequence>",
            "line 3, column 1: no plan has the node `Sleep` here",
        ),
        ("<press lamp='{x}'/>", "`{x}` is an entry of the blackboard"),
        ("<press _skipIf='x'/>", "no plan has the attribute `_skipIf`"),
        ("<Script code='x:=1'/>", "no plan has this script"),
        (
            "<IfThenElse><lit/></IfThenElse>",
            "IfThenElse has two or three children",
        ),
        ("<SubTree ID='None'/>", "there is no tree `None`"),
        ("<SubTree ID='Main'/>", "the tree `Main` is part of itself"),
        (
            "<Parallel success_count='1'><Sequence _actor='left'/></Parallel>",
            "lanes must all succeed",
        ),
        ("<Parallel><Sequence/></Parallel>", "a lane does not say whose it is"),
        ("<press><wait/></press>", "the leaf `press` has children"),
        ("<Repeat num_cycles='{n}'><wait/></Repeat>", "`num_cycles` is no number"),
        (
            "<Sequence><feel outcome='{o}'/><wait/><IfThenElse><ScriptCondition code=\"o=='warm'\"/><wait/></IfThenElse></Sequence>",
            "`o` is not the outcome of the step just before",
        ),
        ("<press", "this is no XML"),
    ];
    for (tree, expected) in cases {
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">\n{tree}</BehaviorTree></root>");
        let error = read(&text).unwrap_err();
        let Unreadable::BehaviorTree { hint, .. } = &error else {
            panic!("{error}")
        };
        assert!(error.to_string().contains(expected) && !hint.is_empty(), "{error}");
    }
    let older = "<root><BehaviorTree ID=\"Main\"/></root>".replace("<root", "<root BTCPP_format=\"3\"");
    assert!(read(&older).unwrap_err().to_string().contains("version `3`"));
}

#[test]
fn nesting_has_a_bound() {
    for depth in [200, 100_000] {
        let tree = format!("{}<wait/>{}", "<Sequence>".repeat(depth), "</Sequence>".repeat(depth));
        let text = format!("<root BTCPP_format=\"4\"><BehaviorTree ID=\"Main\">{tree}</BehaviorTree></root>");
        assert_eq!(read(&text).is_ok(), depth == 200);
    }
    // Each tree has the next one twice.
    let trees = (0..40).map(|number| {
        let next = format!("<SubTree ID=\"T{}\"/>", number + 1);
        format!("<BehaviorTree ID=\"T{number}\"><Sequence>{next}{next}</Sequence></BehaviorTree>")
    });
    let trees: String = trees.collect();
    let last = "<BehaviorTree ID=\"T40\"><wait/></BehaviorTree>";
    let text = format!("<root BTCPP_format=\"4\" main_tree_to_execute=\"T0\">{trees}{last}</root>");
    assert!(read(&text).unwrap_err().to_string().contains("more than 100000 nodes"));
}

#[test]
fn a_name_that_looks_like_the_blackboard_is_refused() {
    let domain = domain();
    let text = r#"{"assets": ["<table_1>"], "objects": ["{lamp}"], "object_states": {}}"#;
    let Ok(world) = longstep_model::environment::parse(&domain, "env.json", text) else {
        return;
    };
    let lamp = world.find("{lamp}").unwrap();
    let (id, _) = domain.action_ids().find(|(_, action)| action.call == "wait").unwrap();
    let step = crate::plan::Step::explained(&world, id, vec![lamp]);
    let plan = check(&world, Plan::sequence(vec![step]), &Purpose::default()).plan;
    assert_eq!(
        write(&world, &plan, Guards::None),
        Err(WriteError::Argument("{lamp}".to_owned()))
    );
}

/// Joiners and marks of direction are parts of names in some scripts, and of emoji.
#[test]
fn names_with_hidden_characters_come_back() {
    let domain = domain();
    for name in [
        "<\u{6a9}\u{62a}\u{627}\u{628}\u{200c}\u{647}\u{627}>",
        "<\u{1f469}\u{200d}\u{1f680}>",
        "<a\u{200f}b>",
    ] {
        let text = format!(r#"{{"assets": ["<table_1>"], "objects": ["{name}"], "object_states": {{}}}}"#);
        let world = longstep_model::environment::parse(&domain, "env.json", &text).unwrap();
        let (id, _) = domain.action_ids().find(|(_, action)| action.call == "wait").unwrap();
        let step = crate::plan::Step::explained(&world, id, vec![world.find(name).unwrap()]);
        let plan = check(&world, Plan::sequence(vec![step]), &Purpose::default()).plan;
        let xml = write(&world, &plan, Guards::None).unwrap();
        assert!(!xml.contains(['\u{200c}', '\u{200d}', '\u{200f}']), "{xml}");
        let document = roxmltree::Document::parse(&xml).unwrap();
        let values: Vec<&str> = document
            .descendants()
            .flat_map(|node| node.attributes())
            .map(|own| own.value())
            .collect();
        assert!(values.contains(&name), "{xml}");
    }
}

/// The program of `tools/peers/behavior_trees/build.sh`.
fn peer(folder: &tempfile::TempDir) -> Peer {
    let program = std::env::var("LONGSTEP_BEHAVIOR_TREES").expect("LONGSTEP_BEHAVIOR_TREES names the runner");
    Peer::start(program.as_ref(), folder.path()).unwrap()
}

/// Numbers below a bound from a seed.
fn choices(seed: u64) -> impl FnMut(usize) -> usize {
    let mut state = seed | 1;
    move |bound| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        usize::try_from(state % bound as u64).unwrap()
    }
}

/// Returns verified plans that were drawn, half of them with lanes.
fn drawn(count: usize) -> Vec<VerifiedPlan> {
    let mut runner = proptest::test_runner::TestRunner::deterministic();
    let domain = domain();
    let mut plans = Vec::new();
    while plans.len() < count {
        let draw = |runner: &mut proptest::test_runner::TestRunner| {
            if plans.len() % 2 == 0 {
                return parts().new_tree(runner).unwrap().current();
            }
            let lanes = [lane("left"), lane("right")].map(|lane| lane.new_tree(runner).unwrap().current());
            let [left, right] = lanes;
            vec![Part::Lanes(vec![("left", left), ("right", right)])]
        };
        let parts = draw(&mut runner);
        let lit = prop::collection::vec(1..=2usize, 0..=2)
            .new_tree(&mut runner)
            .unwrap()
            .current();
        let world = world(&domain, 4, &lit);
        let plan = plan(&world, &parts);
        let has_steps = plan.steps().len() > 2;
        plans.extend(
            check(&world, plan, &Purpose::default())
                .into_verified()
                .ok()
                .filter(|_| has_steps),
        );
    }
    plans
}

#[test]
#[ignore = "needs LONGSTEP_BEHAVIOR_TREES, which tools/peers/behavior_trees/build.sh prints"]
fn behavior_tree_cpp_ticks_the_steps_of_the_plan() {
    let folder = tempfile::tempdir().unwrap();
    let mut peer = peer(&folder);
    let (mut done, mut failed, mut halted, mut endless) = (0, 0, 0, 0);
    let mut count = |end: End| match end {
        End::Done => done += 1,
        End::Failed => failed += 1,
        End::Halted => halted += 1,
        End::Endless => endless += 1,
    };
    for (number, plan) in drawn(500).iter().enumerate() {
        let mut choose = choices(number as u64 + 1);
        let bare = write(plan.world(), plan.plan(), Guards::None).unwrap();
        let guarded = write(plan.world(), plan.plan(), Guards::Preconditions).unwrap();
        let mut tick = |xml: &str, trouble| {
            let end = peer.tick(plan, xml, trouble, &mut choose);
            count(end.unwrap_or_else(|error| panic!("plan {number}, {trouble:?}: {error}\n{xml}")));
        };
        for _ in 0..4 {
            tick(&bare, Trouble::None);
            tick(&guarded, Trouble::None);
        }
        for at in 0..4 {
            tick(&bare, Trouble::Failure(at));
            tick(&bare, Trouble::Halt(at));
            tick(&guarded, Trouble::Failure(at));
            tick(&guarded, Trouble::Change(at + 1));
        }
    }
    println!("{done} runs succeeded, {failed} failed where they had to, {halted} were halted, {endless} were too long");
    assert!(done > 3_000 && failed > 2_000 && halted > 1_000);
}

#[test]
#[ignore = "needs LONGSTEP_BEHAVIOR_TREES, which tools/peers/behavior_trees/build.sh prints"]
fn behavior_tree_cpp_refuses_a_misspelt_port() {
    let folder = tempfile::tempdir().unwrap();
    let domain = domain();
    let world = world(&domain, 2, &[]);
    let xml = write(&world, &plan(&world, &[does("press left 1")]), Guards::None).unwrap();
    let misspelt = xml.replacen(" lamp=", " lampp=", 1);
    let refusal = peer(&folder).refusal(&misspelt).unwrap();
    assert!(refusal.contains("lampp"), "{refusal}");
}
