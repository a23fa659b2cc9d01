//! Goals, written in the typed goal words of a domain.
//!
//! A [`Goal`] is written `put(cup, shelf) & closed(door)`. [`parse`] reads one, search achieves it, and verification
//! checks a plan against [`Goal::purpose`].

mod bounds;
mod choice;
mod comparison;
#[cfg(test)]
mod comparison_tests;
mod conditional;
mod constraint;
mod error;
mod exclusion;
#[cfg(test)]
mod exclusion_tests;
mod expansion;
mod fact;
mod group;
#[cfg(test)]
mod group_tests;
mod invariant;
mod language;
mod names;
mod partial_answer;
mod purpose_file;
mod relative;
mod stages;
#[cfg(test)]
mod tests;

pub use choice::Choice;
pub use comparison::{NumberGoal, Operand};
pub use conditional::{AND, Conditional, ELSE, IF, NOT, THEN, WrittenConditional};
pub use constraint::{ALWAYS, Constraint, NEVER, UNTIL};
pub use error::GoalError;
pub use group::{Group, Quantifier};
pub use language::{JOINT, QUESTION, STAGE, parse, rules};
pub use names::read_form;
pub use partial_answer::{Begun, Next, ended};
pub use purpose_file::with_purpose;
pub use relative::add_values;

use expansion::Expansion;

use longstep_model::model::{
    Atom, Condition, Domain, EntityId, Fact, FormPiece, GoalWordId, PredicateId, RuleTime, Term, Voice, Wanted, When,
    World, written_fact,
};
use longstep_verify::message::GoalSentences;
use longstep_verify::verify::{Purpose, Waiver};

/// One part of a goal.
///
/// Exhaustive on purpose: code that does not know a new kind of goal would be wrong.
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
    /// A comparison of numbers.
    Number(NumberGoal),
    /// Goals that depend on the outcome of sensing.
    If(Conditional),
    /// A goal for some members of a group.
    Choice(Choice),
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
    /// The parts that were written with groups, for display and for another world ([`Goal::carried`]).
    pub groups: Vec<GroupedPart>,
}

