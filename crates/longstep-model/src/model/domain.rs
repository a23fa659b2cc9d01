//! A robot's domain as data: types, predicates, actions, rules, and their wording.

use std::ops::Deref;
use std::sync::Arc;

use super::{
    Atom, Condition, Effect, EntityId, Fact, FunctionId, Lexicon, Number, NumericEffect, NumericExpression,
    SkillParameter, SpatialRelation, Template, ValueType, id,
};

id!(
    /// A type of entities; [`TypeId::OBJECT`] is the root.
    TypeId
);
id!(
    /// A predicate of a domain.
    PredicateId
);
id!(
    /// An action of a domain.
    ActionId
);
id!(
    /// A goal word of a domain.
    GoalWordId
);

impl TypeId {
    /// PDDL's root type, the supertype of all types.
    pub const OBJECT: TypeId = TypeId(0);
}

/// The type hierarchy.
#[derive(Debug, Clone)]
pub struct Types {
    names: Vec<String>,
    parents: Vec<TypeId>,
}

impl Default for Types {
    fn default() -> Self {
        Self {
            names: vec!["object".to_owned()],
            parents: vec![TypeId::OBJECT],
        }
    }
}

impl Types {
    pub(crate) fn intern(&mut self, name: &str) -> TypeId {
        self.find(name).unwrap_or_else(|| {
            self.names.push(name.to_owned());
            self.parents.push(TypeId::OBJECT);
            TypeId::new(self.names.len() - 1)
        })
    }

    pub(crate) fn set_parent(&mut self, child: TypeId, parent: TypeId) -> bool {
        let acyclic = !self.is_a(parent, child);
        if acyclic {
            self.parents[child.index()] = parent;
        }
        acyclic
    }

    /// Returns the type with this name.
    pub fn find(&self, name: &str) -> Option<TypeId> {
        self.names.iter().position(|n| n == name).map(TypeId::new)
    }

    /// Returns the name of a type.
    pub fn name(&self, id: TypeId) -> &str {
        &self.names[id.index()]
    }

    /// Returns the direct supertype; the root is its own.
    pub fn parent(&self, id: TypeId) -> TypeId {
        self.parents[id.index()]
    }

    /// Returns the number of types.
    pub fn count(&self) -> usize {
        self.names.len()
    }

    /// Iterates over the names of all types, the root first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Returns true if `sub` equals `kind` or is one of its subtypes.
    pub fn is_a(&self, mut sub: TypeId, kind: TypeId) -> bool {
        while sub != kind && sub != TypeId::OBJECT {
            sub = self.parents[sub.index()];
        }
        sub == kind
    }
}

/// A derived predicate: a name for a condition. No state has facts of it; [`crate::domain`] writes its condition wherever one is
/// asked for.
#[derive(Debug, Clone)]
pub struct DerivedPredicate {
    /// The predicate.
    pub predicate: PredicateId,
    /// The condition on its parameters, the slots from 0.
    pub condition: Condition,
}

/// A typed parameter of a predicate, an action or a goal word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// The name, without the question mark.
    pub name: String,
    /// The type of its arguments.
    pub kind: TypeId,
}

/// A predicate.
#[derive(Debug, Clone)]
pub struct Predicate {
    /// The name in `domain.pddl`.
    pub name: String,
    /// The parameters.
    pub parameters: Vec<Parameter>,
}

/// A numeric function, with its wording.
#[derive(Debug, Clone)]
pub struct Function {
    /// The name in `domain.pddl`.
    pub name: String,
    /// The parameters.
    pub parameters: Vec<Parameter>,
    /// True if some action changes it.
    pub changes: bool,
    /// The word in an environment: `level`, as in `level(3)`.
    pub word: String,
    /// The unit, for messages.
    pub unit: Option<String>,
    /// The template of the number's name, for example `the level of {tank}`.
    pub says: Template,
    /// The least number that it may have.
    pub min: Option<Number>,
    /// The greatest number that it may have.
    pub max: Option<Number>,
}

impl Function {
    /// Returns true if the number is within the range of the function.
    pub fn allows(&self, number: Number) -> bool {
        self.min.is_none_or(|min| number >= min) && self.max.is_none_or(|max| number <= max)
    }

