//! The domains and scenes of a server.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Instant;

use longstep::{Clock, Planner, domain};
use longstep_core::environment::World;
use longstep_llm::load_domain;
use serde::Serialize;

use crate::problem::{Problem, ProblemKind};

/// The most domains that are kept loaded.
const KEPT: usize = 32;

/// A world in which a session may begin.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[non_exhaustive]
pub struct Scene {
    /// Its name.
    pub name: String,
    /// The domain.
    pub domain: String,
    /// The environment as JSON.
    #[serde(skip)]
    pub environment: String,
    /// An instruction to try.
    pub example: String,
}

impl Scene {
    /// Creates a scene.
    pub fn new(name: &str, domain: &str, environment: &str, example: &str) -> Self {
        Self {
            name: name.to_owned(),
            domain: domain.to_owned(),
            environment: environment.to_owned(),
            example: example.to_owned(),
        }
    }

    /// Returns the scenes that a newcomer can try.
    pub fn shipped() -> Vec<Self> {
        vec![
            Self::new(
                "pantry",
                "household",
                include_str!("../scenes/pantry.json"),
                "Put the juice on top of the shelf",
            ),
            Self::new(
                "kitchen",
                "household-checks",
                include_str!("../scenes/kitchen.json"),
                "If the cream has expired put it in the scrap bin, otherwise on the ledge",
            ),
        ]
    }
}

/// The domains of a server: the shipped ones, and those that its owner names. A request cannot name a folder.
pub struct Domains {
    named: BTreeMap<String, String>,
    scenes: Vec<Scene>,
    clock: Clock,
    loaded: Mutex<BTreeMap<String, Planner>>,
}

impl Domains {
    /// Creates the domains of a server: `folders` are those besides the shipped ones.
    ///
    /// # Errors
    ///
    /// A folder that is no domain.
    pub fn new(folders: &[String], scenes: Vec<Scene>) -> Result<Self, Problem> {
        let began = Instant::now();
        let mut named: BTreeMap<String, String> = domain::shipped_names()
            .into_iter()
            .map(|name| (name.to_owned(), name.to_owned()))
            .collect();
        for folder in folders {
            named.insert(load_domain(folder)?.name.clone(), folder.clone());
        }
        Ok(Self {
            named,
            scenes,
            clock: Clock::new(move || began.elapsed()),
            loaded: Mutex::default(),
        })
    }

    /// Returns the names of the domains.
    pub fn names(&self) -> Vec<&str> {
        self.named.keys().map(String::as_str).collect()
    }

    /// Returns the scenes.
    pub fn scenes(&self) -> &[Scene] {
        &self.scenes
    }

    /// Returns a scene.
    ///
    /// # Errors
    ///
    /// There is none of that name.
    pub fn scene(&self, name: &str) -> Result<&Scene, Problem> {
        let found = self.scenes.iter().find(|scene| scene.name == name);
        found.ok_or_else(|| {
            let names: Vec<&str> = self.scenes.iter().map(|scene| scene.name.as_str()).collect();
            Problem::missing("scene", name).hint(format!("there are {}", names.join(", ")))
        })
    }

    /// Returns the planner of a domain of this server.
    ///
    /// # Errors
    ///
    /// There is no such domain, or its files have errors.
    pub fn planner(&self, name: &str) -> Result<Planner, Problem> {
        let Some(origin) = self.named.get(name) else {
            return Err(
                Problem::new(ProblemKind::Missing, format!("there is no domain `{name}`"))
                    .hint(format!("there are {}", self.names().join(", "))),
            );
        };
        self.load(origin)
    }

    /// Returns the planner for the domain that a log of ours names: a shipped one, or a folder.
    pub(crate) fn of_log(&self, origin: &str) -> Result<Planner, Problem> {
        self.load(origin)
    }

    fn load(&self, origin: &str) -> Result<Planner, Problem> {
        let mut loaded = self.loaded.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(planner) = loaded.get(origin) {
            return Ok(planner.clone());
        }
        let planner = Planner::new(Arc::new(load_domain(origin)?)).with_clock(self.clock.clone());
        if loaded.len() >= KEPT {
            loaded.pop_first();
        }
        loaded.insert(origin.to_owned(), planner.clone());
        Ok(planner)
    }
}

/// Reads an environment, and puts rules in force.
///
/// # Errors
///
/// Every finding, with its place.
pub(crate) fn world(planner: &Planner, environment: &str, rules: &[String]) -> Result<World, Problem> {
    let mut world = planner.world(environment)?;
    let mut read = Vec::new();
    for rule in rules {
        world.add_values(rule);
        let found = longstep_core::goal::rules(&world, rule);
        read.extend(found.map_err(|error| {
            Problem::unreadable(format!("rule `{rule}`: {error}"))
                .hint("a rule is `never GOAL`, `always GOAL` or `untouched(NAME)`")
        })?);
    }
    Ok(world.with_prohibitions(read))
}
