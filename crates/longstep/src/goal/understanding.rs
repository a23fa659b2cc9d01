//! Comparison of goals with the entities that the instruction names.
//!
//! The most frequent error of small models is a goal about an entity that the instruction does not name: the person is asked
//! whether it is meant. An instruction without any name of the environment proves nothing about a goal: it may be in
//! another language.

use super::ambiguous::which;
use super::{Goal, GoalFact, Group, Mentions};
use crate::environment::{EntityId, World};
use longstep_core::model::Domain;

/// Result for a model's answer.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Understanding {
    /// The accepted goal.
    Goal(Goal),
    /// A goal that the words do not show: it is about an entity that they do not name. Without a second look at the words,
    /// the person is asked ([`Understanding::asked`]).
    Doubtful(Goal),
    /// A question to the person.
    Question(String),
    /// A question to the person which of several things is meant that fit the same words.
    Which(String),
}

impl Understanding {
    /// Returns the understanding for another world with these entities (see [`Goal::carried`]), or none if the other
    /// world lacks one of them.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        Some(match self {
            Self::Question(question) => Self::Question(question.clone()),
            Self::Which(question) => Self::Which(question.clone()),
            Self::Goal(goal) => Self::Goal(goal.carried(domain, from, to)?),
            Self::Doubtful(goal) => Self::Doubtful(goal.carried(domain, from, to)?),
        })
    }

    /// Returns the question for a doubtful goal, and everything else as it is.
    pub fn asked(self, world: &World) -> Self {
        match self {
            Self::Doubtful(goal) => Self::Question(guess(world, &goal)),
            other => other,
        }
    }
}

/// Compares a goal with the names in an instruction.
pub fn understand(world: &World, instruction: &str, goal: Goal) -> Understanding {
    understand_mentions(world, &Mentions::of(world, instruction), goal).asked(world)
}

/// Compares a goal with the names that were found.
///
/// The question which of several entities is meant is asked once: a model interprets the answer.
pub(crate) fn understand_mentions(world: &World, mentions: &Mentions, goal: Goal) -> Understanding {
    let named = Named { world, mentions };
    if goal.is_empty() {
        return Understanding::Question("What should I do?".to_owned());
    }
    if !goal.facts.iter().all(|fact| named.has_group(&goal, fact)) {
        return Understanding::Doubtful(goal);
    }
    let unclear = (!mentions.is_answered())
        .then(|| which(world, mentions, &goal))
        .flatten();
    unclear.map_or(Understanding::Goal(goal), Understanding::Which)
}

/// The test whether an instruction names the subjects of goals.
struct Named<'a> {
    world: &'a World,
    mentions: &'a Mentions,
}

impl Named<'_> {
    /// Returns true if the instruction names the subject of each part of a goal, or no entity at all.
    fn has(&self, fact: &GoalFact) -> bool {
        fact.parts().into_iter().all(|part| match part {
            GoalFact::Choice(choice) => {
                self.is_of_type(&choice.groups) || choice.alternatives().any(|part| self.has_subject(part))
            }
            other => self.has_subject(other),
        })
    }

    /// Tests the group of a goal that stands for one of its members.
    fn has_group(&self, goal: &Goal, fact: &GoalFact) -> bool {
        match goal.grouped_part(fact) {
            Some(part) => self.is_of_type(&part.groups) || part.facts.iter().any(|fact| self.has(fact)),
            None => self.has(fact),
        }
    }

    fn has_subject(&self, fact: &GoalFact) -> bool {
        let named = &self.mentions.entities;
        named.is_empty() || self.subject(fact).is_none_or(|subject| named.contains(&subject))
    }

    fn subject(&self, fact: &GoalFact) -> Option<EntityId> {
        match fact {
            GoalFact::Word { word, arguments } => {
                let place = self.world.domain().goal_word(*word).subject;
                place.map(|place| arguments[place])
            }
            GoalFact::Plain(_) | GoalFact::Number(_) | GoalFact::If(_) | GoalFact::Choice(_) => None,
        }
    }

    /// A type of the domain is no name in an instruction.
    fn is_of_type(&self, groups: &[Group]) -> bool {
        groups.iter().any(|group| group.is_of_type(self.world.domain()))
    }
}

/// Returns the question whether a goal is what the person wants.
pub(crate) fn guess(world: &World, goal: &Goal) -> String {
    let guess = goal.sentences(world).join("; ");
    format!("I am not sure what you want. Do you mean: {guess}?")
}
