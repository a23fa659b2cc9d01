//! Worlds for tests and benchmarks, with the feature `testing`.
//!
//! These functions panic where the library returns an error, with the findings as the message.

#![allow(clippy::panic, reason = "a test fails by a panic")]

use std::fmt::Display;

use crate::domain::{self, Files};
use crate::environment;
use crate::model::{Domain, World};

/// Returns a shipped domain, or one that only tests have: `home` with values, `tank` with numbers.
///
/// ```
/// use longstep_model::testing;
/// assert_eq!(testing::domain("household").name, "household");
/// ```
///
/// # Panics
///
/// If there is no such domain.
#[track_caller]
pub fn domain(name: &str) -> Domain {
    let loaded = match name {
        "home" => Some(domain::load(&files(
            include_str!("../tests/domains/home/domain.pddl"),
            include_str!("../tests/domains/home/domain.toml"),
        ))),
        "tank" => Some(domain::load(&files(
            include_str!("../tests/domains/tank/domain.pddl"),
            include_str!("../tests/domains/tank/domain.toml"),
        ))),
        _ => domain::shipped(name),
    };
    match loaded {
        Some(Ok(domain)) => domain,
        Some(Err(findings)) => panic!("{findings}"),
        None => panic!("there is no domain `{name}`"),
    }
}

/// Returns the world of an environment in JSON, read with a domain of this name ([`domain()`]).
///
/// ```
/// use longstep_model::testing;
/// let world = testing::world("household", r#"{"assets": ["<table>"], "objects": ["<cup>"]}"#);
/// assert!(world.find("<cup>").is_some());
/// ```
///
/// # Panics
///
/// If there is no such domain, or the environment has errors.
#[track_caller]
pub fn world(domain_name: &str, environment: impl Display) -> World {
    world_of(&domain(domain_name), environment)
}

/// Returns the world of an environment in JSON: a text or a `serde_json::Value`, bare or wrapped in
/// `{"environment": ...}`.
///
/// ```
/// use longstep_model::testing;
/// let household = testing::domain("household");
/// let world = testing::world_of(&household, serde_json::json!({"assets": ["<table>"]}));
/// assert!(world.find("<table>").is_some());
/// ```
///
/// # Panics
///
/// If the environment has errors.
#[track_caller]
pub fn world_of(domain: &Domain, environment: impl Display) -> World {
    environment::parse(domain, "environment", &environment.to_string()).unwrap_or_else(|findings| panic!("{findings}"))
}

fn files(pddl: &str, words: &str) -> Files {
    Files {
        pddl: pddl.to_owned(),
        words: words.to_owned(),
        ..Files::default()
    }
}

/// Numbers that look random and are the same each time (SplitMix64).
///
/// ```
/// use longstep_model::testing::Draws;
/// let (mut one, mut other) = (Draws::new(7), Draws::new(7));
/// assert!((0..100).all(|_| one.below(10) == other.below(10)));
/// assert!(["a", "b"].contains(&one.of(&["a", "b"])));
/// ```
#[derive(Debug, Clone)]
pub struct Draws(u64);

impl Draws {
    /// Begins with a seed.
    pub fn new(seed: u64) -> Self {
        Self(seed)
    }

    /// Returns a number below the limit, which is not zero.
    pub fn below(&mut self, limit: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((mixed ^ (mixed >> 31)) % limit as u64) as usize
    }

    /// Returns one of several values.
    pub fn of<T: Copy>(&mut self, all: &[T]) -> T {
        all[self.below(all.len())]
    }
}