/// A part of a goal that was written with groups.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct GroupedPart {
    /// The part as it was written.
    pub text: String,
    /// The groups with their members.
    pub groups: Vec<Group>,
    /// The number of the stage, from 0.
    stage: usize,
    /// The goals that it stands for.
    pub facts: Vec<GoalFact>,
    /// The constraints that it stands for.
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
    /// Returns true if the part has a condition.
    pub fn is_conditional(&self) -> bool {
        matches!(self, Self::If(_))
    }

    /// Writes the fact in the goal language; `name` gives the name of each entity.
    fn written(&self, domain: &Domain, name: &dyn Fn(EntityId) -> String) -> String {
        match self {
            Self::Word { word, arguments } => {
                let pieces = domain.goal_word(*word).form.iter();
                let pieces = pieces.map(|piece| match piece {
                    FormPiece::Text(text) => text.clone(),
                    FormPiece::Parameter(index) => name(arguments[*index]),
                });
                pieces.collect()
            }
            Self::Plain(fact) => written_fact(domain, *fact, name),
            Self::Number(comparison) => comparison.written(domain, name),
            Self::If(conditional) => conditional.written(domain, name),
            Self::Choice(choice) => choice.written(domain, name),
        }
    }

    /// Returns true if sensing reveals whether a goal without conditions and groups holds.
    fn is_sensed(&self, domain: &Domain) -> bool {
        match self {
            Self::If(_) | Self::Choice(_) | Self::Number(_) => false,
            Self::Plain(fact) => domain.is_sensed(fact.predicate()),
            Self::Word { word, .. } => {
                let mut atoms = domain.goal_word(*word).condition.atoms();
                atoms.any(|(atom, _)| domain.is_sensed(atom.predicate))
            }
        }
    }

    /// Returns the goals without conditions and groups that it consists of.
    fn leaves(&self) -> Vec<&GoalFact> {
        let mut leaves = Vec::new();
        for part in self.parts() {
            match part {
                Self::Choice(choice) => leaves.extend(choice.alternatives()),
                _ => leaves.push(part),
            }
        }
        leaves
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
        self.sentence_with(voice, world, &|entity| voice.name(world, entity))
    }

    /// Writes the goal as what a person asks for, after "Should I": `put the pen on the shelf`; none if the domain has no words for it.
    fn asked(&self, world: &World) -> Option<String> {
        let Self::Word { word, arguments } = self else {
            return None;
        };
        let asks = world.domain().goal_word(*word).asks.as_ref()?;
        Some(asks.fill(|parameter| Voice::Person.name(world, arguments[parameter])))
    }

    /// Writes the goal as a sentence; `name` gives the name of each entity.
    fn sentence_with(&self, voice: Voice, world: &World, name: &dyn Fn(EntityId) -> String) -> String {
        let domain = world.domain();
        match self {
            Self::Word { word, arguments } => domain
                .goal_word(*word)
                .says
                .fill(|parameter| name(arguments[parameter])),
            Self::Plain(fact) => {
                let says = &domain.words(fact.predicate()).says;
                says.fill(|place| name(fact.argument(place)))
            }
            Self::Number(comparison) => comparison.sentence(voice, world),
            Self::If(conditional) => conditional.sentence(voice, world),
            Self::Choice(choice) => choice.sentence(voice, world),
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
            Self::Number(comparison) => Self::Number(comparison.carried(domain, there)?),
            Self::If(conditional) => Self::If(conditional.carried(domain, from, to)?),
            Self::Choice(choice) => Self::Choice(choice.carried(domain, from, to)?),
        })
    }

    /// Returns true if the goal is this goal word with these arguments.
    pub fn is_word(&self, word: GoalWordId, arguments: &[EntityId]) -> bool {
        matches!(self, Self::Word { word: own, arguments: with } if *own == word && with == arguments)
    }

    /// Returns the entity that the goal is about, if it has one: the subject of the goal word, or the first argument of
    /// the fact.
    pub fn subject(&self, domain: &Domain) -> Option<EntityId> {
        match self {
            Self::Word { word, arguments } => domain.goal_word(*word).subject.map(|parameter| arguments[parameter]),
            Self::Plain(fact) => domain.arguments(*fact).next(),
            Self::Number(comparison) => domain.arguments_of(comparison.fluent).next(),
            Self::If(conditional) => domain.arguments(conditional.condition).next(),
            Self::Choice(choice) => choice.subject(domain),
        }
    }

    /// Returns true if achieving the goal may move the entity: it is the subject, or an argument that the goal word disturbs.
    /// A goal word without a subject is about all its arguments. A choice may move what one of its alternatives may move.
    fn may_move(&self, domain: &Domain, entity: EntityId) -> bool {
        let is_subject = self.subject(domain) == Some(entity);
        match self {
            Self::Choice(choice) => choice.alternatives().any(|goal| goal.may_move(domain, entity)),
            Self::Word { word, arguments } if domain.goal_word(*word).subject.is_none() => arguments.contains(&entity),
            Self::Word { word, arguments } => {
                let mut disturbed = domain.goal_word(*word).disturbs.iter();
                is_subject || disturbed.any(|parameter| arguments[*parameter] == entity)
            }
            Self::Plain(_) | Self::Number(_) | Self::If(_) => is_subject,
        }
    }

    /// Returns all entities in the goal, in order.
    pub fn about(&self, domain: &Domain) -> Vec<EntityId> {
        match self {
            Self::Word { arguments, .. } => arguments.clone(),
            Self::Plain(fact) => domain.arguments(*fact).collect(),
            Self::Number(comparison) => comparison.about(domain),
            Self::If(conditional) => {
                let condition = domain.arguments(conditional.condition);
                let parts = self.parts();
                condition
                    .chain(parts.into_iter().flat_map(|part| part.about(domain)))
                    .collect()
            }
            Self::Choice(choice) => choice.about(domain),
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
            Self::Number(comparison) => comparison.wanted(domain),
            Self::If(conditional) => conditional.wanted(domain, all),
            Self::Choice(choice) => choice.wanted(domain),
        }
    }
}

