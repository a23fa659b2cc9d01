//! Observations: the statements of a robot about the entities that it saw, and the state that they imply.

use indexmap::IndexMap;
use rustc_hash::FxHashSet;
use serde::{Deserialize, Serialize};

use super::statement::{Statement, fact_alone, is_stated, number_of, statement};
use super::{EntityId, Fact, Fluent, Number, State, Words, World, fact_of};
use crate::call::Call;
use crate::model::{
    Atom, Bindings, Condition, Domain, PredicateId, Rule, RuleTime, StateVariable, When, broken_bindings, entries_of,
    entry_of_number, ground, state_word, subject_of,
};

/// An observation of the world, in the words of an environment file, as a robot writes it.
///
/// An entity that is listed is described fully: a statement that its entry lacks does not hold. An entity that is not
/// listed was not seen, and nothing is known about it. Facts that environments have no words for are observed only of the
/// predicates that the robot reports.
///
/// ```
/// use longstep_model::environment::Observation;
/// let text = r#"{"states":{"<cup>":"on_something(<shelf>)","<fridge_handle>":["closed()"],"<spoon>":[]}}"#;
/// let observation: Observation = serde_json::from_str(text)?;
/// assert_eq!(observation.of_entity("<cup>"), Some(&["on_something(<shelf>)".to_owned()][..]));
/// assert_eq!(observation.of_entity("<spoon>"), Some(&[][..]));
/// assert_eq!(observation.of_entity("<plate>"), None);
/// assert_eq!(serde_json::to_string(&observation)?, text);
/// # Ok::<(), serde_json::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Observation {
    /// The states of each entity that was seen, by identifier, as in an environment file.
    #[serde(default)]
    pub states: IndexMap<String, Words>,
    /// Observation without a subject, as `facts` of an environment, and all facts of the reported predicates:
    /// `hand-at(<cup>)`. None if they were not observed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub facts: Option<Vec<String>>,
}

impl Observation {
    /// Returns the statements about an entity; none if it was not seen.
    pub fn of_entity(&self, entity: &str) -> Option<&[String]> {
        self.states.get(entity).map(Words::as_slice)
    }
}

/// Maximum number of statements in an observation; a world has at most 60,000 entities.
const MOST: usize = 200_000;

/// The facts and numbers that an observation shows in a world.
///
/// An entity that is listed is described fully: a state that is not stated of it does not hold. An entity that is not
/// listed was not seen, and nothing is known about it. Predicates without a state word, such as the position of a hand,
/// are observed only by robots that report them: then [`Observation::facts`] lists all their facts.
///
/// ```
/// use longstep_model::{domain, environment::{self, ObservedFacts, Observation}};
/// let household = domain::shipped("household").unwrap().unwrap();
/// let text = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>"], "object_states": {"<cup>": "on_something(<table>)"}}"#;
/// let world = environment::parse(&household, "env.json", text).unwrap();
/// let seen: Observation = serde_json::from_str(r#"{"states": {"<cup>": "on_something(<shelf>)"}}"#).unwrap();
/// let seen = ObservedFacts::read(&world, &[], &seen).unwrap();
/// let state = seen.revised(&world, &world.state);
/// let cup = world.find("<cup>").unwrap();
/// let on = |place| environment::fact_of(&world, cup, &format!("on_something({place})")).unwrap();
/// assert!(state.holds(on("<shelf>")) && !state.holds(on("<table>")));
/// ```
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ObservedFacts {
    seen: Vec<EntityId>,
    facts: FxHashSet<Fact>,
    numbers: Vec<(Fluent, Number)>,
    /// The predicates of which every fact is known; empty if the observation does not list them.
    complete: Vec<PredicateId>,
    /// True if the statements without a subject are listed.
    lists_facts: bool,
    /// Identifiers that the world does not have, sorted.
    pub unknown: Vec<String>,
}

