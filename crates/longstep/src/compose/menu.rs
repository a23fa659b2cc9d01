//! The parts that a composition may use: stored plans, sensing calls, and lanes.
//!
//! Cues in the instruction narrow the choice, because a small model otherwise adds one plan too many or senses without
//! need. The cues are English; without a match, every stored plan is available.

use super::condition_words::Clauses;
use super::sensing::{Check, called, checks};
use super::{Recalled, Stored};
use crate::dialogue::actors;
use crate::environment::World;
use crate::goal::Mentions;
use crate::model::{plain_words, singular};

/// Parts available to a composition.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Menu {
    pub(super) plans: Vec<Offered>,
    pub(super) checks: Vec<Check>,
    /// Actors with a plan that fits a lane, in the order of the world. Empty if there are fewer than two.
    pub(super) lanes: Vec<String>,
    /// True if the instruction asks for a branch or for lanes.
    pub(super) fork_wanted: bool,
}

/// A stored plan as listed in the prompt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Offered {
    pub(super) name: String,
    pub(super) summary: String,
    /// Name of the only actor of the plan, if it fits a lane.
    pub(super) lane: Option<String>,
}

/// Phrases that ask for parallel lanes.
const SIDE_BY_SIDE: [&str; 12] = [
    "at once",
    "same time",
    "meanwhile",
    "simultaneously",
    "in parallel",
    "side by side",
    "both arms",
    "both hands",
    "each arm",
    "each hand",
    "other arm",
    "other hand",
];
/// Phrases that permit lanes but do not require them.
const PERHAPS_SIDE_BY_SIDE: [&str; 6] = ["while", "together", "both robots", "each robot", "other robot", "both"];

impl Menu {
    pub(super) fn of(world: &World, stored: &[Stored], instruction: &str) -> Self {
        let domain = world.domain();
        let mentioned = Mentions::of(world, instruction);
        let words = plain_words(instruction);
        let recalled = stored.iter().map(|plan| (plan, Recalled::of(world, plan).ok()));
        let mut recalled: Vec<(&Stored, Option<Recalled>)> = recalled.collect();
        let is_meant = |(stored, recalled): &(&Stored, Option<Recalled>)| {
            let items = recalled.iter().flat_map(|recalled| &recalled.handled);
            let mut items = items.filter_map(|identifier| world.find(identifier)).filter(|entity| {
                let kind = world.entity(*entity).kind;
                domain.types.is_a(kind, domain.environment.object)
            });
            items.any(|item| mentioned.entities.contains(&item) || is_named(&world.entity(item).names, &words))
                || says_verb(&stored.summary, &words)
        };
        if recalled.iter().any(is_meant) {
            recalled.retain(is_meant);
        }
        let actors = actors(world);
        let lane = |recalled: &Recalled| match &recalled.actors[..] {
            [only] if !recalled.joint && recalled.written.is_sequence() => actors
                .iter()
                .map(|actor| world.entity(*actor))
                .find(|actor| actor.identifier == *only)
                .map(called),
            _ => None,
        };
        let plans: Vec<Offered> = recalled
            .iter()
            .map(|(plan, recalled)| Offered {
                name: plan.name.clone(),
                summary: plan.summary.clone(),
                lane: recalled.as_ref().and_then(lane),
            })
            .collect();
        let text = words.join(" ");
        let says = |cues: &[&str]| cues.iter().any(|cue| format!(" {text} ").contains(&format!(" {cue} ")));
        let side_by_side = says(&SIDE_BY_SIDE);
        let mut lanes: Vec<String> = actors.iter().map(|actor| called(world.entity(*actor))).collect();
        lanes.retain(|lane| plans.iter().any(|plan| plan.lane.as_ref() == Some(lane)));
        if lanes.len() < 2 || !(side_by_side || says(&PERHAPS_SIDE_BY_SIDE)) {
            lanes.clear();
        }
        let clauses = Clauses::of(instruction);
        let outcomes = clauses.outcomes(world, instruction, &mentioned);
        // A condition that matches no cue may still be about the outcome of a sensing call, so every call about the
        // named entities is available.
        let checks = if clauses.are_undecided(world, &outcomes) {
            checks(world, |fact| {
                domain
                    .arguments(fact)
                    .all(|entity| mentioned.entities.contains(&entity))
            })
        } else {
            checks(world, |fact| outcomes.contains(&fact))
        };
        Self {
            fork_wanted: (side_by_side && !lanes.is_empty()) || !outcomes.is_empty(),
            plans,
            checks,
            lanes,
        }
    }
}

/// Returns true if the instruction contains a word of one of the names. Words of up to three letters do not count:
/// "can" is rarely the paint can.
fn is_named(names: &[String], words: &[String]) -> bool {
    let words: Vec<String> = words.iter().map(|word| singular(word)).collect();
    let parts = names.iter().flat_map(|name| plain_words(name));
    let mut parts = parts
        .map(|part| singular(&part))
        .filter(|part| part.chars().count() > 3);
    parts.any(|part| words.contains(&part))
}

/// Returns true if the instruction contains the verb that begins the summary, unless that verb is too common.
fn says_verb(summary: &str, words: &[String]) -> bool {
    const COMMON: [&str; 11] = [
        "put", "place", "set", "lay", "take", "get", "bring", "move", "pick", "fetch", "carry",
    ];
    let verb = plain_words(summary).into_iter().next();
    verb.is_some_and(|verb| !COMMON.contains(&verb.as_str()) && words.contains(&verb))
}