impl GoalSentences for Goal {
    fn goal_sentence(&self, index: usize, voice: Voice, world: &World) -> Option<String> {
        Some(self.facts.get(index)?.sentence_in(voice, world))
    }
}

impl Goal {
    /// Returns the goal as the words for violations ([`Violation::message`](longstep_verify::plan::Violation::message)).
    pub fn as_sentences(&self) -> &dyn GoalSentences {
        self
    }

    /// Maps the goal to another world by identifiers, for example from a restricted world ([`World::narrowed`]) to the
    /// whole one. Groups are read again there, since the other world may have more members. None if an entity is missing
    /// there.
    pub fn carried(&self, domain: &Domain, from: &World, to: &World) -> Option<Goal> {
        let mut goal = Goal::default();
        for (stage, range) in self.ranges().enumerate() {
            if stage > 0 {
                goal.begin_stage();
            }
            for fact in &self.facts[range] {
                let stands_for = |part: &&GroupedPart| part.stage == stage && part.facts.contains(fact);
                match self.groups.iter().find(stands_for) {
                    // The other world may have more members, so the text is read again.
                    Some(part) => goal.add(&part.text, language::part(to, &part.text).ok()?),
                    None => goal.push(fact.carried(domain, from, to)?),
                }
            }
        }
        for constraint in &self.constraints {
            match self.groups.iter().find(|part| part.constraints.contains(constraint)) {
                Some(part) => goal.add(&part.text, language::part(to, &part.text).ok()?),
                None => goal.constrain(constraint.carried(domain, from, to)?),
            }
        }
        goal.end_stages();
        Some(goal)
    }

    /// Returns the part with groups from which a goal comes, if it comes from one.
    pub fn grouped_part(&self, fact: &GoalFact) -> Option<&GroupedPart> {
        self.groups.iter().find(|part| part.facts.contains(fact))
    }

    /// Iterates over the choices among the goals, those in the branches of conditional goals included.
    pub fn choices(&self) -> impl Iterator<Item = &Choice> {
        let parts = self.facts.iter().flat_map(GoalFact::parts);
        parts.filter_map(|part| match part {
            GoalFact::Choice(choice) => Some(choice),
            _ => None,
        })
    }

    /// Begins a stage, unless nothing has been added since the last one began.
    fn begin_stage(&mut self) {
        if self.stages.last().copied().unwrap_or(0) < self.facts.len() {
            self.stages.push(self.facts.len());
        }
    }

    /// Removes a last stage without goals, as a constraint after the last "then" leaves it.
    fn end_stages(&mut self) {
        self.stages.retain(|start| *start < self.facts.len());
    }

    /// Adds a part of a goal to the last stage; `text` is the part as it was written.
    fn add(&mut self, text: &str, part: Expansion) {
        let Expansion {
            facts,
            constraints,
            groups,
        } = part;
        let stage = self.stages.len();
        let known = |part: &GroupedPart| part.text == text && part.stage == stage;
        if !groups.is_empty() && !self.groups.iter().any(known) {
            self.groups.push(GroupedPart {
                text: text.to_owned(),
                groups,
                stage,
                facts: facts.clone(),
                constraints: constraints.clone(),
            });
        }
        facts.into_iter().for_each(|fact| self.push(fact));
        constraints.into_iter().for_each(|own| self.constrain(own));
    }