    /// Writes the range of the function; none if it has none.
    pub fn range(&self) -> Option<String> {
        match (self.min, self.max) {
            (Some(min), Some(max)) => Some(format!("{min} to {max}")),
            (Some(min), None) => Some(format!("at least {min}")),
            (None, Some(max)) => Some(format!("at most {max}")),
            (None, None) => None,
        }
    }
}

/// An action as `domain.pddl` declares it.
#[derive(Debug, Clone)]
pub(crate) struct ActionSchema {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) precondition: Condition,
    pub(crate) effects: Vec<Effect>,
    pub(crate) numeric: Vec<NumericEffect>,
    pub(crate) cost: Option<NumericExpression>,
}

/// An action: its semantics and its wording.
#[derive(Debug, Clone)]
pub struct Action {
    /// The name in `domain.pddl`.
    pub name: String,
    /// The parameters: slots `0..parameters.len()` of the conditions.
    pub parameters: Vec<Parameter>,
    /// The precondition.
    pub precondition: Condition,
    /// The effects on facts.
    pub effects: Vec<Effect>,
    /// The effects on numbers.
    pub numeric: Vec<NumericEffect>,
    /// The cost of a step, from its effect on `(total-cost)`; none for an action without such an effect.
    pub cost: Option<NumericExpression>,
    /// The name of the action in a plan, for example `PutIn`.
    pub call: String,
    /// The parameters written in a call, in order; the others are implicit.
    pub explicit: Vec<usize>,
    /// The implicit parameter whose argument the plan's `object_name` gives.
    pub object: Option<usize>,
    /// The parameter for the actor that performs the action: a hand, an arm or a robot. None if there is no choice, or
    /// if several actors perform it together.
    pub actor: Option<usize>,
    /// The outcomes of a sensing action: exactly one of these facts holds, and the action reveals which one. Empty for
    /// an action that changes the world.
    pub senses: Vec<Atom>,
    /// The template for the explanation of a step.
    pub says: Template,
    /// The description of the action, for models and persons.
    pub means: String,
    /// The number of times that a step which failed is tried again.
    pub retries: u32,
    /// The parameters of the robot's skill: how a step is done, not what it does.
    pub skills: Vec<SkillParameter>,
}

impl Action {
    /// Iterates over the parameters that a call does not write.
    pub fn implicit(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parameters.len()).filter(|index| !self.explicit.contains(index))
    }
}

/// The value of a static fact that the environment does not give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unknown {
    /// The fact is false.
    #[default]
    False,
    /// The fact is assumed unless the environment denies it, and the report lists the assumption. If the environment
    /// gives one fact of this predicate, all its facts that are not given are false.
    Assume,
}

/// The wording of a predicate.
#[derive(Debug, Clone)]
pub struct PredicateWords {
    /// The template for a sentence, for example `{item} is on {place}`.
    pub says: Template,
    /// The template for the negated fact.
    pub denies: Template,
    /// The fact as a scene for a model lists it under the first argument, for example `on {place}`.
    pub short: Option<Template>,
    /// True for an event, which records that something happened: false at the start of every instruction and never
    /// written to an environment.
    pub event: bool,
    /// The value of facts that the environment does not give.
    pub unknown: Unknown,
    /// True if an environment that gives one fact of the predicate gives all of them, so that none is derived.
    pub complete: bool,
    /// True if some action changes or senses the predicate.
    pub fluent: bool,
    /// The event that records that this fact held, added by every action that deletes the fact. Conditional goals need
    /// it: after a dirty table is wiped, the table is clean, but the plan still has to show that a dirty table was
    /// wiped.
    pub past: Option<PredicateId>,
}

/// A fact or its negation, over `?self` (slot 0) and the parameters of the word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Literal {
    /// The fact.
    pub atom: Atom,
    /// True for the fact, false for its negation.
    pub holds: bool,
}

/// The notation of a state in an environment, for example `on_something(<something>)`.
#[derive(Debug, Clone)]
pub struct StateWord {
    /// The word before the parenthesis.
    pub word: String,
    /// The parameters in the parentheses; their slots follow `?self`.
    pub parameters: Vec<String>,
    /// The fact that the word denotes.
    pub atom: Atom,
    /// The description of the state, for models and persons.
    pub means: String,
    /// The relations in space that the word says, for scenes of boxes.
    pub relations: Vec<SpatialRelation>,
}

