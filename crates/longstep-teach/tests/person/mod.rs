//! A person who shows the steps of a plan: a hand path at 30 Hz with 5 mm of noise.
#![allow(dead_code, clippy::unwrap_used, clippy::panic)]

use longstep_core::environment::World;
use longstep_core::plan::{Plan, Step};
use longstep_core::testing;
use longstep_teach::{Demonstration, Format, Request, requests};
use nalgebra::{Rotation3, Unit, Vector3};

/// Random numbers of a seed (splitmix64).
pub(crate) struct Random(pub(crate) u64);

impl Random {
    pub(crate) fn uniform(&mut self, low: f64, high: f64) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        low + (high - low) * ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }

    pub(crate) fn normal(&mut self) -> f64 {
        let (one, other) = (self.uniform(1e-12, 1.0), self.uniform(0.0, std::f64::consts::TAU));
        (-2.0 * one.ln()).sqrt() * other.cos()
    }

    pub(crate) fn vector(&mut self) -> Vector3<f64> {
        Vector3::new(self.normal(), self.normal(), self.normal())
    }
}

/// Slow at both ends, as a hand is.
pub(crate) fn eased(share: f64) -> f64 {
    share * share * (3.0 - 2.0 * share)
}

/// A line of a recording.
#[derive(Clone)]
pub(crate) struct Line {
    pub(crate) time: f64,
    pub(crate) hand: &'static str,
    pub(crate) point: Vector3<f64>,
    pub(crate) grip: f64,
    pub(crate) step: usize,
}

pub(crate) struct Person {
    random: Random,
    pub(crate) noise: f64,
    pub(crate) hand: &'static str,
    pub(crate) position: Vector3<f64>,
    time: f64,
    grip: f64,
    step: usize,
    pub(crate) lines: Vec<Line>,
}

impl Person {
    pub(crate) fn new(noise: f64) -> Self {
        Self {
            random: Random(42),
            noise,
            hand: "right",
            position: Vector3::new(0.0, -1.0, 1.0),
            time: 0.0,
            grip: 0.0,
            step: 1,
            lines: Vec::new(),
        }
    }

    fn frame(&mut self) {
        let point = self.position + self.random.vector() * self.noise;
        self.lines.push(Line {
            time: self.time,
            hand: self.hand,
            point,
            grip: self.grip,
            step: self.step,
        });
        self.time += 1.0 / 30.0;
    }

    pub(crate) fn rest(&mut self, seconds: f64) -> &mut Self {
        for _ in 0..(seconds * 30.0) as usize {
            self.frame();
        }
        self
    }

    pub(crate) fn go(&mut self, to: [f64; 3]) -> &mut Self {
        let (from, to) = (self.position, Vector3::from(to));
        self.follow(1.2, |share| from + (to - from) * share)
    }

    fn follow(&mut self, seconds: f64, path: impl Fn(f64) -> Vector3<f64>) -> &mut Self {
        let frames = (seconds * 30.0) as usize;
        for frame in 1..=frames {
            self.position = path(eased(frame as f64 / frames as f64));
            self.frame();
        }
        self
    }

    pub(crate) fn by(&mut self, way: [f64; 3]) -> &mut Self {
        let to = self.position + Vector3::from(way);
        self.go(to.into())
    }

    pub(crate) fn turn(&mut self, axis: [f64; 3], centre: [f64; 3], degrees: f64) -> &mut Self {
        let (axis, centre) = (Unit::new_normalize(Vector3::from(axis)), Vector3::from(centre));
        let from = self.position - centre;
        self.follow(2.5, |share| {
            centre + Rotation3::from_axis_angle(&axis, share * degrees.to_radians()) * from
        })
    }

    pub(crate) fn wipe(&mut self) -> &mut Self {
        let from = self.position;
        self.follow(4.0, |share| {
            from + Vector3::new(0.15 * (share * 30.0).sin(), 0.2 * share, 0.0)
        })
    }

    pub(crate) fn close(&mut self) -> &mut Self {
        self.grip = 1.0;
        self.rest(0.3)
    }

    pub(crate) fn open(&mut self) -> &mut Self {
        self.rest(0.3);
        self.grip = 0.0;
        self.rest(0.2)
    }

    /// Ends a step with a rest, half of which belongs to the next one.
    pub(crate) fn next(&mut self) -> &mut Self {
        self.rest(0.4);
        self.step += 1;
        self.rest(0.4)
    }
}

/// The parts of a recording that are written.
#[derive(Clone, Copy)]
pub(crate) struct Columns {
    pub(crate) step: bool,
    pub(crate) arm: bool,
    pub(crate) grasp: bool,
}

