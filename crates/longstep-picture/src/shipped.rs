//! The shipped domains, those of the examples, and their environments, for tests.

use std::fs;
use std::path::{Path, PathBuf};

use longstep_core::domain::{self, Files};
use longstep_core::environment;
use longstep_core::model::{Domain, World};
use longstep_core::plan::{Plan, Step};
use longstep_core::testing;
use longstep_core::verify::{Purpose, VerifiedPlan, check};

fn repository() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// Returns a shipped domain, one of tests, or one of the folder `examples`.
#[track_caller]
pub(crate) fn domain(name: &str) -> Domain {
    let folder = repository().join("examples").join(name);
    if !folder.exists() {
        return testing::domain(name);
    }
    let file = |name: &str| fs::read_to_string(folder.join(name)).unwrap();
    let files = Files {
        pddl: file("domain.pddl"),
        words: file("domain.toml"),
        ..Files::default()
    };
    domain::load(&files).unwrap_or_else(|findings| panic!("{findings}"))
}

/// Names of domains, with the folders or files of their environments in the repository.
const ENVIRONMENTS: [(&str, &str); 15] = [
    ("household", "crates/longstep-eval/suites/household/scenes"),
    ("household", "crates/longstep-eval/suites/long/scenes"),
    ("household", "examples/environments/pantry.json"),
    ("household-checks", "crates/longstep-eval/suites/branching/scenes"),
    ("household-checks", "examples/environments/larder.json"),
    ("household-dual", "crates/longstep-eval/suites/two-arms/scenes"),
    ("household-dual", "crates/longstep-eval/suites/unsaid-arms/scenes"),
    ("virtualhome", "crates/longstep-eval/suites/kitchen/scenes"),
    ("virtualhome", "examples/environments/flat.json"),
    ("home", "examples/home/suite/scenes"),
    ("care", "examples/care/suite/scenes"),
    ("laboratory", "examples/laboratory/suite/scenes"),
    ("warehouse", "examples/warehouse/suite/scenes"),
    ("workshop", "examples/workshop/suite/scenes"),
    ("greenhouse", "examples/greenhouse/environment.json"),
];

/// Returns the world of every environment, with the name of its file.
pub(crate) fn worlds() -> Vec<(String, World)> {
    let mut worlds = Vec::new();
    for (name, place) in ENVIRONMENTS {
        let place = repository().join(place);
        let mut files = vec![place.clone()];
        if place.is_dir() {
            files = fs::read_dir(&place)
                .unwrap()
                .map(|entry| entry.unwrap().path())
                .filter(|path| path.extension().is_some_and(|extension| extension == "json"))
                .collect();
            files.sort();
        }
        let domain = domain(name);
        assert!(!files.is_empty(), "{}", place.display());
        for file in files {
            let text = fs::read_to_string(&file).unwrap();
            let label = file.display().to_string();
            let world = environment::parse(&domain, &label, &text).unwrap_or_else(|findings| panic!("{findings}"));
            worlds.push((label, world));
        }
    }
    worlds
}

/// Returns the world of an environment of the repository.
#[track_caller]
pub(crate) fn world(domain_name: &str, file: &str) -> World {
    let text = fs::read_to_string(repository().join(file)).unwrap();
    testing::world_of(&domain(domain_name), text)
}

/// Returns a step, from the name of its action in PDDL and the identifiers of its arguments.
#[track_caller]
pub(crate) fn step(world: &World, action: &str, arguments: &[&str]) -> Step {
    let found = world.domain().action_ids().find(|(_, own)| own.name == action);
    let (id, _) = found.unwrap_or_else(|| panic!("{action}"));
    let entity = |name: &&str| world.find(name).unwrap_or_else(|| panic!("{name}"));
    Step::explained(world, id, arguments.iter().map(entity).collect())
}

/// Returns a plan after its verification without a goal.
#[track_caller]
pub(crate) fn verified(world: &World, plan: Plan) -> VerifiedPlan {
    let report = check(world, plan, &Purpose::default());
    report.into_verified().unwrap_or_else(|report| {
        let messages = report.violations.iter();
        let messages: Vec<String> = messages
            .map(|own| own.message(world, report.plan.steps(), None))
            .collect();
        panic!("{messages:?}")
    })
}