/// A statement that cannot be read in the world.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum ObservationError {
    /// A text that is no state of the domain, or names an entity that the environment does not list.
    #[error(
        "the observation of `{subject}` has `{text}`, which is no state of this domain with entities of this environment"
    )]
    Unreadable {
        /// The subject, or `facts`.
        subject: String,
        /// The statement.
        text: String,
    },
    /// More statements than a world can have.
    #[error("the observation has more than {MOST} statements")]
    TooMany,
}

impl ObservedFacts {
    /// Returns the predicates that a robot may report in [`Observation::facts`]: those that steps change and for which
    /// environments have no words, such as the position of a hand.
    pub fn reportable(domain: &Domain) -> Vec<PredicateId> {
        let is_reportable = |predicate: &PredicateId| {
            domain.words(*predicate).fluent
                && state_word(domain, *predicate).is_none()
                && !domain.is_sensed(*predicate)
                && !domain.predicate(*predicate).parameters.is_empty()
        };
        let all = (0..domain.predicates.len()).map(PredicateId::new);
        all.filter(is_reportable).collect()
    }

    /// Reads the statements of a robot that reports these predicates in [`Observation::facts`], besides the states of entities.
    ///
    /// # Errors
    ///
    /// The first statement that cannot be read. Subjects that the world does not have are no error: a camera may see
    /// more than the environment lists.
    pub fn read(world: &World, reports: &[PredicateId], statements: &Observation) -> Result<Self, ObservationError> {
        let texts = statements.states.values().map(|words| words.as_slice().len());
        if texts.sum::<usize>() + statements.facts.as_ref().map_or(0, Vec::len) > MOST {
            return Err(ObservationError::TooMany);
        }
        let unreadable = |subject: &str, text: &str| ObservationError::Unreadable {
            subject: subject.chars().take(80).collect(),
            text: text.chars().take(80).collect(),
        };
        let mut observation = Self::default();
        if let Some(facts) = &statements.facts {
            observation.lists_facts = true;
            observation.complete = reports.to_vec();
            for text in facts {
                match alone(world, reports, text).ok_or_else(|| unreadable("facts", text))? {
                    Statement::Fact(fact) => {
                        observation.facts.insert(fact);
                    }
                    Statement::Number(fluent, number) => observation.numbers.push((fluent, number)),
                }
            }
        }
        for (identifier, words) in &statements.states {
            let Some(subject) = world.find(identifier) else {
                observation.unknown.push(identifier.clone());
                continue;
            };
            observation.seen.push(subject);
            for text in words.as_slice() {
                if let Some(number) = number_of(world, Some(subject), text) {
                    observation.numbers.push(number);
                } else if let Some(fact) = fact_of(world, subject, text) {
                    observation.facts.insert(fact);
                } else {
                    return Err(unreadable(identifier, text));
                }
            }
        }
        observation.seen.sort_unstable();
        observation.unknown.sort_unstable();
        Ok(observation)
    }

    /// Returns the statements of a state about these entities, with the facts of the reported predicates.
    pub fn statements(world: &World, state: &State, entities: &[EntityId], reports: &[PredicateId]) -> Observation {
        let domain = world.domain();
        let mut by_entity: IndexMap<EntityId, Vec<String>> =
            entities.iter().map(|entity| (*entity, Vec::new())).collect();
        let changing = state.iter().filter(|fact| domain.words(fact.predicate()).fluent);
        for (subject, text) in changing.flat_map(|fact| entries_of(world, fact)) {
            if let Some(texts) = by_entity.get_mut(&subject) {
                texts.push(text);
            }
        }
        let mut alone = Vec::new();
        for (fluent, number) in state.numbers() {
            match entry_of_number(world, *fluent, *number) {
                (Some(subject), text) => by_entity.entry(subject).and_modify(|texts| texts.push(text)),
                (None, text) => {
                    alone.push(text);
                    continue;
                }
            };
        }
        let reported = state
            .iter()
            .filter(|fact| reports.contains(&fact.predicate()) || is_stated(domain, fact.predicate()));
        for fact in reported {
            let arguments = domain
                .arguments(fact)
                .map(|entity| world.entity(entity).identifier.clone());
            let call = Call {
                name: domain.predicate(fact.predicate()).name.clone(),
                arguments: arguments.collect(),
            };
            alone.push(call.to_string());
        }
        let states = by_entity
            .into_iter()
            .map(|(entity, texts)| (world.entity(entity).identifier.clone(), Words::Many(texts)));
        Observation {
            states: states.collect(),
            facts: (!alone.is_empty() || !reports.is_empty()).then_some(alone),
        }
    }