/// The notation of a static property in an environment, for example `IS_OPENABLE`.
#[derive(Debug, Clone)]
pub struct PropertyWord {
    /// The word.
    pub word: String,
    /// The facts about `?self` that the word denotes.
    pub literals: Vec<Literal>,
}

/// A derivation: static facts that follow from names or from other facts.
#[derive(Debug, Clone)]
pub struct Derivation {
    /// The derived facts, over `?self` (slot 0) and `?other` (slot 1).
    pub literals: Vec<Literal>,
    /// Endings of identifiers, one of which `?self` must have; empty for any identifier.
    pub names: Vec<String>,
    /// Endings of identifiers, one of which `?other` must have, if the literals mention it.
    pub other_names: Vec<String>,
    /// The pattern by which `?self` is named after `?other`, as in `{other}_handle`.
    pub pattern: Option<String>,
    /// The additional condition.
    pub when: Condition,
    /// The additional condition as `domain.toml` writes it.
    pub written: Option<String>,
    /// True if `?other` occurs in the literals.
    pub binary: bool,
    /// The line in `domain.toml`.
    pub line: u32,
}

impl Derivation {
    /// Returns true if the derivation depends on names of entities.
    pub fn is_from_names(&self) -> bool {
        !(self.names.is_empty() && self.other_names.is_empty() && self.pattern.is_none())
    }
}

/// A fact assumed in the initial state if its condition holds there.
#[derive(Debug, Clone)]
pub struct DefaultFact {
    /// The fact about `?self`.
    pub atom: Atom,
    /// The condition on `?self`.
    pub when: Condition,
    /// The condition as `domain.toml` writes it.
    pub written: String,
    /// The line in `domain.toml`.
    pub line: u32,
}

/// The states in which a [`Rule`] must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RuleTime {
    /// The state that an environment describes. An environment that violates the rule contradicts itself.
    Start,
    /// Every state of a plan.
    Always,
    /// The state after the last step.
    End,
    /// The state after the last step, for plans made from a goal. For other plans a violation is only a remark, since
    /// their purpose is unknown.
    Tidy,
}

/// A rule: a constraint on plans beyond the preconditions of their steps.
#[derive(Debug, Clone)]
pub struct Rule {
    /// A short name.
    pub name: String,
    /// When it must hold.
    pub time: RuleTime,
    /// The outermost universally quantified variables, bound to slots from 0. Each binding that violates the rule is
    /// one violation.
    pub variables: Vec<Parameter>,
    /// The condition on each binding.
    pub condition: Condition,
    /// The template for the sentence that reports a violation.
    pub says: Template,
    /// Goal words that waive the rule for their subject, or for all their arguments if they have none.
    pub unless: Vec<String>,
}

impl Rule {
    /// Returns the condition, quantified over all bindings.
    pub fn everywhere(&self) -> Condition {
        let variables = self.variables.iter().enumerate().rev();
        variables.fold(self.condition.clone(), |inner, (slot, variable)| {
            Condition::Forall(slot, variable.kind, Box::new(inner))
        })
    }
}

/// A piece of the notation of a goal.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FormPiece {
    /// Literal text.
    Text(String),
    /// A parameter of the word.
    Parameter(usize),
}

/// A goal word: a predicate in which goals are written, for example `put({item}, {place})`.
#[derive(Debug, Clone)]
pub struct GoalWord {
    /// The text before the parenthesis; several forms may share it.
    pub word: String,
    /// The notation of a goal with this word.
    pub form: Vec<FormPiece>,
    /// The parameters: slots from 0 of the conditions.
    pub parameters: Vec<Parameter>,
    /// The condition that the goal requires.
    pub condition: Condition,
    /// The condition on arguments that make sense in the current state.
    pub offered: Condition,
    /// The parameter whose argument the instruction must mention.
    pub subject: Option<usize>,
    /// The mark of a group of goal words. A goal contains at most one word of a group with the same first argument.
    pub exclusive: Option<String>,
    /// Parameters whose arguments the goal may move, so that their earlier facts may be requested again.
    pub disturbs: Vec<usize>,
    /// The template for the goal as a sentence for a person.
    pub says: Template,
    /// The template for what achieves the goal, after "Should I": `put {item} on {place}`.
    pub asks: Option<Template>,
    /// The description of the goal word, for models.
    pub means: String,
}