    /// Adds a constraint, unless the goal has it.
    fn constrain(&mut self, constraint: Constraint) {
        if !self.constraints.contains(&constraint) {
            self.constraints.push(constraint);
        }
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

    /// Returns true if a part of the goal has a condition.
    pub fn depends(&self) -> bool {
        self.facts.iter().any(GoalFact::is_conditional)
    }

    /// Writes the question whether this goal is meant.
    pub fn question(&self, world: &World) -> String {
        let asked: Option<Vec<String>> = self.facts.iter().map(|fact| fact.asked(world)).collect();
        match asked.filter(|asked| !asked.is_empty() && self.stages.is_empty() && self.constraints.is_empty()) {
            Some(asked) => format!("Should I {}?", asked.join(" and ")),
            None => format!("Do you mean: {}?", self.sentences(world).join("; ")),
        }
    }

    /// Writes the goal in the goal language, with everyday names: groups as they were written, stages with `then`, constraints last.
    pub fn text(&self, world: &World) -> String {
        let mut stages: Vec<String> = Vec::new();
        for (stage, range) in self.ranges().enumerate() {
            let mut parts: Vec<String> = Vec::new();
            for fact in &self.facts[range] {
                let stands_for = |part: &&GroupedPart| part.stage == stage && part.facts.contains(fact);
                let text = match self.groups.iter().find(stands_for) {
                    Some(part) => part.text.clone(),
                    None => fact.everyday(world),
                };
                if !parts.contains(&text) {
                    parts.push(text);
                }
            }
            stages.push(parts.join(" & "));
        }
        stages.retain(|stage| !stage.is_empty());
        let mut texts = vec![stages.join(" then ")];
        texts.retain(|text| !text.is_empty());
        for constraint in &self.constraints {
            let text = match self.groups.iter().find(|part| part.constraints.contains(constraint)) {
                Some(part) => part.text.clone(),
                None => constraint.everyday(world),
            };
            if !texts.contains(&text) {
                texts.push(text);
            }
        }
        texts.join(" & ")
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
        let word = |index: usize| if self.stages.contains(&index) { STAGE } else { "" };
        let facts = self.facts.iter().enumerate();
        let facts = facts.map(|(index, own)| format!("{}{}", word(index), fact(own)));
        facts.chain(self.constraints.iter().map(constraint)).collect()
    }

    /// Returns the rules that the goal waives: a goal that the fridge is open waives the rule that it is closed.
    fn waivers(&self, domain: &Domain) -> Vec<Waiver> {
        let mut waivers = Vec::new();
        // A rule that something always holds contradicts tidiness as a goal does.
        let always = self.constraints.iter().filter_map(|constraint| match constraint {
            Constraint::State { fact, holds: true } => Some(fact),
            _ => None,
        });
        for fact in self.facts.iter().chain(always).flat_map(GoalFact::leaves) {
            for (number, rule) in domain.rules.iter().enumerate() {
                match fact {
                    GoalFact::Word { word, arguments } if rule.unless.contains(&domain.goal_word(*word).word) => {
                        // Not for the other arguments: a blanket in the cabinet says nothing about the pills there.
                        let subject = domain.goal_word(*word).subject.and_then(|place| arguments.get(place));
                        let about = subject.map_or(&arguments[..], std::slice::from_ref);
                        waivers.extend(about.iter().map(|entity| Waiver {
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
        let stages = if self.stages.is_empty() {
            Vec::new()
        } else {
            self.milestones(world, &all)
        };
        let mut wanted = all;
        for (kept, wanted) in self.kept(world).into_iter().zip(&mut wanted) {
            if !kept {
                // In place of a goal that need not last, so that conditions keep the indices of their goals.
                *wanted = Wanted {
                    condition: Condition::TRUE,
                    bindings: Vec::new(),
                };
            }
        }
        let constraints = self.constraints.iter();
        Purpose {
            wanted,
            stages,
            prohibitions: constraints.map(|constraint| constraint.prohibition(world)).collect(),
            waivers: self.waivers(domain),
            from_goal: true,
            ..Purpose::default()
        }
    }

    /// Returns true if the goal depends on a sensed fact, so that its plan may need sensing actions.
    pub fn depends_on_sensing(&self, domain: &Domain) -> bool {
        let mut leaves = self.facts.iter().flat_map(GoalFact::leaves);
        self.facts.iter().any(GoalFact::is_conditional) || leaves.any(|leaf| leaf.is_sensed(domain))
    }
}

/// Returns the condition that an atom has a truth value at a time.
fn literal(predicate: PredicateId, terms: &[Term], holds: bool, at: When) -> Condition {
    let terms = terms.to_vec();
    Condition::Atom {
        atom: Atom { predicate, terms },
        holds,
        at,
    }
}
