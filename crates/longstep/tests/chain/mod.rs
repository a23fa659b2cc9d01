//! Long chains of instructions over one world, for the tests here and for those with a real model: instructions drawn
//! for the world as it is, the world computed once more in another way, and the figures of a chain.

#![allow(dead_code, unreachable_pub, unused_imports)]

mod draw;

pub use draw::{Draw, Drawn};

use std::path::PathBuf;

use longstep::domain::{self, Domain};
use longstep_core::environment::{self, Claim, Environment, World};
use longstep_core::json::Path;
use longstep_core::plan::{self, PlanFile};
pub use longstep_core::testing::world_of;
use longstep_core::verify::{self, Purpose};
use serde_json::Value;

/// The household scenes of the paper.
pub const SCENES: [&str; 5] = ["drawer", "fridge", "shelf", "table", "window"];

pub fn read(file: &str) -> Value {
    let folder = std::env::var_os("LONGSTEP_CORPUS").expect("LONGSTEP_CORPUS names the folder of the recorded plans");
    let path = PathBuf::from(folder).join(file);
    serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap()
}

pub fn domain(name: &str) -> Domain {
    domain::shipped(name).unwrap().unwrap()
}

fn read_anew(domain: &longstep_core::domain::Domain, environment: &Environment) -> World {
    environment::read(domain, environment, "environment", "", &Path::default())
        .unwrap_or_else(|error| panic!("{error}"))
}

/// Returns true if the world is as a recorded environment says, fact by fact.
pub fn is_as_recorded(world: &World, recorded: &Value) -> bool {
    let domain = world.domain();
    let recorded: Environment = serde_json::from_value(recorded.clone()).unwrap();
    let claim = Claim::read(world, &recorded);
    let facts = |environment: &Environment| read_anew(domain, environment).state;
    let same = facts(&recorded) == facts(world.environment());
    same && claim.differences(domain, &world.state).is_empty()
}

/// A chain's environment computed from nothing but the first environment and the saved plans: each plan's words are
/// read, and carried out in a world that is read from the environment before it.
pub struct Recomputation {
    environment: Environment,
}

impl Recomputation {
    pub fn new(first: &Environment) -> Self {
        Self {
            environment: first.clone(),
        }
    }

    /// Carries out a saved plan; panics where what it says of its environments is something else.
    pub fn apply(&mut self, domain: &Domain, file: &PlanFile, carried: &World) {
        // What is saved is what counts: it goes through its text.
        let file: PlanFile = serde_json::from_str(&serde_json::to_string(file).unwrap()).unwrap();
        let json = |environment: &Environment| serde_json::to_string(environment).unwrap();
        assert_eq!(
            json(file.environment_before.as_ref().unwrap()),
            json(&self.environment),
            "before"
        );
        let world = read_anew(domain, &self.environment);
        let resolved = plan::resolve(&world, &file.task_cohesion);
        let claimed = file.environment_after.as_ref().unwrap();
        let claim = Claim::read(&world, claimed);
        let steps = resolved.complete().unwrap();
        let (steps, _) = verify::bind(&world, &steps, &resolved.objects, Some(&claim)).unwrap();
        let purpose = Purpose {
            claim: Some(claim),
            ..Purpose::default()
        };
        let verified = verify::check(&world, steps, &purpose).into_verified();
        let verified = verified.unwrap_or_else(|report| panic!("{:?}", report.violations));
        self.environment = environment::write(&world, &verified.ending().after);
        assert_eq!(json(claimed), json(&self.environment), "claimed after");
        assert_eq!(json(carried.environment()), json(&self.environment), "carried");
    }
}

/// The seed of the drawn instructions: `LONGSTEP_SEED`, or 7.
pub fn draw() -> Draw {
    Draw::new(std::env::var("LONGSTEP_SEED").map_or(7, |seed| seed.parse().unwrap()))
}

/// By how much the values grow from one to the next, by least squares.
pub fn slope(values: &[f64]) -> f64 {
    let middle = (values.len() as f64 - 1.0) / 2.0;
    let mean = mean(values);
    let (mut above, mut below) = (0.0, 0.0);
    for (index, value) in values.iter().enumerate() {
        let place = index as f64 - middle;
        above += place * (value - mean);
        below += place * place;
    }
    above / below
}

pub fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// The memory of this process in megabytes: what is resident, and the most that ever was. None where it is not told.
pub fn memory() -> Option<(f64, f64)> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let field = |name: &str| {
        let line = status.lines().find(|line| line.starts_with(name))?;
        let kilobytes: f64 = line.split_whitespace().nth(1)?.parse().ok()?;
        Some(kilobytes / 1024.0)
    };
    Some((field("VmRSS")?, field("VmHWM")?))
}