impl GoalWord {
    /// Returns the notation, with the parameters' names in capitals: `put(ITEM, PLACE)`.
    pub fn shown(&self) -> String {
        let piece = |piece: &FormPiece| match piece {
            FormPiece::Text(text) => text.clone(),
            FormPiece::Parameter(index) => self.parameters[*index].name.to_uppercase(),
        };
        self.form.iter().map(piece).collect()
    }
}

/// The cost of each edit of a draft in repair; keeping an applicable step is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[non_exhaustive]
pub struct RepairCosts {
    /// Inserting a step.
    pub insert: u32,
    /// Replacing the action of a step by another one with the same objects and with some of the same effects.
    pub replace: u32,
    /// Replacing the actor of a step. If the step's explanation names the new actor, the cost is `rebind` instead,
    /// since the explanation remains valid; if it names the actor in the call, the cost is the sum of both.
    pub other_actor: u32,
    /// Moving a step to a later position.
    pub postpone: u32,
    /// Binding an implicit parameter to another argument than the one in the step's explanation.
    pub rebind: u32,
    /// Dropping a step that changes nothing at its position.
    pub drop_idle: u32,
    /// Dropping a step that is never applicable in this world, if no other action can replace it.
    pub drop_impossible: u32,
    /// Dropping a step with an effect. This costs more than inserting the steps that it needs.
    pub drop: u32,
    /// Ending with another relation between two objects than the draft claims, for example on instead of in. This costs
    /// more than the claimed relation usually takes: opening, replacing an action and closing.
    pub other_relation: u32,
    /// Ending without a fact that the draft claims to be achieved.
    pub forgo: u32,
    /// Ending without a fact that the draft claims to be unchanged.
    pub unsettle: u32,
}

impl Default for RepairCosts {
    fn default() -> Self {
        Self {
            insert: 4,
            replace: 5,
            other_actor: 3,
            postpone: 3,
            rebind: 2,
            drop_idle: 2,
            drop_impossible: 4,
            drop: 80,
            other_relation: 15,
            forgo: 60,
            unsettle: 20,
        }
    }
}

/// The types of the environment's two lists.
#[derive(Debug, Clone)]
pub struct EnvironmentTypes {
    /// The type of the entities in `assets`.
    pub asset: TypeId,
    /// The type of the entities in `objects`.
    pub object: TypeId,
}

/// A robot's domain. Create one with [`load`](crate::domain::load), [`shipped`](crate::domain::shipped) or
/// [`from_pddl`](crate::domain::from_pddl).
///
/// A handle on [`DomainData`], which is read through it: clones share the data, and each world holds one. `Debug` shows the name
/// and the hash.
#[derive(Clone)]
pub struct Domain(Arc<DomainData>);

impl std::fmt::Debug for Domain {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(formatter, "Domain({} {})", self.name, self.hash)
    }
}

impl Deref for Domain {
    type Target = DomainData;

    fn deref(&self) -> &DomainData {
        &self.0
    }
}

impl From<DomainData> for Domain {
    fn from(data: DomainData) -> Self {
        Self(Arc::new(data))
    }
}

/// The content of a [`Domain`].
#[derive(Debug, Clone)]
#[non_exhaustive]
pub struct DomainData {
    /// The name.
    pub name: String,
    /// The hash of the files that it was loaded from, 16 hexadecimal digits: a changed domain has another one.
    pub hash: String,
    /// The name in `domain.pddl`, to which PDDL problems refer.
    pub pddl_name: String,
    /// A description in one sentence.
    pub about: String,
    /// The types.
    pub types: Types,
    /// The constants with their types, the first entities of every world.
    pub constants: Vec<(String, TypeId)>,
    /// The predicates.
    pub predicates: Vec<Predicate>,
    /// The wording of the predicates, in the same order.
    pub predicate_words: Vec<PredicateWords>,
    /// The numeric functions.
    pub functions: Vec<Function>,
    /// The actions.
    pub actions: Vec<Action>,
    /// The types of the environment's lists.
    pub environment: EnvironmentTypes,
    /// The state words.
    pub states: Vec<StateWord>,
    /// The property words.
    pub properties: Vec<PropertyWord>,
    /// The derived predicates, each after those that its condition was made from.
    pub derived: Vec<DerivedPredicate>,
    /// The derivations of static facts.
    pub derivations: Vec<Derivation>,
    /// The facts assumed in the initial state.
    pub defaults: Vec<DefaultFact>,
    /// The rules.
    pub rules: Vec<Rule>,
    /// The goal words.
    pub goal_words: Vec<GoalWord>,
    /// The costs of edits in repair.
    pub repair: RepairCosts,
    /// The types whose entities are values.
    pub values: Vec<ValueType>,
    /// The everyday names.
    pub lexicon: Lexicon,
    /// The article before everyday names in sentences; empty for none.
    pub article: String,
    /// Words by which the person who gives an instruction refers to themselves: "me".
    pub speaker_names: Vec<String>,
    /// Words by which an instruction refers to the robot: "you".
    pub robot_names: Vec<String>,
    /// Stems of words that speak of an entity without naming it, by the last word of its identifier: "throw away" speaks of
    /// the trash bin.
    pub implied: indexmap::IndexMap<String, Vec<String>>,
}