    /// Returns true if the observation decides whether the fact holds.
    pub fn decides(&self, world: &World, fact: Fact) -> bool {
        let domain = world.domain();
        if !domain.words(fact.predicate()).fluent {
            return false;
        }
        if self.facts.contains(&fact) {
            return true;
        }
        // What sensing would reveal is not visible.
        if domain.is_sensed(fact.predicate()) {
            return false;
        }
        let alone = self.lists_facts && is_stated(domain, fact.predicate());
        alone
            || self.complete.contains(&fact.predicate())
            || entries_of(world, fact).any(|(subject, _)| self.seen.binary_search(&subject).is_ok())
    }

    /// Returns true if the observation states the fact.
    pub fn states(&self, fact: Fact) -> bool {
        self.facts.contains(&fact)
    }

    /// Returns the number of a fluent that the observation states; none if it does not state it.
    pub fn number(&self, fluent: Fluent) -> Option<Number> {
        let mut stated = self.numbers.iter().rev();
        stated.find(|(own, _)| *own == fluent).map(|(_, number)| *number)
    }

    /// Returns true if the observation decides the fact, or states the number.
    pub fn shows(&self, world: &World, variable: StateVariable) -> bool {
        match variable {
            StateVariable::Fact(fact) => self.decides(world, fact),
            StateVariable::Number(fluent) => self.number(fluent).is_some(),
        }
    }

    /// Returns true if some observation of a robot that reports these predicates can show the fact or the number.
    pub fn can_show(world: &World, reports: &[PredicateId], variable: StateVariable) -> bool {
        let domain = world.domain();
        match variable {
            StateVariable::Number(fluent) => domain.function(fluent.function()).changes,
            StateVariable::Fact(fact) => {
                let predicate = fact.predicate();
                let has_words = is_stated(domain, predicate) || state_word(domain, predicate).is_some();
                domain.words(predicate).fluent
                    && !domain.is_sensed(predicate)
                    && (has_words || reports.contains(&predicate))
            }
        }
    }

    /// Returns what this observation and a newer one show together; the newer one decides what both show.
    #[must_use]
    pub fn updated(self, world: &World, newer: Self) -> Self {
        let mut both = newer.clone();
        both.facts
            .extend(self.facts.into_iter().filter(|fact| !newer.decides(world, *fact)));
        let numbers = self.numbers.into_iter();
        let older: Vec<(Fluent, Number)> = numbers.filter(|(own, _)| newer.number(*own).is_none()).collect();
        both.numbers = older.into_iter().chain(newer.numbers).collect();
        both.seen.extend(self.seen);
        both.complete.extend(self.complete);
        both.unknown.extend(self.unknown);
        both.seen.sort_unstable();
        both.seen.dedup();
        both.complete.sort_unstable();
        both.complete.dedup();
        both.unknown.sort_unstable();
        both.unknown.dedup();
        both.lists_facts |= self.lists_facts;
        both
    }

    /// The entities that the observation lists, sorted.
    pub fn entities(&self) -> &[EntityId] {
        &self.seen
    }

    /// The predicates of which the observation lists every fact.
    pub fn predicates(&self) -> &[PredicateId] {
        &self.complete
    }

    /// Returns true if the observation lists the facts without a subject.
    pub fn lists_facts(&self) -> bool {
        self.lists_facts
    }

    /// Returns true if the fact is listed without a subject.
    pub fn is_without_subject(domain: &Domain, fact: Fact) -> bool {
        is_stated(domain, fact.predicate())
    }

