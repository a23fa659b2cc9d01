//! A new look at the world of a session.

use indexmap::IndexMap;

use crate::call::Call;
use crate::environment::{Environment, World};
use crate::model::StateWord;
use longstep_core::environment::{Observation, Words};
use longstep_core::model::{Domain, SpatialRelation};

/// The relations that a look decides together: something that is on a place is in no other one.
const GROUPS: [&[SpatialRelation]; 3] = [
    &[SpatialRelation::On, SpatialRelation::Inside, SpatialRelation::Held],
    &[SpatialRelation::Open, SpatialRelation::Closed],
    &[SpatialRelation::NextTo],
];

/// The source of a look, which decides how much the look says about an entity that it shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum LookSource {
    /// Boxes with poses: all relations to other boxes, and of a joint only what is given.
    Poses,
    /// Words and pictures: only what is stated.
    Stated,
}

/// Returns the statements of an observation: for each entity that the look and the world have, what the look states, and of
/// the world's own states those that the look does not decide.
///
/// Entities that only the look has are listed too; an observation reports them as unknown.
pub fn observation(world: &World, look: &Environment, source: LookSource) -> Observation {
    let domain = world.domain();
    let own = world.environment();
    let mut states = IndexMap::new();
    for name in look.assets.iter().chain(&look.objects) {
        let new = entries(look, name);
        let mut all = new.clone();
        let old = entries(own, name);
        all.extend(
            old.into_iter()
                .filter(|text| !new.contains(text) && !is_decided(domain, text, &new, source)),
        );
        states.insert(name.clone(), Words::Many(all));
    }
    Observation { states, facts: None }
}

fn entries(environment: &Environment, name: &str) -> Vec<String> {
    let all = [&environment.asset_states, &environment.object_states];
    let own = all.iter().find_map(|states| states.get(name));
    own.map_or_else(Vec::new, |words| words.as_slice().to_vec())
}

/// Returns true if a look with new states decides whether an old one still holds.
fn is_decided(domain: &Domain, old: &str, new: &[String], source: LookSource) -> bool {
    let Some(word) = word_of(domain, old) else { return false };
    let news: Vec<&StateWord> = new.iter().filter_map(|text| word_of(domain, text)).collect();
    if news.iter().any(|other| other.word == word.word) {
        return true;
    }
    let mut groups = GROUPS
        .iter()
        .filter(|group| word.relations.iter().any(|own| group.contains(own)));
    groups.any(|group| {
        let is_seen = source == LookSource::Poses && !group.contains(&SpatialRelation::Open);
        is_seen
            || news
                .iter()
                .any(|other| other.relations.iter().any(|own| group.contains(own)))
    })
}

fn word_of<'a>(domain: &'a Domain, text: &str) -> Option<&'a StateWord> {
    let call = Call::parse(text).ok()?;
    domain.states.iter().find(|word| word.word == call.name)
}
