//! Relations and findings of scenes; how files are read, and random scenes, have files of their own.

mod random;
mod reading;

use super::*;
use crate::domain::{self, Domain};
use crate::model::SpatialRelation;
use crate::testing;

fn household() -> Domain {
    testing::domain("household")
}

fn look_at(text: &str) -> Look {
    look(&household(), &Scene::parse("boxes.json", text).unwrap()).unwrap()
}

fn body(name: &str, position: [f64; 3], size: [f64; 3]) -> Body {
    Body {
        position,
        size,
        ..Body::named(name.to_owned())
    }
}

fn statements(look: &Look, name: &str) -> Vec<String> {
    let own = look.reasons.iter().filter(|reason| reason.subject == name);
    own.map(|reason| reason.statement.clone()).collect()
}

const TABLE: &str = r#"{"name": "<table>", "position": [0, 0, 0.4], "size": [1.2, 0.8, 0.8]}"#;

#[test]
fn relations_follow_from_poses() {
    for (boxes, hands, subject, expected) in [
        // 2 mm above, 2 mm in, and 30 mm above the top.
        (
            r#"{"name": "<cup>", "position": [0, 0, 0.852], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "on_something(<table>)",
        ),
        (
            r#"{"name": "<cup>", "position": [0, 0, 0.848], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "on_something(<table>)",
        ),
        (
            r#"{"name": "<cup>", "position": [0, 0, 0.88], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "",
        ),
        // Half over the edge, and nearly all of it.
        (
            r#"{"name": "<cup>", "position": [0.6, 0, 0.85], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "on_something(<table>)",
        ),
        (
            r#"{"name": "<cup>", "position": [0.64, 0, 0.85], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "",
        ),
        // Lying: turned by 90 degrees about x, so that its length of 0.3 m is along y.
        (
            r#"{"name": "<can>", "position": [0, 0, 0.85], "size": [0.1, 0.1, 0.3], "orientation": {"w": 0.7071, "x": 0.7071, "y": 0, "z": 0}}"#,
            "",
            "<can>",
            "on_something(<table>)",
        ),
        // On a sheet that is thinner than the tolerance.
        (
            r#"{"name": "<mat>", "position": [0, 0, 0.805], "size": [0.3, 0.3, 0.01]},
            {"name": "<cup>", "position": [0, 0, 0.86], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "on_something(<mat>)",
        ),
        (
            r#"{"name": "<mat>", "position": [0, 0, 0.805], "size": [0.3, 0.3, 0.01]},
            {"name": "<cup>", "position": [0, 0, 0.86], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<mat>",
            "on_something(<table>)",
        ),
        // In a basket on the table, and half of it above the rim.
        (
            r#"{"name": "<basket>", "position": [0, 0, 0.9], "size": [0.3, 0.3, 0.2]},
            {"name": "<cup>", "position": [0, 0, 0.86], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "inside_something(<basket>)",
        ),
        (
            r#"{"name": "<basket>", "position": [0, 0, 0.9], "size": [0.3, 0.3, 0.2]},
            {"name": "<loaf>", "position": [0, 0, 0.99], "size": [0.1, 0.1, 0.3]}"#,
            "",
            "<loaf>",
            "inside_something(<basket>)",
        ),
        // On a board in a cupboard: the board counts.
        (
            r#"{"name": "<cupboard>", "position": [2, 0, 0.5], "size": [1, 1, 1]},
            {"name": "<board>", "position": [2, 0, 0.5], "size": [0.9, 0.9, 0.02]},
            {"name": "<cup>", "position": [2, 0, 0.56], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "on_something(<board>)",
        ),
        (
            r#"{"name": "<cupboard>", "position": [2, 0, 0.5], "size": [1, 1, 1], "solid": true},
            {"name": "<cup>", "position": [2, 0, 0.56], "size": [0.1, 0.1, 0.1]}"#,
            "",
            "<cup>",
            "",
        ),
        // In a hand that is closed, and beside one that is open.
        (
            r#"{"name": "<cup>", "position": [0, 0, 1.2], "size": [0.1, 0.1, 0.1]}"#,
            r#"{"name": "right", "position": [0, 0.06, 1.2], "closed": true}"#,
            "<cup>",
            "inside_hand()",
        ),
        (
            r#"{"name": "<cup>", "position": [0, 0, 1.2], "size": [0.1, 0.1, 0.1]}"#,
            r#"{"name": "right", "position": [0, 0.06, 1.2], "closed": false}"#,
            "<cup>",
            "",
        ),
        // On the side of a pane.
        (
            r#"{"name": "<window>", "position": [0, 2, 1], "size": [1, 0.02, 2], "kind": "asset"},
            {"name": "<sponge>", "position": [0, 1.96, 1.2], "size": [0.1, 0.05, 0.1]}"#,
            "",
            "<sponge>",
            "on_something(<window>)",
        ),
        // Joints, and what a detector says.
        (
            r#"{"name": "<knob>", "position": [0, 0.42, 0.5], "size": [0.02, 0.02, 0.02], "part_of": "<table>",
             "joint": {"position": 0.3}}"#,
            "",
            "<knob>",
            "open()",
        ),
        (
            r#"{"name": "<knob>", "position": [0, 0.42, 0.5], "size": [0.02, 0.02, 0.02], "part_of": "<table>",
             "joint": {"position": 1.58, "closed": 1.57}}"#,
            "",
            "<knob>",
            "closed()",
        ),
        (
            r#"{"name": "<knob>", "position": [0, 0.42, 0.5], "size": [0.02, 0.02, 0.02], "part_of": "<table>",
             "open": false}"#,
            "",
            "<knob>",
            "closed()",
        ),
        // Neighbours.
        (
            r#"{"name": "<stool>", "position": [0.83, 0, 0.2], "size": [0.4, 0.4, 0.4]}"#,
            "",
            "<stool>",
            "next_to(<table>)",
        ),
        (
            r#"{"name": "<stool>", "position": [0.88, 0, 0.2], "size": [0.4, 0.4, 0.4]}"#,
            "",
            "<stool>",
            "",
        ),
    ] {
        let scene = format!(r#"{{"boxes": [{TABLE}, {boxes}], "hands": [{hands}]}}"#);
        let look = look_at(&scene);
        let expected: Vec<&str> = expected.split_terminator(' ').collect();
        assert_eq!(statements(&look, subject), expected, "{scene}");
    }
}

#[test]
fn look_gives_measured_reasons_for_each_statement() {
    let look = look_at(&format!(
        r#"{{"boxes": [{TABLE},
            {{"name": "<basket>", "position": [0, 0, 0.9], "size": [0.3, 0.3, 0.2]}},
            {{"name": "<loaf>", "position": [0, 0, 0.99], "size": [0.1, 0.1, 0.3]}}]}}"#
    ));
    let texts: Vec<&str> = look.reasons.iter().map(|reason| reason.text.as_str()).collect();
    assert_eq!(
        texts,
        [
            "<basket> is on <table>: its lowest point is 0 mm above the top of <table>, and 100 % of it is over <table>",
            "<loaf> is in <basket>: 50 % of its volume is in <basket>",
        ]
    );
    let assumed: Vec<&str> = look.assumed.iter().map(|own| own.text.as_str()).collect();
    assert_eq!(assumed[0], "<table> is an asset: it is on nothing and in nothing");
    assert_eq!(look.environment.objects, ["<basket>", "<loaf>"]);
}

