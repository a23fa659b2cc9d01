//! Goals, written in the typed goal words of a domain.
//!
//! A [`Goal`] is written `put(cup, shelf) & closed(door)`. [`parse`] reads one, search achieves it, and verification
//! checks a plan against [`Goal::purpose`].

mod conditional;
mod constraint;
mod language;
mod partial_answer;
mod stages;
#[cfg(test)]
mod tests;

pub use conditional::Conditional;
pub use conditional::{AND, ELSE, IF, NOT, THEN, WrittenConditional};
pub use constraint::{ALWAYS, Constraint, NEVER};
pub use language::{GoalError, JOINT, QUESTION, STAGE, parse, read_form, rules};
pub use partial_answer::{Begun, Next, ended};

use crate::model::{
    Condition, Domain, EntityId, Fact, FormPiece, GoalWordId, RuleTime, Voice, Wanted, World, written_fact,
};
use crate::verify::{Purpose, Waiver};

/// One part of a goal.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub enum GoalFact {
    /// A goal word of the domain with its arguments.
    Word {
        /// The word.
        word: GoalWordId,
        /// One entity for each parameter.
        arguments: Vec<EntityId>,
    },
    /// A fact, written with a state word of the environment.
    Plain(Fact),
    /// Goals that depend on the outcome of sensing.
    If(Conditional),
}

/// A goal: what a plan achieves, in which order, and what it must not do on the way.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
#[non_exhaustive]
pub struct Goal {
    /// The goals, in the order of their stages.
    pub facts: Vec<GoalFact>,
    /// The index in `facts` of the first goal of each stage after the first one, ascending; empty without an order.
    pub stages: Vec<usize>,
    /// The constraints on the whole plan.
    pub constraints: Vec<Constraint>,
}

impl From<Vec<GoalFact>> for Goal {
    /// Creates the goal that all facts hold at the end.
    fn from(facts: Vec<GoalFact>) -> Self {
        Self {
            facts,
            ..Self::default()
        }
    }
}

impl GoalFact {
    /// Writes the fact in the goal language; `name` gives the name of each entity.
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

    /// Returns the goals without conditions that it consists of: itself, or the goals of both branches.
    pub fn parts(&self) -> Vec<&GoalFact> {
        match self {
            Self::If(conditional) => {
                let sides = conditional.then.iter().chain(&conditional.otherwise);
                sides.flat_map(GoalFact::parts).collect()
            }
            _ => vec![self],
        }
    }

    /// Writes the goal with everyday names: `put(pie, oven)`.
    pub fn everyday(&self, world: &World) -> String {
        let domain = world.domain();
        self.written(domain, &|entity| world.entity(entity).name.clone())
    }

    /// Writes the goal with the environment's identifiers: `put(<pie_320>, <microwave_314>)`.
    pub fn exact(&self, world: &World) -> String {
        let domain = world.domain();
        self.written(domain, &|entity| world.entity(entity).identifier.clone())
    }

    /// Writes the goal as a sentence for a person.
    pub fn sentence(&self, world: &World) -> String {
        self.sentence_in(Voice::Person, world)
    }

    /// Writes the goal as a sentence for a person or a model.
    pub fn sentence_in(&self, voice: Voice, world: &World) -> String {
        let domain = world.domain();
        match self {
            Self::Word { word, arguments } => {
                let name = |parameter: usize| voice.name(world, arguments[parameter]);
                domain.goal_word(*word).says.fill(name)
            }
            Self::Plain(fact) => voice.fact(world, *fact, true),
            Self::If(conditional) => conditional.sentence(voice, world),
        }
    }

    /// Maps the goal to another world by identifiers; none if an entity is missing there.
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

    /// Returns the entity that the goal is about, if it has one: the subject of the goal word, or the first argument of
    /// the fact.
    pub fn subject(&self, domain: &Domain) -> Option<EntityId> {
        match self {
            Self::Word { word, arguments } => domain.goal_word(*word).subject.map(|parameter| arguments[parameter]),
            Self::Plain(fact) => domain.arguments(*fact).next(),
            Self::If(conditional) => domain.arguments(conditional.condition).next(),
        }
    }

    /// Returns all entities in the goal, in order.
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

