//! A robot's domain as data: types, predicates, actions, rules, and the words for them.

use super::id;
use super::{Atom, Condition, Effect, EntityId, Fact, Lexicon, Template};

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
    /// A word that goals are told in.
    GoalWordId
);

impl TypeId {
    /// PDDL's root type, which every entity has.
    pub const OBJECT: TypeId = TypeId(0);
}

/// The tree of types.
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

    /// The type of that name.
    pub fn find(&self, name: &str) -> Option<TypeId> {
        self.names.iter().position(|n| n == name).map(TypeId::new)
    }

    /// The type's name.
    pub fn name(&self, id: TypeId) -> &str {
        &self.names[id.index()]
    }

    /// How many types there are.
    pub(crate) fn len(&self) -> usize {
        self.names.len()
    }

    /// The names of all types, the root first.
    pub fn names(&self) -> impl Iterator<Item = &str> {
        self.names.iter().map(String::as_str)
    }

    /// Whether every `sub` is a `kind`.
    pub fn is_a(&self, mut sub: TypeId, kind: TypeId) -> bool {
        while sub != kind && sub != TypeId::OBJECT {
            sub = self.parents[sub.index()];
        }
        sub == kind
    }
}

/// A typed parameter of a predicate, an action or a goal word.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Parameter {
    /// Its name, without the question mark.
    pub name: String,
    /// What may stand there.
    pub kind: TypeId,
}

/// Something that can be true of entities.
#[derive(Debug, Clone)]
pub struct Predicate {
    /// The name in `domain.pddl`.
    pub name: String,
    /// Its arguments.
    pub parameters: Vec<Parameter>,
}

/// An action as PDDL tells it.
#[derive(Debug, Clone)]
pub(crate) struct ActionSchema {
    pub(crate) name: String,
    pub(crate) parameters: Vec<Parameter>,
    pub(crate) precondition: Condition,
    pub(crate) effects: Vec<Effect>,
}

/// Something the robot can do: semantics and words together.
#[derive(Debug, Clone)]
pub struct Action {
    /// The name in `domain.pddl`.
    pub name: String,
    /// Parameters; slots `0..parameters.len()` of the conditions.
    pub parameters: Vec<Parameter>,
    /// What must hold before.
    pub precondition: Condition,
    /// What changes.
    pub effects: Vec<Effect>,
    /// The word in a plan, for example `PutIn`.
    pub call: String,
    /// The parameters that the call shows, in its order; the others are implicit.
    pub explicit: Vec<usize>,
    /// The implicit parameter that a plan's `object_name` gives.
    pub object: Option<usize>,
    /// The parameter that does it, where there is a choice: a hand, an arm, a robot. What no single one of them does
    /// has none.
    pub actor: Option<usize>,
    /// What it tells, if it is sensing: exactly one of these facts holds, and afterwards it is known which. Empty for
    /// an action that changes the world.
    pub senses: Vec<Atom>,
    /// The explanation of a step.
    pub says: Template,
    /// What the action is for, as a model and a person are told.
    pub means: String,
}

impl Action {
    /// The parameters that the call syntax hides.
    pub fn implicit(&self) -> impl Iterator<Item = usize> + '_ {
        (0..self.parameters.len()).filter(|index| !self.explicit.contains(index))
    }
}

/// What to think of a static fact that the environment does not give.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Unknown {
    /// It does not hold.
    #[default]
    False,
    /// It neither forbids nor proves: it is taken to hold, and said so in the report. An environment
    /// that gives such a fact of anything is taken to give it of everything that has it.
    Assume,
}

/// The words for a predicate.
#[derive(Debug, Clone)]
pub struct PredicateWords {
    /// The fact as a sentence, for example `{item} is on {place}`.
    pub says: Template,
    /// Its opposite as a sentence.
    pub denies: Template,
    /// The fact as a model sees it in the entry of its first argument, for example `on {place}`.
    pub short: Option<Template>,
    /// Something that happens rather than lasts: false at the start of every instruction, never written
    /// to an environment.
    pub event: bool,
    /// What to think of it when the environment does not say.
    pub unknown: Unknown,
    /// Whether some action changes it, or tells it.
    pub fluent: bool,
    /// Stems of the words with which people speak of an outcome of sensing, as in "gone bad": each is one word or
    /// several in a row.
    pub cues: Vec<String>,
    /// The event that this held, made true by whatever takes it away: who wipes a dirty table no longer knows that it is
    /// dirty, and still has wiped a dirty table. For goals that depend on it.
    pub past: Option<PredicateId>,
}

/// A fact or its opposite, over `?self` (slot 0) and the word's own parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Literal {
    /// The fact.
    pub atom: Atom,
    /// Whether it holds.
    pub holds: bool,
}

/// How a state is written in an environment, for example `on_something(<something>)`.
#[derive(Debug, Clone)]
pub struct StateWord {
    /// The word before the parenthesis.
    pub word: String,
    /// The entities in the parentheses; their slots follow `?self`.
    pub parameters: Vec<String>,
    /// The fact it stands for.
    pub atom: Atom,
    /// What it means, as a model and a person are told.
    pub means: String,
}