#[test]
fn look_reports_boxes_that_fit_no_world() {
    use SceneFindingKind::{Cut, Floating, TwoContainers, TwoSupports};
    for (boxes, expected) in [
        (
            r#"{"name": "<cup>", "position": [0, 0, 1.05], "size": [0.1, 0.1, 0.1]}"#,
            vec![(
                Floating,
                "<cup> is on nothing: it is 1000 mm above the lowest point of the scene, and no box is within 20 mm of it",
            )],
        ),
        (
            r#"{"name": "<bottle>", "position": [0, 0, 0.9], "size": [0.1, 0.1, 0.3]}"#,
            vec![
                (
                    Cut,
                    "<table> and <bottle> are in each other: 50 mm deep, 12 % of the volume of one of them",
                ),
                (
                    Floating,
                    "<bottle> is on nothing: it is 750 mm above the lowest point of the scene, and no box is within 20 mm of it",
                ),
            ],
        ),
        (
            r#"{"name": "<desk>", "position": [1.25, 0, 0.4], "size": [1.2, 0.8, 0.8]},
            {"name": "<plank>", "position": [0.62, 0, 0.81], "size": [0.6, 0.2, 0.02]}"#,
            vec![(
                TwoSupports,
                "<plank> rests on <table> and on <desk>: 47 % and 45 % of it; <table> is assumed",
            )],
        ),
        (
            r#"{"name": "<net>", "position": [3, 0, 0.5], "size": [1, 1, 1]},
            {"name": "<sack>", "position": [3.6, 0, 0.55], "size": [1, 1, 1.1]},
            {"name": "<ball>", "position": [3.3, 0, 0.5], "size": [0.1, 0.1, 0.1]}"#,
            vec![
                (
                    TwoContainers,
                    "<ball> is in <net> and in <sack>: 100 % and 100 % of its volume; <net> is assumed",
                ),
                (
                    Cut,
                    "<net> and <sack> are in each other: 400 mm deep, 38 % of the volume of one of them",
                ),
            ],
        ),
    ] {
        let look = look_at(&format!(r#"{{"boxes": [{TABLE}, {boxes}]}}"#));
        let found: Vec<(SceneFindingKind, &str)> =
            look.findings.iter().map(|own| (own.kind, own.text.as_str())).collect();
        assert_eq!(found, expected, "{boxes}");
    }
}

#[test]
fn look_lists_spatial_relations_without_a_predicate() {
    let virtualhome = testing::domain("virtualhome");
    let text = format!(
        r#"{{"boxes": [{TABLE}, {{"name": "<stool>", "position": [0.83, 0, 0.2], "size": [0.4, 0.4, 0.4]}}]}}"#
    );
    let found = look(&virtualhome, &Scene::parse("boxes.json", &text).unwrap()).unwrap();
    assert_eq!(found.wordless, [SpatialRelation::NextTo]);
    let pddl = "(define (domain bare) (:predicates (lit ?lamp)) \
        (:action light :parameters (?lamp) :precondition (not (lit ?lamp)) :effect (lit ?lamp)))";
    let bare = domain::from_pddl("domain.pddl", pddl).unwrap();
    let error = look(&bare, &Scene::default()).unwrap_err();
    assert!(matches!(error, LookError::NoGeometry(_)), "{error}");
}

#[test]
fn look_terminates_on_circular_part_relations() {
    let part = |name: &str, whole: &str| Body {
        part_of: Some(whole.to_owned()),
        ..body(name, [0.0, 0.0, 0.5], [1.0, 1.0, 1.0])
    };
    let scene = Scene {
        boxes: vec![part("a", "b"), part("b", "c"), part("c", "b")],
        ..Scene::default()
    };
    look(&household(), &scene).unwrap();
}

#[test]
fn a_thousand_boxes_in_one_place_end_within_the_budget() {
    let boxes = (0..1_000).map(|index| {
        body(
            &format!("b{index}"),
            [0.0, 0.0, 0.0],
            [1.0 + f64::from(index), 1.0, 1.0],
        )
    });
    let scene = Scene {
        boxes: boxes.collect(),
        ..Scene::default()
    };
    assert_eq!(look(&household(), &scene), Err(LookError::TooMuchWork));
}
