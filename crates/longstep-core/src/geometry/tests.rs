use std::collections::BTreeMap;

use proptest::prelude::*;

use super::*;
use crate::domain::{self, Domain};
use crate::environment::{self, Environment, World};
use crate::model::{SpatialRelation, written_fact};

fn household() -> Domain {
    domain::shipped("household").unwrap().unwrap()
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
fn every_statement_has_a_reason_with_its_measures() {
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
fn boxes_that_fit_no_world_are_findings() {
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
fn what_a_domain_has_no_word_for_is_listed() {
    let virtualhome = domain::shipped("virtualhome").unwrap().unwrap();
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
fn impossible_scenes_are_errors_with_their_place() {
    let many = vec![r#"{"name": "a", "position": [0, 0, 0], "size": [1, 1, 1]}"#; 1_001].join(",");
    let cup = |rest: &str| format!(r#"{{"boxes": [{{"name": "<cup>", {rest}}}]}}"#);
    for (text, expected) in [
        (String::new(), "boxes.json:1:1: EOF while parsing a value"),
        (
            "[1]".to_owned(),
            "boxes.json:1:2: invalid type: integer `1`, expected struct Body",
        ),
        (
            r#"{"boxes": [{"name": "<cup>"}]}"#.to_owned(),
            "missing field `position`",
        ),
        (cup(r#""position": [0, 0], "size": [1, 1, 1]"#), "invalid length 2"),
        (
            cup(r#""position": [0, 0, 1e999], "size": [1, 1, 1]"#),
            "number out of range",
        ),
        (
            cup(r#""position": [0, 0, 1e300], "size": [1, 1, 1]"#),
            "boxes.json:1:42: boxes[0].position: a coordinate is at most 100000 m",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 0, 1]"#),
            "boxes[0].size: an edge is 0.000001 to 100000 m long",
        ),
        (cup(r#""position": [0, 0, 0], "size": [1, -1, 1]"#), "boxes[0].size"),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "orientation": [0, 0, 0, 0]"#),
            "a quaternion of length 1",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "orientation": [0, 0, 0, 1]"#),
            "boxes[0].orientation: a list does not say which number is w",
        ),
        (
            cup(r#""position": {"x": 0, "y": 0}, "size": [1, 1, 1]"#),
            "missing field `z`",
        ),
        (
            r#"[{"name": "cup", "box": {"x1": 210.0, "y1": 150.3, "x2": 260.4, "y2": 230.9}}]"#.to_owned(),
            "boxes of a picture, in pixels, have no pose",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "part_of": "<cup>""#),
            "there is no other box `<cup>`",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "open": true, "joint": {"position": 0}"#),
            "give `open` or `joint`, not both",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "colour": "red""#),
            "unknown field `colour`",
        ),
        (
            cup(r#""position": [0, 0, 0], "size": [1, 1, 1], "kind": "thing""#),
            "unknown variant `thing`",
        ),
        (
            format!(r#"{{"boxes": [{many}]}}"#),
            "boxes: more than 1000 boxes and hands",
        ),
        (
            format!(r#"{{"boxes": [{TABLE}, {TABLE}]}}"#),
            "boxes[1].name: `<table>` is listed twice",
        ),
        (
            r#"{"boxes": [], "tolerances": {"contact": 0}}"#.to_owned(),
            "tolerances.contact: a tolerance is above 0 and at most 1",
        ),
        ("[".repeat(100_000), "boxes.json:1:2: invalid type"),
    ] {
        let error = Scene::parse("boxes.json", &text).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\n{expected}");
    }
}

#[test]
fn a_circle_of_parts_ends() {
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

/// A small generator of numbers, so that a scene follows from its seed.
struct Dice(u64);

impl Dice {
    fn below(&mut self, sides: u64) -> u64 {
        self.0 = self
            .0
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) % sides
    }

    fn share(&mut self) -> f64 {
        self.below(10_001) as f64 / 10_000.0
    }
}

/// A random environment, and the boxes that a detector would see in it.
struct Made {
    environment: Environment,
    scene: Scene,
    states: BTreeMap<String, Vec<String>>,
}

impl Made {
    fn add(&mut self, kind: Kind, body: Body, statements: &[String]) -> usize {
        match kind {
            Kind::Asset => &mut self.environment.assets,
            Kind::Object => &mut self.environment.objects,
        }
        .push(body.name.clone());
        self.states
            .entry(body.name.clone())
            .or_default()
            .extend_from_slice(statements);
        self.scene.boxes.push(Body {
            kind: Some(kind),
            ..body
        });
        self.scene.boxes.len() - 1
    }

    /// Puts an item at a height: alone, under another one, as a tray with something on it, or as a basket with something
    /// in it. Returns the name.
    fn item(&mut self, dice: &mut Dice, middle: [f64; 2], height: f64, place: String) -> String {
        let number = self.scene.boxes.len();
        let edge = 0.06 + 0.06 * dice.share();
        let tall = 0.06 + 0.1 * dice.share();
        let at = |low: f64, tall: f64| [middle[0], middle[1], low + tall / 2.0];
        let (name, top) = (format!("<item_{number}>"), format!("<item_{}>", number + 1));
        match dice.below(4) {
            0 => {
                self.add(
                    Kind::Object,
                    body(&name, at(height, tall), [edge, edge, tall]),
                    &[place],
                );
            }
            1 => {
                self.add(
                    Kind::Object,
                    body(&name, at(height, tall), [edge, edge, tall]),
                    &[place],
                );
                let small = [edge * 0.8, edge * 0.8, 0.08];
                let on = format!("on_something({name})");
                self.add(Kind::Object, body(&top, at(height + tall, 0.08), small), &[on]);
            }
            2 => {
                self.add(
                    Kind::Object,
                    body(&name, at(height, 0.015), [0.14, 0.14, 0.015]),
                    &[place],
                );
                let on = format!("on_something({name})");
                self.add(
                    Kind::Object,
                    body(&top, at(height + 0.015, tall), [edge, edge, tall]),
                    &[on],
                );
            }
            _ => {
                self.add(
                    Kind::Object,
                    body(&name, at(height, 0.12), [0.14, 0.14, 0.12]),
                    &[place],
                );
                let within = format!("inside_something({name})");
                let tall = tall.min(0.15);
                self.add(
                    Kind::Object,
                    body(&top, at(height + 0.012, tall), [0.07, 0.07, tall]),
                    &[within],
                );
            }
        }
        name
    }

    /// Puts two neighbours of one size on a place.
    fn pair(&mut self, middle: [f64; 2], height: f64, place: &str) {
        let number = self.scene.boxes.len();
        let (one, other) = (format!("<item_{number}>"), format!("<item_{}>", number + 1));
        for (name, neighbour, side) in [(&one, &other, -1.0), (&other, &one, 1.0)] {
            let position = [middle[0] + side * 0.035, middle[1], height + 0.05];
            let next = format!("next_to({neighbour})");
            self.add(
                Kind::Object,
                body(name, position, [0.05, 0.05, 0.1]),
                &[place.to_owned(), next],
            );
        }
    }

    fn on_a_table(&mut self, dice: &mut Dice, x: f64, name: &str) {
        self.add(Kind::Asset, body(name, [x, 0.0, 0.4], [1.0, 0.8, 0.8]), &[]);
        for slot in 0..4 {
            let middle = [x - 0.36 + 0.24 * f64::from(slot), 0.2 * dice.share() - 0.1];
            match dice.below(3) {
                0 => {}
                1 => {
                    self.item(dice, middle, 0.8, format!("on_something({name})"));
                }
                _ => self.pair(middle, 0.8, &format!("on_something({name})")),
            }
        }
    }

    fn in_a_fridge(&mut self, dice: &mut Dice, x: f64, name: &str) {
        self.add(Kind::Asset, body(name, [x, 0.0, 0.8], [1.0, 0.8, 1.6]), &[]);
        let handle = format!("{}_handle>", name.trim_end_matches('>'));
        let is_open = dice.below(2) == 0;
        let word = if is_open { "open()" } else { "closed()" };
        let mut part = body(&handle, [x - 0.45, -0.42, 1.0], [0.02, 0.04, 0.3]);
        part.part_of = Some(name.to_owned());
        match dice.below(2) {
            0 => part.open = Some(is_open),
            _ => {
                let position = if is_open { 0.4 + dice.share() } else { 0.01 };
                part.joint = Some(Joint { position, closed: 0.0 });
            }
        }
        self.add(Kind::Object, part, &[word.to_owned()]);
        let mut place = format!("inside_something({name})");
        let mut height = 0.05;
        if dice.below(2) == 0 {
            let board = format!("{}_board>", name.trim_end_matches('>'));
            self.add(Kind::Asset, body(&board, [x, 0.0, 0.7], [0.9, 0.7, 0.03]), &[place]);
            place = format!("on_something({board})");
            height = 0.715;
        }
        for slot in 0..3 {
            if dice.below(2) == 0 {
                let middle = [x - 0.25 + 0.25 * f64::from(slot), 0.0];
                self.item(dice, middle, height, place.clone());
            }
        }
    }

    fn at_a_window(&mut self, dice: &mut Dice, x: f64, name: &str) {
        self.add(Kind::Asset, body(name, [x, 0.39, 1.0], [1.0, 0.02, 2.0]), &[]);
        if dice.below(2) == 0 {
            let sponge = format!("<item_{}>", self.scene.boxes.len());
            let on = format!("on_something({name})");
            self.add(Kind::Object, body(&sponge, [x, 0.35, 1.2], [0.1, 0.06, 0.1]), &[on]);
        }
    }

    fn new(seed: u64) -> Self {
        let mut dice = Dice(seed);
        let mut made = Self {
            environment: Environment::default(),
            scene: Scene::default(),
            states: BTreeMap::new(),
        };
        let mut x = 0.0;
        let mut last: Option<(String, bool)> = None;
        for number in 0..1 + dice.below(4) {
            let name = format!("<place_{number}>");
            match dice.below(5) {
                0 | 1 => made.on_a_table(&mut dice, x, &name),
                2 | 3 => made.in_a_fridge(&mut dice, x, &name),
                _ => made.at_a_window(&mut dice, x, &name),
            }
            if let Some((last, true)) = last {
                made.states
                    .entry(name.clone())
                    .or_default()
                    .push(format!("next_to({last})"));
                made.states.entry(last).or_default().push(format!("next_to({name})"));
            }
            let is_near = dice.below(2) == 0;
            x += if is_near { 1.03 } else { 1.4 };
            last = Some((name, is_near));
        }
        if dice.below(2) == 0 {
            let middle = [0.0, -1.0, 1.2];
            let held = body("<held>", middle, [0.08, 0.08, 0.1]);
            made.add(Kind::Object, held, &["inside_hand()".to_owned()]);
            made.scene.hands.push(Hand {
                name: "hand".to_owned(),
                position: [0.0, -1.05, 1.2],
                closed: true,
            });
        }
        made.disturb(&mut dice);
        let (assets, states) = (made.environment.assets.clone(), std::mem::take(&mut made.states));
        for (name, own) in states.into_iter().filter(|(_, own)| !own.is_empty()) {
            let list = match assets.contains(&name) {
                true => &mut made.environment.asset_states,
                false => &mut made.environment.object_states,
            };
            list.insert(name, environment::Words::Many(own));
        }
        made
    }

    /// Turns and moves the scene as a whole, and moves each box by up to 3 mm.
    fn disturb(&mut self, dice: &mut Dice) {
        let turn = dice.share() * std::f64::consts::TAU;
        let away = [10.0 * dice.share(), -10.0 * dice.share(), dice.share()];
        let turned = |[x, y, z]: [f64; 3]| {
            let (sin, cos) = turn.sin_cos();
            [x * cos - y * sin + away[0], x * sin + y * cos + away[1], z + away[2]]
        };
        for body in &mut self.scene.boxes {
            let noise = [0, 1, 2].map(|_| 0.006 * dice.share() - 0.003);
            let [x, y, z] = turned(body.position);
            body.position = [x + noise[0], y + noise[1], z + noise[2]];
            // Written with another sign, it is the same orientation.
            let sign = if dice.below(2) == 0 { -1.0 } else { 1.0 };
            body.orientation = Orientation::new([sign * (turn / 2.0).cos(), 0.0, 0.0, sign * (turn / 2.0).sin()]);
        }
        for hand in &mut self.scene.hands {
            hand.position = turned(hand.position);
        }
    }
}

fn facts(world: &World) -> Vec<String> {
    let name = |entity| world.entity(entity).identifier.clone();
    let written = |fact| written_fact(world.domain(), fact, &name);
    let mut facts: Vec<String> = world.state.iter().map(written).collect();
    facts.sort();
    facts
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(500))]

    #[test]
    fn a_random_environment_is_found_again_in_its_boxes(seed in any::<u64>()) {
        let domain = household();
        let made = Made::new(seed);
        let found = look(&domain, &made.scene).unwrap();
        prop_assert_eq!(&found.findings, &[]);
        prop_assert_eq!(&found.environment.assets, &made.environment.assets);
        prop_assert_eq!(&found.environment.objects, &made.environment.objects);
        let world = |environment: &Environment| {
            environment::read(&domain, environment, "env.json", "", &crate::json::Path::default()).unwrap()
        };
        prop_assert_eq!(facts(&world(&found.environment)), facts(&world(&made.environment)));
    }

    #[test]
    fn no_numbers_make_it_panic(parts in prop::collection::vec((any::<[f64; 3]>(), any::<[f64; 3]>(), any::<[f64; 4]>()), 1..12)) {
        let boxes: Vec<serde_json::Value> = parts.iter().enumerate().map(|(index, (position, size, orientation))| {
            let size = size.map(|edge| if edge.is_finite() { edge.abs().clamp(1e-6, 1e5) } else { 1.0 });
            let position = position.map(|own| if own.is_finite() { own.clamp(-1e5, 1e5) } else { 0.0 });
            let finite = orientation.map(|own| if own.is_finite() { own.clamp(-1.0, 1.0) } else { 0.5 });
            let length = finite.iter().map(|own| own * own).sum::<f64>().sqrt();
            let orientation = if length > 1e-3 { finite.map(|own| own / length) } else { [1.0, 0.0, 0.0, 0.0] };
            serde_json::json!({"name": format!("b{index}"), "position": position, "size": size, "orientation": orientation})
        }).collect();
        let text = serde_json::json!({"boxes": boxes, "quaternions": "wxyz"}).to_string();
        let scene = Scene::parse("boxes.json", &text).unwrap();
        look(&household(), &scene).unwrap();
    }
}

/// One quarter turn in every form in which others write it.
#[test]
fn a_pose_is_read_in_every_form_that_says_what_it_means() {
    let half = std::f64::consts::FRAC_1_SQRT_2;
    let cup = |orientation: &str, more: &str| {
        format!(
            r#"{{"boxes": [{{"name": "cup", "position": {{"x": 1, "y": 2, "z": 3}}, "size": {{"x": 1, "y": 1, "z": 1}},
                "orientation": {orientation}, "score": 0.9}}]{more}}}"#
        )
    };
    let detection = r#"{"header": {"frame_id": "map"}, "detections": [{"id": "8",
        "results": [{"hypothesis": {"class_id": "mug", "score": 0.2}}, {"hypothesis": {"class_id": "cup", "score": 0.8}}],
        "bbox": {"center": {"position": {"x": 1, "y": 2, "z": 3}, "orientation": {"x": 0, "y": 0, "z": 0.70710678, "w": 0.70710678}},
            "size": {"x": 1, "y": 1, "z": 1}}}]}"#;
    for text in [
        cup(r#"{"w": 0.70710678, "x": 0, "y": 0, "z": 0.70710678}"#, ""),
        cup("[0.70710678, 0, 0, 0.70710678]", r#", "quaternions": "wxyz""#),
        cup("[0, 0, 0.70710678, 0.70710678]", r#", "quaternions": "xyzw""#),
        detection.to_owned(),
    ] {
        let scene = Scene::parse("boxes.json", &text).unwrap();
        let [cup] = &scene.boxes[..] else { panic!("{text}") };
        assert_eq!(
            (cup.name.as_str(), cup.position, cup.size),
            ("cup", [1.0, 2.0, 3.0], [1.0; 3])
        );
        let close = cup
            .orientation
            .parts
            .iter()
            .zip([half, 0.0, 0.0, half])
            .all(|(own, other)| (own - other).abs() < 1e-6);
        assert!(close, "{text}: {:?}", cup.orientation);
    }
}

#[test]
fn boxes_of_one_class_are_numbered() {
    let boxes = |names: [&str; 3]| {
        let boxes = names.map(|name| format!(r#"{{"name": "{name}", "position": [0, 0, 0], "size": [1, 1, 1]}}"#));
        let scene = Scene::parse("boxes.json", &format!("[{}]", boxes.join(", ")));
        scene.map(|scene| scene.boxes.into_iter().map(|own| own.name).collect::<Vec<_>>())
    };
    assert_eq!(boxes(["cup", "table", "cup"]).unwrap(), ["cup 1", "table", "cup 2"]);
    let twice = boxes(["<cup>", "<table>", "<cup>"]).unwrap_err().to_string();
    assert!(twice.contains("`<cup>` is listed twice"), "{twice}");
}
