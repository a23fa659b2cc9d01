//! Random environments, which are found again in their boxes.

use std::collections::BTreeMap;

use proptest::prelude::*;

use super::super::*;
use super::{body, household};
use crate::environment::{self, Environment, World};
use crate::model::written_fact;

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
            let list = if assets.contains(&name) {
                &mut made.environment.asset_states
            } else {
                &mut made.environment.object_states
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
    fn look_recovers_a_random_environment_from_boxes(seed in any::<u64>()) {
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
    fn look_never_panics_on_random_boxes(parts in prop::collection::vec((any::<[f64; 3]>(), any::<[f64; 3]>(), any::<[f64; 4]>()), 1..12)) {
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