/// How a static property is written in an environment, for example `IS_OPENABLE`.
#[derive(Debug, Clone)]
pub struct PropertyWord {
    /// The word.
    pub word: String,
    /// What it says of `?self`.
    pub literals: Vec<Literal>,
}

/// Static facts that follow from names or from other facts.
#[derive(Debug, Clone)]
pub struct Derivation {
    /// What follows, of `?self` (slot 0) and `?other` (slot 1).
    pub literals: Vec<Literal>,
    /// `?self` must have an identifier that ends with one of these; empty means any.
    pub names: Vec<String>,
    /// The same for `?other`, if the literals speak of it.
    pub other_names: Vec<String>,
    /// `?self` must be named after `?other`, as in `{other}_handle`.
    pub pattern: Option<String>,
    /// What must hold besides.
    pub when: Condition,
    /// Whether `?other` is spoken of.
    pub binary: bool,
}

/// A fact that is taken to hold at the start when the environment does not say otherwise.
#[derive(Debug, Clone)]
pub struct DefaultFact {
    /// The fact about `?self`.
    pub atom: Atom,
    /// When.
    pub when: Condition,
}

/// When a [`Rule`] must hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RuleTime {
    /// In the state that an environment describes: one that breaks it contradicts itself.
    Start,
    /// In every state that a plan passes through.
    Always,
    /// After the last step.
    End,
    /// After the last step of a plan that was made from a goal; of a plan that came from elsewhere
    /// it is only remarked on, since nobody said what that plan was for.
    Tidy,
}

/// Something that a good plan keeps to beyond its steps being possible.
#[derive(Debug, Clone)]
pub struct Rule {
    /// A short name.
    pub name: String,
    /// When it must hold.
    pub time: RuleTime,
    /// The outermost universally quantified variables, bound to slots from 0: one finding for each
    /// binding that breaks the rule.
    pub variables: Vec<Parameter>,
    /// What must hold of each binding.
    pub condition: Condition,
    /// What is said when it is broken.
    pub says: Template,
    /// Goal words that set the rule aside for what they speak of.
    pub unless: Vec<String>,
}

impl Rule {
    /// The condition for all bindings at once.
    pub(crate) fn everywhere(&self) -> Condition {
        let variables = self.variables.iter().enumerate().rev();
        variables.fold(self.condition.clone(), |inner, (slot, variable)| {
            Condition::Forall(slot, variable.kind, Box::new(inner))
        })
    }
}

/// A piece of how a goal is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum FormPiece {
    /// Literal text.
    Text(String),
    /// A parameter of the word.
    Parameter(usize),
}

/// A word that goals are told in, for example `put({item}, {place})`.
#[derive(Debug, Clone)]
pub struct GoalWord {
    /// The text before the parenthesis; forms may share it.
    pub word: String,
    /// How it is written.
    pub form: Vec<FormPiece>,
    /// The parameters; slots from 0 of the conditions.
    pub parameters: Vec<Parameter>,
    /// What it stands for.
    pub condition: Condition,
    /// Which arguments make sense in the state at hand.
    pub offered: Condition,
    /// Stems of the words that usually ask for it; a further goal of an answer needs one in the instruction.
    pub cues: Vec<String>,
    /// Stems of verbs that say where a thing should end: after one of them, a place that is spoken of is meant
    /// even if the thing is there already.
    pub destination_verbs: Vec<String>,
    /// Words that are meant instead where everything that they need is spoken of.
    pub yields_to: Vec<String>,
    /// Ways to say it, one of which the instruction must use with the argument, as in `top of {place}`.
    pub phrases: Vec<(String, usize)>,
    /// The parameter that the instruction must speak of.
    pub subject: Option<usize>,
    /// Of words with the same mark, one goal has at most one for the same first argument.
    pub exclusive: Option<String>,
    /// Parameters that achieving it may move, so that what held of them may be asked for again.
    pub disturbs: Vec<usize>,
    /// The goal as a sentence for a person.
    pub says: Template,
    /// What it means, as a model is told.
    pub means: String,
}

impl GoalWord {
    /// How it is written, with the parameters' names in capitals: `put(ITEM, PLACE)`.
    pub fn shown(&self) -> String {
        let piece = |piece: &FormPiece| match piece {
            FormPiece::Text(text) => text.clone(),
            FormPiece::Parameter(index) => self.parameters[*index].name.to_uppercase(),
        };
        self.form.iter().map(piece).collect()
    }
}