    /// Iterates over the facts that are stated, in no order.
    pub fn facts(&self) -> impl Iterator<Item = Fact> + '_ {
        self.facts.iter().copied()
    }

    /// Iterates over the numbers that are stated.
    pub fn numbers(&self) -> impl Iterator<Item = (Fluent, Number)> + '_ {
        self.numbers.iter().copied()
    }

    /// Returns true if two observations list the same entities, facts without a subject, and numbers.
    pub fn lists_as(&self, other: &Self) -> bool {
        let numbers = |own: &Self| {
            let mut all: Vec<Fluent> = own.numbers.iter().map(|(fluent, _)| *fluent).collect();
            all.sort_unstable();
            all
        };
        self.seen == other.seen && self.lists_facts == other.lists_facts && numbers(self) == numbers(other)
    }

    /// Returns the state that the observation implies, given the state that was believed before it.
    ///
    /// Facts that the observation does not decide stay as they were, unless they contradict an observed one by a rule
    /// with the time `start`: what is seen on the table is not in the hand.
    #[must_use]
    pub fn revised(&self, world: &World, believed: &State) -> State {
        self.revised_but(world, believed, &FxHashSet::default())
    }

    /// Revises a state as [`ObservedFacts::revised`] does, but leaves some facts and numbers as they were: those that steps
    /// are changing at this moment.
    pub fn revised_but(&self, world: &World, believed: &State, masked: &FxHashSet<StateVariable>) -> State {
        let is_masked = |fact: &Fact| masked.contains(&StateVariable::Fact(*fact));
        let domain = world.domain();
        let mut state = believed.clone();
        let mut changed = false;
        let gone: Vec<Fact> = believed
            .iter()
            .filter(|fact| !self.facts.contains(fact) && !is_masked(fact) && self.decides(world, *fact))
            .collect();
        for fact in &gone {
            changed |= state.set(*fact, false);
        }
        for fact in self.unseen(world, believed, &gone, masked) {
            state.set(fact, false);
        }
        let is_fluent = |fact: &&Fact| domain.words(fact.predicate()).fluent && !is_masked(fact);
        for fact in self.facts.iter().filter(is_fluent) {
            for outcome in domain.outcomes(*fact) {
                changed |= outcome != *fact && state.set(outcome, false);
            }
            changed |= state.set(*fact, true);
        }
        for (fluent, number) in &self.numbers {
            let is_free = !masked.contains(&StateVariable::Number(*fluent));
            if domain.function(fluent.function()).changes && is_free {
                state.set_number(*fluent, *number);
            }
        }
        if changed {
            self.settle(world, &mut state);
        }
        state
    }

    /// Returns the facts without a state word about entities that are not where, or as, they were believed to be: the cup
    /// that lies on the table is not lifted, and the hand is not at it any more.
    fn unseen(&self, world: &World, believed: &State, gone: &[Fact], masked: &FxHashSet<StateVariable>) -> Vec<Fact> {
        let domain = world.domain();
        let mut moved: Vec<EntityId> = gone
            .iter()
            .filter(|fact| state_word(domain, fact.predicate()).is_some())
            .map(|fact| subject_of(domain, *fact))
            .collect();
        moved.sort_unstable();
        moved.dedup();
        if moved.is_empty() {
            return Vec::new();
        }
        let is_unseen = |fact: &Fact| {
            let words = domain.words(fact.predicate());
            words.fluent
                && !words.event
                && state_word(domain, fact.predicate()).is_none()
                && !domain.is_sensed(fact.predicate())
                && !masked.contains(&StateVariable::Fact(*fact))
                && !self.decides(world, *fact)
                && domain.arguments(*fact).any(|own| moved.binary_search(&own).is_ok())
        };
        believed.iter().filter(is_unseen).collect()
    }

    /// Removes facts that were not observed and that contradict, by a rule of the environment, what was.
    fn settle(&self, world: &World, state: &mut State) {
        let domain = world.domain();
        let rules = || domain.rules.iter().filter(|rule| rule.time == RuleTime::Start);
        // Each round removes a fact; a chain of contradictions longer than this is not followed.
        for _ in 0..64 {
            let doubtful = rules().find_map(|rule| {
                let broken = broken_bindings(rule, world, state);
                broken
                    .iter()
                    .find_map(|bindings| self.doubtful(world, state, rule, bindings))
            });
            match doubtful {
                Some(fact) => state.set(fact, false),
                None => return,
            };
        }
    }

    /// Returns a fact that breaks a rule and was not observed.
    fn doubtful(&self, world: &World, state: &State, rule: &Rule, bindings: &Bindings) -> Option<Fact> {
        let mut atoms = Vec::new();
        denied(&rule.condition, &mut atoms);
        let domain = world.domain();
        let grounded = atoms
            .into_iter()
            .filter(|atom| domain.words(atom.predicate).fluent && is_bound(atom, bindings))
            .map(|atom| ground(atom, bindings));
        let mut holding = grounded.filter(|fact| state.holds(*fact));
        holding.find(|fact| !self.decides(world, *fact))
    }
}