pub(crate) const ALL: Columns = Columns {
    step: true,
    arm: true,
    grasp: true,
};

pub(crate) fn csv(lines: &[Line], columns: Columns) -> String {
    let mut text = "t,hand,x,y,z,grip".to_owned();
    if columns.arm {
        text.push_str(",elbow_x,elbow_y,elbow_z,shoulder_x,shoulder_y,shoulder_z");
    }
    if columns.grasp {
        text.push_str(",grasp");
    }
    if columns.step {
        text.push_str(",step");
    }
    for line in lines {
        let [x, y, z]: [f64; 3] = line.point.into();
        text.push_str(&format!(
            "\n{:.4},{},{x:.5},{y:.5},{z:.5},{}",
            line.time, line.hand, line.grip
        ));
        if columns.arm {
            // The lower arm points forward, the upper arm hangs.
            text.push_str(&format!(
                ",{x:.5},{:.5},{z:.5},{x:.5},{:.5},{:.5}",
                y - 0.25,
                y - 0.25,
                z + 0.28
            ));
        }
        if columns.grasp {
            text.push_str(",power");
        }
        if columns.step {
            text.push_str(&format!(",{}", line.step));
        }
    }
    text
}

pub(crate) fn recording(lines: &[Line], columns: Columns) -> Demonstration {
    Demonstration::read("demo.csv", Format::Csv, csv(lines, columns).as_bytes()).unwrap()
}

pub(crate) fn world() -> World {
    let text = r#"{"assets": ["<table>", "<shelf>", "<fridge>", "<drawer>"],
        "objects": ["<fridge_handle>", "<drawer_handle>", "<sponge>"],
        "object_states": {"<sponge>": "on_something(<table>)", "<fridge_handle>": "closed()", "<drawer_handle>": "closed()"}}"#;
    testing::world("household-taught", text)
}

/// The steps to show: an action with its arguments each.
pub(crate) fn plan(world: &World, calls: &[&str]) -> Vec<Request> {
    let step = |call: &&str| {
        let mut words = call.split_whitespace();
        let name = words.next().unwrap();
        let (id, _) = world
            .domain()
            .action_ids()
            .find(|(_, action)| action.name == name)
            .unwrap();
        let arguments = words.map(|word| world.find(&format!("<{word}>")).unwrap()).collect();
        Step::explained(world, id, arguments)
    };
    requests(world, &Plan::sequence(calls.iter().map(step).collect()))
}

/// A plan with all thirteen actions, which is shown by [`shown`].
pub(crate) const CALLS: [&str; 19] = [
    "move-hand fridge_handle",
    "grasp fridge_handle",
    "open-by-rotate fridge_handle",
    "adjust-by-rotate fridge_handle",
    "close-by-rotate fridge_handle",
    "release fridge_handle",
    "move-hand drawer_handle",
    "grasp drawer_handle",
    "open-by-slide drawer_handle",
    "adjust-by-slide drawer_handle",
    "close-by-slide drawer_handle",
    "release drawer_handle",
    "move-hand sponge",
    "grasp sponge",
    "detach sponge table",
    "move-object sponge shelf",
    "attach sponge shelf",
    "wipe sponge shelf",
    "release sponge",
];

/// The hinge of the fridge: the handle is 0.44 m to its right.
pub(crate) const HINGE: [f64; 3] = [-0.14, -0.3, 0.6];

pub(crate) fn shown(noise: f64) -> Person {
    let mut person = Person::new(noise);
    person.rest(0.3).go([0.3, -0.5, 0.6]).next();
    person.by([0.0, 0.2, 0.0]).close().next();
    person.turn([0.0, 0.0, -1.0], HINGE, 80.0).next();
    person.turn([0.0, 0.0, -1.0], HINGE, 50.0).next();
    person.turn([0.0, 0.0, -1.0], HINGE, -130.0).next();
    person.open().by([0.0, -0.2, 0.1]).next();
    person.go([1.0, -0.5, 0.4]).next();
    person.by([0.0, 0.2, 0.0]).close().next();
    person.by([0.0, -0.2, 0.0]).next();
    person.by([0.0, -0.08, 0.0]).next();
    person.by([0.0, 0.28, 0.0]).next();
    person.open().by([0.0, -0.2, 0.0]).next();
    person.go([2.0, 0.0, 0.7]).next();
    person.by([0.0, 0.0, -0.2]).close().next();
    person.by([0.0, 0.0, 0.1]).next();
    person.go([3.0, 0.0, 0.8]).next();
    person.by([0.0, 0.0, -0.1]).next();
    person.wipe().next();
    person.open().by([0.0, -0.1, 0.1]).rest(0.3);
    person
}