    /// Returns the condition to achieve, with `all` as the goals that it belongs to.
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
    /// Maps the goal to another world by identifiers, for example from a restricted world ([`World::narrowed`]) to the
    /// whole one. None if an entity is missing there.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Goal> {
        let facts = self.facts.iter().map(|fact| fact.carried(domain, from, to));
        let constraints = self.constraints.iter().map(|own| own.carried(domain, from, to));
        Some(Goal {
            facts: facts.collect::<Option<Vec<_>>>()?,
            stages: self.stages.clone(),
            constraints: constraints.collect::<Option<Vec<_>>>()?,
        })
    }

    /// Adds a goal to the last stage, unless the stage has it.
    fn push(&mut self, fact: GoalFact) {
        let start = self.stages.last().copied().unwrap_or(0);
        if !self.facts[start..].contains(&fact) {
            self.facts.push(fact);
        }
    }

    /// Returns true if the goal requires nothing.
    pub fn is_empty(&self) -> bool {
        self.facts.is_empty() && self.constraints.is_empty()
    }

    /// Writes the parts of the goal with everyday names. Joined with ` & ` they are the goal in the goal language.
    pub fn everyday(&self, world: &World) -> Vec<String> {
        self.written(|fact| fact.everyday(world), |constraint| constraint.everyday(world))
    }

    /// Writes the parts of the goal with the environment's identifiers.
    pub fn exact(&self, world: &World) -> Vec<String> {
        self.written(|fact| fact.exact(world), |constraint| constraint.exact(world))
    }

    /// Writes the parts of the goal as sentences for a person.
    pub fn sentences(&self, world: &World) -> Vec<String> {
        self.written(|fact| fact.sentence(world), |constraint| constraint.sentence(world))
    }

    fn written(&self, fact: impl Fn(&GoalFact) -> String, constraint: impl Fn(&Constraint) -> String) -> Vec<String> {
        let stage = |(index, own): (usize, &GoalFact)| match self.stages.contains(&index) {
            true => format!("{STAGE}{}", fact(own)),
            false => fact(own),
        };
        let facts = self.facts.iter().enumerate().map(stage);
        facts.chain(self.constraints.iter().map(constraint)).collect()
    }

    /// Returns the rules that the goal waives: a goal that the fridge is open waives the rule that it is closed.
    fn waivers(&self, domain: &Domain) -> Vec<Waiver> {
        let mut waivers = Vec::new();
        let always = self.constraints.iter().filter_map(|constraint| match constraint {
            Constraint::State { fact, holds: true } => Some(fact),
            _ => None,
        });
        for fact in self.facts.iter().chain(always).flat_map(GoalFact::parts) {
            for (number, rule) in domain.rules.iter().enumerate() {
                match fact {
                    GoalFact::Word { word, arguments } if rule.unless.contains(&domain.goal_word(*word).word) => {
                        waivers.extend(arguments.iter().map(|entity| Waiver {
                            rule: number,
                            entity: *entity,
                        }));
                    }
                    // A goal stated as a fact takes precedence over tidiness.
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

    /// Returns the purpose of a plan for this goal: its conditions by goal, its stages, constraints and waivers.
    pub fn purpose(&self, world: &World) -> Purpose {
        let domain = world.domain();
        let all: Vec<Wanted> = self.facts.iter().map(|fact| fact.wanted(domain, &self.facts)).collect();
        let stages = match self.stages.is_empty() {
            true => Vec::new(),
            false => self.milestones(world, &all),
        };
        let nothing = || Wanted {
            condition: Condition::TRUE,
            bindings: Vec::new(),
        };
        let kept = self.kept(world).into_iter().zip(all);
        let constraints = self.constraints.iter();
        Purpose {
            wanted: kept
                .map(|(kept, wanted)| if kept { wanted } else { nothing() })
                .collect(),
            stages,
            prohibitions: constraints.map(|constraint| constraint.prohibition(world)).collect(),
            waivers: self.waivers(domain),
            from_goal: true,
            ..Purpose::default()
        }
    }

    /// Returns true if the goal depends on a sensed fact, so that its plan may need sensing actions.
    pub fn depends_on_sensing(&self, domain: &Domain) -> bool {
        self.facts.iter().any(|fact| match fact {
            GoalFact::If(_) => true,
            GoalFact::Plain(fact) => domain.is_sensed(fact.predicate()),
            GoalFact::Word { word, .. } => {
                let mut atoms = domain.goal_word(*word).condition.atoms();
                atoms.any(|(atom, _)| domain.is_sensed(atom.predicate))
            }
        })
    }
}
