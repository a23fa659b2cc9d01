//! Goals, in the few typed words that a domain declares.
//!
//! A [`Goal`] is written `put(cup, shelf) & closed(door)`. [`parse`] reads one, search turns it into steps, and
//! [`Goal::purpose`] is what verification holds the steps against.

mod conditional;
mod language;
mod partial_answer;

pub use conditional::Conditional;
pub use conditional::{AND, ELSE, IF, NOT, THEN, Written};
pub use language::{GoalError, JOINT, QUESTION, parse, read_form};
pub use partial_answer::{Begun, Next, ended};

use crate::model::{Domain, EntityId, Fact, FormPiece, GoalWordId, RuleTime, Voice, Wanted, World, written_fact};
use crate::verify::{Purpose, Waiver, wanted_at_end};

/// One thing that is wanted.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum GoalFact {
    /// A goal word of the domain with its arguments.
    Word {
        /// The word.
        word: GoalWordId,
        /// One entity for each parameter.
        arguments: Vec<EntityId>,
    },
    /// A plain fact, written with the environment's own words.
    Plain(Fact),
    /// One thing or another, whatever sensing tells.
    If(Conditional),
}

/// Everything that is wanted.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Goal {
    /// Its parts.
    pub facts: Vec<GoalFact>,
}

impl GoalFact {
    /// The fact in the goal language, with `name` called for each entity.
    fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        match self {
            Self::Word { word, arguments } => {
                let piece = |piece: &FormPiece| match piece {
                    FormPiece::Text(text) => text.clone(),
                    FormPiece::Parameter(index) => name(arguments[*index]),
                };
                domain.goal_word(*word).form.iter().map(piece).collect()
            }
            Self::Plain(fact) => written_fact(domain, *fact, name),
            Self::If(conditional) => conditional.written(domain, name),
        }
    }

    /// The goals that it is made of: itself, or those of both sides.
    pub fn parts(&self) -> Vec<&GoalFact> {
        match self {
            Self::If(conditional) => {
                let sides = conditional.then.iter().chain(&conditional.otherwise);
                sides.flat_map(GoalFact::parts).collect()
            }
            _ => vec![self],
        }
    }

    /// As a model writes it: `put(pie, oven)`.
    pub fn everyday(&self, domain: &Domain, world: &World) -> String {
        self.written(domain, &|entity| world.entity(entity).name.clone())
    }

    /// With the environment's identifiers: `put(<pie_320>, <microwave_314>)`.
    pub fn exact(&self, domain: &Domain, world: &World) -> String {
        self.written(domain, &|entity| world.entity(entity).identifier.clone())
    }

    /// As a sentence for a person.
    pub fn sentence(&self, domain: &Domain, world: &World) -> String {
        self.sentence_in(Voice::Person, domain, world)
    }

    /// As a sentence in either voice.
    pub fn sentence_in(&self, voice: Voice, domain: &Domain, world: &World) -> String {
        match self {
            Self::Word { word, arguments } => {
                let name = |parameter: usize| voice.name(world, arguments[parameter]);
                domain.goal_word(*word).says.fill(name)
            }
            Self::Plain(fact) => voice.fact(domain, world, *fact, true),
            Self::If(conditional) => conditional.sentence(voice, domain, world),
        }
    }

    /// The same about the things of another world, if they are there.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Self> {
        let there = |entity: EntityId| to.find(&from.entity(entity).identifier);
        Some(match self {
            Self::Word { word, arguments } => Self::Word {
                word: *word,
                arguments: arguments
                    .iter()
                    .map(|entity| there(*entity))
                    .collect::<Option<Vec<_>>>()?,
            },
            Self::Plain(fact) => {
                let arguments = domain.arguments(*fact).map(there).collect::<Option<Vec<_>>>()?;
                Self::Plain(Fact::new(fact.predicate(), arguments))
            }
            Self::If(conditional) => Self::If(conditional.carried(domain, from, to)?),
        })
    }

    /// The thing that it is about, if it is about one.
    pub fn subject(&self, domain: &Domain) -> Option<EntityId> {
        match self {
            Self::Word { word, arguments } => domain.goal_word(*word).subject.map(|parameter| arguments[parameter]),
            Self::Plain(fact) => domain.arguments(*fact).next(),
            Self::If(conditional) => domain.arguments(conditional.condition).next(),
        }
    }

    /// Everything that it is about.
    pub fn about(&self, domain: &Domain) -> Vec<EntityId> {
        match self {
            Self::Word { arguments, .. } => arguments.clone(),
            Self::Plain(fact) => domain.arguments(*fact).collect(),
            Self::If(conditional) => {
                let condition = domain.arguments(conditional.condition);
                let parts = self.parts();
                condition
                    .chain(parts.into_iter().flat_map(|part| part.about(domain)))
                    .collect()
            }
        }
    }

    /// What must hold for it, as one of the goals of `all`.
    fn wanted(&self, domain: &Domain, all: &[GoalFact]) -> Wanted {
        match self {
            Self::Word { word, arguments } => Wanted {
                condition: domain.goal_word(*word).condition.clone(),
                bindings: arguments.clone(),
            },
            Self::Plain(fact) => Wanted::of_fact(domain, *fact),
            Self::If(conditional) => conditional.wanted(domain, all),
        }
    }
}