impl Domain {
    /// Returns a copy with a change; worlds that hold this domain keep it as it is.
    #[must_use]
    pub fn edited(&self, change: impl FnOnce(&mut DomainData)) -> Self {
        let mut data = (*self.0).clone();
        change(&mut data);
        data.into()
    }

    /// Returns whether both are handles on the same data.
    pub fn is_same(&self, other: &Self) -> bool {
        Arc::ptr_eq(&self.0, &other.0)
    }
}

impl DomainData {
    /// Returns the predicate with this id.
    pub fn predicate(&self, id: PredicateId) -> &Predicate {
        &self.predicates[id.index()]
    }

    /// Returns the numeric function with this id.
    pub fn function(&self, id: FunctionId) -> &Function {
        &self.functions[id.index()]
    }

    /// Returns true if steps have costs: then a cheapest plan is preferred over a shortest one.
    pub fn has_costs(&self) -> bool {
        self.actions.iter().any(|action| action.cost.is_some())
    }

    /// Iterates over the arguments of a fluent.
    pub fn arguments_of(&self, fluent: super::Fluent) -> impl Iterator<Item = EntityId> + use<> {
        let arity = self.function(fluent.function()).parameters.len();
        (0..arity).map(move |place| fluent.argument(place))
    }

    /// Iterates over the arguments of a fact.
    pub fn arguments(&self, fact: Fact) -> impl Iterator<Item = EntityId> + use<> {
        let arity = self.predicate(fact.predicate()).parameters.len();
        (0..arity).map(move |place| fact.argument(place))
    }

    /// Returns true if the fact has more than one argument.
    pub fn is_relation(&self, fact: Fact) -> bool {
        self.predicate(fact.predicate()).parameters.len() > 1
    }

    /// Returns the wording of the predicate with this id.
    pub fn words(&self, id: PredicateId) -> &PredicateWords {
        &self.predicate_words[id.index()]
    }

    /// Returns the action with this id.
    pub fn action(&self, id: ActionId) -> &Action {
        &self.actions[id.index()]
    }

    /// Iterates over all actions with their ids, in the order of `domain.pddl`.
    pub fn action_ids(&self) -> impl Iterator<Item = (ActionId, &Action)> {
        self.actions
            .iter()
            .enumerate()
            .map(|(index, action)| (ActionId::new(index), action))
    }

    /// Returns true if some sensing action reveals facts of this predicate.
    pub fn is_sensed(&self, predicate: PredicateId) -> bool {
        self.sensing_of(predicate).is_some()
    }

    /// Returns all outcomes of the sensing action that reveals the fact, the fact itself included, in the order of the
    /// action. Exactly one of them holds. Empty for a fact that no action senses.
    pub fn outcomes(&self, fact: Fact) -> Vec<Fact> {
        let Some(action) = self.sensing_of(fact.predicate()) else {
            return Vec::new();
        };
        let arguments: Vec<EntityId> = self.arguments(fact).collect();
        let outcome = |atom: &Atom| Fact::new(atom.predicate, arguments.iter().copied());
        action.senses.iter().map(outcome).collect()
    }

    fn sensing_of(&self, predicate: PredicateId) -> Option<&Action> {
        let senses = |action: &&Action| action.senses.iter().any(|atom| atom.predicate == predicate);
        self.actions.iter().find(senses)
    }

    /// Returns the goal word with this id.
    pub fn goal_word(&self, id: GoalWordId) -> &GoalWord {
        &self.goal_words[id.index()]
    }
}