/// Collects the atoms that a condition requires not to hold.
fn denied<'a>(condition: &'a Condition, atoms: &mut Vec<&'a Atom>) {
    match condition {
        Condition::Atom {
            atom,
            holds: false,
            at: When::Now,
        } => atoms.push(atom),
        _ => condition.parts().iter().for_each(|part| denied(part, atoms)),
    }
}

fn is_bound(atom: &Atom, bindings: &Bindings) -> bool {
    atom.terms.iter().all(|term| match term {
        crate::model::Term::Variable(slot) => *slot < bindings.len(),
        crate::model::Term::Constant(_) => true,
    })
}

/// Reads a statement without a subject, or a fact of a reported predicate: `hand-at(<cup>)`, `hand_at(<cup>)`.
fn alone(world: &World, reports: &[PredicateId], text: &str) -> Option<Statement> {
    if let Some(statement) = statement(world, text) {
        return Some(statement);
    }
    let domain = world.domain();
    let call = Call::parse(text).ok()?;
    if let Some(fact) = fact_alone(domain, &call) {
        return Some(Statement::Fact(fact));
    }
    let name = call.name.replace('_', "-");
    let is_named = |id: &&PredicateId| {
        let own = &domain.predicate(**id).name;
        *own == call.name || own.replace('_', "-") == name
    };
    let predicate = reports.iter().find(is_named)?;
    let parameters = &domain.predicate(*predicate).parameters;
    if parameters.len() != call.arguments.len() {
        return None;
    }
    let entities = call.arguments.iter().zip(parameters).map(|(argument, parameter)| {
        world
            .exactly(argument)
            .filter(|entity| world.is_of_kind(*entity, parameter.kind))
    });
    Some(Statement::Fact(Fact::new(
        *predicate,
        entities.collect::<Option<Vec<_>>>()?,
    )))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::testing;

    const WORLD: &str = r#"{"assets": ["<table>", "<shelf>"], "objects": ["<cup>", "<pen>", "<shelf_handle>"],
        "object_states": {"<cup>": "on_something(<table>)", "<pen>": "on_something(<table>)", "<shelf_handle>": "closed()"}}"#;

    fn world() -> World {
        testing::world("household", WORLD)
    }

    fn reported(world: &World) -> Vec<PredicateId> {
        let predicates = world.domain().predicates.iter().enumerate();
        let hidden = predicates.filter(|(_, own)| ["hand-at", "lifted"].contains(&own.name.as_str()));
        hidden.map(|(index, _)| PredicateId::new(index)).collect()
    }

    fn statements(text: &str) -> Observation {
        serde_json::from_str(text).unwrap()
    }

    #[test]
    fn observation_replaces_facts_of_listed_entities_only() {
        let world = world();
        let everything: Vec<EntityId> = world.entities().map(|(id, _)| id).collect();
        for (seen, expected) in [
            ("{}", vec![]),
            (r#"{"states": {"<cup>": "on_something(<table>)"}}"#, vec![]),
            (r#"{"states": {"<cup>": []}}"#, vec!["-<cup> on_something(<table>)"]),
            (
                r#"{"states": {"<cup>": "on_something(<shelf>)", "<shelf_handle>": "open()", "<stranger>": "closed()"}}"#,
                vec![
                    "-<cup> on_something(<table>)",
                    "+<cup> on_something(<shelf>)",
                    "-<shelf_handle> closed()",
                    "+<shelf_handle> open()",
                ],
            ),
            (r#"{"facts": ["hand_at(<cup>)"]}"#, vec!["+hand-at(<cup>)"]),
        ] {
            let seen = ObservedFacts::read(&world, &reported(&world), &statements(seen)).unwrap();
            let state = seen.revised(&world, &world.state);
            let texts = |state: &State| {
                let own = ObservedFacts::statements(&world, state, &everything, &reported(&world));
                let mut texts = own.facts.unwrap_or_default();
                for (subject, words) in &own.states {
                    texts.extend(words.as_slice().iter().map(|word| format!("{subject} {word}")));
                }
                texts
            };
            let (before, after) = (texts(&world.state), texts(&state));
            let mut changes: Vec<String> = Vec::new();
            changes.extend(
                before
                    .iter()
                    .filter(|text| !after.contains(text))
                    .map(|text| format!("-{text}")),
            );
            changes.extend(
                after
                    .iter()
                    .filter(|text| !before.contains(text))
                    .map(|text| format!("+{text}")),
            );
            let mut expected: Vec<String> = expected.into_iter().map(str::to_owned).collect();
            changes.sort();
            expected.sort();
            assert_eq!(changes, expected);
        }
    }

    #[test]
    fn observation_of_one_held_object_releases_the_other() {
        let world = world();
        let cup = world.find("<cup>").unwrap();
        let held = fact_of(&world, cup, "inside_hand()").unwrap();
        let mut believed = world.state.clone();
        believed.set(held, true);
        let pen = statements(r#"{"states": {"<pen>": "inside_hand()"}}"#);
        let pen = ObservedFacts::read(&world, &[], &pen).unwrap();
        assert!(!pen.revised(&world, &believed).holds(held), "one hand cannot hold both");
    }

    #[test]
    fn observation_of_a_fallen_object_ends_the_lifted_state() {
        let world = world();
        let cup = world.find("<cup>").unwrap();
        let reported = reported(&world);
        let hidden = Observation {
            facts: Some(vec!["lifted(<cup>)".to_owned(), "hand-at(<shelf>)".to_owned()]),
            ..Observation::default()
        };
        let carried = statements(r#"{"states": {"<cup>": "inside_hand()"}}"#);
        let carried = Observation {
            facts: hidden.facts,
            ..carried
        };
        let carried = ObservedFacts::read(&world, &reported, &carried).unwrap();
        let believed = carried.revised(&world, &world.state);
        let fallen = statements(r#"{"states": {"<cup>": "on_something(<table>)"}}"#);
        let fallen = ObservedFacts::read(&world, &[], &fallen)
            .unwrap()
            .revised(&world, &believed);
        let left: Vec<Fact> = reported
            .iter()
            .flat_map(|id| fallen.of_predicate(*id))
            .copied()
            .collect();
        assert!(
            left.iter().all(|fact| fact.argument(0) != cup),
            "the cup is still lifted"
        );
        assert_eq!(left.len(), 1, "the hand is where it was");
    }

    #[test]
    fn observation_rejects_unknown_states_and_facts() {
        let world = world();
        for text in [
            r#"{"states": {"<cup>": "flying()"}}"#,
            r#"{"states": {"<cup>": "on_something(<moon>)"}}"#,
            r#"{"states": {"<cup>": ["on_something(<table>)", ""]}}"#,
            r#"{"facts": ["on(<cup>, <table>)"]}"#,
            r#"{"facts": ["hand-at(<cup>, <cup>)"]}"#,
        ] {
            let read = ObservedFacts::read(&world, &reported(&world), &statements(text));
            assert!(matches!(read, Err(ObservationError::Unreadable { .. })), "{text}");
        }
    }
}