impl Goal {
    /// The same goal in another world that has its things: what was understood in a part of a world
    /// ([`World::narrowed`]), for the whole of it. None if something of it is not there.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Goal> {
        let facts = self.facts.iter().map(|fact| fact.carried(domain, from, to));
        Some(Goal {
            facts: facts.collect::<Option<Vec<_>>>()?,
        })
    }

    /// The rules that this goal sets aside: who asks for the fridge to be open does not want it closed.
    fn waivers(&self, domain: &Domain) -> Vec<Waiver> {
        let mut waivers = Vec::new();
        for fact in self.facts.iter().flat_map(GoalFact::parts) {
            for (number, rule) in domain.rules.iter().enumerate() {
                match fact {
                    GoalFact::Word { word, arguments } if rule.unless.contains(&domain.goal_word(*word).word) => {
                        waivers.extend(arguments.iter().map(|entity| Waiver {
                            rule: number,
                            entity: *entity,
                        }));
                    }
                    // Who names a plain fact about a thing wants that rather than what is tidy.
                    GoalFact::Plain(fact) if rule.time == RuleTime::Tidy => {
                        waivers.push(Waiver {
                            rule: number,
                            entity: fact.argument(0),
                        });
                    }
                    _ => {}
                }
            }
        }
        waivers
    }

    /// What a plan for this goal is for: its parts, in order, and the rules it sets aside.
    pub fn purpose(&self, domain: &Domain) -> Purpose {
        Purpose {
            wanted: self.facts.iter().map(|fact| fact.wanted(domain, &self.facts)).collect(),
            waivers: self.waivers(domain),
            from_goal: true,
            ..Purpose::default()
        }
    }

    /// Whether it depends on anything that sensing tells, so that a plan for it may have to look first.
    pub fn depends_on_sensing(&self, domain: &Domain) -> bool {
        self.facts.iter().any(|fact| match fact {
            GoalFact::If(_) => true,
            GoalFact::Plain(fact) => domain.is_sensed(fact.predicate()),
            GoalFact::Word { word, .. } => {
                let mut sensed = false;
                let condition = &domain.goal_word(*word).condition;
                condition.for_each_atom(&mut |atom, _| sensed |= domain.is_sensed(atom.predicate));
                sensed
            }
        })
    }

    /// Everything that must hold at the end, the domain's rules included: what search is given.
    pub fn wanted(&self, domain: &Domain) -> Vec<Wanted> {
        let Purpose {
            mut wanted, waivers, ..
        } = self.purpose(domain);
        wanted.extend(wanted_at_end(domain, &waivers, true));
        wanted
    }
}