/// What each way to change a draft costs; keeping a step that can be done is free.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct RepairCosts {
    /// A step more.
    pub insert: u32,
    /// Another verb for the same things, one that changes some of the same facts in the same way.
    pub replace: u32,
    /// The same verb for the same things by another hand, arm or robot. Where the step's explanation speaks of that
    /// one, `rebind` takes its place, since the explanation is kept; where it speaks of the one in the call, both.
    pub other_actor: u32,
    /// A step later than the draft has it.
    pub postpone: u32,
    /// Another argument in an open place than the step's explanation speaks of.
    pub rebind: u32,
    /// Leaving out a step that would change nothing where it stands.
    pub drop_idle: u32,
    /// Leaving out a step that can never be done in this world, and no other verb for it either.
    pub drop_impossible: u32,
    /// Leaving out a step that does something: more than inserting what it needs.
    pub drop: u32,
    /// Ending with another relation between two things than the draft says, on rather than in: more than opening,
    /// replacing a verb and closing, which is what the one that was said may take.
    pub other_relation: u32,
    /// Ending without something that the draft says will have come about.
    pub forgo: u32,
    /// Ending without something that the draft says will be as before.
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

/// The words for the environment's two lists.
#[derive(Debug, Clone)]
pub struct EnvironmentTypes {
    /// The type of what `assets` lists.
    pub asset: TypeId,
    /// The type of what `objects` lists.
    pub object: TypeId,
}

/// A robot's domain, ready for use. Make one with [`load`](crate::domain::load), [`shipped`](crate::domain::shipped) or
/// [`from_pddl`](crate::domain::from_pddl).
#[derive(Debug, Clone)]
pub struct Domain {
    /// The name.
    pub name: String,
    /// The name that `domain.pddl` gives it, which problems refer to.
    pub pddl_name: String,
    /// One sentence on what it is for.
    pub about: String,
    /// The types.
    pub types: Types,
    /// The constants: names and types; the first entities of every world.
    pub constants: Vec<(String, TypeId)>,
    /// The predicates.
    pub predicates: Vec<Predicate>,
    /// The words of the predicates, in the same order.
    pub predicate_words: Vec<PredicateWords>,
    /// The actions.
    pub actions: Vec<Action>,
    /// Which types an environment's lists have.
    pub environment: EnvironmentTypes,
    /// The words for states.
    pub states: Vec<StateWord>,
    /// The words for properties.
    pub properties: Vec<PropertyWord>,
    /// What follows from names and facts.
    pub derivations: Vec<Derivation>,
    /// What is taken to hold at the start.
    pub defaults: Vec<DefaultFact>,
    /// The rules.
    pub rules: Vec<Rule>,
    /// The words that goals are told in.
    pub goal_words: Vec<GoalWord>,
    /// What changes to a draft cost.
    pub repair: RepairCosts,
    /// Everyday names.
    pub lexicon: Lexicon,
    /// Stems of words that speak of a thing without naming it, by the last word of its identifier: who throws something
    /// away speaks of the trash bin.
    pub implied: indexmap::IndexMap<String, Vec<String>>,
}

impl Domain {
    /// The predicate with this id.
    pub fn predicate(&self, id: PredicateId) -> &Predicate {
        &self.predicates[id.index()]
    }

    /// The entities that a fact is about, in order.
    pub fn arguments(&self, fact: Fact) -> impl Iterator<Item = EntityId> + use<> {
        let arity = self.predicate(fact.predicate()).parameters.len();
        (0..arity).map(move |place| fact.argument(place))
    }

    /// Whether a fact relates several things rather than telling a property of one.
    pub fn is_relation(&self, fact: Fact) -> bool {
        self.predicate(fact.predicate()).parameters.len() > 1
    }

    /// The words of the predicate with this id.
    pub fn words(&self, id: PredicateId) -> &PredicateWords {
        &self.predicate_words[id.index()]
    }

    /// The action with this id.
    pub fn action(&self, id: ActionId) -> &Action {
        &self.actions[id.index()]
    }

    /// Every action with its id, in the order of `domain.pddl`.
    pub fn action_ids(&self) -> impl Iterator<Item = (ActionId, &Action)> {
        self.actions
            .iter()
            .enumerate()
            .map(|(index, action)| (ActionId::new(index), action))
    }

    /// Whether some action tells whether this fact holds.
    pub fn is_sensed(&self, predicate: PredicateId) -> bool {
        self.sensing_of(predicate).is_some()
    }

    /// The outcomes of the sensing that tells whether the fact holds, itself among them, in the order in which the
    /// action lists them: exactly one of them holds. Nothing for a fact that no action tells.
    pub fn outcomes(&self, fact: Fact) -> Vec<Fact> {
        let Some(action) = self.sensing_of(fact.predicate()) else {
            return Vec::new();
        };
        let arguments: Vec<EntityId> = self.arguments(fact).collect();
        let outcome = |atom: &Atom| Fact::new(atom.predicate, arguments.iter().copied());
        action.senses.iter().map(outcome).collect()
    }

    fn sensing_of(&self, predicate: PredicateId) -> Option<&Action> {
        let tells = |action: &&Action| action.senses.iter().any(|atom| atom.predicate == predicate);
        self.actions.iter().find(tells)
    }

    /// The goal word with this id.
    pub fn goal_word(&self, id: GoalWordId) -> &GoalWord {
        &self.goal_words[id.index()]
    }
}
